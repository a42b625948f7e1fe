"""Exposure and optics in a camera's EXIF data: time, sensitivity, aperture, orientation, focal length and distance.

exifread reads the tags; what is ours is which of them count, and that 0/0 and 1/0 count as unknown.
"""

from __future__ import annotations

import io
import logging
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal

from numpy.typing import NDArray

EXPOSURE_GARBLED = "states an impossible exposure time, which is taken as unknown"


#: Distances beyond this are those of a lens at infinity, which a sample is not.
MAX_DISTANCE_M = 1000.0

#: Pixels of sensors, from those of telephones to binned ones; relative difference of square ones along both sides.
PITCHES_MM, SQUARE = (2e-4, 0.1), 0.05


@dataclass(frozen=True)
class Exif:
    """None where the camera said nothing or nonsense (0/0, 1/0): an unknown exposure is asked for, never assumed.

    `exposure_garbled`: an exposure time was written, but an impossible one. `colours`: the colour space that the
    camera states; Adobe RGB by the index R03 of DCF, or by a 2 as some cameras write it. `focal_mm`: of the lens,
    `focal_35mm` that which shows as much on 36 × 24 mm; `distance_m`: to what is in focus; `pitch_mm`: of pixels on the
    sensor, where the image has `width_px` columns (None where it is not known). `artist` and `copyright` as a
    photographer or a camera wrote them, '' where they did not.
    """

    camera: str | None = None
    exposure_s: float | None = None
    iso: float | None = None
    aperture: float | None = None
    orientation: int = 1
    exposure_garbled: bool = False
    colours: Literal["", "srgb", "adobe", "uncalibrated"] = ""
    focal_mm: float | None = None
    focal_35mm: float | None = None
    distance_m: float | None = None
    pitch_mm: float | None = None
    width_px: int | None = None
    artist: str = ""
    copyright: str = ""

    def as_json(self) -> dict[str, Any]:
        return asdict(self)


def read_exif(content: bytes) -> Exif:
    """EXIF of a JPEG, TIFF, PNG or TIFF-like RAW; empty where there is none or where it is damaged beyond reading."""
    import exifread

    logging.getLogger("exifread").setLevel(logging.CRITICAL)
    try:
        tags = exifread.process_file(io.BytesIO(content), details=False, extract_thumbnail=False)
    except (
        ArithmeticError,
        AttributeError,
        LookupError,
        OSError,
        TypeError,
        ValueError,
        exifread.ExifNotFound,
        exifread.InvalidExif,
    ):
        return Exif()
    orientation = _number(tags, "Image Orientation")
    distance, width = _number(tags, "EXIF SubjectDistance"), _number(tags, "EXIF ExifImageWidth")
    exposure_s = _number(tags, "EXIF ExposureTime") or _number(tags, "Image ExposureTime")
    return Exif(
        camera=_camera(tags),
        exposure_s=exposure_s,
        iso=_number(tags, "EXIF ISOSpeedRatings") or _number(tags, "Image ISOSpeedRatings"),
        aperture=_number(tags, "EXIF FNumber") or _number(tags, "Image FNumber"),
        orientation=int(orientation) if orientation is not None and orientation in range(1, 9) else 1,
        exposure_garbled=exposure_s is None and bool({"EXIF ExposureTime", "Image ExposureTime"} & tags.keys()),
        colours=_colours(tags),
        focal_mm=_number(tags, "EXIF FocalLength"),
        focal_35mm=_number(tags, "EXIF FocalLengthIn35mmFilm"),
        distance_m=distance if distance is not None and distance < MAX_DISTANCE_M else None,
        pitch_mm=_pitch(tags),
        width_px=None if width is None else int(width),
        artist=_words(tags, "Image Artist"),
        copyright=_words(tags, "Image Copyright"),
    )


def pixel_pitch_mm(exif: Exif, width: int, height: int) -> float | None:
    """Size of a pixel of an image (as it is stored) on the sensor, None where nothing tells it.

    Sensors of other proportions than 3 : 2 have the diagonal of a film that shows as much.
    """
    if exif.pitch_mm is not None:
        return exif.pitch_mm * (exif.width_px / width if exif.width_px else 1.0)
    if exif.focal_mm is None or exif.focal_35mm is None:
        return None
    return math.hypot(36.0, 24.0) * exif.focal_mm / exif.focal_35mm / math.hypot(width, height)


def _pitch(tags: Mapping[str, Any]) -> float | None:
    across, down = (_number(tags, f"EXIF FocalPlane{axis}Resolution") for axis in "XY")
    unit = {2: 25.4, 3: 10.0, 4: 1.0, 5: 1e-3}.get(int(_number(tags, "EXIF FocalPlaneResolutionUnit") or 2))
    if across is None or unit is None or (down is not None and abs(down / across - 1.0) > SQUARE):
        return None
    pitch = unit / across
    return pitch if PITCHES_MM[0] < pitch < PITCHES_MM[1] else None


def _words(tags: Mapping[str, Any], name: str) -> str:
    """The text of a tag as one line of printable letters."""
    letters = (letter if letter.isprintable() else " " for letter in str(tags.get(name, ""))[:1000])
    return " ".join("".join(letters).split())


def _colours(tags: Mapping[str, Any]) -> Literal["", "srgb", "adobe", "uncalibrated"]:
    index = str(tags.get("Interoperability InteroperabilityIndex", tags.get("EXIF InteroperabilityIndex", "")))
    number = _number(tags, "EXIF ColorSpace")
    if index.startswith("R03") or number == 2:
        return "adobe"
    return {1: "srgb", 65535: "uncalibrated"}.get(int(number or 0), "")  # type: ignore[return-value]


def _number(tags: Mapping[str, Any], name: str) -> float | None:
    values = getattr(tags.get(name), "values", None)
    if not isinstance(values, (list, tuple)) or not values or isinstance(values[0], str):
        return None
    first: Any = values[0]
    if isinstance(first, tuple) and first:  # as exifread gives real numbers
        first = first[0]
    if not isinstance(getattr(first, "num", first), int | float):
        return None
    return rational(float(getattr(first, "num", first)), float(getattr(first, "den", 1)))


def _camera(tags: Mapping[str, Any]) -> str | None:
    make, model = (str(tags.get(f"Image {name}", "")).replace("\0", " ").strip() for name in ("Make", "Model"))
    full = model if model.startswith(make) else f"{make} {model}"
    return " ".join(full.split())[:100] or None


def rational(numerator: float, denominator: float) -> float | None:
    """A quotient that a camera can mean, or None: cameras write 0/0, 1/0 and 0/1 for 'unknown'."""
    if denominator == 0 or not (math.isfinite(numerator) and math.isfinite(denominator)):
        return None
    value = numerator / denominator
    return value if 1e-12 < value < 1e12 else None


def orient(image: NDArray[Any], orientation: int) -> NDArray[Any]:
    """`image` (H, W, …) turned upright by its EXIF orientation 1…8 (a view); 1 for any other number."""
    turned = image.swapaxes(0, 1) if orientation in (5, 6, 7, 8) else image
    if orientation in (3, 4, 7, 8):
        turned = turned[::-1]
    if orientation in (2, 3, 6, 7):
        turned = turned[:, ::-1]
    return turned

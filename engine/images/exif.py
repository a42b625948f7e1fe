"""Exposure in a camera's EXIF data: time, sensitivity, aperture, orientation.

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


@dataclass(frozen=True)
class Exif:
    """None where the camera said nothing or nonsense (0/0, 1/0): an unknown exposure is asked for, never assumed.

    `exposure_garbled`: an exposure time was written, but an impossible one. `colours`: the colour space that the
    camera states; Adobe RGB by the index R03 of DCF, or by a 2 as some cameras write it.
    """

    camera: str | None = None
    exposure_s: float | None = None
    iso: float | None = None
    aperture: float | None = None
    orientation: int = 1
    exposure_garbled: bool = False
    colours: Literal["", "srgb", "adobe", "uncalibrated"] = ""

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
    exposure_s = _number(tags, "EXIF ExposureTime") or _number(tags, "Image ExposureTime")
    return Exif(
        camera=_camera(tags),
        exposure_s=exposure_s,
        iso=_number(tags, "EXIF ISOSpeedRatings") or _number(tags, "Image ISOSpeedRatings"),
        aperture=_number(tags, "EXIF FNumber") or _number(tags, "Image FNumber"),
        orientation=int(orientation) if orientation is not None and orientation in range(1, 9) else 1,
        exposure_garbled=exposure_s is None and bool({"EXIF ExposureTime", "Image ExposureTime"} & tags.keys()),
        colours=_colours(tags),
    )


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

"""A photograph of the capture as linear radiance, whatever wrote it: RAW by `engine.capture.photograph.raw`, else an
image.

What had to be assumed (transfer function, levels, white balance, exposure) stands in the result.

Photographs one after the other: while one is worked on the next ones are decoded, on all cores as far as there is
memory for them; where it is short, one photograph at a time is decoded or worked on.

Decoders answer with the codes of a file, or the mosaic of its sensor, of which linear light is made here: that is a
sixth to a half of the bytes, and memory is new to every decoder but here goes from one photograph to the next.

Cost: as decoding on all cores that memory allows.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import DTypeLike, NDArray

from engine.capture.photograph import bayer
from engine.capture.photograph.kinds import RAW_SUFFIXES
from engine.capture.photograph.radiometry import balance_matrix
from engine.core.budget import free_bytes, thread_count
from engine.core.errors import InputError
from engine.core.steps import Step, Steps
from engine.images import decode as images
from engine.images import tiff
from engine.images.codes import Coded, decode
from engine.images.credits import read_credits
from engine.images.exif import Exif, pixel_pitch_mm, read_exif
from engine.images.tiff_directories import check_directories
from engine.storage.readers import readers
from engine.storage.reused import ReusedMemory
from engine.storage.scratch import find_results_folder, release
from engine.storage.untrusted import CHILDREN, GIBIBYTE, Decoding, build

WhiteBalance = Literal["camera", "none"] | Sequence[float]

#: Address space of a decoder of photographs: enough for the 200 megapixels that are read at most, in 16 bits.
_MEMORY_BYTES = 10 * GIBIBYTE


#: What `read_photograph` does where nothing else is asked for.
OPTIONS: Mapping[str, Any] = {
    "white_balance": "camera",
    "transfer": "auto",
    "half_size": False,
    "orientation": 0,
    "white_code": 0,
    "bands": (),
    "white_samples": (),
    "keep_codes": False,
}


class Unreadable(InputError):
    """A photograph that cannot be decoded whole."""


@dataclass(frozen=True, eq=False)
class Photograph:
    """One photograph.

    Attributes
    ----------
    radiance : (H, W, 3) float32, linear sRGB, upright, read-only; 1 = white level. Negative values are noise around
        black (RAW) or out-of-gamut colours, and are kept.
    saturated : (H, W) bool, True where a sample at white level, or one that is not finite, enters the pixel.
    exposure_s, iso, aperture, camera : None where the file does not say.
    bit_depth : bits per sample. container : 'RAW', 'JPEG', 'PNG', 'TIFF', 'EXR', 'HDR', 'TGA', or a reader's own.
    transfer : what the samples were taken to be, 'srgb', 'linear', or coded by another curve of their 'profile'.
    black_level, white_level : in sample codes per site of the colour filter array (RAW), else empty.
    white_balance : multipliers of red, green, blue that were applied.
    camera_matrix : (9,) row by row, from balanced camera colours to linear sRGB (RAW), else empty.
    orientation : EXIF orientation of the file, 1 for RAW. largest_code : largest sample of an integer image, else 0.
    largest_samples, plateaus : of a floating-point image the largest sample of red, green and blue, and the share of
        samples equal to it where the channel looks clipped (`engine.images.decode.Image`), else empty.
    profile : name of the colour space that the file states and that was applied, else ''.
    focal_mm, distance_m, pitch_mm : focal length, distance of what is in focus, and size of a pixel on the sensor, each
        None where the camera does not say.
    matrix_source : of RAW files, what the camera matrix comes from: 'LibRaw', 'the file', or '' where there is none.
    credits : title, author, licence, copyright and source by these names, as far as the file states them.
    coded : what radiance and saturation are made from, where that was asked for: codes that tables decode, or the
        mosaic of a Bayer sensor.
    """

    radiance: NDArray[np.float32]
    saturated: NDArray[np.bool_]
    path: Path
    camera: str | None
    exposure_s: float | None
    iso: float | None
    aperture: float | None
    bit_depth: int
    container: str
    transfer: images.Coding
    black_level: tuple[float, ...]
    white_level: tuple[float, ...]
    white_balance: tuple[float, float, float]
    camera_matrix: tuple[float, ...]
    warnings: tuple[str, ...]
    orientation: int = 1
    largest_code: int = 0
    largest_samples: tuple[float, ...] = ()
    plateaus: tuple[float, ...] = ()
    profile: str = ""
    matrix_source: str = ""
    coded: Coded | bayer.Mosaic | None = None
    focal_mm: float | None = None
    distance_m: float | None = None
    pitch_mm: float | None = None
    credits: Mapping[str, str] = field(default_factory=dict)


def read_photograph(
    path: str | os.PathLike[str],
    *,
    white_balance: WhiteBalance = "camera",
    transfer: images.TransferChoice = "auto",
    half_size: bool = False,
    orientation: int = 0,
    white_code: int = 0,
    bands: Sequence[int] = (),
    white_samples: Sequence[float] = (),
    keep_codes: bool = False,
) -> Photograph:
    """Decode one photograph; Unreadable for what cannot be decoded whole.

    Parameters
    ----------
    white_balance : of RAW files: the camera's, none, or three multipliers. Green is scaled to 1.
    transfer : of integer JPEG, PNG and TIFF: 'auto' is what their colour profile says, without one sRGB unless the file
        says linear. A stated one overrides the curve of a profile, of which the primaries are applied all the same.
    half_size : average 2×2 pixels, for previews.
    orientation, white_code : EXIF orientation, and full scale of 16 bits, instead of those of an image, where not 0.
    white_samples : samples of red, green and blue from which on a floating-point image is saturated; none without.
    bands : of an image, from 1: one that becomes grey, or three that become red, green and blue; its colours without.
    keep_codes : keep what pixels are made from as well, codes or a mosaic, where the image is not halved.
    """
    options: dict[str, Any] = {"white_balance": white_balance, "transfer": transfer, "half_size": half_size}
    options |= {"orientation": orientation, "white_code": white_code, "bands": bands}
    with closing(Reading(path, **options, white_samples=white_samples, keep_codes=keep_codes)) as reading:
        return reading.photograph()


class Reading:
    """`read_photograph` while its caller does other things."""

    def __init__(
        self,
        path: str | os.PathLike[str],
        *,
        white_balance: WhiteBalance = "camera",
        transfer: images.TransferChoice = "auto",
        half_size: bool = False,
        orientation: int = 0,
        white_code: int = 0,
        bands: Sequence[int] = (),
        white_samples: Sequence[float] = (),
        keep_codes: bool = False,
        memory: ReusedMemory | None = None,
    ) -> None:
        if isinstance(white_balance, str) and white_balance not in ("camera", "none"):
            raise ValueError(f"unknown white balance {white_balance!r}")
        self._path = Path(path)
        options: dict[str, Any] = {
            "white_balance": white_balance if isinstance(white_balance, str) else [float(v) for v in white_balance],
            "transfer": transfer,
            "half_size": half_size,
            "orientation": orientation,
            "white_code": white_code,
            "bands": list(bands),
            "white_samples": [float(value) for value in white_samples],
            "keep_codes": keep_codes,
        }
        self._keep_codes = keep_codes
        self._memory = memory
        self._known = _ask_supplies(self._path, options)
        self._decoding: Decoding | None = None
        if self._known is None:
            name = "engine.capture.photograph.decode:decode_photograph"
            options |= {"codes_alone": True, "memory_bytes": _MEMORY_BYTES}
            if find_results_folder() is None:
                options |= {"mosaic_alone": True, "finish": self._finish}
            self._decoding = Decoding(name, path, **options)

    def wait(self, timeout_s: float) -> bool:
        """Wait for at most `timeout_s`; True if the photograph has been read, or cannot be."""
        return self._decoding is None or self._decoding.wait(timeout_s)

    def photograph(self) -> Photograph:
        """The photograph, waited for."""
        if self._known is not None:
            return self._known
        assert self._decoding is not None
        try:
            found = self._decoding.result()
        except InputError as error:
            raise Unreadable(error.path, error.problem, error.remedy) from None
        # where memory is limited, large arrays lie on the disk that this thread makes
        return found if isinstance(found, Photograph) else self._finish(found)

    def _finish(self, reply: dict[str, Any]) -> Photograph:
        """The photograph that a decoder answered with."""
        arrays = np.empty if self._memory is None else self._memory.array
        photograph = build(_build, self._path, {"arrays": arrays, "path": self._path, **reply})
        return photograph if self._keep_codes else replace(photograph, coded=None)

    def close(self) -> None:
        """Stop reading."""
        if self._decoding is not None:
            self._decoding.cancel()


#: A function that gives a photograph, as it is decoded with these options, or None where it does not have it.
Supply = Callable[[Path, Mapping[str, Any]], Photograph | None]

_supplies: list[Supply] = []


def add_supply(supply: Supply) -> None:
    """Ask `supply` for each photograph before it is decoded."""
    _supplies.append(supply)


def drop_supply(supply: Supply) -> None:
    """Ask `supply` no more; nothing where it was not asked."""
    if supply in _supplies:
        _supplies.remove(supply)


def _ask_supplies(path: Path, options: Mapping[str, Any]) -> Photograph | None:
    return next((found for supply in tuple(_supplies) if (found := supply(path, options)) is not None), None)


def _build(arrays: Callable[[tuple[int, ...], DTypeLike], NDArray[Any]], **fields: Any) -> Photograph:
    """A photograph of what the decoder answered, in `arrays` of a shape and a type; an error where these are not the
    fields it takes."""
    for name, value in fields.items():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
        elif isinstance(value, list):
            fields[name] = tuple(value)
    coded: Coded | bayer.Mosaic | None = None
    if "codes" in fields:
        codes: NDArray[Any] = fields["codes"]
        coded = Coded(**{name: fields.pop(name) for name in ("codes", "tables", "white", "matrix") if name in fields})
        height, width, _ = codes.shape
        pixels = arrays((height, width, 3), np.float32), arrays((height, width), np.bool_)
        samples = np.broadcast_to(codes, (height, width, 3))
        decode(samples, coded.tables, coded.matrix, coded.white, *pixels)
        release(codes)
        fields["radiance"], fields["saturated"] = pixels
    elif "mosaic" in fields:
        coded = _take_mosaic(fields)
        if "radiance" not in fields:
            pixels = arrays((*coded.shape, 3), np.float32), arrays(coded.shape, np.bool_)
            coded.develop_into(*pixels)
            fields["radiance"], fields["saturated"] = pixels
        elif (fields["radiance"].shape, fields["saturated"].shape) != ((*coded.shape, 3), coded.shape):
            raise TypeError("pixels of another size than the mosaic")
        release(coded.codes)
    for name in ("radiance", "saturated"):
        fields[name].flags.writeable = False
    return Photograph(**fields, coded=coded)


def _take_mosaic(fields: dict[str, Any]) -> bayer.Mosaic:
    """The mosaic of a RAW file, and `fields` without what a photograph does not have of it."""
    samples, colours, turn = (fields.pop(name) for name in ("mosaic", "colours", "turn"))
    black, white = (np.asarray(fields[name], np.float64).reshape(2, 2) for name in ("black_level", "white_level"))
    camera, multipliers = (np.asarray(fields[name], np.float64) for name in ("camera_matrix", "white_balance"))
    matrix = balance_matrix(camera.reshape(3, 3), multipliers)
    sensor = bayer.Sensor(black, white, np.asarray(colours, np.int64).reshape(2, 2), matrix, turn)
    return bayer.Mosaic.turn_upright(samples, sensor)


def decode_photograph(
    content: bytes,
    name: str,
    white_balance: str | Sequence[float],
    transfer: images.TransferChoice,
    half_size: bool,
    orientation: int = 0,
    white_code: int = 0,
    bands: Sequence[int] = (),
    white_samples: Sequence[float] = (),
    keep_codes: bool = False,
    codes_alone: bool = False,
    mosaic_alone: bool = False,
) -> dict[str, Any]:
    """The decoder that runs in the child; with `codes_alone` codes come without the pixels that are made of them, and
    with `mosaic_alone` so do mosaics of RAW files. A decoder gives pages of pixels back while it fills them.
    """
    if _is_raw(content, name):
        from engine.capture.photograph.raw import decode_raw

        if bands:
            raise InputError(name, "is camera RAW, which has no bands to choose", "Leave --bands out")
        keep_mosaic = keep_codes or mosaic_alone
        found, noted = (
            decode_raw(content, name, white_balance, half_size, keep_mosaic, mosaic_alone),
            read_exif(content),
        )
        optics = note_optics(noted, found.pop("shape"), half_size)
        return {**found, **optics, "credits": _read_credits(content, noted)}
    more: dict[str, Any] = {"bands": bands, "keep_primaries": True, "white_samples": white_samples}
    more |= {"keep_codes": keep_codes, "codes_alone": codes_alone}
    image = images.decode(content, name, transfer, half_size, orientation, white_code, **more)
    if "pixels" in image:
        image["radiance"] = image.pop("pixels")
        images.refuse_larger(name, image["radiance"])
    shape = image["radiance" if "radiance" in image else "codes"].shape
    if Path(name).suffix.lower() in RAW_SUFFIXES:
        image["warnings"].append(f"is a {image['container']} inside, not camera RAW")
    del image["environment"]  # what a photograph is not
    noted = Exif(**image.pop("exif"))
    photographed: dict[str, Any] = {
        name: getattr(noted, name) for name in ("camera", "exposure_s", "iso", "aperture", "orientation")
    }
    photographed |= note_optics(noted, shape, half_size)
    photographed["credits"] = _read_credits(content, noted)
    levels = {"black_level": [], "white_level": [], "white_balance": [1.0, 1.0, 1.0], "camera_matrix": []}
    return {**image, **photographed, **levels}


def _read_credits(content: bytes, noted: Exif) -> dict[str, str]:
    """What the file says of its author, who is not looked for in samples."""
    return read_credits(tiff.cut_images(content) if content.startswith(tiff.SIGNATURES) else content, noted)


def note_optics(noted: Exif, shape: Sequence[int], half_size: bool) -> dict[str, float | None]:
    """The fields of `Photograph` about the lens and the sensor, of upright pixels of this shape."""
    height, width = ((2 if half_size else 1) * side for side in shape[:2])
    if noted.orientation in (5, 6, 7, 8):
        height, width = width, height
    pitch = pixel_pitch_mm(noted, width, height)
    return {"focal_mm": noted.focal_mm, "distance_m": noted.distance_m, "pitch_mm": pitch}


def prepare() -> None:
    """Compile what the decoders run, before the child is confined."""
    images.prepare()
    bayer.prepare()


def _is_raw(content: bytes, name: str) -> bool:
    """By content where a signature tells; a camera's suffix decides for the rest."""
    named_raw = Path(name).suffix.lower() in RAW_SUFFIXES
    if content.startswith(tiff.SIGNATURES):
        return named_raw or tiff.is_raw_tiff(content, name)
    return named_raw and not images.has_signature(content) and not content.startswith(b"version https://git-lfs")


def decode_exposure(content: bytes, name: str) -> dict[str, Any]:
    """The decoder of what the camera noted alone: exposure_s, iso, aperture, each None where it did not."""
    if any(each.of_radiance and content.startswith(each.signatures) for each in readers("image") if each.signatures):
        return {"exposure_s": None, "iso": None, "aperture": None}
    if content.startswith(tiff.SIGNATURES):
        check_directories(content, name, tiff.DIRECTORIES_LIMIT)
    noted = read_exif(content)
    if noted.exposure_s is None and not noted.exposure_garbled and _is_raw(content, name):
        from engine.capture.photograph.raw import read_noted_exposure

        return read_noted_exposure(content, name)
    return {"exposure_s": noted.exposure_s, "iso": noted.iso, "aperture": noted.aperture}


#: Interval of the steps while a photograph is waited for, in seconds.
PATIENCE_S = 0.05


#: Bytes of memory that a pixel of a photograph takes while it is worked on, and while it is decoded; the same where
#: arrays lie on the disk; and the part of the memory that is free which photographs may take.
WORKED_ON_BYTES, DECODED_BYTES, OF_FREE = 16, 32, 0.5
WORKED_ON_DISK_BYTES, DECODED_ON_DISK_BYTES = 4, 12


def count_at_once(pixels: int, free_bytes: int) -> int:
    """Photographs of so many pixels that are decoded at once while one is worked on; 1 where none is meanwhile."""
    worked_on, decoded = WORKED_ON_BYTES, DECODED_BYTES
    if find_results_folder() is not None:
        worked_on, decoded = WORKED_ON_DISK_BYTES, DECODED_ON_DISK_BYTES
    room = int((OF_FREE * free_bytes / max(pixels, 1) - worked_on) // decoded)
    return max(1, min(room, CHILDREN, max(2, thread_count())))


class ReadAhead:
    """Reads `paths` in order, with the options of `read_photograph`; to be closed, which stops the decoders.

    The first is read alone, because nothing else tells how large they are. The pixels of photographs lie in memory that
    others have left, as far as they have.
    """

    def __init__(self, paths: Sequence[Path], **options: Any) -> None:
        self._paths: Iterator[Path] = iter(paths)
        self._options = options
        self._readings: deque[Reading] = deque()
        self._memory = ReusedMemory() if find_results_folder() is None else None
        self._at_once = 0  # not known yet
        self._start(1)

    def _start(self, count: int) -> None:
        """Have `count` photographs decoded, if so many are left."""
        while len(self._readings) < count and (path := next(self._paths, None)) is not None:
            self._readings.append(Reading(path, **self._options, memory=self._memory))

    def next_photograph(self, done: float, note: str) -> Steps[Photograph]:
        """The next photograph; while it is waited for there are steps that say `done` and `note`."""
        self._start(max(1, self._at_once))
        reading = self._readings[0]
        yield Step(done, note)
        while not reading.wait(PATIENCE_S):
            yield Step(done, note)
        photograph = reading.photograph()
        self._readings.popleft()
        if self._at_once == 0:
            self._at_once = count_at_once(photograph.saturated.size, free_bytes())
        self._start(self._at_once - 1)
        return photograph

    def close(self) -> None:
        """Stop what is still being read."""
        for reading in self._readings:
            reading.close()
        self._readings.clear()
        if self._memory is not None:
            self._memory.close()

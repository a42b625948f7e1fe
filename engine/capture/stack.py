"""The stack of linear photographs that everything after the import works on, and the folder that holds it.

A stack folder holds `stack.json` (`engine.capture.stack_record`), and `codes.npy` where pixels are codes of the
photographs or mosaics of RAW files, of which the record says what makes radiance of them
(`engine.capture.coded_pixels`), with `room.npy` where room light is taken off; else `radiance.npy` and `saturated.npy`,
and `diffuse.npy` where the photographs are pairs under polarisers. It is treated as hostile when it is opened: sizes,
shapes and kinds are compared with the record, then the checksums of all pixels (about 0.5 s for a gigabyte). Stacks of
before there were checksums open as well, with a note in their health. The pixels stay on disk and are read when they
are needed.
"""

from __future__ import annotations

import math
import os
import stat
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
from numpy.typing import DTypeLike, NDArray
from pydantic import ValidationError

from engine.capture.coded_pixels import CodedArray, arrays_of
from engine.capture.lights.light_file import CalibratedLights
from engine.capture.lights.light_positions import Light
from engine.capture.report import Quality
from engine.capture.stack_record import parse_record
from engine.core.colour import REC_709, WORKING_SPACES, WorkingSpace, to_display8, working_space
from engine.core.errors import InputError, UsageError
from engine.core.health import Finding, Health, Verdict
from engine.core.summary import Summary
from engine.storage.crc32 import extend_crc32, join_crc32
from engine.storage.file_array import FileArray
from engine.storage.untrusted import read_bytes

if TYPE_CHECKING:
    from engine.capture.stack_record import StackRecord

RECORD, RADIANCE, SATURATED, DIFFUSE = "stack.json", "radiance.npy", "saturated.npy", "diffuse.npy"
CODES, ROOM = "codes.npy", "room.npy"

_RECORD_LIMIT_BYTES = 64 << 20
_AGAIN = "Import the photographs again"
_HEADER_BYTES = 128
_PART_BYTES = 1 << 24


@dataclass(frozen=True, eq=False, repr=False)
class ImageStack(Summary):
    """Aligned linear photographs of one flat sample, ordered by rising elevation of the light.

    Attributes
    ----------
    radiance : (N, H, W, 3) float32, linear Rec.709, negative where a colour lies beyond it, 1 = the photographs' white
        level. In memory, or in a file that is read as far as it is indexed: by photographs and rows (`FileArray`).
    saturated : (N, H, W) bool, True where any channel of the original sample was at the white level; as `radiance`.
    elevation : (N,) float64, radians above the sample plane.
    azimuth : (N,) float64 radians, or None where the light moves along one arc of unknown azimuth.
    mean_radiance : (N,) float64, mean luminance of each photograph over the crop, summed in float64.
    sources : (N,) file names of the photographs.
    angle_source : 'capture.toml', 'lp', 'dome', 'lights', 'file names', 'user', 'assumed', 'mirror sphere' or
        'photographs'.
    provenance : what was assumed and done: camera, levels, white balance, alignment, software.
    health : counts and findings; the report of the import.
    quality : (N,) figures of each photograph, empty for a stack made in memory.
    folder : where the stack lies on disk, None for one in memory.
    diffuse : (N, H, W, 3) float32 part of the radiance that lost its polarisation, where the photographs are pairs
        under parallel and crossed polarisers; the rest is specular. None where it is not known.
    """

    radiance: NDArray[np.float32] | FileArray
    saturated: NDArray[np.bool_] | FileArray
    elevation: NDArray[np.float64]
    azimuth: NDArray[np.float64] | None
    mean_radiance: NDArray[np.float64]
    sources: tuple[str, ...]
    angle_source: str
    provenance: Mapping[str, Any] = field(default_factory=dict)
    health: Health = field(default_factory=Health)
    quality: tuple[Quality, ...] = ()
    folder: Path | None = None
    diffuse: NDArray[np.float32] | FileArray | None = None

    @property
    def working_space(self) -> WorkingSpace:
        """Return the space in which maps of the photographs are made; the radiance itself is linear Rec.709."""
        return working_space(self.provenance.get("working_space") or REC_709.label)

    def with_working_space(self, space: WorkingSpace) -> ImageStack:
        """Return the stack of which maps are made in another space."""
        return replace(self, provenance=MappingProxyType({**self.provenance, "working_space": space.label}))

    @property
    def pixels(self) -> dict[str, NDArray[Any] | FileArray]:
        """Return the arrays in the files of the photographs by the names of these."""
        if isinstance(self.radiance, CodedArray) and self.radiance.codes is not None:
            room = {} if self.radiance.room is None else {ROOM: self.radiance.room}
            return {**room, CODES: self.radiance.codes}
        found: dict[str, NDArray[Any] | FileArray] = {} if self.diffuse is None else {DIFFUSE: self.diffuse}
        return {**found, RADIANCE: self.radiance, SATURATED: self.saturated}

    @property
    def elevation_deg(self) -> NDArray[np.float64]:
        """Degrees without the last digits, which radians cannot keep: 30, not 29.999999999999996."""
        degrees: NDArray[np.float64] = np.degrees(self.elevation).round(9)
        return degrees

    def summary(self) -> dict[str, Any]:
        """Return what `repr` says."""
        count, height, width, _ = self.radiance.shape
        low, high = (float(self.elevation_deg[at]) for at in (0, -1))
        facts = {"photographs": count, "size": f"{width} × {height} px", "elevations": f"{low:g}° to {high:g}°"}
        return {**facts, "angles": self.angle_source, "warnings": len(self.health.warnings)}

    def _repr_png_(self) -> bytes:
        """Return the middle photograph as PNG, at most 384 pixels a side."""
        from engine.images.encode import encode_png

        step = max(1, -(-max(self.radiance.shape[1:3]) // 384))
        image = np.asarray(self.radiance[len(self.sources) // 2])[::step, ::step]
        return encode_png(to_display8(image / max(float(np.quantile(image, 0.98)), 1e-9)))


def lights_of(stack: ImageStack) -> CalibratedLights:
    """The lights of a stack as a file of lights keeps them; UsageError where their azimuths are not known."""
    if stack.azimuth is None:
        raise UsageError("the azimuths of the lights are not known, and a file of lights needs them")
    angles = zip(stack.sources, stack.elevation.tolist(), stack.azimuth.tolist(), strict=True)
    terms = [term for term in stack.provenance.get("calibration") or [] if term.get("accepted")]
    return CalibratedLights(
        tuple(Light(*one, number) for number, one in enumerate(angles, start=1)),
        tuple(stack.provenance.get("lamp_gains") or [1.0] * len(stack.sources)),
        stack.provenance.get("lamp_distance_widths"),
        {term["name"]: float(term["sigma"]) for term in terms if term["name"] in ("distance", "gains")},
    )


def npy_header(shape: Sequence[int], dtype: DTypeLike) -> bytes:
    """The header of an .npy file (version 1.0) of a C-ordered array."""
    kind = np.dtype(dtype)
    text = f"{{'descr': '{kind.str}', 'fortran_order': False, 'shape': {tuple(int(n) for n in shape)}, }}"
    padded = text.ljust(_HEADER_BYTES - 11) + "\n"
    return b"\x93NUMPY\x01\x00" + len(padded).to_bytes(2, "little") + padded.encode("ascii")


def open_stack(
    folder: str | os.PathLike[str], *, verify: bool = True, pixels: str | os.PathLike[str] | None = None
) -> ImageStack:
    """Open a stack folder; the pixels stay on disk, and are read once against their checksums to `verify` them.

    `pixels` is another folder, in which the pixels are or will be: they are looked for whenever they are read, and
    reading them where they are not there is an InputError. With `verify` they have to be there.
    Raises InputError where the folder is not a stack, incomplete, damaged, or made by a newer version.
    """
    place = Path(folder)
    if place.is_file():
        raise InputError(place, "is a file, and a stack is a folder", "Give the folder that an import has written")
    record, is_sealed = _read_record(place)
    space = record.provenance.get("working_space")
    if space is not None and space not in [known.label for known in WORKING_SPACES]:
        raise InputError(place / RECORD, "states a working space that is not known", f"Update Lightarc, or {_AGAIN}")
    arrays: dict[str, FileArray] = {}
    for name, (shape, kind) in kinds_of(record).items():
        crc32 = _checksum_of(record, name)
        if pixels is None:
            arrays[name] = _check(place / name, shape, kind, crc32 if verify else None)
        else:
            arrays[name] = _elsewhere(Path(pixels) / name, shape, kind, crc32, verify)
    if record.codes is not None:
        try:
            decodings = record.codes.decodings()
        except ValueError as error:
            raise InputError(place / RECORD, f"is damaged ({error})", _AGAIN) from None
        size = record.height_px, record.width_px
        arrays[RADIANCE], arrays[SATURATED] = arrays_of(
            arrays[CODES], decodings, record.codes.window, size, arrays.get(ROOM)
        )
    return ImageStack(
        radiance=arrays[RADIANCE],
        saturated=arrays[SATURATED],
        elevation=_read_only(np.radians(record.elevations_deg)),
        azimuth=None if record.azimuths_deg is None else _read_only(np.radians(record.azimuths_deg)),
        mean_radiance=_read_only(np.array(record.mean_radiance, np.float64)),
        sources=tuple(record.sources),
        angle_source=record.angle_source,
        provenance=MappingProxyType(record.provenance),
        health=_health(record, is_sealed),
        quality=tuple(record.quality),
        folder=place,
        diffuse=arrays.get(DIFFUSE),
    )


def kinds_of(record: StackRecord) -> dict[str, tuple[tuple[int, ...], DTypeLike]]:
    """Shape and kind of the arrays in the files of a stack, by the names of these."""
    shape = (len(record.sources), record.height_px, record.width_px)
    if record.codes is not None:
        size = record.codes.find_shape(record.height_px, record.width_px)
        coded: dict[str, tuple[tuple[int, ...], DTypeLike]] = {}
        if record.codes.room_crc32 is not None:
            coded[ROOM] = (1, *shape[1:], 3), np.float32
        return {**coded, CODES: ((len(record.sources), *size, record.codes.channels), record.codes.dtype)}
    files: dict[str, tuple[tuple[int, ...], DTypeLike]] = {
        RADIANCE: ((*shape, 3), np.float32),
        SATURATED: (shape, np.bool_),
    }
    if record.diffuse_crc32 is not None:
        files[DIFFUSE] = ((*shape, 3), np.float32)
    return files


def _checksum_of(record: StackRecord, name: str) -> int | None:
    """The checksum of a file of a stack; None where it has none."""
    if record.codes is None:
        known = {RADIANCE: record.radiance_crc32, SATURATED: record.saturated_crc32, DIFFUSE: record.diffuse_crc32}
        return known[name]
    if name == ROOM:
        return record.codes.room_crc32
    (_, *of_light), kind = kinds_of(record)[CODES]
    light_bytes = math.prod(of_light) * np.dtype(kind).itemsize
    joined = 0
    for each in record.codes.photographs:
        joined = join_crc32(joined, each.crc32, light_bytes)
    return joined


def read_record(folder: Path) -> StackRecord:
    """The record of a stack folder; InputError where it is none, damaged, or made by a newer version."""
    return _read_record(folder)[0]


def _read_record(folder: Path) -> tuple[StackRecord, bool]:
    path = folder / RECORD
    if folder.is_dir() and not path.exists():
        raise InputError(folder, f"is not a stack: it holds no {RECORD}", "Import the photographs into a stack first")
    try:
        return parse_record(read_bytes(path, _RECORD_LIMIT_BYTES), path, _AGAIN)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(str(part) for part in first["loc"])
        if where == "lightarc_stack":
            raise InputError(path, "was made by another version", f"Update Lightarc, or {_AGAIN.lower()}") from None
        problem = f"{where}: {first['msg']}" if where else first["msg"]
        raise InputError(path, f"is damaged ({problem})", _AGAIN) from None


def _health(record: StackRecord, is_sealed: bool) -> Health:
    health = record.health.restored()
    if record.checksums is None:
        text = "imported before stacks had checksums: damaged pixels would not be noticed"
    elif not is_sealed:
        text = "imported before records of stacks were sealed: a changed record would not be noticed"
    else:
        return health
    return health.merge(Health(findings=(Finding(Verdict.NOTE, text),)))


def _check(path: Path, shape: tuple[int, ...], dtype: DTypeLike, crc32: int | None) -> FileArray:
    header = npy_header(shape, dtype)
    expected = len(header) + math.prod(shape) * np.dtype(dtype).itemsize
    try:
        flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
        with open(os.open(path, flags), "rb") as file:  # noqa: PTH123 - opened by descriptor
            status = os.fstat(file.fileno())
            if not stat.S_ISREG(status.st_mode) or status.st_size != expected:
                problem = f"has {status.st_size:,} bytes instead of {expected:,}"
                raise InputError(path, problem, _AGAIN)
            if file.read(len(header)) != header:
                raise InputError(path, f"does not hold {np.dtype(dtype)} of shape {shape}", _AGAIN)
            if crc32 is not None and _checksum(file) != crc32:
                raise InputError(path, "is damaged: the checksum of its pixels does not fit", _AGAIN)
            return FileArray(path, shape, np.dtype(dtype), len(header), status)
    except OSError as error:
        raise InputError(path, f"cannot be read ({os.strerror(error.errno or 0)})", _AGAIN) from None


def _elsewhere(path: Path, shape: tuple[int, ...], dtype: DTypeLike, crc32: int | None, verify: bool) -> FileArray:
    """An array of a file that may come and go."""
    if verify:
        _check(path, shape, dtype, crc32)
    header = npy_header(shape, dtype)
    return FileArray(path, shape, np.dtype(dtype), len(header), None, header)


def _checksum(file: BinaryIO) -> int:
    """CRC-32 of the rest of a file."""
    checksum = 0
    while part := file.read(_PART_BYTES):
        checksum = extend_crc32(checksum, part)
    return checksum


def _read_only(array: NDArray[np.float64]) -> NDArray[np.float64]:
    array.flags.writeable = False
    return array

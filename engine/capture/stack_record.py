"""`stack.json`, the record of a stack folder, as pydantic checks it.

Apart from the stack itself, so that the window is there before pydantic is.
"""

from __future__ import annotations

import base64
import binascii
import json
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from engine.capture.coded_pixels import Curve, Decoding, FallOff, Window, is_same
from engine.capture.photograph.bayer import MARGIN, Sensor
from engine.capture.report import Quality
from engine.core.errors import InputError
from engine.storage.records import HealthRecord, seal
from engine.storage.text import read_json

#: Largest number of a record: no length, time, gain or radiance of a capture comes near.
MAX_NUMBER = 1e12

#: Numbers of the provenance that are computed with: least and largest value of each in the lists of this name.
RANGES = {
    "picture_balance": (1e-9, 1e9),
    "lamp_gains": (1e-9, 1e9),
    "lamp_distance_widths": (1e-9, 1e9),
    "reference_exposure_s": (0.0, 1e9),
    "sphere_px": (-1e7, 1e7),
    "grey_patch_px": (-1e7, 1e7),
}

#: The key of the seal: SHA-256 of all else in the record, the checksums of the pixels included.
SEAL = "record_sha256"


#: Most curves of the photographs of a stack, which are one or as many as the profiles of their files, and largest
#: light by a table and number of a matrix.
CURVES_LIMIT, _LARGEST_LIGHT, _LARGEST_ENTRY = 16, 1e15, 1e6

#: Most photographs of a stack, each of which may have its own balance and so its own record of a sensor.
PHOTOGRAPHS_LIMIT = 100_000

#: Range of the levels of a sensor, whose samples have 16 bits, and least number between black and white.
_LEVELS, _MIN_SPAN = (-1e6, 1e6), 1e-3

_Positive = Annotated[float, Field(gt=0.0, le=1e9)]
_Crc32 = Annotated[int, Field(ge=0, lt=1 << 32)]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True, strict=True)


class CurveRecord(_Strict):
    """Record of light by codes: `tables` is the base64 of the deflated float32 numbers (little-endian), of one table of
    all codes or of three."""

    tables: str = Field(max_length=2 << 20)
    white: int = Field(ge=0, le=1 << 16)
    matrix: list[Annotated[float, Field(ge=-_LARGEST_ENTRY, le=_LARGEST_ENTRY)]] | None = None

    @model_validator(mode="after")
    def _whole(self) -> CurveRecord:
        if self.matrix is not None and len(self.matrix) != 9:
            raise ValueError("a matrix has not 9 numbers")
        return self

    @classmethod
    def describe(cls, curve: Curve) -> CurveRecord:
        """The record of a curve."""
        text = base64.b64encode(zlib.compress(curve.tables.astype("<f4").tobytes())).decode("ascii")
        return cls(
            tables=text,
            white=curve.white,
            matrix=None if curve.matrix is None else curve.matrix.astype(np.float64).ravel().tolist(),
        )

    def restore(self, count: int) -> Curve:
        """The curve of so many codes; ValueError where the tables are damaged."""
        most = 3 * 4 * count
        try:
            content = zlib.decompressobj().decompress(base64.b64decode(self.tables, validate=True), most + 1)
        except (zlib.error, binascii.Error, ValueError):
            content = b""
        if len(content) not in (4 * count, most):
            raise ValueError("a table does not hold all codes")
        tables = np.frombuffer(content, "<f4").astype(np.float32).reshape(-1, count)
        if not (np.abs(tables) <= _LARGEST_LIGHT).all():
            raise ValueError(f"a number of a table is beyond {_LARGEST_LIGHT:g}")
        matrix = None if self.matrix is None else np.array(self.matrix, np.float32).reshape(3, 3)
        return Curve(tables, self.white, matrix)


class SensorRecord(_Strict):
    """Record of how light is made of the samples of a sensor, by numbers of its 2 × 2 sites and of the matrix."""

    demosaic: Literal["malvar2004"] = "malvar2004"
    black: list[Annotated[float, Field(ge=_LEVELS[0], le=_LEVELS[1])]] = Field(min_length=4, max_length=4)
    white: list[Annotated[float, Field(ge=_LEVELS[0], le=_LEVELS[1])]] = Field(min_length=4, max_length=4)
    colours: list[Annotated[int, Field(ge=0, le=2)]] = Field(min_length=4, max_length=4)
    matrix: list[Annotated[float, Field(ge=-_LARGEST_ENTRY, le=_LARGEST_ENTRY)]] = Field(min_length=9, max_length=9)
    orientation: int = Field(ge=1, le=8)

    @classmethod
    def describe(cls, sensor: Sensor) -> SensorRecord:
        """The record of a sensor."""
        return cls(
            black=sensor.black.ravel().tolist(),
            white=sensor.white.ravel().tolist(),
            colours=sensor.colours.ravel().tolist(),
            matrix=sensor.matrix.astype(np.float64).ravel().tolist(),
            orientation=sensor.orientation,
        )

    def restore(self) -> Sensor:
        """The sensor; ValueError where its numbers do not fit together."""
        black, white = (np.array(each, np.float64).reshape(2, 2) for each in (self.black, self.white))
        if not (white - black >= _MIN_SPAN).all():
            raise ValueError("a white level is not above black")
        colours, matrix = np.array(self.colours, np.int64).reshape(2, 2), np.array(self.matrix, np.float32)
        try:
            return Sensor(black, white, colours, matrix.reshape(3, 3), self.orientation)
        except TypeError as error:
            raise ValueError(str(error)) from None


class FallOffRecord(_Strict):
    """Record of a near lamp: its distance in widths of the image, and its angles."""

    distance: float = Field(gt=0.5, le=1e9)
    elevation_rad: float = Field(ge=-2.0, le=2.0)
    azimuth_rad: float = Field(ge=-13.0, le=13.0)

    @classmethod
    def describe(cls, lamp: FallOff | None) -> FallOffRecord | None:
        """The record of a near lamp; None of a distant one."""
        if lamp is None:
            return None
        return cls(distance=lamp.distance, elevation_rad=lamp.elevation, azimuth_rad=lamp.azimuth)

    def restore(self) -> FallOff:
        """The lamp."""
        return FallOff(self.distance, self.elevation_rad, self.azimuth_rad)


class CodedRecord(_Strict):
    """Record of what makes radiance of the codes of one photograph, in the order of `engine.capture.coded_pixels`, and
    of the checksum of its codes."""

    crc32: _Crc32
    curve: int = Field(ge=0, lt=PHOTOGRAPHS_LIMIT)
    factors: list[_Positive] = Field(min_length=3, max_length=3)
    stated: FallOffRecord | None = None
    found: FallOffRecord | None = None
    gain: _Positive = 1.0


class CodesRecord(_Strict):
    """Record of the codes of `codes.npy`, and of what makes radiance of them.

    Attributes
    ----------
    bits, channels : of a code, and of a pixel.
    photograph_px, corner_px : width and height of the photographs, and column and row at which the codes begin.
    curves : those of the photographs. photographs : one for each, in the order of the sources.
    sensors : in place of curves, of samples of RAW files, which are there for the rows and columns around as well.
    room_crc32 : checksum of the room light of `room.npy`, which is taken off; None where there is none.
    """

    bits: Literal[8, 16]
    channels: Literal[1, 3]
    photograph_px: list[Annotated[int, Field(ge=1, le=1 << 20)]] = Field(min_length=2, max_length=2)
    corner_px: list[Annotated[int, Field(ge=0, lt=1 << 20)]] = Field(min_length=2, max_length=2)
    curves: list[CurveRecord] = Field(max_length=CURVES_LIMIT)
    photographs: list[CodedRecord] = Field(min_length=1, max_length=PHOTOGRAPHS_LIMIT)
    sensors: list[SensorRecord] = Field(default=[], max_length=PHOTOGRAPHS_LIMIT)
    room_crc32: _Crc32 | None = None

    @model_validator(mode="after")
    def _check_curves(self) -> CodesRecord:
        if bool(self.curves) == bool(self.sensors):
            raise ValueError("codes have either curves or sensors")
        if any(each.curve >= len(self.curves or self.sensors) for each in self.photographs):
            raise ValueError("a photograph has a curve that is not there")
        if self.sensors and ((self.bits, self.channels) != (16, 1) or min(self.photograph_px) <= MARGIN):
            raise ValueError("samples of a sensor have 16 bits and one channel")
        return self

    @classmethod
    def describe(
        cls,
        codes: tuple[np.dtype[Any], int, int],
        window: Window,
        decodings: Sequence[Decoding],
        checksums: Sequence[int],
        room_crc32: int | None = None,
    ) -> CodesRecord:
        """The record of photographs by their `decodings`; `codes` are kind, channels and margin of theirs."""
        curves: list[Curve | Sensor] = []
        found = []
        for each, crc32 in zip(decodings, checksums, strict=True):
            at = next((at for at, known in enumerate(curves) if is_same(known, each.curve)), len(curves))
            curves += [each.curve] if at == len(curves) else []
            lamps = FallOffRecord.describe(each.stated), FallOffRecord.describe(each.found)
            factors = [float(factor) for factor in each.factors]
            found.append(
                CodedRecord(
                    crc32=crc32, curve=at, factors=factors, stated=lamps[0], found=lamps[1], gain=float(each.gain)
                )
            )
        return cls(
            bits=8 * codes[0].itemsize,  # type: ignore[arg-type]
            channels=codes[1],  # type: ignore[arg-type]
            photograph_px=[window.width, window.height],
            corner_px=[window.left, window.top],
            curves=[CurveRecord.describe(curve) for curve in curves if isinstance(curve, Curve)],
            photographs=found,
            sensors=[SensorRecord.describe(curve) for curve in curves if isinstance(curve, Sensor)],
            room_crc32=room_crc32,
        )

    @property
    def window(self) -> Window:
        """The part of the photographs that the codes show."""
        (width, height), (left, top) = self.photograph_px, self.corner_px
        return Window(height, width, top, left)

    @property
    def dtype(self) -> np.dtype[Any]:
        """Kind of the codes."""
        return np.dtype(np.uint8 if self.bits == 8 else np.uint16)

    def find_shape(self, height: int, width: int) -> tuple[int, int]:
        """Height and width of the codes of a part of this `height` and `width`."""
        return self.window.find_shape(height, width, MARGIN if self.sensors else 0)

    def decodings(self) -> tuple[Decoding, ...]:
        """Decodings of the photographs; ValueError where tables are damaged."""
        curves: list[Curve | Sensor] = [curve.restore(1 << self.bits) for curve in self.curves]
        curves += [sensor.restore() for sensor in self.sensors]
        return tuple(
            Decoding(
                curves[one.curve],
                (one.factors[0], one.factors[1], one.factors[2]),
                None if one.stated is None else one.stated.restore(),
                None if one.found is None else one.found.restore(),
                one.gain,
            )
            for one in self.photographs
        )


class StackRecord(_Strict):
    """`stack.json`: everything but the pixels. It is 2 where these are `codes`, 3 where they are samples of a sensor,
    and 4 where room light is taken off them, of which older versions do not know."""

    lightarc_stack: Literal[1, 2, 3, 4]
    height_px: int = Field(ge=1, le=1 << 20)
    width_px: int = Field(ge=1, le=1 << 20)
    sources: list[str] = Field(min_length=2, max_length=PHOTOGRAPHS_LIMIT)
    elevations_deg: list[float]
    azimuths_deg: list[float] | None
    angle_source: Literal[
        "capture.toml", "lp", "dome", "lights", "file names", "user", "assumed", "mirror sphere", "photographs"
    ]
    mean_radiance: list[float]
    radiance_crc32: int | None = Field(None, ge=0, lt=1 << 32)
    saturated_crc32: int | None = Field(None, ge=0, lt=1 << 32)
    diffuse_crc32: int | None = Field(None, ge=0, lt=1 << 32)
    codes: CodesRecord | None = None
    quality: list[Quality]
    provenance: dict[str, Any]
    health: HealthRecord

    @model_validator(mode="after")
    def _consistent(self) -> StackRecord:
        azimuths = self.sources if self.azimuths_deg is None else self.azimuths_deg
        lists = (self.elevations_deg, azimuths, self.mean_radiance, self.quality)
        if any(len(values) != len(self.sources) for values in lists):
            raise ValueError("lists differ in length")
        for numbers, (least, largest) in _list_ranges(self):
            if not all(least <= number <= largest for number in _numbers(numbers)):
                raise ValueError(f"a number is not between {least:g} and {largest:g}")
        if self.elevations_deg != sorted(self.elevations_deg) or not self._in_range():
            raise ValueError("elevations_deg do not rise from 0 to 90")
        if self.codes is not None:
            self._refuse_other_codes(self.codes)
        if self.lightarc_stack != find_version(self.codes):
            raise ValueError("codes do not belong to the version of the record")
        return self

    def _refuse_other_codes(self, codes: CodesRecord) -> None:
        if len(codes.photographs) != len(self.sources):
            raise ValueError("lists differ in length")
        window = codes.window
        if window.top + self.height_px > window.height or window.left + self.width_px > window.width:
            raise ValueError("the codes reach beyond the photographs")
        if (self.radiance_crc32, self.saturated_crc32, self.diffuse_crc32) != (None, None, None):
            raise ValueError("checksums are of other pixels than the codes")

    @property
    def checksums(self) -> tuple[int, ...] | None:
        """The checksums of all pixels; None where there are none."""
        if self.codes is not None:
            room = () if self.codes.room_crc32 is None else (self.codes.room_crc32,)
            return (*(each.crc32 for each in self.codes.photographs), *room)
        if self.radiance_crc32 is None or self.saturated_crc32 is None:
            return None
        found = (self.radiance_crc32, self.saturated_crc32, self.diffuse_crc32)
        return tuple(each for each in found if each is not None)

    def _in_range(self) -> bool:
        return self.elevations_deg[0] >= 0.0 and self.elevations_deg[-1] <= 90.0


def find_version(codes: CodesRecord | None) -> Literal[1, 2, 3, 4]:
    """The version of the record of a stack with these codes."""
    if codes is None:
        return 1
    if codes.room_crc32 is not None:
        return 4
    return 3 if codes.sensors else 2


def _list_ranges(record: StackRecord) -> Iterator[tuple[Any, tuple[float, float]]]:
    """Parts of a record that hold numbers, with the range of each."""
    yield record.mean_radiance, (-MAX_NUMBER, MAX_NUMBER)
    yield record.azimuths_deg, (-720.0, 720.0)
    yield [list(vars(each).values()) for each in record.quality], (-MAX_NUMBER, MAX_NUMBER)
    yield record.provenance, (-MAX_NUMBER, MAX_NUMBER)
    for name, limits in RANGES.items():
        yield record.provenance.get(name), limits


def _numbers(value: object) -> Iterator[float]:
    if isinstance(value, dict | list):
        for part in value.values() if isinstance(value, dict) else value:
            yield from _numbers(part)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield value


def write_record(record: StackRecord) -> bytes:
    """The record, sealed, as indented JSON."""
    value = record.model_dump(mode="json")
    if record.codes is None:  # as older versions know it
        del value["codes"]
    else:
        unused = {"sensors": not record.codes.sensors, "room_crc32": record.codes.room_crc32 is None}
        value["codes"] = {name: each for name, each in value["codes"].items() if not unused.get(name)}
    return json.dumps({**value, SEAL: seal(value)}, indent=1, ensure_ascii=False, allow_nan=False).encode()


def parse_record(content: bytes, path: Path, remedy: str) -> tuple[StackRecord, bool]:
    """The record in `content`, and whether it is sealed, which those of older versions are not.

    Raises InputError about `path` where the seal does not fit or this is not JSON, and ValidationError where it is no
    record.
    """
    value = read_json(content, path, path.name, remedy)
    sealed = value.pop(SEAL, None) if isinstance(value, dict) else None
    if sealed is not None and sealed != seal(value):
        raise InputError(path, "is not as it was written", remedy)
    return StackRecord.model_validate_json(json.dumps(value)), sealed is not None

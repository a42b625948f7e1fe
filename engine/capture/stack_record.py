"""`stack.json`, the record of a stack folder, as pydantic checks it.

Apart from the stack itself, so that the window is there before pydantic is.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

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


class StackRecord(BaseModel):
    """`stack.json`: everything but the pixels."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True, strict=True)

    lightarc_stack: Literal[1]
    height_px: int = Field(ge=1, le=1 << 20)
    width_px: int = Field(ge=1, le=1 << 20)
    sources: list[str] = Field(min_length=2, max_length=100_000)
    elevations_deg: list[float]
    azimuths_deg: list[float] | None
    angle_source: Literal[
        "capture.toml", "lp", "dome", "lights", "file names", "user", "assumed", "mirror sphere", "photographs"
    ]
    mean_radiance: list[float]
    radiance_crc32: int | None = Field(None, ge=0, lt=1 << 32)
    saturated_crc32: int | None = Field(None, ge=0, lt=1 << 32)
    diffuse_crc32: int | None = Field(None, ge=0, lt=1 << 32)
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
        return self

    def _in_range(self) -> bool:
        return self.elevations_deg[0] >= 0.0 and self.elevations_deg[-1] <= 90.0


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

"""`stack.json`, the record of a stack folder, as pydantic checks it.

Apart from the stack itself, so that the window is there before pydantic is.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from engine.capture.report import Quality
from engine.storage.records import HealthRecord


class StackRecord(BaseModel):
    """`stack.json`: everything but the pixels."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True, strict=True)

    lightarc_stack: Literal[1]
    height_px: int = Field(ge=1, le=1 << 20)
    width_px: int = Field(ge=1, le=1 << 20)
    sources: list[str] = Field(min_length=2, max_length=100_000)
    elevations_deg: list[float]
    azimuths_deg: list[float] | None
    angle_source: Literal["capture.toml", "lp", "dome", "file names", "user", "assumed", "mirror sphere"]
    mean_radiance: list[float]
    radiance_crc32: int | None = Field(None, ge=0, lt=1 << 32)
    saturated_crc32: int | None = Field(None, ge=0, lt=1 << 32)
    quality: list[Quality]
    provenance: dict[str, Any]
    health: HealthRecord

    @model_validator(mode="after")
    def _consistent(self) -> StackRecord:
        azimuths = self.sources if self.azimuths_deg is None else self.azimuths_deg
        lists = (self.elevations_deg, azimuths, self.mean_radiance, self.quality)
        if any(len(values) != len(self.sources) for values in lists):
            raise ValueError("lists differ in length")
        if self.elevations_deg != sorted(self.elevations_deg) or not self._in_range():
            raise ValueError("elevations_deg do not rise from 0 to 90")
        return self

    def _in_range(self) -> bool:
        return self.elevations_deg[0] >= 0.0 and self.elevations_deg[-1] <= 90.0

"""The stack of linear photographs that everything after the import works on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.health import Health


@dataclass(frozen=True, eq=False)
class ImageStack:
    """Aligned linear photographs of one flat sample, ordered by rising elevation of the light.

    Attributes
    ----------
    radiance : (N, H, W, 3) float32, linear sRGB, 1 = the photographs' white level; read-only, memory-mapped.
    saturated : (N, H, W) bool, True where any channel of the original sample was at the white level.
    elevation : (N,) float64, radians above the sample plane.
    azimuth : (N,) float64 radians, or None where the light moves along one arc of unknown azimuth.
    mean_radiance : (N,) float64, mean luminance of each photograph over the crop, summed in float64.
    sources : (N,) file names of the photographs.
    angle_source : 'capture.toml', 'lp', 'file names', 'user' or 'assumed'.
    provenance : what was assumed and done: camera, levels, white balance, alignment, software.
    health : counts and findings; the report of spec 02 step 6.
    folder : where the stack lies on disk, None for one in memory.
    """

    radiance: NDArray[np.float32]
    saturated: NDArray[np.bool_]
    elevation: NDArray[np.float64]
    azimuth: NDArray[np.float64] | None
    mean_radiance: NDArray[np.float64]
    sources: tuple[str, ...]
    angle_source: str
    provenance: Mapping[str, Any] = field(default_factory=dict)
    health: Health = field(default_factory=Health)
    folder: Path | None = None

    @property
    def elevation_deg(self) -> NDArray[np.float64]:
        return np.degrees(self.elevation)

"""Power-law compression of a shading map, f(r) = k_s (r / a_max)^K per texel and channel (Kautz2004 Eq. 4).

The paper takes k_s = s_{S-1}, the brightest slice ('last-slice'); 'least-squares' chooses k_s as well and is never
worse. f(0) = 0 by definition, also where K = 0, because the paper's slice 0 is black. 512 x 512 x 8 x 3 samples take
about 0.1 s on two cores; the paper reports 40 s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.figure_text import percent
from engine.core.health import Finding, Health, Verdict
from engine.core.steps import Step, Steps
from engine.core.summary import Summary
from engine.shading.kept_tiles import KeptTiles, grid_shape
from engine.shading.lookup import Above, Numbers, neighbours, share_and_gain
from engine.shading.power_law_kernel import exponent_grid, fit_rows, log_positions
from engine.shading.shading_map import ShadingMap
from engine.storage.scratch import release, scratch_array

#: Choice of k_s.
Scale = Literal["last-slice", "least-squares"]
SCALES: tuple[Scale, ...] = ("last-slice", "least-squares")

#: Texels of one tile, about 50 ms of work.
TILE_TEXELS = 2**16


@dataclass(frozen=True)
class Storage:
    """Storage of a pair of scale and exponent; a map holds the values that come back from it.

    Attributes
    ----------
    exponent_bits : 32 for floats; 8 or 16 for codes, K = code * `exponent_step`.
    scale_bits : 32 for floats, 16 for half floats.
    bound : largest change of f at any texel and any r that this rounding can cause, in units of radiance.
    measured : the largest change that it caused at the r of any slice, in units of radiance.
    """

    exponent_bits: Literal[8, 16, 32] = 32
    scale_bits: Literal[16, 32] = 32
    exponent_step: float = 0.0
    bound: float = 0.0
    measured: float = 0.0


@dataclass(frozen=True, eq=False, repr=False)
class PowerLawMap(Summary):
    """Six numbers per texel instead of a stack of slices; tiles that they describe too badly may keep their slices.

    Attributes
    ----------
    scale : (H, W, 3) float32, k_s >= 0, linear radiance at r = r_max.
    exponent : (H, W, 3) float32, K >= 0.
    r_max : a_max of the shading map.
    rms : root mean square of slice minus reconstruction over texels, slices and channels, in units of radiance.
    rms_per_channel : (3,) float64, the same per channel.
    error_map : (H, W) float32, the same per texel.
    storage : how many bits the numbers take when they are stored.
    kept : the tiles that keep their slices, None for none; there the error is 0.
    """

    scale: NDArray[np.float32]
    exponent: NDArray[np.float32]
    r_max: float
    rms: float
    rms_per_channel: NDArray[np.float64]
    error_map: NDArray[np.float32]
    health: Health = field(default_factory=Health)
    storage: Storage = Storage()
    kept: KeptTiles | None = None

    def __post_init__(self) -> None:
        shape = self.scale.shape
        if len(shape) != 3 or shape[2] != 3 or 0 in shape or self.exponent.shape != shape:
            raise ValueError(f"scale and exponent must both be (H, W, 3), not {shape} and {self.exponent.shape}")
        if self.error_map.shape != shape[:2]:
            raise ValueError(f"the error map must be {shape[:2]}, not {self.error_map.shape}")
        if not 0 < self.r_max < math.inf:
            raise ValueError(f"r_max = {self.r_max} is not a positive number")
        for name in ("scale", "exponent", "rms_per_channel", "error_map"):
            view = getattr(self, name).view()
            view.flags.writeable = False
            object.__setattr__(self, name, view)
        if not (self.scale.min() >= 0 and self.exponent.min() >= 0):
            raise ValueError("scale and exponent must not be negative or NaN")
        for array in (self.scale, self.exponent):
            release(array)
        if self.kept is not None and self.kept.place.shape != grid_shape(*shape[:2], self.kept.size):
            raise ValueError(f"a grid of {self.kept.place.shape} tiles does not belong to a map of {shape[:2]} texels")

    @property
    def size_bytes(self) -> int:
        """Bytes that the stored numbers take before any packing: the pair and the kept tiles."""
        pair = self.scale.size * (self.storage.scale_bits + self.storage.exponent_bits) // 8
        return pair + (self.kept.slices.nbytes + self.kept.place.nbytes if self.kept is not None else 0)

    def lookup(self, row: ArrayLike, column: ArrayLike, r: ArrayLike, above: Above = "clamp") -> NDArray[np.float32]:
        """f(r) at texel coordinates: (..., 3) float32, linear radiance under unit light.

        Scale and exponent are filtered bilinearly and then evaluated, as a shader does that samples two textures; kept
        tiles are filtered as slices. Arguments as in `ShadingMap.lookup`: what is not a positive finite r is black.
        """
        row, column, r = np.broadcast_arrays(row, column, r)
        scale = np.zeros((*r.shape, 3))
        exponent = np.zeros((*r.shape, 3))
        for rows, columns, weight in neighbours(row, column, *self.scale.shape[:2]):
            scale += weight[..., None] * self.scale[rows, columns]
            exponent += weight[..., None] * self.exponent[rows, columns]
        share, gain = share_and_gain(r, self.r_max, above)
        value = power(scale, exponent, share)
        if self.kept is not None:
            value = self.kept.over(value, row, column, share, self.error_map.shape)
        return _round(value, gain)

    def slice_image(
        self, r: float, above: Above = "clamp", part: tuple[slice, slice] | None = None
    ) -> NDArray[np.float32]:
        """The whole image f(r), (H, W, 3) float32, or a `part`, its rows and columns; equals `lookup` at every texel
        centre."""
        share, gain = share_and_gain(r, self.r_max, above)
        at = (slice(None), slice(None)) if part is None else part
        value = power(self.scale[at], self.exponent[at], share)
        if self.kept is not None:
            whole = part is None
            value = self.kept.image_over(value, float(share)) if whole else self.kept.part_over(value, at, float(share))
        return _round(value, gain)

    def summary(self) -> dict[str, Any]:
        """Return what `repr` says."""
        height, width = self.error_map.shape
        return {"size": f"{width} × {height} texels", "r_max": float(self.r_max), "rms": float(self.rms)}


def power(scale: NDArray[np.floating], exponent: NDArray[np.floating], share: NDArray[np.float64]) -> Numbers:
    """scale * share^exponent in float64, (..., 3) for a share (...) in [0, 1]; 0 where share is 0."""
    lit = share > 0.0
    log_share = np.log(np.where(lit, share, 1.0))
    with np.errstate(under="ignore"):
        value: Numbers = np.where(lit, 1.0, 0.0)[..., None] * scale * np.exp(exponent * log_share[..., None])
    return value


def _round(value: Numbers, gain: Numbers) -> NDArray[np.float32]:
    with np.errstate(under="ignore"):
        return (gain[..., None] * value).astype(np.float32)


def fit(
    shading_map: ShadingMap, scale: Scale = "last-slice", excluded: NDArray[np.bool_] | None = None
) -> Steps[PowerLawMap]:
    """Compress a shading map; the SSE of every texel and channel is its global minimum over K.

    Samples that are clipped in the photographs, and those marked in `excluded` (S, H, W) bool, do not enter the fit
    (they do enter the reported errors); negative samples count as 0. Where the last slice is black or excluded k_s
    is the least-squares one; where it is excluded, at most four times the brightest slice. K is held between 0 (darker
    texels under more light cannot be described; the error map shows them) and a cap at which darker slices are below
    k_s / 1024. A texel without light has k_s = 0 and K = 1.
    The health counts all of these.
    """
    if scale not in SCALES:
        raise ValueError(f"scale is one of {', '.join(SCALES)}, not {scale!r}")
    count, height, width, _ = shading_map.slices.shape
    if excluded is not None and excluded.shape != (count, height, width):
        raise ValueError(f"excluded must be {(count, height, width)}, not {excluded.shape}")
    yield Step(0.0, "preparing the fit")
    grid, log_x = exponent_grid(count), log_positions(count)
    left_out = _list_left_out(shading_map, excluded)
    flat = np.ascontiguousarray(shading_map.slices).reshape(count, height, 3 * width)
    factor, exponent = (scratch_array((height, 3 * width), np.float32) for _ in range(2))
    error_map, sums = np.empty((height, width), np.float32), np.empty((height, 3))
    outcomes = np.zeros((height, 5), np.int64)
    rows = max(1, TILE_TEXELS // width)
    squares = np.empty((rows, 3 * width), np.float32)
    for start in range(0, height, rows):
        stop = min(start + rows, height)
        tile = (np.asarray(factor), np.asarray(exponent), squares, outcomes)
        fit_rows(flat, left_out, scale == "least-squares", grid, log_x, start, stop, *tile)
        of_channels = squares[: stop - start].reshape(stop - start, width, 3)
        error_map[start:stop] = np.sqrt(of_channels.mean(axis=2) / np.float32(count))
        sums[start:stop] = of_channels.sum(axis=1, dtype=np.float64)
        for array in (shading_map.slices, shading_map.clipped, factor, exponent):
            if array is not None:
                release(array)
        yield Step(stop / height, "fitting the power law")
    mean_squares = sums.sum(axis=0) / (height * width * count)
    rms = math.sqrt(mean_squares.mean())
    health = _health(outcomes.sum(axis=0), left_out)
    factor, exponent = (array.reshape(height, width, 3) for array in (factor, exponent))
    return PowerLawMap(factor, exponent, shading_map.r_max, rms, np.sqrt(mean_squares), error_map, health)


def _list_left_out(shading_map: ShadingMap, excluded: NDArray[np.bool_] | None) -> NDArray[np.bool_]:
    """Samples that the fit leaves out, (S, H, W), or (S, 0, 0) for none; read-only like the slices."""
    marked = [array for array in (shading_map.clipped, excluded) if array is not None and array.any()]
    if marked:
        left_out = np.ascontiguousarray(np.logical_or.reduce(marked) if len(marked) > 1 else marked[0]).view()
    else:
        left_out = np.zeros((len(shading_map.slices), 0, 0), np.bool_)
    left_out.flags.writeable = False
    return left_out


def _health(outcomes: NDArray[np.int64], left_out: NDArray[np.bool_]) -> Health:
    """Counts of texels and channels that a power law describes only by convention, with findings where many."""
    total = float(outcomes.sum())
    names = ("black", "flat_or_darkening", "exponent_capped", "extrapolation_held")
    figures = {f"{name}_fraction": float(count) / total for name, count in zip(names, outcomes[1:], strict=True)}
    figures["excluded_sample_fraction"] = float(left_out.mean()) if left_out.size else 0.0
    findings = []
    if figures["flat_or_darkening_fraction"] > 0.01:
        share = f"{percent(figures['flat_or_darkening_fraction'], 3)} of texels and channels"
        findings.append(Finding(Verdict.NOTE, f"{share} do not brighten with the light; the error map shows them"))
    if figures["black_fraction"] > 0.01:
        share = f"{percent(figures['black_fraction'], 3)} of texels and channels"
        findings.append(Finding(Verdict.NOTE, f"{share} are black in every slice"))
    return Health(MappingProxyType(figures), tuple(findings))

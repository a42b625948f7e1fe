"""Departure of a material from the assumptions of shading maps: that it is isotropic, and its relief small.

Then an image depends on the lamp through its mean radiance alone, whatever the lamp's azimuth (Kautz2004 sections 3
and 6). So the lights are sorted into sectors of azimuth, the photographs of each sector are interpolated to
common mean radiances r as the slices of a shading map are, and the slices of equal r are compared:

    difference = sqrt( mean over r, texels, channels and pairs of sectors of (S_i - S_j)^2 / r^2 )

Noise counts as a difference, and so does what shadows do in relief. Clipped texels are left out.
Cost: each photograph is read once, a block of rows at a time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.capture.stack import ImageStack
from engine.core.figure_text import percent
from engine.core.health import Finding, Verdict
from engine.core.side_by_side import list_side_by_side
from engine.core.steps import Step, Steps

SECTOR = math.radians(45.0)
LEVELS = 5

#: Differences up to which the assumptions hold, and above which they are broken.
HOLDS, BREAKS = 0.05, 0.25

#: Texels of all photographs together that are read at once, about 50 MB, and that stay in the cache of a core.
_BLOCK_TEXELS, _CACHED_TEXELS = 1 << 22, 1 << 16


@dataclass(frozen=True)
class AzimuthCheck:
    """Result of the comparison of azimuths.

    Attributes
    ----------
    azimuths_deg : mean azimuth of each sector that was compared.
    mean_radiance : the levels r at which slices were compared.
    difference : relative difference at each level, NaN where nothing is unclipped.
    """

    azimuths_deg: tuple[float, ...]
    mean_radiance: tuple[float, ...]
    difference: tuple[float, ...]

    @property
    def overall(self) -> float:
        """Root mean square of the differences at all levels."""
        known = np.array(self.difference)[np.isfinite(self.difference)]
        return float(np.sqrt(np.mean(known**2))) if known.size else math.nan

    def finding(self) -> Finding:
        """The verdict in words: a note at most, because photographs of several azimuths make a directional material,
        and the error of a shading map that is made of them all the same is stated with it (`Fidelity`)."""
        *first, last = (f"{angle:.0f}°" for angle in sorted(self.azimuths_deg))
        lights = f"Lit from {', '.join(first)} and {last} of azimuth, images"
        if not math.isfinite(self.overall):
            return Finding(Verdict.NOTE, f"{lights} of equal mean radiance are clipped and cannot be compared")
        spread = f"{lights} of equal mean radiance differ by {percent(self.overall)}"
        if self.overall <= HOLDS:
            return Finding(Verdict.GOOD, f"{spread}: isotropic and of small relief, as the method assumes")
        if self.overall <= BREAKS:
            return Finding(Verdict.NOTE, f"{spread}: relief or grain shows, and lamps from other sides will look alike")
        text = (
            f"{spread}: the material is not isotropic, or its relief not small. A directional material shows it; for a "
            "shading map keep the photographs of one azimuth"
        )
        return Finding(Verdict.NOTE, text)


def check_azimuths(stack: ImageStack) -> Steps[AzimuthCheck | None]:
    """Compare the azimuths of a stack; None where there is one azimuth only, or nothing of equal mean radiance."""
    weights = _weights(stack.mean_radiance, stack.azimuth)
    if weights is None:
        return None
    sectors, levels, of_photographs = weights
    squares, counts = np.zeros(LEVELS), np.zeros(LEVELS)
    count, height, width = stack.saturated.shape
    rows = max(1, _BLOCK_TEXELS // (count * width))
    for first in range(0, height, rows):
        yield Step(first / height, "Comparing azimuths")
        block = np.s_[:, first : first + rows]
        more = _squares(of_photographs, stack.radiance[block], stack.saturated[block])
        squares, counts = squares + more[0], counts + more[1]
    return _check(sectors, levels, squares, counts)


def compare_azimuths(
    samples: NDArray[np.float32], mean_radiance: NDArray[np.float64], azimuth: NDArray[np.float64] | None
) -> AzimuthCheck | None:
    """As `check_azimuths`, of `samples` (N, h, w, 3) of the photographs; clipped ones count like the others."""
    weights = _weights(mean_radiance, azimuth)
    if weights is None:
        return None
    sectors, levels, of_photographs = weights
    rows = max(1, _CACHED_TEXELS // (len(samples) * samples.shape[2]))
    clear = np.zeros((len(samples), rows, samples.shape[2]), np.bool_)

    def compare(first: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        band = samples[:, first : first + rows]
        return _squares(of_photographs, band, clear[:, : band.shape[1]])

    squares, counts = zip(*list_side_by_side(compare, range(0, samples.shape[1], rows)), strict=True)
    return _check(sectors, levels, np.sum(squares, axis=0), np.sum(counts, axis=0))


def _check(
    sectors: Sequence[float], levels: NDArray[np.float64], squares: NDArray[np.float64], counts: NDArray[np.float64]
) -> AzimuthCheck:
    mean = np.divide(squares, counts, out=np.full(LEVELS, np.nan), where=counts > 0)
    difference = np.sqrt(mean) / levels
    degrees = tuple(math.degrees(sector) for sector in sectors)
    return AzimuthCheck(degrees, tuple(map(float, levels)), tuple(map(float, difference)))


def _weights(
    mean_radiance: NDArray[np.float64], azimuth: NDArray[np.float64] | None
) -> tuple[list[float], NDArray[np.float64], NDArray[np.float64]] | None:
    """Azimuth of each sector, the levels (L,), and what each photograph gives to each slice (K, L, N)."""
    sectors = [] if azimuth is None else _sectors(azimuth, mean_radiance)
    if azimuth is None or len(sectors) < 2:
        return None
    lowest = max(float(mean_radiance[members].min()) for members in sectors)
    highest = min(float(mean_radiance[members].max()) for members in sectors)
    if not lowest < highest:
        return None
    levels = lowest + (highest - lowest) * (np.arange(LEVELS) + 0.5) / LEVELS
    weights = np.zeros((len(sectors), LEVELS, len(mean_radiance)))
    for of_sector, members in zip(weights, sectors, strict=True):
        means = mean_radiance[members]
        for place, photograph in enumerate(members):
            of_sector[:, photograph] = np.interp(levels, means, np.eye(len(members))[place])
    turns = [np.exp(1j * azimuth[members]).mean() for members in sectors]
    return [float(np.angle(turn) % (2 * math.pi)) for turn in turns], levels, weights


def _sectors(azimuth: NDArray[np.float64], mean_radiance: NDArray[np.float64]) -> list[NDArray[np.intp]]:
    """Photographs of each sector by rising mean radiance, each mean once; the first photograph is amid its sector."""
    of_photograph = np.floor(((azimuth - azimuth[0]) / SECTOR + 0.5) % (2 * math.pi / SECTOR)).astype(int)
    sectors = []
    for sector in np.unique(of_photograph):
        members = np.flatnonzero((of_photograph == sector) & (mean_radiance > 0))
        _, first = np.unique(mean_radiance[members], return_index=True)
        if len(first) >= 2:
            sectors.append(members[first])
    return sectors


def _squares(
    weights: NDArray[np.float64], radiance: NDArray[np.float32], saturated: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(L,) sums over unclipped texels and channels of the mean squared difference of two sectors, and their counts."""
    count = len(weights)
    squares, counts = np.zeros(LEVELS), np.zeros(LEVELS)
    for level in range(LEVELS):
        used = np.flatnonzero(weights[:, level].any(axis=0))
        clear = ~saturated[used].any(axis=0)
        slices = np.tensordot(weights[:, level, used], radiance[used][:, clear].astype(np.float64), axes=1)
        squares[level] = slices.var(axis=0).sum() * 2 * count / (count - 1)
        counts[level] = slices[0].size
    return squares, counts

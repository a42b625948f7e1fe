"""Splitting the sun out of an environment map: tiny bright sources become lamps, what is left is smooth.

A sun of one texel can be a million times as bright as the sky. Coefficients of the whole map are then those of the sun:
quantised wavelets keep nothing else (Wang2004 Sec. 3.4; spec 07, X6), spherical harmonics ring over the whole
sphere, and a few directional lights miss the sky. As lamps, such sources are exact at no cost.

A source is a connected region above some level of luminance that is tiny (`LARGEST` from its middle, or four texels of
coarse maps), carries a share of all light that counts, and is many times as bright as what is around it: the last
tells a lamp from the middle of a softbox, and a strip light is not tiny however narrow it is. Levels double from four
times the mean, and the lowest at which a region is a source counts, so that a sun takes its glow along. What is left in
its place is the median of what is around. Map and lamps together have the light that the map had, to rounding.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.colour import luminance
from engine.core.directions import normalize
from engine.light.environment import EnvironmentMap, direction_at, solid_angles
from engine.light.lamps import Lamp

#: Angular radius of the largest source, in radians: eleven times the sun's, for its glow, blurred maps and spotlights.
LARGEST = math.radians(3.0)

#: Share of the light of the whole map that a source brings at least: what brings less erases nothing (X6).
SHARE = 0.05

#: Ratio of a source's brightness to its surroundings, its own light weighing the mean.
CONTRAST = 8.0

#: The lowest level, in means of the map over the sphere.
FIRST_LEVEL = 4.0

#: Most lamps that are split off, the brightest first.
MAX_SUNS = 8


@dataclass(frozen=True, eq=False)
class _Source:
    """Texels of one source by flat index (N,), what is left in their place (N, 3), and the lamp that it becomes."""

    texels: NDArray[np.int64]
    left: NDArray[np.float32]
    lamp: Lamp


@lru_cache(maxsize=4)
def split_sun(environment: EnvironmentMap) -> tuple[EnvironmentMap, tuple[Lamp, ...]]:
    """The map without its tiny bright sources, and these as lamps, brightest first; the map itself where it has none.

    The lamps are where the map shows them: turn them with it (`Lamp.rotated`). About 0.1 s for 1024 × 512 texels; the
    last few are remembered.
    """
    sources = sorted(_sources(environment.radiance), key=lambda source: -_brightness(source.lamp))[:MAX_SUNS]
    if not sources:
        return environment, ()
    radiance = environment.radiance.copy()
    for source in sources:
        radiance.reshape(-1, 3)[source.texels] = source.left
    rest = EnvironmentMap(radiance, environment.name, environment.health)
    return rest, tuple(source.lamp for source in sources)


def _brightness(lamp: Lamp) -> float:
    return float(luminance(np.array(lamp.irradiance)))


def _sources(radiance: NDArray[np.float32]) -> Iterator[_Source]:
    """All sources of a map; each texel is in at most one."""
    height, width = radiance.shape[:2]
    bright = luminance(radiance).ravel()
    area = np.broadcast_to(solid_angles(height, width), (height, width)).ravel()
    whole = float(bright @ area)
    least = SHARE * whole
    largest = max(2.0 * math.pi * (1.0 - math.cos(LARGEST)), 4.0 * float(area.max()))
    needed, highest = least / largest, float(bright.max())  # a source holds texels of at least this luminance
    level = FIRST_LEVEL * whole / (4.0 * math.pi)
    if whole <= 0.0 or highest < max(needed, level):
        return
    open_texels = np.flatnonzero(bright >= level)
    while open_texels.size and level <= highest:
        taken = []
        for texels in _regions(open_texels, height, width):
            source = _source(radiance, texels, level, least, area) if bright[texels].max() >= needed else None
            if source is not None:
                taken.append(texels)
                yield source
        if taken:
            open_texels = np.setdiff1d(open_texels, np.concatenate(taken), assume_unique=True)
        level *= 2.0
        open_texels = open_texels[bright[open_texels] >= level]


def _regions(texels: NDArray[np.int64], height: int, width: int) -> list[NDArray[np.int64]]:
    """Connected regions of `texels` (flat indices, rising): the eight neighbours, around the seam in longitude."""
    from scipy.sparse import coo_array  # slow to load, and the window must open at once
    from scipy.sparse.csgraph import connected_components

    row, column = np.divmod(texels, width)
    pairs = []
    for down, right in ((0, 1), (1, -1), (1, 0), (1, 1)):
        neighbour = (row + down) * width + (column + right) % width
        place = np.minimum(np.searchsorted(texels, neighbour), len(texels) - 1)
        found = (row + down < height) & (texels[place] == neighbour)
        pairs.append(np.stack([np.flatnonzero(found), place[found]]))
    start, stop = np.concatenate(pairs, axis=1)
    graph = coo_array((np.ones(len(start), np.int8), (start, stop)), shape=(len(texels), len(texels)))
    _, label = connected_components(graph, directed=False)
    order = np.argsort(label, kind="stable")
    return np.split(texels[order], np.flatnonzero(np.diff(label[order])) + 1)


def _source(
    radiance: NDArray[np.float32], texels: NDArray[np.int64], level: float, least: float, area: NDArray[Any]
) -> _Source | None:
    """The region as a source; None where it is too dim, too large or no brighter than what is around it."""
    height, width = radiance.shape[:2]
    flat = radiance.reshape(-1, 3)
    if float(luminance(flat[texels]) @ area[texels]) < least:
        return None
    towards = _directions(texels, height, width)
    bright = luminance(flat[texels]).astype(np.float64) * area[texels]
    middle = normalize(bright @ towards)
    reach = _angle(towards, middle).max()
    texel = math.sqrt(2.0 * math.pi**2 / (height * width))  # side of a texel at the equator
    if reach > (LARGEST if len(texels) > 4 else max(LARGEST, 1.5 * texel)):
        return None
    around = _around(middle, 2.0 * float(reach) + 2.5 * texel, height, width)
    around = around[luminance(flat[around]) < level]
    if around.size == 0:
        return None
    left = np.minimum(flat[texels], np.median(flat[around], axis=0).astype(np.float32))
    own = float(bright @ luminance(flat[texels]) / bright.sum())
    beside = float(luminance(flat[around]) @ area[around] / area[around].sum())
    excess = flat[texels].astype(np.float64) - left
    flux = area[texels] @ excess
    if own < CONTRAST * beside or float(luminance(flux)) < least:
        return None
    return _Source(texels, left, _lamp(towards, excess, area[texels]))


def _lamp(towards: NDArray[np.float64], excess: NDArray[np.float64], area: NDArray[np.float64]) -> Lamp:
    """The disc of all of `excess` (N, 3): about its mean direction, as large as the radiance is spread."""
    bright = luminance(excess)
    x, y, z = normalize((bright * area) @ towards)
    solid_angle = float((bright @ area) ** 2 / ((bright * bright) @ area))
    radius = 2.0 * math.asin(min(1.0, math.sqrt(solid_angle / (4.0 * math.pi))))
    red, green, blue = (area @ excess) * math.cos(radius / 2.0) ** 2
    return Lamp((x, y, z), (red, green, blue), radius)


def _directions(texels: NDArray[np.int64], height: int, width: int) -> NDArray[np.float64]:
    row, column = np.divmod(texels, width)
    return direction_at((column + 0.5) / width, (row + 0.5) / height)


def _angle(towards: NDArray[np.float64], middle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles between unit vectors (N, 3) and (3,), exact also where they are small."""
    return 2.0 * np.arcsin(np.clip(0.5 * np.linalg.norm(towards - middle, axis=-1), 0.0, 1.0))


def _around(middle: NDArray[np.float64], reach: float, height: int, width: int) -> NDArray[np.int64]:
    """Texels whose centres are within `reach` of the direction `middle`."""
    polar = math.acos(min(1.0, max(-1.0, float(middle[1]))))
    rows = np.arange(max(0, int((polar - reach) / math.pi * height)), height)
    rows = rows[(rows + 0.5) * math.pi / height <= polar + reach]
    texels = (rows[:, None] * width + np.arange(width)).ravel()
    return texels[_angle(_directions(texels, height, width), middle) <= reach]

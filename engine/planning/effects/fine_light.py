"""An environment in few texels of unequal size: large where it is even, small where it is not.

The texels of a coarse cube map are cut in four where that makes the largest difference, and again, until lamps that are
smaller than a degree stand alone. Some thousand texels then tell what a hundred thousand would.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.colour import luminance
from engine.core.directions import Vectors
from engine.light.cube_map import cube_directions, cube_of, cube_solid_angles, texel_numbers
from engine.planning.effects.sample import Light

Array = NDArray[np.float64]

#: Edges of the cube maps that texels are of, each twice the one before, and how many of one are cut into the next.
EDGES, CUT = (16, 32, 64, 128), (256, 384, 512)


@dataclass(frozen=True, eq=False)
class FineLight:
    """T texels of a light without its lamps.

    Attributes
    ----------
    direction : (T, 3) of their middles. area : (T,) sr, which add up to 4 π. radiance : (T, 3).
    """

    direction: Vectors
    area: Array
    radiance: Array
    _number: NDArray[np.int64]

    @property
    def incident(self) -> Array:
        """(T, 3) radiance times solid angle."""
        return self.radiance * self.area[:, None]

    def at(self, direction: Vectors) -> NDArray[np.int64]:
        """(N,) the texels that directions (N, 3) lie in."""
        found: NDArray[np.int64] = self._number[texel_numbers(direction, EDGES[-1])]
        return found


@lru_cache(maxsize=4)
def fine_light(light: Light) -> FineLight:
    """Fine cells of `light` without its lamps; some 50 ms, and remembered."""
    fine = cube_of(light.rest, EDGES[-1]).radiance.astype(np.float64)
    area = np.tile(cube_solid_angles(EDGES[-1]), (6, 1, 1))
    bright: Array = np.asarray(luminance(fine), np.float64)
    whole: NDArray[np.bool_] = np.ones((6, EDGES[0], EDGES[0]), np.bool_)
    number = np.zeros(area.shape, np.int64)
    directions: list[Vectors] = []
    areas: list[Array] = []
    radiances: list[Array] = []
    for edge, cut in zip(EDGES, (*CUT, 0), strict=True):
        size = EDGES[-1] // edge
        own = _sums(area, size)
        split = _max_uneven(np.where(whole, _unevenness(bright, area, size), 0.0), cut)
        left = whole & ~split
        first = sum(len(each) for each in areas)
        numbers = np.cumsum(left.ravel()).reshape(left.shape) - 1 + first
        number = np.where(_spread(left, size), _spread(numbers, size), number)
        directions.append(cube_directions(edge)[left])
        areas.append(own[left])
        radiances.append(np.stack([_sums(each * area, size) for each in np.moveaxis(fine, -1, 0)], -1)[left])
        radiances[-1] /= areas[-1][:, None]
        whole = _spread(split, 2)
    return FineLight(np.concatenate(directions), np.concatenate(areas), np.concatenate(radiances), number.ravel())


def _sums(values: Array, size: int) -> Array:
    """(6, N / size, N / size) of (6, N, N)."""
    edge = values.shape[1] // size
    return np.asarray(values.reshape(6, edge, size, edge, size).sum(axis=(2, 4)))


def _spread(values: NDArray[Any], size: int) -> NDArray[Any]:
    """(6, N size, N size) of (6, N, N)."""
    return np.repeat(np.repeat(values, size, axis=1), size, axis=2)


def _unevenness(bright: Array, area: Array, size: int) -> Array:
    """(6, N / size, N / size) how much light of each texel is not where it would be if it were even."""
    mean = _sums(bright * area, size) / _sums(area, size)
    return _sums(np.abs(bright - _spread(mean, size)) * area, size)


def _max_uneven(gain: Array, count: int) -> NDArray[np.bool_]:
    """The `count` texels of the largest `gain`, those without any apart."""
    chosen = np.zeros(gain.size, np.bool_)
    if count:
        chosen[np.argpartition(gain.ravel(), -count)[-count:]] = True
    return (chosen & (gain.ravel() > 1e-9 * gain.sum())).reshape(gain.shape)

"""Gains by which maps that are seen from afar are as bright, under each light, as they are from near.

A texel of a smaller size stands for many. No planes of a directional map and no power law give the mean of their
radiance under every light exactly: what is left of it reaches 10 % under light from one side, and 30 % under light that
is low. So each size has a factor for each light, by which the mean over the whole map is that of the full size: both
means are taken over the same places, between texels as well, where filters show neither one texel nor the mean of two.
Slices are means of radiance and need no factors.

Cost: the radiance of `PLACES` places for each size and light, 0.1 s for a size of a directional map.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from engine.core.cached import remember_with
from engine.core.colour import srgb_decode
from engine.core.directions import surface_direction
from engine.render.mip_maps import Levels
from engine.shading.directional.effective_light import TILTS, TURNS, bilinear
from engine.shading.directional.planes import DirectionalMap
from engine.shading.lookup import neighbours
from engine.shading.power_law import PowerLawMap
from engine.shading.shading_map import ShadingMap
from engine.surface.pbr_maps import PbrMaps

Array = NDArray[np.float64]
Gains = NDArray[np.float32]

#: Places of a map over which radiance is averaged, evenly spread.
PLACES = 4096

#: Steps of R2, Roberts' sequence of places: powers of the inverse of the plastic number.
_STEPS = np.array([[0.7548776662466927], [0.5698402909980532]])

#: Angles from the normal and azimuths of light under which planes are averaged.
SUMMED_TILTS, SUMMED_TURNS = 12, 18

#: Codes of a table of radiance, eight to each of sRGB, up to twice white.
_CODES = 4096

#: Shares of r_max for which power laws are averaged: powers of 2 at even steps from this one to 0.
LOWEST_POWER, SHARES = -16.0, 65

#: Least mean radiance that counts, as a part of the largest.
DARK = 1e-6

#: The one factor of maps that need none.
NO_GAINS = np.ones((1, 1, 1, 3), np.float32)


#: Layers (L, N, 3) of maps at N places.
Layers = NDArray[np.float32] | Array


def gains_of(maps: ShadingMap | PowerLawMap | DirectionalMap | PbrMaps | None, levels: Levels) -> Gains:
    """(levels, A, B, 3) the factors of maps at each of their `levels`; one factor of 1 where they need none."""
    return _gains_in_grid(maps, levels) if isinstance(maps, PowerLawMap | DirectionalMap) else NO_GAINS


@remember_with
def _gains_in_grid(maps: PowerLawMap | DirectionalMap, levels: Levels) -> Gains:
    return compare_means(maps, [interpolate(level) for level in levels])


def interpolate(level: NDArray[np.float32]) -> Layers:
    """Layers (L, N, 3) of one size (L, h, w, 3) at the places over which radiance is averaged."""
    height, width = level.shape[1:3]
    places = np.mod(np.arange(1, PLACES + 1) * _STEPS, 1.0)
    value = np.zeros((len(level), PLACES, 3), np.float32)
    for row, column, share in neighbours(places[0] * height, places[1] * width, height, width):
        value += share[:, None].astype(np.float32) * level[:, row, column]
    return value


def compare_means(
    maps: ShadingMap | PowerLawMap | DirectionalMap, seen: Sequence[Layers], whole: Layers | None = None
) -> Gains:
    """Factors that bring the mean radiance of layers `seen` at each size to that of the `whole`, or of the first."""
    if isinstance(maps, ShadingMap):
        return NO_GAINS
    observe = observe_planes(maps) if isinstance(maps, DirectionalMap) else observe_powers
    means = np.stack([observe(layers) for layers in seen])
    wanted = means[0] if whole is None else observe(whole)
    floor = DARK * max(float(np.max(wanted)), 1e-30)
    found = ((wanted + floor) / (means + floor)).astype(np.float32)
    return _between_directions(found) if isinstance(maps, DirectionalMap) else found[:, None]


def observe_powers(layers: Layers) -> Array:
    """(SHARES, 3) mean radiance of the layers scale, exponent, and coverage by kept tiles if there are any, by shares
    as `place_of_share` has them."""
    scale = layers[0] * (1.0 - layers[2]) if len(layers) > 2 else layers[0]
    powers = np.linspace(LOWEST_POWER, 0.0, SHARES)
    return np.stack([(scale * np.exp2(layers[1] * power)).mean(axis=0, dtype=np.float64) for power in powers])


def observe_planes(directional: DirectionalMap) -> Callable[[Layers], Array]:
    """Mean radiance (SUMMED_TILTS, SUMMED_TURNS, 3) of layers of planes by three, by directions of light."""
    tilt = np.linspace(0.0, 0.5 * np.pi, SUMMED_TILTS)
    turn = np.arange(SUMMED_TURNS) * (2.0 * np.pi / SUMMED_TURNS)
    functions = directional.functions(surface_direction(tilt[:, None], turn[None]).reshape(-1, 3)).astype(np.float32)
    constant, weights = functions[..., 0].reshape(-1), functions[..., 1:].reshape(-1, functions.shape[-1] - 1)
    table = srgb_decode(np.arange(_CODES) * (8.0**-1 / 255.0)).astype(np.float32)

    def observe(layers: Layers) -> Array:
        planes = np.moveaxis(layers, 0, 1).reshape(layers.shape[1], -1)[:, : weights.shape[1]]
        codes = planes.astype(np.float32) @ weights.T + constant
        radiance = table[np.clip(8.0 * codes + 0.5, 0, _CODES - 1).astype(np.int32)]
        return radiance.mean(axis=0, dtype=np.float64).reshape(SUMMED_TILTS, SUMMED_TURNS, 3)

    return observe


def _between_directions(found: Gains) -> Gains:
    """Factors at the directions of a directional map's own table."""
    down, along = np.meshgrid(
        np.linspace(0.0, SUMMED_TILTS - 1.0, TILTS), np.arange(TURNS) * SUMMED_TURNS / TURNS, indexing="ij"
    )
    finer = [bilinear(each, down.ravel(), along.ravel(), wrap_second=True) for each in found]
    return np.stack(finer).reshape(len(found), TILTS, TURNS, 3).astype(np.float32)


def place_of_share(share: Array) -> Array:
    """Places of shares (N,) of r_max among `SHARES`; of what is darker, the first."""
    power = np.log2(np.clip(share, 2.0**LOWEST_POWER, 1.0))
    return np.asarray((1.0 - power / LOWEST_POWER) * (SHARES - 1))


def place_of_direction(cosine: Array, azimuth: Array) -> tuple[Array, Array]:
    """Places of directions of light (N,) along the axes of the gains of planes."""
    down = np.arccos(np.clip(cosine, 0.0, 1.0)) / (0.5 * np.pi) * (TILTS - 1)
    return np.asarray(down), np.asarray(np.mod(azimuth / (2.0 * np.pi), 1.0) * TURNS)


def gains_at(gains: Gains, detail: Array, first: Array, second: Array) -> Array:
    """(N, 3) of gains (levels, A, B, 3) at mip levels `detail` and places along A and B, which repeats, (N,) each."""
    value = np.ones((len(detail), 3))
    level = np.clip(detail, 0.0, len(gains) - 1.0)
    for size, factors in enumerate(gains):
        weight = np.maximum(1.0 - np.abs(level - size), 0.0)
        used = np.flatnonzero(weight)
        if used.size and not (size == 0 and (factors == 1.0).all()):
            found = bilinear(factors, first[used], second[used], wrap_second=True)
            value[used] += weight[used, None] * (found - 1.0)
    return value

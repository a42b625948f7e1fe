"""Light for wavelet transport: an environment as wavelets, and what is too bright and small for that as lamps.

A sun in the map would erase the sky (one scale for all quantised coefficients), so it is split off
(`engine.light.sun_split`) and falls on each vertex as a lamp does: its irradiance times visibility, by a ray, times
cosine and light maps. Lamps of the scene do the same. That costs a ray for each vertex and direction, and only when
lamps or model change. Interreflection of lamps is that of narrow lobes of light in the map. For light that changes
step by step, `engine.transport.wavelet.relight` spares what stays.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.core.cached import cached_property
from engine.light.cube_map import cube_of
from engine.light.environment import DistantLights, EnvironmentMap
from engine.light.lamps import Lamp, lights_of_all
from engine.light.sun_split import split_sun
from engine.transport.wavelet.haar import FACES
from engine.transport.wavelet.quantise import THRESHOLD, WaveletLight, encode_light
from engine.transport.wavelet.transfer import (
    WaveletTransport,
    cube_texels,
    reflect_light,
    relight_transport,
    split_by_kind,
)

#: Standard deviation in rad of the lobes that lamps are for interreflection, some texels of its vectors.
LOBE = 0.1


@dataclass(frozen=True, eq=False)
class Lighting:
    """Light from all around and from lamps, the sun of the map among them."""

    light: WaveletLight
    lamps: tuple[Lamp, ...] = ()

    @cached_property
    def directional(self) -> DistantLights:
        """The lamps as directional lights."""
        return lights_of_all(self.lamps)


def lighting_of(
    environment: EnvironmentMap,
    edge: int,
    *,
    rotation: float = 0.0,
    factor: float = 1.0,
    lamps: Sequence[Lamp] = (),
    threshold: int = THRESHOLD,
    split: bool = True,
) -> Lighting:
    """The light of `environment`, rotated about +Y by `rotation` rad and times `factor`, with `lamps` beside it.

    Without `split`, a sun stays in the map. ValueError for an edge without wavelets or a threshold out of range.
    """
    rest, suns = split_sun(environment) if split else (environment, ())
    cube = cube_of(rotate(rest, rotation), edge)
    light = encode_light(cube.radiance.astype(np.float64) * factor, threshold)
    moved = tuple(_scale(sun.rotate(rotation), factor) for sun in suns)
    return Lighting(light, (*moved, *lamps))


def dark(edge: int, lamps: Sequence[Lamp]) -> Lighting:
    """Lamps alone."""
    return Lighting(encode_light(np.zeros((6, edge, edge, 3))), tuple(lamps))


def rotate(environment: EnvironmentMap, angle: float) -> EnvironmentMap:
    """The map rotated about +Y by `angle` rad: what came from +Z comes from +X after π/2, linear between texels."""
    width = environment.radiance.shape[1]
    columns = angle / (2.0 * math.pi) * width
    whole = math.floor(columns)
    share = np.float32(columns - whole)
    left = np.roll(environment.radiance, -whole, axis=1)
    if not share:
        return environment if whole % width == 0 else EnvironmentMap(left, environment.name, environment.health)
    between = (np.float32(1.0) - share) * left + share * np.roll(left, -1, axis=1)
    return EnvironmentMap(between, environment.name, environment.health)


def _scale(lamp: Lamp, factor: float) -> Lamp:
    red, green, blue = (channel * factor for channel in lamp.irradiance)
    return Lamp(lamp.direction, (red, green, blue), lamp.radius)


def tuples(transport: WaveletTransport, lighting: Lighting) -> NDArray[np.float64]:
    """The light-modulated K-tuples (R, 3) under all the light, mixed where the transport has a mixture."""
    rows = relight_transport(transport, lighting.light)
    rows += reflect_light(transport, lighting.light)
    if len(lighting.directional.direction):
        rows += lamp_tuples(transport, lighting.directional)
    return mix(transport, rows)


def mix(transport: WaveletTransport, rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """`rows` of all terms, multiplied in place by the weights of the transport's mixture, if it has one."""
    return rows if transport.mixture is None else transport.mixture.applied(rows)


def _lobes(lights: DistantLights, edge: int) -> WaveletLight:
    """Lobes as wide as `LOBE` with the irradiance of `lights`, as wavelets of an `edge`."""
    texels, radiance = cube_texels(edge), np.zeros((FACES * edge * edge, 3))
    for direction, irradiance in zip(lights.direction, lights.irradiance, strict=True):
        lobe = np.exp((texels.direction @ direction - 1.0) / LOBE**2)
        radiance += lobe[:, None] * (irradiance / (lobe @ texels.area))
    return encode_light(radiance.reshape(FACES, edge, edge, 3), 0)


def lamp_tuples(transport: WaveletTransport, lights: DistantLights) -> NDArray[np.float64]:
    """The K-tuples (R, 3) of directional lights, with shadows from one ray for each vertex and light."""
    of = transport.receivers
    first, terms, factors = transport.ground_vertex, transport.terms, transport.factors
    rows = np.zeros((transport.rows, 3))
    if transport.bounces is not None:
        rows += reflect_light(transport, _lobes(lights, transport.edge))
    model = rows[: first * terms].reshape(first, terms, 3)
    for direction, irradiance in zip(lights.direction, lights.irradiance, strict=True):
        local = np.einsum("nij,i->nj", transport.frames, direction)
        facing = np.flatnonzero(local[:, 2] > 0.0)
        towards = np.broadcast_to(direction, (len(facing), 3))
        lit = facing[~of.caster.occluded(of.origin[facing], towards)]
        incident = local[lit, 2:] * irradiance
        on_model = lit < first
        for of_kind, some in split_by_kind(transport.kind, terms, lit[on_model]):
            chosen, arriving = lit[on_model][some], incident[on_model][some]
            for k, light_map in enumerate(factors.second[of_kind]):
                model[chosen, k] += factors.hemisphere_map.look_up(light_map, local[chosen]) * arriving
        rows[first * terms + lit[~on_model] - first] += incident[~on_model]
    return rows

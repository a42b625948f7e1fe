"""Lamps near a model in spherical harmonics: an incident light field (Kautz2002 Sec. 4).

Light from afar is the same for all vertices; light from nearby is not. It is found at the points of a grid about the
vertices, of spheres in closed form and of rectangles and discs as a sum over `POINTS` of their points, and between them
interpolated for each vertex, trilinearly.

The grid is refined until what is interpolated differs from the closed form by at most `TOLERANCE` at some vertices
(root mean square, relative to all coefficients). Shadows are those of the bake: whatever lies in the direction of a
lamp shades, behind the lamp as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.directions import Vectors
from engine.core.errors import UsageError
from engine.light.near_lamps import NearLamp, distance_of, near_lights
from engine.transport.sh.basis import disc_zonal, evaluate, turn_zonal

#: Points along the longest side of the grid, one try after the other.
SWEEP = (2, 3, 5, 9, 17, 33)

#: The error of interpolation that is accepted.
TOLERANCE = 0.01

#: Light of this size leaves 32-bit floats once it is added up.
LARGEST = 1e30

#: Points of a rectangle or a disc.
POINTS = 64

#: Vertices whose interpolated light is compared with their own.
PROBES = 256

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class NearLight:
    """The light of near lamps at vertices: `coefficients` (V, order², 3) float32, from so many `points` of grids.

    `error_rel` is how far interpolation is from the closed form at some vertices.
    """

    coefficients: NDArray[np.float32]
    points: int
    error_rel: float


def incident(lamps: Sequence[NearLamp], points: ArrayLike, order: int, least: float = 0.0) -> Array:
    """(P, order², 3) coefficients of the radiance that `points` (P, 3) get from `lamps`.

    Within the distance `least` of the centre of a lamp, light is that of this distance; within the lamp that of its
    surface. UsageError for a point at the very place of a lamp that is a point.
    """
    where = np.asarray(points, np.float64).reshape(-1, 3)
    total = np.zeros((len(where), order**2, 3))
    for lamp in lamps:
        if lamp.shape != "sphere":
            for direction, irradiance in near_lights(lamp, where, POINTS, least):
                lit = np.flatnonzero(irradiance.any(axis=1))
                total[lit] += evaluate(order, direction[lit])[..., None] * irradiance[lit, None, :]
            continue
        offset = np.asarray(lamp.position) - where
        distance = np.maximum(np.sqrt(np.einsum("pi,pi->p", offset, offset)), max(least, lamp.radius))
        if (distance == 0.0).any():
            raise UsageError("a lamp that is a point lies on a vertex")
        offset[~offset.any(axis=1)] = (0.0, 1.0, 0.0)
        about = turn_zonal(disc_zonal(order, np.arcsin(np.minimum(lamp.radius / distance, 1.0))), offset)
        total += (about / (4.0 * np.pi * distance**2)[:, None])[..., None] * np.asarray(lamp.power)
    return total


def near_light(lamps: Sequence[NearLamp], positions: Vectors, order: int, points: int | None = None) -> NearLight:
    """The light of `lamps` at vertices with `positions` (V, 3).

    `points` is how many there are along the longest side of the grid, and otherwise found by the error. UsageError
    where a lamp touches a vertex, and for less than one point.
    """
    if points is not None and not 1 <= points <= SWEEP[-1]:
        raise UsageError(f"{points} points along a side are outside 1 … {SWEEP[-1]}")
    least = 0.5 * min((_clearance(lamp, positions) for lamp in lamps), default=0.0)
    probes = np.unique(np.linspace(0, len(positions) - 1, PROBES).astype(np.int64)) if len(positions) else slice(0, 0)
    exact = incident(lamps, positions[probes], order)
    size = float(np.linalg.norm(exact))
    if not size < LARGEST:
        raise UsageError("a lamp is too bright for numbers of 32 bits")
    for along in (points,) if points is not None else SWEEP:
        nodes = grid(positions, along)
        values = incident(lamps, list(product(*nodes)), order, least)
        difference = interpolate(nodes, values, positions[probes]) - exact
        error = float(np.linalg.norm(difference)) / size if size > 0.0 else 0.0
        if error <= TOLERANCE:
            break
    return NearLight(interpolate(nodes, values, positions), len(values), error)


def _clearance(lamp: NearLamp, positions: Vectors) -> float:
    """The distance of the nearest vertex from the centre of a sphere, or from the surface of another `lamp`."""
    nearest = float(distance_of(lamp, positions).min()) if len(positions) else 1.0
    if nearest <= (lamp.radius if lamp.shape == "sphere" else 0.0):
        place = ", ".join(f"{x:g}" for x in lamp.position)
        raise UsageError(
            f"the lamp at {place} of radius {lamp.radius:g} touches the model, {nearest:.3g} from its centre"
            if lamp.shape == "sphere"
            else f"the {lamp.shape} at {place} touches the model"
        )
    return nearest


def grid(positions: Vectors, along: int) -> list[Array]:
    """Coordinates of the points of a grid, for each axis: `along` on the longest side of the box of `positions`."""
    if not len(positions):
        return [np.zeros(1)] * 3
    low, high = positions.min(axis=0), positions.max(axis=0)
    longest = float((high - low).max())
    share = (high - low) / longest if longest > 0.0 else np.zeros(3)
    counts = np.where(share > 1e-6, np.maximum(np.ceil((along - 1) * share - 1e-9).astype(int) + 1, min(along, 2)), 1)
    return [
        np.linspace(low[k], high[k], counts[k]) if counts[k] > 1 else np.array([0.5 * (low[k] + high[k])])
        for k in range(3)
    ]


def interpolate(nodes: Sequence[Array], values: Array, positions: Vectors) -> NDArray[np.float32]:
    """(V, order², 3) between the `values` (points, order², 3) of a grid, trilinear; beyond it those of its sides."""
    counts = [len(some) for some in nodes]
    result = np.zeros((len(positions), *values.shape[1:]), np.float32)
    places = [np.interp(positions[:, k], nodes[k], np.arange(counts[k])) for k in range(3)]
    lows = [np.clip(place.astype(np.int64), 0, max(count - 2, 0)) for place, count in zip(places, counts, strict=True)]
    single = values.astype(np.float32)
    for corner in product((0, 1), repeat=3):
        weight, index = np.ones(len(positions)), np.zeros(len(positions), np.int64)
        for k in range(3):
            share = places[k] - lows[k]
            weight *= share if corner[k] else 1.0 - share
            index = index * counts[k] + np.minimum(lows[k] + corner[k], counts[k] - 1)
        used = np.flatnonzero(weight)
        result[used] += single[index[used]] * weight[used, None, None].astype(np.float32)
    return result

"""Directions towards lights near a model, drawn evenly over the solid angle in which a point sees each.

A sphere is seen in a cone. A rectangle is drawn by the map of Urena2013; a disc that is seen large by that of the
square about it, of which what is beside the disc carries no light. Rectangles and discs that are seen small are drawn
by area, which is then nearly as even.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import dot, normalize, world_from_tangent
from engine.light.near_lamps import NearLamp

Floats = NDArray[np.float64]

#: Solid angle in sr below which a rectangle is drawn by area, since the map loses digits there, and below which a disc
#: is, as seen in the square about it: above, draws beside the disc cost less than uneven ones.
SMALL, SMALL_DISC = 1e-5, 3.0


def draw_towards(lamp: NearLamp, u: Floats, points: Floats) -> tuple[Floats, Floats, Floats, Floats | None]:
    """Directions from `points` (N, 3) towards a lamp, for u (N, 2) in [0, 1).

    Returns
    -------
    direction : (N, 3) unit vectors.
    distance : (N,) of the lamp in that direction.
    light : (N, 3) linear RGB radiance that comes from there, 0 where the lamp shines to the other side; of a lamp that
        is a point its irradiance on a surface that faces it.
    density : (N,) in 1/sr; None of a point.
    """
    if lamp.is_point:
        return (*_towards_point(lamp, points), None)
    if lamp.shape == "sphere":
        axis, _, deficit = _cone(lamp, points)
        lower, turn = u[:, 0] * deficit, 2.0 * np.pi * u[:, 1]
        sine = np.sqrt(lower * (2.0 - lower))
        local = np.column_stack([sine * np.cos(turn), sine * np.sin(turn), 1.0 - lower])
        direction = np.einsum("nij,nj->ni", world_from_tangent(axis), local)
    else:
        direction = normalize(_SeenRectangle(lamp, points).draw(u))
    light, density, distance = light_along(lamp, points, direction)
    return direction, distance, light, density


def light_along(lamp: NearLamp, points: Floats, direction: Floats) -> tuple[Floats, Floats, Floats]:
    """Radiance (N, 3) that `points` (N, 3) get from unit `direction` (N, 3) of a lamp that is no point, the density
    (N,) in 1/sr of `draw_towards` there, and the distance (N,) of the lamp; 0, 0 and infinity where it is not."""
    if lamp.shape == "sphere":
        axis, distance, deficit = _cone(lamp, points)
        chord = direction - axis
        inside = 0.5 * dot(chord, chord) <= deficit * (1.0 + 1e-12)
        along = distance * dot(direction, axis)
        reach = along - np.sqrt(np.maximum(lamp.radius**2 - distance**2 + along**2, 0.0))
        density = 1.0 / (2.0 * np.pi * deficit)
    else:
        facing, across = np.asarray(lamp.facing), lamp.half_sides
        offset = np.asarray(lamp.position) - points
        towards = -direction @ facing
        reach = distance_along(lamp, points, direction)
        place = (reach[:, None] * direction - offset) @ (across / (across**2).sum(axis=1, keepdims=True)).T
        beside = dot(place, place) if lamp.shape == "disc" else np.abs(place).max(axis=1)
        inside = (towards > 0.0) & (reach > 0.0) & (beside <= 1.0 + 1e-12)
        density = _SeenRectangle(lamp, points).density(np.where(inside, reach, 1.0), np.where(inside, towards, 1.0))
    light = inside[:, None] * np.asarray(lamp.radiance)
    return light, np.where(inside, density, 0.0), np.where(inside, np.maximum(reach, 0.0), np.inf)


def distance_along(lamp: NearLamp, points: Floats, direction: Floats) -> Floats:
    """Distances (N,) from `points` (N, 3) along unit `direction` (N, 3) of a sphere, or of the plane of another lamp.

    Beside a sphere it is that of the nearest place to its centre, and where a plane is not faced of no meaning.
    """
    offset = np.asarray(lamp.position) - points
    if lamp.shape == "sphere" or lamp.is_point:
        along = dot(offset, direction)
        return np.asarray(along - np.sqrt(np.maximum(lamp.radius**2 - dot(offset, offset) + along**2, 0.0)))
    facing = np.asarray(lamp.facing)
    towards = -direction @ facing
    return np.asarray(-(offset @ facing) / np.where(towards > 0.0, towards, 1.0))


def _towards_point(lamp: NearLamp, points: Floats) -> tuple[Floats, Floats, Floats]:
    offset = np.asarray(lamp.position) - points
    squared = dot(offset, offset)
    direction = normalize(offset)
    share = np.where(squared > 0.0, 1.0 / np.where(squared > 0.0, squared, 1.0), 0.0)
    if lamp.shape != "sphere":
        share = share * np.maximum(-direction @ np.asarray(lamp.facing), 0.0)
    return direction, np.sqrt(squared), share[:, None] * np.asarray(lamp.intensity)


def _cone(lamp: NearLamp, points: Floats) -> tuple[Floats, Floats, Floats]:
    """The axes (N, 3) and 1 − cosine (N,) of the cones in which a sphere is seen, and the distances (N,) of its centre.

    Points within the sphere see it as from its surface.
    """
    offset = np.asarray(lamp.position) - points
    distance = np.maximum(np.sqrt(dot(offset, offset)), lamp.radius)
    sine2 = (lamp.radius / distance) ** 2
    return normalize(offset, (0.0, 1.0, 0.0)), distance, sine2 / (1.0 + np.sqrt(np.maximum(1.0 - sine2, 0.0)))


class _SeenRectangle:
    """A rectangle, or the square about a disc, as points (N, 3) before it see it."""

    def __init__(self, lamp: NearLamp, points: Floats) -> None:
        half = lamp.half_sides
        lengths = np.sqrt((half**2).sum(axis=1))
        self._axes = np.vstack([half / lengths[:, None], lamp.facing])
        middle = (np.asarray(lamp.position) - points) @ self._axes.T
        self._x0, self._x1 = middle[:, 0] - lengths[0], middle[:, 0] + lengths[0]
        self._y0, self._y1 = middle[:, 1] - lengths[1], middle[:, 1] + lengths[1]
        self._z = np.minimum(middle[:, 2], 0.0)  # of points behind it nothing is asked
        self._radius = lamp.radius if lamp.shape == "disc" else None
        self._area = lamp.area
        edges = np.stack([-self._y0, self._x1, self._y1, -self._x0])
        with np.errstate(invalid="ignore", divide="ignore"):
            sines = np.nan_to_num(edges / np.hypot(edges, self._z))
        self._first, self._third = sines[0], sines[2]
        angles = [np.arccos(np.clip(-sines[k] * sines[(k + 1) % 4], -1.0, 1.0)) for k in range(4)]
        self._from = 2.0 * np.pi - angles[2] - angles[3]
        self._solid_angle = angles[0] + angles[1] - self._from
        self._is_small = self._solid_angle < (SMALL if self._radius is None else SMALL_DISC)

    def draw(self, u: Floats) -> Floats:
        """Vectors (N, 3) from the points to points of the rectangle."""
        z, turn = self._z, u[:, 0] * self._solid_angle + self._from
        with np.errstate(invalid="ignore", divide="ignore"):
            slope = (np.cos(turn) * self._first - self._third) / np.sin(turn)
            cosine = np.copysign(1.0, slope) / np.hypot(slope, self._first)
            cosine = np.clip(np.nan_to_num(cosine), -1.0 + 1e-15, 1.0 - 1e-15)
            x = np.clip(-cosine * z / np.sqrt(1.0 - cosine**2), self._x0, self._x1)
            far = np.hypot(x, z)
            low, high = (np.nan_to_num(y / np.hypot(far, y)) for y in (self._y0, self._y1))
            rise = low + u[:, 1] * (high - low)
            y = np.where(rise**2 < 1.0 - 1e-15, rise * far / np.sqrt(np.maximum(1.0 - rise**2, 1e-300)), self._y1)
        if self._radius is None:
            across, up = u[:, 0], u[:, 1]
        else:
            ring, angle = 0.5 * np.sqrt(u[:, 0]), 2.0 * np.pi * u[:, 1]
            across, up = 0.5 + ring * np.cos(angle), 0.5 + ring * np.sin(angle)
        x = np.where(self._is_small, self._x0 + across * (self._x1 - self._x0), x)
        y = np.where(self._is_small, self._y0 + up * (self._y1 - self._y0), np.clip(y, self._y0, self._y1))
        return np.column_stack([x, y, z]) @ self._axes

    def density(self, reach: Floats, cosine: Floats) -> Floats:
        """In 1/sr, (N,), of directions that meet it after `reach` with this `cosine` to its normal."""
        small = self._is_small
        return np.where(small, reach**2 / (self._area * cosine), 1.0 / np.where(small, 1.0, self._solid_angle))

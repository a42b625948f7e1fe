"""The sample on the table of the virtual light arc: lit by a lamp, and seen through the lens.

The sample is lit on a grid `FINE` times as fine as the photographs, blurred by the lens and moved by a known fraction
of a pixel in one Fourier transform. What hides the light is found once for all photographs where the lamp is distant.
The sample repeats beyond the image. The light of a near lamp does not, so that within some two pixels of the border
the lens blurs opposite sides together.
Cost: 0.4 s of CPU time for a light on 1024 x 1024 texels, half of it in the lens, after some 2 s for the sample.

A mirror sphere beside the sample, from whose highlight the direction of the lamp can be read.

The orthographic camera sees the point (x, y) of a sphere of radius one under the normal n = (x, y, sqrt(1 - x^2 - y^2))
and in it what lies towards 2 n_z n - v, v = (0, 0, 1): the sample below the horizon, a dim room above, and the lamp
where n halves the angle between lamp and camera. Polishing leaves the lamp a glow of `GLOW`, far above the white level.
The sphere throws no shadow and lights nothing.
Cost: the square around the sphere, some milliseconds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from engine.capture.lights.mirror_sphere import Circle
from engine.core.steps import Step, Steps, part
from engine.simulate import height_fields, shading
from engine.simulate.arc import LightArc, Shot, sphere
from engine.simulate.camera import blur, rotate
from engine.surface import horizon

#: Deviation of the normals under which the lamp is seen, radians.
GLOW = math.radians(2.0)

_REFLECTANCE, _ROOM, _LAMP = 0.7, 0.02, 6.0


def with_ball(image: NDArray[np.float32], ball: Circle, lamp: NDArray[np.float64]) -> NDArray[np.float32]:
    """A copy of `image` (H, W, 3; 1 = white level) with a sphere that lies inside it.

    `ball` is in texels of the image, `lamp` the unit vector from the sphere to the lamp.
    """
    top, left = (max(0, math.floor(middle - ball.radius) - 1) for middle in (ball.row, ball.column))
    bottom, right = (
        min(size, math.ceil(middle + ball.radius) + 1)
        for size, middle in zip(image.shape, (ball.row, ball.column), strict=False)
    )
    row, column = np.mgrid[top:bottom, left:right] + 0.5
    x, y = (column - ball.column) / ball.radius, (ball.row - row) / ball.radius
    outside = np.hypot(x, y)
    z = np.sqrt(np.clip(1 - outside * outside, 0, 1))
    half = lamp + np.array([0.0, 0.0, 1.0])
    cosine = (x * half[0] + y * half[1] + z * half[2]) / np.linalg.norm(half)
    off_squared = 2 - 2 * np.clip(cosine, -1, 1)
    surroundings = np.where((2 * z * z < 1)[..., None], image.mean(axis=(0, 1)), _ROOM)
    seen = _REFLECTANCE * surroundings + (_LAMP * np.exp(-off_squared / (2 * GLOW * GLOW)))[..., None]
    cover = np.clip((1 - outside) * ball.radius + 0.5, 0, 1)[..., None]
    result = image.copy()
    square = result[top:bottom, left:right]
    square += (cover * (seen - square)).astype(np.float32)
    return result


FINE = 2
LAMP_RADIUS = math.radians(1.0)
LENS_BLUR_PX = 0.45

_BAND_TEXELS = 1 << 16


@dataclass(frozen=True, eq=False)
class Table:
    """Data shared by all photographs.

    Attributes
    ----------
    slope : (H, W, 2) of the surface. open_part : (H, W), None without interreflection.
    horizons : (H, W) towards each azimuth; empty for a near lamp.
    """

    arc: LightArc
    sample: height_fields.Sample
    slope: NDArray[np.float32]
    open_part: NDArray[np.float32] | None
    horizons: dict[float, NDArray[np.float32]] = field(default_factory=dict)

    @property
    def lamp_texels(self) -> float:
        """Distance of the lamp in texels."""
        distance = self.arc.lamp_distance
        return math.inf if distance is None else distance * len(self.slope)


def prepare(arc: LightArc) -> Steps[Table]:
    sample = yield from part(height_fields.making(arc.sample, arc.size * FINE, arc.seed), 0.0, 0.4)
    open_part = None
    if arc.interreflection:
        open_part = yield from part(horizon.openness(sample.height), 0.4, 0.8)
    lowest = max(min(arc.elevation) - LAMP_RADIUS, math.radians(0.5))
    horizons = {}
    for index, azimuth in enumerate(arc.azimuth if arc.lamp_distance is None else ()):
        yield Step(0.8 + 0.2 * index / len(arc.azimuth), "Finding what casts shadows")
        horizons[azimuth] = horizon.horizon_slope(sample.height, azimuth, lowest)
    return Table(arc, sample, shading.surface_slope(sample.height), open_part, horizons)


def light_up(table: Table, elevation: float, azimuth: float) -> Steps[NDArray[np.float32]]:
    """(H, W, 3) radiance of the texels, where the lamp's irradiance in the middle is one on what faces it."""
    light = shading.light_direction(elevation, azimuth)
    visible = yield from part(_visible(table, elevation, azimuth), 0.0, 0.5)
    yield Step(0.5, "Lighting the sample")
    image = shading.radiance(table.sample, table.slope, visible, light, 1 / table.lamp_texels)
    if table.open_part is not None:
        yield Step(0.8, "Following the light that bounces")
        image = shading.add_interreflection(image, table.sample.albedo, table.open_part, len(image) / 100)
    return image


def photograph(table: Table, image: NDArray[np.float32], shot: Shot) -> NDArray[np.float32]:
    """(H / FINE, W / FINE, 3) what reaches the lens of the texels' radiance `image` (1 = white level)."""
    if table.arc.sphere:
        image = with_ball(image, _in_texels(table.arc), light_at_sphere(table, shot.elevation, shot.azimuth))
    if shot.turn:
        still = blur(image, LENS_BLUR_PX * FINE)
        return rotate(still, shot.turn, FINE * shot.right_px, FINE * shot.down_px, FINE)
    to_pixel_centre = 0.5 * (FINE - 1)
    right, down = (shift * FINE - to_pixel_centre for shift in (shot.right_px, shot.down_px))
    return np.ascontiguousarray(blur(image, LENS_BLUR_PX * FINE, right, down)[::FINE, ::FINE])


def light_at_sphere(table: Table, elevation: float, azimuth: float) -> NDArray[np.float64]:
    """(3,) unit vector from the middle of the mirror sphere to the lamp."""
    ball, half = _in_texels(table.arc), len(table.slope) / 2
    place = np.array([ball.column - half, half - ball.row, ball.radius])
    towards = shading.light_direction(elevation, azimuth) - place / table.lamp_texels
    return np.asarray(towards / np.linalg.norm(towards))


def height_px(table: Table) -> NDArray[np.float32]:
    """(H / FINE, W / FINE) height in pixels of the photographs."""
    return _average_pixels(table.sample.height) / np.float32(FINE)


def reference_maps(table: Table) -> dict[str, NDArray[np.float32]]:
    """Maps of the surface, (H / FINE, W / FINE), each the mean over a pixel's texels, as a capture should find them.

    `normal` (…, 3) are unit vectors x to the right of the image, y up, z towards the camera; `albedo` (…, 3) is
    diffuse reflectance and `specular` (…, 3) reflectance at normal incidence; `roughness` is the root of GGX alpha.
    """
    slope = table.slope
    fine = np.dstack([-slope, np.ones(slope.shape[:2], np.float32)])
    normal = _average_pixels(fine / np.linalg.norm(fine, axis=-1, keepdims=True))
    return {
        "normal": (normal / np.linalg.norm(normal, axis=-1, keepdims=True)).astype(np.float32),
        "albedo": _average_pixels(table.sample.albedo),
        "specular": _average_pixels(table.sample.specular),
        "roughness": np.sqrt(_average_pixels(table.sample.roughness)),
    }


def _average_pixels(fine: NDArray[np.float32]) -> NDArray[np.float32]:
    """Means over the texels of each pixel."""
    size = len(fine) // FINE
    mean: NDArray[np.float32] = fine.reshape(size, FINE, size, FINE, *fine.shape[2:]).mean(axis=(1, 3))
    return mean


def _in_texels(arc: LightArc) -> Circle:
    ball = sphere(arc)
    return Circle(FINE * ball.column, FINE * ball.row, FINE * ball.radius)


def _visible(table: Table, elevation: float, azimuth: float) -> Steps[NDArray[np.float32]]:
    """(H, W) share of the lamp that relief leaves visible."""
    if table.arc.lamp_distance is None:
        yield Step(0.0, "Casting shadows")
        return horizon.visibility(table.horizons[azimuth], elevation, LAMP_RADIUS)
    lamp = table.lamp_texels * shading.light_direction(elevation, azimuth)
    relief = table.sample.height - table.sample.height.mean(dtype=np.float64).astype(np.float32)
    rows = max(1, _BAND_TEXELS // len(relief))
    bands = []
    for first in range(0, len(relief), rows):
        yield Step(first / len(relief), "Casting shadows")
        band = slice(first, first + rows)
        bands.append(horizon.near_visibility(relief, lamp, LAMP_RADIUS, band))
    return np.concatenate(bands)

"""The sample on the table of the virtual light arc: lit by a lamp, and seen through the lens.

The sample is lit on a grid `FINE` times as fine as the photographs, blurred by the lens and moved by a known fraction
of a pixel in one Fourier transform. What hides the light is found once for all photographs where the lamp is distant.
The sample repeats beyond the picture. The light of a near lamp does not, so that within some two pixels of the border
the lens blurs opposite sides together.
Cost: 0.4 s of processor time for a light on 1024 x 1024 texels, half of it in the lens, after some 2 s for the sample.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from engine.capture.mirror_sphere import Circle
from engine.render import height_fields, light_arc, shadows
from engine.render.arc import LightArc, Shot, sphere
from engine.render.chrome_ball import with_ball
from engine.render.lens import blurred, turned
from engine.steps import Step, Steps, part

FINE = 2
LAMP_RADIUS = math.radians(1.0)
LENS_BLUR_PX = 0.45

_BAND_TEXELS = 1 << 16


@dataclass(frozen=True, eq=False)
class Table:
    """What is the same for all photographs.

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


def prepared(arc: LightArc) -> Steps[Table]:
    sample = yield from part(height_fields.making(arc.sample, arc.size * FINE, arc.seed), 0.0, 0.4)
    open_part = None
    if arc.interreflection:
        open_part = yield from part(shadows.openness(sample.height), 0.4, 0.8)
    lowest = max(min(arc.elevation) - LAMP_RADIUS, math.radians(0.5))
    horizons = {}
    for index, azimuth in enumerate(arc.azimuth if arc.lamp_distance is None else ()):
        yield Step(0.8 + 0.2 * index / len(arc.azimuth), "Finding what casts shadows")
        horizons[azimuth] = shadows.horizon_slope(sample.height, azimuth, lowest)
    return Table(arc, sample, light_arc.surface_slope(sample.height), open_part, horizons)


def lit(table: Table, elevation: float, azimuth: float) -> Steps[NDArray[np.float32]]:
    """(H, W, 3) radiance of the texels, where the lamp's irradiance in the middle is one on what faces it."""
    light = light_arc.light_direction(elevation, azimuth)
    visible = yield from part(_visible(table, elevation, azimuth), 0.0, 0.5)
    yield Step(0.5, "Lighting the sample")
    image = light_arc.radiance(table.sample, table.slope, visible, light, 1 / table.lamp_texels)
    if table.open_part is not None:
        yield Step(0.8, "Following the light that bounces")
        image = light_arc.interreflected(image, table.sample.albedo, table.open_part, len(image) / 100)
    return image


def photographed(table: Table, image: NDArray[np.float32], shot: Shot) -> NDArray[np.float32]:
    """(H / FINE, W / FINE, 3) what reaches the lens of the texels' radiance `image` (1 = white level)."""
    if table.arc.sphere:
        image = with_ball(image, _in_texels(table.arc), light_at_sphere(table, shot.elevation, shot.azimuth))
    if shot.turn:
        still = blurred(image, LENS_BLUR_PX * FINE)
        return turned(still, shot.turn, FINE * shot.right_px, FINE * shot.down_px, FINE)
    to_pixel_centre = 0.5 * (FINE - 1)
    right, down = (shift * FINE - to_pixel_centre for shift in (shot.right_px, shot.down_px))
    return np.ascontiguousarray(blurred(image, LENS_BLUR_PX * FINE, right, down)[::FINE, ::FINE])


def light_at_sphere(table: Table, elevation: float, azimuth: float) -> NDArray[np.float64]:
    """(3,) unit vector from the middle of the mirror sphere to the lamp."""
    ball, half = _in_texels(table.arc), len(table.slope) / 2
    place = np.array([ball.column - half, half - ball.row, ball.radius])
    towards = light_arc.light_direction(elevation, azimuth) - place / table.lamp_texels
    return np.asarray(towards / np.linalg.norm(towards))


def height_px(table: Table) -> NDArray[np.float32]:
    """(H / FINE, W / FINE) height in pixels of the photographs."""
    size = len(table.slope) // FINE
    mean: NDArray[np.float32] = table.sample.height.reshape(size, FINE, size, FINE).mean(axis=(1, 3))
    return mean / np.float32(FINE)


def _in_texels(arc: LightArc) -> Circle:
    ball = sphere(arc)
    return Circle(FINE * ball.column, FINE * ball.row, FINE * ball.radius)


def _visible(table: Table, elevation: float, azimuth: float) -> Steps[NDArray[np.float32]]:
    """(H, W) share of the lamp that relief leaves visible."""
    if table.arc.lamp_distance is None:
        yield Step(0.0, "Casting shadows")
        return shadows.visibility(table.horizons[azimuth], elevation, LAMP_RADIUS)
    lamp = table.lamp_texels * light_arc.light_direction(elevation, azimuth)
    relief = table.sample.height - table.sample.height.mean(dtype=np.float64).astype(np.float32)
    rows = max(1, _BAND_TEXELS // len(relief))
    bands = []
    for first in range(0, len(relief), rows):
        yield Step(first / len(relief), "Casting shadows")
        band = slice(first, first + rows)
        bands.append(shadows.near_visibility(relief, lamp, LAMP_RADIUS, band))
    return np.concatenate(bands)

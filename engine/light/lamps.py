"""Lamps: distant light from one direction, or from a round patch of the sky of even radiance.

A lamp of angular radius a and radiance L brings the irradiance E = L pi sin^2 a to a surface that faces it; E stays
what it is while a falls to 0, where the lamp is a directional light. Lamps stay where they are in the world, whatever
way an environment map beside them is turned.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from engine.core import params
from engine.core.directions import normalize, world_angles, world_direction, world_from_tangent
from engine.core.errors import UsageError
from engine.core.params import Colour, param
from engine.light.environment import NO_LIGHTS, DistantLights

#: Directions that stand for a disc lie about so far apart: 1.5 degrees, half the width of narrow highlights.
SPACING = math.radians(1.5)

#: Most directions that stand for one lamp, and for all lamps of a scene.
MAX_OF_A_LAMP, MAX_OF_ALL = 256, 1024

#: A turn between neighbours that never lines points up (Vogel, *A better way to construct the sunflower head*, 1979).
GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))

#: A triple of floats: a direction or a colour.
Triple = tuple[float, float, float]


#: Lengths that differ from 1 by no more are those of unit vectors.
ROUNDING = 2.0 * float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class Lamp:
    """One distant lamp.

    Attributes
    ----------
    direction : world direction towards its centre; made a unit vector.
    irradiance : linear RGB on a surface that faces it, finite and not negative.
    radius : angular radius in radians, 0 … pi/2; 0 is a directional light.
    """

    direction: Triple
    irradiance: Triple
    radius: float = 0.0

    def __post_init__(self) -> None:
        direction = np.asarray(self.direction, np.float64)
        if direction.shape != (3,) or not np.isfinite(direction).all() or not direction.any():
            raise UsageError(f"the direction of a lamp needs three finite numbers, not all 0, got {self.direction!r}")
        irradiance = np.asarray(self.irradiance, np.float64)
        if irradiance.shape != (3,) or not (np.isfinite(irradiance) & (irradiance >= 0.0)).all():
            raise UsageError(f"the irradiance of a lamp needs three numbers from 0, got {self.irradiance!r}")
        if not 0.0 <= self.radius <= math.pi / 2:
            raise UsageError(f"a lamp of radius {math.degrees(self.radius):g}° is not between 0 and 90°")
        is_unit = abs(math.hypot(*direction) - 1.0) <= ROUNDING  # read from a record, it shall be what was written
        unit = direction if is_unit else normalize(direction / np.abs(direction).max())
        object.__setattr__(self, "direction", tuple(float(x) for x in unit))
        object.__setattr__(self, "irradiance", tuple(float(x) for x in irradiance))

    @property
    def solid_angle(self) -> float:
        """In sr; 0 of a directional light."""
        return 4.0 * math.pi * math.sin(self.radius / 2.0) ** 2

    @property
    def radiance(self) -> Triple:
        """Linear RGB of the disc; ValueError for a directional light, which has none."""
        if self.radius == 0.0:
            raise ValueError("a directional light has an irradiance and no radiance")
        red, green, blue = self.irradiance
        share = 1.0 / (math.pi * math.sin(self.radius) ** 2)
        return red * share, green * share, blue * share

    @property
    def flux(self) -> Triple:
        """Linear RGB radiance integrated over the disc without a cosine: what it adds to the sum over a map."""
        red, green, blue = self.irradiance
        share = 1.0 / math.cos(self.radius / 2.0) ** 2  # solid angle over pi sin^2 a
        return red * share, green * share, blue * share

    def rotate(self, angle: float) -> Lamp:
        """The same lamp rotated about +Y by `angle` in radians, as `DistantLights.rotated`."""
        lights = DistantLights(np.array([self.direction]), np.array([self.irradiance])).rotate(angle)
        x, y, z = lights.direction[0]
        return Lamp((x, y, z), self.irradiance, self.radius)


@dataclass(frozen=True)
class LampSettings:
    """A lamp as users give it, on the command line and in the window; `.lamp` is its value."""

    theta_deg: float = param(50.0, 0.0, 180.0, unit="°", doc="Angle of the light from straight up.")
    phi_deg: float = param(
        30.0, -360.0, 360.0, unit="°", slider=(-180.0, 180.0), doc="Turn from the viewer's side towards the right."
    )
    irradiance: float = param(1.0, 0.0, 1e9, slider=(0.01, 100.0), log=True, doc="On a surface that faces the light.")
    radius_deg: float = param(0.0, 0.0, 90.0, unit="°", slider=(0.0, 30.0), doc="Angular radius; 0 is one direction.")
    colour: Colour = param((1.0, 1.0, 1.0), 0.0, 1e3, slider=(0.0, 1.0), doc="Linear RGB, times the irradiance.")

    def __post_init__(self) -> None:
        params.check(self)

    @property
    def lamp(self) -> Lamp:
        x, y, z = world_direction(math.radians(self.theta_deg), math.radians(self.phi_deg))
        red, green, blue = (channel * self.irradiance for channel in self.colour)
        return Lamp((x, y, z), (red, green, blue), math.radians(self.radius_deg))

    @classmethod
    def of(cls, lamp: Lamp) -> LampSettings:
        """The settings of `lamp`, with the largest channel of its colour at 1."""
        theta, phi = world_angles(lamp.direction)
        largest = max(lamp.irradiance)
        red, green, blue = (channel / largest for channel in lamp.irradiance) if largest else (1.0, 1.0, 1.0)
        return cls(
            theta_deg=math.degrees(theta),
            phi_deg=math.degrees(phi),
            irradiance=min(largest, 1e9),
            radius_deg=math.degrees(lamp.radius),
            colour=(red, green, blue),
        )


def lamp_from_text(text: str) -> Lamp:
    """`theta_deg=40,phi_deg=20,irradiance=2,radius_deg=5,colour=1:0.8:0.6` as a lamp; what is left out is the default.

    Raises UsageError, naming what can be given, for an unknown name, a bad number or a value out of range.
    """
    return params.parse(LampSettings, text.replace(":", "/")).lamp


def lights_of(lamp: Lamp, count: int) -> DistantLights:
    """`count` directional lights in place of the lamp, evenly spread over its disc by solid angle, all alike.

    They bring the whole irradiance to a surface that faces the lamp, to rounding: cosines of their angles from its
    centre are at the middles of equal steps. Raises ValueError for a count below 1.
    """
    if count < 1:
        raise ValueError(f"{count} directions are too few for a lamp")
    if lamp.radius == 0.0 or count == 1:
        return DistantLights(np.array([lamp.direction]), np.array([lamp.irradiance]))
    step = np.arange(count)
    half_sine = math.sin(lamp.radius / 2.0) * np.sqrt((step + 0.5) / count)  # sin(theta / 2)
    sine = 2.0 * half_sine * np.sqrt(1.0 - half_sine**2)
    azimuth = GOLDEN_ANGLE * step
    around = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), 1.0 - 2.0 * half_sine**2], axis=-1)
    direction = around @ world_from_tangent(lamp.direction).T
    irradiance = np.broadcast_to(np.array(lamp.flux) / count, (count, 3)).copy()
    return DistantLights(direction, irradiance)


def directions_for(lamps: Sequence[Lamp]) -> list[int]:
    """Number of directions for each of `lamps`: about `SPACING` apart, at most `MAX_OF_ALL` together."""
    wanted = [min(MAX_OF_A_LAMP, max(1, math.ceil(lamp.solid_angle / SPACING**2))) for lamp in lamps]
    share = min(1.0, MAX_OF_ALL / max(1, sum(wanted)))
    return [max(1, int(count * share)) for count in wanted]


def lights_of_all(lamps: Sequence[Lamp]) -> DistantLights:
    """The directional lights in place of all `lamps`, in their order."""
    spread = [lights_of(lamp, count) for lamp, count in zip(lamps, directions_for(lamps), strict=True)]
    return DistantLights(
        np.concatenate([NO_LIGHTS.direction, *(lights.direction for lights in spread)]),
        np.concatenate([NO_LIGHTS.irradiance, *(lights.irradiance for lights in spread)]),
    )


def lights_from_all_sides(lights: DistantLights, share: float, more: Triple = (0.0, 0.0, 0.0)) -> DistantLights:
    """Twelve alike, from the corners of an icosahedron, of together `share` of the irradiance of `lights` and `more`.

    Where that is 0, a share of 1 of each channel stands for it.
    """
    total = lights.irradiance.sum(axis=0) + more
    each = share / 12.0 * (total if total.any() else np.ones(3))
    long = (1.0 + math.sqrt(5.0)) / 2.0
    corners = [(0.0, a, b * long) for a in (-1.0, 1.0) for b in (-1.0, 1.0)]
    direction = np.array([np.roll(corner, turn) for turn in range(3) for corner in corners]) / math.hypot(1.0, long)
    return DistantLights(direction, np.broadcast_to(each, (12, 3)).copy())

"""Lamps near a model: spheres of even radiance, at a place in its coordinates.

From the distance d a lamp is a disc of angular radius asin(radius / d) that brings the irradiance

    E = power / (4 π d²)          to a surface that faces it,

so each point of the model sees it elsewhere, and as bright as it is near (`engine.transport.sh.near_light`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from engine.core import params
from engine.core.errors import UsageError
from engine.core.params import Colour, param
from engine.light.lamps import Triple


@dataclass(frozen=True)
class NearLamp:
    """A sphere that shines evenly.

    Attributes
    ----------
    position : of its centre, in the coordinates of the model.
    power : linear RGB radiant power, finite and not negative; the unit of irradiance times the model's length squared.
    radius : of the sphere, finite, from 0, which is a point.
    """

    position: Triple
    power: Triple
    radius: float = 0.0

    def __post_init__(self) -> None:
        if not (len(self.position) == 3 and all(map(math.isfinite, self.position))):
            raise UsageError(f"the position of a lamp needs three finite numbers, got {self.position!r}")
        if not (len(self.power) == 3 and all(math.isfinite(x) and x >= 0.0 for x in self.power)):
            raise UsageError(f"the power of a lamp needs three numbers from 0, got {self.power!r}")
        if not (math.isfinite(self.radius) and self.radius >= 0.0):
            raise UsageError(f"a lamp of radius {self.radius:g} is not possible")


@dataclass(frozen=True)
class NearLampSettings:
    """A near lamp as users give it, on the command line and in the window; `.lamp` is its value."""

    x: float = param(0.0, -1e9, 1e9, doc="Where it is, in the model's own coordinates.")
    y: float = param(0.0, -1e9, 1e9, doc="Upwards.")
    z: float = param(0.0, -1e9, 1e9, doc="Towards the viewer.")
    radius: float = param(0.0, 0.0, 1e9, doc="Of the sphere that shines; 0 is a point.")
    power: float = param(1.0, 0.0, 1e18, log=True, doc="Irradiance at distance d is power / (4 π d²).")
    colour: Colour = param((1.0, 1.0, 1.0), 0.0, 1e3, doc="Linear RGB, times the power.")

    def __post_init__(self) -> None:
        params.check(self)

    @property
    def lamp(self) -> NearLamp:
        red, green, blue = (channel * self.power for channel in self.colour)
        return NearLamp((self.x, self.y, self.z), (red, green, blue), self.radius)


def near_lamp_from_text(text: str) -> NearLamp:
    """`x=1,y=2,z=0.5,radius=0.1,power=40,colour=1:0.8:0.6` as a near lamp; what is left out is the default.

    Raises UsageError, naming what can be given, for an unknown name, a bad number or a value out of range.
    """
    return params.parse(NearLampSettings, text.replace(":", "/")).lamp

"""Lights near a model: spheres, rectangles and discs of even radiance, at a position in its coordinates.

Light leaves a sphere towards all sides, and a rectangle or a disc from the side that it faces. At the distance d

    E = power / (4 π d²)    of a sphere, at any distance,
    E = power / (π d²)      of a rectangle or disc, straight ahead and far away,

on a surface that faces the light, since `power` is the radiant power and the radiance is even: power / (4 π² radius²)
of a sphere, power / (π area) of the others. Spheres whose radius is 0 are points; discs whose radius is 0 are points
that shine with the cosine of the angle to the direction they face.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core import params
from engine.core.directions import dot, normalize, world_direction, world_from_tangent
from engine.core.errors import UsageError
from engine.core.params import Colour, choice, param
from engine.light.lamps import Triple

Floats = NDArray[np.float64]

Shape = Literal["sphere", "rectangle", "disc"]

#: Shapes as users read them.
SHAPES: tuple[tuple[Shape, str], ...] = (("sphere", "Sphere"), ("rectangle", "Rectangle"), ("disc", "Disc"))

#: Parameters of each shape; the others have no effect.
FACING = ("facing_theta_deg", "facing_phi_deg")
PARAMETERS: dict[str, tuple[str, ...]] = {
    "sphere": ("radius",),
    "rectangle": (*FACING, "rotation_deg", "width", "height"),
    "disc": (*FACING, "radius"),
}

#: The part of a turn between neighbours of a lattice and of a sunflower that fill their areas evenly.
GOLDEN = 0.6180339887498949

#: Least width and height of a rectangle.
MIN_SIDE = 1e-6


@dataclass(frozen=True)
class NearLamp:
    """A sphere, a rectangle or a disc that shines evenly.

    Attributes
    ----------
    position : of its centre, in the coordinates of the model.
    power : linear RGB radiant power, finite and not negative; the unit of irradiance times the model's length squared.
    radius : of a sphere or a disc, finite, from 0, which is a point.
    shape : what shines.
    facing : direction in which a rectangle or a disc shines; made a unit vector.
    sides : width and height of a rectangle, finite, at least `MIN_SIDE`.
    across : direction of the width, perpendicular to `facing`; made a unit vector.
    """

    position: Triple
    power: Triple
    radius: float = 0.0
    shape: Shape = "sphere"
    facing: Triple = (0.0, -1.0, 0.0)
    sides: tuple[float, float] = (1.0, 1.0)
    across: Triple | None = None

    def __post_init__(self) -> None:
        if not (len(self.position) == 3 and all(map(math.isfinite, self.position))):
            raise UsageError(f"the position of a lamp needs three finite numbers, got {self.position!r}")
        if not (len(self.power) == 3 and all(math.isfinite(x) and x >= 0.0 for x in self.power)):
            raise UsageError(f"the power of a lamp needs three numbers from 0, got {self.power!r}")
        if not (math.isfinite(self.radius) and self.radius >= 0.0):
            raise UsageError(f"a lamp of radius {self.radius:g} is not possible")
        if self.shape not in get_args(Shape):
            raise UsageError(f"unknown shape {self.shape!r}; choose from {', '.join(get_args(Shape))}")
        if not (len(self.sides) == 2 and all(math.isfinite(x) and x >= MIN_SIDE for x in self.sides)):
            raise UsageError(f"a rectangle of {self.sides!r} is not possible; its sides are at least {MIN_SIDE:g}")
        if not (len(self.facing) == 3 and all(map(math.isfinite, self.facing)) and any(self.facing)):
            raise UsageError(f"the direction of a lamp needs three finite numbers, not all 0, got {self.facing!r}")
        facing = normalize(np.asarray(self.facing, np.float64) / np.abs(self.facing).max())
        across = _level(facing) if self.across is None else np.asarray(self.across, np.float64)
        if across.shape != (3,) or not np.isfinite(across).all():
            raise UsageError(f"the width of a lamp needs a direction of three finite numbers, got {self.across!r}")
        inside = across - float(across @ facing) * facing
        across = normalize(inside, _level(facing)) if float(np.abs(inside).max()) > 1e-9 else _level(facing)
        object.__setattr__(self, "facing", tuple(float(x) for x in facing))
        object.__setattr__(self, "across", tuple(float(x) for x in across))

    @property
    def is_point(self) -> bool:
        """True where the lamp has no extent."""
        return self.shape != "rectangle" and self.radius == 0.0

    @property
    def extent(self) -> float:
        """Largest distance of a point of the lamp from its centre."""
        return 0.5 * math.hypot(*self.sides) if self.shape == "rectangle" else self.radius

    @property
    def area(self) -> float:
        """The area that shines; 0 of a point."""
        if self.shape == "rectangle":
            return self.sides[0] * self.sides[1]
        return (4.0 if self.shape == "sphere" else 1.0) * math.pi * self.radius**2

    @property
    def intensity(self) -> Triple:
        """Linear RGB radiant intensity: towards all sides of a sphere, straight ahead of a rectangle or a disc."""
        share = 1.0 / (4.0 * math.pi if self.shape == "sphere" else math.pi)
        red, green, blue = self.power
        return red * share, green * share, blue * share

    @property
    def radiance(self) -> Triple:
        """Linear RGB of the surface; ValueError of a point, which has none."""
        if self.is_point:
            raise ValueError("a point has an intensity and no radiance")
        red, green, blue = self.power
        share = 1.0 / (math.pi * self.area)
        return red * share, green * share, blue * share

    @property
    def half_sides(self) -> Floats:
        """(2, 3) from the centre to the middle of two edges: of the rectangle, or of the square about the disc."""
        assert self.across is not None
        half = (0.5 * self.sides[0], 0.5 * self.sides[1]) if self.shape == "rectangle" else (self.radius,) * 2
        across, facing = np.asarray(self.across), np.asarray(self.facing)
        return np.array([half[0] * across, half[1] * np.cross(facing, across)])


def _level(facing: Floats) -> Floats:
    """The level direction across `facing`; that of `world_from_tangent` where it points straight up or down."""
    level = np.cross((0.0, 1.0, 0.0), facing)
    if float(np.hypot(level[0], level[2])) > 1e-6:
        return np.asarray(normalize(level))
    return np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True)
class NearLampSettings:
    """A near lamp as users give it, on the command line and in the window; `.lamp` is its value."""

    shape: Literal["sphere", "rectangle", "disc"] = choice(
        "sphere", get_args(Shape), doc="A sphere, or one side of a rectangle or a disc.", offered=SHAPES
    )
    x: float = param(0.0, -1e9, 1e9, doc="Where its centre is, in the model's own coordinates.")
    y: float = param(0.0, -1e9, 1e9, doc="Upwards.")
    z: float = param(0.0, -1e9, 1e9, doc="Towards the viewer.")
    radius: float = param(0.0, 0.0, 1e9, doc="Radius of the sphere or the disc; 0 is a point.")
    width: float = param(1.0, MIN_SIDE, 1e9, doc="Width of the rectangle.")
    height: float = param(1.0, MIN_SIDE, 1e9, doc="Height of the rectangle.")
    facing_theta_deg: float = param(180.0, 0.0, 180.0, unit="°", doc="Direction it faces: angle from straight up.")
    facing_phi_deg: float = param(
        0.0, -360.0, 360.0, unit="°", slider=(-180.0, 180.0), doc="Direction it faces: turn from +Z towards +X."
    )
    rotation_deg: float = param(
        0.0, -360.0, 360.0, unit="°", slider=(-90.0, 90.0), doc="Turn of the rectangle about the direction it faces."
    )
    power: float = param(
        1.0, 0.0, 1e18, log=True, doc="Irradiance at distance d: power / (4 π d²); rectangle and disc power / (π d²)."
    )
    colour: Colour = param((1.0, 1.0, 1.0), 0.0, 1e3, doc="Linear RGB, times the power.")

    def __post_init__(self) -> None:
        params.check(self)

    @property
    def lamp(self) -> NearLamp:
        red, green, blue = (channel * self.power for channel in self.colour)
        facing = world_direction(math.radians(self.facing_theta_deg), math.radians(self.facing_phi_deg))
        level, turn = _level(facing), math.radians(self.rotation_deg)
        across = math.cos(turn) * level + math.sin(turn) * np.cross(facing, level)
        return NearLamp(
            (self.x, self.y, self.z),
            (red, green, blue),
            self.radius,
            self.shape,
            _triple(np.round(facing, 15) + 0.0),
            (self.width, self.height),
            _triple(np.round(across, 15) + 0.0),
        )


def _triple(vector: Floats) -> Triple:
    x, y, z = (float(number) for number in vector)
    return x, y, z


def near_lamp_from_text(text: str) -> NearLamp:
    """`shape=rectangle,x=1,y=2,z=0.5,width=1,height=0.5,power=40,colour=1:0.8:0.6` as a near lamp.

    What is left out is the default. Raises UsageError, naming what can be given, for an unknown name, a bad number, a
    value out of range, or a parameter that the shape does not have.
    """
    settings = params.parse(NearLampSettings, text.replace(":", "/"))
    given = {piece.partition("=")[0].strip() for piece in text.split(",")}
    others = set().union(*PARAMETERS.values()) - set(PARAMETERS[settings.shape])
    if wrong := sorted(given & others):
        has = ", ".join(PARAMETERS[settings.shape])
        raise UsageError(f"a {settings.shape} has no {wrong[0]}; it has {has}")
    return settings.lamp


def sample_pattern(lamp: NearLamp, count: int) -> Floats:
    """(count, 2) points of a lamp that share its area alike: in the unit disc, or in [-1, 1]² of a rectangle."""
    step = np.arange(count) + 0.5
    turns = np.mod(np.arange(count) * GOLDEN, 1.0)
    if lamp.shape == "rectangle":
        return np.column_stack([2.0 * step / count - 1.0, 2.0 * np.mod(turns + 0.5, 1.0) - 1.0])
    radius, angle = np.sqrt(step / count), 2.0 * math.pi * turns
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


def near_irradiance(lamps: Sequence[NearLamp], place: ArrayLike, least: float) -> Triple:
    """About the irradiance (3,) of lamps at `place` (3,), none of which counts as nearer than `least`."""
    total = np.zeros(3)
    for lamp in lamps:
        offset = np.asarray(lamp.position) - place
        total += np.asarray(lamp.intensity) / max(float(offset @ offset), least * least, 1e-300)
    return _triple(total)


def distance_of(lamp: NearLamp, positions: Floats) -> Floats:
    """Distances (N,) of `positions` (N, 3) from the centre of a sphere, or from the surface of another lamp."""
    offset = np.asarray(positions, np.float64) - np.asarray(lamp.position)
    if lamp.shape == "sphere" or lamp.is_point:
        return np.asarray(np.sqrt(dot(offset, offset)))
    height = offset @ np.asarray(lamp.facing)
    axes = lamp.half_sides
    length = np.sqrt((axes**2).sum(axis=1))
    inside = offset @ (axes / length[:, None]).T
    if lamp.shape == "disc":
        beyond = np.maximum(np.hypot(inside[:, 0], inside[:, 1]) - lamp.radius, 0.0)
    else:
        beyond = np.hypot(*np.maximum(np.abs(inside) - length, 0.0).T)
    return np.asarray(np.hypot(height, beyond))


def near_lights(lamp: NearLamp, positions: Floats, count: int, least: float = 0.0) -> Iterator[tuple[Floats, Floats]]:
    """Directions (N, 3) from `positions` (N, 3) towards points of a lamp, and their irradiance (N, 3), one at a time.

    Points share the area of a rectangle or a disc alike, and the solid angle in which a sphere is seen. A lamp that
    has no extent is one point. From the centre of a point light nothing arrives. Within the distance `least` of a point
    of a rectangle or a disc, light is that of this distance.
    """
    centre, intensity = np.asarray(lamp.position), np.asarray(lamp.intensity)
    if lamp.shape == "sphere" and not lamp.is_point:
        yield from _sphere_lights(lamp, positions, count)
        return
    pattern = np.zeros((1, 2)) if lamp.is_point else sample_pattern(lamp, count)
    facing = np.asarray(lamp.facing)
    for place in centre + pattern @ lamp.half_sides:
        offset = place - positions
        squared = dot(offset, offset)
        direction = offset / np.sqrt(np.where(squared > 0.0, squared, 1.0))[:, None]
        nearer = np.maximum(squared, least * least)
        share = np.where(squared > 0.0, 1.0 / (len(pattern) * np.where(nearer > 0.0, nearer, 1.0)), 0.0)
        if lamp.shape != "sphere":
            share = share * np.maximum(-direction @ facing, 0.0)
        yield direction, share[:, None] * intensity


def _sphere_lights(lamp: NearLamp, positions: Floats, count: int) -> Iterator[tuple[Floats, Floats]]:
    offset = np.asarray(lamp.position) - positions
    distance = np.sqrt(dot(offset, offset))
    sine2 = np.minimum(lamp.radius / np.maximum(distance, lamp.radius), 1.0) ** 2
    deficit = sine2 / (1.0 + np.sqrt(1.0 - sine2))
    frame = world_from_tangent(normalize(offset, (0.0, 1.0, 0.0)))
    irradiance = (2.0 * math.pi / count * deficit)[:, None] * np.asarray(lamp.radiance)
    for x, y in sample_pattern(lamp, count):
        lower = (x * x + y * y) * deficit
        scale = np.sqrt(np.maximum(deficit * (2.0 - lower), 0.0))
        local = np.column_stack([x * scale, y * scale, 1.0 - lower])
        yield np.einsum("nij,nj->ni", frame, local), irradiance

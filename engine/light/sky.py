"""The environments that need no file: skies and studios under the names that users ask for.

Daylight by published formulas: clear skies with their sun, and the overcast sky.

Clear skies are those of Preetham, Shirley and Smits, *A practical analytic model for daylight*, SIGGRAPH 1999 (appendix
A: Perez's five-parameter form for luminance Y and chromaticity x, y; the sun through air and haze). They hold for
turbidities of 2 … 6 and, near sunset, roughly. The overcast sky is the first of the standard general skies of CIE
S 011:2003. Every map is as bright as makes a level white card 1, so that noon and sunset need no other exposure; sky
and sun keep their proportion. Directions are (..., 3) unit vectors of the world, +Y up; below the horizon lies even
ground that sky and sun light.

Studios: rooms with lamps of several shapes, as radiance (..., 3) by direction (..., 3) of the world, +Y up.

A lamp is a patch of a plane at distance 1 in front of which the object stands, with edges a little soft so that maps
of 128 rows show them without steps.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from engine.core.colour import luminance, srgb_from_xyz
from engine.core.directions import Vectors, dot, normalize, world_direction
from engine.light.environment import EnvironmentMap, texel_directions

#: Illuminance of the sun above the air in klx.
SUN_ABOVE_THE_AIR = 128.0

#: The sun's disc in maps, as an angular radius: three times the real one, so that it holds a few texels.
SUN_RADIUS = math.radians(0.8)

#: Reflectance of the ground: dry soil and grass.
GROUND = np.array([0.20, 0.17, 0.12])

#: Wavelengths in micrometres that stand for red, green and blue.
_WAVELENGTHS = np.array([0.61, 0.55, 0.465])

#: Perez's A … E of Y, x and y by turbidity T: slope and value at T = 0.
_PEREZ = np.array(
    [
        [[0.1787, -1.4630], [-0.3554, 0.4275], [-0.0227, 5.3251], [0.1206, -2.5771], [-0.0670, 0.3703]],
        [[-0.0193, -0.2592], [-0.0665, 0.0008], [-0.0004, 0.2125], [-0.0641, -0.8989], [-0.0033, 0.0452]],
        [[-0.0167, -0.2608], [-0.0950, 0.0092], [-0.0079, 0.2102], [-0.0441, -1.6537], [-0.0109, 0.0529]],
    ]
)

#: Chromaticity x and y of the zenith: (T^2, T, 1) times these times (s^3, s^2, s, 1), s the sun's angle from it.
_ZENITH = np.array(
    [
        [
            [0.00166, -0.00375, 0.00209, 0.0],
            [-0.02903, 0.06377, -0.03202, 0.00394],
            [0.11693, -0.21196, 0.06052, 0.25886],
        ],
        [
            [0.00275, -0.00610, 0.00317, 0.0],
            [-0.04214, 0.08970, -0.04153, 0.00516],
            [0.15346, -0.26756, 0.06670, 0.26688],
        ],
    ]
)

#: Radiance (..., 3) by direction (..., 3).
Radiance = Callable[[Vectors], Vectors]


def clear_sky(sun_elevation_deg: float, turbidity: float = 2.5, sun_phi_deg: float = 40.0) -> Radiance:
    """The clear sky with the sun at this elevation, on the right in front of the default camera's object."""
    towards = world_direction(math.radians(90.0 - sun_elevation_deg), math.radians(sun_phi_deg))
    sun = sun_irradiance(sun_elevation_deg, turbidity)
    return lambda direction: _above_ground(direction, lambda up: preetham(up, towards, turbidity), sun, towards)


def overcast(direction: Vectors) -> Vectors:
    """The standard overcast sky of CIE S 011, type 1: a = 4, b = -0.7, of even colour."""

    def sky(up: Vectors) -> Vectors:
        gradation = 1.0 + 4.0 * np.exp(-0.7 / np.maximum(up[..., 1:2], 0.01))
        return gradation * np.array([0.97, 1.0, 1.05])

    return _above_ground(direction, sky, np.zeros(3), np.array([0.0, 1.0, 0.0]))


def preetham(direction: Vectors, towards: Vectors, turbidity: float) -> Vectors:
    """The clear sky without the disc of the sun at `towards` (3,): (..., 3) in kcd/m^2 for `direction` (..., 3)."""
    from_zenith = math.acos(max(0.0, float(towards[1])))
    gamma = np.arccos(np.clip(dot(direction, towards), -1.0, 1.0))
    height = np.maximum(direction[..., 1], 0.01)  # the formula has a pole at the horizon
    zenith = _zenith(from_zenith, turbidity)
    values = []
    for (a, b, c, d, e), value in zip(_PEREZ @ (turbidity, 1.0), zenith, strict=True):
        here = (1.0 + a * np.exp(b / height)) * (1.0 + c * np.exp(d * gamma) + e * np.cos(gamma) ** 2)
        above = (1.0 + a * math.exp(b)) * (1.0 + c * math.exp(d * from_zenith) + e * math.cos(from_zenith) ** 2)
        values.append(value * here / above)
    bright, x, y = np.maximum(values, 1e-4)
    xyz = np.stack([x * bright / y, bright, (1.0 - x - y) * bright / y], axis=-1)
    return np.maximum(srgb_from_xyz(xyz), 0.0)


def _zenith(from_zenith: float, turbidity: float) -> tuple[float, float, float]:
    """Luminance in kcd/m^2 and chromaticity x, y of the zenith."""
    chi = (4.0 / 9.0 - turbidity / 120.0) * (math.pi - 2.0 * from_zenith)
    bright = (4.0453 * turbidity - 4.9710) * math.tan(chi) - 0.2155 * turbidity + 2.4192
    x, y = _ZENITH @ (from_zenith**3, from_zenith**2, from_zenith, 1.0) @ (turbidity**2, turbidity, 1.0)
    return bright, float(x), float(y)


def sun_irradiance(elevation_deg: float, turbidity: float) -> Vectors:
    """(3,) in klx: the sun on a surface that faces it, after Rayleigh's scattering and Ångström's haze."""
    from_zenith_deg = 90.0 - elevation_deg
    air_mass = 1.0 / (math.cos(math.radians(from_zenith_deg)) + 0.15 * (93.885 - from_zenith_deg) ** -1.253)
    air = np.exp(-0.008735 * _WAVELENGTHS**-4.08 * air_mass)
    haze = np.exp(-(0.04608 * turbidity - 0.04586) * _WAVELENGTHS**-1.3 * air_mass)
    return np.asarray(SUN_ABOVE_THE_AIR * air * haze)


def _disc(direction: Vectors, towards: Vectors) -> NDArray[np.float64]:
    """(..., 1) radiance of a sun of irradiance 1; its edge is as soft as the texels of a map of 256 rows."""
    angle = 2.0 * np.arcsin(np.clip(0.5 * np.linalg.norm(direction - towards, axis=-1), 0.0, 1.0))[..., None]
    soft = math.pi / 256
    share = np.clip((SUN_RADIUS - angle) / soft + 0.5, 0.0, 1.0)
    return share / (math.pi * (SUN_RADIUS**2 + soft**2 / 12.0))


def _above_ground(direction: Vectors, sky: Radiance, sun: Vectors, towards: Vectors) -> Vectors:
    """`sky` and the sun's disc above the horizon, below it the ground that they light; a level white card is 1."""
    level = _on_level(sky) + sun * max(0.0, float(towards[1]))
    seen = np.where(
        direction[..., 1:2] > 0.0, sky(direction) + _disc(direction, towards) * sun, GROUND * level / math.pi
    )
    return seen * (math.pi / float(luminance(level)))


def _on_level(sky: Radiance) -> Vectors:
    """(3,) what the whole `sky` brings to a level surface, by Gauss's rule in the height."""
    z, weight = np.polynomial.legendre.leggauss(24)
    height, phi = 0.5 * (z + 1.0), np.arange(48) * 2.0 * math.pi / 48
    across = np.sqrt(1.0 - height**2)[:, None]
    up = np.stack([across * np.sin(phi), height[:, None] + 0.0 * phi, across * np.cos(phi)], axis=-1)
    share = (0.5 * weight * height * 2.0 * math.pi / 48)[:, None, None]
    return np.asarray((sky(up) * share).sum(axis=(0, 1)))


#: Width of the soft edges, on a plane at distance 1.
EDGE = 0.05


def studio(direction: Vectors) -> Vectors:
    """A dark room with a large warm lamp above on the left, a cool one on the right and a bright strip behind."""
    lamps = (
        ((-0.6, 0.65, 0.55), 0.45, (5.2, 4.9, 4.4)),
        ((0.9, 0.2, 0.45), 0.30, (1.6, 1.8, 2.1)),
        ((0.35, 0.5, -0.85), 0.22, (5.0, 5.0, 5.2)),
    )
    light = _room(direction)
    for towards, size, colour in lamps:
        light = light + _panel(direction, normalize(towards), size, size) * np.array(colour)
    return light


def softboxes(direction: Vectors) -> Vectors:
    """Three softboxes as portraits are lit: a large key light, a weak fill opposite, a narrow rim light behind."""
    lamps = (
        ((-0.75, 0.55, 0.75), 0.55, 0.75, 7.0),
        ((0.95, 0.15, 0.60), 0.50, 0.70, 1.6),
        ((0.60, 0.60, -0.90), 0.18, 0.60, 9.0),
    )
    light = 0.5 * _room(direction)
    for towards, half_width, half_height, bright in lamps:
        box = _panel(direction, normalize(towards), half_width, half_height)
        light = light + box * bright * np.array([1.0, 0.98, 0.95])
    return light


def ring_light(direction: Vectors) -> Vectors:
    """A ring lamp around the camera and a white table below, for jewellery and for faces."""
    ahead = np.maximum(direction[..., 2:3], 1e-9)
    radius = np.hypot(direction[..., 0:1], direction[..., 1:2]) / ahead
    ring = _step(EDGE * 2.4 - np.abs(radius - 0.42), 0.0, EDGE) * (direction[..., 2:3] > 0.0)
    table = _step(-direction[..., 1:2], 0.35, 0.2)
    return 0.6 * _room(direction) + ring * np.array([14.0, 14.0, 13.4]) + table * np.array([0.35, 0.35, 0.36])


def strip_lights(direction: Vectors) -> Vectors:
    """Four long tubes overhead and one upright at each side, as car bodies are looked at for dents."""
    light = 0.4 * _room(direction)
    for side in (-1.2, -0.4, 0.4, 1.2):
        light = light + _panel(direction, normalize((side, 1.0, 0.0)), 1.6, 0.06) * np.array([6.0, 6.3, 6.6])
    for side in (-1.0, 1.0):
        light = light + _panel(direction, normalize((side, 0.0, 0.25)), 0.08, 0.9) * np.array([4.0, 3.8, 3.4])
    return light


def window(direction: Vectors) -> Vectors:
    """A room with a window of four panes on the left, a sunlit patch on the floor and warm walls."""
    towards = normalize((-1.0, 0.15, 0.35))
    up = direction[..., 1:2]
    walls = np.array([0.16, 0.14, 0.12]) * (0.6 + 0.4 * np.clip(dot(direction, -towards)[..., None], -0.5, 1.0))
    floor = _step(-up, 0.45, 0.1) * np.array([0.10, 0.07, 0.05])
    ceiling = _step(up, 0.6, 0.1) * np.array([0.06, 0.06, 0.06])
    patch = _panel(direction, normalize((0.45, -1.0, 0.25)), 0.22, 0.35) * np.array([3.2, 2.7, 2.1])
    pane = _panel(direction, towards, 0.55, 0.65)
    across, along = _on_plane(direction, towards)
    bars = _step(np.minimum(np.abs(across), np.abs(along))[..., None], 0.035, 0.03)  # 0 on the cross between panes
    sky = np.array([4.2, 5.0, 6.2]) + np.array([2.5, 2.2, 1.8]) * np.clip(-along[..., None] / 0.65, -1.0, 1.0)
    glass = pane * bars
    return (walls + floor + ceiling) * (1.0 - glass) + glass * sky + patch


def _room(direction: Vectors) -> Vectors:
    """Walls that are nearly black, and a ceiling that is a little brighter."""
    return 0.03 + 0.05 * np.clip(direction[..., 1:2], 0.0, 1.0) + np.zeros(3)


def _on_plane(direction: Vectors, towards: Vectors) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Coordinates to the right and down of `direction` on the plane at distance 1 across `towards`; inf behind."""
    right = normalize(np.cross((0.0, 1.0, 0.0), towards))
    ahead = dot(direction, towards)
    distance = np.where(ahead > 0.0, ahead, np.inf)
    far = np.where(ahead > 0.0, 0.0, np.inf)
    return dot(direction, right) / distance + far, dot(direction, np.cross(right, towards)) / distance + far


def _panel(direction: Vectors, towards: Vectors, half_width: float, half_height: float) -> Vectors:
    """(..., 1): 1 inside an upright rectangle on the plane at distance 1, with soft edges."""
    across, along = (np.abs(value) for value in _on_plane(direction, towards))
    beyond = np.minimum(half_width - across, half_height - along)
    return _step(np.maximum(beyond, -9.0), 0.0, EDGE)[..., None]


def _step(x: NDArray[np.float64], middle: float, width: float) -> NDArray[np.float64]:
    """Rises smoothly from 0 to 1 over `width` about `middle`."""
    t = np.clip((x - middle) / width + 0.5, 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


@dataclass(frozen=True)
class Sky:
    """A built-in environment: what users read, radiance (..., 3) by direction (..., 3), and the rows of its map."""

    label: str
    radiance: Radiance
    rows: int = 256


def make_built_in(name: str) -> EnvironmentMap:
    """The environment of that name in `SKIES`, twice as wide as high; KeyError where there is none. Up to 0.2 s."""
    sky = SKIES[name]
    radiance = sky.radiance(texel_directions(sky.rows, 2 * sky.rows))
    return EnvironmentMap(radiance.astype(np.float32), name)


def _sky(direction: Vectors) -> Vectors:
    """A clear sky that pales towards the horizon, a sun of a few degrees with its glow, and a brown ground."""
    height = direction[..., 1:2]
    sun = dot(direction, normalize((0.5, 0.62, 0.6)))[..., None]
    blue = np.array([0.10, 0.20, 0.46]) + np.array([0.32, 0.30, 0.20]) * (1.0 - np.clip(height, 0.0, 1.0)) ** 4
    t = np.clip((sun - np.cos(0.06)) / 8e-4 + 0.5, 0.0, 1.0)
    light = np.array([1.0, 0.88, 0.70]) * (0.25 * np.exp(40.0 * (sun - 1.0)) + 220.0 * t * t * (3.0 - 2.0 * t))
    return np.where(height > 0.0, blue + light, np.array([0.09, 0.075, 0.06]))


#: By name; the first two are the oldest, and their maps stay as small as they were.
SKIES = MappingProxyType(
    {
        "studio": Sky("Studio", studio, 128),
        "sky": Sky("Sky", _sky, 128),
        "noon": Sky("Clear sky, sun at 60°", clear_sky(60.0)),
        "afternoon": Sky("Clear sky, sun at 30°", clear_sky(30.0)),
        "evening": Sky("Clear sky, sun at 10°", clear_sky(10.0, 3.0)),
        "sunset": Sky("Sunset, sun at 2°", clear_sky(2.0, 3.5)),
        "overcast": Sky("Overcast sky", overcast),
        "softboxes": Sky("Three softboxes", softboxes),
        "ring-light": Sky("Ring light", ring_light),
        "strip-lights": Sky("Strip lights", strip_lights),
        "window": Sky("Room with a window", window),
    }
)

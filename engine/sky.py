"""The environments that need no file: skies and studios under the names that people ask for."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from engine.daylight import Radiance, clear_sky, overcast
from engine.directions import Vectors, dot, normalize
from engine.environment import EnvironmentMap, texel_directions
from engine.studios import ring_light, softboxes, strip_lights, studio, window


@dataclass(frozen=True)
class Sky:
    """A built-in environment: what people read, radiance (..., 3) by direction (..., 3), and the rows of its map."""

    label: str
    radiance: Radiance
    rows: int = 256


def built_in(name: str) -> EnvironmentMap:
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

"""Studios: rooms with lamps of several shapes, as radiance (..., 3) by direction (..., 3) of the world, +Y up.

A lamp is a patch of a plane at distance 1 in front of which the object stands, with edges a little soft so that maps
of 128 rows show them without steps.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.directions import Vectors, dot, normalize

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

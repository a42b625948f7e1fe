"""A mirror sphere beside the sample, from whose highlight the direction of the lamp can be read.

The orthographic camera sees the point (x, y) of a sphere of radius one under the normal n = (x, y, sqrt(1 - x^2 - y^2))
and in it what lies towards 2 n_z n - v, v = (0, 0, 1): the sample below the horizon, a dim room above, and the lamp
where n halves the angle between lamp and camera. Polishing leaves the lamp a glow of `GLOW`, far above the white level.
The sphere throws no shadow and lights nothing.
Cost: the square around the sphere, some milliseconds.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.capture.mirror_sphere import Circle

#: Deviation of the normals under which the lamp is seen, radians.
GLOW = math.radians(2.0)

_REFLECTANCE, _ROOM, _LAMP = 0.7, 0.02, 6.0


def with_ball(image: NDArray[np.float32], ball: Circle, lamp: NDArray[np.float64]) -> NDArray[np.float32]:
    """A copy of `image` (H, W, 3; 1 = white level) with a sphere that lies inside it.

    `ball` is in texels of the image, `lamp` the unit vector from the sphere to the lamp.
    """
    top, left = math.floor(ball.row - ball.radius) - 1, math.floor(ball.column - ball.radius) - 1
    side = math.ceil(2 * ball.radius) + 3
    row, column = np.mgrid[top : top + side, left : left + side] + 0.5
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
    square = result[top : top + side, left : left + side]
    square += (cover * (seen - square)).astype(np.float32)
    return result

"""Light probes in a circle: photographs of a mirror ball, and angular maps, as equirectangular maps.

A ball is seen from far away by a camera that looks along −z: a point (x, y) of the unit circle has the normal
n = (x, y, √(1 − x² − y²)) and shows the direction 2 (n · v) n − v, v = +z, so that a direction d lies at the x and y of
the half vector of d and v. Its middle shows what lies behind the camera. An angular map has −z in its middle, and the
angle from it grows evenly to the opposite direction at the rim (Debevec1998). In both x is to the right and y up.
Texels are the means of four directions, between pixels by straight lines; at the rim the last whole pixels count.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from engine.light.environment import direction_at

Array = NDArray[np.float64]

#: Rows of directions that are looked up at once.
_ROWS = 64


def _on_ball(direction: Array) -> tuple[Array, Array]:
    half = direction + np.array((0.0, 0.0, 1.0))
    length = np.linalg.norm(half, axis=-1)
    return half[..., 0] / np.maximum(length, 1e-12), half[..., 1] / np.maximum(length, 1e-12)


def _on_angular_map(direction: Array) -> tuple[Array, Array]:
    across = np.hypot(direction[..., 0], direction[..., 1])
    radius = np.arctan2(across, -direction[..., 2]) / np.pi / np.maximum(across, 1e-12)
    return direction[..., 0] * radius, direction[..., 1] * radius


#: Places (x, y) in the unit circle of directions (…, 3), by form.
FORMS: dict[str, Callable[[Array], tuple[Array, Array]]] = {"ball": _on_ball, "angular": _on_angular_map}


def within_circle(side: int) -> NDArray[np.bool_]:
    """(side, side) True for pixels with their middles in the circle."""
    steps = (np.arange(side) + 0.5) / side * 2.0 - 1.0
    return np.asarray(np.hypot(steps, steps[:, None]) <= 1.0)


def unfold(probe: NDArray[np.float32], form: str) -> NDArray[np.float32]:
    """(N / 2, N, 3) the equirectangular map of a probe (N, N, 3) of a form, N rounded up to an even number."""
    side = len(probe)
    rows = max(1, (side + 1) // 2)
    found = np.empty((rows, 2 * rows, 3), np.float32)
    u = (np.arange(4 * rows) + 0.5) / (4 * rows)
    for first in range(0, rows, _ROWS):
        last = min(first + _ROWS, rows)
        v = (np.arange(2 * first, 2 * last) + 0.5) / (2 * rows)
        fine = _look_up(probe, *FORMS[form](direction_at(*np.meshgrid(u, v))))
        found[first:last] = fine.reshape(last - first, 2, 2 * rows, 2, 3).mean(axis=(1, 3))
    return found


def _look_up(probe: NDArray[np.float32], x: Array, y: Array) -> Array:
    """(…, 3) the probe at places in the unit circle, no nearer to its rim than two pixels."""
    side = len(probe)
    inwards = np.minimum(1.0, max(1.0 - 4.0 / side, 0.0) / np.maximum(np.hypot(x, y), 1e-12))
    column, row = (0.5 + 0.5 * inwards * x) * side - 0.5, (0.5 - 0.5 * inwards * y) * side - 0.5
    value: Array | float = 0.0
    for across in (0, 1):
        for down in (0, 1):
            at_x, at_y = np.floor(column).astype(np.int64) + across, np.floor(row).astype(np.int64) + down
            share = (1.0 - np.abs(column - at_x)) * (1.0 - np.abs(row - at_y))
            inside = probe[np.clip(at_y, 0, side - 1), np.clip(at_x, 0, side - 1)]
            value = value + share[..., None] * inside
    return np.asarray(value)

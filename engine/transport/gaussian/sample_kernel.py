"""Compiled loops of samples: the table of an isotropic highlight put to a vertex, and what the vertex sees along it.

Visibility along a direction is the share of its texel that is visible, of the parts that lie above the horizon. Bound
by memory: some 10 ns for a sample.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import scalar
from engine.light.cube_map import FACES

Bools = NDArray[np.bool_]
Integers = NDArray[np.integer]
Floats = NDArray[np.floating]

#: A texel is this many of its widths across at most: farther from the horizon than that, all of it is above.
ACROSS = 3.0


@scalar
def share_along(direction: Floats, normal: Floats, counts: Integers, edge: int, fine: int) -> float:
    """The visible share of the texel that `direction` (3,) falls into, by `counts` (6 edge²,) of its fine² parts."""
    axis = 0
    for k in range(1, 3):
        if abs(direction[k]) > abs(direction[axis]):
            axis = k
    face = 2 * axis + (1 if direction[axis] < 0.0 else 0)
    longest = abs(direction[axis])
    across = down = height = 0.0
    for k in range(3):
        across += direction[k] * FACES[face, 0, k]
        down += direction[k] * FACES[face, 1, k]
        height += direction[k] * normal[k]
    column = min(int((0.5 * across / longest + 0.5) * edge), edge - 1)
    row = min(int((0.5 * down / longest + 0.5) * edge), edge - 1)
    count = counts[(face * edge + row) * edge + column]
    full = fine * fine
    if count > 0 and height * edge < ACROSS:
        full = _parts_above(face, row, column, normal, edge, fine)
    return min(count / full, 1.0) if full > 0 else 0.0


@scalar
def _parts_above(face: int, row: int, column: int, normal: Floats, edge: int, fine: int) -> int:
    """How many of the fine² parts of a texel lie above the horizon of `normal` (3,)."""
    above, width = 0, edge * fine
    for i in range(fine):
        down = 2.0 * (row * fine + i + 0.5) / width - 1.0
        for j in range(fine):
            across = 2.0 * (column * fine + j + 0.5) / width - 1.0
            height = 0.0
            for k in range(3):
                height += normal[k] * (across * FACES[face, 0, k] + down * FACES[face, 1, k] + FACES[face, 2, k])
            above += height > 0.0
    return above


@scalar
def shares_along(directions: Floats, normal: Floats, counts: Integers, edge: int, fine: int, shares: Floats) -> None:
    """Fill `shares` (N,) with `share_along` of `directions` (N, 3)."""
    for index in range(len(directions)):
        shares[index] = share_along(directions[index], normal, counts, edge, fine)


@scalar
def place_highlights(
    table: tuple[Floats, Floats, Floats],
    views: Floats,
    above: Bools,
    frame: Floats,
    free: bool,
    counts: Integers,
    edge: int,
    fine: int,
    direction: Floats,
    value: Floats,
    area: Floats,
) -> None:
    """Samples of a vertex towards the `views` (M, 3) that are `above` (M,) its horizon, from the table of a highlight.

    Parameters
    ----------
    table : directions (T, S, 3), values (T, S, 3) and areas (T, S) for viewers in the x-z plane of the surface frame,
        at the middles of T equal steps of the angle from the normal.
    frame : (3, 3) with columns tangent, bitangent, normal. free : nothing is in the way. counts : (6 edge²,) uint8.
    direction, value, area : filled, (views above · S, …), in the world.
    """
    directions, values, areas = table
    steps, count = areas.shape
    normal, along, across = frame[:, 2].copy(), np.empty(3), np.empty(3)
    row = 0
    for view in range(len(views)):
        if not above[view]:
            continue
        up = 0.0
        for k in range(3):
            up += views[view, k] * normal[k]
        square = 0.0
        for k in range(3):
            along[k] = views[view, k] - up * normal[k]
            square += along[k] * along[k]
        for k in range(3):
            along[k] = along[k] / math.sqrt(square) if square > 1e-20 else frame[k, 0]
        across[0] = normal[1] * along[2] - normal[2] * along[1]
        across[1] = normal[2] * along[0] - normal[0] * along[2]
        across[2] = normal[0] * along[1] - normal[1] * along[0]
        angle = math.atan2(math.sqrt(square), up)
        step = min(int(angle * (2.0 / math.pi) * steps), steps - 1)
        for s in range(count):
            x, y, z = directions[step, s, 0], directions[step, s, 1], directions[step, s, 2]
            for k in range(3):
                direction[row, k] = x * along[k] + y * across[k] + z * normal[k]
            share = 1.0
            if values[step, s, 0] + values[step, s, 1] + values[step, s, 2] == 0.0:
                share = 0.0
            elif not free:
                share = share_along(direction[row], normal, counts, edge, fine)
            for c in range(3):
                value[row, c] = share * values[step, s, c]
            area[row] = areas[step, s]
            row += 1

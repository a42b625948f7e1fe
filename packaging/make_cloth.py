"""A cloth that falls over a ball: position-based dynamics (Müller et al. 2007) on a small grid.

`python packaging/make_cloth.py resources/models/cloth.npy` made the file that `engine.geometry.shapes` refines.
Constraints are solved one after the other (Gauss–Seidel); a few seconds, bound by the square roots of some 50 million
constraints.
"""

from __future__ import annotations

import sys

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import scalar
from engine.storage.atomic import atomic_file

POINTS = 61
SIDE = 2.6
SPHERE_RADIUS = 0.6
GROUND = -0.6
STEPS = 360
SWEEPS = 5

#: Neighbour (rows, columns) whose distance is kept, and how firmly: threads, shear, bending.
CONSTRAINTS = np.array(
    [(0, 1, 1.0), (1, 0, 1.0), (1, 1, 0.35), (1, -1, 0.35), (0, 2, 0.10), (2, 0, 0.10), (0, 4, 0.02), (4, 0, 0.02)]
)


def drape() -> NDArray[np.float32]:
    """Positions (rows, columns, 3) of the fallen cloth; rows run along v, columns along u, its upper side outside."""
    side = np.linspace(-SIDE / 2, SIDE / 2, POINTS)
    x, z = np.meshgrid(side, -side)
    turned = np.stack([x, z], -1) @ [[np.cos(0.5), np.sin(0.5)], [-np.sin(0.5), np.cos(0.5)]]
    height = SPHERE_RADIUS + 0.02 + 0.01 * np.sin(5.0 * x + 1.0) * np.sin(4.0 * z)
    fallen: NDArray[np.float64] = _fall(np.stack([turned[..., 0], height, turned[..., 1]], -1), CONSTRAINTS)
    return fallen.astype(np.float32)


@scalar
def _fall(positions, constraints):  # type: ignore[no-untyped-def]
    positions = positions.copy()
    velocity = np.zeros_like(positions)
    for _ in range(STEPS):
        before = positions.copy()
        velocity *= 0.985
        velocity[..., 1] -= 0.0016
        positions += velocity
        for _sweep in range(SWEEPS):
            _keep_lengths(positions, constraints)
            _keep_outside(positions, before)
        velocity = positions - before
    return positions


@scalar
def _keep_lengths(positions, constraints):  # type: ignore[no-untyped-def]
    count = positions.shape[0]
    cell = SIDE / (count - 1)
    for rule in range(constraints.shape[0]):
        rows, columns, firmness = int(constraints[rule, 0]), int(constraints[rule, 1]), constraints[rule, 2]
        rest = cell * np.sqrt(rows * rows + columns * columns)
        for row in range(count - rows):
            for column in range(max(0, -columns), count - max(0, columns)):
                p, q = row + rows, column + columns
                x = positions[p, q, 0] - positions[row, column, 0]
                y = positions[p, q, 1] - positions[row, column, 1]
                z = positions[p, q, 2] - positions[row, column, 2]
                share = 0.5 * firmness * (1.0 - rest / max(np.sqrt(x * x + y * y + z * z), 1e-12))
                positions[row, column, 0] += share * x
                positions[row, column, 1] += share * y
                positions[row, column, 2] += share * z
                positions[p, q, 0] -= share * x
                positions[p, q, 1] -= share * y
                positions[p, q, 2] -= share * z


@scalar
def _keep_outside(positions, before):  # type: ignore[no-untyped-def]
    """Push out of ball and ground; what touches the ground stays where it was, what touches the ball nearly so."""
    for row in range(positions.shape[0]):
        for column in range(positions.shape[1]):
            p, old = positions[row, column], before[row, column]
            distance = np.sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2])
            if distance < SPHERE_RADIUS:
                p *= SPHERE_RADIUS / max(distance, 1e-12)
                p += 0.3 * (old - p)
            if p[1] < GROUND:
                p[1] = GROUND
                p[0] += 0.5 * (old[0] - p[0])
                p[2] += 0.5 * (old[2] - p[2])


if __name__ == "__main__":
    with atomic_file(sys.argv[1]) as file:
        np.lib.format.write_array(file, drape(), allow_pickle=False)

"""One function on the sphere as a sum of few Gaussians, of spherical harmonics, or of Haar wavelets: the nearest of
each.

Green2006 Sec. 6.3, compares them by how many numbers they take, seven for a Gaussian.
Functions are grey and tabulated at the texels of a cube map; distances are relative, in the norm of L² on the sphere.

Gaussians are added one by one where they lower the distance most, and all are moved together after each (Levenberg and
Marquardt on means, logarithms of widths and roots of weights). That is a local minimum, and none is promised to be
the lowest; but no sum of more Gaussians is farther than one of fewer.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import Vectors, normalize, world_from_tangent
from engine.core.one_thread import one_thread
from engine.core.steps import Step, Steps
from engine.light.cube_map import cube_directions, cube_solid_angles
from engine.transport.gaussian.fitting.lobes import NARROWEST, WIDEST_LOBE
from engine.transport.sh.basis import evaluate
from engine.transport.wavelet.haar import haar, inverse_haar

Floats = NDArray[np.float64]

#: Numbers that a Gaussian takes.
NUMBERS = 7

#: Places where the next Gaussian is tried, and how wide it is there in rad.
PLACES, WIDTHS = 24, (0.02, 0.05, 0.1, 0.2, 0.4, 0.8)

#: Steps of a minimisation, and the share of the distance below which a step ends it.
STEPS, ENOUGH = 60, 1e-6

#: Texels along a side that are taken as one where a function is below this share of its largest value.
COARSE, DIM = 4, 1e-3


@dataclass(frozen=True, eq=False)
class Tabulated:
    """A grey function: `value` (n,) at unit vectors `direction` (n, 3), each for `area` (n,) in sr."""

    value: Floats
    direction: Vectors
    area: Floats

    @property
    def edge(self) -> int:
        return round(np.sqrt(len(self.value) / 6))

    def distance(self, approximation: Floats) -> float:
        """Distance of (6 N²,) values from the function, relative to it; 0 where that is 0."""
        norm = float(self.area @ self.value**2)
        return float(np.sqrt(self.area @ (approximation - self.value) ** 2 / norm)) if norm > 0.0 else 0.0


@dataclass(frozen=True, eq=False)
class Sum:
    """Gaussians: unit `mean` (L, 3), `sigma` (L,) rad and `weight` (L,) ≥ 0."""

    mean: Vectors
    sigma: Floats
    weight: Floats

    def at(self, direction: Vectors) -> Floats:
        """(n,) at unit vectors (n, 3)."""
        return _gaussians(self, direction) @ self.weight


def texels(edge: int) -> tuple[Vectors, Floats]:
    """Directions (6 N², 3) and solid angles (6 N²,) of the texels of a cube map."""
    return cube_directions(edge).reshape(-1, 3), np.tile(cube_solid_angles(edge).reshape(-1), 6)


def gaussians(table: Tabulated, most: int) -> Steps[list[Sum]]:
    """The sums of 1, 2, … `most` Gaussians."""
    table = condense(table)
    found = Sum(np.zeros((0, 3)), np.zeros(0), np.zeros(0))
    sums = []
    for count in range(1, most + 1):
        with one_thread():
            found = minimise(table, _with_one_more(table, found))
        sums.append(found)
        yield Step(count / most, f"fitting {count} Gaussians")
    return sums


def condense(table: Tabulated) -> Tabulated:
    """The same with fewer samples: squares of texels in which the function is next to nothing count as one."""
    edge, blocks = table.edge, table.edge // COARSE

    def squares(values: Floats) -> Floats:
        """(blocks, texels of each, …)."""
        shape = (6, blocks, COARSE, blocks, COARSE, *values.shape[1:])
        return np.swapaxes(values.reshape(shape), 2, 3).reshape(6 * blocks**2, COARSE**2, *values.shape[1:])

    if edge % COARSE:
        return table
    value, direction, area = map(squares, (table.value, table.direction, table.area))
    dim = (value <= DIM * table.value.max()).all(axis=1)
    together = area[dim].sum(axis=1)
    return Tabulated(
        np.concatenate([value[~dim].reshape(-1), (value[dim] * area[dim]).sum(axis=1) / together]),
        np.concatenate([direction[~dim].reshape(-1, 3), normalize(direction[dim].sum(axis=1))]),
        np.concatenate([area[~dim].reshape(-1), together]),
    )


def _gaussians(own: Sum, direction: Vectors) -> Floats:
    """(n, L) each Gaussian at `direction` (n, 3)."""
    square = np.maximum(2.0 - 2.0 * direction @ own.mean.T, 0.0)
    return np.exp(-0.5 * square / own.sigma**2)


def _with_one_more(table: Tabulated, own: Sum) -> Sum:
    """`own` and the Gaussian that lowers the distance most, by itself, among some places and widths."""
    left = table.value - own.at(table.direction)
    order = np.argsort(-left)
    best, gain = None, 0.0
    for place in order[np.unique(np.geomspace(1, max(len(left) // 8, 1), PLACES).astype(int)) - 1]:
        for sigma in WIDTHS:
            one = Sum(table.direction[place : place + 1], np.array([sigma]), np.ones(1))
            shape = one.at(table.direction)
            weighted = table.area * shape
            height = float(weighted @ left) / float(weighted @ shape)
            lowered = height * float(weighted @ left)
            if height > 0.0 and lowered > gain:
                best, gain = (one, height), lowered
    if best is None:
        return Sum(np.vstack([own.mean, [0.0, 0.0, 1.0]]), np.append(own.sigma, 0.1), np.append(own.weight, 0.0))
    one, height = best
    return Sum(np.vstack([own.mean, one.mean]), np.append(own.sigma, one.sigma), np.append(own.weight, height))


def minimise(table: Tabulated, own: Sum) -> Sum:
    """`own` after steps that lower the distance, as far as they do."""
    damping, cost = 1e-3, _cost(table, own)
    for _ in range(STEPS):
        gradient, hessian = _derivatives(table, own)
        lowered = False
        while damping < 1e9:
            scale = np.diag(hessian) * damping + 1e-12 * max(float(hessian.max()), 1e-300)
            step: Floats = -np.linalg.solve(hessian + np.diag(scale), gradient).astype(np.float64)
            moved = _move(own, step)
            new = _cost(table, moved)
            if new < cost:
                lowered = cost - new > ENOUGH * cost
                own, cost, damping = moved, new, max(0.3 * damping, 1e-9)
                break
            damping *= 6.0
        if not lowered:
            break
    return own


def _cost(table: Tabulated, own: Sum) -> float:
    return float(table.area @ (own.at(table.direction) - table.value) ** 2)


def _axes(mean: Vectors) -> Floats:
    """(L, 3, 2) two unit vectors across each mean."""
    return world_from_tangent(mean)[:, :, :2]


def _derivatives(table: Tabulated, own: Sum) -> tuple[Floats, Floats]:
    """Half the gradient (4L,) and Gauss and Newton's matrix (4L, 4L).

    By steps of the mean across it in units of sigma, twice, of log sigma, and of the root of the weight.
    """
    shape = _gaussians(own, table.direction)
    square = np.maximum(2.0 - 2.0 * table.direction @ own.mean.T, 0.0) / own.sigma**2
    across = np.einsum("ni,lia->nla", table.direction, _axes(own.mean)) / own.sigma[:, None]
    root = np.sqrt(own.weight)
    by_mean = across * (shape * own.weight)[..., None]
    by_width = shape * own.weight * square
    by_root = 2.0 * root * shape
    columns = np.concatenate([by_mean.reshape(len(shape), -1), by_width, by_root], axis=1)
    weighted = columns * table.area[:, None]
    left = shape @ own.weight - table.value
    return weighted.T @ left, weighted.T @ columns


def _move(own: Sum, step: Floats) -> Sum:
    count = len(own.sigma)
    across = np.clip(step[: 2 * count].reshape(count, 2), -2.0, 2.0) * np.minimum(own.sigma, 0.5)[:, None]
    mean = normalize(own.mean + np.einsum("la,lia->li", across, _axes(own.mean)))
    sigma = own.sigma * np.exp(np.clip(step[2 * count : 3 * count], -1.0, 1.0))
    weight = (np.sqrt(own.weight) + step[3 * count :]) ** 2
    return Sum(mean, np.clip(sigma, NARROWEST, WIDEST_LOBE), weight)


def wavelets(table: Tabulated, counts: list[int]) -> list[Floats]:
    """(6 N²,) the function from its so many largest Haar coefficients, for each of `counts`.

    What is transformed is the function times the root of each texel's solid angle, so that no other choice of that many
    coefficients of this transform is nearer in L² on the sphere.
    """
    edge, root = table.edge, np.sqrt(table.area)
    whole = haar((table.value * root).reshape(6, edge, edge)).reshape(-1)
    order = np.argsort(-np.abs(whole), kind="stable")
    found = []
    for count in counts:
        kept = np.zeros_like(whole)
        kept[order[:count]] = whole[order[:count]]
        values: Floats = np.asarray(inverse_haar(kept.reshape(6, edge, edge)), np.float64).reshape(-1) / root
        found.append(values)
    return found


def order_for(numbers: int) -> int:
    """The lowest order of at least so many spherical harmonics."""
    return math.isqrt(max(numbers - 1, 0)) + 1


def spherical_harmonics(table: Tabulated, order: int) -> Floats:
    """(order²,) the coefficients of the nearest sum of spherical harmonics of `order`."""
    root = np.sqrt(table.area)
    basis = evaluate(order, table.direction)
    with one_thread():
        found = np.linalg.lstsq(basis * root[:, None], table.value * root, rcond=None)[0]
    return np.asarray(found, np.float64)

"""Textures that fit samples best, for given projections: sparse least squares, all colour channels at once.

A sample's row of B holds the bilinear weights of its look-ups in every texture (Cole2002 Eq. 3.4,
Cole2002 Eq. 3.6, Cole2002 Eq. 3.11; a
texture that is read twice, by a projection and its conjugate, has both in the same columns). Minimised is

    (1/N) |B y − f|²  +  (λ/M) |L y|²  +  μ |y|²

over the M texels that samples touch. The rows of L are second differences of neighbouring texels, ∂uu, ∂vv and √2 ∂uv:
λ → ∞ leaves a plane, λ → 0 interpolates. Texels of the mask that no sample touches are not unknowns: they are filled by
the mean of their neighbours, which has no extremum of its own. With λ = 0 they are refused.

Without μ there is no unique answer: J textures can pass J − 1 constants and some planes between them, a texture that is
read at u and −u has no odd part. μ is `RIDGE` of the mean diagonal of BᵀB and picks the shortest y; afterwards every
texture but the first has its mean moved into the first.

Normal equations square the condition number (Cole2002 Eq. 3.7 with QMR lost all digits at 1e6). Here μ bounds it: that
of
BᵀB was 1e4 to 6e9 for two to five textures of blue paint (`Fit.condition_number` is the root, that of B with its
further rows). Its Cholesky factor is good to 1e-6 at worst, which is enough to choose projections; for the textures
that are kept it is only the preconditioner of conjugate gradients on B itself (CGLS, whose residuals are those of the
samples), which takes back the bias of μ too and ends at a relative gradient below 1e-13 within three steps. Above
`DENSE_LIMIT` unknowns there is no factor, and CGLS goes with the diagonal.

All of it runs on the caller's thread without the interpreter lock: a search tries several projections at once, one per
thread, and no sum depends on how many there are. LAPACK takes one thread for that reason. Bound by scattered additions
into BᵀB: for two textures read twice each, 100 per sample.

Solution and condition of a dense system from its Cholesky factor, which LAPACK computes (`numpy.linalg`).

Triangles are solved here, since scipy's LAPACK keeps the interpreter lock, and a search solves on all threads at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.linalg import splu

from engine.core.errors import UsageError
from engine.core.kernels import scalar
from engine.core.one_thread import one_thread
from engine.factor.solvers.least_squares_rows import (
    Rows,
    add_products,
    find_reached_texels,
    moments,
    own_products,
    predict,
    products,
    second_differences,
)


@scalar
def substitute(factor: np.ndarray, right: np.ndarray) -> np.ndarray:
    """x (n, m) with F Fᵀ x = right (n, m)."""
    x = right.copy()
    n, m = x.shape
    for i in range(n):
        for c in range(m):
            s = x[i, c]
            for k in range(i):
                s -= factor[i, k] * x[k, c]
            x[i, c] = s / factor[i, i]
    for i in range(n - 1, -1, -1):
        for c in range(m):
            x[i, c] /= factor[i, i]
        for k in range(i):
            for c in range(m):
                x[k, c] -= factor[i, k] * x[i, c]
    return x


@scalar
def largest_eigenvalue(lower: np.ndarray) -> float:
    """That of a symmetric positive matrix given by its lower triangle, from below, by 20 power iterations."""
    n = len(lower)
    x = np.ones(n) / np.sqrt(n)
    length = 0.0
    for _ in range(20):
        y = np.zeros(n)
        for i in range(n):
            s = lower[i, i] * x[i]
            for k in range(i):
                s += lower[i, k] * x[k]
                y[k] += lower[i, k] * x[i]
            y[i] += s
        length = 0.0
        for i in range(n):
            length += y[i] * y[i]
        length = np.sqrt(length)
        x = y / length
    return length


@scalar
def largest_of_inverse(factor: np.ndarray) -> float:
    """The same of the inverse of a matrix given by its Cholesky factor."""
    n = len(factor)
    x = np.empty((n, 1))
    for i in range(n):
        x[i, 0] = 1.0 if i % 2 else -0.7
    length = 0.0
    for _ in range(20):
        x = substitute(factor, x)
        length = 0.0
        for i in range(n):
            length += x[i, 0] * x[i, 0]
        length = np.sqrt(length)
        x = x / length
    return length


Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Weight μ of the shortest solution, relative to the mean diagonal.
RIDGE = 1e-8

#: Most unknowns for which BᵀB is formed.
DENSE_LIMIT = 2600

#: Conjugate gradients end at this gradient, relative to the first, or after so many steps.
GRADIENT = 1e-13
REFINEMENTS = 12
DIAGONAL_STEPS = 300


@dataclass(frozen=True, eq=False)
class Term:
    """One texture's part of the problem, which does not depend on the other textures.

    Attributes
    ----------
    rows : of the samples. smoothing : of L, for texels that samples touch.
    gram : (T, T), BᵀB/N + λ LᵀL/M without μ. moment : (T, 3), Bᵀf/N.
    reached : (T,) the texels that samples touch. mask : (T,) those that any pair of directions can touch.
    """

    rows: Rows
    smoothing: Rows
    gram: Floats
    moment: Floats
    reached: Mask
    mask: Mask


@dataclass(frozen=True, eq=False)
class Fit:
    """Textures (n, n, 3) and how well they are known.

    Attributes
    ----------
    condition_number : κ of B with the rows of smoothing and ridge; at least this. 0 where it was not asked for.
    gradient : |Bᵀ(B y − f)| / (|B| |f|), B with its further rows; how far from the minimum. 0 as above.
    unknowns, steps : texels solved for, and steps of conjugate gradients.
    """

    textures: tuple[Floats, ...]
    condition_number: float
    gradient: float
    unknowns: int
    steps: int


def term(rows: Rows, target: Floats, mask: Mask, smoothing: float) -> Term:
    """Contribution of a texture to the problem for the log values `target` (N, 3), with λ = `smoothing`.

    Raises UsageError where λ = 0 and the mask has texels that no sample touches.
    """
    count = len(rows.texel)
    reached = find_reached_texels(rows)
    mask = mask.reshape(-1) | reached
    if smoothing == 0.0 and (mask & ~reached).any():
        raise UsageError(f"{int((mask & ~reached).sum())} texels have no sample; smoothing above 0 fills them")
    gram = own_products(rows) / count
    index, weight = second_differences(rows.size, reached, np.sqrt(smoothing / reached.sum()))
    differences = Rows(index, weight, rows.size)
    add_products(index, weight, index, weight, gram)
    return Term(rows, differences, gram, moments(rows, target) / count, reached, mask)


def with_smoothing(one: Term, share: float) -> Term:
    """The same with another λ: `share` ≥ 0 of its own."""
    index, weight, size = one.smoothing
    gram = one.gram.copy()
    add_products(index, weight, index, (share - 1.0) * weight, gram)
    return replace(one, gram=gram, smoothing=Rows(index, np.sqrt(share) * weight, size))


def solve(terms: Sequence[Term], target: Floats, refine: bool = False) -> Fit:
    """The textures of all `terms` together that fit `target` (N, 3), the one that the terms were made with.

    With `refine`, to the last digits and with the condition number and the gradient; without, as a search needs it.
    """
    count = len(target)
    places = [np.flatnonzero(one.reached) for one in terms]
    starts = np.concatenate([[0], np.cumsum([len(place) for place in places])])
    unknowns = int(starts[-1])
    right = np.concatenate([one.moment[place] for one, place in zip(terms, places, strict=True)])
    diagonal = np.concatenate([one.gram.diagonal()[place] for one, place in zip(terms, places, strict=True)])
    ridge = RIDGE * float(diagonal.mean())
    slices = [slice(starts[k], starts[k + 1]) for k in range(len(terms))]
    factor: Floats | None = None
    condition = 0.0
    if unknowns <= DENSE_LIMIT:
        factor = np.zeros((unknowns, unknowns))
        for k, one in enumerate(terms):
            factor[slices[k], slices[k]] = one.gram[np.ix_(places[k], places[k])]
            for m in range(k):
                crossed = products(one.rows, terms[m].rows)
                factor[slices[k], slices[m]] = crossed[np.ix_(places[k], places[m])] / count
        factor[np.arange(unknowns), np.arange(unknowns)] += ridge
        largest = largest_eigenvalue(factor) if refine else 0.0
        with one_thread():
            factor = np.asarray(np.linalg.cholesky(factor), np.float64)
        solution = substitute(factor, right)
        if not np.isfinite(solution).all():
            raise ValueError("the samples or their weights are not finite")
        if refine:
            condition = float(np.sqrt(largest * largest_of_inverse(factor)))
    else:
        solution = np.zeros_like(right)
    gradient, steps = 0.0, 0
    if refine or factor is None:
        problem = _Problem(terms, places, slices, target)
        solution, gradient, steps = _conjugate_gradients(problem, solution, factor, diagonal + ridge)
    textures = [_fill(one, place, solution[part]) for one, place, part in zip(terms, places, slices, strict=True)]
    return Fit(tuple(_gauge(terms, textures)), condition, gradient, unknowns, steps)


class _Problem(NamedTuple):
    """The terms, the texels of each that are unknown, where those lie among all unknowns, and the target."""

    terms: Sequence[Term]
    places: Sequence[NDArray[np.intp]]
    slices: Sequence[slice]
    target: Floats

    def forwards(self, unknowns: Floats) -> tuple[Floats, list[Floats]]:
        """B y (N, 3) without the root of N, and L y of each term."""
        values, differences = np.zeros_like(self.target), []
        for one, place, part in zip(self.terms, self.places, self.slices, strict=True):
            texture = np.zeros((len(one.reached), 3))
            texture[place] = unknowns[part]
            values += predict(one.rows, texture)
            differences.append(predict(one.smoothing, texture))
        return values, differences

    def backwards(self, values: Floats, differences: Sequence[Floats]) -> Floats:
        """Bᵀ v / N + Lᵀ d over the unknowns."""
        parts = []
        for one, place, difference in zip(self.terms, self.places, differences, strict=True):
            both = moments(one.rows, values) / len(values) + moments(one.smoothing, difference)
            parts.append(both[place])
        return np.concatenate(parts)


def _conjugate_gradients(
    problem: _Problem, solution: Floats, factor: Floats | None, diagonal: Floats
) -> tuple[Floats, float, int]:
    """CGLS from `solution`, preconditioned by the factor or the diagonal: (y, relative gradient, steps)."""
    values, differences = problem.forwards(solution)
    residual, bent = problem.target - values, [-difference for difference in differences]
    zeros = [np.zeros_like(difference) for difference in differences]
    scale = float(np.sqrt(diagonal.max()) * np.sqrt(_squares(problem.target).sum() / len(problem.target)))
    first = float(np.sqrt(_squares(problem.backwards(problem.target, zeros)).sum()))
    best, best_size, steps = solution, np.inf, 0
    direction, before = np.zeros_like(solution), np.ones(3)
    for steps in range(REFINEMENTS if factor is not None else DIAGONAL_STEPS):
        gradient = problem.backwards(residual, bent)
        size = float(np.sqrt(_squares(gradient).sum()))
        if size < best_size:
            best, best_size = solution.copy(), size
        if size <= GRADIENT * first:
            break
        steered = substitute(factor, gradient) if factor is not None else gradient / diagonal[:, None]
        energy = np.einsum("ij,ij->j", gradient, steered)
        direction = steered + (energy / before) * direction if steps else steered
        before = np.where(energy > 0.0, energy, 1.0)
        moved, bending = problem.forwards(direction)
        length = _squares(moved) / len(moved) + sum(_squares(bend) for bend in bending)
        step = np.where(length > 0.0, energy / np.where(length > 0.0, length, 1.0), 0.0)
        solution = solution + step * direction
        residual = residual - step * moved
        bent = [bend - step * bending_part for bend, bending_part in zip(bent, bending, strict=True)]
    return best, best_size / scale if scale > 0.0 else 0.0, steps


def _squares(values: Floats) -> Floats:
    """Sums of squares (3,) of the columns, in one order."""
    return np.asarray(np.einsum("ij,ij->j", values, values))


def _fill(one: Term, place: NDArray[np.intp], values: Floats) -> Floats:
    """The texture (T, 3): `values` at the unknowns, means of the eight neighbours elsewhere in the mask, 0 outside."""
    texture = np.zeros((len(one.reached), 3))
    texture[place] = values
    free = np.flatnonzero(one.mask & ~one.reached)
    if not len(free):
        return texture
    size = one.rows.size
    number = np.full(len(texture), -1)
    number[free] = np.arange(len(free))
    inside = np.pad(one.mask.reshape(size, size), 1)
    row, column = np.divmod(free, size)
    right, degree, entries = np.zeros((len(free), 3)), np.zeros(len(free)), []
    for down, across in ((-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1)):
        present = inside[row + 1 + down, column + 1 + across]
        neighbour = np.where(present, (row + down) * size + column + across, 0)
        degree += present
        known = present & one.reached[neighbour]
        right[known] += texture[neighbour[known]]
        open_ = np.flatnonzero(present & ~one.reached[neighbour])
        entries.append((open_, number[neighbour[open_]]))
    rows = np.concatenate([np.arange(len(free)), *(pair[0] for pair in entries)])
    columns = np.concatenate([np.arange(len(free)), *(pair[1] for pair in entries)])
    laplacian = csr_array((np.concatenate([degree, -np.ones(len(rows) - len(free))]), (rows, columns)))
    texture[free] = splu(laplacian.tocsc()).solve(right)
    return texture


def _gauge(terms: Sequence[Term], textures: Sequence[Floats]) -> list[Floats]:
    """The textures (n, n, 3) with a mean of 0 over the touched texels in all but the first, which takes the means."""
    first = textures[0].copy()
    gauged = []
    for one, texture in zip(terms[1:], textures[1:], strict=True):
        mean = texture[one.reached].mean(axis=0)
        moved = texture.copy()
        moved[one.mask] -= mean
        gauged.append(moved)
        first[terms[0].mask] += mean * (one.rows.texel.shape[1] / terms[0].rows.texel.shape[1])
    return [
        texture.reshape(one.rows.size, one.rows.size, 3) for one, texture in zip(terms, [first, *gauged], strict=True)
    ]

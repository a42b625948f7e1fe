"""The leading terms of a matrix, M ≈ Σ left_k value_k right_kᵀ, by three methods that reach the Eckart–Young optimum.

    symmetric   eigenvectors of a symmetric matrix; left and right differ by sign at most
    svd         singular vectors of any matrix
    power       the power iteration of Wang2004 Appendix, on a block of vectors and on MᵀM

The paper iterates one vector on M until its Rayleigh quotient rests. With eigenvalues λ and −λ that never happens, or
happens anywhere; and where M is not symmetric it removes nothing. A block of twice as many vectors, made orthonormal
after each product with MᵀM and rotated onto its Ritz vectors, converges through equal and opposite eigenvalues, and
what is watched is the residual ‖Mᵀu − σv‖. (The paper also prints S = D² for S = |D|.)

Large matrices are looked at in block Krylov spaces of MᵀM (Musco2015), each begun with the best vectors of
the one before. A block that is wider than a cluster of values converges through it, however small the gaps within;
single vectors, as in ARPACK, can be kept busy by it for ever. What is found is the start of the block above. If that
does not come to rest, because more values crowd together than the block is wide, LAPACK finds the terms of a matrix
of up to 2,304 rows or columns (5 s); of a larger one the best so far is given, and said. The work is bounded for every
matrix. A residual of 5e-7 of what remains unexplained bounds the loss against the optimum by 1e-6, also where
eigenvalues crowd together. The matrix is first scaled by a power of two, which changes no digit, so that the result
does not depend on the unit of M. The same seed gives the same bits on any number of threads, because the libraries of
linear algebra, which add in another order on each, are held to one; independent matrices may be decomposed at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from engine.core.one_thread import one_thread

Floats = NDArray[np.float64]

#: Least relative asymmetry ‖M − Mᵀ‖/‖M‖ at which a matrix no longer counts as symmetric.
ASYMMETRY = 1e-12

#: Terms with |value| below this fraction of ‖M‖ are rounding and are dropped.
ROUNDING = 64 * 2.0**-53

#: The residual at which a block rests, relative to the root of the energy that its terms do not hold.
RESIDUAL = 5e-7

#: Iterations after which a block gives up and says so.
MAX_ITERATIONS = 300

#: Up to this many rows or columns LAPACK finds all terms in less time than an iteration takes to converge.
DENSE = 200

#: Up to this many rows or columns LAPACK finds them where an iteration does not: maps of 48² texels.
MAX_DENSE = 2304

#: Vectors in a block beyond the terms, products with MᵀM in a Krylov space, and spaces one after the other.
SPARE, DEPTH, MAX_SPACES = 8, 6, 12


@dataclass(frozen=True, eq=False)
class Decomposition:
    """M ≈ left · diag(value) · rightᵀ.

    Attributes
    ----------
    left (m, K), right (n, K) : orthonormal columns; those of dropped terms are 0.
    value (K,) : σ ≥ 0, falling; 0 where a term is dropped. For a symmetric M, left = ±right.
    norm : Frobenius norm of M.
    iterations, converged : of the iteration; 1 and True where LAPACK did it.
    """

    left: Floats
    value: Floats
    right: Floats
    norm: float
    iterations: int = 1
    converged: bool = True

    @property
    def rank(self) -> int:
        """Number of terms that were not dropped."""
        return int(np.count_nonzero(self.value))


Method = Callable[[Floats, int, int], Decomposition]


def asymmetry(matrix: Floats) -> float:
    """‖M − Mᵀ‖/‖M‖ in Frobenius norms, in [0, 2]; infinite where M is not square, 0 for the zero matrix."""
    if matrix.shape[0] != matrix.shape[1]:
        return math.inf
    largest = float(np.abs(matrix).max(initial=0.0))
    if largest == 0.0:
        return 0.0
    scaled = matrix / largest
    return float(np.linalg.norm(scaled - scaled.T) / np.linalg.norm(scaled))


def symmetric(matrix: Floats, terms: int, seed: int = 1) -> Decomposition:
    """By eigenvectors; ValueError where the asymmetry exceeds `ASYMMETRY`, entries are not finite or `terms` < 1."""
    _check_symmetric(matrix)
    return _scale(matrix, terms, lambda scaled: _symmetric(scaled, terms, seed))


def svd(matrix: Floats, terms: int, seed: int = 1) -> Decomposition:
    """By singular vectors; ValueError where entries are not finite or `terms` < 1."""
    return _scale(matrix, terms, lambda scaled: _svd(scaled, terms, seed))


def power(
    matrix: Floats,
    terms: int,
    seed: int = 1,
    *,
    start: Floats | None = None,
    max_iterations: int = MAX_ITERATIONS,
) -> Decomposition:
    """By block power iteration, from the columns of `start` (n, any) and random ones.

    Gives the best so far with `converged` False where `max_iterations` do not suffice. Raises ValueError as `svd`.
    """
    return _scale(matrix, terms, lambda scaled: _block(scaled, terms, seed, start, max_iterations))


def _check_symmetric(matrix: Floats) -> None:
    _check(matrix, 1)
    alpha = asymmetry(matrix)
    if not alpha <= ASYMMETRY:
        raise ValueError(f"the matrix is not symmetric: its asymmetry is {alpha:.3g}")


def _check(matrix: Floats, terms: int) -> None:
    if matrix.ndim != 2 or not matrix.size or terms < 1:
        raise ValueError(f"{terms} terms of a matrix of shape {matrix.shape}")
    if not np.isfinite(matrix).all():
        row, column = np.argwhere(~np.isfinite(matrix))[0]
        raise ValueError(f"the entry in row {row}, column {column} is not a finite number")


def _scale(matrix: Floats, terms: int, method: Callable[[Floats], Decomposition]) -> Decomposition:
    """Run `method` on M/2ᵉ with entries below 1, drop what is rounding, fill up to `terms`, and scale back."""
    matrix = np.asarray(matrix, np.float64)
    _check(matrix, terms)
    largest = float(np.abs(matrix).max())
    if largest == 0.0:
        return Decomposition(np.zeros((len(matrix), terms)), np.zeros(terms), np.zeros((matrix.shape[1], terms)), 0.0)
    exponent = math.frexp(largest)[1]
    with one_thread():
        found = method(np.ldexp(matrix, -exponent))
    kept = int((found.value > ROUNDING * found.norm).sum())
    left, right = (np.zeros((len(side), terms)) for side in (found.left, found.right))
    value = np.zeros(terms)
    # in place of a sign that each method leaves to chance: the largest entry of every right vector is positive
    sign = np.where(np.take_along_axis(found.right, np.abs(found.right).argmax(axis=0)[None], 0)[0] < 0.0, -1.0, 1.0)
    left[:, :kept], right[:, :kept] = (found.left * sign)[:, :kept], (found.right * sign)[:, :kept]
    value[:kept] = np.ldexp(found.value[:kept], exponent)
    return Decomposition(left, value, right, math.ldexp(found.norm, exponent), found.iterations, found.converged)


def _fix_signs(vectors: Floats, values: Floats, terms: int, norm: float) -> Decomposition:
    order = np.argsort(-np.abs(values), kind="stable")[:terms]
    right = vectors[:, order]
    return Decomposition(right * np.where(values[order] < 0.0, -1.0, 1.0), np.abs(values[order]), right, norm)


def _symmetric(matrix: Floats, terms: int, seed: int) -> Decomposition:
    if len(matrix) <= DENSE or 4 * terms >= len(matrix):
        values, vectors = np.linalg.eigh(matrix)
        return _fix_signs(vectors, values, terms, float(np.linalg.norm(matrix)))
    return _large(matrix, terms, seed)


def _svd(matrix: Floats, terms: int, seed: int) -> Decomposition:
    if min(matrix.shape) <= DENSE or 4 * terms >= min(matrix.shape):
        left, value, right = np.linalg.svd(matrix, full_matrices=False)
        return Decomposition(left[:, :terms], value[:terms], right[:terms].T, float(np.linalg.norm(matrix)))
    return _large(matrix, terms, seed)


def _large(matrix: Floats, terms: int, seed: int) -> Decomposition:
    """By an iteration, and by LAPACK where that does not come to rest."""
    found = _block(matrix, terms, seed, _krylov(matrix, terms, seed), MAX_ITERATIONS // 10)
    if found.converged or min(matrix.shape) > MAX_DENSE:
        return found
    return _block(matrix, terms, seed, _dense(matrix, terms), MAX_ITERATIONS // 10)


def _krylov(matrix: Floats, terms: int, seed: int) -> Floats:
    """Right vectors (n, terms + `SPARE`) that are near the leading ones, or as near as `MAX_SPACES` come."""
    norm, columns = float(np.linalg.norm(matrix)), matrix.shape[1]
    width = min(*matrix.shape, terms + SPARE)
    best, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(columns, width)))
    for _ in range(MAX_SPACES):
        space, product = best, matrix @ best
        for _ in range(min(DEPTH, columns // width - 1)):
            following = matrix.T @ product[:, -width:]
            for _ in range(3):  # what is left of a vector may be rounding, which is orthogonal to nothing
                following, _ = np.linalg.qr(following - space @ (space.T @ following))
            space = np.concatenate([space, following], axis=1)
            product = np.concatenate([product, matrix @ following], axis=1)
        left, value, rotation = np.linalg.svd(product, full_matrices=False)
        best = space @ rotation[:width].T
        residual = np.linalg.norm(matrix.T @ left[:, :terms] - best[:, :terms] * value[:terms])
        if residual <= RESIDUAL * math.sqrt(max(norm**2 - float((value[:terms] ** 2).sum()), 0.0)):
            break
    return best


def _dense(matrix: Floats, terms: int) -> Floats:
    """Right vectors (n, terms + `SPARE`) by LAPACK: from MᵀM, or from MMᵀ where that is smaller.

    Of a symmetric M they are its own eigenvectors. In MᵀM those of λ and −λ are one cluster; where it is wider than
    what is taken of it, no part of it is a space that M maps onto itself.
    """
    taken = min(*matrix.shape, terms + SPARE)
    if _is_symmetric(matrix):
        values, vectors = eigh(matrix)
        return np.asarray(vectors[:, np.argsort(-np.abs(values), kind="stable")[:taken]])
    wide = matrix.shape[1] > matrix.shape[0]
    gram = matrix @ matrix.T if wide else matrix.T @ matrix
    _, vectors = eigh(gram, subset_by_index=(len(gram) - taken, len(gram) - 1))
    return np.asarray(matrix.T @ vectors[:, ::-1] if wide else vectors[:, ::-1])


def _is_symmetric(matrix: Floats) -> bool:
    return bool(np.array_equal(matrix, matrix.T)) or asymmetry(matrix) <= ASYMMETRY


def _block(
    matrix: Floats, terms: int, seed: int, start: Floats | None = None, max_iterations: int = MAX_ITERATIONS
) -> Decomposition:
    """Subspace iteration on MᵀM with Rayleigh–Ritz steps; for a symmetric M the Ritz vectors are M's own."""
    own = _is_symmetric(matrix)
    norm = float(np.linalg.norm(matrix))
    columns = matrix.shape[1]
    width = min(min(matrix.shape), terms + max(8, terms // 2 if start is not None else terms))
    block = np.random.default_rng(seed).normal(size=(columns, width))
    if start is not None:
        given = start[:, : width - min(8, width - 1)] if start.shape[1] >= width else start
        block[:, : given.shape[1]] = given
    block, _ = np.linalg.qr(block)
    floor = 16.0 * max(matrix.shape) * 2.0**-53 * norm
    product = matrix @ block
    for iteration in range(1, max_iterations + 1):
        block, _ = np.linalg.qr(matrix.T @ product)
        product = matrix @ block
        found, residual = _ritz(matrix, block, product, terms, norm, own)
        rest = math.sqrt(max(norm**2 - float((found.value**2).sum()), 0.0))
        if iteration > 2 and residual <= max(RESIDUAL * rest, floor):
            break
    else:
        return Decomposition(found.left, found.value, found.right, norm, max_iterations, False)
    return Decomposition(found.left, found.value, found.right, norm, iteration)


def _ritz(
    matrix: Floats, block: Floats, product: Floats, terms: int, norm: float, own: bool
) -> tuple[Decomposition, float]:
    """The best terms within the span of `block`, whose `product` with M is given, and the norm of their residual."""
    if own:
        values, rotation = np.linalg.eigh(block.T @ product)
        order = np.argsort(-np.abs(values), kind="stable")[:terms]
        right, image = block @ rotation[:, order], product @ rotation[:, order]
        residual = float(np.linalg.norm(image - right * values[order]))
        return _fix_signs(right, values[order], terms, norm), residual
    left, value, rotation = np.linalg.svd(product, full_matrices=False)
    right = block @ rotation[:terms].T
    left, value = left[:, :terms], value[:terms]
    residual = float(np.linalg.norm(matrix.T @ left - right * value))
    return Decomposition(left, value, right, norm), residual


def condition_number(value: Floats) -> float:
    """Largest over smallest of the values that were kept; 1 where there are none."""
    kept = value[value > 0.0]
    return float(kept.max() / kept.min()) if len(kept) else 1.0

"""Non-negative terms: against alternating NNLS, against what the singular values allow, and cases known by hand."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import nnls

from engine.brdf.brdf import brdf_from_text
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.solvers.nonnegative import Nonnegative, nonnegative
from engine.factor.solvers.svd import svd

Array = NDArray[np.float64]


def product(found: Nonnegative) -> Array:
    return np.asarray((found.left * found.value) @ found.right.T)


def lobes(count: int = 60) -> Array:
    """A diffuse floor and a highlight along the diagonal, as in a glossy BRDF."""
    x = np.linspace(-1.0, 1.0, count)
    return np.asarray(0.2 + np.exp(-((x[:, None] + x[None]) ** 2) / 0.02) * (1.0 + x[None] ** 2))


@pytest.mark.parametrize("terms", [1, 3, 6])
def test_a_matrix_of_positive_terms_is_found(terms: int) -> None:
    random = np.random.default_rng(2)
    matrix = random.random((40, terms)) ** 4 @ random.random((30, terms)).T ** 4
    found = nonnegative(matrix, terms, 1)
    assert np.linalg.norm(matrix - product(found)) < 0.02 * np.linalg.norm(matrix)
    assert found.error == pytest.approx(
        np.linalg.norm(matrix - product(found)), abs=1e-6 * float(np.linalg.norm(matrix))
    )


def alternate(matrix: Array, terms: int) -> Array:
    """The best of some starts of alternating non-negative least squares, row by row by an active set."""
    products = []
    for seed in range(3):
        right = np.random.default_rng(seed).random((matrix.shape[1], terms))
        for _ in range(40):
            left = np.array([nnls(right, row)[0] for row in matrix])
            right = np.array([nnls(left, column)[0] for column in matrix.T])
        products.append(left @ right.T)
    return min(products, key=lambda each: float(np.linalg.norm(matrix - each)))


@pytest.mark.parametrize("terms", [2, 5])
@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_no_worse_than_alternating_least_squares(terms: int, scale: float) -> None:
    """Both end in local minima."""
    matrix = lobes(30)
    found = nonnegative(scale * matrix, terms, 1)
    ours = np.linalg.norm(scale * matrix - product(found)) / scale
    assert ours < 1.02 * np.linalg.norm(matrix - alternate(matrix, terms))
    assert ours >= found.optimum / scale * (1.0 - 1e-9)
    assert found.optimum / scale == pytest.approx(np.sqrt((np.linalg.svd(matrix)[1][terms:] ** 2).sum()), rel=1e-6)


def test_terms_are_positive_of_unit_length_and_fall() -> None:
    found = nonnegative(lobes(), 7, 3)
    assert (found.left > 0.0).all()
    assert (found.right > 0.0).all()
    np.testing.assert_allclose(np.linalg.norm(found.left, axis=0), 1.0)
    np.testing.assert_allclose(np.linalg.norm(found.right, axis=0), 1.0)
    assert (np.diff(found.value) <= 0.0).all()


def test_equal_seeds_give_equal_bits() -> None:
    one, two = (nonnegative(lobes(), 4, 5) for _ in range(2))
    assert np.array_equal(product(one), product(two))


@pytest.mark.parametrize("matrix", [np.zeros((5, 4)), np.full((5, 4), -1.0), np.ones((1, 1)), np.eye(6) * 1e-300])
def test_matrices_at_the_ends_give_finite_terms(matrix: Array) -> None:
    found = nonnegative(matrix, 1, 1)
    assert all(np.isfinite(part).all() for part in (found.left, found.right, found.value, found.error))
    assert np.linalg.norm(product(found) - np.maximum(matrix, 0.0)) <= np.linalg.norm(np.maximum(matrix, 0.0)) + 1e-12


@pytest.mark.parametrize(("terms", "times"), [(4, 1.9), (16, 4.0)])
def test_positive_terms_of_a_brushed_highlight_are_nearer_in_the_dark_at_little_cost(terms: int, times: float) -> None:
    """As many signed terms are the best in squares, and below 0 at a fifth of the pairs, which have no logarithm."""
    directions = HemisphereMap("orthographic", 24).directions
    brdf = brdf_from_text("ashikhmin-shirley:kd=0.4,ks=0.7,nu=12,nv=120")
    matrix = brdf.f(directions[None], directions[:, None])[..., 1]
    floor = 1e-3 * matrix.mean()
    errors = []
    for found in (svd(matrix, terms, 1), nonnegative(matrix, terms, 1)):
        shown = (found.left * found.value) @ found.right.T
        log = np.log(np.maximum(shown, 0.0) + floor) - np.log(matrix + floor)
        errors.append((np.linalg.norm(shown - matrix), np.mean(log**2), np.mean(shown < 0.0)))
    (least, signed_log, below), (norm, log, none) = errors
    assert least < norm <= 1.07 * least
    assert log * times <= signed_log
    assert below > 0.2
    assert none == 0.0

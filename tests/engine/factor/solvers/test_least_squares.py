"""Textures from samples: cases solved by hand, numpy's dense least squares, scipy's LSQR, and what cannot be solved."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest
from scipy.sparse.linalg import lsqr

from engine.factor.projections import DIFFERENCE, FIRST, HALF, SUM, look_ups, points_of
from engine.factor.solvers import least_squares
from engine.factor.solvers.least_squares import solve, term
from engine.factor.solvers.least_squares_rows import Rows, predict, rows_of
from tests.engine.factor.test_projections import hemisphere

U = 2.0**-53


def dense(rows: Rows) -> np.ndarray:
    """B (N, T) of one texture."""
    matrix = np.zeros((len(rows.texel), rows.size**2))
    for e in range(rows.texel.shape[1]):
        np.add.at(matrix, (np.arange(len(matrix)), rows.texel[:, e]), rows.weight[:, e])
    return matrix


def grid(size: int) -> np.ndarray:
    """Coordinates (size², 2) of all texels."""
    axis = np.linspace(-1.0, 1.0, size)
    return np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)


def everywhere(size: int) -> np.ndarray:
    return np.ones((size, size), bool)


def problem(count: int, size: int, smoothing: float, seed: int = 0) -> tuple[list, np.ndarray]:
    """Two terms of random pairs, their values those of two rough textures and noise."""
    rng = np.random.default_rng(seed)
    points = points_of(hemisphere(count, seed + 1), hemisphere(count, seed + 2), "in-out")
    target = np.zeros((count, 3))
    rows = [rows_of(look_ups(projection, points, "in-out", True), size) for projection in (SUM, DIFFERENCE)]
    for one in rows:
        target += predict(one, rng.normal(size=(size, size, 3)))
    target += 0.1 * rng.normal(size=target.shape)
    return [term(one, target, np.zeros((size, size), bool), smoothing) for one in rows], target


def test_L9_one_sample_is_met() -> None:
    rows = rows_of([np.array([[0.2, -0.4]])], 4)
    target = np.array([[1.0, -2.0, 0.5]])
    fit = solve([term(rows, target, everywhere(4), 1e-3)], target, refine=True)
    np.testing.assert_allclose(predict(rows, fit.textures[0]), target, atol=1e-9)
    assert np.isfinite(fit.textures[0]).all()


def test_L10_samples_that_contradict_each_other_are_met_at_their_mean() -> None:
    rows = rows_of([np.repeat([[0.5, 0.5], [-0.5, 0.1]], 2, axis=0)], 3)
    target = np.array([[1.0, 2.0, 3.0], [3.0, 2.0, 1.0], [0.0, 0.0, 0.0], [0.0, 0.0, 6.0]])
    fit = solve([term(rows, target, everywhere(3), 1e-9)], target, refine=True)
    expected = [[2.0, 2.0, 2.0]] * 2 + [[0.0, 0.0, 3.0]] * 2
    np.testing.assert_allclose(predict(rows, fit.textures[0]), expected, atol=1e-6)


def test_L11_a_texture_is_found_again_at_its_texels() -> None:
    size = 6
    texture = np.random.default_rng(0).normal(size=(size, size, 3))
    rows = rows_of([grid(size)], size)
    target = texture.reshape(-1, 3)
    fit = solve([term(rows, target, everywhere(size), 0.0)], target, refine=True)
    np.testing.assert_allclose(fit.textures[0], texture, rtol=1e-8)


def test_L12_weights_sum_to_one_and_the_last_texel_stays_inside() -> None:
    rng = np.random.default_rng(1)
    coordinates = np.concatenate([rng.uniform(-1.0, 1.0, (1000, 2)), [[1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]])
    for size in (2, 3, 16, 17):
        rows = rows_of([coordinates], size)
        assert np.abs(rows.weight.sum(axis=1) - 1.0).max() <= 2.0 * U
        assert (rows.weight >= 0.0).all()
        assert (rows.texel >= 0).all()
        assert (rows.texel < size**2).all()
        for row, texel in ((-3, size**2 - 1), (-2, 0), (-1, size - 1)):
            assert rows.texel[row, rows.weight[row] == 1.0] == [texel]
    beyond = rows_of([np.array([[1.0 + 1e-12, -3.0]])], 5)
    np.testing.assert_allclose(dense(beyond)[0, 4], 1.0)


def test_bilinear_weights_by_hand() -> None:
    """Size 3 has texels at −1, 0, 1: (0.5, −0.75) is halfway between columns 1 and 2, a quarter above row 0."""
    rows = rows_of([np.array([[0.5, -0.75]])], 3)
    np.testing.assert_array_equal(rows.texel[0], [1, 2, 4, 5])
    np.testing.assert_allclose(rows.weight[0], [0.375, 0.375, 0.125, 0.125])


def test_L5_texels_without_samples_are_refused_or_filled_within_their_neighbours() -> None:
    rng = np.random.default_rng(2)
    coordinates = rng.uniform(-1.0, 1.0, (4000, 2))
    coordinates = coordinates[(np.abs(coordinates) > 0.5).any(axis=1) & (coordinates.sum(axis=1) < 1.2)]
    target = np.column_stack([coordinates, coordinates[:, 0] * coordinates[:, 1]]) * 5.0
    rows, size = rows_of([coordinates], 12), 12
    with pytest.raises(ValueError, match="texels have no sample"):
        term(rows, target, everywhere(size), 0.0)
    one = term(rows, target, everywhere(size), 1e-4)
    fit = solve([one], target, refine=True)
    assert 0.0 < fit.condition_number < 1e6
    flat = fit.textures[0].reshape(-1, 3)
    assert (~one.reached).sum() > 10
    assert (flat[~one.reached].max(axis=0) <= flat[one.reached].max(axis=0)).all()
    assert (flat[~one.reached].min(axis=0) >= flat[one.reached].min(axis=0)).all()
    inner = (~one.reached).reshape(size, size)[1:-1, 1:-1]
    neighbours = cast(
        Any, sum(np.roll(fit.textures[0], (a, b), (0, 1)) for a in (-1, 0, 1) for b in (-1, 0, 1) if a or b)
    )[1:-1, 1:-1]
    np.testing.assert_allclose(fit.textures[0][1:-1, 1:-1][inner], neighbours[inner] / 8.0, atol=1e-12)


def test_L5_smoothing_makes_the_further_rows_regular() -> None:
    terms, _ = problem(300, 8, 1e-3)
    for one in terms:
        place = np.flatnonzero(one.reached)
        augmented = one.gram[np.ix_(place, place)]
        eigenvalues = np.linalg.eigvalsh(
            augmented + least_squares.RIDGE * augmented.diagonal().mean() * np.eye(len(place))
        )
        assert eigenvalues[0] > 0.0


def test_L6_strong_smoothing_leaves_a_plane_and_weak_smoothing_interpolates() -> None:
    rng = np.random.default_rng(3)
    coordinates = rng.uniform(-1.0, 1.0, (400, 2))
    target = rng.normal(size=(400, 3)) + coordinates @ rng.normal(size=(2, 3))
    rows = rows_of([coordinates], 5)
    fit = solve([term(rows, target, everywhere(5), 1e9)], target, refine=True)
    basis = np.column_stack([np.ones(400), coordinates])
    plane = basis @ np.linalg.lstsq(basis, target, rcond=None)[0]
    np.testing.assert_allclose(predict(rows, fit.textures[0]), plane, atol=1e-6)
    few = rows_of([coordinates[:8]], 9)
    fit = solve([term(few, target[:8], everywhere(9), 1e-9)], target[:8], refine=True)
    np.testing.assert_allclose(predict(few, fit.textures[0]), target[:8], atol=1e-5)


def test_L7_gauges_differ_in_the_textures_and_not_in_their_sum() -> None:
    """The shortest solution, numpy's, and ours, whose second texture has the mean 0, predict the same."""
    terms, target = problem(3000, 6, 0.0)
    fit = solve(terms, target, refine=True)
    together = np.hstack([dense(one.rows) for one in terms])
    shortest = np.linalg.lstsq(together, target, rcond=1e-12)[0]
    ours = sum(predict(one.rows, texture) for one, texture in zip(terms, fit.textures, strict=True))
    np.testing.assert_allclose(ours, together @ shortest, atol=1e-10 * np.abs(target).max())
    assert np.abs(fit.textures[1].reshape(-1, 3)[terms[1].reached].mean(axis=0)).max() <= 1e-14
    assert np.linalg.matrix_rank(together) < sum(int(one.reached.sum()) for one in terms)


@pytest.mark.parametrize("smoothing", [0.0, 1e-6, 1e-2])
def test_X11_L8_the_gradient_ends_at_rounding(smoothing: float) -> None:
    terms, target = problem(3000, 6, smoothing)
    fit = solve(terms, target, refine=True)
    stacked = np.hstack([dense(one.rows) for one in terms]) / np.sqrt(len(target))
    bends = [dense(one.smoothing) for one in terms]
    zeros = [[np.zeros((len(bend), 36)) for _ in terms] for bend in bends]
    for k, bend in enumerate(bends):
        zeros[k][k] = bend
    full = np.vstack([stacked, *(np.hstack(blocks) for blocks in zeros)])
    right = np.vstack([target / np.sqrt(len(target)), np.zeros((len(full) - len(target), 3))])
    y = np.concatenate([texture.reshape(-1, 3) for texture in fit.textures])
    gradient = np.linalg.norm(full.T @ (full @ y - right))
    assert gradient <= 1e-10 * np.linalg.norm(full, 2) * np.linalg.norm(right)
    assert fit.gradient <= 1e-10


def test_X11_agrees_with_lsqr_where_normal_equations_lose_their_digits() -> None:
    """Columns scaled so that κ(B) = 1e6: κ(BᵀB) = 1e12 costs a plain solve half of its digits, and us none."""
    rng = np.random.default_rng(4)
    coordinates = rng.uniform(-1.0, 1.0, (600, 2)) * [1.0, 0.5]
    rows = rows_of([coordinates], 6)
    rows = Rows(rows.texel, rows.weight * np.where(coordinates[:, :1] > 0.4, 1e-6, 1.0), 6)
    target = rng.normal(size=(600, 3)) * np.where(coordinates[:, :1] > 0.4, 1e-6, 1.0)
    fit = solve([term(rows, target, everywhere(6), 1e-3)], target, refine=True)
    bend = term(rows, target, everywhere(6), 1e-3).smoothing
    full = np.vstack([dense(rows) / np.sqrt(600.0), dense(bend)])
    right = np.vstack([target / np.sqrt(600.0), np.zeros((len(bend.texel), 3))])
    used = np.abs(full).sum(axis=0) > 0.0
    for channel in range(3):
        expected = lsqr(full[:, used], right[:, channel], atol=1e-15, btol=1e-15, iter_lim=20_000)[0]
        best = np.linalg.norm(full[:, used] @ expected - right[:, channel])
        ours = np.linalg.norm(full[:, used] @ fit.textures[0].reshape(-1, 3)[used, channel] - right[:, channel])
        assert ours <= best * (1.0 + 1e-9)


def test_many_unknowns_go_without_a_factor_and_come_to_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    terms, target = problem(3000, 6, 1e-2)
    with_factor = solve(terms, target, refine=True)
    monkeypatch.setattr(least_squares, "DENSE_LIMIT", 10)
    without = solve(terms, target)
    for one, k in zip(terms, range(2), strict=True):
        np.testing.assert_allclose(
            sum(predict(each.rows, texture) for each, texture in zip(terms, without.textures, strict=True)),
            sum(predict(each.rows, texture) for each, texture in zip(terms, with_factor.textures, strict=True)),
            atol=1e-6,
        )
        assert without.textures[k].shape == (one.rows.size, one.rows.size, 3)
    assert without.steps > with_factor.steps


def test_the_condition_number_is_that_of_the_matrix() -> None:
    points = points_of(hemisphere(3000, 5), hemisphere(3000, 6), "in-out")
    rows = rows_of(look_ups(HALF, points, "in-out", True), 8)
    target = np.random.default_rng(5).normal(size=(3000, 3))
    one = term(rows, target, HALF.mask(8), 1e-2)
    place = np.flatnonzero(one.reached)
    gram = one.gram[np.ix_(place, place)]
    gram += least_squares.RIDGE * gram.diagonal().mean() * np.eye(len(place))
    expected = np.sqrt(np.linalg.cond(gram))
    assert 0.8 * expected <= solve([one], target, refine=True).condition_number <= 1.0001 * expected


def test_what_is_not_finite_is_refused() -> None:
    points = points_of(hemisphere(100, 7), hemisphere(100, 8), "in-out")
    rows = rows_of(look_ups(FIRST, points, "in-out", False), 4)
    rows.weight[3] = np.nan
    with pytest.raises(ValueError, match="not finite"):
        solve([term(rows, np.ones((100, 3)), FIRST.mask(4), 1e-3)], np.ones((100, 3)))
    with pytest.raises(ValueError, match="2 texels"):
        rows_of([np.zeros((1, 2))], 1)

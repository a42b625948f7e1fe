"""Heights from slopes against surfaces that are known, and laws of the weights."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import lsqr

from engine.core.steps import drain
from engine.surface import height as heights
from engine.surface.depth_edges import Division
from engine.surface.height import (
    _bound,
    _divergence,
    _solve_evenly,
    disagreement,
    height_deviation,
    height_from_slopes,
)


def slopes(height: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Central differences, x to the right and y up."""
    return np.gradient(height, axis=1), -np.gradient(height, axis=0)


def test_weighted_slopes_give_the_least_squares_height() -> None:
    """The same sum of squares minimised by a general solver."""
    rng = np.random.default_rng(3)
    rows, columns = 9, 12
    right, up = rng.standard_normal((2, rows, columns))
    variance = rng.uniform(0.5, 2.0, (rows, columns))
    ours = drain(height_from_slopes(right, up, variance))
    place = np.arange(rows * columns).reshape(rows, columns)
    pairs = [(place[r, c], place[r, c + 1], (r, c), (r, c + 1)) for r in range(rows) for c in range(columns - 1)]
    pairs += [(place[r, c], place[r + 1, c], (r, c), (r + 1, c)) for r in range(rows - 1) for c in range(columns)]
    matrix, wanted = sparse.lil_matrix((len(pairs), rows * columns)), np.empty(len(pairs))
    for line, (one, other, first, second) in enumerate(pairs):
        weight = np.sqrt(4.0 / (variance[first] + variance[second]))
        slope = 0.5 * (right[first] + right[second]) if first[0] == second[0] else -0.5 * (up[first] + up[second])
        matrix[line, one], matrix[line, other], wanted[line] = -weight, weight, weight * slope
    theirs = lsqr(matrix.tocsr(), wanted, atol=1e-12, btol=1e-12)[0].reshape(rows, columns)
    np.testing.assert_allclose(ours, theirs - theirs.mean(), atol=1e-3)


@pytest.mark.parametrize("block", [1, 5, 1024])
def test_a_flow_without_weights_is_the_divergence_of_the_steps_of_its_height(
    block: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(heights, "BLOCK", block)
    flow = np.random.default_rng(5).standard_normal((9, 12))
    height = _solve_evenly(flow)
    np.testing.assert_allclose(
        _divergence(np.diff(height, axis=1), np.diff(height, axis=0)), flow - flow.mean(), atol=1e-12
    )


def test_slopes_that_are_not_known_do_not_count() -> None:
    row, column = np.mgrid[:64, :64]
    height = 3.0 * np.sin(row / 9.0) * np.cos(column / 7.0)
    right, up = slopes(height)
    variance = np.full(height.shape, 1e-4)
    right[20:24, 30:40], variance[20:24, 30:40] = 5.0, np.inf
    found = drain(height_from_slopes(right, up, variance))
    assert np.abs(found - (height - height.mean()))[40:].max() < 0.2
    even = drain(height_from_slopes(right, up, np.full(height.shape, 1e-4)))
    assert np.abs(even - (height - height.mean()))[40:].max() > 0.4


def test_broad_waves_are_found_through_weights_that_change_from_texel_to_texel() -> None:
    row, column = np.mgrid[:128, :128]
    height = 6.0 * np.cos(np.pi * row / 127.0) * np.cos(2.0 * np.pi * column / 127.0)
    variance = 1e-3 * np.exp(1.5 * np.random.default_rng(4).standard_normal(height.shape))
    solving, steps = height_from_slopes(*slopes(height), variance), 0
    while True:
        try:
            next(solving)
            steps += 1
        except StopIteration as ended:
            found = ended.value
            break
    assert np.abs(found - height + height.mean()).max() < 0.01 * np.ptp(height)
    assert steps < 60


def test_a_flat_surface_is_flat() -> None:
    flat = np.zeros((5, 7))
    assert not drain(height_from_slopes(flat, flat, np.ones((5, 7)))).any()


def test_the_deviation_is_that_of_drawn_errors() -> None:
    rng = np.random.default_rng(5)
    variance = np.full((40, 40), 0.04)
    errors = 0.2 * rng.standard_normal((24, 2, 40, 40))
    drawn = [drain(height_from_slopes(right, up, variance)) for right, up in errors]
    stated = drain(height_deviation(variance))
    assert np.sqrt(np.mean(stated**2)) == pytest.approx(np.std(drawn), rel=0.35)


def test_slopes_of_no_height_disagree_and_noise_as_stated_does_not() -> None:
    rng = np.random.default_rng(6)
    right, up = 0.1 * rng.standard_normal((2, 96, 96))
    variance = np.full((96, 96), 0.01)
    height = drain(height_from_slopes(right, up, variance))
    assert np.median(disagreement(height, right, up, variance)[0]) < 1.25
    assert np.median(disagreement(height, right, up, variance / 16.0)[0]) > 4.0


def test_variances_of_nothing_but_zeros_stay_positive() -> None:
    """Their inverse is a weight."""
    bounded = _bound(np.zeros((2, 3)))
    assert (bounded > 0.0).all()
    assert np.isfinite(1.0 / bounded).all()


def test_steps_between_regions_leave_the_height_of_each_as_it_is() -> None:
    row, column = np.mgrid[:48, :64]
    height = 2.0 * np.sin(row / 9.0) + 0.1 * column
    out = np.hypot(column - 30, row - 24)
    division = Division(np.abs(out - 12.0) < 1.5, (out < 12.0).astype(np.int32))
    right, up = slopes(height)
    torn = right + 3.0 * division.edges * np.sign(column - 30)  # slopes on the border mean nothing
    variance = np.full(height.shape, 1e-4)
    found = drain(height_from_slopes(torn, up, variance, division))
    for each in range(2):
        inner = (division.region == each) & ~division.edges
        off = (found - height)[inner]
        assert np.abs(off - off.mean()).max() < 0.05
    assert np.abs((found - height) - (found - height).mean()).max() < 2.0  # regions lie on one level
    whole = drain(height_from_slopes(torn, up, variance))
    assert np.ptp((whole - height)[~division.edges]) > 0.3
    excess, off = disagreement(whole, torn, up, variance)
    assert (off[division.edges] > 0.2).mean() > 0.3
    assert np.median(disagreement(found, torn, up, variance, division)[0]) < 1.5 < np.median(excess)


def test_the_deviation_in_a_region_counts_from_its_own_mean() -> None:
    rng = np.random.default_rng(5)
    variance = np.full((40, 60), 0.04)
    division = Division(np.zeros((40, 60), np.bool_), np.zeros((40, 60), np.int32))
    division.edges[:, 39:42], division.region[:, 41:] = True, 1
    errors = 0.2 * rng.standard_normal((24, 2, 40, 60))
    drawn = np.array([drain(height_from_slopes(right, up, variance, division)) for right, up in errors])
    stated = drain(height_deviation(variance, division))
    assert np.isinf(stated[division.edges]).all()
    for part in (np.s_[:, :39], np.s_[:, 42:]):
        own = drawn[(slice(None), *part)]
        own = own - own.mean(axis=(1, 2), keepdims=True)
        assert np.sqrt(np.mean(stated[part] ** 2)) == pytest.approx(np.std(own), rel=0.35)

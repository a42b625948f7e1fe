"""The logarithm: there and back, its floor, and what has none. Data and errors against plain sums."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.brdf.brdf import brdf_from_text
from engine.brdf.samples import BrdfSamples
from engine.brdf.table import DirectionTable, HalfDifferenceTable
from engine.core.directions import surface_direction
from engine.factor.data import FactorData, factor_data
from engine.factor.errors import metrics, reference, rms_cosine_weighted
from engine.factor.homomorphic import LogSpace
from tests.engine.brdf.fitted import fit_scattered_brdf
from tests.engine.factor.factored import blue_paint

U = 2.0**-53


@pytest.mark.parametrize("epsilon", [1e-7, 1e-5, 1e-3])
def test_L1_L2_there_and_back(epsilon: float) -> None:
    """Rounding L itself to float64 costs |L| u of f + εA, which no formula can save; 4 u come on top."""
    space = LogSpace(np.array([0.01, 1.0, 300.0]), epsilon)
    value = np.concatenate([[0.0], np.logspace(-12, 8, 4001)])[:, None] * space.mean
    log = space.forward(value)
    allowed = (np.abs(log) + 4.0) * U * (value + epsilon * space.mean)
    assert (np.abs(space.backward(log) - value) <= allowed).all()
    np.testing.assert_allclose(log[0], np.log(epsilon), rtol=4.0 * U)


def test_X12_L1_leaving_epsilon_in_is_a_bias_of_exactly_epsilon_times_the_mean() -> None:
    space = LogSpace(np.full(3, 2.0), 1e-5)
    value = np.array([[0.002, 0.2, 20.0]])
    thesis = space.mean * np.exp(space.forward(value))
    np.testing.assert_allclose(thesis - value, 2e-5, rtol=1e-9)
    assert (thesis / value - 1.0)[0, 0] == pytest.approx(0.01, rel=1e-6)
    np.testing.assert_allclose(space.backward(space.forward(value)), value, rtol=1e-12)
    assert space.forward(np.zeros(3))[0] == pytest.approx(-11.5, abs=0.02)


def test_L3_black_has_no_logarithm_but_a_black_channel_comes_back_black() -> None:
    with pytest.raises(ValueError, match="0 everywhere"):
        LogSpace.of(np.zeros((5, 3)))
    value = np.array([[1.0, 0.0, 2.0], [3.0, 0.0, 0.0]])
    space = LogSpace.of(value)
    np.testing.assert_allclose(space.mean, [2.0, 1.0, 1.0])
    np.testing.assert_allclose(space.backward(space.forward(value)), value, atol=1e-19)
    for bad in ((np.array([1.0, np.nan, 1.0]), 1e-5), (np.ones(3), 0.0), (np.ones(2), 1e-5)):
        with pytest.raises(ValueError, match="must"):
            LogSpace(*bad)


@given(st.floats(-1e4, 1e4))
def test_L4_no_log_overflows(log: float) -> None:
    value = LogSpace(np.array([1e30, 1.0, 1e-30])).backward(np.full(3, log))
    assert np.isfinite(value).all()
    assert (value >= 0.0).all()


def test_L4_nothing_comes_back_above_the_largest_sample() -> None:
    """Textures may say anything between and beyond the samples."""
    value = np.array([[0.1, 2.0, 0.0], [3.0, 1.0, 0.0]])
    space = LogSpace.of(value)
    np.testing.assert_allclose(space.backward(np.full(3, 9.0)), [3.0, 2.0, 3.0], rtol=1e-12)
    np.testing.assert_allclose(space.backward(space.forward(value)), value, rtol=1e-12, atol=1e-15)


def test_L4_eight_decades_come_back() -> None:
    space = LogSpace.of(np.array([[1e-8, 1e-8, 1e-8], [1.0, 1.0, 1.0]]), 1e-9)
    np.testing.assert_allclose(space.backward(space.forward(np.full(3, 1e-8))), 1e-8, rtol=1e-6)


def test_formulas_are_sampled_uniformly_over_the_parabolic_disks() -> None:
    data = blue_paint(20_000, 55.0)
    for directions in (data.wi, data.wo):
        radius = np.hypot(directions[:, 0], directions[:, 1]) / (1.0 + directions[:, 2])
        share = (radius / np.tan(np.radians(27.5))) ** 2
        assert share.max() <= 1.0
        np.testing.assert_allclose(np.quantile(share, [0.1, 0.5, 0.9]), [0.1, 0.5, 0.9], atol=0.015)
        assert np.abs(directions[:, :2].mean(axis=0)).max() < 0.01
    np.testing.assert_array_equal(data.value, brdf_from_text("lafortune:preset=blue-paint").f(data.wi, data.wo))
    again = factor_data(brdf_from_text("lambert"), 10, seed=4)
    np.testing.assert_array_equal(again.wi, factor_data(brdf_from_text("lambert"), 10, seed=4).wi)
    assert not np.array_equal(again.wi, factor_data(brdf_from_text("lambert"), 10, seed=5).wi)


def test_scattered_measurements_keep_their_values_and_angles() -> None:
    rng = np.random.default_rng(0)
    theta_i, theta_o, phi = rng.uniform(0.1, 1.2, (3, 60))
    wi, wo = surface_direction(theta_i, 0.0 * phi), surface_direction(theta_o, phi)
    samples = BrdfSamples(wi, wo, brdf_from_text("phong").f(wi, wo))
    as_they_are = factor_data(samples)
    np.testing.assert_array_equal(as_they_are.wi, samples.wi)
    brdf = fit_scattered_brdf(samples)
    assert brdf.isotropic
    data = factor_data(brdf, 200)
    assert len(data) == 180
    np.testing.assert_array_equal(data.value, np.tile(samples.value, (3, 1)))
    np.testing.assert_allclose(np.sum(data.wi * data.wo, axis=1), np.tile(np.sum(wi * wo, axis=1), 3), atol=1e-14)
    np.testing.assert_allclose(data.wo[:, 2], np.tile(wo[:, 2], 3), atol=1e-15)
    assert len(np.unique(np.round(np.arctan2(data.wi[:, 1], data.wi[:, 0]), 6))) > 170


def test_tables_give_the_bins_that_were_measured() -> None:
    rng = np.random.default_rng(1)
    missing = rng.random((8, 6, 10)) < 0.5
    table = HalfDifferenceTable(rng.random((8, 6, 10, 3)), missing)
    data = factor_data(table, 10**6)
    np.testing.assert_allclose(table.f(data.wi, data.wo), data.value, atol=1e-12)
    known = {tuple(value) for value in np.asarray(table.values)[~missing]}
    assert {tuple(value) for value in data.value} <= known
    assert len(factor_data(table, 20)) == 20
    angles = np.array([0.2, 0.7, 1.2])
    around = np.array([0.0, 2.0, 4.0])
    grid = DirectionTable(angles, around, angles, around, rng.random((3, 3, 3, 3, 3)), np.zeros((3, 3, 3, 3), bool))
    data = factor_data(grid)
    assert len(data) == 81
    np.testing.assert_allclose(grid.f(data.wi, data.wo), data.value, atol=1e-12)


def test_the_six_errors_by_hand() -> None:
    up = np.tile([[0.0, 0.0, 1.0]], (2, 1))
    data = FactorData(up, up, cast(Any, [[1.0, 1.0, 1.0], [3.0, 3.0, 3.0]]))
    found = metrics(np.array([[2.0, 1.0, 1.0], [3.0, 3.0, 1.0]]), data, 1e-12)
    assert found.abs == pytest.approx(0.5)
    assert found.sq == pytest.approx(5.0 / 6.0)
    assert found.max == pytest.approx(2.0)
    assert found.abs_log == pytest.approx((np.log(2.0) + np.log(3.0)) / 6.0)
    assert found.sq_log == pytest.approx((np.log(2.0) ** 2 + np.log(3.0) ** 2) / 6.0)
    assert found.max_log == pytest.approx(np.log(3.0))
    black = FactorData(up, up, np.zeros((2, 3)))
    assert metrics(np.full((2, 3), -1.0), black).max_log == 0.0
    with pytest.raises(ValueError, match="samples"):
        metrics(np.zeros((3, 3)), data)


def test_the_cosine_weighted_error_of_a_constant() -> None:
    """A difference of c has the RMS c √⟨cos²⟩ = c/√3, in every band of the viewer's elevation."""
    first, second = brdf_from_text("lambert:albedo=0.5"), brdf_from_text("lambert:albedo=0.2")
    expected = 0.3 / np.pi / np.sqrt(3.0)
    assert rms_cosine_weighted(first, second) == pytest.approx(expected, rel=5e-3)
    total, bands = reference(first).rms(second)
    assert total == rms_cosine_weighted(first, second)
    np.testing.assert_allclose(bands[:-1], expected, rtol=0.03)
    assert reference(first, 1000).rms(first) == (0.0, (0.0,) * 9)


def test_impossible_samples_are_refused() -> None:
    lambert = brdf_from_text("lambert")
    for bad in ({"count": 0}, {"max_theta": 1.6}, {"max_theta": np.nan}):
        with pytest.raises(ValueError, match=r"needed|angle"):
            factor_data(lambert, **bad)
    up, down = np.array([[0.0, 0.0, 1.0]]), np.array([[0.0, 0.0, -1.0]])
    for wi, value in (
        (down, np.ones((1, 3))),
        (up, -np.ones((1, 3))),
        (up, np.full((1, 3), np.nan)),
        (up, np.ones((2, 3))),
    ):
        with pytest.raises(ValueError, match="must"):
            FactorData(wi, up, value)
    with pytest.raises(ValueError, match="pair"):
        reference(lambert, 0)

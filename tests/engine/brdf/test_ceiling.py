"""The ceiling of factors against brute force, and factors of measurements under it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmarks.generated_brdfs import generate
from engine.brdf.brdf import brdf_from_text
from engine.brdf.ceiling import NODES, Ceiling, ceiling_of, limits
from engine.brdf.scattered import ScatteredBrdf, fit_scattered
from engine.core.directions import surface_direction
from engine.core.steps import drain
from engine.factor.data import factor_data, parabolic_directions
from engine.factor.errors import HeldOut
from engine.factor.factor import factor
from engine.factor.held_out import _sum_excess
from engine.factor.homomorphic import HomomorphicFactors, LogSpace
from engine.factor.projections import FixedProjection
from engine.factor.settings import FactorSettings
from engine.factor.solvers.regions import compute_squared_distance
from engine.factor.textures import Level, SearchSettings

SHAPE = (NODES, NODES, NODES, 3)
NEAR = 2.0 * np.sin(np.radians(6.0))


def largest_near(samples: Any, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """Three times the largest value of the samples within 12° of each pair; not a number where there is none."""
    found = np.full((len(wi), 3), np.nan)
    for n in range(len(wi)):
        near = compute_squared_distance(samples.wi, samples.wo, wi[n], wo[n]) <= NEAR**2
        if near.any():
            found[n] = 3.0 * samples.value[near].max(axis=0)
    return found


@pytest.fixture(scope="module")
def measured() -> ScatteredBrdf:
    return drain(fit_scattered(generate(0).samples))


def test_limits_are_the_largest_values_within_12_degrees_of_any_turn_mirror_or_exchange() -> None:
    samples = generate(3).samples
    rng = np.random.default_rng(5)
    theta_i, theta_o, phi = *np.arccos(rng.random((2, 300))), np.pi * rng.random(300)
    found = limits(samples.wi, samples.wo, samples.value, theta_i, theta_o, phi, True)
    expected = largest_near(samples, surface_direction(theta_i, 0.0 * phi), surface_direction(theta_o, phi))
    known = np.isfinite(expected[:, 0])
    assert 50 < known.sum() < 300
    np.testing.assert_allclose(found[known], expected[known])


def test_far_from_all_samples_the_nearest_one_is_the_measure() -> None:
    up = np.array([[0.0, 0.0, 1.0]])
    tilted = surface_direction(np.radians([30.0]), np.zeros(1))
    samples = np.concatenate([up, tilted]), np.concatenate([up, tilted]), np.array([[1.0, 2.0, 3.0], [7.0, 7.0, 7.0]])
    found = limits(*samples, np.radians([1.0, 80.0]), np.radians([1.0, 80.0]), np.zeros(2), False)
    np.testing.assert_allclose(found, [[3.0, 6.0, 9.0], [21.0, 21.0, 21.0]])


def test_no_more_than_a_thousandth_of_pairs_has_a_ceiling_above_the_limit(measured: ScatteredBrdf) -> None:
    ceiling = factor_data(measured).add_ceiling(reciprocal=True).ceiling
    assert ceiling is not None
    rng = np.random.default_rng(1)
    wi, wo = (parabolic_directions(rng, 4000, np.radians(80.0)) for _ in range(2))
    above = ceiling.look_up(wi, wo) > largest_near(measured.measured, wi, wo) * (1.0 + 1e-6)
    assert above.any(axis=1).mean() <= 1e-3


def test_a_constant_has_a_ceiling_of_three_times_its_value_everywhere() -> None:
    rng = np.random.default_rng(2)
    wi, wo = (parabolic_directions(rng, 500, np.radians(60.0)) for _ in range(2))
    ceiling = ceiling_of(wi, wo, np.full((500, 3), 0.25), reciprocal=False)
    np.testing.assert_allclose(ceiling.table, 0.75, rtol=1e-6)
    with pytest.raises(ValueError, match="shape"):
        Ceiling(ceiling.table[:2])


@pytest.mark.parametrize(
    ("method", "seed"),
    [
        ("svd", 0),
        ("nonnegative", 7),
        ("homomorphic", 0),
        ("search", 7),
        *(
            pytest.param(*row, marks=pytest.mark.long)
            for row in (
                *(("svd", 7), ("nonnegative", 0), ("homomorphic", 7), ("search", 0)),
                *(("normalised", 0), ("normalised", 7)),
            )
        ),
    ],
)
def test_factors_show_no_colour_that_no_sample_near_has(method: Any, seed: int) -> None:
    brdf = drain(fit_scattered(generate(seed).samples))
    settings = FactorSettings(method, side=8, products=4, size=12, textures=2, restarts=0, samples=4000)
    factors = drain(factor(brdf, settings)).factors
    rng = np.random.default_rng(3)
    wi, wo = (parabolic_directions(rng, 3000, np.radians(80.0)) for _ in range(2))
    limit = largest_near(brdf.measured, wi, wo)
    above = factors.f(wi, wo) > limit * (1.0 + 1e-6)
    assert above.any(axis=1).mean() <= 1e-3
    without = replace(factors, ceiling=None).f(wi, wo) > limit * (1.0 + 1e-6)
    assert method not in ("svd", "nonnegative") or without.any(axis=1).mean() > 1e-2


def test_textures_that_rise_above_the_ceiling_are_judged_by_how_far() -> None:
    """A constant of 0.5 under a ceiling of 0.3: the excess is 0.2 cos θ."""
    data = replace(factor_data(brdf_from_text("lambert:albedo=0.5"), 500), ceiling=Ceiling(np.full(SHAPE, 0.3)))
    level = Level(data, LogSpace(np.full(3, 0.5)), SearchSettings(size=4, low_size=0), 4)
    half = HomomorphicFactors((np.zeros((4, 4, 3)),), (FixedProjection("half"),), level.space)
    cosine = parabolic_directions(np.random.default_rng(0), 1000, np.radians(80.0))[:, 2]
    assert _sum_excess(level, half, 0) == pytest.approx(0.04 * np.mean(cosine**2), rel=1e-4)
    assert HeldOut(3.0, 2.0, 4.0).score == 10.0

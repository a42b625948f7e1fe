"""Errors as distributions: small images move what is predicted by as much as they are worth."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.planning.costs.setting import Setting
from engine.planning.prior import LEVELS, MINIMUM, Deviations, Posterior, Prior, normal, prior_of, read_prior
from engine.planning.small_images import Measured, compare_pixels

LINE = tuple(float(level) for level in np.linspace(-2.0, 2.0, len(LEVELS)))
PRIOR = Prior({"sh": Deviations(0.1, 0.3, 0.2), "": Deviations(0.0, 0.5, 0.5)}, 0.1, 0.05, LINE)
LOW, HIGH, OTHER = Setting("sh", {"order": 3}), Setting("sh", {"order": 8}), Setting("direct")


def test_without_small_images_an_error_is_the_predicted_one_times_the_usual_ratio() -> None:
    found = Posterior(PRIOR, {}, {}).condition(HIGH, 0.02)
    assert found.median == pytest.approx(0.02 * math.exp(0.1))
    assert found.deviation == pytest.approx(math.sqrt(0.1**2 + 0.3**2 + 0.2**2))
    assert found.interval == pytest.approx([found.median * math.exp(1.9 * sign * found.deviation) for sign in (-1, 1)])


def test_T1_one_small_image_is_weighed_as_by_hand() -> None:
    """A measured error of 4 % where 2 % was predicted; all covariances are sums of three squares."""
    common, scene, own, noise = 0.1**2, 0.3**2, 0.2**2, 0.05**2 + 0.1**2
    surprise = math.log(0.04 / 0.02) - 0.1
    posterior = Posterior(PRIOR, {HIGH: Measured(0.04, 0.1)}, {HIGH: 0.02})
    alike = common + scene + own
    for setting, shared, predicted in ((HIGH, alike, 0.02), (LOW, common + scene, 0.1), (OTHER, common, 0.1)):
        found = posterior.condition(setting, predicted)
        whole = alike if setting.mode == "sh" else common + 2 * 0.5**2
        mean = math.log(predicted) + (0.1 if setting.mode == "sh" else 0.0)
        assert found.mean == pytest.approx(mean + shared / (alike + noise) * surprise)
        assert found.deviation == pytest.approx(math.sqrt(whole - shared**2 / (alike + noise)))


def test_noise_of_the_reference_is_not_moved_by_other_errors() -> None:
    posterior = Posterior(PRIOR, {HIGH: Measured(0.5, 0.01)}, {HIGH: 0.02})
    alone = Posterior(PRIOR, {}, {})
    assert posterior.condition(Setting("reference"), 0.1).mean == alone.condition(Setting("reference"), 0.1).mean


@given(st.floats(1e-3, 1.0), st.floats(1.1, 20.0), st.floats(0.05, 0.95))
def test_T5_a_probability_is_the_level_of_its_quantile(low: float, ratio: float, level: float) -> None:
    found = normal(low, low * ratio)
    error = found.quantile(level)
    if error > MINIMUM:
        assert found.probability_below(error) == pytest.approx(level, abs=1e-6)
    assert found.probability_below(0.0) == 0.0
    assert found.interval == pytest.approx((low, low * ratio), rel=1e-2)


def test_the_shipped_prior_is_read_and_sensible() -> None:
    found = read_prior()
    assert prior_of(found.as_record()) == found
    assert {"direct", "sh", "wavelet", "gaussian", "reference", ""} <= found.modes.keys()
    assert len(found.quantiles) == len(LEVELS)
    assert all(one < other for one, other in zip(found.quantiles, found.quantiles[1:], strict=False))


def test_T2_pixels_tell_their_error_without_the_noise_of_the_reference() -> None:
    """An image that is 10 % too bright, against references of known noise: 0.1 within what is stated."""
    rng, truth = np.random.default_rng(3), np.full((800, 3), 2.0)
    noise = np.full_like(truth, 0.1**2)
    found = [compare_pixels(1.1 * truth, truth + 0.1 * rng.normal(size=truth.shape), noise) for _ in range(20)]
    apart = [math.log(each.error_rel / 0.1) / each.deviation for each in found if each is not None]
    assert len(apart) == 20
    assert float(np.std(apart)) < 2.0
    assert max(abs(value) for value in apart) < 4.0


def test_an_error_that_noise_hides_is_small_and_uncertain() -> None:
    rng, truth = np.random.default_rng(3), np.full((800, 3), 2.0)
    found = compare_pixels(truth, truth + 0.2 * rng.normal(size=truth.shape), np.full_like(truth, 0.2**2))
    assert found is not None
    assert found.deviation == 1.0
    assert found.error_rel < 0.1

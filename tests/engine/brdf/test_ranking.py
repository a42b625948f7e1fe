"""Fits in two norms: where one grows while the other falls it is said, and the best of each is offered."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.brdf.fit import FitData, fit, fit_data
from engine.brdf.models.diffuse import Lambert
from engine.brdf.ranking import Offer, best, fit_both, miss, offer, rank, warning
from engine.core.directions import surface_direction
from engine.core.steps import drain

PAINT = fit_data(brdf_from_text("phong:kd=0.2,ks=0.3,exponent=20"), count=200)


def bright_and_dim() -> FitData:
    """Three in ten values are a hundred times the others: no diffuse surface is near both."""
    rng = np.random.default_rng(0)
    wi, wo = (surface_direction(1.2 * rng.random(200), 6.28 * rng.random(200)) for _ in range(2))
    value = np.where(np.arange(200) % 10 < 3, 0.8, 0.008)[:, None] * np.ones(3)
    return FitData(wi, wo, value)


def test_a_fit_whose_linear_error_grows_says_so_and_both_bests_are_offered() -> None:
    data, start = bright_and_dim(), Lambert((0.9, 0.9, 0.9))
    found = drain(fit(data, start, weighting="log"))
    before, after = offer(start, data), offer(found.brdf, data)
    assert after.linear > 1.05 * before.linear
    assert after.log < before.log
    assert "linear error grows" in warning(before, after)
    offers = drain(fit_both(data, start, found, weighting="log"))
    assert offers["log"].log <= after.log
    assert offers["linear"].linear <= before.linear < after.linear
    seen = data.value[:, 0] * data.wi[:, 2]
    least = float(seen @ data.wi[:, 2] / (data.wi[:, 2] @ data.wi[:, 2]))
    nearest = offers["linear"].brdf
    assert isinstance(nearest, Lambert)
    assert nearest.albedo[0] == pytest.approx(np.pi * least, rel=1e-3)


def test_only_a_norm_that_grows_while_the_other_falls_is_worth_a_warning() -> None:
    before = Offer(Lambert(), 0.5, 0.5)
    for after, words in (((0.4, 0.4), ""), ((0.6, 0.4), "linear error grows"), ((0.4, 0.6), "logarithmic error grows")):
        assert words in warning(before, replace(before, linear=after[0], log=after[1]))
        assert bool(words) == bool(warning(before, replace(before, linear=after[0], log=after[1])))
    assert warning(before, replace(before, linear=0.5 * (1.0 + 1e-6), log=0.4)) == ""


def test_models_are_ranked_from_the_least_error_up() -> None:
    models = [brdf_from_text(name) for name in ("lambert", "phong")]
    offers = drain(rank(PAINT, models))
    assert [type(each.brdf) for each in offers] == [type(each) for each in models[::-1]]
    assert offers[0].log < 1e-3 < offers[1].log
    assert best(offers)["linear"] is offers[0]


def test_a_fit_that_is_hardly_better_than_black_is_doubted() -> None:
    """A highlight of 60 times what is around it, and a diffuse surface in its place."""
    data = fit_data(brdf_from_text("ggx:kd=0.1,alpha=0.05,f0=1"), count=2000)
    diffuse, glossy = (drain(fit(data, brdf_from_text(name))).brdf for name in ("lambert", "ggx"))
    assert "misses the values by 9" in miss(offer(diffuse, data))
    assert miss(offer(glossy, data)) == ""

"""Every method by one call: its sweep of errors, what it shows on the way, and what it refuses."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.figure_text import percent
from engine.core.steps import Step, drain
from engine.factor.advice import advise
from engine.factor.data import factor_data
from engine.factor.errors import metrics, reference, uses
from engine.factor.factor import factor
from engine.factor.settings import FactorSettings

PAINT = brdf_from_text("lafortune:preset=blue-paint")


def factor_brdf(brdf: Any = PAINT, **settings: Any) -> Any:
    return drain(factor(brdf, FactorSettings(**{"samples": 2000, "side": 12, "products": 3, **settings})))


@pytest.mark.parametrize("method", ["auto", "symmetric", "svd", "power", "nonnegative", "normalised"])
def test_a_term_errors_tells_the_errors_of_each_number_of_terms(method: Any) -> None:
    found = factor_brdf(method=method)
    assert found.method == ("symmetric" if method == "auto" else method)
    assert [term_error.terms for term_error in found.term_errors] == ([1] if method == "normalised" else [1, 2, 3])
    data, pairs = factor_data(PAINT, 2000), reference(PAINT)
    last = found.term_errors[-1]
    assert last.rms_cosine_weighted == pairs.rms(found.factors)[0]
    assert last.metrics == metrics(found.factors.f(data.wi, data.wo), data)
    assert len(last.rms_by_elevation_band) == 9
    assert last.size_bytes == 2 * last.terms * 12 * 12 * 3 * 4
    assert found.negative_energy == found.factors.negative_energy(pairs.wi, pairs.wo)
    assert found.weighting in ("plain", "cosine")
    assert found.converged
    assert (last.textures, last.time_s > 0.0) == (2 * last.terms, True)


def test_the_search_and_the_fixed_projections_are_called_with_the_settings() -> None:
    fixed = factor_brdf(method="homomorphic", size=8, reciprocal=True)
    assert [term_error.terms for term_error in fixed.term_errors] == [1, 2]
    assert fixed.factors.reciprocal
    found = factor_brdf(method="search", size=6, textures=1, restarts=0, samples=300)
    assert (found.method, len(found.projections), found.factors.textures[0].shape) == ("search", 1, (6, 6, 3))
    more = drain(factor(PAINT, FactorSettings("search", size=6, textures=2, restarts=0, samples=300), found))
    assert [term_error.terms for term_error in more.term_errors] == [1, 2]
    assert more.term_errors[0].metrics == found.term_errors[0].metrics
    with pytest.raises(ValueError, match="go on"):
        drain(factor(PAINT, FactorSettings("search", size=8, samples=500), fixed))


def test_parts_of_the_result_are_seen_on_the_way() -> None:
    seen: list[Step] = []
    drain(factor(PAINT, FactorSettings(side=8, products=4, samples=500)), seen.append)
    term_errors = [len(step.partial.term_errors) for step in seen if step.partial is not None]
    assert term_errors == [1, 2, 3, 4]
    assert all(after.done >= before.done for before, after in itertools.pairwise(seen))


def test_the_best_map_and_parametrisation_are_found() -> None:
    best = factor_brdf(map="auto", parametrisation="auto")
    for kind in ("orthographic", "polar", "parabolic"):
        for form in ("in-out", "half-diff"):
            one = factor_brdf(map=kind, parametrisation=form)
            assert best.term_errors[-1].rms_cosine_weighted <= one.term_errors[-1].rms_cosine_weighted
    assert best.factors.parametrisation == "half-diff"


def test_the_same_seed_gives_the_same_factors() -> None:
    one, other = (factor_brdf(seed=5) for _ in range(2))
    assert np.array_equal(one.factors.first, other.factors.first)
    assert one.term_errors[-1].metrics == other.term_errors[-1].metrics


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"method": "magic"}, "method"),
        ({"map": "square"}, "map"),
        ({"side": 97}, "side"),
        ({"products": 65}, "products"),
        ({"method": "symmetric", "parametrisation": "half-diff"}, "symmetric"),
        ({"method": "search", "parametrisation": "auto"}, "parametrisation"),
        ({"method": "search", "size": 65}, "size"),
        ({"method": "search", "metric": "best"}, "metric"),
        ({"preset": "mine"}, "preset"),
        ({"samples": 10**11}, "samples"),
    ],
)
def test_settings_that_cannot_be_are_refused(settings: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        drain(factor(PAINT, FactorSettings(**{"samples": 100, **settings})))


def test_uses_are_named_and_narrow_highlights_are_sent_to_the_gaussian_mode() -> None:
    sentences = uses(factor_brdf(), PAINT)
    assert "wavelets can use these 3 terms" in sentences[0]
    half = uses(factor_brdf(parametrisation="half-diff"))
    assert any("wavelets cannot" in sentence for sentence in half)
    assert not any("Gaussian" in sentence for sentence in half)
    assert "texture" in uses(factor_brdf(method="homomorphic", size=8))[0]
    mirror = brdf_from_text("ggx:alpha=0.05")
    assert "Gaussian" in uses(factor_brdf(mirror), mirror)[-1]


@pytest.mark.parametrize(
    ("brdf", "more", "words"),
    [
        ("cook-torrance", {}, "factors are of lafortune"),
        ("lafortune:preset=blue-paint", {"size": 10}, "size and epsilon"),
        ("lafortune:preset=blue-paint", {"epsilon": 1e-3}, "size and epsilon"),
        ("lafortune:preset=blue-paint", {"reciprocal": True}, "reciprocity"),
    ],
)
def test_a_search_goes_on_only_as_what_it_was(brdf: str, more: Any, words: str) -> None:
    settings = FactorSettings(method="search", size=6, textures=1, restarts=0, samples=300)
    first = drain(factor(brdf_from_text("lafortune:preset=blue-paint"), settings))
    with pytest.raises(ValueError, match=words):
        drain(factor(brdf_from_text(brdf), replace(settings, textures=2, **more), first))


def test_half_and_difference_vectors_are_advised_with_the_error_that_they_have() -> None:
    """The BRDF of Wang2004: four products of light and view miss the ridge that one of half vectors is."""
    brdf = brdf_from_text("ashikhmin-shirley:kd=0.5,ks=0.75,nu=10,nv=100")
    found = factor_brdf(brdf, side=16, products=4)
    said = drain(advise(found, brdf))[-1]
    other = factor_brdf(brdf, side=16, products=4, parametrisation="half-diff", weighting="cosine", map="polar")
    shares = [reference(brdf).miss(each.term_errors[-1].rms_by_elevation_band) for each in (other, found)]
    assert shares[0] < 0.25 * shares[1]
    assert all(percent(share) in said for share in shares)
    assert drain(advise(other, brdf)) == uses(other, brdf)


def test_factors_that_are_mostly_wrong_are_recommended_for_nothing() -> None:
    """One product of maps of 4² of a narrow highlight: nearly all of its light is missed."""
    mirror = brdf_from_text("ggx:kd=0,alpha=0.02,f0=0.9")
    found = factor_brdf(mirror, side=4, products=1)
    sentences = uses(found, mirror)
    assert reference(mirror).miss(found.term_errors[-1].rms_by_elevation_band) > 0.9
    assert sentences[0].startswith("Use these factors for nothing: they are off by")
    assert not any("can use" in sentence for sentence in sentences)

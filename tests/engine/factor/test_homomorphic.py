"""Products of textures: exact reciprocity, functions that are such products, and the search's promises."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.directions import normalize
from engine.core.steps import Step, drain
from engine.factor.data import FactorData, factor_data
from engine.factor.errors import METRICS, Factorisation, metrics, reference
from engine.factor.homomorphic import HomomorphicFactors, LogSpace
from engine.factor.projection_search import search
from engine.factor.projections import (
    KINDS,
    PARAMETRISATIONS,
    FixedProjection,
    LinearProjection,
    linear_of_pair,
    parabolic,
    points_of,
)
from engine.factor.solvers.quaternions import random_pair
from engine.factor.textures import THESIS, SearchSettings, mccool
from tests.engine.factor.factored import blue_paint
from tests.engine.factor.test_projections import hemisphere

#: A search that takes a fraction of a second.
QUICK = SearchSettings(
    terms=2, size=8, low_size=4, low_samples=300, restarts=1, finalists=1, smoothing=1e-3, reciprocal=True
)


def random_factors(parametrisation: Any, reciprocal: bool, seed: int = 0) -> HomomorphicFactors:
    rng = np.random.default_rng(seed)
    projections = [linear_of_pair(random_pair(rng)) for _ in range(3)] + [FixedProjection(kind) for kind in KINDS]
    textures = [rng.normal(size=(5 + k, 5 + k, 3)) for k in range(len(projections))]
    space = LogSpace(np.array([0.1, 0.2, 0.3]))
    return HomomorphicFactors(tuple(textures), tuple(projections), space, parametrisation, reciprocal)


def same_bits(first: Factorisation, second: Factorisation) -> bool:
    one, other = first.factors, second.factors
    assert isinstance(one, HomomorphicFactors)
    assert isinstance(other, HomomorphicFactors)
    textures = zip(one.textures, other.textures, strict=True)
    return first.evaluations == second.evaluations and all(np.array_equal(a, b) for a, b in textures)


@pytest.mark.parametrize("parametrisation", PARAMETRISATIONS)
def test_L14_exchanging_the_directions_gives_the_same_bits(parametrisation: str) -> None:
    wi, wo = hemisphere(5000, 1), hemisphere(5000, 2)
    factors = random_factors(parametrisation, True)
    np.testing.assert_array_equal(factors.f(wi, wo), factors.f(wo, wi))
    assert not np.array_equal(random_factors(parametrisation, False).f(wi, wo), factors.f(wo, wi))


@pytest.mark.parametrize("reciprocal", [True, False])
def test_values_are_those_of_a_plain_loop(reciprocal: bool) -> None:
    factors = random_factors("in-out", reciprocal)
    wi, wo = hemisphere(6, 3), hemisphere(6, 4)
    points = points_of(wi, wo, "in-out")
    total = np.zeros((6, 3))
    for texture, projection in zip(factors.textures, factors.projections, strict=True):
        reads = [projection.coordinates(points)]
        conjugate = projection.conjugate("in-out")
        if reciprocal and conjugate != projection:
            reads.append(conjugate.coordinates(points))
        for coordinates in reads:
            for k, (u, v) in enumerate(0.5 * (coordinates + 1.0) * (len(texture) - 1)):
                column, row = min(int(u), len(texture) - 2), min(int(v), len(texture) - 2)
                lower = texture[row, column] * (1.0 - u + column) + texture[row, column + 1] * (u - column)
                upper = texture[row + 1, column] * (1.0 - u + column) + texture[row + 1, column + 1] * (u - column)
                total[k] += lower * (1.0 - v + row) + upper * (v - row)
    expected = np.maximum(factors.space.mean * (np.exp(total) - factors.space.epsilon), 0.0)
    np.testing.assert_allclose(factors.f(wi, wo), expected, rtol=1e-12)
    assert (factors.f(wi * (1.0, 1.0, -1.0), wo) == 0.0).all()
    assert factors.f(wi[:, None], wo[None]).shape == (6, 6, 3)


def test_L11_a_function_of_the_incident_direction_is_found_again() -> None:
    """log f is bilinear between the texels of the incident disk: one texture holds it, and a second stays empty."""
    rng = np.random.default_rng(5)
    truth = HomomorphicFactors(
        (rng.normal(size=(6, 6, 3)),), (FixedProjection("wi"),), LogSpace(np.ones(3), 1e-9), reciprocal=False
    )
    wi, wo = hemisphere(4000, 6), hemisphere(4000, 7)
    data = FactorData(wi, wo, truth.f(wi, wo))
    made = drain(mccool(data, 6, reciprocal=False, smoothing=1e-12, epsilon=1e-9))
    assert made.term_errors[0].metrics.max_log < 1e-5
    near = hemisphere(500, 8) * 0.4 + [0.0, 0.0, 0.6]
    near /= np.linalg.norm(near, axis=1)[:, None]
    np.testing.assert_allclose(made.factors.truncate(1).f(near, wo[:500]), truth.f(near, wo[:500]), rtol=1e-5)


COMPARED = ("cook-torrance:kd=0,ks=1,m=0.3,f0=0.2", "ward:alpha_x=0.2,alpha_y=0.5", "lambert:albedo=0.5")


@pytest.mark.parametrize(
    ("text", "reciprocal"),
    [
        (COMPARED[0], True),
        *(pytest.param(text, True, marks=pytest.mark.long) for text in COMPARED[1:]),
        *(pytest.param(text, False, marks=pytest.mark.long) for text in COMPARED),
    ],
)
def test_the_search_is_never_worse_than_mccool_with_as_many_textures(text: str, reciprocal: bool) -> None:
    data = factor_data(brdf_from_text(text), 800, np.radians(80.0))
    terms = 2 if reciprocal else 3
    settings = replace(QUICK, reciprocal=reciprocal, terms=terms, fixed=(), restarts=1)
    found = drain(search(data, settings))
    fixed = drain(mccool(data, settings.size, reciprocal, smoothing=settings.smoothing))
    assert fixed.term_errors[-1].textures == terms
    assert found.term_errors[-1].metrics.sq_log <= fixed.term_errors[-1].metrics.sq_log * (1.0 + 1e-9) + 1e-15


def test_blue_paint_is_far_better_than_mccool_with_two_textures() -> None:
    """To 55° and with few samples; the full figures are those of `python -m benchmarks`."""
    data = blue_paint(4000, 55.0)
    fixed = drain(mccool(data, 16, reciprocal=True))
    found = drain(search(data, SearchSettings(terms=2, restarts=0, low_samples=1000, reciprocal=True)))
    assert found.term_errors[-1].metrics.sq_log < 0.17 * fixed.term_errors[-1].metrics.sq_log


def test_more_terms_are_never_worse() -> None:
    for settings in (
        replace(QUICK, terms=3, fixed=(), restarts=0),
        replace(QUICK, terms=3, refit=False, guesses=False),
    ):
        found = drain(search(blue_paint(800), settings))
        errors = [term_error.metrics.sq_log for term_error in found.term_errors]
        assert len(errors) == 3
        assert all(later <= earlier * 1.01 for earlier, later in itertools.pairwise(errors))
        for term_error in found.term_errors:
            shorter = found.factors.truncate(term_error.terms)
            again = metrics(shorter.f(blue_paint(800).wi, blue_paint(800).wo), blue_paint(800))
            assert again == term_error.metrics
            assert term_error.size_bytes == shorter.size_bytes == term_error.terms * 8 * 8 * 3 * 4


def test_Q16_the_same_seed_gives_the_same_bits_and_another_does_not() -> None:
    settings = replace(QUICK, fixed=(), guesses=False, restarts=2, terms=1)
    first, second = (drain(search(blue_paint(500), settings)) for _ in range(2))
    assert same_bits(first, second)
    assert not same_bits(first, drain(search(blue_paint(500), replace(settings, seed=2))))


def test_Q16_the_number_of_threads_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    settings = replace(QUICK, fixed=(), restarts=2, terms=1)
    results = []
    for threads in (1, 3):
        monkeypatch.setattr("os.cpu_count", lambda threads=threads: threads)
        results.append(drain(search(blue_paint(500), settings)))
    assert same_bits(*results)


@pytest.mark.parametrize("metric", METRICS)
def test_the_chosen_metric_drives(metric: str) -> None:
    data = blue_paint(500)
    found = drain(search(data, replace(QUICK, metric=metric, terms=1)))
    assert found.term_errors[0].terms == 1
    assert np.isfinite(getattr(found.term_errors[0].metrics, metric))


def test_closing_keeps_the_best_so_far_and_resuming_goes_on() -> None:
    data = blue_paint(600)
    settings = replace(QUICK, terms=2, restarts=0)
    whole = drain(search(data, settings))
    steps = search(data, settings)
    partial: Factorisation | None = None
    for step in steps:
        partial = step.partial
        if partial is not None and len(partial.term_errors) == 1 and not partial.searching:
            break
    steps.close()
    assert partial is not None
    resumed = drain(search(data, settings, resume=partial))
    assert [term_error.terms for term_error in resumed.term_errors] == [1, 2]
    assert same_bits(resumed, whole)
    assert drain(search(data, settings, resume=resumed)) is resumed
    with pytest.raises(ValueError, match="goes on"):
        drain(search(data, replace(settings, reciprocal=False), resume=partial))


def test_a_search_cut_off_within_a_term_is_resumed_from_there() -> None:
    data = blue_paint(600)
    settings = replace(QUICK, terms=2, fixed=(), restarts=0, mccool=False)
    unfinished = [
        step.partial for step in search(data, settings) if step.partial is not None and step.partial.searching
    ]
    assert unfinished
    for partial in (unfinished[0], unfinished[-1]):
        assert partial.factors.terms == len(partial.term_errors)
        resumed = drain(search(data, settings, resume=partial))
        assert len(resumed.term_errors) == 2
        assert (
            resumed.term_errors[len(partial.term_errors) - 1].metrics.sq_log
            <= 1.05 * partial.term_errors[-1].metrics.sq_log
        )


def test_steps_come_often_and_progress_never_falls(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.factor.projection_search.PACE_S", 0.0)
    steps: list[Step] = list(search(blue_paint(500), QUICK))
    assert len(steps) > 50
    assert all(0.0 <= step.done <= 1.0 for step in steps)
    assert all(later.done >= earlier.done for earlier, later in itertools.pairwise(steps))
    shown = [step.partial.term_errors[-1].metrics.sq_log for step in steps if step.partial is not None]
    assert shown[-1] == min(shown)


@pytest.mark.parametrize("parametrisation", PARAMETRISATIONS)
def test_the_thesis_searches_linear_projections_alone(parametrisation: Any) -> None:
    settings = replace(
        THESIS, terms=2, size=6, low_size=4, low_samples=300, restarts=1, finalists=1, parametrisation=parametrisation
    )
    found = drain(search(blue_paint(500), settings))
    assert found.method == "search"
    for projection in found.projections:
        assert isinstance(projection, LinearProjection)
        assert projection.extent == "cube"
    assert (THESIS.terms, THESIS.restarts, THESIS.together, THESIS.size) == (5, 6, 2, 16)


def test_facets_without_a_base_are_a_product_of_two_textures() -> None:
    """GGX with kd = 0: D F depends on wi-dot-h, the rest on elevations."""
    data = factor_data(brdf_from_text("ggx:kd=0,alpha=0.6,f0=0.5"), 4000, np.radians(75.0))
    settings = SearchSettings(terms=2, size=16, restarts=0, guesses=False, fixed=("half", "wi-dot-h", "elevations"))
    found = drain(search(data, settings))
    assert [projection.name for projection in found.projections] == ["wi-dot-h", "elevations"]
    assert found.term_errors[-1].metrics.sq_log < 1e-4


def test_every_error_is_reported_with_a_reference() -> None:
    brdf = brdf_from_text("lafortune:preset=blue-paint")
    made = drain(mccool(blue_paint(1000), 8, reciprocal=True, reference=reference(brdf, 2000)))
    assert [term_error.textures for term_error in made.term_errors] == [1, 2]
    assert len(made.term_errors[0].rms_by_elevation_band) == 9
    assert made.condition_number > 1.0
    assert isinstance(made.factors, HomomorphicFactors)
    assert made.projections == made.factors.projections


def test_black_and_impossible_settings_are_refused() -> None:
    data = blue_paint(50)
    black = FactorData(data.wi, data.wo, np.zeros_like(data.value))
    with pytest.raises(ValueError, match="0 everywhere"):
        drain(mccool(black))
    for bad in (
        {"terms": 0},
        {"size": 3},
        {"low_size": 40},
        {"metric": "l2"},
        {"smoothing": -1.0},
        {"smoothing": np.nan},
    ):
        with pytest.raises(ValueError, match=r"must|outside|metric is"):
            SearchSettings(**bad)
    with pytest.raises(ValueError, match="nothing to try"):
        SearchSettings(restarts=0, guesses=False, fixed=())
    with pytest.raises(ValueError, match="choose from"):
        drain(mccool(data, 4)).factors.truncate(7)
    with pytest.raises(ValueError, match="shape"):
        HomomorphicFactors((np.zeros((2, 3, 3)),), (FixedProjection("wi"),), LogSpace(np.ones(3)))


def test_parabolic_coordinates_are_the_thesis_ones() -> None:
    """w + (0, 0, 1) = k (u, v, 1)."""
    w = hemisphere(10, 9)
    k = w[:, 2:] + 1.0
    np.testing.assert_allclose(parabolic(w) * k, w[:, :2])


def test_textures_of_angles_alone_are_isotropic() -> None:
    rng = np.random.default_rng(2)
    turn = np.array([[np.cos(1.0), -np.sin(1.0), 0.0], [np.sin(1.0), np.cos(1.0), 0.0], [0.0, 0.0, 1.0]])
    wi, wo = normalize(np.abs(rng.normal(size=(2, 50, 3))))
    for kinds, isotropic in ((("wi-dot-h-cosines", "elevations"), True), (("wi-dot-h", "half"), False)):
        projections = tuple(FixedProjection(kind) for kind in kinds)  # type: ignore[arg-type]
        textures = tuple(rng.normal(size=(5, 5, 3)) for _ in kinds)
        factors = HomomorphicFactors(textures, projections, LogSpace(np.ones(3)))
        assert factors.isotropic == isotropic
        assert np.allclose(factors.f(wi, wo), factors.f(wi @ turn.T, wo @ turn.T)) == isotropic

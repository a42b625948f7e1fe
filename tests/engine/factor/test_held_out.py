"""Errors at regions that were left out, against dense least squares made anew, and the choice by them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.brdf.samples import BrdfSamples
from engine.brdf.scattered import ScatteredBrdf, fit_scattered
from engine.core.directions import surface_direction
from engine.core.steps import Step, drain
from engine.factor.data import FactorData
from engine.factor.errors import Factorisation, HeldOut, compute_held_out_errors
from engine.factor.factor import factor
from engine.factor.held_out import Judged, _nest, foretold, judge, smooth
from engine.factor.homomorphic import LogSpace
from engine.factor.projections import FixedProjection, points_of
from engine.factor.settings import FactorSettings
from engine.factor.solvers.regions import parts_of
from engine.factor.textures import Level, SearchSettings
from tests.engine.factor.factored import blue_paint


def sparse(text: str, seed: int = 0) -> ScatteredBrdf:
    """A model at directions like Cornell's: light at four angles in one azimuth, viewers on a grid."""
    theta_i, theta_o, phi = np.meshgrid(
        np.radians([5.0, 20.0, 35.0, 50.0, 65.0]),
        np.radians(np.arange(4.0, 76.0, 12.0)),
        np.radians(np.arange(0, 181, 30)),
    )
    wi = surface_direction(theta_i.ravel(), np.zeros(theta_i.size))
    wo = surface_direction(theta_o.ravel(), phi.ravel())
    return drain(fit_scattered(BrdfSamples(wi, wo, brdf_from_text(text).f(wi, wo), "sparse")))


def by_hand(data: FactorData, kind: Any, size: int, smoothing: float, part: int) -> np.ndarray:
    """One texture by a dense matrix of hat functions, without the samples of `part`, at these samples."""
    parts = parts_of(data.wi, data.wo, data.measurement)
    assert parts is not None
    axis = np.linspace(-1.0, 1.0, size)
    at = FixedProjection(kind).coordinates(points_of(data.wi, data.wo, "in-out"))
    hats = [np.maximum(1.0 - np.abs(at[:, k, None] - axis) * (size - 1) / 2.0, 0.0) for k in (0, 1)]
    matrix = (hats[1][:, :, None] * hats[0][:, None, :]).reshape(len(at), -1)
    kept = parts != part
    mean = data.value.mean(axis=0)
    target = np.log(data.value / mean + 1e-5)
    touched = matrix[kept].max(axis=0) > 0.0
    grid = np.eye(size * size).reshape(size * size, size, size)
    second = [
        np.diff(grid, 2, axis=2).reshape(size * size, -1),
        np.diff(grid, 2, axis=1).reshape(size * size, -1),
        np.sqrt(2.0) * np.diff(np.diff(grid, axis=1), axis=2).reshape(size * size, -1),
    ]
    bends = np.concatenate(second, axis=1).T
    bends = bends[(bends[:, ~touched] == 0.0).all(axis=1)]
    rows = [matrix[kept] / np.sqrt(kept.sum()), np.sqrt(smoothing / touched.sum()) * bends]
    right = [target[kept] / np.sqrt(kept.sum()), np.zeros((len(bends), 3))]
    texture = np.linalg.lstsq(np.concatenate(rows)[:, touched], np.concatenate(right), rcond=None)[0]
    assert (matrix[~kept][:, ~touched] == 0.0).all()
    grown = np.exp(matrix[~kept][:, touched] @ texture)
    return np.clip(mean * (grown - 1e-5), 0.0, data.value[kept].max(axis=0))


def test_values_at_regions_left_out_are_those_of_dense_least_squares() -> None:
    data = blue_paint(1500)
    parts = parts_of(data.wi, data.wo, data.measurement)
    assert parts is not None
    level = Level(data, LogSpace.of(data.value), SearchSettings(size=5, low_size=0, reciprocal=False), 5)
    values, excess = drain(foretold(level, data, [FixedProjection("wi-dot-h")], 1e-2, parts))
    assert excess == 0.0
    for part in (0, 3):
        np.testing.assert_allclose(values[parts == part], by_hand(data, "wi-dot-h", 5, 1e-2, part), rtol=1e-5)


def test_both_errors_are_their_definitions() -> None:
    data = blue_paint(50)
    value = 1.1 * data.value + 0.01
    total, logs = 0.0, 0.0
    for n in range(50):
        for c in range(3):
            mean = data.value[:, c].mean()
            total += ((value[n, c] - data.value[n, c]) * data.wi[n, 2]) ** 2
            logs += np.log((value[n, c] + 1e-5 * mean) / (data.value[n, c] + 1e-5 * mean)) ** 2
    errors = compute_held_out_errors(value, data)
    assert errors.rms_cosine_weighted == pytest.approx(np.sqrt(total / 150.0), rel=1e-12)
    assert errors.sq_log == pytest.approx(logs / 150.0, rel=1e-12)


def test_smoothness_is_that_of_the_least_errors() -> None:
    data = blue_paint(400)
    parts = parts_of(data.wi, data.wo, data.measurement)
    assert parts is not None
    level = Level(data, LogSpace.of(data.value), SearchSettings(size=12, low_size=0), 12)
    projections = [FixedProjection("half"), FixedProjection("wi")]
    first = drain(judge(level, data, projections, 1e-3, parts))
    tried = drain(smooth(level, data, first, parts))
    assert tried[-1].score == min(one.score for one in tried) < first.score
    again = drain(judge(level, data, projections, tried[-1].smoothing, parts))
    assert again.held_out == tried[-1].held_out


def test_terms_are_nested() -> None:
    def one(rms: float, log: float) -> Judged:
        return Judged((), 0.0, HeldOut(rms, log))

    found = [one(0.1, 9.0), one(0.5, 3.0), one(0.4, 2.0), one(0.3, 2.0)]
    assert _nest(found) == found[1:]


@pytest.fixture(scope="module")
def measured() -> ScatteredBrdf:
    return sparse("ward:alpha_x=0.15,alpha_y=0.15,kd=0.2")


def find_by(brdf: Any, **settings: Any) -> Factorisation:
    return drain(
        factor(
            brdf, FactorSettings(**{"samples": 1000, "size": 8, "side": 8, "restarts": 0, "textures": 2, **settings})
        )
    )


def test_the_default_is_never_worse_than_mccool_nor_than_fewer_terms(measured: ScatteredBrdf) -> None:
    searched, fixed = (find_by(measured, method=method, reciprocal=True) for method in ("search", "homomorphic"))
    sets = [term_error.held_out for term_error in (*fixed.term_errors, *fixed.left_out)]
    assert len(sets) == 2
    before = None
    for term_error in searched.term_errors:
        assert term_error.held_out is not None
        assert term_error.held_out.no_worse(sets[term_error.terms - 1])  # type: ignore[arg-type]
        assert before is None or term_error.held_out.no_worse(before)
        before = term_error.held_out
    assert before is not None
    assert before.no_worse(sets[-1])  # type: ignore[arg-type]
    assert searched.best_terms == searched.factors.terms == searched.term_errors[-1].terms
    wi, wo = (surface_direction(np.radians(60.0) * np.sqrt(side), 6.28 * turn) for side, turn in RANDOM)
    truth = brdf_from_text("ward:alpha_x=0.15,alpha_y=0.15,kd=0.2").f(wi, wo)
    missed = [float(np.abs(found.factors.f(wi, wo) - truth).mean()) for found in (searched, fixed)]
    assert missed[0] < missed[1]


RANDOM = np.random.default_rng(3).random((2, 2, 3000))


def test_the_thesis_keeps_what_it_found() -> None:
    found = find_by(brdf_from_text("phong"), method="search", preset="thesis", restarts=1, samples=300)
    assert [term_error.terms for term_error in found.term_errors] == [1, 2]
    scores = [term_error.held_out.score for term_error in found.term_errors if term_error.held_out is not None]
    assert found.best_terms == 1 + scores.index(min(scores))


def test_sums_end_where_more_terms_make_them_worse(measured: ScatteredBrdf) -> None:
    found = find_by(measured, method="svd", products=6)
    errors = [term_error.held_out_rms_cosine_weighted for term_error in (*found.term_errors, *found.left_out)]
    assert len(errors) == 6
    assert found.best_terms == found.factors.terms == 1 + int(np.argmin(np.array(errors, float)))
    assert found.held_out_by == "regions"
    assert "Nothing was measured" in found.unmeasured
    assert found.term_errors[0].metrics.sq_log != found.term_errors[0].held_out_sq_log


def test_of_a_measurement_the_automatic_method_is_a_search_where_it_is_better(measured: ScatteredBrdf) -> None:
    found, searched = (find_by(measured, method=method, products=4) for method in ("auto", "search"))
    assert found.method == "search"
    assert [term_error.held_out for term_error in found.term_errors] == [
        term_error.held_out for term_error in searched.term_errors
    ]
    assert found.choice.startswith("The search was taken by its held-out errors")


@pytest.mark.parametrize("as_good", [True, False])
def test_sums_are_taken_where_they_are_as_good_as_the_search_and_as_mccool(
    measured: ScatteredBrdf, as_good: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    errors = iter([HeldOut(0.2, 0.2), HeldOut(0.1, 0.1)])  # of the search and of McCool's set
    if as_good:
        errors = iter([HeldOut(99.0, 99.0), HeldOut(99.0, 99.0)])

    def find_known(found: Factorisation) -> Factorisation:
        error = next(errors)
        term_error = replace(
            found.term_errors[0],
            held_out_rms_cosine_weighted=error.rms_cosine_weighted,
            held_out_sq_log=error.sq_log,
        )
        return replace(found, term_errors=(term_error,), left_out=())

    def quick(*_: Any) -> Any:
        yield Step(0.0, "")
        return find_known(fixed)

    fixed = find_by(measured, method="homomorphic")
    monkeypatch.setattr("engine.factor.factor._search", quick)
    monkeypatch.setattr("engine.factor.factor._fit_fixed", quick)
    found = find_by(measured, products=2)
    assert (found.method == "symmetric") is as_good
    assert found.choice.startswith("Sums of products" if as_good else "The search")


def test_the_norm_of_sums_is_that_of_the_least_held_out_errors(measured: ScatteredBrdf) -> None:
    found, *norms = (
        find_by(measured, method="svd", products=4, weighting=norm) for norm in ("auto", "plain", "cosine")
    )
    scores = [norm.term_errors[-1].held_out.score for norm in norms]  # type: ignore[union-attr]
    assert found.weighting == norms[int(np.argmin(scores))].weighting
    assert found.term_errors[-1].held_out.score == min(scores)  # type: ignore[union-attr]

"""Sums of Gaussians, wavelets and SH of one function: closed forms, laws, and an independent minimiser."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import minimize

from engine.core.directions import normalize
from engine.core.steps import drain
from engine.figures.figure import Settings, coarse_bust
from engine.figures.lobe_fit import (
    Sum,
    Tabulated,
    condense,
    gaussians,
    order_for,
    spherical_harmonics,
    texels,
    wavelets,
)
from engine.figures.papers.green_5 import TYPICAL, errors_of, function_of, green_5, verdict
from engine.transport.sh.basis import evaluate

DIRECTION, AREA = texels(32)


def some_gaussians(count: int, seed: int = 1) -> Sum:
    rng = np.random.default_rng(seed)
    mean = normalize(rng.standard_normal((count, 3)))
    return Sum(mean, rng.uniform(0.2, 0.4, count), rng.uniform(0.5, 2.0, count))


def table_of(own: Sum) -> Tabulated:
    return Tabulated(own.at(DIRECTION), DIRECTION, AREA)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_sums_of_gaussians_are_found_again(count: int) -> None:
    table = table_of(some_gaussians(count))
    found = drain(gaussians(table, count))
    assert table.distance(found[-1].at(DIRECTION)) < 1e-3
    if count == 1:
        assert np.linalg.norm(found[0].mean - some_gaussians(1).mean) < 1e-4
        assert found[0].sigma == pytest.approx(some_gaussians(1).sigma, rel=1e-4)


@pytest.mark.parametrize("typical", TYPICAL, ids=lambda typical: typical.slug)
def test_no_more_gaussians_are_farther_and_one_is_as_near_as_another_minimiser_finds(typical: object) -> None:
    function = function_of(typical, coarse_bust(9, 13))  # type: ignore[arg-type]
    table = Tabulated(function(DIRECTION), DIRECTION, AREA)
    sums = drain(gaussians(table, 4))
    errors = [table.distance(each.at(DIRECTION)) for each in sums]
    assert all(later <= earlier + 1e-4 for earlier, later in pairwise(errors))

    def leftover(parameters: np.ndarray) -> float:
        one = Sum(normalize(parameters[None, :3]), np.exp(parameters[3:4]), np.ones(1))
        shape = one.at(DIRECTION)
        height = max(float((AREA * shape) @ table.value / ((AREA * shape) @ shape)), 0.0)
        return table.distance(height * shape)

    peak = DIRECTION[np.argmax(table.value)]
    mean = normalize((table.value * AREA) @ DIRECTION)
    options = {"xatol": 1e-6, "fatol": 1e-9, "maxiter": 4000, "maxfev": 4000}
    others = [
        minimize(leftover, [*start, np.log(sigma)], method="Nelder-Mead", options=options).fun
        for start in (peak, mean)
        for sigma in (0.05, 0.3)
    ]
    assert errors[0] <= 1.05 * min(others)


def test_condensing_changes_neither_the_integral_nor_what_is_bright() -> None:
    table = table_of(Sum(np.array([[0.0, 0.0, 1.0]]), np.array([0.1]), np.ones(1)))
    few = condense(table)
    assert len(few.value) < len(table.value) / 4
    assert few.area.sum() == pytest.approx(4.0 * np.pi)
    assert few.area @ few.value == pytest.approx(table.area @ table.value, rel=1e-12)
    assert np.isin(table.value[table.value > 0.01], few.value).all()


def test_all_wavelets_are_the_function_and_fewer_are_the_nearest_of_their_number() -> None:
    rng = np.random.default_rng(3)
    table = Tabulated(rng.random(len(AREA)), DIRECTION, AREA)
    few, whole = wavelets(table, [20, len(AREA)])
    np.testing.assert_allclose(whole, table.value, atol=1e-12)
    # an orthonormal basis: what is kept and what is left are square-summed apart
    kept = AREA @ few**2
    assert table.distance(few) ** 2 == pytest.approx(1.0 - kept / (AREA @ table.value**2))


def test_harmonics_of_a_harmonic_are_that_harmonic() -> None:
    table = Tabulated(evaluate(4, DIRECTION)[:, 10], DIRECTION, AREA)
    expected = np.zeros(16)
    expected[10] = 1.0
    np.testing.assert_allclose(spherical_harmonics(table, 4), expected, atol=1e-12)


def test_harmonics_have_at_least_as_many_numbers() -> None:
    assert [order_for(numbers) for numbers in (7, 9, 10, 16, 70)] == [3, 3, 4, 4, 9]


def test_the_figure_says_where_gaussians_are_not_the_nearest() -> None:
    figure = drain(green_5(Settings(mesh=coarse_bust(9, 13), quick=True)))
    assert len(figure.plots) == 3
    assert len(figure.table) == 3 * 3 * 3
    for row in figure.rows:
        own = {line["by"]: line["error_l2_rel"] for line in figure.table if line["brdf"] in row.heading}
        stated = [shown.error.rmse_rel for shown in row.images if shown.error is not None]
        assert stated == list(own.values())
    assert verdict({"Gaussians": [0.5, 0.2], "Haar wavelets": [0.4, 0.3]}).endswith("Haar wavelets at 1.")
    assert "everywhere" in verdict({"Gaussians": [0.1], "Haar wavelets": [0.4]})


def test_errors_are_those_of_the_sums() -> None:
    table = table_of(some_gaussians(2, 4))
    sums = drain(gaussians(table, 2))
    errors = errors_of(table, sums)
    apart = sums[0].at(DIRECTION) - table.value
    assert errors["Gaussians"][0] == pytest.approx(np.sqrt((AREA @ apart**2) / (AREA @ table.value**2)))
    assert errors["Gaussians"][1] < 1e-3 < errors["Haar wavelets"][1]

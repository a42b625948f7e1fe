"""λ by samples that were held out: little where samples are dense, all of it where few were measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.brdf.resample import resample
from engine.core.steps import drain
from engine.factor.data import FactorData, factor_data
from engine.factor.homomorphic import LogSpace
from engine.factor.projections import FixedProjection
from engine.factor.solvers.least_squares import solve, term, with_smoothing
from engine.factor.solvers.least_squares_rows import rows_of
from engine.factor.textures import FALL, FALLS, Level, SearchSettings, measure_held_out
from tests.engine.factor.factored import blue_paint
from tests.engine.factor.test_projections import hemisphere

SETTINGS = SearchSettings(size=10, low_size=0)


def level_of(data: FactorData, settings: SearchSettings = SETTINGS) -> Level:
    level = Level(data, LogSpace.of(data.value), settings, settings.size)
    level.chosen = [FixedProjection("wi-dot-h-mean"), FixedProjection("wi-dot-h-mean-cosines")]
    level.solve_all()
    return level


def unseen(level: Level, data: FactorData) -> float:
    """Mean squared log error at samples that the textures were not made from."""
    other = level_of(data)
    other.textures = level.textures
    return other.get_chosen_error()


def test_dense_samples_of_a_formula_need_little() -> None:
    level = level_of(blue_paint(12_000, 55.0))
    settled, _ = drain(level.settle())
    assert settled.smoothing <= FALL * level.smoothing
    assert settled.smoothing >= FALL**FALLS * (1.0 - 1e-9) * level.smoothing
    fresh = factor_data(brdf_from_text("lafortune:preset=blue-paint"), 12_000, np.radians(55.0), seed=9)
    assert unseen(settled, fresh) < 0.97 * unseen(level, fresh)
    assert level.smoothing == SETTINGS.smoothing


def test_few_measurements_need_all_however_often_they_are_turned() -> None:
    """60 pairs, each 100 times at random azimuths: a copy in both parts would be known from the other."""
    rng = np.random.default_rng(3)
    wi, wo = hemisphere(60, 1), hemisphere(60, 2)
    value = brdf_from_text("ward:alpha_x=0.2,alpha_y=0.2").f(wi, wo) * np.exp(0.3 * rng.normal(size=(60, 1)))
    azimuth = 2.0 * np.pi * rng.random(6000)
    cosine, sine, zero = np.cos(azimuth), np.sin(azimuth), np.zeros(6000)
    turn = np.stack([cosine, -sine, zero, sine, cosine, zero, zero, zero, zero + 1.0], axis=-1).reshape(-1, 3, 3)
    wi, wo = (np.einsum("nij,nj->ni", turn, np.tile(side, (100, 1))) for side in (wi, wo))
    data = FactorData(wi, wo, np.tile(value, (100, 1)), np.tile(np.arange(60), 100))
    settled, _ = drain(level_of(data).settle())
    assert settled.smoothing == SETTINGS.smoothing
    alone = FactorData(data.wi, data.wo, data.value)
    assert drain(level_of(alone).settle())[0].smoothing < SETTINGS.smoothing


@pytest.mark.parametrize("share", [0.0, 1e-9])
def test_without_a_share_to_hold_out_nothing_changes(share: float) -> None:
    level = level_of(blue_paint(500), replace(SETTINGS, held_out=share))
    settled, _ = drain(level.settle())
    assert settled.smoothing == level.smoothing
    np.testing.assert_array_equal(settled.textures[0], level.textures[0])


def test_the_copies_of_a_measurement_bear_its_number() -> None:
    table = drain(resample(brdf_from_text("phong:exponent=5"), (6, 6, 12)))
    data = factor_data(table, 2000)
    numbers, counts = np.unique(data.measurement, return_counts=True)
    assert len(data) == 2000 // len(numbers) * len(numbers)
    assert (counts == 2000 // len(numbers)).all()
    first = data.part(np.flatnonzero(data.measurement == numbers[3]))
    assert len(np.unique(first.value, axis=0)) == 1
    np.testing.assert_allclose(first.wi[:, 2], first.wi[0, 2])


def test_measurements_are_held_out_whole() -> None:
    measurement = np.random.default_rng(0).integers(0, 40, 1000) * 7
    held = measure_held_out(measurement, 0.2, 1)
    assert set(measurement[held]).isdisjoint(measurement[~held])
    assert len(np.unique(measurement[held])) == len(np.unique(measurement)) // 5
    np.testing.assert_array_equal(held, measure_held_out(measurement, 0.2, 1))
    assert not measure_held_out(np.zeros(9, int), 0.2, 1).any()


def test_another_smoothing_is_that_of_a_term_made_with_it() -> None:
    rng = np.random.default_rng(0)
    rows = rows_of([rng.uniform(-1.0, 1.0, (300, 2))], 6)
    target, mask = rng.normal(size=(300, 3)), np.ones((6, 6), bool)
    made, changed = term(rows, target, mask, 1e-5), with_smoothing(term(rows, target, mask, 1e-2), 1e-3)
    np.testing.assert_allclose(changed.gram, made.gram, rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(changed.smoothing.weight, made.smoothing.weight, rtol=1e-12)
    textures = [solve([one], target, refine=True).textures[0] for one in (made, changed)]
    np.testing.assert_allclose(textures[0], textures[1], rtol=0.0, atol=1e-9)

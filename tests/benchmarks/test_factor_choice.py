"""The table of factors: what is worse than McCool's is counted, and samplings are those of instruments."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.factor_choice import INSTRUMENTS, largest_ratio, row, sample
from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.factor.errors import Metrics, TermError
from engine.factor.settings import FactorSettings

ERRORS = Metrics(0.1, 0.2, 0.3, 0.4, 0.5, 0.6)


def term_error(textures: int, rms: float, log: float) -> TermError:
    return TermError(textures, textures, 0.1, (), ERRORS, 1.0, 100, rms, log)


def test_each_number_of_textures_is_compared_with_as_many_and_the_last_with_all() -> None:
    sets = [term_error(1, 1.0, 1.0), term_error(2, 0.5, 0.8)]
    assert largest_ratio([term_error(1, 0.9, 0.9), term_error(2, 0.4, 0.4)], sets) == pytest.approx(0.9)
    assert largest_ratio([term_error(1, 0.9, 1.2), term_error(2, 0.4, 0.4)], sets) == pytest.approx(1.2)
    assert largest_ratio([term_error(1, 0.9, 0.9)], sets) == pytest.approx(1.8)
    assert largest_ratio([term_error(3, 0.4, 1.6)], sets) == pytest.approx(2.0)


@pytest.mark.parametrize("number", range(len(INSTRUMENTS)))
def test_samplings_are_as_sparse_as_measurements_and_the_same_for_a_seed(number: int) -> None:
    samples = sample(3, number)
    assert 200 <= len(samples.value) <= 1600
    assert samples.value.max() > 0.0
    assert np.array_equal(samples.value, sample(3, number).value)
    assert not np.array_equal(samples.value.shape, sample(4, number).value.shape) or not np.array_equal(
        samples.value, sample(4, number).value
    )


@pytest.mark.long
def test_a_row_has_the_errors_of_all_three() -> None:
    small = FactorSettings(samples=500, size=8, textures=2, restarts=0)
    found = drain(row("phong", brdf_from_text("phong"), small))
    assert found.error <= 1.0 + 1e-9 == found.bound
    assert found.more["default_size_bytes"] <= 2 * 8 * 8 * 12
    assert found.more["sums_held_out_sq_log"] > 0.0

"""The choice of a plan beside the best of all settings."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchmarks.transport.choice import DEARER, FEW, Chosen, _count, _settings, choices, summary
from benchmarks.transport.predictions import EVERY
from engine.accuracy.compare import ErrorEstimate
from engine.core.steps import drain
from engine.planning.costs.setting import Setting
from engine.transport import method as transport

SH, GAUSSIAN = Setting("sh", {"order": 3}), Setting("gaussian", {"lobes": 2})
ROW = Chosen(4, "a ball under a sky", 0.05, SH, 0.06, GAUSSIAN, 0.04, 1.4, 9)


@pytest.mark.parametrize(("error", "counted"), [(0.02, 3.0), (0.05, 3.0), (0.1, 12.0), (0.2, 48.0)])
def test_beyond_the_budget_twice_the_error_counts_four_times(error: float, counted: float) -> None:
    choice: Any = SimpleNamespace(price=3.0)
    assert _count(choice, ErrorEstimate(error, 0.0), 0.05) == pytest.approx(counted)


def test_an_uncertain_error_counts_as_the_least_that_it_may_be() -> None:
    choice: Any = SimpleNamespace(price=3.0)
    assert _count(choice, ErrorEstimate(0.07, 0.02), 0.05) == pytest.approx(3.0)


def test_a_row_names_both_settings_and_the_last_one_the_share() -> None:
    rows = summary([ROW, Chosen(5, "a ball", 0.05, SH, 0.04, SH, 0.04, 1.0, 9)])
    assert [each.name for each in rows] == ["choice-4", "choice-5", "choices-dearer"]
    assert rows[0].error > DEARER >= rows[1].error
    assert "sh, order 3" in rows[0].what
    assert "best of 9: gaussian, lobes 2" in rows[0].what
    assert rows[-1].error == 0.5


def test_a_seed_draws_the_same_settings_and_few_of_many_sweeps() -> None:
    every, some = (_settings(seed, np.random.default_rng(1)) for seed in (EVERY, EVERY + 1))
    assert every == _settings(EVERY, np.random.default_rng(1))
    assert {each.mode for each in every} == {"direct", *transport.names()}
    assert {each.mode for each in some} == {"direct", *transport.names()} - {transport.names()[-1]}
    assert sum(each.mode == "wavelet" for each in every) == FEW
    assert all(each.parameters.get("interreflection", 0) == 0 for each in every)


@pytest.mark.long
def test_choices_are_nearly_the_best_of_all_settings(tmp_path: Path) -> None:
    rows = drain(choices(tmp_path, scenes=50, seed=300))
    dearer = next(each for each in rows if each.name == "choices-dearer")
    assert dearer.error <= (dearer.bound or 0.0), "\n".join(f"{each.error:.3g} {each.what}" for each in rows)

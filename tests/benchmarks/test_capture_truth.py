"""The acquisition against known truths, on captures small enough for a test."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks import capture_truth
from engine.core.steps import drain

PROMISED = {"flat-field", "near-lamp", "exposure-merge", "sphere-direction-deg"}


@pytest.fixture(scope="module")
def errors(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(capture_truth, "SIZE", 64)
        patch.setattr(capture_truth, "SPHERE_SIZE", 256)
        patch.setattr(capture_truth, "BETWEEN_DEG", (15.0, 85.0))
        patch.setattr(capture_truth, "SAMPLES", ("woven", "plain"))
        found = drain(capture_truth.measures(tmp_path_factory.mktemp("truth")))
    return {accuracy.name: accuracy for accuracy in found}


def test_every_promise_is_kept(errors: dict[str, Any]) -> None:
    bounded = {name for name, found in errors.items() if found.bound is not None}
    assert bounded == {*PROMISED, "radiance-woven", "radiance-plain"}
    assert {name: errors[name].error for name in bounded if errors[name].error > errors[name].bound} == {}


def test_radiance_is_no_nearer_to_the_truth_than_the_noise_allows(errors: dict[str, Any]) -> None:
    """At a ratio of 100 the noise alone is 1 %; an error far below would mean that the truth looks at itself."""
    for name in ("woven", "plain"):
        assert 0.002 < errors[f"radiance-{name}"].error < 0.01


def test_a_flat_card_is_rendered_within_the_noise_and_relief_is_not(errors: dict[str, Any]) -> None:
    assert errors["rendering-plain"].error < 0.01 < errors["rendering-woven"].error < 0.3


def test_squares_leave_out_what_is_dark_or_clipped() -> None:
    clean = np.array([[[0.5, 0.01, 1.2]]], np.float32)
    squares = capture_truth._squares(clean * np.float32(1.1), clean, 0.004)
    np.testing.assert_allclose(squares, [0.01], rtol=1e-4)

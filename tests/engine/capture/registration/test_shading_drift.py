"""Knocks of the camera distinguished from shading drift."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.capture.registration.arc_motion import without_shading_drift

COUNT, REFERENCE = 10, 9
DISTANCE = np.linspace(0.0, 1.5, COUNT)
#: Drift as simulated leather shows it, a bump of one and a half pixels, and errors for which small jumps fit better.
DRIFT = np.stack([1.5 * np.sin(np.pi * DISTANCE / 1.5), 0.4 * DISTANCE], axis=1)
DRIFT += np.random.default_rng(1).normal(0, 0.08, DRIFT.shape)


def find(jumps: Any) -> Any:
    moved = DRIFT + jumps
    return without_shading_drift(moved - moved[REFERENCE], DISTANCE, REFERENCE)


def test_drift_alone_moves_nothing() -> None:
    kept, doubt = find(np.zeros((COUNT, 2)))
    assert not kept.any()
    assert not doubt.any()


@pytest.mark.parametrize("size", [0.5, 3.0])
def test_a_knock_is_kept(size: float) -> None:
    jumps = np.zeros((COUNT, 2))
    jumps[4] = size, -size
    kept, _ = find(jumps)
    assert np.abs(kept - jumps).max() < 0.15


def test_two_knocks_leave_the_others_alone() -> None:
    jumps = np.zeros((COUNT, 2))
    jumps[2], jumps[6] = (2.0, 1.0), (-1.5, 3.0)
    kept, doubt = find(jumps)
    assert np.abs(kept - jumps).max() < 0.2
    assert doubt.max() < 0.3


def test_motion_indistinguishable_from_shading_drift_is_left_and_doubted() -> None:
    """Jumps of a tenth of a pixel along drift that is not smooth."""
    moved = DRIFT + np.random.default_rng(4).normal(0, 0.15, DRIFT.shape)
    kept, doubt = without_shading_drift(moved - moved[REFERENCE], DISTANCE, REFERENCE)
    assert not kept.any() or (kept**2).mean() > (doubt**2).mean()


@given(st.integers(0, 10_000), st.integers(5, 14))
@settings(max_examples=15)
def test_the_order_of_axes_and_the_sign_do_not_matter(seed: int, count: int) -> None:
    random = np.random.default_rng(seed)
    moved, distance = random.normal(0, 1, (count, 2)), np.cumsum(random.uniform(0.05, 0.4, count))
    moved -= moved[1]
    kept, doubt = without_shading_drift(moved, distance, 1)
    other, same = without_shading_drift(-moved[:, ::-1], distance, 1)
    np.testing.assert_allclose(other, -kept[:, ::-1], atol=1e-9)
    np.testing.assert_allclose(same, doubt, atol=1e-9)


def test_a_camera_that_always_moves_leaves_doubt_that_covers_the_error() -> None:
    errors, doubts = [], []
    for seed in range(20):
        jumps = np.random.default_rng(seed).normal(0, 1.5, (COUNT, 2))
        kept, doubt = find(jumps)
        errors.append(kept - (jumps - jumps[REFERENCE]))
        doubts.append(doubt)
    assert np.array(doubts)[:, REFERENCE].max() == 0.0
    error = np.sqrt(np.mean(np.square(errors), axis=(0, 2)))[:REFERENCE]
    expected = np.sqrt(np.mean(np.square(doubts), axis=0))[:REFERENCE]
    assert (error < 2.0 * expected).all()
    assert (expected < 3.0 * error).all()

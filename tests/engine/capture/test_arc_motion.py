"""What of a motion is taken for knocks of the camera, and what for shading that creeps."""

import numpy as np
import pytest

from engine.capture.arc_motion import without_creep

COUNT, REFERENCE = 10, 9
DISTANCE = np.linspace(0.0, 1.5, COUNT)
#: Creep as simulated leather shows it, a bump of one and a half pixels, and errors for which small jumps fit better.
CREEP = np.stack([1.5 * np.sin(np.pi * DISTANCE / 1.5), 0.4 * DISTANCE], axis=1)
CREEP += np.random.default_rng(1).normal(0, 0.08, CREEP.shape)


def found(jumps):
    moved = CREEP + jumps
    return without_creep(moved - moved[REFERENCE], DISTANCE, REFERENCE)


def test_creep_alone_moves_nothing():
    kept, doubt = found(np.zeros((COUNT, 2)))
    assert not kept.any()
    assert not doubt.any()


@pytest.mark.parametrize("size", [0.5, 3.0])
def test_a_knock_is_kept(size):
    jumps = np.zeros((COUNT, 2))
    jumps[4] = size, -size
    kept, _ = found(jumps)
    error = kept - jumps
    assert np.abs(error[4] - (error[3] + error[5]) / 2).max() < 0.25 * size


def test_a_camera_that_always_moves_leaves_doubt_that_covers_the_error():
    errors, doubts = [], []
    for seed in range(20):
        jumps = np.random.default_rng(seed).normal(0, 1.5, (COUNT, 2))
        kept, doubt = found(jumps)
        errors.append(kept - (jumps - jumps[REFERENCE]))
        doubts.append(doubt)
    assert np.array(doubts)[:, REFERENCE].max() == 0.0
    error = np.sqrt(np.mean(np.square(errors), axis=(0, 2)))[:REFERENCE]
    expected = np.sqrt(np.mean(np.square(doubts), axis=0))[:REFERENCE]
    assert (error < 2.0 * expected).all()
    assert (expected < 3.0 * error).all()

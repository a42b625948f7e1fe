"""Directions that are held out, and the error that a map has of them."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.held_out import AZIMUTHS, DENSE, ELEVATIONS, _between, _error, _grid
from engine.core.colour import srgb_decode
from engine.core.directions import surface_direction
from engine.core.steps import drain


def test_directions_that_are_held_out_are_lamps_of_no_dome() -> None:
    lamps = np.array([*_grid(AZIMUTHS, ELEVATIONS), *_grid(*DENSE)])
    towards = surface_direction(0.5 * np.pi - lamps[:, 0], lamps[:, 1])
    assert len(_between()) == 32
    for up, around in _between():
        wanted = surface_direction(0.5 * np.pi - up, around)
        assert (towards @ wanted).max() < np.cos(np.radians(3.0))
        assert lamps[:, 0].min() < up < lamps[:, 0].max()


def test_the_error_is_that_of_what_a_map_cannot_show() -> None:
    """Codes that are linear in the direction are predicted exactly, so what is added to the truth is all of the error.

    With 12 lamps the trend of kriging has three terms.
    """
    lights = _grid(4, 3)
    rng = np.random.default_rng(2)
    slope = rng.normal(0.0, 20.0, (3, 6, 7, 3))

    def image(up: float, around: float) -> np.ndarray:
        direction = surface_direction(0.5 * np.pi - up, around)
        return np.asarray(120.0 + np.einsum("i,ihwc->hwc", direction, slope))

    images = np.stack([image(*light) for light in lights])
    wanted = [(0.7, 0.3), (0.9, 2.0)]
    truth = np.stack([image(*light) for light in wanted])
    photographs = srgb_decode(images / 255.0).astype(np.float32)
    exact = drain(_error(photographs, lights, srgb_decode(truth / 255.0).astype(np.float32), wanted))
    assert exact < 1.0
    off = drain(_error(photographs, lights, srgb_decode((truth + 10.0) / 255.0).astype(np.float32), wanted))
    assert off == pytest.approx(10.0, abs=1.0)

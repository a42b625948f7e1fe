"""Filters in bands give the bits that they give of whole maps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.surface import bands, height
from engine.surface.depth_edges import Division
from engine.surface.regularise import smooth_roughness, weigh_neighbours

Array = NDArray[Any]

DRAW = np.random.default_rng(1)
SHAPE = (75, 21)
ONE, OTHER, SLOPE = DRAW.random(SHAPE, np.float32), DRAW.random(SHAPE, np.float32), DRAW.random((*SHAPE, 2), np.float32)
OUTSIDE = DRAW.random(SHAPE) < 0.2
OUTSIDE[30:60, :15] = True


def disagree(division: Division | None) -> tuple[Array, Array]:
    right, up = (SLOPE[..., axis].astype(np.float64) for axis in (0, 1))
    return height.disagreement(ONE.astype(np.float64), right, up, OTHER.astype(np.float64) + 0.1, division)


@pytest.mark.parametrize(
    "work",
    [
        lambda: smooth_roughness(ONE, 0.3 * OTHER**2, OUTSIDE),
        lambda: weigh_neighbours(20.0 * ONE, 9.0, OUTSIDE),
        lambda: height.lens_variance(ONE),
        lambda: height.shift_variance(ONE, 0.3),
        lambda: height.estimate_unresolved(SLOPE),
        lambda: disagree(None),
        lambda: disagree(Division(OUTSIDE, np.zeros(SHAPE, np.int32))),
    ],
    ids=["roughness", "metallic", "lens", "shift", "unresolved", "disagreement", "disagreement with edges"],
)
@pytest.mark.parametrize("rows", [1, 13, 74])
def test_filters_are_those_of_whole_maps(work: Callable[[], Any], rows: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bands, "BAND", SHAPE[0])
    whole = work()
    monkeypatch.setattr(bands, "BAND", rows)
    np.testing.assert_array_equal(work(), whole)

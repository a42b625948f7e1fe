"""Alignment of photographs that were moved by known motions of each kind, under a lamp that moves as well."""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest

from benchmarks import alignment as truth
from engine.capture.registration.align import align
from engine.capture.registration.pair_motion import MOTIONS
from engine.core.colour import luminance
from engine.core.steps import drain
from engine.simulate.arc import ELEVATIONS_DEG, LightArc
from engine.simulate.simulate import renderings

SIZE = 288


@pytest.fixture(autouse=True)
def _small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(truth, "SIZE", SIZE)
    monkeypatch.setattr(truth, "BORDER", 16)


@cache
def arc(sample: Any) -> list[Any]:
    angles = [math.radians(angle) for angle in ELEVATIONS_DEG]
    images = drain(renderings(LightArc(sample, size=SIZE + 32, misalignment_px=0.0, interreflection=False), angles))
    return [luminance(image).astype(np.float32) for image in images]


def errors(sample: Any, motion: str, shift_px: Any, count: int) -> tuple[Any, Any, Any]:
    """(before, after), each relative to the reference and to the photographs' mean, in pixels; and the alignment."""
    photographs, known = truth.move(arc(sample), motion, shift_px, count)
    found = drain(align(photographs, [f"{angle:g}" for angle in ELEVATIONS_DEG], motion))
    before = truth.errors_px(None, known, found.reference)
    return before, truth.errors_px(found, known, found.reference), found


@pytest.mark.parametrize("motion", MOTIONS)
def test_AL3_a_still_camera_under_a_moving_lamp_is_left_alone(motion: str) -> None:
    photographs, _ = truth.move(arc("woven"), motion, 0.0, 0)
    found = drain(align(photographs, list("abcdefghij"), motion))
    assert np.array_equal(found.matrix, np.tile(np.eye(3), (10, 1, 1)))


@pytest.mark.parametrize("motion", MOTIONS)
def test_AL3_motions_of_each_kind_are_found_under_a_moving_lamp(motion: str) -> None:
    """Woven cloth repeats after 53 px, of which none must be jumped."""
    before, after, found = errors("woven", motion, 3.0, 10)
    assert found.aligned.all()
    assert after[0] < 0.3 * before[0]
    assert after[1] < 0.2 * before[1]


@pytest.mark.parametrize("motion", ["translation", "euclidean"])
def test_AL3_two_knocks_are_undone_and_the_others_left_alone(motion: str) -> None:
    before, after, _ = errors("woven", motion, 3.0, 2)
    assert after[0] < 0.1 * before[0]


@pytest.mark.parametrize("shift_px", [0.6, 3.0])
def test_AL3_leather_whose_pebbles_drift_does_not_become_worse(shift_px: float) -> None:
    before, after, _ = errors("leather", "translation", shift_px, 10)
    assert after[0] < before[0]
    assert after[1] < before[1]

"""Differences as colours and their scale."""

from __future__ import annotations

import numpy as np
import pytest

from engine.accuracy.difference import MINIMUM, compute_signed_difference, label, scale_of
from engine.core.colour import luminance
from engine.render.display import diverging


def test_colours_say_the_sign_and_grow_with_the_difference() -> None:
    blue, bluish, grey, warm, orange = diverging(np.array([-1.0, -0.5, 0.0, 0.5, 1.0])).astype(int)
    assert grey.tolist() == [219, 219, 219]
    assert blue[2] > blue[0]
    assert orange[0] > orange[2]
    assert abs(bluish - grey).sum() < abs(blue - grey).sum()
    assert abs(warm - grey).sum() < abs(orange - grey).sum()
    assert np.array_equal(diverging(np.array([-9.0, 9.0, np.nan])), [blue, orange, grey])


@pytest.mark.parametrize(
    ("value", "scale"), [(0.9, 1.0), (1.0, 1.0), (1.1, 2.0), (3.0, 5.0), (7.0, 10.0), (0.04, 0.05)]
)
def test_the_scale_is_round_and_holds_the_differences(value: float, scale: float) -> None:
    assert scale_of(np.full((4, 4), -value)) == pytest.approx(scale)


def test_the_scale_of_nothing_is_the_least() -> None:
    assert scale_of(np.zeros((3, 3))) == MINIMUM
    assert scale_of(np.array([np.nan, np.inf])) == MINIMUM


def test_the_difference_is_that_of_luminance_with_its_sign() -> None:
    a, b = np.random.default_rng(0).random((2, 5, 6, 3))
    apart, scale = compute_signed_difference(a, b)
    assert np.allclose(apart, luminance(a) - luminance(b), rtol=0, atol=1e-15)
    assert np.abs(apart).max() <= scale * 1.01


def test_the_bar_below_shows_the_ends_of_the_scale() -> None:
    image = label(np.linspace(-1.0, 1.0, 300 * 20).reshape(20, 300), 1.0)
    assert image.shape == (76, 300, 3)
    assert np.array_equal(image[38, 12], diverging(np.array(-1.0)))
    assert np.array_equal(image[38, 287], diverging(np.array(1.0)))
    assert np.array_equal(image[0, 0], diverging(np.array(-1.0)))
    assert label(np.zeros((3, 4)), 1.0).shape == (59, 256, 3)

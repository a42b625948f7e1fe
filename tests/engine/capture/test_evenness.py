"""Brightness that changes slowly over the photographs: known falloffs are divided out, textures and colours stay."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from engine.capture.evenness import DEGREE, divide, even_out, slow_change
from engine.capture.stack import ImageStack
from engine.core.colour import LUMINANCE
from engine.core.steps import drain

HEIGHT, WIDTH = 96, 160


def weave() -> NDArray[np.float64]:
    """A texture whose blocks all have the same mean: it repeats with the blocks of 6 × 10 pixels."""
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH]
    return (0.5 + 0.4 * ((rows % 6 < 3) ^ (columns % 10 < 5)))[..., None] * np.array([0.9, 0.6, 0.3])


def lamp(distance: float, towards: tuple[float, float]) -> NDArray[np.float64]:
    """cos θ / d² of a lamp at a distance in widths of the sample, above a point beside its middle, (H, W, 1)."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH] / WIDTH - np.array([[[0.5 * HEIGHT / WIDTH]], [[0.5]]])
    d2 = (x - towards[0]) ** 2 + (y - towards[1]) ** 2 + distance**2
    return (distance / d2**1.5)[..., None]


def stack_of(*photographs: NDArray[np.float64]) -> ImageStack:
    radiance = np.stack(photographs).astype(np.float32)
    return ImageStack(
        radiance=radiance,
        saturated=np.zeros(radiance.shape[:3], np.bool_),
        elevation=np.radians(np.linspace(10.0, 80.0, len(radiance))),
        azimuth=None,
        mean_radiance=radiance.astype(np.float64).mean(axis=(1, 2)) @ LUMINANCE,
        sources=tuple(f"{place}.tif" for place in range(len(radiance))),
        angle_source="user",
    )


def relative(one: NDArray[np.float32], other: NDArray[np.float64]) -> float:
    """The largest difference where both have the same mean, over that mean."""
    scaled = other * (one.mean() / other.mean())
    return float(np.abs(one - scaled).max() / one.mean())


def test_a_change_that_the_polynomial_has_goes_to_the_last_digit() -> None:
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH] / np.array([[[HEIGHT / 2]], [[WIDTH / 2]]]) - 1.0
    even = np.full((HEIGHT, WIDTH, 3), 0.4)
    photograph = (even * np.exp(0.5 * x - 0.3 * y)[..., None]).astype(np.float32)
    assert relative(divide(photograph, slow_change(photograph)), even) < 3e-3


@pytest.mark.parametrize("distance", [0.8, 1.5, 4.0])
def test_the_falloff_of_near_lamps_goes_and_the_weave_stays(distance: float) -> None:
    texture = weave()
    lit = texture * lamp(distance, (0.4, 0.1))
    before = relative(lit.astype(np.float32), texture)
    evened_stack, health = drain(even_out(stack_of(lit)))
    assert relative(evened_stack.radiance[0], texture) < min(0.02, 0.1 * before)
    field = lamp(distance, (0.4, 0.1))
    assert health.figures["unevenness"] == pytest.approx(np.ptp(field) / field.mean(), rel=0.03)


def test_an_even_photograph_stays_as_it_is() -> None:
    texture = weave()
    evened_stack, health = drain(even_out(stack_of(texture)))
    np.testing.assert_allclose(evened_stack.radiance[0], texture, rtol=1e-6)
    assert health.figures["unevenness"] < 1e-6


def test_means_and_colours_stay_and_the_worst_is_named() -> None:
    stack = stack_of(weave() * lamp(4.0, (0.0, 0.0)), weave() * lamp(0.8, (0.5, 0.0)), weave())
    evened_stack, health = drain(even_out(stack))
    before, after = (np.asarray(each.radiance[:]) for each in (stack, evened_stack))
    np.testing.assert_allclose(evened_stack.mean_radiance, stack.mean_radiance, rtol=1e-6)
    means = after.astype(np.float64).mean(axis=(1, 2)) @ LUMINANCE
    np.testing.assert_allclose(means, stack.mean_radiance, rtol=1e-6)
    shares = [each / each.sum(axis=-1, keepdims=True) for each in (before, after)]
    np.testing.assert_allclose(shares[1], shares[0], rtol=1e-5)
    assert [finding.source for finding in health.findings] == ["1.tif"]


def test_twice_is_once() -> None:
    once, _ = drain(even_out(stack_of(weave() * lamp(0.8, (0.4, 0.2)))))
    twice, health = drain(even_out(once))
    np.testing.assert_allclose(twice.radiance[0], once.radiance[0], rtol=0.01)
    assert health.figures["unevenness"] < 0.01


@given(seed=st.integers(0, 2**31), factor=st.floats(1e-3, 1e3))
def test_brightness_of_the_whole_does_not_matter(seed: int, factor: float) -> None:
    photograph = np.random.default_rng(seed).uniform(0.1, 1.0, (40, 60, 3)).astype(np.float32)
    brighter = photograph * np.float32(factor)
    np.testing.assert_allclose(slow_change(brighter), slow_change(photograph), atol=1e-4)


@pytest.mark.parametrize("photograph", [np.zeros((40, 60, 3)), np.full((4 * DEGREE, 60, 3), 0.5)])
def test_the_black_and_the_small_stay(photograph: NDArray[np.float64]) -> None:
    evened_stack, health = drain(even_out(stack_of(photograph)))
    np.testing.assert_array_equal(evened_stack.radiance[0], photograph.astype(np.float32))
    assert health.figures["unevenness"] == 0.0


def test_no_place_is_brightened_without_bound() -> None:
    """Half of the photograph lies in black shadow, which no division can light."""
    half = weave()
    half[:, WIDTH // 2 :] *= 1e-6
    evened_stack, _ = drain(even_out(stack_of(half)))
    assert np.isfinite(evened_stack.radiance[0]).all()
    assert evened_stack.radiance[0][:, -10:].max() < 1e-3


def test_an_object_before_a_dark_background_is_doubted_and_a_near_lamp_is_not() -> None:
    before_black = weave()
    before_black[:, : WIDTH // 4] *= 1e-3
    before_black[:, -WIDTH // 4 :] *= 1e-3
    assert drain(even_out(stack_of(weave() * lamp(0.5, (0.5, 0.0)))))[1].warnings == []
    (warning,) = drain(even_out(stack_of(before_black)))[1].warnings
    assert "dark background" in warning

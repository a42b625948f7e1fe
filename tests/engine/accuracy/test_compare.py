"""Errors of images: closed forms, laws, and the package of ꟻLIP as it is called on whole images."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.accuracy.compare import ImageError, compare, error_against, error_against_parts, noise_of
from engine.accuracy.flip import flip_estimate, flip_map
from engine.core.steps import drain

RNG = np.random.default_rng(3)


def image(height: int = 40, width: int = 52, seed: int = 0) -> np.ndarray:
    """Radiance from 0.01 to 4 with structure at all scales."""
    return (0.01 + 4.0 * np.random.default_rng(seed).random((height, width, 3)) ** 3).astype(np.float32)


def test_identical_images_have_no_error() -> None:
    one = image()
    assert compare(one, one.copy()) == ImageError(0.0, 0.0, 0.0, 40 * 52)


@pytest.mark.parametrize("gain", [0.5, 0.99, 1.01, 3.0])
def test_a_gain_is_the_relative_error_itself(gain: float) -> None:
    one = image().astype(np.float64)
    found = compare(gain * one, one)
    assert found.rmse_rel == pytest.approx(abs(gain - 1.0), rel=1e-12)
    assert found.max_abs == pytest.approx(abs(gain - 1.0) * one.max(), rel=1e-12)
    assert 0.0 < found.flip < 1.0


def test_a_single_channel_of_a_single_pixel() -> None:
    one = np.full((10, 10, 3), 2.0)
    other = one.copy()
    other[3, 4, 1] = 5.0
    found = compare(other, one)
    assert found.rmse_rel == pytest.approx(3.0 / (2.0 * np.sqrt(300.0)), rel=1e-12)
    assert found.max_abs == 3.0


def test_only_the_mask_counts() -> None:
    one = image()
    other, mask = 1.25 * one, np.zeros(one.shape[:2], bool)
    mask[5:20, 5:20] = True
    other[~mask] = 1e6
    found = compare(other, one, mask)
    assert found.rmse_rel == pytest.approx(0.25, rel=1e-6)
    assert found.pixels == 225


def test_what_is_not_finite_is_counted_and_left_out() -> None:
    one, other = image(), 1.5 * image()
    other[0, :7] = np.nan
    other[1, 0, 2] = np.inf
    found = compare(other, one)
    assert (found.invalid_pixels, found.pixels) == (8, 40 * 52 - 8)
    assert found.rmse_rel == pytest.approx(0.5, rel=1e-6)
    assert np.isfinite(found.flip)


def test_a_black_reference() -> None:
    black = np.zeros((20, 20, 3), np.float32)
    assert compare(black, black) == ImageError(0.0, 0.0, 0.0, 400)
    found = compare(black + 1.0, black)
    assert found.rmse_rel == np.inf
    assert (found.max_abs, found.pixels) == (1.0, 400)
    assert found.flip > 0.5
    assert compare(black, black + 1.0).rmse_rel == 1.0


@pytest.mark.parametrize("scale", [1e-35, 1e-20, 1e20, 1e35])
def test_extreme_radiance_neither_overflows_nor_vanishes(scale: float) -> None:
    one = image(8, 8)
    found = compare(np.float32(1.1) * one * np.float32(scale), one * np.float32(scale))
    assert found.rmse_rel == pytest.approx(0.1, rel=1e-4)
    assert np.isfinite(found.flip)


@pytest.mark.parametrize(
    ("a", "b", "mask", "words"),
    [
        (image(4, 5), image(5, 4), None, "cannot be compared"),
        (image(4, 5)[..., 0], image(4, 5), None, "cannot be compared"),
        (image(4, 5), image(4, 5), np.zeros((4, 5), bool), "selects no pixel"),
        (image(4, 5), image(4, 5), np.ones((5, 5), bool), "does not fit"),
        (np.full((4, 5, 3), np.nan), image(4, 5), None, "no pixel is finite"),
    ],
)
def test_what_cannot_be_compared_is_refused(a: Any, b: Any, mask: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        compare(a, b, mask)


@settings(max_examples=8)
@given(gain=st.floats(1e-3, 1e3), seed=st.integers(0, 9), turns=st.integers(0, 3))
def test_the_unit_of_radiance_and_the_orientation_change_nothing(gain: float, seed: int, turns: int) -> None:
    one, other = image(24, 24, seed).astype(np.float64), image(24, 24, seed + 50).astype(np.float64)
    found, scaled = compare(other, one), compare(gain * np.rot90(other, turns), gain * np.rot90(one, turns))
    assert scaled.rmse_rel == pytest.approx(found.rmse_rel, rel=1e-9)
    assert scaled.flip == pytest.approx(found.flip, abs=2e-4)


def test_a_larger_error_is_a_larger_figure() -> None:
    one = image()
    noise = RNG.normal(0.0, 1.0, one.shape).astype(np.float32) * one
    found = [compare(one + share * noise, one) for share in (0.01, 0.03, 0.1, 0.3)]
    for name in ("rmse_rel", "flip", "max_abs"):
        values = [getattr(error, name) for error in found]
        assert values == sorted(values)
        assert values[0] > 0.0


@pytest.mark.parametrize("displayed", [False, True])
@pytest.mark.parametrize("tile", [41, *(pytest.param(tile, marks=pytest.mark.long) for tile in (64, 512))])
def test_flip_in_tiles_is_flip_of_the_whole(displayed: bool, tile: int) -> None:
    import flip_evaluator

    one, other = image(90, 110), 1.1 * image(90, 110) + 0.02 * image(90, 110, 8)
    if displayed:
        one, other = np.clip(one, 0.0, 1.0), np.clip(other, 0.0, 1.0)
    whole, mean, _ = flip_evaluator.evaluate(
        one, other, "LDR" if displayed else "HDR", inputsRGB=False, applyMagma=False
    )
    found = drain(flip_map(other, one, displayed=displayed, tile=tile))
    assert np.abs(found - whole[..., 0]).max() <= 1e-4
    assert compare(other, one, displayed=displayed).flip == pytest.approx(mean, abs=1e-5)


def test_flip_of_even_images_is_the_closed_form_of_the_paper() -> None:
    """Andersson et al. 2020: 0.7th power of the HyAB distance with Hunt's effect, of which 40 % become 95 %."""
    black, white = np.zeros((64, 64, 3), np.float32), np.ones((64, 64, 3), np.float32)
    green, blue = white * (0, 1, 0), white * (0, 0, 1)
    largest = (87.735 - 32.297 + np.hypot(0.01 * 87.735 * -86.183 - 0.01 * 32.297 * 79.188, 107.83)) ** 0.7
    expected = 0.95 + 0.05 * (100.0**0.7 - 0.4 * largest) / (0.6 * largest)
    assert compare(green, blue, displayed=True).flip == pytest.approx(1.0, abs=1e-4)
    assert compare(white, black, displayed=True).flip == pytest.approx(expected, abs=1e-4)


def test_an_estimate_from_some_tiles_is_near_the_mean_and_exact_from_all() -> None:
    one = image(300, 320)
    other = one * (1.0 + 0.1 * image(300, 320, 8) / 4.0)
    mask = np.ones(one.shape[:2], bool)
    exact = compare(other, one).flip
    assert drain(flip_estimate(other, one, mask, 6)) == pytest.approx(exact, rel=0.05)
    assert drain(flip_estimate(other, one, mask, 99)) == pytest.approx(exact, abs=1e-5)


def test_flip_of_pixels_outside_the_mask_is_not_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    import flip_evaluator

    calls: list[Any] = []
    evaluate = flip_evaluator.evaluate
    monkeypatch.setattr(
        flip_evaluator, "evaluate", lambda *words, **more: cast(Any, calls).append(1) or evaluate(*words, **more)
    )
    mask = np.zeros((128, 128), bool)
    mask[70:80, 70:80] = True
    drain(flip_map(image(128, 128, 1), image(128, 128), mask, displayed=True, tile=64))
    assert len(calls) == 1


def test_the_uncertainty_of_a_reference_holds_as_often_as_it_says() -> None:
    """Over 400 noisy references of one truth, 95 % of the intervals hold the true error, and noise adds no bias.

    The channels of a pixel rise and fall together, as those of Monte Carlo do; were they independent, intervals would
    be too wide and never too narrow.
    """
    rng = np.random.default_rng(11)
    truth = image(16, 16).astype(np.float64)
    shown = truth * (1.0 + 0.05 * rng.normal(size=(*truth.shape[:2], 1)))
    exact = float(np.linalg.norm(shown - truth) / np.linalg.norm(truth))
    variance = (0.04 * truth) ** 2
    noise = np.sqrt(variance) * rng.normal(size=(400, *truth.shape[:2], 1))
    found = [error_against(shown, truth + one, variance) for one in noise]
    held = np.mean([abs(error.rmse_rel - exact) <= error.uncertainty for error in found])
    assert 0.92 <= held <= 0.98
    apart = np.sqrt(variance) * rng.normal(size=(100, *truth.shape))
    independent = [error_against(shown, truth + one, variance) for one in apart]
    assert np.mean([abs(error.rmse_rel - exact) <= error.uncertainty for error in independent]) >= 0.95
    assert np.mean([error.rmse_rel for error in found]) == pytest.approx(exact, rel=0.01)


@pytest.mark.parametrize("count", [4, 8])
@pytest.mark.parametrize("relative_to_a", [False, True])
def test_independent_parts_tell_the_error_without_knowing_the_noise(count: int, relative_to_a: bool) -> None:
    """Over 300 sets of parts whose noise is skewed, at least 92 % of the intervals hold the error, without bias."""
    rng = np.random.default_rng(12)
    truth = image(16, 16).astype(np.float64)
    shown = truth * (1.0 + 0.08 * rng.normal(size=(*truth.shape[:2], 1)))
    exact = float(np.linalg.norm(shown - truth) / np.linalg.norm(shown if relative_to_a else truth))
    noise = 0.1 * truth * (rng.exponential(size=(300, count, *truth.shape[:2], 1)) - 1.0)
    found = [error_against_parts(shown, truth + one, relative_to_a=relative_to_a) for one in noise]
    held = np.mean([abs(error.rmse_rel - exact) <= error.uncertainty for error in found])
    assert held >= 0.92
    assert np.mean([error.rmse_rel**2 for error in found]) == pytest.approx(exact**2, rel=0.05)
    assert np.median([error.uncertainty for error in found]) < 0.5 * exact
    with pytest.raises(ValueError, match="2 parts"):
        error_against_parts(shown, truth + noise[0][:2])


def test_an_exact_image_against_noise_has_an_error_within_its_uncertainty_of_0() -> None:
    rng, truth = np.random.default_rng(5), image(32, 32).astype(np.float64)
    variance = np.full_like(truth, 0.01)
    found = [error_against(truth, truth + 0.1 * rng.normal(size=truth.shape), variance) for _ in range(200)]
    assert np.mean([error.rmse_rel <= error.uncertainty for error in found]) >= 0.94
    assert max(error.rmse_rel for error in found) < noise_of(truth, variance)


def test_without_variance_the_estimate_is_the_plain_figure() -> None:
    one, other = image(), image(seed=4)
    found = error_against(other, one)
    assert found.rmse_rel == pytest.approx(compare(other, one).rmse_rel, rel=1e-9)
    assert found.uncertainty == 0.0


def test_noise_of_a_reference() -> None:
    one = np.full((6, 6, 3), 2.0)
    assert noise_of(one, np.full_like(one, 0.04)) == pytest.approx(0.2 / np.sqrt(3.96), rel=1e-12)

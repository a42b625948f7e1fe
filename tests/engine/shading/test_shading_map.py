"""Linearisation and look-up of shading maps against closed forms and brute-force oracles."""

from __future__ import annotations

import dataclasses
import itertools
from fractions import Fraction
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.capture.stack import ImageStack
from engine.core.colour import LUMINANCE
from engine.core.errors import InputError
from engine.core.health import Verdict
from engine.core.steps import drain
from engine.shading.power_law import SCALES, fit
from engine.shading.shading_map import ShadingMap, build, check_brightest, interpolation_weights
from engine.storage import scratch

U32 = 2.0**-24


def stack_of(radiance: Any, *, saturated: Any = None, mean_radiance: Any = None) -> ImageStack:
    """A stack in memory with true mean radiances."""
    radiance = np.asarray(radiance, np.float32)
    count = len(radiance)
    if mean_radiance is None:
        mean_radiance = radiance.astype(np.float64).mean(axis=(1, 2)) @ LUMINANCE
    return ImageStack(
        radiance=radiance,
        saturated=np.zeros(radiance.shape[:3], np.bool_) if saturated is None else saturated,
        elevation=np.radians(np.linspace(5, 85, count)),
        azimuth=None,
        mean_radiance=np.asarray(mean_radiance, np.float64),
        sources=tuple(f"photograph_{index}.tif" for index in range(count)),
        angle_source="user",
    )


def noisy_stack(levels: Any, height: int = 7, width: int = 9, seed: int = 0) -> Any:
    rng = np.random.default_rng(seed)
    return stack_of(rng.uniform(0.5, 1.5, (len(levels), height, width, 3)) * np.reshape(levels, (-1, 1, 1, 1)))


X8_MEANS = (0.0, 0.02, 0.05, 0.06, 0.065, 0.3, 0.7, 0.72, 0.9, 1.0)


def test_X8_neighbours_bracket_the_target() -> None:
    weights = interpolation_weights(X8_MEANS, 8)
    assert (weights >= 0).all()
    assert (weights <= 1).all()
    np.testing.assert_allclose(weights @ X8_MEANS, np.arange(8) / 7, atol=1e-15)


@given(
    st.lists(st.floats(0.0, 1e6), min_size=1, max_size=12).filter(lambda means: max(means) > 1e-300),
    st.integers(2, 20),
)
def test_S1_every_slice_interpolates_the_neighbours_of_its_target(means: Any, slices: Any) -> None:
    weights = interpolation_weights(means, slices)
    assert np.all((weights >= 0) & (weights <= 1))
    levels = sorted({0.0, *means})
    for index, row in enumerate(weights):
        target = Fraction(max(means)) * index / (slices - 1)
        mean = sum(Fraction(weight) * Fraction(level) for weight, level in zip(row, means, strict=True))
        assert abs(mean - target) <= Fraction(4e-15) * target
        used = {levels.index(level) for level, weight in zip(means, row, strict=True) if weight > 0} or {0}
        assert max(used) - min(used) <= 1
        assert levels[min(used) - (len(used) == 1 and min(used) > 0)] <= target * (1 + Fraction(1, 10**15))


def test_S2_equal_means_are_averaged_without_division_by_zero() -> None:
    weights = interpolation_weights([0.5, 1.0, 0.5, 1.0, 1.0], 3)
    np.testing.assert_allclose(
        cast(Any, weights), cast(Any, [[0] * 5, [0.5, 0, 0.5, 0, 0], [0, 1 / 3, 0, 1 / 3, 1 / 3]]), atol=1e-16
    )
    levels = np.array([0.5, 1.0, 1.0], np.float32)
    shading_map = drain(build(stack_of(np.broadcast_to(levels[:, None, None, None], (3, 2, 2, 3))), 5))
    np.testing.assert_allclose(shading_map.mean_radiance, shading_map.target_radiance, rtol=4 * U32)


def test_S3_photographs_out_of_order_are_sorted_and_named() -> None:
    stack = noisy_stack([0.1, 0.5, 0.3, 0.9])
    shading_map = drain(build(stack, 6))
    assert shading_map.order == (0, 2, 1, 3)
    (warning,) = [finding for finding in shading_map.health.findings if finding.verdict == Verdict.WARNING]
    assert warning.source == "photograph_2.tif"
    ordered = drain(build(stack_of(stack.radiance[[0, 2, 1, 3]]), 6))
    assert np.array_equal(ordered.slices, shading_map.slices)


@pytest.mark.parametrize("level", [0.0, -0.01])
def test_S4_a_stack_without_light_is_refused(level: float) -> None:
    with pytest.raises(InputError, match="no light"):
        drain(build(stack_of(np.full((3, 2, 2, 3), level))))


def test_S5_one_photograph_gives_darker_copies_and_a_warning() -> None:
    stack = noisy_stack([0.7])
    shading_map = drain(build(stack, 5))
    for index, image in enumerate(shading_map.slices):
        np.testing.assert_allclose(image, stack.radiance[0] * (index / 4), rtol=4 * U32)
    assert shading_map.health.verdict == Verdict.WARNING


def test_S5_more_slices_than_photographs_are_valid_and_fewer_than_two_are_refused() -> None:
    shading_map = drain(build(noisy_stack([0.2, 0.8]), 40))
    np.testing.assert_allclose(shading_map.mean_radiance, shading_map.target_radiance, rtol=4 * U32)
    for slices in (1, 0, -3):
        with pytest.raises(ValueError, match="at least 2"):
            drain(build(noisy_stack([0.2, 0.8]), slices))


def test_S6_slice_0_is_a_synthesised_black_and_flagged() -> None:
    shading_map = drain(build(noisy_stack([0.4, 0.6, 1.0]), 9))
    assert not shading_map.slices[0].any()
    assert any("black by definition" in finding.text for finding in shading_map.health.findings)
    below = (shading_map.target_radiance[1:] < 0.95 * np.min([0.4, 0.6, 1.0])).sum()
    assert abs(shading_map.health.figures["slices_below_darkest_photograph"] - below) <= 1


def test_S6_photographs_black_on_average_are_not_used_and_named() -> None:
    stack = noisy_stack([1e-9, 0.5, 1.0])
    radiance = stack.radiance.copy()
    radiance[0] = -0.001
    shading_map = drain(build(stack_of(radiance), 4))
    assert not shading_map.slices[0].any()
    assert any(finding.source == "photograph_0.tif" for finding in shading_map.health.findings)


@pytest.mark.parametrize("seed", range(4))
def test_S7_mean_of_slice_i_is_i_times_the_largest_mean(seed: int) -> None:
    rng = np.random.default_rng(seed)
    levels = rng.uniform(0.01, 2.0, rng.integers(2, 12))
    slices = int(rng.integers(2, 17))
    shading_map = drain(build(noisy_stack(levels, 61, 47, seed), slices))
    target = shading_map.r_max * np.arange(slices) / (slices - 1)
    measured = shading_map.slices.astype(np.float64).mean(axis=(1, 2)) @ LUMINANCE
    assert np.all(np.abs(measured - target) <= 4 * U32 * target)
    np.testing.assert_allclose(shading_map.mean_radiance, measured, rtol=1e-14)


@pytest.mark.parametrize("above", ["clamp", "scale"])
def test_S8_lookup_is_continuous_at_the_brightest_slice(above: Any) -> None:
    shading_map = drain(build(noisy_stack([0.2, 0.9]), 5))
    below, beyond = (np.nextafter(shading_map.r_max, end) for end in (0.0, np.inf))
    left, right = (shading_map.slice_image(r, above).astype(np.float64) for r in (below, beyond))
    assert np.all(np.abs(right - left) <= 2 * U32 * left)
    twice = shading_map.slice_image(2 * shading_map.r_max, above)
    assert np.array_equal(twice, shading_map.slices[-1] * (2 if above == "scale" else 1))


def test_S9_lookup_at_slice_and_texel_centres_hits_the_slices() -> None:
    shading_map = drain(build(noisy_stack([0.2, 0.5, 0.9], 4, 5), 6))
    rows, columns = np.mgrid[:4, :5] + 0.5
    for index, r in enumerate(shading_map.target_radiance):
        found = shading_map.lookup(rows, columns, r)
        np.testing.assert_allclose(found, shading_map.slices[index], rtol=1e-6)
        assert np.array_equal(found, shading_map.slice_image(r))
    assert np.array_equal(shading_map.slice_image(0.0), shading_map.slices[0])
    assert np.array_equal(shading_map.slice_image(shading_map.r_max), shading_map.slices[-1])


def trilinear(slices: Any, row: Any, column: Any, layer: Any) -> Any:
    """Oracle: eight weighted texels, with repeat, by plain loops."""
    _, height, width, _ = slices.shape
    top, left, lower = int(np.floor(row - 0.5)), int(np.floor(column - 0.5)), min(int(layer), len(slices) - 2)
    total = np.zeros(3)
    for down, right, further in itertools.product((0, 1), repeat=3):
        weight = np.prod([abs(1 - step - (at - base)) for step, at, base in (
            (down, row - 0.5, top), (right, column - 0.5, left), (further, layer, lower),
        )])  # fmt: skip
        total += weight * slices[lower + further, (top + down) % height, (left + right) % width].astype(np.float64)
    return total


@given(st.floats(-20, 20), st.floats(-20, 20), st.floats(0, 1))
def test_S9_lookup_is_trilinear_and_repeats(row: Any, column: Any, share: Any) -> None:
    shading_map = ShadingMap(np.random.default_rng(1).random((5, 3, 4, 3), np.float32), 2.0, np.linspace(0, 2, 5))
    found = shading_map.lookup(row, column, share * 2.0)
    np.testing.assert_allclose(found, trilinear(shading_map.slices, row, column, share * 4), atol=3e-7)


@pytest.mark.parametrize("r", [0.0, -0.0, -1.0, np.nan, np.inf, -np.inf, 1e-320])
@pytest.mark.parametrize("above", ["clamp", "scale"])
def test_S9_what_is_no_radiance_is_black(r: float, above: Any) -> None:
    shading_map = drain(build(noisy_stack([0.5, 1.0])))
    assert not shading_map.lookup(0.0, 0.0, r, above).any()
    assert not shading_map.slice_image(r, above).any()


def test_lookup_refuses_coordinates_that_are_not_finite_and_unknown_rules() -> None:
    shading_map = drain(build(noisy_stack([0.5, 1.0])))
    with pytest.raises(ValueError, match="finite"):
        shading_map.lookup([0.0, np.nan], 0.0, 0.1)
    with pytest.raises(ValueError, match="clamp"):
        shading_map.lookup(0.0, 0.0, 0.1, above=cast(Any, "extrapolate"))


@pytest.mark.parametrize("tile_rows", [1, 2, 5, 13, 64])
def test_S10_tiles_do_not_change_a_bit(tile_rows: int) -> None:
    stack = noisy_stack([0.1, 0.3, 0.3, 1.1], 13, 6)
    whole, tiled = (drain(build(stack, 7, tile_rows=rows)) for rows in (None, tile_rows))
    assert np.array_equal(whole.slices, tiled.slices)
    assert np.array_equal(whole.mean_radiance, tiled.mean_radiance)


def test_S11_large_slices_lie_in_a_scratch_file_and_are_the_same(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    stack = noisy_stack([0.1, 0.3, 1.1], 13, 6)
    in_memory = drain(build(stack, 7))
    monkeypatch.setattr(scratch, "IN_MEMORY_BYTES", 0)
    monkeypatch.setattr(cast(Any, scratch).tempfile, "gettempdir", lambda: str(tmp_path))
    streamed = drain(build(stack, 7, tile_rows=3))
    assert isinstance(streamed.slices, np.memmap)
    assert np.array_equal(streamed.slices, in_memory.slices)
    assert list(tmp_path.iterdir()) == []


def test_S11_work_is_handed_back_between_tiles_and_can_be_cancelled() -> None:
    steps = build(noisy_stack([0.1, 1.1], 16, 6), 7, tile_rows=4)
    done = [next(steps).done for _ in range(3)]
    assert done == sorted(done)
    assert 0 <= done[0] < done[-1] < 1
    steps.close()


def test_slices_know_where_a_photograph_they_sum_was_clipped() -> None:
    saturated = np.zeros((2, 3, 4), np.bool_)
    saturated[1, 2, 1] = True
    radiance = noisy_stack([0.5, 1.0], 3, 4).radiance
    shading_map = drain(build(stack_of(radiance, saturated=saturated), 5))
    means = radiance.astype(np.float64).mean(axis=(1, 2)) @ LUMINANCE
    beyond_first = shading_map.target_radiance > means[0]
    assert shading_map.clipped is not None
    assert np.array_equal(shading_map.clipped[:, 2, 1], beyond_first)
    assert shading_map.clipped.sum() == beyond_first.sum()
    assert drain(build(stack_of(radiance), 5)).clipped is None


def test_negative_noise_around_black_survives() -> None:
    radiance = noisy_stack([0.5, 1.0]).radiance.copy()
    radiance[0, 0, 0] = -0.25
    shading_map = drain(build(stack_of(radiance), 5))
    assert shading_map.slices.min() < 0


def test_the_mean_of_many_pixels_is_known_to_be_theirs() -> None:
    """Sums in single precision would be off by more than is tolerated."""
    radiance = np.full((2, 1500, 1200, 3), 0.1, np.float32)
    radiance[1] += np.float32(0.2)
    check_brightest(stack_of(radiance), np.arange(2))


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_pixels_that_are_not_finite_are_refused(value: float) -> None:
    stack = noisy_stack([0.5, 1.0])
    radiance = stack.radiance.copy()
    radiance[1, 3, 3, 0] = value
    with pytest.raises(InputError, match="do not belong to its pixels"):
        drain(build(stack_of(radiance, mean_radiance=stack.mean_radiance)))
    with pytest.raises(InputError, match="not finite"):
        drain(build(stack_of(radiance)))


def test_figures_that_do_not_belong_to_the_pixels_are_refused() -> None:
    with pytest.raises(InputError, match="do not belong to its pixels"):
        drain(build(stack_of(noisy_stack([0.5, 1.0]).radiance, mean_radiance=[0.5, 1.5])))


def test_a_shading_map_is_checked_and_read_only() -> None:
    slices = np.zeros((2, 3, 4, 3), np.float32)
    shading_map = ShadingMap(slices, 1.0, np.zeros(2))
    with pytest.raises(ValueError, match="read-only"):
        shading_map.slices[0] = 1
    slices[0] = 1
    for broken in (
        (slices.astype(np.float64), 1.0, np.zeros(2)),
        (slices[:1], 1.0, np.zeros(1)),
        (slices, 0.0, np.zeros(2)),
        (slices, np.nan, np.zeros(2)),
        (slices, 1.0, np.zeros(3)),
    ):
        with pytest.raises(ValueError, match=r"slices|r_max"):
            ShadingMap(*broken)


def test_excluded_photographs_are_as_if_they_had_not_been_taken() -> None:
    stack = noisy_stack([0.2, 0.9, 0.4, 0.6, 1.0])
    rest = [0, 2, 3]
    excluded = {stack.sources[1], stack.sources[4]}
    with_them = drain(build(stack, 6, excluded=excluded))
    without = drain(build(stack_of(stack.radiance[rest]), 6))
    assert np.array_equal(with_them.slices, without.slices)
    assert with_them.r_max == without.r_max
    assert with_them.order == (0, 2, 3)
    noted = {finding.source for finding in with_them.health.findings if "excluded" in finding.text}
    assert noted == excluded


def test_excluding_what_is_not_there_or_everything_is_refused() -> None:
    stack = noisy_stack([0.2, 0.9])
    with pytest.raises(ValueError, match=r"no photograph called felt\.tif"):
        drain(build(stack, excluded=["felt.tif"]))
    with pytest.raises(InputError, match="every photograph is excluded"):
        drain(build(stack, excluded=stack.sources))


@pytest.mark.parametrize("scale", SCALES)
def test_R3_a_clipped_photograph_of_ten_does_not_bend_the_fit(scale: Any) -> None:
    """From the stack's mask of saturated samples to K: texels clipped in the brightest photograph keep their K."""
    light = np.arange(1, 11) / 10
    exponent = np.repeat(np.random.default_rng(4).uniform(0.3, 2.5, (64, 64, 1)), 3, axis=2)
    law = 0.8 * light[:, None, None, None] ** exponent
    clipped = np.zeros((10, 64, 128), np.bool_)
    clipped[9, ::16, :64:16] = True
    seen = np.where(clipped[:, :, :64, None], 0.5, law)
    # Beside each texel one that makes their mean grow linearly with the light, so that the slices are photographs.
    radiance = np.concatenate([seen, 2.0 * light[:, None, None, None] - seen], axis=2)
    shading_map = drain(build(stack_of(radiance, saturated=clipped), 11))
    assert shading_map.clipped is not None
    assert np.array_equal(shading_map.clipped[10], clipped[9])
    power_law = drain(fit(shading_map, scale))
    assert np.abs(power_law.exponent[:, :64] - exponent).max() <= 1e-3
    unmasked = drain(fit(dataclasses.replace(shading_map, clipped=None), scale))
    assert np.abs(unmasked.exponent[::16, :64:16] - exponent[::16, ::16]).min() > 0.05

"""Tiles of whole materials: slices that keep their laws, copied from the sample, the same for every slice."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from engine.capture.stack import ImageStack
from engine.core.colour import LUMINANCE
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.shading.power_law import fit
from engine.shading.shading_map import build
from engine.shading.tile import make_tile

PHOTOGRAPHS, SLICES = 5, 6


@pytest.fixture(scope="module")
def stack() -> ImageStack:
    """Leather under a rising lamp: power laws, with a saturated speck."""
    noise = gaussian_filter(np.random.default_rng(1).normal(size=(96, 120, 1)), (2.5, 2.5, 0))
    height = (noise - noise.min()) / np.ptp(noise)
    light = np.linspace(0.2, 1.0, PHOTOGRAPHS)[:, None, None, None]
    radiance = ((0.3 + 0.5 * height) * (0.9, 0.6, 0.4) * light ** (1.6 - height)).astype(np.float32)
    saturated = np.zeros(radiance.shape[:3], np.bool_)
    saturated[-1, 40:44, 50:55] = True
    return ImageStack(
        radiance=radiance,
        saturated=saturated,
        elevation=np.radians(np.linspace(10, 80, PHOTOGRAPHS)),
        azimuth=None,
        mean_radiance=radiance.astype(np.float64).mean(axis=(1, 2)) @ LUMINANCE,
        sources=tuple(f"leather_{index}.tif" for index in range(PHOTOGRAPHS)),
        angle_source="user",
    )


@pytest.fixture(scope="module")
def sample(stack: ImageStack) -> Any:
    return drain(build(stack, SLICES))


@pytest.fixture(scope="module")
def tile(stack: ImageStack, sample: Any) -> Any:
    return drain(make_tile(stack, sample))


def test_slices_of_the_tile_have_the_means_that_they_promise(tile: Any) -> None:
    shading_map = tile.shading_map
    means = shading_map.slices.astype(np.float64).mean(axis=(1, 2)) @ LUMINANCE
    np.testing.assert_allclose(means, shading_map.target_radiance, rtol=4 * 2.0**-24, atol=1e-12)
    assert shading_map.r_max == pytest.approx(means[-1], rel=1e-6)
    assert len(shading_map.slices) == SLICES
    assert not shading_map.slices[0].any()


def test_the_brightest_slice_is_copied_texel_by_texel(tile: Any, stack: ImageStack) -> None:
    row, column = tile.source.row, tile.source.column
    assert np.array_equal(tile.shading_map.slices[-1], stack.radiance[-1][row, column])
    assert np.array_equal(tile.shading_map.clipped[-1], stack.saturated[-1][row, column])


def test_power_laws_of_the_tile_are_those_of_its_texels(tile: Any, sample: Any) -> None:
    of_tile, of_sample = drain(fit(tile.shading_map)), drain(fit(sample))
    expected = of_sample.exponent[tile.source.row, tile.source.column]
    np.testing.assert_allclose(of_tile.exponent, expected, rtol=0.03)


def test_the_seam_is_measured_and_reported(tile: Any, sample: Any) -> None:
    assert tile.shading_map.health.figures["seam_error"] == tile.source.seam_error < 2
    assert any("tileable" in finding.text for finding in tile.shading_map.health.findings)
    brightest = tile.shading_map.slices[-1, ..., 1]
    inside = np.abs(np.diff(sample.slices[-1, ..., 1], axis=1)).mean()
    for axis in (0, 1):
        assert np.abs(np.take(brightest, 0, axis) - np.take(brightest, -1, axis)).mean() < 2.5 * inside


def test_photographs_that_were_left_out_stay_out(stack: ImageStack) -> None:
    excluded = {stack.sources[1]}
    tile = drain(make_tile(stack, drain(build(stack, SLICES, excluded=excluded)), excluded=excluded))
    assert tile.shading_map.order == (0, 2, 3, 4)
    row, column = tile.source.row, tile.source.column
    rest = [0, 2, 3, 4]
    without = dataclasses.replace(
        stack,
        radiance=stack.radiance[rest][:, row, column],
        saturated=stack.saturated[rest][:, row, column],
        mean_radiance=stack.radiance[rest][:, row, column].mean(axis=(1, 2), dtype=np.float64) @ LUMINANCE,
        sources=tuple(stack.sources[place] for place in rest),
    )
    assert np.array_equal(drain(build(without, SLICES)).slices, tile.shading_map.slices)


def test_a_sample_too_small_for_the_overlap_is_bad_input(stack: ImageStack, sample: Any) -> None:
    with pytest.raises(InputError, match="overlap of 90 texels does not fit"):
        drain(make_tile(stack, sample, overlap=90))

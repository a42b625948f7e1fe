"""Procedural samples: tileable, reproducible, within their declared ranges."""

from __future__ import annotations

import numpy as np
import pytest

from engine.simulate.height_fields import SAMPLES, Sample, sample


@pytest.mark.parametrize("name", SAMPLES)
def test_same_arguments_give_the_same_bits(name: str) -> None:
    first, second = sample(name, 64, seed=3), sample(name, 64, seed=3)
    for field in ("height", "albedo", "specular", "roughness"):
        assert np.array_equal(getattr(first, field), getattr(second, field))


@pytest.mark.parametrize("name", ["woven", "hammered", "leather"])
def test_another_seed_gives_another_sample(name: str) -> None:
    assert not np.array_equal(sample(name, 64, seed=1).height, sample(name, 64, seed=2).height)


@pytest.mark.parametrize("name", ["woven", "hammered", "leather"])
def test_tiles_join_without_a_seam(name: str) -> None:
    """The step across the border of a tile is an ordinary step: within the range of the steps inside."""
    height = sample(name, 256).height.astype(float)
    for axis in (0, 1):
        inside = np.abs(np.diff(height, axis=axis)).mean(axis=1 - axis)
        across = np.abs(np.take(height, 0, axis) - np.take(height, -1, axis)).mean()
        assert across <= inside.max()


@pytest.mark.parametrize("name", ["woven", "hammered", "leather"])
def test_relief_scales_with_the_resolution(name: str) -> None:
    coarse, fine = sample(name, 128).height, sample(name, 256).height
    assert np.ptp(fine) / np.ptp(coarse) == pytest.approx(2, rel=0.15)


def test_woven_shows_both_threads_about_equally() -> None:
    albedo = sample("woven", 256).albedo
    ochre = (albedo[..., 0] > albedo[..., 2]).mean()
    assert 0.4 < ochre < 0.6


def test_unknown_name_and_size_are_refused() -> None:
    with pytest.raises(ValueError, match="choose from woven, hammered, leather, medal, plain"):
        sample("velvet", 64)
    with pytest.raises(ValueError, match="size 8"):
        sample("woven", 8)


def test_maps_out_of_range_are_refused() -> None:
    plain = sample("plain", 16)
    with pytest.raises(ValueError, match="albedo must lie in"):
        Sample(plain.height, plain.albedo * np.float32(3), plain.specular, plain.roughness)
    with pytest.raises(ValueError, match="height must be finite"):
        Sample(plain.height * np.float32(np.nan), plain.albedo, plain.specular, plain.roughness)

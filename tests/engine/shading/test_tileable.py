"""Tiles: a cut through all slices at once, found on a torus."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from engine.core.steps import drain
from engine.shading import tile


def tile_source(slices: Any, **options: Any) -> Any:
    return drain(tile.tile_source(slices, **options))


def stack(image: Any, count: int = 4) -> NDArray[np.float32]:
    return np.stack([np.repeat(image[..., None] * k / (count - 1), 3, axis=2) for k in range(count)]).astype(np.float32)


@pytest.fixture(scope="module")
def leather() -> Any:
    noise = gaussian_filter(np.random.default_rng(1).normal(size=(160, 200)), 2.5)
    return stack((noise - noise.min()) / np.ptp(noise))


def test_a_weave_keeps_whole_threads() -> None:
    y, x = np.mgrid[:300, :333]
    weave = stack(0.5 + 0.3 * np.sin(2 * np.pi * x / 37) * np.sin(2 * np.pi * y / 41))
    tile = tile_source(weave)
    assert tile.row.shape[1] % 37 == 0
    assert tile.row.shape[0] % 41 == 0
    shown = weave[:, tile.row, tile.column]
    np.testing.assert_allclose(np.roll(shown, 37, axis=2), shown, atol=1e-6)


def test_every_texel_is_copied_from_the_sample(leather: Any) -> None:
    tile = tile_source(leather)
    height, width = leather.shape[1:3]
    assert 0 <= tile.row.min() <= tile.row.max() < height
    assert 0 <= tile.column.min() <= tile.column.max() < width


def test_seams_are_far_smaller_than_those_of_plain_repetition(leather: Any) -> None:
    tile = tile_source(leather)
    plain = np.abs(leather[-1, :, 0] - leather[-1, :, -1]).mean() / np.abs(np.diff(leather[-1], axis=1)).mean()
    assert plain > 5
    assert tile.seam_error < 2


def test_the_wrap_around_is_no_worse_than_the_cuts(leather: Any) -> None:
    tile = tile_source(leather)
    shown = leather[-1, ..., 0][tile.row, tile.column]
    inside = np.abs(np.diff(leather[-1, ..., 0], axis=1)).mean()
    for axis in (0, 1):
        edge = np.abs(np.take(shown, 0, axis) - np.take(shown, -1, axis)).mean()
        assert edge < 2.5 * inside


def test_the_tile_keeps_at_least_the_fraction_asked_for(leather: Any) -> None:
    tile = tile_source(leather, overlap=8, smallest=0.8)
    assert tile.row.shape[0] >= 0.8 * leather.shape[1]
    assert tile.row.shape[1] >= 0.8 * leather.shape[2]


def test_a_constant_sample_has_no_seam() -> None:
    assert tile_source(np.full((2, 32, 40, 3), 0.5, np.float32)).seam_error == 1.0


def test_what_cannot_be_tiled_is_refused() -> None:
    with pytest.raises(ValueError, match="too small"):
        tile_source(np.zeros((2, 7, 40, 3), np.float32))
    with pytest.raises(ValueError, match="does not fit"):
        tile_source(np.zeros((2, 40, 40, 3), np.float32), overlap=30)


def test_the_search_can_be_watched_and_stopped(leather: Any) -> None:
    steps = list(tile.tile_source(leather))
    assert len(steps) > 50
    assert [step.done for step in steps] == sorted(step.done for step in steps)
    search = tile.tile_source(leather)
    next(search)
    search.close()

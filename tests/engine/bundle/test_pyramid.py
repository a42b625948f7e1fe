"""Tiles of a page hold every texel, to the rounding of their codes."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.bundle.page import (
    EXPONENTS,
    MARGIN,
    PIXELS_WITHIN,
    TILE,
    VIEWER_SIDE,
    Codes,
    _finest,
    bytes_of,
    codes_of,
    coding_error,
    level_sizes,
    planes_in_layers,
    tiles,
)
from tests.engine.bundle.materials import make_material


@given(st.floats(1e-3, 100.0), st.floats(1e-4, 50.0), st.floats(1e-3, 1.0), st.floats(0.0, 1.0))
def test_codes_change_radiance_by_a_known_share(largest: float, high: float, share: float, scale: float) -> None:
    """An exponent by half a step, a factor q, changes s^K by at most (q - 1) / e; a scale is off by half a code."""
    codes = Codes(largest, high / EXPONENTS, high)
    step = EXPONENTS ** (0.5 / 254.0) - 1.0
    exponents = np.geomspace(codes.low, high, 50)
    back = codes.exponent(codes.reduce_exponent(exponents.astype(np.float32)))
    assert np.abs(share**back - share**exponents).max() <= 1.001 * step / np.e * (1 + step)
    assert codes.exponent(codes.reduce_exponent(np.zeros(1, np.float32)))[0] == 0.0
    value = np.array([scale * largest], np.float32)
    found = float(codes.scale(codes.reduce_scale(value))[0])
    assert found == pytest.approx(scale * largest, abs=largest * 0.5 / 255 * 2.275 * 1.01), "2.275 is sRGB's steepest"


def test_codes_of_a_constant_map_are_exact() -> None:
    law = make_material(4, 4).power_law
    assert law is not None
    alike = dataclasses.replace(law, exponent=np.full((4, 4, 3), 1.7, np.float32))
    codes = codes_of(alike)
    assert codes.exponent(codes.reduce_exponent(alike.exponent)) == pytest.approx(1.7, rel=1e-6)


def test_the_error_is_that_of_coded_radiance() -> None:
    rng = np.random.default_rng(2)
    law = make_material(40, 30).power_law
    assert law is not None
    scale, exponent = rng.uniform(0.01, 2, (2, 40, 30, 3)).astype(np.float32)
    law = dataclasses.replace(law, scale=scale, exponent=exponent)
    assert 0.001 < coding_error(law, codes_of(law)) < 0.01
    coarse = dataclasses.replace(codes_of(law), largest=40.0)
    assert coding_error(law, coarse) > 2 * coding_error(law, codes_of(law)), "an outlier costs codes"


@pytest.mark.parametrize("size", [(1, 1100), (700, 1300), (1024, 1025)])
def test_tiles_put_together_are_the_map(size: tuple[int, int]) -> None:
    """Without their margins they are the map, and a margin is what the map has across its edges."""
    values = np.random.default_rng(4).integers(0, 256, (*size, 3), np.uint8)
    found = np.zeros_like(values)
    count = 0
    for column, row, layer, pixels in tiles([(values, lambda part: part)], size):
        assert layer == 0
        rows = np.arange(row * TILE - MARGIN, row * TILE - MARGIN + pixels.shape[0]) % size[0]
        columns = np.arange(column * TILE - MARGIN, column * TILE - MARGIN + pixels.shape[1]) % size[1]
        np.testing.assert_array_equal(pixels, values[np.ix_(rows, columns)])
        inner = pixels[MARGIN:-MARGIN, MARGIN:-MARGIN]
        found[row * TILE : row * TILE + inner.shape[0], column * TILE : column * TILE + inner.shape[1]] = inner
        count += pixels.nbytes
    np.testing.assert_array_equal(found, values)
    assert count == bytes_of([size], 1)


def test_levels_halve_until_the_whole_shows_as_much() -> None:
    assert level_sizes((4000, 6000), VIEWER_SIDE) == [(4000, 6000), (2000, 3000)]
    assert level_sizes((1, 1025), VIEWER_SIDE) == [(1, 1025)]
    assert level_sizes((1, 5000), VIEWER_SIDE) == [(1, 5000), (1, 2500)]
    assert level_sizes((1024, 900), VIEWER_SIDE) == []


def test_a_power_law_of_24_megapixels_has_room_in_one_file() -> None:
    """Its codes, in base64 and without any packing, and the maps of the whole, in 16 bits."""
    sizes = level_sizes((4024, 6048), VIEWER_SIDE)
    whole = 12 * 1024 * 682
    assert _finest(sizes, {"look_up": 2}, PIXELS_WITHIN - whole) == {"look_up": 0}
    assert 4 / 3 * (whole + bytes_of(sizes, 2)) < 256 << 20
    assert _finest(sizes, {"look_up": 5, "surface": 3}, PIXELS_WITHIN) == {"look_up": 1, "surface": 1}
    assert _finest(sizes, {"look_up": 2}, 0) == {"look_up": len(sizes)}


def test_planes_lie_by_three() -> None:
    planes = np.random.default_rng(1).integers(0, 256, (4, 5, 6), np.uint8)
    one, two = (layer for layer, _ in planes_in_layers(planes))
    np.testing.assert_array_equal(np.moveaxis(one, 2, 0), planes[:3])
    np.testing.assert_array_equal(two[..., 0], planes[3])
    assert not two[..., 1:].any()

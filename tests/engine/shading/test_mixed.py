"""Mixed compression: the bound holds everywhere, and its two ends are the slices and the power law themselves."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.core.steps import drain
from engine.shading.kept_tiles import KeptTiles, cut_tiles
from engine.shading.mixed import keep_tiles
from engine.shading.power_law import PowerLawMap, fit
from engine.shading.power_law_error import measure, worst_texels
from engine.shading.quantise import quantise, quantise_exponent, restore_exponent
from engine.shading.shading_map import ShadingMap

SLICES = 6
X = np.arange(SLICES) / (SLICES - 1)


def make_patched_map(height: int = 37, width: int = 45, seed: int = 0) -> ShadingMap:
    """Power laws with a little noise, and a patch that darkens under more light."""
    rng = np.random.default_rng(seed)
    values = X[:, None, None, None] ** rng.uniform(0.4, 3.0, (height, width, 3))
    values *= 1.0 + 0.02 * rng.standard_normal(values.shape)
    values[1:, 20:23, 30:34] = 1.0 - X[1:, None, None, None]
    values[0] = 0.0
    return ShadingMap(values.astype(np.float32), 0.5, np.linspace(0.0, 0.5, SLICES))


@pytest.fixture(scope="module")
def shading_map() -> Any:
    return make_patched_map()


@pytest.fixture(scope="module")
def power_law(shading_map: Any) -> PowerLawMap:
    return drain(fit(shading_map))


def mix(power_law: PowerLawMap, shading_map: ShadingMap, bound: Any, size: int = 16) -> Any:
    return drain(keep_tiles(power_law, shading_map, bound, size))


def errors(form: Any, shading_map: ShadingMap) -> Any:
    """Oracle: the error of each texel from whole images."""
    rebuilt = np.stack([form.slice_image(r) for r in shading_map.target_radiance]).astype(np.float64)
    return np.sqrt(((rebuilt - shading_map.slices) ** 2).mean(axis=(0, 3)))


def coordinates(shading_map: ShadingMap, count: int = 4000) -> tuple[Any, Any, Any]:
    rng = np.random.default_rng(1)
    height, width = shading_map.slices.shape[1:3]
    return rng.uniform(-height, 2 * height, count), rng.uniform(-width, 2 * width, count), rng.uniform(-0.1, 0.7, count)


@pytest.mark.parametrize("above", ["clamp", "scale"])
def test_a_bound_of_0_keeps_the_slices_bit_for_bit(power_law: PowerLawMap, shading_map: Any, above: str) -> None:
    form = mix(power_law, shading_map, 0.0)
    assert np.all(form.kept.place >= 0)
    assert form.rms == 0
    assert not form.error_map.any()
    where = coordinates(shading_map)
    assert np.array_equal(form.lookup(*where, above), shading_map.lookup(*where, above))
    for r in (0.0, 0.2, 0.33, 0.5, 0.8):
        assert np.array_equal(form.slice_image(r, above), shading_map.slice_image(r, above))


@pytest.mark.parametrize("above", ["clamp", "scale"])
@pytest.mark.parametrize("part", [np.s_[:, :], np.s_[20:21, 3:40], np.s_[15:37, 30:45], np.s_[0:3, 0:2]])
def test_a_part_of_an_image_is_that_of_the_whole(
    power_law: PowerLawMap, shading_map: Any, part: Any, above: Any
) -> None:
    form = mix(power_law, shading_map, 0.02)
    assert 0 < len(form.kept.slices) < form.kept.place.size
    for r in (0.0, 0.2, 0.5, 0.8):
        assert np.array_equal(form.slice_image(r, above, part), form.slice_image(r, above)[part])
        assert np.array_equal(power_law.slice_image(r, above, part), power_law.slice_image(r, above)[part])


@pytest.mark.parametrize("above", ["clamp", "scale"])
def test_an_infinite_bound_is_the_power_law_bit_for_bit(power_law: PowerLawMap, shading_map: Any, above: Any) -> None:
    form = mix(power_law, shading_map, np.inf)
    assert form.kept is None
    assert form.size_bytes == power_law.size_bytes
    where = coordinates(shading_map)
    assert np.array_equal(form.lookup(*where, above), power_law.lookup(*where, above))


@settings(max_examples=25)
@given(st.floats(0.0, 0.6), st.sampled_from([1, 5, 16, 64]))
def test_the_error_is_below_the_bound_everywhere(bound: Any, size: int) -> None:
    shading_map = make_patched_map()
    power_law = drain(fit(shading_map))
    form = mix(power_law, shading_map, bound, size)
    found = errors(form, shading_map)
    assert found.max() <= bound * (1 + 1e-5) + 1e-7
    np.testing.assert_allclose(form.error_map, found, atol=1e-6)
    assert form.rms == pytest.approx(np.sqrt((found**2).mean()), rel=1e-4, abs=1e-8)


def test_only_tiles_with_an_error_are_kept_and_their_bytes_are_counted(
    power_law: PowerLawMap, shading_map: Any
) -> None:
    form = mix(power_law, shading_map, 0.2)
    kept = form.kept
    assert kept.place.shape == (3, 3)
    assert np.argwhere(kept.place >= 0).tolist() == [[1, 1], [1, 2]]
    tiles = 2 * SLICES * 16 * 16 * 3 * 4
    assert form.size_bytes == power_law.size_bytes + tiles + kept.place.nbytes
    assert power_law.size_bytes == power_law.scale.nbytes + power_law.exponent.nbytes
    assert form.health.figures["kept_tile_fraction"] == pytest.approx(2 / 9)
    assert form.health.figures["rms_without_kept_tiles"] == power_law.rms
    covered = kept.covers(37, 45)
    assert covered.sum() == 16 * (16 + 13)
    assert np.array_equal(kept.slice_images(37, 45)[:, covered], shading_map.slices[:, covered])
    assert not kept.slice_images(37, 45)[:, ~covered].any()


def test_lookups_equal_images_at_texel_centres(power_law: PowerLawMap, shading_map: Any) -> None:
    form = mix(power_law, shading_map, 0.2)
    rows, columns = np.mgrid[:37, :45] + 0.5
    assert np.array_equal(form.lookup(rows, columns, 0.21), form.slice_image(0.21))


def test_at_the_border_of_a_tile_each_form_counts_with_its_texels(power_law: PowerLawMap, shading_map: Any) -> None:
    form = mix(power_law, shading_map, 0.2)
    at = (20.5, 16.0, 0.3)
    expected = (power_law.lookup(*at) + shading_map.lookup(20.5, 16.5, 0.3)) / 2
    left, right = power_law.lookup(20.5, 15.5, 0.3), shading_map.lookup(20.5, 16.5, 0.3)
    assert np.all(form.lookup(*at) <= np.maximum(left, right) * 1.5)
    np.testing.assert_allclose(form.lookup(*at), expected, rtol=1e-6)


def test_measuring_agrees_with_the_fit(power_law: PowerLawMap, shading_map: Any) -> None:
    again = drain(measure(power_law, shading_map))
    np.testing.assert_allclose(again.error_map, power_law.error_map, rtol=1e-4, atol=1e-7)
    np.testing.assert_allclose(again.rms_per_channel, power_law.rms_per_channel, rtol=1e-5)


def test_the_worst_texels_are_the_darkening_patch(power_law: PowerLawMap, shading_map: Any) -> None:
    worst = worst_texels(power_law, 12)
    assert {(row, column) for row, column, _ in worst} == {(r, c) for r in range(20, 23) for c in range(30, 34)}
    assert [texel.error for texel in worst] == sorted((texel.error for texel in worst), reverse=True)
    assert worst[0].error == power_law.error_map.max()
    assert len(worst_texels(power_law, 10**6)) == power_law.error_map.size
    assert worst_texels(power_law, 0) == ()


def test_equal_errors_are_listed_from_the_upper_left() -> None:
    scale, exponent = np.ones((2, 3, 4, 3), np.float32)
    flat = PowerLawMap(scale, exponent, 1.0, 0.0, np.zeros(3), np.ones((3, 4), np.float32))
    assert [(row, column) for row, column, _ in worst_texels(flat, 5)] == [(0, 0), (0, 1), (0, 2), (0, 3), (1, 0)]


@pytest.mark.parametrize("bits", [8, 16])
def test_quantised_maps_hold_what_their_codes_say_and_stay_within_the_bound(
    power_law: PowerLawMap, shading_map: Any, bits: Any
) -> None:
    form = drain(quantise(power_law, shading_map, bits))
    codes, step = quantise_exponent(form.exponent, bits, form.storage.exponent_step)
    assert codes.dtype.itemsize * 8 == bits
    assert np.array_equal(restore_exponent(codes, step), form.exponent)
    assert np.array_equal(np.float32(np.float16(form.scale)), form.scale)
    change = max(
        np.abs(form.slice_image(r).astype(np.float64) - power_law.slice_image(r)).max()
        for r in np.linspace(0.0, 0.5, 401)
    )
    at_slices = max(
        np.abs(form.slice_image(r).astype(np.float64) - power_law.slice_image(r)).max()
        for r in shading_map.target_radiance
    )
    assert change <= form.storage.bound
    assert form.storage.measured == pytest.approx(at_slices, abs=1e-6)
    assert form.size_bytes * 64 == power_law.size_bytes * (16 + bits)
    np.testing.assert_allclose(form.error_map, errors(form, shading_map), atol=1e-6)
    assert form.rms <= power_law.rms + form.storage.measured


def test_more_bits_are_closer(power_law: PowerLawMap, shading_map: Any) -> None:
    coarse, fine = (drain(quantise(power_law, shading_map, bits)) for bits in (8, 16))
    assert fine.storage.bound < 0.1 * coarse.storage.bound
    assert fine.rms == pytest.approx(power_law.rms, rel=1e-3)


def test_a_few_steep_texels_do_not_coarsen_all_others(shading_map: Any) -> None:
    steep = np.array(shading_map.slices)
    steep[:-1, 0, 0] = 0.0
    plain, with_steep = (
        drain(quantise(drain(fit(form)), form, 8))
        for form in (shading_map, dataclasses.replace(shading_map, slices=steep))
    )
    assert with_steep.storage.exponent_step < 4 * plain.storage.exponent_step
    assert with_steep.rms < 1.2 * plain.rms


def test_a_bound_may_follow_quantising(power_law: PowerLawMap, shading_map: Any) -> None:
    form = mix(drain(quantise(power_law, shading_map, 8)), shading_map, 0.05)
    assert form.storage.exponent_bits == 8
    assert errors(form, shading_map).max() <= 0.05 + 1e-6


def test_impossible_tiles_are_refused(power_law: PowerLawMap, shading_map: Any) -> None:
    for bound, size in ((-1.0, 16), (np.nan, 16), (0.1, 0)):
        with pytest.raises(ValueError, match="not possible"):
            mix(power_law, shading_map, bound, size)
    tiles = cut_tiles(shading_map.slices, np.ones((3, 3), np.bool_), 16)
    with pytest.raises(ValueError, match="does not belong"):
        dataclasses.replace(power_law, kept=dataclasses.replace(tiles, place=tiles.place.reshape(1, 9)))
    with pytest.raises(ValueError, match="each of the 9 tiles once"):
        KeptTiles(np.zeros((3, 3), np.int32), tiles.slices)
    with pytest.raises(ValueError, match="tiles must be"):
        KeptTiles(tiles.place, tiles.slices[:, :, :8])

"""Colour: hard cases CO1–CO6 of the catalogue, R6, and the laws of the display step."""

from typing import Any, cast

import numpy as np
import pytest

from engine.core import colour

RNG = np.random.default_rng(17)


def test_R6_srgb_coding_is_undone_for_every_code() -> None:
    for codes, dtype, wrong in (
        (256, np.float64, 0),
        (65536, np.float64, 0),
        (256, np.float32, 0),
        (65536, np.float32, 1),
    ):
        coded = (np.arange(codes) / (codes - 1)).astype(dtype)
        back = colour.srgb_encode(colour.srgb_decode(coded))
        assert back.dtype == dtype
        off = np.abs(np.rint(back.astype(float) * (codes - 1)) - np.arange(codes))
        assert off.max() <= wrong, (codes, dtype)


def test_R6_no_jump_where_the_two_branches_meet() -> None:
    below, above = colour.srgb_decode(np.array([0.04045, np.nextafter(0.04045, 1)]))
    assert 0 <= above - below <= 1e-7
    assert colour.srgb_decode(0.5) == pytest.approx(((0.5 + 0.055) / 1.055) ** 2.4, rel=1e-15)


def test_CO1_xyz_there_and_back() -> None:
    rgb = RNG.uniform(-0.5, 4, (1000, 3))
    assert np.abs(colour.srgb_from_xyz(colour.xyz_from_srgb(rgb)) - rgb).max() <= 1e-14


def test_CO1_white_is_d65_and_neutral_stays_neutral() -> None:
    white = colour.xyz_from_srgb(np.ones(3))
    assert white == pytest.approx([0.3127 / 0.3290, 1.0, (1 - 0.3127 - 0.3290) / 0.3290], abs=1e-14)
    grey = np.full(3, 0.18, np.float32)
    back = colour.srgb_from_xyz(colour.xyz_from_srgb(grey))
    assert np.ptp(back) <= 1e-7
    assert colour.luminance(grey) == pytest.approx(0.18, rel=1e-6)


def test_CO2_singular_camera_matrices_are_refused() -> None:
    nan = np.eye(3)
    nan[0, 0] = np.nan
    for matrix in (np.zeros((3, 3)), np.ones((3, 3)), nan, np.diag([1, 1, 1e-9]), np.eye(2)):
        assert colour.srgb_from_camera(matrix) is None


def test_CO2_camera_white_becomes_neutral() -> None:
    camera_from_xyz = np.array([[0.7034, -0.0804, -0.1014], [-0.442, 1.2564, 0.2058], [-0.0851, 0.1994, 0.5758]])
    matrix = colour.srgb_from_camera(camera_from_xyz)
    assert matrix is not None
    assert matrix @ np.ones(3) == pytest.approx(np.ones(3), abs=1e-12)
    sums = (camera_from_xyz @ colour.XYZ_FROM_SRGB).sum(axis=1)
    assert matrix @ (camera_from_xyz @ colour.XYZ_FROM_SRGB / sums[:, None]) == pytest.approx(np.eye(3), abs=1e-12)


def test_CO3_negatives_survive_until_the_display() -> None:
    green_laser = np.array([-0.6, 1.2, -0.1])
    assert colour.srgb_from_xyz(colour.xyz_from_srgb(green_laser)) == pytest.approx(green_laser, abs=1e-14)
    assert colour.srgb_decode(colour.srgb_encode(green_laser)) == pytest.approx(green_laser, abs=1e-6)
    assert colour.to_display8(green_laser[None, None])[0, 0].tolist() == [0, 255, 0]


@pytest.mark.parametrize("operator", colour.OPERATORS)
def test_CO4_CO5_extreme_values_and_exposures_stay_finite(operator: Any) -> None:
    values = np.array([np.nan, np.inf, -np.inf, 1e9, -1, 3e38, 1e-38, 0, 1], np.float32)
    image = np.stack(np.meshgrid(values, values, values), axis=-1).reshape(27, 27, 3)
    for exposure_ev in (-20, 0, 20):
        shown = colour.tone_map(image, exposure_ev, operator)
        assert np.isfinite(shown).all()
        assert shown.min() >= 0
        assert colour.to_display8(shown).dtype == np.uint8
    assert colour.to_display8(np.array([[[np.nan, np.inf, 1e9]]], np.float32)).tolist() == [[[0, 255, 255]]]
    assert colour.srgb_encode(np.array([np.inf, -1, 1e9], np.float64))[1] == pytest.approx(-1)
    assert np.isnan(colour.srgb_encode(np.array([np.nan], np.float64))).all()


def test_CO5_exposure_is_a_power_of_two() -> None:
    image = RNG.uniform(0, 4, (5, 7, 3)).astype(np.float32)
    for exposure_ev in (-20, -3, 0, 7, 20):
        assert np.array_equal(colour.tone_map(image, exposure_ev, "none"), image * np.float32(2.0**exposure_ev))


def test_neutral_keeps_dim_colours_and_compresses_bright_ones() -> None:
    dim = RNG.uniform(0.1, 0.7, (100, 1, 3)).astype(np.float32)
    assert np.abs(colour.tone_map(dim) - (dim - 0.04)).max() <= 1e-6
    bright = colour.tone_map(np.array([[[10, 10, 10], [1000, 1, 1]]], np.float32))
    assert bright.max() < 1
    assert bright[0, 1, 1] > 0.5, "very bright red turns white"


def test_aces_matches_the_published_curve_for_grey() -> None:
    grey = np.array([[[0.18] * 3]], np.float32)
    v = 0.18
    fitted = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081)
    assert colour.tone_map(grey, 0, "aces")[0, 0] == pytest.approx([fitted] * 3, abs=1e-4)


def test_CO6_dither_is_deterministic_and_keeps_the_mean() -> None:
    image = np.full((64, 64, 3), colour.srgb_decode(100.3 / 255), np.float32)
    first, second = (colour.to_display8(image, dither=True) for _ in range(2))
    assert np.array_equal(first, second)
    assert set(np.unique(first)) == {100, 101}
    assert first.mean() == pytest.approx(100.3, abs=0.02)


def test_unknown_operator_is_a_wrong_call() -> None:
    with pytest.raises(ValueError, match="filmic"):
        colour.tone_map(np.zeros((1, 1, 3)), 0, cast(Any, "filmic"))

"""Environment files: what is repaired and counted, what is refused, what is built in, and averaging by area."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.environment import EnvironmentMap, all_lights, reduced, solid_angles
from engine.environment_file import open_environment, read_environment, repair
from engine.errors import InputError
from engine.images.encode import encode_png, rgb_channels, write_exr
from engine.light_tree import chosen_lights
from engine.sky import SKIES


def write(path: Path, radiance: Any) -> Path:
    write_exr(path, rgb_channels(np.asarray(radiance, np.float32)), half=False)
    return path


def test_a_sound_file_is_read_as_it_is(tmp_path: Path) -> None:
    radiance = np.random.default_rng(0).uniform(0, 9, (8, 16, 3)).astype(np.float32)
    environment = read_environment(write(tmp_path / "a.exr", radiance))
    assert np.array_equal(environment.radiance, radiance)
    assert not environment.health.warnings


def test_EN5_bad_texels_become_the_median_of_their_neighbours_and_are_counted(tmp_path: Path) -> None:
    radiance = np.ones((8, 16, 3), np.float32)
    radiance[3, 4] = (-149.0, 7.0, 7.0)
    radiance[5, 0] = np.inf
    radiance[6, 9, 1] = np.nan
    radiance[5, 15] = 5.0  # a neighbour across the seam, which the median ignores
    environment = read_environment(write(tmp_path / "a.exr", radiance))
    assert environment.radiance[3, 4].tolist() == [1.0, 7.0, 7.0]
    assert environment.radiance[5, 0].tolist() == [1.0, 1.0, 1.0]
    assert environment.radiance[6, 9].tolist() == [1.0, 1.0, 1.0]
    assert environment.health.figures["negative_texels"] == 1
    assert environment.health.figures["nonfinite_texels"] == 2
    assert environment.health.figures["most_negative_radiance"] == -149.0
    said = " ".join(environment.health.warnings)
    assert "column 4, row 3" in said
    assert "-149" in said


def test_EN5_the_median_wraps_around() -> None:
    radiance = np.full((3, 6, 3), 9.0, np.float32)
    radiance[:, 5] = 2.0
    radiance[:, 1] = 4.0
    bad = np.zeros(radiance.shape, bool)
    bad[:, 0] = True
    repaired, unreached = repair(radiance, bad)
    assert (repaired[:, 0] == 3.0).all()
    assert unreached == 0


def test_EN5_areas_are_filled_from_their_edge_and_black_deep_inside() -> None:
    radiance = np.ones((64, 128, 3), np.float32)
    bad = np.zeros(radiance.shape, bool)
    bad[2:62, 2:126] = True
    repaired, unreached = repair(radiance, bad)
    assert repaired[2:18].min() == 1.0
    assert repaired[32, 64].max() == 0.0
    assert unreached == 3 * (60 - 32) * (124 - 32)


@pytest.mark.parametrize("shape", [(1, 1), (4, 4), (6, 4), (4, 6), (3, 18), (18, 3), (3, 4), (8, 15)])
def test_EN10_other_layouts_are_refused_in_words(tmp_path: Path, shape: tuple[int, int]) -> None:
    with pytest.raises(InputError, match="twice as wide as high") as failure:
        read_environment(write(tmp_path / "a.exr", np.ones((*shape, 3))))
    assert ("cube map" in str(failure.value)) == (max(shape) / min(shape) in (6.0, 4 / 3))


def test_EN10_the_smallest_map_is_two_texels(tmp_path: Path) -> None:
    environment = read_environment(write(tmp_path / "a.exr", np.ones((1, 2, 3))))
    assert chosen_lights(environment, 4).irradiance.sum() == pytest.approx(3 * 4 * np.pi)


@pytest.mark.parametrize("value", [-1.0, np.nan])
def test_a_file_without_any_light_in_it_is_refused(tmp_path: Path, value: float) -> None:
    with pytest.raises(InputError, match="no usable radiance"):
        read_environment(write(tmp_path / "a.exr", np.full((2, 4, 3), value)))


def test_a_black_map_and_an_ordinary_picture_are_warned_of(tmp_path: Path) -> None:
    assert "black" in read_environment(write(tmp_path / "a.exr", np.zeros((2, 4, 3)))).health.warnings[0]
    (tmp_path / "a.png").write_bytes(encode_png(np.full((4, 8, 3), 255, np.uint8)))
    environment = read_environment(tmp_path / "a.png")
    assert environment.radiance.max() == 1.0
    assert "PNG that holds no radiance above 1" in environment.health.warnings[0]


def test_damaged_and_missing_files_are_input_errors(tmp_path: Path, shared_data: Any) -> None:
    for name in ("nothing.hdr", "nothing"):
        with pytest.raises(InputError, match="nothing"):
            open_environment(tmp_path / name)
    for path in shared_data("hdr/damaged").iterdir():
        with pytest.raises(InputError, match=path.name):
            open_environment(path)
    with pytest.raises(InputError, match="cube map"):
        open_environment(shared_data("hdr/openexr/StageEnvCube.exr"))
    with pytest.raises(InputError, match="not an equirectangular"):
        open_environment(shared_data("hdr/not_equirect/memorial.hdr"))


@pytest.mark.parametrize(
    ("name", "negative", "lowest"),
    [("city", 158, -0.0766), ("studio", 798, -149.0), ("forest", 2599, -3.32), ("apartment", 11, -0.572)],
)
def test_EN5_real_maps_with_negative_texels(shared_data: Any, name: str, negative: int, lowest: float) -> None:
    environment = open_environment(shared_data(f"hdr/pmndrs_cc0/{name}.exr"))
    assert environment.health.figures["negative_texels"] == negative
    assert environment.health.figures["most_negative_radiance"] == pytest.approx(lowest, rel=5e-3)
    assert environment.radiance.min() >= 0.0


@pytest.mark.parametrize("name", SKIES)
def test_built_in_maps_need_no_file(name: str) -> None:
    environment = open_environment(name)
    assert environment.name == name
    assert 0.5 < all_lights(environment).irradiance.sum() / (4 * np.pi) < 5.0


@pytest.mark.parametrize("rows", [1, 3, 16, 21])
def test_averaging_by_area_keeps_the_flux(rows: int) -> None:
    environment = EnvironmentMap(np.random.default_rng(0).uniform(0, 9, (32, 64, 3)).astype(np.float32))
    small = reduced(environment, rows)
    assert small.radiance.shape == (rows, 2 * rows, 3)
    flux = [
        (m.radiance * solid_angles(*m.radiance.shape[:2])[..., None]).sum(axis=(0, 1)) for m in (environment, small)
    ]
    np.testing.assert_allclose(flux[0], flux[1], rtol=1e-6)


def test_EN9_a_constant_stays_constant_and_small_maps_stay() -> None:
    environment = EnvironmentMap(np.full((100, 200, 3), 0.7, np.float32))
    np.testing.assert_allclose(reduced(environment, 7).radiance, 0.7, rtol=1e-6)
    assert reduced(environment, 100) is environment

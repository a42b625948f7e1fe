"""Environment files: what is repaired and counted, what is refused, what is built in, and averaging by area."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import pytest

from engine.core.errors import InputError
from engine.images.encode import encode_exr, encode_png, rgb_channels, write_exr
from engine.light.cube_map import cube_directions, direction_on_face
from engine.light.environment import EnvironmentMap, all_lights, reduce, solid_angles, texel_directions
from engine.light.environment_file import open_environment, read_environment, repair
from engine.light.light_tree import choose_lights
from engine.light.sky import SKIES
from tests.engine.damage import ROUNDS, find_damaged


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
    assert environment.radiance[5, 0].tolist() == [65504.0, 65504.0, 65504.0]
    assert environment.radiance[6, 9].tolist() == [1.0, 1.0, 1.0]
    assert environment.health.figures["negative_texels"] == 1
    assert environment.health.figures["nonfinite_texels"] == 1
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


@pytest.mark.parametrize(
    ("shape", "words"),
    [
        ((1, 1), "angular map"),
        ((4, 4), "angular map"),
        ((6, 4), "two rows"),
        ((4, 6), "two rows"),
        ((3, 4), "photograph"),
        ((12, 9), "corners are not empty"),
        ((8, 15), "not an equirectangular map"),
        ((2, 1), "not an equirectangular map"),
    ],
)
def test_EN10_other_layouts_are_refused_in_words(tmp_path: Path, shape: tuple[int, int], words: str) -> None:
    noise = np.random.default_rng(0).random((*shape, 3))
    with pytest.raises(InputError, match="twice as wide as high") as failure:
        read_environment(write(tmp_path / "a.exr", noise))
    assert words in str(failure.value)


def faces(edge: int = 16) -> np.ndarray:
    """A smooth map whose faces differ in brightness and colour, (6, N, N, 3)."""
    direction = cube_directions(edge)
    return (2.0 + direction + 0.5 * direction[..., [1, 2, 0]] * direction).astype(np.float32)


def strip(faces: np.ndarray) -> np.ndarray:
    return faces.reshape(-1, faces.shape[2], 3)


def cross(faces: np.ndarray, standing: bool) -> np.ndarray:
    """Around +Z as OpenGL's faces unfold; a cross that stands has −Z upside down at its foot."""
    n = faces.shape[1]
    image = np.zeros((4 * n, 3 * n, 3) if standing else (3 * n, 4 * n, 3), np.float32)
    places = {0: (1, 2), 1: (1, 0), 2: (0, 1), 3: (2, 1), 4: (1, 1), 5: (3, 1) if standing else (1, 3)}
    for face, (i, j) in places.items():
        turned = faces[face][::-1, ::-1] if standing and face == 5 else faces[face]
        image[i * n : (i + 1) * n, j * n : (j + 1) * n] = turned
    return image


def inside_out(faces: np.ndarray) -> np.ndarray:
    seen = faces[:, :, ::-1].copy()
    seen[2:4] = faces[2:4, ::-1]
    return seen


LAYOUTS = {
    "standing strip": strip(faces()),
    "lying strip": np.concatenate(list(faces()), axis=1),
    "mirrored strip": strip(inside_out(faces())),
    "lying cross": cross(faces(), standing=False),
    "standing cross": cross(faces(), standing=True),
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_EN13_cube_maps_are_converted_in_every_layout(tmp_path: Path, layout: str) -> None:
    environment = read_environment(write(tmp_path / "a.exr", LAYOUTS[layout]))
    assert environment.radiance.shape == (32, 64, 3)
    assert "cube map" in environment.health.warnings[0]
    assert ("mirrored" in " ".join(environment.health.warnings)) == ("mirrored" in layout)
    assert "do not fit" not in " ".join(environment.health.warnings)
    direction = texel_directions(32, 64)
    exact = 2.0 + direction + 0.5 * direction[..., [1, 2, 0]] * direction
    np.testing.assert_allclose(environment.radiance, exact, atol=0.13)  # half of a texel's diagonal


def test_faces_that_do_not_fit_together_are_warned_of(tmp_path: Path) -> None:
    swapped = faces(64)[[4, 1, 3, 2, 0, 5]]
    warnings = read_environment(write(tmp_path / "a.exr", strip(swapped))).health.warnings
    assert any("do not fit together" in text for text in warnings)


def test_EN5_one_bad_texel_of_a_cube_map_does_not_spread(tmp_path: Path) -> None:
    bad = strip(faces()).copy()
    bad[40, 3] = np.nan
    environment = read_environment(write(tmp_path / "a.exr", bad))
    sound = read_environment(write(tmp_path / "b.exr", strip(faces())))
    assert environment.health.figures["nonfinite_texels"] == 1
    assert np.abs(environment.radiance - sound.radiance).max() < 0.3
    assert "column 3, row 40" in " ".join(environment.health.warnings)


def test_EN13_a_cube_map_of_openexr_has_samples_on_its_edges(tmp_path: Path) -> None:
    """Faces as ImfEnvmap.h has them: seen from inside, the outermost samples on the edges."""
    n = 17
    along = np.linspace(0.0, 1.0, n)
    face, t, s = np.meshgrid(np.arange(6), along, along, indexing="ij")
    direction = direction_on_face(face, s, t)
    content = io.BytesIO()
    seen = strip(inside_out((2.0 + direction).astype(np.float32)))
    channels = {name: np.ascontiguousarray(seen[..., index]) for index, name in enumerate("RGB")}
    OpenEXR.File({"type": OpenEXR.scanlineimage, "envmap": OpenEXR.ENVMAP_CUBE}, channels).write(content)
    (tmp_path / "a.exr").write_bytes(content.getvalue())
    environment = read_environment(tmp_path / "a.exr")
    np.testing.assert_allclose(environment.radiance, 2.0 + texel_directions(34, 68), atol=0.06)
    (tmp_path / "latlong.exr").write_bytes(encode_exr(rgb_channels(np.ones((2, 4, 3))), attributes={"comments": "x"}))
    assert not read_environment(tmp_path / "latlong.exr").health.warnings


def test_a_real_cube_map_is_converted_without_seams(shared_data: Any) -> None:
    environment = open_environment(shared_data("hdr/openexr/StageEnvCube.exr"))
    assert environment.radiance.shape == (512, 1024, 3)
    assert environment.health.warnings == ["is a cube map of OpenEXR; it was converted to latitude and longitude"]
    level = np.log1p(environment.radiance.astype(np.float64)).mean(axis=2)
    across = np.abs(np.diff(level, axis=1)).mean(axis=0)
    edges = np.arange(127, 1023, 256)  # between upright faces
    assert across[edges].max() <= np.quantile(across, 0.98)


@pytest.mark.parametrize("half", [True, False])
def test_EN7_values_at_the_end_of_half_floats(tmp_path: Path, half: bool) -> None:
    """Half images hold what is above 65504 as that; float images hold it."""
    values = (65504.0, 65519.0, 65520.0, 1e6)
    radiance = np.ones((2, 4, 3), np.float32)
    radiance[0] = np.array(values, np.float32)[:, None]
    write_exr(tmp_path / "a.exr", rgb_channels(radiance), half=half)
    environment = read_environment(tmp_path / "a.exr")
    assert environment.radiance[0, :, 0].tolist() == [min(value, 65504.0) if half else value for value in values]
    assert not environment.health.warnings


def test_EN5_infinities_of_half_floats_are_the_sun(tmp_path: Path) -> None:
    """The median of the neighbours took the light of the sun out of the map."""
    radiance = np.ones((4, 8, 3), np.float16)
    radiance[2, 5] = np.inf
    content = io.BytesIO()
    channels = {name: np.ascontiguousarray(radiance[..., index]) for index, name in enumerate("RGB")}
    OpenEXR.File({"type": OpenEXR.scanlineimage}, channels).write(content)
    (tmp_path / "a.exr").write_bytes(content.getvalue())
    environment = read_environment(tmp_path / "a.exr")
    assert environment.radiance[2, 5].tolist() == [65504.0] * 3
    assert np.sum(environment.radiance == 1.0) == 3 * (4 * 8 - 1)
    assert environment.health.figures["nonfinite_texels"] == 0
    assert any("3 samples are infinite" in text for text in environment.health.warnings)


def test_the_first_part_with_colours_is_read(tmp_path: Path) -> None:
    radiance = np.random.default_rng(1).uniform(0.0, 4.0, (4, 8, 3)).astype(np.float32)
    colours = {name: np.ascontiguousarray(radiance[..., index]) for index, name in enumerate("RGB")}
    depth = {"Z": np.full((4, 8), 7.0, np.float32)}
    parts = [
        OpenEXR.Part({"name": name, "type": OpenEXR.scanlineimage}, channels)
        for name, channels in (("depth", depth), ("beauty", colours), ("other", {k: v + 1 for k, v in colours.items()}))
    ]
    OpenEXR.File(parts).write(str(tmp_path / "a.exr"))
    environment = read_environment(tmp_path / "a.exr")
    assert np.array_equal(environment.radiance, radiance)
    assert any("part 2" in text for text in environment.health.warnings)


def test_a_part_of_the_display_window_is_completed_by_black(tmp_path: Path) -> None:
    """A quarter of the sphere was stretched over all of it."""
    radiance = np.ones((2, 4, 3), np.float32)
    channels = {name: np.ascontiguousarray(radiance[..., index]) for index, name in enumerate("RGB")}
    windows = {
        "dataWindow": (np.array([6, 3], np.int32), np.array([9, 4], np.int32)),
        "displayWindow": (np.array([2, 2], np.int32), np.array([17, 9], np.int32)),
    }
    OpenEXR.File({"type": OpenEXR.scanlineimage, **windows}, channels).write(str(tmp_path / "a.exr"))
    environment = read_environment(tmp_path / "a.exr")
    assert environment.radiance.shape == (8, 16, 3)
    assert np.argwhere(environment.radiance[..., 0])[[0, -1]].tolist() == [[1, 4], [2, 7]]
    assert environment.radiance.sum() == 2 * 4 * 3
    assert any("the rest is black" in text for text in environment.health.warnings)


def test_EN10_the_smallest_map_is_two_texels(tmp_path: Path) -> None:
    environment = read_environment(write(tmp_path / "a.exr", np.ones((1, 2, 3))))
    assert choose_lights(environment, 4).irradiance.sum() == pytest.approx(3 * 4 * np.pi)


@pytest.mark.parametrize("value", [-1.0, np.nan])
def test_a_file_without_any_light_in_it_is_refused(tmp_path: Path, value: float) -> None:
    with pytest.raises(InputError, match="no usable radiance"):
        read_environment(write(tmp_path / "a.exr", np.full((2, 4, 3), value)))


def test_a_black_map_and_an_ordinary_image_are_warned_of(tmp_path: Path) -> None:
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
    with pytest.raises(InputError, match="photograph"):
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
    small = reduce(environment, rows)
    assert small.radiance.shape == (rows, 2 * rows, 3)
    flux = [
        (m.radiance * solid_angles(*m.radiance.shape[:2])[..., None]).sum(axis=(0, 1)) for m in (environment, small)
    ]
    np.testing.assert_allclose(flux[0], flux[1], rtol=1e-6)


def test_EN9_a_constant_stays_constant_and_small_maps_stay() -> None:
    environment = EnvironmentMap(np.full((100, 200, 3), 0.7, np.float32))
    np.testing.assert_allclose(reduce(environment, 7).radiance, 0.7, rtol=1e-6)
    assert reduce(environment, 100) is environment


def runs_of_1990() -> bytes:
    """A Radiance image of 16 × 8 texels in the run-length coding before 1991."""
    line = b"\x80\x40\x20\x81\1\1\1\x07\xff\x00\x10\x83\1\1\1\x07"
    return b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1\n\n-Y 8 +X 16\n" + line * 8


def exr_cube() -> bytes:
    content = io.BytesIO()
    channels = {name: np.ascontiguousarray(strip(faces(4))[..., index]) for index, name in enumerate("RGB")}
    OpenEXR.File({"type": OpenEXR.scanlineimage, "envmap": OpenEXR.ENVMAP_CUBE}, channels).write(content)
    return content.getvalue()


@pytest.mark.campaign(rounds=ROUNDS)
@pytest.mark.parametrize("make", [runs_of_1990, exr_cube])
def test_fault5_damaged_environments_are_read_or_refused_in_words(
    tmp_path: Path, make: Callable[[], bytes], seed: int
) -> None:
    path, good = tmp_path / "damaged", make()
    refused = 0
    damages = list(find_damaged(good, (0, len(good)), count=300, seed=seed))
    for damage in damages:
        path.write_bytes(damage.content)
        try:
            radiance = read_environment(path).radiance
        except InputError as failure:
            refused += bool(failure.problem and failure.remedy)
        else:
            assert np.isfinite(radiance).all(), damage
            assert radiance.min() >= 0, damage
            assert damage.what != "cut", damage
    assert refused > len(damages) // 5

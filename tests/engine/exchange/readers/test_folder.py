"""Folders of textures: names of many programs, packing, coding, the direction of y, and what is refused."""

from __future__ import annotations

import dataclasses
import zipfile
from pathlib import Path

import numpy as np
import pytest

from engine.core.errors import InputError
from engine.core.steps import drain
from engine.exchange.coding import CODINGS, Coding
from engine.exchange.export import ERRORS, export
from engine.exchange.readers.folder import are_textures, holds_textures, kind_of
from engine.exchange.readers.read import open_material, read_textures
from engine.exchange.subject import Settings, Subject
from engine.exchange.textures import PRESETS, contents
from engine.scene.material import Material, material_of_maps
from engine.surface.pbr_maps import PbrMaps

from .images import SIZE, find_known, grey, png, relief


def open_path(path: Path) -> tuple[PbrMaps, list[str]]:
    material = open_material(path)
    assert material.pbr is not None
    return material.pbr, material.health.warnings


def write(folder: Path, maps: PbrMaps, preset: str, coding: Coding = "png8") -> Path:
    subject = Subject(material_of_maps(maps, "rock"), maps, 1.0 / np.pi)
    folder.mkdir()
    for name, content in drain(contents(subject, Settings(preset, coding), "")).files.items():
        (folder / name).write_bytes(content)
    return folder


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("Bricks076_1K-JPG_Color.jpg", "base_colour"),
        ("Bricks076_1K-JPG_NormalGL.jpg", "normal"),
        ("Bricks076_1K-JPG_AmbientOcclusion.jpg", "occlusion"),
        ("brick_wall_02_diff_2k.png", "base_colour"),
        ("brick_wall_02_nor_gl_2k.exr", "normal"),
        ("brick_wall_02_arm_2k.png", "orm"),
        ("brick_wall_02_disp_4k.png", "height"),
        ("T_Rock_BC.tga", "base_colour"),
        ("T_Rock_N.tga", "normal"),
        ("T_Rock_ORM.tga", "orm"),
        ("Rock_MaskMap.png", "mask"),
        ("Rock_MetallicSmoothness.png", "metallic_smoothness"),
        ("RockBaseColor.png", "base_colour"),
        ("rock_occlusionRoughnessMetallic.png", "orm"),
        ("Metal_Roughness.png", "roughness"),
        ("metallic.exr", "metallic"),
        ("base_colour_sigma.exr", ""),
        ("preview.png", ""),
        ("n.png", ""),
        ("felt_n_orm.png", "orm"),
        ("felt_n_normal.png", "normal"),
        ("Rock_NormalD3D.png", "normal"),
    ],
)
def test_names_of_programs(name: str, kind: str) -> None:
    assert kind_of(name)[0] == kind


@pytest.mark.parametrize("coding", CODINGS)
@pytest.mark.parametrize("preset", sorted(PRESETS))
def test_own_textures_come_back_within_their_rounding(tmp_path: Path, preset: str, coding: Coding) -> None:
    maps = find_known()
    found, _ = open_path(write(tmp_path / "rock", maps, preset, coding))
    step = {"png8": 0.5 / 255, "png16": 0.5 / 65535, "exr": 2.0**-11}[coding] * 1.01
    assert np.abs(found.roughness - maps.roughness).max() <= step + 1e-7
    assert np.abs(found.metallic - maps.metallic).max() <= step + 1e-7
    # sRGB is steepest at 1, where a step of the code is 2.4 / 1.055 steps of light
    assert np.abs(found.base_colour - maps.base_colour).max() <= step * 2.4 / 1.055 + 1e-6
    # x and y are rounded by twice a step, and what that does to the length is of second order
    assert np.abs(found.normal - maps.normal).max() <= 4.0 * step


@pytest.mark.parametrize("coding", CODINGS)
@pytest.mark.parametrize("slope", [0.0, 0.4])
def test_normals_that_nowhere_go_below_zero_come_back(tmp_path: Path, coding: Coding, slope: float) -> None:
    """Flat ones, or those of one slope: in OpenEXR they are n itself, which looks like codes but for its length."""
    normal = np.full((4, 4, 3), (slope, slope, 1.0)) / np.sqrt(1.0 + 2.0 * slope**2)
    grey_map = np.full((4, 4), 0.5, np.float32)
    base = np.full((4, 4, 3), 0.5, np.float32)
    maps = PbrMaps(base, normal.astype(np.float32), grey_map, grey_map, np.full((4, 4), 0.04, np.float32))
    found, _ = open_path(write(tmp_path / "rock", maps, "blender", coding))
    np.testing.assert_allclose(found.normal, maps.normal, atol=0.01)


def test_slopes_tell_the_direction_of_y(tmp_path: Path) -> None:
    """The same relief with y up and y down, under a name that says neither: the gradient of a height has no curl."""
    up = np.rint(255.0 * (0.5 + 0.5 * relief())).astype(np.uint8)
    down = up.copy()
    down[..., 1] = 255 - down[..., 1]
    for name, codes in (("up", up), ("down", down)):
        png(tmp_path / name / "rock_color.png", grey(128, SIZE))
        png(tmp_path / name / "rock_normal.png", codes)
        found, notes = open_path(tmp_path / name)
        assert np.abs(found.normal - relief()).max() < 0.02
        assert any(f"({'OpenGL' if name == 'up' else 'DirectX'}), by its slopes" in note for note in notes)


def test_few_texels_of_noise_contradict_no_name(tmp_path: Path) -> None:
    """Independent slopes tell no direction; one in five of such maps was said to have y the other way round."""
    random = np.random.default_rng(6)
    for number in range(8):
        codes = random.integers(100, 156, (8, 8, 3)).astype(np.uint8)
        codes[..., 2] = 230
        png(tmp_path / f"{number}" / "rock_color.png", grey(128, 8))
        png(tmp_path / f"{number}" / "rock_normal_gl.png", codes)
        assert not any("are called opengl" in note for note in open_path(tmp_path / f"{number}")[1])


def test_a_name_that_contradicts_the_slopes_is_said(tmp_path: Path) -> None:
    png(tmp_path / "rock_color.png", grey(128, SIZE))
    png(tmp_path / "rock_normal_dx.png", np.rint(255.0 * (0.5 + 0.5 * relief())))
    found, notes = open_path(tmp_path)
    assert "called directx" in " ".join(notes)
    assert found.normal[0, 0, 1] == pytest.approx(-relief()[0, 0, 1], abs=0.02)


def test_of_two_normals_the_one_with_y_up_is_taken(tmp_path: Path) -> None:
    png(tmp_path / "R_1K_Color.png", grey(255))
    png(tmp_path / "R_1K_NormalDX.png", np.tile(np.array([128, 0, 255], np.uint8), (4, 4, 1)))
    png(tmp_path / "R_1K_NormalGL.png", np.tile(np.array([128, 255, 255], np.uint8), (4, 4, 1)))
    assert open_path(tmp_path)[0].normal[0, 0, 1] > 0.5


def test_base_colour_is_srgb_and_the_rest_is_not(tmp_path: Path) -> None:
    png(tmp_path / "r_color.png", grey(188))
    png(tmp_path / "r_gloss.png", grey(51))
    found, notes = open_path(tmp_path)
    assert found.base_colour[0, 0, 0] == pytest.approx(0.5029, abs=1e-3)  # IEC 61966-2-1
    assert found.roughness[0, 0] == pytest.approx(0.8, abs=1e-6)
    assert any("metallic 0, normal flat" in note for note in notes)


def test_textures_without_their_folder_are_the_same_material(tmp_path: Path) -> None:
    """Their name is what their names have in common; of a single map, or of an image of no map, there is none."""
    folder = write(tmp_path / "downloads", find_known(), "blender")
    files = sorted(folder.glob("*.png"))
    assert are_textures(files)
    alone, whole = drain(read_textures(files)), open_material(folder)
    assert (alone.name, whole.name) == ("rock", "downloads")
    assert alone.pbr is not None
    assert whole.pbr is not None
    for name in ("base_colour", "normal", "roughness", "metallic"):
        np.testing.assert_array_equal(getattr(alone.pbr, name), getattr(whole.pbr, name))
    assert not are_textures(files[:1])
    assert not are_textures([*files, png(tmp_path / "preview.png", grey(1))])
    assert not are_textures([*files, tmp_path / "rock_normal.txt"])


def test_sizes_are_brought_to_the_largest_and_said(tmp_path: Path) -> None:
    png(tmp_path / "r_color.png", grey(255, 8))
    png(tmp_path / "r_rough.png", grey(102, 4))
    found, notes = open_path(tmp_path)
    assert found.size == (8, 8)
    assert np.allclose(found.roughness, 0.4)
    assert any("r_rough.png: another size than 8 × 8" in note for note in notes)


def test_one_brdf_stands_for_the_maps_at_their_mean(tmp_path: Path) -> None:
    maps = find_known()
    material = material_of_maps(maps, "rock")
    mean = material.reflectance
    assert dataclasses.asdict(mean)["roughness"] == pytest.approx(maps.roughness.mean(), abs=1e-5)  # type: ignore[call-overload]
    assert isinstance(material, Material)
    assert material.has_map
    assert material.size == maps.size


def test_refusals_name_cause_and_remedy(tmp_path: Path) -> None:
    png(tmp_path / "two" / "a_color.png", grey(1))
    png(tmp_path / "two" / "b_color.png", grey(1))
    png(tmp_path / "two" / "a_rough.png", grey(1))
    with pytest.raises(InputError, match=r"several images for base colour \(a_color.png, b_color.png\)"):
        open_material(tmp_path / "two")
    png(tmp_path / "one" / "a_color.png", grey(1))
    assert not holds_textures(tmp_path / "one")
    with pytest.raises(InputError, match="by their names these are base colour alone"):
        open_material(tmp_path / "one")
    for side in "nsd":  # photographs from the north, the south and above are no textures
        png(tmp_path / "sides" / f"cat_{side}.png", grey(1))
    assert not holds_textures(tmp_path / "sides")
    (tmp_path / "one" / "a_rough.png").write_bytes(b"\x89PNG\r\n\x1a\nnonsense")
    with pytest.raises(InputError, match=r"a_rough\.png: is an incomplete PNG"):
        open_material(tmp_path / "one")


@pytest.mark.parametrize("preset", PRESETS)
def test_an_export_says_where_y_of_its_normals_points(preset: str, tmp_path: Path) -> None:
    """Also where slopes do not tell: on a plane that tilts towards one corner."""
    maps = find_known()
    tilted = np.array([0.3, 0.4, 0.866], np.float32)
    normal = np.broadcast_to(tilted / np.linalg.norm(tilted), maps.normal.shape)
    maps = dataclasses.replace(maps, normal=normal.astype(np.float32))
    errors = {**dict.fromkeys(ERRORS, 0.0), "by_environment": {"studio": {"rmse_rel": 0.0, "flip": 0.0}}}
    known = {"textures": errors}  # nothing is measured
    material = material_of_maps(maps, "rock")
    drain(export(tmp_path / "out", material, ["textures"], settings=Settings(preset), known=known))
    found, notes = open_path(tmp_path / "out" / "textures")
    assert np.abs(found.normal - maps.normal).max() < 0.02
    assert not any("y of the normals" in note for note in notes)
    with zipfile.ZipFile(tmp_path / "out.zip", "w") as archive:
        for file in (each for each in (tmp_path / "out").rglob("*") if each.is_file()):
            archive.write(file, file.relative_to(tmp_path / "out"))
    found, notes = open_path(tmp_path / "out.zip")
    assert np.abs(found.normal - maps.normal).max() < 0.02
    assert not any("y of the normals" in note for note in notes)


def test_names_of_unreal_have_normals_with_y_down(tmp_path: Path) -> None:
    tilted = np.tile(np.array([128, 200, 230], np.uint8), (4, 4, 1))
    for name, texels in (("T_Rock_BC", grey(90)), ("T_Rock_N", tilted), ("T_Rock_ORM", grey(200))):
        png(tmp_path / f"{name}.png", texels)
    assert open_path(tmp_path)[0].normal[0, 0, 1] < -0.4


def test_images_that_are_named_for_no_map_are_named(tmp_path: Path) -> None:
    for name in ("T_Metal_BC", "T_Metal_E", "T_Metal_N", "T_Metal_Opacity", "T_Metal_ORM"):
        png(tmp_path / f"{name}.png", grey(100))
    said = [note for note in open_path(tmp_path)[1] if "named for no map" in note]
    assert len(said) == 1
    assert "T_Metal_E.png" in said[0]
    assert "T_Metal_Opacity.png" in said[0]
    with zipfile.ZipFile(tmp_path / "all.zip", "w") as archive:
        for file in tmp_path.glob("*.png"):
            archive.write(file, file.name)
    assert any("T_Metal_Opacity.png" in note for note in open_path(tmp_path / "all.zip")[1])


def test_a_set_of_tiles_is_called_one(tmp_path: Path) -> None:
    for name in ("body_BaseColor.1001", "body_BaseColor.1002", "body_Roughness.1001", "body_Roughness.1002"):
        png(tmp_path / f"{name}.png", grey(100))
    with pytest.raises(InputError, match="UDIM"):
        open_material(tmp_path)


@pytest.mark.parametrize("name", ["rock_basecolor.ktx2", "rock_basecolor.dds"])
def test_textures_of_graphics_devices_are_named_with_the_remedy(name: str, tmp_path: Path) -> None:
    """As one file, and in a folder; `engine.images.decode` says it of images that documents name."""
    (tmp_path / name).write_bytes(b"\xabKTX 20\xbb\r\n\x1a\n" if name.endswith("ktx2") else b"DDS |")
    for path in (tmp_path / name, tmp_path):
        with pytest.raises(InputError, match=r"not read.*Convert it to PNG"):
            open_material(path)

"""Textures: values come back from the files, under the names that importers look for."""

from __future__ import annotations

import dataclasses
import io
import re
from typing import Any

import cv2
import numpy as np
import OpenEXR
import pytest

from engine.core.errors import UsageError
from engine.core.steps import drain
from engine.exchange import blender, gltf, materialx, textures, usd
from engine.exchange.coding import CODINGS, Coding, round_values
from engine.exchange.loss import environment_lights, sphere
from engine.exchange.subject import Contents, Settings, Subject
from engine.exchange.textures import PRESETS
from engine.scene.material import Material
from engine.surface.pbr_maps import ObservedSlopes

from .materials import dome_material, measure_maps, measure_subject, woven_subject


def contents(subject: Subject, settings: Settings) -> Contents:
    return drain(textures.contents(subject, settings, ""))


def decode(content: bytes) -> np.ndarray:
    pixels = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
    assert pixels is not None
    image = np.atleast_3d(pixels)
    order = {1: [0], 3: [2, 1, 0], 4: [2, 1, 0, 3]}[image.shape[2]]
    return image[..., order].astype(np.float64) / np.iinfo(image.dtype).max


def linear(coded: np.ndarray) -> np.ndarray:
    """IEC 61966-2-1, written here anew."""
    return np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)


@pytest.mark.parametrize(("coding", "half_code"), [("png8", 0.5 / 255), ("png16", 0.5 / 65535)])
def test_values_come_back_from_png(coding: Coding, half_code: float) -> None:
    subject = measure_subject()
    maps, made = subject.maps, (contents(subject, Settings("blender", coding)))
    assert maps.occlusion is not None
    assert maps.height is not None
    files = {re.sub(r"A_cloth_woven_|\.png", "", name): decode(content) for name, content in made.files.items()}
    assert set(files) == {"base_color", "normal", "roughness", "metallic", "specular", "height", "ao", "cavity"}
    one = half_code * 1.001 + 1e-7
    np.testing.assert_allclose(linear(files["base_color"]), maps.base_colour, atol=2.3 * one)
    np.testing.assert_allclose(2.0 * files["normal"] - 1.0, maps.normal, atol=2.0 * one)
    for name, values in (("roughness", maps.roughness), ("metallic", maps.metallic), ("ao", maps.occlusion)):
        np.testing.assert_allclose(files[name][..., 0], values, atol=one)
    np.testing.assert_allclose(0.08 * files["specular"][..., 0], maps.f0, atol=0.08 * one)
    low, high = made.record["height_range_texels"]
    np.testing.assert_allclose(low + (high - low) * files["height"][..., 0], maps.height, atol=(high - low) * one)


def test_values_come_back_from_openexr() -> None:
    subject = measure_subject()
    made = contents(subject, Settings("blender", "exr"))
    with OpenEXR.File(io.BytesIO(made.files["A_cloth_woven_base_color.exr"])) as file:
        pixels = file.channels()["RGB"].pixels
    np.testing.assert_array_equal(pixels, subject.maps.base_colour.astype(np.float16))
    with OpenEXR.File(io.BytesIO(made.files["A_cloth_woven_height.exr"])) as file:
        np.testing.assert_array_equal(file.channels()["Y"].pixels, np.asarray(subject.maps.height, np.float16))


@pytest.mark.parametrize("coding", CODINGS)
def test_the_error_is_that_of_the_rounded_maps(coding: Coding) -> None:
    maps = measure_maps()
    back = round_values(maps, coding)
    assert np.abs(back.roughness - maps.roughness).max() <= (0.5001 / 255 if coding == "png8" else 3e-4)
    assert not np.array_equal(back.base_colour, maps.base_colour)
    np.testing.assert_allclose(np.linalg.norm(back.normal, axis=2), 1.0, atol=1e-6)


def test_normals_of_directx_point_down() -> None:
    subject = measure_subject()
    up = decode((contents(subject, Settings("gltf"))).files["A_cloth_woven_normal.png"])
    down = decode((contents(subject, Settings("gltf", normal="directx"))).files["A_cloth_woven_normal.png"])
    np.testing.assert_allclose(up[..., 1] + down[..., 1], 1.0, atol=1.01 / 255)
    np.testing.assert_array_equal(up[..., [0, 2]], down[..., [0, 2]])
    assert (contents(subject, Settings("unreal"))).record["normal"] == "directx"


def test_packed_channels_are_where_programs_read_them() -> None:
    subject = measure_subject()
    maps = subject.maps
    assert maps.occlusion is not None
    for preset, name in (("unreal", "T_A_cloth_woven_ORM"), ("godot", "A_cloth_woven_orm")):
        orm = decode((contents(subject, Settings(preset))).files[f"{name}.png"])
        for channel, values in enumerate((maps.occlusion, maps.roughness, maps.metallic)):
            np.testing.assert_allclose(orm[..., channel], values, atol=0.51 / 255)
    mask = decode((contents(subject, Settings("unity"))).files["A_cloth_woven_MaskMap.png"])
    for channel, values in enumerate((maps.metallic, maps.occlusion, np.ones_like(maps.f0), 1.0 - maps.roughness)):
        np.testing.assert_allclose(mask[..., channel], values, atol=0.51 / 255)


#: Words in names by which Blender's Node Wrangler (Principled Texture Setup) knows sockets, from its preferences.
NODE_WRANGLER = {
    "base_color": "diffuse diff albedo base col color basecolor",
    "normal": "normal nor nrm nrml norm",
    "roughness": "roughness rough rgh",
    "metallic": "metallic metalness metal mtl",
    "specular": "specularity specular spec spc",
    "height": "displacement displace disp dsp height heightmap",
    "ao": "ao ambient occlusion",
}


def test_node_wrangler_sorts_the_files_of_blender() -> None:
    for name in (contents(measure_subject(), Settings("blender"))).files:
        words = re.split(r"[_.\s]", name.lower().removeprefix("a_cloth_woven_").removesuffix(".png"))
        matching = {socket for socket, tags in NODE_WRANGLER.items() if set(words) & set(tags.split())}
        assert matching == ({"_".join(words)} if words != ["cavity"] else set()), name


def test_what_is_not_known_is_left_out_and_said() -> None:
    made = contents(woven_subject(), Settings("substance"))
    assert [name.rpartition("_")[2] for name in made.files] == [
        *("BaseColor.png", "Normal.png", "Roughness.png", "Metallic.png", "Cavity.png")
    ]
    assert "normals are flat: lamps on one arc do not show the side that a slope faces" in made.warnings
    assert any(warning.startswith("no height") for warning in made.warnings)
    orm = decode((contents(woven_subject(), Settings("gltf"))).files["A_cloth_woven_occlusionRoughnessMetallic.png"])
    assert (orm[..., 0] == 1.0).all()


@pytest.mark.parametrize(
    ("preset", "left_out"),
    [("blender", ""), ("unity", "cavity"), ("godot", "cavity"), ("gltf", "height, cavity")],
)
def test_maps_without_a_place_in_a_preset_are_said_to_be_left_out(preset: str, left_out: str) -> None:
    said = [words for words in contents(measure_subject(), Settings(preset)).warnings if "not written" in words]
    assert said == ([f"not written: {left_out}"] if left_out else [])


@pytest.mark.parametrize("target", [gltf, usd, materialx, blender])
def test_targets_of_one_surface_say_what_they_leave_out(target: Any) -> None:
    warnings = drain(target.contents(measure_subject(), Settings(), "")).warnings
    assert f"not written: height, {'ambient occlusion, ' if target is blender else ''}cavity" in warnings
    assert any("OpenPBR surface has no ambient occlusion" in words for words in warnings) == (target is materialx)


@pytest.mark.parametrize("target", [usd, materialx, blender])
def test_one_f0_in_place_of_many_is_said(target: Any) -> None:
    f0 = np.linspace(0.02, 0.08, 120, dtype=np.float32).reshape(12, 10)
    subject = dataclasses.replace(measure_subject(), maps=dataclasses.replace(measure_maps(), f0=f0))
    assert any(words.startswith("f0 varies") for words in drain(target.contents(subject, Settings(), "")).warnings)


def test_an_f0_beyond_the_specular_level_is_said_and_counted() -> None:
    """A gem reflects 0.17; a specular level of 1 is 0.08, and that is what is shown."""
    material = woven_subject().material
    gem, glass = (
        Subject(material, dataclasses.replace(measure_maps(), f0=np.full((12, 10), f0, np.float32)))
        for f0 in (0.17, 0.08)
    )
    assert any("f0 is up to 0.170" in words for words in contents(gem, Settings("blender")).warnings)
    assert not any("f0 is up to" in words for words in contents(glass, Settings("blender")).warnings)
    view, lights = sphere(12, 10, 24), environment_lights("studio")
    shown = textures.show(gem, Settings("blender"))(view, lights)
    np.testing.assert_allclose(shown, glass.decode_as("png8")(view, lights), rtol=1e-5)
    assert not np.allclose(shown, gem.decode_as("png8")(view, lights), rtol=1e-2)


def test_a_dome_without_its_photographs_is_not_called_an_arc() -> None:
    """Planes of many lamps show slopes, but they are measured on photographs."""
    maps = dataclasses.replace(measure_maps(), height=None, occlusion=None, observed=ObservedSlopes("none"))
    warnings = contents(Subject(dome_material(12, 10), maps), Settings()).warnings
    assert sum("measured on photographs of these texels, and none were given" in words for words in warnings) == 3
    assert not any("arc" in words or "not observed" in words for words in warnings)


def test_maps_of_others_are_said_to_lack_what_they_came_without() -> None:
    maps = dataclasses.replace(measure_maps(), height=None, occlusion=None)
    made = contents(Subject(Material(None, None, name="rock", pbr=maps), maps), Settings("substance"))
    said = [warning for warning in made.warnings if warning.startswith(("no height", "no ambient"))]
    assert said == ["no height: the material came without one", "no ambient occlusion: the material came without it"]


def test_presets_are_known() -> None:
    assert set(PRESETS) == {"blender", "unreal", "unity", "godot", "substance", "gltf"}
    with pytest.raises(UsageError, match="unreal"):
        (contents(woven_subject(), Settings("cinema")))

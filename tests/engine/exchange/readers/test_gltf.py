"""glTF materials: our own come back, factors and extensions by hand, and what is hostile is refused."""

from __future__ import annotations

import base64
import dataclasses
import json
import struct
import zlib
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from engine.core.errors import InputError
from engine.core.steps import drain
from engine.exchange.gltf import contents
from engine.exchange.readers.gltf import gltf_of
from engine.exchange.readers.read import open_material
from engine.exchange.readers.textures import Described
from engine.exchange.subject import Settings, Subject
from engine.images.encode import encode_png
from engine.scene.material import material_of_maps
from engine.surface.pbr_maps import PbrMaps

from .images import find_known, grey, png


def test_our_own_file_comes_back_within_its_rounding(tmp_path: Path) -> None:
    maps = find_known()
    f0 = np.linspace(0.02, 0.06, maps.f0.size, dtype=np.float32).reshape(maps.size)
    maps = type(maps)(maps.base_colour, maps.normal, maps.roughness, maps.metallic, f0)
    subject = Subject(material_of_maps(maps, "Grüner Fels"), maps, 1.0 / np.pi)
    (content,) = drain(contents(subject, Settings(), "")).files.values()
    path = tmp_path / "rock.glb"
    path.write_bytes(content)
    material = open_material(path)
    found = material.pbr
    assert material.name == "Grüner Fels"
    assert found is not None
    step = 0.5 / 255 * 1.01
    assert np.abs(found.roughness - maps.roughness).max() <= step
    assert np.abs(found.metallic - maps.metallic).max() <= step
    assert np.abs(found.base_colour - maps.base_colour).max() <= step * 2.4 / 1.055 + 1e-6
    assert np.abs(found.normal - maps.normal).max() <= 4.0 * step
    assert np.abs(found.f0 - f0).max() <= 0.06 * step * 2.4 / 1.055 + 1e-5


def gltf(folder: Path, material: dict[str, Any], images: list[dict[str, Any]]) -> Path:
    tree = {
        "asset": {"version": "2.0"},
        "materials": [material],
        "textures": [{"source": index} for index in range(len(images))],
        "images": images,
    }
    path = folder / "m.gltf"
    path.write_text(json.dumps(tree))
    return path


def within(value: int) -> dict[str, Any]:
    return {"uri": "data:image/png;base64," + base64.b64encode(encode_png(grey(value))).decode()}


def test_factors_and_extensions_by_hand(tmp_path: Path) -> None:
    material = {
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.5, 0.25, 1.0, 1.0],
            "baseColorTexture": {"index": 0},
            "metallicRoughnessTexture": {"index": 1},
            "roughnessFactor": 0.5,
            "metallicFactor": 0.0,
        },
        "extensions": {"KHR_materials_ior": {"ior": 2.0}, "KHR_materials_specular": {"specularFactor": 0.5}},
        "emissiveFactor": [1.0, 0.0, 0.0],
    }
    opened = open_material(gltf(tmp_path, material, [within(255), within(102)]))
    maps = opened.pbr
    assert maps is not None
    np.testing.assert_allclose(maps.base_colour[0, 0], (0.5, 0.25, 1.0), atol=1e-6)
    assert maps.roughness[0, 0] == pytest.approx(0.2, abs=1e-6)
    assert maps.metallic[0, 0] == 0.0
    assert maps.f0[0, 0] == pytest.approx(1.0 / 9.0 / 2.0, abs=1e-6)
    assert "emission is not drawn" in opened.health.warnings


def test_images_beside_the_file_and_none_outside(tmp_path: Path) -> None:
    png(tmp_path / "a" / "pictures" / "base.png", grey(255))
    png(tmp_path / "outside.png", grey(255))
    material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
    path = gltf(tmp_path / "a", material, [{"uri": "pictures/base.png"}])
    assert open_material(path).pbr is not None
    for uri in ("../outside.png", "/etc/passwd", "http://example.com/a.png", "..%2foutside.png"):
        with pytest.raises(InputError, match="outside its folder"):
            open_material(gltf(tmp_path / "a", material, [{"uri": uri}]))


@pytest.mark.parametrize(
    "material",
    [
        {"pbrMetallicRoughness": {"baseColorTexture": {"index": 7}}},
        {"pbrMetallicRoughness": {"baseColorTexture": {"index": True}}},
        {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "roughnessFactor": "rough"}},
        {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "baseColorFactor": [1.0]}},
    ],
)
def test_materials_that_cannot_be_are_refused(tmp_path: Path, material: dict[str, Any]) -> None:
    with pytest.raises(InputError):
        open_material(gltf(tmp_path, material, [within(1)]))


def test_cut_files_are_refused(tmp_path: Path) -> None:
    maps = find_known()
    subject = Subject(material_of_maps(maps, "rock"), maps, 1.0)
    (content,) = drain(contents(subject, Settings(), "")).files.values()
    path = tmp_path / "rock.glb"
    for length in (12, 19, 21, 200, len(content) // 2, len(content) - 1):
        path.write_bytes(content[:length])
        with pytest.raises(InputError):
            open_material(path)


#: Properties of materials in glTF 2.0 and its ratified extensions, each with a value that is seen.
PROPERTIES: dict[str, dict[str, Any]] = {
    "": {
        "emissiveFactor": [1, 1, 1],
        "alphaMode": "MASK",
        "normalTexture": {"index": 0},
        "occlusionTexture": {"index": 0},
    },
    "pbrMetallicRoughness": {
        "baseColorFactor": [0.2, 0.3, 0.4, 1.0],
        "baseColorTexture": {"index": 0},
        "metallicFactor": 0.3,
        "roughnessFactor": 0.3,
        "metallicRoughnessTexture": {"index": 0},
    },
    "normalTexture": {"scale": 0.5, "texCoord": 1},
    "occlusionTexture": {"strength": 0.5, "texCoord": 1},
    "KHR_materials_ior": {"ior": 1.8},
    "KHR_materials_specular": {
        "specularFactor": 0.5,
        "specularTexture": {"index": 0},
        "specularColorFactor": [0.5, 0.2, 0.2],
        "specularColorTexture": {"index": 0},
    },
    "KHR_materials_transmission": {"transmissionFactor": 0.5, "transmissionTexture": {"index": 0}},
    "KHR_materials_volume": {
        "thicknessFactor": 0.5,
        "thicknessTexture": {"index": 0},
        "attenuationDistance": 0.5,
        "attenuationColor": [0.5, 0.2, 0.2],
    },
    "KHR_materials_dispersion": {"dispersion": 0.5},
    "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.5},
    "KHR_materials_clearcoat": {
        "clearcoatFactor": 0.5,
        "clearcoatTexture": {"index": 0},
        "clearcoatRoughnessFactor": 0.5,
        "clearcoatRoughnessTexture": {"index": 0},
        "clearcoatNormalTexture": {"index": 0},
    },
    "KHR_materials_sheen": {
        "sheenColorFactor": [0.5, 0.2, 0.2],
        "sheenColorTexture": {"index": 0},
        "sheenRoughnessFactor": 0.5,
        "sheenRoughnessTexture": {"index": 0},
    },
    "KHR_materials_iridescence": {
        "iridescenceFactor": 0.5,
        "iridescenceTexture": {"index": 0},
        "iridescenceIor": 1.8,
        "iridescenceThicknessMinimum": 50.0,
        "iridescenceThicknessMaximum": 200.0,
        "iridescenceThicknessTexture": {"index": 0},
    },
    "KHR_materials_anisotropy": {
        "anisotropyStrength": 0.5,
        "anisotropyRotation": 0.5,
        "anisotropyTexture": {"index": 0},
    },
    "KHR_materials_emissive_strength": {"emissiveStrength": 3.0},
    "KHR_materials_unlit": {},
    "KHR_materials_pbrSpecularGlossiness": {
        "diffuseFactor": [0.2, 0.3, 0.4, 1.0],
        "diffuseTexture": {"index": 0},
        "specularFactor": [0.2, 0.3, 0.4],
        "glossinessFactor": 0.5,
        "specularGlossinessTexture": {"index": 0},
    },
    "VENDOR_of_somebody": {"anything": 1},
}

#: What must be there for a property to be seen.
PRESENT: dict[str, dict[str, Any]] = {
    "KHR_materials_clearcoat": {"clearcoatFactor": 0.7},
    "KHR_materials_sheen": {"sheenColorFactor": [0.3, 0.3, 0.3]},
    "KHR_materials_iridescence": {"iridescenceFactor": 0.7},
    "KHR_materials_anisotropy": {"anisotropyStrength": 0.7},
    "KHR_materials_volume": {"thicknessFactor": 0.2},
    "KHR_materials_transmission": {"transmissionFactor": 0.2},
    "normalTexture": {"index": 0},
    "occlusionTexture": {"index": 0},
}

CASES = [(owner, key) for owner, entries in PROPERTIES.items() for key in entries] + [("KHR_materials_unlit", "")]


@pytest.mark.parametrize(("owner", "key"), CASES)
def test_every_property_of_a_material_is_read_or_named(owner: str, key: str, tmp_path: Path) -> None:
    """The walk over the schema: each property alone changes the material, or a warning names it or its part."""

    def describe(entries: dict[str, Any] | None) -> Described:
        material: dict[str, Any] = {"pbrMetallicRoughness": {"roughnessFactor": 0.4}}
        light = {"emissiveFactor": [1, 1, 1]} if owner == "KHR_materials_emissive_strength" else {}
        through = {"KHR_materials_transmission": {"transmissionFactor": 0.2}}
        needs_light = owner in ("KHR_materials_volume", "KHR_materials_dispersion")
        if needs_light or owner in through:
            material["pbrMetallicRoughness"]["metallicFactor"] = 0.5  # metals let nothing through
        material |= light | ({"extensions": through} if needs_light else {})
        if entries is not None:
            if not owner:
                material |= entries
            elif owner.startswith(("KHR", "VENDOR")):
                material["extensions"] = {**material.get("extensions", {}), owner: entries}
            elif owner == "pbrMetallicRoughness":
                material[owner] |= entries
            else:
                material[owner] = entries
        path = gltf(tmp_path, material, [within(100)])
        return gltf_of(path.read_bytes(), path)

    present = PRESENT.get(owner, {})
    base = describe(present or None)
    found = describe({**present, **({key: PROPERTIES[owner][key]} if key else {})})
    said = " ".join(found.notes)
    parts = {
        "KHR_materials_volume": "goes through",
        "KHR_materials_dispersion": "goes through",
        "KHR_materials_emissive_strength": "emission",
        "VENDOR_of_somebody": "VENDOR_of_somebody",
        "KHR_materials_diffuse_transmission": "KHR_materials_diffuse_transmission",
    }
    is_read = dataclasses.replace(found, notes=()) != dataclasses.replace(base, notes=())
    words = {"emissiveFactor": "emission", "alphaMode": "opacity"}
    is_named = (key and key in said) or parts.get(owner, "\0") in said or words.get(key, "\0") in said
    assert is_read or is_named or set(found.notes) - set(base.notes), (owner, key, found.notes)


def test_textures_of_a_clear_coat_count_with_their_mean(tmp_path: Path) -> None:
    """Red of one times the weight, green of the other times the roughness; one that varies is named."""
    flat, varied = np.zeros((2, 2, 3), np.uint8), np.zeros((4, 4, 3), np.uint8)
    flat[..., 0], varied[:2, :, 1] = 51, 255
    images = [
        {"uri": "data:image/png;base64," + base64.b64encode(encode_png(each)).decode()} for each in (flat, varied)
    ]
    coat = {
        "clearcoatFactor": 0.5,
        "clearcoatTexture": {"index": 0},
        "clearcoatRoughnessFactor": 0.8,
        "clearcoatRoughnessTexture": {"index": 1},
    }
    found = open_material(gltf(tmp_path, {"extensions": {"KHR_materials_clearcoat": coat}}, images))
    assert found.pbr is not None
    assert found.pbr.of_gltf is not None
    assert (found.pbr.of_gltf.coat_weight, found.pbr.of_gltf.coat_roughness) == pytest.approx((0.1, 0.4))
    assert found.pbr.size == (1, 1)
    (said,) = found.health.warnings
    assert said == "the roughness of the clear coat varies over its texture, 0 to 1; its mean 0.5 is drawn"


def test_textures_of_sheen_count_with_their_mean(tmp_path: Path) -> None:
    """The colour decoded from sRGB, the roughness in alpha; beside iridescence both are of the fuzz in its place.

    Relief below a pixel is not in the sheen, which is said.
    """
    codes = np.zeros((2, 2, 4), np.uint8)
    codes[0], codes[1, :, 3] = (188, 255, 0, 255), 51
    ok, encoded = cv2.imencode(".png", codes[..., [2, 1, 0, 3]])
    assert ok
    images = [{"uri": "data:image/png;base64," + base64.b64encode(encoded.tobytes()).decode()}]
    relief = np.full((2, 2, 3), 128, np.uint8)
    relief[:, 0] = (200, 128, 220)
    images.append({"uri": "data:image/png;base64," + base64.b64encode(encode_png(relief)).decode()})
    sheen = {
        "sheenColorFactor": [1.0, 0.5, 0.5],
        "sheenColorTexture": {"index": 0},
        "sheenRoughnessFactor": 0.5,
        "sheenRoughnessTexture": {"index": 0},
    }
    extensions = {"KHR_materials_sheen": sheen}
    alone = open_material(gltf(tmp_path, {"extensions": extensions, "normalTexture": {"index": 1}}, images))
    assert alone.pbr is not None
    assert alone.pbr.of_gltf is not None
    red = 0.5 * (((188.0 / 255.0) + 0.055) / 1.055) ** 2.4
    assert alone.pbr.of_gltf.sheen_color == pytest.approx((red, 0.25, 0.0))
    assert alone.pbr.of_gltf.sheen_roughness == pytest.approx(0.3)
    assert [words.partition(" varies")[0] for words in alone.health.warnings] == [
        "the colour of the sheen",
        "the roughness of the sheen",
        "where a pixel covers normals that differ, the sheen is that of their mean",
    ]
    extensions["KHR_materials_iridescence"] = {"iridescenceFactor": 1.0}
    beside = open_material(gltf(tmp_path, {"extensions": extensions}, images))
    assert beside.pbr is not None
    assert beside.pbr.openpbr is not None
    assert beside.pbr.openpbr.fuzz_weight == pytest.approx(red)
    assert beside.pbr.openpbr.fuzz_color == pytest.approx((1.0, 0.25 / red, 0.0))
    assert beside.pbr.openpbr.fuzz_roughness == pytest.approx(0.3)
    assert "sheen is drawn as OpenPBR's fuzz" in beside.health.warnings


def test_specular_and_glossiness_become_metal_and_roughness(tmp_path: Path) -> None:
    """A metal has no diffuse part and the colour of its highlight; a plastic the diffuse one under 4 %."""

    def read(diffuse: list[float], specular: list[float], gloss: float) -> PbrMaps:
        entries = {"diffuseFactor": [*diffuse, 1.0], "specularFactor": specular, "glossinessFactor": gloss}
        material = {"extensions": {"KHR_materials_pbrSpecularGlossiness": entries}}
        found = open_material(gltf(tmp_path, material, [])).pbr
        assert found is not None
        return found

    metal = read([0.0, 0.0, 0.0], [0.9, 0.6, 0.3], 0.8)
    np.testing.assert_allclose(metal.base_colour[0, 0], (0.9, 0.6, 0.3), atol=1e-5)
    assert (metal.metallic[0, 0], metal.roughness[0, 0]) == (pytest.approx(1.0), pytest.approx(0.2))
    plastic = read([0.5, 0.2, 0.1], [0.04, 0.04, 0.04], 0.3)
    np.testing.assert_allclose(plastic.base_colour[0, 0], np.array((0.5, 0.2, 0.1)) * 0.96, atol=1e-5)
    assert (plastic.metallic[0, 0], plastic.f0[0, 0]) == (pytest.approx(0.0, abs=1e-6), pytest.approx(0.04))
    water = read([0.5, 0.2, 0.1], [0.02, 0.02, 0.02], 0.3)
    assert (water.metallic[0, 0], water.f0[0, 0]) == (0.0, pytest.approx(0.02, abs=1e-6))
    for d, s in ((0.3, 0.2), (0.1, 0.5), (0.6, 0.06)):
        mixed = read([d] * 3, [s] * 3, 0.5)
        m, b = float(mixed.metallic[0, 0]), float(mixed.base_colour[0, 0, 0])
        assert 0.04 * (1.0 - m) + b * m == pytest.approx(s, abs=1e-4)
        assert b * (1.0 - m) == pytest.approx(d * (1.0 - s), abs=1e-4)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"extensionsRequired": ["VENDOR_unknown_thing"]}, "VENDOR_unknown_thing"),
        ({"textures": [{"extensions": {"KHR_texture_basisu": {"source": 0}}}]}, "KTX2"),
    ],
)
def test_what_cannot_be_read_is_refused_by_name(changes: dict[str, Any], words: str, tmp_path: Path) -> None:
    path = gltf(tmp_path, {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}, [within(9)])
    path.write_text(json.dumps({**json.loads(path.read_text()), **changes}))
    with pytest.raises(InputError, match=words):
        open_material(path)


def test_colours_of_vertices_are_named(tmp_path: Path) -> None:
    path = gltf(tmp_path, {}, [])
    mesh = {"primitives": [{"material": 0, "attributes": {"POSITION": 0, "COLOR_0": 1}}]}
    path.write_text(json.dumps({**json.loads(path.read_text()), "meshes": [mesh]}))
    assert any("colours of vertices" in note for note in open_material(path).health.warnings)


@pytest.mark.parametrize(
    ("kind", "body"),
    [
        (b"gAMA", struct.pack(">I", 100_000)),
        (b"cHRM", struct.pack(">8I", 31270, 32900, 68000, 32000, 26500, 69000, 15000, 6000)),
    ],
)
def test_what_an_image_says_of_its_colours_is_ignored(kind: bytes, body: bytes, tmp_path: Path) -> None:
    plain = encode_png(np.random.default_rng(5).integers(0, 256, (4, 6, 3)).astype(np.uint8))
    chunk = struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
    found = []
    for name, content in (("plain", plain), ("told", plain[:33] + chunk + plain[33:])):
        (tmp_path / f"{name}.png").write_bytes(content)
        found.append(open_material(gltf(tmp_path, material, [{"uri": f"{name}.png"}])).pbr)
    assert found[0] is not None
    assert found[1] is not None
    np.testing.assert_array_equal(found[1].base_colour, found[0].base_colour)

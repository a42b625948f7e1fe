"""glTF materials: our own come back, factors and extensions by hand, and what is hostile is refused."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.core.errors import InputError
from engine.core.steps import drain
from engine.exchange.gltf import contents
from engine.exchange.readers.documents_child import has_textured_material
from engine.exchange.readers.read import open_material
from engine.exchange.subject import Settings, Subject
from engine.images.encode import encode_png
from engine.scene.material import material_of_maps

from .images import find_known, grey, png


def test_our_own_file_comes_back_within_its_rounding(tmp_path: Path) -> None:
    maps = find_known()
    f0 = np.linspace(0.02, 0.06, maps.f0.size, dtype=np.float32).reshape(maps.size)
    maps = type(maps)(maps.base_colour, maps.normal, maps.roughness, maps.metallic, f0)
    subject = Subject(material_of_maps(maps, "rock"), maps, 1.0 / np.pi)
    (content,) = drain(contents(subject, Settings(), "")).files.values()
    path = tmp_path / "rock.glb"
    path.write_bytes(content)
    found = open_material(path).pbr
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
    assert has_textured_material(path)
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

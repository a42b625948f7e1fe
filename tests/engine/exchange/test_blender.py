"""The target of Blender: a script that is Python, its textures, and under --long what Blender makes and draws of it.

Blender's module is found beside this program, or by the interpreter that LIGHTARC_BLENDER_PYTHON names.
"""

from __future__ import annotations

import ast
import dataclasses
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from engine.brdf.models.diffuse import Lambert
from engine.core.directions import normalize
from engine.core.steps import drain
from engine.exchange import blender
from engine.exchange.coding import round_values
from engine.exchange.subject import Settings, Subject
from engine.geometry.camera import Camera
from engine.geometry.mesh import Mesh
from engine.images.decode import read_image
from engine.render.direct import radiance
from engine.scene.material import Material, material_of_maps
from engine.scene.scene import Scene
from engine.shading.power_law import PowerLawMap
from engine.surface.pbr_maps import PbrMaps

from .materials import woven_law

SIDE = 64

#: The sun and the camera of the script that draws.
LIGHT = (float(np.sin(np.radians(40.0))), 0.0, float(np.cos(np.radians(40.0))))
CAMERA = Camera((0.0, 0.0, 4.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 24.0)


def smooth_maps(size: int = 24) -> PbrMaps:
    """Dielectrics of medium gloss and gentle relief, which change slowly."""
    row, column = np.mgrid[0:size, 0:size] * (2.0 * np.pi / size)
    slope = 0.2 * np.sin(column + row)
    return PbrMaps(
        base_colour=np.dstack([0.4 + 0.2 * np.sin(row), 0.4 + 0.2 * np.cos(column), 0.5 + 0.0 * row]).astype(
            np.float32
        ),
        normal=normalize(np.dstack([-slope, -slope, np.ones_like(slope)])).astype(np.float32),
        roughness=(0.6 + 0.2 * np.sin(column)).astype(np.float32),
        metallic=np.zeros((size, size), np.float32),
        f0=np.full((size, size), 0.04, np.float32),
    )


def smooth_law(size: int = 24) -> PowerLawMap:
    """Colours and exponents that change slowly, so that the filters of two programs do not count."""
    row, column = np.mgrid[0:size, 0:size] * (2.0 * np.pi / size)
    return dataclasses.replace(
        woven_law(size, size),
        scale=np.dstack([0.3 + 0.2 * np.sin(row), 0.3 + 0.2 * np.cos(column), 0.25 + 0.0 * row]).astype(np.float32),
        exponent=np.dstack([1.0 + 0.5 * np.sin(column), 1.2 + 0.0 * row, 1.5 + 0.5 * np.cos(row)]).astype(np.float32),
    )


def subject() -> Subject:
    material = Material(None, smooth_law(), name="woven", elevation_deg=(20.0, 50.0, 90.0))
    return Subject(material, smooth_maps(), 1.0)


def test_script_is_python_and_says_what_it_holds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(blender, "has_blender", lambda: False)
    made = drain(blender.contents(subject(), Settings(), 'An error of 12 %, in """quotes""".'))
    assert set(made.files) == {
        *(f"textures/{name}.png" for name in ("base_color", "normal", "roughness", "metallic")),
        *("textures/scale.exr", "textures/exponent.exr", "woven.py", "woven.glb"),
    }
    text = made.files["woven.py"].decode()
    ast.parse(text)
    assert "An error of 12 %" in text
    assert "{{" not in text
    assert any("Blender imports woven.glb" in words for words in made.warnings)
    assert made.files["woven.glb"][:4] == b"glTF"


def test_with_the_module_of_blender_the_blend_takes_the_place_of_the_glb(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(blender, "has_blender", lambda: True)
    monkeypatch.setattr(blender, "make_with_blender", lambda name, files: f"{name} of {len(files)} files".encode())
    made = drain(blender.contents(subject(), Settings(), ""))
    assert made.files["woven.blend"] == b"woven of 7 files"
    assert "woven.glb" not in made.files
    assert not any("Blender imports" in words for words in made.warnings)


def test_sigma_shows_the_brightest_photograph_where_a_white_surface_is_brightest() -> None:
    """By hand: the lamp overhead makes a white diffuse surface 1 / π, which is to be r_max = 0.3."""
    assert blender.lambertian_sigma(subject().material) == pytest.approx(0.3 * np.pi)


def test_maps_without_a_power_law_have_one_material(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(blender, "has_blender", lambda: False)
    maps = smooth_maps()
    made = drain(blender.contents(Subject(material_of_maps(maps, "rock"), maps, 1.0 / np.pi), Settings(), ""))
    assert "textures/scale.exr" not in made.files
    assert '"r_max": null' in made.files["rock.py"].decode()


@pytest.fixture(scope="module")
def python() -> str:
    """An interpreter that has Blender's module."""
    chosen = os.environ.get("LIGHTARC_BLENDER_PYTHON", sys.executable)
    if subprocess.run([chosen, "-c", "import bpy"], capture_output=True, check=False).returncode:
        pytest.skip("Blender's module (bpy) is not installed, and LIGHTARC_BLENDER_PYTHON names no Python that has it")
    return chosen


def draw(python: str, folder: Path, material: str, engine: str) -> np.ndarray:
    made = drain(blender.contents(subject(), Settings(), ""))
    content = blender.make_with_blender("woven", dict(made.files), python)
    assert content is not None
    (folder / "woven.blend").write_bytes(content)
    script, image = Path(__file__).with_name("draw_in_blender.py"), folder / "picture.exr"
    words = [python, script, folder / "woven.blend", material, engine, image, str(SIDE), "16"]
    subprocess.run([str(word) for word in words], check=True, capture_output=True, timeout=280)
    return read_image(image).pixels.astype(np.float64)


def ours(material: Material, **options: object) -> np.ndarray:
    corners = np.array([(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)])
    uv = (0.5 + 0.5 * corners[:, :2]).astype(np.float32)
    faces = np.array([(0, 1, 2), (0, 2, 3)], np.int32)
    mesh = Mesh(corners, np.tile(np.array([0, 0, 1], np.float32), (4, 1)), uv, faces, "square")
    brdf = options.pop("brdf", material.reflectance)
    scene = Scene(mesh, CAMERA, brdf, material, light=LIGHT, repeats=blender.REPEATS, **options)  # type: ignore[arg-type]
    return drain(radiance(scene, (SIDE, SIDE), samples=4))[..., :3].astype(np.float64)


def relative(found: np.ndarray, wanted: np.ndarray) -> float:
    inside = wanted.sum(axis=2) > 0.0
    return float(np.sqrt(np.sum((found - wanted)[inside] ** 2) / np.sum(wanted[inside] ** 2)))


@pytest.mark.long
def test_cycles_draws_the_maps(python: str, tmp_path: Path) -> None:
    wanted = ours(material_of_maps(round_values(smooth_maps(), "png8"), "maps"))
    assert relative(draw(python, tmp_path, "woven", "CYCLES"), wanted) < 0.01


@pytest.mark.long
def test_eevee_looks_the_power_law_up(python: str, tmp_path: Path) -> None:
    wanted = ours(subject().material, brdf=Lambert((1.0, 1.0, 1.0)), source="power-law", lookup="outgoing")
    assert relative(draw(python, tmp_path, "woven (power law)", "BLENDER_EEVEE"), wanted) < 0.03

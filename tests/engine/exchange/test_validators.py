"""Everything that is written, for the validators of others: no error and no warning, for all presets and formats.

glTF for Khronos' validator, MaterialX for its library, USD for the validators of its library, which `usdchecker` runs,
and textures of each preset for another decoder, from which they come back as they were.
"""

from __future__ import annotations

import itertools
import json
import shutil
import subprocess
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.brdf.models.openpbr import OpenPbr
from engine.core.steps import drain
from engine.exchange import gltf, materialx, textures, usd
from engine.exchange.readers.read import open_material
from engine.exchange.subject import Settings, Subject
from engine.exchange.textures import PRESETS
from engine.scene.credits import Credits
from engine.scene.material import material_of_maps

from .materials import measure_subject, woven_subject
from .test_gltf import NODE, VALIDATE, make_varied_subject

pytestmark = pytest.mark.long

LAYERS = (
    "openpbr:coat_weight=0.8,coat_roughness=0.2",
    "openpbr:fuzz_weight=0.5,fuzz_color=1/0.5/0.25",
    "openpbr:thin_film_weight=1,thin_film_thickness=0.4",
    "openpbr-anisotropic:specular_roughness_anisotropy=0.6,rotation_deg=30",
)


def make_subjects() -> Iterator[tuple[str, Subject]]:
    yield "shading map", woven_subject()
    yield "measured", measure_subject()
    yield "f0 varies", make_varied_subject()
    found = measure_subject()
    flat = np.zeros_like(found.maps.normal)
    flat[..., 2] = 1.0
    smooth = replace(found.maps, normal=flat, occlusion=None, height=None)
    yield "smooth", Subject(material_of_maps(smooth, "smooth metal"), smooth, 1.0)
    for text in LAYERS:
        layers = brdf_from_text(text)
        assert isinstance(layers, OpenPbr)
        maps = replace(found.maps, layers=layers)
        yield text, Subject(material_of_maps(maps, "3 – ünusual & <named>"), maps, 1.0)


SUBJECTS = dict(make_subjects())

SETTINGS = [
    Settings(),
    Settings(width_mm=40.0, credits=Credits("Oak & <ash>", 'A "Somebody"', "CC-BY-4.0", source="https://example.org")),
    Settings(tiling_mode="hex"),
]


def write(folder: Path, module: Any, subject: Subject, settings: Settings) -> list[Path]:
    made = drain(module.contents(subject, settings, f"3 % & <more>. {settings.credits.ascii_line}"))
    for name, content in made.files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    return [folder / name for name in made.files]


CASES = list(itertools.product(SUBJECTS, range(len(SETTINGS))))


@pytest.mark.parametrize(("name", "at"), CASES)
def test_usd_is_sound(name: str, at: int, tmp_path: Path) -> None:
    usd_stage = pytest.importorskip("pxr.Usd", reason="usd-core is not installed")
    validation = pytest.importorskip("pxr.UsdValidation")
    registry = validation.ValidationRegistry()
    context = validation.ValidationContext(registry.GetOrLoadAllValidators())
    for path in write(tmp_path, usd, SUBJECTS[name], SETTINGS[at]):
        if path.suffix == ".usdz":
            stage = usd_stage.Stage.Open(str(path))
            assert [error.GetMessage() for error in context.Validate(stage)] == []
        else:  # nodes of MaterialX are in no registry of a USD without it: the layer is read, with all that it names
            stage = usd_stage.Stage.Open(str(path))
            assert stage.GetCompositionErrors() == []


@pytest.mark.parametrize(("name", "at"), CASES)
def test_materialx_is_sound(name: str, at: int, tmp_path: Path) -> None:
    mx = pytest.importorskip("MaterialX", reason="MaterialX is not installed")
    library = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    (path,) = (each for each in write(tmp_path, materialx, SUBJECTS[name], SETTINGS[at]) if each.suffix == ".mtlx")
    found = mx.createDocument()
    mx.readFromXmlFile(found, str(path))
    found.setDataLibrary(library)
    assert found.validate() == (True, "")


@pytest.mark.parametrize(("name", "at"), CASES)
def test_gltf_is_sound(name: str, at: int, tmp_path: Path) -> None:
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed")
    (path,) = write(tmp_path, gltf, SUBJECTS[name], SETTINGS[at])
    done = subprocess.run([node, "-e", VALIDATE, path, NODE], capture_output=True, text=True, timeout=120)
    if "Cannot find module" in done.stderr:
        pytest.skip("gltf-validator is missing: npm install --prefix build/node gltf-validator")
    issues = json.loads(done.stdout)
    assert (issues["numErrors"], issues["numWarnings"]) == (0, 0), issues["messages"]


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("coding", ["png8", "png16", "exr"])
@pytest.mark.parametrize("normal", ["opengl", "directx"])
def test_textures_are_sound(preset: str, coding: Any, normal: Any, tmp_path: Path) -> None:
    """Another decoder reads each image, and the maps come back within half a code."""
    subject = measure_subject()
    for path in write(tmp_path, textures, subject, Settings(preset, coding, normal)):
        if path.suffix == ".png":
            assert cv2.imread(str(path), cv2.IMREAD_UNCHANGED) is not None, path
    record = {"targets": [{"files": [each.name for each in tmp_path.iterdir()], "normal": normal}]}
    (tmp_path / "export.json").write_text(json.dumps(record))
    found = open_material(tmp_path).pbr
    assert found is not None
    step = {"png8": 0.51 / 255, "png16": 0.51 / 65535, "exr": 1e-6}[coding] + 5e-4 * (coding == "exr")
    for key, gain in (("roughness", 1.0), ("metallic", 1.0), ("normal", 4.0), ("base_colour", 2.4)):
        difference = np.abs(getattr(found, key) - getattr(subject.maps, key)).max()
        assert difference <= gain * step, (key, difference, step)

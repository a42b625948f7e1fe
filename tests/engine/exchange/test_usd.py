"""USD packages: without complaint from the validators of USD, and read back by its library."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from engine.core.steps import drain
from engine.exchange.subject import Settings, Subject
from engine.exchange.usd import contents

from .materials import measure_subject, woven_subject

Usd = pytest.importorskip("pxr.Usd", reason="usd-core is not installed")

SUBJECTS = {"shading map": woven_subject, "measured": measure_subject}


@pytest.fixture(params=SUBJECTS)
def folder(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    make: Callable[[], Subject] = SUBJECTS[request.param]
    for name, content in drain(contents(make(), Settings(), "An error of 3 %.")).files.items():
        (tmp_path / name).write_bytes(content)
    return tmp_path


def test_all_validators_of_usd_are_content(folder: Path) -> None:
    validation = pytest.importorskip("pxr.UsdValidation")
    registry = validation.ValidationRegistry()
    context = validation.ValidationContext(registry.GetOrLoadAllValidators())
    stage = Usd.Stage.Open(str(folder / "A_cloth_woven.usdz"))
    names = {each.name for each in registry.GetAllValidatorMetadata()}
    assert {"usdUtilsValidators:UsdzPackageValidator", "usdShadeValidators:ShaderSdrCompliance"} <= names
    assert [error.GetMessage() for error in context.Validate(stage)] == []
    assert stage.GetRootLayer().documentation.endswith("An error of 3 %.")


def test_members_are_stored_at_multiples_of_64_bytes(folder: Path) -> None:
    path = folder / "A_cloth_woven.usdz"
    content = path.read_bytes()
    with zipfile.ZipFile(path) as package:
        assert package.testzip() is None
        entries = package.infolist()
    assert entries[0].filename == "A_cloth_woven.usda"
    for entry in entries:
        start = entry.header_offset
        name, extra = (int.from_bytes(content[start + at : start + at + 2], "little") for at in (26, 28))
        assert (start + 30 + name + extra) % 64 == 0
        assert entry.compress_type == zipfile.ZIP_STORED


def test_maps_are_bound_to_the_sphere(folder: Path) -> None:
    shade = pytest.importorskip("pxr.UsdShade")
    stage = Usd.Stage.Open(str(folder / "A_cloth_woven.usdz"))
    sphere = stage.GetPrimAtPath("/A_cloth_woven/ball")
    material, _ = shade.MaterialBindingAPI(sphere).ComputeBoundMaterial()
    surface, _, _ = material.ComputeSurfaceSource()
    assert surface.GetIdAttr().Get() == "UsdPreviewSurface"
    for name, output in (("diffuseColor", "rgb"), ("roughness", "r"), ("metallic", "r"), ("normal", "rgb")):
        source, found, _ = surface.GetInput(name).GetConnectedSource()
        assert found == output
        image = source.GetPrim().GetAttribute("inputs:file").Get().resolvedPath
        assert image.endswith(".png]")
    space = material.GetPrim().GetChild("baseColor").GetAttribute("inputs:sourceColorSpace").Get()
    assert space == "sRGB"


def test_normals_come_back_by_scale_and_bias() -> None:
    subject = measure_subject()
    package = drain(contents(subject, Settings(), "")).files["A_cloth_woven.usdz"]
    import io

    with zipfile.ZipFile(io.BytesIO(package)) as file:
        pixels = cv2.imdecode(np.frombuffer(file.read("textures/normal.png"), np.uint8), cv2.IMREAD_UNCHANGED)
        layer = file.read("A_cloth_woven.usda").decode()
    assert pixels is not None
    assert "inputs:scale = (2, 2, 2, 1)" in layer
    np.testing.assert_allclose(pixels[..., ::-1] / 255.0 * 2.0 - 1.0, subject.maps.normal, atol=1.01 / 255)


def test_the_layer_of_materialx_has_nodes_of_its_library(folder: Path) -> None:
    """Its nodes are in no registry of a USD without MaterialX; MaterialX itself defines them with these inputs."""
    mx = pytest.importorskip("MaterialX", reason="MaterialX is not installed")
    library = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    stage = Usd.Stage.Open(str(folder / "A_cloth_woven_materialx.usda"))
    geometry = pytest.importorskip("pxr.UsdGeom")
    assert (geometry.GetStageMetersPerUnit(stage), geometry.GetStageUpAxis(stage)) == (1.0, "Y")
    material = stage.GetPrimAtPath("/A_cloth_woven/material")
    nodes = {prim: prim.GetAttribute("info:id").Get() for prim in material.GetChildren()}
    nodes = {prim: name for prim, name in nodes.items() if name.startswith("ND_")}
    assert len(nodes) == 6
    for prim, name in nodes.items():
        definition: Any = library.getNodeDef(name)
        assert definition is not None, name
        for given in prim.GetAttributes():
            if given.GetName().startswith("inputs:"):
                assert definition.getActiveInput(given.GetBaseName()) is not None, (name, given.GetName())
    image = stage.GetPrimAtPath("/A_cloth_woven/material/mtlx_baseColor_image").GetAttribute("inputs:file").Get()
    assert image.path == "./A_cloth_woven.usdz[textures/baseColor.png]"

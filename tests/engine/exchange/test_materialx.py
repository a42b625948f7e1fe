"""MaterialX documents: valid for the library of MaterialX, whose generators make shaders of both surfaces."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.core.errors import UsageError
from engine.core.steps import drain
from engine.exchange.materialx import contents
from engine.exchange.readers.read import open_material
from engine.exchange.subject import Settings, Subject
from engine.exchange.textures import ior_of

from .materials import measure_subject, woven_subject

mx = pytest.importorskip("MaterialX", reason="MaterialX is not installed")

SUBJECTS = {"shading map": woven_subject, "measured": measure_subject}


@pytest.fixture(params=[*SUBJECTS, "measured in hexagonal cells"])
def document(request: pytest.FixtureRequest, tmp_path: Path) -> Any:
    """The document as the library reads it from the disk, with its own definitions."""
    make: Callable[[], Subject] = SUBJECTS[request.param.split(" in ")[0]]
    settings = Settings(tiling_mode="hex" if "cells" in request.param else "grid")
    for name, content in drain(contents(make(), settings, "3 % & <more>.")).files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(content)
    library = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    found = mx.createDocument()
    mx.readFromXmlFile(found, str(tmp_path / "A_cloth_woven.mtlx"))
    found.setDataLibrary(library)
    found.setSourceUri(str(tmp_path / "A_cloth_woven.mtlx"))
    return found


def test_the_library_finds_it_valid(document: Any) -> None:
    assert document.validate() == (True, "")
    assert document.getVersionString() == "1.39"
    assert document.getDocString().endswith("3 % & <more>.")
    surfaces = [mx.getShaderNodes(material)[0].getCategory() for material in document.getMaterialNodes()]
    assert surfaces == ["open_pbr_surface", "gltf_pbr"]


def test_every_input_is_one_of_the_definition(document: Any) -> None:
    for material in document.getMaterialNodes():
        shader = mx.getShaderNodes(material)[0]
        definition = shader.getNodeDef()
        for given in shader.getInputs():
            assert definition.getActiveInput(given.getName()).getType() == given.getType()


def test_files_are_there_and_colours_are_colours(document: Any) -> None:
    folder = Path(document.getSourceUri()).parent
    kinds = ("tiledimage", "hextiledimage", "hextilednormalmap")
    images = [node for node in document.getNodeGraph("maps").getNodes() if node.getCategory() in kinds]
    assert len(images) >= 4
    for node in images:
        file = node.getInput("file")
        assert (folder / file.getValueString()).is_file()
        assert file.getColorSpace() == ("srgb_texture" if node.getName() == "base_color" else "")


@pytest.mark.parametrize("kind", ["Glsl", "Osl"])
def test_its_generators_make_shaders(document: Any, kind: str, tmp_path: Path) -> None:
    shading = pytest.importorskip("MaterialX.PyMaterialXGenShader")
    module = pytest.importorskip(f"MaterialX.PyMaterialXGen{kind}")
    generator = getattr(module, f"{kind}ShaderGenerator").create()
    context = shading.GenContext(generator)
    context.registerSourceCodeSearchPath(mx.getDefaultDataSearchPath())
    colours = shading.DefaultColorManagementSystem.create(generator.getTarget())
    colours.loadLibrary(document.getDataLibrary())
    generator.setColorManagementSystem(colours)
    for material in document.getMaterialNodes():
        made = generator.generate(material.getName(), material, context)
        source = made.getSourceCode("pixel")
        assert "srgb_texture_to_lin_rec709" in source
        compiler = shutil.which("glslangValidator")
        if kind == "Glsl" and compiler is not None:
            for stage, ending in (("vertex", "vert"), ("pixel", "frag")):
                path = tmp_path / f"{material.getName()}.{ending}"
                path.write_text(made.getSourceCode(stage))
                done = subprocess.run([compiler, path], capture_output=True, text=True, timeout=60)
                assert done.returncode == 0, done.stdout


def test_the_index_of_refraction_is_that_of_f0(document: Any) -> None:
    for name, node in (("specular_ior", "open_pbr_surface_shader"), ("ior", "gltf_pbr_shader")):
        stated = float(document.getNode(node).getInput(name).getValueString())
        f0 = 0.06 if "occlusion" in {n.getName() for n in document.getNodeGraph("maps").getNodes()} else 0.04
        assert stated == pytest.approx(ior_of(f0), rel=1e-5)


def test_names_of_files_are_plain() -> None:
    for name in drain(contents(woven_subject(), Settings(), "")).files:
        assert re.fullmatch(r"(textures/)?[A-Za-z][A-Za-z0-9_-]*\.(png|mtlx)", name)


def test_hexagonal_cells_come_back_as_the_same_maps(tmp_path: Path) -> None:
    """The look-up is that of the hexagonal nodes, and the maps those of a grid."""
    found = []
    for mode in ("grid", "hex"):
        made = drain(contents(measure_subject(), Settings(tiling_mode=mode), ""))
        for name, content in made.files.items():
            (tmp_path / mode / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / mode / name).write_bytes(content)
        document = (tmp_path / mode / f"{measure_subject().name}.mtlx").read_text()
        assert ("hextilednormalmap" in document, "<tiledimage" in document) == (mode == "hex", mode == "grid")
        assert any("blended by brightness" in words for words in made.warnings) == (mode == "hex")
        pbr = open_material(tmp_path / mode / f"{measure_subject().name}.mtlx").pbr
        assert pbr is not None
        found.append(pbr)
    for name in ("base_colour", "normal", "roughness", "metallic"):
        np.testing.assert_array_equal(getattr(found[0], name), getattr(found[1], name))
    with pytest.raises(UsageError, match="unknown tiling mode"):
        Settings(tiling_mode="round")  # type: ignore[arg-type]

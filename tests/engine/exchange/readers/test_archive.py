"""Textures in a zip and documents in folders: what a library of materials sends is the material of its folder."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest

from engine.core.errors import InputError
from engine.core.steps import drain
from engine.exchange import materialx, usd
from engine.exchange.readers.read import holds_material, open_material
from engine.exchange.subject import Settings
from engine.geometry import usd as geometry_usd
from tests.engine.exchange.materials import measure_subject

from .images import grey, png


def zip_folder(path: Path, folder: Path) -> Path:
    with zipfile.ZipFile(path, "w") as archive:
        for file in sorted(folder.rglob("*")):
            archive.write(file, file.relative_to(folder.parent))
    return path


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, value in (("Color", 200), ("Roughness", 51), ("Displacement", 9)):
        png(tmp_path / "Bricks076" / f"Bricks076_1K-PNG_{name}.png", grey(value))
    png(tmp_path / "Bricks076" / "Bricks076.png", grey(1))
    return tmp_path / "Bricks076"


def test_a_zip_is_what_its_folder_is(folder: Path, tmp_path: Path) -> None:
    """Also where macOS has packed shadows of files; the image of the whole material is none of its maps."""
    png(folder / "._Bricks076_1K-PNG_Color.png", grey(3))
    path = zip_folder(tmp_path / "bricks.zip", folder)
    (folder / "._Bricks076_1K-PNG_Color.png").unlink()
    assert holds_material(path)
    found, wanted = open_material(path), open_material(folder)
    assert found.name == "bricks"
    assert found.pbr is not None
    assert wanted.pbr is not None
    for name in ("base_colour", "normal", "roughness", "metallic", "height"):
        np.testing.assert_array_equal(getattr(found.pbr, name), getattr(wanted.pbr, name))


def test_documents_in_a_zip_are_said_to_be_passed_over(folder: Path, tmp_path: Path) -> None:
    (folder / "Bricks076_1K-PNG.mtlx").write_text("<materialx/>")
    notes = [finding.text for finding in open_material(zip_folder(tmp_path / "b.zip", folder)).health.findings]
    assert any("Bricks076_1K-PNG.mtlx in the archive is not read" in note for note in notes)


def test_textures_of_our_usd_package_come_back_without_its_library(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(geometry_usd, "has_library", lambda: False)
    subject = measure_subject()
    content = drain(usd.contents(subject, Settings(), "")).files["A_cloth_woven.usdz"]
    (tmp_path / "woven.usdz").write_bytes(content)
    material = open_material(tmp_path / "woven.usdz")
    assert material.pbr is not None
    np.testing.assert_allclose(material.pbr.roughness, subject.maps.roughness, atol=0.51 / 255)
    np.testing.assert_allclose(material.pbr.normal, subject.maps.normal, atol=0.02)
    assert any("A_cloth_woven.usda in the archive is not read" in each.text for each in material.health.findings)


def test_a_folder_with_one_document_stands_for_it(tmp_path: Path) -> None:
    subject = measure_subject()
    for name, content in drain(materialx.contents(subject, Settings(), "")).files.items():
        (tmp_path / "out" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "out" / name).write_bytes(content)
    assert holds_material(tmp_path / "out")
    material = open_material(tmp_path / "out")
    assert material.pbr is not None
    np.testing.assert_allclose(material.pbr.f0, subject.maps.f0, atol=1e-4)
    (tmp_path / "out" / "other.mtlx").write_text("<materialx/>")
    assert not holds_material(tmp_path / "out")


def test_a_broken_texture_is_named_within_its_zip(folder: Path, tmp_path: Path) -> None:
    (folder / "Bricks076_1K-PNG_Color.png").write_bytes(b"hello")
    path = zip_folder(tmp_path / "b.zip", folder)
    with pytest.raises(InputError) as caught:
        open_material(path)
    assert caught.value.path == str(path / "Bricks076_1K-PNG_Color.png")


def test_zips_of_anything_else_are_no_material(folder: Path, tmp_path: Path) -> None:
    for name in ("Roughness", "Displacement"):
        (folder / f"Bricks076_1K-PNG_{name}.png").unlink()
    path = zip_folder(tmp_path / "b.zip", folder)
    assert not holds_material(path)
    path.write_bytes(path.read_bytes()[:-30])
    assert not holds_material(path)
    with pytest.raises(InputError):
        open_material(path)


@pytest.mark.parametrize("begin", [b"#usda 1.0\n", b"PXR-USDC\0\0"])
def test_layers_of_usd_are_refused_by_name_without_its_library(
    begin: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(geometry_usd, "has_library", lambda: False)
    (tmp_path / "m.usd").write_bytes(begin + b" " * 200)
    with pytest.raises(InputError, match="usd-core"):
        open_material(tmp_path / "m.usd")

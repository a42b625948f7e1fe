"""Credits of a material: what they hold, and that they travel into files and back."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest

import lightarc
from engine.bundle.bundle import open_bundle, save_bundle
from engine.core.errors import UsageError
from engine.core.steps import drain
from engine.exchange.export import ERRORS, export
from engine.exchange.readers.read import open_material
from engine.exchange.subject import Settings
from engine.scene.credits import LONGEST, Credits, credits_of
from engine.scene.material import Material, material_of_maps
from engine.surface.pbr_maps import PbrMaps

SAID = Credits("Oak, worn", "Zoë Müller", "CC-BY-4.0", source="https://example.org/oak")


def small(credits: Credits | None = None) -> Material:
    flat = np.broadcast_to(np.array([0.0, 0.0, 1.0], np.float32), (4, 4, 3))
    grey = np.full((4, 4), 0.5, np.float32)
    maps = PbrMaps(np.full((4, 4, 3), 0.4, np.float32), np.array(flat), grey, 0.0 * grey, 0.08 * grey)
    found = material_of_maps(maps, "oak")
    return found if credits is None else Material(**{**vars(found), "credits": credits})


def write(folder: Path, material: Material, names: list[str], credits: Credits | None = None) -> dict[str, object]:
    errors = {**dict.fromkeys(ERRORS, 0.0), "by_environment": {"studio": {"rmse_rel": 0.0, "flip": 0.0}}}
    settings = Settings(credits=credits or Credits())
    return drain(export(folder, material, names, settings=settings, known=dict.fromkeys(names, errors)))


def test_what_is_stated_goes_before_what_came_with_the_material() -> None:
    assert Credits(author="B").over(SAID) == Credits("Oak, worn", "B", "CC-BY-4.0", source=SAID.source)
    assert not Credits()
    assert SAID.line == "title: Oak, worn; author: Zoë Müller; licence: CC-BY-4.0; source: https://example.org/oak"
    assert "Zoe Muller" in SAID.ascii_line
    assert credits_of({"author": "A\nB", "title": 7, "licence": "x" * 999}) == Credits("", "A B", "x" * LONGEST)
    assert credits_of(None) == Credits()
    for text in ("a\nb", "x" * (LONGEST + 1)):
        with pytest.raises(UsageError, match="author"):
            Credits(author=text)


def test_credits_are_in_every_file_of_an_export(tmp_path: Path) -> None:
    record = write(tmp_path / "out", small(SAID), ["gltf", "materialx", "usd", "textures"])
    assert record["credits"] == SAID.entries
    for part in (*(tmp_path / "out").rglob("*.mtlx"), *(tmp_path / "out" / "textures").glob("*.png")):
        assert b"CC-BY-4.0" in part.read_bytes(), part
    with zipfile.ZipFile(next((tmp_path / "out").rglob("*.usdz"))) as package:
        assert any(b"Zoe Muller" in package.read(name) for name in package.namelist())
    file = next((tmp_path / "out").rglob("*.glb"))
    content = file.read_bytes()
    asset = json.loads(content[20 : 20 + int.from_bytes(content[12:16], "little")])["asset"]
    assert "Zoë Müller" in asset["copyright"]
    assert open_material(file).credits == SAID


def test_the_copyright_of_a_file_travels_on(tmp_path: Path) -> None:
    tree = {"asset": {"version": "2.0", "copyright": "2026 A. Nobody, CC-BY 4.0"}, "materials": [{}]}
    (tmp_path / "a.gltf").write_text(json.dumps(tree))
    material = open_material(tmp_path / "a.gltf")
    assert material.credits.copyright == "2026 A. Nobody, CC-BY 4.0"
    write(tmp_path / "out", material, ["materialx"], Credits(title="Again"))
    (document,) = (tmp_path / "out").rglob("*.mtlx")
    assert "2026 A. Nobody, CC-BY 4.0; title: Again" in document.read_text()


def test_a_bundle_keeps_them(tmp_path: Path) -> None:
    drain(save_bundle(tmp_path / "a.lightarc", small(SAID)))
    assert open_bundle(tmp_path / "a.lightarc").credits == SAID
    drain(save_bundle(tmp_path / "b.lightarc", small()))
    assert not open_bundle(tmp_path / "b.lightarc").credits


def test_the_library_takes_them(tmp_path: Path) -> None:
    record = lightarc.export(small(), tmp_path / "out", "textures", author="Zoë", license="CC0-1.0")
    assert record["credits"] == {"author": "Zoë", "licence": "CC0-1.0"}

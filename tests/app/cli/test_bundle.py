"""`lightarc bundle` on the command line: exit codes, one JSON object, plain words."""

from __future__ import annotations

import argparse
import json
import zipfile
from pathlib import Path

import numpy as np
import pytest

from app import command_line
from app.cli import bundle
from engine.bundle.bundle import open_bundle, save_bundle
from engine.core.steps import drain
from engine.exchange.readers.read import open_material
from engine.images.encode import encode_png
from engine.scene.material import Material
from engine.shading.shading_map import ShadingMap
from tests.engine.exchange.materials import woven_material


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    slices = np.random.default_rng(1).random((2, 3, 4, 3), dtype=np.float32)
    material = Material(ShadingMap(slices, 0.5, np.array([0.0, 0.5])), None, name="woven")
    return drain(save_bundle(tmp_path / "woven.lightarc", material))


@pytest.fixture(autouse=True)
def only_this_verb(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command_line, "VERBS", (("bundle", "app.cli.bundle", ""),))


def run(*words: str) -> int:
    return command_line.main(["bundle", *words])


@pytest.fixture
def maps(tmp_path: Path) -> Path:
    """A folder of textures that any program may have written."""
    folder = tmp_path / "rock"
    folder.mkdir()
    colour = np.zeros((6, 5, 3), np.uint8)
    colour[:, :2] = (200, 40, 40)
    (folder / "rock_base_color.png").write_bytes(encode_png(colour))
    (folder / "rock_roughness.png").write_bytes(encode_png(np.full((6, 5), 90, np.uint8), transfer="linear"))
    return folder


def test_maps_of_others_are_kept_in_a_bundle(maps: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = maps.with_name("kept.lightarc")
    assert run("make", str(maps), "-o", str(path), "--json") == 0
    made = json.loads(capsys.readouterr().out)
    assert (made["ok"], made["schema_version"]) == (True, 3)
    assert "pbr_maps.exr" in made["members"]
    kept, wanted = open_bundle(path).pbr, open_material(maps).pbr
    assert kept is not None
    assert wanted is not None
    np.testing.assert_array_equal(kept.base_colour, wanted.base_colour)
    assert run("view", str(path)) == 2
    assert "export --to gltf" in capsys.readouterr().err


def test_a_sound_bundle(saved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("verify", str(saved), "--json") == 0
    value = json.loads(capsys.readouterr().out)
    assert value == {
        "path": str(saved),
        "ok": True,
        "members": ["brdf.json", "manifest.json", "preview.png", "shader/lightarc.glsl", "shading_map.exr"],
        "problems": [],
        "unchecked": [],
        "size_bytes": saved.stat().st_size,
        "schema_version": 1,
        "warnings": [],
    }
    assert run("verify", str(saved)) == 0
    assert capsys.readouterr().out.startswith(f"{saved} is sound: 5 members with the manifest")


def test_a_changed_member_is_named_and_the_exit_code_says_so(saved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    content = saved.read_bytes()
    with zipfile.ZipFile(saved) as packed:
        start = packed.getinfo("shading_map.exr").header_offset + 30 + len("shading_map.exr")
    saved.write_bytes(content[: start + 400] + bytes([content[start + 400] ^ 1]) + content[start + 401 :])
    assert run("verify", str(saved), "--json") == 3
    value = json.loads(capsys.readouterr().out)
    assert not value["ok"]
    assert "shading_map.exr" in value["problems"][0]
    assert "exit_code" not in value


def test_a_whole_bundle_of_an_earlier_build_frightens_nobody(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The material counts; its page is named, as it cannot be checked."""
    with monkeypatch.context() as earlier:
        earlier.setattr("engine.bundle.page._style", lambda: "body { color: red }")
        earlier.setattr("engine.bundle.bundle.maker", lambda: "0123456789abcdef")
        law = drain(save_bundle(tmp_path / "law.lightarc", woven_material()))
    assert run("verify", str(law), "--json") == 0
    value = json.loads(capsys.readouterr().out)
    assert (value["ok"], value["problems"]) == (True, [])
    (sentence,) = value["unchecked"]
    assert sentence.startswith("viewer/index.html was written by another build of version")
    assert sentence in value["warnings"]
    assert run("verify", str(law)) == 0
    said = capsys.readouterr().out
    assert said.startswith(f"The material in {law} is whole: ")
    assert "sound" not in said


@pytest.mark.parametrize("content", [b"", b"PK\3\4", b"not a bundle"], ids=["empty", "cut", "text"])
def test_what_is_no_bundle(tmp_path: Path, content: bytes, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.lightarc").write_bytes(content)
    for path in (tmp_path / "a.lightarc", tmp_path / "absent", tmp_path):
        assert run("verify", str(path)) == 3
        said = capsys.readouterr()
        assert said.out == ""
        assert "Traceback" not in said.err
        assert str(path) in said.err


def test_the_example_of_the_help_parses() -> None:
    parser = argparse.ArgumentParser()
    bundle.add_arguments(parser)
    words = bundle.EXAMPLE.removeprefix("lightarc bundle ").replace(" --json", "").split()
    assert parser.parse_args(words).action == "verify"


def test_a_bundle_is_extracted_and_viewed(
    saved: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[str] = []

    def browse(url: str) -> bool:
        opened.append(url)
        return True

    monkeypatch.setattr("webbrowser.open", browse)
    assert run("extract", str(saved), "-o", str(tmp_path / "folder"), "--json") == 0
    assert json.loads(capsys.readouterr().out)["files"][-1] == "manifest.json"
    assert run("verify", str(tmp_path / "folder"), "--json") == 0
    assert run("extract", str(saved), "-o", str(tmp_path / "x.lightarc")) == 2
    assert run("extract", str(saved)) == 2
    assert run("view", str(saved)) == 2
    law = drain(save_bundle(tmp_path / "law.lightarc", woven_material()))
    capsys.readouterr()
    assert run("view", str(law), "--json") == 0
    page = Path(json.loads(capsys.readouterr().out)["page"])
    assert opened == [page.as_uri()]
    assert "<html" in page.read_text(encoding="utf-8")
    page.unlink()
    page.parent.rmdir()


def test_show_tells_a_user_what_is_in_it_and_json_all(saved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("show", str(saved)) == 0
    said = capsys.readouterr().out
    assert "shading map: 2 slices of 4 × 3 texels" in said
    assert "shading_map.exr" in said
    assert "{" not in said
    assert run("show", str(saved), "--json") == 0
    assert json.loads(capsys.readouterr().out)["shading_map"]["width_px"] == 4

"""`lightarc export` as a user runs it."""

from __future__ import annotations

import json
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from app.cli import export as verb
from app.command_line import main
from app.document.document import Project
from app.project.losses import keep, keys_of
from app.project.project_file import History, Writer, data_folder, read
from engine.bundle.bundle import save_bundle
from engine.core.steps import drain
from engine.exchange.coding import CODINGS
from engine.exchange.export import NAMES, RECORD, Offer
from engine.exchange.targets import EXPORTERS
from engine.exchange.textures import PRESETS
from tests.engine.exchange.materials import woven_material


@pytest.fixture(scope="module")
def bundle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return drain(save_bundle(tmp_path_factory.mktemp("bundle") / "woven.lightarc", woven_material()))


@pytest.fixture(autouse=True)
def _small_balls(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.exchange.loss.DIAMETER", 40)


def run(capsys: pytest.CaptureFixture[str], *words: object) -> tuple[int, Any]:
    code = main([*map(str, words), "--json"])
    output = capsys.readouterr().out
    return code, json.loads(output) if output else None


def test_the_options_are_those_of_the_engine() -> None:
    assert tuple(EXPORTERS) == NAMES
    assert tuple(PRESETS) == verb.PRESETS
    assert verb.CODINGS == CODINGS


def test_each_target_states_files_and_errors(bundle: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names = [name for name in NAMES if name != "rti"]
    code, result = run(capsys, "export", bundle, "--to", *names, "-o", tmp_path / "out")
    assert code == 0
    assert [made["target"] for made in result["targets"]] == names
    for made in result["targets"]:
        sizes = [(tmp_path / "out" / name).stat().st_size for name in made["files"]]
        assert made["bytes"] == sum(sizes)
        assert made["rmse_rel"] is None
    textures = result["targets"][0]
    assert 0.0 < textures["rmse_rel_reference"] < 1.0
    assert 0.0 < textures["flip"] < 1.0
    assert set(textures["by_environment"]) == {"studio", "noon", "overcast"}
    record = json.loads((tmp_path / "out" / RECORD).read_text())
    assert record["targets"] == result["targets"]


def test_a_warning_of_several_targets_is_said_once(bundle: Path, tmp_path: Path, capsys: Any) -> None:
    assert main(["export", str(bundle), "--to", "gltf", "brdf", "materialx", "-o", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert "materialx, gltf: what these files show is" in said
    assert "Of brdf they compare a ball of the BRDF alone" in said


def test_an_export_replaces_an_export_and_nothing_else(
    bundle: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert run(capsys, "export", bundle, "--to", "textures", "-o", out)[0] == 0
    assert run(capsys, "export", bundle, "--to", "textures", "--preset", "godot", "-o", out)[0] == 0
    assert sorted(path.name for path in (out / "textures").iterdir()) == [
        *("A_cloth_woven_albedo.png", "A_cloth_woven_normal.png", "A_cloth_woven_orm.png")
    ]
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "letter.txt").write_text("dear")
    assert run(capsys, "export", bundle, "--to", "textures", "-o", mine)[0] == 3
    assert (mine / "letter.txt").read_text() == "dear"


def test_a_file_that_is_no_bundle_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "x.lightarc").write_bytes(b"no")
    assert run(capsys, "export", tmp_path / "x.lightarc", "--to", "textures", "-o", tmp_path / "out")[0] == 3
    assert not (tmp_path / "out").exists()


def test_an_arc_of_lamps_makes_no_rti(bundle: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(capsys, "export", bundle, "--to", "rti", "-o", tmp_path / "out")[0] == 2
    assert not (tmp_path / "out").exists()


def test_errors_that_the_window_measured_are_stated_and_not_measured_again(tmp_path: Path, capsys: Any) -> None:
    """Where they are of other settings of textures, they are measured."""
    path = tmp_path / "woven.lap"
    with closing(Writer(path)) as writer:
        writer.write(History(Project(material=woven_material()), (), 0))
    kept = Offer(
        "textures",
        {"rmse_rel": None, "rmse_rel_reference": 0.5, "flip": 0.125, "by_environment": {}, "warnings": []},
        None,
    )
    project = read(path).current
    keep(drain(keys_of(project, ["textures"]))["textures"], kept, data_folder(path))
    flips = []
    for at, coding in enumerate(("png8", "exr")):
        words = ("--to", "textures", "--coding", coding, "-o", tmp_path / str(at))
        code, result = run(capsys, "export", path, *words)
        assert code == 0
        flips.append(result["targets"][0]["flip"])
    assert flips[0] == 0.125
    assert flips[1] != 0.125

"""A real batch: two captures and one that is none, as `lightarc batch` makes them and as the verbs alone do."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.arguments.usage import ALL_FAILED, BAD_FILE, SOME_FAILED, WRONG_USAGE
from app.batch.making import make_of_request
from app.batch.record import read_folder
from app.document.document import Project
from app.project.project_file import History, Writer, read
from engine.bundle.bundle import open_bundle
from engine.core.steps import drain
from tests.app.captures import capture
from tests.app.command import Command, result


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dome of eight lights, an arc of three, and a folder of what is no photographs."""
    source = tmp_path_factory.mktemp("source")
    around = {"azimuth": (0.0, 1.6, 3.1, 4.7), "elevation": (0.5, 1.1)}
    capture(source / "dome", size=24, sample="leather", **around)
    capture(source / "arc", size=24)
    (source / "none").mkdir()
    for name in ("a.png", "b.png"):
        (source / "none" / name).write_bytes(b"no image")
    return source


def run(lightarc: Command, *words: Any) -> tuple[int, dict[str, Any]]:
    done = lightarc("batch", *words, "--json")
    return done.code, json.loads(done.out)


@pytest.mark.long
def test_a_batch_makes_what_the_verbs_make(lightarc: Command, source: Path, tmp_path: Path) -> None:
    template = tmp_path / "template.lap"
    writer = Writer(template)
    writer.write(History(Project(slices=4, notes="own")))
    writer.close()
    output = tmp_path / "results"
    sources = (source / "arc", source / "none")
    code, found = run(lightarc, *sources, "-o", output, "--template", template, "--to", "none", "--workers", 2)
    assert code == SOME_FAILED
    assert {each["name"]: each["state"] for each in found["captures"]} == {
        "arc": "done",
        "none": "failed",
    }
    assert "a.png" in found["captures"][1]["reason"]
    assert found["captures"][0]["files"] == {"project": "arc/arc.lap"}

    opened = read(output / "arc" / "arc.lap")
    assert opened.missing == {}
    assert (opened.current.slices, opened.current.notes) == (4, "")
    assert opened.current.recipe == opened.current.built_from
    assert [path.parent for path in opened.current.sources.photographs] == [source / "arc"] * 3  # type: ignore[union-attr]
    result(lightarc("import", source / "arc", "-o", tmp_path / "stack", "--json"))
    result(lightarc("shade", tmp_path / "stack", "-o", tmp_path / "arc.lightarc", "--slices", 4, "--json"))
    ours, alone = (open_bundle(path) for path in (output / "arc" / "material.lightarc", tmp_path / "arc.lightarc"))
    for name in ("exponent", "scale"):
        one, other = (np.asarray(getattr(each.power_law, name)) for each in (ours, alone))
        assert np.array_equal(one, other)

    before = {path: path.read_bytes() for path in output.glob("*/capture.json")}
    code, again = run(lightarc, "-o", output, "--workers", 2)
    assert code == SOME_FAILED
    assert again["captures"][0] == found["captures"][0]
    assert before == {path: path.read_bytes() for path in output.glob("*/capture.json")}


def make(name: str, source: Path, output: Path) -> dict[str, Any]:
    output.mkdir(exist_ok=True)
    said = {"name": name, "place": str(source / name), "options": {"slices": "3"}, "metadata": {"author": "Ada"}}
    order: dict[str, Any] = {"output": str(output), "template": None, "targets": []}
    return drain(make_of_request(json.dumps(said), order))


def test_options_of_a_row_hold_for_its_capture(source: Path, tmp_path: Path) -> None:
    """What is there is not made again."""
    record = make("arc", source, tmp_path)
    assert read_folder(tmp_path / "arc") == record
    project = read(tmp_path / "arc" / "arc.lap").current
    assert (project.slices, project.exporting.credits.author) == (3, "Ada")
    place = (tmp_path / "arc").stat().st_ino
    assert make("arc", source, tmp_path) == record
    assert (tmp_path / "arc").stat().st_ino == place


@pytest.mark.long
def test_results_depend_on_no_folder_and_no_time(source: Path, tmp_path: Path) -> None:
    for name in "ab":
        record = make("dome", source, tmp_path / name)
        assert record["maps"] == "maps"
    files = [sorted(path.relative_to(tmp_path / name) for path in (tmp_path / name).rglob("*")) for name in "ab"]
    assert files[0] == files[1]
    for path in files[0]:
        if (tmp_path / "a" / path).is_file() and path.suffix != ".lap":
            assert (tmp_path / "a" / path).read_bytes() == (tmp_path / "b" / path).read_bytes(), path


def test_exit_codes_tell_how_many_failed(lightarc: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.batch.run.MAKE", "tests.app.batch.fast:make")
    (tmp_path / "list.csv").write_text("path,name\nnowhere,refuse\n")
    assert run(lightarc, tmp_path / "list.csv", "-o", tmp_path / "a")[0] == ALL_FAILED
    assert lightarc("batch", "-o", tmp_path / "b").code == WRONG_USAGE
    refused = lightarc("batch", tmp_path / "list.csv", tmp_path / "gone", "-o", tmp_path / "b")
    assert refused.code == BAD_FILE
    assert not (tmp_path / "b").exists(), "what is refused leaves nothing"

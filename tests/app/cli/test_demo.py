"""`lightarc demo` as a script meets it."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from app import command_line
from engine.core.errors import InputError
from engine.figures import demo as demos
from engine.simulate.arc import LightArc


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    arc = LightArc(size=48, elevation=tuple(math.radians(angle) for angle in (20, 50, 90)))
    monkeypatch.setattr(demos, "LightArc", lambda: arc)
    monkeypatch.setattr(demos, "IMAGE_SIZE", (64, 40))
    monkeypatch.setattr(command_line, "VERBS", (("demo", "app.cli.demo", ""),))


def test_json_lists_bundle_images_and_stages(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command_line.main(["demo", "-o", str(tmp_path / "d"), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert Path(result["bundle"]).name == "woven.lightarc"
    assert all(Path(path).is_file() for path in [result["bundle"], *result["images"]])
    assert all(stage["time_s"] >= 0 and "error" not in stage for stage in result["stages"])


def test_failed_stage_is_named_and_the_rest_is_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(material: Any, **_: Any) -> Iterator[None]:
        raise InputError("stack", "cannot be compressed", "Use more slices")
        yield

    monkeypatch.setattr(demos, "fit", refuse)
    assert command_line.main(["demo", "-o", str(tmp_path / "d"), "--json"]) == 0
    stages = {stage["name"]: stage for stage in json.loads(capsys.readouterr().out)["stages"]}
    assert stages["compress"]["error"] == "stack: cannot be compressed. Use more slices."
    assert "error" not in stages["render"]


def test_unwritable_place_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("x")
    assert command_line.main(["demo", "-o", str(tmp_path / "file"), "--json"]) == 3
    output = capsys.readouterr()
    assert output.out == ""
    assert "Traceback" not in output.err
    assert str(tmp_path / "file") in output.err

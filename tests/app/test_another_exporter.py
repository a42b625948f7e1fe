"""An exporter that is not part of the package: in the command line, the window, a project and the Python API."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import lightarc
from app.cli import export as verb
from app.document.exporting import Exporting
from engine.core.steps import Step, Steps
from engine.exchange.export import candidates, cannot_hold, targets
from engine.exchange.subject import Contents, Settings, Subject
from engine.exchange.targets import EXPORTERS, Exporter, register, unregister


def contents(subject: Subject, settings: Settings, statement: str) -> Steps[Contents]:
    """A text that names the material and states the errors."""
    yield Step(0.5, "writing the note")
    return Contents({"note.txt": f"{subject.material.name}: {statement}".encode()})


NOTE = Exporter(
    "note",
    "Note",
    "A text that names the material",
    shown=lambda subject, _: subject.decode_as("png8"),
    contents=contents,
)


@pytest.fixture
def note() -> Iterator[Exporter]:
    yield register(NOTE)
    unregister(NOTE)


def test_an_exporter_from_outside_is_offered_everywhere(note: Exporter) -> None:
    parser = argparse.ArgumentParser()
    verb.add_arguments(parser)
    assert parser.parse_args(["a.lightarc", "--to", "note", "-o", "out"]).to == ["note"]
    assert Exporting(targets=("note",)).targets == ("note",)
    assert "note" in candidates()
    assert [each.name for each in targets()] == list(EXPORTERS)


def test_an_exporter_from_outside_writes_its_files_with_their_errors(note: Exporter, tmp_path: Any) -> None:
    photographs = np.linspace(0.1, 1.0, 3)[:, None, None, None] * np.ones((3, 8, 8, 3), np.float32)
    material = lightarc.build_material(photographs, slices=3, name="felt")
    assert cannot_hold("note", material, None) == ""
    record = lightarc.export(material, tmp_path / "out", to="note")
    assert record["targets"][0]["rmse_rel_reference"] < 1.0
    assert (tmp_path / "out" / "note" / "note.txt").read_text().startswith("felt: ")


@pytest.mark.parametrize(
    ("exporter", "words"),
    [
        (Exporter("note", "Note", "No functions"), "functions shown and contents"),
        (Exporter("gltf", "glTF", "Taken", shown=lambda *_: None, contents=contents), "another exporter gltf"),
        (Exporter("Two words", "", "", shown=lambda *_: None, contents=contents), "lower-case words"),
    ],
)
def test_what_lacks_a_part_is_refused(exporter: Exporter, words: str) -> None:
    before = dict(EXPORTERS)
    with pytest.raises(ValueError, match=words):
        register(exporter)
    assert before == EXPORTERS

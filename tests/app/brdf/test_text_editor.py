"""The text of a BRDF in GLSL: what is typed reaches the views, a mistake stays beside the text at its line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtWidgets import QFileDialog

from app.brdf.tab import BrdfTab
from app.brdf.text_editor import TextEditor
from app.commands.brdf import TEMPLATES, save_text
from app.widgets.resources import RESOURCES
from app.window.main_window import MainWindow
from engine.brdf.brdf import brdf_from_text
from engine.brdf.resample import random_pairs
from engine.brdf.written import read_written, write
from tests.present import present

PATIENCE_MS = 60_000


@pytest.fixture
def editor(window: MainWindow, qtbot: Any) -> TextEditor:
    """The editor of a text that was just begun."""
    window.show_workspace("brdf")
    window.brdf.library.template_wanted.emit("blinn-phong")
    qtbot.waitUntil(lambda: bool(window.brdf.findChildren(TextEditor)), timeout=PATIENCE_MS)
    (made,) = window.brdf.findChildren(TextEditor)
    return made


def entry_of(editor: TextEditor) -> Any:
    return present(editor.bench.document.project.comparison.find(editor.identity))


def type_in(editor: TextEditor, qtbot: Any, old: str, new: str) -> str:
    """The verdict of the editor once it has compiled the text with `new` in place of `old`."""
    assert old in editor.written
    editor.edit.setPlainText(editor.written.replace(old, new))
    assert editor.pause.isActive()
    editor.pause.stop()
    editor.compile()
    qtbot.waitUntil(lambda: not editor.latest.busy, timeout=PATIENCE_MS)
    return editor.verdict.text()


@pytest.mark.parametrize(
    ("template", "put", "words"),
    [
        ("ggx", ("float roughness 0.05 1 0.4", "float roughness 0.05 1 0.6"), "ggx:kd=0,f0=0.04,alpha=0.36"),
        ("blinn-phong", ("exponent 1 1000 60", "exponent 1 1000 6"), "blinn-phong:kd=0,ks=0.05,exponent=6"),
    ],
)
def test_templates_are_the_models_that_they_name(template: str, put: tuple[str, str], words: str) -> None:
    wi, wo = random_pairs(500)
    text = (RESOURCES / "brdf" / f"{template}.brdf").read_text(encoding="utf-8").replace(*put)
    ours = brdf_from_text(words).f(wi, wo)
    highlight = write(text.replace("color base 0.4 0.25 0.15", "color base 0 0 0"), template).f(wi, wo)
    ratio = highlight.sum() / ours.sum()
    np.testing.assert_allclose(highlight, ratio * ours, rtol=3e-3, atol=1e-5)
    assert 0.9 < ratio < 1.1
    assert template in TEMPLATES


def test_what_is_typed_is_seen_and_is_one_step(editor: TextEditor, window: MainWindow, qtbot: Any) -> None:
    stack = window.bench.document.undo_stack
    steps, before = stack.count(), entry_of(editor).brdf
    assert type_in(editor, qtbot, "vec3(shine * highlight)", "vec3(0.0)") == "Compiled"
    assert stack.count() == steps + 1
    values = entry_of(editor).brdf.f([0.0, 0.0, 1.0], [0.0, 0.0, 1.0])
    np.testing.assert_allclose(values, np.array([0.4, 0.25, 0.15]) / np.pi, rtol=1e-5)
    window.undo.trigger()
    assert entry_of(editor).brdf == before
    assert editor.written == before.text
    window.brdf.inspector.written.editors["shine"].edited.emit(0.5, True)  # type: ignore[union-attr]
    qtbot.waitUntil(lambda: "float shine 0 1 0.5" in editor.written, timeout=PATIENCE_MS)


def test_a_mistake_is_told_at_its_line_and_the_views_keep_the_last(
    editor: TextEditor, window: MainWindow, qtbot: Any
) -> None:
    before, steps = entry_of(editor).brdf, window.bench.document.undo_stack.count()
    said = type_in(editor, qtbot, "return base", "return bose")
    line = next(at for at, text in enumerate(editor.written.split("\n"), 1) if "bose" in text)
    assert said.startswith(f"Line {line}: ")
    assert editor.edit.wrong_line == line
    assert len(editor.edit.extraSelections()) == 1
    assert entry_of(editor).brdf is before
    assert window.bench.document.undo_stack.count() == steps
    assert not window.failures.open_dialogs
    assert type_in(editor, qtbot, "return bose", "return 2.0 * base") == "Compiled"
    assert editor.edit.wrong_line == 0


def test_a_text_that_hangs_or_asks_for_files_is_a_sentence(editor: TextEditor, qtbot: Any) -> None:
    said = type_in(editor, qtbot, "const float PI", "#include <secret>\nconst float PI")
    assert "#include is not allowed" in said


def test_the_text_is_saved_as_it_stands(
    editor: TextEditor, qtbot: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_arguments: (str(tmp_path / "mine"), ""))
    with qtbot.waitSignal(editor.bench.said, timeout=PATIENCE_MS):
        editor.save.click()
    assert (tmp_path / "mine.brdf").read_text(encoding="utf-8") == editor.written
    assert read_written(tmp_path / "mine.brdf").text == editor.written


def test_an_editor_goes_with_its_entry_and_is_opened_once(editor: TextEditor, window: MainWindow, qtbot: Any) -> None:
    tab: BrdfTab = window.brdf
    assert tab.open_text(entry_of(editor)) is editor
    assert not tab.inspector.edit_text.isHidden()
    tab.remove()
    assert not editor.isVisible()


def test_a_text_that_cannot_be_written_is_a_sentence(window: MainWindow, qtbot: Any, tmp_path: Path) -> None:
    job = save_text(window.bench, "analytic", tmp_path / "none" / "a.brdf")
    qtbot.waitUntil(lambda: len(window.failures.open_dialogs) == 1, timeout=PATIENCE_MS)
    assert job.state == "failed"

"""Files that come from outside the window."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import Qt, QUrl
from PySide6.QtWidgets import QApplication, QLabel, QMenu, QWidget

from app.project.listing import Listed
from app.start.project_list import ProjectModel, where
from app.window.banner import short_path
from app.window.failures import Failures, explain, sentence
from app.window.files import local_path, path_of
from app.window.recent import fill
from engine.core.errors import InputError


@pytest.mark.skipif(sys.platform in ("darwin", "win32"), reason="names are UTF-8 on this system")
def test_a_dropped_file_may_have_a_name_in_any_encoding() -> None:
    assert os.fsencode(local_path(QUrl.fromEncoded(b"file:///a/m%FF.lap"))) == b"/a/m\xff.lap"


@pytest.mark.parametrize("name", ["/a b%20/ä#?.png", "/plain.lap"])
def test_other_names_stay(name: str) -> None:
    assert local_path(QUrl.fromLocalFile(name)) == Path(name)


#: Names that drive a terminal, break lines, turn the direction of writing, or hold bytes of another encoding.
NAMES = (b"caf\xe9", b"line\nbreak", b"esc\x1b]0;title\x07", "rtl\u202egpj".encode(), b"-o", b"<img src=x>")


@pytest.mark.skipif(sys.platform in ("darwin", "win32"), reason="names are UTF-8 on this system")
@pytest.mark.parametrize("name", NAMES)
def test_names_of_any_bytes_are_shown_on_one_line_without_controls(qapp: QApplication, name: bytes) -> None:
    """In the recent files, the start page, banners and messages, and in a log of any encoding."""
    path = Path("/folder") / os.fsdecode(name + b"\xff") / os.fsdecode(name + b".png")
    listed = Listed(path.with_suffix(".lap"), path.stem, 0.0, is_untitled=False)
    model, menu = ProjectModel(), QMenu()
    model.show_projects((listed,))
    fill(menu, (), (str(path),), lambda _: None)
    (entry,) = menu.actions()
    error = InputError(path, "is damaged", "Copy it again")
    shown = [
        *entry.text().split("\t"),
        entry.toolTip(),
        *(str(model.data(model.index(0), role)) for role in (0, Qt.ItemDataRole.ToolTipRole)),
        where(listed),
        short_path(path),
        sentence(error),
        *explain(error)[0].split("\n"),
        str(error),
    ]
    for text in shown:
        assert text.isprintable(), ascii(text)
        text.encode("utf-8")
    assert "\\xff" in str(error)


def test_a_message_shows_a_name_as_it_is_and_not_as_mark_up(qtbot: Any) -> None:
    window = QWidget()
    qtbot.addWidget(window)
    failures = Failures(window)
    failures.report('Couldn\'t open "a\nb"', InputError("<img src=x>.png", "is damaged", "Copy it again"))
    qtbot.waitUntil(lambda: bool(failures.open_dialogs))
    (box,) = failures.open_dialogs.values()
    labels = [label for label in box.findChildren(QLabel) if label.text()]
    assert labels
    assert {label.textFormat() for label in labels} == {Qt.TextFormat.PlainText}
    assert "\\n" in box.text()
    box.close()


@pytest.mark.skipif(sys.platform in ("darwin", "win32"), reason="names are UTF-8 on this system")
def test_a_dialog_names_files_whose_bytes_qt_replaces(tmp_path: Path) -> None:
    file = tmp_path / os.fsdecode(b"d\xe9r") / os.fsdecode(b"caf\xe9\xe8.png")
    file.parent.mkdir()
    file.write_bytes(b"1")
    shown = str(tmp_path / "d\ufffdr" / "caf\ufffd\ufffd.png")
    assert path_of(shown) == file
    file.with_name(os.fsdecode(b"caf\xff.png")).write_bytes(b"2")
    with pytest.raises(InputError, match="not UTF-8"):
        path_of(shown)
    assert path_of(str(tmp_path / "missing.png")) == tmp_path / "missing.png"

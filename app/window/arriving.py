"""Photographs that come into a window with a capture: a person says whether they join it, replace it, or neither."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtGui import QIcon
from PySide6.QtWidgets import QMessageBox, QWidget

from app.commands.workbench import Workbench

#: Buttons in their order, and what each does.
CHOICES = {
    "New project": "keeps this project as it is and imports the photographs into one of their own",
    "Add": "imports all photographs together, as one capture of one sample",
    "Replace": "imports the photographs in place of those of this project; Undo brings those back",
}


def ask_for_photographs(
    window: QWidget, bench: Workbench, begin_anew: Callable[[], object], paths: Sequence[Path]
) -> QMessageBox:
    """Ask where the photographs at `paths` belong, and open them there; nothing where the question is closed."""
    box = QMessageBox(window)
    box.setIcon(QMessageBox.Icon.Question)
    box.setWindowTitle("Lightarc")
    box.setText("This project has photographs already.")
    name = paths[0].name if len(paths) == 1 else f"{len(paths)} files"
    lines = "\n\n".join(f"{words}: {does}." for words, does in CHOICES.items())
    box.setTextFormat(Qt.TextFormat.PlainText)
    box.setInformativeText(f"Where does {name} belong?\n\n{lines}")

    def anew() -> None:
        begin_anew()
        bench.open_photographs(paths)

    runs = (anew, lambda: bench.add_photographs(paths), lambda: bench.open_photographs(paths))
    for words, run in zip(CHOICES, runs, strict=True):
        made = box.addButton(words, QMessageBox.ButtonRole.ActionRole)
        made.clicked.connect(lambda _checked=False, run=run: run())
        if words == "New project":
            box.setDefaultButton(made)
    box.addButton(QMessageBox.StandardButton.Cancel).setIcon(QIcon())  # the style's own is of another style
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    box.open()
    return box

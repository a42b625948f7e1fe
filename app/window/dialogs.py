"""Dialogs about the project: its file and its place, what is collected, its history, and a user's notes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtGui import QIcon
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QMessageBox,
    QPlainTextEdit,
    QUndoView,
    QVBoxLayout,
    QWidget,
)

from app.commands.workbench import Workbench
from app.document.document import Project
from app.project import places
from app.project.made import size_of
from app.project.photographs import INSIDE
from app.project.project_file import ENDING, data_folder
from app.widgets.theme import STEP
from engine.capture.lights.file_names import printable
from engine.core.errors import InputError
from engine.core.figure_text import size_text

FILTER = f"Lightarc projects (*{ENDING})"


def ask_to_open(window: QWidget, open_path: Callable[[Path], None], folder: str) -> None:
    """Ask for a project file."""
    chosen, _ = QFileDialog.getOpenFileName(window, "Open project", folder, FILTER)
    if chosen:
        open_path(Path(chosen))


def ask_for_place(window: QWidget, title: str, proposed: Path) -> Path | None:
    """Ask for the path of a project to write; the ending is added where it is missing."""
    chosen, _ = QFileDialog.getSaveFileName(window, title, str(proposed), FILTER)
    return Path(chosen if chosen.endswith(ENDING) else chosen + ENDING) if chosen else None


def ask_what_to_collect(
    window: QWidget, path: Path, outside: Sequence[Path], collect: Callable[[bool], object]
) -> QMessageBox:
    """Ask whether a copy of the project at `path` holds what can be made again too, and `collect` with the answer.

    Files `outside` its folder are named: whoever goes on agrees that they are copied.
    """
    folder = data_folder(path)
    size = size_of(folder) - size_of(folder / INSIDE)
    box = QMessageBox(window)
    box.setIcon(QMessageBox.Icon.Question)
    box.setWindowTitle("Lightarc")
    box.setText("A collected project holds its photographs and opens on any machine.")
    box.setInformativeText(
        f"Is it to hold the results as well, {size_text(size)}? They can be made again there, which takes its time."
    )
    if outside:
        count = f"{len(outside)} files" if len(outside) > 1 else f"the file {outside[0]}"
        box.setInformativeText(
            f"{box.informativeText()}\n\nIt will hold {count} from outside the project's folder. Look at the list "
            "first, if the project came from somebody else."
        )
        box.setDetailedText("\n".join(map(printable, outside)))
    for words, with_derived in (("With results", True), ("Without", False)):
        made = box.addButton(words, QMessageBox.ButtonRole.ActionRole)
        made.clicked.connect(lambda _checked=False, with_derived=with_derived: collect(with_derived))
        if with_derived:
            box.setDefaultButton(made)
    box.addButton(QMessageBox.StandardButton.Cancel).setIcon(QIcon())  # the style's own is of another style
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    box.open()
    return box


def ask_to_recover(window: QWidget, error: InputError, recover: Callable[[], object]) -> QMessageBox:
    """Say why a damaged project was not opened, and `recover` it where the user wants that."""
    box = QMessageBox(window)
    box.setIcon(QMessageBox.Icon.Warning)
    box.setWindowTitle("Lightarc")
    box.setText(f"{Path(error.path).name} {error.problem}.")
    box.setInformativeText("What is sound in it can be saved in a new project. The damaged one stays as it is.")
    box.addButton("Recover…", QMessageBox.ButtonRole.ActionRole).clicked.connect(lambda _checked=False: recover())
    close = box.addButton(QMessageBox.StandardButton.Close)
    close.setIcon(QIcon())  # the style's own is black, also on dark
    box.setDefaultButton(close)
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    box.open()
    return box


def show_history(window: QWidget, bench: Workbench) -> QDialog:
    """The steps of the history, to go back or forth to any of them."""
    dialog = QDialog(window)
    dialog.setWindowTitle("History")
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.resize(360, 480)
    view = QUndoView(bench.document.undo_stack)
    view.setEmptyLabel("The beginning")
    view.setObjectName("history")
    view.setSpacing(STEP // 2)
    view.setAccessibleName("Steps of the history")
    buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
    buttons.button(QDialogButtonBox.StandardButton.Close).setIcon(QIcon())  # the style's own is black, also on dark
    buttons.rejected.connect(dialog.close)
    column = QVBoxLayout(dialog)
    column.addWidget(view)
    column.addWidget(buttons)
    dialog.open()
    return dialog


def show_notes(window: QWidget, bench: Workbench) -> QDialog:
    """A user's own words about the project, to read and to change; they go into the bundles that it exports."""
    dialog = QDialog(window)
    dialog.setWindowTitle("Notes")
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.resize(480, 360)
    words = QPlainTextEdit(bench.document.project.notes)
    words.setAccessibleName("Notes")
    words.setPlaceholderText("The sample, where it is from, who photographed it and when…")
    words.setTabChangesFocus(True)
    buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel)
    for button in buttons.buttons():
        button.setIcon(QIcon())  # the style's own is of another style

    def keep() -> None:
        if words.toPlainText() != bench.document.project.notes:
            bench.document.change("Notes", notes=words.toPlainText())
        dialog.close()

    buttons.accepted.connect(keep)
    buttons.rejected.connect(dialog.close)
    column = QVBoxLayout(dialog)
    column.addWidget(words)
    column.addWidget(buttons)
    dialog.open()
    return dialog


def propose_name(project: Project) -> str:
    """A name for a project file, after what it holds."""
    return places.file_name(project.name, places.UNTITLED)

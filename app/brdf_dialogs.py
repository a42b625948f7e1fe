"""Where the BRDF workspace asks for files, and what it puts on the clipboard."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QFileDialog, QWidget

from app import brdf_verbs
from app.comparison import Entry
from app.workbench import Workbench
from engine.brdf.brdf import brdf_to_text

FILES = "Measured reflectance (*.binary *.bsdf *.brdf *.astm *.bin *.dat *.txt *.csv *.exr *.alta);;All files (*)"
TABLES = "MERL (*.binary);;Table of Lightarc (*.exr)"


def browse(parent: QWidget, bench: Workbench) -> None:
    """Open measured reflectance."""
    chosen, _ = QFileDialog.getOpenFileNames(parent, "Open measured reflectance", "", FILES)
    for path in chosen:
        brdf_verbs.open_file(bench, Path(path))


def relocate(parent: QWidget, bench: Workbench, lost: Path) -> None:
    """Ask where a file of the library is now."""
    chosen, _ = QFileDialog.getOpenFileName(parent, f"Where is {lost.name} now?", str(lost.parent), FILES)
    if chosen:
        brdf_verbs.open_file(bench, Path(chosen), instead_of=lost)


def save(parent: QWidget, bench: Workbench, entry: Entry) -> None:
    """Write `entry` as a table where the person says."""
    name = "".join(letter if letter.isalnum() or letter in " -_" else "-" for letter in entry.name)
    chosen, kind = QFileDialog.getSaveFileName(parent, "Save a table", f"{name}.binary", TABLES)
    if chosen:
        path = Path(chosen)
        if path.suffix.lower() not in (".binary", ".exr"):
            path = path.with_name(path.name + (".exr" if "exr" in kind else ".binary"))
        brdf_verbs.save_table(bench, entry.brdf, path)


def copy_text(bench: Workbench, entry: Entry) -> None:
    """Put the text that names a model on the clipboard."""
    words = brdf_to_text(entry.brdf)
    QGuiApplication.clipboard().setText(words)
    bench.said.emit(f"Copied {words}")

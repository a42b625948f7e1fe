"""File dialogs of the BRDF workspace, and the text that it puts on the clipboard."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QFileDialog, QWidget

from app.commands import brdf as commands_brdf
from app.commands.workbench import Workbench
from app.document.comparison import Entry
from engine.brdf.brdf import brdf_to_text
from engine.brdf.written import WrittenBrdf
from engine.storage.readers import dialog_filter, suffixes

TABLES = "MERL (*.binary);;Table of Lightarc (*.exr)"


def _files() -> str:
    return f"{dialog_filter('Measured BRDFs', suffixes('brdf'))};;All files (*)"


def browse(parent: QWidget, bench: Workbench) -> None:
    """Open measured BRDFs."""
    chosen, _ = QFileDialog.getOpenFileNames(parent, "Open measured BRDFs", "", _files())
    for path in chosen:
        commands_brdf.open_file(bench, Path(path))


def relocate(parent: QWidget, bench: Workbench, lost: Path) -> None:
    """Ask where a file of the library is now."""
    chosen, _ = QFileDialog.getOpenFileName(parent, f"Where is {lost.name} now?", str(lost.parent), _files())
    if chosen:
        commands_brdf.open_file(bench, Path(chosen), instead_of=lost)


def save(parent: QWidget, bench: Workbench, entry: Entry) -> None:
    """Write `entry` as a table where the user says."""
    proposed = f"{bench.propose(entry.name, 'brdf')}.binary"
    chosen, kind = QFileDialog.getSaveFileName(parent, "Save a table", proposed, TABLES)
    if chosen:
        path = Path(chosen)
        if path.suffix.lower() not in (".binary", ".exr"):
            path = path.with_name(path.name + (".exr" if "exr" in kind else ".binary"))
        bench.write_into(path.parent)
        commands_brdf.save_table(bench, entry.brdf, path)


def save_plots(parent: QWidget, bench: Workbench, save: Callable[[Path], object]) -> None:
    """Ask for a folder, new or old, for the files of the plots."""
    proposed = bench.propose("brdf-plots")
    chosen, _ = QFileDialog.getSaveFileName(parent, "Save the plots to a folder", str(proposed))
    if chosen:
        bench.write_into(Path(chosen).parent)
        save(Path(chosen))


def copy_text(bench: Workbench, entry: Entry) -> None:
    """Put the text that names a model, or that of a BRDF in GLSL, on the clipboard."""
    is_written = isinstance(entry.brdf, WrittenBrdf)
    words = entry.brdf.text if isinstance(entry.brdf, WrittenBrdf) else brdf_to_text(entry.brdf)
    QGuiApplication.clipboard().setText(words)
    bench.said.emit(f"Copied {f'the text of {entry.name}' if is_written else words}")

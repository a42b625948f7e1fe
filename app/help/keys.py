"""Dialogs of the Help menu: name, version and licences, and the effect of each mouse gesture and each key."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QMessageBox, QPlainTextEdit, QTextBrowser, QVBoxLayout, QWidget

import engine
from app.widgets.language import translate
from app.widgets.panels import button

HELP = """Mouse in the viewport
Left-drag\trotate the model
Middle-drag\tmove
Wheel\tzoom
Ctrl+left-drag\tmove the light, rotate the environment
Arrow keys\trotate the model (Ctrl: move the light, rotate the environment); + and - zoom
Shift or Alt+arrow keys\tmove the model, move the line between both modes
F\tframe the model, fit the image
H, W, G\tbaked light: SH, wavelet, Gaussian
Ctrl+Enter\tbake, or stop baking
M, D, R\tshading map, direct light, reference
Tab\tswap the two modes while both are shown
Ctrl+P\tsave an image (Ctrl+Shift+P: a turntable)
B, E\tboth modes separated by a line, their difference

Photographs and materials
Ctrl+Enter\timport again with changed settings, build the material, make surface maps

Images
Wheel\tzoom under the pointer
1\t100 %
Left, Right\tprevious, next photograph
X, Space\tleave the selected photographs out, or use them again
Ctrl+A, Shift+Up\tselect all, select several
Z\tloupe at 100 % (drag it or press arrow keys; the wheel, + and - magnify)
M\tmark clipped texels
Arrow keys\tmove the chosen point or reflection (Ctrl: finer, Shift: farther)
Ins, Del\tadd, delete a point; Esc leaves
Left, Right, Space\tprevious, next lamp of the dome, select it

BRDFs
Enter\tadd the chosen BRDF of the library
Space, Del\tshow or hide, remove an entry of the list
Ctrl+left-drag\tmove the light of the lobes
L\tlogarithmic or linear
Ctrl+F, Esc\tsearch the library, show all views

Factors
Ctrl+Enter\tbegin a run
Click a point\tpreview and export that number of terms
Space, Del\tpause or go on with, remove a run of the list
Left, Right\tfewer, more terms while on the textures

Export
Ctrl+Enter\twrite the bundle, or the chosen targets

Numbers
Drag a field\tchange it
Type\ta number, a unit, or 2*3.5
Enter, Esc\ttake what is typed, or the value from before, and return to the work area
Ctrl+click\treset"""


#: Third-party notices, which `packaging/notices.py` generates.
NOTICES = Path(__file__).resolve().parents[2] / "resources" / "licences" / "third-party.txt"

#: Width and height of the table of keys, and of the licences.
HELP_PX, LICENCES_PX = (520, 620), (860, 620)


def show_keys(window: QWidget) -> None:
    """Show keys and gestures, in a dialog that is no higher than the smallest window."""
    table = QTextBrowser()
    table.setAccessibleName("Mouse and keyboard")
    table.setHtml(f"<table cellspacing='0' cellpadding='3'>{''.join(map(_row, translate(HELP).splitlines()))}</table>")
    _show_text(window, "Mouse and keyboard", table, HELP_PX)


def show_about(window: QWidget) -> None:
    """Show name and version, with a way to the licences of what Lightarc runs with."""
    box = QMessageBox(QMessageBox.Icon.NoIcon, "About Lightarc", f"Lightarc {engine.__version__}", parent=window)
    box.setInformativeText("Ten photographs of a material under a moving lamp become a material.\nMIT licence.")
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    licences = box.addButton("Third-party licences", QMessageBox.ButtonRole.ActionRole)
    licences.clicked.connect(lambda: show_licences(window))
    close = box.addButton(QMessageBox.StandardButton.Ok)
    box.setDefaultButton(close)
    box.setEscapeButton(close)
    box.open()


def show_licences(window: QWidget) -> None:
    """Show the licences of third-party software."""
    text = QPlainTextEdit()
    text.setReadOnly(True)
    text.setLineWrapMode(QPlainTextEdit.LineWrapMode.NoWrap)
    text.setAccessibleName("Third-party licences")
    text.setPlainText(NOTICES.read_text(encoding="utf-8"))
    _show_text(window, "Third-party licences", text, LICENCES_PX)


def _show_text(window: QWidget, title: str, text: QWidget, size: tuple[int, int]) -> None:
    """Show a text that scrolls, in a dialog with one button."""
    dialog = QDialog(window)
    dialog.setWindowTitle(title)
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.resize(*size)
    close = button("Close", "primary")
    close.clicked.connect(dialog.close)
    column = QVBoxLayout(dialog)
    column.addWidget(text)
    column.addWidget(close, 0, Qt.AlignmentFlag.AlignRight)
    dialog.open()


def _row(line: str) -> str:
    keys, tab, words = line.partition("\t")
    if not tab:
        return f"<tr><td colspan='2'><b>{keys}</b></td></tr>"
    return f"<tr><td>{keys}&nbsp;&nbsp;</td><td>{words}</td></tr>"

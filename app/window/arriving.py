"""Questions about what comes into the window: the user says where it belongs, and settles doubts."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import Qt
from PySide6.QtGui import QIcon
from PySide6.QtWidgets import QMessageBox, QWidget

from app.commands.workbench import Arrival, Workbench
from app.window.failures import sentence
from engine.capture.doubts import Doubtful
from engine.core.escape import escape_controls

#: What the buttons of the question do, in their order.
NEW, REPLACE = (
    "keeps this project as it is and opens {} in one of its own",
    "opens {} in place of what this project has; Undo brings that back",
)


def ask_where(
    window: QWidget, bench: Workbench, begin_anew: Callable[[Callable[[], object]], object], arrival: Arrival
) -> QMessageBox:
    """Ask where a capture or a material belongs, and open it there; nothing where the question is closed.

    `begin_anew` begins a new project and then calls what it is given.
    """
    box = QMessageBox(window)
    box.setIcon(QMessageBox.Icon.Question)
    box.setWindowTitle("Lightarc")
    project = bench.document.project
    has_photographs = project.sources is not None or project.stack is not None or not project.has_map
    box.setText(f"This project has {'photographs' if has_photographs else 'a material'} already.")

    name = escape_controls(arrival.name)

    def anew() -> None:
        begin_anew(arrival.replace)

    choices: dict[str, tuple[str, Callable[[], object]]] = {"New project": (NEW.format(name), anew)}
    if arrival.add is not None:
        choices["Add"] = (arrival.added, arrival.add)
    choices["Replace"] = (REPLACE.format(name), arrival.replace)
    lines = "\n\n".join(f"{label}: {does}." for label, (does, _) in choices.items())
    box.setTextFormat(Qt.TextFormat.PlainText)
    box.setInformativeText(f"Where does {name} belong?\n\n{lines}")
    for label, (_, run) in choices.items():
        made = box.addButton(label, QMessageBox.ButtonRole.ActionRole)
        made.clicked.connect(lambda _checked=False, run=run: run())
        if label == "New project":
            box.setDefaultButton(made)
    box.addButton(QMessageBox.StandardButton.Cancel).setIcon(QIcon())  # the style's own is of another style
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    box.open()
    return box


#: By the consent that is asked for: the button that gives it, and what else a user can do.
CONSENTS = {
    "trust_angles": (
        "Use these angles",
        "Double-click the angles in the list to enter the real ones, measure them on a mirror sphere, or put an .lp "
        "file or capture.toml into the folder of the photographs. If the angles in the list are right, use them.",
    ),
    "leave_out": ("Exclude it", "Enough photographs remain without it. Or bring a whole copy of it."),
    "use_all": (
        "Use it all the same",
        "Enough photographs remain without it. If it is as it should be, it can be used all the same.",
    ),
}


def ask_for_consent(window: QWidget, bench: Workbench, doubt: Doubtful) -> QMessageBox:
    """Say what is doubtful about photographs, and import them all the same where a user says so."""
    words, about = CONSENTS[doubt.consent]
    if doubt.otherwise:
        _, about = CONSENTS[doubt.otherwise]
    box = QMessageBox(window)
    box.setIcon(QMessageBox.Icon.Question)
    box.setWindowTitle("Lightarc")
    box.setTextFormat(Qt.TextFormat.PlainText)
    box.setText(sentence(doubt))
    box.setInformativeText(about)
    agreed = box.addButton(words, QMessageBox.ButtonRole.ActionRole)
    agreed.clicked.connect(lambda: bench.import_all_the_same(doubt.consent))
    if doubt.otherwise:
        other = box.addButton(CONSENTS[doubt.otherwise][0], QMessageBox.ButtonRole.ActionRole)
        other.clicked.connect(lambda: bench.import_all_the_same(doubt.otherwise))
    cancel = box.addButton(QMessageBox.StandardButton.Cancel)
    cancel.setIcon(QIcon())  # the style's own is of another style
    box.setDefaultButton(agreed if doubt.consent == "leave_out" else cancel)  # nothing is lost, and the report says it
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    box.open()
    return box

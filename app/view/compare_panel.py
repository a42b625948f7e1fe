"""The rows of the View workspace that compare two modes: the modes, their arrangement, and their difference."""

from __future__ import annotations

import dataclasses
from typing import Any

from PySide6.QtCore import Signal

from app.document.document import Look, Project
from app.document.modes import mode_of, modes, why_not
from app.view.image_error import ImageError
from app.widgets.controls import ComboBox
from app.widgets.panels import Rows, Segments
from engine.core.figure_text import number

BOUNCES = ((0, "Direct light only"), (1, "1 bounce"), (2, "2 bounces"), (4, "4 bounces"), (8, "8 bounces"))

SHOWN = (
    ("", "Off", "Only the mode above"),
    ("wipe", "Wipe", "Both modes, separated by a line that you drag (B)"),
    ("difference", "Difference", "The luminance of the mode above minus that of the other (E)"),
)


class ComparePanel(Rows):
    """`set_look(words, look)` asks for a change."""

    set_look = Signal(str, object)

    def __init__(self) -> None:
        super().__init__("Compare")
        self.look = Look()
        self.against = ComboBox()
        for mode in modes():
            self.against.addItem(mode.label, mode.value)
        self.against.activated.connect(lambda _index: self.set("Compare with", against=self.against.currentData()))
        self.row("Against", self.against, "The other mode; Tab exchanges the two while both are shown")
        self.shown = Segments(SHOWN)
        self.shown.chosen.connect(lambda value: self.set("Compare", comparing=value))
        self.wide(self.shown)
        self.bounces = ComboBox()
        for count, words in BOUNCES:
            self.bounces.addItem(words, count)
        self.bounces.activated.connect(lambda _index: self.set("Bounces", bounces=self.bounces.currentData()))
        self.row(
            "Reference",
            self.bounces,
            "Path depth of the reference: bounces after the first surface. All errors are measured against it",
        )
        self.error = self.figure(
            "Error", "Relative RMSE of linear radiance against the other, and its 95 % confidence interval"
        )
        self.flip = self.figure("FLIP", "FLIP: difference seen when the two images alternate, from 0 (none) to 1 (all)")
        self.largest = self.figure("Largest", "The largest difference of a channel, in radiance")

    def set(self, words: str, **parts: Any) -> None:
        """Ask for a look with other `parts`."""
        self.set_look.emit(words, dataclasses.replace(self.look, **parts))

    def toggle(self, shown: str) -> None:
        """Show both in this way, or no longer."""
        if self.shown.buttons[shown].isEnabled():
            self.set("Compare", comparing="" if self.look.comparing == shown else shown)

    def show_project(self, project: Project) -> None:
        """The choices of the project; why there is nothing to compare is said where the mouse rests."""
        self.look = project.look
        self.against.setCurrentIndex(max(0, self.against.findData(project.look.against)))
        self.bounces.setCurrentIndex(max(0, self.bounces.findData(project.look.bounces)))
        self.shown.choose(project.look.comparing)
        why = why_not_compared(project)
        for value in ("wipe", "difference"):
            self.shown.disable(value, why)

    def show_error(self, error: ImageError | None) -> None:
        """The figures, or that there are none."""
        self.error.setText(error.text if error else "–")
        self.flip.setText(f"≈ {number(error.flip)}" if error and error.flip is not None else "–")
        self.largest.setText(number(error.max_abs, 3) if error else "–")


def why_not_compared(project: Project) -> str:
    """The reason why the two modes of a project cannot be compared; empty where they can."""
    look = project.look
    if mode_of(look.mode, project) == mode_of(look.against, project):
        other = next((why_not(mode, project) for mode in modes() if mode.value == look.against), "")
        return other or "Both are the same: choose another under Against"
    return ""

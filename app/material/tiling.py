"""A material that repeats: the rows of a panel for its edges, its brightness, and the seams that are left."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal

from app.document.document import Project
from app.widgets.panels import Rows, Segments, enable
from engine.core.figure_text import number
from engine.core.health import Health


class Tiling(QObject):
    """Rows of `section`; `chosen(words, name, value)` asks for a part of the project to be another, in words."""

    chosen = Signal(str, str, bool)

    def __init__(self, section: Rows) -> None:
        super().__init__(section)
        self.edges = Segments(
            (
                ("plain", "As cut", "The whole sample; its edges do not match"),
                ("tileable", "Tileable", "Cut along a path that is hard to see, so that opposite edges match"),
            )
        )
        self.edges.chosen.connect(lambda value: self.chosen.emit("Edges", "tileable", value == "tileable"))
        section.row("Edges", self.edges)
        self.brightness = Segments(
            (
                ("evened", "Evened", "Its slow change over the sample is divided out, which repeated makes bands"),
                ("as it is", "As it is", "As in the photographs"),
            )
        )
        self.brightness.chosen.connect(lambda value: self.chosen.emit("Brightness", "evened", value == "evened"))
        section.row("Brightness", self.brightness)
        self.seams = section.figure("Seams", "Steps across the seams of a tile relative to those inside the sample")

    def show_project(self, project: Project) -> None:
        """Show what is asked for."""
        self.edges.choose("tileable" if project.tileable else "plain")
        self.brightness.choose("evened" if project.evened else "as it is")

    def show_seams(self, health: Health | None) -> None:
        """Show what was made."""
        seams = health.figures.get("seam_error") if health is not None else None
        self.seams.setText("not tileable" if seams is None else f"{number(seams, 3)} × inside")

    def update_buttons(self, project: Project) -> None:
        """Offer what can be chosen."""
        no_stack = "Needs the photographs of the capture" if project.stack is None else ""
        enable(self.edges, no_stack)
        enable(self.brightness, no_stack or ("" if project.tileable else "Only a tile is evened out"))

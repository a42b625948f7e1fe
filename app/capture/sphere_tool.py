"""The mirror sphere corrected by hand: its outline for all photographs, the lamp's reflection in each.

What is found by itself is found again whenever the outline has been moved; the lights follow at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import asin, atan2, degrees
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QHBoxLayout, QVBoxLayout, QWidget

from app.capture.images_kept import Shelf, as_taken
from app.capture.sphere_view import Outline, SphereView, Spot
from app.commands.workbench import Workbench
from app.document.document import Project
from app.document.import_choices import choose, path_of, transfer_of
from app.jobs.newest import Latest
from app.widgets.figure_table import FigureTable
from app.widgets.number_field import NumberField
from app.widgets.panels import button, enable, fill_stacked, text
from app.widgets.theme import PADDING, STEP, role
from engine.capture.lights.file_names import printable
from engine.capture.lights.mirror_sphere import Circle, find_highlights, light_direction
from engine.capture.lights.sources import Sources
from engine.core.errors import InputError, UsageError
from engine.core.figure_text import format_fixed
from engine.core.steps import Step, Steps, part

if TYPE_CHECKING:
    from app.widgets.image_view import ImageView
    from engine.images.decode import TransferChoice

HEADINGS = ("Photograph", "Reflection", "Elevation", "Azimuth", "Source")

#: Words beside the fields, where they are shorter than what the fields are.
SHORT = {"Column": "x", "Row": "y"}

#: Radius of the outline that waits in the middle if no sphere is found, as a share of the shorter side.
WAITING_SHARE = 0.15


@dataclass(frozen=True, eq=False)
class Looked:
    """The inspected photographs: luminance (N, H, W) in the order of `names`, the outline and reflections if found."""

    names: tuple[str, ...]
    luminance: NDArray[np.float32]
    outline: Outline | None
    found: Mapping[str, Spot]


class SphereTool(QWidget):
    """Shows the sphere and the lights that follow, and asks the document to change them. `done`: back.

    `wanted(name)` asks for another photograph, which was picked in the table.
    """

    done = Signal()
    wanted = Signal(str)

    def __init__(self, bench: Workbench, shelf: Shelf) -> None:
        super().__init__()
        self.bench, self.shelf = bench, shelf
        self.name: str | None = None
        self.looked: Looked | None = None
        self._looked_at: tuple[Any, ...] | None = None
        self._found_for: Outline | None = None
        self._near_at_first = True
        self.looking = Latest(bench.jobs, "Looking at the sphere")
        self.view = SphereView()
        self.view.outline_moved.connect(self._outline_moved)
        self.view.highlight_moved.connect(self._highlight_moved)
        self.table = FigureTable("Lights on the sphere", HEADINGS)
        self.table.picked.connect(lambda row: self.wanted.emit(self._names()[row]))
        self.status = text("", "", wrap=True)
        self.fields: dict[str, NumberField] = {}
        for place, (label, low) in enumerate((("Column", 0.0), ("Row", 0.0), ("Radius", 3.0))):
            field = NumberField(100.0, low, 100_000.0, unit="px")
            field.setAccessibleName(f"{label} of the sphere")
            field.setFixedWidth(62)
            field.edited.connect(lambda value, final, place=place: self._figure_edited(place, value, final))
            self.fields[label] = field
        self.again = button("Find again", hint="Undo all moves by hand")
        self.again.clicked.connect(self._find_again)
        self.close_button = button("Done", "primary", hint="Back to the images (Esc)")
        self.close_button.clicked.connect(self.done)
        self._lay_out()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Esc leaves."""
        if event.key() == Qt.Key.Key_Escape:
            self.done.emit()
        else:
            super().keyPressEvent(event)

    @property
    def main_view(self) -> ImageView:
        """The view that the bar above the images acts on."""
        return self.view

    def _lay_out(self) -> None:
        below = role(QWidget(), "panel")
        below.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        column = QVBoxLayout(below)
        column.setContentsMargins(PADDING, 2 * STEP, PADDING, PADDING)
        column.setSpacing(2 * STEP)
        column.addWidget(self.status)
        column.addWidget(self.table, 1)
        foot = QHBoxLayout()
        foot.setSpacing(2 * STEP)
        for label, field in self.fields.items():
            caption = text(SHORT.get(label, label), "secondary")
            caption.setToolTip(f"{label} of the sphere")
            caption.setBuddy(field)
            foot.addWidget(caption)
            foot.addWidget(field)
        foot.addStretch(1)
        foot.addWidget(self.again)
        foot.addWidget(self.close_button)
        column.addLayout(foot)
        fill_stacked(self, self.view, below, [480, 250])

    def show_photograph(self, name: str | None) -> None:
        """Show the sphere in the photograph `name`."""
        self.bench.document.end_gesture()
        self.name = name
        project = self.bench.document.project
        if self.looked is None and not self.looking.busy:
            self._looked_at = None
        path = path_of(project, name)
        self.shelf.drop(self.view)
        self.view.show_image(None)
        if path is not None and project.sources is not None:
            transfer = transfer_of(project.sources, project.import_choices)
            show = lambda: self.show_project(self.bench.document.project)  # noqa: E731
            self.shelf.show(
                self.view, ("taken", path, transfer), "Reading the photograph", lambda: as_taken(path, transfer), show
            )
        self.show_project(project)

    def show_project(self, project: Project) -> None:
        """Show the sphere of `project` and the lights on it; look at the photographs if they are new."""
        sources = project.sources
        if sources is None:
            return
        transfer = transfer_of(sources, project.import_choices)
        if self._looked_at != (sources.photographs, transfer):
            self._looked_at, self.looked, self._found_for = (sources.photographs, transfer), None, None
            self._near_at_first = True
            self.looking.ask(lambda: _look(sources, transfer), self._seen)
        outline, sure = self._outline(project)
        if self._near_at_first and sure and outline is not None and self.view.image is not None:
            self._near_at_first = False
            self.view.look_near(outline)
        highlight = self._highlights(project).get(self.name or "")
        self.view.show_sphere(outline, highlight, sure=sure)
        self._show_figures(project, outline)
        words, look = self._verdict(project, outline)
        self.status.setText(words)
        role(self.status, look)
        moved = project.import_choices.outline is not None or bool(project.import_choices.highlights)
        enable(self.again, "" if moved else "Nothing was moved by hand", "Undo all moves by hand")
        for field in self.fields.values():
            enable(field, "" if outline is not None else "The photographs are being looked at")
        self._find_reflections()

    def _seen(self, looked: Looked) -> None:
        self.looked, self._found_for = looked, None
        self.show_project(self.bench.document.project)

    def _names(self) -> list[str]:
        sources = self.bench.document.project.sources
        return [printable(path) for path in sources.photographs] if sources is not None else []

    def _outline(self, project: Project) -> tuple[Outline | None, bool]:
        """The outline of the next import, else one that waits for being dragged; and whether it is the former."""
        chosen, sources = project.import_choices.outline, project.sources
        if chosen is not None:
            return chosen, True
        if sources is not None and isinstance(sources.sphere, Circle):
            return (sources.sphere.column, sources.sphere.row, sources.sphere.radius), True
        if self.looked is not None and self.looked.outline is not None:
            return self.looked.outline, True
        if self.looked is None:
            return None, False
        height, width = self.looked.luminance.shape[1:]
        return (width / 2, height / 2, WAITING_SHARE * min(height, width)), False

    def _highlights(self, project: Project) -> dict[str, Spot]:
        """The reflections by name: by hand, else stated, else found."""
        sources, by_hand = project.sources, project.import_choices.highlights
        stated = {}
        if sources is not None and sources.highlights_px:
            pairs = zip(self._names(), sources.highlights_px, strict=True)
            stated = {name: spot for name, spot in pairs if spot is not None}
        return {**(self.looked.found if self.looked is not None else {}), **stated, **by_hand}

    def _show_figures(self, project: Project, outline: Outline | None) -> None:
        for field, value in zip(self.fields.values(), outline or (), strict=False):
            field.show_value(round(value, 2))
        spots, by_hand, rows = self._highlights(project), project.import_choices.highlights, []
        for name in self._names():
            spot = spots.get(name)
            light = light_on(outline, spot)
            rows.append(
                (
                    name,
                    f"{format_fixed(spot[0], 1)} / {format_fixed(spot[1], 1)} px" if spot is not None else "–",
                    f"{format_fixed(light[0], 1)}°" if light is not None else "–",
                    f"{format_fixed(light[1], 1)}°" if light is not None else "–",
                    "by hand" if name in by_hand else "found" if spot is not None else "not found",
                )
            )
        names = self._names()
        self.table.show_rows(rows, names.index(self.name) if self.name in names else None)

    def _verdict(self, project: Project, outline: Outline | None) -> tuple[str, str]:
        if outline is None:
            return "Looking for the sphere in the photographs…", "secondary"
        if self.looked is not None and not self._outline(project)[1]:
            return "No sphere was found by itself: drag the circle and its rim onto it.", "warning"
        spots = self._highlights(project)
        lost = [name for name in self._names() if light_on(outline, spots.get(name)) is None]
        if self.looked is not None and lost:
            more = f" and {len(lost) - 2} more" if len(lost) > 2 else ""
            words = f"No light from {', '.join(lost[:2])}{more}: click the lamp's reflection inside the circle."
            return words, "warning"
        words = "Drag the circle and its rim onto the sphere, and the marker onto the lamp in each image."
        return words, "secondary"

    def _outline_moved(self, outline: Outline, final: bool) -> None:
        choose(self.bench.document, "Move the sphere", "sphere", outline=outline, sphere=True)
        if final:
            self.bench.document.end_gesture()

    def _highlight_moved(self, column: float, row: float, final: bool) -> None:
        if self.name is not None:
            now = self.bench.document.project.import_choices.highlights
            highlights = {**now, self.name: (column, row)}
            choose(self.bench.document, "Move the reflection", "highlight", highlights=highlights, sphere=True)
        if final:
            self.bench.document.end_gesture()

    def _figure_edited(self, place: int, value: float, final: bool) -> None:
        outline, _ = self._outline(self.bench.document.project)
        if outline is not None:
            changed = [*outline]
            changed[place] = value
            self._outline_moved((changed[0], changed[1], changed[2]), final)

    def _find_again(self) -> None:
        choose(self.bench.document, "Find the sphere again", outline=None, highlights={})

    def _find_reflections(self) -> None:
        """Find the reflections inside the outline as it is now, unless that was done."""
        outline, sure = self._outline(self.bench.document.project)
        looked = self.looked
        if looked is None or outline is None or not sure or outline == self._found_for:
            return
        self._found_for = outline
        self.looking.ask(lambda: _find_in(looked, outline), self._found)

    def _found(self, looked: Looked) -> None:
        self.looked = looked
        self.show_project(self.bench.document.project)


def light_on(outline: Outline | None, spot: Spot | None) -> tuple[float, float] | None:
    """Elevation and azimuth in degrees of the lamp that is seen at `spot`; None where there is no such lamp."""
    if outline is None or spot is None:
        return None
    try:
        x, y, z = light_direction(Circle(*outline), *spot)
    except UsageError:
        return None
    return degrees(asin(min(1.0, z))), degrees(atan2(y, x)) if z < 1.0 else 0.0


def _look(sources: Sources, transfer: TransferChoice) -> Steps[Looked]:
    """The luminance of all photographs, and the sphere in their mean."""
    yield Step(0.0, "looking at the sphere")
    from engine.capture.lights.sphere_lights import find_outline, luminances

    images = yield from part(luminances(sources, transfer), 0.0, 0.9)
    names = tuple(printable(path) for path in sources.photographs)
    if isinstance(sources.sphere, Circle):
        return Looked(names, images, None, {})
    try:
        found = find_outline(sources, images)
    except InputError:
        return Looked(names, images, None, {})
    return Looked(names, images, (found.column, found.row, found.radius), {})


def _find_in(looked: Looked, outline: Outline) -> Steps[Looked]:
    """The reflections inside `outline`."""
    yield Step(0.0, "looking for the lamp's reflection")
    spots = find_highlights(looked.luminance, Circle(*outline))
    found = {name: spot for name, spot in zip(looked.names, spots, strict=True) if not isinstance(spot, UsageError)}
    return Looked(looked.names, looked.luminance, looked.outline, found)

"""Control points by hand: the same spots marked in the reference photograph and in another, side by side.

A click in one image waits for its counterpart in the other; the pair is one undo step. Both images zoom and move
together, as far as the points, or else the last import, show how they lie on each other.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from PySide6.QtCore import QPointF, Qt, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QStackedWidget, QVBoxLayout, QWidget

from app.capture.images_kept import Shelf, as_taken
from app.capture.marker_view import MarkerView
from app.commands.workbench import Workbench
from app.document.document import Pair, Project
from app.document.import_choices import choose, path_of, points_of, read_stated_points, reference_of, transfer_of
from app.widgets.controls import ComboBox
from app.widgets.figure_table import FigureTable
from app.widgets.panels import button, enable, fill_stacked, text
from app.widgets.theme import PADDING, ROW, STEP, role
from app.widgets.workspace import side_by_side
from engine.capture.lights.file_names import printable
from engine.capture.registration.control_points import (
    MIN_POINTS,
    MarkedMotion,
    choose_marked_kind,
    fit_marked_motion,
    move,
)
from engine.core.figure_text import format_fixed

if TYPE_CHECKING:
    from app.widgets.image_view import ImageView

HEADINGS = ("Point", "In the reference", "In the photograph", "Misses by")

KINDS = {
    "translation": "a shift",
    "euclidean": "a shift and a turn",
    "affine": "an affine motion",
    "homography": "a perspective motion",
}


class PointsTool(QWidget):
    """Shows the points of one photograph and asks the document to change them. `done`: back to the images."""

    done = Signal()

    def __init__(self, bench: Workbench, shelf: Shelf) -> None:
        super().__init__()
        self.bench, self.shelf = bench, shelf
        self.name: str | None = None
        self.current: int | None = None
        self.waiting: tuple[int, float, float] | None = None
        self._following = False
        self.reference = ComboBox()
        self.reference.setAccessibleName("Reference photograph")
        self.reference.setToolTip("The photograph that the others are aligned to; points of another reference go")
        self.reference.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.reference.setMinimumContentsLength(10)
        self.reference.activated.connect(lambda _index: self._reference_chosen(self.reference.currentData()))
        self.caption = text("", "secondary")
        self.views = (MarkerView("Points in the reference"), MarkerView("Points in the photograph"))
        for side, view in enumerate(self.views):
            view.placed.connect(lambda x, y, side=side: self._on_placed(side, x, y))
            view.moved.connect(lambda number, x, y, final, side=side: self._on_moved(side, number, x, y, final))
            view.chosen.connect(self._choose)
            view.zoomed.connect(lambda _zoom, side=side: self._follow(side))
        self.itself = text("", "secondary", wrap=True)
        self.itself.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.itself.setContentsMargins(PADDING, 0, PADDING, 0)
        self.right = QStackedWidget()
        self.right.addWidget(self.views[1])
        self.right.addWidget(self.itself)
        self.table = FigureTable("Control points", HEADINGS)
        self.table.picked.connect(self._choose)
        self.status = text("", "", wrap=True)
        self.add = button("Add a point", hint="In the middle of both images, to be moved from there (Ins)")
        self.delete = button("Delete", hint="The chosen point (Del)")
        self.reset = button("Remove all", hint="The points of all photographs")
        self.close_button = button("Done", "primary", hint="Back to the images (Esc)")
        self._connect()
        self._lay_out()

    @property
    def main_view(self) -> ImageView:
        """The view that the bar above the images acts on."""
        return self.views[0] if self.views[0].hasFocus() else self.views[1]

    def _connect(self) -> None:
        self.add.clicked.connect(self._add_in_the_middle)
        self.delete.clicked.connect(self._delete)
        self.reset.clicked.connect(self._remove_all)
        self.close_button.clicked.connect(self.done)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Handle the keys that images and table leave: Del, Ins and Esc, as the buttons say."""
        keys = {Qt.Key.Key_Delete: self._delete, Qt.Key.Key_Insert: self._add_in_the_middle}
        run = {**keys, Qt.Key.Key_Escape: self._escape}.get(Qt.Key(event.key()))
        if run is None:
            super().keyPressEvent(event)
        else:
            run()

    def _lay_out(self) -> None:
        halves = side_by_side(
            _caption(self.views[0], text("Reference", "secondary"), self.reference),
            _caption(self.right, self.caption),
            stretch=0,
        )
        layout = halves.layout()
        assert isinstance(layout, QHBoxLayout)
        layout.setStretch(1, 1)
        below = role(QWidget(), "panel")
        below.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        column = QVBoxLayout(below)
        column.setContentsMargins(PADDING, 2 * STEP, PADDING, PADDING)
        column.setSpacing(2 * STEP)
        column.addWidget(self.status)
        column.addWidget(self.table, 1)
        foot = QHBoxLayout()
        foot.setSpacing(2 * STEP)
        for widget in (self.add, self.delete, self.reset):
            foot.addWidget(widget)
        foot.addStretch(1)
        foot.addWidget(self.close_button)
        column.addLayout(foot)
        fill_stacked(self, halves, below, [500, 230])

    def show_photograph(self, name: str | None) -> None:
        """Mark points in the photograph `name`."""
        self.bench.document.end_gesture()
        if name != self.name:
            self.name, self.current, self.waiting = name, None, None
        self._load()
        self.show_project(self.bench.document.project)

    def show_project(self, project: Project) -> None:
        """Show the points of `project` in the photograph, and the motion that they give."""
        pairs = self._pairs(project)
        if self.current is not None and self.current >= len(pairs):
            self.current = len(pairs) - 1 if pairs else None
        reference = reference_of(project)
        self._fill_references(project, reference)
        self.caption.setText(self.name or "")
        itself = self.name is not None and self.name == reference
        self.itself.setText(f"{self.name} is the reference. Choose the photograph that is to be moved in the list.")
        self.right.setCurrentIndex(1 if itself else 0)
        self._show_markers(pairs)
        fit = self._fit(project, pairs)
        known = fit is not None and len(pairs) > MIN_POINTS[fit.motion]
        missed = [f"{format_fixed(one, 2)} px" if known else "–" for one in self._measure_misses(project, pairs, fit)]
        self.table.show_rows(
            [
                (
                    f"{at + 1}",
                    *(f"{format_fixed(x, 2)} / {format_fixed(y, 2)} px" for x, y in (pair[:2], pair[2:])),
                    missed[at],
                )
                for at, pair in enumerate(pairs)
            ],
            self.current,
        )
        words, look = self._verdict(project, pairs, fit)
        self.status.setText(words)
        role(self.status, look)
        none = "" if points_of(project) or project.import_choices.reference is not None else "There are no points"
        enable(self.add, "This is the reference itself" if itself else "", "In the middle of both images (Ins)")
        enable(self.delete, "" if self.current is not None else "No point is chosen", "The chosen point (Del)")
        enable(self.reset, none, "The points of all photographs")

    def reload(self) -> None:
        """Load both images anew, as after another choice of the reference."""
        self._load()

    def _load(self) -> None:
        project = self.bench.document.project
        for view, name in zip(self.views, (reference_of(project), self.name), strict=True):
            path = path_of(project, name)
            self.shelf.drop(view)
            view.show_image(None)
            if path is None or project.sources is None or (view is self.views[1] and name == reference_of(project)):
                continue
            transfer = transfer_of(project.sources, project.import_choices)
            make: Any = lambda path=path, transfer=transfer: as_taken(path, transfer, brighten=True)  # noqa: E731
            self.shelf.show(view, ("marked", path, transfer), "Reading the photograph", make)

    def _pairs(self, project: Project) -> tuple[Pair, ...]:
        return points_of(project).get(self.name or "", ())

    def _change(self, words: str, pairs: tuple[Pair, ...], gesture: str = "") -> None:
        """Give the photograph these points, of the reference that is shown."""
        project = self.bench.document.project
        if self.name is None or self.name == reference_of(project):
            return
        points = {**project.import_choices.control_points, self.name: pairs}
        if not pairs and self.name not in read_stated_points(project.sources):
            del points[self.name]
        choose(self.bench.document, words, gesture, control_points=points, reference=reference_of(project))

    def _on_placed(self, side: int, x: float, y: float) -> None:
        """A click: the first half of a pair, or the second in the other image."""
        project = self.bench.document.project
        if self.name == reference_of(project):
            return
        if self.waiting is None or self.waiting[0] == side:
            self.waiting = (side, x, y)
            self.show_project(project)
            self._look_for_counterpart(side, x, y)
            return
        _, first_x, first_y = self.waiting
        self.waiting = None
        self._add((first_x, first_y, x, y) if side else (x, y, first_x, first_y))

    def _add(self, pair: Pair) -> None:
        pairs = self._pairs(self.bench.document.project)
        self.current = len(pairs)
        self._change("Mark a point", (*pairs, pair))

    def _add_in_the_middle(self) -> None:
        left, right = self.views
        project = self.bench.document.project
        if left.image is None or right.image is None or self.name == reference_of(project):
            return
        self.waiting = None
        here = left.held(QPointF(left.width() / 2, left.height() / 2))
        place = right.held(right.on_screen(self._through(project, 0, here)))
        self._add((*here, *place))

    def _on_moved(self, side: int, number: int, x: float, y: float, final: bool) -> None:
        pairs = list(self._pairs(self.bench.document.project))
        if number < len(pairs):
            old = pairs[number]
            pairs[number] = (*old[:2], x, y) if side else (x, y, *old[2:])
            self._change("Move a point", tuple(pairs), "point")
        if final:
            self.bench.document.end_gesture()

    def _choose(self, number: int) -> None:
        self.current = number
        self.show_project(self.bench.document.project)

    def _delete(self) -> None:
        pairs = self._pairs(self.bench.document.project)
        if self.current is not None and self.current < len(pairs):
            self._change("Delete a point", pairs[: self.current] + pairs[self.current + 1 :])

    def _remove_all(self) -> None:
        self.current, self.waiting = None, None
        document = self.bench.document
        none: dict[str, tuple[Pair, ...]] = dict.fromkeys(read_stated_points(document.project.sources), ())
        choose(document, "Remove all points", control_points=none, reference=None)

    def _reference_chosen(self, name: str) -> None:
        """Points in another reference mean nothing in this one, so they go with it."""
        document = self.bench.document
        if name != reference_of(document.project):
            self.current, self.waiting = None, None
            none: dict[str, tuple[Pair, ...]] = dict.fromkeys(read_stated_points(document.project.sources), ())
            choose(document, "Reference photograph", control_points=none, reference=name)

    def _escape(self) -> None:
        """Forget half a pair, or else leave."""
        if self.waiting is None:
            self.done.emit()
            return
        self.waiting = None
        self.show_project(self.bench.document.project)

    def _fill_references(self, project: Project, reference: str | None) -> None:
        names = [printable(path) for path in project.sources.photographs] if project.sources is not None else []
        if [self.reference.itemText(place) for place in range(self.reference.count())] != names:
            self.reference.clear()
            for name in names:
                self.reference.addItem(name, name)
        self.reference.setCurrentIndex(self.reference.findData(reference))

    def _show_markers(self, pairs: tuple[Pair, ...]) -> None:
        for side, view in enumerate(self.views):
            waits = self.waiting[1:] if self.waiting is not None and self.waiting[0] == side else None
            view.show_markers([pair[2:] if side else pair[:2] for pair in pairs], self.current, waits)

    def _kind(self, project: Project) -> str:
        azimuth = project.stack.azimuth if project.stack is not None else None
        if azimuth is None and project.sources is not None:
            azimuth = project.sources.azimuth
        return choose_marked_kind(project.import_choices.motion, azimuth)

    def _fit(self, project: Project, pairs: tuple[Pair, ...]) -> MarkedMotion | None:
        return fit_marked_motion(pairs, self._kind(project)) if pairs else None

    def _measure_misses(self, project: Project, pairs: tuple[Pair, ...], fit: MarkedMotion | None) -> np.ndarray:
        """The distance of each point from its place after the last import, or after the next one."""
        if fit is None:
            return np.zeros(0)
        matrix = _import(project, self.name) if self._has_followed(project, pairs) else fit.matrix
        table = np.asarray(pairs, np.float64)
        missed: np.ndarray = np.hypot(*(move(fit.matrix if matrix is None else matrix, table[:, :2]) - table[:, 2:]).T)
        return missed

    def _has_followed(self, project: Project, pairs: tuple[Pair, ...]) -> bool:
        """True if the last import followed exactly these points."""
        record = project.stack.provenance.get("control_points_px", {}) if project.stack is not None else {}
        followed = record.get(self.name, ())
        return len(followed) == len(pairs) and np.array_equal(np.asarray(followed), np.asarray(pairs))

    def _verdict(self, project: Project, pairs: tuple[Pair, ...], fit: MarkedMotion | None) -> tuple[str, str]:
        """The next step, or the quality of the points; and the look of the sentence."""
        kind = self._kind(project)
        need = MIN_POINTS[kind]
        if self.waiting is not None:
            other = self.name if self.waiting[0] == 0 else reference_of(project)
            return f"Now click the same spot in {other}. Esc forgets it.", ""
        if self.name == reference_of(project):
            return "Points are marked in a photograph and in the reference that it is moved to.", "secondary"
        if fit is None:
            points = "One point gives" if need == 1 else f"{need} points give"
            words = f"Click a spot in one image, then the same spot in the other. {points} {KINDS[kind]}; more of them"
            return f"{words} average out what each misses.", "secondary"
        if fit.motion != kind and len(pairs) < need:
            return f"{len(pairs)} of the {need} points that {KINDS[kind]} needs: so far {KINDS[fit.motion]}.", "warning"
        if fit.motion != kind:
            words = (
                f"These points do not determine {KINDS[kind]}: they lie on one line, too close together, or swapped."
            )
            return f"{words} {KINDS[fit.motion].capitalize()} is used.", "warning"
        done = "Imported" if self._has_followed(project, pairs) else "For the next import"
        if len(pairs) == need:
            return f"{done}: {KINDS[kind]} from {len(pairs)} points, so nothing shows what they miss; add one.", ""
        missed = float(np.sqrt((self._measure_misses(project, pairs, fit) ** 2).mean()))
        return f"{done}: {KINDS[kind]} from {len(pairs)} points, which misses them by {format_fixed(missed, 2)} px.", ""

    def _through(self, project: Project, side: int, place: tuple[float, float]) -> tuple[float, float]:
        """The place in the other image that a place of one image should match."""
        fit = self._fit(project, self._pairs(project))
        last = _import(project, self.name) if _find_alignment(project) == reference_of(project) else None
        matrix = fit.matrix if fit is not None else last if last is not None else np.eye(3)
        there = move(matrix if side == 0 else np.linalg.inv(matrix), np.array([place]))[0]
        return float(there[0]), float(there[1])

    def _follow(self, side: int) -> None:
        """The other image looks at the same spot, as large."""
        one, other = self.views[side], self.views[1 - side]
        if self._following or one.image is None or other.image is None:
            return
        self._following = True
        if one.fitted:
            other.fit()
        else:
            centre = one.centre.x() - 0.5, one.centre.y() - 0.5
            there = self._through(self.bench.document.project, side, centre)
            other.look_through(one.zoom, QPointF(there[0] + 0.5, there[1] + 0.5))
        self._following = False

    def _look_for_counterpart(self, side: int, x: float, y: float) -> None:
        """Bring the spot where the counterpart is expected into the other image, if it is outside."""
        other = self.views[1 - side]
        there = self._through(self.bench.document.project, side, (x, y))
        if other.image is not None and not other.rect().contains(other.on_screen(there).toPoint()):
            other.look_through(other.zoom, QPointF(there[0] + 0.5, there[1] + 0.5))


def _caption(view: QWidget, *caption: QWidget) -> QWidget:
    """An image below its caption."""
    holder = role(QWidget(), "bar")
    holder.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
    column = QVBoxLayout(holder)
    column.setContentsMargins(0, 0, 0, 0)
    column.setSpacing(0)
    head = QWidget()
    head.setFixedHeight(ROW + 2 * STEP)
    row = QHBoxLayout(head)
    row.setContentsMargins(PADDING, 0, PADDING, 0)
    row.setSpacing(2 * STEP)
    for widget in caption:
        row.addWidget(widget)
    row.addStretch(1)
    column.addWidget(head)
    column.addWidget(view, 1)
    return holder


def _find_alignment(project: Project) -> str | None:
    return project.stack.provenance.get("aligned_to") if project.stack is not None else None


def _import(project: Project, name: str | None) -> np.ndarray | None:
    """The matrix by which the last import moved the photograph `name`."""
    recorded = project.stack.provenance.get("photographs", ()) if project.stack is not None else ()
    for one in recorded:
        if one.get("file") == name and len(one.get("alignment_matrix", ())) == 9:
            return np.reshape(np.asarray(one["alignment_matrix"], np.float64), (3, 3))
    return None

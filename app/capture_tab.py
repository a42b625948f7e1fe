"""The Capture workspace: photographs by angle, the big picture, what was measured, and what deserves a look."""

from __future__ import annotations

import dataclasses
from math import hypot
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QHBoxLayout, QSplitter, QVBoxLayout, QWidget

from app import icons
from app.document import Project
from app.framing_view import Corners, FramingView
from app.import_panel import ImportPanel, is_upright
from app.jobs import Job
from app.panels import EmptyState, Panel, Segments, button, enable, side_by_side, text, tool, with_empty_state
from app.photograph_list import PhotographList, Row, file_name
from app.pictures import Picture, photograph, rgb_image
from app.plots import ElevationPlot
from app.report import Report
from app.theme import PADDING, STEP, role
from app.workbench import Workbench
from engine.health import Finding, Health, Verdict
from engine.steps import Step, Steps

LIST_WIDTH = 232
PICTURES_KEPT = 6

ANGLES = {
    "capture.toml": "capture.toml",
    "lp": "light positions",
    "file names": "file names",
    "assumed": "assumed",
    "user": "entered",
}


#: Share of the photograph that a new framing leaves out at each edge.
INSET = 0.1

if TYPE_CHECKING:
    from engine.capture.framing import Framing
    from engine.capture.import_stack import ThumbnailReady


class CaptureTab(QWidget):
    """Shows the capture of the project and asks the workbench to change it."""

    sample_wanted = Signal()
    files_wanted = Signal()

    def __init__(self, bench: Workbench) -> None:
        super().__init__()
        self.bench = bench
        self.current: str | None = None
        self._pictures: dict[tuple[int, str], Picture] = {}
        self._loading: Job | None = None
        self._make_actions()
        self.list = PhotographList()
        self.list.chosen.connect(self._choose)
        self.list.photographs.angle_edited.connect(self._angle_edited)
        self.image = FramingView()
        self.image.corners_moved.connect(self._corners_moved)
        self.image.patch_drawn.connect(lambda patch: self._choose_import("Grey patch", patch=patch))
        self.plot = ElevationPlot()
        self.plot.selected.connect(self.list.choose)
        self.plot.toggled.connect(self._toggle_place)
        self.report = Report()
        self.report.show_source.connect(self._show_source)
        self.empty = self._make_empty()
        self.pages = with_empty_state(self, self.empty, self._make_work())
        bench.document.changed.connect(self._changed)
        bench.partial.connect(self._show_thumbnail)
        bench.jobs.changed.connect(lambda _job: self._update_buttons())
        self._changed(Project(), bench.document.project)

    def _make_actions(self) -> None:
        self.previous = self._action("Previous photograph", "previous", "Left", lambda: self._step(-1))
        self.next = self._action("Next photograph", "next", "Right", lambda: self._step(1))
        self.fit_action = self._action("Fit picture", "fit", "F", lambda: self.fit())
        self.actual = self._action("100 %", "actual-size", "1", lambda: self.image.actual_size())
        self.marks = self._action("Mark clipped texels", "clipped", "M", lambda: self._toggle_marks())
        self.marks.setCheckable(True)
        self.marks.setChecked(True)
        self.exclude = self._action("Exclude photograph", "exclude", "X", lambda: self._toggle_excluded())
        self.exclude.setCheckable(True)

    def _action(self, words: str, icon: str, keys: str, run: Any) -> QAction:
        action = QAction(icons.icon(icon), words, self)
        action.setShortcut(QKeySequence(keys))
        action.setShortcutContext(Qt.ShortcutContext.WidgetWithChildrenShortcut)
        action.setData(icon)
        action.triggered.connect(run)
        self.addAction(action)
        return action

    def _make_empty(self) -> EmptyState:
        return EmptyState(
            "drop",
            "Drop photographs here, or try the sample capture",
            "About ten photographs of a flat sample under a lamp that moves along an arc: RAW, TIFF, PNG, JPEG, EXR "
            "or HDR. Angles are read from capture.toml, an .lp file or the file names.",
            (("Choose photographs…", "", self.files_wanted), ("Try the sample capture", "sample", self.sample_wanted)),
        )

    def _make_work(self) -> QWidget:
        return side_by_side(self._make_left(), self._make_centre(), self._make_right(), stretch=1)

    def _make_left(self) -> QWidget:
        left = role(QWidget(), "panel")
        left.setFixedWidth(LIST_WIDTH)
        column = QVBoxLayout(left)
        column.setContentsMargins(0, PADDING, 0, PADDING)
        column.setSpacing(2 * STEP)
        head = QHBoxLayout()
        head.setContentsMargins(PADDING, 0, PADDING, 0)
        head.addWidget(text("Photographs", "title"))
        head.addStretch(1)
        self.count = text("", "secondary")
        head.addWidget(self.count)
        column.addLayout(head)
        column.addWidget(self.list, 1)
        more = button("Open other photographs…", "link")
        more.clicked.connect(self.files_wanted)
        foot = QHBoxLayout()
        foot.setContentsMargins(PADDING, 0, PADDING, 0)
        foot.addWidget(more)
        column.addLayout(foot)
        return left

    def _make_centre(self) -> QWidget:
        bar = role(QWidget(), "bar")
        bar.setFixedHeight(36)
        row = QHBoxLayout(bar)
        row.setContentsMargins(PADDING - 4, 0, PADDING, 0)
        row.setSpacing(STEP)
        for action in (self.previous, self.next, self.fit_action, self.actual, self.marks, self.exclude):
            row.addWidget(tool(action))
        self.when = Segments(
            (
                (
                    "before",
                    "Before",
                    "The photograph as it was taken, with handles to frame it",
                ),
                ("after", "After", "Calibrated, aligned and framed"),
            )
        )
        self.when.choose("after")
        self.when.chosen.connect(lambda _value: self._load_picture())
        row.addSpacing(2 * STEP)
        row.addWidget(self.when)
        row.addStretch(1)
        self.readout = text("", "secondary")
        self.zoom = text("", "secondary")
        self.zoom.setMinimumWidth(48)
        self.zoom.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        row.addWidget(self.readout)
        row.addSpacing(2 * STEP)
        row.addWidget(self.zoom)
        self.image.pointed.connect(self._show_readout)
        self.image.zoomed.connect(self._show_zoom)
        top = QWidget()
        column = QVBoxLayout(top)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(bar)
        column.addWidget(self.image, 1)
        centre = QSplitter(Qt.Orientation.Vertical)
        centre.setHandleWidth(1)
        centre.addWidget(top)
        centre.addWidget(self.plot)
        centre.setStretchFactor(0, 1)
        centre.setSizes([560, 190])
        centre.setChildrenCollapsible(False)
        return centre

    def _make_right(self) -> QWidget:
        panel = Panel()
        capture = panel.section("Capture")
        self.resolution = capture.figure("Size")
        self.camera = capture.figure("Camera")
        self.angles = capture.figure("Angles", "Where the elevations of the light come from")
        self.angle_words = text("", "warning", wrap=True)
        capture.wide(self.angle_words)
        settings = panel.section("Import")
        self.options = ImportPanel()
        self.options.chosen.connect(lambda words, parts: self._choose_import(words, **parts))
        self.options.framing_wanted.connect(self._frame)
        self.options.patch_wanted.connect(self._draw_patch)
        settings.wide(self.options)
        self.again = button("Import again")
        self.again.clicked.connect(self._import_again)
        settings.wide(self.again)
        report = panel.section("Report")
        report.wide(self.report)
        self.build = button("Build material", "primary")
        self.build.clicked.connect(self.bench.build_material)
        panel.finish(self.build)
        return panel

    def fit(self) -> None:
        """Show the whole picture."""
        self.image.fit()

    def _changed(self, old: Project, new: Project) -> None:
        self.pages.setCurrentIndex(0 if new.sources is None and new.stack is None else 1)
        if new.sources is not old.sources or new.stack is not old.stack:
            self._show_figures(new)
        if (new.stack, new.sources, new.excluded) != (old.stack, old.sources, old.excluded):
            self._show_rows(new)
            self._show_plot()
        if new.stack is not old.stack:
            self._pictures.clear()
            self.image.show_picture(None)
            self._choose(self.list.currentIndex().row())
        self.plot.setVisible(new.stack is not None)
        self._show_choices(new)
        self._update_buttons()

    def _show_rows(self, project: Project) -> None:
        names, angles = _photographs(project)
        health = project.stack.health if project.stack is not None else Health()
        rows = [
            Row(
                name,
                angle,
                *_worst(health, name),
                excluded=name in project.excluded,
                done=project.stack is not None,
            )
            for name, angle in zip(names, angles, strict=True)
        ]
        self.list.photographs.angles_editable = project.sources is not None and project.sources.angle_source in (
            "assumed",
            "user",
            "file names",
        )
        self.list.photographs.show_rows(rows)
        used = len(rows) - len(project.excluded)
        self.count.setText(f"{len(rows)}" if used == len(rows) else f"{used} of {len(rows)}")
        if rows and not self.list.currentIndex().isValid():
            self.list.choose(names.index(self.current) if self.current in names else len(rows) // 2)

    def _show_figures(self, project: Project) -> None:
        stack = project.stack
        self.resolution.setText(
            f"{stack.radiance.shape[2]} × {stack.radiance.shape[1]} px" if stack is not None else "–"
        )
        cameras = stack.provenance.get("cameras") or stack.provenance.get("camera") if stack is not None else None
        camera = ", ".join(map(str, cameras)) if isinstance(cameras, (list, tuple)) else str(cameras or "not recorded")
        self.camera.setText(self.camera.fontMetrics().elidedText(camera, Qt.TextElideMode.ElideRight, 150))
        self.camera.setToolTip(camera)
        source = stack.angle_source if stack is not None else project.sources.angle_source if project.sources else ""
        self.angles.setText(ANGLES.get(source, "–"))
        self.angle_words.setVisible(source == "assumed")
        self.angle_words.setText(
            "No angles were found, so even steps are assumed. Double-click an angle to correct it."
        )
        self.report.show_health(stack.health if stack is not None else None)

    def _show_plot(self) -> None:
        project = self.bench.document.project
        if project.stack is None:
            self.plot.show_means([], [], [], None)
            return
        stack = project.stack
        excluded = [name in project.excluded for name in stack.sources]
        current = stack.sources.index(self.current) if self.current in stack.sources else None
        self.plot.show_means(stack.elevation_deg, stack.mean_radiance, excluded, current)

    def _choose(self, place: int) -> None:
        rows = self.list.photographs.rows
        if not 0 <= place < len(rows):
            self.current = None
            return
        self.current = rows[place].name
        self._show_plot()
        self._update_buttons()
        self._load_picture()

    def _load_picture(self) -> None:
        stack = self.bench.document.project.stack
        if self._loading is not None:
            self.bench.jobs.cancel(self._loading)
            self._loading = None
        if stack is None or self.current not in stack.sources:
            self._show_small()
            return
        place, key = stack.sources.index(self.current), (id(stack), self.current)
        before = self._file_of_current() if self.when.value == "before" else None
        if before is not None:
            self._loading = self.bench.jobs.submit("Reading the photograph", lambda: _as_taken(before), heavy=False)
            self._loading.succeeded.connect(self.image.show_picture)
            self._show_choices(self.bench.document.project)
            return
        self._show_choices(self.bench.document.project)
        if key in self._pictures:
            self.image.show_picture(self._pictures[key])
            return
        self._loading = self.bench.jobs.submit(
            "Preparing the picture", lambda: photograph(stack.radiance[place], stack.saturated[place]), heavy=False
        )
        self._loading.succeeded.connect(lambda picture: self._show_picture(key, picture))

    def _show_picture(self, key: tuple[int, str], picture: Picture) -> None:
        while len(self._pictures) >= PICTURES_KEPT:
            self._pictures.pop(next(iter(self._pictures)))
        self._pictures[key] = picture
        if key[1] == self.current and self.when.value == "after":
            self.image.show_picture(picture)

    def _show_small(self) -> None:
        """Until the import is done, the thumbnail stands for the picture."""
        image = self.list.photographs.thumbnails.get(self.current or "")
        self.image.show_picture(Picture((image,)) if image is not None else None)

    def _show_thumbnail(self, ready: ThumbnailReady) -> None:
        name = file_name(ready.path)
        self.list.photographs.show_thumbnail(name, rgb_image(ready.thumbnail))
        if self.bench.document.project.stack is None:
            names = [row.name for row in self.list.photographs.rows]
            if name in names:
                self.list.choose(names.index(name))
                self._show_small()

    def _show_source(self, name: str) -> None:
        names = [row.name for row in self.list.photographs.rows]
        if name in names:
            self.list.choose(names.index(name))

    def _show_zoom(self, zoom: float) -> None:
        small = self.bench.document.project.stack is None
        self.zoom.setText("" if small else f"{100 * zoom:.0f} %")

    def _show_readout(self, column: int, row: int) -> None:
        stack = self.bench.document.project.stack
        if stack is None or column < 0 or self.current not in stack.sources or self.when.value == "before":
            self.readout.setText("")
            return
        place = stack.sources.index(self.current)
        if column >= stack.radiance.shape[2] or row >= stack.radiance.shape[1]:
            return
        red, green, blue = (float(value) for value in stack.radiance[place, row, column])
        clipped = "  clipped" if stack.saturated[place, row, column] else ""
        self.readout.setText(f"{column}, {row}   {red:.3f}  {green:.3f}  {blue:.3f}{clipped}")

    def _step(self, by: int) -> None:
        place = self.list.currentIndex().row() + by
        if 0 <= place < len(self.list.photographs.rows):
            self.list.choose(place)

    def _toggle_marks(self) -> None:
        self.image.show_marks(self.marks.isChecked())

    def _toggle_excluded(self) -> None:
        if self.current is not None:
            self.bench.set_excluded(self.current, self.current not in self.bench.document.project.excluded)

    def _toggle_place(self, place: int) -> None:
        project = self.bench.document.project
        if project.stack is not None:
            name = project.stack.sources[place]
            self.bench.set_excluded(name, name not in project.excluded)

    def _file_of_current(self) -> Path | None:
        """The file of the photograph on screen, None where the stack was opened without its photographs."""
        sources = self.bench.document.project.sources
        paths = sources.photographs if sources is not None else ()
        return next((path for path in paths if file_name(path) == self.current), None)

    def _show_choices(self, project: Project) -> None:
        """What will be imported, and the handles for it on the photograph as it was taken."""
        choices, before = project.import_choices, self.when.value == "before"
        size = (project.stack.radiance.shape[2], project.stack.radiance.shape[1]) if project.stack is not None else None
        self.options.show_choices(choices, size)
        framing = choices.framing
        self.image.show_corners(
            framing.corners if framing is not None and before else None, upright=is_upright(framing)
        )
        self.image.show_patch(choices.patch if before else None)
        taken = "" if project.sources is not None and project.stack is not None else "Needs the photographs"
        self.when.disable("before", taken)
        if taken:
            self.when.choose("after")
        self.options.disable(taken)

    def _look_before(self) -> None:
        """Show the photograph that the others are aligned to, as it was taken."""
        stack = self.bench.document.project.stack
        names = [row.name for row in self.list.photographs.rows]
        reference = stack.provenance.get("aligned_to") if stack is not None else None
        if self.when.value != "before":
            self.when.choose("before")
            if reference in names and reference != self.current:
                self.list.choose(names.index(str(reference)))
            else:
                self._load_picture()

    def _frame(self, how: str, width_px: int | None) -> None:
        """Begin, change or end a framing: 'all', 'crop' or 'corners'."""
        if how == "all":
            self._choose_import("Whole picture", framing=None)
            return
        self._look_before()
        framing = self.bench.document.project.import_choices.framing
        path = self._file_of_current()
        if path is None:
            return
        job = self.bench.jobs.submit(
            "Looking at the photograph", lambda: _framed(path, framing, how, width_px), heavy=False
        )
        job.succeeded.connect(lambda made: self._choose_import("Frame the picture", framing=made))

    def _corners_moved(self, corners: Corners, final: bool) -> None:
        """Handles were dragged: one step for the whole gesture."""
        from engine.capture.framing import Framing, estimated_aspect

        old = self.bench.document.project.import_choices.framing
        if old is not None and self.image.picture is not None:
            width, height = self.image.picture.size
            width_px, height_px = _natural_size(corners, estimated_aspect(corners, (height, width)), self.image.upright)
            self._choose_import("Frame the picture", "framing", framing=Framing(corners, width_px, height_px))
        if final:
            self.bench.document.end_gesture()

    def _draw_patch(self) -> None:
        self._look_before()
        self.image.draw_patch(True)

    def _choose_import(self, words: str, gesture: str = "", **parts: Any) -> None:
        document = self.bench.document
        choices = dataclasses.replace(document.project.import_choices, **parts)
        if choices != document.project.import_choices:
            document.change(words, gesture=gesture, import_choices=choices)

    def _angle_edited(self, place: int, angle_deg: float) -> None:
        sources = self.bench.document.project.sources
        if sources is None:
            return
        elevation = sources.elevation.copy()
        elevation[place] = np.radians(angle_deg)
        order = np.argsort(elevation, kind="stable")
        changed = dataclasses.replace(
            sources,
            photographs=tuple(sources.photographs[index] for index in order),
            elevation=elevation[order],
            azimuth=None if sources.azimuth is None else sources.azimuth[order],
            exposure_s=tuple(sources.exposure_s[index] for index in order),
            exposures=tuple(sources.exposures[index] for index in order),
            highlights_px=tuple(sources.highlights_px[index] for index in order) if sources.highlights_px else (),
            angle_source="user",
        )
        self.bench.import_photographs(changed, name=self.bench.document.project.name)

    def _import_again(self) -> None:
        sources = self.bench.document.project.sources
        if sources is not None:
            self.when.choose("after")
            self.bench.import_photographs(sources, name=self.bench.document.project.name)

    def _update_buttons(self) -> None:
        project = self.bench.document.project
        enable(self.again, self._why_not_again(project), "Read the photographs with these settings")
        enable(self.build, self._why_not_build(project), "Linearise the photographs into slices and compress them")
        self.build.setText("Rebuild material" if project.has_map else "Build material")
        self.exclude.setEnabled(self.current is not None and project.stack is not None)
        self.exclude.setChecked(self.current in project.excluded)

    def _why_not_again(self, project: Project) -> str:
        if project.sources is None:
            return "There are no photographs to read again"
        if _running(self.bench.importing):
            return "The photographs are being imported"
        return "" if project.import_choices != project.imported_with else "Nothing was changed"

    def _why_not_build(self, project: Project) -> str:
        if project.stack is None:
            return "Waiting for the photographs"
        if _running(self.bench.building):
            return "The material is being built"
        return "" if project.built_from != project.recipe else "The material is up to date"

    def apply_theme(self) -> None:
        """Redraw what does not follow the palette by itself."""
        for action in self.actions():
            action.setIcon(icons.icon(str(action.data())))
        self.empty.apply_theme()
        self.options.fold.apply_theme()
        self.report.show_health(self.report.health)
        self.plot.apply_theme()
        self._show_plot()


def _running(job: Job | None) -> bool:
    return job is not None and not job.over


def _photographs(project: Project) -> tuple[list[str], list[float]]:
    """Names and elevations in degrees, from the stack or else from the sources."""
    if project.stack is not None:
        return list(project.stack.sources), [float(angle) for angle in project.stack.elevation_deg]
    if project.sources is not None:
        angles = [float(angle) for angle in np.degrees(project.sources.elevation)]
        return [file_name(path) for path in project.sources.photographs], angles
    return [], []


def _worst(health: Health, name: str) -> tuple[Verdict, str]:
    findings: list[Finding] = [finding for finding in health.findings if finding.source == name]
    worst = max(findings, key=lambda finding: finding.verdict, default=None)
    return (worst.verdict, worst.text) if worst is not None else (Verdict.GOOD, "")


def _as_taken(path: Path) -> Steps[Picture]:
    yield Step(0.0, "reading the photograph")
    from engine.capture.decode import read_photograph

    return (yield from photograph(read_photograph(path).radiance))


def _framed(path: Path, framing: Framing | None, how: str, width_px: int | None) -> Steps[Framing]:
    """A framing of the photograph to begin with, or `framing` at another width."""
    yield Step(0.0, "reading the photograph")
    from engine.capture.decode import read_photograph
    from engine.capture.framing import Framing

    if framing is not None and is_upright(framing) == (how == "crop"):
        across = width_px or framing.width_px
        return Framing(framing.corners, across, max(1, round(across * framing.height_px / framing.width_px)))
    height, width = read_photograph(path).saturated.shape
    left, top = round(INSET * width), round(INSET * height)
    across, along = width - 2 * left, height - 2 * top
    lean = 0.0 if how == "crop" else 0.25 * left
    low, right, bottom = top - 0.5, left + across - 0.5, top + along - 0.5
    corners = ((left - 0.5 + lean, low), (right - lean, low), (right, bottom), (left - 0.5, bottom))
    return Framing(corners, across, along)


def _natural_size(corners: Corners, aspect: float, upright: bool) -> tuple[int, int]:
    """Width and height in pixels at which nothing of the figure between `corners` is made coarser."""
    sides = [hypot(x1 - x0, y1 - y0) for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True)]
    if upright:
        return max(1, round(sides[0])), max(1, round(sides[1]))
    width = max(sides[0], sides[2], max(sides[1], sides[3]) * aspect)
    return max(1, round(width)), max(1, round(width / aspect))

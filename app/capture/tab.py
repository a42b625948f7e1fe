"""The Capture workspace: photographs by angle, the big image, the measurements, and the findings."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from PySide6.QtCore import QPoint, Qt, Signal
from PySide6.QtGui import QAction, QKeySequence, QShortcut
from PySide6.QtWidgets import QFileDialog, QSplitter, QStackedWidget, QVBoxLayout, QWidget

from app.capture.framing import Corners, FramingView, begin, frame
from app.capture.image_bar import ImageBar
from app.capture.images_kept import Shelf, as_taken, thumbnails
from app.capture.import_panel import is_upright
from app.capture.light_dome import LightDome, lamps_of
from app.capture.loupe import Loupe
from app.capture.panel import CapturePanel, first_to_mark
from app.capture.photograph_list import PhotographColumn, file_name, rows_of
from app.capture.photograph_menu import menu_of
from app.capture.points_tool import PointsTool
from app.capture.sphere_tool import SphereTool
from app.commands.workbench import Workbench
from app.document.document import Project
from app.document.following import Following
from app.document.import_choices import choose, path_of, reference_of, transfer_of, with_angle
from app.jobs.jobs import Job
from app.project.pixels import are_there
from app.widgets import theme
from app.widgets.elevation_plot import ElevationPlot
from app.widgets.empty_state import EmptyState, with_empty_state
from app.widgets.image_view import Image, photograph, rgb_image
from app.widgets.workspace import side_by_side
from engine.capture.lights.light_file import WRITTEN, save_lights
from engine.capture.stack import ImageStack, lights_of
from engine.core.errors import InputError
from engine.core.figure_text import format_fixed
from engine.core.steps import Step, Steps

if TYPE_CHECKING:
    from engine.capture.import_stack import ThumbnailReady


def is_another_capture(old: Project, new: Project) -> bool:
    """True if the photographs of `new` are others than those of `old`."""
    if old.sources is None or new.sources is None:
        return old.sources is not new.sources or (new.sources is None and old.stack is not new.stack)
    return set(old.sources.photographs).isdisjoint(new.sources.photographs)


def _photographs_of(project: Project) -> tuple[Any, ...]:
    """The photographs of a capture, by which it is known again when an undo or a redo brings it back."""
    if project.sources is not None:
        return tuple(project.sources.photographs)
    return tuple(project.stack.sources) if project.stack is not None else ()


LIGHT_FILES = "Lights with intensities (*.lights);;Directions alone (*.lp)"

#: What stands in place of the photographs of a project that keeps none of their pixels.
NOT_IMPORTED = "These photographs are not imported. Import again reads them."


class CaptureTab(QWidget):
    """Shows the capture of the project and asks the workbench to change it.

    Signals
    -------
    pixels_lacked : the current photograph cannot be shown because the pixels of the stack are gone or damaged.
    """

    sample_wanted = Signal()
    files_wanted = Signal()
    pixels_lacked = Signal()

    def __init__(self, bench: Workbench) -> None:
        super().__init__()
        self.bench = bench
        self.current: str | None = None
        self._chosen: dict[tuple[Any, ...], str] = {}
        self.shelf = Shelf(bench.jobs)
        self._make_actions()
        self.photographs = PhotographColumn()
        self.photographs.others_wanted.connect(self.files_wanted)
        self.list = self.photographs.list
        self.list.chosen.connect(self._choose)
        self.list.photographs.angle_edited.connect(self._angle_edited)
        self.list.use_toggled.connect(self._toggle_excluded)
        self.list.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.list.customContextMenuRequested.connect(self._show_menu)
        self.image = FramingView()
        self.loupe = Loupe(self.image)
        self.loupe.closed.connect(self.magnify.trigger)
        self.image.corners_moved.connect(self._corners_moved)
        self.image.length_drawn.connect(lambda ends: self.options.take_length(ends))
        self.image.outline_drawn.connect(lambda outline: self.options.take_outline(outline))
        self.image.patch_drawn.connect(lambda patch: choose(bench.document, "Grey patch", patch=patch))
        self.plot = ElevationPlot()
        self.plot.selected.connect(self.list.choose)
        self.plot.toggled.connect(self._toggle_place)
        self.dome = LightDome()
        self.dome.chosen.connect(self.list.choose)
        self.dome.picked.connect(self.list.pick)
        self.dome.used.connect(self._use_only)
        self.dome.save_wanted.connect(self._ask_for_lights)
        self.list.picked.connect(self._show_selection)
        self._make_tools()
        self.empty = self._make_empty()
        self.pages = with_empty_state(self, self.empty, self._make_work())
        begin = QShortcut(QKeySequence("Ctrl+Return"), self, context=Qt.ShortcutContext.WindowShortcut)
        begin.activated.connect(lambda: self.panel.main_button.click())
        self.following = Following(bench.document, self, self._on_changed)
        bench.partial.connect(self._show_thumbnail)
        bench.jobs.changed.connect(lambda _job: self._update_buttons())
        self._on_changed(Project(), bench.document.project)

    def _make_actions(self) -> None:
        self.previous = self._action("Previous photograph", "previous", "Left", lambda: self.list.step(-1))
        self.next = self._action("Next photograph", "next", "Right", lambda: self.list.step(1))
        self.fit_action = self._action("Fit image", "fit", "F", lambda: self.fit())
        self.actual = self._action("100 %", "actual-size", "1", lambda: self._view().actual_size())
        self.magnify = self._action("Loupe", "loupe", "Z", lambda: self._toggle_loupe())
        self.magnify.setCheckable(True)
        self.marks = self._action("Mark clipped texels", "clipped", "M", lambda: self._toggle_marks())
        self.marks.setCheckable(True)
        self.marks.setChecked(True)
        self.exclude = self._action("Exclude photograph", "exclude", "X", lambda: self._toggle_excluded())
        self.exclude.setCheckable(True)

    def _action(self, words: str, icon: str, keys: str, run: Callable[[], object]) -> QAction:
        action = QAction(theme.icon(icon), words, self)
        action.setShortcut(QKeySequence(keys))
        action.setShortcutContext(Qt.ShortcutContext.WindowShortcut)
        action.setData(icon)
        action.triggered.connect(run)
        self.addAction(action)
        return action

    def _make_tools(self) -> None:
        """The tools that take the place of the image while something is set by hand."""
        self.points = PointsTool(self.bench, self.shelf)
        self.sphere = SphereTool(self.bench, self.shelf)
        self.sphere.wanted.connect(self._show_source)
        for one in (self.points, self.sphere):
            one.done.connect(self.close_tool)
        self.panel = CapturePanel(self.bench)
        self.options, self.again = self.panel.options, self.panel.again
        self.report, self.build = self.panel.report, self.panel.build
        self.options.chosen.connect(lambda words, parts: choose(self.bench.document, words, **parts))
        self.options.framing_wanted.connect(self._frame)
        self.options.patch_wanted.connect(self._draw_patch)
        self.options.length_wanted.connect(self._draw_length)
        self.options.outline_wanted.connect(self._draw_outline)
        self.options.tool_wanted.connect(self.open_tool)
        self.again.clicked.connect(self._import_again)
        self.report.show_source.connect(self._show_source)

    def _make_empty(self) -> EmptyState:
        return EmptyState(
            "drop",
            "Drop photographs here, or try the sample capture",
            "About ten photographs of a flat sample under a lamp that moves along an arc: RAW, TIFF, PNG, JPEG, EXR "
            "or HDR. Angles are read from capture.toml, an .lp file or the file names.",
            (("Choose photographs…", "", self.files_wanted), ("Try the sample capture", "sample", self.sample_wanted)),
        )

    def _make_work(self) -> QWidget:
        return side_by_side(self.photographs, self._make_centre(), self.panel, stretch=1)

    def _make_centre(self) -> QWidget:
        actions = (self.previous, self.next, self.fit_action, self.actual, self.magnify, self.marks, self.exclude)
        self.bar = ImageBar(actions)
        self.when = self.bar.when
        self.when.chosen.connect(lambda _value: self._load_image())
        self.image.pointed.connect(self._show_readout)
        for view in (self.image, *self.points.views, self.sphere.view):
            view.zoomed.connect(self._show_zoom)
        images = QSplitter(Qt.Orientation.Vertical)
        images.setHandleWidth(1)
        images.addWidget(self.image)
        self.lights = side_by_side(self.plot, self.dome, stretch=0)
        images.addWidget(self.lights)
        images.setStretchFactor(0, 1)
        images.setSizes([560, 190])
        images.setChildrenCollapsible(False)
        self.tools = QStackedWidget()
        for page in (images, self.points, self.sphere):
            self.tools.addWidget(page)
        centre = QWidget()
        column = QVBoxLayout(centre)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.bar)
        column.addWidget(self.tools, 1)
        return centre

    def fit(self) -> None:
        """Show the whole image."""
        self._view().fit()

    def open_tool(self, which: str) -> None:
        """Let something be set by hand: 'points' or 'sphere'."""
        project = self.bench.document.project
        self.tools.setCurrentWidget(self.points if which == "points" else self.sphere)
        name = first_to_mark(project, self.current) if which == "points" else self.current
        if name is not None and name != self.current:
            self._show_source(name)
        else:
            self._load_image()
        self._show_choices(project)
        self._view().setFocus()

    def close_tool(self) -> None:
        """Back to the image and the plot."""
        self.tools.setCurrentIndex(0)
        self._load_image()
        self.list.setFocus()

    def _tool(self) -> PointsTool | SphereTool | None:
        """The tool in use, None for the image."""
        return (None, self.points, self.sphere)[self.tools.currentIndex()]

    @property
    def work(self) -> QWidget:
        """The widget that gets the keys once a field is left."""
        return cast(QWidget, self._view())

    def _view(self) -> Any:
        """The image that the bar is about."""
        tool_in_use = self._tool()
        return self.image if tool_in_use is None else tool_in_use.main_view

    def _on_changed(self, old: Project, new: Project) -> None:
        self.pages.setCurrentIndex(0 if new.sources is None and new.stack is None else 1)
        if is_another_capture(old, new):
            chosen = self.current
            self.list.forget()
            if chosen is not None:
                self._chosen[_photographs_of(old)] = chosen
            self.current = self._chosen.get(_photographs_of(new))
            self.list.photographs.thumbnails.clear()
        if new.sources is not old.sources or new.stack is not old.stack:
            self.panel.show_figures(new)
        if (new.stack, new.sources, new.excluded) != (old.stack, old.sources, old.excluded):
            self._show_rows(new)
            self._show_plot()
        if new.sources is not old.sources:
            self.shelf.forget("taken")
            self.shelf.forget("marked")
        if new.stack is not old.stack:
            self.shelf.forget("stack")
            self.image.show_image(None)
            self._choose(self.list.currentIndex().row())
        self.lights.setVisible(new.stack is not None)
        self._show_choices(new)
        self._show_tool(old, new)
        self._update_buttons()
        if new.stack is not old.stack:
            if new.sources is not old.sources:
                self.list.photographs.thumbnails.clear()
            self._bring_thumbnails(new.stack)

    def _show_tool(self, old: Project, new: Project) -> None:
        """Let the tool in use follow the project, and leave it where there is nothing to set by hand."""
        in_use = self._tool()
        if in_use is None:
            return
        if new.sources is None or new.stack is None:
            self.close_tool()
        elif new.sources is not old.sources or reference_of(new) != reference_of(old):
            in_use.show_photograph(self.current)
        else:
            in_use.show_project(new)

    def _show_rows(self, project: Project) -> None:
        rows = rows_of(project)
        names = [row.name for row in rows]
        self.list.photographs.angles_editable = project.sources is not None and project.sources.angle_source in (
            "assumed",
            "user",
            "file names",
        )
        self.photographs.show_rows(rows)
        if rows and not self.list.currentIndex().isValid():
            self.list.choose(names.index(self.current) if self.current in names else len(rows) // 2)

    def _show_plot(self) -> None:
        project = self.bench.document.project
        if project.stack is None:
            self.plot.show_means([], [], [], None)
            self.dome.show_lamps((), None)
            return
        stack = project.stack
        excluded = [name in project.excluded for name in stack.sources]
        current = stack.sources.index(self.current) if self.current in stack.sources else None
        self.plot.show_means(stack.elevation_deg, stack.mean_radiance, excluded, current)
        self.dome.show_lamps(lamps_of(stack, project.excluded), current, self.list.selection)

    def _ask_for_lights(self) -> None:
        """Ask for a file of the lights, whose ending says what it holds."""
        proposed = f"{self.bench.propose('lamps')}.lights"
        chosen, kind = QFileDialog.getSaveFileName(self, "Save the lights", proposed, LIGHT_FILES)
        if chosen:
            path = Path(chosen)
            if path.suffix.lower() not in WRITTEN:
                path = path.with_name(path.name + next(each for each in WRITTEN if f"*{each}" in (kind or "*.lights")))
            self.bench.write_into(path.parent)
            self.save_lights(path)

    def save_lights(self, path: Path) -> Job | None:
        """Write the lights of the stack, as the ending of `path` says, in a job; None without a stack."""
        stack = self.bench.document.project.stack
        if stack is None:
            return None
        job = self.bench.jobs.submit(f"Saving {path.name}", lambda: _write_lights(path, stack), lane="save")
        job.succeeded.connect(self.bench.said.emit)
        return job

    def _choose(self, place: int) -> None:
        rows = self.list.photographs.rows
        if not 0 <= place < len(rows):
            self.current = None
            return
        self.current = rows[place].name
        self._show_plot()
        self._update_buttons()
        self._load_image()

    def _load_image(self) -> None:
        """Show the current photograph where the user is: in the tool in use, else as taken or as imported."""
        self._show_choices(self.bench.document.project)
        in_use = self._tool()
        if in_use is not None:
            in_use.show_photograph(self.current)
            return
        project = self.bench.document.project
        stack, sources = project.stack, project.sources
        if stack is None or self.current not in stack.sources:
            self.shelf.drop(self.image)
            self._show_small()
            return
        before = path_of(project, self.current) if self.when.value == "before" else None
        if before is not None and sources is not None:
            transfer = transfer_of(sources, project.import_choices)
            self.shelf.show(
                self.image, ("taken", before, transfer), "Reading the photograph", lambda: as_taken(before, transfer)
            )
            return
        if not are_there(stack):
            self.shelf.drop(self.image)
            self._show_small()
            self.pixels_lacked.emit()
            return
        place = stack.sources.index(self.current)
        self.shelf.show(
            self.image,
            ("stack", id(stack), self.current),
            "Preparing the image",
            lambda: photograph(stack.radiance[place], stack.saturated[place]),
        )

    def _show_small(self) -> None:
        """Until the import is done, the thumbnail stands for the image."""
        image = self.list.photographs.thumbnails.get(self.current or "")
        self.image.show_image(Image((image,)) if image is not None else None)

    def _show_thumbnail(self, ready: ThumbnailReady) -> None:
        name = file_name(ready.path)
        self.list.photographs.show_thumbnail(name, rgb_image(ready.thumbnail))
        stack = self.bench.document.project.stack
        if stack is not None and name == self.current and not are_there(stack):
            self._show_small()
        if stack is None:
            names = [row.name for row in self.list.photographs.rows]
            if name in names:
                self.list.choose(names.index(name))
                self._show_small()

    def _bring_thumbnails(self, stack: ImageStack | None) -> None:
        """Read thumbnails from a stack that came without its import, as that of an opened project."""
        if stack is None or all(name in self.list.photographs.thumbnails for name in stack.sources):
            return
        if not are_there(stack):
            return  # until they are (`show_again`)

        def show(step: Step) -> None:
            if step.partial is not None and self.bench.document.project.stack is stack:
                name, image = step.partial
                self.list.photographs.show_thumbnail(name, rgb_image(image))

        job = self.bench.jobs.submit("Reading thumbnails", lambda: thumbnails(stack), lane="screen")
        job.progressed.connect(show)

    def show_again(self) -> None:
        """The pixels of the stack had been gone, and are there again."""
        self._bring_thumbnails(self.bench.document.project.stack)
        self._load_image()

    def _show_source(self, name: str) -> None:
        names = [row.name for row in self.list.photographs.rows]
        if name in names:
            self.list.choose(names.index(name))

    def _show_zoom(self, zoom: float) -> None:
        small = self.bench.document.project.stack is None
        self.bar.zoom.setText("" if small else f"{100 * zoom:.0f} %")

    def _show_readout(self, column: int, row: int) -> None:
        stack = self.bench.document.project.stack
        if stack is None or column < 0 or self.current not in stack.sources or self.when.value == "before":
            self.bar.readout.setText("")
            return
        place = stack.sources.index(self.current)
        if column >= stack.radiance.shape[2] or row >= stack.radiance.shape[1]:
            return
        try:
            red, green, blue = (float(value) for value in stack.radiance[place, row, column])
            clipped = "  clipped" if stack.saturated[place, row, column] else ""
        except InputError as error:
            self.bar.readout.setText(error.problem)
            return
        self.bar.readout.setText(
            f"{column}, {row}   {format_fixed(red, 3)}  {format_fixed(green, 3)}  {format_fixed(blue, 3)}{clipped}"
        )

    def _show_menu(self, at: QPoint) -> None:
        menu_of(self, self.bench, self.list, (self.magnify,)).popup(self.list.viewport().mapToGlobal(at))

    def _toggle_loupe(self) -> None:
        if self.magnify.isChecked() and self.image.image is not None:
            self.loupe.open()
        else:
            self.magnify.setChecked(False)
            self.loupe.hide()

    def _toggle_marks(self) -> None:
        self.image.show_marks(self.marks.isChecked())

    def _toggle_excluded(self) -> None:
        """Exclude the photographs that are selected, or include them where the current one is excluded."""
        if self.current is not None:
            names = {self.list.photographs.rows[place].name for place in self.list.selection} | {self.current}
            self.bench.set_excluded(names, self.current not in self.bench.document.project.excluded)

    def _use_only(self, places: list[int]) -> None:
        stack = self.bench.document.project.stack
        if stack is not None:
            self.bench.use_only({stack.sources[place] for place in places})

    def _show_selection(self, places: list[int]) -> None:
        self.dome.show_selection(places)
        names = [self.list.photographs.rows[place].name for place in places]
        self.exclude.setText("Exclude photograph" if len(names) < 2 else f"Exclude {len(names)} photographs")

    def _toggle_place(self, place: int) -> None:
        project = self.bench.document.project
        if project.stack is not None:
            name = project.stack.sources[place]
            self.bench.set_excluded({name}, name not in project.excluded)

    def _show_choices(self, project: Project) -> None:
        """Show the import choices, and their handles on the photograph as it was taken."""
        choices, before = project.import_choices, self.when.value == "before"
        why_not = self.panel.show_choices(project)
        framing = choices.framing
        self.image.show_corners(
            framing.corners if framing is not None and before else None, upright=is_upright(framing)
        )
        self.image.show_patch(choices.patch if before else None)
        self.image.show_outline(choices.outline_px if before else ())
        known = choices.known_length
        self.image.show_length((known[0], known[1], known[2], known[3]) if known is not None and before else None)
        self.when.disable("before", why_not)
        if why_not:
            self.when.choose("after")
        self.when.setVisible(self._tool() is None)
        for action in (self.marks, self.magnify):
            action.setEnabled(self._tool() is None)

    def _look_before(self) -> None:
        """Show the photograph that the others are aligned to, as it was taken."""
        if self._tool() is not None:
            self.close_tool()
        if self.when.value == "before":
            return
        stack = self.bench.document.project.stack
        names = [row.name for row in self.list.photographs.rows]
        reference = stack.provenance.get("aligned_to") if stack is not None else None
        self.when.choose("before")
        if reference in names and reference != self.current:
            self.list.choose(names.index(str(reference)))
        else:
            self._load_image()

    def _frame(self, how: str, width_px: int | None) -> None:
        """Begin, change or end a framing: 'all', 'crop' or 'corners'."""
        if how == "all":
            choose(self.bench.document, "Whole image", framing=None)
            return
        self._look_before()
        project = self.bench.document.project
        framing, path = project.import_choices.framing, path_of(project, self.current)
        if path is None:
            return
        job = self.bench.jobs.submit(
            "Looking at the photograph", lambda: begin(path, framing, how, width_px), lane="open"
        )
        job.succeeded.connect(lambda made: choose(self.bench.document, "Frame the image", framing=made))

    def _corners_moved(self, corners: Corners, final: bool) -> None:
        """Handles were dragged: one step for the whole gesture."""
        document = self.bench.document
        if document.project.import_choices.framing is not None and self.image.image is not None:
            framing = frame(corners, self.image.image.size, upright=self.image.upright)
            choose(document, "Frame the image", "framing", framing=framing)
        if final:
            document.end_gesture()

    def _draw_patch(self) -> None:
        self._look_before()
        self.image.draw_patch(True)

    def _draw_length(self) -> None:
        self._look_before()
        self.image.draw_length(True)

    def _draw_outline(self) -> None:
        self._look_before()
        self.image.draw_outline(True)

    def _angle_edited(self, place: int, elevation_deg: float, azimuth_deg: float | None) -> None:
        sources = self.bench.document.project.sources
        if sources is not None:
            changed = with_angle(sources, place, elevation_deg, azimuth_deg)
            words = f"Angle of {file_name(sources.photographs[place])}"
            self.bench.import_photographs(changed, name=self.bench.document.project.name, words=words)

    def _import_again(self) -> None:
        sources = self.bench.document.project.sources
        if sources is not None:
            self.when.choose("after")
            self.bench.import_photographs(sources, name=self.bench.document.project.name)

    def _update_buttons(self) -> None:
        project = self.bench.document.project
        self.panel.update_buttons(project)
        is_waiting = project.stack is None and self.panel.again.isEnabled()
        self.image.say(NOT_IMPORTED if is_waiting else "")
        self.exclude.setEnabled(self.current is not None and project.stack is not None)
        self.exclude.setChecked(self.current in project.excluded)

    def apply_theme(self) -> None:
        """Redraw what does not follow the palette by itself."""
        for action in self.actions():
            action.setIcon(theme.icon(str(action.data())))
        self.empty.apply_theme()
        self.panel.apply_theme()
        self.plot.apply_theme()
        self.dome.apply_theme()
        self._show_plot()


def _write_lights(path: Path, stack: ImageStack) -> Steps[str]:
    """Write the lights of `stack`; returns a sentence about it."""
    yield Step(0.0, "saving the lights")
    save_lights(path, lights_of(stack))
    return f"Saved {len(stack.sources)} lights as {path.name}"

"""The window: workspaces as tabs, menus, docks, the status bar, and dropped files."""

from __future__ import annotations

import dataclasses
import logging
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

from PySide6.QtCore import QByteArray, QSize, Qt, QTimer, Signal
from PySide6.QtGui import (
    QAction,
    QCloseEvent,
    QDragEnterEvent,
    QDropEvent,
    QKeySequence,
    QResizeEvent,
)
from PySide6.QtWidgets import (
    QApplication,
    QButtonGroup,
    QFileDialog,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QMainWindow,
    QMenu,
    QMenuBar,
    QMessageBox,
    QStackedWidget,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

import engine
from app.brdf.tab import BrdfTab
from app.capture.tab import CaptureTab
from app.commands.workbench import Workbench
from app.docks.accuracy import AccuracyDock
from app.docks.effects import EffectsDock
from app.docks.health import HealthDock
from app.docks.jobs_and_log import DocksOf, JobsDock, LogDock
from app.document.document import Project
from app.export.tab import ExportTab
from app.factor.tab import FactorTab
from app.jobs.jobs import Job
from app.material.tab import MaterialTab
from app.project.places import projects_folder
from app.project.project_file import ENDING
from app.session import settings
from app.session import settings as session_settings
from app.view.error_line import ErrorLine
from app.view.lobe_inspector import LobeInspector
from app.view.tab import ViewTab
from app.widgets import theme
from app.widgets import theme as icons
from app.widgets.image_view import ImageView
from app.widgets.panels import text
from app.widgets.status_bar import StatusBar
from app.widgets.theme import PADDING, STEP, role
from app.window.arriving import ask_for_photographs
from app.window.banner import Banners
from app.window.doings import Doings, show_reports
from app.window.failures import Failures
from app.window.help_table import help_table
from app.window.interrupted import Interrupted
from app.window.naming import Naming
from app.window.projects import Projects, ask_for_place, ask_to_open, proposed_name, show_history
from app.window.recent import Picturing, remembered
from app.window.recent import fill as fill_recent
from app.window.whereabouts import Whereabouts
from engine.core.errors import FileError

log = logging.getLogger(__name__)

#: The workspaces in the order of the work, and what their tabs say.
WORKSPACES = {
    "capture": "Capture",
    "material": "Material",
    "brdf": "BRDF",
    "factor": "Factor",
    "view": "View",
    "export": "Export",
}
SMALLEST = QSize(1120, 700)

#: Areas of the docks. From the width `WIDE` of the window on, those of the View workspace stand right of the picture,
#: unless a person has put one of them elsewhere.
BOTTOM, RIGHT = Qt.DockWidgetArea.BottomDockWidgetArea, Qt.DockWidgetArea.RightDockWidgetArea
WIDE = 1700

#: Across, in pixels, and the share of each of the two along the window.
DOCK_HEIGHT, DOCK_WIDTH, SHARES = 226, 400, (0.42, 0.58)


class MainWindow(QMainWindow):
    """Owns the workbench and everything on screen. `closes`: it has kept its settings and ends its jobs now."""

    closes = Signal()

    def __init__(self, config: Path | None) -> None:
        """`config` is the folder of remembered settings; without it projects are forgotten as well."""
        super().__init__()
        self.config = config
        self.settings = settings.load(config)
        self.setWindowTitle("Lightarc")
        self.setWindowIcon(icons.icon("lightarc", theme.current().accent))
        self.setMinimumSize(SMALLEST)
        self.resize(1280, 800)
        self.setAcceptDrops(True)
        self.setAnimated(False)
        self._has_drawn = False
        self._has_title = False
        self.failures = Failures(self)
        self._session = session_settings.open_session() if config is None else None
        self.bench = Workbench(self._session or projects_folder(), self)
        self.projects = Projects(self.bench, self._session or projects_folder())
        self.banners = Banners()
        self.doings = Doings(self.bench, self)
        self.projects.begin()
        with theme.dressing_at_once():
            self._make_workspaces()
            self._make_docks()
            self._make_actions()
            self._make_top_bar()
            self._make_centre()
        self._connect()
        self._restore_layout()
        self.show_workspace("capture")

    def _make_workspaces(self) -> None:
        self.capture = CaptureTab(self.bench)
        self.material = MaterialTab(self.bench)
        self.brdf = BrdfTab(self.bench)
        self.factor = FactorTab(self.bench)
        self.view = ViewTab(self.bench)
        self.export = ExportTab(self.bench, self.view)
        self.tabs: dict[str, QWidget] = dict(
            zip(
                WORKSPACES,
                (self.capture, self.material, self.brdf, self.factor, self.view, self.export),
                strict=True,
            )
        )
        self.stack = QStackedWidget()
        for tab in self.tabs.values():
            self.stack.addWidget(tab)

    def _make_docks(self) -> None:
        self.jobs_dock = JobsDock(self.bench.jobs, self)
        self.log_dock = LogDock(self)
        self.accuracy_dock = AccuracyDock(self.bench, self.view, self)
        self.effects_dock = EffectsDock(self.bench, self.view, self)
        self.health_dock = HealthDock(self.bench, self.view, self)
        self.lobe_dock = LobeInspector(self.bench, self.view, self)
        self.of_view = DocksOf(self, (self.effects_dock, self.accuracy_dock))
        self.other_docks = (self.health_dock, self.lobe_dock, self.jobs_dock, self.log_dock)
        for dock in (self.effects_dock, self.accuracy_dock, *self.other_docks):
            self.addDockWidget(BOTTOM, dock)
            dock.hide()
        self._place_docks(BOTTOM)
        for dock in self.other_docks:
            dock.toggleViewAction().triggered.connect(lambda shown, dock=dock: dock.raise_() if shown else None)

    def _place_docks(self, area: Qt.DockWidgetArea) -> None:
        """Effects and accuracy beside each other below the picture, or above each other right of it.

        What else lies below shares the place of accuracy: three beside each other are too narrow for their words.
        """
        lying = area == BOTTOM
        first, second = self.effects_dock, self.accuracy_dock
        for dock in (first, second):
            self.addDockWidget(area, dock)
        direction = Qt.Orientation.Horizontal if lying else Qt.Orientation.Vertical
        self.splitDockWidget(first, second, direction)
        others = [dock for dock in self.other_docks if self.dockWidgetArea(dock) == BOTTOM and not dock.isFloating()]
        for before, behind in pairwise([second, *others] if lying else others):
            self.tabifyDockWidget(before, behind)
        self._sized = False
        self._show_docks_of_view()

    def _show_docks_of_view(self) -> None:
        """Show them beside their workspace, at the earliest when its picture is on screen."""
        in_front = self.stack.currentWidget() is self.view
        self.of_view.show(in_front and self._has_drawn)
        if in_front and self._has_drawn:
            QTimer.singleShot(0, self, self._size_docks)

    def _picture_drawn(self) -> None:
        if not self._has_drawn:
            self._has_drawn = True
            QTimer.singleShot(0, self, self._show_docks_of_view)

    def _size_docks(self) -> None:
        """Give the docks of the View workspace their part of the window, once they are on screen for the first time."""
        docks = list(self.of_view.docks)
        if self._sized or not all(dock.isVisible() for dock in docks):
            return
        self._sized = True
        lying = self.dockWidgetArea(docks[0]) == BOTTOM
        along, across = (self.width(), DOCK_HEIGHT) if lying else (self.height(), DOCK_WIDTH)
        sides = (Qt.Orientation.Horizontal, Qt.Orientation.Vertical)
        self.resizeDocks(docks, [round(share * along) for share in SHARES], sides[0 if lying else 1])
        self.resizeDocks(docks, [across] * len(docks), sides[1 if lying else 0])

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        wanted = RIGHT if self.width() >= WIDE else BOTTOM
        now = BOTTOM if wanted == RIGHT else RIGHT
        docks = self.of_view.docks
        if all(self.dockWidgetArea(dock) == now and not dock.isFloating() for dock in docks):
            self._place_docks(wanted)

    def _make_actions(self) -> None:
        undo_stack = self.bench.document.undo_stack
        self.undo = undo_stack.createUndoAction(self, "Undo")
        self.undo.setShortcuts([QKeySequence("Ctrl+Z")])
        self.redo = undo_stack.createRedoAction(self, "Redo")
        self.redo.setShortcuts([QKeySequence("Ctrl+Shift+Z"), QKeySequence("Ctrl+Y")])

    def _make_top_bar(self) -> None:
        bar = role(QWidget(), "bar")
        bar.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        grid = QGridLayout(bar)
        grid.setContentsMargins(PADDING, 0, PADDING, 0)
        grid.setHorizontalSpacing(0)
        self.mark = QLabel()
        self.menu = QMenuBar()
        self._fill_menus()
        left = QHBoxLayout()
        left.setSpacing(2 * STEP)
        left.addWidget(self.mark)
        left.addWidget(text("Lightarc", "title"))
        left.addWidget(self.menu, 0, Qt.AlignmentFlag.AlignVCenter)
        left.addStretch(1)
        self.buttons = QButtonGroup(self)
        middle = QHBoxLayout()
        middle.setSpacing(0)
        for place, (name, words) in enumerate(WORKSPACES.items()):
            button = QToolButton()
            button.setText(words)
            button.setCheckable(True)
            button.setIconSize(QSize(icons.SMALL, icons.SMALL))
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            button.setToolTip(f"{words} (Ctrl+{place + 1})")
            button.clicked.connect(lambda _checked, name=name: self.show_workspace(name))
            role(button, "workspace")
            self.buttons.addButton(button, place)
            middle.addWidget(button)
        self.title = text("", "secondary")
        self.title.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        grid.addLayout(left, 0, 0)
        grid.addLayout(middle, 0, 1)
        grid.addWidget(self.title, 0, 2)
        grid.setColumnStretch(0, 1)
        grid.setColumnStretch(2, 1)
        bar.setFixedHeight(40)
        self.setMenuWidget(bar)

    def _fill_menus(self) -> None:
        file = self.menu.addMenu("&File")
        self._add(file, "New project", "Ctrl+N", self.new)
        self._add(file, "Open project…", "", self.choose_project)
        self._add(file, "Save as…", "Ctrl+Shift+S", self.save_as)
        self._add(file, "Collect…", "", self.collect)
        self._add(file, "Close project", "Ctrl+W", self.new)
        file.addSeparator()
        self._add(file, "Open files…", "Ctrl+O", self.choose_files)
        self._add(file, "Open folder…", "Ctrl+Shift+O", self.choose_folder)
        self.recent = file.addMenu("Open recent")
        self.recent.aboutToShow.connect(self._fill_recent)
        self._add(file, "Sample capture", "", self.bench.open_sample)
        file.addSeparator()
        self._add(file, "Export bundle…", "Ctrl+E", lambda: self.show_workspace("export"))
        file.addSeparator()
        self._add(file, "Quit", "Ctrl+Q", self.close)
        edit = self.menu.addMenu("&Edit")
        edit.addAction(self.undo)
        edit.addAction(self.redo)
        self._add(edit, "History…", "", lambda: show_history(self, self.bench))
        view = self.menu.addMenu("&View")
        view.setToolTipsVisible(True)
        for place, (name, words) in enumerate(WORKSPACES.items()):
            self._add(view, words, f"Ctrl+{place + 1}", partial(self.show_workspace, name))
        view.addSeparator()
        self._add(view, "Dark theme", "", lambda: self.set_theme("dark"))
        self._add(view, "Light theme", "", lambda: self.set_theme("light"))
        view.addSeparator()
        self.measure = self._add(view, "Error of the picture", "", self._measure_or_not)
        self.measure.setCheckable(True)
        self.measure.setChecked(self.settings.measure_error)
        self.measure.setToolTip("Compare the picture of the View workspace with a reference, while no other job runs")
        self.view.pictures.measure(self.settings.measure_error)
        view.addSeparator()
        for action in self.of_view.actions:
            view.addAction(action)
        view.addAction(self.lobe_dock.toggleViewAction())
        view.addAction(self.health_dock.toggleViewAction())
        view.addAction(self.jobs_dock.toggleViewAction())
        view.addAction(self.log_dock.toggleViewAction())
        aid = self.menu.addMenu("&Help")
        self._add(aid, "Mouse and keyboard", "F1", self.show_help)
        self._add(aid, "Self-test", "", self.self_test)
        self._add(aid, "Crash reports…", "", self._show_reports)
        self._add(aid, "About Lightarc", "", self.show_about)

    def _add(self, menu: QMenu, words: str, keys: str, run: Callable[[], object]) -> QAction:
        action = menu.addAction(words)
        action.setShortcut(QKeySequence(keys))
        action.triggered.connect(lambda _checked=False: run())
        return action

    def _make_centre(self) -> None:
        self.status = StatusBar(self.bench.jobs)
        self.whereabouts = Whereabouts(self.bench, self.projects, self.banners)
        self.picturing = Picturing(self.bench, self.projects)
        self.naming = Naming(self.projects, self.banners, self.save_as)
        self.interrupted = Interrupted(self.projects, self.banners, self._ways_to_go_on())
        centre = QWidget()
        column = QVBoxLayout(centre)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(1)
        column.addWidget(self.banners)
        column.addWidget(self.stack, 1)
        self.setCentralWidget(centre)
        bottom = self.statusBar()
        bottom.setSizeGripEnabled(False)
        bottom.setContentsMargins(0, 0, 0, 0)
        bottom.addWidget(self.status, 1)
        self._tint()

    def _connect(self) -> None:
        bench = self.bench
        bench.document.changed.connect(self._changed)
        self.projects.changed.connect(self._show_title)
        self.projects.changed.connect(self._remember_work)
        self.projects.opened.connect(self._remember)
        self.projects.switched.connect(lambda: self.export.offer(self.projects.shown_name))
        bench.arrived.connect(self._photographs_arrived)
        bench.jobs.failed.connect(self._job_failed)
        bench.said.connect(self.status.say)
        bench.wanted.connect(self.show_workspace)
        self.status.health_clicked.connect(self._show_health)
        self.health_dock.reported.connect(self.status.show_health)
        self.view.viewport.broken.connect(lambda error: self.failures.report("The model cannot be drawn", error))
        self.brdf.broken.connect(lambda error: self.failures.report("The sphere cannot be drawn", error))
        self.factor.broken.connect(lambda error: self.failures.report("The preview cannot be drawn", error))
        for drawing in (self.view, self.brdf, self.factor):
            drawing.drawn.connect(self.status.show_frame_time)
        self.view.drawn.connect(lambda _seconds: self._picture_drawn())
        self.error_line = ErrorLine(self.status, self.view)
        for tab in (self.capture, self.material, self.export):
            tab.sample_wanted.connect(bench.open_sample)
        self.capture.files_wanted.connect(self.choose_folder)
        for tab in (self.material, self.export):
            tab.capture_wanted.connect(lambda: self.show_workspace("capture"))
        self._changed(Project(), bench.document.project)

    def show_workspace(self, name: str) -> None:
        """Bring the workspace `name` to the front."""
        self.stack.setCurrentWidget(self.tabs[name])
        self._show_docks_of_view()
        self.buttons.button(list(WORKSPACES).index(name)).setChecked(True)
        self.status.show_frame_time(None)
        self.error_line.refresh()

    def _ways_to_go_on(self) -> dict[str, Callable[[Mapping[str, Any]], object]]:
        """Functions that go on with an interrupted job, by the kind of the job."""

        def bake(again: Mapping[str, Any]) -> None:
            self.show_workspace("view")
            self.view.bake_again(str(again["method"]))

        def factor(again: Mapping[str, Any]) -> None:
            self.show_workspace("factor")
            self.factor.runs.go_on(int(again["number"]))

        def read(again: Mapping[str, Any]) -> None:
            sources = self.bench.document.project.sources
            self.show_workspace("capture")
            if sources is not None:
                self.bench.import_photographs(sources, name=str(again["name"]))

        return {"bake": bake, "factor": factor, "import": read, "build": lambda _again: self.bench.build_material()}

    def open(self, paths: Sequence[Path]) -> None:
        """Open `paths` by their content, and remember them."""
        if not paths:
            return
        project = next((path for path in paths if path.suffix.lower() == ENDING), None)
        if project is not None:
            self.open_project(project)
            paths = [path for path in paths if path != project]
            if not paths:
                return
        self.bench.open(paths, lighting=self.stack.currentWidget() is self.view)
        self._remember(paths[0] if len(paths) == 1 else paths[0].parent, paths[0].parent)

    def _photographs_arrived(self, paths: Sequence[Path]) -> None:
        ask_for_photographs(self, self.bench, self.new, paths)

    def new(self) -> None:
        """Begin a new project; the one that was open stays on disk."""
        self.projects.begin()
        self.show_workspace("capture")

    def open_project(self, path: Path) -> None:
        """Open a project in place of this one, which stays on disk."""
        try:
            self.projects.open(path)
        except FileError as error:
            self.failures.report("The project cannot be opened", error)

    def choose_project(self) -> None:
        """Ask for a project and open it."""
        ask_to_open(self, self.open_project, self.settings.last_folder or str(self.projects.folder))

    def save_as(self) -> None:
        """Ask for a place, and go on in a copy of the project there."""
        self._written_to("Save as", self.projects.copy_to)

    def collect(self) -> None:
        """Ask for a place, and write a copy there that holds its photographs."""
        self._written_to("Collect", self.projects.collect_to)

    def _written_to(self, title: str, write: Callable[[Path], None]) -> None:
        folder = Path(self.settings.last_folder or Path.home())
        path = ask_for_place(self, title, folder / f"{proposed_name(self.bench.document.project)}{ENDING}")
        if path is not None:
            try:
                write(path)
            except FileError as error:
                self.failures.report("The project cannot be written", error)

    def _remember(self, path: Path, folder: Path | None = None) -> None:
        self.settings = remembered(self.settings, self.config, path, folder or path.parent)

    def _remember_work(self) -> None:
        """Remember the open project as soon as there is work in it."""
        path = self.projects.path
        if self.settings.recent[:1] != (str(path),) and self.projects.is_saved and self.projects.is_worth_keeping():
            self._remember(path, Path(self.settings.last_folder or path.parent))

    def choose_files(self) -> None:
        """Ask for photographs, a mesh, measured BRDFs or a bundle."""
        chosen, _ = QFileDialog.getOpenFileNames(self, "Open", self.settings.last_folder)
        self.open([Path(path) for path in chosen])

    def choose_folder(self) -> None:
        """Ask for a folder of photographs."""
        chosen = QFileDialog.getExistingDirectory(self, "Folder of photographs", self.settings.last_folder)
        self.open([Path(chosen)] if chosen else [])

    def set_theme(self, name: str) -> None:
        """Dress everything in 'dark' or 'light'."""
        application = QApplication.instance()
        assert isinstance(application, QApplication)
        theme.apply(application, name)
        self.settings = dataclasses.replace(self.settings, theme=name)
        self._tint()

    def _measure_or_not(self) -> None:
        """Work out the error of the picture on screen in the background, or leave it."""
        self.settings = dataclasses.replace(self.settings, measure_error=self.measure.isChecked())
        self.view.pictures.measure(self.measure.isChecked())
        self.error_line.refresh()

    def show_help(self) -> None:
        """Keys and gestures."""
        box = QMessageBox(QMessageBox.Icon.NoIcon, "Mouse and keyboard", "Mouse and keyboard", parent=self)
        box.setInformativeText(help_table())
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.open()

    def self_test(self) -> None:
        """Try the hard cases of the numerics on this machine, and show how they end."""
        self._show_health()
        if self.health_dock.job is None:
            self.health_dock.test_or_stop()

    def _show_reports(self) -> None:
        try:
            show_reports()
        except FileError as error:
            self.failures.report("The crash reports cannot be shown", error)

    def show_about(self) -> None:
        """Name and version."""
        box = QMessageBox(QMessageBox.Icon.NoIcon, "About Lightarc", f"Lightarc {engine.__version__}", parent=self)
        box.setInformativeText("Ten photographs of a material under a moving lamp become a material.\nMIT licence.")
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.open()

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        if event.mimeData().hasUrls():
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        paths = [Path(url.toLocalFile()) for url in event.mimeData().urls() if url.isLocalFile()]
        event.acceptProposedAction()
        self.open(paths)

    def closeEvent(self, event: QCloseEvent) -> None:
        self._keep_settings()
        self.hide()
        self.projects.write()
        self.closes.emit()
        self.bench.jobs.close()
        self.projects.finish()
        self.log_dock.disconnect_log()
        self.doings.close()
        if self._session is not None:
            session_settings.close_session(self._session)
        event.accept()

    def _changed(self, _old: Project, new: Project) -> None:
        shown = new.has_map or new.stack is not None
        self.status.show_health(self.health_dock.health)
        power_law = new.material.power_law
        self.status.show_error(*((power_law.rms, power_law.r_max) if power_law is not None else (None,)))
        self._has_title = shown or new.sources is not None
        self._show_title()

    def _show_title(self) -> None:
        """Name of the project, and whether it is on disk; what keeps it from there is said until it is mended."""
        projects, name = self.projects, self.projects.shown_name
        state = "read-only" if projects.is_read_only else "not saved" if projects.problem else ""
        self.title.setText(" – ".join(filter(None, [name if self._has_title else "", state])))
        self.title.setToolTip(projects.problem or str(projects.path))
        self.setWindowTitle(f"{name} – Lightarc" if self._has_title else "Lightarc")
        elsewhere = ("Save elsewhere…", self.save_as)
        words = f"{projects.problem} Everything is kept in memory, and written as soon as that works."
        self.banners.say("saving", words if projects.problem else "", elsewhere)
        words = f"{projects.path.name} {projects.why_read_only}. Changes in this window are not kept in it."
        self.banners.say("read-only", words if projects.is_read_only else "", ("Save as…", self.save_as))

    def _show_health(self) -> None:
        self.health_dock.show()
        self.health_dock.raise_()

    def _job_failed(self, job: Job, error: BaseException) -> None:
        self.failures.report(f"{job.title} did not work", error)

    def _fill_recent(self) -> None:
        fill_recent(self.recent, self.settings.recent, lambda path: self.open([path]))

    def _tint(self) -> None:
        colours = theme.current()
        self.mark.setPixmap(icons.pixmap("lightarc", 20, colours.accent, self.devicePixelRatioF()))
        for place, name in enumerate(WORKSPACES):
            self.buttons.button(place).setIcon(icons.icon(name))
        for tab in (self.capture, self.material, self.brdf, self.factor, self.view, self.export):
            tab.apply_theme()
        self.status.apply_theme()
        for dock in (self.effects_dock, self.accuracy_dock, self.health_dock, self.lobe_dock):
            dock.apply_theme()
        self._changed(Project(), self.bench.document.project)
        for picture in self.findChildren(ImageView):
            picture.update()

    def _restore_layout(self) -> None:
        if self.settings.geometry:
            self.restoreGeometry(QByteArray(bytes.fromhex(self.settings.geometry)))
        if self.settings.layout:
            self._sized = self.restoreState(QByteArray(bytes.fromhex(self.settings.layout)))
        self.of_view.close(self.settings.closed_docks)

    def _keep_settings(self) -> None:
        kept = dataclasses.replace(
            self.settings,
            recent=settings.load(self.config).recent if self.config is not None else self.settings.recent,
            geometry=bytes(self.saveGeometry().data()).hex(),
            layout=bytes(self.saveState().data()).hex(),
            closed_docks=self.of_view.closed,
        )
        settings.save(kept, self.config)

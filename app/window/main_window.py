"""The window: the workspaces under one bar, their docks, and all that connects them with the project."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from PySide6.QtCore import QByteArray, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QCloseEvent, QCursor, QDragEnterEvent, QDropEvent, QKeyEvent, QResizeEvent
from PySide6.QtWidgets import QApplication, QMainWindow, QVBoxLayout, QWidget

from app.batch.panel import BatchDialog
from app.capture.tab import CaptureTab
from app.commands.workbench import Workbench
from app.docks.arrangement import Docks
from app.document.document import Look, Project
from app.export.tab import ExportTab
from app.help.keys import show_about, show_keys
from app.help.manual import show_for_pointer, show_help
from app.help.mode_chooser import ModeChooser
from app.help.tour import Tour, first_hints
from app.jobs.jobs import NICENESS, Job
from app.process import crash
from app.process.packages import LOADING, load_modules, load_shared
from app.project.places import projects_folder
from app.session.settings import NUMBERS, Remembered, close_session, open_session
from app.start.examples import EXAMPLES
from app.view.error_line import ErrorLine
from app.view.tab import ViewTab
from app.widgets import language, theme
from app.widgets.image_view import ImageView
from app.widgets.panels import Pages
from app.widgets.status_bar import StatusBar
from app.window.arriving import ask_for_consent
from app.window.banner import Banners, short_path
from app.window.dialogs import show_history
from app.window.doings import Doings, show_reports
from app.window.failures import Failures
from app.window.files import Files, local_path
from app.window.focus import FieldKeys, text_field
from app.window.interrupted import Interrupted
from app.window.menus import Menus
from app.window.naming import Naming
from app.window.preferences import Preferences
from app.window.projects import Projects
from app.window.recent import Picturing
from app.window.restoring import Restoring
from app.window.starting import Starting
from app.window.top_bar import WORKSPACES, TopBar
from app.window.whereabouts import Whereabouts
from engine.capture.doubts import Doubtful
from engine.core.colour import Operator
from engine.core.errors import FileError
from engine.core.escape import escape_controls
from engine.core.figure_text import write_with
from engine.storage.untrusted import expect

if TYPE_CHECKING:
    from app.brdf.tab import BrdfTab
    from app.factor.tab import FactorTab
    from app.material.tab import MaterialTab
    from app.watch.panel import WatchDialog

#: From one step of making workspaces to the next.
BETWEEN_MS = 5

#: Libraries and modules of the workspaces behind it, which load in 0.4 s.
LIBRARIES = (
    "engine.gl.scene_renderer",
    "pyqtgraph",
    "app.material.tab",
    "app.brdf.tab",
    "app.factor.tab",
    "app.export.tab",
)

#: The decoder of photographs and of notes beside them, whose process starts in 0.7 s and takes 140 MB.
PHOTOGRAPHS = "engine.capture.photograph.decode"

#: Preferences that hold later, and what is said of them.
AT_NEXT_START = {
    "threads": "Lightarc uses this number of CPUs from its next start on",
    "language": "Lightarc uses this language from its next start on",
    "graphics": "Lightarc uses this graphics device from its next start on",
}

#: Drawings of workspaces beside the model.
DRAWN = {"brdf": "The sphere", "factor": "The preview"}

#: Said at the start after a crash.
CRASHED = "Lightarc crashed the last time. A report says where; please send it to the developers."

FIRST, SMALLEST = QSize(1280, 800), QSize(1024, 660)

#: Pixels that the frame around a window takes off the height of a screen, at most.
FRAME = 40


def first_size(screen: QSize) -> QSize:
    """The size of a window that nobody has sized yet: with its frame on a `screen` that is large enough for one."""
    return FIRST.boundedTo(screen - QSize(0, FRAME)).expandedTo(SMALLEST)


def load_libraries() -> None:
    """Load what the workspaces behind the one in front need; the process for photographs loads beside it."""
    expect(PHOTOGRAPHS, NICENESS)
    load_modules(LIBRARIES)


def load_for_work() -> None:
    """Load what nearly every job needs, in 0.8 s, and prepare reports of crashes for libraries written in C."""
    with LOADING:
        load_shared()
        crash.with_native_stack()


def failed_title(job: Job, error: BaseException) -> str:
    """Title of the dialog about a job that did not succeed: the file where a job opens or saves one."""
    verbs = {"open": "open", "save": "save"}
    if isinstance(error, FileError) and job.lane in verbs:
        return f'Couldn\'t {verbs[job.lane]} "{Path(error.path).name}"'
    return f"{job.title} failed"


class MainWindow(QMainWindow):
    """Owns the workbench and everything on screen. `closes`: it has kept its settings and ends its jobs now.

    Workspaces that are not in front at the start, and the libraries that they need, come one after the other once work
    announces itself (`expect_work`), in steps that nobody notices; one that is asked for before is made at once. `tabs`
    are those that are there.
    """

    closes = Signal()

    def __init__(self, config: Path | None) -> None:
        """`config` is the folder of remembered settings; without it projects are forgotten as well."""
        super().__init__()
        self.settings = Remembered(config)
        self.setWindowTitle("Lightarc")
        self.setWindowIcon(theme.icon("lightarc", theme.current().accent))
        self.setMinimumSize(SMALLEST)
        self.resize(FIRST)
        self.setAcceptDrops(True)
        self.setAnimated(False)
        self._has_title = self._is_closed = self._expects_work = False
        self._batch: BatchDialog | None = None
        self._watch: WatchDialog | None = None
        self._making: dict[str, Iterator[None]] = {}
        self._dressing: theme.Dressing | None = None
        self._dressing_steps: Generator[None] | None = None
        self._untinted: list[Any] = []
        self._behind = self._make_behind()
        self.failures = Failures(self)
        self._session = open_session() if config is None else None
        self.bench = Workbench(self._session or projects_folder(), self)
        self.projects = Projects(self.bench, self._session or projects_folder())
        self.banners = Banners()
        self.doings = Doings(self.bench, self)
        self.projects.begin()
        with theme.dressing_at_once():
            self._make_workspaces()
            self.docks = Docks(self, self.bench, self.view)
            self._make_top_bar()
            self._make_centre()
        self.field_keys = FieldKeys(self, self._focus_on_work)
        self._connect()
        self._take_preferences()
        self._restore_layout()
        self.show_workspace("capture")

    def _make_workspaces(self) -> None:
        self.capture, self.view = CaptureTab(self.bench), ViewTab(self.bench)
        self.tabs: dict[str, Any] = {"capture": self.capture, "view": self.view}
        self.stack = Pages()
        for name in WORKSPACES:
            self.stack.addWidget(self.tabs.get(name) or QWidget())
        self.view.images.measure(self.settings.now.measure_error)

    @property
    def material(self) -> MaterialTab:
        return cast("MaterialTab", self._whole("material"))

    @property
    def brdf(self) -> BrdfTab:
        return cast("BrdfTab", self._whole("brdf"))

    @property
    def factor(self) -> FactorTab:
        return cast("FactorTab", self._whole("factor"))

    @property
    def export(self) -> ExportTab:
        return cast("ExportTab", self._whole("export"))

    @property
    def is_whole(self) -> bool:
        """True once all workspaces are there."""
        return len(self.tabs) == len(WORKSPACES)

    def _whole(self, name: str) -> Any:
        """The workspace `name`; what of it is not there yet is made now."""
        if name not in self.tabs:
            load_modules([f"app.{name}.tab"])
        for _ in self._steps(name):
            pass
        return self.tabs[name]

    def _steps(self, name: str) -> Iterator[None]:
        """The steps that are left until the workspace `name` is there."""
        makers = {
            "material": self._make_material,
            "brdf": self._make_brdf,
            "factor": self._make_factor,
            "export": self._make_export,
        }
        if name not in self._making:
            self._making[name] = makers[name]()
        return self._making[name]

    def _make_material(self) -> Iterator[None]:
        from app.material.tab import MaterialTab

        yield from self._fill("material", MaterialTab(self.bench))

    def _make_brdf(self) -> Iterator[None]:
        from app.brdf.tab import BrdfTab

        yield from self._fill("brdf", BrdfTab(self.bench))

    def _make_factor(self) -> Iterator[None]:
        from app.factor.tab import FactorTab

        yield from self._fill("factor", FactorTab(self.bench))

    def _make_export(self) -> Iterator[None]:
        tab = ExportTab(self.bench, self.view)
        yield from self._fill("export", tab)
        tab.elsewhere.measure_in(self.settings.now.unit)
        tab.offer(self.projects.shown_name)
        self.projects.switched.connect(lambda: tab.offer(self.projects.shown_name))

    def _fill(self, name: str, tab: Any) -> Iterator[None]:
        """Put a workspace in its place in the stack and fill it."""
        at = list(WORKSPACES).index(name)
        empty = cast(QWidget, self.stack.widget(at))
        self.stack.removeWidget(empty)
        empty.deleteLater()
        self.stack.insertWidget(at, tab)
        yield
        yield from tab.fill()
        yield
        self._connect_workspace(name, tab)
        tab.apply_theme()
        self.tabs[name] = tab

    def _connect_workspace(self, name: str, tab: Any) -> None:
        """Connect the signals that a workspace has."""
        broken = f"{DRAWN.get(name, 'The image')} cannot be drawn"
        for signal, slot in (
            ("drawn", self.status.show_frame_time),
            ("sample_wanted", lambda: self.starting.open_example(EXAMPLES[0], name)),
            ("capture_wanted", lambda: self.show_workspace("capture")),
            ("broken", lambda error: self.failures.report(broken, error)),
        ):
            if hasattr(tab, signal):
                getattr(tab, signal).connect(slot)

    def make_next(self) -> None:
        """Make a part of the workspaces behind the one in front, and the others once events have been served."""
        if not self._is_closed and next(self._behind, self) is None:
            QTimer.singleShot(BETWEEN_MS, self, self.make_next)

    def _make_behind(self) -> Iterator[None]:
        """Make what an idle window lacks: libraries on a thread of their own, then what needs them."""
        yield from self._on_loaded(load_libraries)
        self.capture.plot.inside  # noqa: B018 - made when it is first asked for
        for name in WORKSPACES:
            if name not in self.tabs:
                yield
                yield from self._steps(name)
        yield from self._on_loaded(load_for_work)

    def expect_work(self) -> None:
        """Make and load what work needs, in steps, as soon as something announces it: a key, a menu, a drag, a job.

        A window that nobody uses does without 200 MB for it.
        """
        if not self._expects_work:
            self._expects_work = True
            QTimer.singleShot(0, self, self.make_next)

    def _on_loaded(self, load: Callable[[], None]) -> Iterator[None]:
        """Call `load` on a thread, in steps that wait for it."""
        loading = threading.Thread(target=load)
        loading.start()
        while loading.is_alive():
            yield

    def keyPressEvent(self, event: QKeyEvent) -> None:
        self.expect_work()
        super().keyPressEvent(event)

    def _make_top_bar(self) -> None:
        self.files = Files(self, self.bench, self.projects, self.settings, self.failures)
        self.menus = Menus(self.files, self.bench.document.undo_stack, self.docks, self.settings)
        self.bar = TopBar(self.menus)
        self.undo, self.redo = self.menus.undo, self.menus.redo
        self.setMenuWidget(self.bar)

    def _make_centre(self) -> None:
        self.status = StatusBar(self.bench.jobs)
        self.error_line = ErrorLine(self.status, self.view)
        self.whereabouts = Whereabouts(self.bench, self.projects, self.banners)
        self.restoring = Restoring(self.bench, self.projects, lambda: self.stack.currentWidget() is self.capture)
        self.restoring.restored.connect(self.capture.show_again)
        self.capture.pixels_lacked.connect(self.restoring.look_again)
        self.picturing = Picturing(self.bench, self.projects)
        self.naming = Naming(self.projects, self.banners, self.files.save_as)
        self.starting = Starting(self.bench, self.projects, self.files, self.show_workspace)
        self.stack.addWidget(self.starting.page)
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
        bench, menus = self.bench, self.menus
        bench.document.changed.connect(self._on_changed)
        bench.document.unread.connect(lambda error: self.failures.report("This step cannot be read now", error))
        self.projects.changed.connect(self._show_title)
        self.projects.confirmed.connect(self.status.confirm)
        self.projects.leaving.connect(self.view.come_to_rest)
        bench.jobs.failed.connect(self._job_failed)
        bench.jobs.changed.connect(lambda job: self.expect_work() if job.is_asked_for else None)
        bench.said.connect(self.status.say)
        bench.output_moved.connect(lambda folder: self.settings.keep(output_folder=str(folder)))
        for wanted in (bench.wanted, self.bar.wanted, menus.workspace_wanted):
            wanted.connect(self.show_workspace)
        self.bar.entered.connect(self.expect_work)
        self.starting.page.approached.connect(self.expect_work)
        self.starting.page.clean_wanted.connect(lambda: self.files.clean_up(self._show_start_during))
        menus.file.aboutToShow.connect(self.expect_work)
        menus.theme_wanted.connect(self.set_theme)
        menus.measuring_wanted.connect(self._measure_or_not)
        menus.image_wanted.connect(self._save_image)
        menus.batch_wanted.connect(self.show_batch)
        menus.watch_wanted.connect(self.show_watch)
        menus.history_wanted.connect(lambda: show_history(self, bench))
        menus.help_wanted.connect(lambda: show_for_pointer(self, self.tabs, QCursor.pos()))
        menus.keys_wanted.connect(lambda: show_keys(self))
        menus.mode_chooser_wanted.connect(self._choose_mode)
        menus.hints_wanted.connect(self.show_hints)
        menus.projects_wanted.connect(self.show_start)
        menus.sample_wanted.connect(lambda: self.starting.open_example(EXAMPLES[0]))
        menus.preferences_wanted.connect(self._show_preferences)
        menus.self_test_wanted.connect(self.self_test)
        menus.reports_wanted.connect(self._show_reports)
        menus.about_wanted.connect(lambda: show_about(self))
        self.status.health_clicked.connect(self.docks.show_health)
        self.docks.health.reported.connect(self.status.show_health)
        self.view.viewport.broken.connect(lambda error: self.failures.report("The model cannot be drawn", error))
        for name, tab in self.tabs.items():
            self._connect_workspace(name, tab)
        self.capture.files_wanted.connect(self.files.choose_folder)
        self.files.choosing.connect(self.expect_work)
        self._on_changed(Project(), bench.document.project)

    def show_workspace(self, name: str) -> None:
        """Bring the workspace `name` to the front."""
        tab, focus = cast(QWidget, getattr(self, name)), QApplication.focusWidget()
        if self.isVisible():
            self.expect_work()
        last = tab.focusWidget()  # before Qt gives the focus to the first button of what comes to the front
        self.stack.setCurrentWidget(tab)
        if focus is None or not tab.isAncestorOf(focus):  # the keys of a workspace hold where the focus is in it
            self._focus_on_work(last)
        self.docks.show_of_view(self._is_lighting())
        self.bar.show_workspace(name)
        if name == "capture":
            self.restoring.look_again()
        self._dress()
        if self.isVisible():
            QTimer.singleShot(0, self, lambda: self.settings.in_front(name))
        self.status.show_frame_time(None)
        self.status.belong_to(name)
        self.error_line.refresh()

    def show_start(self) -> None:
        """Bring the start page to the front, with the projects that there are now."""
        self.stack.setCurrentWidget(self.starting.page)
        self.starting.page.read()
        self._focus_on_work()
        self.docks.show_of_view(False)
        self.bar.show_workspace("")
        self.status.show_frame_time(None)
        self.status.belong_to("")
        self.error_line.refresh()

    def _show_start_during(self, job: Job) -> None:
        """Bring the start page to the front, and read its projects once more when `job` has ended."""
        self.show_start()
        job.succeeded.connect(lambda _: self.starting.page.read())

    def _focus_on_work(self, last: QWidget | None = None) -> None:
        """Give the focus to `last`, which had it in the workspace in front, or else to the work area."""
        tab = cast(QWidget, self.stack.currentWidget())
        if last is None or text_field(last) is not None:
            work = cast(QWidget, getattr(tab, "work", tab))
            last = work if work.isVisible() else tab
        last.setFocus(Qt.FocusReason.OtherFocusReason)

    def _save_image(self, kind: str) -> None:
        self.show_workspace("view")
        self.view.save_image(kind)

    def _is_lighting(self) -> bool:
        """True if the View workspace is in front."""
        return self.stack.currentWidget() is self.view

    def _ways_to_go_on(self) -> dict[str, Callable[[Mapping[str, Any]], object]]:
        """Functions that go on with an interrupted job, by the kind of the job."""

        def bake(again: Mapping[str, Any]) -> None:
            self.show_workspace("view")
            self.view.bake_again(str(again.get("method")))

        def factor(again: Mapping[str, Any]) -> None:
            self.show_workspace("factor")
            self.factor.runs.go_on(again.get("number"))

        def read(again: Mapping[str, Any]) -> None:
            sources = self.bench.document.project.sources
            self.show_workspace("capture")
            if sources is not None:
                self.bench.import_photographs(sources, name=str(again.get("name", "")))

        def write(again: Mapping[str, Any]) -> None:
            self.show_workspace("export")
            self.export.go_on(again)

        def send(again: Mapping[str, Any]) -> None:
            self.show_workspace("export")
            self.export.show_form("elsewhere")
            self.export.elsewhere.go_on(again)

        ways = {"bake": bake, "factor": factor, "import": read, "bundle": write, "exports": send}
        return {**ways, "build": lambda _again: self.bench.build_material()}

    def new(self) -> None:
        """Begin a new project; the one that was open stays on disk."""
        self.files.new()

    def open(self, paths: Sequence[Path]) -> None:
        """Open `paths` by their content, and remember them."""
        self.files.open(paths)

    def open_project(self, path: Path) -> None:
        """Open a project in place of this one, which stays on disk."""
        self.files.open_project(path)

    def set_theme(self, name: str) -> None:
        """Dress everything in 'dark' or 'light': what is visible at once, the rest in short steps."""
        application = QApplication.instance()
        assert isinstance(application, QApplication)
        self.settings.change(theme=name)
        self.menus.show_theme(name)
        dressing = theme.change(application, name)
        if dressing is not None:
            self._dressing, self._untinted = dressing, self._parts()
            self._dress()

    @property
    def is_dressing(self) -> bool:
        """True while parts of the window still have the theme before."""
        return self._dressing is not None

    def _dress(self) -> None:
        """Dress what does not have the theme of now yet: what is visible first, which changes on the screen at once."""
        if self._dressing is not None:
            if self._dressing_steps is not None:
                self._dressing_steps.close()
            self._dressing_steps = self._dress_in_steps(self._dressing)
            self._dress_on(self._dressing_steps)

    def _dress_in_steps(self, dressing: theme.Dressing) -> Generator[None]:
        front = (self.bar, self.status, self.docks, self.stack.currentWidget())
        self._untinted.sort(key=lambda part: part not in front)
        with theme.draw_at_once(cast(QApplication, QApplication.instance())):
            yield from dressing.dress_visible()
            while self._untinted and self._untinted[0] in front:
                yield
                self._untinted.pop(0).apply_theme()
            self._show_anew()
        while self._untinted:
            yield
            self._untinted.pop(0).apply_theme()
        yield from dressing.dress_rest()
        self._dressing = None

    def _dress_on(self, steps: Generator[None]) -> None:
        """Do the next of `steps`, unless others have taken their place meanwhile."""
        if self._is_closed:
            steps.close()
        elif steps is self._dressing_steps and next(steps, self) is not self:
            QTimer.singleShot(0, self, lambda: self._dress_on(steps))

    def show_batch(self) -> BatchDialog:
        """Show the batch of this window, which goes on while its dialog is closed."""
        if self._batch is None:
            self._batch = BatchDialog(self, self.bench.jobs, lambda: self.bench.document.project)
            self._batch.project_wanted.connect(lambda path: self.files.open([path]))
            self._batch.help_wanted.connect(lambda: show_help(self, "batch"))
        self._batch.show()
        self._batch.raise_()
        return self._batch

    def show_watch(self) -> WatchDialog:
        """Show the capture that is being taken, or choose the folder of one."""
        if self._watch is None:
            from app.watch.panel import WatchDialog  # with the libraries that judge photographs

            self._watch = WatchDialog(self, self.bench)
            self._watch.capture_ended.connect(lambda folder: self.bench.open_photographs([folder]))
        self._watch.show()
        self._watch.raise_()
        return self._watch

    def _show_preferences(self) -> None:
        preferences = Preferences(self, self.settings.now, self.bench.jobs)
        preferences.changed.connect(self.prefer)
        preferences.open()

    def prefer(self, name: str, value: Any) -> None:
        """Take a preference of the user, by its name in `Settings`, and keep it."""
        self.settings.keep(**{name: value})
        if name == "theme":
            self.set_theme(value)
        elif name in AT_NEXT_START:
            self.status.say(AT_NEXT_START[name])
        self._take_preferences()
        if name != "theme":
            self._tint()

    def _take_preferences(self) -> None:
        now = self.settings.now
        point = language.locale_of(now.language).decimalPoint()
        write_with(point if now.numbers == NUMBERS[0] else now.numbers, minus="−")
        self.projects.first = Project(look=Look(tone_map=cast(Operator, now.tone_map)))
        self.view.planning.max_memory(1e9 * now.memory_gb or None)
        if "export" in self.tabs:
            self.export.elsewhere.measure_in(now.unit)

    def _choose_mode(self) -> None:
        self.show_workspace("view")
        chooser = ModeChooser(self, self.bench.document.project)
        chooser.mode_wanted.connect(self.view.choose_mode)
        chooser.measuring_wanted.connect(self.docks.measure_modes)
        chooser.open()

    def show_hints_with_first_material(self) -> None:
        """Begin the welcome tour when the View workspace first shows a material, unless it was shown before."""

        def begin() -> None:
            project = self.bench.document.project
            is_shown = self.stack.currentWidget() is self.view and self.view.viewport.camera is not None
            if is_shown and (project.has_map or project.material.measured is not None):
                self.view.drawn.disconnect(begin)
                if not self.settings.now.has_seen_hints:
                    self.show_hints()

        self.view.drawn.connect(begin)

    def show_hints(self) -> None:
        """The welcome tour: point at six parts of the window, one after the other."""
        for earlier in self.findChildren(Tour):
            earlier.end()
        tour = Tour(
            self, first_hints(self.view, self.status, self.bar.buttons.button(list(WORKSPACES).index("export")))
        )
        tour.workspace_wanted.connect(self.show_workspace)
        tour.ended.connect(lambda: self.settings.keep(has_seen_hints=True))
        tour.ended.connect(self._focus_on_work)
        tour.begin()

    def _measure_or_not(self, is_wanted: bool) -> None:
        """Work out the error of the image on screen in the background, or leave it."""
        self.settings.change(measure_error=is_wanted)
        self.view.images.measure(is_wanted)
        self.error_line.refresh()

    def self_test(self) -> None:
        """Try the hard cases of the numerics on this machine, and show how they end."""
        self.docks.show_health()
        if self.docks.health.job is None:
            self.docks.health.test_or_stop()

    def tell_of_crash(self, details: str) -> None:
        """Say that the program crashed before, until a user has seen it; `details` name the report."""
        offers = ("Show the report", self._show_reports), ("Hide", lambda: self.banners.say("crashed", ""))
        self.banners.say("crashed", CRASHED, *offers, details=details)

    def _show_reports(self) -> None:
        try:
            self.status.say(f"Crash reports are in {show_reports()}")
        except FileError as error:
            self.failures.report("The crash reports cannot be shown", error)

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        if event.mimeData().hasUrls():
            self.expect_work()
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        paths = [local_path(url) for url in event.mimeData().urls() if url.isLocalFile()]
        event.acceptProposedAction()
        self.open(paths)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.docks.follow_width()

    def closeEvent(self, event: QCloseEvent) -> None:
        if self.files.leaving.is_held:
            event.ignore()
            self.files.leaving.then("Quit", self.close)
            return
        self._keep_settings()
        self._is_closed = True
        self.hide()
        self.projects.write()
        self.closes.emit()
        self.bench.jobs.close()
        if self._watch is not None:
            self._watch.forget()
        self.projects.finish()
        self.docks.log.disconnect_log()
        self.doings.close()
        if self._session is not None:
            close_session(self._session)
        self.settings.wait()
        event.accept()

    def _on_changed(self, _old: Project, new: Project) -> None:
        self.status.show_health(self.docks.health.health)
        power_law = new.material.power_law
        self.status.show_error(*((power_law.rms, power_law.r_max) if power_law is not None else (None,)))
        is_named = new.name != Project.name
        self._has_title = is_named or new.has_map or new.stack is not None or new.sources is not None
        self._show_title()

    def _show_title(self) -> None:
        """Name of the project, and whether it is on disk; what keeps it from there is said until it is mended."""
        projects, name = self.projects, escape_controls(self.projects.shown_name)
        state = "read-only" if projects.is_read_only else "not saved" if projects.problem else ""
        state = "saving…" if projects.saved_as and not projects.waits_for else state
        self.bar.show_title(name if self._has_title else "", state)
        self.bar.title.setToolTip(projects.details if projects.problem else escape_controls(str(projects.path)))
        self.setWindowTitle(f"{name} – Lightarc" if self._has_title else "Lightarc")
        self.view.name = name
        place, elsewhere = short_path(projects.path), ("Save elsewhere…", self.files.save_as)
        words = f"{place} is not saved: {projects.problem}. All changes stay in memory until they can be written."
        self.banners.say("saving", words if projects.problem else "", elsewhere, details=projects.details)
        words = ""
        if projects.waits_for:
            words = f"{projects.saved_as} is saved. This window goes on in it when “{projects.waits_for}” has ended."
        self.banners.say("saved-as", words, ("Stop that and go on now", projects.hurry))
        as_new = ("Save as…", self.files.save_as)
        words = f"{place} {projects.why_read_only}. Changes in this window are not kept in it."
        self.banners.say("read-only", words if projects.is_read_only else "", as_new, details=str(projects.path))

    def _job_failed(self, job: Job, error: BaseException) -> None:
        if isinstance(error, Doubtful):
            ask_for_consent(self, self.bench, error)
            return
        self.failures.report(failed_title(job, error), error)

    def _parts(self) -> list[Any]:
        """Everything that draws itself by the colours of the theme and the form of numbers."""
        return [self.bar, self.status, self.docks, *self.tabs.values(), self.starting.page]

    def _tint(self) -> None:
        """Let all that draws itself take the colours of the theme and the form of numbers."""
        for part in self._parts():
            part.apply_theme()
        self._show_anew()

    def _show_anew(self) -> None:
        self._on_changed(Project(), self.bench.document.project)
        for image in self.findChildren(ImageView):
            image.update()

    def _restore_layout(self) -> None:
        now = self.settings.now
        folder = Path(now.output_folder)
        if folder.is_absolute() and os.path.isdir(folder):  # noqa: PTH112 - Path.is_dir raises for names too long
            self.bench.output_folder = folder
        if now.geometry:
            self.restoreGeometry(QByteArray(bytes.fromhex(now.geometry)))
        else:
            self.resize(first_size(self.screen().availableSize()))
        self.docks.restore(now.layout, now.closed_docks, now.dock_sizes)

    def _keep_settings(self) -> None:
        self.settings.keep(
            geometry=bytes(self.saveGeometry().data()).hex(),
            layout=bytes(self.saveState().data()).hex(),
            closed_docks=self.docks.of_view.closed,
            dock_sizes=self.docks.sizes,
        )

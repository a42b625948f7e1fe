"""The menus of the window, with the keys of their commands."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from PySide6.QtCore import Signal
from PySide6.QtGui import QAction, QActionGroup, QKeySequence, QUndoStack
from PySide6.QtWidgets import QMenu, QMenuBar

from app.docks.arrangement import Docks
from app.session.settings import Remembered
from app.widgets import theme
from app.window.files import Files
from app.window.recent import fill as fill_recent
from app.window.top_bar import WORKSPACES


class Menus(QMenuBar):
    """Runs the commands of the File menu itself; the others are signals.

    Signals
    -------
    workspace_wanted, theme_wanted : a workspace or a theme, by its name.
    image_wanted : a 'picture' or a 'turntable' of the View workspace as a file.
    measuring_wanted : whether the error of the image is measured.
    batch_wanted, watch_wanted, history_wanted, preferences_wanted, help_wanted, keys_wanted, mode_chooser_wanted,
    reports_wanted, about_wanted : a dialog or a folder.
    hints_wanted : the welcome tour. projects_wanted : the start page. sample_wanted : the shipped woven cloth.
    self_test_wanted : a test of the machine.
    """

    workspace_wanted = Signal(str)
    image_wanted = Signal(str)
    theme_wanted = Signal(str)
    measuring_wanted = Signal(bool)
    batch_wanted = Signal()
    watch_wanted = Signal()
    history_wanted = Signal()
    help_wanted = Signal()
    keys_wanted = Signal()
    mode_chooser_wanted = Signal()
    hints_wanted = Signal()
    projects_wanted = Signal()
    sample_wanted = Signal()
    preferences_wanted = Signal()
    self_test_wanted = Signal()
    reports_wanted = Signal()
    about_wanted = Signal()

    def __init__(self, files: Files, undo_stack: QUndoStack, docks: Docks, settings: Remembered) -> None:
        super().__init__()
        self.files, self.settings = files, settings
        self.file = self.addMenu("&File")
        self._fill_file(self.file)
        self._fill_edit(self.addMenu("&Edit"), undo_stack)
        self._fill_view(self.addMenu("&View"), docks)
        self._fill_help(self.addMenu("&Help"))

    def _fill_file(self, menu: QMenu) -> None:
        files = self.files
        menu.setToolTipsVisible(True)
        add(menu, "New project", "Ctrl+N", files.new)
        add(menu, "Projects…", "Ctrl+Shift+H", self.projects_wanted.emit)
        add(menu, "Open project…", "", files.choose_project)
        add(menu, "Save", "Ctrl+S", files.save)
        add(menu, "Save as…", "Ctrl+Shift+S", files.save_as)
        add(menu, "Collect…", "", files.collect)
        add(menu, "Notes…", "", files.notes)
        add(menu, "Close project", "Ctrl+W", files.new)
        clean = add(menu, "Close and clean up", "", files.clean_up)
        clean.setToolTip(
            "Remove what can be made again from the photographs; it is made again when the project is opened"
        )
        menu.addSeparator()
        add(menu, "Open files…", "Ctrl+O", files.choose_files)
        add(menu, "Open folder…", "Ctrl+Shift+O", files.choose_folder)
        self.recent = menu.addMenu("Open recent")
        self.recent.aboutToShow.connect(self._fill_recent)
        sample = add(menu, "Sample capture", "", self.sample_wanted.emit)
        sample.setToolTip("Open a woven cloth, ready-made, in a project of its own")
        rebuild = add(menu, "Rebuild sample", "", files.bench.rebuild_sample)
        rebuild.setToolTip("Simulate the photographs of a woven cloth at full size, import them and build the material")
        watch = add(menu, "Watch…", "", self.watch_wanted.emit)
        watch.setToolTip("Take photographs in while a camera writes them, and import them when all are there")
        batch = add(menu, "Batch…", "", self.batch_wanted.emit)
        batch.setToolTip("Make materials, projects and exports of many captures in one run")
        menu.addSeparator()
        add(menu, "Save image…", "", partial(self.image_wanted.emit, "picture"))
        add(menu, "Save turntable…", "", partial(self.image_wanted.emit, "turntable"))
        add(menu, "Export bundle…", "Ctrl+E", partial(self.workspace_wanted.emit, "export"))
        menu.addSeparator()
        add(menu, "Quit", "Ctrl+Q", files.window.close)

    def _fill_recent(self) -> None:
        now = self.settings.now
        fill_recent(self.recent, now.recent_projects, now.recent_files, lambda path: self.files.open([path]))

    def _fill_edit(self, menu: QMenu, undo_stack: QUndoStack) -> None:
        self.undo = undo_stack.createUndoAction(self, "Undo")
        self.undo.setShortcuts([QKeySequence("Ctrl+Z")])
        self.redo = undo_stack.createRedoAction(self, "Redo")
        self.redo.setShortcuts([QKeySequence("Ctrl+Shift+Z"), QKeySequence("Ctrl+Y")])
        menu.addAction(self.undo)
        menu.addAction(self.redo)
        add(menu, "History…", "", self.history_wanted.emit)
        menu.addSeparator()
        add(menu, "Preferences…", "Ctrl+,", self.preferences_wanted.emit)

    def _fill_view(self, menu: QMenu, docks: Docks) -> None:
        menu.setToolTipsVisible(True)
        for place, (name, words) in enumerate(WORKSPACES.items()):
            add(menu, words, f"Ctrl+{place + 1}", partial(self.workspace_wanted.emit, name))
        menu.addSeparator()
        self.themes = QActionGroup(self)
        for name, words in (("dark", "Dark theme"), ("light", "Light theme")):
            choice = add(menu, words, "", partial(self.theme_wanted.emit, name))
            choice.setCheckable(True)
            choice.setChecked(name == theme.current().name)
            choice.setData(name)
            self.themes.addAction(choice)
        menu.addSeparator()
        self.measure = add(menu, "Error of the image", "", self._measure_or_not)
        self.measure.setCheckable(True)
        self.measure.setChecked(self.settings.now.measure_error)
        self.measure.setToolTip("Compare the image of the View workspace with a reference, while no other job runs")
        menu.addSeparator()
        menu.addActions(docks.actions)

    def show_theme(self, name: str) -> None:
        """Mark the theme in use."""
        for choice in self.themes.actions():
            choice.setChecked(choice.data() == name)

    def _measure_or_not(self) -> None:
        self.measuring_wanted.emit(self.measure.isChecked())

    def _fill_help(self, menu: QMenu) -> None:
        add(menu, "Help for this panel", "F1", self.help_wanted.emit)
        add(menu, "Mouse and keyboard", "Shift+F1", self.keys_wanted.emit)
        add(menu, "Which mode when…", "", self.mode_chooser_wanted.emit)
        add(menu, "Welcome tour", "", self.hints_wanted.emit)
        menu.addSeparator()
        add(menu, "Self-test", "", self.self_test_wanted.emit)
        add(menu, "Crash reports…", "", self.reports_wanted.emit)
        add(menu, "About Lightarc", "", self.about_wanted.emit)


def add(menu: QMenu, words: str, keys: str, run: Callable[[], object]) -> QAction:
    """A command at the end of `menu`."""
    action = menu.addAction(words)
    action.setShortcut(QKeySequence(keys))
    action.triggered.connect(lambda _checked=False: run())
    return action

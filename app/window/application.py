"""The application: made ready for windows, run with one window, and ended from within its event loop."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import QObject, Qt, QTimer, Signal
from PySide6.QtWidgets import QApplication

from app.process import crash, ending
from app.process.garbage import collect_on_this_thread
from app.process.heap import give_back_free_pages, give_back_freed_arrays
from app.process.packages import load_own
from app.project.places import interrupt, projects_folder
from app.session import settings
from app.start.examples import EXAMPLES
from app.viewport.gl_surface import request_format
from app.widgets import accessible, language, theme
from app.window.main_window import MainWindow
from app.window.top_bar import WORKSPACES

log = logging.getLogger(__name__)

#: A job's thread gives the interpreter to the window's after this long; Python's own 5 ms add up to stutter.
SWITCH_S = 0.0001

#: Variables of the environment by which Mesa chooses what draws, and NVIDIA's driver where it is there.
VARIABLES = {"second": {"DRI_PRIME": "1"}, "processor": {"LIBGL_ALWAYS_SOFTWARE": "1"}}
OF_NVIDIA = {"__NV_PRIME_RENDER_OFFLOAD": "1", "__GLX_VENDOR_LIBRARY_NAME": "nvidia"}


def start() -> QApplication:
    """The application, ready for windows: OpenGL asked for, threads handing over quickly, colours and type set.

    Freed memory goes back to the system from now on, and cycles are searched for on this thread alone.
    """
    load_own()
    give_back_freed_arrays()
    give_back_free_pages()
    kept = settings.load(settings.config_folder())
    draw_by(kept.graphics)
    request_format()
    sys.setswitchinterval(SWITCH_S)
    application = QApplication.instance() or QApplication(["lightarc"])
    assert isinstance(application, QApplication)
    application.setApplicationName("Lightarc")
    _use_processors(kept.threads)
    collect_on_this_thread(application)
    language.use(language.choose(kept.language), application)
    accessible.install()
    theme.apply(application, kept.theme)
    return application


def draw_by(graphics: str) -> None:
    """Let the drivers of Linux draw by what the user chose, unless the environment says something else."""
    variables = VARIABLES.get(graphics, {})
    if graphics == "second" and Path("/proc/driver/nvidia").exists():
        variables = {**variables, **OF_NVIDIA}
    for name, value in variables.items() if sys.platform == "linux" else ():
        os.environ.setdefault(name, value)


def _use_processors(count: int) -> None:
    """Use no more than `count` CPUs from now on, in this process and in those that it starts; 0: all."""
    if not count:
        return
    os.environ["NUMBA_NUM_THREADS"] = str(count)
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:count])


def run(paths: Sequence[Path], *, sample: bool = False) -> int:
    """Open the window and return the exit code when it is closed: 0, also where the system asked for that."""
    application = start()
    closing = _Closing()
    with ending.during(closing.asked.emit, ending.SAVING_S):
        crashed = crash.begin()
        remembered = settings.load(settings.config_folder())
        window = MainWindow(settings.config_folder())
        if crashed:
            log.warning(crashed)
            window.tell_of_crash(crashed)
        window.closes.connect(lambda: ending.end_within(ending.WINDOW_S, 0))
        window.failures.install()
        window.show()
        left = interrupt(projects_folder(), map(Path, remembered.recent_projects))
        if not window.settings.now.has_seen_hints:
            window.show_hints_with_first_material()
        if sample:
            QTimer.singleShot(0, lambda: window.starting.open_example(EXAMPLES[0]))
        elif not paths and left:
            QTimer.singleShot(0, lambda: recover(window, left[0], remembered.workspace))
        elif paths:
            QTimer.singleShot(0, lambda: window.open(paths))
        else:
            window.show_start()
        closing.window = window
        window.closes.connect(lambda: QTimer.singleShot(0, application.quit))
        code = application.exec()
        crash.end()
        return code


def recover(window: MainWindow, project: Path, workspace: str) -> None:
    """Open a project that was interrupted, in the workspace that was in front."""
    window.open_project(project)
    if workspace in WORKSPACES:
        # in an event of its own, because View begins with OpenGL
        QTimer.singleShot(0, window, lambda: window.show_workspace(workspace))


class _Closing(QObject):
    """Closes all windows from within the event loop; `asked` may be emitted on any thread, also before the loop."""

    asked = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.window: MainWindow | None = None
        self.asked.connect(self._close, Qt.ConnectionType.QueuedConnection)

    def _close(self) -> None:
        """Close all windows; the main one waits for what is being saved, for as long as the system grants."""
        if self.window is not None:
            self.window.files.leaving.stop_others()
        is_saving = self.window is not None and self.window.projects.is_saving
        QApplication.closeAllWindows()
        if not is_saving:
            QApplication.exit(0)

"""Windows in processes of their own, driven by commands: the program that `test_sequences` starts.

    python -m tests.app.project.driven_window SOCKET

loads the program once and listens on a Unix socket. Each connection is a window: `lightarc gui FILES` in a fork of this
process, opened with `{"folder": HOME, "files": [...]}`. The folder holds the settings and the untitled projects. Then
each line is an action, `{"do": NAME, ...}`, that runs on the thread of the window. The window answers with

    {"event": "ready", "pid": PID}             it is on screen and takes actions
    {"event": "shown", "path": P, "marks": M}  the document is another one, by an action or by a job
    {"event": "saved", "path": P}              the window shows everything as saved
    {"event": "leaving", "path": P}            the window is about to close the project
    {"event": "switched", "path": P}           the document is that of this project now
    {"event": "accepted", "path": P, "target": T}  the user has confirmed where to save the project
    {"event": "baking", "is_made": M}          the bake that was asked for goes on, or is on screen
    {"event": "done"}                          the action has returned
    {"event": "failed", "message": TEXT}       the window reports a failure; "fault" is true for a fault of the program
    {"event": "ended", "code": CODE}           the process is gone; negative codes are signals

A connection that opens with `{"folder": HOME, "verb": [WORD, ...], "dies_at": N}` is a run of the command line in place
of a window, killed at its Nth operation on files unless N is 0. It answers "ready" before the verb begins,
`{"event": "operations", "count": N}` after it, and "ended".

A connection that opens with `{"read": PATH}` reads project files in place of a window: each line `{"read": PATH}` is
answered by `{"marks": M, "problems": [...]}`, or by `{"error": TEXT}`.
"""

from __future__ import annotations

import dataclasses
import itertools
import json
import os
import random
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from io import RawIOBase
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

if TYPE_CHECKING:
    from app.jobs.jobs import Lane

#: Modules that every window needs, loaded once, before windows are forked.
MODULES = (
    "app.window.application",
    "app.window.main_window",
    "app.material.tab",
    "app.brdf.tab",
    "app.factor.tab",
    "app.export.tab",
    "app.project.report",
    "engine.gl.scene_renderer",
    "engine.capture.import_stack",
    "engine.shading.shading_map",
)

#: Seconds of one step of a job that does not yield, as a step of a search may take.
DEAF_S = 0.7

#: Milliseconds between two gestures of a burst.
BURST_MS = 30


def marks(project: Any, steps: int, position: int) -> list[Any]:
    """What a user would miss in a document, as JSON: the history, and a part of each kind."""
    stack = project.stack
    return [
        steps,
        position,
        project.look.gain,
        project.look.mode,
        project.slices,
        project.notes,
        project.mesh.name if project.mesh is not None else "",
        project.environment.name if project.environment is not None else "",
        str(project.material.brdf),
        len(project.sources.photographs) if project.sources is not None else 0,
        list(stack.radiance.shape) if stack is not None else [],
        bool(project.has_map),
    ]


def serve(place: Path) -> None:
    """Fork a process for each connection, which waits for the process that it starts and says how it ended."""
    from importlib import import_module

    from app.process.packages import load_own, load_shared

    load_own()
    load_shared()
    for name in MODULES:
        import_module(name)
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(str(place))
        listening.listen()
        print("listening", flush=True)
        while True:
            connection, _ = listening.accept()
            if os.fork() == 0:
                listening.close()
                signal.signal(signal.SIGCHLD, signal.SIG_DFL)
                _attend(connection)
                os._exit(0)
            connection.close()


def _attend(connection: socket.socket) -> None:
    lines = connection.makefile("rb", buffering=0)
    first = json.loads(lines.readline())
    if "read" in first:
        for answer in _read_all(first, lines):
            connection.sendall(answer)
        return
    process = os.fork()
    if process == 0:
        _take_home(Path(first["folder"]))
        if "verb" in first:
            _run_verb(connection, first["verb"], first["dies_at"])
        _open_window(connection, [Path(path) for path in first["files"]])
    _, status = os.waitpid(process, 0)
    connection.sendall(_line(event="ended", code=os.waitstatus_to_exitcode(status)))


def _line(**values: Any) -> bytes:
    return json.dumps(values).encode() + b"\n"


def _read_all(first: dict[str, str], lines: RawIOBase) -> Iterator[bytes]:
    """Read project files that are asked for; the content of none is remembered."""
    from app.project.project_file import read
    from app.project.report import problems_of
    from engine.core.errors import FileError
    from engine.core.steps import drain

    asked: dict[str, str] | None = first
    while asked is not None:
        path = Path(asked["read"])
        try:
            opened = read(path)
            found = [*drain(problems_of(path)), *(f"{part} is gone" for part in opened.missing)]
            yield _line(marks=marks(opened.current, len(opened.steps), opened.position), problems=found)
        except FileError as error:
            yield _line(error=str(error))
        line = lines.readline()
        asked = json.loads(line) if line else None


def _take_home(folder: Path) -> None:
    """Be a process of its own user, whose home is `folder`."""
    from app.process import ending

    ending.watch()
    places = {f"XDG_{name}_HOME": str(folder / name.lower()) for name in ("CACHE", "CONFIG", "DATA", "STATE")}
    os.environ.update(places, HOME=str(folder))
    log = os.open(folder / "log.txt", os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)
    for stream in (1, 2):
        os.dup2(log, stream)


def _run_verb(connection: socket.socket, words: list[str], dies_at: int) -> NoReturn:
    """The command line, as `lightarc WORDS` runs it, killed at an operation on files unless that is 0."""
    from app.command_line import main
    from app.process import ending
    from engine.storage import atomic

    operations = itertools.count(1)

    def count(_operation: str, _path: Path) -> None:
        if next(operations) == dies_at:
            os.kill(os.getpid(), signal.SIGKILL)

    atomic.fault = count
    connection.sendall(_line(event="ready", pid=os.getpid()))
    code = main(words)
    connection.sendall(_line(event="operations", count=next(operations) - 1))
    ending.finish(code)


def _open_window(connection: socket.socket, files: list[Path]) -> NoReturn:
    """The window as `lightarc gui` opens it."""
    from app.process import ending

    code = 1
    try:
        from app.window import application

        application.start()
        driver = Driver(connection)
        code = application.run(files)
        del driver
    except BaseException:
        import traceback

        traceback.print_exc()
        ending.leave(70)
    ending.finish(code)


class Driver:
    """Runs the actions of one connection in the window, and says what the user could know."""

    def __init__(self, connection: socket.socket) -> None:
        from PySide6.QtCore import QSocketNotifier, QTimer
        from PySide6.QtWidgets import QFileDialog

        self.connection, self.unread, self.saving_to = connection, b"", ""
        self.window: Any = None
        self.burst: QTimer | None = None
        dialog: Any = QFileDialog  # the user's answers, which no display has to show
        dialog.getSaveFileName = self._choose_place
        self.actions: dict[str, Callable[..., object]] = {
            name.removeprefix("do_"): getattr(self, name) for name in dir(self) if name.startswith("do_")
        }
        self.notifier = QSocketNotifier(connection.fileno(), QSocketNotifier.Type.Read)
        self.notifier.activated.connect(self._hear)
        self.notifier.setEnabled(False)
        self.looking = QTimer(interval=20)
        self.looking.timeout.connect(self._look_for_window)
        self.looking.start()

    def say(self, **values: Any) -> None:
        self.connection.sendall(_line(**values))

    def _look_for_window(self) -> None:
        from PySide6.QtWidgets import QApplication

        from app.window.main_window import MainWindow
        from engine.core.errors import LightarcError

        window = next((each for each in QApplication.topLevelWidgets() if isinstance(each, MainWindow)), None)
        if window is None or not window.isVisible():
            return
        self.looking.stop()
        self.window, self.document = window, window.bench.document
        self.document.changed.connect(lambda _old, _new: self._show())
        self.document.undo_stack.indexChanged.connect(lambda _index: self._show())
        window.projects.leaving.connect(lambda: self.say(event="leaving", path=str(window.projects.path)))
        window.projects.switched.connect(self._on_switched)
        window.projects.changed.connect(self._on_saved)
        window.closes.connect(self._stop_burst)
        window.failures.arrived.connect(
            lambda title, error: self.say(
                event="failed", message=f"{title}: {error}", fault=not isinstance(error, LightarcError)
            )
        )
        self._show()
        self.say(event="ready", pid=os.getpid())
        self.notifier.setEnabled(True)

    def _on_switched(self) -> None:
        self._show()
        self.say(event="switched", path=str(self.window.projects.path))

    def _show(self) -> None:
        from shiboken6 import isValid

        stack, path = self.document.undo_stack, str(self.window.projects.path)
        if not isValid(stack):
            return  # the window is gone
        self.say(event="shown", path=path, marks=marks(self.document.project, stack.count(), stack.index()))

    def _on_saved(self) -> None:
        if self.window.projects.is_saved:
            self.say(event="saved", path=str(self.window.projects.path))

    def _choose_place(self, *_: object) -> tuple[str, str]:
        """The answer to the dialog that asks where to save."""
        target, self.saving_to = self.saving_to, ""
        if target:
            self.say(event="accepted", path=str(self.window.projects.path), target=target)
        return target, ""

    def _hear(self) -> None:
        from PySide6.QtCore import QTimer

        heard = self.connection.recv(1 << 16)
        if not heard:
            self.notifier.setEnabled(False)
            return
        *lines, self.unread = (self.unread + heard).split(b"\n")
        for line in lines:
            QTimer.singleShot(0, partial(self._act, **json.loads(line)))

    def _stop_burst(self) -> None:
        self.burst = None

    def _act(self, do: str, **values: Any) -> None:
        self._stop_burst()
        try:
            self.actions[do](**values)
        finally:
            self.say(event="done")

    def _trigger(self, keys: str) -> None:
        """Run the command of the menus that has these keys; nothing where it is disabled or there is none."""
        from PySide6.QtGui import QAction, QKeySequence

        wanted = QKeySequence(keys)
        for action in self.window.findChildren(QAction):
            if wanted in action.shortcuts() and action.isEnabled():
                action.trigger()
                return

    def do_gain(self, value: float) -> None:
        look = dataclasses.replace(self.document.project.look, gain=value)
        self.document.change("Gain", look=look)

    def do_drag(self, value: float) -> None:
        """One of the many changes of a slider that moves."""
        look = dataclasses.replace(self.document.project.look, gain=value)
        self.document.change("Gain", gesture="gain", look=look)

    def do_notes(self, text: str) -> None:
        self.document.change("Notes", notes=text)

    def do_slices(self, value: int) -> None:
        self.document.change("Slices", slices=value)

    def do_model(self, name: str) -> None:
        self.window.bench.load_model(name)

    def do_sky(self, name: str) -> None:
        self.window.bench.load_environment(name)

    def do_bake(self, method: str) -> None:
        self.window.show_workspace("view")
        baking = self.window.view.bakings[method]
        baking.changed.connect(
            lambda: self.say(event="baking", is_made=baking.is_made) if baking.job or baking.is_made else None
        )
        self.window.view.bake_again(method)

    def do_undo(self) -> None:
        self._trigger("Ctrl+Z")

    def do_redo(self) -> None:
        self._trigger("Ctrl+Shift+Z")

    def do_workspace(self, name: str) -> None:
        self.window.show_workspace(name)

    def do_photographs(self, path: str) -> None:
        self.window.bench.open_photographs([Path(path)])

    def do_build(self) -> None:
        self.window.bench.build_material()

    def do_factor(self) -> None:
        self.window.show_workspace("factor")
        self._trigger("Ctrl+Return")

    def do_burst(self, seed: int) -> None:
        """Gestures without a pause, until something else is done; a dialog in front keeps them from the document."""
        from PySide6.QtCore import QTimer

        chance = random.Random(seed)
        self.burst = QTimer(interval=BURST_MS)
        self.burst.timeout.connect(lambda: self._one_of_burst(chance))
        self.burst.start()

    def _one_of_burst(self, chance: random.Random) -> None:
        from PySide6.QtWidgets import QApplication

        from app.document.modes import modes
        from engine.brdf.brdf import brdf_from_text

        if QApplication.activeModalWidget() is not None:
            return
        look, kind = self.document.project.look, chance.randrange(8)
        if kind == 0:
            self.do_undo()
        elif kind == 1:
            self.do_redo()
        elif kind == 2:
            self.window.view.choose_mode(chance.choice(modes()).value)
        elif kind == 3:
            self.do_model(chance.choice(("sphere", "plane", "torus-knot")))
        elif kind == 4:
            brdf = brdf_from_text(f"ggx:alpha={chance.uniform(0.2, 0.9):.4f}")
            self.window.view.brdf_panel.set_brdf(brdf, "Change BRDF", "")
        elif kind == 5:
            self.do_slices(chance.randrange(2, 16))
        else:
            self.window.view._look_edited(dataclasses.replace(look, gain=chance.uniform(0.2, 5.0)), kind == 6)

    def do_job(self, lane: Lane, deaf: bool) -> None:
        """A job that goes on until it is cancelled; a deaf one for long between two steps."""
        self.window.bench.jobs.submit("Searching without end", lambda: _endless(DEAF_S if deaf else 0.02), lane=lane)

    def do_slow_disk(self, each_s: float) -> None:
        """Let each operation on files of all threads but that of the window take so long from now on."""
        from engine.storage import atomic

        main = threading.main_thread()
        atomic.fault = lambda *_: None if threading.current_thread() is main else time.sleep(each_s)

    def do_cancel(self) -> None:
        for job in self.window.bench.jobs.active:
            self.window.bench.jobs.cancel(job)

    def do_new(self) -> None:
        self._trigger("Ctrl+N")

    def do_open(self, path: str) -> None:
        self.window.open([Path(path)])

    def do_save_as(self, target: str) -> None:
        self.saving_to = target
        self._trigger("Ctrl+Shift+S")

    def do_save(self, target: str) -> None:
        """Save; a project without a name asks for a place."""
        self.saving_to = target
        self._trigger("Ctrl+S")
        self.saving_to = ""

    def do_quit(self) -> None:
        self._trigger("Ctrl+Q")


def _endless(step_s: float) -> Iterator[Any]:
    from engine.core.steps import Step

    while True:
        time.sleep(step_s)
        yield Step(0.5, "searching")


if __name__ == "__main__":
    serve(Path(sys.argv[1]))

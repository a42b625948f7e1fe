"""Measures the start after a crash: a window with a capture in an untitled project is killed, and opened again.

    python -m benchmarks.app.restart [PHOTOGRAPHS]

One JSON object on standard output: `window_s` from the start of the second process until its window is on screen,
`project_s` until the project is open, `material_s` until View has drawn its material, the load of the machine, and the
longest block of the window's thread from its first event on (`benchmarks.app.gaps` says what blocks are).
PHOTOGRAPHS is imported in the first window; without it, the shipped woven cloth is opened and changed. Settings and
projects lie in a folder of their own; the caches of the user are used as they are.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.app.gaps import Drawing, Gaps

PATIENCE_S = 300.0


def main() -> int:
    if sys.argv[1:2] == ["--crash"]:
        return crash([Path(name) for name in sys.argv[2:]])
    if sys.argv[1:2] == ["--again"]:
        return again(float(sys.argv[2]))
    with tempfile.TemporaryDirectory() as folder:
        places = {f"XDG_{name}_HOME": str(Path(folder) / name.lower()) for name in ("CONFIG", "DATA", "STATE")}
        environment = {**os.environ, **places}
        words = [sys.executable, "-m", "benchmarks.app.restart"]
        killed = subprocess.run([*words, "--crash", *sys.argv[1:]], env=environment, check=False).returncode
        if killed != -signal.SIGKILL:
            raise SystemExit(f"the first window ended with {killed}")
        done = subprocess.run(
            [*words, "--again", str(time.time())], env=environment, check=True, stdout=subprocess.PIPE, text=True
        )
    print(done.stdout.strip())
    return 0


def waiting(application: Any) -> Callable[[Callable[[], bool]], None]:
    """A function that runs the event loop until something holds."""

    def until(done: Callable[[], bool]) -> None:
        end = time.perf_counter() + PATIENCE_S
        while not done():
            if time.perf_counter() > end:
                raise SystemExit("the window did not get there in time")
            application.processEvents()
            time.sleep(0.0005)

    return until


def crash(photographs: list[Path]) -> int:
    """Work in a window, and kill it while its project has no name."""
    from app.session import settings
    from app.window.application import start
    from app.window.main_window import MainWindow

    application = start()
    until = waiting(application)
    window = MainWindow(settings.config_folder())
    window.show()
    until(lambda: window.windowHandle().isExposed())
    if photographs:
        window.open(photographs)
    else:
        window.menus.sample_wanted.emit()
    project = window.bench.document
    until(lambda: project.project.has_map and not window.bench.jobs.active)
    window.show_workspace("view")
    project.change("Name it", name="Kept")
    until(lambda: window.projects.is_saved)
    time.sleep(0.5)
    os.kill(os.getpid(), signal.SIGKILL)
    return 0


def again(started: float) -> int:
    """Start as a user does after the crash, and print the figures."""
    from PySide6.QtCore import QTimer
    from PySide6.QtWidgets import QApplication

    from app.session import settings
    from app.window import application as windows

    found: dict[str, Any] = {"load": round(os.getloadavg()[0], 2)}
    window: Any = None

    def watch() -> None:
        nonlocal window
        from app.window.main_window import MainWindow

        window = next(each for each in QApplication.topLevelWidgets() if isinstance(each, MainWindow))
        found["window_s"] = round(time.time() - started, 2)
        Drawing.watch(window.view.viewport.surface)
        gaps = Gaps()
        document = window.bench.document
        document.changed.connect(lambda _old, new: new.has_map and found.setdefault("project_s", passed()))
        window.view.drawn.connect(lambda _s: document.project.has_map and found.setdefault("material_s", passed()))
        QTimer.singleShot(round(1000 * PATIENCE_S), QApplication.quit)
        look = QTimer(window)
        look.timeout.connect(lambda: end(gaps) if "material_s" in found and not window.bench.jobs.active else None)
        look.start(500)

    def passed() -> float:
        return round(time.time() - started, 2)

    def end(gaps: Gaps) -> None:
        gaps.stop()
        found.update(gaps.figures("restart"))
        window.close()

    assert settings.load(settings.config_folder()).workspace == "view"
    real = windows.recover

    def recover(*arguments: Any) -> None:
        watch()
        real(*arguments)

    vars(windows)["recover"] = recover
    windows.run([])
    print(json.dumps(found))
    return 0


if __name__ == "__main__":
    sys.exit(main())

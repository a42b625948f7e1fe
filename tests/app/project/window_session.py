"""A session in the window that goes on until it is killed: the program that `test_kill_points` starts.

    python -m tests.app.project.window_session PROJECT SEED

opens the project, does gestures by the window's own actions, panels and commands, a few each second, and prints what a
person could know: `did` with the marks of the document after each gesture, and `saved` with the number of gestures
that the window calls saved.
"""

from __future__ import annotations

import dataclasses
import random
import sys
from pathlib import Path
from typing import Any

from PySide6.QtCore import QTimer

from app.document.modes import modes
from app.project.project_file import KEPT_STEPS
from app.window.application import start
from app.window.main_window import MainWindow
from engine.geometry.shapes import SHAPES
from engine.light.sky import SKIES

#: Between two gestures, in milliseconds.
EVERY_MS = 30


class Session:
    """The hand of a person in `window`."""

    def __init__(self, window: MainWindow, seed: int) -> None:
        self.window, self.chance, self.done = window, random.Random(seed), 0
        self.document = window.bench.document
        self.document.changed.connect(lambda _old, _new: self.tell())
        self.document.undo_stack.indexChanged.connect(lambda _index: self.tell())
        window.projects.changed.connect(self.saved)
        self.timer = QTimer()
        self.timer.timeout.connect(self.move)
        self.timer.start(EVERY_MS)

    def tell(self) -> None:
        """The document is another one, by a gesture or by a job."""
        stack, project = self.document.undo_stack, self.document.project
        mesh = project.mesh.name if project.mesh is not None else ""
        light = project.environment.name if project.environment is not None else ""
        marks = (project.look.gain, project.look.mode, mesh, light, project.material.brdf, project.slices)
        gone = max(0, stack.count() - KEPT_STEPS)
        self.done += 1
        print("did", self.done, (stack.count() - gone, max(0, stack.index() - gone), *marks), flush=True)

    def saved(self) -> None:
        if self.window.projects.is_saved:
            print("saved", self.done, flush=True)

    def move(self) -> None:
        """One gesture."""
        chance, window, document = self.chance, self.window, self.document
        look = document.project.look
        kind = chance.randrange(9)
        if kind == 0:
            window.undo.trigger()
        elif kind == 1:
            window.redo.trigger()
        elif kind == 2:
            window.view.choose_mode(chance.choice(modes()).value)
        elif kind == 3:
            window.bench.load_model(chance.choice(list(SHAPES)))
        elif kind == 4:
            window.bench.load_environment(chance.choice(list(SKIES)))
        elif kind == 5:
            window.view.brdf_panel.set_brdf(_brdf(chance.uniform(0.2, 0.9)), "Change BRDF", "")
        elif kind == 6:
            document.change("Slices", slices=chance.randrange(2, 16))
        else:
            window.view._look_edited(dataclasses.replace(look, gain=chance.uniform(0.2, 5.0)), kind == 7)


def _brdf(alpha: float) -> Any:
    from engine.brdf.brdf import brdf_from_text

    return brdf_from_text(f"ggx:alpha={alpha:.4f}")


if __name__ == "__main__":
    application = start()
    main = MainWindow(None)
    main.show()
    main.projects.open(Path(sys.argv[1]))
    session = Session(main, int(sys.argv[2]))
    sys.exit(application.exec())

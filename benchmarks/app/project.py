"""Measures projects: a gesture on the thread of the window, a long session, and opening a large one.

    python -m benchmarks.app.project gestures|session|open|window FOLDER

makes one measurement in a process of its own and prints one JSON object; `project` makes them all. A gesture costs what
the document and its recording take on the thread of the window; hashing and writing are the work of another thread,
which competes for the interpreter meanwhile.
"""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from benchmarks.measure import Accuracy
from engine.core.steps import Step, Steps

PHOTOGRAPHS, BRDFS, GESTURES = 64, 12, 200
LONG = 2000

#: Promises: a gesture in ms, opening a large project and a long history in s, and the file of the latter in MB.
GESTURE_MS, OPEN_S, OPEN_LONG_S, FILE_MB = 20.0, 1.5, 1.0, 5.0


def project(folder: Path) -> Steps[list[Accuracy]]:
    """The four figures. That of the large project needs a display, 10 GB of disk and some minutes."""
    yield Step(0.0, "recording gestures")
    gesture = _measure("gestures", folder)
    yield Step(0.2, f"recording {LONG} gestures")
    session = _measure("session", folder)
    opened = _measure("open", folder)
    yield Step(0.4, "importing ten photographs of 24 megapixels")
    found = [
        Accuracy("project-gesture", gesture["worst_ms"], _measure_gesture(gesture), GESTURE_MS, gesture),
        Accuracy("project-file", session["size_mb"], f"MB of a project after {LONG} gestures", FILE_MB),
        Accuracy("project-open-long", opened["open_s"], f"s to open a project after {LONG} gestures", OPEN_LONG_S),
    ]
    if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY") or not sys.platform.startswith("linux"):
        path = yield from _large(folder / "large")
        yield Step(0.9, "opening it")
        large = _measure("window", path)
        what = "s until the window answers with ten photographs of 24 megapixels and all that was made of them"
        found.append(Accuracy("project-open-24mp", large["open_s"], what, OPEN_S, large))
    return found


def _measure_gesture(found: dict[str, float]) -> str:
    what = f"ms of a gesture on the thread of the window with {PHOTOGRAPHS} photographs and {BRDFS} measured BRDFs"
    return f"{what}, the worst of {GESTURES}; the median is {found['median_ms']:.2f} ms"


def _measure(what: str, folder: Path) -> dict[str, float]:
    words = [sys.executable, "-m", "benchmarks.app.project", what, str(folder)]
    done = subprocess.run(words, check=True, stdout=subprocess.PIPE, text=True)
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return found


def _large(folder: Path) -> Steps[Path]:
    """A project of ten photographs of 24 megapixels, with stack and material."""
    from app.commands.making import material_of, stack_of
    from app.document.document import ImportChoices, Project
    from app.project.project_file import History, Writer, data_folder
    from benchmarks.app.program import photographs_of_24_megapixels
    from engine.capture.lights.sources import find
    from engine.core.steps import part
    from engine.storage.atomic import make_folder

    path = folder / "large.lap"
    sources = find(photographs_of_24_megapixels(make_folder(folder / "photographs")))
    choices = ImportChoices(motion="none")
    target = make_folder(data_folder(path)) / "stack-1"
    stack = yield from part(stack_of(sources, choices, target), 0.4, 0.6)
    made = Project(sources=sources, import_choices=choices, imported_with=choices, stack=stack)
    material = yield from part(material_of(made), 0.6, 0.9)
    writer = Writer(path)
    writer.write(History(dataclasses.replace(made, material=material, built_from=made.recipe)))
    writer.close()
    return path


def gestures(folder: Path) -> dict[str, float]:
    """Turn a parameter again and again in a project of many photographs and measured BRDFs."""
    from PySide6.QtCore import QCoreApplication

    from app.document.comparison import Comparison, Entry
    from app.document.open_document import Document
    from app.project.recording import Recording
    from engine.brdf.table import HalfDifferenceTable
    from engine.capture.lights.sources import find
    from engine.images.encode import encode_png
    from engine.storage.atomic import make_folder, write_bytes

    application = QCoreApplication([])
    images = make_folder(folder / "pictures")
    for at in range(PHOTOGRAPHS):
        image = encode_png(np.full((8, 8, 3), 256 * at, np.uint16))
        write_bytes(images / f"light_{at + 10}deg.png", image)
    shape = (90, 90, 180)
    tables = [
        HalfDifferenceTable(np.full((*shape, 3), at, np.float32), np.zeros(shape, bool), f"measured {at}", "table")
        for at in range(BRDFS)
    ]
    document = Document()
    entries = tuple(Entry(table.name, table, at) for at, table in enumerate(tables))
    document.change("Begin", sources=find([images]), comparison=Comparison(entries))
    recording = Recording(document, folder / "gestures.lap")
    handed: list[float] = []
    hand_over = recording.hand_over

    def timed() -> None:
        begun = time.perf_counter()
        hand_over()
        handed.append(time.perf_counter() - begun)

    recording._delay.timeout.disconnect()
    recording._delay.timeout.connect(timed)
    changes = []
    for at in range(GESTURES):
        begun = time.perf_counter()
        document.change("Gain", look=dataclasses.replace(document.project.look, gain=1.0 + at / GESTURES))
        changes.append(time.perf_counter() - begun)
        until = time.perf_counter() + 0.02
        while time.perf_counter() < until:
            application.processEvents()
    recording.close(120.0)
    application.shutdown()
    median = float(np.median(changes) + np.median(handed))
    parts = {"worst": max(changes) + max(handed), "median": median, "change": max(changes), "recording": max(handed)}
    return {f"{name}_ms": round(1e3 * value, 3) for name, value in parts.items()}


def session(folder: Path) -> dict[str, float]:
    """A long session: each gesture is written on its own."""
    from app.document.document import Look
    from app.document.open_document import Document
    from app.project.project_file import History, Writer

    path, document = folder / "long.lap", Document()
    writer = Writer(path)
    for at in range(LONG):
        document.change("Gain", look=Look(gain=1.0 + at / LONG, light_theta_deg=at % 90))
        writer.write(History(document.project, document.steps, document.undo_stack.index()))
    writer.close()
    return {"size_mb": round(path.stat().st_size / 1e6, 3)}


def open_path(folder: Path) -> dict[str, float]:
    """Open that project: read it, and take its history."""
    from app.document.open_document import Document
    from app.project.project_file import read

    document = Document()
    begun = time.perf_counter()
    found = read(folder / "long.lap")
    document.restore(found.current, found.steps, found.position, found.state)
    took_s = time.perf_counter() - begun
    document.clear()  # steps that outlive the stack of Qt's they are on crash Python at its end
    return {"open_s": round(took_s, 3)}


def window(path: Path) -> dict[str, float]:
    """Open the project at `path` in the window, until it answers."""
    from PySide6.QtCore import QTimer

    from app.window.application import start
    from app.window.main_window import MainWindow

    application = start()
    main = MainWindow(None)
    main.show()
    application.processEvents()
    begun = time.perf_counter()
    times: list[float] = []
    main.projects.open(path, then=lambda: QTimer.singleShot(0, lambda: times.append(time.perf_counter() - begun)))
    while not times:
        application.processEvents()
    whole_s = times[0]
    while not main.bench.document.project.has_map and time.perf_counter() - begun < 120.0:
        application.processEvents()
        time.sleep(0.01)
    has_map_s = time.perf_counter() - begun
    main.close()
    return {"open_s": round(whole_s, 3), "material_s": round(has_map_s, 3)}


if __name__ == "__main__":
    measure = {"gestures": gestures, "session": session, "open": open_path, "window": window}[sys.argv[1]]
    print(json.dumps(measure(Path(sys.argv[2]))))

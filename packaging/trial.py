"""A new user's day with the program, killed at twelve moments: nothing that was done may be missing afterwards.

    python packaging/trial.py FOLDER --photographs CAPTURE

needs a display with a window manager (Xvfb and openbox do), and the programs xdotool and import (ImageMagick). The
mouse and the keys are those of the display, so that shortcuts, focus and dialogs are tried as a person has them. The
program runs as it is installed; a look at its window from within (`watched`) only says where things are and what is
saved. Each moment of `DAY` is a piece of work in one workspace. Then the process is killed, and the next start has to
show the same. Pictures of the window before and after each kill lie in FOLDER, to be looked at; `trial.json` says what
was compared. The exit code is 1 where something was missing.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

PATIENCE_S = 600.0

#: Between two events of the mouse or the keyboard, in seconds.
PAUSE_S = 0.25

#: Milliseconds between two looks at the window from within.
EVERY_MS = 150

Seen = dict[str, Any]


def watched(paths: list[Path], seen: Path) -> int:
    """The window as `lightarc gui` opens it, which says in the file `seen` what is on screen and what is saved."""
    from PySide6.QtCore import QTimer

    from app.window.application import run, start

    application = start()
    timer = QTimer(application)
    timer.timeout.connect(lambda: tell(seen))
    timer.start(EVERY_MS)
    return run(paths)


def tell(seen: Path) -> None:
    """Write what can be seen: places of widgets by their words, banners, jobs, and marks of the document."""
    from PySide6.QtWidgets import QApplication, QDialog, QWidget

    from app.viewport.viewport import Viewport
    from app.window.main_window import MainWindow

    window = next((each for each in QApplication.topLevelWidgets() if isinstance(each, MainWindow)), None)
    if window is None or not window.isVisible():
        return
    places = {}
    for widget in QApplication.allWidgets():
        words = getattr(widget, "text", lambda: "")()
        name = widget.accessibleName() or (words if isinstance(words, str) else "") or type(widget).__name__
        if isinstance(widget, Viewport):
            name = "viewport"
        if widget.isVisible() and widget.window().isVisible() and widget.isEnabled():
            corner = widget.mapToGlobal(widget.rect().topLeft())
            places[name.replace("&", "")] = (corner.x(), corner.y(), widget.width(), widget.height())
    projects, document = window.projects, window.bench.document
    said = {
        "places": places,
        "focus": type(QApplication.focusWidget()).__name__ if isinstance(QApplication.focusWidget(), QWidget) else "",
        "dialogs": [
            each.windowTitle()
            for each in QApplication.topLevelWidgets()
            if isinstance(each, QDialog) and each.isVisible()
        ],
        "banners": window.banners.words,
        "jobs": [job.title for job in window.bench.jobs.active if job.heavy],
        "path": str(projects.path),
        "is_saved": projects.is_saved,
        "is_drawn": window.view.viewport.camera is not None,
        "is_read_only": projects.is_read_only,
        "workspace": next(name for name, tab in window.tabs.items() if tab is window.stack.currentWidget()),
        "marks": marks(document.project)
        | {"position": document.undo_stack.index(), "steps": min(200, document.undo_stack.count())},
        "title": window.windowTitle(),
    }
    partial = seen.with_suffix(".new")
    partial.write_text(json.dumps(said))
    partial.replace(seen)


def marks(project: Any) -> dict[str, Any]:
    """All that a person would miss in a document, as JSON."""
    stack, material, mesh = project.stack, project.material, project.mesh
    return {
        "name": project.name,
        "photographs": len(project.sources.photographs) if project.sources is not None else 0,
        "stack": list(stack.radiance.shape) if stack is not None else None,
        "slices": project.slices,
        "map": list(material.shading_map.slices.shape) if material.shading_map is not None else None,
        "planes": list(material.directional.planes.shape) if material.directional is not None else None,
        "power law": round(float(material.power_law.rms), 7) if material.power_law is not None else None,
        "brdf": str(material.brdf),
        "excluded": sorted(project.excluded),
        "compared": [entry.name for entry in project.comparison.entries],
        "runs": [[run.number, run.name] for run in project.factoring.runs],
        "mesh": mesh.name if mesh is not None else None,
        "light": project.environment.name if project.environment is not None else None,
        "look": repr(project.look),
        "camera": repr(project.camera),
        "bakes": repr(sorted(project.bakes.items(), key=str)),
    }


@dataclass
class Person:
    """Mouse, keys and eyes of somebody at the display, and the process of the program that runs now."""

    folder: Path
    process: subprocess.Popen[bytes] | None = None
    shots: int = 0
    compared: list[Seen] = field(default_factory=list)

    @property
    def seen(self) -> Seen:
        """All that is on screen now; empty before the window is there."""
        try:
            return dict(json.loads((self.folder / "seen.json").read_bytes()))
        except (OSError, ValueError):
            return {}

    def start(self, *paths: Path) -> None:
        """Start the program with files, and wait for its window."""
        (self.folder / "seen.json").unlink(missing_ok=True)
        places = {f"XDG_{name}_HOME": str(self.folder / name.lower()) for name in ("CONFIG", "DATA", "STATE")}
        words = [sys.executable, __file__, "--watched", str(self.folder / "seen.json"), *map(str, paths)]
        log = (self.folder / "log.txt").open("ab")
        self.process = subprocess.Popen(words, env={**os.environ, **places}, stdout=log, stderr=log)
        self.until(lambda seen: bool(seen), "the window")
        do("search", "--sync", "--onlyvisible", "--name", "Lightarc", "windowactivate", "--sync")
        time.sleep(4 * PAUSE_S)
        do("key", "Escape")  # the first hints

    def until(self, is_so: Callable[[Seen], bool], what: str, within_s: float = PATIENCE_S) -> Seen:
        """Wait until what is seen `is_so`."""
        end = time.monotonic() + within_s
        while time.monotonic() < end:
            seen = self.seen
            if seen and is_so(seen):
                return seen
            if self.process is not None and self.process.poll() is not None:
                break
            time.sleep(PAUSE_S)
        self.shot("waited-in-vain")
        raise SystemExit(f"waited in vain for {what}; {self.seen.get('banners')}, {self.seen.get('dialogs')}")

    def keys(self, *keys: str) -> None:
        """Press keys, by their names in X, one after the other."""
        for key in keys:
            do("key", "--clearmodifiers", key)
            time.sleep(PAUSE_S)

    def write(self, words: str) -> None:
        """Type `words`."""
        do("type", "--delay", "40", words)
        time.sleep(PAUSE_S)

    def place(self, name: str, across: float = 0.5, down: float = 0.5) -> tuple[int, int]:
        """A point of the widget that is called `name`, by shares of its size."""
        before: list[int] = []
        while True:  # until the layout rests
            seen = self.until(lambda seen: name in seen["places"], f"the widget {name!r}")
            if seen["places"][name] == before:
                break
            before = seen["places"][name]
            time.sleep(4 * PAUSE_S)
        x, y, width, height = seen["places"][name]
        return round(x + across * width), round(y + down * height)

    def click(self, name: str, across: float = 0.5, down: float = 0.5) -> None:
        """Click the middle of the widget that is called `name`, or another point of it."""
        do("mousemove", *self.place(name, across, down))
        time.sleep(PAUSE_S)
        do("click", 1)
        time.sleep(PAUSE_S)

    def drag(self, name: str, start: tuple[float, float], end: tuple[float, float], key: str = "") -> None:
        """Drag within the widget `name`, with a key held down where one is given."""
        first, last = self.place(name, *start), self.place(name, *end)
        do("mousemove", *first, *(("keydown", key) if key else ()), "mousedown", 1)
        for step in range(1, 9):
            do("mousemove", *(round(a + (b - a) * step / 8) for a, b in zip(first, last, strict=True)))
            time.sleep(PAUSE_S / 4)
        do("mouseup", 1, *(("keyup", key) if key else ()))
        time.sleep(PAUSE_S)

    def shot(self, name: str) -> None:
        """Keep a picture of the display."""
        self.shots += 1
        subprocess.run(["import", "-window", "root", self.folder / f"{self.shots:02d}-{name}.png"], check=False)

    def rest(self) -> Seen:
        """Wait until no job runs and everything is on disk."""
        time.sleep(4 * PAUSE_S)
        return self.until(lambda seen: not seen["jobs"] and seen["is_saved"], "rest")

    def saved(self) -> Seen:
        """Wait until everything is on disk, whatever runs."""
        time.sleep(4 * PAUSE_S)
        return self.until(lambda seen: seen["is_saved"], "everything on disk")

    def killed(self, name: str) -> None:
        """Kill the program now, start it again without a word, and compare."""
        before = self.seen
        self.shot(f"{name}-before")
        assert self.process is not None
        os.kill(self.process.pid, signal.SIGKILL)
        self.process.wait()
        self.start()
        self.until(lambda seen: seen["path"] == before["path"], "the project that was open")
        time.sleep(8 * PAUSE_S)
        self.shot(f"{name}-after")
        self.compare(name, before, self.seen)

    def compare(self, name: str, before: Seen, after: Seen) -> None:
        """Note all marks of the document that are others than before."""
        lost = {key: (old, after["marks"][key]) for key, old in before["marks"].items() if after["marks"][key] != old}
        words = {
            "moment": name,
            "jobs": before["jobs"],
            "lost": lost,
            "banners": after["banners"],
            "dialogs": after["dialogs"],
        }
        self.compared.append(words)
        print(json.dumps(words), flush=True)

    def answer(self, title: str, path: Path) -> None:
        """Write a path into the file dialog of this title, and accept it."""
        self.until(lambda seen: title in seen["dialogs"], f"the dialog {title!r}", 60.0)
        time.sleep(4 * PAUSE_S)
        self.keys("ctrl+a")
        self.write(str(path))
        self.shot(title.lower().replace(" ", "-"))
        self.keys("Return")
        self.until(lambda seen: title not in seen["dialogs"], "the end of the dialog", 60.0)

    def go_on(self) -> None:
        """Go on with the work that was interrupted."""
        seen = self.until(lambda seen: any(name.startswith("Go on") for name in seen["places"]), "a button to go on")
        self.click(next(name for name in seen["places"] if name.startswith("Go on")))

    def close(self) -> int:
        """Quit by the keyboard; the exit code."""
        assert self.process is not None
        self.keys("ctrl+q")
        return self.process.wait(PATIENCE_S)


def do(*words: object) -> None:
    """One event or more of xdotool."""
    subprocess.run(["xdotool", *map(str, words)], check=True, capture_output=True)


def importing(person: Person, photographs: Path) -> None:
    """Capture: killed while the photographs are read."""
    person.start(photographs)
    person.until(
        lambda seen: bool(seen["jobs"]) and seen["is_saved"] and seen["marks"]["photographs"] > 0, "the import"
    )
    person.killed("import")
    person.go_on()
    person.until(lambda seen: seen["marks"]["map"] is not None or seen["marks"]["planes"] is not None, "the material")
    person.rest()


def a_material(person: Person) -> None:
    """The material that the import has led to."""
    person.killed("material")


def excluded(person: Person) -> None:
    """Capture: a photograph is left out by a key."""
    person.keys("ctrl+1")
    person.click("PhotographColumn", 0.5, 0.2)
    person.keys("x")
    person.saved()
    person.killed("excluded")


def rebuilt(person: Person) -> None:
    """Material: built anew."""
    person.keys("ctrl+2")
    person.click("Rebuild material")
    person.rest()
    person.killed("rebuilt")


def compared(person: Person) -> None:
    """BRDF: two of the library."""
    person.keys("ctrl+3", "ctrl+f")
    person.write("ward")
    person.keys("Return")
    person.until(lambda seen: bool(seen["marks"]["compared"]), "a BRDF among the compared ones", 60.0)
    person.saved()
    person.killed("compared")


def factored(person: Person) -> None:
    """Factor: killed in the run, which goes on."""
    person.keys("ctrl+4", "ctrl+Return")
    person.until(lambda seen: bool(seen["marks"]["runs"]), "the run", 60.0)
    person.saved()
    is_running = bool(person.seen["jobs"])
    person.killed("factored")
    if is_running:
        person.go_on()
    person.rest()
    person.shot("factored")


def lit(person: Person) -> None:
    """View: light and camera by the mouse."""
    person.keys("ctrl+5")
    person.until(lambda seen: seen["is_drawn"], "the picture")
    time.sleep(8 * PAUSE_S)  # until the docks beside the picture have their place
    light, camera = (person.seen["marks"][name] for name in ("look", "camera"))
    person.drag("viewport", (0.5, 0.5), (0.62, 0.45), "ctrl")
    person.drag("viewport", (0.5, 0.5), (0.4, 0.55))
    person.until(lambda seen: seen["marks"]["look"] != light and seen["marks"]["camera"] != camera, "both", 60.0)
    person.saved()
    person.killed("lit")


def baked(person: Person) -> None:
    """View: killed in the middle of a bake, which goes on."""
    person.keys("ctrl+5", "h")
    person.until(lambda seen: "mode='sh'" in seen["marks"]["look"], "spherical harmonics", 60.0)
    person.click("Bake")
    person.until(lambda seen: any("aking" in job for job in seen["jobs"]), "the bake")
    person.saved()
    is_running = bool(person.seen["jobs"])
    person.killed("baking")
    if is_running:
        person.go_on()
    person.rest()
    person.shot("baked")


def undone(person: Person) -> None:
    """Steps that were undone can be done again after the kill."""
    steps = person.rest()["marks"]["position"]
    person.keys("ctrl+z", "ctrl+z", "ctrl+z")
    person.until(lambda seen: seen["marks"]["position"] == steps - 3, "three steps back")
    person.saved()
    person.killed("undone")
    person.keys("ctrl+shift+z", "ctrl+shift+z", "ctrl+shift+z")
    person.until(lambda seen: seen["marks"]["position"] == steps, "three steps forth")
    person.saved()


def exported(person: Person) -> None:
    """Export: killed while the bundle is written, which goes on where the person says."""
    target = person.folder / "Felt.lightarc"
    person.keys("ctrl+6")
    person.click("Export bundle")
    person.until(lambda seen: bool(seen["jobs"]), "the export", 60.0)
    person.killed("exported")
    person.go_on()
    person.answer("Export bundle", target)
    person.until(lambda seen: target.is_file(), "the bundle")
    person.rest()
    person.shot("exported")


def saved_as(person: Person) -> None:
    """File: saved as through the dialog; the project goes on at its place, and is found there after the kill."""
    target = person.folder / "own place" / "Felt.lap"
    target.parent.mkdir(exist_ok=True)
    person.keys("ctrl+shift+s")
    person.answer("Save as", target)
    person.until(lambda seen: seen["path"] == str(target), "the copy")
    person.saved()
    person.killed("saved-as")


def collected(person: Person) -> None:
    """File: collected through the menu and the dialogs; the copy opens where the photographs are not."""
    target = person.folder / "collected" / "Felt.lap"
    target.parent.mkdir(exist_ok=True)
    person.keys("alt+f", "Down", "Down", "Down", "Return")
    person.click("With results")
    person.answer("Collect", target)
    before = person.rest()
    person.until(lambda seen: target.is_file(), "the collected project")
    kept, hidden = person.folder / "photographs", person.folder / "photographs elsewhere"
    kept.rename(hidden)
    person.killed("collected")
    person.keys("ctrl+q")
    assert person.process is not None
    person.process.wait(PATIENCE_S)
    person.start(target)
    after = person.until(lambda seen: seen["path"] == str(target), "the collected project")
    time.sleep(8 * PAUSE_S)
    person.shot("collected-opened")
    person.compare("opened elsewhere", before, after)
    hidden.rename(kept)


#: Work of the day after the import; each ends with a kill.
DAY = (a_material, excluded, rebuilt, compared, factored, lit, baked, undone, exported, saved_as, collected)


def closed(person: Person) -> None:
    """Closed without a question; what was there is there when the file is opened again."""
    before = person.rest()
    code = person.close()
    person.start(Path(before["path"]))
    after = person.until(lambda seen: seen["path"] == before["path"], "the project")
    time.sleep(8 * PAUSE_S)
    person.shot("closed-after")
    lost = {key: (old, after["marks"][key]) for key, old in before["marks"].items() if after["marks"][key] != old}
    person.compared.append({"moment": "closed", "code": code, "lost": lost, "dialogs": before["dialogs"]})


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--photographs", type=Path, help="a capture; it is copied into FOLDER")
    names = [work.__name__ for work in DAY]
    parser.add_argument("--from", dest="first", choices=names, help="go on in FOLDER with this moment")
    options = parser.parse_args()
    folder = options.folder.absolute()
    person = Person(folder, shots=len(list(folder.glob("*.png"))))
    if options.first is None:
        folder.mkdir(parents=True)
        photographs = folder / "photographs"
        shutil.copytree(options.photographs, photographs)
        importing(person, photographs)
    else:
        person.start()
    for work in DAY[names.index(options.first) if options.first else 0 :]:
        work(person)
    closed(person)
    code = person.close()
    (folder / "trial.json").write_text(json.dumps(person.compared, indent=2))
    lost = [each for each in person.compared if each["lost"] or each["dialogs"]]
    print(f"{len(person.compared)} moments, {len(lost)} with something missing or asked; exit code {code}")
    return 1 if lost or code else 0


if __name__ == "__main__":
    if sys.argv[1:2] == ["--watched"]:
        sys.exit(watched([Path(path) for path in sys.argv[3:]], Path(sys.argv[2])))
    sys.exit(main())

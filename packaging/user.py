"""Somebody at the display: mouse, keys and eyes, and the process of the program that they use.

The mouse and the keys are those of the display (xdotool), so that shortcuts, focus and dialogs are tried as a user
has them. The program runs as it is installed; a look at its window from within (`watched`) only says where things are
and what is saved: `python user.py SEEN [PATH …]` opens the window with paths, and says all that in the file SEEN.
"""

from __future__ import annotations

import json
import os
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


def watch(paths: list[Path], seen: Path) -> int:
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
    from PySide6.QtWidgets import QAbstractButton, QApplication, QDialog, QLabel, QMessageBox, QWidget

    from app.viewport.viewport import Viewport
    from app.window.main_window import MainWindow

    window = next((each for each in QApplication.topLevelWidgets() if isinstance(each, MainWindow)), None)
    if window is None or not window.isVisible():
        return
    found: list[tuple[str, tuple[int, int, int, int]]] = []
    for widget in QApplication.allWidgets():
        is_caption = isinstance(widget, QLabel) and widget.buddy() is not None  # what it names has the same name
        if widget.isVisible() and widget.window().isVisible() and widget.isEnabled() and not is_caption:
            corner = widget.mapToGlobal(widget.rect().topLeft())
            name = "viewport" if isinstance(widget, Viewport) else name_of(widget)
            found.append((name, (corner.x(), corner.y(), widget.width(), widget.height())))
    places: dict[str, tuple[int, int, int, int]] = {}
    for name, place in sorted(found, key=lambda each: (each[1][1], each[1][0])):
        number = 1 + sum(other.partition(" #")[0] == name for other in places)
        places[name if number == 1 else f"{name} #{number}"] = place
    focus = QApplication.focusWidget()
    projects, document = window.projects, window.bench.document
    said = {
        "look": time.monotonic(),
        "places": places,
        "focus": name_of(focus) if isinstance(focus, QWidget) else "",
        "checked": [
            name_of(each)
            for each in QApplication.allWidgets()
            if isinstance(each, QAbstractButton) and each.isVisible() and each.isCheckable() and each.isChecked()
        ],
        "dialogs": [
            each.windowTitle()
            for each in QApplication.topLevelWidgets()
            if isinstance(each, QDialog) and each.isVisible()
        ],
        "banners": window.banners.words,
        "messages": [
            each.text() for each in QApplication.topLevelWidgets() if isinstance(each, QMessageBox) and each.isVisible()
        ],
        "jobs": [job.title for job in window.bench.jobs.active if job.is_asked_for],
        "computing": [job.title for job in window.bench.jobs.active],
        "path": str(projects.path),
        "is_saved": projects.is_saved,
        "is_drawn": window.view.viewport.camera is not None,
        "is_read_only": projects.is_read_only,
        "workspace": next((name for name, tab in window.tabs.items() if tab is window.stack.currentWidget()), "start"),
        "marks": marks(document.project)
        | {"position": document.undo_stack.index(), "steps": min(200, document.undo_stack.count())},
        "title": window.windowTitle(),
    }
    partial = seen.with_suffix(".new")
    partial.write_text(json.dumps(said))
    partial.replace(seen)


def name_of(widget: Any) -> str:
    """The words by which a user knows a widget: its name, else its text, else its kind."""
    words = getattr(widget, "text", lambda: "")()
    name = widget.accessibleName() or (words if isinstance(words, str) else "") or type(widget).__name__
    return str(name).replace("&", "")


def marks(project: Any) -> dict[str, Any]:
    """All that a user would miss in a document, as JSON."""
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
        "measured": getattr(material.measured, "name", None),
        "excluded": sorted(project.excluded),
        "compared": [entry.name for entry in project.comparison.entries],
        "runs": [[run.number, run.name] for run in project.factoring.runs],
        "mesh": mesh.name if mesh is not None else None,
        "surface": project.surface is not None,
        "light": project.environment.name if project.environment is not None else None,
        "look": repr(project.look),
        "camera": repr(project.camera),
        "bakes": repr(sorted(project.bakes.items(), key=str)),
    }


@dataclass
class User:
    """Mouse, keys and eyes of somebody at the display, and the process of the program that runs now.

    `clicks` are those of the mouse, drags among them, `pressed` keys (a text that is typed is one), and `waited_s` the
    seconds until something was there that was waited for. `steps` are clicks, drags, chords of keys and typed texts in
    their order, each with the seconds of waiting that followed; `shows_steps` keeps an image of the display before
    each of them. One who `is_new` begins at the start page; others in Capture. `moments` are seconds since `begun`, the
    start of the program; `notices` are the words of all banners and messages that were seen, but for
    the offer to name a project.
    """

    folder: Path
    process: subprocess.Popen[bytes] | None = None
    shots: int = 0
    clicks: int = 0
    pressed: int = 0
    waited_s: float = 0.0
    compared: list[Seen] = field(default_factory=list)
    steps: list[Seen] = field(default_factory=list)
    shows_steps: bool = False
    is_new: bool = False
    begun: float = 0.0
    moments: dict[str, float] = field(default_factory=dict)
    notices: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.folder = self.folder.absolute()  # a relative XDG_DATA_HOME would be passed over for the user's own

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
        places |= {"XDG_CACHE_HOME": os.environ.get("XDG_CACHE_HOME", str(Path.home() / ".cache"))}  # has kernels
        places |= {"HOME": str(self.folder)}
        words = [sys.executable, __file__, str(self.folder / "seen.json"), *map(str, paths)]
        log = (self.folder / "log.txt").open("ab")
        self.begun = time.monotonic()
        self.process = subprocess.Popen(words, env={**os.environ, **places}, stdout=log, stderr=log)
        self.until(lambda seen: bool(seen), "the window")
        do("search", "--sync", "--onlyvisible", "--name", "Lightarc", "windowactivate", "--sync")
        time.sleep(4 * PAUSE_S)
        self.leave_tour()
        if not paths and not self.is_new and self.seen["workspace"] == "start":
            do("key", "ctrl+1")  # the work of these sessions begins in Capture
            self.until(lambda seen: seen["workspace"] == "capture", "the Capture workspace", 60.0)

    def leave_tour(self) -> None:
        """End the welcome tour where it stands."""
        while "Welcome tour" in self.seen.get("places", ()) and "End" in self.seen["places"]:
            x, y, width, height = self.seen["places"]["End"]
            do("mousemove", x + width // 2, y + height // 2, "click", 1)
            time.sleep(4 * PAUSE_S)

    def until(self, is_so: Callable[[Seen], bool], what: str, within_s: float = PATIENCE_S) -> Seen:
        """Wait until what is seen `is_so`."""
        begun = time.monotonic()
        while time.monotonic() < begun + within_s:
            seen = self.seen
            said = {cause: words for cause, words in seen.get("banners", {}).items() if cause != "name"}
            new = [*said.values(), *seen.get("messages", ())]
            self.notices += [words for words in new if words not in self.notices]
            if seen and is_so(seen):
                waited_s = time.monotonic() - begun
                self.waited_s += waited_s
                if self.steps:
                    self.steps[-1]["waited_s"] += waited_s
                return seen
            if self.process is not None and self.process.poll() is not None:
                break
            time.sleep(PAUSE_S)
        self.shoot("waited-in-vain")
        raise SystemExit(f"waited in vain for {what}; {self.seen.get('banners')}, {self.seen.get('dialogs')}")

    def let_it_follow(self) -> None:
        """Give the window time to do what it was told, however busy the machine is, before the next event."""
        told = time.monotonic()
        time.sleep(PAUSE_S)
        while time.monotonic() < told + 60.0 and self.process is not None and self.process.poll() is None:
            if self.seen.get("look", 0.0) > told + PAUSE_S:
                break
            time.sleep(PAUSE_S / 2)
        self.leave_tour()

    def step(self, words: str) -> None:
        """Note a step, which is about to be done."""
        if self.shows_steps:
            self.shoot(f"before {words}".replace("/", " ")[:60])
        self.steps.append({"step": words, "waited_s": 0.0})

    def keys(self, *keys: str) -> None:
        """Press keys, by their names in X, one after the other."""
        for key in keys:
            self.step(f"press {key}")
            do("key", "--clearmodifiers", key)
            self.pressed += 1
            self.let_it_follow()

    def write(self, words: str) -> None:
        """Type `words`."""
        self.step(f"type {Path(words).name if words.startswith('/') else words}")
        do("type", "--delay", "40", words)
        self.pressed += 1
        self.let_it_follow()

    def place(self, name: str, across: float = 0.5, down: float = 0.5) -> tuple[int, int]:
        """A point of the widget that is called `name`, by shares of its size."""
        before, looked, waited_s = list[int](), 0.0, self.waited_s
        last_s = self.steps[-1]["waited_s"] if self.steps else 0.0
        while True:  # until the layout rests, in two looks from within that are a second apart
            seen = self.until(
                lambda seen, after=looked + 1.0: name in seen["places"] and seen["look"] > after,
                f"the widget {name!r}",
            )
            if seen["places"][name] == before:
                break
            before, looked = seen["places"][name], seen["look"]
        self.waited_s = waited_s
        if self.steps:
            self.steps[-1]["waited_s"] = last_s
        x, y, width, height = seen["places"][name]
        return round(x + across * width), round(y + down * height)

    def click(self, name: str, across: float = 0.5, down: float = 0.5) -> None:
        """Click the middle of the widget that is called `name`, or another point of it."""
        place = self.place(name, across, down)
        self.step(f"click {name}")
        do("mousemove", *place)
        time.sleep(PAUSE_S)
        do("click", 1)
        self.clicks += 1
        self.let_it_follow()

    def drag(self, name: str, start: tuple[float, float], end: tuple[float, float], key: str = "") -> None:
        """Drag within the widget `name`, with a key held down where one is given."""
        first, last = self.place(name, *start), self.place(name, *end)
        self.step(f"drag in {name}{f' with {key}' if key else ''}")
        do("mousemove", *first, *(("keydown", key) if key else ()), "mousedown", 1)
        for step in range(1, 9):
            do("mousemove", *(round(a + (b - a) * step / 8) for a, b in zip(first, last, strict=True)))
            time.sleep(PAUSE_S / 4)
        do("mouseup", 1, *(("keyup", key) if key else ()))
        self.clicks += 1
        self.let_it_follow()

    def shoot(self, name: str) -> None:
        """Keep an image of the display."""
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
        self.shoot(f"{name}-before")
        assert self.process is not None
        os.kill(self.process.pid, signal.SIGKILL)
        self.process.wait()
        self.start()
        self.until(lambda seen: seen["path"] == before["path"], "the project that was open")
        time.sleep(8 * PAUSE_S)
        self.shoot(f"{name}-after")
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
        self.shoot(title.lower().replace(" ", "-"))
        self.keys("Return")
        self.until(lambda seen: title not in seen["dialogs"], "the end of the dialog", 60.0)

    def go_on(self) -> None:
        """Go on with the work that was interrupted: a user whose click was lost clicks again."""
        self.until(lambda seen: bool(buttons_to_go_on(seen)), "a button to go on")
        for _ in range(5):
            for name in buttons_to_go_on(self.seen)[:1]:
                self.click(name)
            time.sleep(8 * PAUSE_S)
            if not buttons_to_go_on(self.seen):
                return
        raise SystemExit("the button to go on stays")

    def close(self) -> int:
        """Quit by the keyboard; the exit code."""
        assert self.process is not None
        self.keys("ctrl+q")
        return self.process.wait(PATIENCE_S)


def buttons_to_go_on(seen: dict) -> list[str]:
    """Names of the buttons that offer to go on with something."""
    return [name for name in seen["places"] if name.startswith("Resume")]


def do(*words: object) -> None:
    """One event or more of xdotool."""
    subprocess.run(["xdotool", *map(str, words)], check=True, capture_output=True)


if __name__ == "__main__":
    sys.exit(watch([Path(path) for path in sys.argv[2:]], Path(sys.argv[1])))

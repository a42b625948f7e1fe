"""Sequences of what users do with projects, the program's promises, and the smallest sequence that breaks one.

A sequence is a list of actions, drawn by a seed: edits, undo, models, photographs, long jobs, Save as, new and other
projects, and the ends of a process: Quit, SIGTERM and SIGKILL while jobs run. The window runs in a process of its own
(`driven_window`). `Promises` is a model of what the program has confirmed, made of what the window shows and of nothing
else; when the process has ended, another process reads the project files, and `Promises.broken` compares.

- A save is promised when the user has accepted the dialog: its file holds the document of that moment, or a later one.
- A gesture is promised when the window shows it as saved; before the last action of a process that is killed, the user
  waits until it does. Quit, SIGTERM and every change to another project promise everything that the window shows.
- Nothing half-written is left after an ordinary end.

After SIGKILL a save that the window had not finished may be missing as a whole, but not in part; the project that it
was made of holds everything.
"""

from __future__ import annotations

import json
import os
import random
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

from app.project.project_file import ENDING

#: Seconds after which a process that does not answer is taken to hang; nothing here takes so long.
PATIENCE_S = 120.0

#: Seconds that an accepted save may take while a job runs that never ends: what waits for the job fails.
SAVING_S = 40.0

#: Seconds between two actions, of which one is drawn: from faster than the eye to the time of a thought.
PAUSES_S = (0.0, 0.0, 0.05, 0.2, 0.5)

#: Names of projects that are saved. There are few, so that saves also replace one another.
NAMES = ("felt", "new\nline", '🧵 "quoted" %20')

#: Lanes of jobs that never end; most of what users wait for is computed.
LANES = ("compute", "compute", "compute", "open", "background")

Action = dict[str, Any]
Marks = list[Any]

#: Weights of actions within a sequence.
WEIGHTS = {
    "gain": 4,
    "notes": 3,
    "drag": 2,
    "burst": 2,
    "slices": 1,
    "model": 3,
    "sky": 1,
    "undo": 4,
    "redo": 2,
    "photographs": 2,
    "build": 1,
    "factor": 1,
    "job": 4,
    "slow_disk": 2,
    "cancel": 2,
    "workspace": 1,
    "new": 2,
    "open": 2,
    "save_as": 7,
    "save": 1,
    "wait": 1,
    "quit": 3,
    "terminate": 2,
    "kill": 3,
}

#: Parts of the names of files that are only half there.
HALF_WRITTEN = (".partial", ".unfinished")

#: Actions that end the process of the window; the next action starts another.
ENDS = ("quit", "terminate", "kill")

#: Places in the list of marks (`driven_window.marks`) of what makes a project worth keeping.
NOTES, MESH, SKY, PHOTOGRAPHS = 5, 6, 7, 9


def draw(seed: int) -> list[Action]:
    """The sequence of a seed; its last action ends the process."""
    chance = random.Random(seed)
    actions: list[Action] = [{"do": "notes", "text": f"{seed} begins"}]
    for at in range(chance.randrange(4, 14)):
        (name,) = chance.choices(list(WEIGHTS), list(WEIGHTS.values()))
        actions.append({"do": name, **_choices(name, at, chance), "pause_s": chance.choice(PAUSES_S)})
    if actions[-1]["do"] not in ENDS:
        actions.append({"do": chance.choices(ENDS, [5, 2, 3])[0]})
    return actions


def _choices(name: str, at: int, chance: random.Random) -> dict[str, Any]:
    """What an action is done with; every edit has a value of its own."""
    choices: dict[str, Callable[[], dict[str, Any]]] = {
        "gain": lambda: {"value": round(1.0 + at / 16 + chance.random() / 64, 6)},
        "drag": lambda: {"value": round(3.0 + at / 16 + chance.random() / 64, 6)},
        "notes": lambda: {"text": f"note {at}"},
        "burst": lambda: {"seed": chance.randrange(1000)},
        "slices": lambda: {"value": chance.randrange(2, 16)},
        "model": lambda: {"name": chance.choice(("sphere", "plane", "torus-knot"))},
        "sky": lambda: {"name": chance.choice(("noon", "studio"))},
        "job": lambda: {"lane": chance.choice(LANES), "deaf": chance.random() < 0.3},
        "slow_disk": lambda: {"each_s": chance.choice((0.05, 0.2))},
        "workspace": lambda: {"name": chance.choice(("capture", "material", "brdf", "factor", "view", "export"))},
        "save_as": lambda: {"target": chance.choice(NAMES)},
        "save": lambda: {"target": chance.choice(NAMES)},
        "open": lambda: {"which": chance.randrange(8)},
    }
    return choices[name]() if name in choices else {}


def is_empty(marks: Marks) -> bool:
    """True for a document that no project is kept for, unless it is saved under a name."""
    return not (marks[NOTES] or marks[MESH] or marks[SKY] or marks[PHOTOGRAPHS])


class Promises:
    """What the program has confirmed about each project: the documents of which its file holds one.

    `begun` are saves that were accepted, by target, with the projects that the document has had the path of since;
    `unsure` the targets that a kill may have left as they were, with what was promised of them before.
    """

    def __init__(self) -> None:
        self.allowed: dict[str, list[Marks]] = {}
        self.begun: dict[str, set[str]] = {}
        self.unsure: dict[str, list[Marks]] = {}
        self.moved: set[str] = set()
        self.path = ""
        self.left: tuple[str, Marks] | None = None
        self.faults: list[str] = []

    def leaving(self, path: str) -> None:
        """What moves in this project comes to rest: it is about to be closed, and written before the next is shown.

        Save as comes to rest as well and goes on: a kill may then still find the file before the last gestures.
        """
        self.left = (path, self.allowed[path][-1])

    def switched(self, path: str) -> None:
        """The window has opened this project; one without content gives its path to the next."""
        left, marks = self.left or ("", [])
        if left == path and not is_empty(marks) and self.allowed[path][-1] != marks:
            self.faults.append(f"{Path(path).name} with {marks} was replaced by a new project")
        self.left = None
        self.settle(path)

    def shown(self, path: str, marks: Marks) -> None:
        """The window shows this document in this project."""
        if path != self.path and self.path:
            self.settle(self.path)
            continued = [target for target, paths in self.begun.items() if self.path in paths]
            if path in continued:
                self.moved.add(self.path)
                for target in continued:
                    self.begun[target].add(path)
            else:
                self.begun = {target: set() for target in self.begun}
            self._on_finished(path)
        self.path = path
        self.allowed.setdefault(path, []).append(marks)
        for target, paths in self.begun.items():
            if path in paths and target != path:
                self.allowed[target].append(marks)

    def accepted(self, path: str, target: str) -> None:
        """The user has confirmed to save the document as `target`."""
        if target == path:
            return
        now = self.allowed[path][-1]
        self.unsure[target] = self.unsure.get(target, []) + self.allowed.get(target, [])
        self.allowed[target] = [now]
        self.begun[target] = {path}
        self.moved.discard(target)

    def settle(self, path: str) -> None:
        """The file of `path` holds what the window shows, and nothing earlier."""
        self.allowed[path] = self.allowed.get(path, [])[-1:]

    def _on_finished(self, target: str) -> None:
        self.begun.pop(target, None)
        self.unsure.pop(target, None)

    def ended(self, how: str) -> None:
        """The process has ended: after a kill, saves that were under way may be missing."""
        if how == "kill":
            for target in self.begun:
                self.allowed[target] = [*self.allowed[target], *self.unsure.get(target, [])]
                self.unsure.setdefault(target, [])
        else:
            self.settle(self.path)
            for target in self.begun:  # those that were killed before stay unsure
                self.unsure.pop(target, None)
        self.begun.clear()
        self.path = ""

    def broken(self, read: Callable[[Path], Action]) -> list[str]:
        """Promises that the files do not keep, in words."""
        found = list(self.faults)
        for name, allowed in self.allowed.items():
            path = Path(name)
            if not path.exists():
                may_be_missing = name in self.moved or name in self.unsure or any(map(is_empty, allowed))
                found += [] if may_be_missing else [f"{path.name} is lost; the last of it was {allowed[-1]}"]
                continue
            held = read(path)
            if "error" in held:
                found.append(f"{path.name} cannot be read: {held['error']}")
            elif held["marks"] not in allowed:
                found.append(f"{path.name} holds {held['marks']} in place of {allowed[-3:]}")
            else:
                found += [f"{path.name}: {problem}" for problem in held["problems"]]
        return found


class Link:
    """One connection to the program `driven_window`: lines of JSON in both directions."""

    def __init__(self, server: Path, first: Action) -> None:
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.settimeout(PATIENCE_S)
        self.socket.connect(str(server))
        self.lines = self.socket.makefile("rb")
        self.send(first)

    def send(self, words: Action) -> None:
        with suppress(BrokenPipeError, ConnectionResetError):  # the next line that is heard says that it is gone
            self.socket.sendall(json.dumps(words).encode() + b"\n")

    def hear(self) -> Action:
        return dict(json.loads(self.lines.readline() or b'{"event": "ended", "code": null}'))

    def has_line(self) -> bool:
        """True if something can be heard without waiting."""
        self.socket.setblocking(False)
        try:
            return bool(self.lines.peek())
        finally:
            self.socket.settimeout(PATIENCE_S)

    def has_line_within(self, seconds: float) -> bool:
        """Wait until something can be heard, but no longer; whether that is so."""
        until = time.monotonic() + seconds
        while not self.has_line():
            if time.monotonic() >= until:
                return False
            time.sleep(0.002)
        return True

    def close(self) -> None:
        self.lines.close()
        self.socket.close()


@contextmanager
def server(folder: Path) -> Iterator[Path]:
    """The program `driven_window`, ready for connections at a socket in `folder`."""
    place, log = folder / "socket", (folder / "server.txt").open("wb")
    command = [sys.executable, "-m", "tests.app.project.driven_window", str(place)]
    one_thread = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "LP_NUM_THREADS": "1"}  # it forks
    process = subprocess.Popen(
        command,
        env={**os.environ, **one_thread},
        cwd=Path(__file__).parents[3],
        stdout=subprocess.PIPE,
        stderr=log,
        start_new_session=True,
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == b"listening\n", (folder / "server.txt").read_text()
        yield place
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        log.close()


class Play:
    """One sequence, done in windows of its own in `folder`."""

    def __init__(self, server: Path, folder: Path, photographs: Path) -> None:
        self.server, self.folder, self.photographs = server, folder, photographs
        self.promises = Promises()
        self.link: Link | None = None
        self.pid = 0
        self.killed: list[int] = []
        self.is_saved = self.is_baking = self.is_baked = False
        self.ended_by = ""
        self.said: list[str] = []
        self.saving_s: list[float] = []
        settings = folder / "config" / "lightarc" / "settings.json"
        settings.parent.mkdir(parents=True)
        settings.write_text(json.dumps({"has_seen_hints": True}))
        (folder / "saved").mkdir()

    def run(self, actions: Sequence[Action]) -> list[str]:
        """Do the actions; the promises that were broken, in words."""
        try:
            for at, action in enumerate(actions):
                kills_next = at + 2 < len(actions) and actions[at + 2]["do"] == "kill"
                self._act(action, before_last=kills_next)
            self._end("quit")
            return [*self.promises.broken(partial(read_project, self.server)), *self.left_behind()]
        except Hang as reason:
            if self.pid:
                os.kill(self.pid, signal.SIGKILL)
            self.promises.ended("kill")
            return [str(reason), *self.promises.broken(partial(read_project, self.server))]
        finally:
            if self.link is not None:
                self.link.close()

    def _act(self, action: Action, *, before_last: bool) -> None:
        name = action["do"]
        if name in ENDS:
            time.sleep(action.get("pause_s", 0.0))
            self._end(name)
            return
        if self.link is None:
            self._start()
        given = {key: value for key, value in action.items() if key not in ("pause_s", "which")}
        if name == "wait":
            self._wait_for_saves()
        elif name == "wait_until_saved":
            self._until(lambda: self.is_saved, "the window shows its changes as saved")
        elif name == "wait_for_model":
            self._until(lambda: bool(self.promises.allowed[self.promises.path][-1][MESH]), "the model is there")
        elif name == "wait_for_bake":
            self._until(lambda: self.is_baked, "the bake is there")
        elif name == "wait_until_baking":
            self._until(lambda: self.is_baking or self.is_baked, "the bake begins")
        elif name == "open":
            known = sorted(path for path in self.promises.allowed if Path(path).exists())
            if known:
                self._do({"do": "open", "path": known[action["which"] % len(known)]})
        else:
            if name == "photographs":
                given["path"] = str(self.photographs)
            if "target" in given:
                given["target"] = str(self.folder / "saved" / f"{given['target']}{ENDING}")
            self._do(given)
        self._listen_for(action.get("pause_s", 0.0))
        if before_last:
            self._until(lambda: self.is_saved, "the window shows its changes as saved")

    def _start(self) -> None:
        self.link = Link(self.server, {"folder": str(self.folder), "files": []})
        ready = self._until_event("ready")
        self.pid = int(ready["pid"])

    def _do(self, action: Action) -> None:
        assert self.link is not None
        self.link.send(action)
        self._until_event("done")

    def _end(self, how: str) -> None:
        """Let the process end, and hear what it said until then."""
        if self.link is None:
            return
        self.ended_by = how
        if how == "quit":
            self.link.send({"do": "quit"})
        else:
            os.kill(self.pid, signal.SIGKILL if how == "kill" else signal.SIGTERM)
        if how == "kill":
            self.killed.append(self.pid)
        begun = time.monotonic()
        while self.link is not None:
            self._hear(f"the end of the process after {how}", begun)

    def _until_event(self, name: str) -> Action:
        begun = time.monotonic()
        while True:
            event = self._hear(f"the event {name!r}", begun)
            if event["event"] in (name, "ended"):
                return event

    def _until(self, is_so: Callable[[], bool], what: str, within_s: float = PATIENCE_S) -> None:
        begun = time.monotonic()
        while self.link is not None and not is_so():
            self._listen_for(0.05)
            if time.monotonic() - begun > within_s:
                raise Hang(f"waited in vain until {what}")

    def _wait_for_saves(self) -> None:
        """A user waits until the saves are done, whatever runs."""
        begun = time.monotonic()
        waiting = tuple(self.promises.begun)
        self._until(lambda: all(Path(target).exists() for target in waiting), "an accepted save is there", SAVING_S)
        if waiting:
            self.saving_s.append(time.monotonic() - begun)

    def _listen_for(self, seconds: float) -> None:
        until = time.monotonic() + seconds
        while self.link is not None:
            if self.link.has_line():
                self._hear("an event", time.monotonic())
            elif time.monotonic() >= until:
                return
            else:
                time.sleep(0.01)

    def _hear(self, what: str, since: float) -> Action:
        """Take in one event."""
        assert self.link is not None
        try:
            event = self.link.hear()
        except TimeoutError:
            raise Hang(f"{what} did not come within {time.monotonic() - since:.0f} s") from None
        kind = event["event"]
        if kind == "shown":
            self.is_saved = False
            self.promises.shown(event["path"], event["marks"])
        elif kind == "saved":
            self.is_saved = True
            self.promises.settle(event["path"])
        elif kind == "baking":
            self.is_baking, self.is_baked = True, event["is_made"]
        elif kind == "leaving":
            self.promises.leaving(event["path"])
        elif kind == "switched":
            self.promises.switched(event["path"])
        elif kind == "accepted":
            self.promises.accepted(event["path"], event["target"])
        elif kind == "failed":
            self.said.append(event["message"])
            if event["fault"]:
                self.promises.faults.append(f"a fault of the program: {event['message']}")
        elif kind == "ended":
            self._on_ended(event["code"])
        return event

    def _on_ended(self, code: int | None) -> None:
        assert self.link is not None
        self.link.close()
        self.link, self.pid, how = None, 0, self.ended_by
        expected = {"quit": 0, "terminate": 0, "kill": -signal.SIGKILL}.get(how)
        if code != expected:
            log = (self.folder / "log.txt").read_text(errors="replace")[-1500:]
            self.promises.faults.append(f"the process ended with {code} after {how or 'nothing'}; {log}")
        self.promises.ended(how or "kill")
        self.ended_by, self.is_baking, self.is_baked = "", False, False

    def left_behind(self, *, also_of_killed: bool = False) -> list[str]:
        """Names of half-written files beside the projects; those of a killed process go with the next start."""
        places = (self.folder / "saved", self.folder / "data" / "lightarc" / "projects")
        names = [path.name for place in places if place.is_dir() for path in place.rglob("*")]
        if not also_of_killed:
            names = [name for name in names if not any(f"-{pid}-" in name for pid in self.killed)]
        return [f"{name} is half-written" for name in names if any(each in name for each in HALF_WRITTEN)]


def read_project(server: Path, path: Path) -> Action:
    """The marks and problems of a project file, or the error, read in another process."""
    link = Link(server, {"read": str(path)})
    try:
        return dict(json.loads(link.lines.readline() or b'{"error": "the reader ended"}'))
    finally:
        link.close()


class Hang(Exception):
    """The program does not go on."""


def smallest(actions: Sequence[Action], fails: Callable[[Sequence[Action]], bool], tries: int) -> list[Action]:
    """The smallest sequence that `fails`, found by leaving actions out, in halves first (ddmin), in at most `tries`."""
    now, parts = list(actions), 2
    while len(now) > 1 and tries > 0:
        size = -(-len(now) // parts)
        for start in range(0, len(now), size):
            candidate = now[:start] + now[start + size :]
            tries -= 1
            if candidate and fails(candidate):
                now, parts = candidate, max(parts - 1, 2)
                break
            if tries <= 0:
                break
        else:
            if size == 1:
                break
            parts = min(len(now), 2 * parts)
    return now


def text_of(actions: Sequence[Action]) -> str:
    """A sequence as lines to read, or to give to `json.loads`."""
    return "\n".join(json.dumps(action, ensure_ascii=False) for action in actions)

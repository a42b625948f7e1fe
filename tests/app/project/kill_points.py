"""A session of gestures, killed at its I/O operations: the program that `test_kill_points` starts.

    python -m tests.app.project.kill_points FOLDER SEED POINTS

draws a session of `GESTURES` by its seed and kills it at `POINTS` operations, or at all where that is 0. Each gesture
is first done undisturbed, which counts its operations: those of SQLite, through its table of system calls, and those of
`engine.storage.atomic`. Then for each chosen operation the project is put back to before the gesture, a child opens it,
does the gesture and gets SIGKILL there, at every second one in the middle of a write. What it left is read: every
gesture that was acknowledged is there, no other but the one in progress, and derived data are complete or absent (of a
sample, at every fifth point). Prints one JSON object: `points`, `operations`, and `failures` in words.
"""

from __future__ import annotations

import _sqlite3
import ctypes
import dataclasses
import json
import os
import random
import shutil
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from app.document.bake_request import choices_for
from app.document.comparison import Comparison, Entry
from app.document.document import Look, Project, Step
from app.document.factoring import Factoring, Run
from app.project import places
from app.project.bakes import KIND, tidy
from app.project.interrupted import interrupt_in, running
from app.project.made import keep_newest, note
from app.project.project_file import History, Opened, Writer, data_folder, read
from app.project.report import problems_of
from app.project.values import name_of
from engine.brdf.brdf import brdf_from_text
from engine.brdf.table import HalfDifferenceTable
from engine.core.errors import FileError
from engine.core.steps import drain
from engine.factor.settings import FactorSettings
from engine.geometry.camera import Camera
from engine.geometry.mesh import Mesh
from engine.scene.material import Material
from engine.shading.shading_map import ShadingMap
from engine.storage import atomic
from engine.transport.baking.file import open_transport, plan_transport, writing

GESTURES = 40

#: Kinds of gestures, and how often each is drawn.
KINDS = {
    "look": 6,
    "camera": 2,
    "mesh": 3,
    "material": 3,
    "table": 3,
    "undo": 5,
    "redo": 3,
    "factor": 3,
    "bake": 3,
    "setting": 3,
}

RECORD = "factors.json"

CHOICES = FactorSettings(side=4, products=1)

Derive = Callable[[Path], None]


class Death:
    """Counts I/O operations, and kills this process at one of them; `torn` lets half of a write be done before."""

    def __init__(self) -> None:
        self.count, self.at, self.torn, self._is_near = 0, -1, False, False

    def arm(self, at: int, torn: bool) -> None:
        self.count, self.at, self.torn = 0, at, torn

    def point(self) -> bool:
        """One operation is about to happen; True where it is the last one and shall be done in part."""
        self.count += 1
        if self._is_near or (self.count == self.at and not self.torn):
            os.kill(os.getpid(), signal.SIGKILL)
        return self.count == self.at

    def watch_atomic(self, operation: str, _path: Path) -> int | None:
        """Hook of `engine.storage.atomic.fault`: bytes of a write that are let through."""
        if not self.point():
            return None
        if operation != "write":
            os.kill(os.getpid(), signal.SIGKILL)
        self._is_near = True
        return 7


DEATH = Death()


class Vfs(ctypes.Structure):
    """The beginning of `sqlite3_vfs` (sqlite.org/c3ref/vfs.html)."""

    _fields_ = (
        ("version", ctypes.c_int),
        ("file_bytes", ctypes.c_int),
        ("longest_path", ctypes.c_int),
        ("others", ctypes.c_void_p * 16),
        ("set_call", ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p)),
        ("get_call", ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p, ctypes.c_char_p)),
    )


_kept: list[Any] = []


def watch_sqlite() -> tuple[str, ...]:
    """Let `DEATH` see the system calls of SQLite that change files; gives their names."""
    library = ctypes.CDLL(_sqlite3.__file__)
    library.sqlite3_vfs_find.restype = ctypes.POINTER(Vfs)
    found = library.sqlite3_vfs_find(None)
    word, place = ctypes.c_ssize_t, ctypes.c_void_p
    calls: dict[str, Any] = {
        "write": (word, ctypes.c_int, place, ctypes.c_size_t),
        "pwrite": (word, ctypes.c_int, place, ctypes.c_size_t, ctypes.c_int64),
        "pwrite64": (word, ctypes.c_int, place, ctypes.c_size_t, ctypes.c_int64),
        "ftruncate": (ctypes.c_int, ctypes.c_int, ctypes.c_int64),
        "unlink": (ctypes.c_int, ctypes.c_char_p),
        "openDirectory": (ctypes.c_int, ctypes.c_char_p, place),
    }
    watched = []
    for name, kinds in calls.items():
        address = found.contents.get_call(found, name.encode())
        if not address:
            continue
        kind = ctypes.CFUNCTYPE(*kinds, use_errno=True)
        call = kind(_watch(name, kind(address)))
        _kept.append(call)
        if found.contents.set_call(found, name.encode(), ctypes.cast(call, place)) == 0:
            watched.append(name)
    return tuple(watched)


def _watch(name: str, original: Any) -> Callable[..., int]:
    def call(*given: Any) -> int:
        if DEATH.point():
            if "write" in name:
                original(*given[:2], given[2] // 2, *given[3:])
            os.kill(os.getpid(), signal.SIGKILL)
        return int(original(*given))

    return call


def change(current: Project, kind: str, chance: random.Random) -> dict[str, Any]:
    """Parts of the document after a gesture."""
    at = chance.randrange(1 << 20)
    if kind == "mesh":
        corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1 + at]], np.float64)
        normals, uv = np.tile(np.array([0, 0, 1], np.float32), (4, 1)), np.zeros((4, 2), np.float32)
        faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], np.int32)
        return {"mesh": Mesh(corners, normals, uv, faces, f"mesh {at}")}
    if kind == "material":
        slices = np.full((2, 24, 32, 3), at, np.float32)
        slices[1] += 1.0
        return {"material": Material(ShadingMap(slices, 1.0, np.array([0.5, 1.0])), None, brdf="lambert", name="Felt")}
    if kind == "table":
        table = HalfDifferenceTable(np.full((4, 5, 6, 3), at / 2**20), np.zeros((4, 5, 6), bool), "measured", "table")
        return {"comparison": Comparison((Entry(f"measured {at}", table, at % 12, path=Path("/gone")),))}
    if kind == "factor":
        return {"factoring": Factoring().with_run(Run(at, 0, "GGX", "material", CHOICES, factor_brdf(at)))}
    if kind == "setting":
        return {"bakes": {"sh": choices_for("sh", order=3 + at % 5).values}}
    return {"look": dataclasses.replace(current.look, gain=1.0 + at / 2**20) if kind == "look" else current.look}


def factor_brdf(at: int) -> Any:
    return brdf_from_text(f"ggx:alpha={0.2 + at / 2**22}")


def after(opened: Opened, kind: str, tag: str, chance: random.Random) -> History:
    """The history after a gesture."""
    if kind == "undo" and opened.position > 0:
        step = opened.steps[opened.position - 1]
        return History(opened.state(str(step.old)), opened.steps, opened.position - 1)
    if kind == "redo" and opened.position < len(opened.steps):
        step = opened.steps[opened.position]
        return History(opened.state(str(step.new)), opened.steps, opened.position + 1)
    if kind == "camera":
        camera = Camera((float(chance.random()), 1.0, 2.0))
        return History(dataclasses.replace(opened.current, camera=camera), opened.steps, opened.position)
    parts = change(opened.current, "look" if kind in ("undo", "redo", "bake") else kind, chance)
    new = dataclasses.replace(opened.current, name=tag, **parts)
    step = Step(f"Gesture {tag}", kind, opened.current, new)
    return History(new, (*opened.steps[: opened.position], step), opened.position + 1)


def derive(kind: str, chance: random.Random) -> Derive | None:
    """The work of a job that follows a gesture, as it is written: factors file by file, a bake chunk by chunk."""
    at = chance.randrange(1 << 20)

    def factors(folder: Path) -> None:
        place = folder / f"factors-{at:040x}"
        with atomic.atomic_folder(place, RECORD, 1 << 12) as partial:
            names = [f"{chance.randrange(1 << 20)}.exr" for _ in range(4)]
            for name in names:
                atomic.write_bytes(partial / name, name.encode())
            atomic.write_bytes(partial / RECORD, json.dumps(names).encode())
        note(place, "factors", 1.0)
        keep_newest(folder, "factors-*", 3)

    def bake(folder: Path) -> None:
        corners = np.arange(12, dtype=np.float64).reshape(4, 3)
        faces, bounds = np.array([[0, 1, 2]], np.int32), np.arange(4)
        mesh = Mesh(corners, corners.astype(np.float32), np.zeros((4, 2), np.float32), faces, "mesh")
        plan = plan_transport("sh", mesh, {"order": at}, {}, {"rows": ("<f4", (5,))}, bounds)
        place = folder / f"{KIND}-{at:024x}-{at:012x}.transport"
        with writing(place, plan) as output:
            for chunk in output.missing:
                output.put(chunk, {"rows": np.full((1, 5), chunk, "<f4")})
        note(place, KIND, 1.0, {"method": "sh", "settings": {}, "effects": None})
        tidy(folder)

    return {"factor": factors, "bake": bake}.get(kind)


def gesture(path: Path, tag: str, seed: str, told: int) -> None:
    """Open the project, do one gesture and the job that follows; `told` is a pipe that hears when it is on disk."""
    chance = random.Random(seed)
    kind = chance.choices(list(KINDS), list(KINDS.values()))[0]
    folder = data_folder(path)
    places.claim(path)
    opened, writer = read(path), Writer(path)
    writer.write(History(opened.current, opened.steps, opened.position))
    history = after(opened, kind, tag, chance)
    writer.write(history)
    os.write(told, b"!")
    work = derive(kind, chance)
    if work is not None:
        with running(folder, f"Job {tag}", {"kind": kind}):
            work(folder)
    if chance.random() < 0.3:
        writer.close()
    places.release(path)


def in_child(path: Path, tag: str, seed: str, at: int, torn: bool) -> tuple[bool, bool, int]:
    """True if the gesture was acknowledged, True if the child was killed, and its number of operations."""
    hears, told = os.pipe()
    process = os.fork()
    if process == 0:
        code = 1
        try:
            os.close(hears)
            DEATH.arm(at, torn)
            gesture(path, tag, seed, told)
            os.write(told, DEATH.count.to_bytes(4, "little"))
            code = 0
        finally:
            os._exit(code)
    os.close(told)
    said = b""
    while part := os.read(hears, 16):
        said += part
    os.close(hears)
    _, status = os.waitpid(process, 0)
    if not os.WIFSIGNALED(status) and os.WEXITSTATUS(status) != 0:
        raise RuntimeError(f"gesture {tag} failed by itself")
    count = int.from_bytes(said[1:], "little") if len(said) == 5 else 0
    return bool(said), os.WIFSIGNALED(status), count


def state_of(path: Path) -> tuple[Any, ...]:
    """Marks of what a project holds: its state by its hash, the number of steps and the position."""
    from app.project.report import identity

    marks, opened = identity(path), read(path)
    return marks["state"], len(opened.steps), opened.position, opened.current.name


def faults(path: Path) -> list[str]:
    """Faults of the project at `path`, in words: what cannot be read, or is there in part."""
    found = drain(problems_of(path))
    opened, folder = read(path), data_folder(path)
    found += [f"{part} is gone" for part in opened.missing]
    for place in folder.glob("arrays/*.npy"):
        if not place.name.startswith(".") and name_of(place.read_bytes()) != place.stem:
            found.append(f"{place.name} is there in part")
    for place in folder.glob(f"{KIND}-*"):
        try:
            open_transport(place)
        except FileError as error:
            found.append(str(error))
    for place in folder.glob("factors-*"):
        names = json.loads((place / RECORD).read_bytes())
        if any((place / name).read_bytes() != name.encode() for name in names):
            found.append(f"{place.name} is there in part")
    interrupt_in(folder)
    return found


def copy(source: Path, target: Path) -> None:
    """Let the folder `target` be as `source`. Arrays are never changed, so they are not copied but named twice."""
    shutil.rmtree(target, ignore_errors=True)

    def one(here: str, there: str) -> None:
        (os.link if here.endswith(".npy") else shutil.copyfile)(here, there)

    shutil.copytree(source, target, copy_function=one)


def session(folder: Path, seed: int, points: int) -> dict[str, Any]:
    """Kill one session at `points` of its operations, all where that is 0."""
    path, before = folder / "now" / "a.lap", folder / "before"
    path.parent.mkdir(parents=True)
    writer = Writer(path)
    writer.write(History(Project(name="new", look=Look())))
    writer.close()
    done, operations, failures = 0, 0, []
    for at in range(GESTURES):
        tag, drawn = f"{seed}.{at}", f"{seed} {at}"
        copy(path.parent, before)
        old = state_of(path)
        _, _, count = in_child(path, tag, drawn, -1, torn=False)
        new, whole = state_of(path), folder / "whole"
        copy(path.parent, whole)
        operations += count
        everywhere = list(range(1, count + 1))
        share = points // GESTURES + (at < points % GESTURES)
        chosen = everywhere if points == 0 else sorted(random.Random(drawn).sample(everywhere, min(share, count)))
        for point in chosen:
            copy(before, path.parent)
            acknowledged, was_killed, _ = in_child(path, tag, drawn, point, (point + seed) % 2 == 1)
            where = f"seed {seed}, gesture {at}, operation {point}"
            done += was_killed  # its last operations may be fewer than those of the undisturbed child
            try:
                now, wrong = state_of(path), faults(path) if points == 0 or done % 5 == 0 else []
            except Exception as error:  # of any kind: this program looks for them
                now, wrong = old, [f"{type(error).__name__}: {error}"]
            if now != new and (acknowledged or now != old):
                wrong.append(f"holds {now} in place of {new}{'' if acknowledged else f' or {old}'}")
            failures += [f"{where}: {each}" for each in wrong]
        copy(whole, path.parent)
        failures += [f"seed {seed}, gesture {at}, undisturbed: {each}" for each in faults(path)]
    return {"points": done, "operations": operations, "failures": failures[:20]}


if __name__ == "__main__":
    calls = watch_sqlite()
    atomic.fault = DEATH.watch_atomic
    if not {"write", "pwrite", "pwrite64"} & set(calls):
        sys.exit("this SQLite does not let its writes be watched")
    place = Path(sys.argv[1])
    print(json.dumps(session(place, int(sys.argv[2]), int(sys.argv[3])) | {"calls": calls}))

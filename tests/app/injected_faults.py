"""Failures of the disk and of memory in verbs and functions of the library, one at a time, by seed.

    python -m tests.app.injected_faults SEED COUNT

Failure N is drawn by a generator with the seed N: one of the scenarios, and in it one operation of three kinds. The
operations of `engine.storage.atomic` (write, flush, rename, close and so on) and everything that Python tells of files
to `sys.addaudithook` (opening, listing, mapping, making and removing) fail with an error of the system; arrays of numpy
find no memory. All run in one process, so that a failure costs tens of milliseconds.

The rule: a verb ends with a known exit code and one sentence, a function with a LightarcError; inputs stay as they
were; an output is complete or absent, and nothing half-written stays.
"""

from __future__ import annotations

import contextlib
import errno
import io
import json
import logging
import os
import random
import shutil
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

import lightarc
from app import command_line
from app.arguments.usage import BAD_FILE, DONE, MISSING, OUT_OF_MEMORY
from app.project.project_file import is_waiting
from engine.core.errors import LightarcError
from engine.storage import atomic
from tests.app.allocations import FailingAllocator
from tests.app.project.hostile import base
from tests.app.scenarios import SCENARIOS, FailAt, photograph

Kind = Literal["atomic", "system", "allocation"]
KINDS: tuple[Kind, ...] = ("atomic", "system", "allocation")

CODES = (errno.ENOSPC, errno.EIO, errno.EACCES, errno.EMFILE, errno.EDQUOT, errno.EROFS)
ALLOWED = (DONE, BAD_FILE, MISSING, OUT_OF_MEMORY)

#: What Python tells of files before it asks the system.
EVENTS = frozenset(
    {
        *("open", "os.listdir", "os.scandir", "os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.truncate"),
        *("os.link", "os.symlink", "os.chmod", "os.utime", "mmap.__new__", "tempfile.mkstemp", "tempfile.mkdtemp"),
        *("shutil.copyfile", "shutil.copymode", "shutil.copystat", "shutil.rmtree", "sqlite3.connect"),
    }
)

#: Operations that clean up: where one fails, what it was to remove stays for the next write.
CLEANING = ("list", "unlink", "rmdir", "os.remove", "os.rmdir", "os.listdir", "os.scandir", "shutil.rmtree")

#: An image that is there before memory fails.
IMAGE = np.full((16, 16, 4), 0.5, np.float32)


@dataclass(frozen=True)
class Work:
    """A verb as `words`, or a `function` of the library; `output` is the name of what it writes, '' for nothing."""

    name: str
    words: str = ""
    function: Callable[[Path, Path], Any] | None = None
    output: str = ""
    read: Callable[[Path], Any] | None = None


def _verbs() -> Iterator[Work]:
    for name, one in SCENARIOS.items():
        if not one.resumed:
            yield Work(name, one.words, None, one.output, one.read)
    yield Work("brdf info", "brdf info {inputs}/paint.csv")
    yield Work("brdf eval", "brdf eval {inputs}/paint.csv --wi-deg 30,0 --wo-deg 30,180")
    yield Work("compare", "compare {inputs}/a.png {inputs}/b.png --difference {output}", None, "d.png")
    yield Work("bundle verify", "bundle verify {inputs}/a.lightarc")
    yield Work("bundle show", "bundle show {inputs}/a.lightarc")
    yield Work(
        "bundle extract", "bundle extract {inputs}/a.lightarc -o {output}", None, "members", lightarc.open_bundle
    )
    for target in ("textures", "materialx", "gltf", "shaders"):
        yield Work(f"export {target}", "export {inputs}/a.lightarc --to " + target + " -o {output}", None, "export")
    yield Work("project info", "project info {inputs}/Felt.lap")
    yield Work("project verify", "project verify {inputs}/Felt.lap")
    yield Work("project collect", "project collect {inputs}/Felt.lap -o {output}", None, "c.lap", _sound)
    yield Work("project recover", "project recover {inputs}/Felt.lap -o {output}", None, "r.lap", _sound)
    yield Work("bundle make", "bundle make {inputs}/Felt.lap -o {output}", None, "f.lightarc", lightarc.open_bundle)
    yield Work("simulate", "simulate --sample plain --size 16 --elevations-deg 30,60 -o {output}", None, "capture")


def _sound(path: Path) -> None:
    from app.project.report import problems_of
    from engine.core.steps import drain

    assert not drain(problems_of(path))


def _functions() -> Iterator[Work]:
    yield Work("open_capture", function=lambda inputs, _: lightarc.open_capture(inputs / "photographs"))
    yield Work(
        "import_capture",
        function=lambda inputs, target: lightarc.import_capture(inputs / "photographs", target, motion="none"),
        output="stack",
        read=lightarc.open_stack,
    )
    yield Work("open_stack", function=lambda inputs, _: lightarc.open_stack(inputs / "stack"))
    yield Work(
        "build_material",
        function=lambda inputs, _: lightarc.build_material(lightarc.open_stack(inputs / "stack"), slices=3),
    )
    yield Work(
        "save_bundle",
        function=lambda inputs, target: lightarc.save_bundle(target, lightarc.open_bundle(inputs / "a.lightarc")),
        output="b.lightarc",
        read=lightarc.open_bundle,
    )
    yield Work("open_bundle", function=lambda inputs, _: lightarc.open_bundle(inputs / "a.lightarc"))
    yield Work("verify_bundle", function=lambda inputs, _: lightarc.verify_bundle(inputs / "a.lightarc"))
    yield Work("open_brdf", function=lambda inputs, _: lightarc.open_brdf(str(inputs / "paint.csv")))
    yield Work("render", function=lambda inputs, _: _render(inputs))
    yield Work(
        "save_image",
        function=lambda _, target: lightarc.save_image(target, IMAGE),
        output="a.exr",
    )
    yield Work("compare ", function=lambda _, __: lightarc.compare(np.ones((64, 64, 4)), np.full((64, 64, 4), 0.9)))


def _render(inputs: Path) -> Any:
    return lightarc.render(str(inputs / "mesh.obj"), brdf="lambert", size=(24, 16))


WORKS = (*_verbs(), *_functions())

#: Works of which a whole run takes milliseconds, and whose inputs are soon made.
QUICK = ("project info", "project recover", "project collect", "save_image")


def prepare(inputs: Path, *, all_works: bool = True) -> None:
    """The inputs of all works, or of `QUICK` alone."""
    from engine.images.encode import encode_png
    from tests.engine.brdf.readers.test_damaged_samples import FILES

    base(inputs)
    for name, value in (("a.png", 100), ("b.png", 110)):
        (inputs / name).write_bytes(encode_png(np.full((16, 16, 3), value, np.uint8)))
    if all_works:
        photograph(inputs)
        assert _end(SCENARIOS["shade"].line(inputs, inputs))[0] == DONE
        (inputs / "paint.csv").write_text(FILES["paint.csv"][0])


_hook: Callable[[str, tuple[Any, ...]], None] | None = None


def _audited(event: str, arguments: tuple[Any, ...]) -> None:
    if _hook is not None and event in EVENTS:
        _hook(event, arguments)


class FailingSystem:
    """Counts what the process asks of files below `folder`, and fails the one numbered `at` (from 0) with `code`."""

    _added = False

    def __init__(self, folder: Path, at: int = -1, code: int = 0) -> None:
        self.folder, self.at, self.code, self.operations = os.fspath(folder), at, code, list[str]()

    def _told(self, event: str, arguments: tuple[Any, ...]) -> None:
        place = arguments[0] if arguments else ""
        place = os.fsdecode(place) if isinstance(place, (str, bytes, os.PathLike)) else ""
        if event != "mmap.__new__" and not place.startswith(self.folder):
            return
        self.operations.append(event)
        if len(self.operations) == self.at + 1:
            raise OSError(self.code, os.strerror(self.code), place or None)

    def __enter__(self) -> FailingSystem:
        global _hook
        if not FailingSystem._added:
            sys.addaudithook(_audited)
            FailingSystem._added = True
        _hook = self._told
        return self

    def __exit__(self, *_: object) -> None:
        global _hook
        _hook = None


def _end(words: list[str]) -> tuple[int, str]:
    """Exit code and standard error of a verb."""
    out, err = (io.TextIOWrapper(io.BytesIO(), "utf-8", write_through=True) for _ in range(2))  # verify prints problems
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = command_line.main(words)
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 1
    said, printed = (stream.buffer.getvalue().decode() for stream in (err, out))
    return code, said or (f"{printed.rstrip().rstrip('.')}." if code != DONE and printed else "")


def _run(work: Work, inputs: Path, folder: Path) -> tuple[int, str]:
    """Exit code and what was said; of a function DONE, or BAD_FILE with the sentence of its error."""
    target = folder / (work.output or "nothing")
    if work.function is None:
        return _end([word.format(inputs=inputs, output=target) for word in work.words.split()])
    try:
        work.function(inputs, target)
    except LightarcError as error:
        return BAD_FILE, f"{error}\n"
    return DONE, ""


def _marks(folder: Path) -> dict[str, tuple[int, int]]:
    return {
        os.fspath(path): (status.st_size, status.st_mtime_ns)
        for path in folder.rglob("*")
        if (status := path.lstat()) and path.is_file()
    }


class Faults:
    """Works with their inputs, in a folder of their own, and how many operations of each kind a work has."""

    def __init__(self, folder: Path, *, all_works: bool = True) -> None:
        self.folder, self.inputs = folder, folder / "inputs"
        prepare(self.inputs, all_works=all_works)
        self.outputs = folder / "outputs"
        self._counts: dict[tuple[str, Kind], int] = {}
        self.marks = _marks(self.inputs)
        self.outcomes = Counter[str]()

    def count(self, work: Work, kind: Kind) -> int:
        """The number of operations of a kind in a work that succeeds."""
        if (work.name, kind) not in self._counts:
            for _ in range(2):  # the first fills caches
                self._fresh()
                with FailAt() as operations, FailingSystem(self.folder) as system:
                    allocator = FailingAllocator()
                    ended = allocator.run(lambda: _run(work, self.inputs, self.outputs))
                assert ended[0] == DONE, f"{work.name}: {ended[1]}"
            self._counts[work.name, "atomic"] = len(operations.operations)
            self._counts[work.name, "system"] = len(system.operations)
            self._counts[work.name, "allocation"] = allocator.count
            self.marks = _marks(self.inputs)
        return self._counts[work.name, kind]

    def _fresh(self) -> None:
        if self.outputs.exists():
            shutil.rmtree(self.outputs)
        self.outputs.mkdir()

    def inject(self, number: int) -> str:
        """Inject the failure of a number; a sentence on the rule that it breaks, '' where none."""
        rng = random.Random(number)
        work = WORKS[number % len(WORKS)]
        kinds = [kind for kind in KINDS if self.count(work, kind)]
        if not kinds:
            return ""
        kind = rng.choice(kinds)
        at, code = rng.randrange(self.count(work, kind)), rng.choice(CODES)
        self._fresh()
        operation = ""
        what = f"{work.name}, {kind} {at} of {self.count(work, kind)}"
        try:
            if kind == "allocation":
                failing = FailingAllocator(at)
                ended = failing.run(lambda: _run(work, self.inputs, self.outputs))
                reached = failing.count > at
            else:
                what += f" with {errno.errorcode[code]}"
                with FailAt(at, code) if kind == "atomic" else FailingSystem(self.folder, at, code) as operations:
                    ended = _run(work, self.inputs, self.outputs)
                reached = len(operations.operations) > at
                operation = operations.operations[at] if reached else ""
                what += f" ({operation})"
        except BaseException as error:  # counted, and told with its number
            if isinstance(error, KeyboardInterrupt):
                raise
            where = traceback.extract_tb(error.__traceback__)[-1]
            place = f"{Path(where.filename).name}:{where.lineno}"
            self.outcomes["FAULT"] += 1
            return f"{what}: {type(error).__name__}: {str(error)[:150]} ({place})"
        self.outcomes["not reached" if not reached else "done" if ended[0] == DONE else "refused"] += 1
        broken = self._broken(work, ended, kind, operation)
        if broken:
            self.outcomes["FAULT"] += 1
        return f"{what}: {broken}" if broken else ""

    def _broken(self, work: Work, ended: tuple[int, str], kind: Kind, operation: str) -> str:
        code, said = ended
        if code not in ALLOWED:
            return f"exit code {code}: {said[-200:]!r}"
        if "Traceback" in said or ".partial-" in said:
            return f"no sentence: {said[-300:]!r}"
        if code != DONE and (not said.strip() or (work.words and not said.rstrip().endswith("."))):
            return f"no sentence: {said[-200:]!r}"
        if kind == "allocation" and code == BAD_FILE and "memory" not in said:
            return f"blames the file: {said[-200:]!r}"
        left = {entry.name for entry in self.outputs.iterdir()}
        if work.output in left:  # data that wait are put in their place when the project is opened
            left -= {work.output, f"{work.output}-data", *filter(is_waiting, left)}
        if left and operation not in CLEANING:
            return f"left {sorted(left)[:3]}"
        if _marks(self.inputs) != self.marks:
            changed = {*_marks(self.inputs).items()} ^ {*self.marks.items()}
            self.marks = _marks(self.inputs)
            return f"inputs have changed: {sorted(changed)[:2]}"
        target = self.outputs / work.output
        if work.output and work.read is not None and target.exists():
            try:
                work.read(target)
            except (LightarcError, AssertionError) as error:
                return f"the output is not whole: {str(error)[:150]}"
        if work.output and code == DONE and not target.exists():
            return "ended well without its output"
        return ""


def main(seed: int, count: int) -> None:
    logging.disable(logging.WARNING)
    os.fsync = lambda fd: None
    shared = "/dev/shm"
    folder = Path(tempfile.mkdtemp(prefix="faults-", dir=shared if os.path.isdir(shared) else None))  # noqa: PTH112
    os.environ |= {f"XDG_{kind}_HOME": str(folder / kind) for kind in ("CONFIG", "DATA")}
    try:
        faults = Faults(folder)
        for number in range(seed, seed + count):
            if broken := faults.inject(number):
                print(f"fault {number}: {broken}", flush=True)
            if (number + 1 - seed) % 100 == 0 or number + 1 == seed + count:
                print(f"seeds {seed} to {number}: {json.dumps(faults.outcomes)}", flush=True)
    finally:
        atomic.fault = None
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))

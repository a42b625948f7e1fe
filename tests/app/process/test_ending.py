"""Ctrl+C, SIGTERM and SIGHUP at any moment of a process: one sentence, exit code 4, and nothing left behind."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from app.project.project_file import read
from tests.app.conftest import NO_DISPLAY
from tests.processes import is_gone

PROJECT = Path(__file__).resolve().parents[3]

pytestmark = pytest.mark.skipif(os.name == "nt", reason="Windows has no such signals")

SENTENCE = "Cancelled; nothing was written.\n"

#: A process that never ends is taken to hang after so many seconds.
HANGS_S = 60

#: Commands that are interrupted, each with its output; all take longer than the process lives.
VERBS = (
    ("simulate", "-o", "out", "--size", "2048"),
    ("factor", "ggx:alpha=0.2", "-o", "out.factors"),
    ("bake", "sphere", "--brdf", "ggx:alpha=0.3", "--mode", "gaussian", "-o", "out.transport"),
    ("render", "sphere", "--brdf", "ggx:alpha=0.3", "--mode", "reference", "--samples", "4000", "-o", "out.png"),
    ("plan", "sphere", "--brdf", "ggx:alpha=0.3", "--env", "sky"),
    ("brdf", "fit", "ggx:alpha=0.3", "--model", "cook-torrance"),
    ("figures", "kautz-6", "--quick", "-o", "out"),
    ("selftest",),
)


def heed() -> None:
    """A shell in the background ignores interrupts, and so does all that it starts."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def start(words: tuple[str, ...], folder: Path, program: str = "") -> subprocess.Popen[str]:
    temporary = folder / "temporary"
    temporary.mkdir(parents=True)
    folders = {f"XDG_{name}_HOME": str(folder / name.lower()) for name in ("CACHE", "CONFIG", "STATE")}
    code = ["-c", program] if program else ["-m", "app"]
    return subprocess.Popen(
        [sys.executable, *code, *words],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, **folders, "PYTHONPATH": str(PROJECT), "TMPDIR": str(temporary)},
        preexec_fn=heed,
    )


@pytest.mark.campaign(rounds=200)
def test_a_signal_at_any_moment_ends_with_4_and_leaves_nothing(seed: int, tmp_path: Path) -> None:
    draw = random.Random(seed)
    for number in range(6 if seed else 2):
        words = draw.choice(VERBS)
        wish = draw.choice([signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
        moment = draw.choice([draw.uniform(0.0, 0.5), draw.uniform(0.0, 8.0 if seed else 2.0)])
        folder = tmp_path / str(number)
        with start(words, folder) as process:
            time.sleep(moment)
            process.send_signal(wish)
            out, err = process.communicate(timeout=HANGS_S)
        case = f"{wish.name} to {words} after {moment:.3f} s: {process.returncode}\n{out}{err}"
        if process.returncode == 0:
            continue
        assert "Exception ignored" not in err, case
        if process.returncode == 4:
            assert "Cancelled" in err + out, case
            assert "Traceback" not in err, case
        else:
            # Python itself was starting: it ends as the system, or its own default, would have it
            assert process.returncode in (-wish, 1), case
            assert str(PROJECT / "app") not in err, case
        kept = [path for path in folder.rglob("*") if path.is_file() and path.suffix != ".unfinished"]
        if "Cancelled" in out:  # the verb says what it keeps: the best factors so far, say
            kept = [path for path in kept if ".partial-" in str(path)]
        assert [path for path in kept if "cache" not in path.parts] == [], case


STUBBORN = """
import hashlib, os, signal, sys, tempfile, threading
from app.process import ending
ending.watch()
from engine.storage.atomic import atomic_file
def wish():
    for number in WISHES:
        os.kill(os.getpid(), number)
with ending.during(ending.INTERRUPT), tempfile.TemporaryDirectory(), atomic_file("out.png") as output:
    output.write(b"half")
    threading.Timer(0.2, wish).start()
    hashlib.pbkdf2_hmac("sha256", b"", b"", 2**31 - 1)  # heeds no signal for half an hour
"""


@pytest.mark.parametrize("wishes", [[signal.SIGTERM], [signal.SIGINT, signal.SIGTERM]], ids=["one", "two"])
def test_a_library_that_does_not_come_back_is_not_waited_for(wishes: list[int], tmp_path: Path) -> None:
    with start((), tmp_path, STUBBORN.replace("WISHES", str([int(number) for number in wishes]))) as process:
        out, err = process.communicate(timeout=HANGS_S)
    assert (process.returncode, out, err) == (4, "", SENTENCE)
    assert [path for path in tmp_path.rglob("*") if path.name != "temporary"] == []


CLOSED = """
import hashlib, os, signal
from app.process import ending
ending.watch()
def close():
    ending.end_within(1.0, 0)  # the window has closed, with all that it had to write
with ending.during(close, 0.5):
    os.kill(os.getpid(), signal.SIGTERM)
    hashlib.pbkdf2_hmac("sha256", b"", b"", 2**31 - 1)  # a job that does not stop
"""


def test_a_window_that_closed_has_done_all_also_where_a_job_does_not_stop(tmp_path: Path) -> None:
    with start((), tmp_path, CLOSED) as process:
        out, err = process.communicate(timeout=HANGS_S)
    assert (process.returncode, out, err) == (0, "", "")


IMPORTING = """
import os, signal, sys, time, types
from app.process import ending
ending.watch()
for name in ("engine.storage.untrusted", "engine.storage.atomic", "app.session.settings"):
    sys.modules[name] = types.ModuleType(name)  # begun, and not yet with anything in it
os.kill(os.getpid(), signal.SIGTERM)
time.sleep(60)
"""


def test_modules_that_are_only_being_imported_do_not_swallow_the_sentence(tmp_path: Path) -> None:
    with start((), tmp_path, IMPORTING) as process:
        out, err = process.communicate(timeout=HANGS_S)
    assert (process.returncode, out, err) == (4, "", SENTENCE)


SWALLOWED = """
import os, signal, sys
from app import __main__; from app import command_line as cli
class Stub:
    def run(options, show):
        try:
            os.kill(os.getpid(), signal.SIGTERM)
            for _ in range(10**9): pass
        except KeyboardInterrupt:
            raise ImportError("a library found something else")
OPTIONS = dict(json=False, quiet=False, log=None, threads=None, memory=None)
class Parser:
    def __init__(self, only): pass
    def parse_args(self, words):
        import argparse
        return argparse.Namespace(module=Stub, verb="stub", **OPTIONS)
cli.build_parser, cli.check_results = Parser, lambda *_: ()
__main__.main()
"""


def test_an_interrupt_that_a_library_turns_into_its_own_error_is_one(tmp_path: Path) -> None:
    with start((), tmp_path, SWALLOWED) as process:
        out, err = process.communicate(timeout=HANGS_S)
    assert (process.returncode, out, err) == (4, "", SENTENCE)


FREED = """
import os, pathlib, signal, sys, tempfile, weakref
from app import __main__; from app import command_line as cli
class Library: pass
library, folder = Library(), tempfile.TemporaryDirectory()
weakref.finalize(library, os.abort)
def run(options, show):
    try:
        os.kill(os.getpid(), signal.SIGTERM)
        for _ in range(10**9): pass
    finally:
        if HANGS:
            for _ in range(10**9): pass
OPTIONS = dict(json=False, quiet=False, log=None, threads=None, memory=None)
class Parser:
    def __init__(self, only): pass
    def parse_args(self, words):
        import argparse
        return argparse.Namespace(module=argparse.Namespace(run=run), verb="stub", **OPTIONS)
cli.build_parser, cli.check_results = Parser, lambda *_: ()
__main__.main()
"""


@pytest.mark.parametrize("hangs", [False, True])
def test_an_interrupt_leaves_what_libraries_hold_alone(hangs: bool, tmp_path: Path) -> None:
    """Numba and Embree free their memory at the end of a process, which crashed where they were at work."""
    with start((), tmp_path, f"HANGS = {hangs}\n{FREED}") as process:
        out, err = process.communicate(timeout=HANGS_S)
    assert (process.returncode, out, err) == (4, "", SENTENCE)
    assert not [*(tmp_path / "temporary").iterdir()]


DONE = """
import atexit, os, signal, sys
from app import __main__; from app import command_line as cli
class Late:
    def __del__(self): os.kill(os.getpid(), signal.SIGTERM)
sys.late = Late()
atexit.register(os.kill, os.getpid(), signal.SIGTERM)
cli.main = lambda: print("done") or 0
__main__.main()
"""


def test_an_end_wished_for_after_the_verb_is_done_does_not_make_it_fail(tmp_path: Path) -> None:
    with start((), tmp_path, DONE) as process:
        out, err = process.communicate(timeout=HANGS_S)
    assert (process.returncode, out, err) == (0, "done\n", "")


WINDOW = """
import os, signal, sys
from PySide6.QtCore import QTimer
from app import __main__; from app.window import main_window
def slot():
    os.kill(os.getpid(), WISH)
    print(sum(range(10**6)), "the slot went on", flush=True)
show = main_window.MainWindow.show
def shown(window):
    show(window)
    print(window.banners.words)
    job = window.bench.jobs.submit("endless", endless, lane="compute")
    job.progressed.connect(lambda _step: begun or begun.append(QTimer.singleShot(300, slot)))
begun = []
def endless():
    from engine.core.steps import Step
    try:
        while True:
            yield Step(0.5, "working")
    finally:
        print("the job was cancelled", flush=True)
main_window.MainWindow.show = shown
sys.argv = ["lightarc"]
__main__.main()
"""


@pytest.mark.skipif(NO_DISPLAY, reason="DISPLAY is not set")
@pytest.mark.parametrize(
    "wish",
    [signal.SIGTERM, *(pytest.param(n, marks=pytest.mark.long) for n in (signal.SIGINT, signal.SIGHUP))],
)
def test_the_window_ends_through_its_event_loop_and_keeps_its_settings(wish: signal.Signals, tmp_path: Path) -> None:
    logs = tmp_path / "state" / "lightarc" / "log"
    if crashed := sys.platform == "linux":
        logs.mkdir(parents=True)
        (logs / f"running-{is_gone(999999999)}.txt").write_text("Fatal Python error: Segmentation fault\n")
    with start((), tmp_path, WINDOW.replace("WISH", str(int(wish)))) as process:
        out, err = process.communicate(timeout=2 * HANGS_S)
    assert process.returncode == 0, err
    assert "the slot went on" in out
    assert "the job was cancelled" in out
    assert "Traceback" not in err
    assert (tmp_path / "config" / "lightarc" / "settings.json").is_file()
    assert [path.name for path in tmp_path.rglob("session-*")] == []
    if crashed:
        assert "Lightarc crashed the last time" in out
        assert [path.name.startswith("crash-") for path in logs.iterdir()] == [True]


SAVING = """
import os, signal, sys, time
from pathlib import Path
from PySide6.QtCore import QTimer
from app import __main__; from app.project import copying; from app.window import main_window, projects
from engine.core.steps import Step
def slow(source, target, **options):
    for at in range(SLOW):
        time.sleep(0.01)
        if at == 10:
            os.kill(os.getpid(), signal.SIGTERM)
        yield Step(0.5, "copying")
    return (yield from copying.copy(source, target, **options))
projects.copy = slow
show = main_window.MainWindow.show
def shown(window):
    show(window)
    window.bench.document.change("Name", name="Felt")
    window.projects.copy_to(Path("Felt.lap"))
main_window.MainWindow.show = shown
sys.argv = ["lightarc"]
from app.process import ending
ending.SAVING_S = LIMIT_S
__main__.main()
"""


@pytest.mark.skipif(NO_DISPLAY, reason="DISPLAY is not set")
@pytest.mark.parametrize(("steps", "limit_s", "code"), [(100, 60.0, 0), (100_000, 1.0, 4)])
def test_a_window_that_the_system_ends_finishes_its_save_within_the_limit(
    steps: int, limit_s: float, code: int, tmp_path: Path
) -> None:
    program = SAVING.replace("SLOW", str(steps)).replace("LIMIT_S", str(limit_s))
    with start((), tmp_path, program) as process:
        _, err = process.communicate(timeout=2 * HANGS_S)
    assert (process.returncode, "Traceback" in err) == (code, False), err
    left = [path.name for path in tmp_path.iterdir() if "Felt" in path.name]
    assert sorted(left) == (["Felt.lap", "Felt.lap-data"] if code == 0 else [])
    if code == 0:
        assert read(tmp_path / "Felt.lap").current.name == "Felt"

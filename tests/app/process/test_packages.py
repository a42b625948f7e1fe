"""Packages that threads share are whole before the first job: the moment in which Python fails otherwise is made."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[3]

#: Two jobs: one loads a package, the other a part of it, which is ready in the moment that importlib takes the package
#: out of `sys.modules`. `ready` is called before, as a job does.
TWO = """
import importlib._bootstrap, sys, threading, types
from pathlib import Path
signals = types.ModuleType("signals")
signals.began, signals.within, signals.out, signals.failed = (threading.Event() for _ in range(4))
sys.modules["signals"] = signals
folder = Path(sys.argv[1], "shared")
folder.mkdir()
(folder / "__init__.py").write_text("import signals; signals.began.set(); signals.within.wait(2.0)")
(folder / "inner.py").write_text("import signals; signals.within.set(); signals.out.wait(2.0)")
sys.path.insert(0, sys.argv[1])
from app.process import packages
packages.SHARED = ("shared",)
ready = packages.load_shared if sys.argv[2] == "ready" else lambda: None
said = []
def watch(frame, event, given):
    if event == "c_return" and getattr(given, "__name__", "") == "pop" and frame.f_code.co_name == "_load_unlocked":
        if frame.f_locals["spec"].name == "shared":
            signals.out.set()
            signals.failed.wait(2.0)
def whole():
    sys.setprofile(watch)
    ready()
    import shared
    said.append("whole")
def part():
    try:
        ready()
        import shared.inner
        said.append("part")
    except KeyError as error:
        said.append(repr(error))
    signals.failed.set()
one, other = threading.Thread(target=whole), threading.Thread(target=part)
one.start()
signals.began.wait(10.0)
other.start()
one.join()
other.join()
print(*sorted(said))
"""


#: Three threads load what the window and its jobs load ahead, as the window does that starts with files; each module is
#: loading until another thread loads as well, or long enough. Prints how many threads loaded side by side at most.
LOADERS = """
import threading, types
from app.process import packages
from app.window import main_window
loading, most, beside = set(), [], threading.Event()
def load(_name=""):
    loading.add(threading.current_thread())
    most.append(len(loading))
    if len(loading) > 1:
        beside.set()
    beside.wait(0.05)
    loading.discard(threading.current_thread())
packages.import_module = load
packages.load_compiler = main_window.crash.with_native_stack = load
packages.SHARED, main_window.LIBRARIES = ("scipy", "cv2"), ("pyqtgraph", "app.material.tab")
main_window.expect = lambda *words: None
class Window:
    tabs, _steps = {}, lambda self, name: self.tabs.setdefault(name, ())
loaders = packages.load_shared, main_window.load_libraries, main_window.load_for_work
threads = [threading.Thread(target=loader) for loader in loaders]
for thread in threads:
    thread.start()
main_window.MainWindow._whole(Window(), "export")
for thread in threads:
    thread.join()
print(len(most), max(most))
"""


def describe(program: str, *arguments: object) -> str:
    command = [sys.executable, "-c", program, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_a_part_that_is_ready_while_its_package_is_put_in_place_does_not_fail(tmp_path: Path) -> None:
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
    assert describe(TWO, tmp_path / "a", "at once") == "KeyError('shared') whole", "the fault of Python is made"
    assert describe(TWO, tmp_path / "b", "ready") == "part whole"


def test_every_package_of_which_the_engine_loads_parts_is_loaded_before_the_first_job() -> None:
    text = "\n".join(path.read_text(encoding="utf-8") for path in (ROOT / "engine").rglob("*.py"))
    named = set(re.findall(r"^\s*(?:from|import) (scipy[\w.]*)", text, re.MULTILINE))
    parents = {name.rpartition(".")[0] for name in named} - {""}
    assert len(parents) > 2
    program = "import sys; from app.process.packages import load_shared; load_shared(); print(*sys.modules)"
    assert parents <= set(describe(program).split())


def test_the_packages_of_the_engine_are_loaded_without_their_modules() -> None:
    program = "import sys; from app.process.packages import load_own; load_own(); print(*sys.modules)"
    loaded = {name for name in describe(program).split() if name.split(".")[0] == "engine"}
    packages = {str(path.parent.relative_to(ROOT)).replace("/", ".") for path in (ROOT / "engine").rglob("__init__.py")}
    assert packages <= loaded
    assert len(loaded) < len(packages) + 3


def test_a_job_of_the_window_begins_when_they_are_loaded(tmp_path: Path) -> None:
    program = """
import sys
from pathlib import Path
from PySide6.QtCore import QCoreApplication
from app.commands.workbench import Workbench
application = QCoreApplication([])
def work():
    from app.process.packages import SHARED
    return set(SHARED) <= set(sys.modules)
    yield
bench = Workbench(Path(sys.argv[1]))
job = bench.jobs.submit("Trying", work, lane="compute")
job.succeeded.connect(print)
for end in (job.succeeded, job.failed):
    end.connect(lambda _: application.quit())
application.exec()
"""
    assert describe(program, tmp_path) == "True"


def test_no_two_threads_load_ahead_side_by_side() -> None:
    assert (
        describe(LOADERS) == "7 1"
    )  # each of two packages, the compiler, two libraries, a workspace, the native stack


def test_an_idle_window_loads_no_library_that_only_work_needs() -> None:
    program = """
import sys
from importlib import import_module
from app.window.main_window import LIBRARIES
for name in ("app.window.application", *LIBRARIES):
    import_module(name)
print(*sys.modules)
"""
    loaded = {name.split(".")[0] for name in describe(program).split()}
    assert loaded & {"numba", "llvmlite", "scipy", "cv2", "matplotlib", "OpenEXR", "tifffile"} == set()

"""Mapped files that are cut short while they are open: an error in words, never the end of the process."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from engine.storage.guarded import is_possible

PROGRAM = """
import gc, os, sys, threading
from pathlib import Path
import numpy as np
from engine.core.errors import InputError
from engine.storage import guarded
from engine.storage.atomic import write_bytes
path, out = Path("mapped"), Path("out")
path.write_bytes(bytes([1]) * 100_000)
numbers = np.frombuffer(guarded.map_file(path), np.uint8)
guarded.check()
os.truncate(path, 5000)
sums = []
thread = threading.Thread(target=lambda: sums.append(int(numbers.sum())))
thread.start()
thread.join()
print(sums, int(numbers.sum()))
for act in (guarded.check, lambda: write_bytes(out, b"computed")):
    try:
        act()
    except InputError as error:
        print(error.path, error.problem)
print(out.exists())
del numbers
gc.collect()
write_bytes(out, b"computed")
print(out.exists())
"""

MAIN = """
import faulthandler, os
from pathlib import Path
import numpy as np
from engine.core.errors import InputError
from engine.storage import guarded
path = Path("mapped")
path.write_bytes(bytes([1]) * 100_000)
numbers = np.frombuffer(guarded.map_file(path), np.uint8)
faulthandler.enable()
guarded.renew()
os.truncate(path, 5000)
try:
    total = int(numbers.sum())
    print("went on")
except InputError as error:
    print(error.path, error.problem)
"""

OTHER = """
import mmap, os
from pathlib import Path
from engine.storage import guarded
for name in ("one", "other"):
    Path(name).write_bytes(bytes([1]) * 100_000)
kept = guarded.map_file(Path("one"))
with open("other", "rb") as file:
    mapped = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
os.truncate("other", 0)
print(mapped[50_000])
"""


def ran(program: str, folder: Path) -> subprocess.CompletedProcess[str]:
    root = Path(__file__).parents[3]
    code = f"import sys; sys.path.insert(0, {str(root)!r})\n{program}"
    return subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True)


@pytest.mark.skipif(not is_possible(), reason="this system cannot guard a mapping, and none is made")
def test_a_mapped_file_that_is_cut_short_is_said_and_nothing_made_of_it_is_kept(tmp_path: Path) -> None:
    found = ran(PROGRAM, tmp_path)
    said = "mapped was cut short while it was open"
    assert found.stdout.splitlines() == ["[5000] 5000", said, said, "False", "True"], found


@pytest.mark.skipif(not is_possible(), reason="this system cannot guard a mapping, and none is made")
def test_the_main_thread_does_not_go_on_with_what_is_gone(tmp_path: Path) -> None:
    """Also where another handler for faults was put in the place of the guard's meanwhile."""
    found = ran(MAIN, tmp_path)
    assert found.stdout.splitlines() == ["mapped was cut short while it was open"], found


@pytest.mark.skipif(not is_possible(), reason="this system cannot guard a mapping, and none is made")
def test_a_fault_elsewhere_ends_the_process_as_before(tmp_path: Path) -> None:
    assert ran(OTHER, tmp_path).returncode == -7

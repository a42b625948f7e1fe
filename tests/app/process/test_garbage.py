"""Widgets in reference cycles end on the thread of the window, whichever thread allocates."""

from __future__ import annotations

import subprocess
import sys
from types import SimpleNamespace

import pytest

from app.process import garbage

ALLOCATE_ON_ANOTHER_THREAD = """
import threading
from PySide6.QtCore import QCoreApplication, QObject, QThread
from app.process.garbage import collect_on_this_thread

class Kept(QObject):
    def __init__(self):
        super().__init__()
        self.cycle = self

    def __del__(self):
        print(threading.current_thread() is threading.main_thread())
        application.quit()

application = QCoreApplication([])
{start}
Kept()
held = []
worker = threading.Thread(target=lambda: held.extend([{{}}] for _ in range(100_000)))
worker.start()
worker.join()
application.exec()
"""


@pytest.mark.parametrize(
    ("start", "on_the_window_s"), [("collect_on_this_thread(application)", "True"), ("", "False")], ids=["set", "unset"]
)
def test_what_a_cycle_kept_ends_on_the_thread_of_the_window(start: str, on_the_window_s: str) -> None:
    program = ALLOCATE_ON_ANOTHER_THREAD.format(start=start)
    if not start:
        program = program.replace("application.exec()", "")
    found = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True, timeout=60)
    assert found.stdout.split()[0] == on_the_window_s


@pytest.mark.parametrize(
    ("objects", "searches", "modules", "old", "done"),
    [
        (garbage.MANY_OBJECTS, 0, 0, 0, []),
        (10_000, garbage.MANY_SEARCHES, 1000, 0, ["new"]),
        (10_000, garbage.MANY_SEARCHES + 1, 0, 0, ["everything"]),
        (10_000, garbage.MANY_SEARCHES + 1, 0, garbage.MANY_OLD + 1, ["new", "set aside"]),
        (10_000, garbage.MANY_SEARCHES + 1, 1000, 0, ["new", "set aside"]),
    ],
)
def test_what_is_new_is_searched_and_what_is_much_is_not_searched_again(
    monkeypatch: pytest.MonkeyPatch, objects: int, searches: int, modules: int, old: int, done: list[str]
) -> None:
    did: list[str] = []
    fake = SimpleNamespace(
        get_count=lambda: (objects, 0, searches),
        get_objects=lambda generation: [None] * old,
        collect=lambda generation=2: did.append({1: "new", 2: "everything"}[generation]),
        freeze=lambda: did.append("set aside"),
    )
    monkeypatch.setattr(garbage, "gc", fake)
    monkeypatch.setattr(garbage, "_modules_then", len(sys.modules) - modules)
    garbage.collect_what_is_due()
    assert did == done

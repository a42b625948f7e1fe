"""Widgets in reference cycles end on the thread of the window, whichever thread allocates."""

from __future__ import annotations

import subprocess
import sys

import pytest

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

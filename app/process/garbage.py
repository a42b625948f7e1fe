"""Reference cycles are searched for on the thread of the window alone.

Python searches on whatever thread happens to allocate, often on that of a job that compiles kernels, and destroys there
the widgets and timers that a cycle kept alive. Qt allows that on their own thread only: elsewhere it ends in a crash,
or in a wait for ever while the interpreter is locked. PySide hands plain widgets over to their thread, classes derived
from them it does not (seen with 6.11.3). pyqtgraph's GarbageCollector does the same; it was not taken because it
searches the modules loaded at the start again and again, and loads the whole of pyqtgraph.
"""

from __future__ import annotations

import gc

from PySide6.QtCore import QObject, QTimer

INTERVAL_MS = 250


def collect_on_this_thread(owner: QObject) -> None:
    """From now on collect garbage on this thread, while its event loop runs and `owner` lives; once is enough."""
    gc.disable()
    gc.freeze()
    timer = QTimer(owner)
    timer.timeout.connect(collect_what_is_due)
    timer.start(INTERVAL_MS)


def collect_what_is_due() -> None:
    """Collect the oldest generation that Python itself would collect now."""
    due = [count > threshold > 0 for count, threshold in zip(gc.get_count(), gc.get_threshold(), strict=True)]
    if any(due):
        gc.collect(2 - due[::-1].index(True))

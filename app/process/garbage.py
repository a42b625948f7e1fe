"""Reference cycles are searched for on the thread of the window alone.

Python searches on whatever thread happens to allocate, often on that of a job that compiles kernels, and destroys there
the widgets and timers that a cycle kept alive. Qt allows that on their own thread only: elsewhere it ends in a crash,
or in a wait for ever while the interpreter is locked. PySide hands plain widgets over to their thread, classes derived
from them it does not (seen with 6.11.3). pyqtgraph's GarbageCollector does the same; it was not taken because it
searches the modules loaded at the start again and again, and loads the whole of pyqtgraph.

What is new is searched often, and searched again only with everything else, at intervals. A search of 240,000 objects
takes 0.2 s, and once numba has compiled or SciPy is loaded nearly all of them are theirs. Where many modules have come
since the last search, or very many objects, what there is is set aside instead and never searched again: a few times in
the life of a process, at the price of cycles among what was alive just then.
"""

from __future__ import annotations

import gc
import sys

from PySide6.QtCore import QObject, QTimer

INTERVAL_MS = 100

#: New objects that have to come before they are searched, and searches of those before one of everything.
MANY_OBJECTS, MANY_SEARCHES = 700, 25

#: Modules that have to come, and objects that have to be there (a search of them takes 15 ms), before what there is is
#: set aside once more.
MANY_MODULES, MANY_OLD = 100, 30_000

_modules_then = 0


def collect_on_this_thread(owner: QObject) -> None:
    """From now on collect garbage on this thread, while its event loop runs and `owner` lives; once is enough."""
    gc.disable()
    _set_aside()
    timer = QTimer(owner)
    timer.timeout.connect(collect_what_is_due)
    timer.start(INTERVAL_MS)


def collect_what_is_due() -> None:
    """Collect what is new where that is much, and everything once in a while."""
    objects, _, searches = gc.get_count()
    if objects <= MANY_OBJECTS:
        return
    if searches <= MANY_SEARCHES:
        gc.collect(1)
    elif len(sys.modules) >= _modules_then + MANY_MODULES or len(gc.get_objects(2)) > MANY_OLD:
        gc.collect(1)
        _set_aside()
    else:
        gc.collect()


def _set_aside() -> None:
    global _modules_then
    _modules_then = len(sys.modules)
    gc.freeze()

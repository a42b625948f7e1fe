"""Packages of which several threads load parts, loaded whole before the first of them.

When a package has been executed, importlib takes it out of `sys.modules` and puts it back (`_load_unlocked`, Python
3.11 to 3.14). A thread that has just loaded a part of it looks it up, and in that moment fails with `KeyError`; so do
jobs that begin at once and load other parts of SciPy. Modules that are not packages do not suffer from that, because
whoever asks for one waits until it is there. Threads that load libraries written in C side by side have also ended the
process, so that whatever is loaded ahead of its use is loaded while `LOADING` is held.

It takes some 0.8 s once, on the thread of a job, with the compiler of kernels: nearly every job needs most of it.
"""

from __future__ import annotations

import pkgutil
import threading
from collections.abc import Iterable
from importlib import import_module

import engine
from engine.core.kernels import load_compiler

#: Packages within which the engine, SciPy or OpenCV itself loads parts by their full names.
SHARED = (
    "scipy.ndimage",
    "scipy.cluster",
    "scipy.spatial.transform",
    "scipy.sparse.csgraph",
    "scipy.optimize",
    "scipy.fft",
    "cv2",
)

#: Held by the thread that loads packages: all others wait, the window's as well.
LOADING = threading.RLock()

_is_loaded = threading.Event()


def load_shared() -> None:
    """Load the packages and the compiler of kernels, once in a process; whoever comes meanwhile waits."""
    if _is_loaded.is_set():
        return
    with LOADING:
        if not _is_loaded.is_set():
            load_modules(SHARED)
            load_compiler()
            _is_loaded.set()


def load_modules(names: Iterable[str]) -> None:
    """Load the modules `names`; another thread that loads some is waited for."""
    with LOADING:
        for name in names:
            import_module(name)


def load_own() -> None:
    """Load the engine's packages, which are empty but for their first sentence, and none of their modules."""
    for _ in pkgutil.walk_packages(engine.__path__, "engine."):
        pass

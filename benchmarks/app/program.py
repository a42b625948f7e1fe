"""Measures the program from outside: the window and a large import, each in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.measure import Measure, best_of
from engine.core.errors import MissingCapability
from engine.core.steps import Step, Steps, drain

UI_BLOCK_LIMIT_S = 0.05
PHOTOGRAPHS, HEIGHT, WIDTH = 10, 4000, 6000
MEMORY_LIMIT_BYTES = 2 * 2**30

EMPTY_WINDOW = """
from PySide6.QtWidgets import QApplication, QMainWindow
application = QApplication([])
window = QMainWindow()
window.show()
application.processEvents()
"""


def window_start() -> Measure:
    """From the start of the interpreter to a window that answers, against an empty Qt window."""
    time_s = _window()["window_start_s"]
    limit_s = best_of(lambda: _run("-c", EMPTY_WINDOW), repeats=3)
    return Measure("window-start", time_s, limit_s, "a process that shows an empty Qt window")


def window_block() -> Measure:
    """The longest that the window's thread was held up while the sample was imported, shaded and fitted."""
    time_s = _window()["longest_block_ms"] / 1000
    return Measure("window-block", time_s, UI_BLOCK_LIMIT_S, "a delay that nobody notices")


def view_block() -> Measure:
    """The longest that the window's thread was held up while a material was rotated under 64 lights, and refined.

    And while the reference was computed beside it and the two were compared.
    """
    found = _window()
    more = {key: found[key] for key in found if key.startswith(("turning", "refin", "reference"))}
    time_s = max(found[f"{name}_block_ms"] for name in ("turning", "refining", "reference")) / 1000
    return Measure("view-block", time_s, UI_BLOCK_LIMIT_S, "a delay that nobody notices", more)


def import_large() -> Measure:
    """Ten 16-bit TIFFs of 24 megapixels, imported with alignment, against reading them; and the memory it took."""
    from engine.capture.photograph.decode import read_photograph

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        photographs = photographs_of_24_megapixels(folder / "photographs")
        read_s = best_of(lambda: read_photograph(photographs[0]), repeats=1)
        words = ("import", str(folder / "photographs"), "-o", str(folder / "stack"), "--json")
        result = json.loads(_run("-m", "app.__main__", *words))
    memory = {"peak_memory_bytes": result["peak_memory_bytes"], "memory_limit_bytes": MEMORY_LIMIT_BYTES}
    limit_s = PHOTOGRAPHS * read_s
    return Measure("import-large", result["time_s"], limit_s, "decoding the ten photographs", memory)


def import_raw() -> Measure:
    """`benchmarks.capture.import_raw` in a working folder."""
    from benchmarks import capture

    with tempfile.TemporaryDirectory() as name:
        return capture.import_raw(Path(name))


def import_aligned() -> Measure:
    """`benchmarks.capture.import_aligned` in a working folder."""
    from benchmarks import capture

    with tempfile.TemporaryDirectory() as name:
        return capture.import_aligned(Path(name))


def import_bracketed() -> Measure:
    """`benchmarks.capture.import_bracketed` in a working folder."""
    from benchmarks import capture

    with tempfile.TemporaryDirectory() as name:
        return capture.import_bracketed(Path(name))


def import_tiff() -> Measure:
    """`benchmarks.capture.import_tiff` in a working folder."""
    from benchmarks import capture

    with tempfile.TemporaryDirectory() as name:
        return capture.import_tiff(Path(name))


@cache
def _window() -> dict[str, Any]:
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise MissingCapability(
            "There is no display to measure the window on", "Set DISPLAY, for instance with xvfb-run"
        )
    result: dict[str, Any] = json.loads(_run("-m", "benchmarks.app.window"))
    return result


def _run(*words: str) -> str:
    """Standard output of this interpreter run with `words`; its messages go where ours go."""
    return subprocess.run([sys.executable, *words], check=True, stdout=subprocess.PIPE, text=True).stdout


def photographs_of_24_megapixels(folder: Path) -> list[Path]:
    """Ten of `large_photographs`."""
    return drain(large_photographs(folder, HEIGHT, WIDTH))


def large_photographs(folder: Path, height: int, width: int) -> Steps[list[Path]]:
    """A surface with texture at all scales under rising light, a pixel or two apart: ten 16-bit TIFFs in `folder`."""
    from engine.images.encode import write_tiff16
    from engine.storage.atomic import make_folder

    make_folder(folder)
    rng = np.random.default_rng(0)
    fine = rng.random((-(-height // 8), -(-width // 8)), np.float32)
    surface = np.kron(fine, np.ones((8, 8), np.float32))[:height, :width]
    paths = []
    for index in range(PHOTOGRAPHS):
        yield Step(index / PHOTOGRAPHS, "making photographs")
        level = 60000 * (index + 1) / PHOTOGRAPHS
        shifted = np.roll(surface, (index % 3, index % 2), axis=(0, 1))
        codes = (level * (0.4 + 0.6 * shifted)).astype(np.uint16)
        paths.append(folder / f"large_{5 + 9 * index}deg.tif")
        write_tiff16(paths[-1], np.repeat(codes[..., None], 3, axis=2), transfer="linear")
    return paths

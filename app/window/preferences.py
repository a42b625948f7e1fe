"""Choices of the user that hold for every project, and the cache with its size; they are kept in the settings."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import psutil
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QComboBox, QDialog, QHBoxLayout, QVBoxLayout, QWidget

from app.jobs.jobs import Jobs
from app.process import crash
from app.project.made import size_of
from app.session import cache
from app.session.settings import NUMBERS, Settings, cache_folder
from app.view.tab import TONE_MAPS
from app.widgets.controls import ComboBox
from app.widgets.language import LANGUAGES
from app.widgets.panels import Rows, button, enable, line, text
from app.widgets.theme import PADDING, STEP
from engine.core.figure_text import size_text
from engine.core.steps import Step, Steps

#: Limits of the cache, in gigabytes; 0 for what suits the disk.
CACHES_GB = (0.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0)

#: Width of the dialog in pixels.
WIDTH_PX = 420

SPOKEN = (("system", "System default"), *LANGUAGES.items())
THEMES = (("dark", "Dark"), ("light", "Light"))
LENGTHS = (("mm", "Millimetres"), ("cm", "Centimetres"), ("in", "Inches"))
FORMS = tuple(zip(NUMBERS, ("By language", "1,234.5", "1 234,5"), strict=True))

#: Memory that a plan may choose, in GB; 0 leaves it to what is free.
MEMORIES_GB = (0.0, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0)


class Preferences(QDialog):
    """`changed(name, value)` follows each choice, by its name in `Settings`."""

    changed = Signal(str, object)

    def __init__(self, window: QWidget, now: Settings, jobs: Jobs) -> None:
        super().__init__(window)
        self.jobs = jobs
        self.setWindowTitle("Preferences")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setMinimumWidth(WIDTH_PX)
        self.column = QVBoxLayout(self)
        self.column.setContentsMargins(PADDING, PADDING, PADDING, PADDING)
        self.column.setSpacing(2 * STEP)
        self.boxes: dict[str, QComboBox] = {}
        window_rows = self._section("Window")
        self._choice(window_rows, "theme", "Theme", THEMES, now.theme)
        self._choice(
            window_rows, "language", "Language", SPOKEN, now.language, "Language of the window, from the next start on"
        )
        self._choice(window_rows, "numbers", "Numbers", FORMS, now.numbers, "The decimal mark of figures and fields")
        self._choice(
            window_rows,
            "tone_map",
            "Tone map",
            TONE_MAPS,
            now.tone_map,
            "Of new projects; View > Image has this one's",
        )
        self._choice(window_rows, "unit", "Lengths", LENGTHS, now.unit, "Unit of the width of a sample")
        self._make_limits(now)
        self._make_cache(now)
        close = button("Close", "primary")
        close.clicked.connect(self.close)
        self.column.addWidget(close, 0, Qt.AlignmentFlag.AlignRight)

    def _section(self, title: str) -> Rows:
        rows = Rows(title)
        if self.column.count():
            self.column.addWidget(line())
        self.column.addWidget(rows)
        return rows

    def _choice(
        self, rows: Rows, name: str, label: str, choices: tuple[tuple[object, str], ...], now: object, hint: str = ""
    ) -> None:
        box = ComboBox()
        for value, words in choices:
            box.addItem(words, value)
        box.setCurrentIndex(max(0, box.findData(now)))
        box.activated.connect(lambda _at: self.changed.emit(name, box.currentData()))
        self.boxes[name] = box
        rows.row(label, box, hint)

    def _make_limits(self, now: Settings) -> None:
        rows = self._section("Machine")
        if sys.platform == "linux":
            second = (("second", "Second graphics card"),) if len(list(Path("/dev/dri").glob("renderD*"))) > 1 else ()
            drawing = (("system", "As the system chooses"), *second, ("processor", "The CPU alone"))
            now_words = f"; now {crash.read_stated('OpenGL')}" if crash.read_stated("OpenGL") else ""
            hint = f"What draws the images, from the next start on{now_words}"
            self._choice(rows, "graphics", "Graphics", drawing, now.graphics, hint)
        count = os.cpu_count() or 1
        threads = tuple((each, f"{each}") for each in range(1, count))
        hint = "CPUs that the program uses, from its next start on"
        self._choice(rows, "threads", "CPUs", ((0, f"All {count}"), *threads), now.threads, hint)
        total = psutil.virtual_memory().total / 1e9
        memories = tuple(
            (each, f"{each:.0f} GB" if each else "50 % of free memory") for each in MEMORIES_GB if each < total
        )
        hint = "The most that a setting may take which a plan chooses"
        self._choice(rows, "memory_gb", "Memory", memories, now.memory_gb, hint)

    def _make_cache(self, now: Settings) -> None:
        rows = self._section("Cache")
        self.folder = text(str(cache_folder() or "none"), wrap=True)
        self.folder.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        rows.row("Folder", self.folder)
        self.size_words = text("…")
        self.empty = button(
            "Clear",
            hint="Working copies of results, costs measured on this machine and the ready-made sample. All are "
            "made again when needed; results whose photographs are gone stay",
        )
        self.empty.clicked.connect(self._empty)
        holder = QWidget()
        row = QHBoxLayout(holder)
        row.setContentsMargins(0, 0, 0, 0)
        row.addWidget(self.size_words, 1)
        row.addWidget(self.empty)
        rows.row("Size", holder)
        sizes = tuple((each, f"{each:.0f} GB" if each else "Automatic") for each in CACHES_GB)
        hint = "The most that working copies of results take; automatic is 10 GB, or half of what the disk has left"
        self._choice(rows, "cache_gb", "Limit", sizes, now.cache_gb, hint)
        self.boxes["cache_gb"].activated.connect(lambda _at: self._keep_within())
        self._measure()

    def _keep_within(self) -> None:
        job = self.jobs.submit("Keeping the cache within its limit", _trim_cache, lane="screen")
        job.succeeded.connect(self._show_size)

    def _measure(self) -> None:
        job = self.jobs.submit("Measuring the cache", _count_cached_bytes, lane="screen")
        job.succeeded.connect(self._show_size)

    def _show_size(self, size: int) -> None:
        self.size_words.setText(size_text(size))
        enable(self.empty, "" if size else "It is empty")

    def _empty(self) -> None:
        enable(self.empty, "It is being emptied")
        self.jobs.submit("Emptying the cache", _empty_cache, lane="screen").succeeded.connect(self._show_size)


def _size_of_cache() -> int:
    folder = cache_folder()
    return size_of(folder) if folder is not None and folder.is_dir() else 0


def _count_cached_bytes() -> Steps[int]:
    yield Step(0.0, "measuring")
    return _size_of_cache()


def _trim_cache() -> Steps[int]:
    """Remove what was used longest ago, until the limit is kept; the bytes that stay."""
    yield Step(0.0, "measuring")
    cache.keep_within()
    return _size_of_cache()


def _empty_cache() -> Steps[int]:
    """Remove all but what open windows use; the bytes that stay."""
    yield Step(0.0, "emptying")
    cache.empty()
    return _size_of_cache()

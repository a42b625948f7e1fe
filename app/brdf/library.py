"""The library on the left of the BRDF workspace: files that were opened, analytic models, published presets.

Thumbnails are drawn in a light job for the rows in sight, from top to bottom, and kept for the session.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QObject, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QIcon, QImage, QPixmap, QShowEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QMenu,
    QVBoxLayout,
    QWidget,
)

from app.commands.brdf import TEMPLATES
from app.commands.brdf_figures import thumbnails
from app.commands.workbench import Workbench
from app.document.comparison import Entry
from app.jobs.jobs import Job
from app.widgets import theme
from app.widgets import theme as icons
from app.widgets.panels import button, enable
from app.widgets.theme import PADDING, STEP, role
from engine.brdf.brdf import MODELS, label_of
from engine.brdf.models.presets import PRESETS
from engine.core.steps import Step, Steps

WIDTH = 232
THUMBNAIL = 36
AT_ONCE = 6

KEY, FILE, WORDS = Qt.ItemDataRole.UserRole, Qt.ItemDataRole.UserRole + 1, Qt.ItemDataRole.UserRole + 2


class Library(QWidget):
    """`model_wanted(text)` and `file_wanted(path)` ask to compare one, `relocate_wanted(path)` to find it again,
    `template_wanted(name)` to write one in GLSL."""

    model_wanted = Signal(str)
    file_wanted = Signal(object)
    relocate_wanted = Signal(object)
    browse_wanted = Signal()
    template_wanted = Signal(str)

    def __init__(self, bench: Workbench) -> None:
        super().__init__()
        self.bench = bench
        role(self, "panel")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setFixedWidth(WIDTH)
        self.images: dict[str, QIcon] = {}
        self.sources: dict[str, Any] = {}
        self.missing: frozenset[Path] = frozenset()
        self._files: tuple[Path, ...] | None = None
        self._drawing: Job | None = None
        self._wait = QTimer(self)
        self._wait.setSingleShot(True)
        self._wait.setInterval(40)
        self._wait.timeout.connect(self._draw_next)
        self.search = QLineEdit()
        self.search.setPlaceholderText("Search")
        self.search.setAccessibleName("Search the library")
        self.search.setToolTip("Part of a name or of a model (Ctrl+F)")
        self.search.setClearButtonEnabled(True)
        self.search.textChanged.connect(self._filter)
        self.search.returnPressed.connect(self._add_found)
        self.list = QListWidget()
        self.list.setAccessibleName("Library of BRDFs")
        self.list.setIconSize(QSize(THUMBNAIL, THUMBNAIL))
        self.list.setUniformItemSizes(False)
        self.list.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.setTextElideMode(Qt.TextElideMode.ElideRight)
        self.list.itemActivated.connect(lambda _item: self.add_current())
        self.list.currentItemChanged.connect(lambda _now, _before: self._update_button())
        self.list.verticalScrollBar().valueChanged.connect(lambda _value: self._wait.start())
        self.list.viewport().installEventFilter(self)
        self.add = button("Add", hint="Add it to the compared BRDFs (Enter, or double-click)")
        self.add.clicked.connect(self.add_current)
        self.browse = button("Open file…", hint="MERL, RGL, UTIA, Cornell, ASTM, CUReT, ALTA, CSV, or a Lightarc table")
        self.browse.clicked.connect(self.browse_wanted)
        self.write = button("Write one in GLSL", hint="Begins as a small text that works; the views follow as you type")
        templates = QMenu(self.write)
        for name, words in TEMPLATES.items():
            templates.addAction(f"Begin with {words}").triggered.connect(
                lambda _checked=False, name=name: self.template_wanted.emit(name)
            )
        self.write.setMenu(templates)
        below = QHBoxLayout()
        below.setContentsMargins(PADDING, 0, PADDING, PADDING)
        below.addWidget(self.write)
        foot = QHBoxLayout()
        foot.setContentsMargins(PADDING, 2 * STEP, PADDING, 2 * STEP)
        foot.setSpacing(2 * STEP)
        foot.addWidget(self.add, 1)
        foot.addWidget(self.browse, 1)
        head = QHBoxLayout()
        head.setContentsMargins(PADDING, PADDING - 4, PADDING, STEP)
        head.addWidget(self.search)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addLayout(head)
        body = QHBoxLayout()
        body.setContentsMargins(PADDING - 4, 0, 0, 0)
        body.addWidget(self.list)
        column.addLayout(body, 1)
        column.addLayout(foot)
        column.addLayout(below)
        self.show_files((), ())

    def show_files(self, files: Sequence[Path], entries: Sequence[Entry]) -> None:
        """Show the user's files above the built-in entries; compared entries lend their values to thumbnails."""
        self.sources |= {str(entry.path): entry.brdf for entry in entries if entry.path is not None}
        if self._files == tuple(files):
            self._wait.start()
            return
        self._files = tuple(files)
        self.list.clear()
        if files:
            self._heading("Files")
            for path in files:
                item = self._item(str(path), path.name, str(path.parent))
                item.setData(FILE, path)
        self._heading("Models")
        for name in MODELS:
            self._item(name, label_of(name), "Analytic model")
        self._heading("Published")
        for preset in PRESETS:
            words = preset.name.replace("-", " ").capitalize()
            self._item(preset.text, words, preset.source)
        self._mark_missing()
        self._filter()
        self._update_button()

    def _heading(self, words: str) -> None:
        item = QListWidgetItem(words)
        item.setFlags(Qt.ItemFlag.NoItemFlags)
        item.setFont(theme.font(strong=True))
        item.setSizeHint(QSize(0, 28))
        self.list.addItem(item)

    def _item(self, key: str, words: str, about: str) -> QListWidgetItem:
        item = QListWidgetItem(self.images.get(key, _blank()), words)
        item.setData(KEY, key)
        item.setData(WORDS, f"{words} {key} {about}".casefold())
        item.setToolTip(f"{words}\n{about}")
        item.setSizeHint(QSize(0, THUMBNAIL + 6))
        self.list.addItem(item)
        return item

    def items(self) -> list[QListWidgetItem]:
        """All rows, headings as well."""
        return [self.list.item(place) for place in range(self.list.count())]

    def _filter(self) -> None:
        words = self.search.text().casefold().split()
        any_below = False
        for item in reversed(self.items()):
            if item.data(KEY) is None:
                item.setHidden(not any_below)
                any_below = False
            else:
                item.setHidden(not all(word in item.data(WORDS) for word in words))
                any_below = any_below or not item.isHidden()
        self._wait.start()

    def _add_found(self) -> None:
        """Add what the search has found; the next word that is typed replaces this one."""
        self.add_current()
        self.search.selectAll()

    def add_current(self) -> None:
        """Compare the row on which the user is, or the only one that the search leaves."""
        item: QListWidgetItem | None = self.list.currentItem()
        if item is None or item.isHidden():
            found = [each for each in self.items() if each.data(KEY) is not None and not each.isHidden()]
            item = found[0] if len(found) == 1 else None
        if item is None or item.data(KEY) is None:
            return
        path = item.data(FILE)
        if path is None:
            self.model_wanted.emit(item.data(KEY))
        elif path in self.missing:
            self.relocate_wanted.emit(path)
        else:
            self.file_wanted.emit(path)

    def _update_button(self) -> None:
        item = self.list.currentItem()
        chosen = item is not None and item.data(KEY) is not None
        missing = chosen and item is not None and item.data(FILE) in self.missing
        self.add.setText("Find it…" if missing else "Add")
        enable(self.add, "" if chosen else "Choose something in the library first")

    def show_missing(self, missing: frozenset[Path]) -> None:
        """Mark the files that are no longer in their place."""
        self.missing = missing
        self._mark_missing()
        self._update_button()

    def _mark_missing(self) -> None:
        for item in self.items():
            path = item.data(FILE)
            if path is not None:
                gone = path in self.missing
                item.setText(f"{path.name} (not found)" if gone else path.name)
                item.setToolTip(f"{path}\n{'Double-click to find the file' if gone else 'Measured BRDF'}")

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self._wait.start()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if event.type() == QEvent.Type.Resize:
            self._wait.start()
        return super().eventFilter(watched, event)

    def in_sight_without(self) -> list[str]:
        """Rows that are seen and have no thumbnail yet, from top to bottom."""
        seen = self.list.viewport().rect()
        keys = []
        for item in self.items():
            key = item.data(KEY)
            if key is None or item.isHidden() or key in self.images:
                continue
            if (item.data(FILE) is None or key in self.sources) and self.list.visualItemRect(item).intersects(seen):
                keys.append(key)
        return keys

    def _draw_next(self) -> None:
        if self._drawing is not None or not self.isVisible():
            return
        keys = self.in_sight_without()[:AT_ONCE]
        if not keys:
            return
        wanted = [(key, self.sources.get(key, key)) for key in keys]
        size = round(THUMBNAIL * self.devicePixelRatioF())
        self._drawing = self.bench.jobs.submit("Drawing thumbnails", lambda: thumbnails(wanted, size), lane="screen")
        self._drawing.progressed.connect(self._drawn)
        self._drawing.succeeded.connect(lambda _result: self._over(()))
        self._drawing.failed.connect(lambda _error: self._over(keys))
        self._drawing.cancelled.connect(lambda: self._over(keys))

    def _drawn(self, step: Step) -> None:
        if step.partial is None:
            return
        key, pixels = step.partial
        self.images[key] = _icon(pixels, self.devicePixelRatioF())
        for item in self.items():
            if item.data(KEY) == key:
                item.setIcon(self.images[key])

    def _over(self, given_up: Sequence[str]) -> None:
        self._drawing = None
        self.images.update({key: _blank() for key in given_up if key not in self.images})
        self._draw_next()

    def apply_theme(self) -> None:
        """Draw the icon in the colour of the current theme."""
        self.browse.setIcon(icons.icon("folder"))


def missing_files(files: Sequence[Path]) -> Steps[frozenset[Path]]:
    """The files of `files` that do not exist; a sleeping disk may take its time."""
    gone = set()
    for done, path in enumerate(files):
        yield Step(done / len(files), "looking for files")
        if not path.with_name(path.name.partition("#")[0]).exists():
            gone.add(path)
    return frozenset(gone)


def _blank() -> QIcon:
    empty = QPixmap(THUMBNAIL, THUMBNAIL)
    empty.fill(Qt.GlobalColor.transparent)
    return QIcon(empty)


def _icon(pixels: NDArray[np.uint8], scale: float) -> QIcon:
    height, width = pixels.shape[:2]
    image = QImage(np.ascontiguousarray(pixels).tobytes(), width, height, 4 * width, QImage.Format.Format_RGBA8888)
    pixmap = QPixmap.fromImage(image)
    pixmap.setDevicePixelRatio(scale)
    return QIcon(pixmap)

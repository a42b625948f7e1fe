"""Sentences that stay above the workspaces until their cause is gone, each with buttons that help."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QSizePolicy, QVBoxLayout, QWidget

from app.widgets.panels import button, text
from app.widgets.theme import PADDING, STEP, role
from engine.core.escape import escape_controls

#: Letters of a path in a sentence, and of one name in it.
MAX_LETTERS, MAX_OF_NAME = 60, 40

#: Words of a button, and what it does.
Offer = tuple[str, Callable[[], object]]


class Banner(QWidget):
    """One sentence and its buttons."""

    def __init__(self) -> None:
        super().__init__()
        role(self, "banner")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.words = text("", wrap=True)
        self.words.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self.buttons: list[QPushButton] = []
        self.image = QLabel()
        self.image.hide()
        self._row = QHBoxLayout(self)
        self._row.setContentsMargins(PADDING, STEP, PADDING, STEP)
        self._row.setSpacing(2 * STEP)
        self._row.addWidget(self.image)
        self._row.addWidget(self.words, 1)
        self.hide()

    def say(self, words: str, offers: Sequence[Offer] = (), image: QPixmap | None = None, details: str = "") -> None:
        """Show `words` beside an image, with a button for each of `offers`; nothing where there are no words.

        `details` stand in the tool tip.
        """
        self.words.setToolTip(details)
        self.image.setVisible(image is not None)
        if image is not None:
            self.image.setPixmap(image)
        if words == self.words.text() and [label for label, _ in offers] == [each.text() for each in self.buttons]:
            return
        self.words.setText(words)
        for old in self.buttons:
            self._row.removeWidget(old)
            old.hide()
            old.deleteLater()
        self.buttons = []
        for label, run in offers:
            made = button(label)
            made.clicked.connect(lambda _checked=False, run=run: run())
            self._row.addWidget(made)
            self.buttons.append(made)
        self.setVisible(bool(words))


class Banners(QWidget):
    """A banner for each cause, in the order of their first words."""

    def __init__(self) -> None:
        super().__init__()
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._column.setSpacing(1)
        self.of: dict[str, Banner] = {}

    def say(self, cause: str, words: str, *offers: Offer, image: QPixmap | None = None, details: str = "") -> None:
        """Say `words` about `cause`; nothing any more where they are empty."""
        if cause not in self.of and not words:
            return
        if cause not in self.of:
            self.of[cause] = Banner()
            self._column.addWidget(self.of[cause])
        self.of[cause].say(words, offers, image, details)

    @property
    def words(self) -> dict[str, str]:
        """All that is said, by its cause."""
        return {cause: banner.words.text() for cause, banner in self.of.items() if banner.words.text()}


def short_path(path: Path) -> str:
    """A path in no more than `MAX_LETTERS` letters or so, on one line: folders in its middle are left out whole.

    A name that is too long by itself loses its own middle.
    """
    parts = [_short_name(part) for part in path.parts]
    for left_out in range(len(parts) - 2):
        first = (len(parts) - left_out) // 2  # the middle, so that of drive, folder and name as much stays as can
        kept = (*parts[:first], *(("…",) if left_out else ()), *parts[first + left_out :])
        if len(shown := str(Path(*kept))) <= MAX_LETTERS:
            return shown
    return str(Path(*(("…",) if len(parts) > 2 else ()), *parts[-2:]))


def _short_name(name: str) -> str:
    """A name without line breaks, and without its middle where it is longer than `MAX_OF_NAME`."""
    shown = escape_controls(name)
    half = MAX_OF_NAME // 2
    return shown if len(shown) <= MAX_OF_NAME else f"{shown[:half]}…{shown[-half:]}"

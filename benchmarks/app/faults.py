"""Faults of a window that the eye finds, found without one.

Text that is cut, widgets that overlap, faint text, controls without a name, and a Tab key that does not follow the eye.

Each function looks at a window as it is on screen and returns a sentence for each fault. `packaging/screenshots.py`
asks them about every image that it takes, and the tests about every workspace.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QModelIndex, QPoint, QRect, Qt
from PySide6.QtGui import QAccessible, QAccessibleInterface, QImage
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractScrollArea,
    QAbstractSlider,
    QComboBox,
    QDockWidget,
    QHeaderView,
    QLabel,
    QLineEdit,
    QPlainTextEdit,
    QScrollArea,
    QScrollBar,
    QStyle,
    QStyleOptionComboBox,
    QTableView,
    QTreeView,
    QWidget,
)

from app.widgets.fitting import Elided, Fitting
from app.widgets.number_field import NumberField

#: Contrast of text with what is behind it that WCAG 2.1 asks for (level AA).
MIN_CONTRAST = 4.5

#: Pixels beside the words of a cell in a table and in a tree, those of an icon in it, and the sides of the smallest.
IN_TABLE, IN_TREE, MARK, SMALLEST_CELL = 16, 6, 20, 12

#: Kinds of controls that a user has to tell apart by their names.
NAMED = (
    QAccessible.Role.Button,
    QAccessible.Role.CheckBox,
    QAccessible.Role.RadioButton,
    QAccessible.Role.ComboBox,
    QAccessible.Role.EditableText,
    QAccessible.Role.Slider,
    QAccessible.Role.SpinBox,
    QAccessible.Role.Table,
    QAccessible.Role.List,
    QAccessible.Role.Tree,
)


def faults(window: QWidget) -> list[str]:
    """All faults of `window` as it is on screen."""
    return [*cut(window), *overlapping(window), *faint(window), *nameless(window), *out_of_order(window)]


def show(window: QWidget) -> Iterator[QWidget]:
    """Widgets of which any part is on screen."""
    for widget in window.findChildren(QWidget):
        if widget.isVisible() and widget.width() > 1 and widget.height() > 1 and not widget.visibleRegion().isEmpty():
            yield widget


def describe(widget: QWidget) -> str:
    """A few words by which a user finds the widget."""
    words = widget.accessibleName()
    if not words and isinstance(widget, (QLabel, QAbstractButton, QLineEdit)):
        words = widget.text()
    if not words and isinstance(widget, QComboBox):
        words = widget.currentText()
    parents: list[str] = []
    parent = widget.parentWidget()
    while parent is not None and len(parents) < 3:
        parents.append(type(parent).__name__)
        parent = parent.parentWidget()
    return f"{type(widget).__name__} {words[:40]!r} in {' < '.join(parents)}"


def cut(window: QWidget) -> list[str]:
    """Text that has less room than it needs, and widgets that reach beyond those around them."""
    found = []
    for widget in show(window):
        needed, room = _room(widget)
        if needed > room + 1:
            found.append(f"{describe(widget)} needs {needed} px and has {room}")
        found += _cut_headings(widget) if isinstance(widget, QHeaderView) else ()
        found += _cut_cells(widget) if isinstance(widget, (QTableView, QTreeView)) else ()
        if isinstance(widget, QScrollArea) and _is_cut_by(widget):
            widths = f"{_width_in(widget)} px and has {widget.viewport().width()}"
            found.append(f"{describe(widget)} does not scroll sideways; what it shows needs {widths}")
        around = widget.parentWidget()
        is_of_qt = isinstance(widget, (QScrollBar, QDockWidget)) or widget.objectName().startswith("qt_")
        if around is None or is_of_qt or _scrolls(around):
            continue
        if around.layout() is not None and not around.rect().adjusted(-1, -1, 1, 1).contains(widget.geometry()):
            found.append(f"{describe(widget)} reaches beyond what is around it")
    return found


def _is_cut_by(area: QScrollArea) -> bool:
    """True where an area that only scrolls up and down shows something wider than itself."""
    return (
        area.horizontalScrollBarPolicy() == Qt.ScrollBarPolicy.ScrollBarAlwaysOff
        and _width_in(area) > area.viewport().width()
    )


def _width_in(area: QScrollArea) -> int:
    inside = area.widget()
    return inside.width() if inside is not None else 0


def _cut_headings(header: QHeaderView) -> list[str]:
    """Headings of a table that are wider than their columns."""
    if header.orientation() != Qt.Orientation.Horizontal:
        return []
    found, model = [], header.model()
    for place in range(header.count()):
        words = str(model.headerData(place, header.orientation()) or "") if model is not None else ""
        needed, room = header.fontMetrics().horizontalAdvance(words), header.sectionSize(place)
        if words and not header.isSectionHidden(place) and needed > room:
            found.append(f"The heading {words!r} of {describe(header)} needs {needed} px and has {room}")
    return found


def _cut_cells(view: QTableView | QTreeView) -> Iterator[str]:
    """Words of a table or a tree that have no room in their cell, on one line or on several."""
    metrics, model = view.fontMetrics(), view.model()
    beside = IN_TABLE if isinstance(view, QTableView) else IN_TREE
    for index in _in_sight(view):
        words = str(model.data(index) or "")
        cell, mark = view.visualRect(index), model.data(index, Qt.ItemDataRole.DecorationRole)
        room = QRect(0, 0, cell.width() - beside - (MARK if mark is not None else 0), 1 << 20)
        needed = metrics.boundingRect(room, Qt.TextFlag.TextWordWrap, words)
        is_whole = metrics.horizontalAdvance(words) <= room.width()
        if words and not is_whole and (needed.width() > room.width() or needed.height() > cell.height()):
            yield f"{words!r} in {describe(view)} needs {needed.width()} × {needed.height()} px and has {room.width()}"


def _in_sight(view: QTableView | QTreeView) -> Iterator[QModelIndex]:
    """The cells of which any part is on screen, each once."""
    seen, inside = set(), view.viewport().rect()
    for top in range(inside.top(), inside.bottom(), SMALLEST_CELL):
        for left in range(inside.left(), inside.right(), SMALLEST_CELL):
            index = view.indexAt(QPoint(left, top))
            place = (index.internalId(), index.row(), index.column())
            if index.isValid() and place not in seen:
                seen.add(place)
                yield index


def _scrolls(widget: QWidget) -> bool:
    """True for what a scroll area shows a part of."""
    area = widget.parentWidget()
    return isinstance(area, QAbstractScrollArea) and area.viewport() is widget


def _room(widget: QWidget) -> tuple[int, int]:
    """Pixels that the text of a widget needs, and pixels that it has; across, or down where it is wrapped."""
    metrics = widget.fontMetrics()
    if isinstance(widget, (Fitting, Elided)):
        return 0, 0
    if isinstance(widget, QLabel) and widget.text():
        if widget.wordWrap():
            return widget.heightForWidth(widget.width()), widget.height()
        return widget.sizeHint().width(), widget.width()
    if isinstance(widget, QAbstractButton) and widget.text():
        return widget.sizeHint().width(), widget.width()
    if isinstance(widget, QComboBox) and not widget.isEditable():
        option = QStyleOptionComboBox()
        widget.initStyleOption(option)
        control, part = QStyle.ComplexControl.CC_ComboBox, QStyle.SubControl.SC_ComboBoxEditField
        room = widget.style().subControlRect(control, option, part, widget).width()
        return metrics.horizontalAdvance(widget.currentText()), room
    if isinstance(widget, NumberField):
        return metrics.horizontalAdvance(widget.text()), widget.width() - 14
    return 0, 0


def overlapping(window: QWidget) -> list[str]:
    """Pairs of widgets that one layout puts over each other."""
    found = []
    for parent in (window, *show(window)):
        layout = parent.layout()
        if layout is None:
            continue
        # Items of a layout are not asked for: PySide keeps what it made of them after a closed dialog has taken them.
        widgets = (each for each in parent.children() if isinstance(each, QWidget) and each.isVisible())
        placed = [widget for widget in widgets if layout.indexOf(widget) >= 0]
        for place, one in enumerate(placed):
            for other in placed[place + 1 :]:
                both = one.geometry().intersected(other.geometry())
                if both.width() > 1 and both.height() > 1:
                    found.append(f"{describe(one)} lies over {describe(other)}")
    return found


def faint(window: QWidget) -> list[str]:
    """Text of less than `MIN_CONTRAST`, measured in the image; what is disabled may be faint."""
    image, found = pixels(window.grab().toImage()), []
    scale = image.shape[1] / max(1, window.width())
    for widget in show(window):
        if not widget.isEnabled() or not isinstance(widget, (QLabel, QAbstractButton, QComboBox, QLineEdit)):
            continue
        words = widget.currentText() if isinstance(widget, QComboBox) else widget.text()
        if not words.strip() or not any(letter.isalnum() for letter in words):
            continue
        seen = QRect(widget.mapTo(window, QPoint()), widget.size()).adjusted(2, 2, -2, -2)
        part = widget.visibleRegion().boundingRect()
        if part != widget.rect() or seen.height() < 10 or seen.width() < 6:
            continue  # its words are seen in part, or there is no room for any
        left, top = round(scale * seen.left()), round(scale * seen.top())
        right, bottom = round(scale * seen.right()), round(scale * seen.bottom())
        patch = image[top:bottom, left:right]
        if not patch.size:
            continue  # it is being laid out, and lies beyond the image
        contrast = _contrast(patch)
        if contrast < MIN_CONTRAST:
            found.append(f"{describe(widget)} has a contrast of {contrast:.2f}")
    return found


def pixels(image: QImage) -> NDArray[np.uint8]:
    """(H, W, 3) uint8 of an image."""
    rgb = image.convertToFormat(QImage.Format.Format_RGB888)
    rows = np.frombuffer(rgb.constBits(), np.uint8).reshape(rgb.height(), rgb.bytesPerLine())
    return rows[:, : 3 * rgb.width()].reshape(rgb.height(), rgb.width(), 3).copy()


def _contrast(part: NDArray[np.uint8]) -> float:
    """The contrast of the ink with the colour that most pixels have (WCAG 2.1)."""
    colours, counts = np.unique(part.reshape(-1, 3), axis=0, return_counts=True)
    linear = np.where(colours / 255.0 <= 0.04045, colours / 255.0 / 12.92, ((colours / 255.0 + 0.055) / 1.055) ** 2.4)
    luminance = linear @ (0.2126, 0.7152, 0.0722)
    behind = luminance[counts.argmax()]
    light, dark = np.maximum(luminance, behind), np.minimum(luminance, behind)
    return float(((light + 0.05) / (dark + 0.05)).max())


def nameless(window: QWidget) -> list[str]:
    """Controls that nobody who does not see them can tell apart: those without an accessible name."""
    found: list[str] = []
    root = QAccessible.queryAccessibleInterface(window)
    if root is not None:
        _walk(root, found)
    return found


def _walk(interface: QAccessibleInterface, found: list[str]) -> None:
    state = interface.state()
    if state.invisible:
        return
    owner = interface.object()
    is_own = not isinstance(owner, QWidget) or not isinstance(owner.parentWidget(), (QLineEdit, QScrollBar, QComboBox))
    if isinstance(owner, (QScrollBar, QPlainTextEdit)) or not is_own:
        return
    if interface.role() in NAMED and not interface.text(QAccessible.Text.Name).strip():
        found.append(f"{describe(owner) if isinstance(owner, QWidget) else interface.role()} has no name")
    if isinstance(owner, (QComboBox, QAbstractScrollArea)) and not isinstance(owner, QScrollArea):
        return
    for place in range(interface.childCount()):
        child = interface.child(place)
        if child is not None and child.isValid():
            _walk(child, found)


def out_of_order(window: QWidget) -> list[str]:
    """Steps of the Tab key within one panel that lead up, or left in a row."""
    found = []
    # PySide may hand out what it made of another object that was at the same place of memory.
    found_widgets = (widget for widget in _chain(window) if isinstance(widget, QWidget))
    controls = [widget for widget in found_widgets if window.isAncestorOf(widget) and _takes_tab(widget)]
    for one, other in pairwise(controls):
        if _panel(one) is not _panel(other):
            continue
        here, there = _place(one, window), _place(other, window)
        is_above = there.bottom() <= here.top()
        is_left = there.right() <= here.left() and min(here.bottom(), there.bottom()) > max(here.top(), there.top())
        if is_above or is_left:
            found.append(f"Tab leads from {describe(one)} back to {describe(other)}")
    return found


def _chain(window: QWidget) -> Iterator[QWidget]:
    widget = window.nextInFocusChain()
    while widget is not None and widget is not window:
        yield widget
        widget = widget.nextInFocusChain()


def _takes_tab(widget: QWidget) -> bool:
    on_screen = widget.isVisible() and widget.isEnabled() and widget.visibleRegion().boundingRect() == widget.rect()
    kinds = (QAbstractButton, QComboBox, QLineEdit, QAbstractSlider)
    return on_screen and isinstance(widget, kinds) and bool(widget.focusPolicy() & Qt.FocusPolicy.TabFocus)


def _panel(widget: QWidget) -> QWidget | None:
    """The scroll area, dock or bar that a control belongs to."""
    around = widget.parentWidget()
    while (
        around is not None and around.property("role") != "bar" and not isinstance(around, (QScrollArea, QDockWidget))
    ):
        around = around.parentWidget()
    return around


def _place(widget: QWidget, window: QWidget) -> QRect:
    return QRect(widget.mapTo(window, QPoint()), widget.size())

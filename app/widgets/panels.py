"""Side panels: a title in sentence case, rows of label and value on one grid, and thin lines between sections."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PySide6.QtCore import QEvent, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QAccessible, QAction, QResizeEvent
from PySide6.QtWidgets import (
    QButtonGroup,
    QComboBox,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QScrollArea,
    QSizePolicy,
    QSplitter,
    QStackedWidget,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from app.widgets import theme
from app.widgets import theme as icons
from app.widgets.theme import PADDING, ROW, STEP, role

#: Widths of panels: as they are, and the share that a narrow window leaves them.
WIDTH, NARROWEST = 296, 0.83
LABEL_WIDTH = 76

#: Width of the bar that scrolls a panel, as the theme has it.
SCROLL_BAR = 10


class Panel(QWidget):
    """A column of sections beside the image, which scrolls where the window is low, and a foot that stays."""

    def __init__(self, width: int = WIDTH) -> None:
        super().__init__()
        role(self, "panel")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.usual_width = width
        self.lines: dict[Rows, QWidget] = {}
        self.setMaximumWidth(width)
        self.inside = role(_Inside(self), "panel")
        # scrolls rather than squeezes its rows
        self.inside.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
        self.column = QVBoxLayout(self.inside)
        self.column.setContentsMargins(PADDING, PADDING, PADDING, PADDING)
        self.column.setSpacing(STEP)
        scroll = Scrolled()
        scroll.setWidgetResizable(True)
        scroll.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        scroll.setFrameShape(QFrame.Shape.NoFrame)
        scroll.setWidget(self.inside)
        self.whole = QVBoxLayout(self)
        self.whole.setContentsMargins(0, 0, 0, 0)
        self.whole.setSpacing(0)
        self.whole.addWidget(scroll, 1)

    def sizeHint(self) -> QSize:
        """As wide as panels are; only where the window is too narrow for its image they give way to it."""
        return QSize(self.usual_width, super().sizeHint().height())

    def minimumSizeHint(self) -> QSize:
        """Narrower than usual, but not so narrow that a row and the bar that scrolls it have no room."""
        rows = self.inside.minimumSizeHint().width() + SCROLL_BAR
        narrowest = max(round(NARROWEST * self.usual_width), min(rows, self.usual_width))
        return QSize(narrowest, super().minimumSizeHint().height())

    def section(self, title: str) -> Rows:
        """A titled group of rows below what is there; a line parts it from the section above."""
        rows = Rows(title)
        self.add(rows)
        return rows

    def add(self, rows: Rows) -> None:
        """Put a group of rows below what is there."""
        if self.column.count():
            self.column.addSpacing(2 * STEP)
            self.lines[rows] = line()
            self.column.addWidget(self.lines[rows])
            self.column.addSpacing(2 * STEP)
        self.column.addWidget(rows)

    def show_group(self, rows: Rows, is_shown: bool) -> None:
        """Show or hide a group of rows that was added, with the line above it."""
        rows.setVisible(is_shown)
        if rows in self.lines:
            self.lines[rows].setVisible(is_shown)

    def finish(self, foot: QWidget | None = None) -> None:
        """Push everything to the top; `foot`, the panel's main button, stays at the bottom whatever scrolls."""
        self.column.addStretch(1)
        if foot is not None:
            holder = QVBoxLayout()
            holder.setContentsMargins(PADDING, 2 * STEP, PADDING, PADDING)
            holder.addWidget(foot)
            self.whole.addLayout(holder)


class Scrolled(QScrollArea):
    """An area that scrolls, and measures its content from its first showing on.

    Qt's own also measures it each time that a widget around it gets a parent, and dresses all of it anew for that.
    """

    accessible_role = QAccessible.Role.Pane

    _was_shown = False

    def __init__(self) -> None:
        super().__init__()
        self.setAccessibleName("Panel")

    def event(self, event: QEvent) -> bool:
        self._was_shown |= event.type() == QEvent.Type.Show
        if not self._was_shown and event.type() in (QEvent.Type.StyleChange, QEvent.Type.LayoutRequest):
            return True
        return super().event(event)


class _Inside(QWidget):
    """The content that a panel scrolls; other rows may need another width of it."""

    def __init__(self, panel: Panel) -> None:
        super().__init__()
        self.panel = panel

    def event(self, event: QEvent) -> bool:
        if event.type() == QEvent.Type.LayoutRequest:
            self.panel.updateGeometry()
        return super().event(event)


def sheet() -> tuple[QWidget, QVBoxLayout]:
    """The content widget of a dock, and its column, still empty."""
    holder = role(QWidget(), "panel")
    holder.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
    column = QVBoxLayout(holder)
    column.setContentsMargins(PADDING, STEP, PADDING, STEP)
    column.setSpacing(STEP)
    return holder, column


def with_buttons(chosen: QWidget, *others: QWidget) -> QWidget:
    """One row: what is chosen, with the buttons that change it, or what goes with it, at its right."""
    holder = QWidget()
    row = QHBoxLayout(holder)
    row.setContentsMargins(0, 0, 0, 0)
    row.setSpacing(STEP)
    row.addWidget(chosen, 1)
    for other in others:
        row.addWidget(other)
    return holder


class Pages(QStackedWidget):
    """Pages of which one is in front; only that one asks for room, so that a low window suits the others."""

    def __init__(self) -> None:
        super().__init__()
        self.currentChanged.connect(lambda _page: self.updateGeometry())

    def minimumSizeHint(self) -> QSize:
        page = self.currentWidget()
        return page.minimumSizeHint() if page is not None else super().minimumSizeHint()


def fill_stacked(holder: QWidget, above: QWidget, below: QWidget, heights: list[int]) -> None:
    """Fill `holder` with an image above its table, with a thin line between them that can be moved."""
    halves = QSplitter(Qt.Orientation.Vertical)
    halves.setHandleWidth(1)
    halves.setChildrenCollapsible(False)
    for place, (part, stretch) in enumerate(((above, 7), (below, 1))):
        halves.addWidget(part)
        halves.setStretchFactor(place, stretch)
    halves.setSizes(heights)
    outer = QVBoxLayout(holder)
    outer.setContentsMargins(0, 0, 0, 0)
    outer.addWidget(halves)


class Rows(QWidget):
    """Rows of a section: label on the left, widget or figure on the right."""

    def __init__(self, title: str = "") -> None:
        super().__init__()
        self.title = title
        self.grid = QGridLayout(self)
        self.grid.setContentsMargins(0, 0, 0, 0)
        self.grid.setHorizontalSpacing(2 * STEP)
        self.grid.setVerticalSpacing(STEP)
        self.grid.setColumnMinimumWidth(0, LABEL_WIDTH)
        self.grid.setColumnStretch(1, 1)
        if title:
            self.wide(text(title, "title"))

    def row(self, label: str, widget: QWidget, hint: str = "") -> QWidget:
        """`label` beside `widget`; `hint` explains both where the mouse rests."""
        place = self.grid.rowCount()
        caption = text(label, "secondary")
        caption.setBuddy(widget)
        caption.setToolTip(hint)
        if hint:
            keep_hint(widget, hint)
        widget.setAccessibleName(label)
        if isinstance(widget, QComboBox):
            widget.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
            widget.setMinimumContentsLength(8)
        self.grid.setRowMinimumHeight(place, ROW)
        self.grid.addWidget(caption, place, 0)
        self.grid.addWidget(widget, place, 1)
        return widget

    def show_row(self, widget: QWidget, is_shown: bool) -> None:
        """Show or hide the row of `widget`, with its label."""
        place = self.grid.getItemPosition(self.grid.indexOf(widget))[0]  # type: ignore[index]
        for column in range(2):
            item = self.grid.itemAtPosition(place, column)
            inside = item.widget() if item is not None else None
            if inside is not None:
                inside.setVisible(is_shown)
        self.grid.setRowMinimumHeight(place, ROW if is_shown else 0)

    def figure(self, label: str, hint: str = "") -> QLabel:
        """A read-out, right-aligned; set its text with the unit."""
        value = text("–", "")
        value.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        value.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.row(label, value, hint)
        return value

    def wide(self, widget: QWidget) -> QWidget:
        """A widget over the whole width."""
        self.grid.addWidget(widget, self.grid.rowCount(), 0, 1, 2)
        return widget


class Fold(QWidget):
    """Rows that are seldom needed, behind a line that opens and closes them."""

    def __init__(self, title: str) -> None:
        super().__init__()
        self.rows = Rows()
        self.rows.hide()
        self.head = QToolButton()
        self.head.setText(title)
        self.head.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.head.setIconSize(QSize(icons.SMALL, icons.SMALL))
        self.head.setCheckable(True)
        self.head.toggled.connect(self._on_toggled)
        role(self.head, "fold")
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(STEP)
        column.addWidget(self.head)
        column.addWidget(self.rows)
        self.apply_theme()

    def _on_toggled(self, opened: bool) -> None:
        self.rows.setVisible(opened)
        self.apply_theme()

    def apply_theme(self) -> None:
        """Draw the arrow in the colour of the current theme."""
        self.head.setIcon(icons.icon("chevron-down" if self.head.isChecked() else "chevron-right"))


class Segments(QWidget):
    """A few choices side by side, exactly one of them active. `chosen` is emitted for clicks and keys only."""

    chosen = Signal(str)

    def __init__(self, choices: Sequence[tuple[str, str, str]], shorter: Mapping[str, str] | None = None) -> None:
        """`choices` are (value, label, hint); `shorter` labels by value stand where the whole ones have no room."""
        super().__init__()
        self.shorter = dict(shorter or {})
        self.whole = {value: label for value, label, _ in choices}
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        self.group = QButtonGroup(self)
        self.buttons: dict[str, QToolButton] = {}
        for value, label, hint in choices:
            button = QToolButton()
            button.setText(label)
            keep_hint(button, hint)
            button.setCheckable(True)
            button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
            button.clicked.connect(lambda _checked, value=value: self.chosen.emit(value))
            role(button, "segment")
            self.group.addButton(button)
            self.buttons[value] = button
            layout.addWidget(button)

    def sizeHint(self) -> QSize:
        """Room for the whole labels."""
        return super().sizeHint() + QSize(self._measure_lost(), 0)

    def minimumSizeHint(self) -> QSize:
        """Room for the short labels."""
        metrics = self.fontMetrics()
        pairs = ((self.buttons[value].text(), short) for value, short in self.shorter.items())
        saved = sum(metrics.horizontalAdvance(now) - metrics.horizontalAdvance(short) for now, short in pairs)
        return super().minimumSizeHint() - QSize(saved, 0)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        is_narrow = self.width() < self.sizeHint().width()
        for value, label in self.shorter.items():
            self.buttons[value].setText(label if is_narrow else self.whole[value])

    def _measure_lost(self) -> int:
        """The width that the labels have lost by their short forms."""
        metrics = self.fontMetrics()
        pairs = ((self.whole[value], self.buttons[value].text()) for value in self.shorter)
        return sum(metrics.horizontalAdvance(whole) - metrics.horizontalAdvance(now) for whole, now in pairs)

    @property
    def value(self) -> str:
        return next((value for value, button in self.buttons.items() if button.isChecked()), "")

    def choose(self, value: str) -> None:
        """Show `value` as active without emitting."""
        self.buttons[value].setChecked(True)

    def disable(self, value: str, why: str) -> None:
        """Make one choice unavailable and let it say why; an empty `why` makes it available."""
        enable(self.buttons[value], why)


def text(words: str, look: str = "", *, wrap: bool = False) -> QLabel:
    """A label; `look` is a role of the theme."""
    label = QLabel(words)
    label.setTextFormat(Qt.TextFormat.PlainText)
    label.setWordWrap(wrap)
    if look:
        role(label, look)
    return label


def line() -> QFrame:
    """A thin horizontal line."""
    rule = QFrame()
    role(rule, "line")
    return rule


def button(label: str, look: str = "", icon: str = "", hint: str = "") -> QPushButton:
    """A push button; `look` is 'primary', 'link' or empty."""
    made = QPushButton(label)
    if icon:
        made.setIcon(icons.icon(icon, theme.current().on_accent if look == "primary" else None))
        made.setIconSize(QSize(icons.SMALL, icons.SMALL))
    made.setToolTip(hint)
    if look:
        role(made, look)
    return made


def tool(action: QAction) -> QToolButton:
    """A small button that shows only the icon of `action`."""
    made = QToolButton()
    made.setDefaultAction(action)
    made.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonIconOnly)
    made.setIconSize(QSize(icons.SMALL, icons.SMALL))
    made.setAccessibleName(action.text())
    keys = action.shortcut().toString()
    made.setToolTip(f"{action.text()} ({keys})" if keys else action.text())
    return made


def small_button(icon: str, hint: str) -> QToolButton:
    """A small button that shows an icon alone."""
    made = QToolButton()
    made.setIcon(icons.icon(icon))
    made.setIconSize(QSize(icons.SMALL, icons.SMALL))
    made.setAccessibleName(hint)
    keep_hint(made, hint)
    return made


def scroll_to(rows: QWidget) -> None:
    """Scroll the panel of `rows` so that all of them are seen, once their new layout has its place."""

    def scroll() -> None:
        area = rows.parentWidget()
        while area is not None and not isinstance(area, QScrollArea):
            area = area.parentWidget()
        inside = area.widget() if area is not None else None
        if area is not None and inside is not None:
            bottom = rows.mapTo(inside, rows.rect().bottomLeft())
            area.ensureVisible(bottom.x(), bottom.y(), 0, PADDING)

    QTimer.singleShot(0, rows, scroll)


def keep_hint(widget: QWidget, hint: str) -> None:
    """Explain `widget` where the mouse rests, whenever nothing is said against using it."""
    widget.setProperty("hint", hint)
    widget.setToolTip(hint)


def enable(widget: QWidget, why_not: str, hint: str = "") -> None:
    """Disable `widget` and let it say why, or enable it when there is no reason against it.

    `hint` explains it from now on; without one it keeps the one that it has. Choices side by side say why each.
    """
    if hint:
        keep_hint(widget, hint)
    widget.setEnabled(not why_not)
    widget.setToolTip(why_not or str(widget.property("hint") or ""))
    if isinstance(widget, Segments):
        for choice in widget.buttons.values():
            choice.setToolTip(why_not or str(choice.property("hint") or ""))

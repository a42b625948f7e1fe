"""The one place where colours, sizes and type are decided: a dark and a light neutral theme over Qt's Fusion style.

The frame around an image has no hue, or colours are misjudged; one accent marks what is active. Spacing goes in
steps of 4 px, panels keep 12 px inside, rows are 26 px high, text is 13 px. Widgets carry no stylesheet of their own:
they name a role (`widget.setProperty("role", "primary")`) and the sheet below says what it looks like. The sheet takes
its colours from the palette and is the same for all themes, so that another theme is a palette: Qt would restyle all
2,500 widgets of a window for another sheet, in 0.2 s at once. Qt looks the palette up when it polishes a widget, so
`Dressing` polishes all anew in short steps, the visible ones first.

Line icons drawn for the program: `resources/icons/NAME.svg` in the colour that the theme asks for.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from types import SimpleNamespace
from typing import TypeVar

import shiboken6
from PySide6.QtCore import QByteArray, QRect, QRectF, QSize, Qt
from PySide6.QtGui import QAction, QColor, QFont, QFontDatabase, QIcon, QIconEngine, QPainter, QPalette, QPixmap
from PySide6.QtSvg import QSvgRenderer
from PySide6.QtWidgets import QAbstractButton, QApplication, QWidget

from app.widgets.resources import LINES as LINES
from app.widgets.resources import RESOURCES as RESOURCES

Item = TypeVar("Item")

STEP, PADDING, ROW, TEXT = 4, 12, 26, 13

#: Seconds of work in one step of a change of the theme.
STEP_S = 0.008


@dataclass(frozen=True)
class Theme:
    """Colours by their use, as '#rrggbb'."""

    name: str
    window: str
    panel: str
    field: str
    hover: str
    line: str
    text: str
    secondary: str
    disabled: str
    accent: str
    on_accent: str
    canvas: str
    good: str
    warning: str
    bad: str

    @property
    def accent_hover(self) -> str:
        """The accent under the pointer."""
        return QColor(self.accent).lighter(108).name()


DARK = Theme(
    name="dark",
    window="#1f1f1f",
    panel="#262626",
    field="#2e2e2e",
    hover="#363636",
    line="#3a3a3a",
    text="#d8d8d8",
    secondary="#a2a2a2",
    disabled="#6a6a6a",
    accent="#4d9bf0",
    on_accent="#101418",
    canvas="#181818",
    good="#57b894",
    warning="#e6a63c",
    bad="#ec7557",
)

LIGHT = Theme(
    name="light",
    window="#dedede",
    panel="#ececec",
    field="#fafafa",
    hover="#e2e2e2",
    line="#c2c2c2",
    text="#1e1e1e",
    secondary="#505050",
    disabled="#929292",
    accent="#1a60b0",
    on_accent="#ffffff",
    canvas="#c8c8c8",
    good="#0a6b4c",
    warning="#865500",
    bad="#b0371a",
)

THEMES = {theme.name: theme for theme in (DARK, LIGHT)}

_current = DARK


def current() -> Theme:
    """The theme that `apply` set last; icons, plots and painted widgets read their colours here."""
    return _current


def line(number: int) -> str:
    """The colour of the line `number` of a plot; below 0 that of text."""
    return LINES[number % len(LINES)] if number >= 0 else current().text


def apply(application: QApplication, name: str) -> Theme:
    """Dress the whole application in the theme `name` ('dark' or 'light'; anything else means dark)."""
    dressing = change(application, name)
    if dressing is not None:
        for _ in (*dressing.dress_visible(), *dressing.dress_rest()):
            pass
    return _current


def change(application: QApplication, name: str) -> Dressing | None:
    """Make `name` the theme of now; what is to be dressed in it then, None where everything looks like that already."""
    global _current
    before, _current = _current, THEMES.get(name, DARK)
    if application.style().name() != "fusion" and not application.styleSheet():
        application.setStyle("Fusion")
    if application.font() != font():
        application.setFont(font())
    application.setPalette(_palette(_current))
    if not application.styleSheet():
        application.setStyleSheet(_sheet())
        return None
    return None if before is _current else Dressing(application)


class Dressing:
    """Gives widgets and icons the theme of now in short steps, each widget once."""

    def __init__(self, application: QApplication) -> None:
        self._waiting = dict.fromkeys(application.allWidgets())

    def dress_visible(self) -> Iterator[None]:
        """Dress the visible widgets that are not dressed yet."""
        yield from _in_short_steps(tuple(self._waiting), self._dress_if_visible)

    def dress_rest(self) -> Iterator[None]:
        """Dress all other widgets, and the icons of actions."""
        yield from _in_short_steps(tuple(self._waiting), self._dress)
        for window in QApplication.topLevelWidgets():
            yield from _in_short_steps(window.findChildren(QAction), _draw_icon_anew)

    def _dress_if_visible(self, widget: QWidget) -> None:
        if shiboken6.isValid(widget) and widget.isVisible():
            self._dress(widget)

    def _dress(self, widget: QWidget) -> None:
        self._waiting.pop(widget, None)
        if not shiboken6.isValid(widget):
            return  # a closed window may be destroyed meanwhile
        _polish_anew(widget)
        if isinstance(widget, QAbstractButton):
            _draw_icon_anew(widget)


def _in_short_steps(items: Iterable[Item], work: Callable[[Item], object]) -> Iterator[None]:
    """Call `work` of each item; a step takes `STEP_S`."""
    begun = time.perf_counter()
    for item in items:
        if time.perf_counter() - begun > STEP_S:
            yield
            begun = time.perf_counter()
        work(item)


@contextmanager
def draw_at_once(application: QApplication) -> Iterator[None]:
    """Leave the windows on the screen as they are until the end of the block, and draw them anew then."""
    windows = [widget for widget in application.topLevelWidgets() if widget.isVisible() and widget.updatesEnabled()]
    for window in windows:
        window.setUpdatesEnabled(False)
    try:
        yield
    finally:
        for window in windows:
            if shiboken6.isValid(window):
                window.setUpdatesEnabled(True)


def _polish_anew(widget: QWidget) -> None:
    """Let Qt look up again what `widget` looks like; one that was never shown is polished when it is."""
    if widget.testAttribute(Qt.WidgetAttribute.WA_WState_Polished):
        widget.style().unpolish(widget)
        widget.style().polish(widget)
        widget.update()


@contextmanager
def dressing_at_once() -> Iterator[None]:
    """Make many widgets in here: the style sheet comes on when all of them are there.

    Once a window has been shown, each step that puts widgets into others would dress everything below anew: a second
    window then takes 0.5 s instead of 1.2 s. The first gains 0.1 s.
    """
    application = QApplication.instance()
    assert isinstance(application, QApplication)
    sheet = application.styleSheet()
    application.setStyleSheet("")
    try:
        yield
    finally:
        application.setStyleSheet(sheet)


@cache
def font(size_px: int = TEXT, *, strong: bool = False) -> QFont:
    """Inter with tabular digits, so that columns of figures line up."""
    if not QFontDatabase.hasFamily("Inter"):
        for file in sorted((RESOURCES / "fonts").glob("*.otf")):
            QFontDatabase.addApplicationFont(str(file))
    font = QFont(["Inter", "Noto Sans", "DejaVu Sans"])
    font.setPixelSize(size_px)
    font.setWeight(QFont.Weight.DemiBold if strong else QFont.Weight.Normal)
    font.setFeature(QFont.Tag("tnum"), 1)
    return font


def role(widget: QWidget, name: str) -> QWidget:
    """Give `widget` the look called `name` and return it; may be called again when the look changes."""
    widget.setProperty("role", name)
    _polish_anew(widget)
    return widget


#: The role of each colour of a theme in the palette, by which the sheet names it. Qt's own style draws with some of
#: them as well; those that it has no use for under this sheet hold what Qt has no role for.
ROLES = {
    "window": QPalette.ColorRole.Shadow,
    "panel": QPalette.ColorRole.Window,
    "field": QPalette.ColorRole.Button,
    "hover": QPalette.ColorRole.Light,
    "line": QPalette.ColorRole.Mid,
    "text": QPalette.ColorRole.WindowText,
    "secondary": QPalette.ColorRole.PlaceholderText,
    "disabled": QPalette.ColorRole.LinkVisited,
    "accent": QPalette.ColorRole.Highlight,
    "accent_hover": QPalette.ColorRole.Midlight,
    "on_accent": QPalette.ColorRole.HighlightedText,
    "canvas": QPalette.ColorRole.Dark,
    "good": QPalette.ColorRole.BrightText,
    "warning": QPalette.ColorRole.ToolTipBase,
    "bad": QPalette.ColorRole.ToolTipText,
}

#: Colours of a theme that have further roles in the palette.
ALSO = {
    "panel": (QPalette.ColorRole.AlternateBase,),
    "field": (QPalette.ColorRole.Base,),
    "text": (QPalette.ColorRole.Text, QPalette.ColorRole.ButtonText),
    "accent": (QPalette.ColorRole.Link, QPalette.ColorRole.Accent),
}


def _palette(theme: Theme) -> QPalette:
    palette, groups = QPalette(), QPalette.ColorGroup
    for name, colour_role in ROLES.items():
        for each in (colour_role, *ALSO.get(name, ())):
            palette.setColor(each, QColor(getattr(theme, name)))
    for colour_role in (ROLES["text"], *ALSO["text"]):
        palette.setColor(groups.Disabled, colour_role, QColor(theme.disabled))
    return palette


def _in_sheet(colour_role: QPalette.ColorRole) -> str:
    """What a style sheet calls a role of the palette: 'palette(window-text)'."""
    name = re.sub(r"(?<!^)([A-Z])", r"-\1", colour_role.name).lower().replace("tool-tip", "tooltip")
    return f"palette({name})"


def _sheet() -> str:
    theme = SimpleNamespace(**{name: _in_sheet(colour_role) for name, colour_role in ROLES.items()})
    icons = (RESOURCES / "icons").as_posix()
    return f"""
QWidget {{ color: {theme.text}; }}
QWidget:disabled {{ color: {theme.disabled}; }}
QMainWindow, QDialog {{ background: {theme.window}; }}
QFileDialog {{ backward-icon: url({icons}/dialog-back.svg); forward-icon: url({icons}/dialog-forward.svg);
  filedialog-parent-directory-icon: url({icons}/dialog-parent.svg); }}
QDialogButtonBox, QMessageBox {{ dialogbuttonbox-buttons-have-icons: 0; }}
QMainWindow::separator {{ background: {theme.line}; width: 1px; height: 1px; }}
QToolTip {{ background: {theme.field}; color: {theme.text}; border: 1px solid {theme.line}; padding: 4px 6px; }}

[role="panel"] {{ background: {theme.panel}; }}
[role="bar"] {{ background: {theme.window}; }}
[role="gap"] {{ background: {theme.line}; }}
[role="canvas"] {{ background: {theme.canvas}; }}
[role="banner"] {{ background: {theme.field}; border: none; border-left: 3px solid {theme.warning}; }}
[role="card"] {{ background: {theme.field}; border: 1px solid {theme.accent}; border-radius: 6px; }}
[role="line"] {{ background: {theme.line}; max-height: 1px; min-height: 1px; border: none; }}
[role="title"] {{ color: {theme.text}; font-weight: 600; }}
[role="heading"] {{ color: {theme.text}; font-size: 18px; font-weight: 600; }}
[role="secondary"] {{ color: {theme.secondary}; }}
[role="good"] {{ color: {theme.good}; }}
[role="warning"] {{ color: {theme.warning}; }}
[role="bad"] {{ color: {theme.bad}; }}

QMenuBar {{ background: transparent; }}
QMenuBar::item {{ padding: 6px 8px; background: transparent; border-radius: 4px; }}
QMenuBar::item:selected {{ background: {theme.hover}; }}
QMenu {{ background: {theme.panel}; border: 1px solid {theme.line}; padding: 4px; }}
QMenu::item {{ padding: 5px 28px 5px 24px; border-radius: 3px; }}
QMenu::item:selected {{ background: {theme.accent}; color: {theme.on_accent}; }}
QMenu::item:disabled {{ color: {theme.disabled}; background: transparent; }}
QMenu::indicator {{ width: 14px; height: 14px; left: 6px; border-radius: 3px; }}
QMenu::indicator:checked {{ background: {theme.accent}; image: url({icons}/tick.svg); }}
QMenu::separator {{ height: 1px; background: {theme.line}; margin: 4px 8px; }}

QPushButton {{ background: {theme.field}; border: 1px solid {theme.line}; border-radius: 4px;
  padding: 0 12px; min-height: {ROW}px; }}
QPushButton:hover {{ background: {theme.hover}; }}
QPushButton:pressed {{ background: {theme.line}; }}
QPushButton:focus {{ border-color: {theme.accent}; }}
QPushButton:disabled {{ color: {theme.disabled}; background: transparent; }}
QPushButton[role="primary"] {{ background: {theme.accent}; color: {theme.on_accent}; border-color: {theme.accent};
  font-weight: 600; }}
QPushButton[role="primary"]:hover {{ background: {theme.accent_hover}; }}
QPushButton[role="primary"]:focus {{ border-color: {theme.text}; }}
QPushButton[role="primary"]:disabled {{ background: transparent; color: {theme.disabled}; border-color: {theme.line}; }}
QPushButton[role="swatch"] {{ padding: 0; min-height: 24px; max-height: 24px; }}
QPushButton[role="link"] {{ background: transparent; border: none; color: {theme.accent}; padding: 0; text-align: left;
  min-height: 20px; }}
QPushButton[role="link"]:hover {{ text-decoration: underline; }}
QPushButton[role="link"]:focus {{ text-decoration: underline; }}

QToolButton {{ background: transparent; border: 1px solid transparent; border-radius: 4px; padding: 3px; }}
QToolButton:hover {{ background: {theme.hover}; }}
QToolButton:checked {{ background: {theme.line}; }}
QToolButton[role="fold"] {{ color: {theme.secondary}; padding: 3px 4px 3px 0; }}
QToolButton[role="fold"]:checked {{ background: transparent; }}
QToolButton:focus {{ border-color: {theme.text}; }}
QToolButton[role="workspace"] {{ padding: 2px 14px 0 14px; min-height: 33px; border: none; border-radius: 0;
  color: {theme.secondary}; border-bottom: 2px solid transparent; }}
QToolButton[role="workspace"]:hover {{ color: {theme.text}; background: transparent; }}
QToolButton[role="workspace"]:focus {{ color: {theme.text}; border-bottom-color: {theme.text}; }}
QToolButton[role="workspace"]:checked {{ color: {theme.text}; background: transparent;
  border-bottom: 2px solid {theme.accent}; font-weight: 600; }}
QToolButton[role="segment"] {{ background: {theme.field}; border: 1px solid {theme.line}; border-radius: 0;
  padding: 0 10px; min-height: 24px; color: {theme.secondary}; }}
QToolButton[role="segment"]:hover {{ color: {theme.text}; }}
QToolButton[role="segment"]:checked {{ background: {theme.accent}; border-color: {theme.accent};
  color: {theme.on_accent}; }}
QToolButton[role="segment"]:focus {{ border: 2px solid {theme.text}; padding: 0 9px; min-height: 22px; }}
QToolButton[role="segment"]:checked:disabled {{ background: {theme.line}; border-color: {theme.line}; }}
QToolButton[role="segment"]:disabled {{ color: {theme.disabled}; }}

QToolButton[popupMode="1"] {{ padding-right: 18px; }}
QToolButton::menu-button {{ border: none; width: 16px; }}
QToolButton::menu-arrow {{ image: url({icons}/arrow-down.svg); width: 10px; height: 10px; }}

QLineEdit, QComboBox {{ background: {theme.field}; border: 1px solid {theme.line}; border-radius: 4px; padding: 0 8px;
  min-height: {ROW - 2}px; selection-background-color: {theme.accent}; selection-color: {theme.on_accent}; }}
QLineEdit:hover, QComboBox:hover {{ border-color: {theme.disabled}; }}
QLineEdit:focus, QComboBox:focus {{ border-color: {theme.accent}; }}
QLineEdit:disabled, QComboBox:disabled {{ background: transparent; color: {theme.disabled}; }}
QLineEdit[role="number"] {{ padding: 0 6px; }}
QLineEdit[invalid]:!disabled {{ border-color: {theme.bad}; }}
QLineEdit[invalid=""]:!disabled {{ border-color: {theme.line}; }}
QLineEdit[invalid=""]:focus {{ border-color: {theme.accent}; }}
QComboBox::drop-down {{ border: none; width: 22px; }}
QComboBox::down-arrow {{ image: url({icons}/arrow-down.svg); width: 12px; height: 12px; }}
QComboBox QAbstractItemView {{ background: {theme.panel}; border: 1px solid {theme.line}; outline: none; padding: 4px;
  selection-background-color: {theme.accent}; selection-color: {theme.on_accent}; }}
QComboBox QAbstractItemView::item {{ min-height: {ROW}px; padding-left: 4px; }}

QCheckBox {{ spacing: 8px; min-height: {ROW}px; }}
QCheckBox::indicator {{ width: 14px; height: 14px; border: 1px solid {theme.disabled}; border-radius: 3px;
  background: {theme.field}; }}
QCheckBox::indicator:hover, QCheckBox:focus::indicator {{ border-color: {theme.accent}; }}
QCheckBox::indicator:checked {{ background: {theme.accent}; border-color: {theme.accent};
  image: url({icons}/tick.svg); }}
QCheckBox::indicator:disabled {{ border-color: {theme.line}; background: transparent; }}

QAbstractItemView {{ background: {theme.panel}; border: 1px solid transparent; outline: none;
  selection-background-color: {theme.hover}; selection-color: {theme.text}; }}
QAbstractItemView:focus {{ border-color: {theme.accent}; }}
QTableView {{ gridline-color: transparent; }}
QTableView::item {{ padding: 0 9px; }}
QTableView::item:selected {{ background: {theme.hover}; color: {theme.text}; }}
QTableView QLineEdit {{ border-radius: 0; min-height: 0; padding: 0 4px; }}
QTableView QComboBox {{ background: transparent; border-color: transparent; }}
QTableView QComboBox:hover {{ border-color: {theme.disabled}; }}
QTableView QComboBox:focus {{ border-color: {theme.accent}; }}
QHeaderView {{ background: {theme.panel}; }}
QHeaderView::section {{ background: {theme.panel}; color: {theme.secondary}; border: none;
  border-bottom: 1px solid {theme.line}; padding: 4px 12px; }}
QListView#history::item:selected {{ background: {theme.accent}; color: {theme.on_accent}; }}
QPlainTextEdit {{ background: {theme.canvas}; border: none; padding: 4px; }}

QScrollArea {{ background: transparent; border: none; }}
QScrollBar:vertical {{ background: transparent; width: 10px; margin: 0; }}
QScrollBar:horizontal {{ background: transparent; height: 10px; margin: 0; }}
QScrollBar::handle {{ background: {theme.line}; border-radius: 3px; margin: 2px; }}
QScrollBar::handle:vertical {{ min-height: 28px; }}
QScrollBar::handle:horizontal {{ min-width: 28px; }}
QScrollBar::handle:hover {{ background: {theme.disabled}; }}
QScrollBar::add-line, QScrollBar::sub-line {{ width: 0; height: 0; }}
QScrollBar::add-page, QScrollBar::sub-page {{ background: transparent; }}

QSplitter::handle {{ background: {theme.line}; }}
QSplitter::handle:horizontal {{ width: 1px; }}
QSplitter::handle:vertical {{ height: 1px; }}
QSplitter::handle:hover {{ background: {theme.accent}; }}

QDockWidget {{ titlebar-close-icon: url({icons}/close-small.svg); titlebar-normal-icon: url({icons}/float-small.svg); }}
QDockWidget::title {{ background: {theme.panel}; padding: 6px 12px; font-weight: 600; }}
QMainWindow QTabBar::tab {{ background: {theme.window}; color: {theme.secondary}; border: none; padding: 5px 12px;
  border-top: 2px solid transparent; }}
QMainWindow QTabBar::tab:hover {{ color: {theme.text}; }}
QMainWindow QTabBar::tab:selected {{ background: {theme.panel}; color: {theme.text};
  border-top-color: {theme.accent}; }}
QStatusBar {{ background: {theme.window}; border-top: 1px solid {theme.line}; }}
QStatusBar::item {{ border: none; }}
"""


SMALL, LARGE = 16, 24


#: Name and colour of every icon that was drawn, by Qt's number of it.
_drawn: dict[int, tuple[str, str]] = {}


def icon(name: str, colour: str | None = None) -> QIcon:
    """The icon `name` in `colour` (the theme's text by default), greyed where disabled."""
    found = _icon(name, colour or current().text, current().disabled)
    _drawn[found.cacheKey()] = (name, colour or current().text)
    return found


def _draw_icon_anew(owner: QAbstractButton | QAction) -> None:
    """Give a button or an action its icon in the colour that has the same use in the theme of now."""
    if not shiboken6.isValid(owner):
        return  # a closed window may be destroyed meanwhile
    name, colour = _drawn.get(owner.icon().cacheKey(), ("", ""))
    use = _uses().get(colour, "")
    if use and colour not in vars(_current).values():
        owner.setIcon(icon(name, getattr(_current, use)))


@cache
def _uses() -> dict[str, str]:
    """The use of each colour of the themes; where one has several, the first in a theme."""
    return {colour: use for theme in THEMES.values() for use, colour in reversed(vars(theme).items())}


def pixmap(name: str, size: int, colour: str | None = None, scale: float = 1.0) -> QPixmap:
    """The icon `name` as an image of `size` device-independent pixels on a screen of `scale`."""
    image = QPixmap(_pixmap(name, round(size * scale), colour or current().text))
    image.setDevicePixelRatio(scale)
    return image


@cache
def _icon(name: str, colour: str, disabled: str) -> QIcon:
    return QIcon(_IconEngine(name, colour, disabled))


class _IconEngine(QIconEngine):
    """Draws an icon at the sizes that are asked for, when they are."""

    def __init__(self, name: str, colour: str, disabled: str) -> None:
        super().__init__()
        self._name, self._colours = name, {QIcon.Mode.Disabled: disabled}
        self._colour = colour

    def pixmap(self, size: QSize, mode: QIcon.Mode, _state: QIcon.State) -> QPixmap:
        extent = min(size.width(), size.height())
        return _pixmap(self._name, extent, self._colours.get(mode, self._colour)) if extent > 0 else QPixmap()

    def paint(self, painter: QPainter, place: QRect, mode: QIcon.Mode, state: QIcon.State) -> None:
        if place.isEmpty():
            return  # a button narrower than its margins leaves no place, and Qt warns of images without pixels
        pixels = place.size() * painter.device().devicePixelRatioF()
        painter.drawPixmap(place, self.pixmap(pixels, mode, state))

    def clone(self) -> QIconEngine:
        return _IconEngine(self._name, self._colour, self._colours[QIcon.Mode.Disabled])


@cache
def _pixmap(name: str, size: int, colour: str) -> QPixmap:
    drawing = (RESOURCES / "icons" / f"{name}.svg").read_text(encoding="utf-8").replace("currentColor", colour)
    renderer = QSvgRenderer(QByteArray(drawing.encode()))
    image = QPixmap(size, size)
    image.fill(Qt.GlobalColor.transparent)
    painter = QPainter(image)
    renderer.render(painter, QRectF(0, 0, size, size))
    painter.end()
    return image

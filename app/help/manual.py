"""The manual, which comes with the program: a page for each workspace and dock, a heading for each section of a panel.

F1 opens the page of the panel under the pointer, at the section that the pointer is in. Pages are Markdown in
`resources/manual`; nothing is fetched from elsewhere. An installation has them also within the whole manual
(`packaging/manual.py`), which then opens in the browser of the system, with tutorials and search.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from PySide6.QtCore import QPoint, Qt, QTimer, QUrl
from PySide6.QtGui import QDesktopServices, QTextBlock, QTextCursor
from PySide6.QtWidgets import QApplication, QDialog, QDockWidget, QHBoxLayout, QTextBrowser, QVBoxLayout, QWidget

from app.help.anchors import anchor_of
from app.widgets.panels import Rows, button
from app.widgets.resources import RESOURCES
from app.widgets.theme import STEP

PAGES = RESOURCES / "manual"

#: The whole manual for a browser; missing in a checkout.
HTML = PAGES / "html"

START = "start"

#: Width and height of the window of the manual, which is no higher than the smallest window of the program.
SIZE_PX = (560, 620)


def place_of(widget: QWidget | None, workspaces: Mapping[str, QWidget]) -> tuple[str, str]:
    """The page and the heading for what is under the pointer; the first page and no heading where nothing is known.

    A dock's page has the name of the dock, a workspace's the name of the workspace.
    """
    names, heading = {id(tab): name for name, tab in workspaces.items()}, ""
    while widget is not None:
        if isinstance(widget, Rows) and widget.title and not heading:
            heading = widget.title
        page = widget.objectName() if isinstance(widget, QDockWidget) else names.get(id(widget), "")
        if page and (PAGES / f"{page}.md").is_file():
            return page, heading if heading in headings(page) else ""
        widget = widget.parentWidget()
    return START, ""


def headings(page: str) -> list[str]:
    """The headings of a page below its title, in their order."""
    lines = path_of(page).read_text(encoding="utf-8").splitlines()
    return [line.removeprefix("## ") for line in lines if line.startswith("## ")]


def path_of(page: str) -> Path:
    """The file of a page."""
    return PAGES / f"{page}.md"


class Manual(QDialog):
    """Pages with links to each other; it may stay open beside the work."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.setWindowTitle("Manual")
        self.resize(*SIZE_PX)
        self.pages = QTextBrowser()
        self.pages.setAccessibleName("Manual")
        self.pages.setSearchPaths([str(PAGES)])
        self.pages.sourceChanged.connect(lambda _page: self._space())
        self.back = button("Previous page")
        self.back.setEnabled(False)
        self.back.clicked.connect(self.pages.backward)
        self.pages.backwardAvailable.connect(self.back.setEnabled)
        self.contents = button("Contents")
        self.contents.clicked.connect(lambda: self.show_page(START))
        close = button("Close", "primary")
        close.clicked.connect(self.close)
        foot = QHBoxLayout()
        foot.addWidget(self.back)
        foot.addWidget(self.contents)
        foot.addStretch(1)
        foot.addWidget(close)
        column = QVBoxLayout(self)
        column.addWidget(self.pages)
        column.addLayout(foot)

    def show_page(self, page: str, heading: str = "") -> None:
        """Open a page, with `heading` on top."""
        self.pages.setSource(QUrl.fromLocalFile(str(path_of(page))))
        self.show()
        self.raise_()
        QTimer.singleShot(0, self, lambda: self._scroll_to(heading))

    def _space(self) -> None:
        """Set headings apart from what is above them; Markdown knows no distances."""
        block = self.pages.document().begin()
        while block.isValid():
            spaced = block.blockFormat()
            level = spaced.headingLevel()
            spaced.setTopMargin(4 * STEP if level > 1 else 0 if level or block.textList() else STEP)
            spaced.setBottomMargin(STEP)
            QTextCursor(block).setBlockFormat(spaced)
            block = block.next()

    def _scroll_to(self, heading: str) -> None:
        """Once the page has its width: `heading` on top, as far as the page is long enough."""
        block = self._found(heading)
        if block is not None:
            self.pages.moveCursor(QTextCursor.MoveOperation.End)
            self.pages.setTextCursor(QTextCursor(block))

    def _found(self, heading: str) -> QTextBlock | None:
        block = self.pages.document().begin()
        while heading and block.isValid():
            if block.blockFormat().headingLevel() and block.text() == heading:
                return block
            block = block.next()
        return None


def address_of(page: str, heading: str) -> QUrl:
    """The address of a heading in the manual for a browser; of the contents where the pointer is on no panel."""
    if page == START:
        return QUrl.fromLocalFile(str(HTML / "index.html"))
    address = QUrl.fromLocalFile(str(HTML / "reference" / "workspaces" / f"{page}.html"))
    address.setFragment(anchor_of(page, heading))
    return address


def show_for_pointer(window: QWidget, workspaces: Mapping[str, QWidget], pointer: QPoint) -> Manual | None:
    """Open the manual at what is below `pointer`, a place on the screen; outside of `window`, at what has the focus.

    Where the manual for a browser is missing or no browser opens it, the pages of the panels are shown in a dialog,
    which is returned.
    """
    under = QApplication.widgetAt(pointer)
    if under is None or under.window() is not window:
        under = QApplication.focusWidget()
    page, heading = place_of(under, workspaces)
    if page == START:
        page = next((name for name, tab in workspaces.items() if tab.isVisible()), START)
    return show_help(window, page, heading)


def show_help(window: QWidget, page: str, heading: str = "") -> Manual | None:
    """Open the manual at a heading of a page, in a browser or else in a dialog, which is returned."""
    if HTML.is_dir() and QDesktopServices.openUrl(address_of(page, heading)):
        return None
    manual = window.findChild(Manual) or Manual(window)
    manual.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose, False)
    manual.show_page(page, heading)
    return manual

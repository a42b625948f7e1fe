"""The manual has a page for every workspace and dock, and a heading for every section of their panels."""

from __future__ import annotations

import re
from typing import Any

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDockWidget, QWidget

from app.help.manual import PAGES, Manual, headings, path_of, place_of
from app.widgets.panels import Rows
from app.window.main_window import MainWindow


def sections(widget: QWidget) -> set[str]:
    return {rows.title for rows in widget.findChildren(Rows) if rows.title}


def test_every_section_of_every_workspace_and_dock_is_explained(window: MainWindow) -> None:
    missing = {name: sections(tab) - {*headings(name)} for name, tab in window.tabs.items()}
    assert {name: titles for name, titles in missing.items() if titles} == {}
    docks = [dock.objectName() for dock in window.findChildren(QDockWidget)]
    assert [name for name in docks if not path_of(name).is_file()] == []


def test_links_of_the_manual_lead_to_its_pages() -> None:
    links = {(page.name, to) for page in PAGES.glob("*.md") for to in re.findall(r"\]\(([^)]*)\)", page.read_text())}
    assert links
    assert [link for link in links if not (PAGES / link[1]).is_file()] == []


def test_the_page_and_the_heading_are_those_of_what_is_under_the_pointer(window: MainWindow, qtbot: Any) -> None:
    window.show_workspace("view")
    lights, effects = window.view.lights, window.docks.effects
    assert place_of(lights.lighting, window.tabs) == ("view", "Light")
    assert place_of(effects.budget, window.tabs) == ("effects", "")
    assert place_of(window.bar, window.tabs) == ("start", "")
    manual = Manual(window)
    manual.show_page("view", "Look-up")
    qtbot.waitUntil(lambda: manual.pages.textCursor().block().text() == "Look-up", timeout=20_000)
    assert manual.pages.viewport().rect().contains(manual.pages.cursorRect())
    qtbot.mouseClick(manual.contents, Qt.MouseButton.LeftButton)
    assert "Lightarc" in manual.pages.toPlainText()
    manual.close()

"""The manual has a page for every workspace and dock, and a heading for every section of their panels."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import QPoint, Qt, QUrl
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import QDockWidget, QWidget

from app.help import manual as manual_module
from app.help.manual import PAGES, Manual, headings, path_of, place_of, show_for_pointer
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
    manual.show_page("view", "Sampling")
    qtbot.waitUntil(lambda: manual.pages.textCursor().block().text() == "Sampling", timeout=20_000)
    assert manual.pages.viewport().rect().contains(manual.pages.cursorRect())
    qtbot.mouseClick(manual.contents, Qt.MouseButton.LeftButton)
    assert "Lightarc" in manual.pages.toPlainText()
    manual.close()


def test_the_manual_for_a_browser_opens_at_the_heading_where_it_is_installed(
    window: MainWindow, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[str] = []
    answers = iter((True, False))

    def open_url(url: QUrl) -> bool:
        opened.append(url.toString())
        return next(answers)

    monkeypatch.setattr(QDesktopServices, "openUrl", open_url)
    monkeypatch.setattr(manual_module, "HTML", tmp_path)
    monkeypatch.setattr(manual_module, "place_of", lambda widget, tabs: ("view", "Spatial variation"))
    nowhere = QPoint(-5, -5)
    assert show_for_pointer(window, window.tabs, nowhere) is None
    assert opened == [f"file://{tmp_path}/reference/workspaces/view.html#panel-view-spatial-variation"]
    dialog = show_for_pointer(window, window.tabs, nowhere)
    assert dialog is not None, "no browser opened it"
    dialog.close()

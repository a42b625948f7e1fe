"""The first hints: six, by keys, each beside its place and inside the window, and not shown twice."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from app.help.tour import Tour
from app.window.main_window import MainWindow


def test_six_hints_lead_through_the_window_by_keys(window: MainWindow, qtbot: Any) -> None:
    window.resize(1024, 700)
    window.show_hints()
    (tour,) = window.findChildren(Tour)
    shown, workspaces = [], []
    for _ in range(6):
        card = tour.card.geometry()
        assert tour.rect().contains(card)
        shown.append(tour.heading.text())
        workspaces.append(next(name for name, tab in window.tabs.items() if tab.isVisible()))
        QTest.keyClick(tour, Qt.Key.Key_Right)
    assert len({*shown}) == 6
    assert workspaces == ["capture", "capture", "material", "view", "view", "export"]
    assert not tour.isVisible()
    assert window.settings.now.has_seen_hints


def test_esc_ends_the_hints_and_gives_the_keys_back_to_the_workspace(window: MainWindow) -> None:
    window.show_hints()
    (tour,) = window.findChildren(Tour)
    QTest.keyClick(tour, Qt.Key.Key_Escape)
    assert not tour.isVisible()
    focus = window.focusWidget()
    assert focus is window.capture or window.capture.isAncestorOf(focus)

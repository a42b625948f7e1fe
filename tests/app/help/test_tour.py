"""The welcome tour: six hints by keys, each beside the part that it describes, and not shown twice."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from app.help.tour import Tour
from app.window.main_window import MainWindow


def test_six_hints_lead_through_the_window_and_cover_nothing_that_they_describe(window: MainWindow, qtbot: Any) -> None:
    for size in ((1280, 720), (1920, 1000)):
        window.resize(*size)
        window.show_hints()
        tour = next(each for each in window.findChildren(Tour) if each.isVisible())
        qtbot.waitUntil(window.view.isVisible)
        shown = []
        for _ in range(6):
            qtbot.waitUntil(lambda tour=tour: tour.frame.geometry() == tour.place)
            card = tour.geometry()
            assert window.rect().contains(card)
            assert not card.intersects(tour.place), tour.heading.text()
            shown.append(tour.heading.text())
            QTest.keyClick(tour, Qt.Key.Key_Right)
        assert len({*shown}) == 6
        assert not tour.isVisible()
    assert window.settings.now.has_seen_hints


def test_esc_ends_the_tour_and_gives_the_keys_back_to_the_workspace(window: MainWindow) -> None:
    window.show_hints()
    (tour,) = window.findChildren(Tour)
    QTest.keyClick(tour, Qt.Key.Key_Escape)
    assert not tour.isVisible()
    focus = window.focusWidget()
    assert focus is window.view or window.view.isAncestorOf(focus)

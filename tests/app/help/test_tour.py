"""The welcome tour: six hints by keys, each beside the part that it describes, and not shown twice."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from app.help.tour import Tour
from app.widgets.number_field import NumberField
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
            read = tour._readable()
            covered = sum((card & each).width() * (card & each).height() for each in read if card.intersects(each))
            assert covered < 0.2 * card.width() * card.height(), tour.heading.text()
            shown.append(tour.heading.text())
            QTest.keyClick(tour, Qt.Key.Key_Right)
        assert len({*shown}) == 6
        assert not tour.isVisible()
    assert window.settings.now.has_seen_hints


def test_esc_ends_the_tour_and_gives_the_keys_back_to_the_workspace(window: MainWindow, qtbot: Any) -> None:
    window.activateWindow()
    qtbot.waitUntil(window.isActiveWindow, timeout=30_000)
    field = window.view.findChild(NumberField)
    for place in (None, window.view.viewport, field, window.bar):
        window.show_hints()
        tour = next(each for each in window.findChildren(Tour) if each.isVisible())
        has_focus = place if place is not None else tour
        has_focus.setFocus()
        QTest.keyClick(has_focus, Qt.Key.Key_Escape)
        assert not tour.isVisible(), has_focus
        focus = window.focusWidget()
        assert focus is window.view or window.view.isAncestorOf(focus)


def test_esc_in_a_number_that_is_being_edited_takes_that_back_before_it_ends_the_tour(
    window: MainWindow, qtbot: Any
) -> None:
    window.activateWindow()
    qtbot.waitUntil(window.isActiveWindow, timeout=30_000)
    window.show_hints()
    (tour,) = window.findChildren(Tour)
    for show, is_seen in ((window.show_start, False), (lambda: window.show_workspace("view"), True)):
        show()
        assert (tour.isVisible(), tour.frame.isVisible()) == (is_seen, is_seen), "it waits where its part is not seen"
    field = next(each for each in window.view.findChildren(NumberField) if each.isVisible() and each.isEnabled())
    before = field.value
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, "0")
    QTest.keyClick(field, Qt.Key.Key_Escape)
    assert tour.isVisible()
    assert field.value == before
    QTest.keyClick(window.focusWidget(), Qt.Key.Key_Escape)
    assert not tour.isVisible()

"""The loupe on the big image: pixels at 100 %, a place that stays, and keys."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QColor

from app.capture.loupe import Loupe
from app.widgets.image_view import ImageView, pixels_image
from tests.app.captures import drag

LEVELS = np.random.default_rng(3).integers(0, 256, (600, 1000, 3), dtype=np.uint8)


@pytest.fixture
def loupe(qapp: object, qtbot: Any) -> Loupe:
    view = ImageView()
    qtbot.addWidget(view)
    view.resize(500, 400)
    view.show_image(pixels_image(LEVELS))
    view.show()
    qtbot.waitExposed(view)
    made = Loupe(view)
    made.open()
    made.move_to(QPointF(500.0, 300.0))
    return made


def colour_at(loupe: Loupe, x: int, y: int) -> tuple[int, int, int]:
    colour = QColor(loupe.grab().toImage().pixel(x, y))
    return colour.red(), colour.green(), colour.blue()


def test_a_pixel_of_the_photograph_is_one_of_the_screen(loupe: Loupe) -> None:
    half = loupe.width() // 2
    for dx, dy in ((0, 0), (-50, 30), (70, -60)):
        assert colour_at(loupe, half + dx, half + dy) == tuple(LEVELS[300 + dy, 500 + dx])
    loupe.magnify(1)
    assert colour_at(loupe, half + 40, half - 20) == tuple(LEVELS[300 - 10, 500 + 20])


def test_its_place_stays_while_photographs_change(loupe: Loupe) -> None:
    loupe.view.show_image(pixels_image(255 - LEVELS))
    assert loupe.place == QPointF(500.0, 300.0)
    half = loupe.width() // 2
    assert colour_at(loupe, half, half) == tuple(255 - LEVELS[300, 500])
    loupe.view.show_image(pixels_image(LEVELS[::2, ::2]))
    assert loupe.place == QPointF(250.0, 150.0)


def test_it_lies_over_its_place_and_within_the_image(loupe: Loupe) -> None:
    middle = loupe.view.to_screen(loupe.place)
    assert (QPointF(loupe.geometry().center()) - middle).manhattanLength() <= 2.0
    loupe.move_to(QPointF(-40.0, 9_999.0))
    assert loupe.place == QPointF(0.0, 600.0)
    assert loupe.view.rect().contains(loupe.geometry())


def test_a_drag_moves_it_as_the_pointer_moves_over_the_photograph(loupe: Loupe) -> None:
    start = QPointF(100.0, 100.0)
    loupe.grab()
    drag_by = QPointF(20.0, -10.0)
    before = loupe.place
    drag(loupe, start, start + drag_by)
    moved = loupe.place - before
    assert moved.x() > 0.0 > moved.y()


def test_keys_move_it_and_leave_the_photograph(loupe: Loupe, qtbot: Any) -> None:
    loupe.setFocus()
    qtbot.keyClick(loupe, Qt.Key.Key_Right)
    qtbot.keyClick(loupe, Qt.Key.Key_Up, Qt.KeyboardModifier.ControlModifier)
    qtbot.keyClick(loupe, Qt.Key.Key_Down, Qt.KeyboardModifier.ShiftModifier)
    assert loupe.place == QPointF(516.0, 427.0)
    qtbot.keyClick(loupe, Qt.Key.Key_Plus)
    assert loupe.magnification == 2
    qtbot.keyClick(loupe, Qt.Key.Key_Minus)
    qtbot.keyClick(loupe, Qt.Key.Key_Minus)
    assert loupe.magnification == 1
    with qtbot.waitSignal(loupe.closed):
        qtbot.keyClick(loupe, Qt.Key.Key_Escape)


def test_the_read_out_follows_the_pixel_below_the_pointer(loupe: Loupe, qtbot: Any) -> None:
    half = loupe.width() // 2
    with qtbot.waitSignal(loupe.view.pointed) as pointed:
        qtbot.mouseMove(loupe, loupe.rect().center() + loupe.rect().topLeft())
    column, row = pointed.args
    assert abs(column - 500) <= 1
    assert abs(row - 300) <= 1
    assert half > 0


def test_a_image_that_is_magnified_is_magnified_further(loupe: Loupe) -> None:
    loupe.hide()
    loupe.view.resize(2500, 1600)  # all of it at more than 200 %
    loupe.open()
    assert loupe.view.zoom * loupe.devicePixelRatioF() > 2.0
    assert loupe.magnification == 4

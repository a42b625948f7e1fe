"""The card of a target: a click anywhere on it chooses it, and it is as large as all cards fit."""

from __future__ import annotations

from typing import Any

import pytest
from PySide6.QtCore import QPoint, Qt

from app.export.card import SPHERES, Board, Card


def test_a_click_anywhere_on_a_card_is_one_on_its_box(qtbot: Any) -> None:
    card = Card("gltf", "glTF", "A hint")
    qtbot.addWidget(card)
    card.show()
    assert card.box is not None
    was = card.box.isChecked()
    for place in (card.sphere.geometry().center(), card.figures[0].geometry().center(), QPoint(3, card.height() - 3)):
        child = card.childAt(place) or card
        qtbot.mouseClick(child, Qt.MouseButton.LeftButton, pos=child.mapFrom(card, place))
        assert card.box.isChecked() != was
        was = not was
    card.refuse("It has no maps")
    qtbot.mouseClick(card, Qt.MouseButton.LeftButton, pos=QPoint(3, 3))
    assert card.box.isChecked() == was


@pytest.mark.parametrize(
    ("size", "sphere"), [((640, 480), SPHERES[0]), ((1010, 820), SPHERES[1]), ((2200, 1300), SPHERES[-1])]
)
def test_cards_are_as_large_as_all_of_them_fit(qtbot: Any, size: tuple[int, int], sphere: int) -> None:
    board = Board([Card(f"card {place}", "glTF", "A hint") for place in range(10)])
    qtbot.addWidget(board)
    board.resize(*size)
    board.show()
    qtbot.waitUntil(lambda: board.cards[0].sphere.width() == sphere)
    bar = board.verticalScrollBar()
    qtbot.waitUntil(lambda: (bar.maximum() > 0) == (sphere == SPHERES[0]))
    assert all(card.width() >= card.minimumWidth() for card in board.cards)

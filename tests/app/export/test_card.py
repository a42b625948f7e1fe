"""The card of a target: a click anywhere on it chooses it."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import QPoint, Qt

from app.export.card import Card


def test_a_click_anywhere_on_a_card_is_one_on_its_box(qtbot: Any) -> None:
    card = Card("gltf", "glTF", "A hint")
    qtbot.addWidget(card)
    card.show()
    assert card.box is not None
    was = card.box.isChecked()
    for place in (card.ball.geometry().center(), card.figures[0].geometry().center(), QPoint(3, card.height() - 3)):
        child = card.childAt(place) or card
        qtbot.mouseClick(child, Qt.MouseButton.LeftButton, pos=child.mapFrom(card, place))
        assert card.box.isChecked() != was
        was = not was
    card.refuse("It has no maps")
    qtbot.mouseClick(card, Qt.MouseButton.LeftButton, pos=QPoint(3, 3))
    assert card.box.isChecked() == was

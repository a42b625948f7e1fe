"""The view of an image, and what stands in its place."""

from __future__ import annotations

from typing import Any

from app.widgets.image_view import ImageView


def test_words_stand_where_there_is_no_image(qtbot: Any) -> None:
    view = ImageView()
    qtbot.addWidget(view)
    view.resize(300, 200)
    empty = view.grab().toImage()
    view.say("These photographs are not imported.")
    assert view.grab().toImage() != empty
    view.say("")
    assert view.grab().toImage() == empty

"""An OpenGL widget says nothing while it paints, since what hears it may change the widget's size."""

from __future__ import annotations

from typing import Any, cast

import pytest
from PySide6.QtGui import QOpenGLContext
from PySide6.QtWidgets import QApplication

from app.viewport.gl_widget import GlWidget
from app.window.main_window import MainWindow


def test_what_follows_a_image_happens_after_the_paint_event(window: MainWindow, qtbot: Any) -> None:
    surface: Any = window.view.viewport.surface
    if not isinstance(surface, GlWidget):
        pytest.skip("OpenGL 3.3 is not available")
    heard: list[bool] = []
    cast(Any, surface).drawn.connect(lambda _seconds: heard.append(surface.is_painting))
    window.show_workspace("view")
    qtbot.waitUntil(lambda: len(heard) > 0, timeout=30_000)
    assert not any(heard)


def test_a_widget_that_is_resized_while_it_paints_raises(
    qapp: QApplication, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    raised: list[type] = []
    monkeypatch.setattr("sys.excepthook", lambda kind, _error, _trace: raised.append(kind))

    class Resized(GlWidget):
        def paint(self, framebuffer: Any) -> None:
            framebuffer.clear(0.0, 0.0, 0.0, 1.0)
            self.resize(self.width() + 1, self.height())

    with qtbot.captureExceptions() as caught:
        widget = Resized()
        qtbot.addWidget(widget)
        widget.resize(64, 64)
        widget.show()
        qtbot.waitExposed(widget)
        qtbot.waitUntil(lambda: bool(raised or caught), timeout=5_000)
    kinds = {*raised, *(kind for kind, *_ in caught)}
    assert kinds == {RuntimeError}


def test_the_context_before_is_current_again_after_the_block(qapp: QApplication, qtbot: Any) -> None:
    one, other = GlWidget(), GlWidget()
    for widget in (one, other):
        qtbot.addWidget(widget)
        widget.resize(32, 32)
        widget.show()
        qtbot.waitExposed(widget)
    qtbot.waitUntil(lambda: one.gl is not None and other.gl is not None)
    before = QOpenGLContext.currentContext()
    with one.current():
        with other.current():
            assert QOpenGLContext.currentContext() is other.context()
        assert QOpenGLContext.currentContext() is one.context()
        with one.current():
            pass
        assert QOpenGLContext.currentContext() is one.context()
    assert QOpenGLContext.currentContext() is before

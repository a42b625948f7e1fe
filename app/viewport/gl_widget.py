"""A widget that owns an OpenGL context: the one place of the window where a context is made, current and given up.

Three rules keep Qt and OpenGL from meeting at the wrong moment:

- Every OpenGL call happens in `paint` or within `with widget.current()`, which restores what was current before.
- While it paints, the widget says nothing to the rest of the window; what it has to say is emitted when the event is
  over (`emit_later`). Qt composes the window with the texture that the widget had when painting began, so a label that
  changes its width, and with it the size of this widget, takes that texture away, and the program dies.
- So a widget that is resized while it paints is a fault of the program, and raises.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

from PySide6.QtCore import QTimer, Signal, SignalInstance
from PySide6.QtGui import QOpenGLContext, QResizeEvent
from PySide6.QtOpenGLWidgets import QOpenGLWidget
from shiboken6 import isValid

from app.process import crash
from engine.core.errors import MissingCapability
from engine.gl.context import Context, Framebuffer, attach_context, driver_name


class GlWidget(QOpenGLWidget):
    """Calls `begin` when there is a context, `paint(framebuffer)` to draw, and `forget` before the context goes.

    `failed` says that OpenGL cannot be used at all. All three are called with the context current.

    Attributes
    ----------
    gl : the moderngl context; None before the first and after the last image.
    is_painting : True within `paint`.
    """

    failed = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self.gl: Context | None = None
        self.is_painting = False

    @property
    def device(self) -> Context:
        """The context, for `begin`, `paint` and `forget`, which are called while there is one."""
        assert self.gl is not None
        return self.gl

    def begin(self) -> None:
        """Make what drawing needs, in a new context."""

    def paint(self, framebuffer: Framebuffer) -> None:
        """Draw into `framebuffer`."""

    def forget(self) -> None:
        """Release everything that was made in the context."""

    @contextmanager
    def current(self) -> Iterator[None]:
        """Make the widget's context current for the block, and afterwards the one that was current before."""
        before = QOpenGLContext.currentContext()
        surface = before.surface() if before is not None else None
        self.makeCurrent()
        try:
            yield
        finally:
            if before is None:
                self.doneCurrent()
            elif before is not self.context():
                before.makeCurrent(surface)

    def emit_later(self, signal: SignalInstance, *values: object) -> None:
        """Emit `signal` once the event that is handled now is over."""
        QTimer.singleShot(0, self, partial(signal.emit, *values))

    def initializeGL(self) -> None:
        try:
            self.gl = attach_context()
            crash.state("OpenGL", driver_name(self.gl))
        except MissingCapability as error:
            self.gl = None
            self.emit_later(self.failed, error)
            return
        self.begin()
        self.context().aboutToBeDestroyed.connect(self._give_up)

    def paintGL(self) -> None:
        if self.gl is None:
            return
        self.is_painting = True
        try:
            self.paint(self.gl.detect_framebuffer(self.defaultFramebufferObject()))
        finally:
            self.is_painting = False

    def resizeEvent(self, event: QResizeEvent) -> None:
        if self.is_painting:
            raise RuntimeError("an OpenGL widget was resized while it painted: use emit_later() in place of emit()")
        super().resizeEvent(event)

    def _give_up(self) -> None:
        """The context goes away (the window moved to another screen, say); everything is made anew in the next one."""
        if not isValid(self) or self.gl is None:
            return
        with self.current():
            self.forget()
            self.gl = None

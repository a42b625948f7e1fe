"""The longest that the window's thread was held up: the delays of a timer behind its plan, with and without drawing."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

TICK_MS = 5
LIMIT_MS = 50.0


class Drawing:
    """Seconds that the window's thread has spent so far on drawing images and composing the window with them.

    `busy_s` are those of them in which the CPU worked for this thread.
    """

    seconds = busy_s = 0.0
    _since = (0.0, 0.0)

    @classmethod
    def watch(cls, surface: Any) -> None:
        """Count what is drawn from now on; `surface` is one of those that the window is composed with."""
        from app.viewport.gl_surface import GlSurface
        from app.viewport.gl_widget import GlWidget
        from app.viewport.refining import Refining

        if not isinstance(surface, GlSurface):
            return
        for owner, name in ((Refining, "_advance"), (GlSurface, "_show"), (GlWidget, "initializeGL")):
            setattr(owner, name, cls._time(getattr(owner, name)))
        surface.aboutToCompose.connect(lambda: setattr(cls, "_since", _clocks()))
        surface.frameSwapped.connect(lambda: cls._add(cls._since))

    @classmethod
    def _add(cls, since: tuple[float, float]) -> None:
        now = _clocks()
        cls.seconds += now[0] - since[0]
        cls.busy_s += now[1] - since[1]

    @classmethod
    def _time(cls, work: Callable[..., Any]) -> Callable[..., Any]:
        def time(*arguments: Any) -> Any:
            since = _clocks()
            try:
                return work(*arguments)
            finally:
                cls._add(since)

        return time


class Gaps:
    """Delays of a timer of the window's thread behind its plan, in milliseconds, counted while `counts` says so.

    `own_ms` are the same without what went into drawing, and `busy_ms` is the time of the CPU in that: where
    other programs work as well, they tell what the window would have taken alone.
    """

    def __init__(self, counts: Callable[[], bool] = lambda: True) -> None:
        from PySide6.QtCore import Qt, QTimer

        self.counts = counts
        self.gaps_ms: list[float] = [0.0]
        self.own_ms: list[float] = [0.0]
        self.busy_ms: list[float] = [0.0]
        self._last = self._state()
        self._timer = QTimer()
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.timeout.connect(self._tick)
        self._timer.start(TICK_MS)

    def stop(self) -> None:
        self._timer.stop()

    @staticmethod
    def _state() -> tuple[float, float, float, float]:
        return *_clocks(), Drawing.seconds, Drawing.busy_s

    def _tick(self) -> None:
        now = self._state()
        passed_s, busy_s, drawn_s, drawn_busy_s = (
            after - before for after, before in zip(now, self._last, strict=True)
        )
        if self.counts():
            self.gaps_ms.append(1000 * passed_s - TICK_MS)
            self.own_ms.append(1000 * (passed_s - drawn_s) - TICK_MS)
            self.busy_ms.append(1000 * (busy_s - drawn_busy_s))
        self._last = now

    def figures(self, name: str) -> dict[str, float]:
        """The longest, the longest without drawing, its time of the CPU, and how many were over the limit."""
        return {
            f"{name}_block_ms": round(max(self.gaps_ms), 1),
            f"{name}_own_block_ms": round(max(self.own_ms), 1),
            f"{name}_own_busy_ms": round(max(self.busy_ms), 1),
            f"{name}_blocks_over_50_ms": sum(gap > LIMIT_MS for gap in self.gaps_ms),
            f"{name}_own_blocks_over_50_ms": sum(gap > LIMIT_MS for gap in self.own_ms),
        }


def _clocks() -> tuple[float, float]:
    return time.perf_counter(), time.thread_time()

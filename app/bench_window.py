"""Measures the window: how soon it can be used, and how long its thread is ever held up while real jobs run.

    python -m app.bench_window [FOLDER]

A timer that should fire every 5 ms runs while the capture in FOLDER (the built-in sample without it) is imported,
shaded and fitted; the longest delay of a tick while a heavy job runs is the longest block. One JSON object on standard
output: `window_start_s`, `longest_block_ms`, `blocks_over_50_ms`, `jobs_s`, and `complete`.
"""

from __future__ import annotations

import time

STARTED_S = time.perf_counter()

import json  # noqa: E402 - the clock starts before anything is imported
import sys  # noqa: E402
import tempfile  # noqa: E402
from collections.abc import Callable  # noqa: E402
from pathlib import Path  # noqa: E402

TICK_MS = 5
LIMIT_MS = 50.0
PATIENCE_S = 300.0


def main() -> int:
    from PySide6.QtCore import QTimer

    from app.main_window import MainWindow, start

    application = start()
    with tempfile.TemporaryDirectory() as folder:
        window = MainWindow(Path(folder))
        window.show()
        application.processEvents()
        start_s = time.perf_counter() - STARTED_S
        bench = window.bench
        gaps = _Gaps(lambda: any(job.heavy for job in bench.jobs.active))
        begun = time.perf_counter()
        if len(sys.argv) > 1:
            window.open([Path(sys.argv[1])])
        else:
            bench.open_sample()
        bench.jobs.failed.connect(lambda job, error: _give_up(f"{job.title}: {error}"))
        watch = QTimer()
        watch.timeout.connect(
            lambda: application.quit() if bench.document.project.has_map and not bench.jobs.active else None
        )
        watch.start(100)
        QTimer.singleShot(round(1000 * PATIENCE_S), application.quit)
        application.exec()
        jobs_s = time.perf_counter() - begun
        complete = bench.document.project.has_map
        window.close()
    print(
        json.dumps(
            {
                "window_start_s": round(start_s, 3),
                "longest_block_ms": round(max(gaps.gaps_ms), 1),
                "blocks_over_50_ms": sum(gap > LIMIT_MS for gap in gaps.gaps_ms),
                "jobs_s": round(jobs_s, 2),
                "complete": complete,
            }
        )
    )
    return 0 if complete else 1


def _give_up(words: str) -> None:
    from PySide6.QtWidgets import QApplication

    print(words, file=sys.stderr)
    QApplication.exit(1)


class _Gaps:
    """How much later than planned a timer of the window's thread fires while `counts` says so, in milliseconds."""

    def __init__(self, counts: Callable[[], bool]) -> None:
        from PySide6.QtCore import Qt, QTimer

        self.counts = counts
        self.gaps_ms: list[float] = [0.0]
        self._last_s = time.perf_counter()
        self._timer = QTimer()
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.timeout.connect(self._tick)
        self._timer.start(TICK_MS)

    def _tick(self) -> None:
        now = time.perf_counter()
        if self.counts():
            self.gaps_ms.append(1000 * (now - self._last_s) - TICK_MS)
        self._last_s = now


if __name__ == "__main__":
    sys.exit(main())

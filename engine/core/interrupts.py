"""Interrupts that wait until compiled code has returned."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def interrupts_held() -> Iterator[None]:
    """Signals that Python handles on this thread are handled after the block.

    Compiled code that calls Python back ends the process where such a call is interrupted (moderngl, for the uniforms
    of a program), or takes the interrupt for an error of its own (nanobind, for an array that it returns).
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    own = {number: handler for number, handler in handlers.items() if callable(handler)}
    try:
        for number in own:
            signal.signal(number, lambda number, _frame: came.append(number))
        yield
    finally:
        for number, handler in own.items():
            signal.signal(number, handler)
        for first in came[:1]:
            own[signal.Signals(first)](first, None)

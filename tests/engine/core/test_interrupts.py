"""Interrupts that wait until compiled code has returned."""

from __future__ import annotations

import signal
from collections.abc import Iterator

import pytest

from engine.core.interrupts import interrupts_held


@pytest.fixture
def interrupted_by_default() -> Iterator[None]:
    """Python's own handler: a test run that began in the background of a script ignores the signal."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_an_interrupt_waits_for_the_end_of_the_block(interrupted_by_default: None) -> None:
    reached = []
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt), interrupts_held():  # noqa: PT012 - the signal may not end the block
        signal.raise_signal(signal.SIGINT)
        reached.append(True)
    assert reached
    assert signal.getsignal(signal.SIGINT) is before

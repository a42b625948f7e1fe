"""What a shortage of memory, threads or files is called, whichever library reports it."""

from __future__ import annotations

import errno

from engine.core.errors import OutOfMemory, shortage


def test_numpy_says_how_much_memory_was_asked_for() -> None:
    error = MemoryError()
    error._total_size = 3 << 20  # type: ignore[attr-defined]
    assert str(shortage(error)).startswith("There is not enough memory: 3.0 MiB more were needed. Close other programs")
    assert str(shortage(MemoryError())).startswith("There is not enough memory. ")


def test_what_is_no_shortage_is_none() -> None:
    own = OutOfMemory("The card is full")
    assert shortage(own) is own
    assert shortage(ValueError("x")) is None
    assert shortage(OSError(errno.ENOENT, "absent")) is None
    assert "memory" in str(shortage(OSError(errno.ENOMEM, "x")))
    assert "thread" in str(shortage(RuntimeError("can't start new thread")))
    assert shortage(OSError(errno.EMFILE, "x")) is not None

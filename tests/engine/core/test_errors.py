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


def test_what_libraries_in_c_make_of_too_little_memory_is_a_shortage() -> None:
    """OpenCV returns from a function with an error set, of which Python makes a SystemError; or raises its own."""
    returned = SystemError("<built-in function filter2D> returned a result with an exception set")
    returned.__cause__ = MemoryError()
    assert shortage(returned) is not None
    assert shortage(SystemError("bad argument to internal function")) is None
    assert shortage(ExceptionGroup("failed the first time", [MemoryError()])) is not None
    assert shortage(ExceptionGroup("failed the first time", [ValueError()])) is None
    of_opencv = type("error", (Exception,), {"__module__": "cv2", "code": -4})
    assert shortage(of_opencv("(-4:Insufficient memory) Failed to allocate 4096 bytes")) is not None

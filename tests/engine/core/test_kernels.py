"""Kernels load their compiler when the first of them is called, and call each other as compiled functions."""

from __future__ import annotations

import errno
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from engine.core import budget, kernels
from engine.core.kernels import Kernel, list_compiling, parallel, prange, scalar, threads_are_shared


@scalar
def _square(value: float) -> float:
    """Square."""
    return value * value


@scalar
def _factorial(count: int) -> int:
    return 1 if count < 2 else count * _factorial(count - 1)


@parallel
def _sum_of_squares(values: Any) -> float:
    total = 0.0
    for place in prange(len(values)):
        total += _square(values[place])
    return total


def _scale_by(inner: Any) -> Any:
    @scalar
    def outer(value: float) -> float:
        return 3.0 * inner(value)

    return outer


def test_kernels_call_each_other_compiled() -> None:
    assert isinstance(_square, Kernel)
    assert _square.__doc__ == "Square."
    assert _sum_of_squares(np.arange(4.0)) == 14.0
    assert not isinstance(_square, Kernel), "later calls by the name of the module are numba's own"
    assert threads_are_shared() in (True, False)
    assert _factorial(5) == 120
    assert _factorial.signatures, "attributes are those of the compiled function"


def test_a_kernel_is_bound_where_it_is_enclosed() -> None:
    @scalar
    def half(value: float) -> float:
        return 0.5 * value

    assert isinstance(half, Kernel)
    assert _scale_by(half)(4.0) == 6.0
    with pytest.raises(AttributeError):
        half.__wrapped__  # noqa: B018 - asked for by whoever inspects functions, which is no reason to compile


@pytest.mark.skipif(sys.platform != "linux", reason="no copies of the process")
def test_a_copy_compiles_while_memory_is_limited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("numba.config.CACHE_DIR", str(tmp_path))

    def twice(value: float) -> float:
        return _square(value) + _square(value)

    made = scalar(twice).made
    with monkeypatch.context() as patched:
        patched.setattr(budget, "has_memory_limit", lambda: True)
        assert made(3.0) == 18.0
    assert sum(made.stats.cache_hits.values()) == 1, "the process loads it"
    assert not made.stats.cache_misses
    assert [path.suffix for path in tmp_path.rglob("*.nbc") if "twice" in path.name] == [".nbc"]
    assert not list_compiling()
    with monkeypatch.context() as patched:  # no process is left, so it compiles by itself
        patched.setattr(budget, "has_memory_limit", lambda: True)
        patched.setattr("os.fork", no_process)
        assert made(3) == 18
    assert sum(made.stats.cache_misses.values()) == 1


@pytest.mark.skipif(sys.platform != "linux", reason="no copies of the process")
def test_a_copy_that_waits_for_a_lock_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernels, "_COMPILING_S", 0.05)
    assert not kernels._compile_in_copy(SimpleNamespace(compile=lambda _: time.sleep(60.0)), ())
    assert not list_compiling()


def no_process() -> int:
    raise OSError(errno.EAGAIN, "")


def test_what_has_kernels_is_imported_without_their_compiler() -> None:
    program = "import sys, engine.gl.scene_renderer, engine.capture.photograph.decode; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert {"numba", "llvmlite"} & set(done.stdout.split()) == set()

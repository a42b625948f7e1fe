"""Kernels load their compiler when the first of them is called, and call each other as compiled functions."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from engine.core.kernels import Kernel, parallel, prange, scalar, threads_are_shared


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


def test_what_has_kernels_is_imported_without_their_compiler() -> None:
    program = "import sys, engine.gl.scene_renderer, engine.capture.photograph.decode; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert {"numba", "llvmlite"} & set(done.stdout.split()) == set()

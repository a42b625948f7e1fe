"""Allocations of numpy's arrays that fail one by one (NEP 49), as SQLite's tests let its allocator fail.

Only arrays that the calling thread makes are counted, since a handler belongs to one context; numba's, embree's and
OpenGL's memory is not numpy's.

The allocator is machine code (numba): numpy makes arrays also while an error is set, to clean up after an allocation
that failed, and no Python may run then (a handler written in Python returns nonsense, and the process crashes).
"""

from __future__ import annotations

import contextvars
import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any, TypeVar, cast

import numpy as np

from engine.storage import spilling

Value = TypeVar("Value")


def _function(index: int, *arguments: Any) -> Any:
    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    table = ctypes.cast(
        pointer(cast(Any, np)._core._multiarray_umath._ARRAY_API, None), ctypes.POINTER(ctypes.c_void_p)
    )
    return ctypes.PYFUNCTYPE(ctypes.py_object, *arguments)(table[index])


def _default() -> spilling.Handler:
    capsule = _function(spilling.GET_HANDLER)()
    return spilling.Handler.from_address(ctypes.pythonapi.PyCapsule_GetPointer(capsule, b"mem_handler"))


@cache
def _compile() -> tuple[Any, Any]:
    """Functions `malloc` and `calloc` whose context is the table of a `FailingAllocator`."""
    from numba import cfunc, types

    size, table = ctypes.c_size_t, types.CPointer(types.uint64)
    default = _default()
    default_malloc = ctypes.CFUNCTYPE(size, size, size)(default.malloc)
    default_calloc = ctypes.CFUNCTYPE(size, size, size, size)(default.calloc)

    @cfunc(types.uint64(table, types.uint64))
    def malloc(state, size_bytes):  # type: ignore[no-untyped-def]
        if size_bytes >= state[1]:
            state[2] += types.uint64(1)
            if state[2] == state[0]:
                return types.uint64(0)
        return default_malloc(types.uint64(0), size_bytes)

    @cfunc(types.uint64(table, types.uint64, types.uint64))
    def calloc(state, count, size_bytes):  # type: ignore[no-untyped-def]
        if count * size_bytes >= state[1]:
            state[2] += types.uint64(1)
            if state[2] == state[0]:
                return types.uint64(0)
        return default_calloc(types.uint64(0), count, size_bytes)

    return malloc, calloc


class FailingAllocator:
    """Counts arrays of at least `smallest_bytes`, and finds no memory for the one numbered `at` (from 0)."""

    #: Handlers live as long as the arrays that they made.
    _kept: list[Any] = []  # noqa: RUF012

    def __init__(self, at: int = -1, smallest_bytes: int = 1024) -> None:
        malloc, calloc = _compile()
        self._state = (ctypes.c_uint64 * 3)(at + 1, smallest_bytes, 0)
        self._handler = spilling.Handler.from_buffer_copy(_default())
        self._handler.name = b"failing"
        self._handler.context = ctypes.addressof(self._state)
        self._handler.malloc, self._handler.calloc = malloc.address, calloc.address
        FailingAllocator._kept.append((self._handler, self._state))

    @property
    def count(self) -> int:
        """Arrays that were asked for."""
        return int(self._state[2])

    def run(self, work: Callable[[], Value]) -> Value:
        """Return the result of `work`, run while this allocator is the one that numpy asks."""
        return contextvars.copy_context().run(self._install, work)

    def _install(self, work: Callable[[], Value]) -> Value:
        new = ctypes.pythonapi.PyCapsule_New
        new.restype, new.argtypes = ctypes.py_object, [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p]
        _function(spilling.SET_HANDLER, ctypes.py_object)(new(ctypes.addressof(self._handler), b"mem_handler", None))
        return work()

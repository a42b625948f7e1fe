"""Allocations of numpy's arrays that fail one by one (NEP 49), as SQLite's tests let its allocator fail.

Only arrays that the calling thread makes are counted, since a handler belongs to one context; numba's, embree's and
OpenGL's memory is not numpy's.
"""

from __future__ import annotations

import contextvars
import ctypes
from collections.abc import Callable
from typing import Any, TypeVar, cast

import numpy as np

Value = TypeVar("Value")

# With the interpreter lock held, as numpy does.
MALLOC = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t)
CALLOC = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_size_t)

#: Places of PyDataMem_SetHandler and PyDataMem_GetHandler in numpy's table of functions.
SET_HANDLER, GET_HANDLER = 304, 305


class _Handler(ctypes.Structure):
    _fields_ = (
        ("name", ctypes.c_char * 127),
        ("version", ctypes.c_uint8),
        ("context", ctypes.c_void_p),
        ("malloc", MALLOC),
        ("calloc", CALLOC),
        ("realloc", ctypes.c_void_p),
        ("free", ctypes.c_void_p),
    )


def _function(index: int, *arguments: Any) -> Any:
    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    table = ctypes.cast(
        pointer(cast(Any, np)._core._multiarray_umath._ARRAY_API, None), ctypes.POINTER(ctypes.c_void_p)
    )
    return ctypes.PYFUNCTYPE(ctypes.py_object, *arguments)(table[index])


def _default() -> _Handler:
    capsule = _function(GET_HANDLER)()
    return _Handler.from_address(ctypes.pythonapi.PyCapsule_GetPointer(capsule, b"mem_handler"))


class FailingAllocator:
    """Counts arrays of at least `smallest_bytes`, and finds no memory for the one numbered `at` (from 0)."""

    #: Handlers live as long as the arrays that they made.
    _kept: list[Any] = []  # noqa: RUF012

    def __init__(self, at: int = -1, smallest_bytes: int = 1024) -> None:
        self.at, self.smallest_bytes, self.count = at, smallest_bytes, 0
        default = _default()
        malloc, calloc = default.malloc, default.calloc
        self._handler = _Handler.from_buffer_copy(default)
        self._handler.name = b"failing"
        self._handler.malloc = MALLOC(lambda context, size: None if self._fails(size) else malloc(context, size))
        self._handler.calloc = CALLOC(
            lambda context, count, size: None if self._fails(count * size) else calloc(context, count, size)
        )
        FailingAllocator._kept.append(self._handler)

    def _fails(self, size_bytes: int) -> bool:
        if size_bytes < self.smallest_bytes:
            return False
        self.count += 1
        return self.count == self.at + 1

    def run(self, work: Callable[[], Value]) -> Value:
        """Return the result of `work`, run while this allocator is the one that numpy asks."""
        return contextvars.copy_context().run(self._install, work)

    def _install(self, work: Callable[[], Value]) -> Value:
        new = ctypes.pythonapi.PyCapsule_New
        new.restype, new.argtypes = ctypes.py_object, [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p]
        _function(SET_HANDLER, ctypes.py_object)(new(ctypes.addressof(self._handler), b"mem_handler", None))
        return work()

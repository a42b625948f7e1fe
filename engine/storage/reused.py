"""Arrays in memory that arrays of the same size have left.

The system clears fresh memory, and a virtual machine has to be given it first: of arrays as large as a photograph that
takes as long as much of what is computed of them.
"""

from __future__ import annotations

import ctypes
import math
import weakref
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray


class ReusedMemory:
    """Gives arrays; the memory of one goes to the next of its size when its last view has gone."""

    def __init__(self) -> None:
        self._left: dict[int, list[NDArray[np.uint8]]] | None = {}

    def array(self, shape: tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
        """An array that is not cleared."""
        size_bytes = math.prod(shape) * np.dtype(dtype).itemsize
        left = self._left.get(size_bytes) if self._left is not None else None
        memory = left.pop() if left else np.empty(size_bytes, np.uint8)
        if size_bytes == 0:
            return memory.view(dtype).reshape(shape)
        lent = (ctypes.c_uint8 * size_bytes).from_buffer(memory.data)  # which every view keeps, unlike the first array
        weakref.finalize(lent, self._take_back, memory).atexit = False
        return np.ctypeslib.as_array(lent).view(dtype).reshape(shape)

    def close(self) -> None:
        """Let the memory go that nobody uses, and other memory as soon as nobody does."""
        self._left = None

    def _take_back(self, memory: NDArray[np.uint8]) -> None:
        if self._left is not None:
            self._left.setdefault(len(memory), []).append(memory)

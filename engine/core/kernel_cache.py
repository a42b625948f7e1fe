"""Where compiled kernels are kept when `NUMBA_CACHE_DIR` names a folder: by content instead of by path.

numba names a cached kernel by the path of its module and checks it by a hash of that file. A fresh checkout therefore
compiles everything again, and a kernel whose callee or constant changed in another module is used although it is stale.
Here the key is a hash of all that the machine code depends on, so that every checkout with the same kernel uses the
same file, and a changed callee or constant is noticed.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator
from pathlib import Path
from types import CodeType, FunctionType, ModuleType

import numpy as np
from numba.core import config
from numba.core.caching import _CacheLocator

from engine.core.kernels import Kernel

#: Modules whose functions and constants are named in the bytecode and change with the version of the packages alone.
_LIBRARIES = ("numpy", "math")

#: Where an object lies in memory, which is another place in each process.
_ADDRESS = re.compile(r" at 0x[0-9a-fA-F]{1,16}")


class ContentLocator(_CacheLocator):
    """A place in `NUMBA_CACHE_DIR` for each function, named by `fingerprint`."""

    def __init__(self, function: FunctionType, file: str) -> None:
        self._py_file = file  # numba names it in warnings
        self._folder = Path(config.CACHE_DIR) / function.__module__
        self._fingerprint = fingerprint(function)

    @classmethod
    def from_function(cls, py_func: FunctionType, py_file: str) -> ContentLocator | None:
        """The place of `py_func`; None, so that numba goes on to the next kind of place, where none can be written."""
        if not config.CACHE_DIR:
            return None
        locator = cls(py_func, py_file)
        try:
            locator.ensure_cache_path()
        except OSError:
            return None
        return locator

    def get_cache_path(self) -> str:
        return str(self._folder)

    def get_source_stamp(self) -> str:
        return self._fingerprint

    def get_disambiguator(self) -> str:
        return self._fingerprint[:16]


def fingerprint(function: FunctionType) -> str:
    """Hash of the bytecode, constants and compile options of `function` and of all functions that it calls."""
    digest = hashlib.sha256()
    for part in _parts(function, set()):
        digest.update(part.encode() + b"\0")
    return digest.hexdigest()


def _parts(function: FunctionType, seen: set[CodeType]) -> Iterator[str]:
    if function.__code__ in seen:
        return
    seen.add(function.__code__)
    yield repr(getattr(function, "compile_options", None))
    yield repr(function.__defaults__)
    cells = [cell.cell_contents for cell in function.__closure__ or ()]
    for code in _codes(function.__code__):
        names = (code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars)
        yield repr((code.co_code, names, code.co_flags))
        for constant in code.co_consts:
            if not isinstance(constant, CodeType):
                yield from _value(constant, seen)
        for name in code.co_names:
            if name in function.__globals__:
                value = function.__globals__[name]
                yield name
                yield from _value(value, seen)
                if isinstance(value, ModuleType) and value.__name__ not in _LIBRARIES:
                    cells += [vars(value)[other] for other in code.co_names if other in vars(value)]
    for value in cells:
        yield from _value(value, seen)


def _codes(code: CodeType) -> Iterator[CodeType]:
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


def _value(value: object, seen: set[CodeType]) -> Iterator[str]:
    """What a value that a kernel refers to adds to its hash."""
    called = _function(value)
    if called is not None:
        yield from _parts(called, seen)
    elif isinstance(value, np.ndarray):
        yield repr((value.dtype, value.shape, value.tobytes()))
    elif isinstance(value, tuple | list):
        yield str(len(value))
        for each in value:
            yield from _value(each, seen)
    elif isinstance(value, set | frozenset):
        yield from sorted(map(repr, value))
    elif isinstance(value, ModuleType):
        yield value.__name__
    else:
        yield _ADDRESS.sub("", repr(value))


def _function(value: object) -> FunctionType | None:
    """The Python function of a kernel, of numba's function, or of an intrinsic; None for anything else."""
    if isinstance(value, Kernel):  # one that calls itself is still being compiled
        return value.function
    for name in ("py_func", "_defn"):
        if isinstance(inner := getattr(value, name, None), FunctionType):
            return inner
    return value if isinstance(value, FunctionType) else None

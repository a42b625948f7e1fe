"""The two kinds of compiled kernels, so that every hot loop is compiled alike.

Kernels are cached on disk, release the interpreter lock and never use fast-math, because results must not depend on
the CPU's whims. `threads_are_shared` says whether two Python threads may run parallel kernels at once.

numba takes 0.5 s to load and 70 MB, so it is loaded when the first kernel is called, not when a module that has one is
imported. Until then a kernel is a `Kernel`. Compiling needs the kernels that it calls as functions of numba: their
names in the module are bound to these first, which also spares later calls the detour.

The compiler takes up to 150 MB more and keeps most of them. Where memory is limited (`engine.core.budget`), a copy of
the process therefore compiles what is not in the cache yet, and ends; the process itself loads the compiled code. The
copy shares all pages that it does not change. Linux alone has such copies; elsewhere the process compiles by itself.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from types import CodeType, FunctionType
from typing import Any, Generic, ParamSpec, TypeVar

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")

#: One thread at a time loads numba and binds names.
_binding = threading.RLock()

#: Of prctl(2): PR_SET_PDEATHSIG.
_DIES_WITH_PARENT = 1

#: Seconds after which a process that compiles is ended, and this one compiles.
_COMPILING_S = 120.0

#: Processes that compile for this one, and whether it is such a process itself.
_copies: set[int] = set()
_is_copy = False


class Kernel(Generic[Parameters, Result]):
    """A function that numba compiles when it is called first; attributes are those of what numba makes of it."""

    def __init__(self, function: Callable[Parameters, Result], make: Callable[[FunctionType], Any]) -> None:
        assert isinstance(function, FunctionType)
        self.function, self._make = function, make
        self._made: Any = None
        self.__name__, self.__doc__, self.__module__ = function.__name__, function.__doc__, function.__module__

    def __call__(self, *arguments: Parameters.args, **options: Parameters.kwargs) -> Result:
        result: Result = self.made(*arguments, **options)
        return result

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self.made, name)

    @property
    def made(self) -> Any:
        """The function of numba."""
        if self._made is None:
            with _binding:
                if self._made is None:
                    _bind(self.function)
                    made = self._make(self.function)
                    if self.function.__globals__.get(self.__name__) is self:
                        self.function.__globals__[self.__name__] = made
                    self._made = made
        return self._made


def scalar(function: Callable[Parameters, Result]) -> Kernel[Parameters, Result]:
    """Compile a scalar or serial function, inlined into kernels or called by itself."""
    return Kernel(function, _njit)


def parallel(function: Callable[Parameters, Result]) -> Kernel[Parameters, Result]:
    """Compile a loop over `prange` on all threads."""
    return Kernel(function, lambda function: _njit(function, parallel=True))


def intrinsic(function: Callable[..., tuple[Any, Callable[..., Any]]]) -> Kernel[..., Any]:
    """Make a function that writes its own code, called from kernels only (`numba.extending.intrinsic`)."""

    def make(function: FunctionType) -> Any:
        from numba.extending import intrinsic

        return intrinsic(function)

    return Kernel(function, make)


def prange(*arguments: int) -> range:
    """A range whose steps a `parallel` kernel divides between threads (`numba.prange`)."""
    return range(*arguments)


def only(kernel: Kernel[..., Any], *signatures: str) -> None:
    """Compile `kernel` for `signatures` and for no other types from then on; what fits one of them is converted.

    For processes that may not write the compiled code to the disk later (`engine.storage.sandbox`).
    """
    for signature in signatures:
        kernel.compile(signature)
    kernel.disable_compile()


@contextmanager
def serial_kernels() -> Iterator[None]:
    """While the block runs, parallel kernels that this thread calls take one thread.

    For many short calls: a second thread would wait actively between them, and where the CPUs are busy otherwise, each
    call for it to be scheduled.
    """
    numba = _numba()
    before = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        yield
    finally:
        numba.set_num_threads(before)


def threads_are_shared() -> bool:
    """False where numba's thread pool must not be entered by two threads at once (its 'workqueue' layer).

    OpenMP and TBB give each thread a team of its own. Before the first kernel is called there is nothing to share.
    """
    return "numba" not in sys.modules or _layer() != "workqueue"


@lru_cache(maxsize=1)
def _layer() -> str:
    """The threading layer of numba, whose pool is started if it has not been yet."""
    numba = _numba()
    numba.get_num_threads()
    return str(numba.threading_layer())


def list_compiling() -> list[int]:
    """The numbers of the processes that compile for this one."""
    return list(_copies)


def load_compiler() -> None:
    """Load numba now, on the thread of the caller."""
    with _binding:
        _numba()


def _numba() -> Any:
    import numba

    numba.config.THREADING_LAYER = "default"
    if numba.config.CACHE_DIR:
        content = f"{__package__}.kernel_cache.ContentLocator"
        numba.config.CACHE_LOCATOR_CLASSES = f"{content},InTreeCacheLocator,UserWideCacheLocator"
    return numba


def _njit(function: FunctionType, **options: bool) -> Any:
    from engine.core import budget  # with all that it needs, when the first kernel is called

    vars(function)["compile_options"] = sorted(options.items())
    made = _numba().njit(function, cache=True, nogil=True, error_model="numpy", **options)
    load = made._cache.load_overload

    def load_or_compile(types: Any, target: Any) -> Any:
        """Code from the cache, to which a copy of this process adds it where memory is limited; None for none."""
        found = load(types, target)
        if found is None and budget.has_memory_limit() and _compile_in_copy(made, types):
            found = load(types, target)
        return found

    made._cache.load_overload = load_or_compile
    return made


def _compile_in_copy(made: Any, types: Any) -> bool:
    """Compile for argument types in a copy of this process, which writes the cache; False where it could not."""
    from engine.core import budget

    global _is_copy
    if sys.platform != "linux" or _is_copy:
        return False
    try:
        copy = os.fork()
    except OSError:  # no process is left for this user
        return False
    if copy == 0:
        code, _is_copy = 1, True
        try:
            ctypes.CDLL(None).prctl(_DIES_WITH_PARENT, signal.SIGKILL)  # or it would keep the pipes of who was killed
            signal.set_wakeup_fd(-1)  # what reads the other end is told by the process itself
            budget.lift_memory_limit()
            made.compile(types)
            code = 0
        finally:
            os._exit(code)
    _copies.add(copy)
    ended, until_s = False, time.monotonic() + _COMPILING_S
    try:
        while time.monotonic() < until_s:
            process, status = os.waitpid(copy, os.WNOHANG)
            ended = process != 0
            if ended:
                return status == 0
            time.sleep(0.01)
        return False  # it waits for a lock that another thread held when it was made
    finally:
        if not ended:
            os.kill(copy, signal.SIGKILL)
            os.waitpid(copy, 0)
        _copies.discard(copy)


def _bind(function: FunctionType) -> None:
    """Bind the names by which `function` calls kernels, in its module and around it, to functions of numba."""
    for name in _names(function.__code__):
        value = function.__globals__.get(name)
        if isinstance(value, Kernel) and value.function is not function:
            function.__globals__[name] = value.made
        elif value is prange:
            function.__globals__[name] = _numba().prange
    for cell in function.__closure__ or ():
        if isinstance(cell.cell_contents, Kernel):
            cell.cell_contents = cell.cell_contents.made


def _names(code: CodeType) -> Iterator[str]:
    """Names of globals in a function and in the functions within it."""
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)

"""The two kinds of compiled kernels, so that every hot loop is compiled alike.

Kernels are cached on disk, release the interpreter lock and never use fast-math, because results must not depend on
the processor's whims. `threads_are_shared` says whether two Python threads may run parallel kernels at once.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numba

numba.config.THREADING_LAYER = "default"

#: Scalar or serial function, inlined into kernels or called by itself.
scalar = numba.njit(cache=True, nogil=True, error_model="numpy")

#: Loop over `numba.prange` on all threads.
parallel = numba.njit(cache=True, nogil=True, error_model="numpy", parallel=True)

prange = numba.prange


def only(kernel: Any, *signatures: str) -> None:
    """Compile `kernel` for `signatures` and for no other types from then on; what fits one of them is converted.

    For processes that may not write the compiled code to the disk later (`engine.storage.sandbox`).
    """
    for signature in signatures:
        kernel.compile(signature)
    kernel.disable_compile()


@lru_cache(maxsize=1)
def threads_are_shared() -> bool:
    """False where numba's thread pool must not be entered by two threads at once (its 'workqueue' layer).

    OpenMP and TBB give each thread a team of its own. The pool is started if it has not been yet.
    """
    numba.get_num_threads()
    layer: Any = numba.threading_layer()
    return layer != "workqueue"

"""Memory that was freed goes back to the system, although many threads take and free arrays of all sizes.

glibc keeps a pool for each thread. As soon as one large array was freed, it takes all of up to 32 MiB from these pools,
where what is freed stays as long as anything small lies above it: after four minutes of the soak of the window 990 of
the 1,500 MB in the pools were free. Arrays of `OWN_PAGES_BYTES` or more get pages of their own instead. Setting one of
the two limits ends glibc's own choice of both, so both are set: with its first choice of 128 KiB for the other, an
image that the CPU renders had 3.7 times the page faults; with these it has 13 % more, and takes no longer.

Smaller arrays leave holes in the pools of all threads. A thread of its own gives the pages in them back every few
seconds, in 10 to 30 ms, where they are worth it.
"""

from __future__ import annotations

import ctypes
import sys
import threading
import time

OWN_PAGES_BYTES = 2**20

#: Free bytes at the end of a pool that it keeps for what is taken next.
KEPT_FREE_BYTES = 8 * 2**20

#: Free bytes within the pools from which on they are looked through, and how often, in s.
MAX_FREE_BYTES, EVERY_S = 64 * 2**20, 10.0

#: Of mallinfo2(3), in its order.
_FIELDS = ["arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks", "fordblks", "keepcost"]

#: Of mallopt(3).
_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3


def give_back_freed_arrays() -> None:
    """Give the pages of large arrays back as soon as these are freed, from now on; Linux with glibc only."""
    if sys.platform == "linux":
        mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
        if mallopt is not None:
            mallopt(_MMAP_THRESHOLD, OWN_PAGES_BYTES)
            mallopt(_TRIM_THRESHOLD, KEPT_FREE_BYTES)


def give_back_free_pages() -> None:
    """Give the free pages within the pools back now and then, from now on; Linux with glibc 2.33 or later only."""
    if sys.platform == "linux":
        libc = ctypes.CDLL(None)
        if hasattr(libc, "mallinfo2"):
            libc.mallinfo2.restype = _Mallinfo
            threading.Thread(target=_trim_for_ever, args=(libc,), name="free pages", daemon=True).start()


class _Mallinfo(ctypes.Structure):
    """As mallinfo2(3) returns it; `fordblks` are the free bytes within the pools."""

    _fields_ = tuple((name, ctypes.c_size_t) for name in _FIELDS)


def _trim_for_ever(libc: ctypes.CDLL) -> None:
    while True:
        time.sleep(EVERY_S)
        if libc.mallinfo2().fordblks > MAX_FREE_BYTES:
            libc.malloc_trim(0)

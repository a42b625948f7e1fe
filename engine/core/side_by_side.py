"""Many like pieces of work on all cores, their results one after the other in the order of the pieces.

For work that leaves the interpreter: reading, compiled kernels without the lock, linear algebra, which meanwhile takes
one thread for each piece (`engine.core.one_thread`). Sums over the results are therefore the same on any machine.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing
from typing import TypeVar

from engine.core.budget import thread_count
from engine.core.kernels import serial_kernels, threads_are_shared
from engine.core.one_thread import one_thread

Piece = TypeVar("Piece")
Result = TypeVar("Result")


def side_by_side(
    work: Callable[[Piece], Result], pieces: Iterable[Piece], threads: int | None = None
) -> Generator[Result]:
    """`work` of each of `pieces`, in their order.

    At most twice as many pieces as `threads` are begun and not yet handed out, so that memory is bounded; without a
    number there is a thread for each core. What a piece raises is raised in its place. Who does not ask for all
    results closes the generator (`contextlib.closing`), which waits for the pieces that have begun and drops the rest.
    """
    workers = threads or thread_count()
    waiting: deque[Future[Result]] = deque()
    with one_thread():
        pool = ThreadPoolExecutor(workers)
        try:
            for piece in pieces:
                waiting.append(pool.submit(work, piece))
                if len(waiting) >= 2 * workers:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def list_side_by_side(work: Callable[[Piece], Result], pieces: Iterable[Piece]) -> list[Result]:
    """The results of `work` of each of `pieces`, whose parallel kernels take one thread meanwhile.

    Pieces are worked through one after the other where two threads must not enter such kernels at once.
    """

    def work_alone(piece: Piece) -> Result:
        with serial_kernels():
            return work(piece)

    with closing(side_by_side(work_alone, pieces, None if threads_are_shared() else 1)) as found:
        return list(found)

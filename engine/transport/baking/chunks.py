"""Through what the chunks of a bake run: the threads of this process, or the workers of a Dask cluster.

A chunk depends on its number, or on a task that says what else it takes, and on what all chunks share; the kernels
inside it run on all threads. For a cluster, what they share is a recipe, a mapping of arrays and plain values, which
goes to each worker once and is made ready there once. Both ways compute the same from the same numbers, and the file is
the same bit for bit on CPUs that round alike (no kernel uses fast-math). A worker that is lost costs the chunks that it
had begun; others make them. No more tasks are made than workers can begin soon, and each result is handed over before
others are waited for, so that neither side holds what grows with their number.

Scheduler and workers run the code of this project and exchange objects as Dask does: only name a cluster of your own.

The time of a bake is estimated from some vertices of the model and of the ground that lie apart.
"""

from __future__ import annotations

import importlib
import math
import threading
import time
import uuid
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import engine
from engine.core.budget import thread_count
from engine.core.cluster import PATIENCE_S, connect, count_threads
from engine.core.errors import InputError
from engine.core.figure_text import count_text
from engine.core.steps import Step, Steps, time_left

if TYPE_CHECKING:
    from engine.transport.baking.carried_visibility import Carrier
    from engine.transport.baking.file import TransportWriter

#: Data that all chunks of one bake share.
Recipe = Mapping[str, Any]

#: Chunks that are under way for each thread of the workers, and seconds until these are counted again.
AHEAD, WORKERS_S = 2, 1.0


@dataclass(frozen=True, eq=False)
class Chunk:
    """A chunk of a transport file: its number, its rows of every streamed array, and the seconds for visibility.

    `seen` is what its vertices see, from a worker that found it (`engine.transport.baking.carried_visibility`).
    """

    number: int
    rows: Mapping[str, NDArray[Any]]
    visibility_s: float
    seen: bytes = b""


Make = Callable[[int], Chunk]

#: Gives the next task that can be begun; None where there is none until more results are known, or none any more.
Ask = Callable[[], Any]

#: Makes what is asked for, one after the other or side by side; results come in any order.
Run = Callable[[Ask], Generator[Any, None, None]]


@dataclass(frozen=True, eq=False)
class Remote:
    """Work for a cluster: the `address` of its scheduler (`engine.core.cluster`), and what workers make chunks with.

    `maker` turns `recipe`, arrays and plain values, into a function from number to chunk, or from task to result;
    workers know it by its module and name.
    """

    address: str
    maker: Callable[[Recipe], Callable[[Any], Any]]
    recipe: Recipe


def run(
    make: Make, numbers: Sequence[int], remote: Remote | None = None, load: Callable[[int], Any] = int
) -> Generator[Chunk, None, None]:
    """The chunks `numbers`: by `make` here, one after the other, or in any order by the workers of `remote`.

    `load` turns a number into the task of these.

    Closing the iterator gives up what is under way. MissingCapability without the library; InputError where no
    scheduler answers, there are no workers, or they cannot do it, having another version of this program, say.
    """
    if not numbers:
        return
    with open_workers(make if remote is None else remote) as run_tasks:
        yield from each_of(run_tasks, numbers if remote is None else map(load, numbers))


def each_of(run_tasks: Run, tasks: Iterable[Any]) -> Generator[Any, None, None]:
    """The results of `tasks` that wait for nothing, each made when it can be begun."""
    left = iter(tasks)
    return run_tasks(lambda: next(left, None))


@contextmanager
def open_workers(by: Callable[[Any], Any] | Remote) -> Iterator[Run]:
    """Run tasks within the block: by a function here, or by the workers of a cluster, which get the recipe once.

    A result is known to whoever iterates before the next task is asked for, so a task may depend on results. Raises
    what `run` does.
    """
    if not isinstance(by, Remote):
        yield partial(_run_here, by)
        return
    with connect(by.address, "Baking") as client:
        token = uuid.uuid4().hex
        # a mapped array is copied to be sent, unless it is one as any other
        recipe = {name: np.asarray(each) if isinstance(each, np.memmap) else each for name, each in by.recipe.items()}
        held = client.submit(dict, recipe, key=f"lightarc-recipe-{token}")
        try:
            yield partial(_run_there, client, by, token, held)
        finally:
            client.cancel([held], force=True)


def _run_here(make: Callable[[Any], Any], ask: Ask) -> Generator[Any, None, None]:
    while (task := ask()) is not None:
        yield make(task)


def fill(
    writer: TransportWriter, make: Make, missing: Sequence[int], carrier: Carrier, remote: Remote | None = None
) -> Steps[float]:
    """Put all `missing` chunks; the seconds that visibility took. `carrier` keeps what the workers of `remote` see.

    What `run` raises; closing the generator leaves the chunks that are put.
    """
    sizes = carrier.sizes
    total, done, visibility_s = int(sizes[list(missing)].sum()), 0, 0.0
    started = time.perf_counter()
    yield Step(0.0, f"baking {count_text(total)} vertices")
    with closing(run(make, missing, remote, carrier.load)) as chunks:
        for chunk in chunks:
            writer.put(chunk.number, chunk.rows)
            carrier.unload(chunk)
            visibility_s += chunk.visibility_s
            done += int(sizes[chunk.number])
            left = time_left((time.perf_counter() - started) / done * (total - done))
            yield Step(done / total, f"baking vertex {count_text(done)} of {count_text(total)}, {left}")
    return visibility_s


def _run_there(client: Any, remote: Remote, token: str, held: Any, ask: Ask) -> Generator[Any, None, None]:
    import distributed

    try:
        yield from _results(distributed, client, remote, token, held, ask)
    except (
        distributed.KilledWorker,
        distributed.CancelledError,
        OSError,
        ImportError,
        AttributeError,
        RuntimeError,
    ) as error:
        words = " ".join(str(error).split())[:200] or type(error).__name__
        raise InputError(
            remote.address,
            f"the cluster could not do its part ({words})",
            f"Install Lightarc {engine.__version__} where the scheduler and the workers run and start again; "
            "the bake goes on where it stopped",
        ) from None


def _results(
    distributed: Any, client: Any, remote: Remote, token: str, held: Any, ask: Ask
) -> Generator[Any, None, None]:
    """Submit tasks as workers can take them, and yield what is done."""
    entry, words = _entry(), (engine.__version__, token, remote.maker.__module__, remote.maker.__name__)
    under_way = set[Any]()
    threads, asked_s = 0, -math.inf
    try:
        while True:
            if time.monotonic() > asked_s + WORKERS_S:
                threads, asked_s = count_threads(client, remote.address), time.monotonic()
            while len(under_way) < AHEAD * threads and (task := ask()) is not None:
                key = f"lightarc-chunk-{token}-{uuid.uuid4().hex}"
                under_way.add(client.submit(entry, *words, held, task, key=key, retries=2))
            if not under_way:
                return
            for future in _finish(distributed, client, under_way):
                under_way.remove(future)
                yield future.result()
    finally:
        if under_way:
            client.cancel([*under_way], force=True)


def _finish(distributed: Any, client: Any, under_way: set[Any]) -> set[Any]:
    """Those of `under_way` that are done within some time, perhaps none."""
    with client.as_current(), suppress(TimeoutError):
        done: set[Any] = distributed.wait(under_way, timeout=PATIENCE_S, return_when="FIRST_COMPLETED").done
        return done
    return set()


def _entry() -> Callable[..., Any]:
    """Function sent to workers. A nested function travels whole; one of a module would end workers without it."""

    def entry(*words: Any) -> Any:
        return importlib.import_module("engine.transport.baking.chunks").on_worker(*words)

    return entry


#: Result of the latest recipe in this process, a worker: one bake at a time, its kernels take all threads.
_kept: tuple[str, Callable[[Any], Any]] | None = None
_at_work = threading.Lock()


def on_worker(version: str, token: str, module: str, name: str, recipe: Recipe, task: Any) -> Any:
    """A result, in a worker: `name` in `module` is the maker, `token` identifies the recipe."""
    global _kept
    if version != engine.__version__:
        raise RuntimeError(f"a worker has Lightarc {engine.__version__}, not {version}")
    with _at_work:
        if _kept is None or _kept[0] != token:
            _kept = (token, getattr(importlib.import_module(module), name)(recipe))
        return _kept[1](task)


#: Fewest vertices of the model whose bake predicts that of all others, and of the ground, where vertices differ less.
PROBES, GROUND_PROBES = 48, 16

#: Seconds from which on a trial is repeated: the first vertex may see its whole hemisphere, and others need kernels
#: that are compiled for them, which takes that long.
REPEATED_S = 0.2

#: Portions that every thread gets of the vertices of the model, and of those of the ground: few would not share evenly.
PORTIONS, GROUND_PORTIONS = 4, 2


def estimate_s(make: Callable[[NDArray[np.int64]], object], vertices: int, first: int, portion: int = 1) -> float:
    """Seconds that `make` takes for all vertices, of which those from `first` on are ground; it is run on some.

    `make` bakes vertices, all of one kind; what all vertices share is made before. Threads take `portion` vertices at a
    time. Compiling and first touches are not counted. Costs about a hundredth of a bake of many vertices.
    """
    threads = thread_count()
    kinds = (
        (np.arange(first), max(PROBES, PORTIONS * threads * portion)),
        (np.arange(first, vertices), max(GROUND_PROBES, GROUND_PORTIONS * threads * portion)),
    )
    return sum(_estimate_s(make, some, count) for some, count in kinds if len(some))


def _estimate_s(make: Callable[[NDArray[np.int64]], object], vertices: NDArray[np.int64], probes: int) -> float:
    spaces = np.linspace(0, len(vertices), min(probes, len(vertices)) + 1)
    chosen = vertices[((spaces[:-1] + spaces[1:]) / 2.0).astype(np.int64)]
    make(chosen[:1])
    taken_s = _time_s(make, chosen)
    if taken_s > REPEATED_S:
        taken_s = min(taken_s, _time_s(make, chosen))
    return taken_s / len(chosen) * len(vertices)


def _time_s(make: Callable[[NDArray[np.int64]], object], vertices: NDArray[np.int64]) -> float:
    started = time.perf_counter()
    make(vertices)
    return time.perf_counter() - started

"""Captures that the workers of a Dask cluster make, each in a process of its own there (`app.batch.processes`).

Photographs and results lie in folders that all machines see under the same names. A capture whose worker is lost is
made by another one.
"""

from __future__ import annotations

import importlib
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from typing import Any

import engine
from app.batch.captures import Capture, capture_from
from app.batch.processes import CarryOut, MakingProcess, Order, Tell
from engine.core.cluster import connect, count_threads
from engine.core.errors import InputError

#: Workers that may be lost with a capture before it has failed.
RETRIES = 3


@contextmanager
def on_cluster(address: str, order: Order) -> Iterator[tuple[CarryOut, int]]:
    """A function that has the cluster at `address` make captures, and how many at a time.

    Raises what `connect` and `count_threads` raise; the function gives the `error` where the cluster is gone.
    """
    with connect(address, "Making captures") as client:
        import distributed

        token, entry = uuid.uuid4().hex, _entry()

        def carry_out(capture: Capture, _tell: Tell) -> dict[str, Any]:
            words = (engine.__version__, asdict(order), capture.as_text())
            try:
                key = f"lightarc-capture-{token}-{capture.name}"
                found: dict[str, Any] = client.submit(entry, *words, key=key, retries=RETRIES, pure=False).result()
                return found
            except distributed.KilledWorker:
                return {"failed": "The workers that made it were lost; their logs say why."}
            except (distributed.CancelledError, OSError, ImportError, AttributeError, RuntimeError) as error:
                said = " ".join(str(error).split())[:200] or type(error).__name__
                remedy = f"Install Lightarc {engine.__version__} where scheduler and workers run and start again"
                return {"error": InputError(address, f"the cluster could not do its part ({said})", remedy)}

        yield carry_out, count_threads(client, address)


def _entry() -> Callable[..., Any]:
    """Function sent to workers. A nested function travels whole; one of a module would end workers without it."""

    def entry(*words: Any) -> Any:
        return importlib.import_module("app.batch.cluster").make_on_worker(*words)

    return entry


def make_on_worker(version: str, order: dict[str, Any], text: str) -> dict[str, Any]:
    """The end of a capture, in a worker of the cluster."""
    import distributed

    if version != engine.__version__:
        raise RuntimeError(f"a worker has Lightarc {engine.__version__}, not {version}")
    process = MakingProcess(Order(**order), distributed.get_worker().state.nthreads)
    try:
        return process.carry_out(capture_from(text), lambda _step: None)
    finally:
        process.end()

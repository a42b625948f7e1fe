"""A Dask cluster of the user: the address of its scheduler, the connection to it, and its workers.

Scheduler, workers and this program run code that they send each other, so each of them trusts all others. Only TLS
with certificates on both sides says who they are; an address without it is taken as it is on this machine alone, where
other users could reach it as well, and elsewhere where the user asks for it. Certificates are named in the settings of
Dask (`distributed.comm.tls`).
"""

from __future__ import annotations

import ipaddress
import os
import re
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

from engine.core.errors import InputError, MissingCapability, UsageError

#: Seconds to wait for a scheduler, and for a worker where there is none (any more).
PATIENCE_S = 20.0

#: Bytes that tell how fast a connection is, and how often they are sent.
PROBE_BYTES, PROBES = 4 << 20, 3

#: Bytes in a second of a connection that nobody has measured, most of a gigabit, and seconds until the first arrives.
ASSUMED_BYTES_PER_S, ASSUMED_LATENCY_S = 1e8, 1e-3

_ADDRESS = re.compile(r"(tcp|tls|ws|wss)://(\[[0-9a-fA-F:.]{1,45}+\]|[^\s:/@]{1,253}+):\d{1,5}/?")


@dataclass(frozen=True)
class Link:
    """A connection between this machine and all workers: bytes in a second, and seconds until the first arrives."""

    bytes_per_s: float = ASSUMED_BYTES_PER_S
    latency_s: float = ASSUMED_LATENCY_S


def check_cluster(address: str, *, allow_plain: bool = False) -> str:
    """`address` if it is one of a scheduler, by TLS or on this machine unless `allow_plain`; else UsageError."""
    found = _ADDRESS.fullmatch(address)
    if found is None:
        raise UsageError(f"{address!r} is not an address of a Dask scheduler such as tls://192.168.0.10:8786")
    protocol, host = found.groups()
    if protocol in ("tcp", "ws") and not allow_plain and not _is_loopback(host):
        raise UsageError(
            f"{address!r} has no TLS, so that anybody in the network could run code on this computer: use a tls:// "
            "address, or add --plain-cluster in a network of your own"
        )
    return address


def _is_loopback(host: str) -> bool:
    """True for a host that is this machine itself."""
    with suppress(ValueError):
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    return host.lower().rstrip(".") == "localhost"


@contextmanager
def connect(address: str, purpose: str) -> Iterator[Any]:
    """A client of the scheduler at `address`, within the block.

    MissingCapability where the library is missing, for `purpose` in words ('Baking'); InputError where none answers.
    """
    try:
        import dask
        import distributed
    except ImportError:
        remedy = "Install it with: pip install distributed"
        raise MissingCapability(f"{purpose} on a cluster needs the library distributed", remedy) from None
    # what all tasks share is part of the graph, so that it outlives any worker
    with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1TB"}):
        try:
            client = distributed.Client(address, timeout=PATIENCE_S, set_as_default=False, name="lightarc")
        except (OSError, ValueError, TypeError) as error:  # TypeError: certificates that are not named
            words = " ".join(str(error).split())[:200]
            raise InputError(
                address,
                f"no scheduler of a cluster answers there ({words})",
                "Start one with: dask scheduler, and workers with: dask worker ADDRESS; or leave --cluster out",
            ) from None
        try:
            yield client
        finally:
            client.close(timeout=5)


def count_threads(client: Any, address: str) -> int:
    """Threads of all workers, once there is one; InputError where none comes within `PATIENCE_S`."""
    patience = time.monotonic() + PATIENCE_S
    while not (found := client.nthreads()):
        if time.monotonic() > patience:
            raise InputError(address, "the cluster has no workers", f"Start some with: dask worker {address}")
        time.sleep(0.1)
    return sum(found.values())


def measure_cluster(address: str) -> tuple[list[float], Link]:
    """The threads that each worker computes on, and the connection to them; what `connect` raises.

    Workers on one machine share its threads. Sends some megabytes to and fro.
    """
    with connect(address, "Planning") as client:
        count_threads(client, address)
        hosts = list(client.run(_host()).values())
        together = Counter(name for name, _ in hosts)
        latency_s = min(_time_s(lambda: client.submit(len, b"", pure=False).result()) for _ in range(2 * PROBES))
        taken_s = min(_time_s(lambda: _echo(client)) for _ in range(PROBES))
    threads = [count / together[name] for name, count in hosts]
    return threads, Link(2.0 * PROBE_BYTES / max(taken_s - latency_s, 1e-6), 0.5 * latency_s)


def _host() -> Callable[[], tuple[str, int]]:
    """Function sent to workers: the name of a worker's machine, and the threads that it computes on."""

    def host() -> tuple[str, int]:
        import platform

        from engine.core.budget import thread_count

        return platform.node(), thread_count()

    return host


def _echo(client: Any) -> bytes:
    result: bytes = client.submit(bytes, os.urandom(PROBE_BYTES), pure=False).result()
    return result


def _time_s(work: Callable[[], object]) -> float:
    started = time.perf_counter()
    work()
    return time.perf_counter() - started

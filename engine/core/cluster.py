"""A Dask cluster of the user: the address of its scheduler, the connection to it, and its workers.

Scheduler, workers and this program run code that they send each other, so each of them trusts all others. Only TLS
with certificates on both sides says who they are; an address without it is taken as it is on this machine alone, where
other users could reach it as well, and elsewhere where the user asks for it. Certificates are named in the settings of
Dask (`distributed.comm.tls`).
"""

from __future__ import annotations

import ipaddress
import re
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

from engine.core.errors import InputError, MissingCapability, UsageError

#: Seconds to wait for a scheduler, and for a worker where there is none (any more).
PATIENCE_S = 20.0

_ADDRESS = re.compile(r"(tcp|tls|ws|wss)://(\[[0-9a-fA-F:.]{1,45}+\]|[^\s:/@]{1,253}+):\d{1,5}/?")


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

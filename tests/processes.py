"""Names of processes that run no longer."""

from __future__ import annotations

from engine.storage.writer import writer


def gone(number: int | None = None) -> str:
    """A process of this machine that had the number of this one (or `number`) before, and is over."""
    host, own, _start = writer().rsplit("-", 2)
    return f"{host}-{number or own}-1"

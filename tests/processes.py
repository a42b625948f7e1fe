"""Other processes: names of those that run no longer, and one where nothing but a test's own work happens."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from typing import TypeVar

from engine.storage.writer import writer

Result = TypeVar("Result")


def is_gone(number: int | None = None) -> str:
    """A process of this machine that had the number of this one (or `number`) before, and is over."""
    host, own, _start = writer().rsplit("-", 2)
    return f"{host}-{number or own}-1"


def alone(function: Callable[[], Result]) -> Result:
    """The result of `function`, of a module's own level, in a new process, where no thread of another test runs."""
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as process:
        return process.submit(function).result()

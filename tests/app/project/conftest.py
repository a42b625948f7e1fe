"""Windows in processes of their own, which several modules start."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.app.project.sequences import server


@contextmanager
def folder_in_memory() -> Iterator[Path]:
    """A folder in memory where there is one: SQLite synchronises, and that is none of the matter here."""
    memory = Path("/dev/shm")
    folder = Path(tempfile.mkdtemp(prefix="lightarc-", dir=memory if memory.is_dir() else None))
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture(scope="session")
def windows() -> Iterator[Path]:
    """The socket of a program that starts windows."""
    with folder_in_memory() as folder, server(folder) as place:
        yield place

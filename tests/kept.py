"""Files that make a test fail, kept in `build/failed`: a campaign makes them by the thousand and in passing."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

FAILED = Path(__file__).resolve().parents[1] / "build" / "failed"


@contextmanager
def keep(name: str, content: bytes) -> Iterator[None]:
    """Keep `content` as a file that ends in `name` if the block fails, and report where with the failure."""
    try:
        yield
    except Exception as error:
        FAILED.mkdir(parents=True, exist_ok=True)
        path = FAILED / f"{hashlib.sha256(content).hexdigest()[:12]}-{name}"
        path.write_bytes(content)
        error.add_note(f"The file is kept in {path}")
        raise

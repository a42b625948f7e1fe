"""Hidden names of what is being written until it is whole; they say by which process."""

from __future__ import annotations

import os
import re
import secrets
from pathlib import Path

from engine.storage.writer import WRITER, is_gone, is_own, writer

LONGEST_NAME_BYTES = 255

_PARTIAL = re.compile(rf"\..*\.partial-{WRITER}-[0-9a-f]{{8}}(\.[^.]{{1,15}})?", re.DOTALL)
_ASIDE = re.compile(rf"\.lightarc-replaced-{WRITER}-[0-9a-f]{{8}}")


def partial_name(target: Path, spare_bytes: int = 0) -> str:
    """A free hidden name for what becomes `target`, with its suffix; `spare_bytes` longer it is a name still."""
    suffix = target.suffix if len(target.suffix) <= 16 else ""
    ending = f".partial-{writer()}-{secrets.token_hex(4)}{suffix}"
    stem = target.name.removesuffix(suffix)
    while len(os.fsencode(stem + ending)) >= LONGEST_NAME_BYTES - spare_bytes:
        stem = stem[:-1]
    return f".{stem}{ending}"


def aside_name() -> str:
    """A free hidden name for a folder in which another lies while it is being replaced."""
    return f".lightarc-replaced-{writer()}-{secrets.token_hex(4)}"


def is_partial(name: str) -> bool:
    """True for the names that `partial_name` gives."""
    return _PARTIAL.fullmatch(name) is not None


def is_aside(name: str) -> bool:
    """True for the names that `aside_name` gives."""
    return _ASIDE.fullmatch(name) is not None


def is_abandoned(path: Path) -> bool:
    """True for a partial or a folder put aside whose writer is gone, or is this very process."""
    return (is_partial(path.name) or is_aside(path.name)) and (is_own(path) or is_gone(path))

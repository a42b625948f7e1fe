"""The hard case of untrusted files: a decoder that tries to reach what it was not handed."""

from __future__ import annotations

import os
import socket
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from engine.core.errors import MissingCapability
from engine.selftest.case import Found, Question
from engine.storage import untrusted


def attempt(content: bytes, name: str, parent: int, home: str) -> dict[str, Any]:
    """The decoder: try to read the folder `home`, to write, to connect, to start a program and to reach the parent.

    `reached` names what worked. The folder is handed over: a decoder has no environment that says it.
    """
    attempts: dict[str, Callable[[], Any]] = {
        "the user's folder": lambda: list(Path(home).iterdir()),
        "the parent's environment": lambda: Path(f"/proc/{parent}/environ").read_bytes(),
        "a temporary file": tempfile.TemporaryFile,
        "a socket": socket.socket,
        "a new process": lambda: os.posix_spawn("/bin/true", ["true"], {}),
        "the parent": lambda: os.kill(parent, 0),
    }
    reached = []
    for what, reach in attempts.items():
        try:
            reach()
        except OSError:
            continue
        reached.append(what)
    return {"reached": reached}


def _decoders_are_confined() -> Found:
    facts: dict[str, Any] = {"parent": os.getpid(), "home": str(Path.home())}
    found = untrusted.decode_content("engine.selftest.confinement:attempt", "self-test", b" ", **facts)
    protection = untrusted.protection()
    if protection is None or not protection.whole:
        raise MissingCapability(protection.sentence if protection else "no decoder has run", "Use a newer Linux")
    return float(len(found["reached"])), 0.0


QUESTIONS: tuple[Question, ...] = (
    Question("D1", "things outside its file that a decoder reaches", _decoders_are_confined),
)

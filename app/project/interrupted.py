"""Jobs that were running when the process ended: each has a small file beside the project, which goes when it ends.

A file holds the title of the job and how to go on with it. Its name says whose it is (`engine.storage.writer`), so that
the jobs of a process that is gone are told from those that run.

An export says its place and its parts. The file may come from anybody with the project, so that nothing is written on
its word: it only fills in a dialog, in which the user says where the export goes.
"""

from __future__ import annotations

import itertools
import json
import logging
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from engine.core.errors import FileError, InputError
from engine.storage.atomic import discard, write_json
from engine.storage.untrusted import read_bytes
from engine.storage.writer import is_gone, is_own, writer

log = logging.getLogger(__name__)

_NAME = "job-"
_numbers = itertools.count()

#: Size of such a file and jobs that are listed, at most.
MAX_BYTES, MAXIMUM = 1 << 16, 20


@dataclass(frozen=True)
class Interrupted:
    """One job that did not end: its file, its title, and how to go on with it (`app.jobs.jobs.Job.again`)."""

    path: Path
    title: str
    again: Mapping[str, Any] = field(default_factory=dict)


@contextmanager
def running(folder: Path, title: str, again: Mapping[str, Any] | None = None) -> Iterator[None]:
    """A job runs within the block. Where its file cannot be written it runs all the same."""
    place = folder / f"{_NAME}{next(_numbers)}-{writer()}.json"
    try:
        write_json(place, {"title": title, "again": dict(again or {})})
    except (FileError, OSError) as error:
        log.info("if the program is killed, %s is not listed as interrupted: %s", title, error)
    try:
        yield
    finally:
        discard(place)


def interrupt_in(folder: Path) -> tuple[Interrupted, ...]:
    """The jobs in a data folder whose process is gone, the first begun first."""
    places = [place for place in folder.glob(f"{_NAME}*.json") if is_gone(place) and not is_own(place)]
    found = (_read(place) for place in sorted(places, key=lambda place: place.stat().st_mtime)[:MAXIMUM])
    return tuple(each for each in found if each is not None)


def _read(place: Path) -> Interrupted | None:
    """One of them; None where the file is damaged, which is then removed."""
    try:
        said = json.loads(read_bytes(place, MAX_BYTES))
        return Interrupted(place, str(said["title"])[:200], dict(said["again"]))
    except (InputError, ValueError, TypeError, KeyError, RecursionError):
        discard(place)
        return None


def forget(job: Interrupted) -> None:
    """Somebody goes on with the job, or does not want to."""
    discard(job.path)


def propose_place(again: Mapping[str, Any], folder: Path, name: str) -> Path:
    """The path to propose, in letters that can be shown; `folder` and `name` stand in for what cannot be used."""
    said, before = str(again.get("name", "")), str(again.get("folder", ""))
    shown = "".join(letter for letter in said if letter.isprintable()).strip()
    is_name = shown not in ("", ".", "..") and Path(shown).name == shown
    is_folder = os.path.isabs(before) and os.path.isdir(before)  # noqa: PTH112, PTH117 - a Path raises for long ones
    return (Path(before) if is_folder else folder) / (shown if is_name else name)


def propose_parts(again: Mapping[str, Any]) -> frozenset[str]:
    """The parts of a bundle or the targets that were chosen."""
    said = again.get("parts")
    return frozenset(map(str, said)) if isinstance(said, list) else frozenset()

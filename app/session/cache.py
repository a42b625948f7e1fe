"""Working copies in the cache of the user: pixels and arrays as they are mapped and read, each named by its content.

All projects and windows share them. A project keeps what cannot be made again, and its results compressed; here lie the
copies that open at once. Together they stay within a limit: those go first that were used longest ago, but none that a
window works with (a file `used-WRITER` in its folder), and no pixels whose photographs are gone while a project needs
them (`origin-*.json`, who needs them and of which photographs they were made).

An entry is a folder that gets its name when it is whole. Whoever uses one marks it and then looks whether it is still
called so; whoever removes one renames it and then looks for marks.
"""

from __future__ import annotations

import hashlib
import json
import logging
import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path

from app.session.settings import PREFIX, cache_folder, config_folder, load
from engine.core.errors import FileError
from engine.storage.atomic import discard, make_folder, perform, write_bytes
from engine.storage.partial_names import partial_name
from engine.storage.untrusted import read_bytes
from engine.storage.writer import is_gone, is_own, writer

log = logging.getLogger(__name__)

#: The limit where the user sets none: so many bytes, and at most this share of what the disk has left for it.
DEFAULT_BYTES, DEFAULT_SHARE = 10 * 2**30, 0.5

FOLDER, VISIBILITY = "results", "visibility"
_USED, _ORIGIN = "used-", "origin-"
_ORIGIN_LIMIT_BYTES = 1 << 22


def entries_folder() -> Path | None:
    """The folder of the working copies, which is made; None where the system has none that can be written."""
    folder = cache_folder()
    if folder is None:
        return None
    try:
        made = make_folder(folder / FOLDER)
    except FileError as error:
        log.info("results are not cached: %s", error)
        return None
    return made if os.access(made, os.W_OK) else None


def visibility_folder() -> Path | None:
    """The folder of records of visibility, which bakes make; None where there is no cache."""
    folder = cache_folder()
    return None if folder is None else folder / VISIBILITY


def entry(name: str) -> Path | None:
    """The folder of a working copy, which may not exist; None where there is no cache."""
    folder = entries_folder()
    return folder / name if folder is not None else None


def use(place: Path) -> bool:
    """Keep an entry for this process, as used now; False where it is not there."""
    mark = place / f"{_USED}{writer()}"
    try:
        if not place.is_dir():
            return False
        if not mark.exists():
            write_bytes(mark, b"")
        os.utime(place)
    except (FileError, OSError):
        return False
    return mark.exists()


def mark_used(place: Path) -> None:
    """Mark an entry as used now."""
    with suppress(OSError):
        os.utime(place)


def let_go(place: Path) -> None:
    """This process needs the entry no longer."""
    discard(place / f"{_USED}{writer()}")


def note_origin(place: Path, project: Path, photographs: Iterable[Path]) -> None:
    """Note that the `project` needs the pixels at `place`, and that they can be made of `photographs` as these are."""
    known = [[str(path), *about] for path in photographs if (about := _about(path)) is not None]
    said = json.dumps({"project": str(project), "photographs": known}).encode()
    target = place / f"{_ORIGIN}{hashlib.blake2b(str(project).encode(), digest_size=8).hexdigest()}.json"
    try:
        if not target.exists() or target.read_bytes() != said:
            write_bytes(target, said)
    except (FileError, OSError) as error:
        log.info("the origin of a working copy is not noted: %s", error)


def _about(path: Path) -> tuple[int, int] | None:
    """Size and time of change of a file; None where it is not there."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_size, found.st_mtime_ns


def limit_bytes() -> int:
    """Bytes that all working copies may take."""
    chosen = load(config_folder()).cache_gb
    if chosen > 0:
        return int(chosen * 1e9)
    folder = entries_folder()
    if folder is None:
        return DEFAULT_BYTES
    with suppress(OSError):
        return min(DEFAULT_BYTES, int(DEFAULT_SHARE * (shutil.disk_usage(folder).free + size_bytes())))
    return DEFAULT_BYTES


def size_bytes() -> int:
    """Bytes of all working copies."""
    return sum(_size_of(place) for place in _entries())


def keep_within(limit: int | None = None) -> int:
    """Remove entries, those used longest ago first, until the rest is within the limit; the bytes that went."""
    limit = limit_bytes() if limit is None else limit
    found = sorted(((_get_last_use(place), _size_of(place), place) for place in _entries()), key=lambda each: each[0])
    total, freed = sum(size for _, size, _ in found), 0
    for _, size, place in found:
        if total - freed <= limit:
            break
        freed += size if remove(place) else 0
    return freed


def remove(place: Path, *, even_own: bool = False) -> bool:
    """Remove an entry; False where a window uses it, or a project needs it and its photographs are gone.

    `even_own` removes also what this process has marked.
    """
    if _is_in_use(place, even_own) or is_needed(place):
        return False
    hidden = place.with_name(partial_name(place))
    try:
        perform("rename", place, lambda: place.rename(hidden))
    except FileError as error:
        log.info("a working copy stays: %s", error)
        return False
    if _is_in_use(hidden, even_own) and not place.exists():
        with suppress(OSError):
            hidden.rename(place)
            return False
    discard(hidden)
    return True


def empty() -> None:
    """Remove all of the cache of the user but what open windows use and what projects need."""
    folder = cache_folder()
    for place in folder.glob("*") if folder is not None else ():
        if place.name == FOLDER:
            keep_within(0)
        elif not place.name.startswith(PREFIX) or is_gone(place):
            discard(place)


def _is_in_use(place: Path, even_own: bool) -> bool:
    marks = list(place.glob(f"{_USED}*"))
    return any(not is_gone(mark) and not (even_own and is_own(mark)) for mark in marks)


def is_needed(place: Path) -> bool:
    """True for pixels that a project needs, and that its photographs can no longer be read for."""
    return any(_needs(origin) for origin in place.glob(f"{_ORIGIN}*.json"))


def _needs(origin: Path) -> bool:
    try:
        said = json.loads(read_bytes(origin, _ORIGIN_LIMIT_BYTES))
        if not Path(said["project"]).is_file():
            return False
        return any(_about(Path(path)) != (size, modified) for path, size, modified in said["photographs"])
    except (FileError, OSError, ValueError, KeyError, TypeError):
        return True  # what cannot be understood is kept


def _entries() -> Iterator[Path]:
    folder = cache_folder()
    with suppress(OSError):
        if folder is not None:
            yield from (each for each in (folder / FOLDER).iterdir() if not each.name.startswith(".") and each.is_dir())


def _size_of(place: Path) -> int:
    with suppress(OSError):
        return sum(each.stat().st_size for each in place.iterdir() if each.is_file())
    return 0


def _get_last_use(place: Path) -> float:
    with suppress(OSError):
        return place.stat().st_mtime
    return 0.0

"""Copies of projects: as they are, and collected, with their photographs inside.

A copy is made under a hidden name and takes the place of what has its name when it is whole: one rename of the file
decides, and the data folder follows, after an interruption when the project is next opened (`settle`).

The project that is copied may be open and at work: what other threads are writing meanwhile is left out, and what they
remove is not missed. A copy of links takes no time and no room, whatever the size of the project, and is as independent
of the original as any other, because files in a data folder are replaced and never changed. It is half of a move, of
which the other half is to remove the original.
"""

from __future__ import annotations

import hashlib
import os
import sqlite3
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from urllib.parse import quote

from app.document.document import Project
from app.document.variation import Blend
from app.project.database import connect, explain, unreadable, upgrade
from app.project.photographs import INSIDE, Mark, copy_places, files_of, marks_of, outside_of, relocate
from app.project.places import is_open_elsewhere, remove
from app.project.project_file import WAITING, History, Writer, data_folder, is_waiting, read, settle, waiting_name
from app.project.values import in_full, is_file
from engine.brdf.readers.read import read_brdf
from engine.core.errors import FileError, InputError, OutputError
from engine.core.steps import Step, Steps
from engine.storage.atomic import (
    atomic_file,
    discard,
    explaining,
    is_in_use,
    link,
    make_folder,
    perform,
    put_file,
    remove_leftovers,
    replaceable,
    require_space,
    spell,
    standing_for,
    synchronise,
)
from engine.storage.partial_names import is_aside, is_partial, partial_name
from engine.storage.untrusted import FILE_LIMIT_BYTES, open_checked
from engine.storage.writer import is_gone

#: Bytes that are copied between two steps.
PIECE_BYTES = 1 << 24

#: Ending of results that are written piece by piece in place (`engine.storage.resumable`).
UNFINISHED = ".unfinished"

#: Endings of what lies beside a project: its data, and what SQLite writes first. Names have to have room for them.
BESIDE = ("-data", "-journal")

#: Files that an error lists.
MAX_LISTED = 20


def copy(
    source: Path,
    target: Path,
    *,
    with_derived: bool = True,
    now: History | None = None,
    own: Path | None = None,
    is_unreadable: bool = False,
    with_links: bool = False,
) -> Steps[Path]:
    """Copy the project `source`, its history and its data to `target`, which it replaces in one step.

    Parameters
    ----------
    source, target : files of projects.
    with_derived : whether results are copied that can be made again.
    now : the document as it is in memory, which the copy holds whatever `source` says; None for that of `source`.
    own : the folder of what was made of `now`, where that is not the data folder of `source`.
    is_unreadable : whether the copy may hold `now` alone, because `source` cannot be read.
    with_links : whether files are linked where the file system can do that.

    Raises OutputError where `target` is open or cannot be written; it is then as it was.
    """
    with becoming(target) as partial:
        yield from _copy(source, partial, with_derived, now, own, is_unreadable, with_links)
    return target


class OutsideFiles(InputError):
    """A project names files outside its folder: they are copied only where the user has seen them and agreed."""

    def __init__(self, project: Path, files: tuple[Path, ...]) -> None:
        self.files = files
        named = [str(each) for each in files[:MAX_LISTED]]
        more = [f"and {len(files) - MAX_LISTED} more"] if len(files) > MAX_LISTED else []
        problem = f"names files outside its folder, which a collected project would hold: {', '.join([*named, *more])}"
        super().__init__(project, problem, "Look at them, and give --include-outside to copy them too")


def collect(source: Path, target: Path, with_derived: bool = True, *, include_outside: bool = False) -> Steps[Path]:
    """Copy `source` to `target` with its photographs inside, so that it opens on another machine.

    A received project may name any file of its user, so that a file is taken only where its size and content are those
    that the project recorded when it was imported, and where it decodes as what the project takes it for. Files
    outside the folder of the project, links followed, are taken only where `include_outside` says so.

    Raises InputError for photographs that are missing or are not those that were recorded, OutsideFiles where files
    lie outside, and OutputError as `copy` does.
    """
    files = files_of(read(source).current)
    gone = [path for path in files if not is_file(path)]
    if gone:
        raise InputError(gone[0], f"is missing ({len(gone)} of the photographs)", "Say where they are now, or copy")
    outside = outside_of(source, files)
    if outside and not include_outside:
        raise OutsideFiles(source, outside)
    marks = marks_of(source)
    with becoming(target) as partial:
        yield from _copy(source, partial, with_derived, None, None)
        yield from _with_photographs_inside(partial, marks)
    return target


@contextmanager
def becoming(target: Path) -> Iterator[Path]:
    """The hidden path of a project that takes the place of `target` where the block ends well, and goes otherwise."""
    with explaining(target):  # a name that is too long for what lies beside it raises here, before anything is made
        has_data, _ = (target.with_name(target.name + ending).exists() for ending in BESIDE)
    existing = replaceable(target, target)
    if is_open_elsewhere(target):
        raise OutputError(target, "is open in another window", "Close it there, or choose another name")
    if existing is None and has_data:
        raise OutputError(data_folder(target), "exists already", "Choose another name, or remove it first")
    make_folder(target.parent)
    if existing is not None:
        with suppress(FileError):  # one that is not a project of ours, or damaged, is replaced as well
            settle(target)
    remove_leftovers(target.parent)
    _remove_waiting(target)
    partial = spell(target.parent) / partial_name(target, max(map(len, BESIDE)))
    data, journal = data_folder(partial), partial.with_name(partial.name + BESIDE[1])
    waiting, is_whole = data.with_name(waiting_name(data.name)), False
    with standing_for(partial, target), standing_for(data, data_folder(target)), standing_for(journal, target):
        try:
            with explaining(target):
                yield partial
            with connect(partial) as connection, connection:
                connection.execute("INSERT INTO meta VALUES (?, ?)", (WAITING, quote(os.fsencode(waiting.name))))
            if existing is not None:
                _finish_journal(target)
            synchronise(partial)
            perform("rename", data, lambda: data.rename(waiting))  # whoever cleans up after us leaves it from now on
            is_whole = True
            put_file(partial, target, existing)
        finally:
            if not is_whole or partial.exists():
                remove(partial)
                discard(waiting)
    settle(target)


def _remove_waiting(target: Path) -> None:
    """Remove data folders of copies to `target` that a killed process left just before the copy was there.

    One whose copy is there is no longer among them: `settle` has given it its name.
    """
    for path in target.parent.iterdir():
        if path.name.startswith(f".{target.stem}.") and is_waiting(path.name) and is_gone(path):
            discard(path)


def _finish_journal(target: Path) -> None:
    """Let SQLite finish what an interrupted process left of the old file: it would take that for the new one's."""
    with suppress(FileError), connect(target):
        pass
    discard(target.with_name(target.name + "-journal"))


def _copy(
    source: Path,
    partial: Path,
    with_derived: bool,
    now: History | None,
    own: Path | None,
    is_unreadable: bool = False,
    with_links: bool = False,
) -> Steps[None]:
    """The project at `partial`, of the file at `source` and of what is only in memory."""
    make_folder(data_folder(partial))
    try:
        copy_database(source, partial)
        yield from copy_files(data_folder(source), data_folder(partial), with_derived, with_links)
    except (FileError, OSError):
        if now is None or not is_unreadable:
            raise
        discard(partial)
        now = in_memory(now)
    if now is not None:
        if own is not None and own != data_folder(source):
            yield from copy_files(own, data_folder(partial), True)
        yield Step(1.0, "writing the latest changes")
        writer = Writer(partial, seen_from=data_folder(source), own=own)
        with closing(writer):
            writer.write(now)
    copy_places(source, partial)


def in_memory(history: History) -> History:
    """The latest steps of a history that need no file: those between documents that were read."""
    unread = [at for at, step in enumerate(history.steps) if not (_is_read(step.old) and _is_read(step.new))]
    first = unread[-1] + 1 if unread else 0
    kept = history.steps[first:] if first <= history.position else ()
    return History(history.current, kept, history.position - first if kept else 0)


def _is_read(state: Project | str) -> bool:
    return isinstance(state, Project)


def _with_photographs_inside(target: Path, marks: Mapping[Path, Mark]) -> Steps[None]:
    """Copy the photographs into the data folder, and note that they are there, for every state of the history."""
    inside = data_folder(target) / INSIDE
    project = read(target).current
    files = [path for path in files_of(project) if not path.is_relative_to(inside)]
    brdfs = {each.brdf for each in project.variations if isinstance(each, Blend) and isinstance(each.brdf, Path)}
    places = {path: inside / f"{at + 1:04d}" / path.name for at, path in enumerate(files)}
    for at, (path, place) in enumerate(places.items()):
        done = at / len(places)
        yield Step(done, f"copying {path.name}")
        _copy_marked(path, place, marks.get(in_full(path)))
        yield Step(done, f"decoding {path.name}")
        _check_decodes(path, place, path in brdfs)
    relocate(target, places)
    yield Step(1.0, "collected")


def _copy_marked(source: Path, target: Path, mark: Mark | None) -> None:
    """Copy a file whose content is the one that a project recorded; InputError for any other."""
    remedy = "`lightarc project find` with the folder of the photographs records those that are there"
    if mark is None:
        raise InputError(source, "is named by the project, which has no record of its content", remedy)
    digest = hashlib.blake2b(digest_size=20)
    make_folder(target.parent)
    with open_checked(source, FILE_LIMIT_BYTES) as (there, size_bytes):
        if size_bytes != mark.size:
            raise InputError(source, "is not the file that the project recorded", remedy)
        with atomic_file(target, size_bytes) as here:
            while piece := there.read(1 << 22):
                digest.update(piece)
                here.write(piece)
    if digest.hexdigest() != mark.hash:
        raise InputError(source, "is not the file that the project recorded", remedy)


def _check_decodes(path: Path, copied: Path, is_brdf: bool) -> None:
    """InputError about `path` where its copy is not a photograph, image or BRDF."""
    from engine.capture.photograph.decode import read_photograph

    try:
        if is_brdf:
            read_brdf(copied)
        else:
            read_photograph(copied, half_size=True)
    except InputError as error:
        kind = "measured BRDF" if is_brdf else "photograph"
        raise InputError(
            path, f"is not a usable {kind} ({error.problem})", "Remove it from the project, or copy it"
        ) from error


#: Beginnings of the names of what this program puts into a data folder, besides photographs.
_MADE = ("stack-", "bake-", "factors-")


def copy_files(source: Path, target: Path, with_derived: bool, with_links: bool = False) -> Steps[None]:
    """Files that this program puts into a data folder, without the marks of windows and without what is being written.

    Links are left behind: in a received project they lead to whatever its maker likes. Raises OutputError where there
    is no room for it.
    """
    files = [path for path in _list_files(source) if path.is_file() and not path.is_symlink()]
    files = [
        path for path in files if _is_ours(path.relative_to(source), with_derived) and not _is_written(path, source)
    ]
    sizes = {path: size for path in files if (size := _size_of(path)) is not None}
    total, so_far = sum(sizes.values()), 0
    if not with_links:
        require_space(target, total)
    for path, size in sizes.items():
        yield Step(so_far / max(1, total), f"copying {path.name}")
        yield from _copy_file(path, target / path.relative_to(source), with_links, _portion(so_far, size, total))
        so_far += size


def _list_files(folder: Path) -> Iterator[Path]:
    """All files in a folder, if it exists; UnreadableError for a part of it that cannot be listed."""

    def refuse(error: OSError) -> None:
        raise unreadable(Path(str(error.filename)), error)

    if folder.exists():
        for place, _, names in os.walk(folder, onerror=refuse):
            yield from (Path(place, name) for name in names)


def _is_ours(path: Path, with_derived: bool) -> bool:
    first = path.parts[0].removeprefix(".")  # results that are written in place are hidden
    return first == INSIDE or (with_derived and (first in ("arrays", "thumbnail.png") or first.startswith(_MADE)))


def _is_written(path: Path, folder: Path) -> bool:
    """True for what is being written in the data folder `folder`."""
    parts = path.relative_to(folder).parts
    return any(is_partial(part) or is_aside(part) for part in parts) or is_in_use(spell(path))


def _portion(start: int, size: int, total: int) -> Callable[[float], float]:
    """The share done of all, of the share done of a part that begins at `start`."""
    return lambda done: (start + done * size) / max(1, total)


def _size_of(path: Path) -> int | None:
    try:
        return path.stat().st_size
    except FileNotFoundError:
        return None  # it has just been removed


def _copy_file(source: Path, target: Path, with_links: bool, share: Callable[[float], float]) -> Steps[None]:
    """One file, or a link to it; nothing where it has just been removed. `share` makes progress of the part done."""
    make_folder(target.parent)
    if with_links and not source.name.endswith(UNFINISHED) and link(source, target):
        return
    with suppress(FileNotFoundError), source.open("rb") as there:
        size = os.fstat(there.fileno()).st_size
        with atomic_file(target, size) as here:
            while piece := there.read(PIECE_BYTES):
                here.write(piece)
                yield Step(share(there.tell() / max(1, size)), f"copying {source.name}")


def copy_database(source: Path, target: Path) -> None:
    """Copy the project file alone, in this schema. Raises InputError or OutputError."""
    with connect(source) as there, explain(target), closing(sqlite3.connect(target)) as copy_:
        there.backup(copy_)
        upgrade(copy_, target)

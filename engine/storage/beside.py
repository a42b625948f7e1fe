"""Files that a document of a stranger names: those in its folder or below, and in a folder that a user allows."""

from __future__ import annotations

import re
from pathlib import Path, PurePosixPath

from engine.core.errors import InputError
from engine.storage.untrusted import FILE_LIMIT_BYTES, open_checked

#: The place of the number in the name of a UDIM set, and its numbers: 1001 + column + 10 row, rows upwards.
_UDIM, UDIM_TILES = re.compile("<UDIM>", re.IGNORECASE), range(1001, 1101)

#: The beginning of an address of the web, also where its slashes were taken together.
_ADDRESS = re.compile(r"[A-Za-z][A-Za-z0-9+.-]{1,20}:/")


def tiles_beside(path: Path, named: str, remedy: str, search: Path | None = None) -> dict[int, Path]:
    """The tiles of a UDIM set that `path` calls `named`, by their numbers, 1001 to 1100; none for another name.

    Each lies where `file_beside` looks for a file; InputError where there is no tile at all.
    """
    if not _UDIM.search(named):
        return {}
    found, problem = dict[int, Path](), None
    for number in UDIM_TILES:
        try:
            found[number] = file_beside(path, _UDIM.sub(str(number), named), remedy, search)
        except InputError as error:
            problem = problem or error
    if problem is not None and not found:
        raise problem
    return found


def file_beside(path: Path, named: str, remedy: str, search: Path | None = None) -> Path:
    """The file that `path` calls `named`, in its folder or below; InputError for any other and for one not there.

    A user allows further files by a folder to `search`: those in it or below, where `path` calls them so, or where they
    would lie if the name began there, without the steps out of a folder at its beginning.
    """
    folder = path.absolute().parent
    places = [(folder / named, folder)]
    if search is not None:
        steps = [step for step in PurePosixPath(named).parts if step != ".."]
        places += [(folder / named, search.absolute()), (search.absolute().joinpath(*steps), search.absolute())]
    try:
        inside = [place for place, within in places if place.resolve().is_relative_to(within.resolve())]
    except (OSError, ValueError, RuntimeError):
        raise InputError(path, f"names an impossible file ({named[:60]!r})", remedy) from None
    if not inside or _ADDRESS.match(named):
        raise InputError(path, f"names a file outside its folder ({named[:60]!r})", remedy)
    beside = next((place for place in inside if place.is_file()), inside[0])
    try:
        with open_checked(beside, FILE_LIMIT_BYTES):
            return beside
    except InputError as error:
        raise InputError(path, f"needs the file {named[:60]!r} next to it, which {error.problem}", remedy) from None

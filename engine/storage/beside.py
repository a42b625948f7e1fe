"""Files that a document of a stranger names: those in its folder or below, and in a folder that a user allows."""

from __future__ import annotations

import re
from pathlib import Path, PurePosixPath

from engine.core.errors import InputError
from engine.storage.untrusted import FILE_LIMIT_BYTES, open_checked

#: The beginning of an address of the web, also where its slashes were taken together.
_ADDRESS = re.compile(r"[A-Za-z][A-Za-z0-9+.-]{1,20}:/")


def file_beside(path: Path, named: str, remedy: str, search: Path | None = None) -> Path:
    """The file that `path` calls `named`, in its folder or below; InputError for any other and for one not there.

    A user allows further files by a folder to `search`: those in it or below, where `path` calls them so, or where they
    would lie if the name began there, without the steps out of a folder at its beginning.
    A set of UDIM tiles is refused.
    """
    if "<UDIM>" in named.upper():
        problem = f"names a set of UDIM tiles ({PurePosixPath(named).name[:40]!r}), of which one is read at a time"
        raise InputError(path, problem, "Put the number of a tile, 1001 say, in the place of <UDIM>")
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
        raise InputError(path, f"needs the file {named[:60]!r} beside it, which {error.problem}", remedy) from None

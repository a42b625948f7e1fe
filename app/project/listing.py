"""The projects of a user, for a list: their files, titles, dates and sizes, read without opening any of them.

A project that is damaged, huge or hostile is listed as any other: only its name, what the system says of its files, and
its title (`app.project.thumbnail`) are looked at.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from app.project.places import is_open_elsewhere, is_untitled
from app.project.project_file import ENDING, data_folder
from app.project.thumbnail import title_of

#: Projects that are listed, and files of one whose sizes are added up, at most.
MAX_PROJECTS, MAX_FILES = 500, 20_000


@dataclass(frozen=True)
class Listed:
    """A project in a list.

    Attributes
    ----------
    name : the name of the file without its ending; of an untitled project that of its material, where it is known.
    modified_s : when the file was written last, in seconds since 1970.
    is_untitled : nobody has given the project a name and a folder.
    is_open : another window has it open.
    """

    path: Path
    name: str
    modified_s: float
    is_untitled: bool
    is_open: bool = False


def list_projects(folder: Path, others: Iterable[Path] = ()) -> list[Listed]:
    """The projects in `folder` and those of `others` that exist, the latest first, at most `MAX_PROJECTS`.

    What cannot be looked at, as a drive that is gone, is left out.
    """
    try:
        own = [Path(entry.path) for entry in os.scandir(folder) if entry.name.endswith(ENDING)]
    except OSError:
        own = []
    found = (_as_list(path) for path in dict.fromkeys((*own, *others)))
    return sorted((each for each in found if each), key=lambda each: each.modified_s, reverse=True)[:MAX_PROJECTS]


def _as_list(path: Path) -> Listed | None:
    try:
        if not path.is_file():
            return None
        modified_s, has_no_name = path.stat().st_mtime, is_untitled(path)
        name = (title_of(path) if has_no_name else "") or path.name.removesuffix(ENDING)
        return Listed(path, name, modified_s, has_no_name, is_open_elsewhere(path))
    except (OSError, ValueError):
        return None


def size_of_project(path: Path) -> int:
    """Bytes of a project file and of its data folder; links are not followed, and no more than `MAX_FILES` counted."""
    total, count, waiting = _size(path), 0, [data_folder(path)]
    while waiting and count < MAX_FILES:
        try:
            with os.scandir(waiting.pop()) as entries:
                for entry in entries:
                    count += 1
                    if entry.is_dir(follow_symlinks=False):
                        waiting.append(Path(entry.path))
                    elif entry.is_file(follow_symlinks=False):
                        total += entry.stat(follow_symlinks=False).st_size
        except OSError:
            continue
    return total


def _size(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return 0

"""Projects that are not open: renamed, and moved to the trash."""

from __future__ import annotations

from pathlib import Path

import platformdirs
from PySide6.QtCore import QFile

from app.project.copying import copy_database
from app.project.places import is_open_elsewhere
from app.project.project_file import ENDING, data_folder, settle
from engine.core.errors import InputError, OutputError
from engine.core.steps import Step, Steps
from engine.storage.atomic import atomic_path, discard, explaining, make_folder, perform


def rename(path: Path, name: str) -> Steps[Path]:
    """Give a project another name in its folder; its new path.

    A copy of the file takes the new name, then the data folder, then the old file goes: an interruption leaves all data
    beside one of the two files, and at worst the other one without them.
    Raises InputError where there is no such project or one of that name, and OutputError where it is open or cannot be
    renamed.
    """
    yield Step(0.0, f"renaming {path.name}")
    stem = name.strip().removesuffix(ENDING)
    if not stem.strip(". ") or any(letter in stem for letter in "/\\\0"):
        raise InputError(name, "cannot be the name of a project", "Choose a name without slashes")
    target = path.with_name(f"{stem}{ENDING}")
    if target == path:
        return path
    _require_closed(path)
    with explaining(target):
        if target.exists() or data_folder(target).exists():
            raise InputError(target, "exists already", "Choose another name")
    settle(path)
    with atomic_path(target) as partial:
        copy_database(path, partial)
    try:
        if data_folder(path).is_dir():
            perform("rename", data_folder(path), lambda: data_folder(path).rename(data_folder(target)))
    except OutputError:
        discard(target)
        raise
    discard(path)
    return target


def move_to_trash(path: Path) -> Steps[None]:
    """Move a project with its data to the trash of the system.

    Raises OutputError where it is open, or where the system takes nothing there; nothing is removed for good.
    """
    yield Step(0.0, f"moving {path.name} to the trash")
    _require_closed(path)
    make_folder(Path(platformdirs.user_data_dir()))  # Qt makes the trash in it, and fails where it is not there
    for part in (path, data_folder(path)):
        if part.exists() and not trash(part):
            remedy = f"Remove {path.name} and {data_folder(path).name} in your file manager"
            raise OutputError(part, "cannot be moved to the trash of this system", remedy)


def trash(path: Path) -> bool:
    """Move a file or a folder to the trash of the system; False where there is none, and all is as it was."""
    return QFile(str(path)).moveToTrash()


def _require_closed(path: Path) -> None:
    if not path.is_file():
        raise InputError(path, "is no longer there", "Look for it in your file manager")
    if is_open_elsewhere(path):
        raise OutputError(path, "is open in another window", "Close it there first")

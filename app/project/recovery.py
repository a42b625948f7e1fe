"""What is sound in a damaged project, as a new project.

The damaged file is only read, under the guards of every project (`app.project.database`). Parts of the document that
cannot be read are as in a new one. The history is kept where the document and all states of it are sound.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing
from pathlib import Path

from app.document.document import Project, Step
from app.project.copying import becoming, copy_files
from app.project.database import Guarded, salvage
from app.project.photographs import Mark, keep, marks_in
from app.project.project_file import (
    MAX_POSITION,
    History,
    Writer,
    data_folder,
    describe_problem,
    finder_of,
    parts_in,
    read_part,
    read_state,
    steps_in,
)
from app.project.values import DAMAGE, Absent, Finder
from engine.core.errors import FileError, InputError
from engine.core.steps import Step as Progress
from engine.core.steps import Steps
from engine.storage.atomic import make_folder
from engine.storage.text import whole_number


def recover(source: Path, target: Path) -> Steps[list[str]]:
    """Write what is sound in the project `source` to the project `target`; sentences about what is not.

    Raises InputError where nothing is sound, OutputError as `copy` does.
    """
    yield Progress(0.0, "reading what is sound")
    with salvage(source) as (connection, tables):
        history, lost = _sound(source, connection, tables)
        marks = _marks(source, connection, tables)
    with becoming(target) as partial:
        make_folder(data_folder(partial))
        yield from copy_files(data_folder(source), data_folder(partial), True)
        with closing(Writer(partial, seen_from=data_folder(source))) as writer:
            writer.write(history)
    keep(target, marks)
    return lost


def _sound(path: Path, connection: Guarded, tables: list[str]) -> tuple[History, list[str]]:
    """The document with its sound parts, and its history where all of it is sound; what is left behind."""
    if not {"meta", "state", "value", "array"} <= set(tables):
        raise InputError(path, "holds no document that could be saved", "Open a copy of the project")
    try:
        finder = finder_of(path)
    except FileError as error:
        raise InputError(path, f"holds nothing that can be read ({error.problem})", "Open a copy of it") from error
    steps, lost = _steps(connection, tables)
    for name in _candidates(connection, steps):
        try:
            found, wrong = _document(path, connection, name, finder)
        except FileError:
            continue
        lost += wrong
        if wrong or not steps:
            return History(found), lost + (["the history is left behind"] if steps else [])
        try:
            whole = tuple(_read_step(path, step, finder) for step in steps)
        except (FileError, *DAMAGE) as error:
            said = error.problem if isinstance(error, FileError) else "damaged"
            return History(found), [*lost, f"the history is left behind: one of its states {said}"]
        position = _position(connection, len(steps))
        return History(found, whole, position), lost
    raise InputError(path, "holds no document that could be saved", "Open a copy of the project")


def _steps(connection: Guarded, tables: list[str]) -> tuple[tuple[Step, ...], list[str]]:
    if "step" not in tables:
        return (), ["the history cannot be read"]
    try:
        return steps_in(connection), []
    except sqlite3.Error as error:
        return (), [f"the history cannot be read ({error})"]


def _candidates(connection: Guarded, steps: tuple[Step, ...]) -> Iterator[str]:
    """Names of states, the current one first, then those of the history and all others, the latest first."""
    names = dict[str, None]()
    for statement in (
        "SELECT value FROM meta WHERE name = 'current'",
        "SELECT name FROM state ORDER BY rowid DESC LIMIT 400",
    ):
        try:
            names |= dict.fromkeys(str(row[0]) for row in connection.execute(statement).fetchall())
        except sqlite3.Error:
            continue
        if "meta" in statement:
            names |= dict.fromkeys(str(step.new) for step in reversed(steps))
    yield from names


def _document(path: Path, connection: Guarded, name: str, finder: Finder) -> tuple[Project, list[str]]:
    """The sound parts of a state, and sentences about the others. Raises InputError where there are none."""
    try:
        row = connection.execute("SELECT parts FROM state WHERE name = ?", (name,)).fetchone()
    except sqlite3.Error as error:
        raise InputError(path, f"is damaged ({error})", "") from error
    if row is None:
        raise InputError(path, "has lost a state", "")
    parts, lost = {}, []
    for part, value in parts_in(str(row[0]), path).items():
        try:
            parts[part] = read_part(part, value, finder)
        except Absent as gone:
            lost.append(f"{part}: {gone}")
        except DAMAGE as error:
            lost.append(describe_problem(part, error))
        except FileError as error:
            lost.append(f"{part}: {error.problem}")
    if not parts:
        raise InputError(path, "has no sound part", "")
    return Project(**parts), lost


def _read_step(path: Path, step: Step, finder: Finder) -> Step:
    old, new = (read_state(path, str(state), finder, {}) for state in (step.old, step.new))
    return Step(step.text, step.gesture, old, new)


def _position(connection: Guarded, count: int) -> int:
    row = connection.execute("SELECT value FROM meta WHERE name = 'position'").fetchone()
    position = whole_number(row[0] if row is not None else None, MAX_POSITION)
    return count if position is None else min(position, count)


def _marks(path: Path, connection: Guarded, tables: list[str]) -> Mapping[Path, Mark]:
    """Marks of photographs, as far as they can be read."""
    if "photograph" not in tables:
        return {}
    try:
        statement = "SELECT place, now, size, modified, hash FROM photograph WHERE hash != ''"
        return marks_in(connection.execute(statement).fetchall(), data_folder(path))
    except sqlite3.Error:
        return {}

"""Tidying of a project file: values and arrays that no state needs any more go, also the arrays and stacks beside it.

A value is needed where a state or another needed value names it, an array or a stack where a value does. Beside those
of the history, the states of the last materials stay, so that settings that were there before find their results.
"""

from __future__ import annotations

import logging
import sqlite3
from collections.abc import Iterator, Mapping
from pathlib import Path

from app.project.values import DAMAGE, parse
from engine.core.errors import FileError
from engine.storage.atomic import discard, perform
from engine.storage.partial_names import partial_name

log = logging.getLogger(__name__)

#: Materials of which a state stays that no step leads to, because it was undone or is older than the history.
KEPT_MATERIALS = 4


def forget_unused(connection: sqlite3.Connection, folder: Path, *, stacks: bool = False) -> None:
    """Remove states that no step leads to, and values, arrays and, where asked, `stacks` that no state holds.

    Steps that only the memory of a window has may need more stacks than the file knows of. Nothing is removed where a
    state or a value is damaged, since what it holds is not known then, nor from a folder that a link leads to: a
    project may come from anybody, and a link to anywhere.
    """
    try:
        arrays, named = _forget_rows(connection)
    except DAMAGE as error:
        log.info("nothing is tidied, because a part of the project is damaged: %s", error)
        return
    connection.execute("PRAGMA incremental_vacuum").fetchall()
    if not is_own(folder) or (folder / "arrays").is_symlink():
        return
    for beside in (folder / "arrays").glob("*"):
        if beside.suffix in (".npy", ".packed") and beside.stem not in arrays:
            discard(beside)
    for beside in folder.glob("stack-*") if stacks else ():
        if beside.name not in named:
            remove_whole(beside)


def is_own(folder: Path) -> bool:
    """True for a data folder that lies where its name says, so that what is in it belongs to the project."""
    return not folder.is_symlink()


def _forget_rows(connection: sqlite3.Connection) -> tuple[set[str], set[str]]:
    """Remove the rows that no state needs; the names of the arrays and of the stacks that are needed."""
    with connection:
        connection.execute("BEGIN IMMEDIATE")
        used = {row[0] for row in connection.execute("SELECT old FROM step UNION SELECT new FROM step")}
        used |= {row[0] for row in connection.execute("SELECT value FROM meta WHERE name = 'current'")}
        _keep_only(connection, "state", used | _last_built(connection))
        held, arrays, named = set[str](), set[str](), set[str]()
        waiting = [name for (parts,) in connection.execute("SELECT parts FROM state") for name in parse(parts).values()]
        while waiting:
            name = waiting.pop()
            if name in held:
                continue
            held.add(name)
            row = connection.execute("SELECT text FROM value WHERE name = ?", (name,)).fetchone()
            for kind, content in names_in(parse(row[0])) if row else ():
                if kind == "value":
                    waiting.append(content)
                else:
                    (arrays if kind == "array" else named).add(content)
        _keep_only(connection, "value", held)
        _keep_only(connection, "array", arrays)
    return arrays, named


def _last_built(connection: sqlite3.Connection) -> set[str]:
    """A state of each of the last materials that were built."""
    found: dict[str, str] = {}
    for name, parts in connection.execute("SELECT name, parts FROM state ORDER BY rowid DESC"):
        found.setdefault(str(parse(parts).get("built_from", "")), name)
    return {name for recipe, name in found.items() if recipe in list(found)[:KEPT_MATERIALS]}


def remove_whole(place: Path) -> None:
    """Remove a result at once: a folder gets a name of no result before the first file in it goes."""
    hidden = place.with_name(partial_name(place))
    try:
        perform("rename", place, lambda: place.rename(hidden))
    except FileError as error:
        log.info("a result stays: %s", error)
        return
    discard(hidden)


def _keep_only(connection: sqlite3.Connection, table: str, names: set[str]) -> None:
    gone = [(row[0],) for row in connection.execute(f"SELECT name FROM {table}") if row[0] not in names]
    connection.executemany(f"DELETE FROM {table} WHERE name = ?", gone)


def names_in(said: object) -> Iterator[tuple[str, str]]:
    """Names of the values, arrays and stacks that a value holds."""
    if isinstance(said, list):
        for part in said:
            yield from names_in(part)
    elif isinstance(said, Mapping):
        for key, part in said.items():
            if key in ("value", "array", "stack") and isinstance(part, str) and len(said) == 1:
                yield key, part
            else:
                yield from names_in(part)

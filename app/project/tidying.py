"""Tidying of a project file: values and arrays that no state needs any more go, also the arrays beside it.

A value is needed where a state or another needed value names it, an array where a value does.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from engine.storage.atomic import discard


def forget_unused(connection: sqlite3.Connection, folder: Path) -> None:
    """Remove states that no step leads to, and values and arrays that no state holds."""
    with connection:
        connection.execute("BEGIN IMMEDIATE")
        used = {row[0] for row in connection.execute("SELECT old FROM step UNION SELECT new FROM step")}
        used |= {row[0] for row in connection.execute("SELECT value FROM meta WHERE name = 'current'")}
        _keep_only(connection, "state", used)
        held, arrays = set[str](), set[str]()
        waiting = [
            name for (parts,) in connection.execute("SELECT parts FROM state") for name in json.loads(parts).values()
        ]
        while waiting:
            name = waiting.pop()
            if name in held:
                continue
            held.add(name)
            row = connection.execute("SELECT text FROM value WHERE name = ?", (name,)).fetchone()
            for kind, content in names_in(json.loads(row[0])) if row else ():
                if kind == "value":
                    waiting.append(content)
                elif kind == "array":
                    arrays.add(content)
        _keep_only(connection, "value", held)
        _keep_only(connection, "array", arrays)
    connection.execute("PRAGMA incremental_vacuum").fetchall()
    for beside in (folder / "arrays").glob("*.npy"):
        if beside.stem not in arrays:
            discard(beside)


def _keep_only(connection: sqlite3.Connection, table: str, names: set[str]) -> None:
    gone = [(row[0],) for row in connection.execute(f"SELECT name FROM {table}") if row[0] not in names]
    connection.executemany(f"DELETE FROM {table} WHERE name = ?", gone)


def names_in(said: Any) -> Iterator[tuple[str, str]]:
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

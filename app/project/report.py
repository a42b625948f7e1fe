"""A project file described: what it holds, what is missing, and whether all of it can be read."""

from __future__ import annotations

import contextlib
import datetime
import logging
import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from app.document.document import Project
from app.document.document import Step as HistoryStep
from app.project.arrays import file_of, find_problems, is_cached
from app.project.budget import check_arrays
from app.project.database import Damaged, connect, explain, page_problems, reading, schema_of
from app.project.declared import can_be_opened
from app.project.made import list_notes, size_of
from app.project.photographs import check, describe_changed, files_of, marks_of, name_files, photographs
from app.project.pixels import check_pixels, open_kept
from app.project.project_file import data_folder, read
from app.project.tidying import names_in
from app.project.values import DAMAGE, in_full, is_file, is_name, is_there, parse
from engine.capture.lights.file_names import printable
from engine.core.errors import FileError, InputError
from engine.core.steps import Step, Steps

log = logging.getLogger(__name__)

#: The hash of the photographs: BLAKE2b of 160 bits.
HASH = "blake2b-160"

#: Settings of a project that its material was built by.
SETTINGS = ("slices", "tileable", "evened", "part_of_light", "scale", "exponent_bits", "mixed", "error_bound_percent")


def describe(path: Path) -> dict[str, Any]:
    """For `lightarc project info --json`.

    `schema`, `name`, `photographs` (paths), `history_steps`, `position`, `missing` (photographs that are not there),
    `derived` (kind, bytes and presence of what can be made again, and the seconds that it took or None), `notes` (the
    user's words), `last_change` (ISO 8601, UTC; where an older version wrote the file, that of the file) and
    `warnings` (photographs that are missing, doubts about the material).
    Raises InputError where this is not a project.
    """
    opened = read(path)
    files = photographs(opened.current)
    missing = [file for file in files_of(opened.current) if not is_file(file)]
    with connect(path) as connection:
        schema = schema_of(connection, path)
        changed = connection.execute("SELECT value FROM meta WHERE name = 'changed'").fetchone()
    written = datetime.datetime.fromtimestamp(path.stat().st_mtime, datetime.UTC)
    return {
        "schema": schema,
        "name": opened.current.name,
        "photographs": [str(file) for file in files],
        "history_steps": len(opened.steps),
        "position": opened.position,
        "missing": [str(file) for file in missing],
        "derived": list(_derive(path)),
        "notes": opened.current.notes,
        "last_change": str(changed[0]) if changed else written.isoformat(timespec="seconds"),
        "warnings": [*_describe_missing(missing, path), *_health(opened.current)],
    }


def _describe_missing(missing: Sequence[Path], project: Path) -> list[str]:
    """One sentence on the photographs of a project that are not there, none where all are."""
    if not missing:
        return []
    remedy = f"`lightarc project find {shlex.quote(str(project))} --photographs FOLDER` finds those that moved"
    return [f"{name_files(missing)} missing from {missing[0].parent}; {remedy}"]


def _health(project: Project) -> list[str]:
    """Sentences on what is doubtful about the photographs and the material of a project, each once."""
    found = project.stack.health.without(project.excluded).warnings if project.stack is not None else []
    return list(dict.fromkeys(found + (project.material.health.warnings if project.has_map else [])))


def identity(path: Path) -> dict[str, Any]:
    """Marks of a project, by which to know it and its moment again: `name`, `state`, `history_steps`.

    `state` is the hash of the document with all that it holds. Raises InputError where the project holds nothing yet.
    """
    with connect(path) as connection, explain(path):
        meta = dict(connection.execute("SELECT name, value FROM meta WHERE name IN ('name', 'current')"))
        steps = connection.execute("SELECT count(*) FROM step").fetchone()[0]
    if "current" not in meta:
        raise Damaged(path, "it has no document")
    return {"name": meta.get("name", ""), "state": meta["current"], "history_steps": steps}


def chain_of(path: Path, project: Project, steps: Sequence[HistoryStep]) -> dict[str, Any]:
    """The chain from photographs to a material, as JSON for the bundle of `project`, kept at `path`, made by `steps`.

    `photographs` (file, and where the project has marked it, bytes and hash), `material` (settings), `brdf`, `steps`
    (their words), and `notes` (the user's, where there are any). Empty where the material was not made from
    photographs here: it brings its own chain.
    """
    if project.stack is None:
        return {}
    try:
        marks = marks_of(path)
    except FileError as error:
        log.warning("the bundle names no hashes of photographs: %s", error)
        marks = {}
    files: list[dict[str, Any]] = []
    for file in photographs(project):
        mark = marks.get(in_full(file))
        known = {} if mark is None else {"bytes": mark.size, HASH: mark.hash}
        files.append({"file": printable(file), **known})
    return {
        "chain": {
            "photographs": files,
            "material": {name: getattr(project, name) for name in SETTINGS},
            "brdf": str(project.material.brdf),
            "steps": [step.text for step in steps],
            **({"notes": project.notes} if project.notes else {}),
        }
    }


def problems_of(path: Path) -> Steps[list[str]]:
    """Sentences about whatever of a project cannot be read or is not as it was written; empty for a sound one.

    These are pages of the file, states of the history, arrays and stacks beside it, and photographs that are gone or
    changed. All of it is read, by the readers that open a project. Raises InputError where it cannot be opened.
    """
    yield Step(0.0, "reading all states")
    with connect(path) as connection, explain(path):
        found = page_problems(connection)
    opened = read(path, thorough=True)
    stacks = dict[Path, None]()
    with reading(path):
        for at, step in enumerate(opened.steps):
            yield Step(0.3 * at / len(opened.steps), "reading all states")
            for state in (step.old, step.new):
                try:
                    document = opened.state(state) if isinstance(state, str) else state
                except InputError as error:
                    found.append(f"step {at + 1} ({step.text[:80]}): {error}")
                    continue
                if document.stack is not None and document.stack.folder is not None:
                    stacks[document.stack.folder] = None
    if opened.current.stack is not None and opened.current.stack.folder is not None:
        stacks[opened.current.stack.folder] = None
    for stack in stacks:
        yield Step(0.3, f"reading {stack.name}")
        try:
            yield from check_pixels(open_kept(stack, verify=True))
        except InputError as error:
            found.append(f"{stack.name} can be made again: {error}")
    found += yield from find_problems(data_folder(path))
    yield from check_arrays(path, data_folder(path))
    about = yield from check(path, files_of(opened.current), thorough=True)
    found += _describe_missing(about.missing, path)
    return found + ([describe_changed(about.changed)] if about.changed else [])


def _derive(path: Path) -> Iterator[dict[str, Any]]:
    """All that lies beside the file: arrays and stacks that the document or its history names, factors and bakes."""
    folder = data_folder(path)
    named = set[tuple[str, str]]()
    with connect(path) as connection, explain(path):
        inside = {row[0] for row in connection.execute("SELECT name FROM array")}
        for (text,) in connection.execute("SELECT text FROM value"):
            with contextlib.suppress(*DAMAGE):
                named.update(names_in(parse(text)))
    took = {each.name: each for each in list_notes(path)}
    for kind, name in sorted(named):
        if kind == "value" or name in inside or not (is_name(name) if kind == "array" else can_be_opened(Path(name))):
            continue
        place = folder / name if kind == "stack" else file_of(folder, name)
        if not place.is_relative_to(folder) or ".." in place.parts:  # a stack elsewhere is no part of the project
            continue
        seconds = took.pop(name).seconds if name in took else None
        present = is_there(place) or (kind == "array" and is_cached(name))
        yield {"kind": kind, "name": name, "bytes": size_of(place), "present": present, "seconds": seconds}
    unnoted = {place.name for kind in ("bake", "factors") for place in folder.glob(f"{kind}-*")} - set(took)
    for name in sorted(unnoted):  # the process ended between making and noting
        place = folder / name
        yield {"kind": name.partition("-")[0], "name": name, "bytes": size_of(place), "present": True, "seconds": None}
    for each in took.values():
        size, seconds = each.size_bytes if each.present else 0, each.seconds
        yield {"kind": each.kind, "name": each.name, "bytes": size, "present": each.present, "seconds": seconds}

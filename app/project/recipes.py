"""Results that the photographs of a state give again, and the settings that they were made with.

A material and maps of a surface that are out of date are made again with the settings that they were made with, which
`built_from` and `surface_from` name. These come from a file: settings that no project can have are not taken.
"""

from __future__ import annotations

import dataclasses
import json
import logging
from collections.abc import Container
from pathlib import Path
from typing import Any

import engine
from app.document.document import Project
from app.project.database import explain, reading
from app.project.declared import problem_of
from app.project.photographs import photographs
from app.project.project_file import data_folder, finder_of, parts_in, path_of, read_part
from app.project.values import DAMAGE, Absent, encode_path, name_of
from engine.capture.stack import ImageStack

log = logging.getLogger(__name__)


def as_built(project: Project) -> Project | None:
    """`project` with the stack and the settings that its material was built with; None where these are not known.

    Where the photographs were imported again since, the stack is another than that of `project`.
    """
    if len(project.built_from) < 7:
        return None
    stack, excluded, slices, tileable, scale, bits, bound, *more = project.built_from
    has_pairs = isinstance(stack, ImageStack) and stack.diffuse is not None
    settings = {
        "stack": stack,
        "excluded": excluded,
        "slices": slices,
        "tileable": tileable,
        "scale": scale,
        "exponent_bits": bits,
        "mixed": bound is not None,
        "error_bound_percent": project.error_bound_percent if bound is None else bound,
        "evened": "evened" in more,
        "part_of_light": "whole" if has_pairs and "diffuse" not in more else "diffuse",
        "representation": next((each for each in more if each not in ("evened", "diffuse")), "auto"),
    }
    before = _with_settings(project, settings)
    is_known = before is not None and before.stack is not None and before.recipe == project.built_from
    return before if is_known else None


def as_surface_made(project: Project) -> Project | None:
    """`project` with the settings that the maps of its surface were made with; None where its stack was another."""
    if project.surface_from is None or len(project.surface_from) < 2:
        return None
    _, excluded, *white = project.surface_from
    before = _with_settings(project, {"excluded": excluded, "white": white[0] if white else None})
    return before if before is not None and before.surface_recipe == project.surface_from else None


def _with_settings(project: Project, settings: dict[str, Any]) -> Project | None:
    return None if problem_of(Project, settings) else dataclasses.replace(project, **settings)


def with_origin(project: Project) -> Project:
    """`project` with the photographs that its stack was imported from and the choices for that, as the first state in
    the file tells that has this stack; as it is where none has it.

    Raises InputError where the project file cannot be read.
    """
    stack = project.stack
    if stack is None or stack.folder is None:
        return project
    path = path_of(stack.folder.parent)
    if not path.is_file():
        return project
    said = json.dumps({"stack": encode_path(stack.folder, data_folder(path))["path"]})
    with reading(path) as connection, explain(path):
        statement = "SELECT parts FROM state WHERE parts LIKE ? ORDER BY rowid LIMIT 1"
        row = connection.execute(statement, (f'%"stack":"{name_of(said.encode())}"%',)).fetchone()
    if row is None:
        return project
    finder, parts = finder_of(path), parts_in(str(row[0]), path)
    try:
        found = {name: read_part(name, parts[name], finder) for name in ("sources", "imported_with") if name in parts}
    except (Absent, *DAMAGE) as error:
        log.info("the origin of %s is not known: %s", stack.folder.name, error)
        return project
    return dataclasses.replace(project, **found) if len(found) == 2 else project


def list_remakable(project: Project, folders: Container[Path | None], gone: Container[Path] = ()) -> frozenset[str]:
    """The parts of a state that its photographs give again, bit for bit: 'stack', 'material' and 'surface'.

    `folders` are the data folders that a stack of the project may lie in, and `gone` photographs that are missing or
    changed.
    """
    stack = project.stack
    if stack is None or stack.folder is None or stack.folder.parent not in folders:
        return frozenset()
    if project.sources is None or project.imported_with is None or any(each in gone for each in photographs(project)):
        return frozenset()
    if stack.provenance.get("software") != f"lightarc {engine.__version__}":
        return frozenset()
    parts = {"stack": project, "material": as_built(project), "surface": as_surface_made(project)}
    return frozenset(name for name, before in parts.items() if before is not None and before.stack is stack)

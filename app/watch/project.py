"""The project of a capture that has just been taken: its photographs, their stack and the material.

It is what the window has after it has opened the photographs and built the material with the same choices.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from app.commands.making import mark_stack, material_of, with_material
from app.document.document import ImportChoices, Project
from app.project.photographs import photographs
from app.project.project_file import History, Writer, data_folder
from app.project.thumbnail import keep_thumbnail
from app.session import cache
from engine.capture.lights.sources import Sources
from engine.core.steps import Step, Steps, part, without_partials
from engine.storage.atomic import make_folder


def choose_path_ahead(otherwise: Path) -> Path:
    """The path beside which lights are written before a stack is imported for a project: in the cache, where its pixels
    will be, or `otherwise`."""
    return cache.entry("ahead") or otherwise


def write_project(path: Path, sources: Sources, choices: ImportChoices) -> Steps[Project]:
    """Import `sources` by `choices`, build the material, and write both as the project `path`.

    Raises FileError for photographs that cannot be used, or where the project cannot be written.
    """
    data = make_folder(data_folder(path))
    project = Project(name=path.stem, sources=sources, import_choices=choices, imported_with=choices)
    making = mark_stack(sources, choices, (data, data), photographs(project), None)
    stack = yield from part(making, 0.0, 0.6)
    project = replace(project, stack=stack)
    material = yield from part(without_partials(material_of(project)), 0.6, 0.95)
    project = with_material(project, stack, material)
    yield Step(0.95, "writing the project")
    writer = Writer(path)
    writer.write(History(project))
    writer.close()
    yield from part(keep_thumbnail(path, project), 0.97, 1.0)
    return project

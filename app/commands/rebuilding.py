"""Results that a project had and that are gone from its data, made again of its photographs, bit for bit.

A document says what it had: a material that was built of its stack and lacks its maps, and surface maps of which only
the origin is there. What is made again, with the settings that it was made with, takes their place without a step in
the history.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from app.commands.making import material_of, prepare_to_draw
from app.commands.surface import surface_of
from app.document.document import Project
from app.project.arrays import keep_working_copy
from app.project.project_file import Opened, data_folder, read
from app.project.recipes import as_built, as_surface_made, with_origin
from app.project.setup import Setup, set_up
from engine.core.errors import InputError
from engine.core.steps import Steps, drain, part
from engine.scene.material import Material

if TYPE_CHECKING:
    from engine.surface.recover import Surface


def lacks_material(project: Project) -> bool:
    """True if the material was built of photographs, and maps that were built are gone."""
    maps = (project.material.shading_map, project.material.power_law)
    if project.stack is None or project.material.directional is not None or None not in maps:
        return False
    return as_built(project) is not None


def lacks_surface(project: Project) -> bool:
    """True if surface maps were made of its stack and are gone."""
    return project.stack is not None and project.surface is None and as_surface_made(project) is not None


def material_again(project: Project) -> Steps[Material]:
    """The material of `project` with its maps as they were built, its appearance as it is."""
    before = as_built(project)
    assert before is not None
    if before.stack is not project.stack:
        before = with_origin(before)
    return prepare_to_draw((yield from material_of(before)).looking_like(project.material))


def surface_again(project: Project) -> Steps[Surface]:
    """The surface of `project` as it was made."""
    before = as_surface_made(project)
    assert before is not None
    return (yield from surface_of(before))


def rebuild(path: Path) -> Steps[Opened]:
    """Open the project at `path` with all its results; those that are gone are made again, and lie in the cache.

    Raises InputError where photographs for that are gone, or where their results are other ones than before.
    """
    opened = read(path)
    project, folder = opened.current, data_folder(path)
    if not (lacks_material(project) or lacks_surface(project)):
        return opened
    if lacks_material(project):
        material = yield from part(material_again(project), 0.0, 0.5)
        for value in (material.shading_map, material.power_law, material.directional):
            _keep_arrays(folder, value)
    if lacks_surface(project):
        _keep_arrays(folder, (yield from part(surface_again(project), 0.5, 1.0)).maps)
    opened = read(path)
    if lacks_material(opened.current) or lacks_surface(opened.current):
        raise InputError(path, "its photographs give other results than they did", "Open it and build it again")
    return opened


def set_up_whole(path: Path, aspect: float = 4.0 / 3.0) -> Setup:
    """As `app.project.setup.set_up`; results that are gone are made again first."""
    if read(path).missing:
        drain(rebuild(path))
    return set_up(path, aspect)


def _keep_arrays(folder: Path, value: object) -> None:
    """Keep the arrays of a value and of its parts."""
    if isinstance(value, np.ndarray):
        keep_working_copy(folder, value)
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        for each in dataclasses.fields(value):
            _keep_arrays(folder, getattr(value, each.name))

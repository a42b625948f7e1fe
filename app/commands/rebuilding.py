"""Results that a project had and that are gone from its data, made again of its photographs, bit for bit.

A document says what it had: a material whose recipe is the one of the settings but which lacks its maps, and surface
maps of which only the origin is there. What is made again takes their place without a step in the history.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np

from app.commands.making import material_of, prepare_to_draw
from app.commands.surface import surface_of
from app.document.document import Project
from app.project.arrays import keep_working_copy
from app.project.project_file import Opened, data_folder, read
from app.project.setup import Setup, set_up
from engine.core.errors import InputError
from engine.core.steps import Steps, drain, part
from engine.scene.material import Material


def lacks_material(project: Project) -> bool:
    """True if the material was built by these settings, and maps that were built are gone."""
    maps = (project.material.shading_map, project.material.power_law)
    if project.stack is None or project.material.directional is not None or None not in maps:
        return False
    return bool(project.built_from) and project.built_from == project.recipe


def lacks_surface(project: Project) -> bool:
    """True if surface maps were made by these settings and are gone."""
    has_origin = project.surface_from is not None and project.surface_from == project.surface_recipe
    return project.stack is not None and project.surface is None and has_origin


def material_again(project: Project) -> Steps[Material]:
    """The material of `project` with its maps, its appearance as it is."""
    return prepare_to_draw((yield from material_of(project)).looking_like(project.material))


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
        _keep_arrays(folder, (yield from part(surface_of(project), 0.5, 1.0)).maps)
    opened = read(path)
    if lacks_material(opened.current) or lacks_surface(opened.current):
        raise InputError(path, "its photographs give other results than they did", "Open it and build it again")
    return opened


def set_up_whole(path: Path, aspect: float = 4.0 / 3.0) -> Setup:
    """As `app.project.setup.set_up`; results that are gone are made again first."""
    if read(path).missing:
        drain(rebuild(path))
    return set_up(path, aspect)


def _keep_arrays(folder: Path, value: Any) -> None:
    """Keep the arrays of a value and of its parts."""
    if isinstance(value, np.ndarray):
        keep_working_copy(folder, value)
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        for each in dataclasses.fields(value):
            _keep_arrays(folder, getattr(value, each.name))

"""A project as the command line works on it: the scene and the mode that a user set up in the window.

The scene is complete or there is none: where data beside the file are gone, an image of what is left would be another.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from app.document.document import Project
from app.document.modes import mode_of
from app.document.scene import DEFAULT_MODEL, scene_of_project
from app.project.project_file import ENDING, data_folder, read
from engine.core.errors import InputError
from engine.geometry.shapes import frame_mesh, shape
from engine.scene.scene import Scene

#: Parts that a scene is made of, and what a user calls them.
PARTS = {
    "mesh": "model",
    "environment": "light",
    "material": "material",
    "shading_map": "shading map",
    "power_law": "power law",
    "directional": "directional map",
    "measured": "measured BRDF",
}


@dataclass(frozen=True, eq=False)
class Setup:
    """The project of a file, its scene, and the mode that it is drawn in (`app.document.modes`)."""

    path: Path
    project: Project
    scene: Scene
    mode: str


def is_project(path: str | Path) -> bool:
    """True for a path that is called as projects are."""
    return str(path).lower().endswith(ENDING)


def set_up(path: Path, aspect: float = 4.0 / 3.0) -> Setup:
    """The scene that a user set up in the project at `path`; a model that nobody moved is framed for
    `aspect` (width over height).

    Raises InputError where this is not a project, or data are gone that the scene needs.
    """
    opened = read(path)
    gone = [words for part, words in PARTS.items() if part in opened.missing]
    if gone:
        place = data_folder(path).name
        remedy = f"Open the project in the window and make it again, or bring back {place}"
        raise InputError(path, f"has lost its {' and '.join(gone)} with its data folder", remedy)
    project = opened.current
    mesh = project.mesh or shape(DEFAULT_MODEL)
    camera = project.camera or frame_mesh(mesh, aspect)
    scene = scene_of_project(project, mesh, project.material.reflectance, camera)
    return Setup(path, project, scene, mode_of(project.look.mode, project).value)

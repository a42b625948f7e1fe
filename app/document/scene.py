"""The scene of a project: everything that a user set up in the View workspace, as one value.

The window puts in the BRDF in the form that it draws and its own camera; the command line takes the project's.
"""

from __future__ import annotations

from math import radians
from typing import TYPE_CHECKING

from engine.scene.scene import Scene

if TYPE_CHECKING:
    from app.document.document import Project
    from engine.brdf.brdf import Brdf
    from engine.geometry.camera import Camera
    from engine.geometry.mesh import Mesh

#: The model that a project without one is shown on, by its name.
DEFAULT_MODEL = "cloth"


def scene_of_project(project: Project, mesh: Mesh, brdf: Brdf, camera: Camera) -> Scene:
    """The material of `project` on `mesh` under its light, seen from `camera`.

    `mesh` is the project's, or the model of those without one; `brdf` its reflectance, in the form that is drawn.
    """
    look = project.look
    one = 0.0 if look.only_lamps else look.irradiance
    return Scene(
        mesh=mesh,
        camera=camera,
        brdf=brdf,
        material=project.material if project.has_map else None,
        light=tuple(look.light),
        irradiance=one if project.environment is None else look.gain,
        environment=project.environment,
        environment_rotation=radians(look.rotation_deg),
        directions=look.directions,
        source=look.source,
        lookup=look.lookup,
        above=look.above,
        repeats=look.repeats,
        tiling_mode=look.tiling_mode,
        lamps=tuple(settings.lamp for settings in look.lamps),
        near_lamps=tuple(settings.lamp for settings in look.near_lamps),
        ground=look.ground,
    )

"""Models and environments as the window opens them, in jobs: by a built-in name, or from a file.

Models come with the tangents, environments with the tree of lights, that drawing would otherwise wait for.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from engine.core.steps import Step, Steps
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import open_mesh
from engine.light.environment import EnvironmentMap, reduce
from engine.light.light_tree import CELL_ROWS, choose_lights
from engine.light.sky import SKIES, make_built_in


def load_shape(name_or_path: str) -> Steps[Mesh]:
    """A built-in model or the mesh in a file, with the tangents that drawing would otherwise wait for."""
    yield Step(0.0, f"loading {Path(name_or_path).name}")
    mesh = open_mesh(name_or_path)
    yield Step(0.9, "finding its tangents")
    mesh.tangents.flags.writeable = False
    return mesh


def load_environment(name_or_path: str) -> Steps[EnvironmentMap]:
    """The map no larger than directions need, and its tree of lights, so that another number of them costs nothing."""
    yield Step(0.0, "reading the environment")
    from engine.light.environment_file import open_environment

    if name_or_path in SKIES:
        return _open_built_in(name_or_path)
    environment = open_environment(name_or_path)
    yield Step(0.7, "choosing directions")
    return _with_lights(environment)


@lru_cache(maxsize=len(SKIES))
def _open_built_in(name: str) -> EnvironmentMap:
    """One object for each, so that the steps of a history that name it share its texels."""
    return _with_lights(make_built_in(name))


def _with_lights(environment: EnvironmentMap) -> EnvironmentMap:
    small = reduce(environment, 2 * CELL_ROWS)
    choose_lights(small, 1)
    return small

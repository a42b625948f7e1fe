"""A project file in place of a model: the scene that a user set up there is what the verbs of transport work on.

Model, ground and material are the project's, and options that contradict them are refused. Light, look-up and camera
may be given anew, so that a batch goes on from what a user set up.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.commands.rebuilding import set_up_whole
from app.document.modes import mode_named
from app.document.variation import as_baked, select_shown, settings_with, words_on_left_out
from app.project.setup import is_project
from engine.core.errors import UsageError
from engine.geometry.camera import parse
from engine.light.environment_file import open_environment
from engine.scene.scene import direction_of
from engine.scene.settings import DEFAULTS as scene_defaults

if TYPE_CHECKING:
    from app.project.setup import Setup
    from engine.scene.scene import Scene, direction_of
    from engine.transport.method import Method, Subject

#: Options that a project decides.
DECIDED = ("material", "brdf", "ground", "vary", "orient")

#: Options for parts of a scene, as they are called there.
PARTS = {
    **{name: name for name in ("directions", "source", "lookup", "above", "tiling_mode")},
    "tile": "repeats",
}


def is_given(arguments: argparse.Namespace) -> bool:
    """True where a project is in the place of the model."""
    return is_project(arguments.mesh)


def setup_of(arguments: argparse.Namespace) -> Setup:
    """The project in the place of the model, with the light, the look-up and the camera that the options give anew."""
    for name in DECIDED:
        if getattr(arguments, name, None):
            raise UsageError(f"--{name} is part of the project; change it there")
    size = getattr(arguments, "width", None), getattr(arguments, "height", None)
    aspect = size[0] / size[1] if size[0] and size[1] else 4.0 / 3.0
    setup = set_up_whole(Path(arguments.mesh), aspect)
    return replace(setup, scene=_with_options(setup.scene, arguments))


def list_left_out(setup: Setup, mode: str) -> list[str]:
    """Sentences on what an image or a bake of a project leaves out in a mode."""
    words = words_on_left_out(mode_named(mode).label, mode, setup.scene.brdf, setup.project.variations)
    return [words] if words else []


def vary(
    arguments: argparse.Namespace, method: Method, subject: Subject, settings: Any
) -> tuple[Subject, Any, list[str]]:
    """Subject and settings of a bake with what varies over the model of the project, and what is left out of that."""
    setup = setup_of(arguments)
    shown = select_shown(method, subject.brdf, setup.project.variations)
    with_variations = replace(subject, variations=as_baked(shown))
    return with_variations, settings_with(settings, shown), list_left_out(setup, method.name)


def _with_options(scene: Scene, arguments: argparse.Namespace) -> Scene:
    parts: dict[str, Any] = {"camera": parse(getattr(arguments, "camera", None) or "", scene.camera)}
    parts |= _light(arguments)
    if (intensity := getattr(arguments, "intensity", None)) is not None:
        parts["irradiance"] = intensity
    if (turn_deg := getattr(arguments, "env_rotation_deg", None)) is not None:
        parts["environment_rotation"] = math.radians(turn_deg)
    if (brushing := getattr(arguments, "brushing", None)) is not None:
        parts["mesh"] = scene.mesh.brush(brushing)
    for option, part in PARTS.items():
        if (value := getattr(arguments, option, None)) is not None:
            parts[part] = value
    return replace(scene, **parts)


def _light(arguments: argparse.Namespace) -> dict[str, Any]:
    """The light in place of the project's, all of it; nothing where no option names one."""
    light_deg, lamps = getattr(arguments, "light_deg", None), tuple(getattr(arguments, "lamp", ()))
    path, near_lamps = getattr(arguments, "env", None), tuple(getattr(arguments, "near_lamp", ()))
    if light_deg is None and not (lamps or near_lamps) and path is None:
        return {}
    only_lamps = light_deg is None and path is None
    return {
        "light": direction_of(light_deg),
        "irradiance": 0.0 if only_lamps else scene_defaults.irradiance,
        "environment": open_environment(path) if path is not None else None,
        "environment_rotation": 0.0,
        "lamps": lamps,
        "near_lamps": near_lamps,
    }


def check_model(arguments: argparse.Namespace) -> None:
    """Wrong usage where a model comes without what a project brings: one reflectance, and an environment."""
    if (arguments.brdf is None) == (arguments.material is None):
        raise UsageError("a model needs either --brdf or --material; a project brings its own")
    if arguments.env is None:
        raise UsageError("a model needs --env; a project brings its own light")


def with_defaults(arguments: argparse.Namespace, defaults: dict[str, Any]) -> None:
    """Fill in what was left out, where there is no project that says it."""
    for name, value in defaults.items():
        if getattr(arguments, name) is None:
            setattr(arguments, name, value)


def needs_environment(scene: Scene, verb: str) -> Any:
    """The environment of a scene; wrong usage where one light is all that it has."""
    if scene.environment is None:
        raise UsageError(
            f"{verb} is for an environment, and the project has none: choose one in the View workspace, or give --env"
        )
    return scene.environment

"""`lightarc render --mode auto`: the plan of a single image, and the mode without a bake that it calls for."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from app.cli.transport.plan import add_budget, plan_for, record
from engine.core.errors import UsageError
from engine.core.steps import Step
from engine.planning.plan import brdf_of
from engine.scene.mode import DIRECT, REFERENCE, is_traced

if TYPE_CHECKING:
    from engine.scene.scene import Scene

#: The modes that need no bake.
MODES = (DIRECT.name, REFERENCE.name)

#: Options of the budget.
BUDGET = ("error", "time_ms", "max_memory_mb", "max_bake_s", "max_frame_ms", "force", "skip")


def add_arguments(parser: argparse.ArgumentParser | argparse._ArgumentGroup) -> None:
    add_budget(parser)


def check(arguments: argparse.Namespace) -> None:
    """UsageError for what a plan has no room for, and for a budget without --mode auto."""
    if arguments.mode != "auto":
        given = [name for name in BUDGET if getattr(arguments, name)]
        if given:
            raise UsageError(f"--{given[0].replace('_', '-')} needs --mode auto")
        return
    if not arguments.env or arguments.lamp or arguments.near_lamp:
        raise UsageError("--mode auto needs --env, the light that the plan is for, and no --lamp or --near-lamp")
    if arguments.material:
        raise UsageError("--mode auto is for a --brdf, not for a --material")
    if arguments.samples is not None or arguments.max_depth != 1:
        raise UsageError("--mode auto chooses --samples and --max-depth itself")


def plan(
    scene: Scene, arguments: argparse.Namespace, show: Callable[[Step], None]
) -> tuple[Scene, argparse.Namespace, dict[str, Any]]:
    """The scene and the arguments as the plan has them, and its record."""
    found = plan_for(
        arguments,
        scene.mesh,
        scene.brdf,
        scene.environment,
        show,
        modes=MODES,
        ground=scene.ground,
        rotation=scene.environment_rotation,
        camera=scene.camera,
        pixels=arguments.width * arguments.height,
        frames=1,
    )
    spent: dict[str, Any] = {"mode": found.mode, **dict.fromkeys(BUDGET), "force": [], "skip": []}
    chosen = argparse.Namespace(**{**vars(arguments), **spent})
    if is_traced(found.mode):
        chosen.samples, chosen.max_depth = found.setting["samples"], found.max_depth
    else:
        chosen.directions = found.setting["directions"]
    left_out = [f"No {effect.effect}: {effect.reason}" for effect in found.effects if not effect.on]
    drawn = replace(scene, brdf=brdf_of(found, scene.brdf), directions=chosen.directions, shadows=found.casts_shadows)
    return drawn, chosen, {**record(found), "skipped": left_out}

"""`lightarc bake --mode auto`: what the plan of a scene calls for (`lightarc plan`), and nothing else."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from app.arguments.results import Input
from app.cli.doubts import doubts_of_brdf, doubts_of_light
from app.cli.transport import project_input
from app.cli.transport.bake_report import UNCHECKED, carry_out, subject_of
from app.cli.transport.options import variations_of
from app.cli.transport.plan import add_budget, plan_for, record, why_not_satisfied
from app.session.machine_profile import learn
from engine.accuracy.bake_check import check_file
from engine.core.errors import UsageError
from engine.core.figure_text import percent, percent_range
from engine.core.steps import Step, Steps, drain, part
from engine.core.stopwatch import read_clock
from engine.geometry.camera import frame
from engine.light.environment_file import open_environment
from engine.planning.bake import prepare
from engine.planning.costs.setting import Setting, parameters_of
from engine.planning.plan import SHOWN
from engine.transport import method as transport

if TYPE_CHECKING:
    from engine.light.environment import EnvironmentMap
    from engine.planning.plan import EffectsPlan
    from engine.transport.baking.check import BakeCheck
    from engine.transport.baking.spatially_varying import Variation
    from engine.transport.method import Baked, Subject

#: Options of the methods that a plan takes too.
SHARED = ("--fine",)


def add_arguments(parser: argparse.ArgumentParser | argparse._ArgumentGroup) -> None:
    parser.add_argument(
        "--env",
        type=Input(reach="file"),
        metavar="FILE",
        help="environment that the plan is for, as for lightarc render",
    )
    add_budget(parser)


def list_given(arguments: argparse.Namespace) -> list[str]:
    """The options of this mode that were given, each as its flag."""
    parser = argparse.ArgumentParser(add_help=False)
    add_arguments(parser)
    return [action.option_strings[0] for action in parser._actions if getattr(arguments, action.dest) != action.default]


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    _check(arguments)
    subject = subject_of(arguments)
    mesh, brdf, ground = subject.mesh, subject.brdf, subject.ground
    variations = variations_of(arguments, brdf)
    if project_input.is_given(arguments):
        scene = project_input.setup_of(arguments).scene
        environment, camera = project_input.needs_environment(scene, "--mode auto"), scene.camera
    else:
        environment, camera = open_environment(arguments.env), frame(mesh.positions)
    options: dict[str, Any] = {"modes": transport.names(), "ground": ground, "variations": variations, "camera": camera}
    found = plan_for(arguments, mesh, brdf, environment, lambda step: show(step), **options)
    fine = 4 if arguments.fine is None else arguments.fine
    if found.mode in transport.names():
        transport.method_of(found.mode).check_parts(replace(subject, variations=tuple(variations)))
    more: dict[str, Any] = {"variations": variations, "fine": fine, "kept": subject.kept, "parts": subject.parts}
    preparing = prepare(found, mesh, brdf, ground, **more)
    ready = drain(part(preparing, 0.0, 0.05), show)
    planned = record(found)
    since = read_clock()
    baked, result = carry_out(
        arguments,
        show,
        ready.work,
        found.mode,
        lambda: ready.start(arguments.output),
        estimated_s=ready.estimated_s,
        parameters={**found.parameters, "chosen": found.mode, "fine": fine, "vary": arguments.vary},
        start=0.05,
        check=lambda done: _check_planned(arguments, found, done, subject, variations, environment),
    )
    result = {**result, **planned, "knobs": result["knobs"]}
    if baked is None:
        return result
    if not baked.resumed_chunks:
        learn(found.mode, found.cost.bake_s, baked.bake_s, since)
    left_out = [f"No {effect.effect}: {effect.reason}" for effect in found.effects if not effect.on]
    casts_rays = found.decision("self-shadowing") == "needed"
    left_out += [each for each in result["skipped"] if casts_rays or each == UNCHECKED]
    return {
        **result,
        "skipped": left_out,
        "warnings": [
            *mesh.health.warnings,
            *doubts_of_brdf(brdf),
            *doubts_of_light(environment),
            *(["the plan is that of one material of the model; each part is baked with its own"] * bool(subject.parts)),
            *result["warnings"],
        ],
    }


def _check_planned(
    arguments: argparse.Namespace,
    plan: EffectsPlan,
    done: Baked,
    subject: Subject,
    variations: Sequence[Variation],
    environment: EnvironmentMap,
) -> Steps[BakeCheck | None]:
    """Check a bake that follows a plan, unless the user left effects out, which the reference shows."""
    if any(effect.decision == "forced off" for effect in plan.effects):
        return None
    method = transport.method_of(plan.mode)
    settings = method.with_values(plan.setting.parameters)
    whole = replace(subject, variations=variations)
    return (yield from check_file(arguments.output, done.transport, method, whole, settings, [environment]))


def lines(result: dict[str, Any]) -> list[str]:
    """The lines of the summary that only `--mode auto` adds: the chosen method, its errors, the effects left out."""
    shown = [effect["effect"] for effect in result["effects"] if effect["decision"] in SHOWN]
    setting = Setting(
        result["mode"], {name: result["knobs"][name] for name in result["knobs"] if name in _names(result)}
    )
    error = f"about {percent(result['predicted_error_rel'])} ({percent_range(*result['error_interval_rel'])})"
    found = [f"{setting}: with {', '.join(shown) or 'no effect'}, an error of {error}"]
    return found if result["satisfied"] else [*found, why_not_satisfied(result)]


def _names(result: dict[str, Any]) -> set[str]:
    return set(parameters_of(result["mode"]))


def _check(arguments: argparse.Namespace) -> None:
    if arguments.env is None and not project_input.is_given(arguments):
        raise UsageError("--mode auto needs --env, the light that the plan is for")
    for option in ("error_env", "cluster"):
        if getattr(arguments, option):
            raise UsageError(f"--{option.replace('_', '-')} is not for --mode auto")

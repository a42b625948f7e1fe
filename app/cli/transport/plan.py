"""`lightarc plan`: which effects a scene calls for, and the mode and parameters that show them within a budget."""

from __future__ import annotations

import argparse
import math
import textwrap
from collections.abc import Callable
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from app.arguments.options import add_search
from app.arguments.quantities import MEGABYTES, MILLISECONDS, SECONDS, share
from app.arguments.results import Input
from app.cli.brdf import BRDF_HELP
from app.cli.doubts import doubts_of_scene
from app.cli.transport import options as vary
from app.cli.transport import plan_cluster, project_input, scene_options
from app.session import machine_profile
from engine.core.errors import UsageError
from engine.core.figure_text import number, percent, percent_range, size_text, time_text
from engine.core.steps import Step, drain, part
from engine.planning.ceilings import usual
from engine.planning.costs.setting import Setting, setting_of
from engine.planning.plan import check_effects, plan
from engine.scene.mode import is_traced
from engine.scene.settings import DEFAULTS as scene_defaults

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf
    from engine.geometry.mesh import Mesh
    from engine.light.environment import EnvironmentMap
    from engine.planning.ceilings import Ceilings
    from engine.planning.plan import Alternative, Beyond, EffectsPlan

EXAMPLE = "lightarc plan torus-knot --brdf ggx:alpha=0.3 --env studio --error 0.02"

#: Pixels of an image that frames are predicted for.
WIDTH, HEIGHT = 960, 540

#: Images that a bake is spread over (`engine.planning.choices.FRAMES`).
FRAMES = 20_000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    scene_options.add_mesh(parser)
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--brdf", type=Input(), metavar="TEXT", help=BRDF_HELP)
    what.add_argument("--material", type=Input(), metavar="MATERIAL", help=scene_options.MATERIAL_HELP)
    add_search(parser)
    scene_options.add_surroundings(parser)
    add_budget(parser)
    vary.add_argument(parser)
    parser.add_argument("--width", type=int, default=WIDTH, metavar="PX", help=f"width of the images ({WIDTH})")
    parser.add_argument("--height", type=int, default=HEIGHT, metavar="PX", help=f"height of the images ({HEIGHT})")
    parser.add_argument(
        "--calibrate",
        action="store_true",
        help="measure the machine profile again: some ten seconds, more while other programs work or kernels are being "
        "compiled; kept for a month, unless Lightarc, Python or the machine's name changes",
    )
    parser.add_argument(
        "--frames",
        type=int,
        default=FRAMES,
        metavar="N",
        help=f"number of images drawn with one bake; 1: a single image ({FRAMES})",
    )
    plan_cluster.add_arguments(parser.add_argument_group("bakes on a cluster"))


def add_budget(parser: argparse.ArgumentParser | argparse._ArgumentGroup) -> None:
    """The budget and the wishes, which `lightarc bake --mode auto` shares."""
    budget = parser.add_mutually_exclusive_group()
    budget.add_argument("--error", type=share, metavar="E", help="allowed relative error (0.01)")
    budget.add_argument("--time-ms", type=MILLISECONDS, metavar="MS", help="allowed time of a frame")
    parser.add_argument(
        "--max-memory-mb",
        type=MEGABYTES,
        metavar="MB",
        help="memory that a setting may take (a quarter of the free)",
    )
    parser.add_argument("--max-bake-s", type=SECONDS, metavar="S", help="time that a bake may take (600)")
    parser.add_argument("--max-frame-ms", type=MILLISECONDS, metavar="MS", help="time that a frame may take (100)")
    parser.add_argument(
        "--force",
        type=str,
        action="append",
        default=[],
        metavar="EFFECT",
        help="compute an effect even if it adds nothing",
    )
    parser.add_argument(
        "--skip",
        type=str,
        action="append",
        default=[],
        metavar="EFFECT",
        help="leave an effect out even if the error is large",
    )


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    scene_options.take_own_material(arguments)
    _check(arguments)
    plan_cluster.check(arguments)
    scene = scene_options.scene_of(arguments, "a plan")
    mesh, brdf, environment = scene.mesh, scene.brdf, scene.environment
    options = {
        "ground": scene.ground,
        "rotation": scene.environment_rotation,
        "camera": scene.camera,
        "material": scene.material,
        "variations": vary.variations_of(arguments, brdf),
        "pixels": arguments.width * arguments.height,
        "aspect": arguments.width / arguments.height,
        "frames": arguments.frames,
    }
    found = plan_for(arguments, mesh, brdf, environment, show, anew=arguments.calibrate, **options)
    return {
        "mesh": arguments.mesh,
        "vertices": len(mesh.positions),
        "error": arguments.error if arguments.time_ms is None else None,
        "time_ms": arguments.time_ms,
        **record(found),
        **plan_cluster.record(arguments, scene, found, show),
        "warnings": doubts_of_scene(scene),
    }


def plan_for(
    arguments: argparse.Namespace,
    mesh: Mesh,
    brdf: Brdf,
    environment: EnvironmentMap | None,
    show: Callable[[Step], None],
    *,
    anew: bool = False,
    **options: Any,
) -> EffectsPlan:
    """The plan for the budget, the ceilings and the wishes of `arguments`; wrong usage where they cannot be."""
    assert environment is not None, "a scene that is planned has one"
    check_effects(arguments.force, arguments.skip)
    options["ceilings"] = ceilings_of(arguments)
    model = drain(part(machine_profile.cost_model(anew=anew), 0.0, 0.8), show)
    show(Step(0.9, "analysing the scene"))
    budget = {"error": arguments.error, "time_ms": arguments.time_ms}
    return plan(mesh, brdf, environment, cost=model, force=arguments.force, skip=arguments.skip, **budget, **options)


def ceilings_of(arguments: argparse.Namespace) -> Ceilings:
    """The usual ceilings, with those that were given in their place."""
    names = ("max_memory_mb", "max_bake_s", "max_frame_ms")
    for name in names:
        value = getattr(arguments, name)
        if value is not None and not 0.0 < value < math.inf:
            raise UsageError(f"--{name.replace('_', '-')} {value} is not above 0")
    memory_mb, bake_s, frame_ms = (getattr(arguments, name) for name in names)
    return usual(
        memory_bytes=None if memory_mb is None else 1e6 * memory_mb,
        bake_s=bake_s,
        frame_s=None if frame_ms is None else 1e-3 * frame_ms,
    )


def record(found: EffectsPlan) -> dict[str, Any]:
    """The plan as a JSON object."""
    return {
        "effects": [asdict(effect) for effect in found.effects],
        "mode": found.mode,
        "max_depth": found.max_depth if is_traced(found.mode) else None,
        "knobs": found.parameters,
        "means": dict(found.mean),
        "predicted_error_rel": found.predicted_error_rel,
        "error_interval_rel": list(found.error_interval_rel),
        "probability_within_budget": found.probability,
        "predicted_frame_s": found.cost.frame_s,
        "predicted_relight_s": found.cost.relight_s,
        "predicted_bake_s": found.cost.bake_s,
        "predicted_another_brdf_s": found.cost.another_s,
        "predicted_memory_bytes": found.cost.memory_bytes,
        "predicted_size_bytes": found.cost.size_bytes,
        "times_within_factor": found.times_within,
        "satisfied": found.satisfied,
        "ceilings": asdict(found.ceilings),
        "exceeded": list(found.exceeded),
        "beyond": _beyond_record(found.beyond),
        "alternatives": [_alternative_record(each) for each in found.alternatives],
        "excluded": {effect: list(names) for effect, names in found.excluded.items()},
        "free_vertices_share": found.unoccluded_fraction,
    }


def _beyond_record(beyond: Beyond | None) -> dict[str, Any] | None:
    """The setting that would meet the budget beyond the ceilings, as JSON."""
    if beyond is None:
        return None
    predicted = {"max_depth": beyond.max_depth, "error_rel": beyond.error_rel, "exceeded": list(beyond.exceeded)}
    return {**beyond.setting.as_json(), **predicted, **asdict(beyond.cost)}


def _alternative_record(found: Alternative) -> dict[str, Any]:
    """The choice of a slower or a faster machine, as JSON."""
    facts = {"times": "longer" if found.slower else "shorter", "ceilings": list(found.ceilings)}
    predicted = {"error_rel": found.error_rel, "satisfied": found.satisfied}
    return {**found.setting.as_json(), **facts, **predicted, **asdict(found.cost)}


def report(result: dict[str, Any]) -> str:
    lines = [f"{'effect':24} {'decision':10} {'without it':>10} {'saves':>10} {'':>10}"]
    for effect in result["effects"]:
        saves = time_text(effect["saves_s"]) if effect["saves_s"] >= 0.05 else "–"
        size = size_text(effect["saves_bytes"]) if effect["saves_bytes"] >= 50_000 else "–"
        error = percent(effect["estimated_error_rel"])
        lines.append(f"{effect['effect']:24} {effect['decision']:10} {error:>10} {saves:>10} {size:>10}")
        lines += textwrap.wrap(effect["reason"], 100, initial_indent="    ", subsequent_indent="    ")
    setting = Setting(result["mode"], result["knobs"])
    lines += [
        "",
        f"Draw with {setting}: an error of {percent(result['predicted_error_rel'])} "
        f"({percent_range(*result['error_interval_rel'])} in 95 of 100 scenes), {_probability(result)}"
        f"{time_text(result['predicted_frame_s'])} a frame, "
        f"{time_text(result['predicted_relight_s'])} for a rotated environment, "
        f"{time_text(result['predicted_bake_s'])} to bake{_price_another(result)}, "
        f"{size_text(result['predicted_size_bytes'])} "
        f"(times within a factor of {number(result['times_within_factor'])})",
    ]
    return "\n".join(
        [
            *lines,
            *_ceilings(result),
            *_list_exclusions(result),
            *_alternatives(result),
            *_shortfall(result),
            *plan_cluster.lines(result),
        ]
    )


def _price_another(result: dict[str, Any]) -> str:
    """Return ' (another BRDF afterwards: 1.8 s)' for a mode that is baked for one; its visibility is kept."""
    another_s = result.get("predicted_another_brdf_s")
    return "" if another_s is None else f" (another BRDF afterwards: {time_text(another_s)})"


def _probability(result: dict[str, Any]) -> str:
    """The probability of meeting a budget of error, with what follows it; nothing for a budget of time."""
    probability = result["probability_within_budget"]
    return "" if probability is None else f"within the budget with a probability of {percent(probability)}, "


#: Ceilings as users read them: what is limited, the flag that raises it, and units in a second or a byte.
CEILINGS = {
    "memory_bytes": ("memory", "--max-memory-mb", 1e-6),
    "bake_s": ("the bake", "--max-bake-s", 1.0),
    "frame_s": ("a frame", "--max-frame-ms", 1e3),
}


def _ceilings(result: dict[str, Any]) -> list[str]:
    """The ceilings that the choice keeps below, or is beyond because everything is."""
    limits = result["ceilings"]
    words = (
        f"{size_text(limits['memory_bytes'])} of memory, {number(limits['bake_s'], 4)} s of bake and "
        f"{number(1e3 * limits['frame_s'], 4)} ms a frame"
    )
    if result["exceeded"]:
        what = " and ".join(CEILINGS[name][0] for name in result["exceeded"])
        return [f"Every mode is beyond the ceilings of {words}; this one by {what}."]
    return [f"Ceilings: {words} ({', '.join(flag for _, flag, _ in CEILINGS.values())})."]


def _list_exclusions(result: dict[str, Any]) -> list[str]:
    """A sentence for each effect that a ceiling keeps out though it is worth more than the budget."""
    return [
        f"{effect.capitalize()} is left out because every mode that shows it exceeds the ceiling of "
        f"{' and '.join(CEILINGS[name][0] for name in names)} ({', '.join(CEILINGS[name][1] for name in names)})."
        for effect, names in result["excluded"].items()
    ]


def _alternatives(result: dict[str, Any]) -> list[str]:
    """A sentence for each choice that a time near a ceiling would change."""
    return [
        f"The time of {' and '.join(CEILINGS[name][0] for name in each['ceilings'])} is near its ceiling: "
        f"if times turn out {each['times']}, draw with {setting_of(each)}: {percent(each['error_rel'])}, "
        f"{time_text(each['frame_s'])} a frame, {time_text(each['bake_s'])} to bake."
        for each in result["alternatives"]
    ]


def _shortfall(result: dict[str, Any]) -> list[str]:
    """The sentences about a budget that is not met: by how much, and which setting would meet it."""
    if result["satisfied"]:
        return []
    if result.get("time_ms") is not None:
        return [f"No mode draws a frame in {number(result['time_ms'], 3)} ms; this is the quickest."]
    return [why_not_satisfied(result), *_beyond(result["beyond"])]


def why_not_satisfied(result: dict[str, Any]) -> str:
    """Return the sentence on a budget that is not met: its setting is likely to meet it, or the best for its cost."""
    if (result["probability_within_budget"] or 0.0) >= 0.5:
        return "No mode below the ceilings is certain to meet the budget; this one is likely to."
    return "No mode meets the budget below the ceilings; this one has the least error for what it costs."


def _beyond(beyond: dict[str, Any] | None) -> list[str]:
    """The setting that would meet the budget, and the flags that allow it."""
    if beyond is None:
        return []
    error = percent(beyond["error_rel"])
    if is_traced(beyond["mode"]):
        seconds, samples = beyond["frame_s"], beyond["knobs"]["samples"]
        return [
            f"The reference meets it with {samples:,} paths for each pixel, in about {time_text(seconds)} an image: "
            f"lightarc render --mode reference --samples {samples} --max-depth {beyond['max_depth']}."
        ]
    flags = (_raise_error(beyond, name) for name in beyond["exceeded"])
    return [
        f"With {' '.join(flags)} {setting_of(beyond)} meets it: {error}, {time_text(beyond['frame_s'])} a frame, "
        f"{time_text(beyond['bake_s'])} to bake, {size_text(beyond['memory_bytes'])} of memory."
    ]


def _raise_error(beyond: dict[str, Any], name: str) -> str:
    """'--max-bake-s 1600': the flag that allows what a setting takes, rounded up to two digits."""
    value = beyond[name] * CEILINGS[name][2]
    step = 10.0 ** (math.floor(math.log10(value)) - 1)
    return f"{CEILINGS[name][1]} {math.ceil(value / step) * step:.12g}"


def _check(arguments: argparse.Namespace) -> None:
    for name in ("error", "time_ms"):
        value = getattr(arguments, name)
        if value is not None and not 0.0 < value < math.inf:
            raise UsageError(f"--{name.replace('_', '-')} {value} is not above 0")
    if not project_input.is_given(arguments):
        project_input.check_model(arguments)
        rotation = scene_defaults.environment_rotation_deg
        project_input.with_defaults(arguments, {"env_rotation_deg": rotation})
    if arguments.frames < 1:
        raise UsageError(f"--frames {arguments.frames} is below 1")
    if not math.isfinite(arguments.env_rotation_deg or 0.0):
        raise UsageError(f"--env-rotation-deg {arguments.env_rotation_deg} is not finite")
    if not (1 <= arguments.width <= 1 << 15 and 1 <= arguments.height <= 1 << 15):
        raise UsageError(f"images of {arguments.width} × {arguments.height} pixels are not possible")

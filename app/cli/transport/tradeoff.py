"""`lightarc tradeoff`: what accuracy costs on one scene: settings of all modes, measured against one reference."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.arguments.options import add_search, refuse_unused
from app.arguments.quantities import SECONDS
from app.arguments.results import Input, Output, sweep_in
from app.arguments.usage import CANCELLED, DONE
from app.cli.brdf import BRDF_HELP
from app.cli.doubts import doubts_of_scene
from app.cli.transport import project_input, scene_options
from app.process import ending
from app.session import machine_profile
from engine.brdf.brdf import MODELS
from engine.core.errors import UsageError
from engine.core.figure_text import number, percent, percent_range, percent_within, size_text, time_text
from engine.core.steps import Step, drain, part
from engine.core.stopwatch import read_clock
from engine.core.suggestion import suggest
from engine.planning.ceilings import usual
from engine.planning.costs.setting import modes, setting_of
from engine.planning.costs.setting import modes as all_modes
from engine.planning.plan import plan
from engine.scene.mode import MODES
from engine.storage.atomic import make_folder
from engine.tradeoff.agenda import modes_of, settings_of
from engine.tradeoff.front import budget_from_text, choose
from engine.transport import method as transport

if TYPE_CHECKING:
    from engine.planning.costs.cost_model import CostModel
    from engine.planning.costs.setting import Setting
    from engine.planning.plan import EffectsPlan
    from engine.scene.scene import Scene
    from engine.tradeoff.front import Budget
    from engine.tradeoff.sweep import Tradeoff

EXAMPLE = "lightarc tradeoff torus-knot --brdf ggx:alpha=0.3 --env studio --budget-s 60 -o tradeoff"

#: Seconds that are measured unless something else is said, and the most of them.
BUDGET_S, MAX_S = 480.0, 86_400.0

#: Settings without a measurement that are named, and after which there are only how many.
NAMED = 12

#: Most pixels: images of all settings are kept until the end.
MAX_PIXELS = 1 << 20

#: Sub-pixels of each pixel, as images of a sweep are drawn.
SUBPIXELS = 4

#: Effects that every image of a sweep shows where the scene has them.
SHOWN = frozenset({"self-shadowing", "glossy", "anisotropy", "fresnel", "retro-reflection"})

AXES = ("frame", "relight", "bake", "memory")

#: Wrong predictions that are listed one by one, and the labels of the figures.
MISSES = 6
FIGURE_WORDS = {"frame_s": "frame", "relight_s": "relighting", "bake_s": "bake", "size_bytes": "file"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    scene_options.add_mesh(parser)
    parser.add_argument("--brdf", type=Input(), metavar="TEXT", help=BRDF_HELP)
    parser.add_argument("--material", type=Input(), metavar="MATERIAL", help=scene_options.MATERIAL_HELP)
    add_search(parser)
    scene_options.add_surroundings(parser)
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        type=Output(sweep_in, Path),
        metavar="FOLDER",
        help="folder for JSON, CSV and plots",
    )
    parser.add_argument(
        "--modes",
        type=str,
        nargs="+",
        metavar="MODE",
        help=f"modes: {', '.join((*transport.names(), *MODES))} (those that draw the whole scene)",
    )
    parser.add_argument(
        "--budget-s",
        type=SECONDS,
        default=BUDGET_S,
        metavar="S",
        help=f"time limit of the measurement ({BUDGET_S:.0f})",
    )
    parser.add_argument(
        "--choose",
        type=str,
        metavar="TEXT",
        help="name the best setting within '8 ms and 100 MB' (least error) or '1 %%' (least time)",
    )
    parser.add_argument("--axis", choices=AXES, help="the time that --choose compares (frame)")
    parser.add_argument("--intensity", type=float, metavar="L", help="factor on the environment (1)")
    parser.add_argument("--width", type=int, default=320, metavar="PX", help="width of the images (320)")
    parser.add_argument("--height", type=int, default=240, metavar="PX", help="height of the images (240)")
    parser.add_argument("--max-depth", type=int, default=1, metavar="D", help="largest path depth of the reference (1)")
    parser.add_argument("--tile", type=float, metavar="N", help="repeats of the material over one uv (4)")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of the reference (0)")


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    scene_options.take_own_material(arguments)
    refuse_unused(arguments, [("--axis", bool(arguments.choose), "--choose")])
    _check(arguments)
    budget = budget_from_text(arguments.choose) if arguments.choose else None
    scene = scene_options.scene_of(arguments, "a sweep")
    settings = _settings(arguments, scene)
    with _folder(arguments.output):
        return _measure(arguments, scene, settings, budget, show)


@contextmanager
def _folder(path: Path) -> Iterator[None]:
    """Make the folder before minutes are spent for what cannot be kept; where it stays empty it goes again."""
    is_new = not path.exists()
    make_folder(path)
    try:
        yield
    except BaseException:
        if is_new:
            with suppress(OSError):
                path.rmdir()
        raise


def _measure(
    arguments: argparse.Namespace,
    scene: Scene,
    settings: list[Setting],
    budget: Budget | None,
    show: Callable[[Step], None],
) -> dict[str, Any]:
    from engine.tradeoff.sweep import sweep
    from engine.tradeoff.write import write

    costs = drain(part(machine_profile.cost_model(), 0.0, 0.05), show)
    planned = _plan(arguments, scene, costs, budget)
    latest: list[Tradeoff] = []
    options = {"seconds": arguments.budget_s, "max_depth": arguments.max_depth, "seed": arguments.seed, "costs": costs}
    options["first"] = [planned.setting] if planned else []

    def keep(step: Step) -> None:
        if step.partial is not None and step.partial.points:
            latest[:] = [step.partial]
            ending.keep_work()
        show(step)

    since = read_clock()
    try:
        found = drain(sweep(scene, settings, (arguments.width, arguments.height), **options), keep)
        is_cancelled = False
    except KeyboardInterrupt:
        if not latest:
            raise
        found, is_cancelled = latest[0], True
    machine_profile.learn_from(found.points, since)
    about = {
        "mesh": arguments.mesh,
        "vertices": len(scene.mesh.positions),
        "brdf": arguments.brdf,
        "material": arguments.material,
        "env": arguments.env,
        "max_depth": arguments.max_depth,
        "cancelled": is_cancelled,
        "plan": _record_plan(planned) if planned else None,
    }
    record = drain(write(found, arguments.output, _title(arguments), **about), show)
    chosen = _choose(found, budget, arguments.axis or AXES[0])
    exit_code = CANCELLED if is_cancelled else DONE
    return {
        "output": str(arguments.output),
        **record,
        **chosen,
        "warnings": doubts_of_scene(scene),
        "exit_code": exit_code,
    }


def _plan(arguments: argparse.Namespace, scene: Scene, costs: CostModel, budget: Budget | None) -> EffectsPlan | None:
    """The plan for the same budget, with the effects that a sweep shows; None where there can be none."""
    if scene.environment is None or scene.irradiance != 1.0:
        return None
    error, time_s, room = (None, None, None) if budget is None else (budget.error, budget.time_s, budget.bytes)
    bounces = arguments.max_depth > 1
    try:
        return plan(
            scene.mesh,
            scene.brdf,
            scene.environment,
            cost=costs,
            error=error,
            time_ms=None if time_s is None or error is not None else 1e3 * time_s,
            force=SHOWN | {"interreflection"} if bounces else SHOWN,
            skip=() if bounces else ("interreflection",),
            modes=_modes(arguments) or modes(),
            ground=scene.ground,
            rotation=scene.environment_rotation,
            camera=scene.camera,
            material=scene.material,
            pixels=SUBPIXELS * arguments.width * arguments.height,
            aspect=arguments.width / arguments.height,
            ceilings=usual(memory_bytes=room, frame_s=time_s),
        )
    except UsageError:
        return None


def report(result: dict[str, Any]) -> str:
    lines = [
        f"{'':1} {'setting':46} {'error':>16} {'frame':>10} {'relight':>10} {'bake':>9} {'new BRDF':>9} {'memory':>10}"
    ]
    for point in sorted(result["points"], key=lambda point: point["frame_s"]):
        error = percent_within(point["error_rmse_rel"], point["error_uncertainty"])
        mark = "●" if point["on_front"] else " "
        lines.append(
            f"{mark} {setting_of(point)!s:46} {error:>16} {time_text(point['frame_s']):>10} "
            f"{_time(point['relight_s']):>10} {_time(point['bake_s']):>9} "
            f"{_time(point['another_brdf_s'] or 0.0):>9} {size_text(point['memory_bytes']):>10}"
        )
    if result["break_even_frames"] is not None:
        frames, name = result["break_even_frames"], setting_of(result["break_even_setting"])
        times = "frame" if frames == 1 else "frames"
        lines.append(f"Against the reference at equal error, {name} has paid off after {frames} {times}.")
    if result["baked_share"] < 1.0:
        lines.append(
            f"The images show {percent(result['baked_share'])} of the vertices; only these were baked; "
            "times are for all vertices."
        )
    lines.append(_sweeps(result["ladders"]))
    lines += _predictions(result["predictions"])
    if result["plan"]:
        chosen = result["plan"]
        predicted = f"{percent(chosen['predicted_error_rel'])} ({percent_range(*chosen['error_interval_rel'])})"
        hidden = chosen["interreflection_error_rel"]
        beside = f", of which up to {percent(hidden)} is interreflection that these images lack" if hidden else ""
        costs = f"{time_text(chosen['predicted_frame_s'])} a frame, {time_text(chosen['predicted_bake_s'])} to bake"
        certain = f"(times within a factor of {number(chosen['times_within_factor'])})"
        lines.append(f"A plan chooses {setting_of(chosen)}, with an error of {predicted}{beside}; {costs} {certain}.")
    if "choice_reason" in result:
        chosen = setting_of(result["choice"]) if result["choice"] else "none"
        lines.append(f"Choice: {chosen} ({result['choice_reason']})")
    left = [f"{setting_of(each)}: {each['reason']}{_describe_expectation(each)}" for each in result["left_out"]]
    lines += [f"Not measured: {words}" for words in left[:NAMED]]
    lines += [f"Not measured: {len(left) - NAMED} more, see tradeoff.json"] if len(left) > NAMED else []
    lines += ["Cancelled; these are the results so far."] if result["cancelled"] else []
    return "\n".join([*lines, f"{result['output']}: {', '.join(result['files'])}"])


def _describe_expectation(left_out: dict[str, Any]) -> str:
    """The extrapolated error of a setting that was not measured, where there is one."""
    if "error_rmse_rel" not in left_out:
        return ""
    error, interval = percent(left_out["error_rmse_rel"]), percent_range(*left_out["error_interval_rel"])
    return f"; extrapolated error {error} ({interval})"


def _time(seconds: float) -> str:
    """Seconds in words, a dash where there is nothing to do."""
    return time_text(seconds) if seconds > 0.0 else "–"


def _sweeps(found: list[dict[str, Any]]) -> str:
    """State that errors fall along the sweeps, or name the sweeps where they rise."""
    if not found:
        return "No two settings that were measured differ in one parameter alone, so there is no sweep."
    rising = [f"{each['mode']} {each['knob']} from {low} to {high}" for each in found for low, high in each["rises"]]
    if not rising:
        return "The error falls along every sweep."
    return f"The error falls along every sweep, but rises along {', '.join(dict.fromkeys(rising))}."


def _record_plan(planned: EffectsPlan) -> dict[str, Any]:
    """The setting that the plan chooses, with its error, and how much of it images of direct light do not show."""
    hidden = next(each for each in planned.effects if each.effect == "interreflection")
    return {
        **planned.setting.as_json(),
        "predicted_error_rel": planned.predicted_error_rel,
        "error_interval_rel": list(planned.error_interval_rel),
        "predicted_frame_s": planned.cost.frame_s,
        "predicted_bake_s": planned.cost.bake_s,
        "times_within_factor": planned.times_within,
        "interreflection_error_rel": 0.0 if hidden.on else hidden.estimated_error_rel,
    }


def _predictions(found: dict[str, Any]) -> list[str]:
    """The errors of the cost model: predicted beside measured, the worst first."""
    if not found["compared"]:
        return []
    lines = [f"{found['within']} of {found['compared']} costs were predicted within a factor of {found['factor']}."]
    for miss in found["misses"][:MISSES]:
        amount = size_text if miss["figure"].endswith("_bytes") else time_text
        predicted, measured = (amount(miss[name]) for name in ("predicted", "measured"))
        more = "more" if miss["measured"] > miss["predicted"] else "less"
        what = FIGURE_WORDS[miss["figure"]]
        lines.append(
            f"Wrong: {what} of {setting_of(miss)}: predicted {predicted}, measured {measured}, "
            f"{number(miss['factor'])} times {more}"
        )
    rest = len(found["misses"]) - MISSES
    return [*lines, f"Wrong: {rest} more, see tradeoff.json"] if rest > 0 else lines


def _check(arguments: argparse.Namespace) -> None:
    if not project_input.is_given(arguments):
        project_input.check_model(arguments)
        project_input.with_defaults(arguments, scene_options.defaults_of_options())
    if not 1.0 <= arguments.budget_s <= MAX_S:
        raise UsageError(f"--budget-s {arguments.budget_s} is outside 1 … {MAX_S:.0f}")
    width, height = arguments.width, arguments.height
    if min(width, height) < 16 or width * height > MAX_PIXELS:
        raise UsageError(f"images of {width} × {height} pixels are outside 16 × 16 … {MAX_PIXELS} pixels")
    if not 1 <= arguments.max_depth <= 100:
        raise UsageError(f"--max-depth {arguments.max_depth} is outside 1 … 100")
    if arguments.seed < 0:
        raise UsageError(f"--seed {arguments.seed} is negative")


def _modes(arguments: argparse.Namespace) -> list[str]:
    """The modes that were asked for."""
    return list(dict.fromkeys(name for text in arguments.modes or () for name in text.replace(",", " ").split()))


def _settings(arguments: argparse.Namespace, scene: Scene) -> list[Setting]:
    modes = _modes(arguments)
    strange = [mode for mode in modes if mode not in all_modes()]
    if strange:
        meant = suggest(strange[0], all_modes())
        raise UsageError(f"unknown mode {strange[0]!r}{meant}; choose from {', '.join(all_modes())}")
    if scene.material is None and (lacking := [mode for mode in modes if mode in MODES and MODES[mode].needs_map]):
        raise UsageError(f"the mode {lacking[0]} needs --material")
    return settings_of(scene, modes or modes_of(scene), bounces=arguments.max_depth > 1)


def _title(arguments: argparse.Namespace) -> str:
    if project_input.is_given(arguments):
        return Path(arguments.mesh).stem
    named = arguments.brdf or arguments.material
    what = named if named.partition(":")[0] in MODELS else Path(named).name
    return f"{Path(arguments.mesh).name}, {what}, under {Path(arguments.env).name}"


def _choose(found: Tradeoff, budget: Budget | None, axis: str) -> dict[str, Any]:
    """The best setting within the budget, and why; nothing without one."""
    if budget is None:
        return {}
    choice = choose(found.points, budget, axis)
    return {"choice": choice.point.as_json() if choice.point else None, "choice_reason": choice.reason}

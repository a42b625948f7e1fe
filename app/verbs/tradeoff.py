"""`lightarc tradeoff`: what accuracy costs on one scene: settings of all modes, measured against one reference."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app import ending
from app.results import Input, Output, sweep_in
from app.verbs.brdf import BRDF_HELP
from engine.steps import Step, drain, part
from engine.transport import method as transport

if TYPE_CHECKING:
    from engine.effects.setting import Setting
    from engine.scene import Scene
    from engine.tradeoff.choose import Budget
    from engine.tradeoff.sweep import Tradeoff

HELP = "Measure what accuracy costs: error, times and memory of many settings, and which are worth it."
EXAMPLE = "lightarc tradeoff torus-knot --brdf ggx:alpha=0.3 --env studio --budget-s 60 -o tradeoff"

#: Seconds that are measured unless something else is said, and the most of them.
BUDGET_S, MOST_S = 480.0, 86_400.0

#: Settings without a measurement that are named, and after which there are only how many.
NAMED = 12

#: Most pixels: pictures of all settings are kept until the end.
MOST_PIXELS = 1 << 20

AXES = ("frame", "relight", "bake", "memory")

#: Predictions that were off and are told one by one, and what the figures are called.
MISSES = 6
FIGURE_WORDS = {"frame_s": "frame", "relight_s": "turned light", "bake_s": "bake", "size_bytes": "file"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "mesh",
        type=Input(reach="file"),
        metavar="MESH",
        help="a file, or a built-in: sphere, plane, torus-knot, cloth, blob",
    )
    parser.add_argument("--brdf", type=Input(), metavar="TEXT", help=BRDF_HELP)
    parser.add_argument(
        "--material", type=Input(), metavar="BUNDLE", help="a material that is looked up, with its own reflectance"
    )
    parser.add_argument(
        "--env", required=True, type=Input(reach="file"), metavar="FILE", help="an environment, as for lightarc render"
    )
    parser.add_argument(
        "-o", "--output", required=True, type=Output(sweep_in, Path), metavar="FOLDER", help="for JSON, CSV and plots"
    )
    parser.add_argument(
        "--modes",
        type=str,
        nargs="+",
        metavar="MODE",
        help=f"of {', '.join(transport.names())}, shading-map, direct, reference (those that draw all of the scene)",
    )
    parser.add_argument(
        "--budget-s", type=float, default=BUDGET_S, metavar="S", help=f"measure for so long at most ({BUDGET_S:.0f})"
    )
    parser.add_argument(
        "--choose",
        type=str,
        metavar="TEXT",
        help="name the best setting within '8 ms and 100 MB' (least error) or '1 %%' (least time)",
    )
    parser.add_argument("--axis", default="frame", choices=AXES, help="the time that --choose looks at (frame)")
    parser.add_argument("--env-rotation-deg", type=float, default=0.0, metavar="A", help="turn it about +Y (0)")
    parser.add_argument("--intensity", type=float, default=1.0, metavar="L", help="factor on the environment (1)")
    parser.add_argument(
        "--ground", nargs="?", type=float, const=0.5, metavar="ALBEDO", help="let the model stand on a matt ground"
    )
    parser.add_argument(
        "--camera", type=str, metavar="TEXT", help="as for lightarc render; otherwise the model is framed"
    )
    parser.add_argument("--width", type=int, default=320, metavar="PX", help="of the pictures (320)")
    parser.add_argument("--height", type=int, default=240, metavar="PX", help="of the pictures (240)")
    parser.add_argument(
        "--max-depth", type=int, default=1, metavar="D", help="points that light of the reference may touch (1)"
    )
    parser.add_argument("--tile", type=float, default=4.0, metavar="N", help="repeats of the material over one uv (4)")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="of the reference (0)")


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    from app.cli import usage
    from engine.tradeoff.choose import budget_from_text

    usage(_check, arguments)
    budget: Budget | None = usage(budget_from_text, arguments.choose) if arguments.choose else None
    scene = _scene(arguments)
    settings = usage(_settings, arguments, scene)
    with _folder(arguments.output):
        return _measured(arguments, scene, settings, budget, show)


@contextmanager
def _folder(path: Path) -> Iterator[None]:
    """Make the folder before minutes are spent for what cannot be kept; where it stays empty it goes again."""
    from engine.files.atomic import make_folder

    is_new = not path.exists()
    make_folder(path)
    try:
        yield
    except BaseException:
        if is_new:
            with suppress(OSError):
                path.rmdir()
        raise


def _measured(
    arguments: argparse.Namespace,
    scene: Scene,
    settings: list[Setting],
    budget: Budget | None,
    show: Callable[[Step], None],
) -> dict[str, Any]:
    from app.cli import CANCELLED, DONE, usage
    from app.cost import cost_model
    from engine.tradeoff.sweep import sweep
    from engine.tradeoff.write import write

    costs = drain(part(cost_model(), 0.0, 0.05), show)
    latest: list[Tradeoff] = []
    options = {"seconds": arguments.budget_s, "max_depth": arguments.max_depth, "seed": arguments.seed, "costs": costs}

    def keep(step: Step) -> None:
        if step.partial is not None and step.partial.points:
            latest[:] = [step.partial]
            ending.keep_work()
        show(step)

    try:
        found = usage(drain, sweep(scene, settings, (arguments.width, arguments.height), **options), keep)
        is_cancelled = False
    except KeyboardInterrupt:
        if not latest:
            raise
        found, is_cancelled = latest[0], True
    about = {
        "mesh": arguments.mesh,
        "vertices": len(scene.mesh.positions),
        "brdf": arguments.brdf,
        "material": arguments.material,
        "env": arguments.env,
        "max_depth": arguments.max_depth,
        "cancelled": is_cancelled,
    }
    record = drain(write(found, arguments.output, _title(arguments), **about), show)
    chosen = _chosen(found, budget, arguments.axis)
    warnings = list(scene.mesh.health.warnings)
    exit_code = CANCELLED if is_cancelled else DONE
    return {"output": str(arguments.output), **record, **chosen, "warnings": warnings, "exit_code": exit_code}


def report(result: dict[str, Any]) -> str:
    from engine.effects.setting import setting_of

    lines = [f"{'':1} {'setting':46} {'error':>16} {'frame':>10} {'relight':>10} {'bake':>9} {'memory':>10}"]
    for point in sorted(result["points"], key=lambda point: point["frame_s"]):
        error = f"{100.0 * point['error_rmse_rel']:.2f} ± {100.0 * point['error_uncertainty']:.2f} %"
        mark = "●" if point["on_front"] else " "
        lines.append(
            f"{mark} {setting_of(point)!s:46} {error:>16} {1e3 * point['frame_s']:7.1f} ms "
            f"{1e3 * point['relight_s']:7.1f} ms {point['bake_s']:7.1f} s {point['memory_bytes'] / 1e6:7.1f} MB"
        )
    if result["break_even_frames"] is not None:
        frames, name = result["break_even_frames"], setting_of(result["break_even_setting"])
        times = "frame" if frames == 1 else "frames"
        lines.append(f"Against the reference at equal error, {name} has paid off after {frames} {times}.")
    if result["baked_share"] < 1.0:
        share = 100.0 * result["baked_share"]
        lines.append(f"The pictures show {share:.0f} % of the vertices; these were baked, and times are told for all.")
    lines.append(_ladders(result["ladders"]))
    lines += _predictions(result["predictions"])
    if "choice_reason" in result:
        chosen = setting_of(result["choice"]) if result["choice"] else "none"
        lines.append(f"Choice: {chosen} ({result['choice_reason']})")
    left = [f"{setting_of(each)}: {each['reason']}" for each in result["left_out"]]
    lines += [f"Not measured: {words}" for words in left[:NAMED]]
    lines += [f"Not measured: {len(left) - NAMED} more, see tradeoff.json"] if len(left) > NAMED else []
    lines += ["Cancelled; this is what was measured until then."] if result["cancelled"] else []
    return "\n".join([*lines, f"{result['output']}: {', '.join(result['files'])}", *result["warnings"]])


def _ladders(found: list[dict[str, Any]]) -> str:
    """Whether errors fall along the ladders, and where they do not."""
    if not found:
        return "No two settings that were measured differ in one knob alone, so no ladder can be told."
    rising = [f"{each['mode']} {each['knob']} from {low} to {high}" for each in found for low, high in each["rises"]]
    if not rising:
        return "The error falls along every ladder."
    return f"The error falls along every ladder, but rises along {', '.join(dict.fromkeys(rising))}."


def _predictions(found: dict[str, Any]) -> list[str]:
    """How often the cost model was right, and where it was not: predicted beside measured, the worst first."""
    from engine.effects.setting import setting_of

    if not found["compared"]:
        return []
    lines = [f"{found['within']} of {found['compared']} costs were predicted within a factor of {found['factor']}."]
    for miss in found["misses"][:MISSES]:
        predicted, measured = (_amount(miss["figure"], miss[name]) for name in ("predicted", "measured"))
        more = "more" if miss["measured"] > miss["predicted"] else "less"
        what = FIGURE_WORDS[miss["figure"]]
        lines.append(
            f"Off: {what} of {setting_of(miss)}: predicted {predicted}, measured {measured}, "
            f"{miss['factor']:.1f} times {more}"
        )
    rest = len(found["misses"]) - MISSES
    return [*lines, f"Off: {rest} more, see tradeoff.json"] if rest > 0 else lines


def _amount(figure: str, value: float) -> str:
    """'4.2 ms', '12 s' or '3.1 MB'."""
    if figure.endswith("_bytes"):
        return f"{value / 1e6:.3g} MB"
    return f"{1e3 * value:.3g} ms" if value < 1.0 else f"{value:.3g} s"


def _check(arguments: argparse.Namespace) -> None:
    if (arguments.brdf is None) == (arguments.material is None):
        raise ValueError("give either --brdf or --material")
    if not 1.0 <= arguments.budget_s <= MOST_S:
        raise ValueError(f"--budget-s {arguments.budget_s} is outside 1 … {MOST_S:.0f}")
    width, height = arguments.width, arguments.height
    if min(width, height) < 16 or width * height > MOST_PIXELS:
        raise ValueError(f"pictures of {width} × {height} pixels are outside 16 × 16 … {MOST_PIXELS} pixels")
    if not 1 <= arguments.max_depth <= 100:
        raise ValueError(f"--max-depth {arguments.max_depth} is outside 1 … 100")
    if arguments.seed < 0:
        raise ValueError(f"--seed {arguments.seed} is negative")


def _settings(arguments: argparse.Namespace, scene: Scene) -> list[Setting]:
    from engine.effects.setting import modes as all_modes
    from engine.tradeoff.sweep import modes_of, settings_of

    modes = list(dict.fromkeys(name for text in arguments.modes or () for name in text.replace(",", " ").split()))
    strange = [mode for mode in modes if mode not in all_modes()]
    if strange:
        raise ValueError(f"{strange[0]!r} is no mode; known are {', '.join(all_modes())}")
    if "shading-map" in modes and not arguments.material:
        raise ValueError("the mode shading-map needs --material")
    return settings_of(scene, modes or modes_of(scene), bounces=arguments.max_depth > 1)


def _scene(arguments: argparse.Namespace) -> Scene:
    from app.cli import usage
    from engine.camera import frame, parse
    from engine.environment_file import open_environment
    from engine.factor.factor_file import open_reflectance
    from engine.files.bundle import open_bundle
    from engine.ground import Ground
    from engine.scene import Scene
    from engine.shapes import open_mesh

    material = open_bundle(arguments.material) if arguments.material else None
    brdf = material.reflectance if material else usage(open_reflectance, arguments.brdf)
    mesh = open_mesh(arguments.mesh)
    environment = open_environment(arguments.env)
    camera = usage(parse, arguments.camera or "", frame(mesh.positions, arguments.width / arguments.height))
    ground = None if arguments.ground is None else usage(lambda: Ground(albedo=arguments.ground))
    scene: Scene = usage(
        lambda: Scene(
            mesh=mesh,
            camera=camera,
            brdf=brdf,
            material=material,
            irradiance=arguments.intensity,
            repeats=arguments.tile,
            environment=environment,
            environment_rotation=math.radians(arguments.env_rotation_deg),
            ground=ground,
        )
    )
    return scene


def _title(arguments: argparse.Namespace) -> str:
    from engine.brdf.brdf import MODELS

    named = arguments.brdf or arguments.material
    what = named if named.partition(":")[0] in MODELS else Path(named).name
    return f"{Path(arguments.mesh).name}, {what}, under {Path(arguments.env).name}"


def _chosen(found: Tradeoff, budget: Any, axis: str) -> dict[str, Any]:
    """The best setting within the budget, and why; nothing without one."""
    from engine.tradeoff.choose import choose

    if budget is None:
        return {}
    choice = choose(found.points, budget, axis)
    return {"choice": choice.point.as_json() if choice.point else None, "choice_reason": choice.reason}

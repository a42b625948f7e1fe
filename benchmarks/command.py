"""Run benchmarks by name: the speed of each part beside its limit, and its error against known results."""

from __future__ import annotations

import argparse
import importlib
import os
from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.arguments.quantities import size_bytes
from app.arguments.results import MEASURED_PAGE, SHARED, SOAK_LOG, Input, Output
from engine.core.errors import FileError, MissingCapability, UsageError
from engine.core.figure_text import number, time_text
from engine.core.steps import Step, drain
from engine.storage.atomic import write_bytes
from engine.transport import method as transport

if TYPE_CHECKING:
    from benchmarks.measure import Accuracy, Measure

#: BRDF models, each with a measure of its own.
BRDFS = (
    "lambert",
    "oren-nayar",
    "phong",
    "blinn-phong",
    "lafortune",
    "lafortune-three-lobes",
    "ward",
    "ashikhmin-shirley",
    "cook-torrance",
    "ggx",
    "ggx-anisotropic",
    "poulin-fournier",
    "metallic-roughness",
    "openpbr",
    "openpbr-anisotropic",
)

#: Name of a measure and the function that takes it.
MEASURES = {
    "linearise": "benchmarks.shading:linearise",
    "power-law-fit": "benchmarks.shading:power_law_fit",
    "power-law-fit-copy": "benchmarks.shading:power_law_fit_copy",
    "rgl-values": "benchmarks.rgl:rgl_values",
    "rgl-samples": "benchmarks.rgl:rgl_samples",
    "merl-values": "benchmarks.tables:merl_values",
    "utia-values": "benchmarks.tables:utia_values",
    "merl-read": "benchmarks.tables:merl_read",
    **{f"brdf-{model}": f"benchmarks.brdf:{model.replace('-', '_')}" for model in BRDFS},
    "separable-48": "benchmarks.factor:separable",
    "separable-48-svd": "benchmarks.factor:separable_svd",
    "separable-48-power": "benchmarks.factor:separable_power",
    "separable-48-auto": "benchmarks.factor:separable_auto",
    "factor-inner": "benchmarks.factor:inner_evaluation",
    "factor-search-55-large": "benchmarks.factor:search_55",
    "factor-search-88-large": "benchmarks.factor:search_88",
    "factor-thesis-55-large": "benchmarks.factor:thesis_55",
    "factor-thesis-88-large": "benchmarks.factor:thesis_88",
    "cube-map": "benchmarks.prefilter:cube_map",
    "prefilter": "benchmarks.prefilter:prefilter",
    "prefilter-lookup": "benchmarks.prefilter:prefilter_lookup",
    "reference-direct": "benchmarks.transport.reference:reference_direct",
    "reference-paths": "benchmarks.transport.reference:reference_paths",
    "rays-occluded": "benchmarks.transport.rays:rays_occluded",
    "occlusion-50k": "benchmarks.transport.rays:occlusion_50k",
    "visibility-cube": "benchmarks.transport.rays:visibility_cubes",
    "wavelet-bake": "benchmarks.transport.wavelet:wavelet_bake",
    "wavelet-bake-large": "benchmarks.transport.wavelet:wavelet_bake_large",
    "bake-41k-sh": "benchmarks.transport.bake_speed:bake_41k_sh",
    "bake-41k-wavelet": "benchmarks.transport.bake_speed:bake_41k_wavelet",
    "bake-41k-gaussian": "benchmarks.transport.bake_speed:bake_41k_gaussian",
    "wavelet-relight": "benchmarks.transport.wavelet:wavelet_relight",
    "gl-frame": "benchmarks.transport.frame:gl_frame",
    "gl-frame-slices": "benchmarks.transport.frame:gl_frame_slices",
    "gl-frame-hex": "benchmarks.tiling:gl_frame_hex",
    "gl-wavelet-frame": "benchmarks.transport.transported:gl_wavelet_frame",
    "gl-sh-frame": "benchmarks.transport.transported:gl_sh_frame",
    "gl-sh-frame-brushed": "benchmarks.transport.transported:gl_sh_frame_brushed",
    "gl-gaussian-frame": "benchmarks.transport.transported:gl_gaussian_frame",
    **{
        f"gl-4k-{mode}": f"benchmarks.transport.frame_4k:{mode.replace('-', '_')}"
        for mode in (
            "brdf",
            "power-law",
            "shading-map",
            "directional-map",
            "pbr-maps",
            "sh",
            "wavelet",
            "gaussian",
            "sh-texels",
            "wavelet-texels",
            "gaussian-texels",
        )
    },
    "gaussian-fit-speed": "benchmarks.transport.gaussian_fit:gaussian_fit_speed",
    "gaussian-bake": "benchmarks.transport.gaussian_bake:gaussian_bake",
    "gaussian-bake-large": "benchmarks.transport.gaussian_bake:gaussian_bake_large",
    "gaussian-environment": "benchmarks.transport.gaussian:gaussian_environment",
    "gaussian-environment-sharp": "benchmarks.transport.gaussian:gaussian_environment_sharp",
    "transport-paid-off": "benchmarks.transport.paid_off:transport_paid_off",
    "transport-paid-off-sh": "benchmarks.transport.paid_off:transport_paid_off_sh",
    "gl-lobe": "benchmarks.transport.lobe:gl_lobe",
    "plan-50k": "benchmarks.transport.plan:plan_50k",
    "plan-convex": "benchmarks.transport.plan:plan_convex",
    "sh-rotate": "benchmarks.transport.sh:sh_rotate",
    "sh-project": "benchmarks.transport.sh:sh_project",
    "sh-project-15": "benchmarks.transport.sh:sh_project_15",
    "sh-table": "benchmarks.transport.sh:sh_table",
    "sh-table-15": "benchmarks.transport.sh:sh_table_15",
    "sh-table-brushed": "benchmarks.transport.sh:sh_table_brushed",
    "sh-bake": "benchmarks.transport.sh:sh_bake",
    "sh-relight": "benchmarks.transport.sh:sh_relight",
    "sh-relight-view": "benchmarks.transport.sh:sh_relight_view",
    "window-start": "benchmarks.app.program:window_start",
    "window-block": "benchmarks.app.program:window_block",
    "view-block": "benchmarks.app.program:view_block",
    "import-large": "benchmarks.app.program:import_large",
    "import-raw-24mp": "benchmarks.app.program:import_raw",
    "import-tiff-24mp": "benchmarks.app.program:import_tiff",
    "import-aligned-24mp": "benchmarks.app.program:import_aligned",
    "import-bracketed-24mp": "benchmarks.app.program:import_bracketed",
    "align-24mp": "benchmarks.capture:align_large",
    "hostile-text": "benchmarks.hostile_text:hostile_text",
}
LARGE = (
    *(
        name
        for name in MEASURES
        if name.endswith(("-large", "-24mp")) or name.startswith(("transport-paid-off", "gl-4k-", "bake-41k-"))
    ),
    "hostile-text",
    "surface",
    "surface-sigma",
    "fall-off",
    "held-out",
    "relighting",
    "alignment-arc",
    "transport-errors",
    "gaussian-fit-quality",
    "gaussian-errors",
    "factors",
    "factor-bounds",
    "fits",
    "choices",
    "tradeoff-choices",
    "steady-plans",
    "predictions",
    "bake-checks",
    "window-soak",
    "cancel",
    "batch",
    "batch-captures",
    "watch",
    "project",
    "large-memory",
    "cluster-bakes",
    "cluster-memory",
    "cluster-memory-writer",
    "cluster-price",
    "cluster-tasks",
    "large-models",
    "busy-models",
)

#: Name of a group of errors and the function that finds them in a working folder.
ACCURACIES = {
    "capture-truth": "benchmarks.capture_truth:measures",
    "alignment-accuracy": "benchmarks.capture:alignment",
    "alignment-arc": "benchmarks.alignment:measures",
    "directions": "benchmarks.directions:directions",
    "surface": "benchmarks.surface:surface",
    "surface-sigma": "benchmarks.surface:deviations",
    "fall-off": "benchmarks.fall_off:measure_fall_off",
    "held-out": "benchmarks.held_out:measure_held_out",
    "relighting": "benchmarks.relighting:measure_relighting",
    "ray-misses": "benchmarks.transport.rays:ray_misses",
    "hex-tiling": "benchmarks.tiling:hex_tiling",
    "transport-errors": "benchmarks.transport.wavelet:transport_errors",
    "interreflection": "benchmarks.transport.interreflection:interreflection",
    "reuse": "benchmarks.transport.reuse:reuse",
    "transport-sizes": "benchmarks.transport.sizes:transport_sizes",
    "cost-model": "benchmarks.transport.plan:cost_model",
    "gaussian-fit-quality": "benchmarks.transport.gaussian_fit:gaussian_fit_quality",
    "gaussian-errors": "benchmarks.transport.gaussian_bake:gaussian_errors",
    "factors": "benchmarks.factor_choice:factors",
    "factor-bounds": "benchmarks.factor_bounds:bounds",
    "fits": "benchmarks.fits:fits",
    "choices": "benchmarks.transport.choice:choices",
    "tradeoff-choices": "benchmarks.transport.tradeoff_choice:tradeoff_choices",
    "steady-plans": "benchmarks.transport.steady_plans:steady_plans",
    "predictions": "benchmarks.transport.predictions:predictions",
    "bake-checks": "benchmarks.transport.bake_checks:bake_checks",
    "window-soak": "benchmarks.app.soak:window_soak",
    "cancel": "benchmarks.app.cancel:cancel",
    "batch": "benchmarks.batch:batch",
    "batch-captures": "benchmarks.batch:batch_captures",
    "watch": "benchmarks.watch:watch",
    "project": "benchmarks.app.project:project",
    "project-size": "benchmarks.app.project_size:project_size",
    "large-memory": "benchmarks.app.large_memory:large_memory",
    "cluster-bakes": "benchmarks.app.cluster_bakes:cluster_bakes",
    "cluster-memory": "benchmarks.app.cluster:cluster_memory",
    "cluster-memory-writer": "benchmarks.app.cluster:writer_memory",
    "cluster-price": "benchmarks.app.cluster:cluster_price",
    "cluster-tasks": "benchmarks.app.cluster_tasks:cluster_tasks",
    "large-models": "benchmarks.app.large_models:large_models",
    "busy-models": "benchmarks.app.large_models:busy_models",
}

#: Options of the command line that a group of errors takes.
OPTIONS = {
    "choices": ("scenes", "seed", "data"),
    "tradeoff-choices": ("scenes", "seed"),
    "reuse": ("data", "modes"),
    "predictions": ("scenes", "seed", "data", "modes"),
    "bake-checks": ("scenes", "seed", "data", "modes"),
    "window-soak": ("runs", "run_s", "at_once", "seed", "record"),
    "cancel": ("runs", "seed"),
    "batch": ("runs", "seed"),
    "batch-captures": ("runs", "seed", "megapixels", "keep"),
    "busy-models": ("runs",),
    "large-memory": ("megapixels", "photographs", "limit_bytes", "hard_limit"),
    "watch": ("photographs",),
    "cluster-bakes": ("scenes", "seed", "modes"),
    "cluster-memory": ("vertices", "modes"),
    "cluster-memory-writer": ("vertices", "modes"),
    "surface-sigma": ("scenes", "seed"),
    "fall-off": ("scenes", "seed"),
    "relighting": ("scenes", "seed", "data"),
    "factors": ("data", "samplings", "seed"),
    "factor-bounds": ("data", "samplings", "seed"),
    "fits": ("data", "samplings", "seed"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    names = (*MEASURES, *ACCURACIES)
    parser.add_argument("--only", nargs="+", choices=names, metavar="NAME", help=", ".join(names))
    parser.add_argument(
        "--large",
        action="store_true",
        help="also the measurements that take minutes: 24 megapixels, 4K frames, moving arcs, searches",
    )
    parser.add_argument(
        "--runs",
        type=int,
        metavar="N",
        help="runs of window-soak and busy-models (20), signals for each verb of cancel (8), or captures for each "
        "process of batch (24) and batch-captures (30)",
    )
    parser.add_argument("--run-s", type=float, metavar="S", help="seconds of each run (8)")
    parser.add_argument("--at-once", type=int, metavar="N", help="runs of window-soak side by side (4)")
    parser.add_argument(
        "--seed",
        type=int,
        metavar="N",
        help="seed of batch, batch-captures, cancel and factors, or of the first run of window-soak, scene of "
        "predictions, model of cluster-bakes, capture of relighting or material of factor-bounds, fits or "
        "surface-sigma; more count up",
    )
    parser.add_argument(
        "--scenes",
        type=int,
        metavar="N",
        help="scenes of predictions and bake-checks (10), models of cluster-bakes (3), captures of each kind of "
        "relighting (2), or materials of surface-sigma (24)",
    )
    parser.add_argument(
        "--modes",
        nargs="+",
        choices=("reference", "direct", *transport.names()),
        metavar="MODE",
        help="modes that predictions draws in every scene that they can draw (all, but the dearest in one of six), or "
        "that cluster-bakes, cluster-memory (sh wavelet gaussian) and cluster-memory-writer (gaussian) bake",
    )
    parser.add_argument(
        "--data",
        type=Input(Path),
        metavar="FOLDER",
        help="folder of models and measured BRDFs that join the scenes of predictions, of files for factors, "
        "factor-bounds and fits, or of photographs with light lists for relighting",
    )
    parser.add_argument(
        "--samplings",
        type=int,
        metavar="N",
        help="random models at directions of instruments, for factors (4), factor-bounds (24) and fits (12)",
    )
    parser.add_argument(
        "--megapixels",
        type=float,
        nargs="+",
        metavar="M",
        help="sizes of photographs for large-memory (6 24 48), or the size for batch-captures (0.05)",
    )
    parser.add_argument(
        "--vertices",
        type=int,
        nargs="+",
        metavar="N",
        help="vertices of the models of cluster-memory (2000 5000 10000 20000) and cluster-memory-writer (5000 10000 "
        "20000 40000)",
    )
    parser.add_argument(
        "--photographs",
        type=int,
        metavar="N",
        help="photographs of large-memory, more than 10 of which are of a dome (10), or of the one capture of watch "
        "(4 8 12, from which those of 64 are extrapolated)",
    )
    parser.add_argument(
        "--report",
        type=Output(MEASURED_PAGE, Path),
        metavar="FILE",
        help="also write what was measured as a page (.md), with the machine, its load and the commit",
    )
    parser.add_argument(
        "--limit",
        dest="limit_bytes",
        type=size_bytes,
        metavar="SIZE",
        help="memory that each command of large-memory is told to take at most, as 4GB (no limit)",
    )
    parser.add_argument(
        "--hard-limit",
        action="store_true",
        default=None,
        help="let the system end commands of large-memory that need a tenth more than --limit (Linux, control groups)",
    )
    parser.add_argument(
        "--keep",
        type=Output(SHARED, Path),
        metavar="FOLDER",
        help="folder of batch-captures, where a run that was ended goes on",
    )
    parser.add_argument(
        "--record",
        type=Output(SOAK_LOG, Path),
        metavar="FOLDER",
        help="folder for the record of each run of window-soak",
    )


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    chosen = arguments.only or [name for name in (*MEASURES, *ACCURACIES) if arguments.large or name not in LARGE]
    load = os.getloadavg()[0]
    measures, warnings = [], []
    accuracies: list[dict[str, Any]] = []
    for index, name in enumerate(chosen):
        show(Step(index / len(chosen), f"measuring {name}"))
        try:
            if name in MEASURES:
                measures.append(_record(_measure(name)))
            else:
                accuracies += _accuracies(name, show, arguments)
        except (MissingCapability, UsageError, FileError, ModuleNotFoundError) as missing:
            if arguments.only:
                raise
            warnings.append(f"{name} was left out: {missing}")
    warnings += [
        f"{each['name']}: {number(each['error'])} is above its bound of {number(each['bound'])}"
        for each in accuracies
        if each["bound"] is not None and each["error"] > each["bound"]
    ]
    result = {"measures": measures, "accuracies": accuracies, "warnings": warnings}
    if arguments.report is None:
        return result
    from benchmarks.page import write_page

    write_bytes(arguments.report, write_page(result, load).encode())
    return {**result, "report": str(arguments.report)}


def report(result: dict[str, Any]) -> str:
    lines = [f"{'':28}{'time':>12}{'limit':>12}{'ratio':>10}"]
    for measure in result["measures"]:
        times = "".join(f"{time_text(measure[key]):>12}" for key in ("time_s", "limit_s"))
        lines.append(f"{measure['name']:28}{times}{number(measure['ratio'], 4):>10}   limit: {measure['limit']}")
    for found in result["accuracies"]:
        bound = f"bound: {number(found['bound'])}" if found["bound"] is not None else "no bound"
        lines.append(
            f"{found['name']:28}{'error':>12}{number(found['error'], 4):>12}{'':10}   {bound}; {found['what']}"
        )
    return "\n".join(lines)


def _measure(name: str) -> Measure:
    measure: Measure = _function(MEASURES[name])()
    return measure


def _accuracies(name: str, show: Callable[[Step], None], arguments: argparse.Namespace) -> list[dict[str, Any]]:
    from app.session.settings import close_session, open_session

    chosen = {key: getattr(arguments, key) for key in OPTIONS.get(name, ())}
    folder = open_session()
    try:
        find = partial(
            _function(ACCURACIES[name]), **{key: value for key, value in chosen.items() if value is not None}
        )
        found = drain(find(folder), show)
    finally:
        close_session(folder)
    return [_flat(accuracy) for accuracy in found]


def _flat(accuracy: Accuracy) -> dict[str, Any]:
    record = asdict(accuracy)
    more = record.pop("more")
    return {**record, **more}


def _function(place: str) -> Any:
    """Only what is asked for is loaded."""
    module, function = place.split(":")
    return getattr(importlib.import_module(module), function)


def _record(measure: Measure) -> dict[str, Any]:
    record = {key: getattr(measure, key) for key in ("name", "time_s", "limit_s", "limit", "ratio")}
    return {**record, **measure.more}

"""`lightarc bake`: precompute what light does to a model, so that light and view can then change at once."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from typing import Any

from app.verbs import bake_sh
from app.verbs.brdf import BRDF_HELP
from engine.steps import Step, drain, part

HELP = "Precompute light transport for a model and a reflectance, for 'lightarc render' and the window."
EXAMPLE = "lightarc bake sphere --brdf ggx:alpha=0.3 --mode wavelet --ground -o sphere.transport"

MODES = ("wavelet", "sh")

#: Edge of the cube maps of wavelets.
EDGE = 64

MAPS = ("orthographic", "polar", "parabolic")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("mesh", metavar="MESH", help="a file, or a built-in: sphere, plane, torus-knot, cloth, blob")
    parser.add_argument("--brdf", required=True, metavar="TEXT", help=BRDF_HELP)
    parser.add_argument("-o", "--output", required=True, metavar="TRANSPORT", help="file to write, say bunny.transport")
    parser.add_argument(
        "--mode", default="wavelet", choices=MODES, help="wavelet: sharp shadows; sh: soft light (wavelet)"
    )
    parser.add_argument("--order", type=int, default=5, metavar="N", help="sh: harmonics of N bands, 3 to 15 (5)")
    parser.add_argument("--interreflection", action="store_true", help="sh: with light between parts of the model")
    parser.add_argument("--terms", type=int, default=4, metavar="K", help="terms of the reflectance (4)")
    parser.add_argument(
        "--cube", type=int, metavar="N", help="edge of the light's cube map: 16, 32, 64 (64; sh: 32, above order 8 64)"
    )
    parser.add_argument(
        "--coefficients", type=int, default=96, metavar="N", help="wavelet coefficients kept for each term (96)"
    )
    parser.add_argument(
        "--fine",
        type=int,
        default=4,
        metavar="N",
        help="N × N rays for each texel of the cube map at the edges of shadows (4)",
    )
    parser.add_argument(
        "--map",
        default="orthographic",
        choices=MAPS,
        help="of the reflectance's textures; polar suits single terms of anisotropic ones",
    )
    parser.add_argument(
        "--weighting",
        default="auto",
        choices=("auto", "plain", "cosine"),
        help="norm in which terms are found; auto: the one with the lower cosine-weighted error",
    )
    parser.add_argument(
        "--ground",
        nargs="?",
        type=float,
        const=0.5,
        metavar="ALBEDO",
        help="let the model stand on a matt ground that receives its shadow (of albedo 0.5)",
    )
    parser.add_argument(
        "--occluder-cells",
        type=int,
        default=0,
        metavar="N",
        help="let shadows fall from a model simplified in a grid of N cells a side (0: the model itself)",
    )
    parser.add_argument(
        "--error-env",
        metavar="FILE",
        help="measure the error under this environment at 400 vertices, seen from 20 directions (half a minute)",
    )
    parser.add_argument("--ground-cells", type=int, default=64, metavar="N", help="squares along its side (64)")


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    from app.cli import CANCELLED, DONE, usage
    from engine.factor.factor_file import open_reflectance
    from engine.ground import Ground
    from engine.shapes import open_mesh
    from engine.transport.wavelet import MOST_TERMS
    from engine.transport.wavelet_bake import BakeSettings, Work, bake, estimate_s, factors_for, prepare

    if arguments.mode == "sh":
        return bake_sh.run(arguments, show)
    if arguments.interreflection:
        usage(_refuse, "--interreflection needs --mode sh")
    arguments.cube = EDGE if arguments.cube is None else arguments.cube
    if not 1 <= arguments.terms <= MOST_TERMS:
        usage(_refuse, f"--terms {arguments.terms} is outside 1 … {MOST_TERMS}")
    settings = usage(
        lambda: BakeSettings(arguments.cube, arguments.coefficients, arguments.fine, arguments.occluder_cells)
    )
    ground = None
    if arguments.ground is not None:
        ground = usage(lambda: Ground(albedo=arguments.ground, cells=arguments.ground_cells))
    brdf = usage(open_reflectance, arguments.brdf)
    mesh = open_mesh(arguments.mesh)
    show(Step(0.0, "factoring the reflectance"))
    options = {"kind": arguments.map, "weighting": arguments.weighting}
    factors = usage(drain, part(factors_for(brdf, arguments.terms, **options), 0.0, 0.02), show)
    work: Work = usage(prepare, mesh, factors, settings, ground)
    knobs = _knobs(arguments, work)
    error = _error(arguments, work, brdf, show) if arguments.error_env else {}
    error |= _occluder(arguments, work) if arguments.occluder_cells else {}
    expected_s = estimate_s(work)
    print(
        f"{work.vertices:,} vertices, {work.size_bytes / 1e6:.1f} MB, about {_time(expected_s)}",
        file=sys.stderr,
        flush=True,
    )
    started = time.perf_counter()
    try:
        baked = drain(part(bake(arguments.output, work), 0.02, 1.0), show)
    except KeyboardInterrupt:
        return {
            "output": None,
            "vertices": work.vertices,
            "bake_s": time.perf_counter() - started,
            "size_bytes": work.size_bytes,
            "knobs": knobs,
            "cancelled": True,
            "exit_code": CANCELLED,
        }
    return {
        "output": arguments.output,
        "vertices": work.vertices,
        "faces": len(work.surface.faces),
        "bake_s": baked.bake_s,
        "visibility_s": baked.visibility_s,
        "estimated_s": expected_s,
        "size_bytes": work.size_bytes,
        "vectors": baked.transport.rows,
        "coefficients_kept_mean": float(baked.transport.vectors.counts.mean()),
        "knobs": knobs,
        **error,
        "skipped": _skipped(baked, work),
        "chunks": baked.chunks,
        "chunks_resumed": baked.resumed_chunks,
        "warnings": list(mesh.health.warnings),
        "cancelled": False,
        "exit_code": DONE,
    }


def report(result: dict[str, Any]) -> str:
    if result["cancelled"]:
        return "Cancelled; the same command goes on from here."
    size = f"{result['size_bytes'] / 1e6:.1f} MB"
    share = 100.0 * result["visibility_s"] / result["bake_s"] if result["bake_s"] > 0.0 else 0.0
    lines = [
        f"{result['output']}: {result['vertices']:,} vertices, {size}, {_time(result['bake_s'])}, "
        f"{share:.0f} % of it for visibility"
    ]
    if "error_rmse_rel" in result:
        lines.append(
            f"error under {result['error_env']}: {100.0 * result['error_rmse_rel']:.1f} % of the radiance "
            f"(RMS, {result['error_pairs']:,} pairs of vertex and view)"
        )
    if "occluder_faces" in result:
        lines.append(
            f"shadows from {result['occluder_faces']:,} triangles: the open share of the sky is off by "
            f"{100.0 * result['occluder_open_rms']:.2g} % RMS, rays take {result['occluder_time_rel']:.2f} of the time"
        )
    if result["chunks_resumed"]:
        lines.append(f"{result['chunks_resumed']} of {result['chunks']} chunks were there from before")
    return "\n".join([*lines, *result["skipped"], *result["warnings"]])


def _refuse(problem: str) -> None:
    raise ValueError(problem)


def _error(arguments: argparse.Namespace, work: Any, brdf: Any, show: Callable[[Step], None]) -> dict[str, Any]:
    from engine.cube_map import cube_of
    from engine.environment_file import open_environment
    from engine.transport.wavelet_error import wavelet_error

    environment = open_environment(arguments.error_env)
    found = drain(wavelet_error(work, brdf, cube_of(environment, arguments.cube).radiance), show)
    return {
        "error_env": environment.name,
        "error_rmse_rel": found.rmse_rel,
        "error_negative_rel": found.negative_rel,
        "error_pairs": found.pairs,
    }


def _occluder(arguments: argparse.Namespace, work: Any) -> dict[str, Any]:
    """What the simplified occluder costs and saves, at some vertices."""
    import numpy as np

    from engine.transport.occluder import occluder_error

    vertices = np.unique(np.linspace(0, work.ground_vertex - 1, 200).astype(int))
    found = occluder_error(work.surface, work.occluder, arguments.cube, vertices)
    return {
        "occluder_faces": found.faces,
        "occluder_open_rms": found.open_rms,
        "occluder_time_rel": found.time_rel,
    }


def _time(seconds: float) -> str:
    return f"{seconds:.1f} s" if seconds < 120.0 else f"{seconds / 60.0:.1f} min"


def _knobs(arguments: argparse.Namespace, work: Any) -> dict[str, Any]:
    return {
        "mode": arguments.mode,
        "brdf": arguments.brdf,
        "terms": work.factors.terms,
        "cube": arguments.cube,
        "coefficients": arguments.coefficients,
        "fine": arguments.fine,
        "occluder_cells": arguments.occluder_cells,
        "map": work.factors.chart.kind,
        "weighting": arguments.weighting,
        "ground_albedo": arguments.ground,
    }


def _skipped(baked: Any, work: Any) -> list[str]:
    """What needed no work, and why."""
    if not baked.free_vertices:
        return []
    return [f"No rays for {baked.free_vertices:,} of {work.vertices:,} vertices, which see their whole hemisphere."]

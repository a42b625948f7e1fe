"""`lightarc bake --mode sh`: shadows, and light between parts of a model, in spherical harmonics."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from typing import Any

from engine.steps import Step, drain, part

#: Bounces between parts of the model that --interreflection asks for.
BOUNCES = 3


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    from app.cli import CANCELLED, DONE, usage
    from engine.factor.factor_file import open_reflectance
    from engine.ground import Ground
    from engine.shapes import open_mesh
    from engine.transport.sh_bake import BakeSettings, Work, bake, default_edge, estimate_s, prepare

    edge = arguments.cube or default_edge(arguments.order)
    bounces = BOUNCES if arguments.interreflection else 0
    settings = usage(lambda: BakeSettings(arguments.order, edge, arguments.fine, bounces))
    ground = None
    if arguments.ground is not None:
        ground = usage(lambda: Ground(albedo=arguments.ground, cells=arguments.ground_cells))
    brdf = usage(open_reflectance, arguments.brdf)
    mesh = open_mesh(arguments.mesh)
    before = time.perf_counter()
    work: Work = usage(drain, part(prepare(mesh, brdf, settings, ground), 0.0, 0.05), show)
    table_s = time.perf_counter() - before
    expected_s = estimate_s(work)
    print(
        f"{work.vertices:,} vertices, {work.size_bytes / 1e6:.1f} MB, about {_time(expected_s)}",
        file=sys.stderr,
        flush=True,
    )
    knobs = {
        "mode": arguments.mode,
        "brdf": arguments.brdf,
        "order": settings.order,
        "cube": settings.edge,
        "fine": settings.fine,
        "bounces": settings.bounces,
        "gather": settings.gather,
        "ground_albedo": arguments.ground,
    }
    started = time.perf_counter()
    try:
        baked = drain(part(bake(arguments.output, work), 0.05, 1.0), show)
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
        "bounce_s": baked.bounce_s,
        "table_s": table_s,
        "table_error_rel": work.table.error_rel,
        "estimated_s": expected_s,
        "size_bytes": work.size_bytes,
        "stored": "vectors" if work.table.diffuse else "matrices",
        "knobs": knobs,
        "skipped": _skipped(baked, work),
        "chunks": baked.chunks,
        "chunks_resumed": baked.resumed_chunks,
        "warnings": _warnings(mesh, work),
        "cancelled": False,
        "exit_code": DONE,
    }


def _time(seconds: float) -> str:
    return f"{seconds:.1f} s" if seconds < 120.0 else f"{seconds / 60.0:.1f} min"


def _skipped(baked: Any, work: Any) -> list[str]:
    """What needed no work, and why."""
    skipped = []
    if work.table.diffuse:
        skipped.append("No matrices: a matt model looks the same from every side, and a vector does.")
    if not work.settings.bounces:
        skipped.append("No light between parts of the model; --interreflection adds it.")
    if baked.free_vertices:
        words = f"{baked.free_vertices:,} of {work.vertices:,} vertices, which see their whole hemisphere."
        skipped.append(f"No rays for {words}")
    return skipped


def _warnings(mesh: Any, work: Any) -> list[str]:
    warnings = [*mesh.health.warnings, *work.table.health.warnings]
    if work.settings.bounces and not work.table.diffuse:
        warnings.append("Light between parts of the model counts as reflected evenly to all sides until the last time.")
    return warnings

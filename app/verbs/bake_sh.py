"""`lightarc bake --mode sh`: shadows, and light between parts of a model, in spherical harmonics."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from app.verbs.baked import carry_out, subject_of
from engine.steps import Step, drain, part

if TYPE_CHECKING:
    from engine.mesh import Mesh
    from engine.transport.sh_bake import Work

#: Bounces between parts of the model that --interreflection asks for.
BOUNCES = 3


def add_arguments(parser: Any) -> None:
    parser.add_argument("--order", type=int, default=5, metavar="N", help="harmonics of N bands, 3 to 15 (5)")
    parser.add_argument("--interreflection", action="store_true", help="with light between parts of the model")


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    from app.cli import usage
    from engine.transport.sh_bake import BakeSettings, bake, default_edge, estimate_s, prepare

    if arguments.cluster is not None:
        usage(_refuse, "--cluster is for the mode wavelet")
    edge = arguments.cube or default_edge(arguments.order)
    bounces = BOUNCES if arguments.interreflection else 0
    settings = usage(lambda: BakeSettings(arguments.order, edge, arguments.fine, bounces))
    subject = subject_of(arguments)
    before = time.perf_counter()
    preparing = prepare(subject.mesh, subject.brdf, settings, subject.ground)
    work: Work = usage(drain, part(preparing, 0.0, 0.05), show)
    table_s = time.perf_counter() - before
    knobs = {
        "order": settings.order,
        "cube": settings.edge,
        "fine": settings.fine,
        "bounces": settings.bounces,
        "gather": settings.gather,
    }
    baked, record = carry_out(
        arguments,
        show,
        work,
        lambda: bake(arguments.output, work),
        estimated_s=estimate_s(work),
        knobs=knobs,
        start=0.05,
    )
    if baked is None:
        return record
    return {
        **record,
        "bounce_s": baked.bounce_s,
        "table_s": table_s,
        "table_error_rel": work.table.error_rel,
        "stored": "vectors" if work.table.diffuse else "matrices",
        "skipped": [*_skipped(work), *record["skipped"]],
        "warnings": _warnings(subject.mesh, work),
    }


def lines(_result: dict[str, Any]) -> list[str]:
    """What there is to say beyond what all modes say."""
    return []


def _refuse(problem: str) -> None:
    raise ValueError(problem)


def _skipped(work: Work) -> list[str]:
    """What needed no work, and why."""
    skipped = []
    if work.table.diffuse:
        skipped.append("No matrices: a matt model looks the same from every side, and a vector does.")
    if not work.settings.bounces:
        skipped.append("No light between parts of the model; --interreflection adds it.")
    return skipped


def _warnings(mesh: Mesh, work: Work) -> list[str]:
    warnings = [*mesh.health.warnings, *work.table.health.warnings]
    if work.settings.bounces and not work.table.diffuse:
        warnings.append("Light between parts of the model counts as reflected evenly to all sides until the last time.")
    return warnings

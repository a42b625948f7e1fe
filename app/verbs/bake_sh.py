"""`lightarc bake --mode sh`: shadows, and light between parts of a model, in spherical harmonics."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from app.verbs.baked import carry_out, error_lines, error_under, subject_of
from app.verbs.vary import variations_of
from engine.steps import Step, drain, part

if TYPE_CHECKING:
    from engine.mesh import Mesh
    from engine.transport.sh_bake import Work

#: Bounces between parts of the model that --interreflection asks for.
BOUNCES = 3


def add_arguments(parser: Any) -> None:
    parser.add_argument("--interreflection", action="store_true", help="with light between parts of the model")


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    from app.cli import usage
    from engine.transport.sh_bake import BakeSettings, bake, default_edge, estimate_s, prepare
    from engine.transport.sh_error import sh_error

    edge = arguments.cube or default_edge(arguments.order)
    bounces = BOUNCES if arguments.interreflection else 0
    settings = usage(lambda: BakeSettings(arguments.order, edge, arguments.fine, bounces))
    variations = variations_of(arguments)
    subject = subject_of(arguments)
    before = time.perf_counter()
    preparing = prepare(subject.mesh, subject.brdf, settings, subject.ground, variations)
    work: Work = usage(drain, part(preparing, 0.0, 0.05), show)
    table_s = time.perf_counter() - before
    error = error_under(
        arguments.error_env,
        edge,
        lambda cube: sh_error(work, subject.brdf, cube, variations=variations),
        show,
    )
    knobs = {
        "order": settings.order,
        "cube": settings.edge,
        "fine": settings.fine,
        "bounces": settings.bounces,
        "gather": settings.gather,
        "vary": arguments.vary,
    }
    baked, record = carry_out(
        arguments,
        show,
        work,
        lambda: bake(arguments.output, work, cluster=arguments.cluster),
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
        **_varied(work),
        **error,
        "stored": "vectors" if work.table.diffuse else "matrices",
        "skipped": [*_skipped(work), *record["skipped"]],
        "warnings": _warnings(subject.mesh, work),
    }


def lines(result: dict[str, Any]) -> list[str]:
    """What there is to say beyond what all modes say."""
    found = error_lines(result)
    if "tables" in result:
        grid = " × ".join(map(str, result["tables"]))
        found.append(
            f"the reflectance varies over {grid} tables; between them it is off by up to "
            f"{100.0 * result['interpolation_rel']:.1f} %"
        )
    return found


def _varied(work: Work) -> dict[str, Any]:
    """How many tables a reflectance that varies has, and how far what is between them is off."""
    from engine.transport.sh_varied import VariedTable

    if not isinstance(work.table, VariedTable):
        return {}
    return {"tables": [len(some) for some in work.table.nodes], "interpolation_rel": work.table.interpolation_rel}


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

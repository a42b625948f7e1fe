"""`lightarc bake --mode gaussian`: sharp highlights, as Gaussians for each vertex and view."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from app.verbs.baked import carry_out, error_lines, subject_of
from app.verbs.vary import variations_of
from engine.steps import Step, drain, part

if TYPE_CHECKING:
    from engine.cube_map import CubeMap
    from engine.transport.gaussian_bake import Baked, Work

#: Directions of view: the icosahedron of frequency 3.
VIEWS = 92

#: Edge of the cube map that errors are measured under, and vertices that they are measured at.
ERROR_EDGE, ERROR_VERTICES = 64, 400


def add_arguments(parser: Any) -> None:
    parser.add_argument(
        "--lobes", type=int, default=1, metavar="N", help="Gaussians for each vertex and view, 1 to 3 (1)"
    )
    parser.add_argument(
        "--indirect", action="store_true", help="with highlights of light that comes by way of the model"
    )
    parser.add_argument("--views", type=int, default=VIEWS, metavar="N", help=f"directions of view ({VIEWS})")
    parser.add_argument(
        "--samples", type=int, default=128, metavar="N", help="directions that each highlight is tabulated at (128)"
    )
    parser.add_argument(
        "--weights",
        default="auto",
        choices=("auto", "plain", "preserving"),
        help="heights of the Gaussians: nearest to the highlight, or with all its energy; auto: the lower error of the "
        "radiance under --error-env, or in the studio",
    )
    parser.add_argument("--compress", action="store_true", help="store Gaussians in 8 bytes or fewer instead of 28")


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    from app.cli import usage
    from engine.transport.gaussian_bake import PROBES, BakeSettings, bake, estimate_s, prepare
    from engine.transport.sh_bake import default_edge

    usage(_check, arguments)
    settings = usage(
        lambda: BakeSettings(
            lobes=arguments.lobes,
            indirect=arguments.indirect,
            samples=arguments.samples,
            order=arguments.order,
            edge=arguments.cube or default_edge(arguments.order),
            fine=arguments.fine,
            weights=arguments.weights,
            compress=arguments.compress,
        )
    )
    variations = variations_of(arguments)
    subject = subject_of(arguments)
    environment = _environment(arguments.error_env)
    probes = PROBES if environment is None else ERROR_VERTICES
    preparing = prepare(subject.mesh, subject.brdf, settings, subject.ground, variations, environment, probes)
    work: Work = usage(drain, part(preparing, 0.0, 0.05), show)
    knobs = {
        "lobes": settings.lobes,
        "indirect": settings.indirect,
        "views": arguments.views,
        "samples": settings.samples,
        "order": settings.order,
        "cube": settings.edge,
        "fine": settings.fine,
        "weights": settings.weights,
        "compress": settings.compress,
        "vary": arguments.vary,
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
        "size_bytes": baked.file.size_bytes,
        "matt_s": baked.matt_s,
        **_error(work),
        **baked.figures,
        "skipped": [*_skipped(work), *record["skipped"]],
        "warnings": [*subject.mesh.health.warnings, *_warnings(baked)],
    }


def lines(result: dict[str, Any]) -> list[str]:
    """What there is to say beyond what all modes say."""
    words = {"plain": "nearest to the highlights", "preserving": "with all their energy"}
    plain, preserving = 100.0 * result["error_plain_rmse_rel"], 100.0 * result["error_preserving_rmse_rel"]
    found = [
        *error_lines(result),
        f"Gaussians {words[result['weights_taken']]}: error {plain:.1f} % plain, {preserving:.1f} % with all energy; "
        f"off the highlights themselves by {100.0 * result['direct_error_rel_mean']:.0f} % on average, "
        f"{100.0 * result['direct_error_rel_worst']:.0f} % for the worst hundredth",
    ]
    if "compressed_bytes" in result:
        before, after = (result[name] / 1e6 for name in ("uncompressed_bytes", "compressed_bytes"))
        found.append(
            f"Gaussians take {after:.1f} MB instead of {before:.1f} MB, which changes the radiance by "
            f"{100.0 * result['compression_error_rel']:.2g} %"
        )
    return found


def _check(arguments: argparse.Namespace) -> None:
    if arguments.cluster is not None:
        raise ValueError("--cluster is for --mode wavelet and sh")
    if arguments.views != VIEWS:
        raise ValueError(f"--views {arguments.views} is not possible; there are {VIEWS}, an icosahedron cut in three")


def _environment(name: str | None) -> tuple[str, CubeMap] | None:
    from engine.cube_map import cube_of
    from engine.environment_file import open_environment

    if name is None:
        return None
    environment = open_environment(name)
    return environment.name, cube_of(environment, ERROR_EDGE)


def _error(work: Work) -> dict[str, Any]:
    """Errors by either way to weigh, and which was taken for direct light."""
    error, taken = work.error, work.weights[0]
    return {
        "error_env": work.tested,
        "error_rmse_rel": error.of(taken),
        "error_mean_rel": error.mean_of(taken),
        "error_plain_rmse_rel": error.plain_rmse_rel,
        "error_preserving_rmse_rel": error.preserving_rmse_rel,
        "error_glossy_plain_rmse_rel": error.glossy_plain_rmse_rel,
        "error_glossy_preserving_rmse_rel": error.glossy_preserving_rmse_rel,
        "error_pairs": error.pairs,
        "weights_taken": taken,
    }


def _skipped(work: Work) -> list[str]:
    return [] if work.settings.indirect else ["No light between parts of the model; --indirect adds it."]


def _warnings(baked: Baked) -> list[str]:
    flipped = baked.figures.get("direct_flipped_pairs", 0.0)
    return [f"{flipped:,.0f} pairs of neighbours disagree on which Gaussian is which."] if flipped else []

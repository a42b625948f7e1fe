"""`lightarc bake --mode wavelet`: sharp shadows of a reflectance that is a sum of terms, in wavelets."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from app.verbs.baked import carry_out, error_lines, error_under, subject_of
from engine.steps import Step, drain, part

if TYPE_CHECKING:
    from engine.transport.wavelet_bake import Work

#: Edge of the cube maps unless something else is said.
EDGE = 64

MAPS = ("orthographic", "polar", "parabolic")


def add_arguments(parser: Any) -> None:
    parser.add_argument("--terms", type=int, default=4, metavar="K", help="terms of the reflectance (4)")
    parser.add_argument(
        "--coefficients", type=int, default=96, metavar="N", help="wavelet coefficients kept for each term (96)"
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
        "--occluder-cells",
        type=int,
        default=0,
        metavar="N",
        help="let shadows fall from a model simplified in a grid of N cells a side (0: the model itself)",
    )
    parser.add_argument(
        "--blend",
        action="append",
        default=[],
        metavar="BRDF:SOURCE",
        help="mix in another reflectance with its own terms; its weight over the model is x, y or z across its "
        "bounding box or the luminance of a picture at its texture coordinates: ggx:alpha=0.1:y; --brdf has what is "
        "left; can be given several times",
    )
    parser.add_argument(
        "--albedo", metavar="IMAGE", help="multiply what the model sends out by a picture at its texture coordinates"
    )


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    from app.cli import WrongUsage, usage
    from engine.factor.factor_file import open_reflectance
    from engine.transport.blend import blend_from_text, mixture, together
    from engine.transport.wavelet import MOST_TERMS
    from engine.transport.wavelet_bake import BakeSettings, bake, estimate_s, factors_for, prepare
    from engine.transport.wavelet_error import wavelet_error

    edge = EDGE if arguments.cube is None else arguments.cube
    if not 1 <= arguments.terms <= MOST_TERMS:
        raise WrongUsage(f"--terms {arguments.terms} is outside 1 … {MOST_TERMS}.")
    settings = usage(lambda: BakeSettings(edge, arguments.coefficients, arguments.fine, arguments.occluder_cells))
    blends = [usage(blend_from_text, text) for text in arguments.blend]
    subject = subject_of(arguments)
    brdfs = [subject.brdf, *(usage(open_reflectance, text) for text, _ in blends)]
    show(Step(0.0, "factoring the reflectance"))
    options = {"kind": arguments.map, "weighting": arguments.weighting}
    bases = [usage(drain, part(factors_for(brdf, arguments.terms, **options), 0.0, 0.02), show) for brdf in brdfs]
    mixed = None
    if blends or arguments.albedo:
        counts, sources = [each.terms for each in bases], [source for _, source in blends]
        mixed = usage(mixture, subject.mesh, counts, sources, arguments.albedo)
    work: Work = usage(prepare, subject.mesh, usage(together, bases), settings, subject.ground, mixed)
    error = error_under(arguments.error_env, edge, lambda cube: wavelet_error(work, brdfs, cube.radiance), show)
    error |= _occluder(work) if settings.occluder_cells else {}
    knobs = {
        "terms": work.factors.terms,
        "cube": settings.edge,
        "coefficients": settings.coefficients,
        "fine": settings.fine,
        "occluder_cells": settings.occluder_cells,
        "map": work.factors.chart.kind,
        "weighting": arguments.weighting,
        "blend": arguments.blend,
        "albedo": arguments.albedo,
    }
    baked, record = carry_out(
        arguments,
        show,
        work,
        lambda: bake(arguments.output, work, arguments.cluster),
        estimated_s=estimate_s(work),
        knobs=knobs,
        start=0.02,
    )
    if baked is None:
        return record
    return {
        **record,
        "vectors": baked.transport.rows,
        "coefficients_kept_mean": float(baked.transport.vectors.counts.mean()),
        **error,
        "warnings": list(subject.mesh.health.warnings),
    }


def lines(result: dict[str, Any]) -> list[str]:
    """What there is to say beyond what all modes say."""
    found = error_lines(result)
    if "occluder_faces" in result:
        found.append(
            f"shadows from {result['occluder_faces']:,} triangles: the open share of the sky is off by "
            f"{100.0 * result['occluder_open_rms']:.2g} % RMS, rays take {result['occluder_time_rel']:.2f} of the time"
        )
    return found


def _occluder(work: Work) -> dict[str, Any]:
    """What the simplified occluder costs and saves, at some vertices."""
    import numpy as np

    from engine.transport.occluder import occluder_error

    vertices = np.unique(np.linspace(0, work.ground_vertex - 1, 200).astype(int))
    found = occluder_error(work.surface, work.occluder, work.settings.edge, vertices)
    return {
        "occluder_faces": found.faces,
        "occluder_open_rms": found.open_rms,
        "occluder_time_rel": found.time_rel,
    }

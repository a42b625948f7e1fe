"""`lightarc factor`: a reflectance as textures, with the error of every number of them."""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from app.verbs.brdf import BRDF_HELP
from engine.steps import Step, drain

if TYPE_CHECKING:
    from engine.factor.factor import FactorSettings

HELP = "Factor a reflectance (BRDF) into textures: sums of products, or products of projections."
EXAMPLE = "lightarc factor lafortune:preset=blue-paint --terms 4 -o paint-factors --json"

_COLUMNS = (
    ("terms", 6),
    ("textures", 10),
    ("RMS·cos 1/sr", 14),
    ("sq. log", 10),
    ("abs. log", 10),
    ("size", 12),
    ("time", 10),
)

METHODS = ("auto", "symmetric", "svd", "power", "normalised", "homomorphic", "search")
METRICS = ("abs_log", "sq_log", "max_log", "abs", "sq", "max")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("brdf", metavar="BRDF", help=BRDF_HELP)
    parser.add_argument("-o", "--output", metavar="FACTORS", help="folder to write: factors.json and OpenEXR textures")
    parser.add_argument(
        "--method", default="auto", choices=METHODS, help="auto: symmetric where the matrix is, else svd"
    )
    parser.add_argument(
        "--parametrisation",
        default="in-out",
        choices=("in-out", "half-diff", "auto"),
        help="light and viewer, or half and difference vector; auto: the better one (separable methods)",
    )
    parser.add_argument(
        "--map",
        default="orthographic",
        choices=("orthographic", "polar", "parabolic", "auto"),
        help="of separable textures; auto: the best one",
    )
    parser.add_argument(
        "--weighting",
        default="auto",
        choices=("auto", "plain", "cosine"),
        help="norm of the separable methods; auto: the one with the lower cosine-weighted error",
    )
    parser.add_argument("--size", type=int, metavar="N", help="texels a side (48; homomorphic 16)")
    parser.add_argument("--terms", type=int, metavar="K", help="terms at most (8; homomorphic 5)")
    parser.add_argument("--reciprocal", action="store_true", help="enforce reciprocity (homomorphic and search)")
    parser.add_argument("--restarts", type=int, default=6, metavar="N", help="random starts of the search per term (6)")
    parser.add_argument("--together", type=int, default=2, metavar="N", help="textures solved for each projection (2)")
    parser.add_argument("--samples", type=int, default=45_000, metavar="N", help="pairs of directions (45000)")
    parser.add_argument(
        "--max-theta-deg", type=float, default=88.0, metavar="DEG", help="their largest angle, of formulas only (88)"
    )
    parser.add_argument("--epsilon", type=float, default=1e-5, metavar="E", help="added before the logarithm (1e-5)")
    parser.add_argument("--metric", default="sq_log", choices=METRICS, help="what the search makes small (sq_log)")
    parser.add_argument(
        "--preset", default="default", choices=("default", "thesis"), help="of the search: ours, or Cole's own"
    )
    parser.add_argument("--resume", metavar="FACTORS", help="a folder of searched factors, to go on to more terms")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of samples and starts (1)")


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    import numpy as np

    from app.cli import WrongUsage, usage
    from engine.factor.errors import BANDS
    from engine.factor.factor import factor
    from engine.factor.factor_file import open_reflectance, read_factors, write_factors
    from engine.factor.uses import uses

    settings: FactorSettings = usage(_settings, arguments)
    if arguments.resume and settings.method != "search":
        raise WrongUsage("--resume goes with --method search; other methods are quick and start anew.")
    resume = read_factors(arguments.resume) if arguments.resume else None
    show(Step(0.0, "reading"))
    brdf = usage(open_reflectance, arguments.brdf)
    started = time.perf_counter()
    found = usage(drain, factor(brdf, settings, resume), show)
    time_s = time.perf_counter() - started
    if arguments.output:
        show(Step(0.99, "writing"))
        found = write_factors(arguments.output, found)
    factors = found.factors
    return {
        "brdf": arguments.brdf,
        "output": arguments.output,
        "method": found.method,
        "parametrisation": factors.parametrisation,
        "map": factors.chart.kind if settings.separable else None,
        "size": factors.chart.size if settings.separable else len(factors.textures[0]),
        "reciprocal": bool(factors.reciprocal),
        "asymmetry": found.asymmetry,
        "condition_number": found.condition_number if math.isfinite(found.condition_number) else None,
        "optimum_ratio": found.optimum_ratio,
        "weighting": found.weighting or None,
        "converged": found.converged,
        "negative_energy_rel": found.negative_energy,
        "evaluations": found.evaluations,
        "projections": [_projection(each) for each in found.projections],
        "terms": [_rung(rung) for rung in found.ladder],
        "elevation_bands_deg": np.linspace(0.0, 90.0, BANDS + 1).tolist(),
        "samples": settings.samples,
        "max_theta_deg": arguments.max_theta_deg,
        "epsilon": settings.epsilon,
        "seed": settings.seed,
        "time_s": time_s,
        "uses": list(uses(found, brdf)),
    }


def _settings(arguments: argparse.Namespace) -> FactorSettings:
    from engine.factor.factor import FactorSettings

    for name in ("size", "terms", "samples"):
        value = getattr(arguments, name)
        if value is not None and value < 1:
            raise ValueError(f"--{name} {value} is too few")
    if not 0.0 < arguments.max_theta_deg < 90.0:
        raise ValueError("--max-theta-deg must lie between 0 and 90")
    if arguments.seed < 0:
        raise ValueError("--seed must not be negative")
    if not 0.0 < arguments.epsilon < 1.0:
        raise ValueError("--epsilon must lie between 0 and 1")
    return FactorSettings(
        method=arguments.method,
        parametrisation=arguments.parametrisation,
        map=arguments.map,
        weighting=arguments.weighting,
        size=arguments.size or 0,
        terms=arguments.terms or 0,
        reciprocal=arguments.reciprocal,
        restarts=arguments.restarts,
        together=arguments.together,
        samples=arguments.samples,
        max_theta=math.radians(arguments.max_theta_deg),
        epsilon=arguments.epsilon,
        metric=arguments.metric,
        preset=arguments.preset,
        seed=arguments.seed,
    )


def _rung(rung: Any) -> dict[str, Any]:
    values = asdict(rung)
    return {**values, **values.pop("metrics"), "rms_by_elevation_band": list(rung.rms_by_elevation_band)}


def _projection(projection: Any) -> dict[str, Any]:
    rows = getattr(projection, "rows", None)
    return {"kind": projection.name} if rows is None else {"kind": projection.name, "rows": rows.tolist()}


def report(result: dict[str, Any]) -> str:
    """The result in words, for people who did not ask for JSON."""
    form = {"in-out": "light and viewer", "half-diff": "half and difference vector"}[result["parametrisation"]]
    title = f"{result['method']}, {form}, textures of {result['size']}²"
    lines = [f"{title}, {result['map']} map" if result["map"] else title]
    lines.append(
        f"{'terms':>6}{'textures':>10}{'RMS·cos 1/sr':>14}{'sq. log':>10}{'abs. log':>10}{'size':>12}{'time':>10}"
    )
    lines += [
        f"{rung['terms']:6d}{rung['textures']:10d}{rung['rms_cosine_weighted']:14.5g}{rung['sq_log']:10.4g}"
        f"{rung['abs_log']:10.4g}{rung['size_bytes'] / 1024:8.1f} KiB{rung['time_s']:8.2f} s"
        for rung in result["terms"]
    ]
    lines.append(
        f"RMS over 80,000 pairs of the hemisphere; logarithms over {result['samples']:,} samples up to "
        f"{result['max_theta_deg']:g}° of a formula, or the measured ones"
    )
    if result["optimum_ratio"]:
        lines.append(
            f"asymmetry of the matrix {result['asymmetry']:.2g}; truncation error over the optimum "
            f"{result['optimum_ratio']:.9f} in the {result['weighting']} norm"
        )
    if not result["converged"]:
        lines.append("The iteration gave up before it came to rest; these are its best terms so far.")
    if result["negative_energy_rel"]:
        lines.append(
            f"Sums below 0 are taken as 0, which adds {100 * result['negative_energy_rel']:.2g} % to the energy."
        )
    if result["projections"]:
        lines.append(f"projections: {', '.join(each['kind'] for each in result['projections'])}")
    lines += result["uses"]
    if result["output"]:
        lines.append(f"written to {result['output']}")
    return "\n".join(lines)

"""`lightarc factor`: a BRDF as textures, with the error for every number of terms."""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from app.arguments.options import option, refuse_unused, settings_from, words_of
from app.arguments.results import FACTORS, Input, Output
from app.arguments.usage import CANCELLED, DONE
from app.cli.brdf import BRDF_HELP
from app.cli.doubts import doubts_of_brdf
from app.process import ending
from engine.core.errors import UsageError
from engine.core.figure_text import number, percent, size_text, time_text
from engine.core.params import Parameter, parameters
from engine.core.steps import Step, drain
from engine.factor.advice import advise
from engine.factor.errors import BANDS, TermError, uses
from engine.factor.factor import factor, search_settings
from engine.factor.factor_file import open_reflectance, read_factors, write_factors
from engine.factor.homomorphic import HomomorphicFactors
from engine.factor.separable_factors import SeparableFactors
from engine.factor.settings import HOMOMORPHIC_PARAMETERS, SEPARABLE_PARAMETERS, FactorSettings
from engine.factor.thesis_table import FIGURE_4_2, thesis_table

if TYPE_CHECKING:
    from engine.factor.errors import Factorisation
    from engine.factor.projections import Projection

EXAMPLE = "lightarc factor lafortune:preset=blue-paint --terms 4 -o paint-factors --json"

_COLUMNS = (
    ("terms", 6),
    ("textures", 10),
    ("RMS·cos 1/sr", 14),
    ("sq. log", 10),
    ("held out: RMS", 14),
    ("sq. log", 14),
    ("size", 12),
    ("time", 10),
)

_TABLE_COLUMNS = (
    ("method", 10),
    ("over", 11),
    ("", 12),
    ("textures", 10),
    ("size", 12),
    ("sq. log", 10),
    ("abs. log", 10),
    ("RMS·cos 1/sr", 14),
    ("time", 10),
)

#: Default BRDFs of the table: the two models of Cole's Chapter 4.
TABLE_BRDFS = ("lafortune:preset=blue-paint", "cook-torrance")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "brdf", type=Input(), metavar="BRDF", nargs="*", help=f"{BRDF_HELP}; one, or several with --table"
    )
    parser.add_argument(
        "--table",
        action="store_true",
        help="compare searches, fixed projections and sums at equal bytes on each BRDF, as in Cole's Fig. 4.2; "
        "minutes each (blue paint, Cook-Torrance)",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Output(FACTORS),
        metavar="FACTORS",
        help="folder to write: factors.json and OpenEXR textures",
    )
    for flag, declared in _options().items():
        parser.add_argument(flag, **option(declared[0], "; ".join(map(words_of, declared))))
    parser.add_argument(
        "--resume", type=Input(), metavar="FACTORS", help="a folder of searched factors, to add more terms"
    )


def _options() -> dict[str, list[Parameter]]:
    """The parameters of every option, by its flag: two where sums and products each have their own."""
    found: dict[str, list[Parameter]] = {}
    for parameter in parameters(FactorSettings):
        found.setdefault(parameter.flag, []).append(parameter)
    return found


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    settings = _settings(arguments)
    is_search = arguments.table or settings.method in ("auto", "search")
    flags = ("--restarts", "--together", "--metric", "--preset")
    refuse_unused(arguments, [(flag, is_search, "--method search") for flag in flags])
    if arguments.table:
        return _table(arguments, settings, show)
    if len(arguments.brdf) != 1:
        raise UsageError(f"One BRDF is factored at a time, not {len(arguments.brdf)}; several need --table")
    text = arguments.brdf[0]
    if arguments.resume and settings.method != "search":
        raise UsageError("--resume needs --method search; other methods are quick and start anew")
    resume = read_factors(arguments.resume) if arguments.resume else None
    show(Step(0.0, "reading"))
    brdf = open_reflectance(text)
    started = time.perf_counter()
    best: Factorisation | None = None

    def keep(step: Step) -> None:
        nonlocal best
        best = step.partial or best
        if best is not None and arguments.output:
            ending.keep_work()
        show(step)

    cancelled = False
    try:
        found = drain(factor(brdf, settings, resume), keep)
    except KeyboardInterrupt:
        if best is None or not arguments.output:
            raise
        found, cancelled = best, True
    time_s = time.perf_counter() - started
    if arguments.output:
        show(Step(0.99, "writing"))
        found = write_factors(arguments.output, found)
    factors = found.factors
    texels = factors.hemisphere_map if isinstance(factors, SeparableFactors) else None
    return {
        "brdf": text,
        "output": arguments.output,
        "method": found.method,
        "parametrisation": factors.parametrisation,
        "map": texels.kind if texels is not None else None,
        "size": len(factors.textures[0]) if isinstance(factors, HomomorphicFactors) else factors.hemisphere_map.size,
        "reciprocal": bool(factors.reciprocal),
        "asymmetry": found.asymmetry,
        "condition_number": found.condition_number if math.isfinite(found.condition_number) else None,
        "optimum_ratio": found.optimum_ratio,
        "weighting": found.weighting or None,
        "converged": found.converged,
        "negative_energy_rel": found.negative_energy,
        "evaluations": found.evaluations,
        "projections": [_projection(each) for each in found.projections],
        "terms": [_term_error(term_error) for term_error in found.term_errors],
        "terms_not_stored": [_term_error(term_error) for term_error in found.left_out],
        "best_terms": found.best_terms,
        "held_out_by": found.held_out_by or None,
        "unmeasured": found.unmeasured or None,
        "choice": found.choice or None,
        "terms_share_time": texels is not None,
        "elevation_bands_deg": np.linspace(0.0, 90.0, BANDS + 1).tolist(),
        "samples": settings.samples,
        "max_theta_deg": settings.max_theta_deg,
        "epsilon": settings.epsilon,
        "seed": settings.seed,
        "time_s": time_s,
        "warnings": [*doubts_of_brdf(brdf), *doubts_of_brdf(found.factors)],
        "uses": list(uses(found, brdf) if cancelled else drain(advise(found, brdf))),
        "cancelled": cancelled,
        "exit_code": CANCELLED if cancelled else DONE,
    }


def _table(arguments: argparse.Namespace, settings: FactorSettings, show: Callable[[Step], None]) -> dict[str, Any]:
    """`table`: a row for each BRDF, method, parametrisation and reciprocity."""
    if arguments.output or arguments.resume:
        raise UsageError("--table compares and keeps nothing: leave out --output and --resume")
    search = search_settings(settings.with_texels(arguments.size or FIGURE_4_2.size))
    show(Step(0.0, "reading"))
    brdfs = {text: open_reflectance(text) for text in arguments.brdf or TABLE_BRDFS}
    steps = thesis_table(
        brdfs, settings=search, count=settings.samples, max_theta=settings.max_theta, seed=settings.seed
    )
    rows = drain(steps, show)
    return {
        "table": [{**_flat(asdict(row)), "projections": list(row.projections)} for row in rows],
        "warnings": [f"{text}: {each}" for text, brdf in brdfs.items() for each in doubts_of_brdf(brdf)],
    }


def _flat(values: dict[str, Any]) -> dict[str, Any]:
    return {**values, **values.pop("metrics")}


def _settings(arguments: argparse.Namespace) -> FactorSettings:
    """Settings as given, as far as the method reads them, and the defaults of the rest."""
    if arguments.table:
        arguments.method, arguments.parametrisation = "search", None
    separable = FactorSettings(arguments.method or FactorSettings.method).separable
    settings: FactorSettings = settings_from(
        arguments, FactorSettings, without=HOMOMORPHIC_PARAMETERS if separable else SEPARABLE_PARAMETERS
    )
    if settings.method == "auto":  # bounds of a sum are those of a product too
        settings = settings.with_terms(settings.products) if arguments.terms else settings
        settings = settings.with_texels(settings.side) if arguments.size else settings
    if settings.why_not:
        raise UsageError(settings.why_not)
    return settings


def _term_error(term_error: TermError) -> dict[str, Any]:
    return {**_flat(asdict(term_error)), "rms_by_elevation_band": list(term_error.rms_by_elevation_band)}


def _projection(projection: Projection) -> dict[str, Any]:
    rows = getattr(projection, "rows", None)
    return {"kind": projection.name} if rows is None else {"kind": projection.name, "rows": rows.tolist()}


def report(result: dict[str, Any]) -> str:
    """The result in words, for users who did not ask for JSON."""
    if "table" in result:
        return _report_table(result["table"])
    form = {"in-out": "light and viewer", "half-diff": "half and difference vector"}[result["parametrisation"]]
    title = f"{result['method']}, {form}, textures of {result['size']}²"
    lines = [f"{title}, {result['map']} map" if result["map"] else title]
    lines.append("".join(f"{word:>{width}}" for word, width in _COLUMNS))
    lines += [_line(term_error) for term_error in result["terms"]]
    lines += [f"{_line(term_error)}  not stored" for term_error in result["terms_not_stored"]]
    lines.append(
        f"RMS over 80,000 pairs of the hemisphere; logarithms over {result['samples']:,} samples up to "
        f"{result['max_theta_deg']:g}° of a formula, or the measured ones"
    )
    lines += _on_held_out(result)
    if result["choice"]:
        lines.append(result["choice"])
    if result["terms"]:
        bands = "  ".join(number(rms, 3) for rms in result["terms"][-1]["rms_by_elevation_band"])
        lines.append(f"RMS of all terms by the viewer's elevation, from 0° upwards in bands of 10°: {bands}")
    if result["terms_share_time"] and len(result["terms"]) > 1:
        lines.append("All terms come from one decomposition and have its time.")
    if result["optimum_ratio"]:
        lines.append(
            f"asymmetry of the matrix {number(result['asymmetry'])}; truncation error over the optimum "
            f"{number(result['optimum_ratio'], 10)} in the {result['weighting']} norm"
        )
    if not result["converged"]:
        lines.append("The iteration stopped before it converged; these are its best terms.")
    if result["negative_energy_rel"]:
        lines.append(f"Sums below 0 are taken as 0, which adds {percent(result['negative_energy_rel'])} to the energy.")
    if result["projections"]:
        lines.append(f"projections: {', '.join(each['kind'] for each in result['projections'])}")
    lines += result["uses"]
    if result["cancelled"]:
        lines.append("Cancelled: these are the best factors so far; a search continues from them with --resume.")
    if result["output"]:
        lines.append(f"written to {result['output']}")
    return "\n".join(lines)


def _line(term_error: dict[str, Any]) -> str:
    held = [term_error[name] for name in ("held_out_rms_cosine_weighted", "held_out_sq_log")]
    columns = "".join(f"{number(value, 4):>14}" if value is not None else f"{'–':>14}" for value in held)
    rms, log = number(term_error["rms_cosine_weighted"], 4), number(term_error["sq_log"], 4)
    return (
        f"{term_error['terms']:6d}{term_error['textures']:10d}{rms:>14}{log:>10}{columns}"
        f"{size_text(term_error['size_bytes']):>12}{time_text(term_error['time_s'], 3):>10}"
    )


def _on_held_out(result: dict[str, Any]) -> list[str]:
    """Sentences on what held-out errors leave out and choose, and on where nothing was measured."""
    lines = []
    if result["held_out_by"] == "regions":
        lines.append("Held-out errors are those at samples of whole regions of directions that were left out in turn.")
    elif result["held_out_by"]:
        lines.append("The factors are made at the centres of texels alone: errors between them are held-out ones.")
    else:
        lines.append("Too few measurements to leave out regions of them: nothing is known between the samples.")
    best = result["best_terms"]
    if best is not None:
        by = "RMS" if result["map"] else "RMS and logarithm"
        further = "; more make it worse and are not stored" if result["terms_not_stored"] else ""
        lines.append(f"Best with {best} term{'s'[: best != 1]} by the held-out {by}{further}.")
    if result["unmeasured"]:
        lines.append(result["unmeasured"])
    return lines


def _report_table(rows: list[dict[str, Any]]) -> str:
    lines: list[str] = []
    shown = None
    for row in rows:
        if row["brdf"] != shown:
            shown = row["brdf"]
            domain = f"{row['samples']:,} samples, formulas up to {row['max_theta_deg']:g}°"
            lines.append(f"{shown}: {domain}; RMS over the hemisphere")
            lines.append("".join(f"{word:>{width}}" for word, width in _TABLE_COLUMNS))
        reciprocal = "reciprocal" if row["reciprocal"] else ""
        lines.append(
            f"{row['method']:>10}{row['parametrisation']:>11}{reciprocal:>12}{row['textures']:10d}"
            f"{size_text(row['size_bytes']):>12}{number(row['sq_log'], 4):>10}{number(row['abs_log'], 4):>10}"
            f"{number(row['rms_cosine_weighted'], 4):>14}{time_text(row['time_s'], 3):>10}"
            f"  {', '.join(row['projections'])}"
        )
    return "\n".join(lines)

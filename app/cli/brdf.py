"""`lightarc brdf`: list, look at, evaluate, fit and convert BRDFs, analytic or measured."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from app.arguments.quantities import Degrees
from app.arguments.results import FIT, TABLE, Input, Output
from app.cli.doubts import doubts_of_brdf
from engine.brdf.analysis import conserves_energy, doubts, maximum_albedo, reciprocity_error
from engine.brdf.brdf import MODELS, brdf_from_text, brdf_to_text, model_name
from engine.brdf.fit import Residual, fit_data
from engine.brdf.models.presets import PRESETS
from engine.brdf.ranking import Offer, fit_both, miss, offer, warning
from engine.brdf.readers.csv_samples import directions_from_degrees
from engine.brdf.readers.merl import SIZE_BYTES, write_merl
from engine.brdf.readers.samples_child import read_directions
from engine.brdf.readers.table_file import write_table
from engine.brdf.resample import SHAPE, resample
from engine.brdf.samples import BELOW_HORIZON
from engine.brdf.table import DirectionTable, HalfDifferenceTable
from engine.brdf.written import one_request
from engine.core.errors import UsageError
from engine.core.figure_text import number, percent, shorten
from engine.core.params import parameters
from engine.core.steps import Step, drain
from engine.factor.factor_file import open_reflectance
from engine.storage.atomic import require_space, write_json
from engine.storage.readers import readers

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from engine.brdf.brdf import Brdf

EXAMPLE = "lightarc brdf eval ggx:alpha=0.2 --wi-deg 30,0 --wo-deg 30,180 --json"

BRDF_HELP = (
    "a measured file, a folder of factors, or model:name=value,… or model:preset=name (see `lightarc brdf list`)"
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)

    _action(actions, "list", "the models with their parameters, the presets, and the formats that are read", brdf=False)

    info = _action(actions, "info", "kind, samples, reciprocity, largest albedo")
    info.add_argument("--seed", type=int, default=0, metavar="N", help="seed of the compared pairs of directions (0)")

    evaluate = _action(actions, "eval", "values in 1/sr without the cosine")
    evaluate.add_argument(
        "--directions",
        type=Input(),
        metavar="FILE",
        help="CSV of theta_i, phi_i, theta_o, phi_o in degrees, a pair a line",
    )
    pair = Degrees(2, "30,0")
    evaluate.add_argument("--wi-deg", type=pair, metavar="THETA,PHI", help="a single pair: towards the light")
    evaluate.add_argument("--wo-deg", type=pair, metavar="THETA,PHI", help="a single pair: towards the viewer")

    fit = _action(actions, "fit", "the parameters of the model that fit best")
    fit.add_argument("--model", type=str, metavar="MODEL", help="e.g. ggx, or ggx:alpha=0.3 to start from there")
    fit.add_argument("--rank", action="store_true", help="fit every model and rank them by the error of --weighting")
    fit.add_argument(
        "--fix", type=str, default="", metavar="NAMES", help="parameters that keep their value, e.g. f0,kd"
    )
    fit.add_argument(
        "--weighting",
        default="joint",
        choices=("joint", "log", "cosine"),
        help="weight of the errors: joint, relative to the value and with the albedo of the data; log, relative to the "
        "value; cosine, by energy",
    )
    fit.add_argument("--samples", type=int, default=8000, metavar="N", help="number of compared directions (8000)")
    fit.add_argument("--seed", type=int, default=0, metavar="N", help="seed of directions and starts (0)")
    fit.add_argument(
        "-o",
        "--output",
        type=Output(FIT),
        metavar="FILE",
        help="write the fit, or the ranking, with its errors as .json",
    )

    convert = _action(actions, "convert", "write a table: .binary (MERL) or .exr (Lightarc)")
    convert.add_argument(
        "-o", "--output", required=True, type=Output(TABLE), metavar="FILE", help=".binary (MERL) or .exr (Lightarc)"
    )


def _action(
    actions: argparse._SubParsersAction[argparse.ArgumentParser], name: str, words: str, *, brdf: bool = True
) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = actions.add_parser(name, help=words, description=f"{words.capitalize()}.")
    if brdf:
        parser.add_argument("brdf", type=Input(), metavar="BRDF", help=BRDF_HELP)
    return parser


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    actions = {"list": _list, "info": _info, "eval": _evaluate, "fit": _fit, "convert": _convert}
    return actions[arguments.action](arguments, show)


def _check_seed(arguments: argparse.Namespace) -> None:
    if arguments.seed < 0:
        raise UsageError(f"--seed {arguments.seed} is negative")


def _open(text: str) -> Brdf:
    return open_reflectance(text)


def _list(_arguments: argparse.Namespace, _show: Callable[[Step], None]) -> dict[str, Any]:
    """`models`: name, what it is, its parameters with range, unit and default; `presets`; `formats` that are read."""
    return {
        "models": [
            {
                "name": name,
                "reciprocal": model().reciprocal,
                "isotropic": model().isotropic,
                "parameters": [
                    {"name": p.name, "default": p.default, "low": p.low, "high": p.high, "unit": p.unit, "doc": p.doc}
                    for p in parameters(model)
                ],
            }
            for name, model in MODELS.items()
        ],
        "presets": [{"name": preset.name, "brdf": preset.text, "source": preset.source} for preset in PRESETS],
        "formats": [known.title for known in readers("brdf")],
        "warnings": [],
    }


def _info(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    """Describe a BRDF; for a measurement also its samples and its defects."""
    with one_request():
        return _describe(arguments, show)


def _describe(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    _check_seed(arguments)
    show(Step(0.0, "reading"))
    brdf: Any = _open(arguments.brdf)
    analytic = type(brdf) in MODELS.values()
    measured = hasattr(brdf, "samples")
    below = int(brdf.health.figures.get(BELOW_HORIZON, 0)) if measured else 0
    result: dict[str, Any] = {
        "name": arguments.brdf if analytic else brdf.name,
        "kind": "analytic model" if analytic else brdf.kind,
        "isotropic": brdf.isotropic,
        "reciprocal": brdf.reciprocal,
        "samples": brdf.samples if measured else 0,
        "invalid_samples": brdf.invalid_samples - below if measured else 0,
        "samples_below_horizon": below,
    }
    show(Step(0.4, "exchanging light and viewer"))
    error = reciprocity_error(brdf, seed=arguments.seed)
    result |= {"reciprocity_rms_rel": error.rms, "reciprocity_max_rel": error.largest, "reciprocity_pairs": error.pairs}
    show(Step(0.6, "integrating"))
    largest = maximum_albedo(brdf)
    result |= {
        "energy_conserving": conserves_energy(brdf, largest),
        "maximum_albedo": list(largest.albedo),
        "maximum_albedo_theta_deg": float(np.degrees(largest.theta)),
        "maximum_albedo_phi_deg": float(np.degrees(largest.phi)),
    }
    for figure in ("condition_number", "leave_one_out", "leave_one_out_log"):
        if hasattr(brdf, figure):
            result[figure] = float(getattr(brdf, figure))
    result["warnings"] = [*doubts_of_brdf(brdf), *(doubts(brdf, error, largest) if measured else ())]
    return result


def _evaluate(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    """`values`: [R, G, B] for each pair of directions, linear sRGB in 1/sr without the cosine."""
    single = arguments.wi_deg is not None and arguments.wo_deg is not None
    if single == (arguments.directions is not None) or (arguments.wi_deg is None) != (arguments.wo_deg is None):
        raise UsageError("Give either --directions FILE, or --wi-deg and --wo-deg together")
    wi, wo = _directions(arguments)
    show(Step(0.2, "reading"))
    brdf = _open(arguments.brdf)
    show(Step(0.6, "evaluating"))
    values = {"values": brdf.f(wi, wo).tolist(), "unit": "1/sr", "cosine": False}
    return {"brdf": arguments.brdf, **values, "warnings": doubts_of_brdf(brdf)}


def _directions(arguments: argparse.Namespace) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    if arguments.directions is not None:
        return read_directions(Path(arguments.directions))
    return directions_from_degrees(np.array([[*arguments.wi_deg, *arguments.wo_deg]]))


def _fit(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    """The fitted model, or the ranking of all; written to a file where one is named."""
    if arguments.samples < 1:
        raise UsageError(f"--samples {arguments.samples} is too few")
    _check_seed(arguments)
    if arguments.rank == (arguments.model is not None):
        raise UsageError("Give either --model MODEL or --rank")
    if arguments.rank and arguments.fix:
        raise UsageError("--fix names parameters of one model, and --rank fits all of them")
    result = _ranking(arguments, show) if arguments.rank else _fit_one(arguments, show)
    if arguments.output:
        write_json(arguments.output, result)
    return {**result, "output": arguments.output}


def _ranking(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    """`ranking`: each model fitted, from the least error up; `best` in the linear and in the logarithmic norm."""
    from engine.brdf.ranking import best, miss, rank

    show(Step(0.0, "reading"))
    brdf = _open(arguments.brdf)
    data = fit_data(brdf, count=arguments.samples, seed=arguments.seed)
    models = [model() for model in MODELS.values()]
    offers = drain(rank(data, models, weighting=arguments.weighting, seed=arguments.seed), show)
    nearest = best(offers)
    return {
        "brdf": arguments.brdf,
        "weighting": arguments.weighting,
        "samples": len(data.value),
        "ranking": [_offer(each) for each in offers],
        "best": {norm: _offer(each) for norm, each in nearest.items()},
        "warnings": [*doubts_of_brdf(brdf), *filter(None, [miss(nearest["linear"])])],
    }


def _offer(offer: Offer) -> dict[str, Any]:
    return {
        "model": model_name(offer.brdf),
        "fitted": brdf_to_text(offer.brdf),
        "rmse_rel": offer.linear,
        "rmse_log": offer.log,
    }


def _fit_one(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    """The fitted model as text and numbers, errors before and after, and by angle; `best` where one norm grew."""

    from engine.brdf.fit import fit, fit_data

    start = brdf_from_text(arguments.model)
    fixed = tuple(filter(None, (name.strip() for name in arguments.fix.split(","))))
    names = [parameter.name for parameter in parameters(start)]
    for name in fixed:
        if name not in names:
            raise UsageError(f"--fix names {name!r}; the parameters of {model_name(start)} are {', '.join(names)}")
    show(Step(0.0, "reading"))
    brdf = _open(arguments.brdf)
    data = fit_data(brdf, count=arguments.samples, seed=arguments.seed)
    steps = fit(data, start, weighting=arguments.weighting, fixed=fixed, seed=arguments.seed)
    found = drain(steps, show)
    before, after = offer(start, data), offer(found.brdf, data)
    grown = warning(before, after)
    best = {}
    if grown:
        words = {"weighting": arguments.weighting, "fixed": fixed, "seed": arguments.seed}
        best = drain(fit_both(data, start, found, **words), show)
    return {
        "brdf": arguments.brdf,
        "model": model_name(found.brdf),
        "fitted": brdf_to_text(found.brdf),
        "parameters": {p.name: getattr(found.brdf, p.name) for p in parameters(found.brdf)},
        "weighting": arguments.weighting,
        "samples": len(data.value),
        "rmse_rel_before": found.before.rmse_rel,
        "rmse_rel_after": found.after.rmse_rel,
        "objective_before": found.before.objective,
        "objective_after": found.after.objective,
        "residual_by_angle": {name: _bands(remains) for name, remains in found.by_angle.items()},
        "rmse_log_before": before.log,
        "rmse_log_after": after.log,
        "warnings": [*doubts_of_brdf(brdf), *filter(None, [grown, miss(after)])],
        "best": {norm: _offer(each) for norm, each in best.items()},
        "evaluations": found.evaluations,
    }


def _bands(remains: Residual) -> list[dict[str, Any]]:
    """The error of a fit in each band of an angle."""
    edges = [round(math.degrees(edge), 6) for edge in remains.edges]
    rows = zip(edges[:-1], edges[1:], remains.rms.tolist(), remains.count.tolist(), strict=True)
    return [{"from_deg": low, "to_deg": high, "rmse_rel": rms, "samples": count} for low, high, rms, count in rows]


def _convert(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    """Write a BRDF as a table, and report the error of the table."""
    output = Path(arguments.output)
    require_space(output, SIZE_BYTES)
    show(Step(0.0, "reading"))
    merl = output.suffix.lower() == ".binary"
    table: Any = _open(arguments.brdf)
    kept = isinstance(table, HalfDifferenceTable) and (table.missing.shape == SHAPE or not merl)
    if not kept and (merl or not isinstance(table, DirectionTable)):
        table = drain(resample(table), show)
    show(Step(0.96, "writing"))
    stored = write_merl(output, table) if merl else write_table(output, table)
    return {
        "brdf": arguments.brdf,
        "output": str(output),
        "format": "MERL" if merl else "Lightarc table",
        "shape": list(stored.missing.shape),
        "samples": stored.samples,
        "invalid_samples": stored.invalid_samples,
        "size_bytes": output.stat().st_size,
        "resampling_rms_rel": 0.0 if kept else float(stored.health.figures.get("resampling_rms_rel", 0.0)),
        "warnings": stored.health.warnings,
    }


def report(result: dict[str, Any]) -> str:
    """The result in words, for users who did not ask for JSON."""
    if "models" in result:
        return _catalogue(result)
    if "values" in result:
        rows = "\n".join("  ".join(f"{number(each, 6):>12}" for each in value) for value in result["values"])
        return f"R, G, B in 1/sr, without the cosine:\n{rows}"
    if "ranking" in result:
        return _report_ranking(result)
    if "fitted" in result:
        bands = result["residual_by_angle"]["theta_h"]
        lines = [shorten(result["fitted"])]
        lines += [f"error {percent(result['rmse_rel_before'], 3)} before, {percent(result['rmse_rel_after'], 3)} after"]
        lines += [
            f"  theta_h {band['from_deg']:2.0f} to {band['to_deg']:2.0f} deg: {percent(band['rmse_rel'], 3):>9}"
            for band in bands
            if band["samples"]
        ]
        return "\n".join([*lines, *_best(result)])
    words = [f"{key.replace('_', ' ')}: {_words(value)}" for key, value in result.items() if key != "warnings"]
    return "\n".join(words)


def _report_ranking(result: dict[str, Any]) -> str:
    lines = [f"{'linear':>9}{'log':>10}  model, by the {result['weighting']} error"]
    lines += [_line(offer) for offer in result["ranking"]]
    return "\n".join([*lines, *_best(result)])


def _line(offer: dict[str, Any]) -> str:
    return f"{percent(offer['rmse_rel'], 3):>9}{number(offer['rmse_log'], 3):>10}  {shorten(offer['fitted'])}"


def _best(result: dict[str, Any]) -> list[str]:
    return [
        f"best in the {words} norm: {_line(result['best'][norm]).strip()}"
        for norm, words in (("linear", "linear"), ("log", "logarithmic"))
        if norm in result["best"]
    ]


def _words(value: object) -> str:
    if isinstance(value, list):
        return ", ".join(_words(item) for item in value) or "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return number(value, 4) if isinstance(value, float) else str(value)


def _catalogue(result: dict[str, Any]) -> str:
    lines = []
    for model in result["models"]:
        lines.append(model["name"])
        for p in model["parameters"]:
            unit = f" {p['unit']}" if p["unit"] else ""
            default = p["default"][0] if isinstance(p["default"], tuple) else p["default"]
            lines.append(f"  {p['name']:<11} {default:g} in [{p['low']:g}, {p['high']:g}]{unit}  {p['doc']}")
    lines += ["", "presets", *(f"  {preset['brdf']}" for preset in result["presets"])]
    lines += ["", f"measured files: {', '.join(result['formats'])}"]
    return "\n".join(lines)

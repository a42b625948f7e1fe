"""`lightarc figures`: the papers' figures as pictures, each panel with its error against the reference."""

from __future__ import annotations

import argparse
import importlib
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.results import Input, Output, figures_in
from engine.steps import Step, drain, part

if TYPE_CHECKING:
    from engine.figures.figure import Settings

HELP = "Draw the papers' figures, each panel with its error against the reference."
EXAMPLE = "lightarc figures kautz-6 wang-2 -o figures"

#: Name of a figure, the function that makes it, and what it shows.
FIGURES = {
    "kautz-6": ("engine.figures.kautz_6:kautz_6", "order of harmonics against glossiness"),
    "wang-2": ("engine.figures.wang_2:wang_2", "terms of a reflectance against the analytic model"),
    "wang-3": ("engine.figures.wang_3:wang_3", "wavelet coefficients against the sharpness of shadows"),
    "wang-4": ("engine.figures.wang_4:wang_4", "reflectances as sums of products, with their RMS curves"),
    "green-5": ("engine.figures.green_5:green_5", "Gaussians, wavelets and harmonics of as many numbers"),
    "green-6": ("engine.figures.green_6:green_6", "lobes with visibility and prefiltered light without"),
    "green-7": ("engine.figures.green_7:green_7", "one lobe against two"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    known = "; ".join(f"{name}: {words}" for name, (_, words) in FIGURES.items())
    parser.add_argument("names", type=str, nargs="+", metavar="NAME", help=f"{known}; all: every one of them")
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        type=Output(figures_in, Path),
        metavar="FOLDER",
        help="each gets a folder there",
    )
    parser.add_argument(
        "--mesh",
        type=Input(reach="file"),
        metavar="MESH",
        help="a file or a built-in model in place of the figures' own",
    )
    parser.add_argument(
        "--env",
        type=Input(reach="file"),
        metavar="FILE",
        help="light of the figures that show an environment, as for render",
    )
    parser.add_argument("--quick", action="store_true", help="few vertices, pixels and samples, to see that it works")


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    from app.cli import CANCELLED, DONE, usage
    from engine.figures.write import drawn_into

    names = usage(_chosen, arguments.names)
    settings = _settings(arguments)
    figures: list[dict[str, Any]] = []
    cancelled = False
    for index, name in enumerate(names):
        started = time.perf_counter()
        steps = drawn_into(arguments.output, name, _function(FIGURES[name][0])(settings))
        share = part(steps, index / len(names), (index + 1) / len(names))
        try:
            record = usage(drain, share, lambda step, name=name: show(Step(step.done, f"{name}: {step.note}")))
        except KeyboardInterrupt:
            if not figures:
                raise
            cancelled = True
            break
        figures.append({**record, "time_s": time.perf_counter() - started})
    return {
        "output": str(arguments.output),
        "figures": [{key: value for key, value in figure.items() if key != "pictures"} for figure in figures],
        "pictures": [picture for figure in figures for picture in figure["pictures"]],
        "warnings": list(settings.warnings),
        "cancelled": cancelled,
        "exit_code": CANCELLED if cancelled else DONE,
    }


def report(result: dict[str, Any]) -> str:
    lines = []
    for figure in result["figures"]:
        folder = Path(result["output"]) / figure["name"]
        lines.append(f"{folder / figure['picture']}: {figure['title']}, {figure['time_s']:.0f} s")
        lines += [_line(picture) for picture in result["pictures"] if picture["name"] == figure["name"]]
    end = ["Cancelled; the figures above are complete."] if result["cancelled"] else []
    return "\n".join([*filter(None, lines), *result["warnings"], *end])


def _line(picture: dict[str, Any]) -> str:
    if picture["error_rmse_rel"] is None:
        return ""
    error, spread = 100.0 * picture["error_rmse_rel"], 100.0 * picture["error_uncertainty"]
    return f"  {picture['panel']:60} {error:8.2f} % ± {spread:.2f}"


def _chosen(names: list[str]) -> list[str]:
    """All names, each once, in the order given."""
    wanted = [each for name in names for each in (FIGURES if name == "all" else (name,))]
    strange = [name for name in wanted if name not in FIGURES]
    if strange:
        raise ValueError(f"{strange[0]!r} is no figure; known are {', '.join(FIGURES)} and all")
    return list(dict.fromkeys(wanted))


def _settings(arguments: argparse.Namespace) -> Settings:
    from engine.environment_file import open_environment
    from engine.figures.figure import Settings
    from engine.shapes import open_mesh

    mesh = open_mesh(arguments.mesh) if arguments.mesh else None
    environment = open_environment(arguments.env) if arguments.env else None
    return Settings(mesh, environment, arguments.quick)


def _function(place: str) -> Any:
    module, function = place.split(":")
    return getattr(importlib.import_module(module), function)

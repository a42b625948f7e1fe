"""`lightarc figures`: the papers' figures as images, each panel with its error against the reference."""

from __future__ import annotations

import argparse
import importlib
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.arguments.results import Input, Output, figures_in
from app.arguments.usage import CANCELLED, DONE
from engine.core.errors import UsageError
from engine.core.figure_text import percent_within, time_text
from engine.core.steps import Step, drain, part
from engine.core.suggestion import suggest
from engine.figures.papers.catalogue import FIGURES
from engine.geometry.shapes import open_mesh
from engine.light.environment_file import open_environment

if TYPE_CHECKING:
    from engine.figures.figure import Settings

EXAMPLE = "lightarc figures kautz-6 wang-2 -o figures"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    known = "; ".join(f"{name}: {words}" for name, (_, words) in FIGURES.items())
    parser.add_argument("names", type=str, nargs="+", metavar="NAME", help=f"{known}; all: every one of them")
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        type=Output(figures_in, Path),
        metavar="FOLDER",
        help="folder for the results; each figure gets a subfolder",
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
        help="environment of the figures that show one, as for render",
    )
    parser.add_argument("--quick", action="store_true", help="few vertices, pixels and samples, as a quick test")


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    from engine.figures.write import draw_into

    names = _choose(arguments.names)
    settings = _settings(arguments)
    figures: list[dict[str, Any]] = []
    cancelled = False
    for index, name in enumerate(names):
        started = time.perf_counter()
        steps = draw_into(arguments.output, name, _function(FIGURES[name][0])(settings))
        share = part(steps, index / len(names), (index + 1) / len(names))
        try:
            record = drain(share, _name_notes(name, show))
        except KeyboardInterrupt:
            if not figures:
                raise
            cancelled = True
            break
        figures.append({**record, "time_s": time.perf_counter() - started})
    return {
        "output": str(arguments.output),
        "figures": [{key: value for key, value in figure.items() if key != "pictures"} for figure in figures],
        "pictures": [image for figure in figures for image in figure["pictures"]],
        "left": names[len(figures) :],
        "warnings": list(settings.warnings),
        "cancelled": cancelled,
        "exit_code": CANCELLED if cancelled else DONE,
    }


def _name_notes(name: str, show: Callable[[Step], None]) -> Callable[[Step], None]:
    """`show` with the name of the figure before each note."""
    return lambda step: show(Step(step.done, f"{name}: {step.note}"))


def report(result: dict[str, Any]) -> str:
    lines = []
    for figure in result["figures"]:
        folder = Path(result["output"]) / figure["name"]
        lines.append(f"{folder / figure['picture']}: {figure['title']}, {time_text(figure['time_s'])}")
        lines += [_line(image) for image in result["pictures"] if image["name"] == figure["name"]]
    left = ", ".join(result["left"])
    end = [f"Cancelled; the figures above are complete. Left: {left}"] if result["cancelled"] else []
    return "\n".join([*filter(None, lines), *end])


def _line(image: dict[str, Any]) -> str:
    if image["error_rmse_rel"] is None:
        return ""
    error = percent_within(image["error_rmse_rel"], image["error_uncertainty"])
    return f"  {image['panel']:60} {error:>16}"


def _choose(names: list[str]) -> list[str]:
    """All names, each once, in the order given."""
    wanted = [each for name in names for each in (FIGURES if name == "all" else (name,))]
    strange = [name for name in wanted if name not in FIGURES]
    if strange:
        raise UsageError(
            f"unknown figure {strange[0]!r}{suggest(strange[0], FIGURES)}; choose from {', '.join(FIGURES)} and all"
        )
    return list(dict.fromkeys(wanted))


def _settings(arguments: argparse.Namespace) -> Settings:
    from engine.figures.figure import Settings

    mesh = open_mesh(arguments.mesh) if arguments.mesh else None
    environment = open_environment(arguments.env) if arguments.env else None
    return Settings(mesh, environment, arguments.quick)


def _function(place: str) -> Any:
    module, function = place.split(":")
    return getattr(importlib.import_module(module), function)

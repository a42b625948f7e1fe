"""`lightarc demo`: the whole path on the built-in sample, with a contact sheet to look at."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from app.arguments.results import DEMO, Output
from engine.core.figure_text import time_text
from engine.core.steps import Step, drain
from engine.figures.demo import demo

EXAMPLE = "lightarc demo -o demo"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "-o", "--output", required=True, type=Output(DEMO, Path), metavar="FOLDER", help="folder for the results"
    )


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    made = drain(demo(arguments.output), show)
    return {
        "bundle": str(made.bundle) if made.bundle else None,
        "images": [str(image) for image in made.images],
        "stages": [{key: value for key, value in asdict(stage).items() if value is not None} for stage in made.stages],
        "warnings": list(made.warnings),
    }


def report(result: dict[str, Any]) -> str:
    lines = [
        f"{stage['name']:14}{time_text(stage['time_s']):>8}  {stage.get('error', '')}".rstrip()
        for stage in result["stages"]
    ]
    return "\n".join([*lines, *filter(None, [result["bundle"]]), *result["images"]])

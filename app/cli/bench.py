"""`lightarc bench`, deprecated: the benchmarks are part of the source code, not of the installed program."""

from __future__ import annotations

import argparse
import importlib
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import app
from engine.core.errors import MissingCapability
from engine.core.steps import Step

EXAMPLE = "lightarc bench --only linearise power-law-fit"

COMMAND = Path(app.__file__).parents[1] / "benchmarks" / "command.py"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    if COMMAND.is_file():
        _command().add_arguments(parser)
    else:
        parser.add_argument("--only", nargs="+", metavar="NAME", help=argparse.SUPPRESS)
        parser.add_argument("--large", action="store_true", help=argparse.SUPPRESS)


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    if not COMMAND.is_file():
        raise MissingCapability(
            "The benchmarks are part of Lightarc's source code and are not installed",
            "Run them there with: python3 packaging/dev.py bench",
        )
    result: dict[str, Any] = _command().run(arguments, show)
    return result


def report(result: dict[str, Any]) -> str:
    return str(_command().report(result))


def _command() -> ModuleType:
    return importlib.import_module("benchmarks.command")

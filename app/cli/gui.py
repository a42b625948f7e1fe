"""`lightarc gui`, and `lightarc` alone: the window."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from app.arguments.results import Input
from app.process import ending
from engine.core.errors import MissingCapability
from engine.core.steps import Step

NAME = "gui"
EXAMPLE = "lightarc gui --sample"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "files",
        nargs="*",
        type=Input(Path),
        metavar="FILE",
        help="a project, photographs, a folder, a mesh, a bundle",
    )
    parser.add_argument("--sample", action="store_true", help="begin with the woven cloth, the first of the examples")


def run(options: argparse.Namespace, _show: Callable[[Step], None]) -> dict[str, Any]:
    """Open the window; `exit_code` when it is closed. MissingCapability without a display or without Qt's libraries."""
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise MissingCapability(
            "There is no display to open a window on",
            "Run lightarc demo -o FOLDER for the same work without a window, or set DISPLAY",
        )
    try:
        with ending.during(ending.END):
            from app.window.application import run as open_window
    except ImportError as error:
        raise MissingCapability(
            f"The window needs a library that is missing ({error})",
            "Install the extra gui: pip install 'lightarc[gui]', or in a checkout run python3 packaging/dev.py run",
        ) from None
    return {"exit_code": open_window(getattr(options, "files", []), sample=getattr(options, "sample", False))}


def report(_result: dict[str, Any]) -> str:
    return ""

"""Find and run the commands of the README and of the manual.

    python packaging/manual_commands.py [PAGE …] -o FOLDER

A command is a line of a code block that begins with `lightarc`, after `$ ` or not, with all lines that a backslash at
the end of a line joins to it. Blocks of Python are run as well. The commands of a page follow one another in one
folder, which is empty before the first.
"""

from __future__ import annotations

import argparse
import os
import re
import shlex
import subprocess
import sys
import textwrap
import time
from collections.abc import Iterator
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1]
MANUAL = PROJECT / "docs" / "manual"


def tutorials() -> list[Path]:
    """The pages whose commands can be run as they are."""
    return sorted(path for path in (MANUAL / "tutorials").glob("*.md") if path.stem != "index")


def pages() -> list[Path]:
    """All pages with commands: the README and the manual, without what is written from declarations."""
    return [PROJECT / "README.md", *sorted(MANUAL.rglob("*.md"))]


def steps(page: Path) -> Iterator[str]:
    """The commands and scripts of a page in their order: lines that begin with `lightarc`, and blocks of Python."""
    text = page.read_text(encoding="utf-8").replace("\\\n", " ")
    fenced = r"^(?P<indent> *)```(?P<kind>\w*)\n(?P<content>.*?)^(?P=indent)```$"
    for block in re.finditer(rf"{fenced}|^ {{4,}}(?P<line>lightarc [^\n]*)$", text, re.MULTILINE | re.DOTALL):
        if block["line"]:
            yield block["line"]
        elif block["kind"] == "python":
            yield textwrap.dedent(block["content"])
        elif block["kind"] in {"", "console"}:
            yield from (found[1] for found in re.finditer(r"^ *(?:\$ )?(lightarc .*)$", block["content"], re.MULTILINE))


def commands(page: Path) -> list[list[str]]:
    """The words of each command of a page, without `lightarc`."""
    return [shlex.split(step)[1:] for step in steps(page) if step.startswith("lightarc ")]


def run_commands(page: Path, folder: Path) -> None:
    """Run everything in `folder`; RuntimeError with the output of the first one that fails."""
    for step in steps(page):
        begun = time.monotonic()
        output = run_step(step, folder)
        print(f"{time.monotonic() - begun:6.1f} s  {step}\n{output}", flush=True)


def run_step(step: str, folder: Path) -> str:
    """Run a command or a script in `folder`; what it prints."""
    words = ["-m", "app", *shlex.split(step)[1:]] if step.startswith("lightarc ") else ["-c", step]
    environment = {**os.environ, "PYTHONPATH": str(PROJECT)}
    done = subprocess.run([sys.executable, *words], cwd=folder, env=environment, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{step}\n{done.stdout}{done.stderr}")
    return done.stdout + done.stderr


def main() -> int:
    parser = argparse.ArgumentParser(description="Run the commands of pages.")
    parser.add_argument("pages", nargs="*", type=Path, default=tutorials(), metavar="PAGE")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FOLDER")
    options = parser.parse_args()
    for page in options.pages:
        folder = options.output / page.stem
        folder.mkdir(parents=True)
        run_commands(page, folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())

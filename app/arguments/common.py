"""Options of every verb, and their effect: what is printed and logged, and how many threads and how much memory."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TextIO

import engine
from app.arguments.quantities import size_bytes
from app.arguments.results import LOG, Output
from engine.core.budget import limit_memory, limit_threads
from engine.core.escape import escape_controls
from engine.storage.atomic import explaining
from engine.storage.text import whole_number

#: Most threads that can be asked for.
MAX_THREADS = 4096


def thread_number(text: str) -> int:
    """A number of threads, as argparse's `type`."""
    count = whole_number(text, MAX_THREADS)
    if not count:
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is not a number from 1 to {MAX_THREADS}")
    return count


#: The options, each with what argparse's `add_argument` takes.
OPTIONS: dict[str, dict[str, Any]] = {
    "--overwrite": {
        "action": "store_true",
        "help": "replace an existing file that this command did not write; never one that it reads",
    },
    "--json": {"action": "store_true", "help": "print one JSON object on standard output"},
    "--quiet": {"action": "store_true", "help": "print warnings and errors alone: no progress and no summary"},
    "--log": {
        "type": Output(LOG),
        "metavar": "FILE",
        "help": "also write progress, messages and the summary into this file (.log), with times, while they come",
    },
    "--threads": {
        "type": thread_number,
        "metavar": "N",
        "help": "threads of kernels, linear algebra and drawing on the CPU (one for each CPU); photographs are decoded "
        "by as many processes beside them, at least two",
    },
    "--memory": {
        "type": size_bytes,
        "metavar": "SIZE",
        "help": "most memory, as 4GB: plans and batches stay below it; on Linux images that would take more lie in the "
        "folder for temporary files, and what needs more all the same ends with exit code 6. Each process that decodes "
        "photographs may take as much",
    },
}


def add_common(parser: argparse.ArgumentParser, *, is_top: bool = True) -> None:
    """Add `OPTIONS` to the top parser and all below, whose defaults must not replace what stood before the verb."""
    group = parser.add_argument_group("every command") if parser._actions and not is_top else parser
    for flag, settings in OPTIONS.items():
        group.add_argument(flag, **settings | ({} if is_top else {"default": argparse.SUPPRESS}))
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for below in dict.fromkeys(action.choices.values()):
                add_common(below, is_top=False)


def find_threads(words: list[str]) -> int | None:
    """The number of threads that is asked for, before the words are parsed; None where there is none that can be.

    Libraries read it when they are loaded, which the parser of a verb does.
    """
    early = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    early.add_argument("--threads", nargs="?")
    found = early.parse_known_args(words)[0].threads
    return whole_number(found, MAX_THREADS) or None if found is not None else None


@contextmanager
def limits(options: argparse.Namespace) -> Iterator[None]:
    """Within the block --threads and --memory hold."""
    with ExitStack() as held:
        if options.threads is not None:
            held.enter_context(limit_threads(options.threads))
        if options.memory is not None:
            from engine.storage.spilling import spill_arrays  # it loads numpy

            held.enter_context(limit_memory(options.memory))
            held.enter_context(spill_arrays(options.memory))
        yield


@dataclass(frozen=True)
class Line:
    """A sentence that stays on the terminal, as the partial result of a step."""

    text: str


class Log:
    """Lines of a file, each with its time, written as they come: a log is read while work goes on, or after a crash.

    `write` is without effect where no file was asked for.
    """

    def __init__(self, path: str | None, words: Sequence[str]) -> None:
        self.path, self.begun = Path(path or ""), time.monotonic()
        self.file: TextIO | None = None
        if path is not None:
            with explaining(self.path):
                self.file = self.path.open("w", encoding="utf-8", buffering=1, errors="backslashreplace")
            self.write(f"{HEAD} {engine.__version__}: {' '.join(words)}")

    def write(self, text: str) -> None:
        """Add the lines of `text`."""
        if self.file is not None:
            now = time.strftime("%Y-%m-%d %H:%M:%S")
            with explaining(self.path):
                self.file.writelines(f"{now}  {escape_controls(line)}\n" for line in text.split("\n") if line)

    def close(self, code: int) -> None:
        """Add how the command ended."""
        self.write(f"exit code {code} after {time.monotonic() - self.begun:.1f} s")
        if self.file is not None:
            self.file.close()


#: The beginning of the first line of a log, behind its time.
HEAD = "lightarc"

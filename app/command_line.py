"""The command line: every capability of the window is also a verb.

One JSON object on standard output with `--json` and nothing else there; progress and messages go to standard error.
Exit codes: 0 done, 2 wrong usage, 3 bad input or output, 4 cancelled, 5 a needed capability is missing,
6 memory, threads or processes ran out.

Verbs import what they compute with inside their functions: the options of all verbs are there in 0.2 s of processor
time, numerical libraries and decoders would take 1.0 s more. A plain `import` does it without lazy_loader.
"""

from __future__ import annotations

import argparse
import importlib
import io
import json
import logging
import re
import sys
import time
from collections.abc import Sequence
from typing import Any, cast

import engine
from app.arguments.results import add_overwrite, check_results
from app.arguments.usage import BAD_FILE, CANCELLED, DONE, MISSING, OUT_OF_MEMORY, WRONG_USAGE
from app.process import ending, last_words
from engine.core.errors import FileError, MissingCapability, OutOfMemory, UsageError, shortage
from engine.core.steps import Step
from engine.storage import guarded

#: Verb and module, in the order in which people meet them.
VERBS = (
    ("gui", "app.cli.gui"),
    ("demo", "app.cli.demo"),
    ("simulate", "app.cli.simulate"),
    ("import", "app.cli.import_"),
    ("shade", "app.cli.shading.shade"),
    ("normals", "app.cli.normals"),
    ("render", "app.cli.transport.render"),
    ("compare", "app.cli.compare"),
    ("brdf", "app.cli.brdf"),
    ("factor", "app.cli.factor"),
    ("bake", "app.cli.transport.bake"),
    ("plan", "app.cli.transport.plan"),
    ("figures", "app.cli.figures"),
    ("tradeoff", "app.cli.transport.tradeoff"),
    ("project", "app.cli.project"),
    ("bundle", "app.cli.bundle"),
    ("export", "app.cli.export"),
    ("selftest", "app.cli.selftest"),
    ("bench", "app.cli.bench"),
)

#: Warnings that are printed; photographs may have some each.
MOST_WARNINGS = 8

EXIT_CODES = (
    "exit codes: 0 done, 2 wrong usage, 3 a file that cannot be used, 4 cancelled, 5 something is missing from the "
    "machine, 6 memory, threads or processes ran out"
)


class Progress:
    """Shows steps on one line of a terminal, or a line every five seconds where there is none."""

    def __init__(self, stream: Any) -> None:
        self.stream = stream
        self.interactive = stream.isatty()
        self.shown = 0.0 if self.interactive else time.monotonic()

    def __call__(self, step: Step) -> None:
        now = time.monotonic()
        if now - self.shown < (0.1 if self.interactive else 5.0):
            return
        self.shown = now
        line = f"{100 * step.done:3.0f} %  {step.note}"
        self.stream.write(f"\r\x1b[K{line[:100]}" if self.interactive else f"{line}\n")
        self.stream.flush()

    def clear(self) -> None:
        if self.interactive:
            self.stream.write("\r\x1b[K")


def build_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="lightarc",
        description="Turn photographs of a material under a moving lamp into a material. Without a verb: the window.",
        epilog=EXIT_CODES,
    )
    parser.add_argument("--version", action="version", version=f"lightarc {engine.__version__}")
    verbs = parser.add_subparsers(dest="verb", metavar="VERB")
    for name, module_name in VERBS:
        module = importlib.import_module(module_name)
        verb = verbs.add_parser(
            name,
            help=module.HELP,
            description=module.HELP,
            epilog=f"example: {module.EXAMPLE}",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        module.add_arguments(verb)
        add_overwrite(verb)
        verb.add_argument("--json", action="store_true", help="print one JSON object on standard output")
        verb.set_defaults(module=module)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb (the window without one) and return the exit code."""
    words = _joined(list(sys.argv[1:] if arguments is None else arguments)) or ["gui"]
    for stream in (sys.stdout, sys.stderr):
        # File names may hold bytes that no encoding knows.
        cast("io.TextIOWrapper", stream).reconfigure(errors="backslashreplace")
    parser = build_parser()
    options = parser.parse_args(words)
    logging.basicConfig(stream=sys.stderr, level=logging.WARNING, format="%(message)s")
    last_words.leave_last_words(str(OutOfMemory("There is not enough memory or no further thread")), OUT_OF_MEMORY)
    with ending.during(ending.FINISH):
        return _run(parser, options)


def _run(parser: argparse.ArgumentParser, options: argparse.Namespace) -> int:
    progress = Progress(sys.stderr)
    try:
        with ending.during(ending.INTERRUPT):
            check_results(parser, options)
            result = options.module.run(options, progress)
            guarded.check()
    except KeyboardInterrupt as interrupt:
        ending.keep_frames(interrupt)
        return _fail(progress, CANCELLED, ending.SENTENCE)
    except FileError as error:
        return _fail(progress, BAD_FILE, str(error))
    except MissingCapability as error:
        return _fail(progress, MISSING, str(error))
    except UsageError as error:
        return _fail(progress, WRONG_USAGE, f"{str(error).rstrip('.')}. See lightarc {options.verb} -h.")
    except (OutOfMemory, MemoryError, RuntimeError, ImportError, OSError) as error:
        lack = shortage(error)
        if lack is None:
            raise
        return _fail(progress, OUT_OF_MEMORY, str(lack))
    progress.clear()
    _print(options, result)
    return int(result.get("exit_code", DONE)) if isinstance(result, dict) else DONE


def _joined(words: list[str]) -> list[str]:
    """`words` in which `--light-deg -30,0` is `--light-deg=-30,0`: argparse takes -30,0 for an option of its own."""
    joined: list[str] = []
    for word in words:
        if joined and re.match(r"--\w[\w-]*$", joined[-1]) and re.match(r"-[\d.]+(e[-+]?\d+)?,", word):
            joined[-1] += f"={word}"
        else:
            joined.append(word)
    return joined


def _print(options: argparse.Namespace, result: Any) -> None:
    if not isinstance(result, dict):
        return
    public = {key: value for key, value in result.items() if key != "exit_code"}
    if not public:
        return
    health = health_text(public["warnings"])
    if options.json:
        print(json.dumps(public, allow_nan=False))
        return
    if hasattr(options.module, "report"):
        print(options.module.report(public))
    else:
        for key, value in public.items():
            print(f"{key}: {value}")
    print(health)


def health_text(warnings: Sequence[str]) -> str:
    """The health of a result: 'Health: no warnings.', or how many with the first `MOST_WARNINGS` of them."""
    if not warnings:
        return "Health: no warnings."
    lines = [f"- {warning}" for warning in warnings[:MOST_WARNINGS]]
    if len(warnings) > MOST_WARNINGS:
        lines.append(f"- and {len(warnings) - MOST_WARNINGS} more, which --json lists")
    return "\n".join([f"Health: {len(warnings)} warning{'s' * (len(warnings) > 1)}:", *lines])


def _fail(progress: Progress, code: int, message: str) -> int:
    progress.clear()
    print(message, file=sys.stderr)
    return code

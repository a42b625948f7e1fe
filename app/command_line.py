"""The command line: every capability of the window is also a verb.

One JSON object on standard output with `--json` and nothing else there; progress and messages go to standard error.
Exit codes: 0 done, 2 wrong usage, 3 bad input or output, 4 cancelled, 5 a needed capability is missing,
6 memory, threads or processes ran out, 7 some captures of a batch failed, 8 all of them.

A word that is no verb but the name of a file opens the window with it, and `help VERB` is `VERB -h`.

Only the verb that is asked for is imported, with the libraries that it computes with: the help of all verbs takes
0.2 s, numerical libraries and decoders would take 1.0 s more.
"""

from __future__ import annotations

import argparse
import importlib
import io
import json
import logging
import os
import re
import sys
import time
from collections.abc import Sequence
from contextlib import nullcontext
from typing import TextIO, cast

import engine
from app.arguments.common import Line, Log, add_common, find_threads, limits
from app.arguments.once import OnceParser
from app.arguments.results import check_results
from app.arguments.usage import BAD_FILE, CANCELLED, DONE, MISSING, OUT_OF_MEMORY, WRONG_USAGE
from app.process import ending, last_words
from engine.core.budget import limit_threads
from engine.core.errors import FileError, MissingCapability, OutOfMemory, UsageError, file_failure, shortage
from engine.core.escape import escape_controls
from engine.core.figure_text import size_text
from engine.core.steps import Step
from engine.storage import guarded
from engine.storage.outputs import Written, find_written, identify, make_folders

#: Verb, module and help, in the order in which users meet them.
VERBS = (
    ("gui", "app.cli.gui", "Open the window."),
    (
        "demo",
        "app.cli.demo",
        "Run all steps on the built-in sample; write every result and a contact sheet into a folder.",
    ),
    (
        "simulate",
        "app.cli.simulate",
        "Photograph a procedural sample on a virtual light arc or dome, with reference data beside the photographs.",
    ),
    (
        "import",
        "app.cli.import_",
        "Import photographs of a material under a moving lamp: decode, align, crop and report.",
    ),
    (
        "watch",
        "app.cli.watch",
        "Follow a capture while it is taken: judge each photograph, then import them and write the project.",
    ),
    (
        "shade",
        "app.cli.shading.shade",
        "Make a material of a stack: a shading map, or a directional material from lights on several azimuths.",
    ),
    (
        "normals",
        "app.cli.normals",
        "Find normals, height, base colour, roughness and specular maps of a stack, with their uncertainty.",
    ),
    (
        "batch",
        "app.cli.batch",
        "Make materials, projects and exports of many captures in one run that can be stopped and goes on.",
    ),
    ("render", "app.cli.transport.render", "Draw a material on a model."),
    (
        "compare",
        "app.cli.compare",
        "Report the error of an image against a reference: relative RMSE, FLIP and the largest difference.",
    ),
    ("brdf", "app.cli.brdf", "List, inspect, evaluate, fit or convert BRDFs."),
    ("factor", "app.cli.factor", "Factor a BRDF into textures: sums of products, or products of projections."),
    (
        "bake",
        "app.cli.transport.bake",
        "Precompute light transport for a model and a BRDF, for 'lightarc render' and the window.",
    ),
    (
        "plan",
        "app.cli.transport.plan",
        "List the effects that a scene needs, with the error and saving of leaving each out, and the best mode.",
    ),
    ("figures", "app.cli.figures", "Draw the papers' figures, each panel with its error against the reference."),
    (
        "tradeoff",
        "app.cli.transport.tradeoff",
        "Measure the cost of accuracy: error, times and memory of many settings, and the best of them.",
    ),
    (
        "project",
        "app.cli.project",
        "Show, check or recover a project file, make it small, find or collect its photographs, or replay it.",
    ),
    (
        "bundle",
        "app.cli.bundle",
        "Check a bundle (hashes, schema, bounds, pixels), show, extract or view it, or make one of a project.",
    ),
    ("export", "app.cli.export", "Write a material in forms that other programs open, with what each of them loses."),
    (
        "selftest",
        "app.cli.selftest",
        "Check the numerics of this machine: hard cases of every part, each measured beside its bound.",
    ),
    (
        "desktop-install",
        "app.cli.desktop_install",
        "Add Lightarc to the menu of a Linux desktop: entry, icon, kinds of files, previews, man page.",
    ),
    ("completion", "app.cli.completion", "Write the script by which bash, zsh or fish completes verbs and options."),
    ("bench", "app.cli.bench", "Deprecated: run the benchmarks of a checkout of the source code."),
)

#: Words that users of other programs type for a verb, each with what does it here.
OTHER_WORDS = {
    **dict.fromkeys(("open", "view", "show", "start"), "gui"),
    **{"convert": "export", "material": "shade", "fit": "brdf fit", "list": "brdf list", "measure": "tradeoff"},
    **{
        "align": "import",
        "capture": "simulate",
        "version": "--version",
        "test": "selftest",
        "film": "render --turntable",
    },
}

#: Warnings that are printed; photographs may have some each.
MAX_WARNINGS = 8

#: Options of a verb from which on its usage shows only those that must be given.
_FEW_OPTIONS = 12

EXIT_CODES = (
    "exit codes: 0 done, 2 wrong usage, 3 a file that cannot be used, 4 cancelled, 5 something is missing from the "
    "machine, 6 memory, threads or processes ran out, 7 some captures of a batch failed, 8 all of them"
)


class Progress:
    """Shows steps on one line of a terminal, or a line every five seconds where there is none.

    Each new note of a step goes into the `log`; a `quiet` one shows nothing.
    """

    def __init__(self, stream: TextIO, log: Log, *, quiet: bool) -> None:
        self.stream, self.log, self.quiet = stream, log, quiet
        self.interactive = stream.isatty() and not quiet
        self.shown = 0.0 if self.interactive else time.monotonic()
        self.note = ""

    def __call__(self, step: Step) -> None:
        if step.note != self.note:
            self.note = step.note
            self.log.write(f"{100 * step.done:3.0f} %  {step.note}")
        if isinstance(step.partial, Line):
            self._say(step.partial.text)
        if self.quiet:
            return
        now = time.monotonic()
        if now - self.shown < (0.1 if self.interactive else 5.0):
            return
        self.shown = now
        line = f"{100 * step.done:3.0f} %  {escape_controls(step.note)}"
        self.stream.write(f"\r\x1b[K{line[:100]}" if self.interactive else f"{line}\n")
        self.stream.flush()

    def _say(self, text: str) -> None:
        """Show a sentence that stays."""
        self.log.write(text)
        if not self.quiet:
            self.clear()
            self.stream.write(f"{escape_controls(text)}\n")
            self.stream.flush()

    def clear(self) -> None:
        if self.interactive:
            self.stream.write("\r\x1b[K")


def build_parser(only: str | None = None) -> OnceParser:
    """Build the parser of all verbs, with the options of the verb `only`, or of every verb if it is None."""
    parser = OnceParser(
        prog="lightarc",
        description="Turn photographs of a material under a moving lamp into a material. Without a verb: the window.",
        epilog=EXIT_CODES,
    )
    parser.add_argument("--version", action="version", version=f"lightarc {engine.__version__}")
    verbs = parser.add_subparsers(dest="verb", metavar="VERB")
    for name, module_name, text in VERBS:
        verb = verbs.add_parser(name, help=text, description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
        if only not in (None, name):
            continue
        module = importlib.import_module(module_name)
        verb.epilog = f"example: {module.EXAMPLE}"
        module.add_arguments(verb)
        verb.usage = _shorten_usage(verb)
        verb.set_defaults(module=module, build_parser=build_parser)
    add_common(parser)
    return parser


def _shorten_usage(parser: argparse.ArgumentParser) -> str | None:
    """The usage of a parser of many options: what must be given; None for few, which are all shown."""
    if len(parser._actions) < _FEW_OPTIONS:
        return None
    needed = [action for action in parser._actions if action.required or not action.option_strings]
    shown = parser._get_formatter()
    shown.add_usage(None, needed, [], "")
    return f"{' '.join(shown.format_help().split())} [OPTION …]"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb (the window without one) and return the exit code."""
    words = _understand(_join(list(sys.argv[1:] if arguments is None else arguments)))
    for stream in (sys.stdout, sys.stderr):
        # File names may hold bytes that no encoding knows.
        cast("io.TextIOWrapper", stream).reconfigure(errors="backslashreplace")
    threads = find_threads(words)
    with limit_threads(threads) if threads else nullcontext():
        parser = build_parser(_verb_in(words))
        options = parser.parse_args(words)
        logging.basicConfig(stream=sys.stderr, level=logging.WARNING, format="%(message)s")
        last_words.leave_last_words(str(OutOfMemory("There is not enough memory or no further thread")), OUT_OF_MEMORY)
        with ending.during(ending.FINISH):
            return _run(parser, options, words)


def _understand(words: list[str]) -> list[str]:
    """`words` with the verb that is left out: the window for nothing and for names of files, help for `help VERB`."""
    if not words:
        return ["gui"]
    if words[0] == "help":
        return [*words[1:2], "-h"]
    if words[0] in OTHER_WORDS:
        raise SystemExit(_refuse_other(words[0]))
    if not _verb_in(words[:1]) and not words[0].startswith("-") and os.path.lexists(words[0]):
        return ["gui", *words]
    return words


def _refuse_other(word: str) -> int:
    """Say which verb does what `word` asks for; the exit code."""
    print(f"lightarc: {word!r} is no verb (did you mean {OTHER_WORDS[word]}?). See lightarc -h.", file=sys.stderr)
    return WRONG_USAGE


def _verb_in(words: Sequence[str]) -> str:
    """The first word that is a verb; before it may stand options of every command."""
    return next((word for word in words if word in {name for name, _, _ in VERBS}), "")


def _run(parser: argparse.ArgumentParser, options: argparse.Namespace, words: Sequence[str]) -> int:
    progress = Progress(sys.stderr, Log(None, ()), quiet=options.quiet)
    code = _carry_out(parser, options, words, progress)
    progress.log.close(code)
    return code


def _carry_out(
    parser: argparse.ArgumentParser, options: argparse.Namespace, words: Sequence[str], progress: Progress
) -> int:
    """The exit code of the verb, of which all is reported."""
    written: list[Written] = []
    try:
        with ending.during(ending.INTERRUPT):
            outputs = check_results(parser, options)
            before = identify(outputs)
            with make_folders(outputs), limits(options):
                progress.log = Log(options.log, words)
                result = options.module.run(options, progress)
                written = find_written(outputs, before)
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
    except Exception as error:  # whatever a library makes of too little memory
        lack = shortage(error)
        if lack is not None:
            return _fail(progress, OUT_OF_MEMORY, str(lack))
        refused = file_failure(error)
        if refused is None:
            raise
        return _fail(progress, BAD_FILE, str(refused))
    progress.clear()
    code = int(result.get("exit_code", DONE)) if isinstance(result, dict) else DONE
    results = [each for each in written if each.path != options.log and code == DONE]
    _print(options, result, results, progress.log)
    return code


def _join(words: list[str]) -> list[str]:
    """`words` in which `--light-deg -30,0` is `--light-deg=-30,0`: argparse takes -30,0 for an option of its own."""
    joined: list[str] = []
    for word in words:
        if joined and re.match(r"--\w[\w-]*$", joined[-1]) and re.match(r"-[\d.]+(e[-+]?\d+)?,", word):
            joined[-1] += f"={word}"
        else:
            joined.append(word)
    return joined


def _print(options: argparse.Namespace, result: object, written: Sequence[Written], log: Log) -> None:
    """Print a result: as JSON, or its report, where it was written, how large it is, and its health."""
    if not isinstance(result, dict):
        return
    public = {key: value for key, value in result.items() if key != "exit_code"}
    if not public:
        return
    health = health_text(public["warnings"])
    if hasattr(options.module, "report"):
        report = _lines(options.module.report(public))
    else:
        report = "\n".join(escape_controls(f"{key}: {value}") for key, value in public.items())
    text = "\n".join([report, *map(describe_written, written), health])
    log.write(text)
    if options.json:
        print(json.dumps(public, allow_nan=False))
    elif not options.quiet:
        print(text)
    elif public["warnings"]:
        print(health, file=sys.stderr)


def describe_written(written: Written) -> str:
    """A line such as 'Wrote stack: 12 MB in 5 files.'"""
    files = f" in {written.files} files" if written.files > 1 else ""
    return escape_controls(f"Wrote {written.path}: {size_text(written.size_bytes)}{files}.")


def _lines(text: str) -> str:
    """Lines of `text`, each of which can be shown: names in it do not drive the terminal."""
    return "\n".join(map(escape_controls, text.split("\n")))


def health_text(warnings: Sequence[str]) -> str:
    """The health of a result: 'Health: no warnings.', or how many with the first `MAX_WARNINGS` of them."""
    if not warnings:
        return "Health: no warnings."
    lines = [f"- {escape_controls(warning)}" for warning in warnings[:MAX_WARNINGS]]
    if len(warnings) > MAX_WARNINGS:
        lines.append(f"- and {len(warnings) - MAX_WARNINGS} more, which --json lists")
    return "\n".join([f"Health: {len(warnings)} warning{'s' * (len(warnings) > 1)}:", *lines])


def _fail(progress: Progress, code: int, message: str) -> int:
    progress.clear()
    progress.log.write(message)
    print(_lines(message), file=sys.stderr)
    return code

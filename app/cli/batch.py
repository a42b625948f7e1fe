"""`lightarc batch`: many captures become materials, projects and exports in one run that goes on where it stopped."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

from app.arguments.common import thread_number
from app.arguments.quantities import SECONDS, size_bytes
from app.arguments.results import SHARED, Input, Output
from app.arguments.usage import ALL_FAILED, CANCELLED, DONE, SOME_FAILED
from app.process import ending
from engine.core.errors import UsageError
from engine.core.figure_text import time_text
from engine.core.steps import Step, drain
from engine.exchange.targets import EXPORTERS

EXAMPLE = "lightarc batch museum/ -o results --template dome.lap --to web textures"

#: Captures that failed, of which the summary names the reason.
MAX_REASONS = 8

#: The shortest time that a capture may be given, in seconds.
LEAST_S = 1.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "sources",
        nargs="*",
        type=Input(),
        metavar="SOURCE",
        help="folders of captures, with all below them, archives, patterns in quotes ('museum/*/raw'), or a table "
        "(.csv) with the column path, and name, options (working_space=acescg slices=12) and any metadata; without a "
        "source the captures of the folder of results",
    )
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        type=Output(SHARED, Path),
        metavar="FOLDER",
        help="results: a folder for each capture, the record of the batch, and report.html, .csv and .json",
    )
    parser.add_argument(
        "--template",
        type=Input(Path),
        metavar="PROJECT",
        help="a project (.lap) whose choices hold for all captures: import, material, appearance, exports, credits",
    )
    parser.add_argument(
        "--to",
        nargs="+",
        action="extend",
        choices=(*EXPORTERS, "none"),
        help="targets of an export of each material, or none (those of the template, else web)",
    )
    parser.add_argument(
        "--workers",
        type=thread_number,
        metavar="N",
        help="captures that are made at a time, each by a process on one thread (one for each CPU)",
    )
    parser.add_argument(
        "--time-limit",
        type=SECONDS,
        metavar="TIME",
        help="a capture that takes longer has failed, as 90s, 20min (1h)",
    )
    parser.add_argument(
        "--memory-limit",
        type=size_bytes,
        metavar="SIZE",
        help="a capture that takes more memory, decoders included, has failed, as 4GB (an even share of what is free)",
    )
    parser.epilog = f"{parser.epilog}\n\n{MORE_HELP}"


MORE_HELP = """\
The same command goes on where it stopped or was killed: it makes captures that are missing or failed, and those whose
files, choices or version have changed; lightarc batch -o FOLDER alone goes on with the captures, the template and the
targets of the last run. Exit code 7: some captures failed, 8: all of them; the report tells why.

JSON: waiting, done and failed are numbers of captures, captures lists them with name, path, state, reason, figures,
seconds, options, metadata, folder, files and log; stopped is true where the run was interrupted."""


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    from app.batch.captures import find_captures
    from app.batch.record import open_record
    from app.batch.report import describe, summarise
    from app.batch.run import Settings, make_batch
    from engine.storage.atomic import make_folder

    if arguments.time_limit is not None and not LEAST_S <= arguments.time_limit <= 1e9:
        raise UsageError(f"--time-limit {arguments.time_limit:g} s is outside 1 s … 1e9 s")
    if arguments.to and "none" in arguments.to and len(set(arguments.to)) > 1:
        raise UsageError("--to none writes no export: leave the other targets out")
    show(Step(0.0, "looking for captures"))
    output = make_folder(arguments.output.absolute())
    with open_record(output) as record:
        before = record.rows()
        known = [row.capture for row in before]
        captures = find_captures(arguments.sources, known) if arguments.sources else known
        if not captures:
            raise UsageError("there is no capture: name folders of photographs, or a table of them")
        chosen = _choose(arguments, record.choices())
        record.choose(chosen)
        given = {"time_limit_s": arguments.time_limit, "memory_limit_bytes": arguments.memory_limit}
        settings = Settings(
            None if chosen["template"] is None else Path(chosen["template"]),
            None if chosen["targets"] is None else tuple(chosen["targets"]),
            arguments.workers,
            **{name: value for name, value in given.items() if value is not None},
        )
        ending.keep_work()
        stopped = False
        try:
            with closing(make_batch(output, record, captures, settings)) as steps:
                drain(steps, show)
        except KeyboardInterrupt:
            stopped = True
        names = {each.name for each in captures}
        rows = [row for row in record.rows() if row.capture.name in names]
    summary = summarise(rows)
    code = CANCELLED if stopped else DONE if not summary["failed"] else SOME_FAILED if summary["done"] else ALL_FAILED
    return {
        **summary,
        "captures": [describe(row) for row in rows],
        "folder": str(arguments.output),
        "stopped": stopped,
        "warnings": _list_failures([row.capture.name for row in rows], [row.reason for row in rows]),
        "exit_code": code,
    }


def _choose(arguments: argparse.Namespace, before: dict[str, Any]) -> dict[str, Any]:
    """Template and targets of this run: those that are given, else those of the last one."""
    chosen = {"template": before.get("template"), "targets": before.get("targets")}
    if arguments.template is not None:
        chosen["template"] = str(arguments.template.absolute())
    if arguments.to:
        chosen["targets"] = [] if "none" in arguments.to else list(dict.fromkeys(arguments.to))
    return chosen


def _list_failures(names: Sequence[str], reasons: Sequence[str]) -> list[str]:
    return [f"{name}: {reason}" for name, reason in zip(names, reasons, strict=True) if reason]


def report(result: dict[str, Any]) -> str:
    total, folder = len(result["captures"]), result["folder"]
    counts = ", ".join(f"{result[state]} {state}" for state in ("done", "failed", "waiting") if result[state])
    lines = [f"{total} captures: {counts}; {time_text(result['seconds'])} of work"]
    if result["stopped"]:
        lines.append(f"Stopped. Go on with: lightarc batch -o {shlex.quote(folder)}")
    lines.append(f"Written to {folder}: report.html, report.csv, report.json, and a folder for each capture.")
    return "\n".join(lines)

"""`lightarc batch`: many captures become materials, projects and exports in one run that goes on where it stopped."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.arguments.common import thread_number
from app.arguments.options import add_cluster, refuse_plain_cluster
from app.arguments.quantities import SECONDS, size_bytes
from app.arguments.results import SHARED, Input, Output
from app.arguments.usage import ALL_FAILED, CANCELLED, DONE, SOME_FAILED
from app.process import ending
from engine.core.errors import UsageError
from engine.core.figure_text import time_text
from engine.core.steps import Step, drain
from engine.exchange.targets import EXPORTERS

if TYPE_CHECKING:
    from app.batch.run import Settings

EXAMPLE = "lightarc batch museum/ -o results --template dome.lap --to web textures"


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
    add_cluster(parser, "make captures")
    parser.epilog = f"{parser.epilog}\n\n{MORE_HELP}"


MORE_HELP = """\
The same command goes on where it stopped or was killed: it makes captures that are missing or failed, and those whose
files, choices or version have changed; lightarc batch -o FOLDER alone goes on with the captures, the template and the
targets of the last run. Exit code 7: some captures failed, 8: all of them; the report tells why.

JSON: waiting, done and failed are numbers of captures, captures lists them with name, path, state, reason, figures,
seconds, options, metadata, folder, files and log; stopped is true where the run was interrupted."""


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    from app.batch.record import read_rows
    from app.batch.report import describe, summarise
    from app.batch.run import go_on

    settings, stopped = _settings(arguments), False
    ending.keep_work()
    try:
        with closing(go_on(arguments.output, arguments.sources, settings)) as steps:
            rows = drain(steps, show)
    except KeyboardInterrupt:
        stopped, rows = True, read_rows(arguments.output)
    summary = summarise(rows)
    code = CANCELLED if stopped else DONE if not summary["failed"] else SOME_FAILED if summary["done"] else ALL_FAILED
    return {
        **summary,
        "captures": [describe(row) for row in rows],
        "folder": str(arguments.output),
        "stopped": stopped,
        "warnings": [f"{row.capture.name}: {row.reason}" for row in rows if row.reason],
        "exit_code": code,
    }


def _settings(arguments: argparse.Namespace) -> Settings:
    """The settings of a run; UsageError for those that cannot be."""
    from app.batch.run import TIME_LIMIT_S, Settings
    from app.project.project_file import read

    limit_s = TIME_LIMIT_S if arguments.time_limit is None else arguments.time_limit
    targets = None if arguments.to is None else tuple(dict.fromkeys(arguments.to))
    if targets is not None and "none" in targets:
        if len(targets) > 1:
            raise UsageError("--to none writes no export: leave the other targets out")
        targets = ()
    template = None if arguments.template is None else read(arguments.template).current
    refuse_plain_cluster(arguments)
    if arguments.cluster is not None and arguments.workers is not None:
        raise UsageError("--workers is of this computer, and --cluster has workers of its own: choose one")
    cluster = arguments.cluster or ""
    return Settings(template, targets, arguments.workers, limit_s, arguments.memory_limit, cluster)


def report(result: dict[str, Any]) -> str:
    total, folder = len(result["captures"]), result["folder"]
    counts = ", ".join(f"{result[state]} {state}" for state in ("done", "failed", "waiting") if result[state])
    lines = [f"{total} captures: {counts}; {time_text(result['seconds'])} of work"]
    if result["stopped"]:
        lines.append(f"Stopped. Go on with: lightarc batch -o {shlex.quote(folder)}")
    lines.append(f"Written to {folder}: report.html, report.csv, report.json, and a folder for each capture.")
    return "\n".join(lines)

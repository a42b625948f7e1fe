"""`lightarc project`: show, check, clean up, collect or replay a project file, or find its photographs again."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from app.arguments.options import refuse_unused
from app.arguments.results import Input, Output, project_result
from app.arguments.usage import BAD_FILE, DONE
from app.project.cleaning import clean_up
from app.project.copying import collect
from app.project.photographs import files_of, find_moved, keep, marks_of, relocate, take_marks
from app.project.places import claim, release
from app.project.project_file import read
from app.project.recovery import recover
from app.project.report import describe, problems_of
from app.project.values import in_full, is_file
from engine.core.errors import InputError, UsageError
from engine.core.figure_text import size_text, time_text
from engine.core.steps import Step, drain

NAME = "project"
EXAMPLE = "lightarc project info Felt.lap --json"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "action",
        choices=("info", "verify", "find", "collect", "clean-up", "recover", "replay"),
        help="info: what is in it; verify: read all; find: photographs that moved; collect: copy all; clean-up: remove "
        "the results that its photographs give again; recover: what is sound in a damaged one; replay: make all "
        "results anew and compare them",
    )
    parser.add_argument("path", type=Input(Path), metavar="PROJECT", help="a .lap file")
    parser.add_argument(
        "-o",
        "--output",
        type=Output(project_result, Path),
        metavar="FILE",
        help="collect, recover: the .lap file to write; replay: the folder",
    )
    parser.add_argument(
        "--photographs", type=Input(Path), metavar="FOLDER", help="find: look here, by content, for those that moved"
    )
    parser.add_argument(
        "--include-outside",
        action="store_true",
        help="collect: copy also photographs that lie outside the project's folder; without it they are listed",
    )
    parser.add_argument("--without-derived", action="store_true", help="collect: leave out what can be made again")


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    """The description that `app.project.report` gives; exit code 3 where a verified project is not sound."""
    from app.commands.replay import replay

    show(Step(0.0, "reading the project"))
    users = {"--output": ("collect", "recover", "replay"), "--photographs": ("find",)}
    users |= dict.fromkeys(("--include-outside", "--without-derived"), ("collect",))
    refuse_unused(arguments, [(flag, arguments.action in names, " or ".join(names)) for flag, names in users.items()])
    if arguments.action in ("collect", "recover", "replay") and arguments.output is None:
        raise UsageError(
            f"{arguments.action} needs -o, the {'folder' if arguments.action == 'replay' else 'project'} to write"
        )
    if arguments.action == "replay":
        results = drain(replay(arguments.path, arguments.output), show)
        different = [f"{each['name']}: {each['reason']}" for each in results if each["bit_equal"] is False]
        return {"results": results, "output": str(arguments.output), "warnings": different}
    if arguments.action == "collect":
        with_derived, include_outside = not arguments.without_derived, arguments.include_outside
        drain(collect(arguments.path, arguments.output, with_derived, include_outside=include_outside), show)
        return describe(arguments.output)
    if arguments.action == "recover":
        lost = drain(recover(arguments.path, arguments.output), show)
        result = describe(arguments.output)
        return result | {"lost": lost, "warnings": [*(f"not recovered: {each}" for each in lost), *result["warnings"]]}
    if arguments.action == "clean-up":
        cleaned = drain(clean_up(arguments.path), show)
        sizes = {"bytes_before": cleaned.before_bytes, "bytes": cleaned.after_bytes, "bytes_freed": cleaned.freed_bytes}
        return {**describe(arguments.path), **sizes, "kept": list(cleaned.kept)}
    if arguments.action == "find":
        _find(arguments.path, arguments.photographs, show)
    result = describe(arguments.path)
    if arguments.action == "verify":
        problems = drain(problems_of(arguments.path), show)
        result |= {"ok": not problems, "problems": problems, "exit_code": BAD_FILE if problems else DONE}
        result["warnings"] = list(dict.fromkeys([*problems, *result["warnings"]]))
    return result


def _find(path: Path, folder: Path | None, show: Callable[[Step], None]) -> None:
    """Note where photographs are that moved; UsageError without a folder, or where a window has the project open."""
    if folder is None:
        raise UsageError("find needs --photographs, the folder that the photographs moved to")
    marks = marks_of(path)
    gone = [each for each in files_of(read(path).current) if not is_file(each) or in_full(each) not in marks]
    if not claim(path):
        raise InputError(path, "is open in a window", "Find the photographs there, or close it")
    try:
        places = drain(find_moved(path, gone, folder), show)
        relocate(path, places)
        unmarked = (new for old, new in places.items() if in_full(old) not in marks)
        keep(path, drain(take_marks(unmarked), show))
    finally:
        release(path)


def report(result: dict[str, Any]) -> str:
    """A few lines for a user."""
    if "results" in result:
        verdicts = {True: "bit-equal", False: "not bit-equal", None: "not compared"}
        return "\n".join(
            f"{each['name']}: {verdicts[each['bit_equal']]}, {each['reason']}" for each in result["results"]
        )
    lines = [
        f"Project “{result['name']}”: {result['history_steps']} steps, last changed {result['last_change']}",
        f"{len(result['photographs'])} photographs",
        *_beside(result["derived"]),
    ]
    if "bytes_freed" in result:
        lines.append(f"{size_text(result['bytes_freed'])} freed, {size_text(result['bytes'])} left")
        lines += [f"{why}." for why in result["kept"]]
    if "ok" in result:
        lines.append("The project is sound." if result["ok"] else "The project is not sound: see the warnings.")
    return "\n".join(lines)


def _beside(derived: list[dict[str, Any]]) -> list[str]:
    """A line for each kind of what lies beside the file, and for what of it is gone."""
    lines = []
    for kind, present in dict.fromkeys((each["kind"], each["present"]) for each in derived):
        of_kind = [each for each in derived if (each["kind"], each["present"]) == (kind, present)]
        known = [each["seconds"] for each in of_kind if each["seconds"] is not None]
        count = f"{len(of_kind)} files, " if len(of_kind) > 1 else ""
        size = size_text(sum(each["bytes"] for each in of_kind))
        lines.append(f"{kind}: {count}{size if present else _make_again(sum(known) if known else None)}")
    return lines


def _make_again(seconds: float | None) -> str:
    return "gone, can be made again" + (f" in about {time_text(seconds)}" if seconds is not None else "")

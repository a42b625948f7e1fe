"""`lightarc selftest`: the fast part of the catalogue of hard cases on this machine: measured, bound, pass.

With `--long` cases are drawn by seed from all parts; what fails is made as small as it can be and kept in a file.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.arguments.results import SELFTEST_CASES, Input, Output
from engine.core.errors import MissingCapability, UsageError
from engine.core.figure_text import number, time_text
from engine.core.steps import Step, drain

if TYPE_CHECKING:
    from engine.selftest.case import Case

EXAMPLE = "lightarc selftest"

#: The exit code where a case fails.
FAILED = 1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--only", type=str, nargs="+", metavar="ID", help="only these cases or groups, for example H5 V EN"
    )
    parser.add_argument(
        "--long", action="store_true", help="draw cases by seed instead, and make what fails as small as it can be"
    )
    parser.add_argument("--cases", type=int, metavar="N", help="cases that --long draws (10000)")
    parser.add_argument("--seed", type=int, metavar="N", help="seed of the first round of --long (0)")
    parser.add_argument(
        "-o",
        "--output",
        type=Output(SELFTEST_CASES, Path),
        metavar="FILE",
        help="file of what fails with --long (.json)",
    )
    parser.add_argument("--repeat", type=Input(Path), metavar="FILE", help="ask the cases of such a file again")


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    if not arguments.long and (arguments.cases, arguments.seed, arguments.output) != (None, None, None):
        raise UsageError("--cases, --seed and -o go with --long")
    if arguments.long and arguments.repeat:
        raise UsageError("--long draws new cases, --repeat asks those of a file: choose one")
    started = time.perf_counter()
    if arguments.long:
        found = _draw(arguments, show)
    else:
        found = {"cases": _ask(arguments, show)}
    failed = sum(not each["pass"] for each in found["cases"])
    return {
        **found,
        "failed": failed,
        "selftest_s": time.perf_counter() - started,
        "warnings": [
            f"{each['id']}: {each.get('problem') or each['text']}" for each in found["cases"] if not each["pass"]
        ],
        "exit_code": FAILED if failed else 0,
    }


def report(result: dict[str, Any]) -> str:
    lines = [f"{'':4} {'case':5} {'measured':>10} {'at most':>10}  what"]
    for case in result["cases"]:
        mark = "skip" if case.get("skipped") else "    " if case["pass"] else "FAIL"
        what = case.get("problem") or case.get("skipped") or case["text"]
        lines.append(f"{mark} {case['id']:5} {number(case['measured'], 2):>10} {number(case['bound'], 2):>10}  {what}")
    seconds = time_text(result["selftest_s"])
    if "drawn" in result:
        return "\n".join([*(lines if result["failed"] else ()), *_about_drawn(result, seconds)])
    verdict = "all pass" if not result["failed"] else f"{result['failed']} fail"
    return "\n".join([*lines, f"{len(result['cases'])} cases in {seconds}: {verdict}"])


def _about_drawn(result: dict[str, Any], seconds: str) -> list[str]:
    whole = f"{result['drawn']:,} cases of {result['laws']} laws in {seconds}: "
    if not result["failed"]:
        return [whole + "all hold"]
    lines = [whole + f"{result['failed']} are broken"]
    if result["output"]:
        return [*lines, f"The smallest cases that break them are in {result['output']}; --repeat asks them again."]
    cases = [f"{case['id']} {json.dumps(case['values'])}" for case in result["cases"]]
    return [*lines, "The smallest cases that break them follow; -o keeps them in a file.", *cases]


def _ask(arguments: argparse.Namespace, show: Callable[[Step], None]) -> list[dict[str, Any]]:
    from engine.selftest.run import selftest

    if arguments.repeat:
        _need_hypothesis()
        from engine.selftest.generated.search import ask_file

        return [_record(case) for case in drain(ask_file(arguments.repeat), show)]
    return [_record(case) for case in drain(selftest(tuple(arguments.only or ())), show)]


def _draw(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    _need_hypothesis()
    from engine.selftest.generated.search import CASES, search, write_broken

    cases = CASES if arguments.cases is None else arguments.cases
    found = drain(search(cases, arguments.seed or 0, tuple(arguments.only or ())), show)
    is_kept = arguments.output is not None and found.broken
    if is_kept:
        write_broken(found.broken, arguments.output)
    return {
        "cases": [_record(each.case) | {"seed": each.seed, "values": each.values} for each in found.broken],
        "laws": found.laws,
        "drawn": found.cases,
        "output": str(arguments.output) if is_kept else None,
    }


def _record(case: Case) -> dict[str, Any]:
    return {
        "id": case.id,
        "text": case.text,
        "measured": case.measured,
        "bound": case.bound,
        "pass": case.passed,
        **({"problem": case.problem} if case.problem else {}),
        **({"skipped": case.skipped} if case.skipped else {}),
    }


def _need_hypothesis() -> None:
    if importlib.util.find_spec("hypothesis") is None:
        raise MissingCapability("Drawing cases needs the library Hypothesis", "Install it with: pip install hypothesis")

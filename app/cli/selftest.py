"""`lightarc selftest`: the fast part of the catalogue of hard cases on this machine: measured, bound, pass."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any

from engine.core.steps import Step, drain

HELP = "Check the numerics of this machine: hard cases of every part, each measured beside its bound."
EXAMPLE = "lightarc selftest"

#: The exit code where a case fails.
FAILED = 1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--only", type=str, nargs="+", metavar="ID", help="only these cases or groups, for example H5 V EN"
    )


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    from app.arguments.usage import DONE
    from engine.selftest.run import selftest

    started = time.perf_counter()
    cases = drain(selftest(tuple(arguments.only or ())), show)
    failed = sum(not case.passed for case in cases)
    return {
        "cases": [
            {
                "id": case.id,
                "text": case.text,
                "measured": case.measured,
                "bound": case.bound,
                "pass": case.passed,
                **({"problem": case.problem} if case.problem else {}),
                **({"skipped": case.skipped} if case.skipped else {}),
            }
            for case in cases
        ],
        "failed": failed,
        "selftest_s": time.perf_counter() - started,
        "exit_code": FAILED if failed else DONE,
    }


def report(result: dict[str, Any]) -> str:
    lines = [f"{'':4} {'case':5} {'measured':>10} {'at most':>10}  what"]
    for case in result["cases"]:
        mark = "skip" if case.get("skipped") else "    " if case["pass"] else "FAIL"
        what = case.get("problem") or case.get("skipped") or case["text"]
        lines.append(f"{mark} {case['id']:5} {case['measured']:10.2g} {case['bound']:10.2g}  {what}")
    count = len(result["cases"])
    verdict = "all pass" if not result["failed"] else f"{result['failed']} fail"
    return "\n".join([*lines, f"{count} cases in {result['selftest_s']:.0f} s: {verdict}"])

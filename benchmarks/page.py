"""A page of what was measured: each figure beside its limit, with the machine, its load, and the commit."""

from __future__ import annotations

import os
import platform
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import psutil

from engine.core.figure_text import number, time_text

PROJECT = Path(__file__).resolve().parents[1]


def write_page(result: Mapping[str, Any], load: float) -> str:
    """The Markdown page of the benchmarks `result`, on a machine whose load was `load` before them."""
    lines = [
        "# Speeds and errors of one run",
        "",
        "`python3 packaging/dev.py bench --report FILE` wrote this page: every speed next to what bounds it, in one "
        "run, and errors against known results.",
        "",
        *(f"- {words}" for words in describe_machine(load)),
        "",
        "| speed of | time | limit | ratio | what the limit is |",
        "|---|---|---|---|---|",
        *(
            f"| `{each['name']}` | {time_text(each['time_s'])} | {time_text(each['limit_s'])} | "
            f"{number(each['ratio'], 3)} | {escape_cell(each['limit'])} |"
            for each in result["measures"]
        ),
        "",
        "| error of | measured | bound | of what |",
        "|---|---|---|---|",
        *(
            f"| `{each['name']}` | {number(each['error'], 3)} | {_limit(each['bound'])} | {escape_cell(each['what'])} |"
            for each in result["accuracies"]
        ),
        "",
        *(f"- {escape_cell(words)}" for words in result["warnings"]),
    ]
    return "\n".join(lines).rstrip() + "\n"


def describe_machine(load: float) -> Sequence[str]:
    """Lines about the machine, its load, and the commit that was measured."""
    memory_gib = psutil.virtual_memory().total / 2**30
    return (
        f"Machine: {processor_name()}, {os.cpu_count()} cores, {memory_gib:.0f} GiB, {platform.system()}",
        f"Load before the run: {load:.1f}",
        f"Python {platform.python_version()}, commit {find_commit()}",
    )


def processor_name() -> str:
    """The processor as the system names it."""
    try:
        facts = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        facts = ""
    named = (line.partition(":")[2].strip() for line in facts.splitlines() if line.startswith("model name"))
    return next(named, "") or platform.processor() or platform.machine()


def find_commit() -> str:
    """The short name of the commit, with a plus where files differ from it; 'unknown' without git."""
    words = ("git", "-C", str(PROJECT), "describe", "--always", "--dirty=+", "--exclude=*")
    try:
        return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def escape_cell(text: str) -> str:
    """`text` within a cell of a table."""
    return " ".join(str(text).replace("|", "\\|").split())


def _limit(bound: float | None) -> str:
    return "none" if bound is None else number(bound, 3)

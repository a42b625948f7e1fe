"""Every operation on the disk and every allocation of an array fails once in each scenario, and processes are killed.

Each suite tries one of them in each scenario; `--long` all failures and 2,000 kills (safety S7, faults 1 and 2).
"""

from __future__ import annotations

import errno
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
import pytest

from app.arguments.usage import BAD_FILE, DONE, OUT_OF_MEMORY
from engine.core.errors import OutOfMemory
from tests.app.allocations import FailingAllocator
from tests.app.command import Command
from tests.app.scenarios import (
    SCENARIOS,
    FailAt,
    Scenario,
    assert_complete_or_absent,
    assert_one_sentence,
    begin,
    digest,
    names,
    prepare,
)

CODES = (errno.ENOSPC, errno.EIO, errno.EACCES, errno.EMFILE, errno.EDQUOT, errno.EROFS)

#: Rounds over which all failures are distributed, after the sample of every suite.
ROUNDS = 120

#: Kills of the campaign; a scenario has about so many operations on the disk, and takes about so long in a new process.
KILLS, OPERATIONS, TIME_S = 2000, 40, 4.0

PROJECT = Path(__file__).resolve().parents[2]

#: The command line in a process that kills itself before the operation whose number is the first argument.
VICTIM = """
import os, signal, sys
from engine.storage import atomic

at = int(sys.argv.pop(1))

def kill(operation, path):
    global at
    at -= 1
    if at < 0:
        os.kill(os.getpid(), getattr(signal, "SIGKILL", signal.SIGTERM))

atomic.fault = kill
from app.__main__ import main
main()
"""

Case = TypeVar("Case")

#: Operations that clean up: where one fails, the next write does it.
CLEANING = ("list", "unlink", "rmdir")


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("scenarios") / "inputs"
    prepare(folder)
    return folder


def share(cases: Sequence[Case], seed: int) -> Sequence[Case]:
    """One of `cases` for the seed of every suite, and a part of them for each round."""
    return cases[len(cases) // 2 :][:1] if seed == 0 else cases[seed % ROUNDS :: ROUNDS]


def allow(scenario: Scenario, code: int, operation: str) -> set[str]:
    """Names that may lie in the folder of the output after a run that ended with `code`."""
    if code == DONE:
        return {scenario.output}
    if scenario.resumed or operation in CLEANING:
        return {scenario.output, f".{scenario.output}.unfinished"}
    return {scenario.output, f".{scenario.output}.unfinished"} if scenario.output.endswith("transport") else set()


def assert_the_next_run_succeeds(
    scenario: Scenario, lightarc: Command, inputs: Path, folder: Path, before: str, what: str
) -> None:
    assert digest(inputs) == before, f"{what}: inputs have changed"
    assert_complete_or_absent(scenario, folder, what)
    again = lightarc(*scenario.line(inputs, folder))
    assert again.code == DONE, f"{what}, the next run: {again.err}"
    assert names(folder) == {scenario.output}, what
    assert_complete_or_absent(scenario, folder, what)


@pytest.mark.campaign(rounds=ROUNDS + 1)
@pytest.mark.parametrize("name", SCENARIOS)
def test_every_operation_on_the_disk_fails_once(
    name: str, seed: int, lightarc: Command, inputs: Path, tmp_path: Path
) -> None:
    scenario, before = SCENARIOS[name], digest(inputs)
    begin(scenario, inputs, tmp_path / "whole")
    with FailAt() as counted:
        assert lightarc(*scenario.line(inputs, tmp_path / "whole")).code == DONE
    cases = [(at, code) for at in range(len(counted.operations)) for code in CODES]
    assert len(cases) >= 6 * len(CODES)
    for at, code in share(cases, seed):
        folder = tmp_path / f"{at}-{code}"
        begin(scenario, inputs, folder)
        with FailAt(at, code) as failing:
            ended = lightarc(*scenario.line(inputs, folder))
        what = f"{name}, operation {at} ({counted.operations[at]}) with {errno.errorcode[code]}"
        assert len(failing.operations) > at, what
        assert ended.code in (DONE, BAD_FILE), f"{what}: {ended.err}"
        if ended.code != DONE:
            assert_one_sentence(ended.err, what)
        if failing.operations[at] not in CLEANING:
            assert names(folder) <= allow(scenario, ended.code, failing.operations[at]), what
        assert_the_next_run_succeeds(scenario, lightarc, inputs, folder, before, what)


@pytest.mark.campaign(rounds=ROUNDS + 1)
@pytest.mark.parametrize("name", SCENARIOS)
def test_every_allocation_fails_once(name: str, seed: int, lightarc: Command, inputs: Path, tmp_path: Path) -> None:
    scenario, before = SCENARIOS[name], digest(inputs)
    begin(scenario, inputs, tmp_path / "whole")
    counted = FailingAllocator()
    assert counted.run(lambda: lightarc(*scenario.line(inputs, tmp_path / "whole"))).code == DONE
    assert counted.count > 0
    for at in share(range(counted.count), seed):
        folder = tmp_path / str(at)
        begin(scenario, inputs, folder)
        failing = FailingAllocator(at)
        ended = failing.run(cast(Any, lambda folder=folder: lightarc(*scenario.line(inputs, folder))))
        what = f"{name}, allocation {at} of {counted.count}"
        assert ended.code in (DONE, OUT_OF_MEMORY), f"{what}: {ended.err}"
        if ended.code != DONE:
            assert_one_sentence(ended.err, what)
            assert OutOfMemory("").remedy in ended.err, what
        # Memory may end after the output is there, while a verb measures it; it is then complete.
        assert names(folder) <= allow(scenario, ended.code, "") | {scenario.output}, what
        assert_the_next_run_succeeds(scenario, lightarc, inputs, folder, before, what)


@pytest.mark.campaign(rounds=KILLS)
def test_killed_at_an_operation_or_at_any_moment(seed: int, lightarc: Command, inputs: Path, tmp_path: Path) -> None:
    """Even seeds are killed before an operation on the disk, odd ones after some time."""
    name = list(SCENARIOS)[seed // 2 % len(SCENARIOS)]
    scenario, before, folder = SCENARIOS[name], digest(inputs), tmp_path / "killed"
    begin(scenario, inputs, folder)
    random = np.random.default_rng(seed)
    at, patience_s = int(random.integers(1, OPERATIONS)), None
    if seed % 2:
        at, patience_s = sys.maxsize, TIME_S * random.random()
    command = [sys.executable, "-c", VICTIM, str(at), *scenario.line(inputs, folder)]
    what = f"{name} killed before operation {at} or after {patience_s} s"
    try:
        done = subprocess.run(command, cwd=PROJECT, capture_output=True, text=True, timeout=patience_s)
    except subprocess.TimeoutExpired:
        pass
    else:
        assert done.returncode in (0, -9), f"{what}: {done.stderr}"
    assert_the_next_run_succeeds(scenario, lightarc, inputs, folder, before, what)

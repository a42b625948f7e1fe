"""Times beside other programs: runs go on until these have nothing, or for so long."""

from __future__ import annotations

import subprocess
import sys

import pytest

from engine.core import stopwatch


class Clock:
    """A machine with two CPUs, on which another program keeps one busy until `until_s`.

    A run takes 0.1 s, and 0.2 s beside the other program.
    """

    def __init__(self, until_s: float) -> None:
        self.until_s, self.now_s, self.own_s, self.used_s = until_s, 0.0, 0.0, 0.0

    def work(self) -> None:
        beside = self.now_s < self.until_s
        passed = 0.2 if beside else 0.1
        self.now_s += passed
        self.own_s += 0.2
        self.used_s += 0.2 + (passed if beside else 0.0)

    def read_clock(self) -> stopwatch.Spent:
        return self.used_s, self.own_s, 2.0 * self.now_s


@pytest.fixture
def machine(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> Clock:
    clock = Clock(request.param)
    monkeypatch.setattr(stopwatch, "read_clock", clock.read_clock)
    monkeypatch.setattr("engine.core.stopwatch.time.perf_counter", lambda: clock.now_s)
    return clock


@pytest.mark.parametrize("machine", [0.0], indirect=True)
def test_a_quiet_machine_is_asked_for_one_window(machine: Clock) -> None:
    assert stopwatch.time_undisturbed(machine.work) == (pytest.approx(0.1), 0.0)
    assert machine.now_s <= stopwatch.WINDOW_S + 0.21


@pytest.mark.parametrize("machine", [1.0], indirect=True)
def test_another_program_is_waited_for(machine: Clock) -> None:
    assert stopwatch.time_undisturbed(machine.work) == (pytest.approx(0.1), pytest.approx(0.0, abs=1e-12))
    assert machine.now_s > 1.0


@pytest.mark.parametrize("machine", [100.0], indirect=True)
def test_a_busy_machine_is_told_after_some_patience(machine: Clock) -> None:
    shortest_s, load = stopwatch.time_undisturbed(machine.work)
    assert shortest_s == pytest.approx(0.2)
    assert load == pytest.approx(0.5)
    assert machine.now_s < stopwatch.PATIENCE_S + 1.0


def test_children_are_no_other_programs() -> None:
    """One lives and has worked for half a second of a CPU, and then it has ended."""
    work = "import time\nwhile time.process_time() < 0.5: pass\nprint('done', flush=True)\ninput()"
    before = stopwatch.read_clock()
    with subprocess.Popen([sys.executable, "-c", work], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as child:
        assert child.stdout is not None
        child.stdout.readline()
        alive = stopwatch.read_clock()
        child.communicate(b"\n")
    ended = stopwatch.read_clock()
    assert alive[1] - before[1] >= 0.45
    assert ended[1] - before[1] >= 0.45

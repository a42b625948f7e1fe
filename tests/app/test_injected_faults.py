"""Failures of disk and memory in all verbs and functions of the library: a few in each suite, 20,000 with `--long`."""

from __future__ import annotations

from pathlib import Path

import pytest

from engine.core.errors import OutOfMemory
from tests.app import injected_faults
from tests.app.injected_faults import QUICK, WORKS, Faults, Work, choose, reduced

#: Failures of a round of the campaign, of which there are 20.
FAULTS = 1000


@pytest.fixture(scope="module")
def faults(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> Faults:
    return Faults(tmp_path_factory.mktemp("faults") / "all", all_works=bool(request.config.getoption("--long")))


@pytest.mark.campaign(rounds=21)
def test_whatever_fails_is_said_in_a_sentence_and_nothing_is_lost(seed: int, faults: Faults) -> None:
    if seed:
        numbers: list[int] = list(range(FAULTS * seed, FAULTS * (seed + 1)))
    else:
        numbers = [number for number in range(8 * len(WORKS)) if choose(number).name in QUICK]
    with reduced():
        broken = [f"{number}: {said}" for number in numbers if (said := faults.inject(number))]
    assert not broken, "\n".join(broken)
    assert faults.outcomes["refused"] > len(numbers) // 4


def test_a_rule_that_is_broken_is_told(faults: Faults, monkeypatch: pytest.MonkeyPatch) -> None:
    """A work that leaves a half-written file, and one from which a bare exception comes."""

    def careless(_inputs: Path, target: Path) -> None:
        target.with_name("half").write_bytes(b"1")
        try:
            target.write_bytes(b"2")
        except OSError as error:
            raise OutOfMemory("no room") from error

    def bare(_inputs: Path, target: Path) -> None:
        target.write_bytes(b"2")

    works = Work("careless", function=careless, output="a"), Work("bare", function=bare, output="a")
    monkeypatch.setattr(injected_faults, "WORKS", works)
    said = [faults.inject(number) for number in range(40)]
    assert any("left ['half']" in each for each in said)
    assert any("OSError" in each or "PermissionError" in each for each in said)

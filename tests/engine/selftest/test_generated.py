"""Laws of the self-test hold; a law that does not is found, made small, kept, and asked again from its file."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import strategies as st

from engine.core.errors import InputError, OutOfMemory, UsageError
from engine.core.steps import drain
from engine.selftest.generated import search as searching
from engine.selftest.generated.brdf import LAWS
from engine.selftest.generated.law import Law, decades, draw, many
from engine.selftest.generated.search import CASES, ask_file, search, write_broken

#: A law that lists with a number above 100 break, by how many there are.
BAD = Law(
    "Y1", "large numbers", draw(values=many(decades(0, 3))), lambda case: (sum(v > 100 for v in case["values"]), 0)
)


@pytest.fixture
def bad(monkeypatch: pytest.MonkeyPatch) -> Law:
    monkeypatch.setattr(searching, "LAWS", (BAD, LAWS[0]))
    return BAD


def test_all_laws_hold() -> None:
    """Few cases of each; `--long` draws all."""
    found = drain(search(2 * len(searching.LAWS)))
    assert found.broken == ()
    assert found.laws == len(searching.LAWS) == len({law.id for law in searching.LAWS})
    assert found.cases >= found.laws


@pytest.mark.long
def test_all_laws_hold_for_long() -> None:
    found = drain(search(CASES, 1))
    assert found.broken == ()
    assert found.cases >= 0.9 * CASES


@pytest.mark.parametrize("seed", range(3))
def test_what_breaks_a_law_is_made_as_small_as_it_can_be(bad: Law, seed: int) -> None:
    (broken,) = drain(search(200, seed)).broken
    assert broken.id == bad.id
    assert broken.values == {"values": [pytest.approx(1000.0)]}
    assert broken.case.measured == 1.0


def test_a_kept_case_is_asked_again(bad: Law, tmp_path: Path) -> None:
    broken = drain(search(200)).broken
    write_broken(broken, tmp_path / "cases.json")
    (case,) = drain(ask_file(tmp_path / "cases.json"))
    assert case == broken[0].case
    assert not case.passed


@pytest.mark.parametrize(
    "content", [b"0", b"[]", b'{"schema": 1}', b'{"schema": "lightarc-selftest-cases-1"}', b"\xff"]
)
def test_another_file_is_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "cases.json"
    path.write_bytes(content)
    with pytest.raises(InputError, match="holds no cases"):
        drain(ask_file(path))


def test_values_of_a_stranger_end_in_a_sentence(bad: Law, tmp_path: Path) -> None:
    path = tmp_path / "cases.json"
    values: list[Any] = [{}, {"values": 1}, {"values": ["a"]}]
    path.write_text(
        json.dumps({"schema": searching.SCHEMA, "cases": [{"law": "Y1", "values": each} for each in values]})
    )
    cases = drain(ask_file(path))
    assert [case.passed for case in cases] == [False] * 3
    assert all(case.problem for case in cases)


def test_what_raises_breaks_its_law(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(searching, "LAWS", (replace(BAD, cases=draw(values=st.just([])), ask=lambda case: (1 / 0, 0)),))
    (broken,) = drain(search(10)).broken
    assert "ZeroDivisionError" in broken.case.problem


def test_a_case_that_breaks_a_law_at_times_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = iter(range(1000))
    at_times = replace(BAD, cases=draw(values=st.just([])), ask=lambda case: (float(next(asked) == 0), 0.0))
    monkeypatch.setattr(searching, "LAWS", (at_times,))
    assert [each.id for each in drain(search(10)).broken] == [BAD.id]


def test_too_little_memory_breaks_no_law(monkeypatch: pytest.MonkeyPatch) -> None:
    def run_out(_case: Any) -> Any:
        raise BlockingIOError(11, "Resource temporarily unavailable")

    monkeypatch.setattr(searching, "LAWS", (replace(BAD, cases=draw(values=st.just([])), ask=run_out),))
    with pytest.raises(OutOfMemory, match="process"):
        drain(search(10))


@pytest.mark.parametrize(("cases", "only"), [(0, ()), (10, ("Y9",)), (10, ("BR1", "Y9"))])
def test_wrong_words_are_refused(cases: int, only: tuple[str, ...]) -> None:
    with pytest.raises(UsageError):
        drain(search(cases, 0, only))

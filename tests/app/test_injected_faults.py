"""Failures of disk and memory in all verbs and functions of the library: a few in each suite, 20,000 with `--long`."""

from __future__ import annotations

import argparse
import inspect
from collections.abc import Iterator
from pathlib import Path

import pytest

import lightarc
from app.arguments.results import Output
from app.command_line import VERBS, build_parser
from engine.core.errors import OutOfMemory
from engine.transport import method as transport
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


#: Outputs of options that no work writes, and why.
NO_WORK = {
    "bench --record": "runs windows for minutes; not installed",
    "bench --keep": "makes captures for an hour; not installed",
}


def _outputs(parser: argparse.ArgumentParser, verb: str = "") -> Iterator[tuple[str, str]]:
    """The arguments of every verb and of its actions that name an output, as 'verb' and option."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, below in action.choices.items():
                yield from _outputs(below, f"{verb} {name}".strip())
        elif isinstance(action.type, Output) and action.option_strings[0] != "--log":  # is there after a failure too
            yield verb, action.option_strings[0]


def test_every_verb_and_every_function_has_a_work() -> None:
    lines = [work.words.split() for work in WORKS if work.words]
    assert {name for name, *_ in VERBS} == {line[0] for line in lines}
    for verb in ("project", "bundle", "export"):
        positional = next(each for each in _parser(verb)._actions if each.choices and each.dest in ("action", "to"))
        assert positional.choices is not None
        given = {word for line in lines if line[0] == verb for word in line}
        assert set(positional.choices) <= given, verb
    for verb, option in _outputs(build_parser()):
        words = verb.split()
        writes = any(line[: len(words)] == words and option in line for line in lines)
        assert writes or f"{verb} {option}" in NO_WORK, f"no work has the output {option} of {verb}"
    for mode in transport.names():
        assert any(line[0] == "bake" and mode in line for line in lines), f"no work bakes {mode}"
    functions = {name for name in lightarc.__all__ if inspect.isfunction(getattr(lightarc, name))}
    works = {work.name.split()[0] for work in WORKS if work.function is not None}
    untouched = {name for name in functions if name.startswith("register_")} | {"param"}
    assert functions - untouched <= works, "a function of the library has no work"


def _parser(verb: str) -> argparse.ArgumentParser:
    parsers = next(each for each in build_parser(verb)._actions if isinstance(each, argparse._SubParsersAction))
    found: argparse.ArgumentParser = parsers.choices[verb]
    return found

"""Search for cases that break a law: drawn by seed, and made as small as they can be (Hypothesis).

Cases that break a law are written as JSON, so that they can be sent and asked again.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, Phase, Verbosity, given, seed, settings
from hypothesis.errors import Flaky

from engine.core.errors import InputError, UsageError, shortage
from engine.core.steps import Step, Steps
from engine.selftest.case import Case, Question
from engine.selftest.generated import brdf, files, images, light
from engine.selftest.generated.law import Law, Values
from engine.selftest.run import ask as ask_question
from engine.storage.atomic import write_bytes
from engine.storage.untrusted import read_bytes

LAWS: tuple[Law, ...] = (*images.LAWS, *brdf.LAWS, *light.LAWS, *files.LAWS)

#: Cases of a whole search, over all laws, and rounds in which they are drawn; a search can be cancelled between laws.
CASES, ROUNDS = 10_000, 10

#: The most cases of a search, and the most that are drawn of a law between two moments at which it can be cancelled.
MAX_CASES, MAX_AT_ONCE = 10**9, 100

#: Schema of a file of cases, and the most bytes that are read of one.
SCHEMA, MAX_BYTES = "lightarc-selftest-cases-1", 1 << 18


@dataclass(frozen=True)
class Broken:
    """The smallest case found that breaks the law `id`, the seed that it was drawn with, and what came out."""

    id: str
    values: Values
    seed: int
    case: Case


@dataclass(frozen=True)
class Searched:
    """The laws that were asked, how many cases were drawn of them, and those that break one."""

    laws: int
    cases: int
    broken: tuple[Broken, ...]


def search(cases: int = CASES, first_seed: int = 0, only: Sequence[str] = ()) -> Steps[Searched]:
    """Some `cases` over all laws, or those of the ids `only`, from `first_seed` on; a broken law is not asked again.

    About 25 ms a case on two cores, most of it the decoders. UsageError for a number of cases outside 1 … `MAX_CASES`,
    and for an id that is not known.
    """
    if not 1 <= cases <= MAX_CASES:
        raise UsageError(f"the number of cases must lie between 1 and {MAX_CASES:,}")
    laws = [law for law in LAWS if not only or law.id in only]
    if not laws or set(only) - {law.id for law in laws}:
        raise UsageError(f"unknown property; choose from {', '.join(law.id for law in LAWS)}")
    drawn, broken = 0, dict[str, Broken]()
    each = min(math.ceil(cases / (len(laws) * ROUNDS)), MAX_AT_ONCE)
    rounds = math.ceil(cases / (len(laws) * each))
    for number in range(rounds):
        for place, law in enumerate(laws):
            share = (number + place / len(laws)) / rounds
            yield Step(share, f"{drawn} cases, {len(broken)} laws broken; {law.text}")
            if law.id in broken:
                continue
            count, worst = _find_broken(law, each, first_seed + number)
            drawn += count
            if worst is not None:
                broken[law.id] = worst
    return Searched(len(laws), drawn, tuple(broken.values()))


def ask(law: Law, values: Values) -> Case:
    return ask_question(Question(law.id, law.text, lambda: law.ask(values)))


def _find_broken(law: Law, count: int, number: int) -> tuple[int, Broken | None]:
    """The number of cases drawn, and the smallest that breaks the law, which is the last that Hypothesis asks."""
    found: list[Broken] = []
    drawn = 0

    @seed(number)
    @settings(
        max_examples=count,
        database=None,
        deadline=None,
        phases=(Phase.generate, Phase.shrink),
        suppress_health_check=list(HealthCheck),
        report_multiple_bugs=False,
        verbosity=Verbosity.quiet,
    )
    @given(law.cases)
    def holds(values: Values) -> None:
        nonlocal drawn
        drawn += not found
        case = ask(law, values)
        if not case.passed:
            found.append(Broken(law.id, values, number, case))
            raise AssertionError(law.id)

    try:
        holds()
    except AssertionError:
        return drawn, found[-1]
    except Flaky as error:  # a case that is broken at times, as where a decoder process is ended
        if (lack := shortage(error)) is not None:
            raise lack from error
        if not found:
            raise
        return drawn, found[-1]
    return drawn, None


def write_broken(broken: Sequence[Broken], path: Path) -> None:
    """The cases as a file of JSON; OutputError where it cannot be written."""
    cases = [
        {
            "law": each.id,
            "values": each.values,
            "seed": each.seed,
            "measured": each.case.measured,
            "bound": each.case.bound,
            "problem": each.case.problem,
        }
        for each in broken
    ]
    write_bytes(path, (json.dumps({"schema": SCHEMA, "cases": cases}, indent=1) + "\n").encode())


def ask_file(path: Path) -> Steps[tuple[Case, ...]]:
    """The cases of a file, asked on this machine; InputError for what is no such file."""
    laws = {law.id: law for law in LAWS}
    try:
        record: Any = json.loads(read_bytes(path, MAX_BYTES))
        if record["schema"] != SCHEMA:
            raise ValueError
        asked_again = [(laws[each["law"]], dict(each["values"])) for each in record["cases"]]
    except (ValueError, KeyError, TypeError, RecursionError):
        raise InputError(path, "it holds no cases of the self-test", "Choose a file that --long has written") from None
    cases: list[Case] = []
    for place, (law, values) in enumerate(asked_again):
        yield Step(place / len(asked_again), law.text)
        cases.append(ask(law, values))
    return tuple(cases)

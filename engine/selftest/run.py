"""Asking all questions one after the other; a row that fails does not stop the others."""

from __future__ import annotations

import math
import warnings

from engine.core.errors import FileError, MissingCapability, UsageError, shortage
from engine.core.steps import Step, Steps
from engine.core.suggestion import suggest
from engine.selftest import brdf as selftest_brdf
from engine.selftest import confinement, files, images, light
from engine.selftest.case import Case, Question, group_of

QUESTIONS: tuple[Question, ...] = (
    *images.QUESTIONS,
    *selftest_brdf.QUESTIONS,
    *light.QUESTIONS,
    *files.QUESTIONS,
    *confinement.QUESTIONS,
)

#: Exceptions that a row reports as its failure.
FAILURES = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    FileError,
    LookupError,
    OSError,
    RuntimeError,
    RuntimeWarning,
    TypeError,
    ValueError,
)


def selftest(only: tuple[str, ...] = ()) -> Steps[tuple[Case, ...]]:
    """All cases, or those of the ids or groups `only`; each step's `partial` holds those that are done.

    Some 20 s, of which starting compiled code takes most. A measure that is not finite is reported as −1 and a problem.
    UsageError for an id that is not known.
    """
    known = {question.id for question in QUESTIONS} | {group_of(question.id) for question in QUESTIONS}
    for name in only:
        if name not in known:
            raise UsageError(f"unknown case {name!r}{suggest(name, known)}; choose from {', '.join(sorted(known))}")
    chosen = [each for each in QUESTIONS if not only or each.id in only or group_of(each.id) in only]
    cases: list[Case] = []
    for number, question in enumerate(chosen):
        yield Step(number / len(chosen), f"{question.id}: {question.text}", tuple(cases))
        cases.append(ask(question))
    yield Step(1.0, "done", tuple(cases))
    return tuple(cases)


def ask(question: Question) -> Case:
    """One case. What raises, and what warns of numbers, does not pass; what the machine lacks is said to be missing.

    Raises OutOfMemory where memory, threads or processes run out, which tells nothing of the case.
    """
    nothing = (question.id, question.text, 0.0, 0.0)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            measured, bound = question.ask()
    except MissingCapability as error:
        return Case(*nothing, skipped=str(error))
    except FAILURES as error:
        if (lack := shortage(error)) is not None:
            raise lack from error
        return Case(*nothing, problem=f"{type(error).__name__}: {error}"[:300])
    if not math.isfinite(measured):
        return Case(question.id, question.text, -1.0, float(bound), problem=f"the figure is {measured}")
    return Case(question.id, question.text, float(measured), float(bound))

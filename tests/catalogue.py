"""The catalogue of numerical hard cases: where each is tested, and what was measured beside the bound.

    .venv/bin/python -m tests.catalogue FOLDER [ARGUMENTS OF PYTEST …]

Runs every test whose name begins with the id of a case (`test_X4_accumulators_do_not_overflow`; one test may stand for
several) and writes FOLDER/catalogue.md and catalogue.json: a row for each id, with its tests, how they ended, and of
all assertions that compare two numbers the one that came nearest to failing. Ids without a test are listed with the
reason. The figures are taken from the assertions themselves, so none is written down by hand.
"""

from __future__ import annotations

import ast
import json
import math
import os
import re
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Generator, Iterable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from types import FrameType
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray

#: Letters of a group of cases, how many it has, and what they are about.
GROUPS = (
    ("X", 15, "errors in the papers"),
    ("R", 13, "RAW import and linearisation"),
    ("AL", 8, "alignment"),
    ("S", 11, "shading-map linearisation"),
    ("P", 11, "power-law fit"),
    ("BR", 11, "BRDF evaluation"),
    ("M", 11, "parametrisations"),
    ("F", 5, "tangent frames"),
    ("W", 17, "factorisation by SVD and power iteration"),
    ("L", 14, "homomorphic factorisation"),
    ("Q", 16, "four-dimensional rotations and search"),
    ("H", 14, "spherical harmonics"),
    ("Z", 16, "Haar wavelets and quantisation"),
    ("V", 12, "visibility and meshes"),
    ("G", 17, "Gaussian fit"),
    ("EN", 13, "environment and prefiltering"),
    ("GL", 10, "OpenGL and display"),
    ("CO", 9, "colour"),
    ("T", 8, "effects, accuracy and time"),
)

#: Figures taken of one test: one that draws many examples would spend its time on being explained.
MAX_FIGURES = 200

#: Why a case has no test.
WITHOUT_TEST: dict[str, str] = {}

_NAME = re.compile(r"test_((?:[A-Z]{1,2}\d+_)*[A-Z]{1,2}\d+)(?:_|$|\[)")
_WRAPPED = re.compile(r"np\.\w+\(([^()]*)\)")

_RELATIONS: dict[type[ast.cmpop], str] = {ast.LtE: "<=", ast.Lt: "<", ast.GtE: ">=", ast.Gt: ">", ast.Eq: "="}

#: Syntax allowed in an expression that is evaluated a second time, because it changes nothing.
_PURE = (
    *(ast.Name, ast.Attribute, ast.Subscript, ast.Constant, ast.BinOp, ast.UnaryOp, ast.Slice, ast.Tuple, ast.Load),
    *(ast.operator, ast.unaryop, ast.Call, ast.keyword),
)


@dataclass(frozen=True)
class Figure:
    """A comparison of two numbers that held: `measured` beside its `bound`; `share` of the bound that it reaches."""

    measured: float
    relation: str
    bound: float
    where: str

    @property
    def is_real(self) -> bool:
        return self.relation != "=" and not (self.measured.is_integer() and self.bound.is_integer())

    @property
    def share(self) -> float:
        low, high = (self.measured, self.bound) if "<" in self.relation else (self.bound, self.measured)
        if self.relation == "=" or low <= 0.0:
            return 0.0
        return low / high if math.isfinite(high) and high > 0.0 else 0.0


@dataclass
class Case:
    """Everything recorded of one id at the end of a run."""

    id: str
    group: str
    tests: list[str] = field(default_factory=list)
    outcome: str = "no test"
    figure: dict[str, Any] | None = None
    note: str = ""


def all_ids() -> list[str]:
    return [f"{letters}{number}" for letters, count, _ in GROUPS for number in range(1, count + 1)]


def ids_of(name: str) -> list[str]:
    """The cases that a test of this name stands for."""
    found = _NAME.match(name)
    return found[1].split("_") if found else []


def figure_of(explanation: str, where: str) -> Figure | None:
    """The two numbers that an assertion compared, as pytest explains it; None where it compared something else."""
    words = _WRAPPED.sub(r"\1", explanation.strip().splitlines()[0])
    if " ± " in words:
        found = re.fullmatch(r"(\S+) == (\S+) ± (\S+)", words)
        numbers = [_value(text) for text in found.groups()] if found else [None]
        if None in numbers:
            return None
        measured, expected, bound = numbers
        return Figure(abs(measured - expected), "<=", bound, where)  # type: ignore[operator, arg-type]
    compared = _comparison(words)
    if compared is None:
        return None
    low, relation, high = (
        _value(ast.unparse(compared.left)),
        compared.ops[0],
        _value(ast.unparse(compared.comparators[0])),
    )
    if low is None or high is None or type(relation) not in _RELATIONS:
        return None
    return Figure(low, _RELATIONS[type(relation)], high, where)


def array_figure(assertion: str, names: Mapping[str, Any], where: str) -> Figure | None:
    """The pair of numbers that came nearest in `(a <= b).all()`, evaluated anew among `names`."""
    try:
        called = ast.parse(assertion, mode="eval").body
    except SyntaxError:
        return None
    if not (isinstance(called, ast.Call) and isinstance(called.func, ast.Attribute) and called.func.attr == "all"):
        return None
    compared = called.args[0] if called.args else called.func.value
    if not (isinstance(compared, ast.Compare) and len(compared.ops) == 1 and type(compared.ops[0]) in _RELATIONS):
        return None
    sides = (compared.left, compared.comparators[0])
    if isinstance(compared.ops[0], ast.Eq) or not all(map(_is_pure, sides)):
        return None
    low, high = (_evaluate(side, names) for side in sides)
    if low is None or high is None:
        return None
    relation = _RELATIONS[type(compared.ops[0])]
    pairs = zip(*(each.ravel().tolist() for each in np.broadcast_arrays(low, high)), strict=True)
    return nearest(Figure(first, relation, second, where) for first, second in pairs)


def _is_pure(expression: ast.expr) -> bool:
    """True if only arithmetic happens: the only calls are those of numpy, and not for random numbers."""
    for node in ast.walk(expression):
        if not isinstance(node, _PURE):
            return False
        if isinstance(node, ast.Call) and not re.fullmatch(
            r"abs|len|max|min|np\.(?!random)\w+", ast.unparse(node.func)
        ):
            return False
    return True


def _evaluate(expression: ast.expr, names: Mapping[str, Any]) -> NDArray[np.float64] | None:
    value = eval(compile(ast.Expression(expression), "<assertion>", "eval"), dict(names))
    array = np.asarray(value)
    return array.astype(np.float64) if array.dtype.kind in "fiu" and array.size <= 1_000_000 else None


def _comparison(words: str) -> ast.Compare | None:
    try:
        compared = ast.parse(words, mode="eval").body
    except (SyntaxError, ValueError):
        return None
    return compared if isinstance(compared, ast.Compare) and len(compared.ops) == 1 else None


def _value(words: str) -> float | None:
    """The value of arithmetic on plain numbers."""
    try:
        tree = ast.parse(words, mode="eval")
    except SyntaxError:
        return None
    allowed = (ast.Expression, ast.Constant, ast.BinOp, ast.UnaryOp, ast.operator, ast.unaryop)
    if not all(isinstance(node, allowed) for node in ast.walk(tree)):
        return None
    value = eval(compile(tree, "<figure>", "eval"), {})
    return float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else None


def close_figure(actual: Any, desired: Any, rtol: float, atol: float, where: str) -> Figure | None:
    """The pair that came nearest to what `np.testing.assert_allclose` allows."""
    first, second = np.broadcast_arrays(np.asarray(actual), np.asarray(desired))
    if first.dtype.kind not in "fiu" or second.dtype.kind not in "fiu" or not first.size:
        return None
    first, second = first.astype(np.float64).ravel(), second.astype(np.float64).ravel()
    usable = np.isfinite(first) & np.isfinite(second)
    if not usable.any():
        return None
    first, second = first[usable], second[usable]
    apart, bound = np.abs(first - second), atol + rtol * np.abs(second)
    place = int(np.argmax(apart / np.maximum(bound, np.finfo(float).tiny)))
    return Figure(float(apart[place]), "<=", float(bound[place]), where)


def nearest(figures: Iterable[Figure]) -> Figure | None:
    """The figure that came nearest to its bound; counts and equalities only where there is nothing else."""
    return max(figures, key=lambda figure: (figure.is_real, figure.share), default=None)


def cases_of(outcomes: dict[str, dict[str, str]], figures: dict[str, list[Figure]]) -> list[Case]:
    """One case for each id, from the outcome of each test by id and from the figures by id."""
    titles = {f"{letters}{number}": words for letters, count, words in GROUPS for number in range(1, count + 1)}
    cases = []
    for name, title in titles.items():
        tests = outcomes.get(name, {})
        case = Case(name, title, sorted(tests))
        if tests:
            ended = set(tests.values())
            case.outcome = next((word for word in ("failed", "passed", "skipped") if word in ended), "not run")
        else:
            case.note = WITHOUT_TEST.get(name, "no test carries this id")
        best = nearest(figures.get(name, []))
        case.figure = None if best is None else asdict(best)
        cases.append(case)
    return cases


def as_table(cases: list[Case]) -> str:
    """The report for users."""
    counts: dict[str, int] = defaultdict(int)
    for case in cases:
        counts[case.outcome] += 1
    lines = ["# Numerical hard cases", "", ", ".join(f"{count} {word}" for word, count in sorted(counts.items())), ""]
    for title in dict.fromkeys(case.group for case in cases):
        lines += [f"## {title[0].upper()}{title[1:]}", "", "| id | outcome | measured | tests |", "|---|---|---|---|"]
        for case in (each for each in cases if each.group == title):
            tests = "<br>".join(f"`{test}`" for test in case.tests) or case.note
            lines.append(f"| {case.id} | {case.outcome} | {_words(case.figure)} | {tests} |")
        lines.append("")
    return "\n".join(lines)


def _words(figure: dict[str, Any] | None) -> str:
    if figure is None:
        return "holds exactly or by comparison of arrays"
    relation = figure["relation"].replace("<=", "≤").replace(">=", "≥")
    return f"{figure['measured']:.4g} {relation} {figure['bound']:.4g}"


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--catalogue", metavar="FOLDER", help="write the catalogue of hard cases into this folder")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    kept = [item for item in items if ids_of(item.name)]
    config.hook.pytest_deselected(items=[item for item in items if not ids_of(item.name)])
    items[:] = kept


def pytest_assertion_pass(item: pytest.Item, lineno: int, orig: str, expl: str) -> None:
    if len(item.user_properties) >= MAX_FIGURES:
        return
    where = f"{item.location[0]}:{lineno}"
    figure = figure_of(expl, where)
    if figure is None and (frame := _frame_of(item)) is not None:
        figure = array_figure(orig, {**frame.f_globals, **frame.f_locals}, where)
    if figure is not None:
        item.user_properties.append(("figure", asdict(figure)))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, None, None]:
    """Keep what `np.testing.assert_allclose` finds, which raises no hook of its own."""
    check = np.testing.assert_allclose

    def checked(actual: Any, desired: Any, rtol: float = 1e-7, atol: float = 0.0, **options: Any) -> None:
        check(actual, desired, rtol=rtol, atol=atol, **options)
        if len(item.user_properties) >= MAX_FIGURES:
            return
        figure = close_figure(actual, desired, rtol, atol, item.location[0])
        if figure is not None:
            item.user_properties.append(("figure", asdict(figure)))

    np.testing.assert_allclose = cast(Any, checked)
    try:
        yield
    finally:
        np.testing.assert_allclose = check


def _frame_of(item: pytest.Item) -> FrameType | None:
    """The innermost frame of the file of a test."""
    frame: FrameType | None = sys._getframe(1)
    while frame is not None and frame.f_code.co_filename != str(item.path):
        frame = frame.f_back
    return frame


def pytest_configure(config: pytest.Config) -> None:
    if config.getoption("--catalogue") and not hasattr(config, "workerinput"):
        config.pluginmanager.register(_Report(Path(config.getoption("--catalogue"))), "catalogue-report")


class _Report:
    """Gathers what every test says of its ids, and writes the report at the end."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.outcomes: dict[str, dict[str, str]] = defaultdict(dict)
        self.figures: dict[str, list[Figure]] = defaultdict(list)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.when != "call" and report.outcome == "passed":
            return
        test = report.nodeid.split("[")[0]
        for name in ids_of(report.nodeid.split("::")[-1]):
            if self.outcomes[name].get(test) != "failed":
                self.outcomes[name][test] = report.outcome
            figures = [Figure(**value) for key, value in report.user_properties if key == "figure"]  # type: ignore[arg-type]
            best = nearest(figures)
            if best is not None:
                self.figures[name].append(best)

    def pytest_sessionfinish(self) -> None:
        cases = cases_of(self.outcomes, self.figures)
        self.folder.mkdir(parents=True, exist_ok=True)
        (self.folder / "catalogue.md").write_text(as_table(cases))
        (self.folder / "catalogue.json").write_text(json.dumps([asdict(case) for case in cases], indent=1))


def main(words: list[str]) -> int:
    if not words:
        print(__doc__, file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory() as cache:
        # Assertions that tell what they compared are compiled differently, so the usual cache would hide them.
        environment = {**os.environ, "PYTHONPYCACHEPREFIX": cache}
        options = ["-p", "tests.catalogue", "--catalogue", words[0], "-o", "enable_assertion_pass_hook=true"]
        command = [sys.executable, "-m", "pytest", "-q", "-n", "2", "--dist", "worksteal", *options, *words[1:]]
        return subprocess.run(command, env=environment).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

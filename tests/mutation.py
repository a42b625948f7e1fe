"""Would the tests notice a wrong operator or constant? Changes of the engine, each run against the tests it concerns.

    python -m tests.mutation [--seed 0] [--count 30] [--files 6] [--cases FILE]

A change exchanges one operator, comparison or number in a function (by `ast`), in a copy of the project. The test files
that are nearest to the changed module by imports run on it in one process, the quickest first, without OpenGL and a
display where the module is not of `engine.gl`; a test that fails with the change and passes without it kills the
change. How long each file takes is learnt on the way and kept in the user's cache. Survivors are printed. `--cases`
takes changes from a file instead, one JSON object with `file`, `before` and `after` a line. Exit code 1 where fewer
than 95 % were killed.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import platformdirs

from tests.import_graph import PROJECT, module_of, modules, select_tests

#: Part of the changes that must be killed.
GOAL = 0.95

#: Seconds after which a run of tests on one change is taken to hang, which is noticing it.
LIMIT_S = 1200

#: Packages whose code is about tests and figures of papers, or only runs where other programs are installed.
EXCLUDED = ("engine.selftest", "engine.proof", "engine.figures")

#: Operator → what takes its place.
OPERATORS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
    ast.And: ast.Or,
    ast.Or: ast.And,
}

#: A file with the seconds that each file of tests takes.
SECONDS = platformdirs.user_cache_path("lightarc-tests") / "seconds.json"

#: Tests run beside other programs, in one thread.
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "LP_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}

#: Variables with which no OpenGL and no display are found.
WITHOUT_OPENGL = {"__EGL_VENDOR_LIBRARY_FILENAMES": os.devnull, "LIBGL_DRIVERS_PATH": os.devnull}


@dataclass(frozen=True)
class Mutant:
    """One change: `before`, from an offset in the text of a file, becomes `after`."""

    file: str
    line: int
    offset: int
    before: str
    after: str

    def apply_to(self, text: str) -> str:
        assert text[self.offset :].startswith(self.before), f"{self.file} has changed"
        return text[: self.offset] + self.after + text[self.offset + len(self.before) :]

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {' '.join(self.before.split())}  ->  {self.after}"


def mutants_of(file: str, text: str) -> list[Mutant]:
    """All changes of functions in a module. Docstrings, annotations, messages, `Step`s of progress and asserts stay."""
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))

    def at(line: int, column: int) -> int:
        row = text[starts[line - 1] : starts[line]]
        return starts[line - 1] + len(row.encode()[:column].decode())

    found = []
    for function in ast.walk(ast.parse(text)):
        if isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef) and not function.name.startswith("__"):
            for node in _inner(function):
                for changed in _changes(node):
                    begin, end = at(node.lineno, node.col_offset), at(node.end_lineno or 0, node.end_col_offset or 0)
                    after = ast.unparse(changed)
                    after = after if isinstance(changed, ast.Constant) else f"({after})"
                    found.append(Mutant(file, node.lineno, begin, text[begin:end], after))
    return sorted(set(found), key=lambda each: (each.offset, each.after))


def _inner(function: ast.FunctionDef | ast.AsyncFunctionDef) -> Iterator[ast.expr]:
    """Expressions of the body of a function that are worth changing."""
    waiting: list[ast.AST] = list(function.body)
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.Assert | ast.Raise | ast.JoinedStr | ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        if (
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Name)
            and node.func.id in {"Step", "cast", "shortest"}
        ):
            continue
        if isinstance(node, ast.AnnAssign):
            waiting += [node.value] if node.value else []
            continue
        if isinstance(node, ast.expr):
            yield node
        waiting += ast.iter_child_nodes(node)


def _changes(node: ast.expr) -> Iterator[ast.expr]:
    if isinstance(node, ast.BinOp) and type(node.op) in OPERATORS and not _is_text(node):
        yield ast.BinOp(node.left, OPERATORS[type(node.op)](), node.right)  # type: ignore[arg-type]
    elif isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in OPERATORS:
        yield ast.Compare(node.left, [OPERATORS[type(node.ops[0])]()], node.comparators)  # type: ignore[list-item]
    elif isinstance(node, ast.BoolOp):
        yield ast.BoolOp(OPERATORS[type(node.op)](), node.values)  # type: ignore[arg-type]
    elif isinstance(node, ast.Constant) and isinstance(node.value, int | float) and not isinstance(node.value, bool):
        yield ast.Constant(node.value + 1 if node.value in (0, 1) else node.value * 2)


def _is_text(node: ast.BinOp) -> bool:
    return any(
        isinstance(side, ast.JoinedStr | ast.Constant) and not _is_number(side) for side in (node.left, node.right)
    )


def _is_number(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, int | float)


def draw(seed: int, count: int) -> list[Mutant]:
    """One change in each of `count` different modules of the engine, longer ones being likelier."""
    rng = random.Random(seed)
    paths = [
        path
        for name, path in modules().items()
        if name.startswith("engine.") and not name.startswith(EXCLUDED) and path.name != "__init__.py"
    ]
    order = sorted(paths, key=lambda path: rng.random() ** (1.0 / path.stat().st_size), reverse=True)
    found: list[Mutant] = []
    for path in order:
        if len(found) == count:
            break
        mutants = mutants_of(path.relative_to(PROJECT).as_posix(), path.read_text(encoding="utf-8"))
        found += rng.sample(mutants, 1) if mutants else []
    return found


def read_cases(path: Path) -> list[Mutant]:
    """Changes of a file of cases."""
    found = []
    for line in path.read_text(encoding="utf-8").splitlines():
        case = json.loads(line)
        text = (PROJECT / case["file"]).read_text(encoding="utf-8")
        offset = text.find(case["before"])
        if offset < 0:
            print(f"{case['file']} no longer holds {case['before']}")
            continue
        found.append(Mutant(case["file"], text.count("\n", 0, offset) + 1, offset, case["before"], case["after"]))
    return found


def copy_project(folder: Path) -> None:
    """Copy the files that git knows and new ones, not those that it ignores."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    for name in subprocess.run(command, cwd=PROJECT, capture_output=True, text=True, check=True).stdout.split("\0"):
        if name and (PROJECT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(PROJECT / name, folder / name)


def find_killer(mutant: Mutant, copy: Path, files: int, excused: set[str]) -> str | None:
    """The test that notices `mutant`, 'a hang', or None. Tests that fail without it as well are added to `excused`."""
    path = copy / mutant.file
    text = path.read_text(encoding="utf-8")
    tests = [test.relative_to(PROJECT).as_posix() for test in select_tests(module_of(PROJECT / mutant.file))]
    if without_opengl := not mutant.file.startswith("engine/gl/"):
        tests = [test for test in tests if not test.startswith("tests/engine/gl/")]
    seconds = known_seconds()
    tests = sorted(tests[:files], key=lambda test: seconds.get(test, guess_seconds(PROJECT / test)))
    try:
        while tests:
            path.write_text(mutant.apply_to(text), encoding="utf-8")
            failed = first_failure(copy, [*tests, *_deselected(excused)], without_opengl=without_opengl)
            path.write_text(text, encoding="utf-8")
            if failed in (None, "a hang") or first_failure(copy, [failed], without_opengl=without_opengl) is None:
                return failed
            excused.add(failed)
            tests = tests[tests.index(failed.partition("::")[0]) :]
    finally:
        path.write_text(text, encoding="utf-8")
    return None


def _deselected(tests: Iterable[str]) -> list[str]:
    return [word for test in sorted(tests) for word in ("--deselect", test)]


def first_failure(copy: Path, words: Sequence[str], *, without_opengl: bool) -> str | None:
    """The first test of `words` that fails in a copy; None where none does, 'a hang' where they do not end."""
    environment = {**os.environ, **ONE_THREAD, "PYTHONPATH": str(copy)}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    if without_opengl:
        environment.update(WITHOUT_OPENGL)
        environment.pop("DISPLAY", None)
    report = copy / "junit.xml"
    command = [sys.executable, "-m", "pytest", "-x", "-q", "--tb=no", f"--junit-xml={report}", *words]
    try:
        done = subprocess.run(command, cwd=copy, env=environment, capture_output=True, text=True, timeout=LIMIT_S)
    except subprocess.TimeoutExpired:
        return "a hang"
    if done.returncode in (0, 5):
        if "::" not in words[0]:
            learn_seconds(report)
        return None
    found = re.search(r"^(?:FAILED|ERROR) (.+?)(?: - |$)", done.stdout, re.MULTILINE)
    return found[1] if found else str(words[0])


def guess_seconds(test: Path) -> float:
    """Longer files take longer, as far as nobody has measured them."""
    return test.stat().st_size / 2000.0


def known_seconds() -> dict[str, float]:
    """The seconds that files of tests took when they last ran as a whole."""
    if not SECONDS.is_file():
        return {}
    return {str(test): float(took) for test, took in json.loads(SECONDS.read_text(encoding="utf-8")).items()}


def learn_seconds(report: Path) -> None:
    """Keep the seconds of the files in a report of pytest of which every test ran."""
    found: dict[str, float] = {}
    for case in ElementTree.parse(report).iter("testcase"):
        test = f"{case.get('classname', '').replace('.', '/')}.py"
        found[test] = found.get(test, 0.0) + float(case.get("time", "0"))
    SECONDS.parent.mkdir(parents=True, exist_ok=True)
    SECONDS.write_text(json.dumps({**known_seconds(), **found}, indent=1), encoding="utf-8")


def run(mutants: Sequence[Mutant], files: int) -> list[Mutant]:
    """Run all changes; what survives."""
    survivors = []
    excused: set[str] = set()
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "project"
        copy_project(copy)
        for number, mutant in enumerate(mutants, 1):
            found = find_killer(mutant, copy, files, excused)
            survivors += [] if found else [mutant]
            print(f"{number}/{len(mutants)} {f'killed by {found}' if found else 'SURVIVED'}: {mutant}", flush=True)
    return survivors


def main(words: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="tests.mutation", description="Change the engine and see which tests notice.")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--count", type=int, default=30, help="number of changes, each of another module")
    parser.add_argument("--files", type=int, default=6, help="test files that run on each change, the nearest first")
    parser.add_argument("--cases", type=Path, help="take the changes from this file")
    options = parser.parse_args(words)
    mutants = read_cases(options.cases) if options.cases else draw(options.seed, options.count)
    survivors = run(mutants, options.files)
    killed = len(mutants) - len(survivors)
    print(f"{killed} of {len(mutants)} changes killed, seed {options.seed}")
    for mutant in survivors:
        print(f"survived: {mutant}")
    return 0 if killed >= GOAL * len(mutants) else 1


if __name__ == "__main__":
    sys.exit(main())

"""Who imports whom in the program and its tests, and which test files concern a module.

    python -m tests.import_graph [REVISION]    test files that concern what differs from REVISION (HEAD), one a line

Modules that are named in strings (verbs, methods, names that tests patch) count as imported. Files that are no modules
(shaders, resources, pyproject.toml) concern all tests: nothing is printed for them, and exit code 3 says so.
"""

from __future__ import annotations

import re
import subprocess
import sys
from collections import deque
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1]

PACKAGES = ("engine", "app", "lightarc", "benchmarks", "tests")

#: An import of one of them, with the names that follow, and a string that names one.
_FROM = re.compile(rf"^[ \t]*from ((?:{'|'.join(PACKAGES)})\b[\w.]*) import (\([^)]*\)|[^\n]*)", re.MULTILINE)
_IMPORT = re.compile(rf"^[ \t]*import ((?:{'|'.join(PACKAGES)})\b[\w.]*)", re.MULTILINE)
_STRING = re.compile(rf"[\"']((?:{'|'.join(PACKAGES)})(?:\.\w+)+)[\"']")


@cache
def modules() -> dict[str, Path]:
    """Dotted name of each module and its file."""
    paths = (path for top in PACKAGES for path in sorted((PROJECT / top).rglob("*.py")))
    return {module_of(path): path for path in paths}


def module_of(path: Path) -> str:
    return ".".join(path.relative_to(PROJECT).with_suffix("").parts).removesuffix(".__init__")


def imports_in(text: str) -> Iterator[tuple[int, str]]:
    """Line and dotted name of what a module imports anywhere: without a tree, which takes twenty times as long."""
    for match in _FROM.finditer(text):
        line = 1 + text.count("\n", 0, match.start())
        yield from ((line, f"{match[1]}.{name}") for name in re.findall(r"(\w+)(?: as \w+)?", match[2]))
    for match in _IMPORT.finditer(text):
        yield 1 + text.count("\n", 0, match.start()), match[1]


def names_in(text: str) -> Iterator[str]:
    """Dotted names that a module imports anywhere or names in a string."""
    yield from (name for _line, name in imports_in(text))
    yield from _STRING.findall(text)


def nearest_module(name: str) -> str | None:
    """The module of a dotted name, which may go on with names in it; None for those of others."""
    while name not in modules():
        name, _, last = name.rpartition(".")
        if not last:
            return None
    return name


@cache
def importers() -> dict[str, set[str]]:
    """Module → modules that import it, and the `conftest` modules that pytest imports for the tests below them."""
    found: dict[str, set[str]] = {name: set() for name in modules()}
    for name, path in modules().items():
        for other in filter(None, map(nearest_module, names_in(path.read_text(encoding="utf-8")))):
            found[other].add(name)
    return found


def distances(changed: Iterable[str]) -> dict[str, int]:
    """Modules that import one of `changed`, by steps in between, the nearest first."""
    found = dict.fromkeys(changed, 0)
    queue = deque(found)
    while queue:
        name = queue.popleft()
        for other in sorted(importers().get(name, ())):
            if other not in found:
                found[other] = found[name] + 1
                queue.append(other)
    return found


def select_tests(*changed: str) -> list[Path]:
    """Files of tests that import a module of `changed`: that of its name first, then the nearest, its folder's first.

    A `conftest` stands for the tests of its folder and below.
    """
    near: dict[Path, int] = {}
    for name, steps in distances(changed).items():
        path = modules()[name]
        if path.name == "conftest.py":
            for test in path.parent.rglob("test_*.py"):
                near[test] = min(near.get(test, steps + 1), steps + 1)
        elif path.name.startswith("test_"):
            near[path] = min(near.get(path, steps), steps)
    folders = {PROJECT / "tests" / modules()[name].parent.relative_to(PROJECT) for name in changed}
    named = {f"test_{modules()[name].name}" for name in changed}

    def order(path: Path) -> tuple[bool, int, bool, Path]:
        beside = path.parent in folders
        return not (beside and path.name in named), near[path], not beside, path

    return sorted(near, key=order)


def changed_files(revision: str) -> list[str]:
    """Files that differ from a revision, and new ones."""
    commands = (["diff", "--name-only", "--no-renames", revision], ["ls-files", "--others", "--exclude-standard"])
    return sorted(
        line
        for command in commands
        for line in subprocess.run(
            ["git", *command], cwd=PROJECT, capture_output=True, text=True, check=True
        ).stdout.splitlines()
    )


def main(revision: str = "HEAD") -> int:
    files = changed_files(revision)
    known = {path.relative_to(PROJECT).as_posix(): name for name, path in modules().items()}
    if any(not file.endswith(".md") and file not in known for file in files):
        return 3
    for path in select_tests(*(known[file] for file in files if file in known)):
        print(path.relative_to(PROJECT).as_posix())
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))

"""Build Lightarc for pip: setuptools, but a wheel holds one top-level package, `lightarc`.

In the repository `engine/`, `app/` and `resources/` stand at the top and name each other so, which reads well, and
which an editable installation keeps. Installed under these names they would collide with anything. For a wheel they
are copied into `lightarc/`, and the copies name each other by their new places: in import statements, and in strings
that hold the dotted name of a module, as tables of verbs and decoders do. Nothing else changes, and no line moves.
A name that cannot be changed safely ends the build. The manual for a browser goes along where it has been built.
"""

from __future__ import annotations

import ast
import itertools
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import chdir, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from setuptools import build_meta
from setuptools.build_meta import (
    build_editable,
    build_sdist,
    get_requires_for_build_editable,
    get_requires_for_build_sdist,
    get_requires_for_build_wheel,
    prepare_metadata_for_build_editable,
)

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
    "prepare_metadata_for_build_editable",
    "prepare_metadata_for_build_wheel",
]

PROJECT = Path(__file__).resolve().parents[1]
PACKAGE = "lightarc"
INNER = ("app", "engine", "resources")

#: The manual for a browser, where `packaging/dev.py manual` has built it.
MANUAL = PROJECT / "build" / "manual" / "html"

_DOTTED = re.compile(rf"(?<![\w./])(?:{'|'.join(INNER)})(?:\.[A-Za-z_]\w*)+")
_QUOTED = re.compile(rf'"(?=(?:{"|".join(INNER)})[".*])')

#: An insertion into a file, before a line and a byte of that line (both from 0): an old text that stands there, and
#: the new one.
Edit = tuple[int, int, str, str]


class UnclearName(Exception):
    """A name of an inner package that cannot be changed safely; the message says where it is and what to write."""


def build_wheel(directory: str, settings: dict[str, Any] | None = None, metadata: str | None = None) -> str:
    """The hook of PEP 517; `metadata` is not used, since it is made along with the wheel."""
    directory = os.path.abspath(directory)  # noqa: PTH100 - as the hook hands it on
    with stage_sources():
        return str(build_meta.build_wheel(directory, settings))


def prepare_metadata_for_build_wheel(directory: str, settings: dict[str, Any] | None = None) -> str:
    directory = os.path.abspath(directory)  # noqa: PTH100 - as the hook hands it on
    with stage_sources():
        return str(build_meta.prepare_metadata_for_build_wheel(directory, settings))


@contextmanager
def stage_sources() -> Iterator[None]:
    """Within the block the working folder is a copy of the project as it is to be installed."""
    with TemporaryDirectory(prefix="lightarc-wheel-") as name:
        stage(PROJECT, Path(name))
        with chdir(name):
            yield


def stage(project: Path, target: Path) -> None:
    """Copy `project` into `target`, its inner packages into the one that is installed."""
    leave_out = shutil.ignore_patterns("__pycache__", "*.partial-*")
    shutil.copytree(project / PACKAGE, target / PACKAGE, ignore=leave_out)
    for name in INNER:
        shutil.copytree(project / name, target / PACKAGE / name, ignore=leave_out)
    if MANUAL.is_dir():
        shutil.copytree(MANUAL, target / PACKAGE / "resources" / "manual" / "html", ignore=leave_out)
    for name in ("LICENSE", "README.md"):
        shutil.copy(project / name, target)
    described = (project / "pyproject.toml").read_text(encoding="utf-8")
    (target / "pyproject.toml").write_text(_QUOTED.sub(f'"{PACKAGE}.', described), encoding="utf-8")
    modules = modules_of(target / PACKAGE)
    for path in sorted((target / PACKAGE).rglob("*.py")):
        try:
            changed = rewrite(path.read_text(encoding="utf-8"), modules)
        except UnclearName as unclear:
            raise UnclearName(f"{path.relative_to(target / PACKAGE)}:{unclear}") from None
        path.write_text(changed, encoding="utf-8")


def modules_of(folder: Path) -> set[str]:
    """The dotted names of all modules and packages in the inner packages that lie in `folder`."""
    paths = [path.relative_to(folder).with_suffix("") for name in INNER for path in (folder / name).rglob("*.py")]
    return {".".join(place.parts) for path in paths for place in (path, *path.parents)}


def rewrite(source: str, modules: set[str]) -> str:
    """`source` with all names of inner packages as they are once installed; UnclearName, by line, where one is not."""
    tree = ast.parse(source)
    lines = [line.encode() for line in source.split("\n")]
    nodes = list(ast.walk(tree))
    edits = [*_imports(nodes), *_strings(nodes, lines, modules)]
    for row, column, old, new in sorted(set(edits), reverse=True):
        line = lines[row]
        if not line.startswith(old.encode(), column):
            raise UnclearName(f"{row + 1}: {old!r} is not where it was expected.")
        lines[row] = line[:column] + new.encode() + line[column + len(old.encode()) :]
    return b"\n".join(lines).decode()


def _imports(nodes: list[ast.AST]) -> Iterator[Edit]:
    for node in nodes:
        row, column = getattr(node, "lineno", 1) - 1, getattr(node, "col_offset", 0)
        if isinstance(node, ast.ImportFrom) and not node.level and _is_inner(node.module or ""):
            yield row, column, f"from {node.module}", f"from {PACKAGE}.{node.module}"
        elif isinstance(node, ast.Import) and any(_is_inner(alias.name) for alias in node.names):
            (name, alias) = (node.names[0].name, node.names[0].asname)
            if len(node.names) > 1 or ("." in name and alias is None):
                raise UnclearName(f"{row + 1}: import {name} cannot be changed. Write: from … import ….")
            package, _, module = f"{PACKAGE}.{name}".rpartition(".")
            yield row, column, f"import {name}", f"from {package} import {module}"


def _is_inner(name: str) -> bool:
    return name.partition(".")[0] in INNER


def _strings(nodes: list[ast.AST], lines: list[bytes], modules: set[str]) -> Iterator[Edit]:
    """Dotted names of modules in strings; docstrings and comments speak of the repository and stay as they are."""
    passed_over = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    passed_over |= {id(part) for node in nodes if isinstance(node, ast.JoinedStr) for part in ast.walk(node)}
    joined = [node for node in nodes if isinstance(node, ast.JoinedStr)]
    for node in [*joined, *(each for each in nodes if isinstance(each, ast.Constant) and id(each) not in passed_over)]:
        parts: list[ast.AST] = [node] if isinstance(node, ast.Constant) else list(ast.walk(node))
        texts = [part.value for part in parts if isinstance(part, ast.Constant) and isinstance(part.value, str)]
        named = [found[0] for text in texts for found in _DOTTED.finditer(text)]
        for name in named:
            if not any(name == module or name.startswith(f"{module}.") for module in modules if "." in module):
                raise UnclearName(f"{node.lineno}: {name!r} looks like a module and is none.")
        if named:
            yield from _in_literal(node, lines, set(named))
    for each in nodes:
        if isinstance(each, (ast.List, ast.Tuple, ast.Call)):
            _refuse_bare(each.args if isinstance(each, ast.Call) else each.elts)


def _in_literal(node: ast.expr, lines: list[bytes], named: set[str]) -> Iterator[Edit]:
    """Positions of the names in the source of a string."""
    assert node.end_lineno is not None
    assert node.end_col_offset is not None
    found = 0
    for row in range(node.lineno - 1, node.end_lineno):
        start = node.col_offset if row == node.lineno - 1 else 0
        stop = node.end_col_offset if row == node.end_lineno - 1 else len(lines[row])
        before, text = lines[row][:start].decode(), lines[row][start:stop].decode()
        for match in _DOTTED.finditer(text):
            if match[0] in named:
                found += 1
                yield row, len((before + text[: match.start()]).encode()), match[0], f"{PACKAGE}.{match[0]}"
    if not found:
        raise UnclearName(f"{node.lineno}: {', '.join(sorted(named))} cannot be changed. Write it in one piece.")


def _refuse_bare(words: list[ast.expr]) -> None:
    """`python -m app` names a package without a dot, which could be any word."""
    for first, second in itertools.pairwise(words):
        values = [each.value if isinstance(each, ast.Constant) else None for each in (first, second)]
        if values[0] == "-m" and isinstance(values[1], str) and values[1] in INNER:
            raise UnclearName(f'{second.lineno}: "-m", "{values[1]}" cannot be changed. Write {values[1]}.__main__.')

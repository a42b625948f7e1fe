"""The layers: every folder of sources is a package, and imports point down from layer to layer.

Ours instead of contracts of import-linter: it refuses layers that contain other layers, as `engine/capture` above
`engine/capture/registration`, and one order over all packages is what rules out cycles among them.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from pathlib import Path, PurePosixPath

import pytest

from tests.import_graph import imports_in

PROJECT = Path(__file__).resolve().parents[1]

#: All packages, lowest first: each imports itself and packages before it, also for type checkers and within functions.
PACKAGES = (
    "engine/core",
    "engine/storage",
    "engine/images",
    "engine/geometry",
    "engine/light",
    "engine/texel",
    "engine/capture/photograph",
    "engine/capture/chart",
    "engine/capture/lights",
    "engine/capture/registration",
    "engine/capture/calibration",
    "engine/capture",
    "engine/brdf/models",
    "engine/brdf",
    "engine/brdf/readers",
    "engine/factor/solvers",
    "engine/factor",
    "engine/shading/directional",
    "engine/shading",
    "engine/surface",
    "engine/scene",
    "engine/transport/baking",
    "engine/transport/sh",
    "engine/transport/wavelet",
    "engine/transport/gaussian/fitting",
    "engine/transport/gaussian",
    "engine/transport",
    "engine/render",
    "engine/simulate",
    "engine/gl",
    "engine/gl/reflectance",
    "engine/accuracy",
    "engine/planning/costs",
    "engine/planning/effects",
    "engine/planning/methods",
    "engine/planning",
    "engine/bundle",
    "engine/exchange/readers",
    "engine/exchange",
    "engine/figures",
    "engine/figures/papers",
    "engine/proof",
    "engine/tradeoff",
    "engine/selftest",
    "engine/selftest/generated",
    "app/process",
    "app/arguments",
    "app/jobs",
    "app/session",
    "app/widgets",
    "app/viewport",
    "app/document",
    "app/project",
    "app/commands",
    "app/batch",
    "app/capture",
    "app/watch",
    "app/material",
    "app/brdf",
    "app/factor",
    "app/varying",
    "app/view",
    "app/export",
    "app/docks",
    "app/help",
    "app/start",
    "app/window",
    "app/cli",
    "app/cli/shading",
    "app/cli/transport",
    "app",
    "benchmarks",
    "benchmarks/transport",
    "benchmarks/app",
)


@cache
def modules() -> dict[str, Path]:
    """Dotted name → file of every module of the program."""
    found = {}
    for path in sorted(path for top in ("engine", "app", "benchmarks") for path in (PROJECT / top).rglob("*.py")):
        found[".".join(path.relative_to(PROJECT).with_suffix("").parts).removesuffix(".__init__")] = path
    return found


def package_of(module: str) -> str:
    return modules()[module].parent.relative_to(PROJECT).as_posix()


def import_capture(module: str) -> Iterator[tuple[int, str]]:
    """Line and name of every module of ours that a module imports, wherever it does.

    Lists of modules by name (verbs, methods, measurements, figures) are the seams where a low package is given what it
    calls; they are no imports.
    """
    for line, name in imports_in(modules()[module].read_text(encoding="utf-8")):
        imported = name if name in modules() else name.rpartition(".")[0]
        if imported in modules():
            yield line, imported


def test_every_folder_is_a_package_and_every_package_a_folder() -> None:
    packages = {package_of(name) for name, path in modules().items() if path.name != "__init__.py"}
    assert sorted(packages) == sorted(PACKAGES)


@pytest.mark.parametrize("package", PACKAGES)
def test_imports_point_down(package: str) -> None:
    """With one order for all packages there is no cycle among them."""
    below = set(PACKAGES[: PACKAGES.index(package) + 1]) | {"engine", "app"}
    upward = [
        f"{modules()[name].relative_to(PROJECT)}:{line} imports {other}"
        for name in modules()
        if package_of(name) == package
        for line, other in import_capture(name)
        if package_of(other) not in below and modules()[other].name != "__init__.py"
    ]
    assert upward == []


@pytest.mark.parametrize("package", [package for package in PACKAGES if package not in {"engine", "app"}])
def test_a_package_says_in_one_sentence_what_it_is(package: str) -> None:
    """The sentence is that of ARCHITECTURE.md; nothing else stands in `__init__.py`."""
    (sentence,) = ast.parse((PROJECT / package / "__init__.py").read_text(encoding="utf-8")).body
    assert isinstance(sentence, ast.Expr)
    assert isinstance(sentence.value, ast.Constant)
    said = str(sentence.value.value)
    assert said.endswith(".")
    assert f"| `{package}` | {said[:-1]} |" in (PROJECT / "ARCHITECTURE.md").read_text(encoding="utf-8")


def test_packages_stand_one_upon_the_other() -> None:
    """The engine is complete before the window begins."""
    tops = [PurePosixPath(package).parts[0] for package in PACKAGES]
    assert [pair for pair in pairwise(tops) if pair == ("app", "engine")] == []


def test_tests_lie_where_their_sources_lie() -> None:
    tests = {path.parent.relative_to(PROJECT / "tests").as_posix() for path in (PROJECT / "tests").rglob("*.py")}
    assert sorted(tests - set(PACKAGES) - {".", "engine", "app"}) == []

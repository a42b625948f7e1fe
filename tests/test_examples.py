"""Scripts of the gallery and notebooks of the manual: they name what `lightarc` has, and run."""

from __future__ import annotations

import ast
import re
import runpy
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import matplotlib
import pytest

import lightarc

MANUAL = Path(__file__).resolve().parents[1] / "docs" / "manual"
SCRIPTS = sorted((MANUAL / "scripts").glob("plot_*.py"))
NOTEBOOKS = sorted(path for path in (MANUAL / "notebooks").glob("*.md") if path.stem != "index")


def code_of(path: Path) -> str:
    """The source of a script, or that of the cells of a notebook."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".py":
        return text
    return "\n".join(re.findall(r"^```\{code-cell\} ipython3\n(.*?)^```$", text, re.MULTILINE | re.DOTALL))


@pytest.fixture
def plots(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[ModuleType]:
    """The module that scripts draw with, without a window; folders of theirs are removed with the test."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    matplotlib.use("agg")
    import matplotlib.pyplot as plt

    yield plt
    plt.close("all")


@pytest.mark.parametrize("path", [*SCRIPTS, *NOTEBOOKS], ids=lambda path: path.stem)
def test_examples_name_what_the_package_has(path: Path) -> None:
    tree = ast.parse(code_of(path))
    used = [node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute) and _is_package(node.value)]
    assert used
    assert [name for name in used if name not in lightarc.__all__] == []


def _is_package(node: ast.expr) -> bool:
    return isinstance(node, ast.Name) and node.id == "lightarc"


def test_there_are_twelve_scripts_and_three_notebooks() -> None:
    assert (len(SCRIPTS), len(NOTEBOOKS)) == (12, 3)


def test_the_script_of_lobes_draws_them(plots: ModuleType) -> None:
    runpy.run_path(str(MANUAL / "scripts" / "plot_04_lobes.py"))
    (axes,) = plots.gcf().axes
    assert len(axes.lines) == 5


@pytest.mark.long
@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_scripts_draw_a_figure(path: Path, plots: ModuleType) -> None:
    runpy.run_path(str(path))
    assert plots.get_fignums()


@pytest.mark.long
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_cells_of_notebooks_run_one_after_another(path: Path, plots: ModuleType) -> None:
    exec(compile(code_of(path), path.name, "exec"), {"__name__": "__main__"})

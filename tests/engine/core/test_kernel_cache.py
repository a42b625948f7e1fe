"""The key of a cached kernel: it follows what is compiled, and nothing else."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from types import FunctionType

import pytest

from engine.core.kernel_cache import fingerprint

PROJECT = Path(__file__).resolve().parents[3]

MODULES = {
    "callee.py": """
from engine.core.kernels import scalar

FACTOR = 3.0

@scalar
def scaled(value):
    return FACTOR * value
""",
    "caller.py": """
import numpy as np
import callee
from callee import scaled
from engine.core.kernels import scalar

OFFSETS = np.array([1.0, 2.0])

@scalar
def moved(value):
    return scaled(value) + np.max(OFFSETS) + callee.FACTOR + (100.0 if value in {7.5, 0.25, 1e9} else 0.0)

@scalar
def counted(value):
    return 0.0 if value < 1.0 else 1.0 + counted(value - 1.0)
""",
}

USE = """
import sys
for folder in sys.argv[1:]:
    sys.path.insert(0, folder)
    from caller import counted, moved
    print(moved(2.0), counted(2.5), *(sum(each.stats.cache_hits.values()) for each in (moved, counted)))
    del sys.modules["caller"], sys.modules["callee"]
"""


@pytest.fixture
def modules(tmp_path: Path) -> Path:
    for name, text in MODULES.items():
        (tmp_path / name).write_text(text)
    return tmp_path


def use(cache: Path, *folders: Path) -> list[str]:
    """What the program USE prints with the modules of each folder: two results and whether each kernel was cached."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(PROJECT)}
    words = [sys.executable, "-c", USE, *map(str, folders)]
    done = subprocess.run(words, capture_output=True, text=True, env=environment, check=True)
    return done.stdout.splitlines()


def test_kernels_are_shared_by_checkouts_and_compiled_anew_where_a_callee_changed(
    modules: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    cache, other, changed = (tmp_path_factory.mktemp(name) for name in ("cache", "other", "changed"))
    assert use(cache, modules) == ["11.0 2.0 0 0"]
    for name, text in MODULES.items():
        for folder in (other, changed):
            (folder / name).write_text(f"# a line more\n{text}")
    (changed / "callee.py").write_text(MODULES["callee.py"].replace("3.0", "4.0"))
    found = use(cache, other, changed)
    assert found[0] == "11.0 2.0 1 1", "another folder, other lines, the same kernels"
    assert found[1] == "14.0 2.0 0 1", "the caller's own file has not changed"


def test_constants_and_options_belong_to_the_key() -> None:
    def make(expression: str, **values: object) -> FunctionType:
        names: dict[str, object] = dict(values)
        exec(f"def f(x):\n    return {expression}", names)
        return names["f"]  # type: ignore[return-value]

    same = make("x + A", A=1.0)
    assert fingerprint(same) == fingerprint(make("x + A", A=1.0, B=2.0))
    others = [make("x - A", A=1.0), make("x + A", A=2.0), make("x + 1.0"), make("x + A", A=(1.0,))]
    assert len({fingerprint(each) for each in [same, *others]}) == 5
    before = fingerprint(same)
    same.compile_options = [("parallel", True)]  # type: ignore[attr-defined]
    assert fingerprint(same) != before

"""`import lightarc`: the declared names, their examples, and the wheel that installs them."""

from __future__ import annotations

import doctest
import inspect
from pathlib import Path

import pytest

import lightarc


def test_examples_of_all_functions_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the order of `__all__`, in one folder and with the names of those before."""
    monkeypatch.chdir(tmp_path)
    finder, runner = doctest.DocTestFinder(recurse=False), doctest.DocTestRunner()
    names: dict[str, object] = {}
    said: list[str] = []
    for name in lightarc.__all__:
        function = getattr(lightarc, name)
        if not inspect.isfunction(function):
            continue
        (example,) = finder.find(function, name, globs={})
        assert example.examples, f"{name} has no example"
        example.globs = names
        runner.run(example, out=said.append, clear_globs=False)
    assert runner.failures == 0, "".join(said)

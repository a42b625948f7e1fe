"""`import lightarc`: the declared names, their examples, and the wheel that installs them."""

from __future__ import annotations

import doctest
import inspect
from pathlib import Path
from typing import Any

import numpy as np
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


@pytest.mark.parametrize("size", [(0, 10), (10, -1), (10**6, 10**6), (1.5, 2), (1,), None])
def test_sizes_that_no_image_has_are_refused(size: Any) -> None:
    with pytest.raises(lightarc.UsageError, match="image size must be"):
        lightarc.render("sphere", size=size)


def test_nothing_but_its_own_errors_leaves_the_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wrong: Any = ("a", 2)
    for act in (
        lambda: lightarc.render("sphere", light_deg=wrong),
        lambda: lightarc.compare(np.zeros((2, 2, 4)), np.zeros((3, 2, 4))),
        lambda: lightarc.evaluate_brdf("ggx:alpha=.1,alpha=.2", [0, 0, 1], [0, 0, 1]),
        lambda: lightarc.evaluate_brdf("lambert", [[0, 0, 1]] * 2, [[0, 0, 1]] * 3),
        lambda: lightarc.open_stack("a\0b"),
        lambda: lightarc.save_image(tmp_path / "no" / "a.png", np.zeros((0, 0, 4), np.float32)),
        lambda: lightarc.open_bundle(tmp_path),
    ):
        with pytest.raises(lightarc.LightarcError):
            act()
    monkeypatch.setattr("engine.render.direct.radiance", lambda *_, **__: (_ for _ in ()).throw(MemoryError))
    with pytest.raises(lightarc.OutOfMemory):
        lightarc.render("sphere", size=(8, 8))


def test_negative_images_warn_of_nothing(recwarn: pytest.WarningsRecorder) -> None:
    lightarc.compare(np.full((8, 8, 3), -1.0, np.float32), np.full((8, 8, 3), -2.0, np.float32))
    assert not [each for each in recwarn if issubclass(each.category, RuntimeWarning)]

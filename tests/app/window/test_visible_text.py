"""Every text of the window: in words of the field, and accessible names and roles, read from one window."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib.util import module_from_spec, spec_from_file_location
from typing import Any

import pytest
from PySide6.QtWidgets import QApplication

from app.window.main_window import MainWindow
from app.window.top_bar import WORKSPACES
from tests.app.conftest import open_window
from tests.app.visible_text import read
from tests.app.window.test_main_window import fill
from tests.test_words import OLD_IN_WINDOW, PROJECT

#: Workspaces in which a light is one of the scene; in the others a lamp stands before the sample.
RENDERED = ("view", "varying", "viewport")


def load_translate() -> Any:
    spec = spec_from_file_location("translate", PROJECT / "packaging" / "translate.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def whole(qapp: QApplication, tmp_path_factory: pytest.TempPathFactory) -> Iterator[MainWindow]:
    """One window for all tests of this file, with all workspaces and a material with findings of every kind."""
    folder = tmp_path_factory.mktemp("home")
    with pytest.MonkeyPatch.context() as monkeypatch:
        for name in ("CACHE", "CONFIG", "DATA"):
            monkeypatch.setenv(f"XDG_{name}_HOME", str(folder / name.lower()))
        with open_window(monkeypatch, WORKSPACES) as made:
            fill(made)
            yield made


def test_texts_of_the_window_are_in_words_of_the_field(whole: MainWindow) -> None:
    shown = {text for _, text in read(whole)}
    assert len(shown) > 900, "the walk has lost most of the window"
    assert [f"{found[0]}: {text}" for text in sorted(shown) for found in OLD_IN_WINDOW.finditer(text)] == []


def test_texts_that_the_window_may_show_are_in_words_of_the_field() -> None:
    translate = load_translate()
    found = [
        f"{path.relative_to(PROJECT)}:{line}: {match[0]}"
        for context in translate.CONTEXTS
        for path in sorted((PROJECT / "app" / context).rglob("*.py"))
        for line, text in translate.find_phrases(path)
        for match in (OLD_IN_WINDOW.search(text), context in RENDERED and re.search(r"\blamps? |\bLamps?\b", text))
        if match
    ]
    assert found == []

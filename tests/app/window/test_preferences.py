"""Preferences hold at once, are on disk, and the cache is emptied but for what windows use."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import pytest

from app.session import cache, settings
from app.session.settings import Settings, cache_folder, close_session, open_session
from app.widgets import theme
from app.window.application import draw_by
from app.window.main_window import MainWindow
from app.window.preferences import Preferences
from engine.core.figure_text import local, write_with
from tests.present import present


def choose(preferences: Preferences, name: str, value: object) -> None:
    box = preferences.boxes[name]
    box.setCurrentIndex(box.findData(value))
    box.activated.emit(box.currentIndex())


def test_choices_hold_at_once(window: MainWindow, qtbot: Any, tmp_path: Path) -> None:
    window.settings.folder = tmp_path / "config"
    window.menus.preferences_wanted.emit()
    (preferences,) = window.findChildren(Preferences)
    try:
        choose(preferences, "theme", "light")
        assert theme.current().name == "light"
        assert window.menus.themes.checkedAction().data() == "light"
        choose(preferences, "numbers", ",")
        assert local("1,234.5") == "1\u202f234,5"
        choose(preferences, "tone_map", "aces")
        qtbot.waitUntil(lambda: preferences.size_words.text() != "…", timeout=20_000)
        window.new()  # drops what the window still works at
        assert window.bench.document.project.look.tone_map == "aces"
        window.export.elsewhere.width_field.edited.emit(50.8, True)
        choose(preferences, "unit", "in")
        assert window.export.elsewhere.width_field.text() == "2 in"
        assert window.export.elsewhere.choices.width_mm == 50.8
        window.settings.wait()
        kept = settings.load(tmp_path / "config")
        assert (kept.theme, kept.numbers, kept.tone_map, kept.unit) == ("light", ",", "aces", "in")
    finally:
        write_with(".")
        window.set_theme("dark")
    preferences.close()


@pytest.mark.parametrize(
    "content",
    [
        '{"unit": "ell"}',
        '{"graphics": "both"}',
        '{"threads": -1}',
        '{"numbers": "!"}',
        '{"tone_map": "x"}',
        '{"memory_gb": 1e999}',
        '{"threads": true}',
    ],
)
def test_preferences_that_cannot_be_are_put_aside(tmp_path: Path, content: str) -> None:
    (tmp_path / "settings.json").write_text(content)
    assert settings.load(tmp_path) == Settings()
    assert (tmp_path / "settings.corrupt.json").is_file()


def test_the_cache_is_emptied_but_for_what_is_in_use() -> None:
    session = open_session()
    folder = present(cache_folder())
    (folder / "cost-model.json").write_text("{}")
    assert session.parent == folder
    cache.empty()
    assert [*folder.iterdir()] == [session]
    close_session(session)


@pytest.mark.skipif(sys.platform != "linux", reason="other systems choose by programs of their own")
def test_what_draws_is_told_to_the_drivers_unless_the_environment_does(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("LIBGL_ALWAYS_SOFTWARE", raising=False)
    monkeypatch.setenv("DRI_PRIME", "0")
    draw_by("system")
    assert "LIBGL_ALWAYS_SOFTWARE" not in os.environ
    draw_by("processor")
    draw_by("second")
    assert (os.environ["LIBGL_ALWAYS_SOFTWARE"], os.environ["DRI_PRIME"]) == ("1", "0")

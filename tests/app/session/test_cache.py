"""Working copies go in the order of their use, but none that a window uses or that a project cannot do without."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from app.session import cache
from app.session.settings import Settings, cache_folder, config_folder, save
from engine.storage.atomic import perform
from engine.storage.writer import start_of, writer


@pytest.fixture(autouse=True)
def _own_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("CACHE", "CONFIG", "DATA"):
        monkeypatch.setenv(f"XDG_{name}_HOME", str(tmp_path / name.lower()))


def entry(name: str, used_at: float, size: int = 1000) -> Path:
    place = cache.entry(name)
    assert place is not None
    place.mkdir()
    (place / "content.npy").write_bytes(bytes(size))
    os.utime(place, (used_at, used_at))
    return place


def test_those_used_longest_ago_go_first() -> None:
    places = [entry(f"array-{at}", 1000.0 + at) for at in range(4)]
    cache.mark_used(places[0])
    assert cache.keep_within(2500) == 2000
    assert [place.exists() for place in places] == [True, False, False, True]
    assert cache.size_bytes() == 2000


def test_the_limit_of_the_user_holds() -> None:
    save(Settings(cache_gb=2.0), config_folder())
    assert cache.limit_bytes() == 2_000_000_000
    save(Settings(), config_folder())
    assert 0 < cache.limit_bytes() <= cache.DEFAULT_BYTES


def test_what_another_window_uses_stays_until_it_ends() -> None:
    place = entry("pixels-a", 1.0)
    other = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
    try:
        (place / f"used-{writer().rsplit('-', 2)[0]}-{other.pid}-{start_of(other.pid)}").touch()
        assert cache.keep_within(0) == 0
        assert not cache.remove(place, even_own=True)
        assert place.is_dir()
    finally:
        other.kill()
        other.wait()
    assert cache.keep_within(0) > 0
    assert not place.exists()


def test_what_this_window_uses_stays_unless_it_says_so() -> None:
    place = entry("pixels-a", 1.0)
    assert cache.use(place)
    assert not cache.remove(place)
    assert cache.remove(place, even_own=True)
    assert not cache.use(place)


def test_a_mark_that_comes_while_an_entry_goes_keeps_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """A window marks the entry after another looked for marks, and before it renames."""
    place = entry("pixels-a", 1.0)

    def late(operation: str, path: Path, action: Callable[[], object]) -> object:
        if operation == "rename" and path == place:
            assert cache.use(place)
        return perform(operation, path, action)

    monkeypatch.setattr("app.session.cache.perform", late)
    assert not cache.remove(place)
    assert (place / "content.npy").is_file()


def test_pixels_stay_where_a_project_needs_them_and_its_photographs_are_gone(tmp_path: Path) -> None:
    place, project, photograph = entry("pixels-a", 1.0), tmp_path / "a.lap", tmp_path / "a.png"
    project.write_bytes(b"")
    photograph.write_bytes(b"1")
    cache.note_origin(place, project, [photograph])
    assert not cache.is_needed(place)
    photograph.write_bytes(b"12")
    assert cache.is_needed(place)
    cache.empty()
    assert place.is_dir()
    photograph.unlink()
    assert cache.keep_within(0) == 0
    project.unlink()  # which nobody can miss any more
    cache.empty()
    assert not place.exists()


def test_an_origin_that_cannot_be_understood_keeps_its_pixels() -> None:
    place = entry("pixels-a", 1.0)
    (place / "origin-0.json").write_text("{")
    assert cache.keep_within(0) == 0


def test_without_a_folder_nothing_is_cached(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert cache.entry("array-a") is None
    assert cache.size_bytes() == 0
    assert cache_folder() is not None

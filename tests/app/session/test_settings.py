from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from app.session import settings
from app.session import settings as session_settings
from app.session.settings import Settings
from engine.storage.writer import writer
from tests.processes import is_gone


def test_what_is_saved_comes_back(tmp_path: Path) -> None:
    kept = Settings(theme="light", geometry="0a0b", recent_projects=("/a.lap",), recent_files=("/b",))
    settings.save(kept, tmp_path / "config")
    assert settings.load(tmp_path / "config") == kept


def test_recent_projects_may_have_names_in_any_encoding(tmp_path: Path) -> None:
    name = os.fsdecode(b"m\xff.lap")
    settings.save(Settings(recent_projects=(name,)), tmp_path)
    assert settings.load(tmp_path).recent_projects == (name,)


@pytest.mark.parametrize(
    "content",
    [b"", b"{", b"[]", b'{"theme": 3}', b'{"geometry": "zz"}', b"\xff\xfe", b'{"recent": [1]}', b"[" * 100_000],
)
def test_fault_14_corrupt_settings_are_put_aside_and_defaults_used(
    tmp_path: Path, content: bytes, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "settings.json").write_bytes(content)
    assert settings.load(tmp_path) == Settings()
    assert (tmp_path / "settings.corrupt.json").read_bytes() == content
    assert not (tmp_path / "settings.json").exists()
    assert "settings.json" in caplog.text


def test_fault_14_a_folder_that_cannot_be_written_is_said_and_nothing_else(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "file").write_text("in the way")
    settings.save(Settings(), tmp_path / "file" / "config")
    assert "not kept" in caplog.text
    settings.save(Settings(), None)


def test_fault_14_without_a_home_the_defaults_are_used() -> None:
    program = (
        "from app.session import settings as session; from app.session import settings\n"
        "folder = settings.config_folder()\n"
        "print(settings.load(folder) == settings.Settings())\n"
        "settings.save(settings.Settings(), folder)\n"
        "place = session.open_session(); print(place.is_dir()); session.close_session(place); print(place.exists())\n"
    )
    bare = {key: value for key, value in os.environ.items() if key != "HOME" and not key.startswith("XDG_")}
    environment = {**bare, "HOME": "/nonexistent/home"}
    done = subprocess.run(
        [sys.executable, "-c", program], env=environment, capture_output=True, text=True, timeout=60, check=False
    )
    assert done.stdout.split() == ["True", "True", "False"], done.stderr


def test_latest_keeps_each_once_newest_first() -> None:
    assert settings.with_latest(("a", "b"), "b", 8) == ("b", "a")
    assert len(settings.with_latest(tuple("abcdefghij"), "z", 8)) == 8


def test_the_single_list_of_older_versions_is_divided_into_projects_and_files(tmp_path: Path) -> None:
    (tmp_path / "settings.json").write_text('{"theme": "light", "recent": ["/a.obj", "/b.lap", "/c.hdr", "/D.LAP"]}')
    found = settings.load(tmp_path)
    assert found.recent_projects == ("/b.lap", "/D.LAP")
    assert found.recent_files == ("/a.obj", "/c.hdr")
    assert found.theme == "light"


def test_files_do_not_push_projects_out_and_500_projects_load_again(tmp_path: Path) -> None:
    remembered = settings.Remembered(tmp_path)
    remembered.opened(tmp_path / "first.lap", tmp_path)
    for at in range(3 * settings.RECENT):
        remembered.opened(tmp_path / f"{at}.obj", tmp_path)
    assert remembered.now.recent_projects == (str(tmp_path / "first.lap"),)
    assert len(remembered.now.recent_files) == settings.RECENT
    longest = "/" + "ü" * (settings.MAX_PATH - 10)
    remembered.keep(recent_projects=tuple(f"{longest}{at}.lap" for at in range(settings.MAX_PROJECTS)))
    remembered.wait()
    assert settings.load(tmp_path) == remembered.now
    remembered.forget(Path(f"{longest}1.lap"), Path("/renamed.lap"))
    remembered.wait()
    assert settings.load(tmp_path).recent_projects[1] == "/renamed.lap"


def test_the_disk_does_not_keep_the_window_waiting_and_what_is_kept_meanwhile_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    disk, save = threading.Event(), settings.save

    def save_slowly(kept: Settings, folder: Path | None) -> None:
        disk.wait()
        save(kept, folder)

    monkeypatch.setattr(settings, "save", save_slowly)
    remembered = settings.Remembered(tmp_path)
    remembered.opened(tmp_path / "one.obj", tmp_path)
    remembered.in_front("view")
    remembered.opened(tmp_path / "other.obj", tmp_path)
    assert settings.load(tmp_path) == Settings(), "nothing is on disk yet"
    disk.set()
    remembered.wait()
    found = settings.load(tmp_path)
    assert found.workspace == "view"
    assert [Path(text).stem for text in found.recent_files] == ["other", "one"]


def test_folders_of_dead_runs_are_removed_and_those_of_the_living_stay(tmp_path: Path) -> None:
    dead = tmp_path / f"{session_settings.PREFIX}{is_gone()}-abc"
    alive = tmp_path / f"{session_settings.PREFIX}{writer()}-abc"
    for folder in (dead, alive):
        folder.mkdir()
        (folder / "radiance.npy").write_bytes(b"x")
    session_settings.remove_abandoned(tmp_path)
    assert not dead.exists()
    assert alive.exists()

"""Projects in a list, renamed, and in the trash: none is opened that may be damaged, and nothing is lost."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from app.document.document import Project
from app.project import upkeep
from app.project.listing import list_projects, size_of_project
from app.project.places import new_path, projects_folder
from app.project.project_file import History, Writer, data_folder, read
from app.project.thumbnail import keep_thumbnail
from engine.core.errors import InputError, OutputError
from engine.core.steps import drain


def save(path: Path, name: str) -> Path:
    data_folder(path).mkdir(parents=True)
    writer = Writer(path)
    writer.write(History(Project(name=name)))
    writer.close()
    return path


def test_all_projects_are_listed_and_none_is_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    untitled = save(new_path(projects_folder()), "Felt")
    drain(keep_thumbnail(untitled, Project(name="Felt\n\x1b[31m")))
    named, damaged = save(tmp_path / "Linen.lap", "Linen"), tmp_path / "Damaged.lap"
    damaged.write_bytes(b"SQLite format 3\0" + os.urandom(4000))
    data_folder(damaged).mkdir()
    (data_folder(damaged) / "title.txt").write_bytes(b"x" * 10_000)
    for age, path in enumerate((untitled, damaged, named)):
        os.utime(path, (1e9 - age, 1e9 - age))
    monkeypatch.setattr("sqlite3.connect", lambda *_a, **_k: pytest.fail("a project is opened"))
    found = list_projects(projects_folder(), [named, damaged, named, tmp_path / "gone.lap", tmp_path])
    assert [(each.path, each.name, each.is_untitled) for each in found] == [
        (untitled, "Felt [31m", True),
        (damaged, "Damaged", False),
        (named, "Linen", False),
    ]
    (data_folder(named) / "loop").symlink_to(tmp_path, target_is_directory=True)
    (data_folder(named) / "deep").mkdir()
    (data_folder(named) / "deep" / "a").write_bytes(bytes(5000))
    assert size_of_project(named) == named.stat().st_size + 5000


def test_a_renamed_project_keeps_its_data_wherever_it_is_interrupted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = save(tmp_path / "Old.lap", "Felt")
    (data_folder(path) / "kept").write_text("data")
    new = drain(upkeep.rename(path, "New name"))
    assert new == tmp_path / "New name.lap"
    assert sorted(each.name for each in tmp_path.iterdir()) == ["New name.lap", "New name.lap-data"]
    assert (data_folder(new) / "kept").read_text() == "data"
    assert read(new).current.name == "Felt"
    for name in ("copy_database", "perform"):  # the disk fails
        with monkeypatch.context() as patch:
            patch.setattr(upkeep, name, failing)
            with pytest.raises(OutputError):
                drain(upkeep.rename(new, "Newer"))
        assert sorted(each.name for each in tmp_path.iterdir()) == ["New name.lap", "New name.lap-data"]
    with monkeypatch.context() as patch:  # killed before the old file goes
        patch.setattr(upkeep, "discard", print)
        newer = drain(upkeep.rename(new, "Newer"))
    for either in (new, newer):
        assert read(either).current.name == "Felt"
    assert (data_folder(newer) / "kept").read_text() == "data"


def failing(*_given: object) -> None:
    raise OutputError("disk", "is full", "Free some space")


def test_no_project_is_renamed_onto_another_or_while_it_is_open(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    one, other = save(tmp_path / "One.lap", "1"), save(tmp_path / "Other.lap", "2")
    with pytest.raises(InputError, match="exists already"):
        drain(upkeep.rename(one, "Other"))
    for name in ("../away", "", "..", "a/b"):
        with pytest.raises(InputError):
            drain(upkeep.rename(one, name))
    monkeypatch.setattr(upkeep, "is_open_elsewhere", lambda _path: True)
    for work in (lambda: drain(upkeep.rename(one, "x")), lambda: drain(upkeep.move_to_trash(one))):
        with pytest.raises(OutputError, match="open in another window"):
            work()
    assert read(one).current.name == "1"
    assert read(other).current.name == "2"


def test_a_project_goes_to_the_trash_with_its_data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    path = save(tmp_path / "Felt.lap", "Felt")
    drain(upkeep.move_to_trash(path))
    assert not path.exists()
    assert not data_folder(path).exists()
    assert {each.name for each in (tmp_path / "data/Trash/files").iterdir()} == {"Felt.lap", "Felt.lap-data"}


def test_where_there_is_no_trash_nothing_is_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = save(tmp_path / "Felt.lap", "Felt")
    monkeypatch.setattr(upkeep, "trash", lambda _path: False)
    with pytest.raises(OutputError, match="cannot be moved to the trash"):
        drain(upkeep.move_to_trash(path))
    assert read(path).current.name == "Felt"

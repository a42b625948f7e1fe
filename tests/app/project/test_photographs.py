"""Photographs of a project that were moved, changed, renamed or collected, and projects of an older schema."""

from __future__ import annotations

import os
import shutil
import sqlite3
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.document.document import ImportChoices, Look, Project, Step
from app.project import photographs as module
from app.project.copying import OutsideFiles, collect, copy
from app.project.database import SCHEMA, migrate
from app.project.photographs import check, find_moved, keep, marks_of, photographs, relocate, take_marks
from app.project.places import claim, release
from app.project.project_file import History, Writer, data_folder, read
from app.project.report import describe, problems_of
from engine.capture.lights.sources import Sources, find, find_packed, unpack_again
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.images.encode import encode_png
from tests.app.command import Command

OLDER = Path(__file__).with_name("schema_1.sql")


def sheet(folder: Path, shade: int = 0) -> Path:
    """Three photographs of a flat sheet."""
    folder.mkdir(parents=True, exist_ok=True)
    for angle in (10, 50, 90):
        image = np.full((4, 4, 3), 100 * angle + shade, np.uint16)
        (folder / f"felt_{angle}deg.png").write_bytes(encode_png(image))
    return folder


def save(path: Path, sources: Sources, *, marked: bool = True, **parts: Any) -> Path:
    """A project whose capture is at the end of two steps, and whose photographs have marks."""
    first = Project(sources=sources, look=Look(gain=1.5), name="Felt", **parts)
    second = Project(sources=sources, name="Felt", **parts)
    writer = Writer(path)
    writer.write(History(second, (Step("Open", "", Project(), first), Step("Gain", "", first, second)), 2))
    writer.close()
    if marked:
        keep(path, drain(take_marks(photographs(second))))
    return path


def name_files(path: Path) -> list[Path]:
    sources = read(path).current.sources
    assert sources is not None
    return list(sources.photographs)


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A project beside its photographs."""
    return save(tmp_path / "a" / "Felt.lap", find([sheet(tmp_path / "a" / "Felt")]))


def test_marks_are_of_the_content_and_of_frames_too(tmp_path: Path) -> None:
    choices = ImportChoices(dark=sheet(tmp_path / "dark", 7) / "felt_10deg.png")
    path = save(tmp_path / "Felt.lap", find([sheet(tmp_path / "Felt")]), import_choices=choices)
    assert len(marks_of(path)) == 4
    assert choices.dark in marks_of(path)
    assert drain(check(path, marks_of(path))) == module.Checked()


def test_a_project_moved_with_its_photographs_takes_those_beside_it(tmp_path: Path, project: Path) -> None:
    """Also where the old ones are still there: a copy of a folder works on its own photographs."""
    shutil.copytree(tmp_path / "a", tmp_path / "b")
    assert {path.parent for path in name_files(tmp_path / "b" / "Felt.lap")} == {tmp_path / "b" / "Felt"}
    shutil.rmtree(tmp_path / "a")
    assert describe(tmp_path / "b" / "Felt.lap")["missing"] == []
    assert len(marks_of(tmp_path / "b" / "Felt.lap").keys() & set(name_files(tmp_path / "b" / "Felt.lap"))) == 3


def test_a_project_that_moved_alone_finds_its_photographs_in_full(tmp_path: Path, project: Path) -> None:
    (tmp_path / "away").mkdir()
    project.rename(tmp_path / "away" / "Felt.lap")
    assert {path.parent for path in name_files(tmp_path / "away" / "Felt.lap")} == {tmp_path / "a" / "Felt"}


def test_photographs_that_moved_are_found_by_content_for_every_state_of_the_history(
    tmp_path: Path, project: Path
) -> None:
    """Names and folders are others, and of two that are equal the one with the old name is taken."""
    gone = name_files(project)
    there = tmp_path / "archive" / "deep"
    there.mkdir(parents=True)
    for at, path in enumerate(gone):
        path.rename(there / f"{at}.png")
    shutil.copy(there / "1.png", there / gone[1].name)
    sheet(tmp_path / "archive" / "other", shade=3)
    assert drain(check(project, gone)).missing == tuple(gone)
    places = drain(find_moved(project, gone, tmp_path / "archive"))
    assert [places[path].name for path in gone] == ["0.png", gone[1].name, "2.png"]
    relocate(project, places)
    opened = read(project)
    for state in (opened.current, opened.state(str(opened.steps[0].new))):
        assert state.sources is not None
        assert [path.parent for path in state.sources.photographs] == [there] * 3
    assert drain(check(project, name_files(project))).missing == ()
    assert describe(project)["missing"] == []
    (tmp_path / "archive").rename(tmp_path / "a" / "archive")
    relocate(project, drain(find_moved(project, name_files(project), tmp_path / "a")))
    (tmp_path / "a").rename(tmp_path / "c")
    assert describe(tmp_path / "c" / "Felt.lap")["missing"] == []


def test_photographs_that_changed_are_named_and_those_only_touched_are_not(project: Path) -> None:
    first, second, third = name_files(project)
    os.utime(first)
    second.write_bytes(encode_png(np.zeros((4, 4, 3), np.uint16)))
    about = drain(check(project, (first, second, third)))
    assert about.changed == (second,)
    assert set(about.new) == {first}
    keep(project, about.new)
    assert drain(check(project, (first, third))).new == {}
    assert any(second.name in words and "not as it was" in words for words in drain(problems_of(project)))


def test_a_change_that_keeps_size_and_time_is_found_by_verify(project: Path) -> None:
    path = name_files(project)[0]
    times, content = path.stat(), bytearray(path.read_bytes())
    content[-1] ^= 1
    path.write_bytes(content)
    os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
    assert drain(check(project, (path,))).changed == ()
    assert drain(check(project, (path,), thorough=True)).changed == (path,)


def test_without_marks_a_photograph_is_found_by_its_name_if_only_one_has_it(tmp_path: Path) -> None:
    project = save(tmp_path / "Felt.lap", find([sheet(tmp_path / "Felt")]), marked=False)
    gone = name_files(project)
    (tmp_path / "Felt").rename(tmp_path / "moved")
    (tmp_path / "moved" / "twice").mkdir()
    shutil.copy(tmp_path / "moved" / gone[0].name, tmp_path / "moved" / "twice")
    places = drain(find_moved(project, gone, tmp_path / "moved"))
    assert set(places) == set(gone[1:])


def test_a_folder_of_too_many_files_is_refused(tmp_path: Path, project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_FILES", 2)
    with pytest.raises(InputError, match="more than 2 files"):
        drain(find_moved(project, (), tmp_path / "a" / "Felt"))


def test_a_copy_finds_the_photographs_of_the_original_and_no_others_beside_itself(
    tmp_path: Path, project: Path
) -> None:
    sheet(tmp_path / "b" / "Felt", shade=9)
    drain(copy(project, tmp_path / "b" / "Copy.lap"))
    assert name_files(tmp_path / "b" / "Copy.lap") == name_files(project)


def test_a_collected_project_takes_what_lies_within_it_in_every_state(tmp_path: Path) -> None:
    project = save(tmp_path / "a" / "Felt.lap", find([sheet(tmp_path / "a" / "Felt")]))
    drain(collect(project, tmp_path / "b" / "Felt.lap"))
    assert all(path.is_relative_to(tmp_path / "b") for path in name_files(tmp_path / "b" / "Felt.lap"))
    shutil.rmtree(tmp_path / "a")
    (tmp_path / "b").rename(tmp_path / "c")
    opened = read(tmp_path / "c" / "Felt.lap")
    for state in (opened.current, opened.state(str(opened.steps[0].new))):
        assert state.sources is not None
        assert all(path.is_file() and path.is_relative_to(tmp_path / "c") for path in state.sources.photographs)
    drain(collect(tmp_path / "c" / "Felt.lap", tmp_path / "d" / "Felt.lap", False))
    shutil.rmtree(tmp_path / "c")
    assert describe(tmp_path / "d" / "Felt.lap")["missing"] == []


def test_photographs_of_an_archive_are_there_after_a_restart_and_are_unpacked_again(tmp_path: Path) -> None:
    archive = Path(shutil.make_archive(str(tmp_path / "Red felt"), "zip", sheet(tmp_path / "Felt")))
    path = tmp_path / "Felt.lap"
    place = data_folder(path) / module.INSIDE / "archive-1"
    save(path, drain(find_packed([archive], keep=place)))
    sources = read(path).current.sources
    assert sources is not None
    assert sources.unpacked is not None
    assert (sources.name, sources.unpacked.archive) == ("Red felt", archive)
    assert sources.unpacked.members[sources.photographs[0].name] == "felt_10deg.png"
    assert all(each.is_file() for each in sources.photographs)
    shutil.rmtree(data_folder(path))
    assert len(drain(check(path, sources.photographs)).missing) == 3
    drain(unpack_again(sources.unpacked, sources.photographs[0].parent))
    about = drain(check(path, sources.photographs))
    assert (about.missing, about.changed) == ((), ())


def test_an_archive_that_holds_no_capture_leaves_nothing(tmp_path: Path) -> None:
    folder = sheet(tmp_path / "Felt")
    for extra in sorted(folder.iterdir())[1:]:
        extra.unlink()
    archive = Path(shutil.make_archive(str(tmp_path / "one"), "zip", folder))
    with pytest.raises(InputError):
        drain(find_packed([archive], keep=tmp_path / "kept"))
    assert not (tmp_path / "kept").exists()


def test_the_verb_finds_photographs(tmp_path: Path, project: Path, lightarc: Command) -> None:
    (tmp_path / "a" / "Felt").rename(tmp_path / "moved")
    assert "missing" in lightarc("project", "info", project).out
    assert lightarc("project", "find", project).code == 2
    found = lightarc("project", "find", project, "--photographs", tmp_path / "moved")
    assert found.code == 0
    assert "missing" not in found.out
    assert {path.parent for path in name_files(project)} == {tmp_path / "moved"}


@pytest.fixture
def older(tmp_path: Path) -> Iterator[Path]:
    """A project as the version before marks of photographs wrote it, with its photographs beside it."""
    path = tmp_path / "old" / "Felt.lap"
    sheet(path.parent / "Felt")
    with sqlite3.connect(path) as connection:
        connection.executescript(OLDER.read_text(encoding="utf-8"))
    connection.close()
    yield path
    release(path)


def test_a_project_of_an_older_schema_is_read_as_it_is(older: Path, tmp_path: Path) -> None:
    before = older.read_bytes()
    opened = read(older)
    assert (opened.current.name, opened.current.look.gain) == ("Felt", 2.0)
    assert opened.current.excluded == {"felt_10deg.png"}
    packed = opened.state(str(opened.steps[0].new))
    assert packed.sources is not None
    assert packed.sources.unpacked is None
    assert describe(older)["missing"] == []
    assert describe(older)["schema"] == 1
    assert older.read_bytes() == before
    with pytest.raises(InputError, match="no record of its content"):
        drain(collect(older, tmp_path / "b.lap", include_outside=True))
    assert claim(older)
    keep(older, drain(take_marks(name_files(older))))
    drain(collect(older, tmp_path / "b.lap", include_outside=True))
    assert describe(tmp_path / "b.lap")["schema"] == SCHEMA
    assert all(path.is_relative_to(tmp_path / "b.lap-data") for path in name_files(tmp_path / "b.lap"))


def test_a_project_of_an_older_schema_is_migrated_on_a_copy_and_the_original_kept(older: Path) -> None:
    before, gain = older.read_bytes(), read(older).current.look.gain
    assert claim(older)
    kept = older.with_name("Felt (schema 1).lap")
    with sqlite3.connect(kept) as one, sqlite3.connect(":memory:") as other:
        other.executescript(OLDER.read_text(encoding="utf-8"))
        assert list(one.iterdump()) == list(other.iterdump())
    assert describe(older)["schema"] == SCHEMA
    assert older.read_bytes() != before
    opened = read(older)
    assert (opened.current.look.gain, len(opened.steps)) == (gain, 2)
    keep(older, drain(take_marks(name_files(older))))
    assert len(marks_of(older).keys() & set(name_files(older))) == 3
    assert not any("state" in words for words in drain(problems_of(older)))
    assert migrate(older) is None
    assert sorted(path.name for path in older.parent.glob("*.lap")) == ["Felt (schema 1).lap", "Felt.lap"]


@pytest.mark.parametrize("operation", ["rename", "fsync"])
def test_a_migration_that_fails_leaves_the_project_as_it_was(
    older: Path, operation: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    from engine.core.errors import OutputError
    from engine.storage import atomic

    before = older.read_bytes()
    count = 0

    def find_broken(what: str, _path: Path) -> None:
        nonlocal count
        count += what == operation
        if what == operation and count == 2:  # that of the project; the first is that of the original
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(atomic, "fault", find_broken)
    with pytest.raises(OutputError):
        migrate(older)
    monkeypatch.setattr(atomic, "fault", None)
    assert older.read_bytes() == before
    assert describe(older)["schema"] == 1


@pytest.mark.parametrize("stand", [".", "a", "b/deep"])
def test_paths_are_understood_from_wherever_a_process_stands(
    tmp_path: Path, project: Path, monkeypatch: pytest.MonkeyPatch, stand: str
) -> None:
    """Moved apart, found, copied and collected, all by relative paths; then without the original."""
    for name in ("b/deep", "c", "d"):
        (tmp_path / name).mkdir(parents=True)
    (tmp_path / "a" / "Felt").rename(tmp_path / "b" / "Moved")
    monkeypatch.chdir(tmp_path / stand)

    def at(place: str) -> Path:
        return Path(os.path.relpath(tmp_path / place))

    gone = name_files(at("a/Felt.lap"))
    relocate(at("a/Felt.lap"), drain(find_moved(at("a/Felt.lap"), gone, at("b"))))
    drain(copy(at("a/Felt.lap"), at("c/Copy.lap")))
    with pytest.raises(OutsideFiles, match=str(tmp_path / "b" / "Moved" / "felt_10deg.png")):
        drain(collect(at("c/Copy.lap"), at("d/Felt.lap")))
    drain(collect(at("c/Copy.lap"), at("d/Felt.lap"), include_outside=True))
    monkeypatch.undo()
    for place in ("a/Felt.lap", "c/Copy.lap"):
        assert {path.parent for path in name_files(tmp_path / place)} == {tmp_path / "b" / "Moved"}
    for name in ("a", "b", "c"):
        shutil.rmtree(tmp_path / name)
    (tmp_path / "d").rename(tmp_path / "e")
    assert describe(tmp_path / "e" / "Felt.lap")["missing"] == []
    assert drain(problems_of(tmp_path / "e" / "Felt.lap")) == []

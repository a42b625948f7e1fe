"""Projects from anybody: hostile ones are refused in words, or are sound in all that works on them."""

from __future__ import annotations

import dataclasses
import json
import os
import random
import sqlite3
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.document.document import ImportChoices, Project
from app.project import database
from app.project.copying import OutsideFiles, collect, copy
from app.project.database import Damaged, connect
from app.project.photographs import files_of, keep, outside_of, take_marks
from app.project.project_file import History, Writer, data_folder, read
from app.project.recovery import recover
from app.project.report import describe, problems_of
from app.project.tidying import forget_unused
from app.project.values import array_parts, header_of, name_of
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.storage.text import whole_number
from tests.app.command import Command
from tests.app.project import hostile
from tests.kept import keep as keep_failed

#: Hostile projects of one seed of the campaign; all 4000 seeds are 100,000.
COUNT = 25


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return hostile.base(tmp_path_factory.mktemp("sound"))


@pytest.fixture
def felt(sound: Path, tmp_path: Path) -> Path:
    """A copy of the sound project, in a folder of its own."""
    (tmp_path / "here").mkdir()
    drain(copy(sound, tmp_path / "here" / "Felt.lap"))
    return tmp_path / "here" / "Felt.lap"


@pytest.mark.campaign(rounds=4000)
def test_hostile_projects_are_refused_in_words_or_work(sound: Path, tmp_path: Path, seed: int) -> None:
    outcomes = set()
    for number in range(COUNT * seed, COUNT * (seed + 1)):
        here = tmp_path / str(number)
        here.mkdir()
        done = hostile.hostile(sound, here / "Felt.lap", number)
        with keep_failed(f"{number}.lap", (here / "Felt.lap").read_bytes()):
            try:
                outcomes.add(hostile.outcome(here / "Felt.lap", here))
            except Exception as error:
                error.add_note(f"seed {number}: {done}")
                raise
    assert {"refused", "sound"} <= outcomes


def test_the_sound_project_is_sound(sound: Path, tmp_path: Path) -> None:
    assert hostile.outcome(sound, tmp_path) == "sound"


@pytest.mark.parametrize(
    ("statements", "said"),
    [
        ("ALTER TABLE step RENAME TO x; CREATE VIEW step AS SELECT 1 AS number", "which no project has"),
        ("CREATE TRIGGER t AFTER UPDATE ON meta BEGIN DELETE FROM step; END", "the trigger 't'"),
        ("CREATE INDEX i ON value(length(text))", "the index 'i'"),
        ("CREATE TABLE more(a)", "the table 'more'"),
        ("ALTER TABLE value ADD COLUMN twice AS (text || text)", "the table 'value'"),
        ("DROP TABLE step", "it has no table step"),
        ("UPDATE meta SET value = '²' WHERE name = 'position'", "position in the history is not a number"),
        ("UPDATE meta SET value = '²' WHERE name = 'schema'", "does not say its version"),
        ("UPDATE meta SET value = printf('%.*c', 5000, '9') WHERE name = 'position'", "position in the history"),
        ("UPDATE step SET text = x'00ff'", "values of other types"),
        ("UPDATE value SET text = CAST(x'22ff22' AS TEXT)", "not in UTF-8"),
        ("PRAGMA writable_schema=ON; UPDATE sqlite_master SET sql = CAST(x'e0e1' AS TEXT) WHERE name = 'step'", "dama"),
    ],
)
def test_a_project_has_exactly_the_tables_and_types_of_this_program(felt: Path, statements: str, said: str) -> None:
    with hostile.change(felt) as connection:
        connection.executescript(statements)
    with pytest.raises(Damaged, match=said):
        read(felt)


def test_a_statement_has_a_budget_and_can_do_nothing_else(felt: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(database, "BASE_STEPS", 100_000)
    endless = "SELECT count(*) FROM value a, value b, value c, value d, value e, value f"
    with connect(felt) as connection:
        with pytest.raises(Damaged, match="more work"), database.explain(felt):
            connection.execute(endless)
        for statement in (
            "ATTACH 'other.db' AS other",
            "CREATE TABLE more(a)",
            "DROP TABLE step",
            "PRAGMA writable_schema=ON",
            "SELECT hex(zeroblob(100))",
            "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) SELECT * FROM c",
        ):
            with pytest.raises(sqlite3.DatabaseError, match=r"prohibited|authorized"):
                connection.execute(statement).fetchall()


@pytest.mark.skipif(sys.platform == "win32", reason="links and pipes of other systems")
@pytest.mark.parametrize("ending", ["-journal", "-wal", "-shm"])
@pytest.mark.parametrize("kind", ["device", "pipe", "folder", "hole", "link"])
def test_what_lies_beside_a_project_is_not_read_where_it_is_no_journal(felt: Path, ending: str, kind: str) -> None:
    """SQLite reads it, whatever it is: a device without an end, and for a pipe it waits."""
    beside = felt.with_name(felt.name + ending)
    if kind == "folder":
        beside.mkdir()
    elif kind == "pipe":
        os.mkfifo(beside)
    elif kind == "hole":
        beside.write_bytes(b"")
        os.truncate(beside, 1 << 40)
    else:
        beside.symlink_to("/dev/zero" if kind == "device" else felt)
    with pytest.raises(InputError, match="not a Lightarc journal"):
        read(felt)
    with pytest.raises(InputError, match="not a Lightarc journal"):
        drain(recover(felt, felt.with_name("New.lap")))


def test_a_journal_that_names_a_file_does_not_make_sqlite_delete_it(felt: Path) -> None:
    victim = felt.with_name("victim")
    victim.write_text("kept")
    name = str(victim).encode()
    magic = bytes.fromhex("d9d505f920a163d7")
    tail = len(name).to_bytes(4, "big") + (sum(name) & 0xFFFFFFFF).to_bytes(4, "big") + magic
    pages = felt.stat().st_size // 4096
    head = magic + (0).to_bytes(4, "big") + bytes(4) + pages.to_bytes(4, "big") + (512).to_bytes(4, "big")
    head += (4096).to_bytes(4, "big")
    felt.with_name("Felt.lap-journal").write_bytes(head.ljust(512, b"\0") + (1).to_bytes(4, "big") + name + tail)
    with pytest.raises(InputError, match="not a Lightarc journal"):
        read(felt)
    assert victim.read_text() == "kept"


@pytest.mark.parametrize(
    ("part", "value", "said"),
    [
        ("mesh", "str", "mesh is not a valid mesh"),
        ("look", 5, "look is not a valid look"),
        ("sources", 5, "sources is not a valid list of photographs"),
        ("material", 5, "material is not a valid material"),
        ("stack", 5, "stack is not a valid stack of photographs"),
        ("variations", 5, "variations is not a list of values"),
        ("slices", 1e9, "slices is not a whole number"),
        ("slices", 10**9, "slices is not between 2 and 4096"),
        ("white", {"float": "nan"}, "white is not a finite number"),
        ("bakes", {"map": [["sh", {"map": [["order", "x"]]}]]}, "bakes: "),
        ("built_from", {"tuple": [{"array": "0" * 40}]}, ""),
        ("name", "\ud800", "name is not text"),
    ],
)
def test_parts_are_compared_with_their_declared_types(felt: Path, part: str, value: Any, said: str) -> None:
    replace(felt, part, value)
    if said:
        with pytest.raises(Damaged, match=said):
            read(felt)
    else:
        assert part in read(felt).missing


def replace(path: Path, part: str, value: Any) -> None:
    """Let a part of the current document be what JSON says."""
    text = json.dumps(value)
    name = name_of(text.encode())
    with hostile.change(path) as connection:
        connection.execute("INSERT OR REPLACE INTO value VALUES (?, ?)", (name, text))
        current = connection.execute("SELECT value FROM meta WHERE name = 'current'").fetchone()[0]
        statement = "UPDATE state SET parts = json_set(parts, ?, ?) WHERE name = ?"
        connection.execute(statement, (f"$.{part}", name, current))


def test_all_damaged_parts_are_named_and_the_others_recovered(felt: Path, tmp_path: Path, lightarc: Command) -> None:
    before = read(felt).current
    replace(felt, "mesh", 5)
    replace(felt, "look", "no")
    with pytest.raises(Damaged, match=r"look is not a valid look; mesh is not a valid mesh"):
        read(felt)
    found = lightarc("project", "recover", felt, "-o", tmp_path / "new.lap", "--json")
    assert (found.code, json.loads(found.out)["lost"][:2]) == (
        0,
        ["look is not a valid look", "mesh is not a valid mesh"],
    )
    again = read(tmp_path / "new.lap").current
    assert (again.name, again.notes, again.mesh) == (before.name, "Linen", None)
    assert again.material.shading_map is not None
    assert problems_of(tmp_path / "new.lap") is not None
    assert drain(problems_of(tmp_path / "new.lap")) == []
    assert lightarc("project", "verify", felt).code == 3


def test_a_history_whose_states_are_sound_is_recovered_from_a_file_with_a_view(felt: Path, tmp_path: Path) -> None:
    steps = len(read(felt).steps)
    with hostile.change(felt) as connection:
        connection.execute("CREATE VIEW v AS SELECT 1")
    with pytest.raises(Damaged):
        read(felt)
    assert drain(recover(felt, tmp_path / "new.lap")) == []
    opened = read(tmp_path / "new.lap")
    assert (len(opened.steps), opened.position) == (steps, 1)


def test_verify_finds_numbers_in_large_arrays_that_are_not_finite(felt: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    material = read(felt).current.material
    assert material.shading_map is not None
    slices = material.shading_map.slices.copy()
    slices[0, 0, 0, 0] = np.nan
    shading_map = dataclasses.replace(material.shading_map, slices=slices)
    writer = Writer(felt)
    writer.write(History(Project(material=dataclasses.replace(material, shading_map=shading_map))))
    writer.close()
    with pytest.raises(Damaged, match="not finite"):
        read(felt)
    monkeypatch.setattr("app.project.declared.MAX_SEARCHED_BYTES", 0)
    read(felt)
    with pytest.raises(Damaged, match="not finite"):
        drain(problems_of(felt))


def test_only_recorded_photographs_are_collected(felt: Path, tmp_path: Path) -> None:
    files = files_of(read(felt).current)
    assert outside_of(felt, files) == files
    with pytest.raises(OutsideFiles, match=str(files[0])):
        drain(collect(felt, tmp_path / "out.lap"))
    drain(collect(felt, tmp_path / "out.lap", include_outside=True))
    assert describe(tmp_path / "out.lap")["missing"] == []
    secret = tmp_path / "id_key"
    secret.write_text("-----BEGIN KEY-----")
    sources = read(felt).current.sources
    assert sources is not None
    exposures = ((dataclasses.replace(sources.exposures[0][0], path=secret),), *sources.exposures[1:])
    stolen = dataclasses.replace(sources, photographs=(secret, *sources.photographs[1:]), exposures=exposures)
    theirs = tmp_path / "theirs.lap"
    writer = Writer(theirs)
    writer.write(History(Project(sources=stolen)))
    writer.close()
    for said in ("has no record of its content", "is not a usable photograph"):
        with pytest.raises(InputError, match=said) as caught:
            drain(collect(theirs, tmp_path / "stolen.lap", include_outside=True))
        assert caught.value.path == str(secret)
        assert not (tmp_path / "stolen.lap").exists()
        assert not data_folder(tmp_path / "stolen.lap").exists()
        keep(theirs, drain(take_marks([secret, *sources.photographs])))
    secret.write_text("-----BEGIN OTHER-----")
    with pytest.raises(InputError, match="not the file that the project recorded"):
        drain(collect(theirs, tmp_path / "stolen.lap", include_outside=True))


def test_links_in_a_data_folder_are_not_followed(felt: Path, tmp_path: Path) -> None:
    private, work = tmp_path / "private", tmp_path / "work"
    private.write_text("private")
    work.mkdir()
    (work / "mine.npy").write_bytes(b"mine")
    data = data_folder(felt)
    (data / "photographs").mkdir(exist_ok=True)
    (data / "photographs" / "0001.png").symlink_to(private)
    (data / "stack-1").symlink_to(work)
    drain(copy(felt, tmp_path / "copied.lap"))
    there = [path.read_bytes() for path in data_folder(tmp_path / "copied.lap").rglob("*") if path.is_file()]
    assert b"private" not in there
    assert outside_of(felt, [data / "photographs" / "0001.png"])
    (data / "arrays").rename(data / "other")
    (data / "arrays").symlink_to(work)
    with connect(felt) as connection:
        forget_unused(connection, data, stacks=True)
    assert (work / "mine.npy").exists()


def test_a_named_pipe_in_place_of_an_array_holds_nobody(felt: Path) -> None:
    for array in (data_folder(felt) / "arrays").iterdir():
        array.unlink()
        os.mkfifo(array)
    assert "mesh" in read(felt).missing


@pytest.mark.parametrize(
    ("text", "number"),
    [
        *(("0", 0), ("12", 12), ("100", 100), ("101", None), ("²", None), ("१", None), ("1_0", None), (" 1", None)),
        *(("-1", None), ("", None), ("9" * 5000, None), (None, None), (5, None)),
    ],
)
def test_whole_numbers_are_decimal_digits_of_ascii(text: Any, number: int | None) -> None:
    assert whole_number(text, 100) == number


def test_headers_of_arrays_are_read_without_evaluating_them() -> None:
    rng = random.Random(3)
    stream = np.lib.format.header_data_from_array_1_0(np.zeros((2, 3), np.float32))
    assert stream["shape"] == (2, 3)
    for shape in ((), (0,), (5,), (2, 3), (1, 2, 3, 4)):
        for kind in ("f4", "f8", "i4", "u1", "?"):
            content = array_parts(np.zeros(shape, kind))[0]
            assert header_of(content) == (shape, np.dtype(kind), len(content))
            spoiled = bytearray(content)
            spoiled[rng.randrange(len(content))] ^= 0xFF
            with pytest.raises(ValueError, match="array"):
                header_of(bytes(spoiled))


def test_a_word_that_is_no_choice_is_found(tmp_path: Path) -> None:
    path = tmp_path / "a.lap"
    writer = Writer(path)
    writer.write(History(Project(import_choices=ImportChoices(transfer="linear"))))
    writer.close()
    for word in ("srgb", "sideways"):
        with hostile.change(path) as connection:
            ((name, text),) = connection.execute("SELECT name, text FROM value WHERE text LIKE '%transfer%'").fetchall()
            old = json.loads(text)["of"]["transfer"]
            hostile.replace(connection, name, text.replace(f'"{old}"', f'"{word}"'))
        if word == "srgb":
            assert read(path).current.import_choices.transfer == "srgb"
    with pytest.raises(InputError, match="transfer is none of auto, srgb, linear"):
        read(path)


def test_an_unknown_form_of_the_lights_is_found(tmp_path: Path) -> None:
    path = tmp_path / "a.lap"
    writer = Writer(path)
    writer.write(History(Project(import_choices=ImportChoices(lights_form="shifted+2"))))
    writer.close()
    assert read(path).current.import_choices.lights_form == "shifted+2"
    with hostile.change(path) as connection:
        ((name, text),) = connection.execute("SELECT name, text FROM value WHERE text LIKE '%shifted%'").fetchall()
        hostile.replace(connection, name, text.replace("shifted+2", "sideways"))
    with pytest.raises(InputError, match="import_choices"):
        read(path)

"""The captures of a batch: found in folders and tables, with names that every system takes."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from app.batch.captures import Capture, capture_from, find_captures, read_options, value_of
from engine.core.errors import InputError


def photographs(folder: Path) -> Path:
    folder.mkdir(parents=True)
    for name in ("a.png", "b.png"):
        (folder / name).write_bytes(b"no image is looked at")
    return folder


def names(*sources: str | Path, known: list[Capture] | None = None) -> dict[str, str]:
    return {each.name: each.place.name for each in find_captures(list(map(str, sources)), known or [])}


def test_folders_stand_for_the_captures_below_them(tmp_path: Path) -> None:
    """A folder of RTIBuilder, one of pairs and one with all in a folder of it are one capture each; names differ."""
    for place in ("one", "deep/two", "rti/jpeg-exports", "rti/original-captures", "pair/par", "pair/cross", "raw/DCIM"):
        photographs(tmp_path / place)
    (tmp_path / "rti" / "assembly-files").mkdir()
    (tmp_path / "empty").mkdir()
    photographs(tmp_path / "other" / "ONE")
    found = {"deep": "two", "one": "one", "other": "ONE", "pair": "pair", "raw": "DCIM", "rti": "rti"}
    assert names(tmp_path) == found
    assert names(tmp_path / "one", tmp_path / "other" / "ONE") == {"one": "one", "ONE-2": "ONE"}
    assert names(tmp_path / "*" / "two") == {"two": "two"}
    with pytest.raises(InputError, match="holds no capture"):
        names(tmp_path / "empty")


def test_captures_that_are_known_keep_their_names(tmp_path: Path) -> None:
    first = find_captures([str(photographs(tmp_path / "b" / "medal"))])
    photographs(tmp_path / "a" / "medal")
    assert names(tmp_path / "a", tmp_path / "b") == {"medal": "medal", "medal-2": "medal"}
    again = find_captures([str(tmp_path / "a" / "medal"), str(tmp_path / "b" / "medal")], first)
    assert [(each.name, each.place.parent.name) for each in again] == [("medal-2", "a"), ("medal", "b")]


def test_a_table_gives_names_options_and_metadata(tmp_path: Path) -> None:
    """Names from anybody become names of folders; files of options lie beside the table."""
    table = tmp_path / "list.csv"
    rows = [
        "path;name;options;inventory",
        'a;=HYPERLINK("x")../..;slices=12 --working-space acescg;17',
        '"b";<script>;"mixed=yes lens=""my lens.lens"" lamp_distance=3";\N{RIGHT-TO-LEFT OVERRIDE}gnp',
    ]
    table.write_text("\ufeff" + "\r\n".join(rows).replace("--working-space acescg", "--working-space=acescg"), "utf-8")
    one, other = find_captures([str(table)])
    assert (one.name, other.name) == ("HYPERLINK x", "script")
    assert one.place == tmp_path / "a"
    assert one.options == {"slices": "12", "working_space": "acescg"}
    assert one.metadata == {"inventory": "17"}
    assert other.options["lens"] == os.fspath(tmp_path / "my lens.lens")
    assert capture_from(other.as_text()) == other
    assert other.as_text().isascii()
    assert [value_of(name, text) for name, text in other.options.items()] == [True, tmp_path / "my lens.lens", 3]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("name,options\na,b\n", "one called path"),
        ("path,options\na,sliecs=3\n", r"row 2 that is none \('sliecs' is no setting \(did you mean slices\?\)"),
        ("path,options\na,slices=many\n", "slices is not a whole number"),
        ("path,options\na,control_points=1\n", "is no setting"),
        ("path,options\na,motion=nne\n", "motion is none of auto, none, translation"),
        ("path,owner\na,Ann\n./a,Bob\n", "same photographs with the same options in rows 2 and 3"),
        ("path,name\na,b,c\n", "more cells in row 2"),
        ("path,name\n,b\n", "no path in row 2"),
        ('path,name\n"a,b\n', "no table of cells"),
        ("path\n" + "a" * 5000 + "\n", "too long"),
    ],
)
def test_a_table_that_cannot_be_used_names_its_row(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "list.csv").write_text(text)
    with pytest.raises(InputError, match=said):
        find_captures([str(tmp_path / "list.csv")])


@pytest.mark.parametrize(
    "text",
    [
        "path;name;owner\r\nM\xfcnzen/Hof;Hof;M\xfcller",
        "sep=;\r\nPath;NAME;owner;;\r\nM\xfcnzen\\Hof;Hof;M\xfcller;;",
        'path,name,owner,,\n"Mu\u0308nzen/Hof",Hof,M\xfcller,,',
    ],
)
@pytest.mark.parametrize("code", ["utf-8-sig", "cp1252", "utf-16"])
def test_tables_as_spreadsheets_write_them(tmp_path: Path, text: str, code: str) -> None:
    """Excel states separators, writes the Windows code page, and keeps empty columns; macOS takes umlauts apart."""
    if "\u0308" in text and code == "cp1252":
        text = text.replace("u\u0308", "\xfc")
    photographs(tmp_path / "M\xfcnzen" / "Hof")
    (tmp_path / "list.csv").write_bytes(text.encode(code))
    (found,) = find_captures([str(tmp_path / "list.csv")])
    assert (found.name, dict(found.metadata)) == ("Hof", {"owner": "M\xfcller"})
    assert found.place == tmp_path / "M\xfcnzen" / "Hof"


def test_backslashes_of_an_option_are_those_of_a_path(tmp_path: Path) -> None:
    assert read_options(r"mask=D:\masks\a.png", tmp_path)["mask"].endswith(r"D:\masks\a.png")


def test_an_option_is_a_name_and_a_value(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="not NAME=VALUE"):
        read_options("strict", tmp_path)

"""The captures of a batch: folders and archives that are found, or listed in a table with options and metadata.

A folder that holds photographs is a capture. Any other folder stands for the captures below it. Names become those of
folders of results: letters that every system takes, each name once.
"""

from __future__ import annotations

import csv
import glob
import io
import json
import os
import re
import shlex
import unicodedata
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from app.document.document import ImportChoices, Project
from app.project.declared import problem_of
from app.project.places import file_name
from app.project.values import in_full
from engine.capture.lights.folder import inside, is_made_by_program, is_sidecar
from engine.capture.lights.polarised_pairs import folders_of_pairs
from engine.capture.lights.sources import list_entries
from engine.capture.photograph.kinds import photograph_suffixes
from engine.core.errors import InputError
from engine.core.suggestion import suggest
from engine.storage.text import utf8
from engine.storage.unpack import is_archive
from engine.storage.untrusted import read_bytes

#: Bytes and rows of the largest table, letters of a cell, captures of one batch, and levels of folders that are looked
#: through.
MAX_TABLE_BYTES, MAX_ROWS, MAX_LETTERS, MAX_CAPTURES, MAX_DEPTH = 1 << 26, 200_000, 4000, 200_000, 12

#: Columns of a table that are no metadata.
COLUMNS = ("path", "name", "options")

#: Settings of a project, beside its choices for an import, that a row of a table may set.
OF_PROJECT = (
    *("representation", "slices", "tileable", "evened", "part_of_light", "scale", "exponent_bits"),
    *("mixed", "error_bound_percent", "white"),
)

#: Choices for an import that hold for the photographs of one capture alone, which a table cannot set.
OF_PHOTOGRAPHS = ("control_points", "highlights", "outline_px")

#: Names within the folder of results that are not those of captures, and names that Windows gives to devices.
_TAKEN = ("logs", "template.lap", "template.lap-data", "batch.sqlite", "report.html", "report.csv", "report.json")
_RESERVED = {"CON", "PRN", "AUX", "NUL", *(f"{port}{number}" for port in ("COM", "LPT") for number in range(10))}

_WORDS = {"yes": True, "true": True, "no": False, "false": False, "none": None}


@dataclass(frozen=True)
class Capture:
    """A capture of a batch.

    Attributes
    ----------
    name : of the folder of its results, unlike that of any other capture of the batch, whatever the case of letters.
    place : folder or archive of its photographs.
    options : settings as they were written, by the names of fields of `ImportChoices` and `Project`.
    metadata : other columns of the table.
    """

    name: str
    place: Path
    options: Mapping[str, str] = field(default_factory=dict)
    metadata: Mapping[str, str] = field(default_factory=dict)

    def as_text(self) -> str:
        """The capture as JSON in ASCII, in which any path can be told."""
        said = {"name": self.name, "place": os.fspath(self.place)}
        return json.dumps({**said, "options": dict(self.options), "metadata": dict(self.metadata)}, sort_keys=True)


def capture_from(text: str) -> Capture:
    """The capture of which `as_text` gave `text`; ValueError for a name that is none of a folder."""
    said = json.loads(text)
    name = str(said["name"])
    if name != _file_name(name) or name.casefold() in _TAKEN:
        raise ValueError(f"{name[:40]!r} is no name of a capture")
    options, metadata = ({str(key): str(each) for key, each in said[kind].items()} for kind in ("options", "metadata"))
    return Capture(name, Path(said["place"]), options, metadata)


def find_captures(sources: Sequence[str], known: Collection[Capture] = ()) -> list[Capture]:
    """The captures of `sources`: folders, archives, patterns such as `museum/*/photographs`, and tables (.csv).

    Captures that a batch knows keep their names, so that others can join it. Raises InputError for a source without a
    capture, and for a table that cannot be used.
    """
    names = {_key(each): each.name for each in known}
    taken = {*_TAKEN, *(name.casefold() for name in names.values())}
    found: dict[str, Capture] = {}
    for given in sources:
        listed = list(_find(given))
        if not listed:
            raise InputError(given, "holds no capture", "Give folders of photographs, or a table of them (.csv)")
        for each in listed:
            key = _key(each)
            if key not in names:
                names[key] = _free(each.name, taken)
                taken.add(names[key].casefold())
            found[names[key]] = Capture(names[key], in_full(each.place), each.options, each.metadata)
            if len(found) > MAX_CAPTURES:
                raise InputError(given, f"makes more than {MAX_CAPTURES:,} captures", "Divide it into several batches")
    return list(found.values())


def _file_name(wish: str) -> str:
    """`wish` in letters that every system takes."""
    name = file_name(wish, "").strip(" .") or "capture"
    return f"{name}-1" if name.split(".")[0].upper() in _RESERVED else name


def _key(capture: Capture) -> tuple[str, ...]:
    """Equal for captures of the same photographs with the same options."""
    options = (f"{name}={text}" for name, text in sorted(capture.options.items()))
    return (os.fspath(in_full(capture.place)), *options)


def _free(wish: str, taken: Collection[str]) -> str:
    """`wish` as the name of a folder that nothing in `taken`, in small letters, is called."""
    name = _file_name(wish)
    for at in range(1, MAX_CAPTURES + 2):
        tried = name if at == 1 else f"{name}-{at}"
        if tried.casefold() not in taken:
            return tried
    raise AssertionError("more names are taken than there can be captures")


def _find(given: str) -> Iterator[Capture]:
    """The captures of one source, with the names that they wish for."""
    if given.lower().endswith(".csv"):
        yield from _read_table(Path(given))
        return
    places = [Path(given)]
    if not os.path.lexists(given) and glob.has_magic(given):
        places = [Path(each) for each in sorted(glob.glob(given, recursive=True))]  # noqa: PTH207 - absolute patterns
    for place in places:
        if not os.path.lexists(place):
            raise InputError(place, "does not exist", "Check its name, or put a pattern into quotes")
        yield from _below(place)


def name_of(place: Path) -> str:
    """The name of a capture that lies at `place`: of the folder, of an archive without its ending."""
    name = in_full(place).name
    return re.sub(r"(\.tar)?\.[A-Za-z0-9]{1,5}$", "", name) if is_archive(place) else name


def _below(place: Path, depth: int = 0, wish: str = "") -> Iterator[Capture]:
    """The captures at or below `place`, in the order of their names, each with the name that it wishes for.

    A folder that alone holds photographs in another one, as `medal/photographs`, wishes for the name of that.
    """
    if place.is_file():
        if is_archive(place):
            yield Capture(name_of(place), place)
        return
    entries = sorted(list_entries(place), key=lambda entry: entry.name)
    if any(_is_photograph(entry) for entry in entries):
        yield Capture(wish or name_of(place), place)
        return
    folders = [each for each in entries if each.is_dir() and not is_made_by_program(each.name)]
    counts = [(each.name, sum(map(_is_photograph, list_entries(each)))) for each in folders]
    filled = [name for name, count in counts if count]
    known, lights = inside(counts)
    if folders_of_pairs(filled) is not None or lights is not None or (known is not None and len(filled) > 1):
        yield Capture(name_of(place), place)
        return
    if depth >= MAX_DEPTH:
        raise InputError(place, f"lies more than {MAX_DEPTH} folders deep", "Give a folder that is nearer")
    for each in entries:
        if each in folders or is_archive(each):
            yield from _below(each, depth + 1, name_of(place) if depth and filled == [each.name] else "")


def _is_photograph(entry: Path) -> bool:
    return not is_sidecar(entry) and entry.suffix.lower() in photograph_suffixes() and entry.is_file()


def _read_table(table: Path) -> Iterator[Capture]:
    """The captures of a table; InputError names its row."""
    content = utf8(read_bytes(table, MAX_TABLE_BYTES)).decode("utf-8", "surrogateescape").removeprefix("\ufeff")
    head, _, rest = content.partition("\n")
    stated = re.fullmatch(r'"?sep=([,;\t])"?\s{0,9}', head, re.IGNORECASE)  # by which Excel states the separator
    separator = stated[1] if stated else max(",;\t", key=head.count)
    reader = csv.reader(io.StringIO(rest if stated else content, newline=""), delimiter=separator, strict=True)
    rows: dict[tuple[str, ...], tuple[int, Capture]] = {}
    try:
        columns = [_in_small(_as_shown(cell.strip())) for cell in next(reader, [])]
        named = [column for column in columns if column]
        if named.count("path") != 1 or len(set(named)) != len(named):
            problem = "needs a first row that names its columns, each once, with one called path"
            raise InputError(table, problem, "Begin it with path,name,options and columns for metadata")
        for at, cells in enumerate(reader, 3 if stated else 2):
            if any(cell.strip() for cell in cells):
                found = _read_row(table, at, columns, cells)
                before, same = rows.setdefault(_key(found), (at, found))
                if same != found:
                    problem = f"names the same photographs with the same options in rows {before} and {at}"
                    raise InputError(table, problem, "Leave one of them out, or give it other options")
                yield found
            if at > MAX_ROWS:
                raise InputError(table, f"has more than {MAX_ROWS:,} rows", "Divide it")
    except csv.Error as error:
        raise InputError(table, f"is no table of cells ({error})", "Save it as CSV again") from None


def _read_row(table: Path, at: int, columns: Sequence[str], cells: Sequence[str]) -> Capture:
    if len(cells) > len(columns) or any(len(cell) > MAX_LETTERS or "\0" in cell for cell in cells):
        problem = f"has more cells in row {at} than it has columns, or one that is too long"
        raise InputError(table, problem, "Put cells that hold separators into quotation marks")
    row = {column: cell.strip() for column, cell in zip(columns, cells, strict=False) if column}
    if not row["path"]:
        raise InputError(table, f"has no path in row {at}", "Name the folder of the photographs there")
    place = _find_place(table.parent, row["path"])
    row = {column: _as_shown(cell) for column, cell in row.items()}
    try:
        options = read_options(row.get("options", ""), table.parent)
    except ValueError as error:
        raise InputError(table, f"has an option in row {at} that is none ({error})", "See lightarc batch -h") from None
    metadata = {column: cell for column, cell in row.items() if column not in COLUMNS and cell}
    return Capture(row.get("name") or name_of(place), place, options, metadata)


def _in_small(column: str) -> str:
    """The name of a column that means something here in small letters, others as they are."""
    return column.lower() if column.lower() in COLUMNS else column


def _as_shown(cell: str) -> str:
    """A cell whose bytes are no UTF-8 by the Windows code page, in which Excel writes tables."""
    try:
        cell.encode()
    except UnicodeEncodeError:
        return cell.encode("utf-8", "surrogateescape").decode("cp1252", "replace")
    return cell


def _find_place(folder: Path, path: str) -> Path:
    """The first of the ways to read `path` that exists, or the plainest where none does.

    Excel writes names in the Windows code page, macOS takes umlauts apart, and Windows divides folders by backslashes.
    """
    shown = _as_shown(path)
    forms = [path, shown, *(unicodedata.normalize(form, shown) for form in ("NFC", "NFD"))]
    forms += [form.replace("\\", "/") for form in forms]
    return next((folder / form for form in forms if os.path.lexists(folder / form)), folder / shown)


def read_options(text: str, folder: Path) -> dict[str, str]:
    """Settings such as `working_space=acescg lens="my lens.lens"` by name; ValueError for what is none.

    Files are looked for in `folder`, and are named in full afterwards.
    """
    options: dict[str, str] = {}
    words = shlex.shlex(text, posix=True, punctuation_chars=False)
    words.whitespace_split, words.commenters, words.escape = True, "", ""  # backslashes are of Windows' paths
    for word in words:
        name, equals, value = word.partition("=")
        name = name.removeprefix("--").replace("-", "_")
        if not equals:
            raise ValueError(f"{word[:40]!r} is not NAME=VALUE")
        if isinstance(value_of(name, value), Path):
            value = os.fspath(in_full(folder / value))
        options[name] = value
    return options


def value_of(name: str, text: str) -> Any:
    """The value of the setting `name` that `text` means; ValueError where there is no such setting or value."""
    choices = {each for each in ImportChoices.__dataclass_fields__ if each not in OF_PHOTOGRAPHS}
    if name not in choices | {*OF_PROJECT}:
        raise ValueError(f"{name[:40]!r} is no setting{suggest(name, sorted(choices | {*OF_PROJECT}))}")
    kind: type = ImportChoices if name in choices else Project
    readings: list[Any] = [text]
    readings += [_WORDS[text.lower()]] if text.lower() in _WORDS else []
    for read in (int, float):
        with suppress(ValueError):
            readings.append(read(text))
    with suppress(ValueError):
        readings.append(tuple(float(part) for part in text.split(",")))
        readings.append(tuple(int(part) for part in text.split(",")))
    problems = [(each, problem_of(kind, {name: each})) for each in [*readings, Path(text)]]
    for each, problem in problems:
        if not problem:
            return each
    raise ValueError(problems[0][1])

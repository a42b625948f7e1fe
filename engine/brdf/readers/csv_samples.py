"""Plain tables of theta_i, phi_i, theta_o, phi_o in degrees, with R, G, B or one value in 1/sr without the cosine.

A first line may name the columns, in any order; without it the order is the one above. Columns are separated by commas,
semicolons, tabs or blanks; lines from `#` are comments, of which one before the data may name the columns too, as numpy
writes it. X, Y, Z are read in place of R, G, B. Decimal commas are read where semicolons, tabs or blanks separate, and
refused with the line where commas do, because there nobody can tell. `read_csv_directions` reads such a table without
values.
"""

from __future__ import annotations

import math
import re
import string
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from engine.brdf.readers.text import (
    Line,
    head_lines,
    is_number,
    numbers,
    read_lines,
    refuse,
    table,
    without_unit,
)
from engine.brdf.samples import BrdfSamples, samples_from_rows
from engine.brdf.spectrum import srgb_from_measured_xyz
from engine.core.directions import Vectors, surface_direction
from engine.core.errors import InputError
from engine.core.health import Finding, Verdict
from engine.storage.untrusted import AGAIN

ANGLES = ("theta_i", "phi_i", "theta_o", "phi_o")
_COLOUR = ("r", "g", "b")
_XYZ = ("x", "y", "z")
_COLOURS = (
    _COLOUR,
    *(tuple(before + c for c in _COLOUR) for before in ("brdf_", "f_", "fr_")),
    ("red", "green", "blue"),
)
_GREY = ("value", "f", "fr", "f_r", "brdf", "y", "luminance", "grey", "gray")
_VALUES = (*_COLOURS, _XYZ, *((grey,) for grey in _GREY))
_OUTGOING = re.compile(r"(theta|phi)_?(o|out|outgoing|r|reflected|s|scattered|v|view)")
_INCIDENT = re.compile(r"(theta|phi)_?(i|in|incident|incoming|l|light)")
_PER_STERADIAN = ("1/sr", "/sr", "sr^-1", "sr-1", "sr⁻¹")
_DEGREES = ("degrees", "degree", "deg", "°")
_RADIANS = ("radians", "radian", "rad")
_SEPARATORS = (";", "\t", ",", None)

#: Most columns that are named: far beyond any table.
_COLUMNS_LIMIT = 4096

#: Angles beyond this many degrees are damage.
_LARGEST_DEG = 3600.0


def looks_like_csv(head: bytes, size_bytes: int, name: str) -> bool:
    """True where the first line names angles, or the first lines are rows of five or seven numbers."""
    filled = [Line(number, line) for number, line in enumerate(head_lines(head), 1) if line]
    lines = [line.text for line in filled if not line.text.startswith("#")]
    if not lines:
        return False
    words = _words(lines[0], _separator(lines[0]))
    if _is_header(words):
        return any("theta" in word.lower() for word in words) and any("phi" in word.lower() for word in words)
    if _find_names_in_comments(filled, len(words)):
        return all(is_number(word.replace(",", ".")) for word in words)
    # The last line may be cut.
    rows = [_words(line, _separator(lines[0])) for line in lines[: max(len(lines) - 1, 1)]]
    # With decimal commas between commas there are twice as many, which the reader then says.
    return all(len(row) in (5, 7, 10, 14) and all(is_number(word.replace(",", ".")) for word in row) for row in rows)


def read_csv_samples(path: Path) -> BrdfSamples:
    """The samples of a table with four angles and one or three values; InputError names the line that is wrong."""
    columns, data = _read(path)
    for values in _VALUES:
        if set(values) <= set(columns):
            break
    else:
        raise InputError(path, "has directions but no values R,G,B", "Add the columns R, G, B in 1/sr")
    angles = data[:, [columns.index(angle) for angle in ANGLES]]
    wi, wo = directions_from_degrees(angles)
    findings = []
    if np.nanmax(np.abs(np.where(np.isfinite(angles), angles, np.nan)), initial=0.0) <= 2.0 * math.pi:
        text = "no angle is above 6.3; this file is read in degrees, but looks like radians"
        findings.append(Finding(Verdict.WARNING, text))
    rgb = data[:, [columns.index(value) for value in values]]
    if values == _XYZ:
        rgb = srgb_from_measured_xyz(rgb)
    is_xyz = values == _XYZ  # what was a colour has no negative channel any more
    return samples_from_rows(path, "CSV samples", wi, wo, rgb, findings=findings, negative_is_missing=is_xyz)


def read_csv_directions(path: Path) -> tuple[Vectors, Vectors]:
    """Unit directions wi, wo (N, 3) of a table with four angles in degrees; other columns are not looked at.

    Raises InputError naming the line that is wrong, also for an angle that is not finite.
    """
    columns, data = _read(path)
    angles = data[:, [columns.index(angle) for angle in ANGLES]]
    if not np.isfinite(angles).all():
        row = int(np.flatnonzero(~np.isfinite(angles).all(axis=1))[0])
        raise InputError(path, f"has an angle that is not finite in row {row + 1}", "Give all angles in degrees")
    return directions_from_degrees(angles)


def directions_from_degrees(angles_deg: NDArray[np.float64]) -> tuple[Vectors, Vectors]:
    """Unit directions wi, wo (N, 3) of theta_i, phi_i, theta_o, phi_o (N, 4) in degrees.

    90° is exactly on the horizon, which its cosine in floating-point numbers is not.
    """
    with np.errstate(invalid="ignore"):
        theta_i, phi_i, theta_o, phi_o = np.deg2rad(angles_deg).T
        wi, wo = surface_direction(theta_i, phi_i), surface_direction(theta_o, phi_o)
        for directions, theta_deg in ((wi, angles_deg[:, 0]), (wo, angles_deg[:, 2])):
            directions[np.abs(theta_deg) % 180.0 == 90.0, 2] = 0.0
    return wi, wo


def _read(path: Path) -> tuple[list[str], NDArray[np.float64]]:
    """Names of the columns and the rows (N, columns)."""
    filled = read_lines(path)
    lines = [line for line in filled if not line.text.startswith("#")]
    if not lines:
        raise InputError(path, "holds no measurement", AGAIN)
    separator = _separator(lines[0].text)
    first = _words(lines[0].text, separator)
    if _is_header(first):
        columns = _name_columns(path, lines[0], first)
        lines = lines[1:]
    elif named := _find_names_in_comments(filled, len(first)):
        columns = _name_columns(path, *named)
    else:
        columns = _count(path, lines[0], first)
        _refuse_counted_rows(path, lines, separator)
    rows = []
    for line in lines:
        words = _words(line.text, separator)
        if len(words) != len(columns):
            _refuse_width(path, line, len(words), str(len(columns)), separator)
        if separator != ",":
            words = [word.replace(",", ".") if word.count(",") == 1 and "." not in word else word for word in words]
        values = numbers(path, line.number, words)
        for name, value in zip(columns, values, strict=True):
            if name in ANGLES and abs(value) > _LARGEST_DEG and math.isfinite(value):
                refuse(path, line.number, f"has {name} = {value:g} degrees")
        rows.append(values)
    return columns, table(path, rows)


def _separator(line: str) -> str | None:
    return next(separator for separator in _SEPARATORS if separator is None or separator in line)


def _words(line: str, separator: str | None) -> list[str]:
    """The columns of a line; a separator behind the last one makes none."""
    words = [word.strip().strip("\"'") for word in line.split(separator)]
    return words[:-1] if len(words) > 1 and not words[-1] else words


def _find_names_in_comments(lines: Sequence[Line], count: int) -> tuple[Line, list[str]] | None:
    """The last comment before the data that names all four angles among `count` columns, and its words."""
    named = None
    for line in lines:
        if not line.text.startswith("#"):
            break
        text = line.text.lstrip("# ")
        words = _words(text, _separator(text))
        if len(words) == count and all([_plain(word) for word in words].count(angle) == 1 for angle in ANGLES):
            named = line, words
    return named


def _is_header(words: list[str]) -> bool:
    return any(
        word.lower().lstrip(string.punctuation + string.whitespace).startswith(("theta", "phi")) for word in words
    )


def _plain(word: str) -> str:
    """`theta_o` for every usual spelling of it, and so on; other words in small letters."""
    name, _ = without_unit(word.lower().strip(), _DEGREES)
    name, _ = without_unit(name, _PER_STERADIAN)
    name = "_".join(name.replace("-", " ").split())
    for pattern, letter in ((_OUTGOING, "o"), (_INCIDENT, "i")):
        match = pattern.fullmatch(name)
        if match:
            return f"{match[1]}_{letter}"
    return name


def _name_columns(path: Path, line: Line, words: list[str]) -> list[str]:
    if len(words) > _COLUMNS_LIMIT:
        refuse(path, line.number, f"names {len(words)} columns; at most {_COLUMNS_LIMIT} are possible")
    for word in words:
        if without_unit(word, _RADIANS)[1]:
            refuse(path, line.number, f"says that {word[:40]!r} is in radians", "Write degrees")
    columns = [_plain(word) for word in words]
    for angle in ANGLES:
        if columns.count(angle) != 1:
            refuse(path, line.number, f"names {angle} {columns.count(angle)} times; once is needed")
    return columns


def _count(path: Path, line: Line, words: list[str]) -> list[str]:
    """The columns of a file that names none."""
    values: dict[int, tuple[str, ...]] = {4: (), 5: ("value",), 7: _COLOUR}
    if len(words) not in values:
        _refuse_width(path, line, len(words), "4 angles and 0, 1 or 3 values", _separator(line.text))
    return [*ANGLES, *values[len(words)]]


def _refuse_counted_rows(path: Path, lines: Sequence[Line], separator: str | None) -> None:
    """A file without names whose first column counts 1, 2, 3 … is not one of angles: CUReT's `table.txt` is such."""
    if len(lines) > 4 and all(_words(line.text, separator)[0] == str(count) for count, line in enumerate(lines, 1)):
        remedy = "Name the columns in a first line; of CUReT's files name rbrdf.dat or abrdf.dat"
        refuse(path, lines[0].number, "begins a column that counts the rows, where theta_i is needed", remedy)


def _refuse_width(path: Path, line: Line, found: int, needed: str, separator: str | None) -> NoReturn:
    remedy = f"Write one row of {', '.join(ANGLES)} in degrees and R, G, B"
    if separator == "," and found in (10, 14):
        remedy = "If these are decimal commas, write decimal points, or separate the columns by semicolons"
    refuse(path, line.number, f"has {found} columns where {needed} are needed", remedy)

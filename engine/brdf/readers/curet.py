"""The measurement tables of CUReT (Dana1999).

`rbrdf.dat`, `gbrdf.dat`, `bbrdf.dat` (red, green, blue) and `abrdf.dat` (their mean) have one row per material: its
number, 1 to 61, and one value in 1/sr for each of 205 pairs of directions. The pairs stand in `table.txt` beside them:
rows of theta_v phi_v theta_i phi_i, a running number before them or not, in radians as published; a polar angle above
π/2 by more than a degree says that they are in degrees. Any of the files may be named: where red, green and blue lie
together all three are read, else the one that is named, as grey. Which material is meant is said as `abrdf.dat#17`;
a file of one row needs no number. Values that are negative (the camera had overflowed) are dropped.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.brdf.readers.text import head_lines, is_number, numbers, read_lines, refuse, table
from engine.brdf.samples import BrdfSamples, samples_from_rows
from engine.core.directions import surface_direction
from engine.core.errors import InputError
from engine.core.health import Finding, Verdict
from engine.storage.untrusted import is_at_hand

#: Fewer values in a row are not a table of CUReT, whose rows have 205.
_FEWEST = 100

_CHANNELS = "rgb"
_NAME = re.compile(r"[argb]brdf\b", re.IGNORECASE)
_LARGEST_RADIANS = 1.6


def looks_like_curet(head: bytes, size_bytes: int, name: str) -> bool:
    """True where the first row is a small whole number and a hundred numbers or more."""
    lines = [line for line in head_lines(head) if line]
    words = lines[0].split() if lines else []
    # The last word may be cut.
    return bool(
        len(words) > _FEWEST and re.fullmatch(r"\d{1,3}", words[0]) and all(is_number(word) for word in words[:-1])
    )


def split_material(path: Path) -> tuple[Path, int | None]:
    """The file and the number of the material of `abrdf.dat#17`; a file that really has such a name is left alone."""
    stem, mark, number = path.name.rpartition("#")
    if mark and stem and re.fullmatch(r"\d{1,3}", number) and not is_at_hand(path):
        return path.with_name(stem), int(number)
    return path, None


def read_curet(path: Path) -> BrdfSamples:
    """The samples of one material; InputError names what is missing, or the line that is wrong."""
    path, material = split_material(path)
    channels = _channels(path)
    directions = _directions(path)
    values = []
    for channel in channels:
        rows = _materials(channel, len(directions))
        if material is None and len(rows) == 1:
            material = next(iter(rows))
        if material not in rows:
            known = f"{min(rows)} to {max(rows)}"
            problem = f"holds {len(rows)} materials" if material is None else f"has no material {material}"
            raise InputError(path, f"{problem}; their numbers are {known}", f"Name one, as {path.name}#{min(rows)}")
        values.append(rows[material])
    wo = surface_direction(directions[:, 0], directions[:, 1])
    wi = surface_direction(directions[:, 2], directions[:, 3])
    findings = (
        [Finding(Verdict.NOTE, "red, green and blue do not lie together; read as grey")] if len(values) == 1 else []
    )
    name, rgb = f"CUReT {material}", np.stack(values, axis=-1)
    return samples_from_rows(path, "CUReT samples", wi, wo, rgb, findings=findings, name=name, negative_is_missing=True)


def _channels(path: Path) -> list[Path]:
    """The files of red, green and blue where `path` is one of the four and all three are there, else `path`."""
    if not _NAME.match(path.name):
        return [path]
    siblings = [path.with_name(letter + path.name[1:]) for letter in _CHANNELS]
    return siblings if all(is_at_hand(sibling) for sibling in siblings) else [path]


def _directions(path: Path) -> NDArray[np.float64]:
    """theta_v, phi_v, theta_i, phi_i (M, 4) in radians, from `table.txt` beside `path`."""
    source = path.with_name("table.txt")
    if not is_at_hand(source):
        raise InputError(path, "needs the directions of its measurements", "Put CUReT's table.txt next to it")
    rows: list[list[float]] = []
    for line in read_lines(source):
        words = line.text.replace(",", " ").split()
        if not words or (not rows and not is_number(words[0])):
            continue  # a heading, or commas alone
        if len(words) not in (4, 5):
            refuse(source, line.number, f"has {len(words)} values; theta_v phi_v theta_i phi_i are needed")
        rows.append(numbers(source, line.number, words)[-4:])
    angles = table(source, rows)
    if not (np.abs(angles) <= 3600.0).all():
        raise InputError(source, "has angles that are not possible", "Fetch CUReT's table.txt again")
    if (np.abs(angles[:, [0, 2]]) > _LARGEST_RADIANS).any():
        angles = np.deg2rad(angles)
    return angles


def _materials(path: Path, count: int) -> dict[int, NDArray[np.float64]]:
    """The values (M,) of each material by its number."""
    materials: dict[int, NDArray[np.float64]] = {}
    for line in read_lines(path):
        words = line.text.split()
        if not re.fullmatch(r"\d{1,3}", words[0]):
            refuse(path, line.number, f"has {words[0][:40]!r} where the number of a material is needed")
        if len(words) != count + 1:
            refuse(path, line.number, f"has {len(words) - 1} values, but table.txt has {count} pairs of directions")
        if int(words[0]) in materials:
            refuse(path, line.number, f"is a second row of material {int(words[0])}")
        materials[int(words[0])] = np.array(numbers(path, line.number, words[1:]))
    return materials

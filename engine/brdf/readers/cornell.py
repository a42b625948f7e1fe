"""Tables of Cornell's gonioreflectometer, in both spellings, and other tables after ASTM E1392.

`.brdf` (as pbrt-v2 reads it): comments from `#`, the number of wavelengths, the wavelengths in nm, then rows of
theta_i phi_i theta_s phi_s and one value per wavelength; white space and line breaks separate, also in the head.
`.astm`: lines `KEY value`, among them NUM_POINTS and last `VARS theta_i,phi_i,theta_s,phi_s,400nm,…`, then one row of
values per measurement, separated by commas or blanks. VARS may name the columns in any order and, in place of
wavelengths, R,G,B (taken as linear sRGB), X,Y,Z or one value.
Angles are in radians, as Cornell writes them, unless the header says degrees (a key with UNIT in it, or names such as
`theta_i_deg`) or a polar angle is above π, which no angle in radians is. Values are in 1/sr without the cosine. See
Foo1997, and S. Westin, "Measurement data", Cornell Program of Computer Graphics.
"""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np

from engine.brdf.readers.text import (
    SAMPLES_LIMIT,
    Line,
    head_lines,
    is_number,
    numbers,
    read_lines,
    refuse,
    table,
    without_unit,
)
from engine.brdf.samples import BrdfSamples, Floats, samples_from_rows
from engine.brdf.spectrum import srgb_from_measured_xyz
from engine.core.directions import surface_direction
from engine.core.errors import InputError
from engine.storage.untrusted import AGAIN

_WAVELENGTHS_LIMIT = 4096
_ANGLES = ("theta_i", "phi_i", "theta_s", "phi_s")
_SPELLINGS = {"theta_o": "theta_s", "theta_r": "theta_s", "phi_o": "phi_s", "phi_r": "phi_s"}
_SPELLINGS |= {"red": "r", "green": "g", "blue": "b"}
_RGB, _XYZ = ["r", "g", "b"], ["x", "y", "z"]
_WAVELENGTH = re.compile(r"(\d{1,9}+(?:\.\d{1,9}+)?) {0,9}+nm", re.IGNORECASE)
_UNITS = ("degrees", "degree", "deg", "radians", "radian", "rad")

#: A polar angle above this (a little more than π) is in degrees.
_LARGEST_RADIANS = 3.15


def looks_like_cornell(head: bytes, size_bytes: int, name: str) -> bool:
    """True for the first bytes of either spelling."""
    lines = head_lines(head)
    return _is_astm(lines) or _is_table(lines)


def _is_astm(lines: list[str]) -> bool:
    """True where a line names columns or the number of points."""
    keys = [line.split(maxsplit=1) for line in lines if line.startswith(("VARS", "NUM_POINTS"))]
    return any(len(key) == 2 and (key[0] == "VARS" or (key[0] == "NUM_POINTS" and key[1][0].isdigit())) for key in keys)


def _is_table(lines: list[str]) -> bool:
    words = [word for line in lines for word in line.partition("#")[0].split()]
    if len(words) < 3 or not re.fullmatch(r"\d{1,4}", words[0]):
        return False
    # The last word may be cut.
    bands = words[1 : 1 + int(words[0])][: max(len(words) - 2, 1)]
    if not bands or not all(is_number(word) for word in bands):
        return False
    return all(100.0 <= float(word) <= 20000.0 for word in bands)


def read_cornell(path: Path) -> BrdfSamples:
    """The samples of a `.brdf` or `.astm` table; InputError names the line that is wrong."""
    lines = read_lines(path)
    if _is_astm([line.text for line in lines]):
        return _read_astm(path, lines)
    return _read_table(path, lines)


def _read_table(path: Path, lines: list[Line]) -> BrdfSamples:
    bare = (Line(each.number, each.text.partition("#")[0].strip()) if "#" in each.text else each for each in lines)
    filled = [line for line in bare if line.text]
    count = filled[0].text.split()[0] if filled else ""
    if not re.fullmatch(r"\d{1,9}", count):
        refuse(path, filled[0].number if filled else 1, "should begin with the number of wavelengths")
    bands = int(count)
    if not 1 <= bands <= _WAVELENGTHS_LIMIT:
        refuse(path, filled[0].number, f"announces {bands} wavelengths; 1 to {_WAVELENGTHS_LIMIT} are possible")
    wavelengths = numbers(path, filled[0].number, filled[0].text.split()[1:])
    start = 1
    while len(wavelengths) < bands and start < len(filled):
        wavelengths += numbers(path, filled[start].number, filled[start].text.split())
        start += 1
    if len(wavelengths) != bands:
        last = filled[start - 1].number
        refuse(path, last, f"ends a list of {len(wavelengths)} wavelengths, but {bands} are announced")
    rising = _rising(path, filled[min(1, start - 1)].number, wavelengths)
    return _samples(path, "Cornell table", _free_rows(path, filled[start:], 4 + bands), rising)


def _free_rows(path: Path, lines: list[Line], width: int) -> Floats:
    """Rows of `width` numbers: one a line where the first line is one, else broken anywhere."""
    one_a_line = bool(lines) and len(lines[0].text.split()) == width
    values: list[float] = []
    for line in lines:
        words = line.text.split()
        if one_a_line and len(words) != width:
            refuse(path, line.number, f"has {len(words)} values where {width} are needed")
        values += numbers(path, line.number, words)
        if len(values) > SAMPLES_LIMIT * width:
            break
    if len(values) % width:
        refuse(path, lines[-1].number, f"ends within a row: {len(values) % width} values of {width}")
    return table(path, [values[first : first + width] for first in range(0, len(values), width)])


def _read_astm(path: Path, lines: list[Line]) -> BrdfSamples:
    header: dict[str, Line] = {}
    rows: list[Line] = []
    for index, line in enumerate(lines):
        key, _, value = line.text.partition(" ") if " " in line.text else line.text.partition("\t")
        header[key.upper()] = Line(line.number, value.strip())
        if key.upper() == "VARS":
            rows = lines[index + 1 :]
            break
    if "VARS" not in header:
        raise InputError(path, "has no line VARS that names its columns", AGAIN)
    names, in_degrees = _columns(path, header)
    values = []
    for line in rows:
        words = line.text.split(",") if "," in line.text else line.text.split()
        words = [word.strip() for word in words[: len(words) - (not words[-1].strip())]]
        if len(words) != len(names):
            refuse(path, line.number, f"has {len(words)} values where VARS names {len(names)}")
        values.append(numbers(path, line.number, words))
    _check_count(path, header, len(values))
    angles = [names.index(angle) for angle in _ANGLES]
    bands = [column for column in range(len(names)) if column not in angles]
    matched = [_WAVELENGTH.fullmatch(names[column]) for column in bands]
    wavelengths = [float(match[1]) for match in matched if match]
    order = np.argsort(wavelengths, kind="stable") if wavelengths else np.arange(len(bands))
    data = table(path, values)[:, angles + [bands[index] for index in order]]
    if [names[column] for column in bands] == _XYZ:
        data[:, 4:] = srgb_from_measured_xyz(data[:, 4:])
    spectral = _rising(path, header["VARS"].number, sorted(wavelengths)) if wavelengths else None
    return _samples(path, "ASTM E1392 table", data, spectral, in_degrees)


def _columns(path: Path, header: dict[str, Line]) -> tuple[list[str], bool]:
    """The names of the columns without their units, and whether angles are said to be in degrees."""
    line, text = header["VARS"]
    in_degrees = any("deg" in value.text.lower() for key, value in header.items() if "UNIT" in key)
    words = [word.strip() for word in text.replace(";", ",").split(",")]
    if len(words) > len(_ANGLES) + _WAVELENGTHS_LIMIT:
        refuse(path, line, f"names {len(words)} columns; at most {len(_ANGLES) + _WAVELENGTHS_LIMIT} are possible")
    names = []
    for name in words:
        bare, unit = without_unit(name, _UNITS)
        if unit and name.lower().startswith(("theta", "phi")):
            in_degrees = in_degrees or unit.startswith("deg")
            name = bare
        names.append(_SPELLINGS.get(name.lower(), name.lower()))
    missing = [angle for angle in _ANGLES if names.count(angle) != 1]
    if missing:
        refuse(path, line, f"names {missing[0]} {names.count(missing[0])} times; once is needed")
    values = [name for name in names if name not in _ANGLES]
    spectral = [bool(_WAVELENGTH.fullmatch(name)) for name in values]
    if not values or len(values) > _WAVELENGTHS_LIMIT:
        refuse(path, line, f"names {len(values)} columns of values; 1 to {_WAVELENGTHS_LIMIT} are possible")
    if not (all(spectral) or values in (_RGB, _XYZ) or (len(values) == 1 and not any(spectral))):
        unknown = next(name for name, band in zip(values, spectral, strict=True) if not band)
        problem = f"names a column {unknown[:40]!r}; wavelengths as 400nm, R,G,B, X,Y,Z or one value are read"
        refuse(path, line, problem)
    return names, in_degrees


def _check_count(path: Path, header: dict[str, Line], found: int) -> None:
    announced = header.get("NUM_POINTS")
    if announced is None:
        return
    if not re.fullmatch(r"\d{1,18}", announced.text):
        refuse(path, announced.number, f"has {announced.text[:40]!r} where the number of points is needed")
    if int(announced.text) != found:
        refuse(path, announced.number, f"announces {int(announced.text)} points, but {found} follow", AGAIN)


def _rising(path: Path, line: int, wavelengths: list[float]) -> Floats:
    array = np.array(wavelengths)
    if not np.isfinite(array).all() or (np.diff(array) <= 0.0).any():
        refuse(path, line, "has wavelengths that do not rise")
    return array


def _samples(
    path: Path, kind: str, rows: Floats, wavelengths_nm: Floats | None, in_degrees: bool = False
) -> BrdfSamples:
    angles = rows[:, :4]
    polar = angles[:, [0, 2]]
    with np.errstate(invalid="ignore"):
        in_degrees = in_degrees or bool((np.abs(polar[np.isfinite(polar)]) > _LARGEST_RADIANS).any())
        if in_degrees:
            angles = angles * (math.pi / 180.0)
        wi, wo = surface_direction(angles[:, 0], angles[:, 1]), surface_direction(angles[:, 2], angles[:, 3])
    return samples_from_rows(path, kind, wi, wo, rows[:, 4:], wavelengths_nm)

"""Files of light positions, of the kinds that reflectance transformation imaging (RTI) has: `.lp` and `.dome`.

`.lp`: the first line holds the number of lights, every other one `name x y z`: x to the right, y up in the image, z
towards the camera. Names may contain spaces and may be paths of the machine that took the photographs, of which the
last part counts. Programs write it in other forms as well: without the number of lights, with positions in any unit,
with an intensity in a fifth column, with tabs, semicolons or commas, and with decimal commas. These are read, and what
was made of them is said; what does not fit is reported with its line number.

`.dome`: JSON of RelightLab, which describes a dome apart from photographs; its `directions` stand in the order in which
the lamps are lit. Where its lights lie on a sphere, `domeDiameter` and `imageWidth` give their distance.

The text is read in the decoder child of the photographs (`engine.storage.untrusted`), which an import starts in any
case. Cost: 2 ms for 64 lights, once that child runs.
"""

from __future__ import annotations

import json
import math
import re
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any, NoReturn, TypeGuard

from engine.capture.lights.file_names import comparable
from engine.core.errors import InputError
from engine.storage.text import utf8
from engine.storage.untrusted import decode_in_child, hand, read_bytes

_LIMIT_BYTES = 16 << 20

#: Largest deviation of a direction's length from 1: files with two decimals are welcome.
_UNIT_TOLERANCE = 0.01


@dataclass(frozen=True)
class Light:
    """The light of one photograph, in radians; `line` of the file counts from 1."""

    name: str
    elevation: float
    azimuth: float
    line: int


@dataclass(frozen=True)
class LightList:
    """The lights of an `.lp` file in its order, and what was made of its form, in sentences."""

    lights: tuple[Light, ...]
    notes: tuple[str, ...]


def read_light_positions(path: Path) -> LightList:
    """The lights of an `.lp` file; InputError names the line that is wrong."""
    decoder, process = (
        "engine.capture.lights.light_positions:decode_light_positions",
        "engine.capture.photograph.decode",
    )
    reply = decode_in_child(decoder, path, limit_bytes=_LIMIT_BYTES, process=process)
    return LightList(tuple(Light(*fields) for fields in reply["lights"]), tuple(reply["notes"]))


def decode_light_positions(content: bytes, name: str) -> dict[str, Any]:
    """The decoder: the fields of every `Light`, and the notes."""
    with hand({name: content}):
        found = _list(Path(name))
        return {"lights": [astuple(light) for light in found.lights], "notes": list(found.notes)}


@dataclass(frozen=True)
class _Row:
    """A line of a list: the number of its words, and the numbers at its end with where they begin."""

    number: int
    text: str
    words: int
    starts: tuple[int, ...]
    values: tuple[float, ...]


def _list(path: Path) -> LightList:
    text = utf8(read_bytes(path, _LIMIT_BYTES)).decode("utf-8-sig", "surrogateescape")
    lines = [(number, line.strip()) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]
    if not lines:
        _refuse(path, 1, "should hold the number of lights")
    notes = []
    is_counted = re.fullmatch(r"\d{1,7}", lines[0][1]) is not None
    rows = [_row(path, number, line) for number, line in lines[is_counted:]]
    if is_counted and len(rows) != int(lines[0][1]):
        _refuse(path, 1, f"announces {int(lines[0][1])} lights, but {len(rows)} follow")
    if not is_counted:
        notes.append("does not begin with the number of lights; each of its lines was taken for one")
    first = _first_column(rows)
    if first == -4:
        notes.append("has a fourth number in each line, which was not used: intensities come from the photographs")
    lights = tuple(_light(path, row, first) for row in rows)
    if any(abs(math.hypot(*_vector(row, first)) - 1.0) > _UNIT_TOLERANCE for row in rows):
        notes.append("holds positions instead of directions; only their directions were used")
    _refuse_repeated_names(path, lights)
    return LightList(lights, tuple(notes))


def _row(path: Path, number: int, line: str) -> _Row:
    """A line whose fields are separated by blanks, tabs, semicolons or commas, with decimal points or commas."""
    words = list(re.finditer(r"[^;\s]{1,4096}+", line))
    if words[-1].group().count(",") >= 3:  # commas alone separate
        words = list(re.finditer(r"[^,]{1,4096}+", line))
        if len(words) > 5:
            _refuse(path, number, "has commas between numbers and in them; write decimal points")
    starts: list[int] = []
    values: list[float] = []
    for word in reversed(words[1:]):
        text = word.group().strip().rstrip(",")
        if not re.fullmatch(r"[-+]?(\d{1,400}+([.,]\d{0,400}+)?|[.,]\d{1,400}+)([eE][-+]?\d{1,3}+)?", text):
            break
        starts.insert(0, word.start())
        values.insert(0, float(text.replace(",", ".")))
    if len(values) < 3:
        _refuse(path, number, f"should hold a name and three numbers, not {line[:60]!r}")
    return _Row(number, line, len(words), tuple(starts), tuple(values))


def _first_column(rows: list[_Row]) -> int:
    """Where x stands, from the end of a line: -3, or -4 where intensities follow z.

    A number before x may also be the end of a name with blanks; the last three are then directions, or no name is one
    word alone.
    """
    if not rows or any(row.words != 5 or len(row.values) != 4 for row in rows):
        return -3
    last = [abs(math.hypot(*_vector(row, -3)) - 1.0) <= _UNIT_TOLERANCE for row in rows]
    return -3 if all(last) else -4


def _vector(row: _Row, first: int) -> tuple[float, ...]:
    return row.values[first : first + 3] if first + 3 else row.values[first:]


def _light(path: Path, row: _Row, first: int) -> Light:
    x, y, z = _vector(row, first)
    length = math.hypot(x, y, z)
    if not 1e-6 < length < 1e9:
        _refuse(path, row.number, f"has a light at the distance {length:g}; a direction or a position is needed")
    if z < 0.0:
        _refuse(path, row.number, f"has a light behind the sample (z = {z:g})")
    name = row.text[: row.starts[first]].strip("; ,\t\"'")
    return Light(name, math.atan2(z, math.hypot(x, y)), math.atan2(y, x), row.number)


def _refuse_repeated_names(path: Path, lights: tuple[Light, ...]) -> None:
    first: dict[str, int] = {}
    for light in lights:
        earlier = first.setdefault(comparable(light.name), light.line)
        if earlier != light.line:
            _refuse(path, light.line, f"names {light.name[:60]}, as line {earlier} does")


def _refuse(path: Path, line: int, problem: str) -> NoReturn:
    raise InputError(path, f"line {line} {problem}", "Correct the file, or remove it and give the angles yourself")


@dataclass(frozen=True)
class Dome:
    """Directions (elevation, azimuth) in radians in the order of the lamps, and their distance from the middle of the
    image in widths of the image; None where the file does not say."""

    directions: tuple[tuple[float, float], ...]
    lamp_distance: float | None


def read_dome(path: Path) -> Dome:
    """The lamps of a `.dome` file; InputError names the lamp that is wrong."""
    decoder, process = "engine.capture.lights.light_positions:decode_dome", "engine.capture.photograph.decode"
    reply = decode_in_child(decoder, path, limit_bytes=_LIMIT_BYTES, process=process)
    return Dome(tuple((elevation, azimuth) for elevation, azimuth in reply["directions"]), reply["distance"])


def decode_dome(content: bytes, name: str) -> dict[str, Any]:
    """The decoder: `directions` and `distance` of a `Dome`."""
    path = Path(name)
    with hand({name: content}):
        try:
            values = json.loads(utf8(read_bytes(path, _LIMIT_BYTES)).decode("utf-8-sig"))
        except (ValueError, RecursionError):
            _refuse_dome(path, "is not valid JSON")
    lamps = values.get("directions") if isinstance(values, dict) else None
    if not isinstance(lamps, list) or not lamps:
        _refuse_dome(path, "holds no list of directions")
    directions = [_dome_direction(path, number, lamp) for number, lamp in enumerate(lamps, 1)]
    return {"directions": directions, "distance": _dome_distance(values)}


def _dome_direction(path: Path, number: int, lamp: object) -> tuple[float, float]:
    """Elevation and azimuth; directions of any length are welcome, since some files keep positions there."""
    numbers = [lamp.get(key) for key in "xyz"] if isinstance(lamp, dict) else lamp
    if not isinstance(numbers, list) or len(numbers) != 3 or not all(map(_is_number, numbers)):
        _refuse_dome(path, f"has no x, y and z for lamp {number}")
    x, y, z = numbers
    length = math.hypot(x, y, z)
    if not 1e-6 < length < 1e6:
        _refuse_dome(path, f"has a direction of length {length:g} for lamp {number}")
    if z < 0.0:
        _refuse_dome(path, f"has lamp {number} behind the sample (z = {z:g})")
    return math.atan2(z, math.hypot(x, y)), math.atan2(y, x)


def _dome_distance(values: dict[str, Any]) -> float | None:
    """Half the diameter in widths of the image, for lamps that lie on a sphere."""
    diameter, width = values.get("domeDiameter"), values.get("imageWidth")
    is_near = values.get("lightConfiguration", "directional") != "directional"
    if not (is_near and _is_number(diameter) and _is_number(width)):
        return None
    distance = float(diameter) / (2.0 * float(width)) if width > 0 else 0.0
    return distance if 0.5 < distance < 1e6 else None


def _is_number(value: object) -> TypeGuard[float]:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e30


def _refuse_dome(path: Path, problem: str) -> NoReturn:
    raise InputError(path, problem, "Correct the file, or remove it and give the angles yourself")

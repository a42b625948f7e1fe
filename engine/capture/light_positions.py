"""`.lp` files: the light positions of reflectance transformation imaging.

The first line holds the number of lights, every other one `name x y z`: x to the right, y up in the image, z towards
the camera. Names may contain spaces and may be paths of the machine that took the photographs, of which the last part
counts. What does not fit is reported with its line number and never guessed. The text is read in the decoder child of
the photographs (`engine.files.untrusted`), which an import starts in any case.
Cost: 2 ms for 64 lights, once that child runs.
"""

from __future__ import annotations

import math
import re
import unicodedata
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any, NoReturn

from engine.errors import InputError
from engine.files.text import utf8
from engine.files.untrusted import decode_in_child, handed, read_bytes

_LIMIT_BYTES = 16 << 20

#: How far the length of a direction may be from 1: files with two decimals are welcome.
_UNIT_TOLERANCE = 0.01


@dataclass(frozen=True)
class Light:
    """The light of one photograph, in radians; `line` of the file counts from 1."""

    name: str
    elevation: float
    azimuth: float
    line: int


def read_light_positions(path: Path) -> tuple[Light, ...]:
    """The lights of an `.lp` file in its order; InputError names the line that is wrong."""
    decoder, process = "engine.capture.light_positions:decode_light_positions", "engine.capture.decode"
    reply = decode_in_child(decoder, path, limit_bytes=_LIMIT_BYTES, process=process)
    return tuple(Light(*fields) for fields in reply["lights"])


def decode_light_positions(content: bytes, name: str) -> dict[str, Any]:
    """The decoder: the fields of every `Light`."""
    with handed({name: content}):
        return {"lights": [astuple(light) for light in _lights(Path(name))]}


def _lights(path: Path) -> tuple[Light, ...]:
    text = utf8(read_bytes(path, _LIMIT_BYTES)).decode("utf-8-sig", "surrogateescape")
    lines = [(number, line.strip()) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]
    if not lines or not re.fullmatch(r"\d{1,7}", lines[0][1]):
        _refuse(path, 1, "should hold the number of lights")
    lights = tuple(_light(path, number, line) for number, line in lines[1:])
    if len(lights) != int(lines[0][1]):
        _refuse(path, 1, f"announces {int(lines[0][1])} lights, but {len(lights)} follow")
    _refuse_repeated_names(path, lights)
    return lights


def comparable(name: str) -> str:
    """A file name in the spelling in which names are compared: systems store accents composed or decomposed."""
    return unicodedata.normalize("NFC", re.split(r"[/\\]", name)[-1])


def _light(path: Path, number: int, line: str) -> Light:
    words = line.rsplit(maxsplit=3)
    if len(words) != 4:
        _refuse(path, number, f"should hold a name and three numbers, not {line[:60]!r}")
    if any("," in word for word in words[1:]):
        _refuse(path, number, f"has a decimal comma in {' '.join(words[1:])[:60]!r}; write decimal points")
    try:
        x, y, z = (float(word) for word in words[1:])
    except ValueError:
        _refuse(path, number, f"has no three numbers at its end: {' '.join(words[1:])[:60]!r}")
    length = math.sqrt(x * x + y * y + z * z)
    if not abs(length - 1.0) <= _UNIT_TOLERANCE:
        _refuse(path, number, f"has a direction of length {length:g}; a unit vector is needed")
    if z < 0.0:
        _refuse(path, number, f"has a light behind the sample (z = {z:g})")
    return Light(words[0].strip("\"'"), math.atan2(z, math.hypot(x, y)), math.atan2(y, x), number)


def _refuse_repeated_names(path: Path, lights: tuple[Light, ...]) -> None:
    first: dict[str, int] = {}
    for light in lights:
        earlier = first.setdefault(comparable(light.name), light.line)
        if earlier != light.line:
            _refuse(path, light.line, f"names {light.name[:60]}, as line {earlier} does")


def _refuse(path: Path, line: int, problem: str) -> NoReturn:
    raise InputError(path, f"line {line} {problem}", "Correct the file, or remove it and give the angles yourself")

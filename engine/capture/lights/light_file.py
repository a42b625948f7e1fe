"""Lights of a capture in a file, so that a dome is calibrated once: `.lights` and `.lp`.

`.lights` is JSON: the direction of each lamp in the order of the photographs' names, its intensity over the median, the
distance of the lamps, and the standard deviations of these. A capture under the same lamps by a camera in the same
place names that file and needs no ball; what the file states is not estimated again. `.lp` has the directions alone.

The file is read in the decoder child of the photographs (`engine.storage.untrusted`).
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from engine.capture.lights.file_names import natural
from engine.capture.lights.light_positions import Light
from engine.core.errors import InputError, UsageError
from engine.storage.atomic import write_bytes
from engine.storage.text import utf8
from engine.storage.untrusted import decode_in_child, hand, read_bytes

#: Endings of files that lights can be written to.
WRITTEN = (".lights", ".lp")

_LIMIT_BYTES = 16 << 20


@dataclass(frozen=True)
class CalibratedLights:
    """The lights of a `.lights` file.

    Attributes
    ----------
    lights : one for each photograph; `line` is the number of the lamp in the file, from 1.
    gains : the intensity of each over the median.
    lamp_distance : of near lamps in widths of the image; None for distant ones.
    sigma : standard deviation of the inverse distance ('distance') and of the logarithm of intensities ('gains').
    """

    lights: tuple[Light, ...]
    gains: tuple[float, ...]
    lamp_distance: float | None
    sigma: Mapping[str, float]


class _Lamp(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    photograph: str = Field(min_length=1, max_length=4096)
    elevation_deg: float = Field(ge=0, le=90)
    azimuth_deg: float = Field(ge=-360, le=360)
    gain: float = Field(default=1.0, gt=1e-6, lt=1e6)


class _File(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    lightarc_lights: Literal[1]
    lamps: list[_Lamp] = Field(min_length=1, max_length=100_000)
    lamp_distance_widths: float | None = Field(default=None, gt=0.5, lt=1e9)
    sigma: dict[Literal["distance", "gains"], float] = {}


def save_lights(path: str | os.PathLike[str], found: CalibratedLights) -> None:
    """Write lights to a `.lights` or `.lp` file, in the order of the photographs' names.

    Raises UsageError for another ending, OutputError where the file cannot be written.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in WRITTEN:
        raise UsageError(f"lights are written to {' or '.join(WRITTEN)}, not to {suffix or 'a file without an ending'}")
    order = sorted(range(len(found.lights)), key=lambda index: natural(found.lights[index].name))
    write_bytes(Path(path), (_as_lp if suffix == ".lp" else _as_json)(found, order).encode())


def _as_lp(found: CalibratedLights, order: list[int]) -> str:
    lines = [str(len(order))]
    for light in (found.lights[index] for index in order):
        across = math.cos(light.elevation)
        vector = across * math.cos(light.azimuth), across * math.sin(light.azimuth), math.sin(light.elevation)
        lines.append(" ".join((light.name, *(f"{value:.8f}" for value in vector))))
    return "\n".join(lines) + "\n"


def _as_json(found: CalibratedLights, order: list[int]) -> str:
    lamps = [
        {
            "photograph": found.lights[index].name,
            "elevation_deg": round(math.degrees(found.lights[index].elevation), 6),
            "azimuth_deg": round(math.degrees(found.lights[index].azimuth), 6),
            "gain": round(found.gains[index], 6),
        }
        for index in order
    ]
    said = {
        "lightarc_lights": 1,
        "lamp_distance_widths": found.lamp_distance,
        "sigma": dict(found.sigma),
        "lamps": lamps,
    }
    return json.dumps(said, indent=1, ensure_ascii=False) + "\n"


def read_lights(path: Path) -> CalibratedLights:
    """The lights of a `.lights` file; InputError names the lamp that is wrong."""
    decoder, process = "engine.capture.lights.light_file:decode_lights", "engine.capture.photograph.decode"
    reply = decode_in_child(decoder, path, limit_bytes=_LIMIT_BYTES, process=process)
    lights = tuple(Light(*fields) for fields in reply["lights"])
    return CalibratedLights(lights, tuple(reply["gains"]), reply["distance"], reply["sigma"])


def decode_lights(content: bytes, name: str) -> dict[str, Any]:
    """The decoder: the fields of every `Light`, `gains`, `distance` and `sigma`."""
    path, remedy = Path(name), "Write it again with --write-lights, or take it out of the folder"
    with hand({name: content}):
        try:
            found = _File.model_validate_json(utf8(read_bytes(path, _LIMIT_BYTES)))
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            where = ".".join(str(part + 1) if isinstance(part, int) else part for part in first["loc"])
            problem = (
                f"does not hold lights as Lightarc writes them: {where + ': ' if where else ''}{first['msg'][:200]}"
            )
            raise InputError(path, problem, remedy) from None
    lights = [
        Light(lamp.photograph, math.radians(lamp.elevation_deg), math.radians(lamp.azimuth_deg), number)
        for number, lamp in enumerate(found.lamps, start=1)
    ]
    return {
        "lights": [astuple(light) for light in lights],
        "gains": [lamp.gain for lamp in found.lamps],
        "distance": found.lamp_distance_widths,
        "sigma": {term: min(max(0.0, sigma), 1e3) for term, sigma in found.sigma.items()},
    }

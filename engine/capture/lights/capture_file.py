"""`capture.toml`: what a user or the virtual light arc says about a folder of photographs.

    notes = "suede, distant lamp"
    transfer = "linear"            # of 8- and 16-bit files: "srgb" or "linear"
    dark = "dark.tif"              # optional; photograph without light
    flat = "flat.tif"              # optional; photograph of an even white surface
    reference = "woven_05.tif"     # optional; the photograph that the others are aligned to
    lamp_distance = 1.5            # optional; of a near lamp from the middle of the image, in its widths

    [[photographs]]
    file = "woven_01.tif"
    elevation_deg = 10.0           # of the light above the sample; optional where a mirror sphere tells it
    azimuth_deg = 0.0              # optional; 0 = right, 90 = up in the image
    exposure_s = 0.5               # optional; replaces what the camera noted
    highlight_px = [95.0, 431.5]   # optional; column and row of the lamp's reflection, where it is not found rightly
    control_points = [[12, 30, 15, 28], [400, 310, 402, 309]]    # optional; where it is not aligned rightly

    [sphere]                       # optional; outline of a mirror sphere in the image
    column_px = 80.5
    row_px = 450.0
    radius_px = 40.0

A control point is x and y in the reference, then x and y in the photograph; pixel centres are at integers.
Entries with equal angles and different exposures are exposures of one light.
A table [simulation] is kept for the virtual light arc, dates in it as text. Misspelt keys are refused, because a key
that is silently ignored is an angle that is silently wrong. The text is read in the decoder child of the photographs
(`engine.storage.untrusted`), which an import starts in any case.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from engine.core.errors import InputError
from engine.storage.text import utf8
from engine.storage.untrusted import decode_in_child, hand, read_bytes

_LIMIT_BYTES = 16 << 20
_STRICT = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True)


#: Most parts of a dotted key; the time of Python's parser grows with their square, and none of ours has more than one.
_PARTS_LIMIT = 32

#: Marks that begin and end strings, comments and keys of TOML; six quotes are a string of none.
_MARKS = re.compile(r"""\\.|"{6}|"{3,5}|'{6}|'{3,5}|["'.=,{}\[\]\n#]""", re.DOTALL)


class PhotographEntry(BaseModel):
    """One photograph; angles in degrees, exposure in seconds."""

    model_config = _STRICT

    file: str
    elevation_deg: float | None = Field(default=None, ge=0.0, le=90.0)
    azimuth_deg: float | None = Field(default=None, ge=-360.0, le=360.0)
    exposure_s: float | None = Field(default=None, gt=0.0)
    highlight_px: tuple[float, float] | None = None
    control_points: tuple[tuple[float, float, float, float], ...] = Field(default=(), max_length=1000)


class SphereEntry(BaseModel):
    """Outline of a mirror sphere in pixels, (0, 0) = the upper left corner of the image."""

    model_config = _STRICT

    column_px: float
    row_px: float
    radius_px: float = Field(gt=0.0)


class CaptureFile(BaseModel):
    """The whole file."""

    model_config = _STRICT

    notes: str = ""
    transfer: Literal["srgb", "linear"] | None = None
    dark: str | None = Field(default=None, min_length=1)
    flat: str | None = Field(default=None, min_length=1)
    reference: str | None = Field(default=None, min_length=1)
    lamp_distance: float | None = Field(default=None, gt=0.5)
    photographs: tuple[PhotographEntry, ...] = ()
    sphere: SphereEntry | None = None
    simulation: dict[str, Any] = {}


def read_capture_file(path: Path) -> CaptureFile:
    """Read and check `path`; InputError names the line or the key that is wrong."""
    decoder, process = "engine.capture.lights.capture_file:decode_capture_file", "engine.capture.photograph.decode"
    reply = decode_in_child(decoder, path, limit_bytes=_LIMIT_BYTES, process=process)
    return _check(path, reply["values"])


def decode_capture_file(content: bytes, name: str) -> dict[str, Any]:
    """The decoder: the `values` of a `CaptureFile` that were checked, as JSON has them."""
    with hand({name: content}):
        return {"values": _check(Path(name), _values(Path(name))).model_dump(mode="json")}


def _values(path: Path) -> dict[str, Any]:
    try:
        text = utf8(read_bytes(path, _LIMIT_BYTES)).decode("utf-8-sig")
        if _max_parts(text) > _PARTS_LIMIT:
            raise InputError(path, f"has a key of more than {_PARTS_LIMIT} parts", "Correct it, or remove the file")
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # also for a whole number of thousands of digits
        raise InputError(path, f"is not valid TOML ({str(error)[:120]})", "Correct it, or remove the file") from None


def _check(path: Path, values: dict[str, Any]) -> CaptureFile:
    try:
        return CaptureFile.model_validate(values)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(str(part) for part in first["loc"])[:80]
        raise InputError(path, f"{where}: {first['msg']}", "Correct this key, or remove the file") from None


def _max_parts(text: str) -> int:
    """The most dots between two marks of TOML, outside of strings and comments."""
    parts = most = 0
    closing = ""
    for mark in map(re.Match.group, _MARKS.finditer(text)):
        if closing:
            long = len(closing) == 3 and mark.startswith(closing)
            short = len(closing) == 1 and (mark == "\n" or mark == closing or (mark[-1] == closing == "'"))
            closing = "" if long or short else closing
        elif mark[0] in "\"'":
            closing = {1: mark, 6: ""}.get(len(mark), mark[:3])
        elif mark == ".":
            parts += 1
            most = max(most, parts)
        else:
            parts = 0
            closing = "\n" if mark == "#" else ""
    return most

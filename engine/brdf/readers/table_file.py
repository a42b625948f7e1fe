"""Our own file of a BRDF table: an OpenEXR image of 32-bit floats that any image program can look at.

Channels R, G, B hold values in 1/sr without the cosine, `missing` is 1 where an entry was not measured but filled.
Rows are theta_h × theta_d (theta_h outermost) and columns phi_d, or rows theta_i × phi_i and columns theta_o × phi_o.
The attribute `brdfTable` says which, as JSON with dimensions, grids, name, kind, what was missing and the health;
`brdfTableSha256` is the fingerprint of that text and all pixels, so that damage cannot pass for data.
float32 comes back bit for bit; float64 is rounded to it (6·10⁻⁸ relative), which the table's health then says.
"""

from __future__ import annotations

import hashlib
import os
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from engine.brdf.brdf import Brdf
from engine.brdf.resample import resample
from engine.brdf.table import DirectionTable, HalfDifferenceTable
from engine.core.errors import InputError
from engine.core.health import Finding, Health, Verdict
from engine.core.steps import Steps
from engine.images.encode import encode_exr
from engine.storage.atomic import write_bytes
from engine.storage.records import HealthRecord
from engine.storage.untrusted import AGAIN, decode_content, read_bytes

Table = HalfDifferenceTable | DirectionTable

RECORD, FINGERPRINT = "brdfTable", "brdfTableSha256"
SUFFIX = ".exr"

_SIGNATURE = b"\x76\x2f\x31\x01"
_PLANES = ("R", "G", "B", "missing")
_LIMIT_BYTES = 1 << 30
_MAX_ENTRIES = 1 << 25
_REMEDY = "Write the table again with this program"

_Angle = Annotated[float, Field(ge=0.0, le=6.2831853071795865, allow_inf_nan=False)]
_Grid = Annotated[list[_Angle], Field(max_length=4096)]
_Text = Annotated[str, Field(max_length=1000)]


class _Record(BaseModel):
    """Contents of the attribute `brdfTable`; angles in radians."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    version: Literal[1] = 1
    layout: Literal["half-difference", "directions"]
    shape: Annotated[list[Annotated[int, Field(ge=1, le=1 << 20)]], Field(min_length=3, max_length=4)]
    unit: Literal["1/sr, without the cosine"] = "1/sr, without the cosine"
    colour: Literal["linear sRGB"] = "linear sRGB"
    name: _Text
    kind: _Text
    missing: Annotated[int, Field(ge=0)]
    health: HealthRecord
    grids: Annotated[list[_Grid], Field(max_length=4)] = []


def looks_like_table(head: bytes, size_bytes: int, name: str) -> bool:
    """OpenEXR with our attribute, which stands before all others."""
    return head.startswith(_SIGNATURE) and RECORD.encode() + b"\0string\0" in head


def write_table(path: str | os.PathLike[str], table: Table) -> Table:
    """Write `table` and return what stands in the file; OutputError where it cannot be written."""
    content, stored = encode_table(table)
    write_bytes(path, content)
    return stored


def keep_table(brdf: Brdf) -> Steps[Table]:
    """`brdf` as the table that a file gives back bit for bit: rounded, or resampled where it is not a table yet."""
    if isinstance(brdf, HalfDifferenceTable | DirectionTable):
        return _round(brdf)
    return (yield from resample(brdf, dtype=np.float32))


def _round(table: Table) -> Table:
    """`table` in float32, with a note in its health where that changes values."""
    values = np.ascontiguousarray(table.values, np.float32)
    health = table.health
    if not np.array_equal(values, table.values):
        note = "The values are rounded from float64 to float32, 6·10⁻⁸ relative."
        health = health.merge(Health(findings=(Finding(Verdict.NOTE, note),)))
    if isinstance(table, HalfDifferenceTable):
        return replace(table, values=values, health=health, planes=None)
    return replace(table, values=values, health=health)


def encode_table(table: Table) -> tuple[bytes, Table]:
    """The content of a table's file, and the table that it gives back."""
    table = _round(table)
    grids = [] if isinstance(table, HalfDifferenceTable) else [table.theta_i, table.phi_i, table.theta_o, table.phi_o]
    record = _Record(
        layout="half-difference" if isinstance(table, HalfDifferenceTable) else "directions",
        shape=list(table.missing.shape),
        name=table.name[:1000],
        kind=table.kind[:1000],
        missing=table.invalid_samples,
        health=HealthRecord.of(table.health),
        grids=[[float(angle) for angle in grid] for grid in grids],
    ).model_dump_json()
    rows, columns = _image(table.missing.shape)
    planes = [*np.moveaxis(table.values.reshape(rows, columns, 3), -1, 0), table.missing.reshape(rows, columns)]
    channels = {name: np.ascontiguousarray(plane, np.float32) for name, plane in zip(_PLANES, planes, strict=True)}
    attributes = {RECORD: record, FINGERPRINT: _fingerprint(record, channels)}
    return encode_exr(channels, half=False, attributes=attributes), table


def read_table(path: str | os.PathLike[str]) -> Table:
    """The table in a file of `write_table`; InputError for any other file, and for one that is damaged."""
    return decode_table(read_bytes(path, _LIMIT_BYTES), Path(path))


def decode_table(content: bytes, path: str | os.PathLike[str]) -> Table:
    """The table in the content of a file, which messages call `path`."""
    found = decode_content("engine.images.exr:read_exr_channels", path, content)
    attributes = found.pop("attributes")
    record = _record(attributes.get(RECORD), path)
    shape = tuple(record.shape)
    rows, columns = _image(shape)
    channels: dict[str, Any] = {name: found.get(f"channel:{name}") for name in _PLANES}
    for name, plane in channels.items():
        if plane is None or plane.dtype != np.float32 or plane.shape != (rows, columns):
            raise InputError(path, f"has no channel {name} of {columns} × {rows} floats, as its table needs", _REMEDY)
    if _fingerprint(attributes[RECORD], channels) != attributes.get(FINGERPRINT):
        raise InputError(path, "is damaged: its fingerprint does not fit its content", AGAIN)
    missing = channels["missing"].reshape(shape) != 0.0
    values = np.stack([channels[name] for name in "RGB"], axis=-1).reshape(*shape, 3)
    try:
        return _table(record, values, missing)
    except (ValueError, TypeError) as error:
        raise InputError(path, f"holds a table that cannot be: {error}", _REMEDY) from None


def _record(text: object, path: str | os.PathLike[str]) -> _Record:
    if not isinstance(text, str):
        raise InputError(path, f"is an OpenEXR image without the attribute {RECORD}", _REMEDY)
    try:
        record = _Record.model_validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(map(str, first["loc"]))[:60]
        raise InputError(path, f"has a faulty attribute {RECORD}: {place} {first['msg'][:100]}", _REMEDY) from None
    wanted = 3 if record.layout == "half-difference" else 4
    if len(record.shape) != wanted or np.prod(record.shape, dtype=np.float64) > _MAX_ENTRIES:
        raise InputError(path, f"states an impossible table of {record.shape} entries", _REMEDY)
    if len(record.grids) != (0 if wanted == 3 else 4):
        raise InputError(path, f"states {len(record.grids)} grids for a table in {record.layout}", _REMEDY)
    return record


def _table(record: _Record, values: NDArray[np.float32], missing: NDArray[np.bool_]) -> Table:
    if record.missing != missing.sum():
        raise ValueError(f"{record.missing} entries are said to be missing, but {missing.sum()} are marked")
    words: dict[str, Any] = {"name": record.name, "kind": record.kind, "health": record.health.restored()}
    if record.layout == "half-difference":
        return HalfDifferenceTable(values, missing, **words)
    theta_i, phi_i, theta_o, phi_o = (np.array(grid, np.float64) for grid in record.grids)
    return DirectionTable(theta_i, phi_i, theta_o, phi_o, values, missing, **words)


def _image(shape: tuple[int, ...]) -> tuple[int, int]:
    """Rows and columns of the image that holds a table of `shape`."""
    return shape[0] * shape[1], int(np.prod(shape[2:]))


def _fingerprint(record: str, channels: dict[str, Any]) -> str:
    digest = hashlib.sha256(record.encode())
    for name in _PLANES:
        digest.update(np.ascontiguousarray(channels[name], "<f4").data)
    return digest.hexdigest()

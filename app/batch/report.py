"""The report of a batch: one page that opens without a network, and the same rows as CSV and JSON.

Names, metadata and messages come from anybody: the page escapes all of them, runs no script but its own (by the hash
in its policy) and loads nothing; cells of the CSV that a spreadsheet would compute begin with an apostrophe.
"""

from __future__ import annotations

import base64
import csv
import hashlib
import html
import io
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from string import Template
from typing import Any
from urllib.parse import quote

from app.batch.record import STATES, Row
from app.project.project_file import data_folder
from engine.core.errors import InputError
from engine.core.escape import escape_controls
from engine.core.figure_text import number, time_text
from engine.storage.atomic import write_bytes
from engine.storage.untrusted import read_bytes

#: The files, in the folder of the results.
PAGE, CSV, JSON = "report.html", "report.csv", "report.json"

#: Captures up to which the page holds their images; beyond that it names the files.
MAX_IMAGES = 2000

_RESOURCES = Path(__file__).resolve().parents[2] / "resources" / "batch"
_IMAGE_LIMIT_BYTES = 1 << 20

#: Columns of the page behind the image: words, kind of values, and those that sort it.
_COLUMNS = (
    ("Capture", "text"),
    ("State", "text"),
    ("Warnings", "text"),
    ("Held-out error", "number"),
    ("ΔE2000", "number"),
    ("Photographs", "number"),
    ("Time", "number"),
)

#: Figures of a record in CSV and JSON.
FIGURES = (
    *("photographs", "width_px", "height_px", "representation", "verdict", "held_out_rmse_srgb8"),
    *("mean_picture_rmse_srgb8", "delta_e", "alignment_residual_px"),
)


def write_report(folder: Path, rows: Sequence[Row]) -> None:
    """Write page, CSV and JSON of all captures into the folder of their results; OutputError where that cannot be."""
    described = [describe(row) for row in rows]
    summary = {"lightarc_batch": 1, **summarise(rows), "captures": described}
    text = json.dumps(summary, indent=1, allow_nan=False)
    write_bytes(folder / JSON, text.encode())
    write_bytes(folder / CSV, _table(described).encode("utf-8-sig", "backslashreplace"))
    write_bytes(folder / PAGE, _page(folder, rows, summary).encode("utf-8", "backslashreplace"))


def summarise(rows: Sequence[Row]) -> dict[str, Any]:
    """Numbers of captures by state, and the seconds that those that are done took together."""
    count = Counter(row.state for row in rows)
    return {**{state: count[state] for state in STATES}, "seconds": sum(row.seconds or 0.0 for row in rows)}


def describe(row: Row) -> dict[str, Any]:
    """A capture as the JSON report tells of it; paths are relative to the folder of the results."""
    own, record = row.capture.name, row.record
    files = {name: f"{own}/{record[name]}" for name in ("project", "page", "maps") if record.get(name)}
    return {
        "name": own,
        "path": escape_controls(str(row.capture.place)),
        "state": row.state,
        "reason": row.reason,
        "warnings": list(record.get("warnings", ())),
        **{name: record.get(name) for name in FIGURES},
        "rmse_rel": record.get("rmse_rel", {}),
        "seconds": row.seconds,
        "options": dict(row.capture.options),
        "metadata": dict(row.capture.metadata),
        "folder": own if row.state == "done" else None,
        "files": files,
        "log": f"logs/{own}.log" if row.state in ("done", "failed") else None,
    }


def _table(described: Sequence[Mapping[str, Any]]) -> str:
    """The rows as CSV: a column for each figure and for each kind of metadata."""
    more = list(dict.fromkeys(name for each in described for name in each["metadata"]))
    columns = ("name", "path", "state", "reason", *FIGURES, "seconds", "warnings")
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow([*map(_cell, columns), *map(_cell, more)])
    for each in described:
        values = [each[name] if name != "warnings" else "; ".join(each[name]) for name in columns]
        writer.writerow([*map(_cell, values), *(_cell(each["metadata"].get(name, "")) for name in more)])
    return text.getvalue()


def _cell(value: object) -> object:
    """A value for a cell; text that a spreadsheet would take for a formula does not begin as one."""
    if not isinstance(value, str):
        return value
    text = escape_controls(value)
    return f"'{text}" if text.startswith(("=", "+", "-", "@")) else text


def _page(folder: Path, rows: Sequence[Row], summary: Mapping[str, Any]) -> str:
    script = (_RESOURCES / "report.js").read_text(encoding="utf-8")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    heads = "".join(
        f'<th scope="col" aria-sort="none" data-kind="{kind}"{_number_class(kind)}><button>{words}</button></th>'
        for words, kind in _COLUMNS
    )
    counts = ", ".join(f"{summary[state]} {state}" for state in STATES if summary[state])
    total = sum(summary[state] for state in STATES)
    embeds = len(rows) <= MAX_IMAGES
    values = {
        "title": f"Batch {_escape(folder.name)}",
        "summary": f"{total} captures: {counts}. {time_text(summary['seconds'])} of work. "
        "Errors are those of photographs that were left out, in 8-bit levels.",
        "states": "".join(f"<option>{state}</option>" for state in STATES),
        "heads": heads,
        "rows": "\n".join(_row(folder, row, embeds=embeds) for row in rows),
        "script": script,
        "script_hash": f"sha256-{digest}",
    }
    return Template((_RESOURCES / "report.html").read_text(encoding="utf-8")).substitute(values)


def _number_class(kind: str) -> str:
    return ' class="number"' if kind == "number" else ""


def _row(folder: Path, row: Row, *, embeds: bool) -> str:
    said, own = describe(row), row.capture.name
    verdict = said["verdict"] or ""
    tone = row.state if row.state == "failed" else verdict if row.state == "done" else ""
    state = f"{row.state}: {verdict}" if row.state == "done" and verdict in ("warning", "bad") else row.state
    words = [said["reason"], *said["warnings"]]
    about = [f"{key}: {value}" for key, value in (*row.capture.metadata.items(), *row.capture.options.items())]
    links = [(f"{own}/{row.record[name]}", name) for name in ("project", "page", "maps") if row.record.get(name)]
    links += [(said["log"], "log")] if said["log"] else []
    small = "".join(f"<small>{_escape(each)}</small>" for each in about)
    cells = (
        f"<td>{_image(folder, row, embeds=embeds)}</td>",
        f'<td class="name" data-key="{_escape(own)}">{_escape(own)}{small}</td>',
        f'<td class="state {tone}" data-key="{_escape(state)}">{_escape(state)}</td>',
        f'<td class="words" data-key="{len(said["warnings"]) or ""}">'
        + "".join(f"<p>{_escape(each)}</p>" for each in words if each)
        + "</td>",
        *(_figure(said[name]) for name in ("held_out_rmse_srgb8", "delta_e", "photographs")),
        _figure(row.seconds, time_text(row.seconds) if row.seconds is not None else ""),
        "<td>" + "".join(f'<a href="{_escape(_address(path))}">{name}</a>' for path, name in links) + "</td>",
    )
    return f'<tr data-state="{row.state}">{"".join(cells)}</tr>'


def _figure(value: float | None, text: str | None = None) -> str:
    if value is None:
        return '<td class="number" data-key=""></td>'
    return f'<td class="number" data-key="{value!r}">{_escape(text if text is not None else number(value, 3))}</td>'


def _image(folder: Path, row: Row, *, embeds: bool) -> str:
    if row.state != "done" or not row.record.get("project"):
        return ""
    path = data_folder(folder / row.capture.name / Path(row.record["project"]).name) / "thumbnail.png"
    if not embeds:
        return f'<img alt="" loading="lazy" src="{_escape(_address(path.relative_to(folder.absolute()).as_posix()))}">'
    try:
        content = read_bytes(path, _IMAGE_LIMIT_BYTES)
    except InputError:
        return ""
    return f'<img alt="" src="data:image/png;base64,{base64.b64encode(content).decode()}">'


def _address(path: str) -> str:
    """A relative path as an address within the page."""
    return "./" + quote(path, errors="surrogateescape")


def _escape(text: str) -> str:
    return html.escape(escape_controls(text))

"""A correction of colours in files: `.chart` for later captures under the same lamps, `.html` as a report.

`.chart` is JSON, as stacks and bundles keep it, and is read in the decoder child (`engine.storage.untrusted`). Quality
is graded by the guides of the field, whose tolerances are those for ΔE2000:

- FADGI, Technical Guidelines for Digitizing Cultural Heritage Materials, third edition of 2023 (bound and general
  collections): mean and 90th percentile;
- Metamorfoze Preservation Imaging Guidelines 2.0 (draft of 2023): mean and largest, measured there on a
  ColorChecker SG with a measured reference.
"""

from __future__ import annotations

import base64
import html
import json
import os
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from engine.capture.chart.correction import ColourCorrection, Form
from engine.capture.chart.reference import NAMES, REFERENCE_RGB
from engine.core.colour import to_display8
from engine.core.errors import InputError, UsageError
from engine.core.figure_text import number, percent
from engine.storage.atomic import write_bytes
from engine.storage.text import utf8
from engine.storage.untrusted import decode_in_child

#: Endings of files that a correction can be written to.
WRITTEN = (".chart", ".html")

_LIMIT_BYTES = 1 << 20

#: Levels of each guide from the best, with the largest mean and 90th percentile, or mean and largest difference.
FADGI = (("4 stars", 2.0, 4.0), ("3 stars", 3.5, 7.0), ("2 stars", 5.0, 10.0), ("1 star", 6.5, np.inf))
METAMORFOZE = (("Full", 3.0, 7.0), ("Light", 4.0, 14.0))

_FADGI_SOURCE = "FADGI Technical Guidelines, 3rd edition, 2023: mean and 90th percentile of ΔE2000"
_METAMORFOZE_SOURCE = "Metamorfoze Preservation Imaging Guidelines 2.0, draft of 2023: mean and largest ΔE2000"

_PNG = b"\x89PNG\r\n\x1a\n"

_Colour = tuple[float, float, float]


class _Patch(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    name: str = Field(max_length=40)
    before: float | None = Field(ge=0, le=1000)
    after: float | None = Field(ge=0, le=1000)
    measured: _Colour | None
    corrected: _Colour | None
    crop: str | None = Field(None, max_length=32_768)

    @field_validator("crop")
    @classmethod
    def _is_png(cls, crop: str | None) -> str | None:
        if crop is not None and not base64.b64decode(crop, validate=True).startswith(_PNG):
            raise ValueError("an image of a patch is no PNG")
        return crop


class _File(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    lightarc_chart: Literal[1]
    photograph: str = Field(max_length=4096)
    form: Form
    matrix: list[list[float]] = Field(min_length=3, max_length=3)
    held_out: float = Field(ge=0, le=1000)
    unevenness: float = Field(ge=0, le=1e6)
    summary: dict[str, Any]
    patches: list[_Patch] = Field(min_length=24, max_length=24)

    @model_validator(mode="after")
    def _consistent(self) -> _File:
        width = 6 if self.form == "root-polynomial" else 3
        if any(len(row) != width or max(map(abs, row)) > 1e4 for row in self.matrix):
            raise ValueError("the matrix does not belong to the form")
        return self


def as_json(correction: ColourCorrection, photograph: str) -> dict[str, Any]:
    """The correction as JSON values; `photograph` is the name of the file that shows the chart."""
    patches = [
        {
            "name": name,
            "before": _as_number(correction.before[at]),
            "after": _as_number(correction.after[at]),
            "measured": _colour(correction.measured[at]),
            "corrected": _colour(correction.corrected[at]),
            "crop": base64.b64encode(correction.crops[at]).decode() if correction.crops else None,
        }
        for at, name in enumerate(NAMES)
    ]
    return {
        "lightarc_chart": 1,
        "photograph": photograph,
        "form": correction.form,
        "matrix": [[float(value) for value in row] for row in correction.matrix],
        "held_out": correction.held_out,
        "unevenness": correction.unevenness,
        "summary": summary(correction),
        "patches": patches,
    }


def summary(correction: ColourCorrection) -> dict[str, Any]:
    """Mean, 90th percentile and largest difference before and after, and the grade of each guide (None: below all)."""
    found: dict[str, Any] = {}
    for name, values in (("before", correction.before), ("after", correction.after)):
        known = values[np.isfinite(values)]
        figures = {"mean": known.mean(), "percentile_90": np.quantile(known, 0.9), "largest": known.max()}
        found[name] = {key: float(value) for key, value in figures.items()}
    after = found["after"]
    guides = (
        ("FADGI", FADGI, after["percentile_90"], _FADGI_SOURCE),
        ("Metamorfoze", METAMORFOZE, after["largest"], _METAMORFOZE_SOURCE),
    )
    found["grades"] = [
        {
            "guide": guide,
            "grade": next((level for level, mean, most in levels if after["mean"] <= mean and worst <= most), None),
            "source": source,
        }
        for guide, levels, worst, source in guides
    ]
    return found


def text_of(record: dict[str, Any]) -> str:
    """One sentence about a correction as `as_json` gives it."""
    before, after = record["summary"]["before"], record["summary"]["after"]
    form = {"white": "white balance", "matrix": "3 × 3 matrix", "root-polynomial": "root polynomials"}[record["form"]]
    grades = ", ".join(f"{each['guide']} {each['grade'] or 'below all levels'}" for each in record["summary"]["grades"])
    return (
        f"Colours were corrected by the chart in {record['photograph']} ({form}): ΔE2000 of its patches "
        f"{number(before['mean'])} → {number(after['mean'])} in the mean, {number(before['largest'])} → "
        f"{number(after['largest'])} at most, {number(record['held_out'])} on held-out patches; {grades}"
    )


def save_chart(path: str | os.PathLike[str], record: dict[str, Any]) -> None:
    """Write a correction, as `as_json` gives it, to a `.chart` or `.html` file.

    Raises UsageError for another ending, OutputError where the file cannot be written.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in WRITTEN:
        raise UsageError(f"a chart is written to {' or '.join(WRITTEN)}, not to {suffix or 'a file without an ending'}")
    text = _page(record) if suffix == ".html" else json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False)
    write_bytes(Path(path), (text + "\n").encode())


def read_chart(path: Path) -> tuple[ColourCorrection, str]:
    """The correction of a `.chart` file and the name of its photograph; InputError for anything else."""
    decoder, process = "engine.capture.chart.file:decode_chart", "engine.capture.photograph.decode"
    record = decode_in_child(decoder, path, limit_bytes=_LIMIT_BYTES, process=process)["record"]
    patches = record["patches"]
    before, after = (
        np.array([np.nan if each[key] is None else each[key] for each in patches], np.float64)
        for key in ("before", "after")
    )
    measured, corrected = (
        np.array([each[key] or [np.nan] * 3 for each in patches], np.float64) for key in ("measured", "corrected")
    )
    matrix = np.array(record["matrix"], np.float64)
    held_out, unevenness = record["held_out"], record["unevenness"]
    images = [each["crop"] for each in patches]
    crops = tuple(map(base64.b64decode, images)) if all(images) else ()
    form = record["form"]
    correction = ColourCorrection(form, matrix, before, after, held_out, measured, corrected, unevenness, crops)
    return correction, record["photograph"]


def decode_chart(content: bytes, name: str) -> dict[str, Any]:
    """The decoder: the checked `record`."""
    try:
        record = _File.model_validate_json(utf8(content))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(str(part + 1) if isinstance(part, int) else part for part in first["loc"])
        problem = f"does not hold a chart as Lightarc writes it: {where + ': ' if where else ''}{first['msg'][:200]}"
        raise InputError(name, problem, "Write it again with --write-chart") from None
    if not any(patch.after is not None for patch in record.patches):
        raise InputError(name, "holds a chart without a patch", "Write it again with --write-chart")
    return {"record": record.model_dump(mode="json")}


def _as_number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _colour(colour: Any) -> list[float] | None:
    return [float(value) for value in colour] if np.isfinite(colour).all() else None


def _page(record: dict[str, Any]) -> str:
    """The report, with every patch as photographed, measured, corrected and published."""
    rows = []
    for patch, reference in zip(record["patches"], REFERENCE_RGB, strict=True):
        cells = "".join(_swatch(each) for each in (patch["measured"], patch["corrected"], reference))
        figures = "".join(
            f"<td>{number(patch[key]) if patch[key] is not None else 'clipped'}</td>" for key in ("before", "after")
        )
        crop = patch.get("crop")
        image = f'<img alt="" width="48" height="48" src="data:image/png;base64,{crop}">' if crop else ""
        rows.append(f"<tr><th>{patch['name']}</th><td>{image}</td>{cells}{figures}</tr>")
    grades = "".join(
        f"<li>{each['guide']}: <b>{each['grade'] or 'below all levels'}</b> ({html.escape(each['source'])})</li>"
        for each in record["summary"]["grades"]
    )
    title = f"Colour chart in {html.escape(record['photograph'])}"
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title><style>
body {{ font: 15px/1.5 system-ui, sans-serif; max-width: 46rem; margin: 2rem auto; padding: 0 1rem; color: #222 }}
table {{ border-collapse: collapse }} th, td {{ padding: .2rem .7rem; text-align: right }} th {{ text-align: left }}
td {{ min-width: 4rem }} img {{ display: block }}
</style></head><body><h1>{title}</h1><p>{html.escape(text_of(record))}.</p><ul>{grades}</ul>
<p>The light on the chart differs by {percent(record["unevenness"])}, which is evened out. References are those that
X-Rite publishes for charts made since the end of 2014 (L*a*b* under D50).</p>
<table>
<tr><th>Patch</th><th>Photograph</th><th>Measured</th><th>Corrected</th><th>Published</th>
<th>ΔE2000 before</th><th>after</th></tr>
{chr(10).join(rows)}
</table></body></html>"""


def _swatch(colour: Any) -> str:
    if colour is None:
        return "<td></td>"
    red, green, blue = to_display8(np.array([[colour]]))[0, 0]
    return f'<td style="background-color: rgb({red}, {green}, {blue})"></td>'

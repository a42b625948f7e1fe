"""Figures as folders: the contact sheet, plots, the radiance of every image, and all numbers as CSV and JSON.

A folder appears complete or not at all, and replaces an earlier one of its name.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from engine.core.steps import Step, Steps, part
from engine.figures.figure import Figure, Shown, file_name, records, sheet_of
from engine.figures.plot import save
from engine.images.encode import encode_exr, encode_png, rgb_channels
from engine.storage.atomic import atomic_folder, make_folder, write_bytes, write_json

#: By this file a folder is known as ours.
MARKER = "figure.json"


def draw_into(folder: Path, name: str, steps: Steps[Figure]) -> Steps[dict[str, Any]]:
    """Draw the figure `steps` into `folder` / `name`; what its `figure.json` holds.

    OutputError at once where that folder cannot be written or is not ours; closing the generator leaves all as it was.
    """
    make_folder(folder)
    with atomic_folder(folder / name, MARKER) as making:
        figure = yield from part(steps, 0.0, 0.98)
        yield Step(0.98, "writing")
        record = _record(figure)
        write_bytes(making / record["picture"], encode_png(sheet_of(figure)))
        for plot in figure.plots:
            save(figure.plots[plot], making / f"{plot}.png")
        write_bytes(making / "pictures.csv", csv_of([_flat(image) for image in record["pictures"]]))
        if figure.table:
            write_bytes(making / "curves.csv", csv_of(figure.table))
        radiance = make_folder(making / "radiance")
        for number, row in enumerate(figure.rows):
            for column, shown in enumerate(row.images):
                write_bytes(radiance / file_name(number, column, shown), _exr(shown))
        write_json(making / MARKER, record)
    return record


def _record(figure: Figure) -> dict[str, Any]:
    return {
        "name": figure.name,
        "title": figure.title,
        "shows": figure.subtitle,
        "picture": f"{figure.name}.png",
        "plots": [f"{name}{suffix}" for name in figure.plots for suffix in (".png", ".svg")],
        "pictures": records(figure),
    }


def csv_of(table: Sequence[Mapping[str, Any]]) -> bytes:
    """Rows of equal keys as CSV; a key that a row lacks is empty there."""
    stream = io.StringIO(newline="")
    names = list(dict.fromkeys(name for row in table for name in row))
    writer = csv.DictWriter(stream, names, lineterminator="\n")
    writer.writeheader()
    writer.writerows(table)
    return stream.getvalue().encode("utf-8")


def _flat(image: Mapping[str, Any]) -> dict[str, Any]:
    """A record with each parameter in a column of its own."""
    return {**{name: value for name, value in image.items() if name != "knobs"}, **image["knobs"]}


def _exr(shown: Shown) -> bytes:
    """Radiance and coverage, and the standard error where it is a reference, in full precision."""
    channels = rgb_channels(shown.image[..., :3]) | {"A": shown.image[..., 3]}
    if shown.variance is not None:
        channels |= rgb_channels(np.sqrt(shown.variance).astype(np.float32), "standard_error")
    return encode_exr(channels, half=False)

"""The contact sheet of a comparison: where a representation is worst, and what all others show there.

A place is a square neighbourhood in one photograph. Each representation shows it as it is made of the other
photographs, above the signed difference in codes of 8-bit sRGB, where mid-grey is none.
Cost: places are found on a grid of `ACROSS` texels to a neighbourhood, which takes a decomposition for each photograph.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.capture.stack import ImageStack
from engine.core.figure_text import number
from engine.core.steps import Step, Steps
from engine.figures.contact_sheet import Panel, Row, draw_sheet
from engine.shading.compare import Candidate
from engine.shading.directional.left_out import Predict, Texels

#: Places that are shown, neighbourhoods along the shorter side of an image, and texels of the grid along one of them.
PLACES, ALONG, ACROSS = 5, 10, 8


@dataclass(frozen=True)
class Place:
    """A neighbourhood: the photograph's place in the list, first row and column, and its edge in texels."""

    photograph: int
    row: int
    column: int
    edge: int


@dataclass(frozen=True, eq=False)
class Seen:
    """A place with its photograph (edge, edge, 3) in codes, and what each representation shows, by name."""

    heading: str
    record: dict[str, Any]
    wanted: NDArray[np.float32]
    shown: dict[str, NDArray[np.float64]]


def worst_places(stack: ImageStack, used: NDArray[np.int64], predict: Predict) -> Steps[list[Place]]:
    """Places at which `predict` is farthest from the photographs `used`, no two in one photograph or beside another."""
    height, width = stack.radiance.shape[1:3]
    edge = max(1, min(height, width) // ALONG)
    step = max(1, edge // ACROSS)
    across = min(max(1, edge // step), len(range(0, height, step)), len(range(0, width, step)))
    grid = _texels(stack, used, slice(0, height, step), slice(0, width, step))
    shape = (len(range(0, height, step)), len(range(0, width, step)))
    squares = np.empty((len(used), shape[0] - across + 1, shape[1] - across + 1))
    for out in range(len(used)):
        yield Step(out / len(used), "finding the worst places")
        apart = predict(grid, out) - grid.codes[out]
        one = (apart**2).mean(axis=1).reshape(shape)
        squares[out] = np.lib.stride_tricks.sliding_window_view(one, (across, across)).mean(axis=(2, 3))
    found: list[Place] = []
    for _ in range(PLACES):
        out, row, column = (int(each) for each in np.unravel_index(int(squares.argmax()), squares.shape))
        if not squares[out, row, column] > 0.0:
            break
        # Texels of the last cell of the grid may be fewer than `step`.
        found.append(Place(out, min(row * step, height - edge), min(column * step, width - edge), edge))
        squares[out] = 0.0
        near = np.s_[:, max(0, row - across + 1) : row + across, max(0, column - across + 1) : column + across]
        squares[near] = 0.0
    return found


def select_seen_places(
    stack: ImageStack, used: NDArray[np.int64], candidates: Sequence[Candidate], places: Sequence[Place]
) -> Steps[list[Seen]]:
    """The `places` as all `candidates` show them."""
    found = []
    for at, place in enumerate(places):
        yield Step(at / len(places), "looking at the worst places")
        rows, columns = slice(place.row, place.row + place.edge), slice(place.column, place.column + place.edge)
        texels = _texels(stack, used, rows, columns)
        wanted, shown, errors = texels.codes[place.photograph], {}, {}
        for each in candidates:
            codes = np.clip(each.predict(texels, place.photograph), 0.0, 255.0)
            errors[each.name] = float(np.sqrt(np.mean((codes - wanted) ** 2)))
            shown[each.name] = codes.reshape(place.edge, place.edge, 3)
        photograph = int(used[place.photograph])
        light = f"{number(float(stack.elevation_deg[photograph]))}° up"
        if stack.azimuth is not None:
            light += f", {number(float(np.degrees(stack.azimuth[photograph])) % 360.0)}° round"
        where = f"columns {place.column} to {columns.stop - 1}, rows {place.row} to {rows.stop - 1}"
        record = {
            "photograph": stack.sources[photograph],
            **{"row": place.row, "column": place.column, "edge_px": place.edge, "rmse_srgb8": errors},
        }
        heading = f"{stack.sources[photograph]}: light {light}; {where}"
        found.append(Seen(heading, record, wanted.reshape(place.edge, place.edge, 3), shown))
    return found


def worst_sheet(seen: Sequence[Seen], worst_of: str) -> NDArray[np.uint8]:
    """(H, W, 3) the sheet of places at which the representation `worst_of` is farthest off."""
    rows = []
    for each in seen:
        errors = each.record["rmse_srgb8"]
        images = [Panel(_show(codes), name) for name, codes in each.shown.items()]
        rows.append(Row(each.heading, (Panel(_show(each.wanted), "photograph"), *images)))
        apart = [
            Panel(_show(127.5 + 0.5 * (codes - each.wanted)), f"{number(errors[name])} codes")
            for name, codes in each.shown.items()
        ]
        rows.append(Row("", (Panel(None, "minus the photograph: mid-grey is none"), *apart)))
    return draw_sheet(
        f"Where {worst_of} is worst",
        "Each representation is made of the other photographs. Errors are root mean squares in 8-bit levels of sRGB.",
        rows,
    )


def _show(codes: NDArray[np.floating]) -> NDArray[np.uint8]:
    return np.asarray(np.rint(np.clip(codes, 0.0, 255.0)), np.uint8)


def _texels(stack: ImageStack, used: NDArray[np.int64], rows: slice, columns: slice) -> Texels:
    """Every texel of the rows and columns, of which alone are read."""
    height, width = stack.radiance.shape[1:3]
    lines, across = range(height)[rows], np.arange(width)[columns]
    radiance = np.empty((len(used), len(lines), len(across), 3), np.float32)
    usable = np.empty(radiance.shape[:3], np.bool_)
    diffuse = None if stack.diffuse is None else np.empty_like(radiance)
    for place, photograph in enumerate(used):
        radiance[place] = stack.radiance[int(photograph), rows, columns]
        if diffuse is not None and stack.diffuse is not None:
            diffuse[place] = stack.diffuse[int(photograph), rows, columns]
        usable[place] = ~np.asarray(stack.saturated[int(photograph), rows, columns])
    row, column = np.meshgrid(np.array(lines), across, indexing="ij")
    count = len(used)
    parts = None if diffuse is None else diffuse.reshape(count, -1, 3)
    return Texels(radiance.reshape(count, -1, 3), usable.reshape(count, -1), row.ravel(), column.ravel(), parts)

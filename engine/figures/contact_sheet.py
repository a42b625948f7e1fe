"""The contact sheet: one image that shows what became of a capture, row by row, for users to look at.

A `Panel` is an image with a caption, a `Row` a heading over panels of equal width that fill the sheet. Text is set
in the typeface that OpenCV carries, so the sheet looks the same on every machine.
Cost: some 50 ms for a sheet of five megapixels. With matplotlib it is 460 ms, and 410 ms more for loading it.

Images about a material for users: where its compression is off, and how it looks when it repeats.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.colour import luminance, to_display8
from engine.shading.power_law import PowerLawMap
from engine.shading.power_law_error import Texel

Image = NDArray[np.uint8]
Grey = tuple[int, int, int]

WIDTH, MARGIN, GAP = 2000, 48, 16
GROUND, FIELD, LINE = (24, 24, 24), (36, 36, 36), (64, 64, 64)
TEXT, QUIET, ACCENT = (222, 222, 222), (150, 150, 150), (110, 170, 245)


@dataclass(frozen=True, eq=False)
class Panel:
    """An (H, W, 3) uint8 image, or None and a `caption` that says why there is none."""

    image: Image | None
    caption: str


@dataclass(frozen=True, eq=False)
class Row:
    """Panels side by side, each `aspect` times as wide as high."""

    heading: str
    panels: tuple[Panel, ...]
    aspect: float = 1.0


def draw_sheet(title: str, subtitle: str, rows: Sequence[Row]) -> Image:
    """(H, WIDTH, 3) uint8 image of all rows."""
    lines = _break_lines(subtitle, (WIDTH - 2 * MARGIN) // 11)
    head = _blank(114 + 26 * len(lines))
    _text(head, title, MARGIN, 74, 40, TEXT, 500)
    for index, line in enumerate(lines):
        _text(head, line, MARGIN, 106 + 26 * index, 19, QUIET)
    return np.vstack([head, *(_draw_row(row) for row in rows), _blank(MARGIN - GAP)])


def with_colour_bar(values: ArrayLike, label: str, size: int, top: float | None = None) -> Image:
    """(size, size, 3) image of an (H, W) map in viridis from 0 to `top`, with a bar that says what colours mean."""
    values = np.nan_to_num(np.asarray(values, np.float64))
    top = top or float(np.percentile(values, 99.5)) or 1.0
    image = _blank(size, size, FIELD)
    edge = size - 92
    x, y = (size - edge) // 2, 14
    scaled = cv2.resize(values.astype(np.float32), (edge, edge), interpolation=cv2.INTER_AREA)
    image[y : y + edge, x : x + edge] = _viridis(scaled / top)
    bar = y + edge + 14
    image[bar : bar + 12, x : x + edge] = _viridis(np.linspace(0, 1, edge)[None, :])
    _text(image, "0", x, bar + 40, 17, QUIET)
    _text(image, f"{top:.3g}", x + edge, bar + 40, 17, QUIET, align=1.0)
    _text(image, label, size // 2, bar + 40, 17, TEXT, align=0.5)
    return image


def draw_error_map(values: ArrayLike, label: str, caption: str, rings: Sequence[tuple[int, int]] = ()) -> Image:
    """An (H, W) map in viridis from 0 to its largest value, with a colour bar, a caption, and numbered `rings`.

    `rings` are (row, column) of texels. The image is as large as the map, but at least 512 and at most 1536 pixels
    along its longer side, beside the margins.
    """
    field = np.asarray(values, np.float64)
    top = float(field.max()) or 1.0
    height, width = field.shape
    scale = np.clip(max(height, width), 512, 1536) / max(height, width)
    columns, rows = max(320, round(width * scale)), round(height * scale)
    image = _blank(rows + 152, columns + 2 * GAP)
    method = cv2.INTER_AREA if scale < 1 else cv2.INTER_NEAREST
    across = round(width * scale)
    image[GAP : GAP + rows, GAP : GAP + across] = _viridis(
        cv2.resize((field / top).astype(np.float32), (across, rows), interpolation=method)
    )
    for number, (row, column) in enumerate(rings, 1):
        x, y = GAP + round((column + 0.5) * scale), GAP + round((row + 0.5) * scale)
        cv2.circle(image, (x, y), 9, TEXT, 1, cv2.LINE_AA)
        _text(image, f"{number}", min(x + 12, GAP + columns - 20), max(y - 6, 20), 15, TEXT)
    bar = rows + 2 * GAP
    image[bar : bar + 14, GAP : GAP + columns] = _viridis(np.linspace(0, 1, columns)[None, :])
    for share in (0.0, 0.5, 1.0):
        _text(image, f"{share * top:.3g}", GAP + round(share * columns), bar + 38, 16, QUIET, align=share)
    _text(image, label, GAP + columns // 2, bar + 66, 16, TEXT, align=0.5)
    _text(image, caption, GAP + columns // 2, bar + 92, 15, QUIET, align=0.5)
    return image


def plot(x: ArrayLike, y: ArrayLike, x_label: str, y_label: str, size: int) -> Image:
    """(size, size, 3) image of points joined by lines, both axes from 0 with their units."""
    horizontal, vertical = np.asarray(x, np.float64), np.asarray(y, np.float64)
    image = _blank(size, size, FIELD)
    left, right, top, bottom = 74, size - 26, 30, size - 76
    x_ticks, y_ticks = _ticks(float(horizontal.max())), _ticks(float(vertical.max()))

    def place(a: float, b: float) -> tuple[int, int]:
        return round(left + (right - left) * a / x_ticks[-1]), round(bottom - (bottom - top) * b / y_ticks[-1])

    for tick in x_ticks:
        cv2.line(image, place(tick, 0), place(tick, y_ticks[-1]), LINE, 1)
        _text(image, f"{tick:g}", place(tick, 0)[0], bottom + 26, 17, QUIET, align=0.5)
    for tick in y_ticks:
        cv2.line(image, place(0, tick), place(x_ticks[-1], tick), LINE, 1)
        _text(image, f"{tick:g}", left - 10, place(0, tick)[1] + 6, 17, QUIET, align=1.0)
    points = [place(a, b) for a, b in zip(horizontal, vertical, strict=True)]
    cv2.polylines(image, [np.array(points, np.int32)], False, ACCENT, 2, cv2.LINE_AA)
    for point in points:
        cv2.circle(image, point, 6, ACCENT, -1, cv2.LINE_AA)
    _text(image, x_label, (left + right) // 2, size - 20, 17, TEXT, align=0.5)
    _text(image, y_label, left, 20, 17, TEXT)
    return image


def panel_width(count: int) -> int:
    """Width in pixels of each of `count` panels of a row."""
    return (WIDTH - 2 * MARGIN - (count - 1) * GAP) // count


def _draw_row(row: Row) -> Image:
    width = panel_width(len(row.panels))
    height = round(width / row.aspect)
    strip = _blank(46 + height + 44)
    _text(strip, row.heading, MARGIN, 30, 22, TEXT, 500)
    for index, panel in enumerate(row.panels):
        x, y = MARGIN + index * (width + GAP), 46
        strip[y : y + height, x : x + width] = _fit(panel, width, height)
        if panel.image is not None:
            _text(strip, panel.caption, x + width // 2, y + height + 26, 18, QUIET, align=0.5)
    return strip


def _fit(panel: Panel, width: int, height: int) -> Image:
    """The image cut to the panel's proportions and resized; a quiet field with the caption where there is none."""
    if panel.image is None:
        field = _blank(height, width, FIELD)
        _wrap(field, panel.caption, width)
        return field
    rows, columns = panel.image.shape[:2]
    scale = max(width / columns, height / rows)
    cut_rows, cut_columns = min(rows, round(height / scale)), min(columns, round(width / scale))
    row, column = (rows - cut_rows) // 2, (columns - cut_columns) // 2
    cut = panel.image[row : row + cut_rows, column : column + cut_columns]
    method = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    return np.asarray(cv2.resize(cut, (width, height), interpolation=method), np.uint8)


def _break_lines(text: str, letters: int) -> list[str]:
    """Lines of some `letters`, at least one."""
    lines = [""]
    for word in text.split():
        if len(lines[-1]) + len(word) > letters:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines


def _wrap(field: Image, text: str, width: int) -> None:
    lines = _break_lines(text, width // 11)
    for index, line in enumerate(lines[:8]):
        _text(field, line, width // 2, field.shape[0] // 2 + 26 * index - 13 * len(lines) + 18, 18, QUIET, align=0.5)


def _viridis(values: ArrayLike) -> Image:
    codes = np.rint(np.clip(np.asarray(values, np.float64), 0, 1) * 255).astype(np.uint8)
    return np.asarray(cv2.applyColorMap(codes, cv2.COLORMAP_VIRIDIS)[..., ::-1], np.uint8)


def _ticks(top: float) -> NDArray[np.float64]:
    """Round numbers from 0 to at least `top`, three to six of them."""
    top = top if top > 0 else 1.0
    unit = 10.0 ** np.floor(np.log10(top / 3))
    step = next(unit * factor for factor in (1, 2, 5, 10) if top / (unit * factor) <= 5)
    return step * np.arange(np.ceil(top / step * (1 - 1e-9)) + 1)


def _blank(height: int, width: int = WIDTH, colour: Grey = GROUND) -> Image:
    return np.full((height, width, 3), colour, np.uint8)


def _text(
    image: Image, text: str, x: int, y: int, size: int, colour: Grey, weight: int = 400, align: float = 0.0
) -> None:
    """Set `text` on the base line y; `align` 0, 0.5 or 1 puts its start, middle or end at x."""
    face = cv2.FontFace("sans")
    width = cv2.getTextSize((0, 0), text, (0, 0), face, size, weight)[2]
    cv2.putText(image, text, (round(x - align * width), y), colour, face, size, weight)


#: Longest side of a tile in its preview, in pixels.
PREVIEW_SIDE = 512

REPEATS = 3


def error_image(power_law: PowerLawMap, worst: Sequence[Texel] = ()) -> Image:
    """The error of each texel relative to r_max in colours, with a bar that explains them and rings around `worst`."""
    relative = power_law.error_map / power_law.r_max
    caption = (
        f"RMS {power_law.rms / power_law.r_max:.4f} of r max over {relative.shape[1]} x {relative.shape[0]} texels"
    )
    return draw_error_map(relative, "error of a texel / r max", caption, [(row, column) for row, column, _ in worst])


def tile_preview(image: NDArray[np.float32]) -> Image:
    """Linear radiance (H, W, 3), 3 x 3 times, in display colours; exposed so that one texel in a hundred is white."""
    image = _reduce(image)
    white = float(np.percentile(luminance(image), 99.0))
    shown = to_display8(np.clip(image / white if white > 0 else image, 0.0, 1.0))
    return np.tile(shown, (REPEATS, REPEATS, 1))


def repeat(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Linear radiance (H, W, 3), reduced to `PREVIEW_SIDE` and 3 x 3 times."""
    return np.tile(_reduce(image), (REPEATS, REPEATS, 1))


def _reduce(image: NDArray[np.float32]) -> NDArray[np.float32]:
    height, width = image.shape[:2]
    share = PREVIEW_SIDE / max(height, width)
    if share >= 1.0:
        return image
    size = (max(1, round(width * share)), max(1, round(height * share)))
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.float32)

"""Plots as files: PNG and SVG as on screen, and CSV of the values with a heading that states their units."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QBuffer, QRectF
from PySide6.QtGui import QImage, QPaintDevice, QPainter
from PySide6.QtSvg import QSvgGenerator

from engine.core.steps import Step, Steps
from engine.storage.atomic import make_folder, write_bytes

if TYPE_CHECKING:
    import pyqtgraph as pg

Floats = NDArray[np.float64]


def svg(plot: pg.PlotWidget) -> bytes:
    """A plot as it is on screen."""
    content, made = QBuffer(), QSvgGenerator()
    content.open(QBuffer.OpenModeFlag.WriteOnly)
    made.setOutputDevice(content)
    made.setSize(plot.size())
    made.setViewBox(plot.rect())
    made.setResolution(plot.logicalDpiX())
    _draw(plot, made)
    return bytes(content.data().data())


def png(plot: pg.PlotWidget, scale: int = 2) -> bytes:
    """A plot as it is on screen, with `scale` pixels for each of the screen along either axis."""
    image = QImage(scale * plot.size(), QImage.Format.Format_RGB32)
    image.setDevicePixelRatio(scale)
    _draw(plot, image)
    content = QBuffer()
    content.open(QBuffer.OpenModeFlag.WriteOnly)
    image.save(content, "PNG")  # type: ignore[call-overload]
    return bytes(content.data().data())


def _draw(plot: pg.PlotWidget, place: QPaintDevice) -> None:
    """Draw a plot at its size on the screen, its markers as shapes and not as the pixels that are kept of them."""
    items = [item for item in plot.scene().items() if hasattr(item, "setExportMode")]
    painter = QPainter(place)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    try:
        for item in items:
            item.setExportMode(True, {"antialias": True})
        plot.render(painter, QRectF(plot.rect()), plot.rect())  # Qt would take the pixels of an image for points
    finally:
        for item in items:
            item.setExportMode(False)
        painter.end()


def rows_of(headings: Sequence[str], lines: Iterable[Sequence[object]]) -> bytes:
    """CSV in UTF-8: the headings, then the lines, with all digits; what is None stays empty."""
    text = io.StringIO()
    rows = csv.writer(text)
    rows.writerow(headings)
    rows.writerows(lines)
    return text.getvalue().encode()


def table(heading: str, x: Floats, columns: Mapping[str, Floats]) -> bytes:
    """CSV in UTF-8: `x` under its heading, then a column (N,) for each name, with all digits."""
    return rows_of((heading, *columns), zip(x.tolist(), *(each.tolist() for each in columns.values()), strict=True))


def grid(values: Floats) -> bytes:
    """CSV of values (N, N), theta_h by column and theta_d by row from 0° up: degrees at the middles of cells."""
    angles = 90.0 * (np.arange(len(values)) + 0.5) / len(values)
    text = io.StringIO()
    rows = csv.writer(text)
    rows.writerow(("theta_d / ° by theta_h / °", *angles.tolist()))
    for angle, row in zip(angles.tolist(), values[::-1].tolist(), strict=True):
        rows.writerow((angle, *row))
    return text.getvalue().encode()


def distinct(names: Sequence[str]) -> list[str]:
    """The same names, with a number behind those that come again."""
    return [
        name if name not in names[:at] else f"{name} ({names[:at].count(name) + 1})" for at, name in enumerate(names)
    ]


def save(folder: Path, files: Mapping[str, bytes]) -> Steps[str]:
    """Write `files` by their names into `folder`; a sentence. Raises OutputError where that cannot be done."""
    yield Step(0.0, "writing")
    make_folder(folder)
    for name, content in files.items():
        write_bytes(folder / name, content)
    return f"{len(files)} files of plots written to {folder}" if len(files) > 1 else f"{next(iter(files))} written"

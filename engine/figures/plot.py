"""Plots that are files: curves with direct labels, and settings of several modes with their front; PNG and SVG.

Figures are made through matplotlib's objects and drawn by its Agg and SVG canvases, never through `pyplot`, so that
they need no window and can be made on any thread. They are dark on light, whatever theme the window has; colours are
told apart by users who see few colours, and differ in lightness and marker as well. Text is set in the typeface that
matplotlib carries, and neither a date nor a random number is written: equal figures are equal files.
Cost: half a second for the first figure of a process (some seconds where matplotlib lists the system's typefaces for
the first time), 0.2 s for each after it.
"""

from __future__ import annotations

import io
import logging
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.storage.atomic import AnyPath, write_bytes


def _without_home() -> None:
    """Let matplotlib keep its list of typefaces where it always does, or for this process alone without a word."""
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    try:
        Path.home()
    except RuntimeError:
        os.environ.setdefault("MPLCONFIGDIR", os.devnull)


_without_home()

import matplotlib  # noqa: E402
from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: E402
from matplotlib.backends.backend_svg import FigureCanvasSVG  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402
from matplotlib.patheffects import withStroke  # noqa: E402
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter  # noqa: E402
from scipy.optimize import isotonic_regression  # noqa: E402

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Colours after Okabe and Ito, some darker or lighter, and their markers, in the order in which plots use them.
COLOURS = ("#0072b2", "#e69f00", "#1f2a44", "#d55e00", "#00664b", "#d488b1", "#8f8f8f")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")

GROUND, INK, QUIET, LINE = "#fbfbfb", "#222222", "#666666", "#dddddd"

#: Pixels of a PNG, and how many of them go to an inch: at 150 the smallest text is 15 pixels high.
WIDTH, HEIGHT, DOTS_PER_INCH = 1200, 800, 150

#: Decades of an axis beyond which only whole ones have numbers.
_MAX_DECADES = 4.5

#: Points of matplotlib: of text, of a line, of a marker.
_TEXT, _SMALL, _WIDE, _MARK = 9.0, 7.5, 1.6, 5.0

matplotlib.rcdefaults()
matplotlib.rcParams.update(
    {
        "font.family": "DejaVu Sans",
        "font.size": _TEXT,
        "text.parse_math": False,
        "svg.hashsalt": "lightarc",
        "axes.unicode_minus": True,
        "path.simplify": False,
    }
)


@dataclass(frozen=True, eq=False)
class Curve:
    """A line through the points `x`, `y` (n,) called `name`; `spread` (n,) is drawn above and below where given."""

    name: str
    x: ArrayLike
    y: ArrayLike
    spread: ArrayLike | None = None


@dataclass(frozen=True)
class Dot:
    """One setting: where it lies, the `group` that gives its colour, and a few words that tell it from others.

    `spread` is drawn above and below y, or a pair of lengths below and above it; `front` means that no other is better
    on both axes, `current` that it is the one in use.
    """

    x: float
    y: float
    group: str
    label: str = ""
    spread: float | tuple[float, float] = 0.0
    front: bool = False
    current: bool = False


def curves(
    lines: Sequence[Curve],
    x_label: str,
    y_label: str,
    *,
    title: str = "",
    note: str = "",
    log_x: bool = False,
    log_y: bool = False,
    y_from_zero: bool = False,
    size: tuple[int, int] = (WIDTH, HEIGHT),
) -> Figure:
    """A plot of `lines`, each named at its right end; labels tell the units. `note` is set small under it.

    What is not finite, or not above 0 on a logarithmic axis, is left out, and the note says how many points that are.
    ValueError for more lines than there are colours.
    """
    _check_count(len(lines))
    figure, axes = _figure(size, title)
    hidden, ends = 0, []
    for index, line in enumerate(lines):
        x, y, spread = _arrays(line)
        shown = _drawable(x, y, log_x, log_y)
        hidden += int(np.sum(~shown))
        style = {"color": COLOURS[index], "marker": MARKERS[index], "markersize": _MARK, "linewidth": _WIDE}
        if spread is None:
            axes.plot(x[shown], y[shown], label=line.name, **style)
        else:
            axes.errorbar(x[shown], y[shown], spread[shown], label=line.name, capsize=2.5, elinewidth=0.9, **style)
        if shown.any():
            last = np.flatnonzero(shown)[np.argmax(x[shown])]
            ends.append((float(x[last]), float(y[last]), line.name, COLOURS[index]))
    _label_axes(axes, x_label, y_label, log_x, log_y)
    if y_from_zero and not log_y:
        axes.set_ylim(bottom=0.0)
    _finish(figure, axes, note, hidden)
    _name_ends(figure, axes, ends)
    return figure


def scatter_front(
    dots: Sequence[Dot],
    x_label: str,
    y_label: str,
    *,
    title: str = "",
    note: str = "",
    log_x: bool = True,
    log_y: bool = True,
    size: tuple[int, int] = (WIDTH, HEIGHT),
) -> Figure:
    """A plot of `dots` coloured by group: filled and joined by steps where they are on the front, hollow elsewhere.

    Labels are set beside dots of the front, and beside others, as far as there is room. What cannot be drawn is left
    out and counted as in `curves`.
    """
    groups = list(dict.fromkeys(dot.group for dot in dots))
    _check_count(len(groups))
    figure, axes = _figure(size, title)
    place = np.array([(dot.x, dot.y) for dot in dots], np.float64).reshape(-1, 2)
    shown = _drawable(place[:, 0], place[:, 1], log_x, log_y)
    _label_axes(axes, x_label, y_label, log_x, log_y)
    front = place[[bool(dot.front and seen) for dot, seen in zip(dots, shown, strict=True)]]
    front = front[np.argsort(front[:, 0], kind="stable")]
    axes.plot(front[:, 0], front[:, 1], color=QUIET, linewidth=1.0, drawstyle="steps-post", zorder=1)
    for index, group in enumerate(groups):
        own = [dot for dot, seen in zip(dots, shown, strict=True) if seen and dot.group == group]
        _draw_group(axes, own, group, COLOURS[index], MARKERS[index])
    if any(groups):
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=len(groups), frameon=False, fontsize=_SMALL)
    across = place[shown, 0]
    if log_x and across.size and not np.ptp(across):  # nothing else says how wide the axis is to be
        axes.set_xlim(0.5 * across[0], 2.0 * across[0])
    _finish(figure, axes, note, int(np.sum(~shown)))
    _name_dots(figure, axes, [dot for dot, seen in zip(dots, shown, strict=True) if seen])
    return figure


def png_of(figure: Figure) -> bytes:
    """The figure as a PNG file of the size that it was made with."""
    stream = io.BytesIO()
    FigureCanvasAgg(figure).print_png(stream, metadata={"Software": None})
    return stream.getvalue()


def svg_of(figure: Figure) -> bytes:
    """The figure as an SVG file, text as outlines."""
    stream = io.BytesIO()
    FigureCanvasSVG(figure).print_svg(stream, metadata={"Date": None, "Creator": None})
    return stream.getvalue()


def save(figure: Figure, path: AnyPath) -> tuple[Path, Path]:
    """Write `figure` beside each other as PNG and SVG; the suffix of `path` is replaced. OutputError as usual."""
    png, svg = Path(path).with_suffix(".png"), Path(path).with_suffix(".svg")
    drawn = png_of(figure), svg_of(figure)
    write_bytes(png, drawn[0])
    write_bytes(svg, drawn[1])
    return png, svg


def _check_count(count: int) -> None:
    if count > len(COLOURS):
        raise ValueError(f"{count} lines or groups are more than the {len(COLOURS)} that can be told apart")


def _arrays(line: Curve) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64] | None]:
    x, y = np.asarray(line.x, np.float64), np.asarray(line.y, np.float64)
    if x.ndim != 1 or x.shape != y.shape:
        raise ValueError(f"a line of {x.shape} by {y.shape} points is none")
    spread = None if line.spread is None else np.nan_to_num(np.broadcast_to(np.asarray(line.spread, float), x.shape))
    return x, y, spread


def _drawable(x: NDArray[np.float64], y: NDArray[np.float64], log_x: bool, log_y: bool) -> NDArray[np.bool_]:
    shown = np.isfinite(x) & np.isfinite(y)
    for values, logarithmic in ((x, log_x), (y, log_y)):
        if logarithmic:
            shown &= np.nan_to_num(values) > 0.0
    return shown


def _figure(size: tuple[int, int], title: str) -> tuple[Figure, Any]:
    figure = Figure(
        figsize=(size[0] / DOTS_PER_INCH, size[1] / DOTS_PER_INCH),
        dpi=DOTS_PER_INCH,
        facecolor=GROUND,
        layout="constrained",
    )
    FigureCanvasAgg(figure)
    if title:
        figure.suptitle(title, x=0.012, ha="left", fontsize=_TEXT + 2.0, color=INK)
    return figure, figure.add_subplot(facecolor=GROUND)


def _label_axes(axes: Axes, x_label: str, y_label: str, log_x: bool, log_y: bool) -> None:
    axes.set_xlabel(x_label, color=INK)
    axes.set_ylabel(y_label, color=INK)
    for axis, logarithmic, set_scale in ((axes.xaxis, log_x, axes.set_xscale), (axes.yaxis, log_y, axes.set_yscale)):
        if logarithmic:
            set_scale("log", nonpositive="clip")
            axis.set_major_locator(_Decades())
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axis.set_minor_formatter(NullFormatter())
    axes.grid(True, which="major", color=LINE, linewidth=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(which="both", length=0, labelsize=_SMALL, labelcolor=QUIET)
    for side in ("top", "right", "left", "bottom"):
        axes.spines[side].set_visible(side in ("left", "bottom"))
        axes.spines[side].set_color(QUIET)


class _Decades(LogLocator):
    """1, 2 and 5 of each decade, and over many decades the first alone, so that numbers do not run into each other."""

    def __init__(self) -> None:
        super().__init__(10.0, (1.0, 2.0, 5.0), numticks=12)

    def tick_values(self, vmin: float, vmax: float) -> Any:
        wide = vmin > 0.0 and vmax > vmin * 10.0**_MAX_DECADES
        self.set_params(subs=(1.0,) if wide else (1.0, 2.0, 5.0))
        return super().tick_values(vmin, vmax)


def _draw_group(axes: Axes, dots: Sequence[Dot], group: str, colour: str, marker: str) -> None:
    for dot in dots:
        below, above = dot.spread if isinstance(dot.spread, tuple) else (dot.spread, dot.spread)
        if above > 0.0 and np.isfinite(above):
            bar = [[below], [above]]
            axes.errorbar([dot.x], [dot.y], bar, fmt="none", ecolor=colour, elinewidth=0.8, capsize=2.0, zorder=2)
        if dot.current:
            axes.plot([dot.x], [dot.y], "o", markersize=3 * _MARK, fillstyle="none", color=INK, linewidth=0, zorder=2)
    for front in (False, True):  # no other hides one of the front
        alike = [dot for dot in dots if dot.front == front]
        places, face = ([dot.x for dot in alike], [dot.y for dot in alike]), colour if front else GROUND
        axes.scatter(*places, s=7.0**2, marker=marker, c=face, edgecolors=colour, linewidths=1.1, zorder=3 + front)
    axes.plot([], [], marker, color=colour, markersize=6.0, label=group)


def _finish(figure: Figure, axes: Axes, note: str, hidden: int) -> None:
    """Margins that keep points off the edges, the note, and then a layout that stays."""
    axes.margins(0.06)
    left_out = {0: "", 1: "1 point cannot be shown."}.get(hidden, f"{hidden} points cannot be shown.")
    words = " ".join(filter(None, (note, left_out)))
    if words:
        figure.text(0.012, 0.012, words, fontsize=_SMALL, color=QUIET, ha="left", va="bottom", wrap=True)
        lines = 1 + words.count("\n")
        _layout(figure).set(rect=(0.005, 0.03 * lines, 0.99, 1.0 - 0.03 * lines))


def _name_ends(figure: Figure, axes: Axes, ends: Sequence[tuple[float, float, str, str]]) -> None:
    """The names of lines right of their last points, moved up or down where they would cover each other."""
    if not ends:
        return
    longest = max(len(name) for *_, name, _ in ends)
    width_px = figure.get_figwidth() * figure.dpi
    left, bottom, width, height = _layout(figure).get()["rect"]
    _layout(figure).set(rect=(left, bottom, max(width - 10.2 * longest / width_px, 0.5), height))
    figure.draw_without_rendering()
    points = [axes.transData.transform((x, y)) * 72.0 / figure.dpi for x, y, *_ in ends]
    heights = _apart(np.array([point[1] for point in points]), _TEXT * 1.25)
    for (x, y, name, colour), point, height in zip(ends, points, heights, strict=True):
        axes.annotate(
            name,
            (x, y),
            xytext=(8.0, float(height - point[1])),
            textcoords="offset points",
            color=colour,
            va="center",
            annotation_clip=False,
            in_layout=False,
        )


def _layout(figure: Figure) -> Any:
    return figure.get_layout_engine()


def _apart(heights: NDArray[np.float64], least: float) -> NDArray[np.float64]:
    """The heights moved as little as possible (least squares) for all to be `least` apart, in the same order."""
    order = np.argsort(heights, kind="stable")
    steps = least * np.arange(len(heights))
    moved = np.empty_like(heights)
    moved[order] = isotonic_regression(heights[order] - steps).x + steps
    return moved


#: Sides of a dot on which its label may stand, the sides of those that lie on the front also a line further away.
_NEAR, _FURTHER = ((1, 1), (-1, -1), (1, -1), (-1, 1)), ((1, -3), (1, 3), (-1, -3), (-1, 3))


def _name_dots(figure: Figure, axes: Axes, dots: Sequence[Dot]) -> None:
    """Labels beside dots, those of the front first; left out where all places around a dot are taken."""
    figure.draw_without_rendering()
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    marks = axes.transData.transform([(dot.x, dot.y) for dot in dots]) if dots else np.zeros((0, 2))
    taken = [np.concatenate([mark - 7.0, mark + 7.0]) for mark in marks]
    frame = axes.get_window_extent(renderer)
    for dot in sorted(dots, key=lambda dot: not dot.front):
        for right, up in _NEAR + _FURTHER if dot.front else _NEAR:
            words = axes.annotate(
                dot.label,
                (dot.x, dot.y),
                xytext=(5.5 * right, 4.5 * up),
                textcoords="offset points",
                fontsize=_SMALL,
                color=INK if dot.front else QUIET,
                ha="left" if right > 0 else "right",
                va="bottom" if up > 0 else "top",
                in_layout=False,
                path_effects=[withStroke(linewidth=2.0, foreground=GROUND)],
                zorder=5,
            )
            box = words.get_window_extent(renderer)
            corners = np.array([box.x0, box.y0, box.x1, box.y1])
            inside = box.x1 <= frame.x1 + 1.0 and box.x0 >= frame.x0 and box.y0 >= frame.y0 and box.y1 <= frame.y1 + 8.0
            if inside and not any(_overlap(corners, other) for other in taken):
                taken.append(corners)
                break
            words.remove()


def _overlap(one: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
    return bool(one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3])

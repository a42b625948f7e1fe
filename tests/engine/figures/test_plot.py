"""Plots as files: what is drawn is where it belongs, colours are distinct, equal figures give equal files."""

from __future__ import annotations

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, cast

import cv2
import numpy as np
import pytest

from engine.core.colour import srgb_decode, xyz_from_srgb
from engine.figures import plot
from engine.figures.plot import COLOURS, Curve, Dot, curves, png_of, save, scatter_front, svg_of
from tests.present import present

STEPS = np.arange(1, 6)


def some_curves() -> Any:
    lines = [Curve("Haar", STEPS, 60 / STEPS, 3 / STEPS), Curve("Harmonics", STEPS, 50 / STEPS**0.5)]
    return curves(lines, "Lobes", "Relative L² error in %")


def rgb(colour: str) -> np.ndarray[Any, Any]:
    return np.array([int(colour[start : start + 2], 16) for start in (1, 3, 5)])


def image_of(figure: Any) -> np.ndarray[Any, Any]:
    return present(cv2.imdecode(np.frombuffer(png_of(figure), np.uint8), cv2.IMREAD_COLOR))[..., ::-1]


def pixel(figure: Any, image: np.ndarray[Any, Any], x: float, y: float) -> np.ndarray[Any, Any]:
    column, row = figure.axes[0].transData.transform((x, y))
    return image[image.shape[0] - 1 - round(row), round(column)]


def test_points_lie_where_the_axes_say() -> None:
    figure = some_curves()
    image = image_of(figure)
    assert image.shape == (plot.HEIGHT, plot.WIDTH, 3)
    for x, y in zip(STEPS, 60 / STEPS, strict=True):
        assert np.abs(pixel(figure, image, cast(Any, x), y) - rgb(COLOURS[0])).max() <= 2
    ticks = [(tick.get_text(), tick.get_position()[0]) for tick in figure.axes[0].get_xticklabels()]
    assert all(float(words) == pytest.approx(place) for words, place in ticks)


def test_dots_of_the_front_are_filled_and_others_hollow() -> None:
    dots = [Dot(0.01, 0.1, "sh", "5", 0.01, True), Dot(0.1, 0.02, "wavelet", "4", front=True), Dot(0.1, 0.5, "sh", "3")]
    figure = scatter_front(dots, "Frame in s", "Error")
    image = image_of(figure)
    assert np.abs(pixel(figure, image, 0.01, 0.1) - rgb(COLOURS[0])).max() <= 2
    assert np.abs(pixel(figure, image, 0.1, 0.02) - rgb(COLOURS[1])).max() <= 2
    assert np.abs(pixel(figure, image, 0.1, 0.5) - rgb(plot.GROUND)).max() <= 2
    assert {words.get_text() for words in figure.axes[0].texts} == {"3", "4", "5"}


def test_labels_of_dots_cover_neither_dots_nor_each_other() -> None:
    random = np.random.default_rng(1)
    dots = [Dot(x, y, "sh", f"setting {x:.3f}", front=True) for x, y in random.uniform(0.1, 1.0, (60, 2))]
    figure = scatter_front(dots, "x", "y")
    boxes = [words.get_window_extent() for words in figure.axes[0].texts]
    assert 5 < len(boxes) < 60
    assert not any(one.overlaps(other) for n, one in enumerate(boxes) for other in boxes[:n])
    places = figure.axes[0].transData.transform([(dot.x, dot.y) for dot in dots])
    assert not any(box.contains(*place) for box in boxes for place in places)


def test_names_at_the_ends_of_lines_do_not_cover_each_other() -> None:
    figure = curves([Curve(f"line {n}", STEPS, 1.0 + 1e-3 * n * STEPS) for n in range(6)], "x", "y", y_from_zero=True)
    figure.draw_without_rendering()
    boxes = [words.get_window_extent() for words in figure.axes[0].texts]
    assert len(boxes) == 6
    assert not any(one.overlaps(other) for n, one in enumerate(boxes) for other in boxes[:n])
    assert max(box.x1 for box in boxes) <= plot.WIDTH


@pytest.mark.parametrize("log_y", [False, True])
def test_what_cannot_be_drawn_is_left_out_and_counted(log_y: bool) -> None:
    figure = curves([Curve("a", [1, 2, 3, 4], [1.0, np.nan, 0.0, np.inf])], "x", "y", log_y=log_y)
    assert f"{3 if log_y else 2} points cannot be shown." in [words.get_text() for words in figure.texts]
    assert png_of(figure)


@pytest.mark.parametrize("figure", [lambda: curves([], "x", "y"), lambda: scatter_front([], "x", "y")])
def test_plots_of_nothing_are_empty_plots(figure: Any) -> None:
    assert png_of(figure())
    assert svg_of(figure())


def test_words_are_set_as_they_are_written() -> None:
    figure = curves([Curve("$x_{ü}$ μ ≤ °", STEPS, STEPS)], "100 % ± 1", "a_b^c", title="$\\frac", note="$")
    assert png_of(figure)


def test_equal_figures_are_equal_files_on_any_thread() -> None:
    with ThreadPoolExecutor(4) as pool:
        files = list(pool.map(lambda _: (png_of(figure := some_curves()), svg_of(figure)), range(6)))
    assert len(set(files)) == 1
    assert b"<dc:date>" not in files[0][1]


def test_a_figure_is_saved_twice_beside_each_other(tmp_path: Path) -> None:
    written = save(some_curves(), tmp_path / "error.png")
    assert [path.name for path in written] == ["error.png", "error.svg"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["error.png", "error.svg"]
    assert written[0].read_bytes() == png_of(some_curves())


def test_more_groups_than_colours_are_refused() -> None:
    with pytest.raises(ValueError, match="told apart"):
        curves([Curve(str(n), STEPS, STEPS) for n in range(8)], "x", "y")


def test_colours_differ_in_lightness_and_stand_out() -> None:
    grey = [xyz_from_srgb(srgb_decode(rgb(colour) / 255.0))[1] for colour in (*COLOURS, plot.GROUND)]
    lightness = 116.0 * np.cbrt(grey) - 16.0
    assert np.diff(np.sort(lightness)).min() > 4.0
    assert lightness[-1] - lightness[:-1].max() > 20.0


def test_plots_need_no_home_and_say_nothing(tmp_path: Path) -> None:
    program = "from engine.figures.plot import *; save(curves([Curve('a', [1, 2], [1, 2])], 'x', 'y'), 'plot')"
    project = Path(__file__).resolve().parents[3]
    environment = {"PYTHONPATH": str(project), "HOME": str(tmp_path / "none" / "there"), "PATH": os.environ["PATH"]}
    environment |= {"TMPDIR": str(tmp_path), "XDG_CACHE_HOME": "/proc/none", "XDG_CONFIG_HOME": "/proc/none"}
    ran = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
    )
    assert (ran.stdout, ran.stderr) == ("", "")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["plot.png", "plot.svg"]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("x", [1.92e-4, 0.042, 3e5])
def test_a_single_dot_has_an_axis(x: float) -> None:
    figure = scatter_front([Dot(x, 25.7, "Direct", "lights 4", spread=0.4, front=True)], "x", "y")
    low, high = figure.axes[0].get_xlim()
    assert low < x < high


def test_ticks_of_many_decades_do_not_run_into_each_other() -> None:
    few, many = ([Dot(10.0**power, 1.0 + power, "a") for power in range(count)] for count in (3, 8))
    for dots, numbers in ((few, 6), (many, 7)):
        figure = scatter_front(dots, "x", "y")
        figure.draw_without_rendering()
        low, high = figure.axes[0].get_xlim()
        ticks = [tick for tick in figure.axes[0].get_xticks() if low <= tick <= high]
        assert numbers <= len(ticks) <= 10


def test_a_bar_may_reach_further_up_than_down() -> None:
    """Extrapolated errors are certain to a factor, so that their bars are longer above."""
    figure = scatter_front([Dot(1.0, 2.0, "sh", "order 5", (1.0, 3.0))], "x", "y")
    (bar,) = figure.axes[0].collections[:1]
    low, high = (float(end[1]) for end in bar.get_segments()[0])  # type: ignore[attr-defined]
    assert (low, high) == (1.0, 5.0)

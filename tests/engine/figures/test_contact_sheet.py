"""The contact sheet: what is drawn is where and what the numbers say."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import pytest

from engine.figures.contact_sheet import (
    ACCENT,
    MARGIN,
    WIDTH,
    Panel,
    Row,
    draw_sheet,
    panel_width,
    plot,
    with_colour_bar,
)


def fill_in(colour: Any, rows: int = 60, columns: int = 60) -> Any:
    return np.full((rows, columns, 3), colour, np.uint8)


def find(sheet: Any, colour: Any) -> tuple[Any, Any, Any, Any]:
    row, column = np.nonzero((sheet == np.array(colour, np.uint8)).all(axis=2))
    return row.min(), row.max(), column.min(), column.max()


def test_panels_fill_the_width_in_order() -> None:
    colours = [(200, 10, 10), (10, 200, 10), (10, 10, 200)]
    sheet = draw_sheet("A", "b", [Row("row", tuple(Panel(fill_in(colour), "x") for colour in colours))])
    assert sheet.shape[1] == WIDTH
    boxes = [find(sheet, colour) for colour in colours]
    assert boxes[0][2] == MARGIN
    assert WIDTH - MARGIN - 3 <= boxes[2][3] + 1 <= WIDTH - MARGIN
    assert boxes[0][3] < boxes[1][2] < boxes[1][3] < boxes[2][2]
    assert all(bottom - top + 1 == panel_width(3) for top, bottom, _, _ in boxes)


def test_a_image_is_cut_to_the_panel_not_stretched() -> None:
    tall = np.zeros((200, 100, 3), np.uint8)
    tall[50:150] = (250, 0, 250)
    top, bottom, left, right = find(draw_sheet("", "", [Row("", (Panel(tall, ""),) * 2)]), (250, 0, 250))
    assert right - left > 2 * (bottom - top) - 10


def test_missing_image_shows_its_reason() -> None:
    with_reason, without = (
        draw_sheet("A", "b", [Row("row", (Panel(None, reason),), 10.0)]) for reason in ("OpenGL is missing", "")
    )
    assert (with_reason != without).any()


def test_colour_bar_ends_in_the_colours_of_zero_and_top() -> None:
    values = np.zeros((32, 32))
    values[:, 16:] = 4.0
    image = with_colour_bar(values, "exponent", 400, top=4.0)
    low, high = cv2.applyColorMap(np.array([[0, 255]], np.uint8), cv2.COLORMAP_VIRIDIS)[0, :, ::-1]
    assert np.array_equal(image[100, 60], low)
    assert np.array_equal(image[100, 340], high)
    bar = 14 + (400 - 92) + 14 + 5
    assert np.array_equal(image[bar, 46], low)
    assert np.array_equal(image[bar, 46 + 400 - 92 - 1], high)


@pytest.mark.parametrize("values", [np.zeros((4, 4)), np.full((4, 4), np.nan), np.ones((1, 1))])
def test_colour_bar_of_odd_maps_is_drawn(values: Any) -> None:
    assert with_colour_bar(values, "x", 200).shape == (200, 200, 3)


def test_plotted_points_lie_where_their_values_say() -> None:
    image = plot([10, 50, 100], [0.1, 0.4, 0.2], "x", "y", 464)
    left, right, top, bottom = 74, 464 - 26, 30, 464 - 76
    for x, y in ((10, 0.1), (50, 0.4), (100, 0.2)):
        column, row = round(left + (right - left) * x / 100), round(bottom - (bottom - top) * y / 0.4)
        assert np.array_equal(image[row, column], ACCENT)


def test_plot_of_darkness_is_drawn() -> None:
    assert plot([1, 2], [0, 0], "x", "y", 300).shape == (300, 300, 3)


def test_a_long_subtitle_takes_further_lines() -> None:
    """The caption of a paper's figure was cut off at the right edge."""
    rows = [Row("", (Panel(fill_in((0, 0, 250)), ""),))]
    short, long = draw_sheet("A", "b", rows), draw_sheet("A", "word " * 60, rows)
    assert long.shape[0] == short.shape[0] + 26
    background = long[0, -1]
    assert (long[:, -20:] == background).all()

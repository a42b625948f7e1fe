"""Shadows of relief under a lamp and the sky: horizons of a periodic height field.

The horizon of a texel towards azimuth a is the largest slope (h(x + t d) - h(x)) / t over t > 0. For a distant lamp it
is found once for all elevations of an azimuth by sweeping lines across the field and keeping the upper convex hull of
what lies towards the lamp (Timonen2010 Sec. 3): exact along
rows and columns, interpolated between neighbouring lines otherwise. Every texel sees a near lamp in a direction of its
own, so there the relief between texel and lamp is walked over in steps of one texel.

The lamp is a uniform disc of angular radius w; what a straight edge at the horizon leaves of it is

    V(u) = 1/2 + (u sqrt(1 - u^2) + asin u) / pi,    u = (e - horizon) / w  in [-1, 1]

so that shadows have the soft edges of a real lamp, and hard ones for w = 0.
Cost: some 40 ms per megatexel and azimuth for a distant lamp; for a near one 0.1 s per megatexel where it is high and
2 s where it grazes rough relief, on two cores.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import parallel, prange, scalar
from engine.core.steps import Step, Steps


def horizon_slope(height: NDArray[np.float32], azimuth: float, lowest: float) -> NDArray[np.float32]:
    """(H, W) tangent of the horizon's elevation towards `azimuth` of a periodic height field, at least 0.

    Horizons below `lowest` (rad) may be missed, because nothing farther than relief / tan(lowest) is looked at; pass
    the elevation of the lower edge of the lowest lamp.
    """
    if not 0.0 < lowest <= math.pi / 2:
        raise ValueError(f"lowest elevation {lowest:g} rad is outside (0, pi/2]")
    towards_column, towards_row = math.cos(azimuth), -math.sin(azimuth)
    if abs(towards_column) < abs(towards_row):
        return np.ascontiguousarray(_horizon(height.T, towards_row, towards_column, lowest).T)
    return _horizon(height, towards_column, towards_row, lowest)


def near_visibility(
    relief: NDArray[np.float32], lamp: NDArray[np.float64], lamp_radius: float, rows: slice
) -> NDArray[np.float32]:
    """(rows, W) share of a lamp disc of angular radius `lamp_radius` (rad) that relief leaves of a lamp at a place.

    Parameters
    ----------
    relief : (H, W) heights above the plane of the sample, texels.
    lamp : (3,) place of the lamp from the middle of the image: x right, y up, z above the plane, texels.
    rows : the rows that are asked for, so that long work can be done in parts.
    """
    first, last, _ = rows.indices(len(relief))
    horizon = np.empty((last - first, relief.shape[1]), np.float32)
    height_of_lamp = np.empty_like(horizon)
    _walk(relief, lamp, math.tan(lamp_radius), float(relief.max()), first, horizon, height_of_lamp)
    return visibility(horizon, np.arctan(height_of_lamp), lamp_radius)


def openness(
    height: NDArray[np.float32], azimuths: int = 8, lowest: float = math.radians(5.0)
) -> Steps[NDArray[np.float32]]:
    """(H, W) cosine-weighted part of the hemisphere above a horizontal receiver that relief leaves open, 1 if flat.

    It is the mean of cos^2(horizon) over azimuths: the integral of the cosine above the horizon, over pi.
    """
    total = np.zeros(height.shape)
    for index in range(azimuths):
        yield Step(index / azimuths, "Finding what hides the sky")
        slope = horizon_slope(height, 2 * math.pi * index / azimuths, lowest).astype(np.float64)
        total += 1.0 / (1.0 + slope * slope)
    return (total / azimuths).astype(np.float32)


def visibility(
    horizon: NDArray[np.float32], elevation: float | NDArray[np.float32], lamp_radius: float
) -> NDArray[np.float32]:
    """(H, W) share of a lamp disc of angular radius `lamp_radius` (rad) at `elevation` (rad) above the horizon."""
    above = elevation - np.arctan(horizon, dtype=np.float64)
    if lamp_radius == 0.0:
        return (above >= 0.0).astype(np.float32)
    u = np.clip(above / lamp_radius, -1.0, 1.0)
    return (0.5 + (u * np.sqrt(1.0 - u * u) + np.arcsin(u)) / np.pi).astype(np.float32)


def _horizon(height: NDArray[np.float32], along: float, across: float, lowest: float) -> NDArray[np.float32]:
    """Horizon towards the direction `along` columns and `across` rows (|along| >= |across|, together a unit vector)."""
    field = np.ascontiguousarray(height if along > 0 else height[:, ::-1])
    drift = across / abs(along) if abs(across) > 1e-12 else 0.0
    rows, columns = field.shape
    relief = float(field.max()) - float(field.min())
    reach = math.ceil(min(relief / math.tan(lowest) * abs(along), 4.0 * (rows + columns)))
    lines = np.empty(field.shape, np.float32)
    _sweep(field, drift, 1.0 / abs(along), reach, lines)
    if drift:
        slope = np.empty_like(lines)  # here, since memory that kernels take cannot be a file (engine.storage.spilling)
        _between_lines(lines, drift, slope)
    else:
        slope = lines
    return slope if along > 0 else np.ascontiguousarray(slope[:, ::-1])


@parallel
def _sweep(field: np.ndarray, drift: float, spacing: float, reach: int, lines: np.ndarray) -> None:
    """Bound by the reads of heights: each enters and leaves the hull once.

    Line j passes column c at row j + drift c; it is walked from the far right, where the lamp is, to the left.
    """
    rows, columns = field.shape
    for line in prange(rows):
        hull_height = np.empty(columns + reach + 1)
        hull_column = np.empty(columns + reach + 1, np.int64)
        count = 0
        for column in range(columns + reach - 1, -1, -1):
            here = _on_line(field, line + drift * column, column % columns)
            while count > 1 and (hull_height[count - 1] - here) * (hull_column[count - 2] - column) <= (
                hull_height[count - 2] - here
            ) * (hull_column[count - 1] - column):
                count -= 1
            if column < columns:
                slope = 0.0
                if count > 0:
                    slope = (hull_height[count - 1] - here) / ((hull_column[count - 1] - column) * spacing)
                lines[line, column] = max(slope, 0.0)
            hull_height[count], hull_column[count] = here, column
            count += 1


@scalar
def _on_line(field: np.ndarray, row: float, column: int) -> float:
    rows = field.shape[0]
    above = math.floor(row)
    first = int(above) % rows
    second = first + 1 if first + 1 < rows else 0
    return field[first, column] + (row - above) * (field[second, column] - field[first, column])


@parallel
def _between_lines(lines: np.ndarray, drift: float, slope: np.ndarray) -> None:
    """Bound by memory: two reads and a write to a texel."""
    rows, columns = lines.shape
    for row in prange(rows):
        for column in range(columns):
            slope[row, column] = _on_line(lines, row - drift * column, column)


@parallel
def _walk(
    relief: np.ndarray,
    lamp: np.ndarray,
    radius: float,
    highest: float,
    first: int,
    horizon: np.ndarray,
    height_of_lamp: np.ndarray,
) -> None:
    """Bound by the reads of four heights to a step.

    `least` is the slope to the disc's lower edge; the walk ends where the highest relief lies below it.
    """
    rows, columns = relief.shape
    for index in prange(horizon.shape[0]):
        row = first + index
        for column in range(columns):
            here = relief[row, column]
            across = lamp[0] - (column + 0.5 - 0.5 * columns)
            down = -lamp[1] - (row + 0.5 - 0.5 * rows)
            reach = math.sqrt(across * across + down * down)
            towards_lamp = (lamp[2] - here) / max(reach, 1e-6)
            least = max((towards_lamp - radius) / (1.0 + towards_lamp * radius), 1e-3)
            step_right, step_down = across / max(reach, 1e-6), down / max(reach, 1e-6)
            slope = 0.0
            far = min(reach, (highest - here) / least)
            distance = 1.0
            while distance < far:
                there = _at(relief, row + distance * step_down, column + distance * step_right)
                slope = max(slope, (there - here) / distance)
                distance += 1.0
            horizon[index, column] = slope
            height_of_lamp[index, column] = towards_lamp


@scalar
def _at(field: np.ndarray, row: float, column: float) -> float:
    """Bilinear height at a place of the periodic field."""
    left = math.floor(column)
    first = int(left) % field.shape[1]
    second = first + 1 if first + 1 < field.shape[1] else 0
    above = math.floor(row)
    upper = int(above) % field.shape[0]
    lower = upper + 1 if upper + 1 < field.shape[0] else 0
    share, part = column - left, row - above
    top = field[upper, first] + share * (field[upper, second] - field[upper, first])
    bottom = field[lower, first] + share * (field[lower, second] - field[lower, first])
    return top + part * (bottom - top)

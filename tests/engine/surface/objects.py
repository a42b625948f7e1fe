"""Photographs of objects that stand before a background, whose heights and regions are known.

Surfaces are smooth reliefs, each with slopes of its own; the highest is seen. Where one ends before another the height
steps, without a slope. Photographs are taken at `FINE` samples along each side of a texel and averaged, so that texels
on an edge mix both sides, after the blur of a lens. Light, shadows and reflectance are those of the independent
generator of captures, which takes nothing from the program.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from engine.capture.stack import ImageStack
from tests.engine.capture.calibration.generated import Capture, dome, draw_colour, find_lit
from tests.engine.surface.photographs import stack

Array = NDArray[np.float64]

#: Samples along each side of a texel, and texels around the image.
FINE, AROUND = 3, 10


@dataclass(frozen=True, eq=False)
class Scene:
    """A stack, and the truth: heights (H, W) in widths of a texel, the surface that is seen (H, W), −1 where a texel
    shows more than one, and the normals (H, W, 3).
    """

    stack: ImageStack
    height: Array
    surface: NDArray[np.int64]
    normals: Array


def draw_scene(seed: int, objects: int | None = None, size: tuple[int, int] = (96, 112)) -> Scene:
    """A scene drawn by `seed`, of one to four objects unless `objects` says how many."""
    random = np.random.default_rng([seed, 91])
    count = int(random.integers(1, 5)) if objects is None else objects
    rows, columns = (FINE * (side + 2 * AROUND) for side in size)
    row, column = (np.mgrid[:rows, :columns] + 0.5) / FINE
    heights = [_relief(random, (rows, columns), random.uniform(0.03, 0.2))]
    for _ in range(count):
        heights.append(_object(random, row, column, heights[0]))
    layers = np.stack(heights)
    seen = layers.argmax(axis=0)
    known = np.where(np.isfinite(layers), layers, np.nan)
    slopes = [np.stack([np.gradient(each, 1.0 / FINE, axis=axis) for axis in (0, 1)]) for each in known]
    height = layers.max(axis=0)
    down, right = np.take_along_axis(np.stack(slopes), seen[None, None], axis=0)[0]
    down, right = _fill(down), _fill(right)
    normals = np.stack([-right, down, np.ones_like(right)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    width = columns / FINE
    unit = 1.0 / (FINE * width)
    capture = Capture(seed=seed, material=str(random.choice(["matte", "plastic", "satin metal"], p=[0.6, 0.25, 0.15])))
    places = np.stack(
        [column / width - 0.5, 0.5 * size[0] / width - row / width, (height - height.mean()) / width], axis=-1
    )
    colours = draw_colour((rows, columns), random)
    for each in range(1, count + 1):
        colours[seen == each] *= random.uniform(0.5, 1.1, 3)
    directions = dome(int(random.integers(16, 49)), random)
    seen_by = []
    for direction in directions:
        lit = find_lit(places, normals, np.clip(colours, 0.02, 0.95), direction, capture, unit)
        blurred = ndimage.gaussian_filter(lit, (0.45 * FINE, 0.45 * FINE, 0.0), mode="nearest")
        seen_by.append(_average(blurred))
    taken = np.stack(seen_by)
    taken *= 0.85 / np.quantile(taken, 0.995)
    taken += capture.noise * np.sqrt(0.05 + taken) * random.standard_normal(taken.shape)
    elevation, azimuth = np.arcsin(directions[:, 2]), np.arctan2(directions[:, 1], directions[:, 0])
    cells = seen.reshape(rows // FINE, FINE, -1, FINE)
    pure = (cells == cells[:, :1, :, :1]).all(axis=(1, 3))
    surface = np.where(pure, cells[:, 0, :, 0], -1)[AROUND:-AROUND, AROUND:-AROUND]
    mean = _average(normals)
    mean /= np.linalg.norm(mean, axis=-1, keepdims=True)
    photographs = stack(np.clip(taken, 0.0, 1.0), elevation, azimuth)
    return Scene(photographs, _average(height[..., None])[..., 0], surface, mean)


def _average(values: Array) -> Array:
    """Means of the samples of each texel of the image, of values (H, W, C)."""
    rows, columns, channels = values.shape
    found = values.reshape(rows // FINE, FINE, columns // FINE, FINE, channels).mean(axis=(1, 3))
    return np.asarray(found[AROUND:-AROUND, AROUND:-AROUND])


def _fill(slope: Array) -> Array:
    """Slopes beside the end of a surface, which has no neighbour there, are those of the nearest sample that has."""
    missing = ~np.isfinite(slope)
    nearest = ndimage.distance_transform_edt(missing, return_distances=False, return_indices=True)
    return np.asarray(slope[tuple(nearest)])


def _relief(random: np.random.Generator, shape: tuple[int, int], steepness: float) -> Array:
    """(H, W) smooth relief in widths of a texel, of slopes whose root mean square is `steepness`."""
    found = np.zeros(shape)
    for scale in (4.0, 12.0):
        field = ndimage.gaussian_filter(random.standard_normal(shape), FINE * scale, mode="nearest")
        found += scale * field / field.std()
    down, right = np.gradient(found, 1.0 / FINE)
    return np.asarray(found * steepness / math.sqrt(float((down**2 + right**2).mean())))


def _object(random: np.random.Generator, row: Array, column: Array, ground: Array) -> Array:
    """(H, W) height of an object, −inf beside it: a plate, a dome, a ring, or a plate with an edge in the ground."""
    high, wide = row.max() - 2.0 * AROUND, column.max() - 2.0 * AROUND
    radius = random.uniform(0.14, 0.3) * high
    y = row - AROUND - random.uniform(0.2, 0.8) * high
    x = column - AROUND - random.uniform(0.2, 0.8) * wide
    turn, stretch = random.uniform(0.0, 2.0 * math.pi), random.uniform(0.6, 1.0)
    along, across = x * math.cos(turn) + y * math.sin(turn), (y * math.cos(turn) - x * math.sin(turn)) / stretch
    angle, out = np.arctan2(across, along), np.hypot(along, across)
    wavy = 1.0 + 0.15 * np.sin(3.0 * angle + turn) * random.random()
    kind, step = str(random.choice(["plate", "dome", "ring", "flap"])), random.uniform(3.0, 14.0)
    top = step + np.median(ground) + _relief(random, (row.shape[0], row.shape[1]), random.uniform(0.03, 0.2))
    inside = out < radius * wavy
    if kind == "dome":
        top = top + 0.4 * radius * (1.0 - (out / radius) ** 2)
    elif kind == "ring":
        inside &= out > 0.55 * radius
    elif kind == "flap":
        inside = (np.abs(along) < radius) & (np.abs(across) < radius)
        top = top - step * (along + radius) / (1.6 * radius)
    else:
        top = top + random.uniform(-0.15, 0.15) * x + random.uniform(-0.15, 0.15) * y
    return np.where(inside, top, -np.inf)

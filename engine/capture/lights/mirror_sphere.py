"""Directions of lights from a mirror sphere in the image.

An orthographic camera along +z sees the lamp where the sphere's normal halves the angle between camera and lamp, so
the highlight at (x, y) on the sphere gives n = (x, y, sqrt(1 - x^2 - y^2)) and the light l = 2 (n . v) n - v with
v = (0, 0, 1). An error of d pixels of the highlight turns the light by about 2 d / (radius sqrt(1 - x^2 - y^2)).

Conventions: pixel centres at half-integers, row 0 on top; directions x right, y up, z towards the camera.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import UsageError

#: Circles that compete to be the outline: with a third of the points on it, all but certainly some are of those alone.
_DRAWS = 400
#: Rays whose steepest step is below this share of the steepest of all cross no outline that could be seen.
_FLAT = 0.02


@dataclass(frozen=True)
class Circle:
    """Outline of the sphere in pixels: centre (column, row) and radius."""

    column: float
    row: float
    radius: float


def find_sphere(mean_image: NDArray[np.float32]) -> Circle:
    """The most circular outline in `mean_image` (H, W) luminance (Hough transform); UsageError if there is none."""
    import cv2

    scale = min(1.0, 640 / max(mean_image.shape))
    bright = np.sqrt(np.clip(mean_image / max(float(np.percentile(mean_image, 99.5)), 1e-9), 0, 1))
    small = cv2.resize(np.uint8(255 * bright), None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    side = min(small.shape)
    found = cv2.HoughCircles(
        cv2.medianBlur(small, 5),
        cv2.HOUGH_GRADIENT_ALT,
        1.5,
        side / 4,
        param1=200,
        param2=0.7,
        minRadius=side // 40,
        maxRadius=side // 2,
    )
    if found is None:
        raise UsageError("no sphere was found; mark its outline by hand")
    x, y, radius = (float(value) / scale for value in found[0][0][:3])
    image = bright.astype(np.float32)
    return _refine(image, _outermost(image, Circle(x + 0.5 / scale, y + 0.5 / scale, radius)))


def _outermost(image: NDArray[np.float32], found: Circle) -> Circle:
    """The outline around `found`, which may be the horizon that the sphere mirrors, at sqrt(1/2) of its radius.

    Steps along 360 rays are averaged with their sign, so that the texture around the sphere cancels. The strongest is
    a horizon if another stands out at sqrt(2) times its distance.
    """
    import cv2

    angles = np.radians(np.arange(360.0))[:, None]
    reach = found.radius * np.linspace(0.8, 1.8, 201)[None, :]
    columns, rows = found.column + reach * np.cos(angles), found.row + reach * np.sin(angles)
    rays = cv2.remap(image, np.float32(columns - 0.5), np.float32(rows - 0.5), cv2.INTER_LINEAR)
    strength = np.abs(np.gradient(cv2.GaussianBlur(rays, (9, 1), 2.0), axis=1).mean(axis=0))
    inner = float(reach[0, :81][strength[:81].argmax()])
    outer = np.abs(reach[0] / (np.sqrt(2.0) * inner) - 1)
    stands_out = strength[outer < 0.03].max() > 2 * strength[(outer > 0.08) & (outer < 0.12)].max()
    if stands_out and strength[outer < 0.03].max() > 0.2 * strength[:81].max():
        return Circle(found.column, found.row, float(np.sqrt(2.0)) * inner)
    return found


def _refine(image: NDArray[np.float32], start: Circle) -> Circle:
    """The circle near `start` that most of the steepest steps along 360 rays lie on, fitted to those.

    Part of an outline often drowns in the dark, or a highlight is steeper than it; so circles through three random
    steps compete for the consent of the others (RANSAC, Fischler1981), always with the same random numbers.
    """
    import cv2

    angles = np.radians(np.arange(360.0))[:, None]
    reach = start.radius * np.linspace(0.8, 1.2, 81)[None, :]
    columns, rows = start.column + reach * np.cos(angles), start.row + reach * np.sin(angles)
    rays = cv2.remap(image, np.float32(columns - 0.5), np.float32(rows - 0.5), cv2.INTER_LINEAR)
    slope = np.abs(np.gradient(cv2.GaussianBlur(rays, (9, 1), 2.0), axis=1))
    steepest, steepness = slope.argmax(axis=1), slope.max(axis=1)
    step = np.flatnonzero((steepest > 0) & (steepest < 80) & (steepness > _FLAT * steepness.max()))
    if len(step) < 3:
        return start
    x, y = columns[step, steepest[step]], rows[step, steepest[step]]
    random = np.random.default_rng(0)
    threes = (random.choice(len(step), 3, replace=False) for _ in range(_DRAWS))
    drawn = (_through(x[three], y[three]) for three in threes)
    near = (one for one in drawn if abs(one.radius / start.radius - 1) < 0.2)
    circle = max(near, key=lambda one: int(_on(one, x, y).sum()), default=start)
    for _ in range(4):
        on = _on(circle, x, y)
        if on.sum() < 3:
            return start
        circle = _through(x[on], y[on])
    return circle


def _through(x: NDArray[np.float64], y: NDArray[np.float64]) -> Circle:
    """The circle that fits points best (least squares of the squared distances; exact for three)."""
    design = np.column_stack([2 * x, 2 * y, np.ones_like(x)])
    a, b, c = np.linalg.lstsq(design, x * x + y * y, rcond=None)[0]
    return Circle(float(a), float(b), float(np.sqrt(max(0.0, c + a * a + b * b))))


def _on(circle: Circle, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Mask of the points on the circle, to a hundredth of its radius or a pixel."""
    on: NDArray[np.bool_] = np.abs(np.hypot(x - circle.column, y - circle.row) - circle.radius) <= max(
        1.0, 0.01 * circle.radius
    )
    return on


def find_highlight(luminance: NDArray[np.float32], sphere: Circle) -> tuple[float, float]:
    """(column, row) of the lamp's reflection: centroid of the brightest connected spot inside the outline.

    The spot holds the pixels above half of the brightest; of several spots the one with the most light wins.
    Raises UsageError if nothing stands out (the brightest pixel is less than twice the median of the sphere).
    """
    import cv2

    rows, columns = np.mgrid[: luminance.shape[0], : luminance.shape[1]]
    inside = np.hypot(columns + 0.5 - sphere.column, rows + 0.5 - sphere.row) < 0.97 * sphere.radius
    if not inside.any():
        raise UsageError("the outline of the sphere lies outside the image")
    shown = np.where(inside, luminance, 0)
    brightest = float(shown.max())
    if brightest <= 2 * float(np.median(luminance[inside])) or brightest <= 0:
        raise UsageError("no highlight stands out on the sphere; mark it by hand")
    count, labels = cv2.connectedComponents(np.uint8(shown > 0.5 * brightest))
    light = np.bincount(labels.ravel(), weights=shown.ravel(), minlength=count)
    light[0] = 0
    spot = labels == int(np.argmax(light))
    weight = shown[spot].astype(np.float64)
    return (
        float(np.average(columns[spot] + 0.5, weights=weight)),
        float(np.average(rows[spot] + 0.5, weights=weight)),
    )


def light_direction(sphere: Circle, column: float, row: float) -> NDArray[np.float64]:
    """(3,) unit vector towards the lamp whose reflection is seen at (column, row).

    Raises UsageError for a point outside the outline, or so close to it that the lamp would stand behind the sample.
    """
    x = (column - sphere.column) / sphere.radius
    y = (sphere.row - row) / sphere.radius
    z = np.sqrt(max(0.0, 1 - x * x - y * y))
    light = np.array([2 * z * x, 2 * z * y, 2 * z * z - 1])
    if x * x + y * y > 1 or light[2] <= 0:
        raise UsageError("the highlight lies too close to the outline: the lamp would stand below the sample")
    return light

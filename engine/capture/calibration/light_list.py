"""Whether a list of lights belongs to its photographs, or fits them clearly better in another form.

Lists that name photographs in another order leave larger residuals of the fit of a texel. Mirrored lists do not: they
fit as well, by mirrored normals. But their slopes belong to no surface, since for a height h the derivative of dh/dx by
y is that of dh/dy by x. The part of the slopes' changes that breaks this is small for one handedness alone.
A list that is turned by half a circle fits as well by both measures: hills are then valleys. So does one that is
mirrored in x where it should be in y. Near lamps and cast shadows tell these two apart: a shadow lies where the surface
rises towards the lamp. Where they do not, of mirrored lists y is named, which points down in many programs, and of
others it is said that they may be turned.

Cost: 0.3 s of one core for 64 photographs, whatever their size. Orders of the list are fitted side by side.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from engine.capture.calibration.rig import Array, Rig, Sample, fit
from engine.capture.lights.list_forms import AXES, LISTED, change
from engine.core.kernels import serial_kernels
from engine.core.one_thread import one_thread
from engine.core.side_by_side import list_side_by_side
from engine.core.slopes import integrate_slopes

#: Longer side of the images that are compared, texels of the fit, and least number of lamps.
SIDE, TEXELS, FEWEST = 56, 160, 8

#: Shifts that are tried, and the largest residual that counts, over the brightness of a texel.
SHIFTS, LARGEST = (1, -1, 2, -2, 3, -3), 0.25

#: The residual of another order, over that of the list, up to which it fits as well.
AS_WELL = 1.05

#: The part of slopes' changes that belongs to no surface, times the square of the residual, over that of the list,
#: below which a form fits clearly better; and the part above which nothing is told.
CLEAR, UNTOLD = 0.55, 0.75

#: Texels over which slopes are smoothed, and the share of texels, those of the largest changes, that is looked at.
SMOOTH, STEEPEST = 0.8, 0.25

#: The residual of near lamps in one of two mirrored lists, over that in the other, below which they tell.
NEAR_BETTER = 0.97

#: For a list that fits as it is: that residual turned by half a circle, over that of the list, below which the list is
#: turned, and above which it is not; between them, by how much more steeply the surface has to rise in cast shadows.
TURNED, UPRIGHT, RISE = 0.9, 1.1, 0.1

#: By how much more steeply it has to rise for shadows to decide against near lamps: the distance of lamps bends to
#: explain the shadows of a thing that stands out. Of 40 generated captures 0.13 at most contradict near lamps that are
#: right, and of such things 0.5 and more contradict lamps that are not near.
STEEP = 0.3


#: What is said where neither near lamps nor cast shadows tell hills from valleys.
UNTOLD_RELIEF = (
    "The photographs do not distinguish the list of lights from one that is turned by half a circle: if hills look "
    "like valleys, import again with --lights-form turned"
)


@dataclass(frozen=True)
class ListCheck:
    """The form that fits clearly better than the list, or 'listed'; and the measures of both.

    `residual` and `no_surface` are pairs (as listed, in that form): mean residual over the brightness, and part of the
    changes of slopes that belongs to no surface. `doubt` is a sentence about what the photographs do not tell of the
    list.
    """

    form: str
    residual: tuple[float, float]
    no_surface: tuple[float, float]
    doubt: str = ""


def check_list(
    photographs: Sequence[NDArray[np.float32]], clipped: Sequence[NDArray[np.float32]], directions: Array
) -> ListCheck:
    """Compare the list (N, 3), in the order of file names, as the small linear `photographs` (h, w, 3) are."""
    nothing = ListCheck(LISTED, (np.nan, np.nan), (np.nan, np.nan))
    if len(directions) < FEWEST:
        return nothing
    sample, size = _dense(photographs, clipped)
    some = np.arange(len(sample.values)) % max(1, len(sample.values) // TEXELS) == 0
    if sample.brightness.min() <= 0.0 or min(size) < 16:
        return nothing
    orders = [LISTED, "reversed", *(f"shifted{shift:+d}" for shift in SHIFTS if abs(shift) < len(directions) // 2)]
    with one_thread(), serial_kernels():
        few = sample.of(some)
        fitted = list_side_by_side(lambda order: _fit(few, change(directions, order)), orders)
        fits = dict(zip(orders, fitted, strict=True))
        own = _no_surface(sample, directions, fits[LISTED][1], size)
        candidates = {form: (1.0, own[form]) for form in AXES}
        for order in orders[1:]:
            share = fits[order][0] / max(fits[LISTED][0], 1e-9)
            if share < AS_WELL:
                turned = change(directions, order)
                candidates[order] = share, _no_surface(sample, turned, fits[order][1], size)[LISTED]

        def doubt(form: str) -> float:
            """Measure of both together, over that of the list."""
            share, apart = candidates[form]
            return share**2 * apart / max(own[LISTED], 1e-9)

        form = min(candidates, key=doubt)
        share, apart = candidates[form]
        is_clear = doubt(form) < CLEAR and apart < UNTOLD and share * apart < own[LISTED]
        if is_clear and form.startswith("mirrored"):
            form = _mirror(sample, directions, fits[LISTED][1], size)
        relief = ""
        if not is_clear:
            near, rise = _compare_turned(sample, directions, fits[LISTED][1], size)
            by_lamps = near < TURNED or (near < UPRIGHT and rise > RISE)
            if rise > STEEP or (rise > -STEEP and by_lamps):
                form, share, apart, is_clear = "turned", near, own[LISTED], True
            elif near < UPRIGHT and rise > -RISE:
                relief = UNTOLD_RELIEF
    residual = (fits[LISTED][0], share * fits[LISTED][0])
    return ListCheck(form if is_clear else LISTED, residual, (own[LISTED], apart), relief)


def _mirror(sample: Sample, directions: Array, rig: Rig, size: tuple[int, int]) -> str:
    """'mirrored-x' or 'mirrored-y', whose surfaces are each other's negative."""
    near, rise = _compare_turned(sample, change(directions, "mirrored-y"), rig, size)
    if abs(rise) <= STEEP and (near > 1.0 / NEAR_BETTER or near < NEAR_BETTER):
        return "mirrored-x" if near < 1.0 else "mirrored-y"
    return "mirrored-x" if rise > 0.0 else "mirrored-y"


def _compare_turned(sample: Sample, directions: Array, rig: Rig, size: tuple[int, int]) -> tuple[float, float]:
    """Evidence that a list is turned by half a circle, so that hills are valleys.

    The residual with near lamps of the turned list over that of the list, and by how much more steeply the surface then
    rises towards the lamp in cast shadows (0 where there are too few).
    """
    few = sample.of(np.arange(len(sample.values)) % max(1, len(sample.values) // (2 * TEXELS)) == 0)

    def compare(directions: Array) -> tuple[float, float]:
        near = fit(few, directions, ("distance", "gains"), rig)
        return float(np.median(np.abs(few.values - near.model.values))), _rise_in_shadows(sample, directions, rig, size)

    both = list_side_by_side(compare, (directions, change(directions, "turned")))
    (left, listed), (left_turned, turned) = both
    return left_turned / max(left, 1e-9), turned - listed


def _rise_in_shadows(sample: Sample, directions: Array, rig: Rig, size: tuple[int, int]) -> float:
    """How much more steeply the surface rises towards the lamp in cast shadows than elsewhere, over the light's own
    slope."""
    found = fit(sample, directions, (), rig)
    model = found.model.values
    normals = found.albedo_normals / np.maximum(np.linalg.norm(found.albedo_normals, axis=1), 1e-12)[:, None]
    steep = np.maximum(normals[:, 2], 0.2)
    height = integrate_slopes((-normals[:, 0] / steep).reshape(size), (-normals[:, 1] / steep).reshape(size))
    shadow = (sample.values < 0.5 * model) & (model > 0.2) & sample.usable
    rows, columns = np.mgrid[: size[0], : size[1]]
    total, number = 0.0, 0
    for lamp, (x, y, z) in enumerate(directions):
        dark, across = shadow[:, lamp].reshape(size), float(np.hypot(x, y))
        if not 3 <= dark.sum() <= 0.5 * dark.size or across < 0.2:
            continue
        rise = np.full(size, -np.inf)
        for reach in (1.5, 2.5, 4.0, 6.0, 9.0):
            there = ndimage.map_coordinates(
                height, [rows - reach * y / across, columns + reach * x / across], order=1, mode="nearest"
            )
            rise = np.maximum(rise, (there - height) / reach)
        total += float(rise[dark].mean() - rise[~dark].mean()) * across / z * int(dark.sum())
        number += int(dark.sum())
    return total / number if number >= 20 else 0.0


def _dense(
    photographs: Sequence[NDArray[np.float32]], clipped: Sequence[NDArray[np.float32]]
) -> tuple[Sample, tuple[int, int]]:
    """All texels of the photographs at a side of `SIDE`, and rows and columns."""
    height, width = photographs[0].shape[:2]
    scale = min(1.0, SIDE / max(height, width))
    size = (max(1, round(width * scale)), max(1, round(height * scale)))
    values = np.stack([cv2.resize(each.mean(axis=-1), size, interpolation=cv2.INTER_AREA) for each in photographs])
    usable = np.stack([cv2.resize(each, size, interpolation=cv2.INTER_AREA) <= 0.0 for each in clipped])
    flat = values.reshape(len(values), -1).T.astype(np.float64)
    columns, rows = (each.ravel() for each in np.meshgrid(np.arange(size[0]), np.arange(size[1])))
    positions = np.stack([(columns + 0.5) / size[0] - 0.5, (0.5 * size[1] - 0.5 - rows) / size[0]], axis=1)
    mean = flat.mean(axis=1)
    block = np.zeros(len(flat), np.int64)
    scaled = flat / np.maximum(mean, 1e-12)[:, None]
    return Sample(scaled, usable.reshape(len(values), -1).T, positions, mean, block), (size[1], size[0])


def _fit(sample: Sample, directions: Array) -> tuple[float, Rig]:
    """Mean residual over the brightness, and the rig with gains, which wrong lists take for unequal lamps."""
    found = fit(sample, directions, ("gains",))
    counted = np.minimum(np.abs((sample.values - found.model.values)[sample.usable]), LARGEST)
    return float(np.sqrt((counted**2).mean())), found.rig


def _no_surface(sample: Sample, directions: Array, rig: Rig, size: tuple[int, int]) -> dict[str, float]:
    """By form of the axes, the part of the changes of slopes that belongs to no surface."""
    normals = fit(sample, directions, (), rig).albedo_normals.reshape(*size, 3)
    length = np.linalg.norm(normals, axis=-1)
    known = normals[..., 2] > 0.2 * length
    steep = np.where(known, normals[..., 2], 1.0)
    right, up = (ndimage.gaussian_filter(np.where(known, -normals[..., axis] / steep, 0.0), SMOOTH) for axis in (0, 1))
    found = {}
    for form, (x, y, is_swapped) in {LISTED: (1.0, 1.0, False), **AXES}.items():
        across, along = (up, right) if is_swapped else (x * right, y * up)
        one = -np.gradient(across, axis=0)[1:-1, 1:-1]
        other = np.gradient(along, axis=1)[1:-1, 1:-1]
        whole = np.abs(one) + np.abs(other)
        large = whole >= np.quantile(whole, 1.0 - STEEPEST)
        found[form] = float(np.abs(one - other)[large].mean() / max(float(whole[large].mean()), 1e-9))
    return found

"""Intensities of lamps that differ, solved from the photographs themselves, so that they can be divided out.

Of a white patch, a matt surface parallel to the sample: lamp i gives it the radiance g_i sin(elevation_i), so its gain
g_i is known up to one factor common to all.
Of the object: the median m_i of a photograph stands for its diffuse texels, since shadows and highlights lie at the
ends. log (m_i / sin elevation_i) = s(l_i) + log g_i, with s a polynomial of second degree in the direction l_i, fitted
with least absolute residuals (so that one odd lamp turns nothing); what it leaves is the gain. This is ambiguous: a
gain that changes smoothly over the dome looks like the reflectance of the object, and stays. Only a white patch tells
them apart.

Cost: each photograph is decoded once more, at half size.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from engine.capture.lights.sources import Sources
from engine.capture.photograph.decode import ReadAhead
from engine.capture.photograph.exposures import Scale
from engine.capture.photograph.grey_patch import GreyPatch
from engine.core.colour import LUMINANCE
from engine.core.errors import InputError
from engine.core.steps import Steps

Array = NDArray[np.float64]

#: Lamps for each coefficient of the smooth part, at least.
_LAMPS_PER_TERM = 2

_ROUNDS, _SMALLEST = 60, 1e-4


def lamp_gains(
    sources: Sources, how: GreyPatch | Literal["object"], scale: Scale, options: Mapping[str, Any]
) -> Steps[Array]:
    """(N,) intensity of each lamp over the median of all, from photographs read with `options` of `read_photograph`.

    Raises InputError for a patch that is clipped or black, or where there are too few lamps to tell their gains from
    the reflectance of the object.
    """
    place, count = sources.photographs[0].parent, len(sources.photographs)
    medians = np.empty(count)
    with closing(ReadAhead(sources.photographs, **options, half_size=True)) as ahead:
        for index, path in enumerate(sources.photographs):
            note = f"Measuring the lamp of {index + 1} of {count}"
            photograph = yield from ahead.next_photograph(index / count, note)
            part = _part(how, *photograph.saturated.shape)
            bright = photograph.radiance[part] @ LUMINANCE.astype(np.float32)
            if isinstance(how, GreyPatch) and (bright.size == 0 or photograph.saturated[part].mean() > 0.05):
                raise InputError(path, "does not show the white patch, or clipped", "Give another patch")
            medians[index] = float(np.median(bright)) * scale.factor.get(path, 1.0)
    if not (medians > 0.0).all():
        raise InputError(sources.photographs[int(medians.argmin())], "is black", "Leave it out")
    if isinstance(how, GreyPatch):
        return patch_gains(medians, sources.elevation)
    terms = _terms(sources.elevation, sources.azimuth)
    if count < _LAMPS_PER_TERM * terms.shape[1]:
        problem = f"has {count} lamps, too few to separate their intensities from the reflectance of the object"
        remedy = f"Give a white patch (--equalise LEFT,TOP,WIDTH,HEIGHT), or {_LAMPS_PER_TERM * terms.shape[1]} lamps"
        raise InputError(place, problem, remedy)
    return object_gains(medians, sources.elevation, sources.azimuth)


def _part(how: GreyPatch | Literal["object"], height: int, width: int) -> tuple[slice, slice]:
    """Rows and columns at half size."""
    if not isinstance(how, GreyPatch):
        return slice(0, height), slice(0, width)
    return (
        slice(how.top // 2, max(how.top // 2 + 1, (how.top + how.height) // 2)),
        slice(how.left // 2, max(how.left // 2 + 1, (how.left + how.width) // 2)),
    )


def patch_gains(medians: Array, elevation: Array) -> Array:
    """(N,) gains over their median, of the radiance (N,) of a matt patch parallel to the sample."""
    gains = medians / _receive(elevation)
    return gains / float(np.median(gains))


def _receive(elevation: Array) -> Array:
    """Irradiance of the sample over that from above; that of grazing light is uncertain and not taken as 0."""
    return np.maximum(np.sin(elevation), 0.02)


def object_gains(medians: Array, elevation: Array, azimuth: Array | None) -> Array:
    """(N,) gains over their median, of the median radiance (N,) of an object; azimuth None for lamps of one arc."""
    terms, wanted = _terms(elevation, azimuth), np.log(medians / _receive(elevation))
    weight = np.ones(len(medians))
    left = wanted
    for _ in range(_ROUNDS):
        root = np.sqrt(weight)
        smooth = terms @ np.linalg.lstsq(root[:, None] * terms, root * wanted, rcond=None)[0]
        left = wanted - smooth
        weight = 1.0 / np.maximum(np.abs(left), _SMALLEST)
    gains: Array = np.exp(left - float(np.median(left)))
    return gains


def _terms(elevation: Array, azimuth: Array | None) -> Array:
    """(N, 6) polynomials of second degree in the direction, or (N, 3) in the sine of the elevation alone."""
    if azimuth is None:
        height = np.sin(elevation)
        return np.stack([np.ones_like(height), height, height * height], axis=1)
    x, y = np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth)
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)

"""Representations of a capture with lamps at several azimuths, beside each other: error, bytes and time of the fit.

The rivals are those of the field: the mean image, polynomial texture maps, hemispherical harmonics, and radial basis
functions over all photographs. Polynomials and harmonics are ridge fits, each with the strength of the least error of
leaving a photograph out. These errors follow from second moments (`engine.shading.directional.moments`), so that each
takes milliseconds once these are known.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.capture.object_part import object_share
from engine.capture.stack import ImageStack
from engine.core.steps import Result, Step, Steps, part
from engine.shading.directional import interpolation
from engine.shading.directional.functions import hsh, polynomial
from engine.shading.directional.left_out import Predict, by_brightness, by_photographs, by_planes
from engine.shading.directional.moments import moments
from engine.shading.directional.planes import BUDGET, directions, fit_planes
from engine.shading.fidelity import fidelity
from engine.shading.shading_map import build

Array = NDArray[np.float64]

#: Numbers of planes that are told beside the one that is chosen, and the one in whose bytes rivals are measured.
PLANES = (9, 27)


@dataclass(frozen=True)
class Candidate:
    """A representation: errors in codes of 8-bit sRGB (NaN where not known), bytes of a texel, and what it costs.

    `products` are the multiplications of a fragment for each light once its values are fetched (None where they are
    not the whole of it), `fit_s` seconds. `predict` shows a photograph as it is made of the others.
    """

    name: str
    leave_one_out: float
    in_sample: float
    bytes_per_texel: int
    products: int | None
    fit_s: float
    predict: Predict


def compare(stack: ImageStack, used: NDArray[np.int64], slices: int = 8, most: int = BUDGET) -> Steps[list[Candidate]]:
    """All candidates and rivals of the photographs `used`, by rising error; ValueError for a stack without azimuths.

    The first planes have `most` bytes a texel or fewer. Of a stack that shows an object alone
    (`engine.capture.object_part`) errors are those of its texels.
    """
    found, moments_s = yield from _time(part(moments(stack, used), 0.0, 0.3))
    lights, second = directions(stack, used), found.average_channels()
    rows = [*_fits(lights, second, moments_s)]
    for place, budget in enumerate((most, *PLANES)):
        first = 0.3 + 0.15 * place
        planes, seconds = yield from _time(part(fit_planes(stack, used, found, budget), first, first + 0.15))
        errors = (planes.leave_one_out, planes.in_sample)
        count = len(planes.planes)
        name, predict = f"planes-{count}", by_planes(lights, found, planes.kernel, count)
        took = moments_s + seconds
        rows.append(Candidate(name, *errors, planes.bytes_per_texel, 3 * count, took, predict))
    excluded = [name for place, name in enumerate(stack.sources) if place not in used]
    started = time.perf_counter()
    yield from part(build(stack, slices, excluded=excluded), 0.75, 0.9)
    seconds = time.perf_counter() - started
    shown = (yield from part(fidelity(stack, used, slices), 0.9, 1.0)).over(object_share(stack))
    errors = (shown.leave_one_out, shown.in_sample)
    predict = by_brightness(stack.mean_radiance[used])
    rows.append(Candidate("shading-map", *errors, 12 * slices, 6, seconds, predict))
    unique = {row.name: row for row in rows}
    return sorted(unique.values(), key=lambda row: row.leave_one_out)


def _fits(lights: Array, second: Array, moments_s: float) -> list[Candidate]:
    """The rivals, and kriging of all photographs, each with the moments that it follows from."""
    count = len(lights)
    fits: dict[str, Callable[[Array], Array]] = {
        "mean": lambda at: np.ones((len(at), 1)),
        "ptm": polynomial,
        "hsh": hsh,
    }
    rows = []
    for name, functions in fits.items():
        values = functions(lights)
        ridge = interpolation.best_ridge(values, second)
        out = interpolation.leave_out_of_fit(values, ridge)
        error = interpolation.rms(out, second)
        inside = interpolation.rms(interpolation.smoother(values, ridge) - np.eye(count), second)
        terms = 3 * values.shape[1]
        products = 0 if name == "mean" else terms
        rows.append(Candidate(name, error, inside, terms, products, moments_s, by_photographs(out)))
    kernel = interpolation.best_kernel(lights, second)
    inside = interpolation.rms(interpolation.weights(lights, lights, kernel) - np.eye(count), second)
    out = interpolation.list_left_out(lights, kernel)
    error, size = interpolation.rms(out, second), 3 * count
    rows.append(Candidate("kriging-of-all", error, inside, size, size, moments_s, by_photographs(out)))
    return rows


def _time(work: Steps[Result]) -> Steps[tuple[Result, float]]:
    """The result of `work` and the seconds of it."""
    started = time.perf_counter()
    result = yield from work
    yield Step(1.0, "comparing representations")
    return result, time.perf_counter() - started

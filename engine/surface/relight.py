"""Photographs that the maps predict, and their error against those that were taken.

Maps are relit as engines do it: GGX over a diffuse part, without shadows of the relief on itself. Errors are root mean
squares over texels, channels and photographs in codes of 8-bit sRGB, as in `engine.shading.fidelity`.
Bound by arithmetic, one GGX for each texel and lamp.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.capture.object_part import object_mask
from engine.capture.stack import ImageStack
from engine.core.colour import REC_709, srgb_encode
from engine.core.steps import Step, Steps
from engine.shading.directional.left_out import Predict, Texels
from engine.surface.lamps import Lamps, lamps
from engine.surface.reflectance import Array, Kinds, fit, kinds, leave_out, metallic_roughness, texels
from engine.texel.kernel import (
    COV_REFLECTANCE,
    DIFFUSE,
    ROUGHNESS,
    SPECULAR,
    VAR_DIFFUSE,
    VAR_SPECULAR,
    show_texels,
)

Values = NDArray[np.floating]

#: Texels in which errors are found, and those in which photographs are left out, which takes a fit for each.
GRID, LEFT_OUT_GRID = 1 << 16, 2048

#: Photographs that are left out in turn, at most.
FOLDS = 64


@dataclass(frozen=True)
class RelitErrors:
    """Root mean squares in codes of 8-bit sRGB: of all photographs, of those left out in turn, and of their mean.

    `fit_s` are the seconds of a fit of all texels, by those of the ones that were compared.
    """

    in_sample: float
    left_out: float
    mean_picture: float
    fit_s: float


def errors(stack: ImageStack, used: NDArray[np.int64], *, lambertian: bool = False) -> Steps[RelitErrors]:
    """The errors of maps in Rec.709 that are made of the photographs `used`, as a row beside other representations.

    Kinds of texels and the brightness of white are those of all photographs, also where one is left out.
    """
    stack, seen, outside = stack.with_working_space(REC_709), lamps(stack, used), _background(stack)
    alike = yield from kinds(stack, used, seen, outside=outside)
    return (yield from measure_relight_errors(stack, used, seen, alike, lambertian=lambertian, outside=outside))


def _background(stack: ImageStack) -> NDArray[np.bool_] | None:
    """(H, W) True around the object of a stack that shows it alone; None for another."""
    mask = object_mask(stack)
    return None if mask is None else ~mask


def predicting(stack: ImageStack, used: NDArray[np.int64], *, lambertian: bool = False) -> Steps[Predict]:
    """A function that shows a photograph as maps in Rec.709 that are made of the others do, for some texels."""
    stack, seen = stack.with_working_space(REC_709), lamps(stack, used)
    alike = yield from kinds(stack, used, seen, outside=_background(stack))
    height, width = stack.radiance.shape[1:3]

    def predict(texels: Texels, out: int) -> Array:
        others = np.flatnonzero(np.arange(len(used)) != out)
        towards = seen.observe_from(texels.rows, texels.columns, height, width)
        found = fit(texels.choose(others), towards[others], seen, alike, lambertian)
        return np.asarray(_codes(_predict(found, towards[out : out + 1], alike, lambertian))[0], np.float64)

    return predict


def measure_relight_errors(
    stack: ImageStack,
    used: NDArray[np.int64],
    seen: Lamps,
    alike: Kinds,
    *,
    lambertian: bool = False,
    outside: NDArray[np.bool_] | None = None,
) -> Steps[RelitErrors]:
    """The same where lamps and kinds are known, without texels `outside` (H, W)."""
    inside, mean, fit_s, count = 0.0, 0.0, 0.0, len(used)
    matrix = stack.working_space.to_rec709.T.astype(np.float32)

    def codes(radiance: NDArray[np.float32]) -> NDArray[np.float32]:
        return _codes(radiance if stack.working_space == REC_709 else radiance @ matrix)

    for some, towards in _grid(stack, used, seen, GRID, outside):
        yield Step(0.1, "comparing with the photographs")
        started = time.perf_counter()
        found = fit(some, towards, seen, alike, lambertian)
        fit_s += (time.perf_counter() - started) * stack.radiance.shape[1] * stack.radiance.shape[2] / len(found)
        wanted = codes(some.radiance)
        inside += float(((codes(_predict(found, towards, alike, lambertian)) - wanted) ** 2).mean(dtype=np.float64))
        average = wanted.mean(axis=0)
        mean += float(((wanted - average) ** 2).mean(dtype=np.float64)) * (count / max(count - 1, 1)) ** 2
    out = np.nan
    if count > 4:
        out = 0.0
        folds = np.unique(np.linspace(0, count - 1, min(count, FOLDS)).round().astype(np.int64))
        for some, towards in _grid(stack, used, seen, LEFT_OUT_GRID, outside):
            for at, fold in enumerate(folds):
                yield Step(0.3 + 0.7 * at / len(folds), "leaving photographs out")
                others = np.flatnonzero(np.arange(count) != fold)
                found = fit(some.choose(others), towards[others], seen, alike, lambertian)
                shown = codes(_predict(found, towards[fold : fold + 1], alike, lambertian))
                out += float(((shown - codes(some.radiance[fold : fold + 1])) ** 2).mean(dtype=np.float64)) / len(folds)
    return RelitErrors(float(np.sqrt(inside)), float(np.sqrt(out)), float(np.sqrt(mean)), fit_s)


def _grid(
    stack: ImageStack, used: NDArray[np.int64], seen: Lamps, most: int, outside: NDArray[np.bool_] | None
) -> list[tuple[Texels, Array]]:
    """Texels of a regular grid of at most `most` that are not `outside`, and their lamps, as one block."""
    height, width = stack.radiance.shape[1:3]
    step = max(1, int(np.ceil(np.sqrt(height * width / most))))
    some = leave_out(texels(stack, used, step // 2, height, step), outside)
    return [(some, seen.observe_from(some.rows, some.columns, height, width))]


def _predict(found: Array, towards: Array, alike: Kinds, lambertian: bool) -> NDArray[np.float32]:
    """(N, T, 3) radiance of texels `found` by the kernel, through the maps that are made of them."""
    diffuse, specular = found[:, DIFFUSE : DIFFUSE + 3], found[:, SPECULAR : SPECULAR + 3]
    if not lambertian:
        variance = found[:, (VAR_DIFFUSE, VAR_SPECULAR, COV_REFLECTANCE)]
        made = metallic_roughness(diffuse, specular, variance)
        diffuse, specular = coefficients(made.base_colour, made.metallic[:, None], made.f0[:, None])
    image = np.empty((len(towards), len(found), 3), np.float32)
    show_texels(np.ascontiguousarray(found[:, :2]), found[:, ROUGHNESS], diffuse, specular, towards, image)
    return image * np.float32(alike.white)


def coefficients(base: Values, metallic: Values, f0: Values) -> tuple[Array, Array]:
    """ρ and F (T, 3) of metallic-roughness."""
    specular = f0 * (1.0 - metallic) + base * metallic
    return np.asarray(base * (1.0 - metallic) * (1.0 - specular), np.float64), np.asarray(specular, np.float64)


def _codes(radiance: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.asarray(255.0 * srgb_encode(np.clip(radiance, 0.0, 1.0)), np.float32)

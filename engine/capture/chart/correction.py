"""The correction of colours by a chart: white, a matrix, or root polynomials, whichever shows patches left out best.

    corrected = M φ(colour)

where φ are the three channels, or those and the square roots of their products (Finlayson2015, "Color correction using
root-polynomial regression", degree 2). All forms are homogeneous: twice the light gives twice the colour. The light on
the chart is uneven (vignetting, a near lamp); its logarithm, a plane and the squared distance from the middle, is
estimated with the correction where that shows patches left out better. Residuals are differences in L*a*b* under D50,
chroma scaled as ΔE2000 scales it.

The correction keeps the luminance of the chart's white: photographs keep the scale that exposures give them.
Cost: a second.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from engine.capture.chart.reference import LAB, REFERENCE_RGB, WHITE
from engine.core.colour import D65, LUMINANCE, XYZ_FROM_SRGB, adaptation
from engine.core.colour_difference import delta_e_2000, lab_from_xyz
from engine.images.colour_space import D50

Form = Literal["white", "matrix", "root-polynomial"]
FORMS: tuple[Form, ...] = ("white", "matrix", "root-polynomial")

#: A form with more numbers has to show patches left out better by this share.
_CLEARLY = 0.95

#: Patches that are needed for a correction, and the mean difference on patches left out up to which they are a chart.
MIN_PATCHES, MAX_HELD_OUT = 18, 8.0

#: Mean difference with a simpler form above which no other one is tried.
_HOPELESS = 16.0

_LAB_FROM_RGB = adaptation(D65, D50) @ XYZ_FROM_SRGB
_FOLDS = 6


@dataclass(frozen=True, eq=False)
class ColourCorrection:
    """A correction and how good it is; differences are ΔE2000.

    Attributes
    ----------
    form : 'white' (a factor for each channel), 'matrix' or 'root-polynomial'.
    matrix : (3, 3), or (3, 6) for root polynomials.
    before, after : (24,) differences of the patches from the published ones, NaN where a patch was clipped; before,
        brightness alone was fitted.
    held_out : mean difference of patches that were left out of the fit.
    measured, corrected : (24, 3) linear Rec. 709, with the light on the chart evened out, 1 for a perfect white.
    unevenness : difference of the light across the chart, as a share of its middle.
    crops : (24,) PNG of each patch as photographed, as bright as `measured`; empty where none were kept.
    """

    form: Form
    matrix: NDArray[np.float64]
    before: NDArray[np.float64]
    after: NDArray[np.float64]
    held_out: float
    measured: NDArray[np.float64]
    corrected: NDArray[np.float64]
    unevenness: float
    crops: tuple[bytes, ...] = ()

    def apply(self, radiance: NDArray[np.float32]) -> NDArray[np.float32]:
        """Corrected colours (H, W, 3), block of rows by block."""
        corrected = np.empty_like(radiance)
        matrix = self.matrix.T.astype(np.float32)
        for first in range(0, len(radiance), 256):
            corrected[first : first + 256] = _terms(radiance[first : first + 256], self.form) @ matrix
        return corrected


def lab_of(rgb: NDArray[np.float64]) -> NDArray[np.float64]:
    """L*a*b* under D50 of linear Rec. 709."""
    return lab_from_xyz(rgb @ _LAB_FROM_RGB.T)


def fit_correction(colours: NDArray[np.float64], positions: NDArray[np.float64]) -> ColourCorrection | None:
    """Fit the correction by patches of linear `colours` (24, 3), NaN for clipped ones, at `positions` (24, 2).

    None where the colours are not those of a chart.
    """
    usable = np.logical_and(np.isfinite(colours).all(axis=1), (colours > 0).any(axis=1))
    if usable.sum() < MIN_PATCHES:
        return None
    scale = _exposure(colours, usable)
    values = colours * scale
    terms = _unevenness_terms(positions)
    before = np.where(usable, delta_e_2000(lab_of(values), LAB), np.nan)
    best: tuple[float, Form, bool] | None = None
    for form in FORMS:
        if form == "root-polynomial" and best is not None and best[0] > _HOPELESS:
            return None
        for uneven in (False, True):
            error = _cross_validate(values, terms, form, uneven, usable)
            if best is None or error < _CLEARLY * best[0]:
                best = error, form, uneven
    assert best is not None
    held_out, form, uneven = best
    if not held_out <= MAX_HELD_OUT:
        return None
    matrix, light = _fit(values, terms, form, uneven, usable)
    evened = values / light[:, None]
    corrected = _terms(evened, form) @ matrix.T
    after = np.where(usable, delta_e_2000(lab_of(corrected), LAB), np.nan)
    white = float(LUMINANCE @ evened[WHITE]) / float(LUMINANCE @ corrected[WHITE]) if usable[WHITE] else 1.0
    spread = float(light[usable].max() - light[usable].min())
    return ColourCorrection(form, matrix * white, before, after, held_out, evened, corrected, spread)


def _exposure(colours: NDArray[np.float64], usable: NDArray[np.bool_]) -> float:
    """The factor by which the brightness of the patches is as published."""
    seen, known = colours[usable] @ LUMINANCE, REFERENCE_RGB[usable] @ LUMINANCE
    return float(np.exp(np.median(np.log(known / np.maximum(seen, 1e-9)))))


def _unevenness_terms(positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """(24, 3) column, row and squared distance from the middle of the chart, each over half of its size."""
    centred = positions - positions.mean(axis=0)
    centred = centred / np.abs(centred).max()
    return np.column_stack([centred, (centred**2).sum(axis=1)])


def _terms(values: Any, form: Form) -> Any:
    if form != "root-polynomial":
        return values
    some = np.maximum(values, 0)
    red, green, blue = some[..., 0], some[..., 1], some[..., 2]
    roots = np.sqrt(np.stack([red * green, green * blue, red * blue], axis=-1))
    return np.concatenate([values, roots], axis=-1)


def _fit(
    values: NDArray[np.float64], terms: NDArray[np.float64], form: Form, uneven: bool, used: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The matrix of `form`, and the light on each patch (24,), by the patches `used`."""
    start = np.diag(np.median(REFERENCE_RGB[used] / np.maximum(values[used], 1e-4), axis=0))
    chroma = np.hypot(LAB[used, 1], LAB[used, 2])
    weight = np.column_stack([np.ones_like(chroma), *[1.0 / (1.0 + 0.045 * chroma)] * 2])
    count = 6 if form == "root-polynomial" else 3

    def unpack(numbers: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        of_light = terms @ numbers[-3:] if uneven else np.zeros(len(terms))
        own = numbers[:-3] if uneven else numbers
        matrix = np.diag(own) if form == "white" else own.reshape(3, count)
        return matrix, np.exp(np.clip(of_light, -3.0, 3.0))

    def residual(numbers: NDArray[np.float64]) -> NDArray[np.float64]:
        matrix, light = unpack(numbers)
        found = _terms(values[used] / light[used, None], form) @ matrix.T
        return ((lab_of(found) - LAB[used]) * weight).ravel()

    first = np.diag(start) if form == "white" else np.hstack([start, np.zeros((3, count - 3))]).ravel()
    numbers = np.concatenate([first, np.zeros(3 if uneven else 0)])
    return unpack(least_squares(residual, numbers, method="lm", max_nfev=20 * (len(numbers) + 1)).x)


def _cross_validate(
    values: NDArray[np.float64], terms: NDArray[np.float64], form: Form, uneven: bool, usable: NDArray[np.bool_]
) -> float:
    """Mean difference of patches that a fit of the others shows; every sixth is left out at once."""
    order = np.random.default_rng(24).permutation(np.flatnonzero(usable))
    found = []
    for fold in range(_FOLDS):
        left = order[fold::_FOLDS]
        used = usable.copy()
        used[left] = False
        matrix, light = _fit(values, terms, form, uneven, used)
        shown = _terms(values[left] / light[left, None], form) @ matrix.T
        found.append(delta_e_2000(lab_of(shown), LAB[left]))
    return float(np.concatenate(found).mean())

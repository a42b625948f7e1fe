"""Quality of the photographs of a stack: figures for each, and plain verdicts that name the photograph.

Noise, sharpness and the error of leaving one photograph out are estimated on samples so that large stacks cost no
more than small ones: noise and sharpness in the middle square megapixel at full resolution, the error on a regular
grid of at most 65,536 pixels. Counts and means are taken over all pixels of the crop, where they are computed.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.capture.lights.azimuth_spread import ONE_ARC, azimuth_spread
from engine.core.figure_text import percent
from engine.core.health import Finding, Health, Verdict

#: Luminance below this part of the white level counts as black: less than one step of an 8-bit sRGB code.
BLACK = 1.0 / 4096.0

_WINDOW = 1024

#: Side of the square in which noise is told from the grain of the material, photographs that tell the grain of one,
#: and independent images that grain has under all lights: those of three lights, as far as it is matte.
_WINDOW_SIDE, _OTHERS, _GRAINS = 160, 16, 3

_SECOND_DIFFERENCES = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], np.float32)
_GRID_PIXELS = 65_536


@dataclass(frozen=True)
class Quality:
    """Figures of one photograph.

    Attributes
    ----------
    clipped_fraction, black_fraction : parts of the crop at the white level, and below `BLACK`.
    noise : standard deviation of what looks like white noise and no light explains, in units of the white level.
    sharpness : slope at one pixel over slope at four, which falls when an image is out of focus.
    alignment_residual_px : what the alignment left, None where it was not or could not be measured.
    leave_one_out_error : relative error of predicting the photograph from the others, None where it is black.
    """

    clipped_fraction: float
    black_fraction: float
    noise: float
    sharpness: float
    alignment_residual_px: float | None = None
    leave_one_out_error: float | None = None


def middle(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """The middle square megapixel of an image (H, W, …), in which noise and sharpness are measured."""
    height, width = image.shape[:2]
    top, left = max(0, (height - _WINDOW) // 2), max(0, (width - _WINDOW) // 2)
    return image[top : top + _WINDOW, left : left + _WINDOW]


def noise_and_sharpness(luminance: NDArray[np.float32]) -> tuple[float, float]:
    """Noise (Immerkær 1996, with a median so that texture weighs little) and sharpness of (H, W) luminance."""
    import cv2

    from engine.capture.registration.texture import slope

    window = np.ascontiguousarray(middle(luminance))
    noise = _deviation(cv2.filter2D(window, cv2.CV_32F, _SECOND_DIFFERENCES))
    fine, coarse = (float(slope(window, deviation).mean(dtype=np.float64)) for deviation in (1.0, 4.0))
    return noise, fine / coarse if coarse > 0.0 else 0.0


def _deviation(detail: NDArray[np.floating[Any]]) -> float:
    """The standard deviation of the noise whose second differences are `detail`."""
    return float(np.median(np.abs(detail))) / (6.0 * 0.6745)


def window_of(luminance: NDArray[np.float32]) -> NDArray[np.float32]:
    """A copy of the middle (h, w) of (H, W) luminance, at most 160 pixels a side."""
    height, width = luminance.shape
    side = min(_WINDOW_SIDE, height, width)
    top, left = (height - side) // 2, (width - side) // 2
    return luminance[top : top + side, left : left + side].copy()


def grain(window: NDArray[np.float32]) -> NDArray[np.float32]:
    """The second differences of (h, w) luminance: grain of the material, and noise; flat."""
    import cv2

    return cv2.filter2D(window, cv2.CV_32F, _SECOND_DIFFERENCES)[1:-1, 1:-1].ravel()


def noise_beside_grain(grains: Sequence[NDArray[np.float32]]) -> list[float]:
    """The noise of each photograph by its `grain`: what the photographs most like it do not show as well.

    The grain of a material is the same under all lights but for its brightness and the direction of its slopes, so
    that those photographs span it; a fixed pattern of the sensor counts as grain too. What is left holds a part of
    their noise as well, and grain where the camera moved: of two photographs alike it is sqrt(2) times the noise, of
    many little more than that.
    """
    seen = np.stack(grains).astype(np.float64)
    products = seen @ seen.T
    size = np.sqrt(np.maximum(np.diag(products), 1e-30))
    likeness = np.abs(products) / size / size[:, None]
    found = []
    for index, own in enumerate(seen):
        others = [at for at in np.argsort(-likeness[index], kind="stable") if at != index][:_OTHERS]
        values, vectors = np.linalg.eigh(products[np.ix_(others, others)])
        values, vectors = values[-_GRAINS:], vectors[:, -_GRAINS:]
        known = values > 1e-9 * max(values[-1], 1e-30)
        shares = np.where(known, vectors.T @ products[others, index] / np.where(known, values, 1.0), 0.0)
        found.append(_deviation(own - (vectors @ shares) @ seen[others]))
    return found


def grid_step(height: int, width: int) -> int:
    """Every how many pixels of rows and columns are taken for the leave-one-out error."""
    return max(1, math.ceil(math.sqrt(height * width / _GRID_PIXELS)))


def leave_one_out(samples: NDArray[np.float32], mean_radiance: NDArray[np.float64]) -> list[float | None]:
    """Relative error of each photograph as the shading map of the others would show it.

    Parameters
    ----------
    samples : (N, h, w, 3) radiance on a grid. mean_radiance : (N,) of the whole photographs.

    The others are interpolated at the photograph's mean radiance between the two that bracket it, black below the
    darkest; the brightest is scaled (Kautz2004 sections 3.2 and 4). The error is the root mean square over
    grid and channels, divided by the mean radiance; None for a photograph without light.
    """
    errors: list[float | None] = []
    for index, mean in enumerate(mean_radiance):
        others = [other for other in np.argsort(mean_radiance, kind="stable") if other != index]
        if not mean > 0.0 or not (mean_radiance[others] > 0.0).any():
            errors.append(None)
            continue
        predicted = bracket(samples, mean_radiance, others, float(mean))
        difference = predicted - samples[index]
        errors.append(float(np.sqrt(np.mean(difference * difference, dtype=np.float64)) / mean))
    return errors


def bracket(
    samples: NDArray[np.float32], means: NDArray[np.float64], others: Sequence[Any], mean: float
) -> NDArray[np.float32]:
    """A photograph of mean radiance `mean` from those of `others`, which are sorted by theirs; not all are black."""
    place = int(np.searchsorted(means[others], mean))
    if place == len(others):
        return samples[others[-1]] * np.float32(mean / means[others[-1]])
    above = others[place]
    below_mean = float(means[others[place - 1]]) if place else 0.0
    below = samples[others[place - 1]] if place else np.zeros_like(samples[above])
    weight = np.float32((mean - below_mean) / (float(means[above]) - below_mean)) if means[above] > below_mean else 0.0
    return below + np.float32(weight) * (samples[above] - below)


def report(
    names: Sequence[str],
    mean_radiance: NDArray[np.float64],
    qualities: Sequence[Quality],
    azimuth: NDArray[np.float64] | None = None,
) -> Health:
    """Verdicts on the photographs `names`, which are in the order of rising elevation.

    Where lamps stood on several sides (`azimuth`, radians), the order and the prediction by mean radiance say nothing
    against a photograph: they are those of a shading map, and a directional material is made instead.
    """
    several = azimuth_spread(azimuth) > ONE_ARC
    findings = [
        *judge_each(names, mean_radiance, qualities),
        *_about_alignment(names, qualities),
        *([] if several else [_about_order(names, mean_radiance)]),
        *_about_prediction(names, mean_radiance, qualities, several),
    ]
    errors = [quality.leave_one_out_error for quality in qualities if quality.leave_one_out_error is not None]
    residuals = [quality.alignment_residual_px for quality in qualities if quality.alignment_residual_px is not None]
    figures = {
        "clipped_fraction": max(quality.clipped_fraction for quality in qualities),
        "black_fraction": max(quality.black_fraction for quality in qualities),
        "noise": max(quality.noise for quality in qualities),
    }
    if errors:
        figures["leave_one_out_error"] = max(errors)
    if residuals:
        figures["alignment_residual_px"] = max(residuals)
    return Health(figures, tuple(findings))


def judge_each(names: Sequence[str], mean_radiance: NDArray[np.float64], qualities: Sequence[Quality]) -> list[Finding]:
    """Findings on the light, the noise and the focus of photographs, also while others are still missing."""
    return [
        *_about_light(names, qualities),
        *_about_noise(names, mean_radiance, qualities),
        *_about_focus(names, qualities),
    ]


def _about_light(names: Sequence[str], qualities: Sequence[Quality]) -> list[Finding]:
    findings = []
    for name, quality in zip(names, qualities, strict=True):
        if quality.clipped_fraction > 0.005:
            verdict = Verdict.WARNING if quality.clipped_fraction > 0.02 else Verdict.NOTE
            text = f"{percent(quality.clipped_fraction)} of the pixels are clipped; a shorter exposure would keep them"
            findings.append(Finding(verdict, text, name))
        if quality.black_fraction > 0.05:
            verdict = Verdict.WARNING if quality.black_fraction > 0.9 else Verdict.NOTE
            findings.append(Finding(verdict, f"{percent(quality.black_fraction)} of the pixels are black", name))
    return findings or [Finding(Verdict.GOOD, "Hardly a pixel is clipped or black")]


def _about_noise(names: Sequence[str], means: NDArray[np.float64], qualities: Sequence[Quality]) -> list[Finding]:
    findings = []
    for name, mean, quality in zip(names, means, qualities, strict=True):
        if quality.noise > 0.0 and mean < 20.0 * quality.noise:
            verdict = Verdict.WARNING if mean < 5.0 * quality.noise else Verdict.NOTE
            text = f"is noisy: its mean is {max(0.0, mean) / quality.noise:.1f} times the noise"
            findings.append(Finding(verdict, text, name))
    return findings


def _about_focus(names: Sequence[str], qualities: Sequence[Quality]) -> list[Finding]:
    usual = float(np.median([quality.sharpness for quality in qualities]))
    text = "looks blurred: {} of the usual sharpness of this stack"
    return [
        Finding(Verdict.WARNING, text.format(percent(quality.sharpness / usual)), name)
        for name, quality in zip(names, qualities, strict=True)
        if quality.sharpness < 0.6 * usual
    ]


def _about_alignment(names: Sequence[str], qualities: Sequence[Quality]) -> list[Finding]:
    findings = []
    for name, quality in zip(names, qualities, strict=True):
        residual = quality.alignment_residual_px
        if residual is not None and residual > 0.5:
            verdict = Verdict.WARNING if residual > 1.0 else Verdict.NOTE
            findings.append(Finding(verdict, f"alignment left {residual:.1f} px", name))
    return findings


def _about_order(names: Sequence[str], means: NDArray[np.float64]) -> Finding:
    falls = [after for (before, after) in itertools.pairwise(range(len(means))) if means[after] < 0.99 * means[before]]
    if not falls:
        return Finding(Verdict.GOOD, "Mean radiance grows with the elevation of the light")
    more = f" and {len(falls) - 3} more" if len(falls) > 3 else ""
    which = _join_names(names, falls[:3])
    text = f"Mean radiance does not grow with the elevation of the light: it falls at {which}{more}"
    return Finding(Verdict.WARNING, text)


def _about_prediction(
    names: Sequence[str], means: NDArray[np.float64], qualities: Sequence[Quality], several: bool
) -> list[Finding]:
    """The photographs that the others predict worst, of all and of those that they interpolate."""
    errors = np.array([quality.leave_one_out_error or 0.0 for quality in qualities])
    ends = {int(means.argmin()): "the darkest", int(means.argmax()): "the brightest"}
    inner = np.array([0.0 if at in ends else error for at, error in enumerate(errors)])
    findings = []
    for at in dict.fromkeys((int(errors.argmax()), int((inner if inner.any() else errors).argmax()))):
        verdict = Verdict.WARNING if errors[at] > 0.5 else Verdict.NOTE if errors[at] > 0.2 else Verdict.GOOD
        text = f"is predicted from the others with an error of {percent(errors[at])} of its mean radiance"
        if at in ends:  # which says little against it
            verdict, text = min(verdict, Verdict.NOTE), f"{text}: it is {ends[at]}, and extrapolated"
        else:
            text += ", the worst of all" if errors[at] == errors.max() else ", the worst of those that are interpolated"
        if several:
            verdict, text = min(verdict, Verdict.NOTE), f"{text}; a shading map, which does not know sides, predicts it"
        findings.append(Finding(verdict, text, names[at]))
    return findings


def _join_names(names: Sequence[str], places: Sequence[int]) -> str:
    return ", ".join(names[place] for place in places)

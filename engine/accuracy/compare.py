"""Error of an image against a reference: relative RMSE of linear radiance, ꟻLIP, and the largest difference.

Over the pixels p of the mask and the three channels, with a the image and b the reference,

    rmse_rel = ‖a − b‖ / ‖b‖,    max_abs = max |a − b|,    flip = mean of ꟻLIP (`engine.accuracy.flip`).

Pixels that are not finite in either image are left out and counted.

A Monte Carlo reference b = t + n is itself uncertain: E ‖a − b‖² = ‖a − t‖² + Σ v, where v is the variance of each of
its values. `error_against` takes that bias off and states what is left: with normal n the squared distance of a pixel
has at most the variance 4 ‖a − t‖² Σ v + 2 (Σ v)², sums over its channels, which it has where they rise and fall
together, as those of Monte Carlo do; pixels are independent. `error_against_parts` needs no variance: it multiplies
differences from independent parts of the reference.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from engine.accuracy.flip import LARGE_TILE, flip_map
from engine.core.steps import Steps, drain

Image = NDArray[Any]
Mask = NDArray[np.bool_]

#: An uncertainty is so many standard deviations: true in 95 % of all cases.
DEVIATIONS = 1.96


@dataclass(frozen=True)
class ImageError:
    """Error of an image against a reference.

    Attributes
    ----------
    rmse_rel : relative root mean square error, no unit; infinite where the reference is black and the image is not.
    flip : mean ꟻLIP in [0, 1].
    max_abs : largest difference of a channel, in radiance.
    pixels : how many were compared; invalid_pixels : how many of the mask were not finite in one of the two.
    """

    rmse_rel: float
    flip: float
    max_abs: float
    pixels: int
    invalid_pixels: int = 0


@dataclass(frozen=True)
class ErrorEstimate:
    """Relative RMSE against an uncertain reference: the truth is within ± `uncertainty` in 95 % of all cases."""

    rmse_rel: float
    uncertainty: float


def compare(a: Image, b: Image, mask: Mask | None = None, *, displayed: bool = False) -> ImageError:
    """The error of image `a` (H, W, 3 or more) against the reference `b`; further channels, as coverage, are ignored.

    `mask` (H, W) selects pixels. `displayed` tells ꟻLIP that both are what a screen shows, in [0, 1], and not radiance.
    ValueError where the shapes differ or no pixel is left to compare.
    """
    return drain(comparison(a, b, mask, displayed=displayed))


def comparison(
    a: Image, b: Image, mask: Mask | None = None, *, displayed: bool = False, tile: int = LARGE_TILE
) -> Steps[ImageError]:
    """`compare` in steps; `tile` is the side of the squares of which ꟻLIP is computed one at a time."""
    valid, invalid_pixels = _valid(a, b, mask)
    first, second = (np.asarray(image)[..., :3][valid].astype(np.float64) for image in (a, b))
    found = yield from flip_map(
        np.where(valid[..., None], a[..., :3], 0.0),
        np.where(valid[..., None], b[..., :3], 0.0),
        valid,
        displayed=displayed,
        tile=tile,
    )
    return ImageError(
        rmse_rel=_ratio(_length(first - second), _length(second)),
        flip=float(found[valid].mean(dtype=np.float64)),
        max_abs=float(np.abs(first - second).max()),
        pixels=len(first),
        invalid_pixels=invalid_pixels,
    )


def error_against(a: Image, reference: Image, variance: Image | float = 0.0, mask: Mask | None = None) -> ErrorEstimate:
    """Relative RMSE of `a` (H, W, 3) against the truth of which `reference` is an estimate.

    `variance` (H, W, 3) is that of the reference's own values (of the mean, not of a sample). ValueError as `compare`.
    """
    valid, _ = _valid(a, reference, mask)
    first, second = (np.asarray(image)[..., :3][valid].astype(np.float64) for image in (a, reference))
    noise = np.broadcast_to(variance, (*valid.shape, 3))[valid].astype(np.float64)
    apart = (first - second) ** 2
    total = max(float(np.sum(second**2 - noise)), 0.0)
    squared = max(float(np.sum(apart - noise)), 0.0)
    of_pixel, noise_of_pixel = np.sum(apart - noise, axis=-1), np.sum(noise, axis=-1)
    spread = max(float(np.sum(4.0 * of_pixel * noise_of_pixel)), 0.0) + float(np.sum(2.0 * noise_of_pixel**2))
    spread = DEVIATIONS * float(np.sqrt(spread))
    low, middle, high = (np.sqrt(max(value, 0.0)) for value in (squared - spread, squared, squared + spread))
    scale = float(np.sqrt(total))
    return ErrorEstimate(_ratio(middle, scale), _ratio(max(high - middle, middle - low), scale))


def error_against_parts(
    a: Image, parts: NDArray[Any], mask: Mask | None = None, *, relative_to_a: bool = False
) -> ErrorEstimate:
    """Relative RMSE of `a` (H, W, 3) against the truth of which `parts` (P, H, W, 3), P ≥ 3, are estimates.

    The parts are independent and equally good. Products of differences from two of them have no bias, whatever the
    noise is like, and how the result changes without each part tells its uncertainty (jackknife, Student's t). The
    error is relative to the truth, or to `a`. ValueError as `compare`, and for fewer parts.
    """
    count = len(parts)
    if count < 3:
        raise ValueError(f"{count} parts do not tell an uncertainty")
    valid, _ = _valid(a, parts.mean(axis=0), mask)
    first = np.asarray(a)[..., :3][valid].astype(np.float64).ravel()
    estimates = [np.asarray(part)[..., :3][valid].astype(np.float64).ravel() for part in parts]
    squared = _without_each(first - np.array(estimates))
    power = np.full(count + 1, np.dot(first, first)) if relative_to_a else _without_each(np.array(estimates))
    if not (power > 0.0).all():
        return ErrorEstimate(0.0, 0.0) if squared[0] <= 0.0 else ErrorEstimate(float("inf"), float("inf"))
    share, without = squared[0] / power[0], squared[1:] / power[1:]
    variance = (count - 1) / count * float(np.sum((without - without.mean()) ** 2))
    spread = float(stdtrit(count - 1, 0.975)) * variance**0.5
    low, middle, high = (float(np.sqrt(max(value, 0.0))) for value in (share - spread, share, share + spread))
    return ErrorEstimate(middle, max(high - middle, middle - low))


def _without_each(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """(P + 1,) the mean product of two different rows of `values` (P, N): of all rows, and without each."""
    count = len(values)
    total = values.sum(axis=0)
    own, with_all = np.einsum("pn,pn->p", values, values), values @ total
    whole = float(np.dot(total, total))
    every = (whole - own.sum()) / (count * (count - 1))
    without = (whole - 2.0 * with_all + own - (own.sum() - own)) / ((count - 1) * (count - 2))
    return np.concatenate([[every], without])


def noise_of(reference: Image, variance: Image, mask: Mask | None = None) -> float:
    """Relative RMSE that the noise of `reference` alone amounts to: the root of Σ v over that of Σ b²."""
    valid, _ = _valid(reference, reference, mask)
    noise = np.asarray(variance)[..., :3][valid].astype(np.float64)
    values = np.asarray(reference)[..., :3][valid].astype(np.float64)
    return _ratio(float(np.sqrt(noise.sum())), float(np.sqrt(max(np.sum(values**2 - noise), 0.0))))


def _valid(a: Image, b: Image, mask: Mask | None) -> tuple[Mask, int]:
    """(H, W) the pixels to compare, and how many of the mask are not finite."""
    if a.ndim != 3 or b.ndim != 3 or a.shape[:2] != b.shape[:2] or min(a.shape[2], b.shape[2]) < 3:
        raise ValueError(f"images of {a.shape} and {b.shape} cannot be compared")
    wanted = np.ones(a.shape[:2], np.bool_) if mask is None else np.asarray(mask, np.bool_)
    if wanted.shape != a.shape[:2]:
        raise ValueError(f"a mask of {wanted.shape} does not fit an image of {a.shape[:2]}")
    if not wanted.any():
        raise ValueError("the mask selects no pixel")
    finite = np.isfinite(a[..., :3]).all(axis=2) & np.isfinite(b[..., :3]).all(axis=2)
    valid = wanted & finite
    if not valid.any():
        raise ValueError("no pixel is finite in both images")
    return valid, int(np.sum(wanted & ~finite))


def _length(values: NDArray[np.float64]) -> float:
    """Euclidean norm without overflow."""
    top = float(np.abs(values).max())
    return top * float(np.sqrt(np.sum((values / top) ** 2))) if top > 0.0 else 0.0


def _ratio(part: float, whole: float) -> float:
    """`part` / `whole`; 0 where both are 0, infinite where only `whole` is."""
    if whole > 0.0:
        return float(part / whole)
    return 0.0 if part == 0.0 else float("inf")

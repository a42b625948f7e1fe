"""Shading maps: photographs resampled so that their mean radiance grows linearly (Kautz2004 Sec. 3.2).

Slice i has mean luminance r_i = i a_max / (S - 1) (Kautz2004 Eq. 1) and interpolates the two photographs whose means
BRACKET
r_i. The paper takes the two whose means are closest, which need not bracket and then extrapolates
(`test_X8_neighbours_bracket_the_target`). Below the darkest photograph the bracket's lower end is black, r_0 = 0.

Linearising copies the photographs tile by tile, about 50 MB at a time, reads each copy about twice and writes each
slice once; slices larger than half a gigabyte lie in a scratch file, so memory stays small for any number of pixels.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.colour import LUMINANCE
from engine.core.errors import InputError, UsageError
from engine.core.health import Finding, Health, Verdict
from engine.core.steps import Step, Steps
from engine.core.summary import Summary
from engine.shading.linearise import linearise_rows
from engine.shading.lookup import Above, layer_at, neighbours, share_and_gain
from engine.storage.scratch import release, scratch_array

if TYPE_CHECKING:
    from engine.capture.stack import ImageStack
    from engine.storage.file_array import FileArray

#: Texels of one tile over all slices, and over all photographs, about 50 ms of work.
TILE_TEXELS = 2**22

#: Largest relative distance between a slice's mean and its target before the stack's own figures are distrusted.
MEAN_TOLERANCE = 1e-4


@dataclass(frozen=True, eq=False, repr=False)
class ShadingMap(Summary):
    """Slices S(r) of a material; slice i has mean luminance r_i = i r_max / (S - 1), slice 0 is black.

    Attributes
    ----------
    slices : (S, H, W, 3) float32, S >= 2, linear sRGB, read as BRDF times cosine.
    r_max : the largest mean luminance of the photographs, a_max in the paper; positive.
    mean_radiance : (S,) float64, measured mean luminance of each slice.
    health : findings of the linearisation.
    clipped : (S, H, W) bool, True where a photograph that the slice sums was at its white level; None where nowhere.
    order : the photographs' places in the stack by rising mean radiance; empty where not known.
    """

    slices: NDArray[np.float32]
    r_max: float
    mean_radiance: NDArray[np.float64]
    health: Health = field(default_factory=Health)
    clipped: NDArray[np.bool_] | None = None
    order: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        shape = self.slices.shape
        if self.slices.dtype != np.float32 or len(shape) != 4 or shape[0] < 2 or shape[3] != 3 or 0 in shape:
            raise ValueError(f"slices must be (S >= 2, H, W, 3) float32, not {shape} {self.slices.dtype}")
        if not 0 < self.r_max < np.inf:
            raise ValueError(f"r_max = {self.r_max} is not a positive number")
        if self.mean_radiance.shape != shape[:1]:
            raise ValueError(f"{shape[0]} slices need as many means, not {self.mean_radiance.shape}")
        if self.clipped is not None and self.clipped.shape != shape[:3]:
            raise ValueError(f"clipped must be {shape[:3]}, not {self.clipped.shape}")
        for name in ("slices", "mean_radiance", "clipped"):
            array = getattr(self, name)
            if array is not None:
                view = array.view()
                view.flags.writeable = False
                object.__setattr__(self, name, view)

    @property
    def target_radiance(self) -> NDArray[np.float64]:
        """(S,) the mean luminance that each slice should have, Kautz2004 Eq. 1."""
        return target_radiance(self.r_max, len(self.slices))

    def lookup(self, row: ArrayLike, column: ArrayLike, r: ArrayLike, above: Above = "clamp") -> NDArray[np.float32]:
        """S(r) at texel coordinates, trilinear (Kautz2004 Sec. 4): (..., 3) float32, linear radiance under unit light.

        `row`, `column` (texel centres at half-integers, repeating) and `r` (BRDF times cosine) are broadcast
        together. Above r_max the brightest slice is taken as it is ('clamp') or times r / r_max ('scale').
        What is not a positive finite r is black.
        """
        row, column, r = np.broadcast_arrays(row, column, r)
        lower, share, gain = self._layer(r, above)
        result = np.zeros((*r.shape, 3))
        for rows, columns, weight in neighbours(row, column, *self.slices.shape[1:3]):
            result += (weight * (1.0 - share))[..., None] * self.slices[lower, rows, columns]
            result += (weight * share)[..., None] * self.slices[lower + 1, rows, columns]
        return (result * gain[..., None]).astype(np.float32)

    def slice_image(self, r: float, above: Above = "clamp") -> NDArray[np.float32]:
        """The whole image S(r), (H, W, 3) float32; equals `lookup` at every texel centre."""
        lower, share, gain = self._layer(np.float64(r), above)
        below, beyond = self.slices[int(lower)], self.slices[int(lower) + 1]
        return (gain * ((1.0 - share) * below + share * beyond)).astype(np.float32)

    def _layer(self, r: ArrayLike, above: Above) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
        """The slice below r, the share of the next one, and the gain."""
        share, gain = share_and_gain(r, self.r_max, above)
        return *layer_at(share, len(self.slices)), gain

    def summary(self) -> dict[str, Any]:
        """Return what `repr` says."""
        count, height, width, _ = self.slices.shape
        return {"slices": count, "size": f"{width} × {height} texels", "r_max": float(self.r_max)}


def target_radiance(r_max: float, slices: int) -> NDArray[np.float64]:
    """(S,) r_i = i r_max / (S - 1), Kautz2004 Eq. 1; both ends exact."""
    return np.linspace(0.0, r_max, slices)


def interpolation_weights(mean_radiance: ArrayLike, slices: int) -> NDArray[np.float64]:
    """Weight of each photograph in every slice: (S, N), entries in [0, 1], at most two groups per row.

    `mean_radiance` (N,) in any order. Photographs of equal mean share their weight equally; black is the implied
    photograph of mean 0, so those with a mean of 0 or below are not used, and rows may sum to less than 1.
    Raises ValueError unless slices >= 2, the means are finite and one of them is positive.
    """
    means = np.asarray(mean_radiance, dtype=np.float64)
    if slices < 2:
        raise UsageError(f"a shading map needs at least 2 slices, not {slices}")
    if means.ndim != 1 or not np.isfinite(means).all() or not (means > 0).any():
        raise ValueError("mean radiances must be finite and one of them positive")
    lit = np.flatnonzero(means > 0)
    levels, level_of, members = np.unique(means[lit], return_inverse=True, return_counts=True)
    knots = np.concatenate(([0.0], levels))
    targets = target_radiance(knots[-1], slices)
    upper = np.clip(np.searchsorted(knots, targets), 1, len(knots) - 1)
    share = (targets - knots[upper - 1]) / (knots[upper] - knots[upper - 1])

    of_knots = np.zeros((slices, len(knots)))
    row = np.arange(slices)
    of_knots[row, upper] = share
    of_knots[row, upper - 1] = 1.0 - share
    weights = np.zeros((slices, len(means)))
    weights[:, lit] = of_knots[:, 1 + level_of] / members[level_of]
    return weights


def build(
    stack: ImageStack, slices: int = 8, *, excluded: Collection[str] = (), tile_rows: int | None = None
) -> Steps[ShadingMap]:
    """Linearise a stack into `slices` slices whose mean luminance grows linearly from 0.

    Photographs named in `excluded` are not read. The means of the slices equal their targets to 4 ulp of float32. The
    result is bit-equal for every `tile_rows`.
    Raises InputError for a stack without light, with figures that do not belong to its pixels or with files that can
    be read no more, UsageError for fewer than two slices and for excluded names that the stack does not hold.
    """
    if slices < 2:
        raise UsageError(f"a shading map needs at least 2 slices, not {slices}")
    used = include(stack, excluded)
    check_light(stack, used)
    used_means = stack.mean_radiance[used]
    yield Step(0.0, "preparing to linearise")
    weights = np.zeros((slices, len(stack.radiance)))
    weights[:, used] = interpolation_weights(used_means, slices)
    linear, clipped, means = yield from _linearise(stack, weights, tile_rows)
    r_max = float(used_means.max())
    if not np.abs(means - target_radiance(r_max, slices)).max() <= MEAN_TOLERANCE * r_max:
        raise _other_pixels(stack)
    health = _health(stack, used, weights, clipped)
    release(clipped)
    order = tuple(int(photograph) for photograph in used[np.argsort(used_means, kind="stable")])
    return ShadingMap(linear, r_max, means, health, clipped if clipped.any() else None, order)


def sample_slices(radiance: NDArray[np.float32], means: NDArray[np.float64], slices: int) -> ShadingMap:
    """The shading map of some texels alone, with `radiance` (N, h, w, 3) in photographs of these `means` (N,).

    Its slices have the bits of those of `build`. Its means are the targets, and nothing is known of what is clipped.
    """
    photographs, packed = _pack(interpolation_weights(means, slices))
    shape = (slices, *radiance.shape[1:3])
    found, clipped, sums = np.empty((*shape, 3), np.float32), np.zeros(shape, np.bool_), np.empty(shape[:2])
    saturated = np.zeros(radiance.shape[:3], np.bool_)
    linearise_rows(np.ascontiguousarray(radiance), saturated, photographs, packed, LUMINANCE, 0, found, clipped, sums)
    r_max = float(means.max())
    return ShadingMap(found, r_max, target_radiance(r_max, slices))


def check_light(stack: ImageStack, used: NDArray[np.int64]) -> None:
    """Raise InputError unless the means of the photographs `used` are finite and one of them is positive."""
    where, means = stack.folder or "the stack", stack.mean_radiance[used]
    if not np.isfinite(means).all():
        raise InputError(where, "its mean radiance is not finite", "Import the photographs again")
    if not (means > 0).any():
        raise InputError(where, "no light: every photograph is black", "Check the exposure and the dark frame")


def check_brightest(stack: ImageStack, used: NDArray[np.int64]) -> None:
    """Raise InputError unless the largest mean of the photographs `used` is that of its pixels, which are read."""
    brightest = int(used[np.argmax(stack.mean_radiance[used])])
    _, height, width = stack.radiance.shape[:3]
    rows, sums = max(1, TILE_TEXELS // (4 * width)), np.zeros(3 * width)
    for start in range(0, height, rows):
        band = np.asarray(stack.radiance[brightest, start : start + rows])
        sums += band.reshape(len(band), -1).sum(axis=0, dtype=np.float64)
    mean = float(sums.reshape(-1, 3).sum(axis=0) @ LUMINANCE) / (height * width)
    r_max = float(stack.mean_radiance[brightest])
    if not abs(mean - r_max) <= MEAN_TOLERANCE * r_max:
        raise _other_pixels(stack)


def _other_pixels(stack: ImageStack) -> InputError:
    problem = "its mean radiances do not belong to its pixels"
    return InputError(stack.folder or "the stack", problem, "Import the photographs again")


def include(stack: ImageStack, excluded: Collection[str]) -> NDArray[np.int64]:
    """The places in the stack of the photographs that are not named in `excluded`.

    Raises UsageError for names that the stack does not hold, InputError where no photograph is left.
    """
    unknown = sorted(set(excluded) - set(stack.sources))
    if unknown:
        raise UsageError(f"the stack holds no photograph called {', '.join(unknown)}")
    used = np.flatnonzero([source not in excluded for source in stack.sources])
    if used.size == 0:
        raise InputError(stack.folder or "the stack", "every photograph is excluded", "Include some of them")
    return used


def _linearise(
    stack: ImageStack, weights: NDArray[np.float64], tile_rows: int | None
) -> Steps[tuple[NDArray[np.float32], NDArray[np.bool_], NDArray[np.float64]]]:
    """The weighted sums of the photographs, tile by tile, where they are clipped, and their mean luminances."""
    _, height, width = stack.radiance.shape[:3]
    used = np.flatnonzero(weights.any(axis=0))
    photographs, packed = _pack(weights[:, used])
    linear = scratch_array((len(weights), height, width, 3), np.float32, stack.folder)
    clipped = scratch_array((len(weights), height, width), np.bool_, stack.folder)
    sums = np.empty((len(weights), height))
    rows = tile_rows or max(1, TILE_TEXELS // (width * max(len(weights), len(used))))
    for start in range(0, height, rows):
        stop = min(start + rows, height)
        radiance, saturated = (_part(array, used, start, stop) for array in (stack.radiance, stack.saturated))
        slices = (np.asarray(linear), np.asarray(clipped), sums)
        linearise_rows(np.ascontiguousarray(radiance), saturated, photographs, packed, LUMINANCE, start, *slices)
        for array in (stack.radiance, linear, clipped):
            release(array)
        yield Step(stop / height, "linearising")
    return linear, clipped, sums.sum(axis=1) / (height * width)


def _pack(weights: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """The non-zero entries of each row moved to its front: photographs and weights, (S, M)."""
    most = max(1, int((weights > 0).sum(axis=1).max()))
    order = np.argsort(weights <= 0, axis=1, kind="stable")[:, :most]
    return np.ascontiguousarray(order), np.ascontiguousarray(np.take_along_axis(weights, order, axis=1))


def _part(array: NDArray[Any] | FileArray, photographs: NDArray[np.int64], start: int, stop: int) -> NDArray[Any]:
    """A copy of the rows [start, stop) of some photographs."""
    return np.ascontiguousarray(array[photographs, start:stop])


def _health(
    stack: ImageStack, used: NDArray[np.int64], weights: NDArray[np.float64], clipped: NDArray[np.bool_]
) -> Health:
    means, sources = stack.mean_radiance[used], [stack.sources[photograph] for photograph in used]
    findings = []
    for place in np.flatnonzero(np.diff(means) < 0) + 1:
        text = (
            f"darker on average ({means[place]:.4g}) than the photograph at the light's elevation before it "
            f"({means[place - 1]:.4g}); sorted by mean radiance"
        )
        findings.append(Finding(Verdict.WARNING, text, sources[place]))
    for place in np.flatnonzero(means <= 0):
        findings.append(Finding(Verdict.WARNING, "black on average; not used", sources[place]))
    for source in sorted(set(stack.sources) - set(sources)):
        findings.append(Finding(Verdict.NOTE, "excluded; not used", source))
    if len(means) == 1:
        findings.append(Finding(Verdict.WARNING, "one photograph: every slice is a darker copy of it"))
    elif len(np.unique(means)) < len(means):
        findings.append(Finding(Verdict.NOTE, "photographs of equal mean radiance were averaged"))
    from_black = int((weights.sum(axis=1) > 0).sum() - np.isclose(weights.sum(axis=1), 1.0).sum())
    if means.min() > 0:
        text = f"slice 0 is black by definition; the darkest photograph has a mean radiance of {means.min():.4g}"
        findings.append(Finding(Verdict.NOTE, f"{text}, {from_black} slices between them are darkened copies of it"))
    figures = {
        "slices_below_darkest_photograph": float(from_black),
        "clipped_fraction": float(clipped.mean()),
    }
    return Health(MappingProxyType(figures), tuple(findings))

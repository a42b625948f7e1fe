"""Parallel and crossed photographs as diffuse and specular parts, and what must be measured for that.

The lamp has a linear polariser, and so has the camera. Light that enters a material and leaves it again has lost its
polarisation: half of it passes the camera's polariser in any position. Light that is reflected at the surface keeps it:
all of it passes the parallel polariser and none the crossed one, but for the share ε that real polarisers leak. With D
and S the diffuse and specular radiance of the sample in unpolarised light, halved so that a white card keeps its
brightness in the parallel photograph P, the photographs under one lamp are

    P = D + 2 S,    X = g (D + 2 ε S),

with g the gain of crossed photographs over parallel ones: exposure, transmission of the filters and lamps that changed,
for each channel (Debevec2000 Sec. 4, Ma2007 Sec. 4). Then 2 S = (P − X/g) / (1 − ε), D = P − 2 S, and the radiance
without polarisers is D + S. Room light is not polarised, and shows alike in P and X/g.

The gain follows from the photographs themselves, since S is a lobe and D is not: P is regressed on X and on a GGX lobe
about the normal n that X shows, P_i = u X_i + F (s_i(r) + κ n·l_i). F and the roughness r belong to each texel, u = 1/g
and κ are common: κ stands for what lobes of materials have more or less than GGX far from the highlight, which would
else pass for diffuse light; colours and brightness that differ over the image tell both apart, as F does not follow the
diffuse colour. F is eliminated (Golub1973), Gauss-Newton steps find the rest. Its standard deviation has the scatter
over blocks of the image and over groups of lamps, and the change of u where only the photographs with the weaker half
of the lobe are looked at. A uniform grey sample, a metal, or a lobe that is all but matte do not tell g, which then has
to be measured on a matte white patch.

The leak is the regression of what X shows above the diffuse part on 2 S, in highlights that are brighter than D.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.capture.calibration.separation import Separation
from engine.core.errors import UsageError
from engine.core.figure_text import percent
from engine.texel.kernel import COLUMNS, DIFFUSE, S_R, C, S, differentiate, fit_texels

Array = NDArray[np.float64]

#: Texels that are looked at, and the least number that tell.
TEXELS, MIN_TEXELS = 1200, 40

#: Values of roughness from which the fit of a texel starts, and mean and deviation of the prior.
ROUGHNESS_STARTS, ROUGHNESS_PRIOR = (0.15, 0.22, 0.32, 0.45, 0.62, 0.85), (0.5, 0.3)

#: Least and largest roughness, the largest step, and iterations of the fit at most with the change at which they end.
ROUGHNESS_RANGE, MAX_STEP, ITERATIONS, SETTLED = (0.12, 1.0), 0.1, 25, 2e-4

#: Deviation of the prior of the matte share of lobes.
BROAD_PRIOR = 3.0

#: Residuals, over their median, beyond which a photograph does not count.
OUTLIER = 6.0

#: Parts of the image along a side, and groups of lamps, of the jackknife.
BLOCKS, GROUPS = 4, 4

#: Relative standard deviation of a gain that is not used, the least one that is stated, that of pairs of which one
#: photograph was moved, and the factor by which lobes of other shapes than the model's (Beckmann, two lobes, relief
#: within a texel) make deviations larger: found on 70 generated captures.
MAX_GAIN_SIGMA, MIN_GAIN_SIGMA, MOVED_GAIN_SIGMA, GROWTH = 0.01, 0.001, 0.0025, 1.6

#: Standard deviations above zero from which a leak is believed, and the highlights that tell it.
LEAK_EVIDENCE, MIN_HIGHLIGHTS = 3.0, 30

#: Leak that is worth taking off, and rounds in which it is sought.
MIN_LEAK, LEAK_ROUNDS = 2e-4, 3


@dataclass(frozen=True, eq=False)
class PairTexels:
    """Texels of pairs, sampled and not averaged: averages over relief have other lobes.

    Attributes
    ----------
    parallel, crossed : (T, N, 3) radiance in both photographs.
    usable : (T, N) where neither is clipped.
    lights : (N, T or 1, 3) irradiance by each lamp over π, as a vector.
    block : (T,) part of the image in which each texel lies.
    room : (T, 3) radiance by room light in the crossed photographs, or None.
    moved : whether photographs were sampled between their pixels.
    """

    parallel: Array
    crossed: Array
    usable: NDArray[np.bool_]
    lights: Array
    block: NDArray[np.int64]
    room: Array | None = None
    moved: bool = False


def texel_grid(height: int, width: int) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Rows, columns and blocks (T,) of the texels of an image that are looked at."""
    across = min(width, max(1, round(np.sqrt(TEXELS * width / height))))
    down = min(height, max(1, round(TEXELS / across)))
    rows, columns = (
        each.ravel()
        for each in np.meshgrid(
            ((np.arange(down) + 0.5) * height / down).astype(np.int64),
            ((np.arange(across) + 0.5) * width / across).astype(np.int64),
            indexing="ij",
        )
    )
    return rows, columns, rows * BLOCKS // height * BLOCKS + columns * BLOCKS // width


def separate(texels: PairTexels, gain: float | None) -> Separation:
    """What turns pairs into their parts; `gain` is stated where it is not None.

    Raises UsageError where the texels do not tell it.
    """
    some = _sample(texels)
    if gain is None and len(some.parallel) < MIN_TEXELS:
        raise UsageError("too few texels are lit in both photographs of the pairs")
    if gain is not None:
        stated = np.full(3, gain)
        return Separation(stated, np.zeros(3), *_leak(some, stated), stated=True)
    whole = _fit(some, np.ones(some.parallel.shape[:2], np.bool_))
    inverse, squares = whole.inverse, [whole.sigma**2]
    if some.count >= 2 * GROUPS:
        groups = [_fit(some, np.arange(some.count)[None] % GROUPS != each, whole.roughness) for each in range(GROUPS)]
        apart = [(each.inverse - inverse) ** 2 for each in groups]
        squares.append((GROUPS - 1) * np.mean(apart, axis=0))
        share = whole.specular.mean(axis=-1) / np.maximum(whole.diffuse.mean(axis=-1), 1e-9)
        weak = share <= np.median(share, axis=1, keepdims=True)
        squares.append((_solve_with_lobes(some, weak, whole) - inverse) ** 2)
    least = MOVED_GAIN_SIGMA if texels.moved else MIN_GAIN_SIGMA
    deviations = GROWTH * np.sqrt(np.sum(squares, axis=0) + (least * inverse) ** 2)
    found = 1.0 / inverse
    sigma = deviations / inverse * found
    if not (np.isfinite(sigma).all() and (sigma <= MAX_GAIN_SIGMA * found).all()):
        worst = float(np.nanmax(sigma / found)) if np.isfinite(sigma).any() else float("inf")
        raise UsageError(f"their brightness over each other is known to {percent(worst)} only")
    return Separation(found, sigma, *_leak(some, found))


@dataclass(frozen=True, eq=False)
class _Sample:
    """Texels as in `PairTexels`, of which crossed photographs tell slopes (T, 2) and ρ (T, 3); the first axis of the
    lights runs along their arc where they do not tell slopes across it."""

    parallel: Array
    crossed: Array
    usable: NDArray[np.bool_]
    lights: Array
    across_free: bool
    block: NDArray[np.int64]
    slopes: Array
    diffuse: Array
    room: Array

    @property
    def count(self) -> int:
        return self.parallel.shape[1]


def _sample(texels: PairTexels) -> _Sample:
    """The texels that are bright enough."""
    usable = texels.usable & np.isfinite(texels.parallel + texels.crossed).all(axis=-1)
    parallel, crossed = (np.where(usable[..., None], each, 0.0) for each in (texels.parallel, texels.crossed))
    bright, grey = parallel.mean(axis=(1, 2)), crossed.mean(axis=(1, 2))
    kept = (bright > 0.05 * np.quantile(bright, 0.9)) & (usable.sum(axis=1) >= 4) & (grey > 0.0)
    lights = texels.lights if texels.lights.shape[1] == 1 else texels.lights[:, kept]
    towards, across_free = _turn_to_arc(np.ascontiguousarray(lights))
    room = np.zeros((1, 1, 3)) if texels.room is None else texels.room[kept][:, None]
    parallel, crossed, usable = parallel[kept], crossed[kept], usable[kept]
    slopes, diffuse = _matte(crossed - room, usable, towards, across_free)
    return _Sample(parallel, crossed, usable, towards, across_free, texels.block[kept], slopes, diffuse, room)


def _matte(values: Array, usable: NDArray[np.bool_], lights: Array, across_free: bool) -> tuple[Array, Array]:
    """Slopes (T, 2) and ρ (T, 3) of a matte surface of radiance (T, N, 3), by the robust fit of a texel."""
    found = np.zeros((len(values), COLUMNS))
    shown = np.ascontiguousarray(values.swapaxes(0, 1), np.float32)
    seen, shares = np.ascontiguousarray(usable.T), np.ones((len(lights), 2))
    kind = np.zeros(len(found), np.int64)
    fit_texels(shown, seen, lights, shares, across_free, np.array([[0.5, 0.25, 0.04, 0.02]]), kind, True, found)
    return np.ascontiguousarray(found[:, :2]), found[:, DIFFUSE : DIFFUSE + 3]


def _turn_to_arc(lights: Array) -> tuple[Array, bool]:
    """Lights with the first axis along their arc, and whether they tell slopes across it as well."""
    middle = lights.mean(axis=1)
    _, spread, axes = np.linalg.svd(middle / np.linalg.norm(middle, axis=1, keepdims=True), full_matrices=False)
    if len(spread) > 2 and spread[2] > 0.1 * spread[1]:
        return lights, True
    turn = np.arctan2(-axes[-1, 0], axes[-1, 1])
    cosine, sine = np.cos(turn), np.sin(turn)
    along = cosine * lights[..., 0] + sine * lights[..., 1]
    across = cosine * lights[..., 1] - sine * lights[..., 0]
    return np.ascontiguousarray(np.stack([along, across, lights[..., 2]], axis=-1)), False


def _solve_with_lobes(some: _Sample, use: NDArray[np.bool_], whole: _Fit) -> Array:
    """u (3,) of some photographs, with the lobes that were found with all."""
    weight = _weights(whole.inverse * whole.diffuse + whole.specular, some.usable & use)[..., None]
    upper = (weight * whole.diffuse * (some.parallel - whole.specular)).sum(axis=1)
    lower = (weight * whole.diffuse * some.crossed).sum(axis=1)
    return np.asarray(np.median(upper / np.maximum(lower, 1e-300), axis=0))


def _fit(some: _Sample, use: NDArray[np.bool_], roughness: Array | None = None) -> _Fit:
    """Gauss-Newton steps of u and of the roughness of texels, from the best of `ROUGHNESS_STARTS` or a known one."""
    parallel, crossed, usable = some.parallel, some.crossed, some.usable & use
    own = np.empty((len(parallel), 7, some.count))
    differentiate(some.slopes, np.full(len(own), 0.5), some.lights, own)
    shown = np.maximum(some.diffuse[:, None] * own[:, C, :, None], 0.0)  # crossed photographs without their noise
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(usable[..., None] & (crossed > 0.0), parallel / crossed, np.nan)
        lit = np.asarray(np.isfinite(ratio).all(axis=-1)).any(axis=1)
        inverse = np.nanmedian(np.nanquantile(ratio[lit], 0.3, axis=1), axis=0)
    model = inverse * shown
    if roughness is None:
        roughness = _start(some, usable, inverse, model, own)
    sigma = np.ones(len(parallel))
    scores = curvature = np.zeros((0, 4))
    broad = 0.0
    for _ in range(ITERATIONS):
        differentiate(some.slopes, roughness, some.lights, own)
        received, slope = own[:, C, :, None], own[:, S_R, :, None]
        lobe = own[:, S, :, None] + broad * received
        weight = _weights(model, usable)
        strength, residual = _specular(weight, parallel - inverse * crossed, lobe)
        off = np.abs(residual).mean(axis=-1) * np.sqrt(weight)
        seen = (weight > 0.0).any(axis=1)
        median = np.full(len(off), np.inf)
        median[seen] = np.nanmedian(np.where(weight > 0.0, off, np.nan)[seen], axis=1) + 1e-9
        weight = np.where(off < OUTLIER * median[:, None], weight, 0.0)
        strength, residual = _specular(weight, parallel - inverse * crossed, lobe)
        sigma = 1.4826 * median
        along = _without(weight, strength[:, None] * slope, lobe)
        wide = strength[:, None] * received
        # instruments: the crossed photographs as their fit shows them, whose noise is not that of the photographs
        across, across_wide = _without(weight, shown, lobe), _without(weight, wide, lobe)
        w = weight[..., None]
        prior = (sigma / ROUGHNESS_PRIOR[1]) ** 2
        rr = (w * along**2).sum(axis=(1, 2)) + prior
        by_r = np.column_stack([(w * along * crossed).sum(axis=1), (w * along * wide).sum(axis=(1, 2))])
        of_r = np.column_stack([(w * along * across).sum(axis=1), (w * along * across_wide).sum(axis=(1, 2))])
        gr = (w * along * residual).sum(axis=(1, 2)) - prior * (roughness - ROUGHNESS_PRIOR[0])
        precise = np.where(sigma < 4.0 * np.median(sigma[seen]), 1.0 / np.maximum(sigma, 1e-6) ** 2, 0.0)
        curvature = -(of_r[:, :, None] * by_r[:, None, :]) / rr[:, None, None]
        curvature[:, range(3), range(3)] += (w * across * crossed).sum(axis=1)
        curvature[:, :3, 3] += (w * across * wide).sum(axis=1)
        curvature[:, 3, :3] += (w * across_wide * crossed).sum(axis=1)
        curvature[:, 3, 3] += (w * across_wide * wide).sum(axis=(1, 2))
        scores = np.column_stack([(w * across * residual).sum(axis=1), (w * across_wide * residual).sum(axis=(1, 2))])
        scores = scores - of_r * (gr / rr)[:, None]
        curvature, scores = precise[:, None, None] * curvature, precise[:, None] * scores
        own_prior = np.diag([0.0, 0.0, 0.0, BROAD_PRIOR**-2])
        total = curvature.sum(axis=0) + own_prior
        step = np.linalg.solve(total, scores.sum(axis=0) - own_prior @ np.array([0.0, 0.0, 0.0, broad]))
        step = np.clip(step, [*(-0.2 * inverse), -0.3], [*(0.2 * inverse), 0.3])
        turned = (gr - (by_r * step).sum(axis=1)) / rr
        inverse, broad = inverse + step[:3], float(broad + step[3])
        roughness = np.clip(roughness + np.clip(turned, -MAX_STEP, MAX_STEP), *ROUGHNESS_RANGE)
        model = inverse * shown + strength[:, None] * lobe
        if np.abs(step[:3]).max() < SETTLED * inverse.min() and abs(step[3]) < SETTLED:
            break
    blocks = np.unique(some.block)
    bread = np.linalg.inv(total)
    sums = np.array([scores[some.block == each].sum(axis=0) for each in blocks])
    sums = sums - scores.sum(axis=0) / len(blocks)
    covariance = bread @ (sums.T @ sums) @ bread.T * len(blocks) / max(len(blocks) - 1, 1)
    return _Fit(inverse, np.sqrt(np.maximum(np.diag(covariance)[:3], 0.0)), roughness, strength[:, None] * lobe, shown)


@dataclass(frozen=True, eq=False)
class _Fit:
    """u (3,) with its deviation by blocks of the image, roughness (T,), and (T, N, 3) F s and the diffuse part of X."""

    inverse: Array
    sigma: Array
    roughness: Array
    specular: Array
    diffuse: Array


def _start(some: _Sample, usable: NDArray[np.bool_], inverse: Array, model: Array, own: Array) -> Array:
    """(T,) the roughness of `ROUGHNESS_STARTS` whose lobe explains most."""
    costs, rest = [], some.parallel - inverse * some.crossed
    weight = _weights(model, usable)
    for roughness in ROUGHNESS_STARTS:
        differentiate(some.slopes, np.full(len(own), roughness), some.lights, own)
        _, residual = _specular(weight, rest, own[:, S, :, None])
        costs.append((np.sqrt(weight)[..., None] * np.abs(residual)).sum(axis=(1, 2)))
    return np.asarray(np.array(ROUGHNESS_STARTS)[np.argmin(costs, axis=0)])


def _weights(model: Array, usable: NDArray[np.bool_]) -> Array:
    """(T, N) inverse squares of the brightness of a photograph of a texel as it is fitted."""
    grey = model.mean(axis=-1)
    floor = 0.1 * grey.mean(axis=1, keepdims=True) + 1e-9
    return np.asarray(np.where(usable, 1.0 / (np.maximum(grey, 0.0) + floor) ** 2, 0.0))


def _specular(weight: Array, rest: Array, lobe: Array) -> tuple[Array, Array]:
    """F (T, 3), zero or more, of what is left of P, and the residuals (T, N, 3)."""
    w = weight[..., None]
    strength = np.maximum((w * rest * lobe).sum(axis=1) / np.maximum((w * lobe**2).sum(axis=1), 1e-300), 0.0)
    return np.asarray(strength), np.asarray(rest - strength[:, None] * lobe)


def _without(weight: Array, values: Array, lobe: Array) -> Array:
    """(T, N, 3) `values` without their part along the lobe."""
    w = weight[..., None]
    share = (w * values * lobe).sum(axis=1) / np.maximum((w * lobe**2).sum(axis=1), 1e-300)
    return np.asarray(values - share[:, None] * lobe)


def _leak(some: _Sample, gain: Array) -> tuple[float, float]:
    """The leak and its standard deviation; 0 where it is not told or not more than chance.

    What leaks is in the diffuse part that crossed photographs show as well, so that it is taken off and sought again.
    """
    even = (some.crossed - some.room) / gain
    parallel = some.parallel - some.room / gain
    polarised = (parallel - even).mean(axis=-1)
    leak, sigma = 0.0, float("nan")
    for _ in range(LEAK_ROUNDS):
        share = leak / (1.0 - leak)
        rest = even - share * (parallel - even)
        slopes, diffuse = _matte(rest, some.usable, some.lights, some.across_free)
        own = np.empty((len(slopes), 7, some.count))
        differentiate(slopes, np.full(len(own), 0.5), some.lights, own)
        shown = (diffuse[:, None] * own[:, C, :, None]).mean(axis=-1)
        bright = some.usable & (polarised > shown) & (shown > 0.0)
        if bright.sum() < MIN_HIGHLIGHTS:
            return 0.0, float("nan")
        weight = np.where(bright, 1.0 / np.where(bright, polarised + shown, 1.0), 0.0)
        upper, lower = weight * (rest.mean(axis=-1) - shown) * polarised, weight * polarised**2
        blocks = [some.block == each for each in np.unique(some.block)]
        sums = np.array([(upper[each].sum(), lower[each].sum()) for each in blocks])
        more = float(sums[:, 0].sum() / sums[:, 1].sum())
        sigma = float(np.sqrt(((sums[:, 0] - more * sums[:, 1]) ** 2).sum()) / sums[:, 1].sum())
        ratio = max(share + more, 0.0)  # of (1 − ε) 2 S
        leak = ratio / (1.0 + ratio)
    return (leak, sigma) if leak > max(LEAK_EVIDENCE * sigma, MIN_LEAK) else (0.0, sigma)

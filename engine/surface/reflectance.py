"""Slopes and reflectance of all texels of a stack, and their conversion to metallic-roughness.

Where the photographs of one texel do not tell its roughness and reflectance, texels that look alike do: k-means of the
root of their mean colour makes a few kinds, a sample of texels is fitted with a prior that hardly speaks, and each
kind's mean and spread are the prior of all its texels (empirical Bayes).

Covariances of a fit take residuals to be independent. Those of a model are not: a shadow, a bounce of light or a lobe
of another shape errs alike in lamps that stand together. So texels of the sample are fitted without one block of lamps
after the other, and the variance of these estimates (jackknife of blocks, Kunsch1989) over the stated one is the factor
by which all variances of a kind grow.

The diffuse part of a kind may fall otherwise than Lambert's: its fall-off is the one of three parameters that leaves
least unexplained in the photographs of a texel which are explained best, by rank, as shadows and bounced light follow
no fall-off. Lambert's stays where it leaves nearly as little.

Radiance has the unit of a white card that faces a lamp. `white` says how bright it is in the photographs: the white
level, unless texels are brighter, whose reflectance would then exceed one.

Pairs under polarisers tell both parts apart: the crossed photograph shows the diffuse part alone, the parallel one the
diffuse and twice the specular part (`engine.capture.calibration.polarisation`). Both are fitted together, so that
slopes and ρ follow from photographs without highlights, and roughness and F from what the other has more.
Memory: the block of rows that is being fitted, and the maps.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.capture.stack import ImageStack
from engine.core.budget import block_values
from engine.core.colour import REC_709
from engine.core.steps import Step, Steps, part
from engine.shading.directional.left_out import Texels
from engine.storage.file_array import FileArray
from engine.surface import metal_kernel
from engine.surface.depth_edges import find_shadows
from engine.surface.fall_off import find_falls
from engine.surface.lamps import Lamps
from engine.surface.metal_kernel import METAL_EVIDENCE, convert_texels
from engine.surface.pbr_maps import DIELECTRIC_F0
from engine.texel.kernel import (
    COLUMNS,
    COV_AB,
    COV_REFLECTANCE,
    DIFFUSE,
    DIFFUSE_BY_R,
    ROUGHNESS,
    SPECULAR,
    SPECULAR_BY_R,
    VAR_A,
    VAR_B,
    VAR_DIFFUSE,
    VAR_ROUGHNESS,
    VAR_SPECULAR,
    A,
    B,
    fit_texels,
    show_kinds,
    show_texels,
    weigh_fall_off,
)

Array = NDArray[np.float64]

#: Texels of the sample that tells the kinds, and the number of kinds.
SAMPLE, KINDS = 4096, 6

#: Values of all photographs in a block of rows at most, and bytes that one takes while it is fitted.
BLOCK_VALUES, VALUE_BYTES = 1 << 24, 64

#: Mean and deviation of roughness, and of the reflectance F: where photographs are enough to tell them, and where not.
WIDE, NARROW = (0.5, 0.25, 0.05, 0.3), (0.5, 0.25, DIELECTRIC_F0, 0.02)

#: The same of kinds that are found to be metals.
GLOSSY = (0.5, 0.25, 0.6, 0.5)

#: Photographs that are enough for the one, and for either; from fewer, surfaces are taken to be diffuse.
ENOUGH, FEWEST_FOR_GLOSS = 8, 6

#: Least deviations of a kind in roughness and F, and texels in which a kind is known.
MIN_SPREAD, MIN_KNOWN = (0.02, 0.01), 16

#: Largest reflectance F of kinds that are taken for dielectrics. Theirs is silent where there is no highlight, since a
#: very rough one is all but diffuse; a wide prior would then find none, and no dielectric has none.
BRIGHTEST_DIELECTRIC = 0.06

#: A kind without a known F is a metal all the same where a brighter F leaves less than this part of what F near 0.04
#: leaves unexplained: highlights that are narrow beside the steps from lamp to lamp tell no texel's F. Of 13 generated
#: materials, dielectrics leave 0.95 and more, and kinds of such metals 0.7 and less.
EXPLAINED_AS_WELL = 0.9

#: What a kind without highlights may leave unexplained, over what it leaves with them, to be taken for matte: of few
#: photographs, which the additional parameters show better by chance, and of `ENOUGH`. Generated matte surfaces leave
#: 0.98 to 1.07 and 0.98 to 1.01, and plastics of roughness 0.4 2.2 and more.
MATTE_AS_WELL = 1.1, 1.03

#: Deviation of the roughness of all texels together: light that bounces and lobes of another shape err alike under all
#: lamps, and so does a kind's prior of F, with which roughness moves. ρ and F move with it. Found on 24 generated
#: materials; `python -m benchmarks --only surface-sigma` counts the texels of others.
ROUGHNESS_DEVIATION = 0.03

#: Blocks of neighbouring lamps, the photographs in one at least, and every which texel of the sample they are tried on.
BLOCKS, FEWEST_IN_BLOCK, EVERY = 8, 2, 4

#: Share of texels whose variance of slopes grows by less, of photographs so few that a highlight in one of them is not
#: told from a slope.
FEW_SHARE = 0.75

#: Photographs that two slopes and a reflectance need.
MIN_OBSERVED = 3

#: Mean residual of a fit without shadows, over that with them, below which it counts.
EXPLAINED_BETTER = 0.8

#: Photographs from which fall-offs are found, every which texel of the sample they are found on, and of these every
#: which they are looked for on at first; the share of a texel's photographs, those that are explained best, by which
#: they are judged, and parts that are left out in turn.
ENOUGH_FOR_FALL, FALL_EVERY, ROUGHLY, FALL_SHARE, FALL_FOLDS = 12, 8, 4, 0.7, 4

#: Share of texels that may be brighter than white.
ABOVE_WHITE = 1e-3

#: Shares of the diffuse and of the specular part that photographs through crossed and parallel polarisers show.
CROSSED, PARALLEL = (1.0, 0.0), (1.0, 2.0)

#: Values of metallic that are tried.
METALLIC = np.linspace(0.0, 1.0, metal_kernel.STEPS + 1)


@dataclass(frozen=True, eq=False)
class Kinds:
    """Texels that look alike: `colour` (K, 3) roots of mean colours, `priors` (K, 4) as `WIDE`; and `white`.

    `growth` (K, 4) are the factors, 1 or more, of the variances of slopes, roughness, ρ and F; `deviation` is that of
    the roughness by which all texels may err alike. The slopes of kinds that are `matte` (K,) are those of a surface
    without highlights, which shows the photographs as well: a lobe that is not there would bend them. `falls` (K, 3)
    are the fall-off of the diffuse part of each (`engine.texel.kernel`), None where all are Lambert's, and `doubt` (K,)
    is the variance of slopes that follows from not knowing it.
    """

    colour: Array
    priors: Array
    white: float
    growth: Array
    deviation: float = 0.0
    matte: NDArray[np.bool_] | None = None
    falls: Array | None = None
    doubt: Array | float = 0.0

    def of(self, values: NDArray[np.float32]) -> NDArray[np.int64]:
        """(T,) the kind of texels of radiance (N, T, 3)."""
        colour = _colour(values)
        return np.asarray(((colour[:, None] - self.colour[None]) ** 2).sum(axis=-1).argmin(axis=1))


@dataclass(frozen=True, eq=False)
class Reflectance:
    """Metallic-roughness of texels and one standard deviation of each, (T, …) as in `PbrMaps`, and by how many squared
    deviations a metal explains each better than a dielectric."""

    base_colour: Array
    metallic: Array
    f0: Array
    base_colour_sigma: Array
    metallic_sigma: Array
    f0_sigma: Array
    metal_evidence: Array


def texels(stack: ImageStack, used: NDArray[np.int64], first: int, last: int, step: int = 1) -> Texels:
    """Every `step`-th texel of rows, in the working space of the stack."""
    width = stack.radiance.shape[2]
    lines, columns = range(first, last, step), np.arange(step // 2, width, step)
    shape = (len(used), len(lines), len(columns))

    def read(array: NDArray[Any] | FileArray) -> NDArray[Any]:
        if step == 1:
            return np.asarray(array[used, first:last])
        found = np.empty((*shape, *array.shape[3:]), array.dtype)
        for place, photograph in enumerate(used):
            found[place] = array[int(photograph), first:last:step][:, columns]
        return found

    rows, across = np.meshgrid(np.array(lines), columns, indexing="ij")
    count, space = len(used), stack.working_space
    matrix = space.from_rec709.T.astype(np.float32)

    def colours(array: NDArray[Any] | FileArray) -> NDArray[np.float32]:
        values = read(array).reshape(count, -1, 3)
        return values if space == REC_709 else np.ascontiguousarray(values @ matrix)

    return Texels(
        colours(stack.radiance),
        ~read(stack.saturated).reshape(count, -1),
        rows.ravel(),
        across.ravel(),
        None if stack.diffuse is None else colours(stack.diffuse),
    )


def leave_out(texels: Texels, outside: NDArray[np.bool_] | None) -> Texels:
    """The texels that are not `outside` (H, W); all where none would be left."""
    if outside is None or not outside.any():
        return texels
    inside = np.flatnonzero(~outside[texels.rows, texels.columns])
    return texels.take(inside) if len(inside) else texels


def fit(texels: Texels, towards: Array, lamps: Lamps, kinds: Kinds, lambertian: bool = False) -> Array:
    """(T, COLUMNS) of `engine.texel.kernel` for texels under the light (N, T or 1, 3).

    ρ of kinds with a fall-off is that of the Lambertian surface which is nearest under these lamps, as maps show it.
    """
    return _as_lambertian(_fit(texels, towards, lamps, kinds, lambertian), texels, towards, kinds)


def _as_lambertian(found: Array, texels: Texels, towards: Array, kinds: Kinds) -> Array:
    """The same texels with ρ of the nearest Lambertian surface."""
    if kinds.falls is not None:
        share = np.empty(len(found))
        slopes = np.ascontiguousarray(found[:, :2])
        weigh_fall_off(slopes, towards, kinds.falls, kinds.of(texels.radiance), share)
        found[:, DIFFUSE : DIFFUSE + 3] *= share[:, None]
        found[:, VAR_DIFFUSE] *= share**2
        found[:, COV_REFLECTANCE] *= share
        found[:, DIFFUSE_BY_R] *= share
    return found


def _fit(texels: Texels, towards: Array, lamps: Lamps, kinds: Kinds, lambertian: bool = False) -> Array:
    """The same with ρ of what faces lamp and viewer."""
    found = np.zeros((texels.radiance.shape[1], COLUMNS))
    values, usable, shares = texels.radiance, texels.usable, np.ones((len(texels.radiance), 2))
    if texels.diffuse is not None and lambertian:
        values = texels.diffuse
    elif texels.diffuse is not None:
        values = np.concatenate([texels.diffuse, 2.0 * values - texels.diffuse])
        usable, towards = np.concatenate([usable, usable]), np.concatenate([towards, towards])
        shares = np.repeat(np.array([CROSSED, PARALLEL]), len(texels.radiance), axis=0)
    scaled = np.ascontiguousarray(values / np.float32(kinds.white))
    both, kind = lamps.observed.kind == "both", kinds.of(texels.radiance)
    usable = np.ascontiguousarray(usable)
    priors = kinds.priors if kinds.falls is None else np.hstack([kinds.priors, kinds.falls])
    fit_texels(scaled, usable, towards, shares, both, priors, kind, lambertian, found)
    if kinds.matte is not None and not lambertian and kinds.matte[kind].any():
        at = np.flatnonzero(kinds.matte[kind])
        own, plain = towards[:, at] if towards.shape[1] > 1 else towards, np.zeros((len(at), COLUMNS))
        some, some_usable = np.ascontiguousarray(scaled[:, at]), np.ascontiguousarray(usable[:, at])
        fit_texels(some, some_usable, own, shares, both, priors, kind[at], True, plain)
        for column in (A, B, VAR_A, VAR_B, COV_AB):
            found[at, column] = plain[:, column]
    growth = kinds.growth[kind]
    found[:, [VAR_A, VAR_B, COV_AB]] *= growth[:, :1]
    found[:, [VAR_A, VAR_B]] += np.broadcast_to(kinds.doubt, len(kinds.growth))[kind][:, None]
    found[:, [VAR_ROUGHNESS, VAR_DIFFUSE, VAR_SPECULAR]] *= growth[:, 1:]
    found[:, COV_REFLECTANCE] *= np.sqrt(growth[:, 2] * growth[:, 3])
    found[:, VAR_ROUGHNESS] += kinds.deviation**2
    by_diffuse, by_specular = kinds.deviation * found[:, [DIFFUSE_BY_R, SPECULAR_BY_R]].T
    found[:, VAR_DIFFUSE] += by_diffuse**2
    found[:, VAR_SPECULAR] += by_specular**2
    found[:, COV_REFLECTANCE] += by_diffuse * by_specular
    return found


def kinds(
    stack: ImageStack,
    used: NDArray[np.int64],
    lamps: Lamps,
    white: float | None = None,
    outside: NDArray[np.bool_] | None = None,
) -> Steps[Kinds]:
    """The kinds of a stack's texels, from a sample without those `outside` (H, W); `white` where it is known."""
    from scipy.cluster.vq import kmeans2

    height, width = stack.radiance.shape[1:3]
    step = max(1, int(np.ceil(np.sqrt(height * width / SAMPLE))))
    yield Step(0.0, "looking for texels that are alike")
    some = leave_out(texels(stack, used, step // 2, height, step), outside)
    towards = lamps.observe_from(some.rows, some.columns, height, width)
    colour = _colour(some.radiance)
    count = min(KINDS, len(np.unique(colour, axis=0)))
    centres, label = kmeans2(colour, count, minit="++", seed=1)
    start = np.array([WIDE if len(used) >= ENOUGH else NARROW])
    one = Kinds(np.zeros((1, 3)), start, white or 1.0, np.ones((1, 4)))
    yield Step(0.2, "fitting a sample of texels")
    found = _fit(some, towards, lamps, one, len(used) < FEWEST_FOR_GLOSS)
    if white is None:
        brightest = float(np.quantile(found[:, DIFFUSE : DIFFUSE + 3].max(axis=1), 1.0 - ABOVE_WHITE))
        one = Kinds(one.colour, start, max(1.0, brightest), one.growth)
        found[:, DIFFUSE : DIFFUSE + 6] /= one.white
    of_kind = label == np.arange(count)[:, None]
    one = Kinds(centres, np.repeat(start, count, axis=0), one.white, np.ones((count, 4)))
    if len(used) < FEWEST_FOR_GLOSS:
        growth = yield from part(_growth(some, towards, lamps, one, lambertian=True), 0.5, 1.0)
        return replace(one, growth=growth)

    is_separated = some.diffuse is not None  # slopes follow from photographs without highlights

    def unexplained(found: Array, kinds: Kinds | None = None) -> Array:
        return np.asarray(of_kind @ _measure_unexplained(some, towards, found, kinds or one))

    def measure_bare(kinds: Kinds) -> Array:
        return np.full(count, np.inf) if is_separated else unexplained(_fit(some, towards, lamps, kinds, True), kinds)

    bare = measure_bare(one)
    if len(used) >= ENOUGH_FOR_FALL:
        bald = one if is_separated else _find_falls(some, towards, lamps, one, True)
        one = _find_falls(some, towards, lamps, one)
        found = found if one.falls is None else _fit(some, towards, lamps, one)
        bare = measure_bare(bald)
        # a lobe takes up what a fall-off explains, so that either is found with the other or without it
        is_plain = bare < MATTE_AS_WELL[1] * unexplained(found)
        if is_plain.any() and (bald.falls is not None or one.falls is not None):
            none = np.zeros((count, 3))
            of_either = [none if each.falls is None else each.falls for each in (bald, one)]
            doubt = np.where(is_plain, bald.doubt, one.doubt)
            one = replace(one, falls=np.where(is_plain[:, None], *of_either), doubt=doubt)
            found = _fit(some, towards, lamps, one)
    if len(used) < ENOUGH:
        matte = bare < MATTE_AS_WELL[0] * unexplained(found)
        one = replace(one, matte=matte)
        growth = yield from part(_growth(some, towards, lamps, one), 0.5, 1.0)
        return replace(one, growth=growth)
    priors = np.array([_prior(found[texels], start[0], one.white) for texels in of_kind])
    plain = priors[:, 2] < BRIGHTEST_DIELECTRIC
    if plain.any():
        trying = [replace(one, priors=np.repeat([prior], count, axis=0)) for prior in (NARROW, GLOSSY)]
        narrow, glossy = (_fit(some, towards, lamps, each) for each in trying)
        left, least = unexplained(narrow), unexplained(found)
        upper = [np.quantile(found[texels, SPECULAR : SPECULAR + 3], 0.75) for texels in of_kind]
        for kind in np.flatnonzero(plain):
            if upper[kind] > BRIGHTEST_DIELECTRIC and least[kind] < EXPLAINED_AS_WELL * left[kind]:
                priors[kind] = _prior(glossy[of_kind[kind]], np.array(GLOSSY), 1.0)
            else:
                priors[kind] = *_prior(narrow[of_kind[kind]], start[0], 1.0)[:2], *NARROW[2:]
    alike = replace(one, priors=priors)
    matte = bare < MATTE_AS_WELL[1] * unexplained(_fit(some, towards, lamps, alike))
    alike = replace(alike, matte=matte)
    growth = yield from part(_growth(some, towards, lamps, alike), 0.5, 1.0)
    return replace(alike, growth=growth, deviation=ROUGHNESS_DEVIATION)


def _find_falls(texels: Texels, towards: Array, lamps: Lamps, kinds: Kinds, lambertian: bool = False) -> Kinds:
    """The kinds with their fall-off, of surfaces with highlights or without."""
    count = len(kinds.colour)

    def choose(every: int) -> tuple[Texels, Array]:
        """Every so many texels, and their light."""
        return texels.choose(slice(None), every), towards[:, ::every] if towards.shape[1] > 1 else towards

    def add_up(some: Texels, off: NDArray[np.float32]) -> Array:
        """(K,) sums of the photographs that are explained best: shadows are explained by no fall-off."""
        best = np.sort(np.where(some.usable, off, 0.0), axis=0)[: max(1, int(FALL_SHARE * len(off)))]
        of_kind = kinds.of(some.radiance) == np.arange(count)[:, None]
        return np.asarray(of_kind @ best.sum(axis=0, dtype=np.float64))

    def measure_on(some: Texels, lit: Array, falls: Array) -> Array:
        trial = replace(kinds, falls=falls)
        found = _fit(some, lit, lamps, trial, lambertian)
        return add_up(some, np.abs(_residuals(some, lit, found, trial)).sum(axis=-1))

    some, lit = choose(FALL_EVERY)
    of_kind = kinds.of(some.radiance) == np.arange(count)[:, None]
    measure = partial(measure_on, some, lit)
    roughly = partial(measure_on, *choose(ROUGHLY * FALL_EVERY))

    def predict(falls: Array) -> Array:
        trial, every = replace(kinds, falls=falls), np.arange(len(some.radiance))
        off = np.empty(some.usable.shape, np.float32)
        for first in range(FALL_FOLDS):
            out = every[first::FALL_FOLDS]
            rest = np.setdiff1d(every, out)
            found = _fit(some.choose(rest), lit[rest], lamps, trial, lambertian)
            off[out] = np.abs(_residuals(some.choose(out), lit[out], found, trial)).sum(axis=-1)
        return add_up(some, off)

    falls, others = find_falls(count, measure, predict, roughly)
    kinds, doubt = replace(kinds, falls=falls), np.zeros(count)
    best = _fit(some, lit, lamps, kinds, lambertian)[:, :2]
    for other, as_well in others:
        if as_well.any():
            apart = _fit(some, lit, lamps, replace(kinds, falls=other), lambertian)[:, :2] - best
            square = of_kind @ (apart**2).mean(axis=1) / np.maximum(of_kind.sum(axis=1), 1)
            doubt = np.where(as_well, np.maximum(doubt, square), doubt)
    return replace(kinds, doubt=doubt)


def _measure_unexplained(texels: Texels, towards: Array, found: Array, kinds: Kinds) -> Array:
    """(T,) sums of absolute residuals of texels `found` by the kernel, in units of white."""
    off = np.abs(_residuals(texels, towards, found, kinds))
    return np.asarray(off.sum(axis=-1, where=texels.usable[..., None], dtype=np.float64).sum(axis=0))


def _residuals(texels: Texels, towards: Array, found: Array, kinds: Kinds) -> NDArray[np.float32]:
    """(N, T, 3) radiance less that of texels `found` by the kernel, in units of white."""
    diffuse, specular = found[:, DIFFUSE : DIFFUSE + 3], found[:, SPECULAR : SPECULAR + 3]
    shown, slopes = np.empty(texels.radiance.shape, np.float32), found[:, :2]
    if kinds.falls is None:
        show_texels(slopes, found[:, ROUGHNESS], diffuse, specular, towards, shown)
    else:
        kind = kinds.of(texels.radiance)
        show_kinds(slopes, found[:, ROUGHNESS], diffuse, specular, towards, kinds.falls, kind, shown)
    return np.asarray(texels.radiance / np.float32(kinds.white) - shown)


def _growth(texels: Texels, towards: Array, lamps: Lamps, kinds: Kinds, *, lambertian: bool = False) -> Steps[Array]:
    """(K, 4) how many times larger variances are than those of independent residuals, by a jackknife of blocks.

    Few photographs are blocks of one, and the variance of slopes alone grows: `FEW_SHARE` of texels has less. Three
    have no block that could be missed.
    """
    total = len(texels.radiance)
    if total <= MIN_OBSERVED:
        return np.ones_like(kinds.growth)
    is_few = total < ENOUGH
    count = total if is_few else min(BLOCKS, total // FEWEST_IN_BLOCK)
    growth = np.ones_like(kinds.growth)
    texels = texels.choose(slice(None), EVERY)
    towards = towards[:, ::EVERY] if towards.shape[1] > 1 else towards
    both = lamps.observed.kind == "both"
    order = np.argsort(np.arctan2(lamps.direction[:, 1], lamps.direction[:, 0]) if both else towards[:, 0, 0])
    apart = []
    for block, out in enumerate(np.array_split(order, count)):
        yield Step(block / count, "leaving neighbouring lamps out")
        others = np.setdiff1d(order, out)
        apart.append(_fit(texels.choose(others), towards[others], lamps, kinds, lambertian))
    stated = _fit(texels, towards, lamps, kinds, lambertian)
    squares = (count - 1) * np.var(np.stack(apart)[..., : SPECULAR + 3], axis=0)
    slopes = (squares[:, 0] + squares[:, 1]) / (stated[:, VAR_A] + (stated[:, VAR_B] if both else 0.0))
    factors = np.column_stack(
        [
            slopes,
            squares[:, ROUGHNESS] / stated[:, VAR_ROUGHNESS],
            squares[:, DIFFUSE:SPECULAR].mean(axis=1) / stated[:, VAR_DIFFUSE],
            squares[:, SPECULAR:].mean(axis=1) / stated[:, VAR_SPECULAR],
        ]
    )
    kind = kinds.of(texels.radiance)
    for each in range(len(growth) if is_few else 0):
        known = slopes[(kind == each) & np.isfinite(slopes)]
        if len(known):
            growth[each, 0] = max(np.quantile(known, FEW_SHARE), 1.0)
    for each in range(0 if is_few else len(growth)):
        known = factors[(kind == each) & np.isfinite(factors).all(axis=1)]
        if len(known) >= MIN_KNOWN:
            growth[each] = np.maximum(np.median(known, axis=0), 1.0)
    return growth


def metallic_roughness(
    diffuse: Array, specular: Array, variance: Array, evidence: float | Array = METAL_EVIDENCE
) -> Reflectance:
    """The metallic-roughness nearest to the coefficients ρ and F (T, 3), in the metric of their errors.

    `variance` (T, 3) are the variances of ρ and F and their covariance. A texel is a dielectric unless a metal explains
    it better by `evidence`, in squared deviations, and then a pure metal unless a mixture does. ρ = base (1 − metallic)
    (1 − F) and F = f0 (1 − metallic) + base metallic.
    """
    given = np.column_stack([diffuse, specular, variance]).astype(np.float64, copy=False)
    found = np.empty((len(given), metal_kernel.FOUND))
    convert_texels(given, np.broadcast_to(evidence, len(given)).astype(np.float64), METALLIC, found)
    return Reflectance(
        found[:, metal_kernel.BASE : metal_kernel.BASE + 3],
        found[:, metal_kernel.METALLIC],
        found[:, metal_kernel.F0],
        found[:, metal_kernel.BASE_SIGMA : metal_kernel.BASE_SIGMA + 3],
        found[:, metal_kernel.METALLIC_SIGMA],
        found[:, metal_kernel.F0_SIGMA],
        found[:, metal_kernel.EVIDENCE],
    )


def fit_rows(
    stack: ImageStack,
    used: NDArray[np.int64],
    lamps: Lamps,
    kinds: Kinds,
    lambertian: bool = False,
    beside_edges: NDArray[np.bool_] | None = None,
    outside: NDArray[np.bool_] | None = None,
) -> Steps[None]:
    """Fit block after block of rows; each step's `partial` is (first, last, found).

    Texels `beside_edges` (H, W) are fitted without the photographs in which they are dark, where these show the others
    far better: where more than half of the lamps are hidden, a robust fit takes those that are not for outliers. Texels
    `outside` (H, W) are taken to be black.
    """
    count, height, width = len(used), stack.radiance.shape[1], stack.radiance.shape[2]
    values = block_values(BLOCK_VALUES, VALUE_BYTES)
    block = max(1, values // (3 * count * width * (1 if stack.diffuse is None else 2)))
    for first in range(0, height, block):
        last = min(first + block, height)
        some = texels(stack, used, first, last)
        if outside is not None and outside[first:last].any():
            covered = ~outside[first:last].ravel()[:, None]
            diffuse = None if some.diffuse is None else some.diffuse * covered
            some = replace(some, radiance=some.radiance * covered, diffuse=diffuse)
        towards = lamps.observe_from(some.rows, some.columns, height, width)
        found = _fit(some, towards, lamps, kinds, lambertian)
        if beside_edges is not None and beside_edges[first:last].any():
            shadows = find_shadows(stack, used, first, last)
            at = np.flatnonzero(beside_edges[first:last].ravel() & shadows.any(axis=0))
            own = towards[:, at] if towards.shape[1] > 1 else towards
            near = some.take(at)
            lit = replace(near, usable=near.usable & ~shadows[:, at])
            other = _fit(lit, own, lamps, kinds, lambertian)
            # what is dark beside the highlight of a metal is no shadow, and explained with the rest
            left = [
                _measure_unexplained(each, own, values, kinds) / np.maximum(each.usable.sum(axis=0), 1)
                for each, values in ((near, found[at]), (lit, other))
            ]
            better = left[1] < EXPLAINED_BETTER * left[0]
            found[at[better]] = other[better]
        found = _as_lambertian(found, some, towards, kinds)
        yield Step(last / height, "finding slopes and reflectance", (first, last, found))


def _prior(found: Array, start: Array, white: float) -> Array:
    """Means and deviations of roughness and F in the texels of one kind."""
    specular = found[:, SPECULAR : SPECULAR + 3].mean(axis=1)
    pairs = (
        (found[:, ROUGHNESS], found[:, VAR_ROUGHNESS], start[:2], MIN_SPREAD[0]),
        (specular, found[:, VAR_SPECULAR] / (3.0 * white * white), start[2:], MIN_SPREAD[1]),
    )
    made: list[float] = []
    for value, variance, (mean, spread), least in pairs:
        known = np.isfinite(variance) & (variance < 0.25 * spread**2)
        if known.sum() < MIN_KNOWN:
            made += [mean, spread]
            continue
        middle = float(np.median(value[known]))
        apart = (1.4826 * float(np.median(np.abs(value[known] - middle)))) ** 2 - float(np.median(variance[known]))
        made += [middle, float(np.sqrt(max(apart, least**2)))]
    return np.array(made)


def _colour(values: NDArray[np.float32]) -> Array:
    """(T, 3) roots of the mean colour of texels of radiance (N, T, 3)."""
    return np.sqrt(np.maximum(values.mean(axis=0, dtype=np.float64), 0.0))

"""Which terms of a rig the photographs tell, and how well.

All sets of terms are fitted. Of those in which each term lowers the error on photographs held out by more than chance,
and by more than a model that fits badly may pretend, the one of least error is accepted. Terms are fitted on half of
the image (a chequerboard of blocks) and judged on the other half, where each photograph of a texel is predicted from
the others. Chance is judged by the scatter over blocks.

Texels are matte first; where that model errs and highlights explain the photographs clearly better, they are glossy.

Intervals join that scatter with a jackknife over groups of lamps, since what the model of a texel lacks (gloss,
shadows, light that bounces) errs alike over the image but not from lamp to lamp.

Cost: 1 s of one core for 64 photographs of matte texels and 4 s of glossy ones, whatever their size. Sets of terms and
halves of the image are fitted side by side.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from engine.capture.calibration.rig import TERMS, Array, Fit, Kind, Rig, Sample, fit, measure_held_out, typical
from engine.core.colour import srgb_encode
from engine.core.figure_text import number, percent
from engine.core.kernels import serial_kernels
from engine.core.one_thread import one_thread
from engine.core.side_by_side import list_side_by_side

#: Least number of lamps from which each term is estimated.
FEWEST = {"distance": 6, "gains": 9, "ambient": 8}

#: Share of the held-out error that a term has to take away, and deviations of its mean over blocks.
MIN_GAIN, SURE = {"distance": 0.08, "gains": 0.1, "ambient": 0.08}, 4.0

#: Held-out error, over the brightness of a texel, up to which the model of a texel is good enough for each term, and
#: the share that a term has to take away beyond it.
GOOD, LARGE_GAIN = {"distance": 0.05, "gains": 0.12, "ambient": 0.03}, {"distance": 0.25, "gains": 0.25, "ambient": 1.0}

#: Share by which another set of terms may leave a larger held-out error than the accepted ones and is as likely, the
#: deviation of a share beyond which it is less so, and the largest share that is looked at.
UNDECIDED, LESS_LIKELY, MAX_SHARE = 0.05, 0.15, 0.5

#: Angle in degrees by which other sets of terms that are as likely turn half of the normals at most, without a warning.
MAX_UNDECIDED_DEG = 2.25

#: Held-out error from which the model of a texel tells nothing.
HOPELESS = 0.18

#: Held-out error below which a matte model is good enough, the share of it that a glossy one may leave, and the share
#: that it has to leave under the terms of the matte one, or under all, for its other sets of terms to be fitted.
MATTE_ENOUGH, CLEARLY_GLOSSY, MAYBE_GLOSSY = 0.004, 0.8, 0.95

#: Held-out error of matte texels up to which the rig that they tell is as likely as that of glossy ones.
MATTE_FITS = 0.008

#: Inverse distances from which the fit of glossy texels starts as well.
STARTS = (0.5,)

#: Texels of the sample to which the glossy model is fitted.
GLOSSY_TEXELS = 300

#: Radiance of texels that are looked at, at least: of the white level, and over the brightest.
DARKEST, DARKEST_SHARE = 0.003, 0.03

#: Texels of the sample, groups of lamps of the jackknife, and blocks along a row of the image.
TEXELS, GROUPS, BLOCKS = 1000, 4, 6

#: Largest room light over a lamp that is believed.
MAX_AMBIENT = 0.6


@dataclass(frozen=True)
class Term:
    """One term of a rig as it was found.

    Attributes
    ----------
    name : one of `rig.TERMS`.
    accepted : whether the photographs tell it.
    text : a sentence for the user.
    held_out_before, held_out_after : error on photographs left out, in 8-bit levels, without and with the term.
    normals_change_deg : angle that 95 % of normals change by at most.
    sigma : standard deviation: of the inverse distance, of the logarithm of gains, or of room light over a lamp.
    """

    name: str
    accepted: bool
    text: str
    held_out_before: float
    held_out_after: float
    normals_change_deg: float
    sigma: float

    def as_json(self) -> dict[str, Any]:
        return dict(vars(self))


@dataclass(frozen=True, eq=False)
class Estimate:
    """A rig, what is said about each of its terms, and the held-out error over the brightness of a texel.

    `kind` is the model of a texel that the photographs fit. `undecided_deg` is the angle by which normals change under
    other sets of terms that show the photographs about as well: in the middle of the image, and more for each width of
    distance from it, to be joined as independent errors are; 0 where the model of a texel is hopeless, and says nothing
    of normals. `rival_deg` is the angle that half of the normals change by under those that are as likely.
    """

    rig: Rig
    terms: tuple[Term, ...]
    held_out: float
    kind: Kind = "matte"
    undecided_deg: tuple[float, float] = (0.0, 0.0)
    rival_deg: float = 0.0

    @property
    def accepted(self) -> tuple[str, ...]:
        return tuple(term.name for term in self.terms if term.accepted)


def describe_undecided(rival_deg: float) -> str:
    """A sentence where other sets of terms turn half of the normals by too much; '' elsewhere.

    `rival_deg` is that of an `Estimate`.
    """
    if rival_deg <= MAX_UNDECIDED_DEG:
        return ""
    return (
        "The photographs do not decide how they were lit: another distance or intensity of the lamps, or room light, "
        f"explains them as well and turns half of the normals by more than {number(rival_deg, 2)}°. State what is "
        "known (--lamp-distance, --dark, a .lights file)"
    )


def sample_texels(
    photographs: Sequence[NDArray[np.float32]], clipped: Sequence[NDArray[np.float32]], most: int = TEXELS
) -> Sample:
    """A regular grid of texels of small linear photographs (h, w, 3), with shares of clipped samples (h, w)."""
    height, width = photographs[0].shape[:2]
    across = min(width, max(1, round(np.sqrt(most * width / height))))
    numbers = (min(height, max(1, round(most / across))), across)
    evenly = [
        ((np.arange(n) + 0.5) * size / n).astype(np.int64) for n, size in zip(numbers, (height, width), strict=True)
    ]
    rows, columns = (each.ravel() for each in np.meshgrid(*evenly, indexing="ij"))
    values = np.stack([photograph[rows, columns].mean(axis=-1, dtype=np.float64) for photograph in photographs], axis=1)
    usable = np.stack([share[rows, columns] <= 0.0 for share in clipped], axis=1) & np.isfinite(values)
    values = np.where(np.isfinite(values), values, 0.0)
    mean = values.mean(axis=1)
    positions = np.stack([(columns + 0.5) / width - 0.5, (0.5 * height - 0.5 - rows) / width], axis=1)
    block = (rows * (BLOCKS - 1) // height) * BLOCKS + columns * BLOCKS // width
    darkest = max(DARKEST, DARKEST_SHARE * float(np.quantile(mean, 0.98)))
    kept = (mean > darkest) & (usable.mean(axis=1) > 0.6)
    with np.errstate(divide="ignore", invalid="ignore"):
        found = Sample(values / mean[:, None], usable, positions, mean, block.astype(np.int64))
    return found.of(kept)


def estimate(sample: Sample, directions: Array, allowed: Collection[str], start: Rig | None = None) -> Estimate:
    """The terms of `allowed` that the photographs of `sample` tell, of lamps in `directions` (N, 3).

    `start` holds what is known of the others.
    """
    with one_thread(), serial_kernels():
        return _estimate(sample, directions, allowed, start or Rig.plain(len(directions)))


def _estimate(sample: Sample, directions: Array, allowed: Collection[str], start: Rig) -> Estimate:
    count = len(directions)
    tried = tuple(term for term in TERMS if term in allowed and count >= FEWEST[term])
    if not tried or len(sample.values) < 40:
        return Estimate(start, (), float("nan"))
    kind: Kind = "matte"
    errors = HeldOut(sample, directions, start, kind)
    kept = _choose_terms(tried, errors, sample)
    matte, matte_error = kept, float(errors(kept).mean())
    if matte_error > MATTE_ENOUGH:
        few = _sparse(sample)
        others = HeldOut(few, directions, start, "glossy")
        others.find([kept, tried] if kept != tried else [kept])
        likely = min(float(others(terms).mean()) for terms in (kept, tried))
        if likely < MAYBE_GLOSSY * matte_error:
            terms = _choose_terms(tried, others, few)
            if float(others(terms).mean()) < CLEARLY_GLOSSY * matte_error:
                kind, sample, errors, kept = "glossy", few, others, terms
    final = _fit_from_several(sample, directions, kept, start, kind)
    spread = _jackknife(sample, directions, kept, final, kind)
    changed = list_side_by_side(lambda term: fit(sample, directions, (), _put(final.rig, start, term), kind), kept)
    angles = [float(np.quantile(_angles_between(each, final), 0.95)) for each in changed]
    changes = dict(zip(kept, angles, strict=True))
    left = float(errors(kept).mean())
    squares, of_rivals = np.zeros(len(sample.values)), np.zeros(len(sample.values))
    shares = {
        rival: float(errors(rival).mean()) / max(left, 1e-9) - 1.0
        for rival in _subsets(tried)
        if left < HOPELESS and rival != kept
    }
    rivals = [rival for rival, share in shares.items() if share < MAX_SHARE]
    fits = list_side_by_side(lambda rival: _fit_from_several(sample, directions, rival, start, kind), rivals)
    for rival, found in zip(rivals, fits, strict=True):
        likely = np.exp(-0.5 * (max(shares[rival] - UNDECIDED, 0.0) / LESS_LIKELY) ** 2)
        angle = _angles_between(found, final)
        squares = np.maximum(squares, (likely * angle) ** 2)
        of_rivals = np.maximum(of_rivals, angle) if shares[rival] <= UNDECIDED else of_rivals
    if kind == "glossy" and matte_error < MATTE_FITS:  # a gloss that is not there looks like weak room light
        rig = fit(sample, directions, matte, start, "matte").rig
        squares = np.maximum(squares, _angles_between(fit(sample, directions, (), rig, kind), final) ** 2)
    undecided = _by_distance(squares, sample.positions)
    said = tuple(_term(term, kept, errors, sample, final, spread, changes.get(term, 0.0)) for term in tried)
    return Estimate(final.rig if kept else start, said, left, kind, undecided, float(np.median(of_rivals)))


def _subsets(terms: tuple[str, ...]) -> list[tuple[str, ...]]:
    return [chosen for number in range(len(terms), -1, -1) for chosen in combinations(terms, number)]


def _choose_terms(tried: tuple[str, ...], errors: HeldOut, sample: Sample) -> tuple[str, ...]:
    """The terms of least error, of those sets in which each term is worth accepting beside the others."""
    errors.find(_subsets(tried))
    worth = [
        terms
        for terms in _subsets(tried)
        if all(_evidence(term, errors(_without(terms, term)), errors(terms), sample.block) >= 1.0 for term in terms)
    ]
    return min(worth, key=lambda terms: float(errors(terms).mean()))


def _sparse(sample: Sample) -> Sample:
    """Every so many texels, since the fit of a glossy one takes long."""
    return sample.of(np.arange(len(sample.values)) % max(1, len(sample.values) // GLOSSY_TEXELS) == 0)


class HeldOut:
    """Held-out errors (T,) by terms, of rigs that are fitted on the other half of the image; each is found once."""

    def __init__(self, sample: Sample, directions: Array, start: Rig, kind: Kind) -> None:
        self._how = directions, start, kind
        row, column = np.divmod(sample.block, BLOCKS)
        self._halves = [(row + column) % 2 == parity for parity in (0, 1)]
        self._samples = [sample.of(half) for half in self._halves]
        self._errors: dict[tuple[str, ...], Array] = {}

    def __call__(self, terms: tuple[str, ...]) -> Array:
        self.find([terms])
        return self._errors[terms]

    def find(self, several: Sequence[tuple[str, ...]]) -> None:
        """Find the errors of several sets of terms, side by side."""
        unknown = [terms for terms in several if terms not in self._errors]
        parts = list_side_by_side(self._judge, [(terms, parity) for terms in unknown for parity in (0, 1)])
        for terms, *both in zip(unknown, parts[::2], parts[1::2], strict=True):
            found = np.empty(len(self._halves[0]))
            for half, errors in zip(self._halves, both, strict=True):
                found[half] = errors
            self._errors[terms] = found

    def _judge(self, piece: tuple[tuple[str, ...], int]) -> Array:
        """The errors of one half of the image."""
        (terms, parity), (directions, start, kind) = piece, self._how
        here = self._samples[parity]
        rig = _fit_from_several(self._samples[1 - parity], directions, terms, start, kind).rig
        return typical(measure_held_out(here, directions, rig, kind), here.usable)


def _fit_from_several(sample: Sample, directions: Array, terms: tuple[str, ...], start: Rig, kind: Kind) -> Fit:
    """The best fit of those from several distances: highlights of near lamps on a flat surface are
    those of distant ones on a bent one, which is a minimum as well."""
    several = (start.nearness, *STARTS) if kind == "glossy" and "distance" in terms else (start.nearness,)
    fits = [fit(sample, directions, terms, replace(start, nearness=each), kind) for each in several]
    return min(fits, key=lambda each: float(typical(sample.values - each.model.values, sample.usable).mean()))


def _without(terms: tuple[str, ...], term: str) -> tuple[str, ...]:
    return tuple(each for each in terms if each != term)


def _put(rig: Rig, start: Rig, term: str) -> Rig:
    """`rig` with one term as in `start`."""
    name = {"distance": "nearness", "gains": "log_gains", "ambient": "ambient"}[term]
    return replace(rig, **{name: getattr(start, name)})


def _evidence(term: str, before: Array, after: Array, block: NDArray[np.int64]) -> float:
    """1 or more where a term is worth accepting."""
    share = 1.0 - float(after.mean()) / max(float(before.mean()), 1e-9)
    if after.mean() > HOPELESS:
        return 0.0
    needed = MIN_GAIN[term] if after.mean() < GOOD[term] else LARGE_GAIN[term]
    number = np.bincount(block)
    gain = (np.bincount(block, before - after) / np.maximum(number, 1))[number > 0]
    chance = float(gain.std(ddof=1) / np.sqrt(len(gain))) + 1e-9
    return min(share / needed, float(gain.mean()) / chance / SURE)


def _jackknife(
    sample: Sample, directions: Array, terms: tuple[str, ...], final: Fit, kind: Kind
) -> tuple[float, float]:
    """Deviations of the inverse distance and of room light over groups of lamps that are left out."""
    count = len(directions)
    if not {"distance", "ambient"} & set(terms) or count < 3 * GROUPS:
        return 0.0, 0.0

    def fit_without(group: int) -> list[float]:
        kept = np.arange(count) % GROUPS != group
        part = replace(sample, values=sample.values[:, kept], usable=sample.usable[:, kept])
        start = replace(final.rig, log_gains=final.rig.log_gains[kept])
        rig = fit(part, directions[kept], terms, start, kind).rig
        return [rig.nearness, *rig.ambient]

    found = list_side_by_side(fit_without, range(GROUPS))
    variance = (GROUPS - 1) * np.var(np.array(found), axis=0)
    return float(np.sqrt(variance[0])), float(np.sqrt(variance[1:].mean()))


def _angles_between(one: Fit, other: Fit) -> Array:
    """(T,) degrees by which normals differ."""
    first, second = (
        each.albedo_normals / np.maximum(np.linalg.norm(each.albedo_normals, axis=1), 1e-12)[:, None]
        for each in (one, other)
    )
    return np.asarray(np.degrees(np.arccos(np.clip((first * second).sum(axis=1), -1.0, 1.0))))


def _by_distance(squares: Array, positions: Array) -> tuple[float, float]:
    """(a, b) of the squares a² + (b r)² nearest to `squares` (T,) of texels at the distance r from the middle."""
    distance = np.hypot(*positions.T)
    design = np.column_stack([np.ones(len(distance)), distance**2])
    found, _ = nnls(design, squares)
    return float(np.sqrt(found[0])), float(np.sqrt(found[1]))


def _term(
    term: str,
    kept: tuple[str, ...],
    errors: HeldOut,
    sample: Sample,
    final: Fit,
    spread: tuple[float, float],
    change: float,
) -> Term:
    accepted = term in kept
    others = _without(kept, term)
    brightness = float(np.median(sample.brightness))
    before = levels(float(errors(others).mean()), brightness)
    after = levels(float(errors(tuple(each for each in TERMS if each in {*kept, term})).mean()), brightness)
    own = np.sqrt(np.diag(final.covariance))
    sigma = {
        "distance": float(np.hypot(own[0], spread[0])),
        "ambient": float(np.hypot(np.sqrt((own[1:4] ** 2).mean()), spread[1])),
        "gains": float(np.sqrt((own[4:] ** 2).mean())),
    }[term]
    what = {"distance": _distance, "gains": _gains, "ambient": _ambient}[term](final.rig, sigma, accepted)
    held = f"held-out error {number(before)} → {number(after)} levels"
    text = f"{what}: normals change by up to {number(change)}°, {held}" if accepted else f"{what} ({held})"
    return Term(term, accepted, text, before, after, change, sigma)


def levels(error: float, brightness: float) -> float:
    """An error over the brightness as 8-bit levels."""
    ends = srgb_encode(np.array([brightness, brightness * (1.0 + error)]))
    return float(255.0 * (ends[1] - ends[0]))


def _distance(rig: Rig, sigma: float, accepted: bool) -> str:
    if not accepted:
        return "The photographs do not show that lamps are near: they are taken as distant"
    nearest, farthest = 1.0 / (rig.nearness + 2.0 * sigma), 1.0 / max(rig.nearness - 2.0 * sigma, 1e-9)
    upper = number(farthest, 3) if farthest < 100.0 else "any distance"
    return f"Lamps {number(1.0 / rig.nearness, 3)} image widths away ({number(nearest, 3)} to {upper})"


def _gains(rig: Rig, sigma: float, accepted: bool) -> str:
    if not accepted:
        return "The photographs do not show that lamps differ in intensity: they are taken as equal"
    gains = np.exp(rig.log_gains - np.median(rig.log_gains))
    return f"Lamps of {gains.min():.2f} to {gains.max():.2f} of their median intensity (each ±{percent(2.0 * sigma)})"


def _ambient(rig: Rig, sigma: float, accepted: bool) -> str:
    if not accepted:
        return "The photographs show no room light"
    strength = float(np.linalg.norm(rig.ambient))
    side = float(np.degrees(np.arctan2(rig.ambient[1], rig.ambient[0])) % 360.0)
    return f"Room light of {strength:.3f} of a lamp (±{2.0 * sigma:.3f}) from azimuth {side:.0f}°"

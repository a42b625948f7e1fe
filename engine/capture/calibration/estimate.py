"""Which terms of a rig the photographs tell, and how well.

All terms that may be unknown are fitted together; then the one that helps least is left out, until each that remains
lowers the error on photographs left out by more than chance and more than a model that fits badly may pretend. Terms
are fitted on half of the image (a chequerboard of blocks) and judged on the other half, where each photograph of a
texel is predicted from the others. Chance is judged by the scatter over blocks.

Intervals join that scatter with a jackknife over groups of lamps, since what the model of a texel lacks (gloss,
shadows, light that bounces) errs alike over the image but not from lamp to lamp.

Cost: 0.3 s of one core for 25 photographs, 1.5 s for 64, whatever their size.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.capture.calibration.rig import TERMS, Array, Fit, Rig, Sample, fit, measure_held_out, typical
from engine.core.colour import srgb_encode
from engine.core.figure_text import number, percent
from engine.core.one_thread import one_thread

#: Least number of lamps from which each term is estimated.
FEWEST = {"distance": 6, "gains": 9, "ambient": 8}

#: Share of the held-out error that a term has to take away, and deviations of its mean over blocks.
MIN_GAIN, SURE = {"distance": 0.08, "gains": 0.1, "ambient": 0.08}, 4.0

#: Held-out error, over the brightness of a texel, up to which the model of a texel is good enough for each term, and
#: the share that a term has to take away beyond it.
GOOD, LARGE_GAIN = {"distance": 0.05, "gains": 0.12, "ambient": 0.03}, {"distance": 0.25, "gains": 0.25, "ambient": 1.0}

#: Held-out error from which the model of a texel tells nothing.
HOPELESS = 0.18

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
    """A rig, what is said about each of its terms, and the held-out error over the brightness of a texel."""

    rig: Rig
    terms: tuple[Term, ...]
    held_out: float

    @property
    def accepted(self) -> tuple[str, ...]:
        return tuple(term.name for term in self.terms if term.accepted)


def sample_texels(
    photographs: Sequence[NDArray[np.float32]], clipped: Sequence[NDArray[np.float32]], most: int = TEXELS
) -> Sample:
    """A regular grid of texels of small linear photographs (h, w, 3), with shares of clipped samples (h, w)."""
    height, width = photographs[0].shape[:2]
    step = max(1, int(np.sqrt(height * width / most)))
    rows, columns = (
        each.ravel()
        for each in np.meshgrid(np.arange(step // 2, height, step), np.arange(step // 2, width, step), indexing="ij")
    )
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
    with one_thread():
        return _estimate(sample, directions, allowed, start or Rig.plain(len(directions)))


def _estimate(sample: Sample, directions: Array, allowed: Collection[str], start: Rig) -> Estimate:
    count = len(directions)
    tried = tuple(term for term in TERMS if term in allowed and count >= FEWEST[term])
    if not tried or len(sample.values) < 40:
        return Estimate(start, (), float("nan"))
    row, column = np.divmod(sample.block, BLOCKS)
    halves = [(row + column) % 2 == parity for parity in (0, 1)]

    @cache
    def errors(terms: tuple[str, ...]) -> Array:
        """(T,) held-out errors, of rigs that are fitted on the other half of the image."""
        found = np.empty(len(sample.values))
        for half in halves:
            rig = fit(sample.of(~half), directions, terms, start).rig
            here = sample.of(half)
            found[half] = typical(measure_held_out(here, directions, rig), here.usable)
        return found

    kept = tried
    while kept:
        evidence = {term: _evidence(term, errors(_without(kept, term)), errors(kept), sample.block) for term in kept}
        least = min(kept, key=lambda term: evidence[term])
        if evidence[least] >= 1.0:
            break
        kept = _without(kept, least)
    final = fit(sample, directions, kept, start)
    spread = _jackknife(sample, directions, kept, final)
    changes = {term: _angle_between(fit(sample, directions, (), _put(final.rig, start, term)), final) for term in kept}
    terms = [_term(term, kept, errors, sample, final, spread, changes.get(term, 0.0)) for term in tried]
    return Estimate(final.rig if kept else start, tuple(terms), float(errors(kept).mean()))


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


def _jackknife(sample: Sample, directions: Array, terms: tuple[str, ...], final: Fit) -> tuple[float, float]:
    """Deviations of the inverse distance and of room light over groups of lamps that are left out."""
    count = len(directions)
    found = []
    for group in range(GROUPS if {"distance", "ambient"} & set(terms) and count >= 3 * GROUPS else 0):
        kept = np.arange(count) % GROUPS != group
        part = replace(sample, values=sample.values[:, kept], usable=sample.usable[:, kept])
        start = replace(final.rig, log_gains=final.rig.log_gains[kept])
        rig = fit(part, directions[kept], terms, start).rig
        found.append([rig.nearness, *rig.ambient])
    if not found:
        return 0.0, 0.0
    variance = (GROUPS - 1) * np.var(np.array(found), axis=0)
    return float(np.sqrt(variance[0])), float(np.sqrt(variance[1:].mean()))


def _angle_between(one: Fit, other: Fit) -> float:
    """Degrees by which 95 % of normals differ at most."""
    first, second = (
        each.albedo_normals / np.maximum(np.linalg.norm(each.albedo_normals, axis=1), 1e-12)[:, None]
        for each in (one, other)
    )
    cosine = np.clip((first * second).sum(axis=1), -1.0, 1.0)
    return float(np.degrees(np.quantile(np.arccos(cosine), 0.95)))


def _term(
    term: str,
    kept: tuple[str, ...],
    errors: Any,
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
        return "The photographs do not tell that lamps are near: they are taken as distant"
    nearest, farthest = 1.0 / (rig.nearness + 2.0 * sigma), 1.0 / max(rig.nearness - 2.0 * sigma, 1e-9)
    upper = number(farthest, 3) if farthest < 100.0 else "any distance"
    return f"Lamps {number(1.0 / rig.nearness)} image widths away ({number(nearest, 3)} to {upper})"


def _gains(rig: Rig, sigma: float, accepted: bool) -> str:
    if not accepted:
        return "The photographs do not tell that lamps differ in intensity: they are taken as equal"
    gains = np.exp(rig.log_gains - np.median(rig.log_gains))
    return f"Lamps of {gains.min():.2f} to {gains.max():.2f} of their median intensity (each ±{percent(2.0 * sigma)})"


def _ambient(rig: Rig, sigma: float, accepted: bool) -> str:
    if not accepted:
        return "The photographs show no room light"
    strength = float(np.linalg.norm(rig.ambient))
    side = float(np.degrees(np.arctan2(rig.ambient[1], rig.ambient[0])) % 360.0)
    return f"Room light of {strength:.3f} of a lamp (±{2.0 * sigma:.3f}) from azimuth {side:.0f}°"

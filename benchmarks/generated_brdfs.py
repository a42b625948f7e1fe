"""Measured BRDFs that never were measured: materials drawn by seed at the directions of instruments, noise and gaps.

A material is a diffuse base and one or two highlights of colours of their own: GGX, brushed GGX, a retro-reflective
lobe of Lafortune's, or Ashikhmin and Shirley's paint. What an instrument sees of it has multiplicative noise, dark
current, and gaps: a cap of directions round one that a sample holder hides, and a share of readings that failed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from benchmarks.factor_choice import INSTRUMENTS
from engine.brdf.brdf import Brdf
from engine.brdf.models.diffuse import Lambert
from engine.brdf.models.lafortune import Lafortune
from engine.brdf.models.microfacet import AshikhminShirley, Ggx, GgxAnisotropic
from engine.brdf.samples import BrdfSamples
from engine.core.directions import Vectors, surface_direction
from engine.core.params import Colour

#: Kinds of materials, one after the other.
KINDS = ("paint", "two gloss paints", "brushed metal", "retro-reflector", "coated")

#: Largest share of noise, of the readings that failed, and radius (radians) of the cap that is hidden.
NOISE, FAILED, HIDDEN = 0.04, 0.1, float(np.radians(15.0))


@dataclass(frozen=True)
class Layered:
    """The sum of several BRDFs; a `Brdf` without samples of its own."""

    parts: Sequence[Brdf]
    name: str = "layered"

    @property
    def isotropic(self) -> bool:
        return all(each.isotropic for each in self.parts)

    reciprocal = energy_conserving = True

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Values (..., 3) in 1/sr for unit directions (..., 3) that broadcast."""
        return np.asarray(sum(each.f(wi, wo) for each in self.parts))


@dataclass(frozen=True, eq=False)
class Measured:
    """A material, and the samples of it that an instrument took."""

    truth: Layered
    samples: BrdfSamples


def generate(seed: int) -> Measured:
    """The material and the samples of one seed, the same for the same seed."""
    rng = np.random.default_rng([23, seed])
    kind = KINDS[seed % len(KINDS)]
    truth = Layered(tuple(_parts(kind, rng)), f"{seed}: {kind}")
    instrument = list(INSTRUMENTS)[rng.integers(len(INSTRUMENTS))]
    wi, wo = INSTRUMENTS[instrument](rng)
    kept = (np.minimum(wi[:, 2], wo[:, 2]) > 0.02) & (rng.random(len(wi)) > FAILED * rng.random())
    hidden = surface_direction(0.4 * np.pi * rng.random(), 2.0 * np.pi * rng.random())
    kept &= wo @ hidden < np.cos(HIDDEN * rng.random())
    wi, wo = wi[kept], wo[kept]
    value = truth.f(wi, wo)
    noisy = value * (1.0 + NOISE * rng.random() * rng.standard_normal(value.shape))
    dark = 1e-4 * float(np.median(value)) * rng.standard_normal(value.shape)
    name = f"{truth.name} at {instrument} directions"
    return Measured(truth, BrdfSamples(wi, wo, np.maximum(noisy + dark, 0.0), name, "generated samples"))


def _parts(kind: str, rng: np.random.Generator) -> list[Brdf]:
    base = Lambert(albedo=_colour(rng, 0.02, 0.7))
    gloss = _log(rng, 0.06, 0.5)
    if kind == "brushed metal":
        across = gloss * rng.uniform(0.2, 0.8)
        f0 = _colour(rng, 0.3, 0.95)
        metal = GgxAnisotropic(alpha_x=across, alpha_y=gloss, f0=f0, kd=(0.0, 0.0, 0.0))
        return [Lambert(albedo=_colour(rng, 0.005, 0.1)), metal]
    if kind == "retro-reflector":
        back = Lafortune(kd=(0.0, 0.0, 0.0), ks=_colour(rng, 0.1, 0.8), cxy=1.0, cz=1.0, exponent=_log(rng, 8.0, 80.0))
        return [base, back, _highlight(rng, gloss, 0.05)]
    if kind == "coated":
        paint = AshikhminShirley(
            kd=_colour(rng, 0.05, 0.5), ks=_colour(rng, 0.03, 0.3), nu=_log(rng, 10.0, 400.0), nv=_log(rng, 10.0, 400.0)
        )
        return [paint]
    if kind == "two gloss paints":
        return [base, _highlight(rng, gloss, 0.06), _highlight(rng, min(2.5 * gloss, 0.8), 0.3)]
    return [base, _highlight(rng, gloss, rng.uniform(0.03, 0.2))]


def _highlight(rng: np.random.Generator, alpha: float, strength: float) -> Brdf:
    red, green, blue = map(float, strength * rng.uniform(0.5, 1.0, 3))
    return Ggx(alpha=alpha, f0=(red, green, blue), kd=(0.0, 0.0, 0.0))


def _colour(rng: np.random.Generator, low: float, high: float) -> Colour:
    """Three reflectances, each anywhere between both on a scale of logarithms: most colours are strong."""
    red, green, blue = map(float, low * (high / low) ** rng.random(3))
    return red, green, blue


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(low * (high / low) ** rng.random())

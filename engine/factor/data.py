"""The samples that a BRDF is factored from: pairs of directions and values, however the BRDF is given.

    formulas, and measurements in an adaptive parametrisation (RGL)
                 pairs, uniform over the parabolic disks of both directions up to an angle from the normal
    scattered measurements     every sample with its measured value; nothing is interpolated
    tables                     the centres of the measured bins, where the table is exact, at most `count` of them

Instruments light an isotropic material from one azimuth, and its tables have no azimuth at all. A factorisation needs
them all, so samples of an isotropic BRDF are turned about the normal, both directions by the same random angle, which
leaves their values true; where there are fewer than `count`, each is turned several times.

A measured colour outside sRGB has a negative channel, which counts as 0 here: it has no logarithm.

In parabolic coordinates (x, y)/(1 + z) the hemisphere is the unit disk, and the angle θ the radius tan(θ/2).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import Brdf
from engine.brdf.ceiling import Ceiling, ceiling_of
from engine.brdf.samples import HORIZON, BrdfSamples
from engine.brdf.scattered import ScatteredBrdf
from engine.brdf.table import DirectionTable, HalfDifferenceTable, bin_directions
from engine.core.directions import Vectors, surface_direction
from engine.factor.settings import DEFAULT

Floats = NDArray[np.float64]

#: Samples, largest angle from the normal in radians and seed of the thesis's size and of the whole hemisphere's.
COUNT, MAX_THETA, SEED = DEFAULT.samples, DEFAULT.max_theta, DEFAULT.seed


@dataclass(frozen=True, eq=False)
class FactorData:
    """N > 0 samples of a BRDF.

    Attributes
    ----------
    wi, wo : (N, 3) unit directions towards light and viewer in the surface frame, above the horizon.
    value : (N, 3) in 1/sr without the cosine, finite and not negative.
    measurement : (N,) numbers; samples with the same one are one measurement, turned about the normal. By default
        every sample is one of its own.
    ceiling : the largest values that factors of these samples may have; None where they have no bound.
    """

    wi: Floats
    wo: Floats
    value: Floats
    measurement: NDArray[np.intp] = field(default_factory=lambda: np.empty(0, np.intp))
    ceiling: Ceiling | None = None

    def __post_init__(self) -> None:
        if not self.measurement.size:
            object.__setattr__(self, "measurement", np.arange(len(self.value)))
        for name in ("wi", "wo", "value"):
            array = np.array(getattr(self, name), np.float64)
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        count = len(self.value)
        if not count or any(array.shape != (count, 3) for array in (self.wi, self.wo, self.value)):
            raise ValueError("wi, wo and value must have the shape (N, 3) with N > 0")
        if self.measurement.shape != (count,):
            raise ValueError(f"{self.measurement.shape} numbers of measurements for {count} samples")
        if not (self.wi[:, 2].min() > 0.0 and self.wo[:, 2].min() > 0.0):
            raise ValueError("directions must be above the horizon")
        if not (self.value.min() >= 0.0 and np.isfinite(self.value).all()):
            raise ValueError("values must be finite and not negative")

    def __len__(self) -> int:
        return len(self.value)

    def part(self, samples: NDArray[np.intp]) -> FactorData:
        """The samples of these indices."""
        sides = self.wi[samples], self.wo[samples], self.value[samples]
        return FactorData(*sides, self.measurement[samples], self.ceiling)

    def add_ceiling(self, *, reciprocal: bool) -> FactorData:
        """The same samples with the ceiling that they give (`engine.brdf.ceiling`)."""
        _, first = np.unique(self.measurement, return_index=True)
        sides = (self.wi[first], self.wo[first], self.value[first])
        return replace(self, ceiling=ceiling_of(*sides, reciprocal=reciprocal))


def factor_data(
    brdf: Brdf | BrdfSamples, count: int = COUNT, max_theta: float = MAX_THETA, seed: int = SEED
) -> FactorData:
    """The samples of `brdf` as the head of this file says; the same for the same seed.

    `max_theta` in (0, π/2) bounds both directions of formulas only: measured data are taken as they are. Raises
    ValueError where `count` < 1, the angle is out of range or a value is not a finite number.
    """
    if count < 1:
        raise ValueError(f"at least one sample is needed, not {count}")
    if not 0.0 < max_theta < 0.5 * np.pi:
        raise ValueError(f"the largest angle must lie between 0 and 90 degrees, not {np.degrees(max_theta):g}")
    rng = np.random.default_rng(seed)
    if isinstance(brdf, BrdfSamples):
        return FactorData(brdf.wi, brdf.wo, np.maximum(brdf.value, 0.0))
    if isinstance(brdf, ScatteredBrdf):
        measured = brdf.measured
        value = np.maximum(measured.value, 0.0)
        return _turn(measured.wi, measured.wo, value, brdf.isotropic, count, rng)
    if isinstance(brdf, HalfDifferenceTable):
        bins = bin_directions(brdf.missing.shape)
        return _sample_table(brdf, (bins[0], bins[1]), count, rng)
    if isinstance(brdf, DirectionTable):
        light = surface_direction(*np.meshgrid(brdf.theta_i, brdf.phi_i, indexing="ij"))[:, :, None, None]
        view = surface_direction(*np.meshgrid(brdf.theta_o, brdf.phi_o, indexing="ij"))
        shape = (*brdf.missing.shape, 3)
        return _sample_table(brdf, (np.broadcast_to(light, shape), np.broadcast_to(view, shape)), count, rng)
    wi, wo = parabolic_directions(rng, count, max_theta), parabolic_directions(rng, count, max_theta)
    return FactorData(wi, wo, np.maximum(brdf.f(wi, wo), 0.0))


def parabolic_directions(rng: np.random.Generator, count: int, max_theta: float) -> Vectors:
    """Unit directions (count, 3), uniform over the disk of parabolic coordinates up to `max_theta`."""
    radius = np.tan(0.5 * max_theta) * np.sqrt(rng.random(count))
    return surface_direction(2.0 * np.arctan(radius), 2.0 * np.pi * rng.random(count))


def _sample_table(
    table: HalfDifferenceTable | DirectionTable, bins: tuple[Vectors, Vectors], count: int, rng: np.random.Generator
) -> FactorData:
    wi, wo = (directions.reshape(-1, 3) for directions in bins)
    usable = np.flatnonzero((wi[:, 2] > HORIZON) & (wo[:, 2] > HORIZON) & ~table.missing.reshape(-1))
    if len(usable) > count:
        usable = np.sort(rng.choice(usable, count, replace=False))
    value = np.asarray(table.values.reshape(-1, 3)[usable], np.float64)
    return _turn(wi[usable], wo[usable], value, table.isotropic, count, rng)


def _turn(wi: Floats, wo: Floats, value: Floats, isotropic: bool, count: int, rng: np.random.Generator) -> FactorData:
    """The samples as they are, or, where the BRDF is isotropic, each about count/N times at random azimuths."""
    if not isotropic or not len(value):
        return FactorData(wi, wo, value)
    times = max(1, count // len(value))
    angle = 2.0 * np.pi * rng.random(times * len(value))
    wi, wo = (_about_normal(np.tile(directions, (times, 1)), angle) for directions in (wi, wo))
    return FactorData(wi, wo, np.tile(value, (times, 1)), np.tile(np.arange(len(value)), times))


def _about_normal(vectors: Floats, angle: Floats) -> Floats:
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y, z = vectors.T
    return np.column_stack([cosine * x - sine * y, sine * x + cosine * y, z])

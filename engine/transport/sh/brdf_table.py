"""Reflectances as tables of spherical harmonics over the direction of view (Kautz2002 Sec. 3):

    c_i(wo) = ∫ y_i(wi) f(wi, wo) max(0, cos θ_i) dwi,        radiance towards wo = Σ c_i(wo) L_i (Kautz2002 Eq. 1)

with everything in the surface frame. An anisotropic BRDF has all order² coefficients in a parabolic map of 128
texels a side. An isotropic one has one row over tan(θ_o/2), the radius of that map: for φ_o = 0 its function is even
in φ_i, so only m ≥ 0 are not 0, and a turn by φ_o turns pairs of them. Lambert's is known in closed form.

The integrals are sums over directions that the BRDF's own lobes send out (`engine.brdf.models.sampling`), weighted by
the density of all lobes together (balance heuristic): narrow highlights get as many directions as wide ones. Two sums
over different halves of the directions tell the error, about twice that of their mean.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.brdf import Brdf
from engine.brdf.models.diffuse import Lambert
from engine.brdf.models.sampling import sampler_of
from engine.brdf.models.sampling_lobes import CosineLobe, Mixture, Sampler, TabulatedLobe
from engine.core.directions import Vectors
from engine.core.figure_text import percent
from engine.core.health import Finding, Health, Verdict
from engine.core.steps import Step, Steps
from engine.factor.hemisphere_map import HemisphereMap
from engine.transport.sh import kernel as sh_kernel
from engine.transport.sh.basis import bands, check_order, cosine_zonal, evaluate, recurrence

#: Texels a side of the map of anisotropic BRDFs, and rows of isotropic ones.
MAP_SIZE, ROWS = 128, 256

#: Directions of light for each direction of view, of isotropic and anisotropic BRDFs; of the latter twice as
#: many at orders above `LOW_ORDER`.
SAMPLES, SAMPLES_OF_MAP = 4096, 1024

#: So many times as many where the lobes are drawn from tables of values.
FOR_TABLES = 4

#: Functions of orders up to this are smooth beside a texel of 3 degrees.
LOW_ORDER = 8

#: Share of the directions that the cosine lobe gets at least: its rule is the best one for what is smooth.
MIN_SMOOTH = 0.5

#: Cosines of the view below this are looked up at it: models are 0 or not finite at the horizon itself.
GRAZING = 1e-3

#: A relative error above this is reported as a warning.
LARGE_ERROR = 0.02

#: Directions of light that are worked on at once.
CHUNK = 1 << 18

#: 1 / golden ratio: multiples of it modulo 1 are spread evenly whatever their number.
_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BrdfTable:
    """Coefficients of f cos θ_i over the direction of view.

    Attributes
    ----------
    values : (R, order², 3) float64 of an isotropic BRDF, at φ_o = 0 and tan(θ_o/2) = r/(R − 1); or
        (S, S, order², 3), the texels of a parabolic `HemisphereMap`.
    error_rel : of the sums, root mean square relative to all coefficients.
    diffuse : whether the BRDF is Lambert's: its radiance is then known from the irradiance alone.
    """

    order: int
    values: Floats
    error_rel: float = 0.0
    diffuse: bool = False
    health: Health = field(default_factory=Health)

    @property
    def isotropic(self) -> bool:
        return self.values.ndim == 3

    def at(self, wo: ArrayLike, vertices: ArrayLike = ()) -> Floats:
        """Coefficients (N, order², 3) towards unit directions wo (N, 3) in the surface frame; 0 below the horizon.

        `vertices` (N,) matter where the BRDF varies (`engine.transport.sh.brdf_table_varying`); this one is
        alike for all.
        """
        directions = np.ascontiguousarray(wo, np.float64).reshape(-1, 3)
        out = np.empty((len(directions), self.order**2, 3))
        if self.isotropic:
            sh_kernel.isotropic_rows(self.order, self.values, directions, out)
        else:
            hemisphere_map = HemisphereMap("parabolic", self.values.shape[0])
            up = directions[:, 2] > 0.0
            flat = self.values.reshape(*self.values.shape[:2], -1)
            out[up] = hemisphere_map.look_up(flat, directions[up]).reshape(-1, self.order**2, 3)
            out[~up] = 0.0
        return out

    def radiance(self, light: NDArray[Any], wo: ArrayLike, vertices: ArrayLike = ()) -> Floats:
        """(N, 3) towards wo (N, 3) under `light` (N, order², 3), both in the frame of the point; not clamped."""
        if light.shape[1] != self.order**2:
            raise ValueError(f"light of {light.shape[1]} coefficients does not fit a table of {self.order**2}")
        directions = np.ascontiguousarray(wo, np.float64).reshape(-1, 3)
        if not self.isotropic:
            return np.asarray(np.einsum("nic,nic->nc", self.at(directions), light))
        out = np.empty((len(directions), 3))
        sh_kernel.isotropic_radiance(self.order, self.values, directions, np.ascontiguousarray(light), out)
        return out

    @property
    def mean(self) -> Floats:
        """(order², 3) of ∫ c_i(wo) cos θ_o dwo / π: what a surface reflects that shows its mean to every side."""
        if self.isotropic:
            cosine, weight = _cosines(len(self.values))
            zonal = np.where(np.arange(self.order**2) == bands(self.order) * (bands(self.order) + 1), 1.0, 0.0)
            return np.asarray(np.einsum("r,ric->ic", 2.0 * cosine * weight, self.values) * zonal[:, None])
        hemisphere_map = HemisphereMap("parabolic", self.values.shape[0])
        share = hemisphere_map.directions[:, 2] * hemisphere_map.solid_angles
        return np.asarray(np.einsum("n,nic->ic", share / share.sum(), self.values[hemisphere_map.mask]))

    @property
    def even_albedo(self) -> Floats:
        """(3,) the share of even light that is reflected, in the mean over all sides; of Lambert's its albedo."""
        return np.asarray(self.mean[0] * math.sqrt(4.0 * math.pi))

    def reduce_order(self, order: int) -> BrdfTable:
        """The same with fewer coefficients; ValueError where it has fewer than asked for."""
        if order > self.order:
            raise ValueError(f"a table of order {self.order} has no coefficients of order {order}")
        kept = np.ascontiguousarray(self.values[..., : order**2, :])
        return BrdfTable(order, kept, self.error_rel, self.diffuse, self.health)


def tabulate(brdf: Brdf, order: int) -> Steps[BrdfTable]:
    """The table of `brdf` at any order; ValueError for orders out of range."""
    check_order(order)
    if isinstance(brdf, Lambert):
        return lambert_table(brdf, order)
    if brdf.isotropic:
        halves = yield from _project(brdf, order, isotropic_views(), SAMPLES)
        # exactly even in φ: what is left of m < 0 is noise, and so is m ≠ 0 at the normal
        halves[:, :, _negative(order)] = 0.0
        halves[:, 0, bands(order) * (bands(order) + 1) != np.arange(order**2)] = 0.0
        return _table(order, halves.mean(axis=0), _difference(halves))
    hemisphere_map = HemisphereMap("parabolic", MAP_SIZE)
    chosen, fill = _quarter(brdf, hemisphere_map, order)
    samples = SAMPLES_OF_MAP * (1 if order <= LOW_ORDER else 2)
    halves = yield from _project(brdf, order, hemisphere_map.directions[chosen], samples)
    values = np.zeros((*hemisphere_map.shape, order**2, 3))
    values[hemisphere_map.mask] = fill(halves.mean(axis=0))
    return _table(order, values, _difference(halves))


def coefficients_towards(brdf: Brdf, order: int, views: Vectors) -> Steps[Floats]:
    """(N, order², 3) of `brdf` towards `views` (N, 3) above the horizon, summed as for its table."""
    samples = SAMPLES if brdf.isotropic else SAMPLES_OF_MAP
    return np.asarray((yield from _project(brdf, order, views, samples)).mean(axis=0))


def lambert_table(brdf: Lambert, order: int) -> BrdfTable:
    """The table of Lambert's BRDF, exact: zonal, and the same towards every side."""
    coefficients = np.zeros((order**2, 3))
    degree = np.arange(order)
    coefficients[degree * (degree + 1)] = cosine_zonal(order)[:, None] * np.asarray(brdf.albedo) / np.pi
    return BrdfTable(order, np.stack([coefficients, coefficients]), diffuse=True)


def isotropic_views(rows: int = ROWS) -> Vectors:
    """(R, 3) directions of view at φ = 0 with tan(θ/2) = r/(R − 1), the last of them just above the horizon."""
    radius = np.arange(rows) / (rows - 1)
    cosine = np.maximum((1.0 - radius**2) / (1.0 + radius**2), GRAZING)
    return np.stack([np.sqrt(1.0 - cosine**2), np.zeros(rows), cosine], axis=-1)


def _cosines(rows: int) -> tuple[Floats, Floats]:
    """cos θ (R,) of the rows, and what each counts in an integral over cos θ from 0 to 1 (trapezia)."""
    if rows == 2:
        return np.array([1.0, 1.0]), np.array([0.25, 0.25])
    radius = np.arange(rows) / (rows - 1)
    cosine = (1.0 - radius**2) / (1.0 + radius**2)
    step = -np.diff(cosine)
    weight = 0.5 * (np.append(step, 0.0) + np.append(0.0, step))
    return cosine, weight / (2.0 * (cosine * weight).sum())


def _table(order: int, values: Floats, error: float) -> BrdfTable:
    figures = MappingProxyType({"table_error_rel": error})
    findings: tuple[Finding, ...] = ()
    if error > LARGE_ERROR:
        text = f"Its spherical harmonics have an error of {percent(error, 3)}: the BRDF is too narrow or too uneven."
        findings = (Finding(Verdict.WARNING, text),)
    return BrdfTable(order, values, error, health=Health(figures, findings))


def _negative(order: int) -> NDArray[np.bool_]:
    band = bands(order)
    return np.arange(order**2) < band * (band + 1)


@lru_cache(maxsize=4)
def _parity(order: int) -> tuple[Floats, Floats]:
    """Signs (order²,) of the basis where x, and where y, changes its sign."""
    point = np.array([0.36, 0.48, 0.8])
    here = evaluate(order, point)
    across, along = evaluate(order, point * (-1.0, 1.0, 1.0)), evaluate(order, point * (1.0, -1.0, 1.0))
    return np.sign(here * across), np.sign(here * along)


def _quarter(brdf: Brdf, hemisphere_map: HemisphereMap, order: int) -> tuple[NDArray[np.intp], Any]:
    """The texels that have to be worked out, and what makes all of theirs: a quarter where both axes are mirrors."""
    texels = np.arange(len(hemisphere_map.directions))
    if hemisphere_map.flips is None or not _mirror(brdf):
        return texels, lambda values: values
    across, along = hemisphere_map.flips
    first = np.minimum(np.minimum(texels, across), np.minimum(along, across[along]))
    chosen, place = np.unique(first, return_inverse=True)
    x_sign, y_sign = _parity(order)
    at_x, at_y = hemisphere_map.directions[:, 0], hemisphere_map.directions[:, 1]
    mirror_x = at_x * at_x[first] < 0.0
    mirror_y = at_y * at_y[first] < 0.0

    def fill(values: Floats) -> Floats:
        signs = np.where(mirror_x[:, None], x_sign, 1.0) * np.where(mirror_y[:, None], y_sign, 1.0)
        return np.asarray(values[place.reshape(-1)] * signs[..., None])

    return chosen, fill


def _mirror(brdf: Brdf) -> bool:
    """True if f keeps its value when both directions are mirrored across x, and across y: by 512 pairs."""
    rng = np.random.default_rng(0)
    pairs = rng.normal(size=(2, 512, 3))
    pairs[..., 2] = np.abs(pairs[..., 2]) + 1e-3
    wi, wo = pairs / np.linalg.norm(pairs, axis=-1, keepdims=True)
    value = brdf.f(wi, wo)
    for mirror in ((-1.0, 1.0, 1.0), (1.0, -1.0, 1.0)):
        if np.abs(brdf.f(wi * mirror, wo * mirror) - value).max() > 1e-9 * np.abs(value).max():
            return False
    return True


def _difference(halves: Floats) -> float:
    """Half of what two sums (2, ...) differ by, relative to their mean."""
    difference, size = (float(np.sqrt((part**2).sum())) for part in (halves[0] - halves[1], halves.mean(axis=0)))
    return 0.5 * difference / size if size > 0.0 else 0.0


def _project(brdf: Brdf, order: int, views: Vectors, samples: int) -> Steps[Floats]:
    """Coefficients (2, N, order², 3) towards `views` (N, 3), from each half of the directions of light."""
    mixture = sampler_of(brdf)
    assert isinstance(mixture, Mixture)
    if any(isinstance(lobe, TabulatedLobe) for lobe in mixture.lobes):
        samples *= FOR_TABLES
    halves = np.empty((2, len(views), order**2, 3))
    step = max(1, CHUNK // samples)
    for start in range(0, len(views), step):
        some = slice(start, start + step)
        for half in range(2):
            halves[half, some] = _sums(brdf, mixture, order, views[some], samples // 2, half)
        yield Step(min(start + step, len(views)) / len(views), "projecting the BRDF")
    return halves


def _sums(brdf: Brdf, mixture: Mixture, order: int, views: Vectors, samples: int, half: int) -> Floats:
    """Sums (N, order², 3) over about `samples` directions towards the light for each of `views` (N, 3)."""
    shares = np.maximum(mixture.shares, [MIN_SMOOTH * isinstance(lobe, CosineLobe) for lobe in mixture.lobes])
    rules = [
        _rule(lobe, share * samples, half) for lobe, share in zip(mixture.lobes, shares / shares.sum(), strict=True)
    ]
    parts = []
    for lobe, (numbers, _) in zip(mixture.lobes, rules, strict=True):
        drawn = lobe.sample(np.repeat(views, len(numbers), axis=0), np.tile(numbers, (len(views), 1)))
        parts.append(drawn.reshape(len(views), -1, 3))
    wi = np.concatenate(parts, axis=1)
    share = np.concatenate([len(weight) * weight for _, weight in rules])
    back, flat = np.repeat(views, wi.shape[1], axis=0), wi.reshape(-1, 3)
    density = np.zeros(len(flat))
    for lobe, (_, weight) in zip(mixture.lobes, rules, strict=True):
        density += len(weight) * lobe.pdf(flat, back)
    product = brdf.f(flat, back) * np.maximum(flat[:, 2:], 0.0)
    used = (density > 0.0)[:, None] & np.isfinite(product)
    product = np.where(used, product / np.where(density > 0.0, density, 1.0)[:, None], 0.0)
    out = np.empty((len(views), 3, order**2))
    sh_kernel.lobe_sums(order, wi, product.reshape(wi.shape) * share[:, None], recurrence(order), out)
    return out.swapaxes(1, 2)


def _rule(lobe: Sampler, count: float, half: int) -> tuple[Floats, Floats]:
    """About `count` numbers (n, 3) in [0, 1) for a lobe, and weights (n,) with sum 1; two halves lie differently.

    The cosine lobe, which finds what is smooth, gets Gauss's rule in θ and even steps around; what narrow lobes see
    ends at the horizon or in their tables, and there numbers that are only evenly spread do better.
    """
    if isinstance(lobe, CosineLobe):
        radii = max(1, round(math.sqrt(count / 2.5))) + half
        turns = max(1, round(count / radii))
        at, share = np.polynomial.legendre.leggauss(radii)
        theta = np.asarray(0.25 * np.pi * (1.0 + at), np.float64)
        radial = np.repeat(np.sin(theta) ** 2, turns)
        around = np.tile((np.arange(turns) + 0.25 + 0.5 * half) / turns, radii)
        weight = np.repeat(np.asarray(share * np.sin(2.0 * theta), np.float64), turns)
        return np.stack([np.full(radial.shape, 0.5), radial, around], axis=-1), weight / weight.sum()
    # never 0: at the edges of the unit square the density of measured lobes is not that of their neighbourhood
    index, shift = np.arange(max(1, round(count))), 0.25 + 0.5 * half
    number = index + shift
    choice, turn = (index * math.sqrt(2.0) + shift) % 1.0, number * _GOLDEN % 1.0
    return np.stack([choice, number / len(number), turn], axis=-1), np.full(len(number), 1.0 / len(number))

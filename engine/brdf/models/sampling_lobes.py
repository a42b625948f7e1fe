"""Lobes from which directions are drawn, each with its density: closed forms, and mixtures of any.

A sampler draws directions towards the light for a fixed viewer. A lobe may send directions below the horizon: a BRDF
is 0 there, the density is not.

Lobes made of a BRDF's own values, for what has no closed form: one over half vectors, one over directions.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.models.evaluate import power_of_one_minus
from engine.core.colour import luminance
from engine.core.directions import Vectors, dot, normalize, surface_direction

Floats = NDArray[np.float64]


class Evaluable(Protocol):
    """Methods of a BRDF that sampling needs."""

    @property
    def isotropic(self) -> bool: ...

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors: ...


class Sampler(Protocol):
    """A conditional density over the sphere of wi and a way to draw from it."""

    def sample(self, wo: Vectors, u: Floats) -> Vectors:
        """Unit directions (N, 3) for unit directions wo (N, 3) above the surface and u (N, 3) in [0, 1)."""
        ...

    def pdf(self, wi: Vectors, wo: Vectors) -> Floats:
        """Density (N,) in 1/sr at which `sample` makes wi (N, 3)."""
        ...


@dataclass(frozen=True)
class Mixture:
    """Several samplers, each used for its share of the directions; `shares` sum to 1."""

    lobes: tuple[Sampler, ...]
    shares: tuple[float, ...]

    def sample(self, wo: Vectors, u: Floats) -> Vectors:
        edges = np.concatenate([[0.0], np.cumsum(self.shares)])
        chosen = np.minimum(np.searchsorted(edges, u[:, 0], side="right") - 1, len(self.lobes) - 1)
        wi = np.empty_like(wo)
        for index, lobe in enumerate(self.lobes):
            mine = chosen == index
            again = np.clip((u[mine, 0] - edges[index]) / self.shares[index], 0.0, BELOW_ONE)
            wi[mine] = lobe.sample(wo[mine], np.column_stack([again, u[mine, 1:]]))
        return wi

    def pdf(self, wi: Vectors, wo: Vectors) -> Floats:
        density = np.zeros(len(wi))
        for lobe, share in zip(self.lobes, self.shares, strict=True):
            density += share * lobe.pdf(wi, wo)
        return density


BELOW_ONE = float(np.nextafter(1.0, 0.0))


@dataclass(frozen=True)
class CosineLobe:
    """cos(theta_i) / pi above the horizon."""

    def sample(self, wo: Vectors, u: Floats) -> Vectors:
        radius, phi = np.sqrt(u[:, 1]), 2.0 * np.pi * u[:, 2]
        return np.column_stack([radius * np.cos(phi), radius * np.sin(phi), np.sqrt(1.0 - u[:, 1])])

    def pdf(self, wi: Vectors, wo: Vectors) -> Floats:
        return np.asarray(np.maximum(wi[:, 2], 0.0) / np.pi)


@dataclass(frozen=True)
class PowerLobe:
    """(n + 1) / (2 pi) max(0, a·wi)^n about the axis a = `turn` ∘ wo, made a unit vector.

    `turn` = (−1, −1, 1) is the mirror direction of Phong's model, (cxy, cxy, cz) the axis of a Lafortune lobe.
    """

    exponent: float
    turn: tuple[float, float, float] = (-1.0, -1.0, 1.0)

    def _axis(self, wo: Vectors) -> Vectors:
        return normalize(wo * self.turn)

    def sample(self, wo: Vectors, u: Floats) -> Vectors:
        return about_axis(self._axis(wo), *_power_angles(u[:, 1], self.exponent), 2.0 * np.pi * u[:, 2])

    def pdf(self, wi: Vectors, wo: Vectors) -> Floats:
        difference = wi - self._axis(wo)
        power = power_of_one_minus(0.5 * dot(difference, difference), self.exponent)
        if self.exponent == 0.0:
            power = (dot(wi, self._axis(wo)) > 0.0).astype(np.float64)
        return (self.exponent + 1.0) / (2.0 * np.pi) * power


def _power_angles(u: Floats, exponent: float | Floats) -> tuple[Floats, Floats]:
    """(sine, cosine) of the angle whose cosine is (1 − u)^(1 / (exponent + 1)), exact for narrow lobes."""
    deficit = -np.expm1(np.log1p(-u) / (exponent + 1.0))
    return np.sqrt(deficit * (2.0 - deficit)), 1.0 - deficit


def about_axis(axis: Vectors, sine: Floats, cosine: Floats, phi: Floats) -> Vectors:
    """Directions at an angle given by its sine and cosine from unit `axis` (N, 3), at azimuth phi about it."""
    sign = np.where(axis[:, 2] < 0.0, -1.0, 1.0)
    a = -1.0 / (sign + axis[:, 2])
    b = axis[:, 0] * axis[:, 1] * a
    across = np.column_stack([1.0 + sign * axis[:, 0] ** 2 * a, sign * b, -sign * axis[:, 0]])
    along = np.column_stack([b, sign + axis[:, 1] ** 2 * a, -axis[:, 1]])
    return normalize(
        (sine * np.cos(phi))[:, None] * across + (sine * np.sin(phi))[:, None] * along + cosine[:, None] * axis
    )


class HalfVectors(Protocol):
    """A density over half vectors on the upper hemisphere, in 1/sr, that does not depend on the viewer."""

    def draw(self, u: Floats) -> Vectors: ...

    def density(self, half: Vectors) -> Floats: ...


@dataclass(frozen=True)
class HalfVectorLobe:
    """wo mirrored about half vectors that are drawn from `half_vectors`: density / (4 |wo·h|)."""

    half_vectors: HalfVectors

    def sample(self, wo: Vectors, u: Floats) -> Vectors:
        half = self.half_vectors.draw(u[:, 1:])
        return normalize(2.0 * dot(wo, half)[:, None] * half - wo)

    def pdf(self, wi: Vectors, wo: Vectors) -> Floats:
        both = wi + wo
        length = np.sqrt(dot(both, both))
        half = normalize(np.where(both[:, 2:] < 0.0, -both, both))
        return self.half_vectors.density(half) / np.maximum(2.0 * length, 1e-300)


@dataclass(frozen=True)
class PowerHalfVectors:
    """√((nu + 1)(nv + 1)) / (2 pi) (n·h)^(nu cos² phi + nv sin² phi): Ashikhmin2000 Eq. 6."""

    nu: float
    nv: float

    def draw(self, u: Floats) -> Vectors:
        turn = 2.0 * np.pi * u[:, 1]
        phi = np.arctan2(np.sqrt(self.nu + 1.0) * np.sin(turn), np.sqrt(self.nv + 1.0) * np.cos(turn))
        sine, cosine = _power_angles(u[:, 0], self.nu * np.cos(phi) ** 2 + self.nv * np.sin(phi) ** 2)
        return np.column_stack([sine * np.cos(phi), sine * np.sin(phi), cosine])

    def density(self, half: Vectors) -> Floats:
        across = half[:, 0] ** 2 + half[:, 1] ** 2
        along = (self.nu * half[:, 0] ** 2 + self.nv * half[:, 1] ** 2) / np.maximum(across, 1e-300)
        logarithm = 0.5 * np.log1p(-np.minimum(across, 1.0 - 1e-16))
        return np.asarray(np.sqrt((self.nu + 1.0) * (self.nv + 1.0)) / (2.0 * np.pi) * np.exp(along * logarithm))


@dataclass(frozen=True)
class GaussianHalfVectors:
    """exp(−tan² theta (cos² phi / αx² + sin² phi / αy²)) / (pi αx αy cos³ theta): Ward's and Beckmann's facets."""

    alpha_x: float
    alpha_y: float

    def draw(self, u: Floats) -> Vectors:
        turn, slope = 2.0 * np.pi * u[:, 1], np.sqrt(-np.log1p(-u[:, 0]))
        tangents = (self.alpha_x * slope * np.cos(turn), self.alpha_y * slope * np.sin(turn))
        return normalize(np.column_stack([*tangents, np.ones(len(u))]))

    def density(self, half: Vectors) -> Floats:
        z = np.maximum(half[:, 2], 1e-12)
        slopes = ((half[:, 0] / self.alpha_x) ** 2 + (half[:, 1] / self.alpha_y) ** 2) / z**2
        return np.exp(-np.minimum(slopes, 700.0)) / (np.pi * self.alpha_x * self.alpha_y * z**3) * (slopes < 700.0)


@dataclass(frozen=True)
class VisibleGgxLobe:
    """The GGX facets that the viewer sees (Heitz2018); density D / (2 (wo.z + |(αx wo.x, αy wo.y, wo.z)|))."""

    alpha_x: float
    alpha_y: float

    def sample(self, wo: Vectors, u: Floats) -> Vectors:
        stretched = normalize(wo * (self.alpha_x, self.alpha_y, 1.0))
        radius, phi = np.sqrt(u[:, 1]), 2.0 * np.pi * u[:, 2]
        across = normalize(
            np.column_stack([-stretched[:, 1], stretched[:, 0], np.zeros(len(u))]), fallback=(1.0, 0.0, 0.0)
        )
        along = np.cross(stretched, across)
        x = radius * np.cos(phi)
        lift = 0.5 * (1.0 + stretched[:, 2])
        y = (1.0 - lift) * np.sqrt(np.maximum(1.0 - x * x, 0.0)) + lift * radius * np.sin(phi)
        z = np.sqrt(np.maximum(1.0 - x * x - y * y, 0.0))
        facet = x[:, None] * across + y[:, None] * along + z[:, None] * stretched
        half = normalize(np.maximum(facet, (-np.inf, -np.inf, 0.0)) * (self.alpha_x, self.alpha_y, 1.0))
        return normalize(2.0 * dot(wo, half)[:, None] * half - wo)

    def pdf(self, wi: Vectors, wo: Vectors) -> Floats:
        half = normalize(wi + wo)
        scaled = half / (self.alpha_x, self.alpha_y, 1.0)
        facets = 1.0 / (np.pi * self.alpha_x * self.alpha_y * dot(scaled, scaled) ** 2)
        stretched = wo * (self.alpha_x, self.alpha_y, 1.0)
        visible = 0.5 / (wo[:, 2] + np.sqrt(dot(stretched, stretched)))
        return np.where(half[:, 2] > 0.0, facets * visible, 0.0)


#: Cells of the tables of `TabulatedHalfVectors` and `TabulatedLobe`.
HALF_CELLS = 90
AZIMUTH_CELLS = 32
ELEVATION_CELLS = 48
VIEWERS = 12


@dataclass(frozen=True, eq=False)
class TabulatedHalfVectors:
    """Half vectors by the BRDF's own mean over difference angles; cells (theta, phi), fine near the normal.

    `density_per_sr` (T, P) is constant in a cell; cell t ends at theta = pi/2 ((t + 1) / T)², MERL's scale.
    """

    density_per_sr: Floats

    @staticmethod
    def of(brdf: Evaluable) -> TabulatedHalfVectors:
        theta = 0.5 * np.pi * ((np.arange(HALF_CELLS) + 0.5) / HALF_CELLS) ** 2
        phi = _middles(1 if brdf.isotropic else AZIMUTH_CELLS, 2.0 * np.pi)
        half = surface_direction(theta[:, None], phi[None, :])
        total = np.zeros(half.shape[:2])
        for theta_d in np.radians([4.0, 20.0, 45.0]):
            for phi_d in _middles(4, np.pi):
                wi, wo = _around(half, theta_d, phi_d)
                total += luminance(brdf.f(wi, wo)) * np.maximum(wi[..., 2], 0.0)
        return TabulatedHalfVectors(_normalise(np.maximum(total, 0.0), _half_solid_angles(len(phi))))

    def draw(self, u: Floats) -> Vectors:
        azimuths = self.density_per_sr.shape[1]
        cell, (first, second) = _draw_cell(self.density_per_sr * _half_solid_angles(azimuths), u)
        edges = np.cos(_half_edges())
        cosine = edges[cell // azimuths] + first * (edges[cell // azimuths + 1] - edges[cell // azimuths])
        sine = np.sqrt(np.maximum((1.0 - cosine) * (1.0 + cosine), 0.0))
        phi = 2.0 * np.pi * (cell % azimuths + second) / azimuths
        return np.column_stack([sine * np.cos(phi), sine * np.sin(phi), cosine])

    def density(self, half: Vectors) -> Floats:
        theta = np.arctan2(np.hypot(half[:, 0], half[:, 1]), half[:, 2])
        row = np.minimum((np.sqrt(theta / (0.5 * np.pi)) * HALF_CELLS).astype(np.int64), HALF_CELLS - 1)
        return self.density_per_sr[row, _azimuth_cell(half, self.density_per_sr.shape[1])]


def _half_edges() -> Floats:
    return np.asarray(0.5 * np.pi * (np.arange(HALF_CELLS + 1) / HALF_CELLS) ** 2)


def _half_solid_angles(azimuths: int) -> Floats:
    """(HALF_CELLS, 1) solid angle of one cell in sr: 2 sin(middle) sin(half width), which does not cancel."""
    edges = _half_edges()
    middle, half_width = 0.5 * (edges[1:] + edges[:-1]), 0.5 * (edges[1:] - edges[:-1])
    return (2.0 * np.pi / azimuths * 2.0 * np.sin(middle) * np.sin(half_width))[:, None]


def _around(half: Vectors, theta_d: float, phi_d: float) -> tuple[Vectors, Vectors]:
    """wi at difference angles (theta_d, phi_d) from half vectors (..., 3), and wo on the other side."""
    flat = half.reshape(-1, 3)
    ones = np.ones(len(flat))
    wi = about_axis(flat, np.sin(theta_d) * ones, np.cos(theta_d) * ones, phi_d * ones)
    wo = 2.0 * dot(wi, flat)[:, None] * flat - wi
    return wi.reshape(half.shape), wo.reshape(half.shape)


@dataclass(frozen=True, eq=False)
class TabulatedLobe:
    """Directions by the BRDF's own values on a grid, for viewers on a grid between which it is mixed linearly.

    `cells` (V, E, C): the probability of each cell of wi, equal in sin² theta_i and in azimuth, for V viewers equal in
    theta_o from the normal to the horizon, and E in azimuth. The azimuth of wi counts from wo's where E is 1.
    """

    cells: Floats

    @staticmethod
    def of(brdf: Evaluable) -> TabulatedLobe:
        azimuths = 1 if brdf.isotropic else AZIMUTH_CELLS
        wi = surface_direction(
            np.arcsin(np.sqrt(_middles(ELEVATION_CELLS, 1.0)))[:, None], _middles(AZIMUTH_CELLS, 2.0 * np.pi)[None, :]
        ).reshape(-1, 3)
        theta = np.minimum(0.5 * np.pi * np.arange(VIEWERS) / (VIEWERS - 1), np.radians(89.0))
        wo = surface_direction(theta[:, None], 2.0 * np.pi * np.arange(azimuths)[None, :] / azimuths)
        seen = np.empty((VIEWERS, azimuths, len(wi)))
        for viewer in range(VIEWERS):
            seen[viewer] = np.maximum(luminance(brdf.f(wi, wo[viewer, :, None, :])), 0.0)
        return TabulatedLobe(_normalise(seen.reshape(-1, len(wi)), 1.0, axis=1).reshape(seen.shape))

    def _viewers(self, wo: Vectors) -> list[tuple[NDArray[np.int64], Floats]]:
        """The up to four rows of `cells` between which each wo (N, 3) lies, and their weights."""
        theta = np.arctan2(np.hypot(wo[:, 0], wo[:, 1]), wo[:, 2]) / (0.5 * np.pi) * (VIEWERS - 1)
        azimuths = self.cells.shape[1]
        turn = np.arctan2(wo[:, 1], wo[:, 0]) / (2.0 * np.pi) % 1.0 * azimuths
        rows = []
        for node, weight in _between(theta, VIEWERS):
            for other, share in _between(turn, azimuths, periodic=True) if azimuths > 1 else [(0, 1.0)]:
                rows.append((node * azimuths + other, weight * share))
        return rows

    def sample(self, wo: Vectors, u: Floats) -> Vectors:
        rows = self._viewers(wo)
        summed = np.cumsum([weight for _, weight in rows], axis=0)
        last = summed[-1]
        chosen = np.minimum((summed <= u[:, 0] * last).sum(axis=0), len(rows) - 1)
        row = np.choose(chosen, [node for node, _ in rows])
        before = np.where(chosen > 0, np.take_along_axis(summed, np.maximum(chosen - 1, 0)[None], 0)[0], 0.0)
        width = np.take_along_axis(summed, chosen[None], 0)[0] - before
        again = np.clip((u[:, 0] * last - before) / np.maximum(width, 1e-300), 0.0, BELOW_ONE)
        tables = self.cells.reshape(-1, self.cells.shape[-1])
        wi = np.empty_like(wo)
        for index in np.unique(row):
            mine = row == index
            cell, _ = _draw_cell(tables[index], np.column_stack([again[mine], again[mine]]))
            sine2 = (cell // AZIMUTH_CELLS + u[mine, 1]) / ELEVATION_CELLS
            phi = 2.0 * np.pi * (cell % AZIMUTH_CELLS + u[mine, 2]) / AZIMUTH_CELLS + self._start(wo[mine])
            sine = np.sqrt(sine2)
            wi[mine] = np.column_stack([sine * np.cos(phi), sine * np.sin(phi), np.sqrt(1.0 - sine2)])
        return wi

    def pdf(self, wi: Vectors, wo: Vectors) -> Floats:
        sine2 = wi[:, 0] ** 2 + wi[:, 1] ** 2
        row = np.minimum((sine2 * ELEVATION_CELLS).astype(np.int64), ELEVATION_CELLS - 1)
        cell = row * AZIMUTH_CELLS + _azimuth_cell(wi, AZIMUTH_CELLS, self._start(wo))
        tables = self.cells.reshape(-1, self.cells.shape[-1])
        probability = sum(weight * tables[node, cell] for node, weight in self._viewers(wo))
        return np.asarray(probability * self.cells.shape[-1] * np.maximum(wi[:, 2], 0.0) / np.pi)

    def _start(self, wo: Vectors) -> Floats | float:
        return np.arctan2(wo[:, 1], wo[:, 0]) if self.cells.shape[1] == 1 else 0.0


def _middles(count: int, period: float) -> Floats:
    return np.asarray(period * (np.arange(count) + 0.5) / count)


def _azimuth_cell(direction: Vectors, count: int, start: Floats | float = 0.0) -> NDArray[np.int64]:
    """The cell among `count` equal ones, counted from the azimuth `start`, in which each direction (N, 3) lies."""
    turn = (np.arctan2(direction[:, 1], direction[:, 0]) - start) / (2.0 * np.pi) % 1.0
    return np.asarray(np.minimum((turn * count).astype(np.int64), count - 1))


def _normalise(values: Floats, sizes: Floats | float, axis: int | None = None) -> Floats:
    """`values` ≥ 0 scaled so that they sum to 1 times `sizes`, none below 1e-3 of their mean; equal where all are 0."""
    mean = np.mean(values, axis=axis, keepdims=True)
    kept = np.where(mean > 0.0, np.maximum(values, 1e-3 * mean), 1.0)
    return np.asarray(kept / np.sum(kept * sizes, axis=axis, keepdims=True))


def _draw_cell(probabilities: Floats, u: Floats) -> tuple[NDArray[np.int64], tuple[Floats, Floats]]:
    """Flat indices (N,) of cells drawn by u[:, 0], and two numbers in [0, 1) for the place inside: u's rest."""
    summed = np.cumsum(probabilities.ravel())
    target = u[:, 0] * summed[-1]
    cell = np.minimum(np.searchsorted(summed, target, side="right"), summed.size - 1)
    inside = (target - np.where(cell > 0, summed[cell - 1], 0.0)) / probabilities.ravel()[cell]
    return cell, (np.clip(inside, 0.0, BELOW_ONE), u[:, 1])


def _between(position: Floats, count: int, *, periodic: bool = False) -> list[tuple[NDArray[np.int64], Floats]]:
    """The two nodes on either side of a position in units of nodes, with linear weights."""
    lower = np.floor(position).astype(np.int64)
    lower = lower % count if periodic else np.clip(lower, 0, count - 2)
    share = position - np.floor(position) if periodic else np.clip(position - lower, 0.0, 1.0)
    return [(lower, 1.0 - share), ((lower + 1) % count, share)]

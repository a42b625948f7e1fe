"""Lobes from which directions are drawn, each with its density: closed forms, and mixtures of any.

A sampler draws directions towards the light for a fixed viewer. A lobe may send directions below the horizon: a BRDF
is 0 there, the density is not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from engine.brdf.highlight import power_of_one_minus
from engine.directions import Vectors, dot, normalize

Floats = NDArray[np.float64]


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
    """√((nu + 1)(nv + 1)) / (2 pi) (n·h)^(nu cos² phi + nv sin² phi): Ashikhmin and Shirley 2000, equation 6."""

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
    """The GGX facets that the viewer sees (Heitz 2018); density D / (2 (wo.z + |(αx wo.x, αy wo.y, wo.z)|))."""

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

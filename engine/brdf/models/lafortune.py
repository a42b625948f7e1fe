"""Lafortune's generalised cosine lobes (Lafortune1997), one lobe or three.

A lobe is max(0, cxy (wi_x wo_x + wi_y wo_y) + cz wi_z wo_z)^n; cxy = −1, cz = 1 is Phong's. With m = max(|cxy|, |cz|)
it is m^n (1 − d)^n, and since directions are unit vectors

    2m d = Σ_xy |cxy| (p ± q)² + (m − |cxy|)(p² + q²)  +  |cz| (z ∓ z')² + (m − |cz|)(z² + z'²),

a sum of positive terms, so that nothing cancels where the lobe is sharp. GLSL counterparts: resources/shaders/brdf/.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.brdf.models.evaluate import channels, diffuse_and_highlight, power_of_one_minus
from engine.brdf.models.model import Model
from engine.brdf.models.sampling import Lobes, grey
from engine.brdf.models.sampling_lobes import PowerLobe, Sampler
from engine.core.colour import LUMINANCE
from engine.core.params import Colour, param

Floats = NDArray[np.float64]

_SHAPE = "Above 1 the lobe is higher than a cosine's."


@dataclass(frozen=True)
class Lafortune(Model):
    """f = kd/π + ks (n + 2)/(2π m^n) max(0, cxy (wi_x wo_x + wi_y wo_y) + cz wi_z wo_z)^n, m = max(|cxy|, |cz|).

    One lobe as Ngan2005 normalise it. Without direction (cxy = cz = 0) there is no highlight.
    """

    name: ClassVar[str] = "lafortune"
    label: ClassVar[str] = "Lafortune"
    diffuse_parameter: ClassVar[str] = "kd"

    kd: Colour = param((0.3, 0.3, 0.3), 0.0, 1.0, doc="Diffuse reflectance.")
    ks: Colour = param((0.2, 0.2, 0.2), 0.0, 10.0, doc="Strength of the highlight.", slider=(0.0, 1.0))
    cxy: float = param(-0.6, -1.0, 1.0, doc="Weight along the surface; negative is forward, positive back.")
    cz: float = param(0.5, -1.0, 1.0, doc="Weight along the normal; only its ratio to the other counts.")
    exponent: float = param(20.0, 0.0, 1e6, doc="Sharpness of the highlight.", slider=(1.0, 1000.0), log=True)

    @property
    def energy_conserving(self) -> bool:
        m = max(abs(self.cxy), abs(self.cz))
        shape = (self.cxy / m, self.cz / m) if m else (0.0, 0.0)
        strengths = [strength * (self.exponent + 2.0) / (2.0 * np.pi) for strength in self.ks]
        return all(
            _conserves(diffuse, [Lobe(strength, *shape, self.exponent)])
            for diffuse, strength in zip(self.kd, strengths, strict=True)
        )

    def sampling_lobes(self) -> Lobes:
        size = max(abs(self.cxy), abs(self.cz)) or 1.0
        turn = (self.cxy / size, self.cxy / size, self.cz / size)
        return [(PowerLobe(self.exponent, turn), grey(self.ks))], grey(self.kd)

    def formula(self, wi: Floats, wo: Floats) -> Floats:
        m = max(abs(self.cxy), abs(self.cz))
        if m == 0.0:
            return channels(self.kd) / np.pi
        lobe = power_of_one_minus(_deficit(wi, wo, self.cxy, self.cz), self.exponent)
        return diffuse_and_highlight(self.kd, self.ks, (self.exponent + 2.0) / (2.0 * np.pi) * lobe)


@dataclass(frozen=True)
class LafortuneThreeLobes(Model):
    """f = kd/π + Σ over three lobes of max(0, cxy (wi_x wo_x + wi_y wo_y) + cz wi_z wo_z)^n, each channel for itself.

    The form of Lafortune1997, in which the published fits of measured materials are given: a lobe's strength
    is in cxy and cz. In texts it goes by the name `lafortune`, with `cxy1`, `cz1`, `exponent1` and so on.
    """

    name: ClassVar[str] = "lafortune-three-lobes"
    label: ClassVar[str] = "Lafortune, three lobes"
    form_of: ClassVar[str] = "lafortune"
    diffuse_parameter: ClassVar[str] = "kd"

    kd: Colour = param((0.3094, 0.39667, 0.70837), 0.0, 1.0, doc="Diffuse reflectance.")
    cxy1: Colour = param((0.870567, 0.857255, 0.670982), -3.0, 3.0, doc=f"First lobe along the surface. {_SHAPE}")
    cz1: Colour = param((0.803624, 0.77429, 0.586674), -3.0, 3.0, doc=f"First lobe along the normal. {_SHAPE}")
    exponent1: Colour = param((21.820103, 18.597755, 7.472717), 0.0, 500.0, doc="Sharpness of the first lobe.")
    cxy2: Colour = param((-0.451218, -0.406681, -0.477976), -3.0, 3.0, doc=f"Second lobe along the surface. {_SHAPE}")
    cz2: Colour = param((0.023123, 0.017625, 0.227295), -3.0, 3.0, doc=f"Second lobe along the normal. {_SHAPE}")
    exponent2: Colour = param((2.774499, 2.581499, 3.677653), 0.0, 500.0, doc="Sharpness of the second lobe.")
    cxy3: Colour = param((-1.031545, -1.029426, -1.026588), -3.0, 3.0, doc=f"Third lobe along the surface. {_SHAPE}")
    cz3: Colour = param((0.706734, 0.69653, 0.687715), -3.0, 3.0, doc=f"Third lobe along the normal. {_SHAPE}")
    exponent3: Colour = param((66.89906, 63.767912, 57.489181), 0.0, 500.0, doc="Sharpness of the third lobe.")

    @property
    def lobes(self) -> tuple[tuple[Colour, Colour, Colour], ...]:
        """cxy, cz and exponent of each lobe."""
        return (
            (self.cxy1, self.cz1, self.exponent1),
            (self.cxy2, self.cz2, self.exponent2),
            (self.cxy3, self.cz3, self.exponent3),
        )

    @property
    def energy_conserving(self) -> bool:
        return all(
            _conserves(self.kd[k], [Lobe(1.0, cxy[k], cz[k], exponent[k]) for cxy, cz, exponent in self.lobes])
            for k in range(3)
        )

    def sampling_lobes(self) -> Lobes:
        """The lobes of each channel, by its part in the luminance and the lobe's largest albedo 2 pi / (n + 2) m^n."""
        found: list[tuple[Sampler, float]] = []
        for cxy, cz, exponent in self.lobes:
            for channel, share in enumerate(LUMINANCE):
                size = max(abs(cxy[channel]), abs(cz[channel]))
                energy = float(share) * size ** exponent[channel] * 2.0 * np.pi / (exponent[channel] + 2.0)
                turn = (cxy[channel], cxy[channel], cz[channel])
                found.append((PowerLobe(exponent[channel], turn), energy))
        return found, grey(self.kd)

    def formula(self, wi: Floats, wo: Floats) -> Floats:
        value = np.repeat(channels(self.kd) / np.pi, wi.shape[1], axis=1)
        for lobe in self.lobes:
            for row, cxy, cz, exponent in zip(value, *lobe, strict=True):
                m = max(abs(cxy), abs(cz))
                if m > 0.0:
                    row += m**exponent * power_of_one_minus(_deficit(wi, wo, cxy, cz), exponent)
                elif exponent == 0.0:
                    row += 1.0
        return value


def _deficit(wi: Floats, wo: Floats, cxy: float, cz: float) -> Floats:
    """1 − (cxy (wi_x wo_x + wi_y wo_y) + cz wi_z wo_z)/m, (n,)."""
    m = max(abs(cxy), abs(cz))
    twice = _one_minus(wi[0], wo[0], cxy, m) + _one_minus(wi[1], wo[1], cxy, m) + _one_minus(wi[2], wo[2], cz, m)
    return twice / (2.0 * m)


def _one_minus(p: Floats, q: Floats, weight: float, m: float) -> Floats:
    """m (p² + q²) − 2 weight p q for |weight| <= m."""
    size = abs(weight)
    difference = p - q if weight > 0.0 else p + q
    square = size * difference**2
    return square if size == m else square + (m - size) * (p * p + q * q)


class Lobe(NamedTuple):
    """strength · max(0, cxy (…) + cz (…))^exponent of one channel."""

    strength: float
    cxy: float
    cz: float
    exponent: float


def _conserves(diffuse: float, lobes: Iterable[Lobe]) -> bool:
    """True if the albedo is at most 1 towards every direction.

    Seen from one direction a lobe is |v|^n times a cosine power about v = (cxy sin, 0, cz cos), and reflects at most
    2π/(n + 2) |v|^n (Hölder's inequality), which is reached where v is the normal. Where the sum of these bounds
    exceeds 1 the albedo itself decides, which is known to 1e-3.
    """
    lobes = list(lobes)
    bound = diffuse + sum(
        lobe.strength * max(abs(lobe.cxy), abs(lobe.cz)) ** lobe.exponent * 2.0 * np.pi / (lobe.exponent + 2.0)
        for lobe in lobes
    )
    if bound <= 1.0 + 1e-12:
        return True
    theta = np.linspace(0.0, np.pi / 2, 181)
    albedo = diffuse + sum(_albedo(lobe, theta) for lobe in lobes)
    return bool(np.max(albedo) <= 1.0 - 1e-3)


def _albedo(lobe: Lobe, theta: Floats) -> Floats:
    """∫ strength max(0, v·w)^n max(0, w_z) dw over the hemisphere, (T,), for viewers at polar angles `theta` (T,).

    About v, cos ψ = t^(1/(n+2)) takes the power into the measure, and the integral over azimuth has a closed form:
    w_z = A + B cos φ with A = cos γ cos ψ, B = sin γ sin ψ, γ the angle between v and the normal.
    """
    along, up = lobe.cxy * np.sin(theta), lobe.cz * np.cos(theta)
    gamma = np.arctan2(np.abs(along), up)[:, None]
    t = (np.arange(400) + 0.5) / 400
    cosine = t ** (1.0 / (lobe.exponent + 2.0))
    a, b = np.cos(gamma) * cosine, np.sin(gamma) * np.sqrt(1.0 - cosine**2)
    edge = np.arccos(np.clip(-a / np.maximum(b, 1e-300), -1.0, 1.0))
    around = 2.0 * (a * edge + b * np.sin(edge))
    length = np.hypot(along, up) ** lobe.exponent
    return lobe.strength * length * np.mean(np.maximum(around, 0.0) / cosine, axis=1) / (lobe.exponent + 2.0)

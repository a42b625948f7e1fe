"""Importance sampling of BRDFs: directions towards the light, drawn where f cos(theta_i) is large.

A sampler is made once for a BRDF and serves every viewer:

    sampler = sampler_of(brdf)
    wi = sampler.sample(wo, u)          # (N, 3) for wo (N, 3) and u (N, 3) uniform in [0, 1)
    density = sampler.pdf(wi, wo)       # (N,) in 1/sr, over the whole sphere of wi

The mean of f cos(theta_i) / density over such directions is the albedo towards wo. Every sampler is a mixture of
lobes, with shares that do not depend on wo; a cosine lobe is always among them, so that no direction that reflects is
left out. A lobe may send directions below the horizon: f is 0 there, the density is not.

What samples itself (`sample` and `pdf`, as measurements in an adaptive parametrisation do) is one of the lobes of its
mixture. Everything that has no closed form is drawn from two tables of its values: one over the half vector, which
resolves narrow highlights, one over the direction itself, which finds the others.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from engine.brdf.brdf import Brdf
from engine.brdf.models.diffuse import Lambert, OrenNayar
from engine.brdf.models.lafortune import Lafortune, LafortuneThreeLobes
from engine.brdf.models.microfacet import AshikhminShirley, CookTorrance, Ggx, GgxAnisotropic, MetallicRoughness, Ward
from engine.brdf.models.phong import BlinnPhong, Phong
from engine.brdf.sampling_lobes import (
    CosineLobe,
    GaussianHalfVectors,
    HalfVectorLobe,
    HalfVectors,
    Mixture,
    PowerHalfVectors,
    PowerLobe,
    Sampler,
    TabulatedHalfVectors,
    TabulatedLobe,
    VisibleGgxLobe,
)
from engine.core.colour import LUMINANCE, luminance

#: Share of the cosine lobe in every mixture: it bounds the weight f cos / pdf where the other lobes miss something.
COSINE_SHARE = 0.2


def sampler_of(brdf: Brdf) -> Sampler:
    """The sampler of any BRDF: its closed form where there is one, else tables of its values (about 0.1 s)."""
    closed = _find_closed_form(brdf)
    if closed is not None:
        return _mixture(*closed)
    own: Any = brdf
    if hasattr(own, "sample") and hasattr(own, "pdf"):
        return _mixture([(own, 1.0)])
    return _mixture([(HalfVectorLobe(TabulatedHalfVectors.of(brdf)), 0.5), (TabulatedLobe.of(brdf), 0.5)])


def _find_closed_form(brdf: Brdf) -> tuple[list[tuple[Sampler, float]], float] | None:
    """The lobes of an analytic model with their energies, and the diffuse energy; None where tables must serve."""
    match brdf:
        case Lambert() | OrenNayar():
            return [], 1.0
        case Phong():
            return [(PowerLobe(brdf.exponent), _grey(brdf.ks))], _grey(brdf.kd)
        case BlinnPhong():
            facets: HalfVectors = PowerHalfVectors(brdf.exponent, brdf.exponent)
            return [(HalfVectorLobe(facets), _grey(brdf.ks))], _grey(brdf.kd)
        case Lafortune():
            size = max(abs(brdf.cxy), abs(brdf.cz)) or 1.0
            turn = (brdf.cxy / size, brdf.cxy / size, brdf.cz / size)
            return [(PowerLobe(brdf.exponent, turn), _grey(brdf.ks))], _grey(brdf.kd)
        case LafortuneThreeLobes():
            return _three_lobes(brdf), _grey(brdf.kd)
        case Ward():
            facets = GaussianHalfVectors(brdf.alpha_x, brdf.alpha_y)
            return [(HalfVectorLobe(facets), _grey(brdf.ks))], _grey(brdf.kd)
        case AshikhminShirley():
            facets = PowerHalfVectors(brdf.nu, brdf.nv)
            return [(HalfVectorLobe(facets), _FRESNEL + _grey(brdf.ks))], _grey(brdf.kd)
        case CookTorrance():
            facets = GaussianHalfVectors(brdf.m, brdf.m)
            return [(HalfVectorLobe(facets), _grey(brdf.ks) * (_FRESNEL + _grey(brdf.f0)))], _grey(brdf.kd)
        case Ggx():
            return [(VisibleGgxLobe(brdf.alpha, brdf.alpha), _FRESNEL + _grey(brdf.f0))], _grey(brdf.kd)
        case GgxAnisotropic():
            return [(VisibleGgxLobe(brdf.alpha_x, brdf.alpha_y), _FRESNEL + _grey(brdf.f0))], _grey(brdf.kd)
        case MetallicRoughness():
            alpha, base = brdf.roughness**2, _grey(brdf.base_color)
            f0 = 0.04 + (base - 0.04) * brdf.metallic
            return [(VisibleGgxLobe(alpha, alpha), _FRESNEL + f0)], base * (1.0 - brdf.metallic)
    return None


def _three_lobes(brdf: LafortuneThreeLobes) -> list[tuple[Sampler, float]]:
    """The lobes of each channel, by its part in the luminance and the lobe's largest albedo 2 pi / (n + 2) m^n."""
    lobes: list[tuple[Sampler, float]] = []
    for cxy, cz, exponent in brdf.lobes:
        for channel, share in enumerate(LUMINANCE):
            size = max(abs(cxy[channel]), abs(cz[channel]))
            energy = float(share) * size ** exponent[channel] * 2.0 * np.pi / (exponent[channel] + 2.0)
            turn = (cxy[channel], cxy[channel], cz[channel])
            lobes.append((PowerLobe(exponent[channel], turn), energy))
    return lobes


#: Least part of all energy for which a lobe has a share: less than this would be lost to rounding beside the others.
MIN_ENERGY = 1e-9

#: Reflection of Schlick's Fresnel term under even light beside f0: the mean of (1 − cos)^5, 1/21, and more.
_FRESNEL = 0.05


def _mixture(lobes: list[tuple[Sampler, float]], diffuse: float = 0.0) -> Mixture:
    """The lobes by their energy beside a cosine lobe, whose share is the diffuse energy's or COSINE_SHARE if larger."""
    whole = diffuse + sum(energy for _, energy in lobes)
    used = [(lobe, energy) for lobe, energy in lobes if energy > MIN_ENERGY * whole]
    total = sum(energy for _, energy in used)
    if not used:
        return Mixture((CosineLobe(),), (1.0,))
    cosine = max(COSINE_SHARE, diffuse / (diffuse + total))
    shares = [(1.0 - cosine) * (energy / total) for _, energy in used]
    return Mixture((CosineLobe(), *(lobe for lobe, _ in used)), (1.0 - sum(shares), *shares))


def _grey(colour: ArrayLike) -> float:
    return float(luminance(colour))

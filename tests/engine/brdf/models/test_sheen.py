"""Sheen of glTF against its equations in exact arithmetic, its albedo by quadrature, and the furnace."""

from __future__ import annotations

from dataclasses import replace

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

from engine.brdf.models.microfacet import MetallicRoughness
from engine.brdf.models.sheen import sheen, sheen_albedo
from engine.core.directions import surface_direction
from tests.engine.brdf.all_models import pairs

Floats = NDArray[np.float64]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(160)
#: Nodes of cosines in (0, 1), close together near the horizon, with weights of ∫ … μ dμ.
COSINES = (0.5 + 0.5 * _NODES) ** 4
SHARES = 2.0 * _WEIGHTS * (0.5 + 0.5 * _NODES) ** 3 * COSINES
#: Azimuths in (0, π), close together at π, where half vectors turn fast, with weights of twice ∫ … dφ.
AZIMUTHS = np.pi * (1.0 - (0.5 + 0.5 * _NODES) ** 2)
TURNS = 2.0 * np.pi * _WEIGHTS * (0.5 + 0.5 * _NODES)

BASE = MetallicRoughness((0.9, 0.5, 0.2), 0.3, 0.4, 1.0)


def albedo(brdf: MetallicRoughness, cosine: float) -> float:
    """The share of light from a direction of this cosine that leaves, by quadrature."""
    wi = surface_direction(np.arccos(COSINES)[:, None], AZIMUTHS[None])
    return float(SHARES @ (brdf.f(wi, surface_direction(np.arccos(cosine), 0.0))[..., 0] @ TURNS))


def visible_distribution(nl: mpmath.mpf, nv: mpmath.mpf, nh: mpmath.mpf, roughness: float) -> mpmath.mpf:
    """D V as the implementation notes of KHR_materials_sheen have it."""
    alpha = mpmath.mpf(roughness) ** 2
    smooth = (1 - alpha) ** 2
    ends = zip(
        ("21.5473", "3.82987", "0.19823", "-1.97760", "-4.32054"),
        ("25.3245", "3.32435", "0.16801", "-1.27393", "-4.85967"),
        strict=True,
    )
    a, b, c, d, e = (mpmath.mpf(one) * (1 - smooth) + mpmath.mpf(other) * smooth for one, other in ends)

    def logarithm(x: mpmath.mpf) -> mpmath.mpf:
        return a / (1 + b * x**c) + d * x + e

    def shadowing(x: mpmath.mpf) -> mpmath.mpf:
        return mpmath.exp(logarithm(x) if x < 0.5 else 2 * logarithm(mpmath.mpf("0.5")) - logarithm(1 - x))

    distribution = (2 + 1 / alpha) * (1 - nh**2) ** (1 / (2 * alpha)) / (2 * mpmath.pi)
    return distribution / ((1 + shadowing(nv) + shadowing(nl)) * 4 * nv * nl)


@pytest.mark.parametrize("roughness", [0.05, 0.3, 0.8, 1.0])
def test_the_lobe_is_the_one_of_the_extension(roughness: float) -> None:
    mpmath.mp.dps = 40
    wi, wo = pairs(12, seed=5)
    half = wi + wo
    sine2 = (half[:, 0] ** 2 + half[:, 1] ** 2) / np.sum(half * half, axis=1)
    found = sheen(wi[:, 2], wo[:, 2], sine2, roughness, 1.0)[0]
    for value, i, o in zip(found, wi, wo, strict=True):
        sums = [mpmath.mpf(float(a)) + mpmath.mpf(float(b)) for a, b in zip(i, o, strict=True)]
        cosine = sums[2] / mpmath.sqrt(sum(each**2 for each in sums))
        wanted = visible_distribution(mpmath.mpf(float(i[2])), mpmath.mpf(float(o[2])), cosine, roughness)
        assert abs(value - float(wanted)) <= 1e-12 * float(wanted) + 1e-200


@pytest.mark.parametrize("roughness", [0.05, 0.11, 0.24, 0.3, 0.47, 0.66, 0.85, 1.0])
def test_the_albedo_is_that_of_the_lobe(roughness: float) -> None:
    """As far as 1; a smooth sheen exceeds it towards the horizon, which leaves nothing of the base."""
    for cosine in (0.003, 0.01, 0.05, 0.2, 0.43, 0.7, 0.999):
        wi = surface_direction(np.arccos(COSINES)[:, None], AZIMUTHS[None])
        both = wi + surface_direction(np.arccos(cosine), 0.0)
        sine2 = (both[..., 0] ** 2 + both[..., 1] ** 2) / np.sum(both * both, axis=-1)
        lobe = sheen(wi[..., 2], np.full(sine2.shape, cosine), sine2, roughness, 1.0)[0]
        own = float(SHARES @ (lobe @ TURNS))
        assert min(own, 1.0) == pytest.approx(min(float(sheen_albedo(np.array(cosine), roughness)), 1.0), abs=0.004)


@pytest.mark.parametrize("roughness", [0.3, 0.5, 0.82, 1.0])
def test_sheen_over_white_facets_passes_the_furnace(roughness: float) -> None:
    facets = MetallicRoughness((1.0, 1.0, 1.0), 1.0, 0.6, 1.0, sheen_color=(1.0, 1.0, 1.0), sheen_roughness=roughness)
    assert facets.energy_conserving
    assert facets.reciprocal
    assert not replace(facets, sheen_roughness=0.2).energy_conserving
    found = [albedo(facets, cosine) for cosine in (0.003, 0.01, 0.02, 0.1, 0.4, 0.95)]
    assert max(found) <= 1.0 + 5e-5
    assert min(found) > 0.7


@pytest.mark.parametrize("roughness", [0.0, 0.3, 1.0])
def test_BR9_it_is_reciprocal_to_the_last_bit(roughness: float) -> None:
    wi, wo = pairs(20_000, seed=3)
    brdf = replace(BASE, sheen_color=(0.2, 0.7, 1.0), sheen_roughness=roughness)
    assert np.array_equal(brdf.f(wi, wo), brdf.f(wo, wi))


def test_black_sheen_is_the_base() -> None:
    wi, wo = pairs(200, seed=2)
    for base in (BASE, replace(BASE, coat_weight=0.7, coat_roughness=0.2)):
        np.testing.assert_array_equal(replace(base, sheen_roughness=0.9).f(wi, wo), base.f(wi, wo))


def test_the_clear_coat_lies_over_sheen() -> None:
    """A coat of share s leaves 1 − s of what sheen adds to the base."""
    wi, wo = pairs(50, seed=3)
    fibrous = replace(BASE, sheen_color=(0.8, 0.4, 0.1), sheen_roughness=0.4)
    added = fibrous.f(wi, wo) - BASE.f(wi, wo)
    share = 0.7 * (0.04 + 0.96 * (1.0 - wo[:, 2:]) ** 5)
    both, alone = (replace(each, coat_weight=0.7, coat_roughness=0.2).f(wi, wo) for each in (fibrous, BASE))
    np.testing.assert_allclose(both - alone, (1.0 - share) * added, rtol=1e-9, atol=1e-12)

"""Light that facets scatter more than once, by the furnace: white facets under even light must vanish in it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.brdf.models.microfacet import MetallicRoughness
from engine.brdf.models.multiple_scattering import CORRELATED, SEPARABLE, Facets, multiple_scattering
from engine.core.directions import surface_direction

Floats = NDArray[np.float64]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(200)
#: Nodes of cosines in (0, 1), close together near the horizon, with weights of ∫ … 2μ dμ.
COSINES = (0.5 + 0.5 * _NODES) ** 3
SHARES = 3.0 * _WEIGHTS * (0.5 + 0.5 * _NODES) ** 2 * COSINES


def albedo_of_one_reflection(
    cosine: float, alpha: float, facets: Facets = SEPARABLE, rings: int = 96, sectors: int = 192
) -> float:
    """E: the mean of G₂/G₁ over visible normals (Heitz2018), F = 1."""
    radius, radius_weight = np.polynomial.legendre.leggauss(rings)
    square, azimuth = np.meshgrid(0.5 + 0.5 * radius, 2.0 * np.pi * (np.arange(sectors) + 0.5) / sectors, indexing="ij")
    viewer = np.array([np.sqrt(1.0 - cosine**2), 0.0, cosine])
    stretched = viewer * (alpha, alpha, 1.0)
    stretched /= np.linalg.norm(stretched)
    across = np.array([0.0, 1.0, 0.0])
    first, second = np.sqrt(square) * np.cos(azimuth), np.sqrt(square) * np.sin(azimuth)
    lifted = 0.5 * (1.0 + stretched[2])
    second = (1.0 - lifted) * np.sqrt(np.maximum(1.0 - first**2, 0.0)) + lifted * second
    third = np.sqrt(np.maximum(1.0 - first**2 - second**2, 0.0))
    normal = first[..., None] * across + second[..., None] * np.cross(stretched, across) + third[..., None] * stretched
    facet = normal * (alpha, alpha, 1.0)
    facet /= np.linalg.norm(facet, axis=-1, keepdims=True)
    light = 2.0 * (facet @ viewer) * facet[..., 2] - cosine
    above = np.maximum(light, 1e-12)
    slope, own = (np.sqrt(alpha**2 + (1.0 - alpha**2) * each**2) for each in (above, cosine))
    shadowing = 2.0 * above / (above + slope)
    if facets is CORRELATED:
        shadowing = above * (cosine + own) / (slope * cosine + own * above)
    return float(0.5 * radius_weight @ np.where(light > 0.0, shadowing, 0.0).mean(axis=1))


@pytest.mark.parametrize("roughness", [0.02, 0.05, 0.13, 0.3, 0.47, 0.66, 0.85, 1.0])
@pytest.mark.parametrize("facets", [SEPARABLE, CORRELATED], ids=["separable", "correlated"])
def test_white_facets_return_all_light_and_no_more(facets: Facets, roughness: float) -> None:
    alpha = roughness**2
    for cosine in (0.002, 0.02, 0.11, 0.37, 0.73, 1.0):
        once = albedo_of_one_reflection(cosine, alpha, facets)
        again = np.pi * multiple_scattering(COSINES, cosine, alpha, 1.0, facets) @ SHARES
        assert 0.99 <= once + again <= 1.0 + 2e-4


@pytest.mark.parametrize("roughness", [0.4, 0.7, 1.0])
def test_the_model_passes_the_furnace(roughness: float) -> None:
    """By quadrature of the model's own values, over directions of light; without the lobe up to 69 % are lost."""
    azimuth = 2.0 * np.pi * (np.arange(256) + 0.5) / 256
    for cosine in (0.1, 0.5, 0.95):
        wo = surface_direction(np.arccos(cosine), 0.0)
        wi = surface_direction(np.arccos(COSINES)[:, None], azimuth[None])
        for coat in (0.0, 0.7):
            white = MetallicRoughness((1.0, 1.0, 1.0), 1.0, roughness, 1.0, coat, roughness)
            albedo = np.pi * white.f(wi, wo)[..., 0].mean(axis=1) @ SHARES
            assert 0.99 <= albedo <= 1.0 + 5e-5
    assert (
        roughness < 1.0 or np.pi * MetallicRoughness((1.0, 1.0, 1.0), 1.0, 1.0).f(wi, wo)[..., 0].mean(1) @ SHARES < 0.4
    )


def test_the_mean_loss_is_that_of_the_loss() -> None:
    roughness = np.linspace(0.02, 1.0, 29)
    for facets in (SEPARABLE, CORRELATED):
        mean = np.array([SHARES @ facets.loss(COSINES, each**2) for each in roughness])
        np.testing.assert_allclose(facets.mean_loss(roughness**2), mean, rtol=9e-3)


def test_coloured_facets_grow_more_saturated() -> None:
    """Each further reflection takes the colour once more: F̄ of red over blue is above F0 of red over blue."""
    red, blue = (float(multiple_scattering(0.6, 0.7, 0.8, f0)) for f0 in (0.9, 0.3))
    assert red / blue > 0.9 / 0.3


def test_it_is_reciprocal() -> None:
    assert multiple_scattering(0.2, 0.9, 0.5, 0.7) == multiple_scattering(0.9, 0.2, 0.5, 0.7)

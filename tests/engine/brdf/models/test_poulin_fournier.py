"""Cylinders on a floor against rays that are cast in their cross-section, and against what has a closed form."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.brdf.models.poulin_fournier import PoulinFournier
from engine.core.directions import normalize, surface_direction
from tests.engine.brdf.all_models import pairs


def is_blocked(y: np.ndarray, z: np.ndarray, direction: np.ndarray, spacing: float) -> np.ndarray:
    """True if a ray from (y, z) towards `direction` across the cylinders enters one of seven discs of radius 1."""
    dy, dz = direction[1:] / np.hypot(*direction[1:])
    hit = np.zeros(y.shape, bool)
    for centre in spacing * np.arange(-3, 4):
        ahead = (centre - y) * dy - z * dz
        distance = np.abs((centre - y) * dz + z * dy)
        leaves = ahead + np.sqrt(np.maximum(1.0 - distance**2, 0.0))
        hit |= (distance < 1.0) & (leaves > 1e-9)
    return hit


def cross_section(brdf: PoulinFournier, wi: np.ndarray, wo: np.ndarray, count: int = 8_000) -> np.ndarray:
    """The average over points of the profile, (3,), by midpoints; points on a disc leave it along their normal."""
    end = np.arccos(brdf.floor)
    angle = end * ((np.arange(count) + 0.5) / count * 2 - 1)
    flat = np.sin(end) + (brdf.spacing - 2 * np.sin(end)) * (np.arange(count) + 0.5) / count
    y = np.concatenate([np.sin(angle), flat])
    z = np.concatenate([np.cos(angle), np.full(count, brdf.floor)])
    normal_y, normal_z = np.concatenate([[np.sin(angle), np.cos(angle)], [np.zeros(count), np.ones(count)]], axis=1)
    step = np.concatenate([np.full(count, 2 * end / count), np.full(count, (brdf.spacing - 2 * np.sin(end)) / count)])
    ni, no = (normal_y * w[1] + normal_z * w[2] for w in (wi, wo))
    seen = (ni > 0) & (no > 0)
    lift = 1e-7
    for w in (wi, wo):
        seen &= ~is_blocked(y + lift * normal_y, z + lift * normal_z, w, brdf.spacing)
    lobe = np.maximum(2 * ni * no - wi @ wo, 0.0) ** brdf.exponent
    phong = np.array(brdf.kd)[:, None] / np.pi + np.array(brdf.ks)[:, None] * (brdf.exponent + 2) / (2 * np.pi) * lobe
    return np.sum(phong * np.where(seen, ni * no, 0.0) * step, axis=1) / (brdf.spacing * wi[2] * wo[2])


@pytest.mark.parametrize(
    "brdf",
    [
        PoulinFournier(),
        PoulinFournier(kd=cast(Any, 0.1), ks=(0.5, 0.2, 0.9), exponent=7.5, spacing=2.0, floor=0.0),
        PoulinFournier(kd=cast(Any, 0.2), ks=cast(Any, 0.6), exponent=300.0, spacing=3.5, floor=0.7),
        PoulinFournier(kd=cast(Any, 0.2), ks=cast(Any, 0.6), exponent=1.0, spacing=6.0, floor=0.0),
    ],
    ids=["default", "touching", "sharp", "apart"],
)
def test_value_equals_rays_cast_in_the_cross_section(brdf: PoulinFournier) -> None:
    wi, wo = pairs(60, seed=2)
    low = np.radians([60.0, 75.0, 80.0, 85.0])
    wi = np.concatenate([wi, surface_direction(low, np.pi / 2), surface_direction(low, -np.pi / 2 + 0.3)])
    wo = np.concatenate([wo, surface_direction(low, -np.pi / 2), surface_direction(low[::-1], -np.pi / 2)])
    values = brdf.f(wi, wo)
    expected = np.array([cross_section(brdf, i, o) for i, o in zip(wi, wo, strict=True)])
    assert np.abs(values - expected).max(axis=1) == pytest.approx(0.0, abs=2e-3 * float(expected.max()))
    smooth = expected[:, 0] > 0.02
    assert np.median(np.abs(values / expected - 1)[smooth]) < 1e-4
    assert np.abs(values / expected - 1)[smooth].max() < 2e-2


def test_a_floor_at_the_top_is_a_phong_plane() -> None:
    wi, wo = pairs(2000)
    plane = brdf_from_text("phong:kd=0.3,ks=0.4,exponent=60").f(wi, wo)
    hidden = brdf_from_text("poulin-fournier:kd=0.3,ks=0.4,exponent=60,floor=1").f(wi, wo)
    assert hidden == pytest.approx(plane, rel=1e-12)


def test_touching_diffuse_cylinders_seen_and_lit_from_above() -> None:
    """∫ cos² φ dφ over the upper half, over a period of 2: kd/π · π/4."""
    normal = np.array([0.0, 0.0, 1.0])
    value = brdf_from_text("poulin-fournier:kd=0.8,ks=0,spacing=2,floor=0").f(normal, normal)
    assert value == pytest.approx([0.8 / np.pi * np.pi / 4] * 3, rel=1e-6)


@pytest.mark.parametrize("exponent", [1.0, 3.5, 40.0, 1e4, 1e6])
def test_quadrature_of_the_highlight_is_good_to_1e_6(exponent: float) -> None:
    """From above, spacing 2: (n+2)/(2π) / 2 · ∫ cos(2φ)^n cos² φ dφ over |φ| < π/4, by many more nodes."""
    normal = np.array([0.0, 0.0, 1.0])
    value = brdf_from_text(f"poulin-fournier:kd=0,ks=1,exponent={exponent},spacing=2,floor=0").f(normal, normal)
    x, w = np.polynomial.legendre.leggauss(400)
    reach = min(np.pi / 4, 10.0 / np.sqrt(exponent))
    phi = reach * x
    integral = reach * np.sum(w * np.maximum(np.cos(2 * phi), 0.0) ** exponent * np.cos(phi) ** 2)
    assert value == pytest.approx([(exponent + 2) / (4 * np.pi) * integral] * 3, rel=1e-6)


def test_cylinders_streak_the_highlight_across_themselves() -> None:
    """Tilted along the grooves the mirror direction is bright; across them the highlight is spread over all angles."""
    brdf = brdf_from_text("poulin-fournier:kd=0,ks=0.5,exponent=400,spacing=2.5,floor=0")
    normal = np.array([0.0, 0.0, 1.0])
    along, across = surface_direction(0.4, 0.0), surface_direction(0.4, np.pi / 2)
    assert brdf.f(normal, across)[0] > 1e3 * brdf.f(normal, along)[0]


def test_mirrored_directions_reflect_alike() -> None:
    wi, wo = pairs(1000)
    brdf = PoulinFournier()
    for mirror in ((-1, 1, 1), (1, -1, 1)):
        assert brdf.f(wi * mirror, wo * mirror) == pytest.approx(brdf.f(wi, wo), rel=1e-12)
    flat = normalize((0.5, 0.0, 0.8))
    assert brdf.f(flat, flat * (1, -1, 1)) == pytest.approx(brdf.f(flat, flat), rel=1e-12)

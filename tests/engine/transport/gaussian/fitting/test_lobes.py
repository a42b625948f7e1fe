"""Spherical Gaussians: near their means, their products, and lobes as sums of them."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from engine.light.cube_map import cube_directions, cube_solid_angles, direction_on_face
from engine.light.gaussian_prefilter import gaussian_integral
from engine.transport.gaussian.fitting.lobes import NARROWEST, Lobes, gaussian


def test_G3_near_its_mean_a_narrow_gaussian_is_right() -> None:
    mean = np.array([0.6, 0.48, 0.64])
    across = np.cross(mean, (0.0, 0.0, 1.0))
    across /= np.linalg.norm(across)
    for sigma in (1e-3, NARROWEST, 0.1):
        angle = sigma * np.linspace(0.0, 3.0, 31)
        at = np.cos(angle)[:, None] * mean + np.sin(angle)[:, None] * across
        exact = np.array([float(mpmath.exp((mpmath.cos(a) - 1) / mpmath.mpf(sigma) ** 2)) for a in angle])
        assert np.abs(gaussian(at, mean, sigma) - exact).max() <= 1e-9
        # with float32 vectors: by the distance 1e-3, where w·mu − 1 alone would be off by more than a tenth
        rounded, centre = at.astype(np.float32), mean.astype(np.float32)
        assert np.abs(gaussian(rounded, centre, sigma) - exact).max() <= 1e-3


def test_G4_the_floor_is_half_a_texel_and_keeps_the_energy() -> None:
    assert pytest.approx(0.5 * 3.07e-3, rel=2e-3) == NARROWEST
    edge = 2048  # texels half as wide as the Gaussian
    solid = cube_solid_angles(edge)
    corner = slice(edge // 2 - 24, edge // 2 + 24)
    centres = (np.arange(edge)[corner] + 0.5) / edge
    some = direction_on_face(np.zeros(1, np.int64), centres[None], centres[:, None])
    for mean in (some[24, 24], some[24, 24] + some[24, 25], some[20, 30]):
        unit = mean / np.linalg.norm(mean)
        summed = (gaussian(some, unit, NARROWEST) * solid[corner, corner]).sum()
        assert summed == pytest.approx(float(gaussian_integral(NARROWEST)), rel=1e-3)


def test_lobes_know_their_energy_and_values() -> None:
    random = np.random.default_rng(1)
    mean = random.normal(size=(2, 92, 2, 3)).astype(np.float32)
    mean /= np.linalg.norm(mean, axis=-1)[..., None]
    lobes = Lobes(random.random((2, 92, 2, 3), np.float32), mean, random.uniform(0.3, 1.0, (2, 92, 2)).astype("f4"))
    directions, solid = cube_directions(48).reshape(-1, 3), np.tile(cube_solid_angles(48).ravel(), 6)
    values = lobes.values(directions)
    np.testing.assert_allclose(np.einsum("vnsc,s->vnc", values, solid), lobes.energy(), rtol=2e-3)
    one = lobes.values(np.broadcast_to(directions[7], (2, 92, 3)))
    np.testing.assert_allclose(one, values[:, :, 7], rtol=1e-12)


def test_lobes_that_do_not_fit_together_are_refused() -> None:
    with pytest.raises(ValueError, match="do not fit together"):
        Lobes(np.zeros((1, 92, 1, 3), "f4"), np.zeros((1, 92, 2, 3), "f4"), np.zeros((1, 92, 1), "f4"))

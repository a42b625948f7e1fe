"""The reflectance of PBR maps against the model of one material."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.brdf.models.microfacet import MetallicRoughness
from engine.core.directions import surface_direction
from engine.surface.metallic_roughness import reflectance

SHARE = st.floats(0.0, 1.0)


@given(SHARE, SHARE, st.floats(0.05, 1.0), st.floats(0.0, 1.5), st.floats(0.0, 1.5), st.floats(0.0, 6.0))
def test_it_is_the_model_at_each_point(
    base: float, metallic: float, roughness: float, theta_i: float, theta_o: float, phi: float
) -> None:
    wi, wo = surface_direction([theta_i], [phi]), surface_direction([theta_o], [0.0])
    colour = (base, 0.5 * base, 0.1)
    model = MetallicRoughness(colour, metallic, roughness)
    found = reflectance(wi, wo, np.array([colour]), np.array([roughness]), np.array([metallic]), np.array([0.04]))
    np.testing.assert_allclose(found, model.f(wi, wo), rtol=1e-6, atol=1e-12)


def test_it_is_black_below_the_surface() -> None:
    wi, wo = np.array([[0.6, 0.0, -0.8]]), np.array([[0.0, 0.0, 1.0]])
    assert (reflectance(wi, wo, (1.0, 1.0, 1.0), 0.5, 0.0, 0.04) == 0.0).all()


def test_f0_is_the_reflectance_of_a_mirror_at_normal_incidence() -> None:
    """At normal incidence D G / 4 is 1 / (4 π α²) for a smooth surface; what remains of f is F."""
    up = np.array([[0.0, 0.0, 1.0]])
    value = reflectance(up, up, (0.0, 0.0, 0.0), 0.1, 0.0, 0.08)
    assert value * 4.0 * np.pi * 0.1**4 == pytest.approx(0.08)

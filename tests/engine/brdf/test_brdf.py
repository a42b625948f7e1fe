"""Laws that every model obeys: the horizon, reciprocity, limits, its text."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.brdf.brdf import MODELS, brdf_from_text, brdf_to_text
from engine.core.directions import normalize, surface_direction
from engine.core.params import parameters
from tests.engine.brdf.all_models import TEXTS, pairs


@pytest.mark.parametrize("text", TEXTS)
def test_BR9_reciprocity(text: str) -> None:
    """Every formula is symmetric operation by operation, so the two values are the same number."""
    brdf = brdf_from_text(text)
    wi, wo = pairs(100_000)
    assert brdf.reciprocal
    assert np.array_equal(brdf.f(wi, wo), brdf.f(wo, wi))


@pytest.mark.parametrize("text", TEXTS)
@pytest.mark.parametrize("cosine", [0.0, -0.0, -1e-8, -1.0])
def test_BR1_nothing_is_reflected_at_and_below_the_horizon(text: str, cosine: float) -> None:
    brdf = brdf_from_text(text)
    low = np.array([np.sqrt(1 - cosine**2), 0.0, cosine])
    up = normalize((0.3, -0.2, 0.9))
    for wi, wo in ((low, up), (up, low), (low, low)):
        assert brdf.f(wi, wo).tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("text", TEXTS)
def test_BR1_BR2_values_just_above_the_horizon_and_at_the_normal_are_finite(text: str) -> None:
    brdf = brdf_from_text(text)
    grazing = np.array([np.sqrt(1 - 1e-16), 0.0, 1e-8])
    normal = np.array([0.0, 0.0, 1.0])
    for wi, wo in ((grazing, normal), (normal, normal), (grazing, grazing * (-1, 1, 1)), (grazing, grazing)):
        value = brdf.f(wi, wo)
        assert np.isfinite(value).all()
        assert (value >= 0).all()


@pytest.mark.parametrize("text", TEXTS)
def test_BR3_opposite_directions_give_zero_and_no_nan(text: str) -> None:
    brdf = brdf_from_text(text)
    wi = surface_direction(np.array([np.pi / 2, 1.0, 0.0, 2.0]), 0.3)
    value = brdf.f(wi, -wi) * np.maximum(wi[:, 2:], 0.0)
    assert np.array_equal(value, np.zeros_like(value))


def test_BR4_exponent_zero_is_diffuse() -> None:
    wi, wo = pairs(100)
    assert brdf_from_text("phong:kd=0.2,ks=0.3,exponent=0").f(wi, wo) == pytest.approx(0.5 / np.pi, rel=1e-14)


def test_BR6_fresnel_ends_are_exact() -> None:
    ggx: Any = brdf_from_text("ggx:kd=0,alpha=0.5,f0=0.04")
    white: Any = brdf_from_text("ggx:kd=0,alpha=0.5,f0=1")
    normal = np.array([0.0, 0.0, 1.0])
    assert (ggx.f(normal, normal) / white.f(normal, normal)).tolist() == [0.04] * 3
    grazing = np.array([1.0, 0.0, 1e-9])
    ratio = ggx.f(grazing, grazing * (-1, 1, 1)) / white.f(grazing, grazing * (-1, 1, 1))
    assert ratio == pytest.approx([1.0] * 3, abs=1e-8)


@pytest.mark.parametrize("alpha", [1e-4, 1e-3, 0.03, 0.3, 1.0])
def test_BR7_normal_distribution_integrates_to_one(alpha: float) -> None:
    """With wo = wi = h and F = 1: f = D G₂ / (4 cos²); 2π ∫ D cos sin dθ = 1, in t = ln tan θ."""
    brdf = brdf_from_text(f"ggx:kd=0,alpha={alpha},f0=1")
    t = np.linspace(np.log(alpha) - 12, 14, 20_001)
    theta = np.arctan(np.exp(t))
    w = surface_direction(theta)
    w = w[w[:, 2] > 1e-5]
    theta = theta[: len(w)]
    sine2 = w[:, 0] ** 2
    g2 = w[:, 2] / np.sqrt(w[:, 2] ** 2 + alpha**2 * sine2)
    distribution = brdf.f(w, w)[:, 0] * 4 * w[:, 2] ** 2 / g2
    integrand = 2 * np.pi * distribution * w[:, 2] * np.sin(theta) * np.sin(theta) * np.cos(theta)
    assert np.sum(integrand) * (t[1] - t[0]) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("name", MODELS)
@given(data=st.data())
@settings(max_examples=50)
def test_BR9_every_allowed_parameter_gives_finite_values_that_are_as_reciprocal_as_stated(
    name: str, data: st.DataObject
) -> None:
    model = MODELS[name]
    values = {}
    for p in parameters(model):
        number = st.floats(p.low, p.high)
        values[p.name] = data.draw(st.tuples(number, number, number) if p.is_colour else number)
    brdf = model(**values)
    wi, wo = pairs(64, seed=data.draw(st.integers(0, 99)))
    value = brdf.f(wi, wo)
    assert np.isfinite(value).all()
    assert (value >= 0).all()
    assert not brdf.reciprocal or np.array_equal(value, brdf.f(wo, wi))
    assert brdf_from_text(brdf_to_text(brdf)) == brdf


@pytest.mark.parametrize(
    "text",
    [
        "velvet",
        "ggx:alpha=0.1,alpha_x=0.2",
        "phong:shine=2",
        "phong:exponent=-1",
        "phong:exponent=nan",
        "ggx:alpha=0",
        "",
    ],
)
def test_bad_text_is_a_value_error(text: str) -> None:
    with pytest.raises(ValueError, match=r"choose from|outside"):
        brdf_from_text(text)

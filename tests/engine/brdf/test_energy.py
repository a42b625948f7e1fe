"""BR10: what a model reflects of the light, beside what it says of itself; and the library of presets."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.brdf.brdf import MODELS, Brdf, brdf_from_text, brdf_to_text
from engine.brdf.models.presets import PRESETS, find_preset
from engine.core.directions import normalize, surface_direction
from engine.core.params import parameters
from tests.engine.brdf.all_models import TEXTS, pairs

#: Up to 89.9°, denser towards grazing.
VIEWERS = np.radians(89.9) * np.sin(np.linspace(0.0, np.pi / 2, 24))

#: Tolerance of the quadrature.
ERROR = 2e-3


def albedo(brdf: Brdf, theta_o: float, phi_o: float = 0.0, rings: int = 240, spokes: int = 96) -> np.ndarray:
    """∫ f cos(theta_i) dwi, (3,): midpoints of rings about the mirror direction, which crowd together near it."""
    wo = surface_direction(theta_o, phi_o)
    axis = wo * (-1, -1, 1)
    across = normalize(np.cross((0.0, 1.0, 0.0) if abs(axis[1]) < 0.9 else (1.0, 0.0, 0.0), axis))
    edges = np.pi * np.linspace(0.0, 1.0, rings + 1) ** 4
    psi = 0.5 * (edges[1:] + edges[:-1])[:, None]
    phi = 2 * np.pi * (np.arange(spokes) + 0.5) / spokes
    wi = (
        np.cos(psi)[..., None] * axis
        + (np.sin(psi) * np.cos(phi))[..., None] * across
        + (np.sin(psi) * np.sin(phi))[..., None] * np.cross(axis, across)
    )
    weight = (np.cos(edges[:-1]) - np.cos(edges[1:])) * (2 * np.pi / spokes)
    return np.einsum("rsc,rs,r->c", brdf.f(wi, wo), np.maximum(wi[..., 2], 0.0), weight)


def largest_albedo(brdf: Brdf, azimuths: tuple[float, ...] = (0.0,), viewers: np.ndarray = VIEWERS) -> np.ndarray:
    return np.max([albedo(brdf, theta, phi) for theta in viewers for phi in azimuths], axis=0)


def test_the_quadrature_knows_what_is_known_in_closed_form() -> None:
    for theta in (0.0, 0.7, 1.5):
        assert albedo(brdf_from_text("lambert:albedo=0.5"), theta) == pytest.approx([0.5] * 3, abs=ERROR)
    for model in ("phong", "blinn-phong"):
        for exponent in (1, 20, 20_000):
            sharp = brdf_from_text(f"{model}:kd=0,ks=0.5,exponent={exponent}")
            assert albedo(sharp, 0.0) == pytest.approx([0.5] * 3, abs=ERROR)


def test_oren_nayar_reflects_what_its_integral_says() -> None:
    """albedo (A + B g), g = (2/π) (sin θ (θ − sin θ cos θ)/2 + tan θ (1 − sin³ θ)/3)."""
    brdf = brdf_from_text("oren-nayar:albedo=0.8,sigma_deg=25")
    facing, retro = brdf.coefficients  # type: ignore[attr-defined]
    for theta in (0.1, 0.8, 1.4):
        s, c = np.sin(theta), np.cos(theta)
        g = 2 / np.pi * (s * (theta - s * c) / 2 + s / c * (1 - s**3) / 3)
        assert albedo(brdf, theta)[0] == pytest.approx(0.8 * (facing + retro * g), abs=ERROR)


#: Lobes that are narrower than the quadrature in azimuth.
TOO_NARROW = {"ward:alpha_x=0.0001,alpha_y=0.001"}


@pytest.mark.parametrize("text", [text for text in TEXTS if text not in TOO_NARROW])
def test_BR10_models_that_say_so_conserve_energy(text: str) -> None:
    brdf = brdf_from_text(text)
    if brdf.energy_conserving:
        assert largest_albedo(brdf, (0.0,) if brdf.isotropic else (0.0, 0.6, np.pi / 2)).max() <= 1.0 + ERROR


@pytest.mark.parametrize(
    "text",
    [
        "oren-nayar:albedo=1,sigma_deg=12",
        "phong:kd=0.7,ks=0.5",
        "blinn-phong:kd=0.7,ks=0.5",
        "lafortune:kd=0.7,ks=0.5,cxy=-0.5,cz=0.5",
        "lafortune:preset=brushed-metal",
        "ward:kd=0.7,ks=0.5",
        "cook-torrance:kd=0.9,ks=1,f0=0.9",
        "ggx:kd=0.9,alpha=0.1,f0=0.9",
        "ggx:kd=0.9,alpha_x=0.1,alpha_y=0.3,f0=0.9",
        "metallic-roughness:base_color=0.9,roughness=0.2",
    ],
)
def test_BR10_models_that_do_not_are_flagged(text: str) -> None:
    brdf = brdf_from_text(text)
    assert not brdf.energy_conserving
    assert largest_albedo(brdf).max() > 1.0 + ERROR


@pytest.mark.parametrize("name", MODELS)
@given(data=st.data())
@settings(max_examples=8)
def test_BR10_whatever_the_parameters_a_model_that_says_so_conserves_energy(name: str, data: st.DataObject) -> None:
    values = {}
    for p in parameters(MODELS[name]):
        number = st.floats(*(min(max(limit, p.low), p.high) for limit in p.slider))
        values[p.name] = data.draw(st.tuples(number, number, number) if p.is_colour else number)
    brdf = MODELS[name](**values)
    if brdf.energy_conserving:
        viewers = np.array([0.0, data.draw(st.floats(0.0, np.radians(89.9)))])
        assert largest_albedo(brdf, (data.draw(st.floats(0.0, np.pi)),), viewers).max() <= 1.0 + 2 * ERROR


@pytest.mark.parametrize("every", [7, pytest.param(1, marks=pytest.mark.long)])
def test_BR9_BR10_every_preset_is_reciprocal_and_says_whether_it_conserves_energy(every: int) -> None:
    wi, wo = pairs(5000)
    gains = []
    for preset in PRESETS:
        assert np.array_equal(preset.brdf.f(wi, wo), preset.brdf.f(wo, wi)), preset.name
        largest = largest_albedo(preset.brdf, viewers=VIEWERS[every - 1 :: every]).max()
        assert largest <= 1.0 + ERROR or not preset.brdf.energy_conserving, preset.name
        if largest > 1.0:
            gains.append(preset.name)
    assert gains == [preset.name for preset in PRESETS if not preset.brdf.energy_conserving] == ["brushed-metal"]


def test_presets_are_the_published_ones() -> None:
    assert len(PRESETS) == 106
    assert len({preset.name for preset in PRESETS}) == 106
    assert all(brdf_from_text(preset.text) == preset.brdf for preset in PRESETS)
    assert all(brdf_to_text(preset.brdf) == preset.text for preset in PRESETS)
    assert all("Lafortune" in preset.source or "Ngan" in preset.source for preset in PRESETS)
    assert find_preset("lafortune", "blue-paint").brdf == MODELS["lafortune-three-lobes"]()


def test_a_preset_is_evaluated_as_its_table_prescribes() -> None:
    """By hand from the rows of blue paint (green) and alum bronze (red), towards one pair of directions."""
    wi, wo = normalize((0.3, 0.1, 0.9)), normalize((-0.5, 0.2, 0.7))
    along, up = wi[0] * wo[0] + wi[1] * wo[1], wi[2] * wo[2]
    rows = ((0.857255, 0.77429, 18.597755), (-0.406681, 0.017625, 2.581499), (-1.029426, 0.69653, 63.767912))
    green = 0.39667 / np.pi + sum(max(0.0, cxy * along + cz * up) ** n for cxy, cz, n in rows)
    assert brdf_from_text("lafortune:preset=blue-paint").f(wi, wo)[1] == pytest.approx(green, rel=1e-12)
    lobe = 0.322 * 632 / (2 * np.pi * 0.579**630) * (-0.579 * along + 0.574 * up) ** 630
    red = 0.0923 / np.pi + lobe
    assert brdf_from_text("lafortune:preset=alum-bronze").f(wi, wo)[0] == pytest.approx(red, rel=1e-12)


@pytest.mark.parametrize(
    "text", ["lafortune:preset=blu", "phong:preset=shiny", "lafortune:preset=blue-paint,kd=0.1", "lafortune:preset="]
)
def test_unknown_presets_are_named_with_those_that_exist(text: str) -> None:
    with pytest.raises(ValueError, match=r"choose from|only ones|takes no other"):
        brdf_from_text(text)

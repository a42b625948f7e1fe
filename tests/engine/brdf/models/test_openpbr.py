"""OpenPBR by the furnace, by cases that have a closed form, and with OpenGL; MaterialX draws it in tests of proofs."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.brdf.models.openpbr import Base, airy, coat_widths, fresnel, fresnel_mean, hoffman, hoffman_mean, reflect
from engine.core.directions import normalize, surface_direction
from engine.core.steps import drain
from engine.geometry.camera import frame
from engine.geometry.shapes import shape
from engine.light.lamps import Lamp
from engine.render.direct import radiance
from engine.scene.scene import Scene

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(400)
_PLACES = 0.5 + 0.5 * _NODES
COSINES, SHARES = _PLACES**3, 3.0 * _WEIGHTS * _PLACES**5


def albedo(text: str, tilt: float) -> float:
    """Of white light from all sides, the share that leaves towards a viewer at `tilt` radians."""
    azimuth = 2.0 * np.pi * (np.arange(720) + 0.5) / 720
    wi = surface_direction(np.arccos(COSINES)[:, None], azimuth[None])
    return float(np.pi * SHARES @ brdf_from_text(text).f(wi, surface_direction(tilt, 0.0))[..., 0].mean(axis=1))


@pytest.mark.parametrize(
    "text",
    [
        "openpbr:base_color=1",
        "openpbr:base_color=1,specular_roughness=0.6",
        "openpbr:base_color=1,specular_roughness=1,base_diffuse_roughness=1",
        "openpbr:base_color=1,specular_weight=0",
        "openpbr:base_color=1,specular_ior=2.5",
        "openpbr:base_color=1,base_metalness=1",
        "openpbr:base_color=1,base_metalness=1,specular_roughness=1",
        "openpbr:base_color=1,coat_weight=1,coat_roughness=0.3",
        "openpbr:base_color=1,fuzz_weight=1,fuzz_roughness=0.4",
        "openpbr:base_color=1,thin_film_weight=1,thin_film_ior=1.4",
        "openpbr:base_color=1,thin_film_weight=1,thin_film_ior=2",
    ],
)
def test_white_layers_vanish_in_even_light(text: str) -> None:
    """However many layers lie over a white base, none of the light is lost; albedos of GGX are fits within 2 %."""
    for tilt in (0.0, 0.7, 1.1, 1.3):
        assert albedo(text, tilt) == pytest.approx(1.0, abs=0.02)


def test_light_is_as_bright_as_it_comes_without_a_highlight() -> None:
    """Weight 0 leaves a diffuse surface of the base colour."""
    wi, wo = surface_direction([0.3, 1.2], [0.0, 2.0]), surface_direction([0.9, 0.1], [1.0, 0.0])
    found = brdf_from_text("openpbr:base_color=0.5/0.25/1,specular_weight=0").f(wi, wo)
    np.testing.assert_allclose(found, np.tile(np.array([0.5, 0.25, 1.0]) / np.pi, (2, 1)), rtol=1e-9)


def test_two_widths_that_are_alike_are_one() -> None:
    wi, wo = surface_direction([0.3, 1.2, 0.8], [0.0, 2.0, 4.0]), surface_direction([0.9, 0.1, 0.8], [1.0, 0.0, 1.0])
    rest = "base_metalness=0.5,coat_weight=0.4,coat_roughness=0.3"
    one, two = brdf_from_text(f"openpbr:{rest}"), brdf_from_text(f"openpbr:{rest},specular_roughness_anisotropy=0")
    np.testing.assert_allclose(one.f(wi, wo), two.f(wi, wo), rtol=1e-12)


def test_anisotropic_highlights_run_along_the_tangent() -> None:
    """αx > αy: light that is tilted along x still meets the highlight where light tilted along y does not."""
    brdf = brdf_from_text("openpbr:base_metalness=1,specular_roughness=0.3,specular_roughness_anisotropy=0.8")
    up = surface_direction(0.0, 0.0)
    along, across = brdf.f(surface_direction([0.4, 0.4], [0.0, np.pi / 2]), up)[:, 0]
    assert along > 4.0 * across
    turned = dataclasses.replace(brdf, rotation_deg=90.0)  # type: ignore[type-var]
    np.testing.assert_allclose(turned.f(surface_direction([0.4, 0.4], [np.pi / 2, np.pi]), up)[:, 0], (along, across))


def test_fresnel_terms_by_hand() -> None:
    assert fresnel(np.ones(1), 1.5)[0] == pytest.approx(0.04)
    assert fresnel(np.zeros(1), 1.5)[0] == pytest.approx(1.0)
    # Brewster's angle: the part in the plane of incidence is gone, the other ((n² − 1)/(n² + 1))²
    assert fresnel(np.array([1.0 / np.sqrt(1.0 + 2.25)]), 1.5)[0] == pytest.approx(0.5 * (1.25 / 3.25) ** 2)
    f0, tint = np.array([[0.9], [0.5], [0.1]]), np.array([[0.5], [1.0], [0.2]])
    schlick = f0 + (1.0 - f0) * (6.0 / 7.0) ** 5
    np.testing.assert_allclose(hoffman(np.full(1, 1.0 / 7.0), f0, tint), schlick * tint, rtol=1e-12)


def test_means_of_fresnel_terms_are_their_integrals() -> None:
    for ior in (1.05, 1.5, 2.0, 4.0):
        assert fresnel_mean(ior) == pytest.approx(float(SHARES @ fresnel(COSINES, ior)), abs=0.005)
    f0, tint = np.array([[0.9], [0.5], [0.2]]), np.array([[0.8], [1.0], [0.6]])
    np.testing.assert_allclose(hoffman_mean(f0, tint)[:, 0], hoffman(COSINES, f0, tint) @ SHARES, rtol=1e-9)


def test_a_film_of_no_thickness_is_the_plain_interface() -> None:
    """Amplitudes of both faces add to that of the base alone: (r + s)/(1 + r s), squared."""
    upper, lower = (1.0 - 1.3) / 2.3, (1.3 - 1.8) / 3.1
    exact = ((upper + lower) / (1.0 + upper * lower)) ** 2
    assert exact == pytest.approx((0.8 / 2.8) ** 2)
    found = airy(np.ones(1), (0.0, 1.3), np.full(1, lower**2), np.full(1, lower**2), np.zeros(1), np.zeros(1))
    np.testing.assert_allclose(found[:, 0], exact, rtol=0.02)


def test_a_thick_film_shows_no_colour() -> None:
    """Beyond some micrometres colours average out, to the sum of intensities over all bounces."""
    upper, lower = (0.4 / 2.4) ** 2, (0.6 / 3.4) ** 2
    found = airy(np.ones(1), (10.0, 1.4), np.full(1, lower), np.full(1, lower), np.zeros(1), np.zeros(1))
    np.testing.assert_allclose(found[:, 0], upper + (1 - upper) ** 2 * lower / (1 - upper * lower), rtol=0.02)


def test_bases_differ_from_pair_to_pair() -> None:
    """One call with arrays gives what one call for each gives."""
    model: Any = brdf_from_text("openpbr:coat_weight=0.5,coat_roughness=0.2,thin_film_weight=0.3,fuzz_weight=0.2")
    random = np.random.default_rng(3)
    wi, wo = (normalize(np.abs(random.normal(size=(6, 3)))).T for _ in range(2))
    colour, metalness, width, ior = (random.random(shape) for shape in ((3, 6), 6, 6, 6))
    width, ior = 0.1 + 0.8 * width, 1.2 + ior
    coat = coat_widths(model)
    whole = reflect(model, wi, wo, Base(colour, metalness, (width, width), ior), coat)
    for at in range(6):
        one = slice(at, at + 1)
        base = Base(colour[:, one], float(metalness[at]), (float(width[at]),) * 2, float(ior[at]))
        np.testing.assert_allclose(whole[:, one], reflect(model, wi[:, one], wo[:, one], base, coat), rtol=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        "openpbr:base_color=0.8/0.3/0.1,specular_roughness=0.4,base_diffuse_roughness=0.7,specular_color=0.5/1/1",
        "openpbr:base_metalness=1,base_color=0.9/0.6/0.3,specular_color=0.9/0.8/1,specular_roughness=0.6",
        "openpbr:coat_weight=0.8,coat_roughness=0.3,coat_color=0.9/0.5/0.4,fuzz_weight=0.4,fuzz_color=0.5/0.6/1",
        "openpbr:thin_film_weight=1,thin_film_thickness=0.4,thin_film_ior=1.8,base_metalness=0.5",
        "openpbr:specular_roughness_anisotropy=0.7,coat_weight=1,coat_roughness=0.4,coat_roughness_anisotropy=0.5",
    ],
)
def test_opengl_shows_what_the_cpu_shows(gl: Any, text: str) -> None:
    from engine.gl.direct import DirectRenderer

    mesh = shape("torus-knot")
    lamps = (Lamp((-0.5, 0.7, 0.5), (0.5, 0.5, 1.0)), Lamp((0.8, 0.1, 0.5), (1.0, 0.5, 0.5)))
    scene = Scene(mesh, frame(mesh.positions, 1.0), brdf_from_text(text), lamps=lamps)
    renderer = DirectRenderer(gl)
    try:
        theirs = renderer.radiance(scene, (48, 48))
    finally:
        renderer.release()
    ours = drain(radiance(scene, (48, 48)))
    assert np.abs(ours - theirs).mean() < 1e-4 * ours.mean()
    assert np.quantile(np.abs(ours - theirs), 0.999) < 2e-3 * ours.max()


@pytest.mark.parametrize("roughness", [0.1, 0.35, 0.8])
def test_colours_of_films_change_without_a_step(roughness: float) -> None:
    """Over 1,500 directions of view, no step between two of them is far above its neighbours."""
    rest = "coat_weight=1,coat_roughness=0.15,coat_ior=1.68,thin_film_weight=1,thin_film_thickness=0.42,thin_film_ior=2"
    tilt = np.linspace(0.0, 1.5, 1500)
    value = brdf_from_text(f"openpbr:specular_roughness={roughness},{rest}").f(
        surface_direction(0.6, 1.0), surface_direction(tilt, np.zeros(1500))
    )
    bend = np.abs(np.diff(value, 2, axis=0)).max(axis=1)
    assert bend.max() < 1e-3 * value.max()

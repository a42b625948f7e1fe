"""Light near a model without shadows: against closed forms, dense sums over points of the light, and the reference."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.brdf.brdf import brdf_from_text
from engine.core.directions import Vectors, normalize, world_from_tangent
from engine.core.steps import drain
from engine.geometry.camera import frame
from engine.geometry.shapes import shape
from engine.light.near_lamps import NearLamp, near_lamp_from_text, near_lights
from engine.render.direct import radiance
from engine.render.near_light import facets_of, lobe_integrals, reflect_near
from engine.render.reference import reference
from engine.scene.scene import Scene

#: Lights above and beside a sphere, whose horizon cuts them at many of its points.
LIGHTS = (
    "shape=rectangle,x=0.5,y=1.2,width=1.2,height=0.5,power=9,colour=1:0.5:0.25",
    "shape=disc,x=0.5,y=1,radius=0.4,power=9",
    "x=0.4,y=1,radius=0.3,power=9",
)


def on_a_sphere(count: int = 60) -> tuple[Vectors, NDArray[np.float64], Vectors]:
    """Positions, frames and directions of a viewer in them, of points on a sphere below the lights."""
    normal = np.random.default_rng(2).normal(size=(count, 3))
    normal[:, 1] = np.abs(normal[:, 1])
    normal = normalize(normal)
    positions, frames = 0.8 * normal - (0.0, 0.4, 0.0), world_from_tangent(normal)
    viewer = np.einsum("nij,ni->nj", frames, normalize((0.5, 1.5, 3.0) - positions))
    seen = viewer[:, 2] > 0.02
    return positions[seen], frames[seen], viewer[seen]


def sum_points(lamp: NearLamp, brdf: str, count: int, place: tuple[Vectors, NDArray[np.float64], Vectors]) -> Vectors:
    model, (positions, frames, viewer) = brdf_from_text(brdf), place
    total = np.zeros((len(viewer), 3))
    for direction, irradiance in near_lights(lamp, positions, count):
        wi = np.einsum("nij,ni->nj", frames, direction)
        lit = np.flatnonzero((wi[:, 2] > 0.0) & irradiance.any(axis=1))
        total[lit] += model.f(wi[lit], viewer[lit]) * wi[lit, 2:] * irradiance[lit]
    return total


def relative(found: Vectors, exact: Vectors) -> float:
    return float(np.linalg.norm(found - exact) / np.linalg.norm(exact))


@pytest.mark.parametrize("light", LIGHTS)
@pytest.mark.parametrize(
    "brdf",
    [
        "metallic-roughness:metallic=1,roughness=0.1,base_color=0.9/0.5/0.2",
        "metallic-roughness:metallic=1,roughness=0.3,multiple_scattering=1",
        "metallic-roughness:metallic=1,roughness=1,multiple_scattering=1",
        "metallic-roughness:roughness=0.4,base_color=0.8/0.6/0.2",
        "ggx:alpha=0.2,kd=0,f0=0.9",
        "ggx:alpha_x=0.1,alpha_y=0.5,kd=0.1,f0=0.5",
        "lambert:albedo=0.9/0.5/0.1",
    ],
)
def test_facets_of_any_width_reflect_what_dense_points_of_the_light_do(brdf: str, light: str) -> None:
    lamp, place = near_lamp_from_text(light), on_a_sphere()
    facets = facets_of(brdf_from_text(brdf), len(place[0]))
    assert facets is not None
    narrow = "roughness=0.1" in brdf
    exact = sum_points(lamp, brdf, 8192 if narrow else 1024, place)
    assert relative(reflect_near((lamp,), *place, facets), exact) < (0.003 if "lambert" in brdf else 0.02)


def test_irradiance_below_and_beside_a_rectangle_is_the_closed_form() -> None:
    """The second point lies on a wall: the horizon cuts the rectangle, which a vertical plane sees in half."""
    lamp = near_lamp_from_text("shape=rectangle,y=0.7,width=2,height=0.6,power=3")
    up = world_from_tangent(np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]))
    facets = facets_of(brdf_from_text("lambert:albedo=1"), 2)
    assert facets is not None
    found = reflect_near((lamp,), np.zeros((2, 3)), up, np.tile((0.0, 0.6, 0.8), (2, 1)), facets)
    x, y, c = 1.0 / 0.7, 0.3 / 0.7, 0.7
    below = x / math.hypot(1, x) * math.atan(y / math.hypot(1, x)) + y / math.hypot(1, y) * math.atan(
        x / math.hypot(1, y)
    )
    beside = math.atan(0.3 / c) - c / math.hypot(c, 1.0) * math.atan(0.3 / math.hypot(c, 1.0))
    expected = np.array([4.0 * below, 2.0 * beside]) / (2.0 * math.pi)
    np.testing.assert_allclose(found[:, 0], lamp.radiance[0] * expected, rtol=1e-9)


def test_a_light_over_all_half_vectors_finds_all_facets() -> None:
    """A sphere that fills the hemisphere: D cos is integrated over all facets that reflect upwards, up to 45°."""
    lamp = near_lamp_from_text("y=1.0001,radius=1,power=1")
    for alpha in (0.01, 0.3, 1.0):
        integrals, middles = lobe_integrals(
            lamp,
            np.zeros((1, 3)),
            world_from_tangent(np.array([[0.0, 1.0, 0.0]])),
            np.array([[0.0, 0.0, 1.0]]),
            np.full((1, 2), alpha),
        )
        assert integrals[0, 0] == pytest.approx(math.pi / 1.0001**2, rel=1e-3)
        assert integrals[1, 0] == pytest.approx(1.0 / (1.0 + alpha**2), abs=1e-2)
        np.testing.assert_allclose(middles[:, 0], [(0.0, 0.0, 1.0)] * 2, atol=1e-6)


def test_lights_behind_below_and_at_touching_distance() -> None:
    """Nothing from the back of a light or from below the horizon; finite values where a light touches the surface."""
    up = world_from_tangent(np.array([[0.0, 1.0, 0.0]]))
    facets = facets_of(brdf_from_text("metallic-roughness:roughness=0.1"), 1)
    assert facets is not None

    def reflected(text: str) -> float:
        found = reflect_near((near_lamp_from_text(text),), np.zeros((1, 3)), up, np.array([[0.6, 0.0, 0.8]]), facets)
        assert np.isfinite(found).all(), text
        assert (found >= 0.0).all(), text
        return float(found.sum())

    assert reflected("shape=rectangle,y=1,facing_theta_deg=0") == 0.0
    assert reflected("shape=disc,y=1,radius=0.5,facing_theta_deg=0") == 0.0
    assert reflected("shape=disc,y=1,facing_theta_deg=0") == 0.0
    assert reflected("shape=rectangle,y=-0.6,z=1,facing_theta_deg=90,facing_phi_deg=180,height=1") == 0.0
    assert reflected("y=-0.4,radius=0.4") == 0.0
    for text in ("power=1", "radius=1", "shape=disc,radius=1", "shape=disc", "shape=rectangle", "y=1e-9,radius=1e-9"):
        reflected(text)
    for height in (1e-12, 1e-6, 1e-3):
        assert reflected(f"shape=rectangle,y={height},width=2,height=1") > 0.0
        assert reflected(f"shape=disc,y={height},radius=2") > 0.0
        assert reflected(f"y={1.0 + height},radius=1") > 0.0


def test_lights_seen_small_are_continuous_with_those_seen_large() -> None:
    place = on_a_sphere()
    facets = facets_of(brdf_from_text("metallic-roughness:roughness=0.2,metallic=1"), len(place[0]))
    assert facets is not None
    images = [
        reflect_near((near_lamp_from_text(f"shape=disc,x=0.5,y=2,radius={radius},power=9"),), *place, facets)
        for radius in (0.0, 0.0013, 0.0021)
    ]
    assert relative(images[0], images[2]) < 1e-3
    assert relative(images[1], images[2]) < 1e-3


@pytest.mark.parametrize("light", LIGHTS[:2])
def test_images_are_those_of_the_reference_on_a_convex_model(light: str) -> None:
    """A glossy metal, whose highlight no few points would show, and a BRDF that is summed over points."""
    mesh = shape("sphere")
    for brdf in ("metallic-roughness:metallic=1,roughness=0.3,multiple_scattering=1", "oren-nayar"):
        lamp = near_lamp_from_text(light)
        what = Scene(
            mesh,
            frame(mesh.positions, 1.0, 35.0, (0.3, 0.5, 1.0)),
            brdf_from_text(brdf),
            irradiance=0.0,
            near_lamps=(dataclasses.replace(lamp, position=(0.5, 1.4, 0.0)),),
        )
        traced = drain(reference(what, (24, 24), samples=256))
        found = drain(radiance(what, (24, 24), samples=4))
        inside = (found[..., 3] >= 1.0) & (traced.image[..., 3] >= 1.0)
        assert traced.variance is not None
        power = float(np.square(traced.image[inside][:, :3], dtype=np.float64).sum())
        noise = math.sqrt(float(traced.variance[inside].sum()) / power)
        error = relative(found[inside][:, :3].astype(float), traced.image[inside][:, :3].astype(float))
        assert error < 0.02 + noise, brdf
        assert noise < 0.04

"""Light near a model, sampled: against closed forms of irradiance, by both estimators and from touching distances."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.geometry.camera import Camera
from engine.geometry.mesh import Mesh
from engine.light.near_lamps import NearLamp, near_lamp_from_text, near_lights
from engine.render.near_light_sampling import draw_towards, light_along
from engine.render.reference import reference
from engine.scene.scene import Scene

POINTS = 20_000


def irradiance(lamp: NearLamp, point: tuple[float, float, float], seed: int = 0) -> tuple[float, float]:
    """Of a plane with normal +Y at `point`, by directions drawn from the lamp; with its standard error."""
    u = np.random.default_rng(seed).random((POINTS, 2))
    points = np.tile(np.asarray(point), (POINTS, 1))
    direction, distance, light, density = draw_towards(lamp, u, points)
    assert np.isfinite(direction).all()
    assert (distance >= 0.0).all()
    value = light[:, 0] * np.maximum(direction[:, 1], 0.0)
    if density is not None:
        value = np.where(density > 0.0, value / np.where(density > 0.0, density, 1.0), 0.0)
    return float(value.mean()), float(value.std() / math.sqrt(POINTS))


def of_corner(a: float, b: float, c: float) -> float:
    """Form factor of a rectangle a × b at the height c, from the point below one of its corners to it."""
    x, y = a / c, b / c
    first = x / math.hypot(1.0, x) * math.atan(y / math.hypot(1.0, x))
    return (first + y / math.hypot(1.0, y) * math.atan(x / math.hypot(1.0, y))) / (2.0 * math.pi)


def test_rectangle_over_a_plane() -> None:
    """The point below the rectangle's centre sees four quarters of it; one beside it, differences of corners."""
    lamp = near_lamp_from_text("shape=rectangle,y=0.7,width=2,height=0.6,power=3")
    radiance = lamp.radiance[0]
    assert radiance == pytest.approx(3.0 / (math.pi * 1.2))
    found, deviation = irradiance(lamp, (0.0, 0.0, 0.0))
    assert found == pytest.approx(math.pi * radiance * 4.0 * of_corner(1.0, 0.3, 0.7), abs=4.5 * deviation)
    found, deviation = irradiance(lamp, (1.5, 0.0, 0.0))
    exact = 2.0 * (of_corner(2.5, 0.3, 0.7) - of_corner(0.5, 0.3, 0.7))
    assert found == pytest.approx(math.pi * radiance * exact, abs=4.5 * deviation)


@pytest.mark.parametrize("height", [0.5, 1e-4, 50.0])
def test_disc_and_sphere_over_a_plane(height: float) -> None:
    disc = near_lamp_from_text(f"shape=disc,y={height},radius=0.4,power=2")
    found, deviation = irradiance(disc, (0.0, 0.0, 0.0))
    exact = math.pi * disc.radiance[0] * 0.4**2 / (0.4**2 + height**2)
    assert found == pytest.approx(exact, abs=4.5 * deviation + 1e-9 * exact)
    sphere = near_lamp_from_text(f"y={height + 0.4},radius=0.4,power=2")
    found, deviation = irradiance(sphere, (0.0, 0.0, 0.0))
    exact = 2.0 / (4.0 * math.pi * (height + 0.4) ** 2)
    assert found == pytest.approx(exact, abs=4.5 * deviation + 1e-9 * exact)


@pytest.mark.parametrize(
    "text",
    [
        "shape=rectangle,x=0.4,y=1,z=-0.3,facing_theta_deg=130,facing_phi_deg=50,rotation_deg=20,width=1.5,height=0.7,power=5",
        "shape=disc,x=0.4,y=0.8,facing_theta_deg=150,facing_phi_deg=-80,radius=0.3,power=5",
        "shape=disc,x=0.4,y=0.8,facing_theta_deg=150,facing_phi_deg=-80,radius=1.8,power=5",
        "x=0.3,y=0.9,z=0.2,radius=0.6,power=5",
    ],
)
def test_directions_from_anywhere_find_what_those_from_the_lamp_find(text: str) -> None:
    """The density integrates to 1, but for the corners of the square about a disc; both estimators and points agree."""
    lamp = near_lamp_from_text(text)
    random = np.random.default_rng(1)
    height, turn = random.uniform(-1.0, 1.0, 200_000), random.uniform(0.0, 2.0 * np.pi, 200_000)
    ring = np.sqrt(1.0 - height**2)
    direction = np.column_stack([ring * np.sin(turn), height, ring * np.cos(turn)])
    light, density, distance = light_along(lamp, np.zeros_like(direction), direction)
    assert (np.isfinite(distance) == (density > 0.0)).all()
    whole = 4.0 * np.pi * density
    is_beside = lamp.shape == "disc" and lamp.radius > 1.0
    assert whole.mean() == pytest.approx(0.937 if is_beside else 1.0, abs=0.03)
    found, deviation = irradiance(lamp, (0.0, 0.0, 0.0))
    value = 4.0 * np.pi * light[:, 0] * np.maximum(direction[:, 1], 0.0)
    error = math.hypot(deviation, value.std() / math.sqrt(len(value)))
    assert value.mean() == pytest.approx(found, abs=4.5 * error)
    by_points = sum(
        light[0, 0] * max(towards[0, 1], 0.0) for towards, light in near_lights(lamp, np.zeros((1, 3)), 4096)
    )
    assert by_points == pytest.approx(found, abs=4.5 * deviation + 1e-3 * found)


def test_nothing_comes_from_the_back_or_from_the_centre_of_a_point() -> None:
    back = near_lamp_from_text("shape=rectangle,y=1,facing_theta_deg=0,power=5")
    assert irradiance(back, (0.0, 0.0, 0.0)) == (0.0, 0.0)
    for text in ("power=5", "shape=disc,power=5", "shape=disc,radius=1,power=5", "shape=rectangle,power=5"):
        assert irradiance(near_lamp_from_text(text), (0.0, 0.0, 0.0))[0] == 0.0


@pytest.mark.parametrize("brdf", ["lambert:albedo=0.5", "metallic-roughness:metallic=1,roughness=0.5"])
def test_what_stands_behind_a_light_casts_no_shadow_and_what_stands_before_it_does(brdf: str) -> None:
    """Two squares, one above the other: a light between them shines on the lower, and one above both does not."""
    low = np.array([(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)])
    positions = np.concatenate([low, low + np.array([0.0, 0.0, 3.0])])
    faces = np.array([(0, 1, 2), (0, 2, 3), (4, 5, 6), (4, 6, 7)], np.int32)
    normals = np.tile(np.array([0.0, 0.0, 1.0], np.float32), (8, 1))
    mesh = Mesh(positions, normals, np.zeros((8, 2), np.float32), faces, "two squares")
    camera = Camera((0.0, 0.0, 0.9), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 1.0)

    def seen(height: float, depth: int = 1) -> float:
        lamp = near_lamp_from_text(f"shape=disc,z={height},radius=0.3,facing_theta_deg=90,facing_phi_deg=180,power=2")
        scene = Scene(mesh, camera, brdf_from_text(brdf), irradiance=0.0, near_lamps=(lamp,))
        return float(drain(reference(scene, (4, 4), samples=256, max_depth=depth)).image[..., 0].mean())

    lamp = NearLamp((0.0, 0.0, 1.0), (2.0,) * 3, 0.3, "disc")
    irradiance = math.pi * lamp.radiance[0] * 0.3**2 / (0.3**2 + 1.0)
    if "lambert" in brdf:
        assert seen(1.0) == pytest.approx(0.5 / math.pi * irradiance, rel=0.01)
    assert seen(1.0) > 0.0
    assert seen(1.0, depth=2) >= 0.97 * seen(1.0)
    assert seen(4.0) == 0.0

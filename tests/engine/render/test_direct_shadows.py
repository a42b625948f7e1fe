"""Shadows of sharp lights in sums over lights: against geometry that is solved by hand, and the reference."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.brdf.brdf import brdf_from_text
from engine.core.directions import normalize
from engine.core.steps import drain
from engine.geometry.camera import Camera, frame
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import shape
from engine.light.environment import EnvironmentMap, solid_angles, texel_directions
from engine.light.lamps import Lamp
from engine.light.near_lamps import NearLamp, near_lamp_from_text
from engine.render.direct import radiance
from engine.render.reference import reference
from engine.scene.mode import DIRECT
from engine.scene.scene import Scene

Floats = NDArray[np.float64]

#: Centre and radius of the ball, and how far from its edge triangles may change what is in its shadow.
CENTRE, RADIUS, DOUBT = np.array([0.0, 3.0, 0.0]), 1.0, 0.01

#: Side of the images of the ball.
SIDE = 96


def ball_above_a_plane() -> Mesh:
    """A ball of many triangles, above a square of two at y = 0."""
    rows = 96
    theta, phi = np.meshgrid(np.linspace(0.0, np.pi, rows), np.linspace(0.0, 2.0 * np.pi, 2 * rows), indexing="ij")
    normal = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], -1).reshape(-1, 3)
    index = np.arange(len(normal)).reshape(rows, 2 * rows)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    square = np.array([[-9.0, 0.0, 9.0], [9.0, 0.0, 9.0], [9.0, 0.0, -9.0], [-9.0, 0.0, -9.0]])
    corners = len(normal) + np.array([[0, 1, 2], [0, 2, 3]])
    positions = np.concatenate([CENTRE + RADIUS * normal, square])
    normals = np.concatenate([normal, np.tile([0.0, 1.0, 0.0], (4, 1))]).astype(np.float32)
    uv = np.zeros((len(positions), 2), np.float32)
    return Mesh(positions, normals, uv, np.concatenate([faces, corners]).astype(np.int32), "ball")


def from_above(**options: Any) -> Scene:
    """The ball seen from above, diffuse with an albedo of 1, with shadows."""
    camera = Camera((-2.0, 20.0, 0.1), (-2.0, 0.0, 0.0), (0.0, 0.0, -1.0), 30.0)
    return Scene(ball_above_a_plane(), camera, brdf_from_text("lambert:albedo=1"), shadows=True, **options)


def places_on_the_plane(scene: Scene) -> tuple[NDArray[np.bool_], Floats]:
    """Pixels (SIDE²,) whose ray meets the plane and not the ball, and where (SIDE², 3)."""
    row, column = np.mgrid[0:SIDE, 0:SIDE].reshape(2, -1) + 0.5
    ray, eye = scene.camera.rays(column, row, SIDE, SIDE), np.asarray(scene.camera.eye)
    place = eye - ray * (eye[1] / ray[:, 1:2])
    return distance_to_the_line(np.broadcast_to(eye, ray.shape), ray) > RADIUS + DOUBT, place


def distance_to_the_line(start: Floats, direction: Floats) -> Floats:
    """Distances (N,) of the centre of the ball from lines through `start` along unit `direction`, both (N, 3)."""
    offset = CENTRE - start
    return np.asarray(np.linalg.norm(offset - (offset * direction).sum(1, keepdims=True) * direction, axis=1))


def draw(scene: Scene, size: tuple[int, int] = (SIDE, SIDE), samples: int = 1) -> Floats:
    return np.asarray(drain(radiance(scene, size, samples=samples))[..., :3], np.float64).reshape(-1, 3)


def check(found: Floats, irradiance: Floats, distance: Floats, seen: NDArray[np.bool_]) -> None:
    """The plane is dark where lines to the light pass the centre of the ball within its radius, else lit."""
    sure = seen & (np.abs(distance - RADIUS) > DOUBT)
    dark, lit = sure & (distance < RADIUS), sure & (distance > RADIUS)
    assert dark.sum() > 200
    assert lit.sum() > 1000
    assert (found[dark] == 0.0).all()
    np.testing.assert_allclose(found[lit], (irradiance / np.pi)[lit], rtol=1e-5)


def test_the_shadow_of_a_ball_under_one_direction_is_its_cylinder() -> None:
    light = normalize((1.0, 1.2, 0.3))
    scene = from_above(light=tuple(light), irradiance=2.0)
    seen, place = places_on_the_plane(scene)
    distance = distance_to_the_line(place, np.broadcast_to(light, place.shape))
    check(draw(scene), np.full((len(place), 3), 2.0 * light[1]), distance, seen)
    assert (draw(dataclasses.replace(scene, shadows=False))[seen] > 0.0).all()


def test_the_shadow_of_a_ball_under_a_near_point_is_its_cone() -> None:
    lamp = NearLamp((2.5, 6.0, 0.5), (1000.0, 500.0, 100.0))
    scene = from_above(irradiance=0.0, near_lamps=(lamp,))
    seen, place = places_on_the_plane(scene)
    offset = np.asarray(lamp.position) - place
    length = np.linalg.norm(offset, axis=1, keepdims=True)
    irradiance = np.asarray(lamp.intensity) * offset[:, 1:2] / length**3
    check(draw(scene), irradiance, distance_to_the_line(place, offset / length), seen)


def test_what_is_beyond_a_near_light_casts_no_shadow() -> None:
    """A point between the ball and the plane lights the plane as if there were no ball."""
    lamp = NearLamp((-2.0, 1.0, 0.0), (100.0, 100.0, 100.0))
    scene = from_above(irradiance=0.0, near_lamps=(lamp,))
    seen, _ = places_on_the_plane(scene)
    np.testing.assert_array_equal(draw(scene)[seen], draw(dataclasses.replace(scene, shadows=False))[seen])


def test_a_convex_model_casts_no_shadow_on_itself() -> None:
    mesh = shape("sphere")
    scene = Scene(mesh, frame(mesh.positions), brdf_from_text("ggx:kd=0.5,alpha=0.2,f0=0.3"), light=(1.0, 0.2, 0.3))
    np.testing.assert_array_equal(draw(dataclasses.replace(scene, shadows=True)), draw(scene))


def difference(found: Floats, exact: NDArray[Any]) -> float:
    return float(np.linalg.norm(found - exact) / np.linalg.norm(exact))


@pytest.mark.parametrize("brdf", ["ward:ks=0.4,alpha_x=0.05,alpha_y=0.3", "ggx-anisotropic:alpha_x=0.4,alpha_y=0.05"])
def test_lamps_on_a_knot_are_those_of_the_reference(brdf: str) -> None:
    """Two directions and a ground, which have no noise but that of where a pixel is looked at."""
    mesh = shape("torus-knot")
    lamps = (Lamp((1.0, 1.0, 0.4), (3.0, 2.0, 1.0)), Lamp((-0.5, 1.0, 1.0), (0.5, 1.0, 2.0)))
    scene = Scene(mesh, frame(mesh.positions), brdf_from_text(brdf), irradiance=0.0, lamps=lamps, ground=Ground())
    exact = drain(reference(scene, (48, 48), samples=256)).image[..., :3].reshape(-1, 3)
    error = difference(draw(dataclasses.replace(scene, shadows=True), (48, 48), 4), exact)
    assert error < 0.03
    assert difference(draw(scene, (48, 48), 4), exact) > 10.0 * error


@pytest.mark.parametrize(
    ("light", "brdf"),
    [
        pytest.param("x=2,y=3,z=2,radius=0.3,power=60", "phong:ks=0.3,exponent=20", marks=pytest.mark.long),
        (
            "shape=rectangle,x=2,y=3,z=1,facing_theta_deg=145,facing_phi_deg=63,power=60",
            "ggx:kd=0.4,alpha=0.3,f0=0.2",
        ),
    ],
)
def test_near_lights_cast_soft_shadows_as_in_the_reference(light: str, brdf: str) -> None:
    mesh = shape("torus-knot")
    scene = Scene(mesh, frame(mesh.positions), brdf_from_text(brdf), irradiance=0.0, ground=Ground())
    scene = dataclasses.replace(scene, near_lamps=(near_lamp_from_text(light),))
    exact = drain(reference(scene, (48, 48), samples=256)).image[..., :3].reshape(-1, 3)
    error = difference(draw(dataclasses.replace(scene, shadows=True), (48, 48), 3), exact)
    assert error < 0.04
    assert difference(draw(scene, (48, 48), 3), exact) > 5.0 * error


def test_suns_of_an_environment_are_lights_that_cast_shadows() -> None:
    """A sky of 0.1 with a sun of one texel: the sun alone is hidden, and the sky arrives everywhere."""
    radiance_of_map = np.full((64, 128, 3), 0.1, np.float32)
    radiance_of_map[20, 40] = 5e3
    sky = EnvironmentMap(radiance_of_map)
    scene = DIRECT.adapt(dataclasses.replace(from_above(environment=sky, directions=256), shadows=False))
    flux = (radiance_of_map * solid_angles(64, 128)[..., None]).sum(axis=(0, 1))
    np.testing.assert_allclose(scene.lights.irradiance.sum(axis=0), flux, rtol=1e-3)
    sun = texel_directions(64, 128)[20, 40]
    cosines = scene.lights.direction[list(scene.casting)] @ sun
    assert len(cosines)
    assert cosines.min() > np.cos(np.radians(3.0))
    seen, place = places_on_the_plane(scene)
    distance = distance_to_the_line(place, np.broadcast_to(sun, place.shape))
    found = draw(scene)
    dark = seen & (distance < 0.85 * RADIUS)
    assert dark.any()
    np.testing.assert_allclose(found[dark], 0.1, rtol=0.02)
    assert (found[seen & (distance > 1.15 * RADIUS)] > 1.0).all()


def test_without_suns_an_environment_casts_no_shadow() -> None:
    room = EnvironmentMap(np.random.default_rng(1).uniform(0.5, 1.0, (16, 32, 3)).astype(np.float32))
    scene = from_above(environment=room)
    assert len(scene.casting) == 0
    np.testing.assert_array_equal(draw(scene), draw(dataclasses.replace(scene, shadows=False)))

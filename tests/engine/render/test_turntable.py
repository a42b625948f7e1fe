"""The frames of a turn: the model and its light as somebody sees them who does not turn."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, sin

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.geometry.camera import Camera
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import shape
from engine.light.environment import EnvironmentMap
from engine.light.lamps import Lamp
from engine.light.near_lamps import near_lamp_from_text
from engine.render.background import blur, in_front_of, observe
from engine.render.direct import radiance
from engine.render.turntable import Turns, about_y, frame_all_round, frames, turn
from engine.scene.scene import Scene

SIZE = (48, 36)
LIGHT = (0.6, 0.5, 0.62)


def scene() -> Scene:
    knot = shape("torus-knot")
    moved = replace(knot, positions=knot.positions + np.array([3.0, 1.0, -2.0]))
    lamp = Lamp((0.2, 0.3, -0.9), (0.2, 0.1, 0.4))
    camera = frame_all_round(moved.positions, SIZE[0] / SIZE[1])
    near = near_lamp_from_text("shape=rectangle,x=4,y=3,z=-1,facing_theta_deg=140,facing_phi_deg=-120,width=2,power=9")
    brdf = brdf_from_text("phong:exponent=12")
    return Scene(moved, camera, brdf, light=LIGHT, lamps=(lamp,), near_lamps=(near,), directions=8)


def image(of: Scene) -> np.ndarray:
    return np.asarray(drain(radiance(of, SIZE, samples=1)), np.float64)


def rotate(mesh: Mesh, angle: float, centre: np.ndarray) -> Mesh:
    """The mesh itself, turned about the vertical through `centre`."""
    matrix = np.array([[cos(angle), 0.0, sin(angle)], [0.0, 1.0, 0.0], [-sin(angle), 0.0, cos(angle)]])
    positions = (mesh.positions - centre) @ matrix.T + centre
    return replace(mesh, positions=positions, normals=(mesh.normals @ matrix.T).astype(np.float32))


def test_a_model_that_turns_is_the_image_of_the_turned_mesh_under_the_light_that_rests() -> None:
    start, angle = scene(), 0.7
    centre = (start.mesh.positions.min(axis=0) + start.mesh.positions.max(axis=0)) / 2.0
    expected = image(replace(start, mesh=rotate(start.mesh, angle, centre)))
    found = image(turn(start, angle, "model"))
    inside = (found[..., 3] == 1.0) & (expected[..., 3] == 1.0)
    assert (found[..., 3] != expected[..., 3]).mean() < 0.01
    assert np.median(np.abs(found - expected)[inside]) < 1e-6
    assert np.abs(found - image(start)).max() > 0.1


def test_light_that_turns_leaves_the_camera_and_turns_like_an_environment() -> None:
    start = scene()
    after = turn(start, pi / 2, "light")
    assert after.camera == start.camera
    assert np.allclose(after.light, start.lights.rotate(pi / 2).direction[0])
    assert np.allclose(after.lamps[0].direction, about_y(start.lamps[0].direction, pi / 2))
    assert after.environment_rotation == pytest.approx(pi / 2)
    assert about_y((0.0, 0.0, 1.0), pi / 2) == pytest.approx((1.0, 0.0, 0.0))


@pytest.mark.parametrize("turns", ["model", "light", "both"])
def test_a_turn_ends_where_it_begins(turns: Turns) -> None:
    start = scene()
    found = list(frames(start, 4, turns))
    assert found[0].camera.eye == pytest.approx(start.camera.eye)
    again = turn(found[3], pi / 2, turns)
    assert (*again.camera.eye, *again.light) == pytest.approx((*start.camera.eye, *start.light))
    assert (found[2].camera != start.camera, found[2].light != start.light) == (turns != "light", turns != "both")


def test_the_camera_of_a_turn_sees_all_of_the_model_in_every_frame() -> None:
    for each in frames(scene(), 16, "model"):
        clip = each.camera.clip_from_model((0.0, 0.0, 0.0), 20.0, SIZE[0] / SIZE[1])
        seen_at = np.concatenate([each.mesh.positions, np.ones((len(each.mesh.positions), 1))], axis=1) @ clip.T
        assert np.abs(seen_at[:, :2] / seen_at[:, 3:]).max() <= 1.001


def test_what_is_behind_the_model_is_the_environment_along_the_ray() -> None:
    rows = np.linspace(0.2, 3.0, 16)[:, None, None] * np.ones((16, 32, 3))
    rows[:, :8] *= (4.0, 1.0, 0.5)
    sky = EnvironmentMap(rows.astype(np.float32))
    camera = Camera((0.0, 0.0, 3.0))
    empty = np.zeros((6, 8, 4), np.float32)
    empty[2, 3] = (0.5, 0.25, 0.0, 0.5)
    shown = in_front_of(empty, camera, sky, rotation=0.4, gain=2.0)
    assert (shown[..., 3] == 1.0).all()
    ray = camera.rays(3.5, 2.5, 8, 6)
    behind = 2.0 * observe(sky, about(ray, -0.4))
    assert shown[2, 3, :3] == pytest.approx(np.array([0.5, 0.25, 0.0]) + 0.5 * behind)


def about(ray: np.ndarray, angle: float) -> np.ndarray:
    return np.array(about_y((ray[0], ray[1], ray[2]), angle))


def test_a_blur_keeps_one_colour_and_smooths_a_sun() -> None:
    grey = EnvironmentMap(np.full((16, 32, 3), 0.3, np.float32))
    assert blur(grey, 0.2).radiance == pytest.approx(0.3)
    assert blur(grey, 0.0) is grey
    texels = np.zeros((32, 64, 3), np.float32)
    texels[16, 20] = 100.0
    soft = blur(EnvironmentMap(texels), 0.3).radiance[..., 0]
    assert np.unravel_index(soft.argmax(), soft.shape) == (16, 20)
    half = soft[16, 20] * np.exp((np.cos(3 * 2 * np.pi / 64) - 1.0) / 0.3**2)
    assert soft[16, 23] == pytest.approx(half, rel=0.02)

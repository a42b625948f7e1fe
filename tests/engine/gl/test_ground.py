"""The ground under a model: what both renderers show of it, and that it leaves the model alone."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from engine.core.directions import dot, normalize
from engine.core.steps import drain
from engine.geometry.camera import Camera, frame
from engine.geometry.ground import Ground
from engine.geometry.shapes import shape
from engine.gl.direct import DirectRenderer
from engine.render.direct import radiance
from engine.scene.scene import Scene
from tests.engine.scenes import scene, weave

SIZE = (120, 90)


def draw(gl: Any, what: Scene, **options: Any) -> np.ndarray:
    renderer = DirectRenderer(gl, **options)
    image = renderer.radiance(what, SIZE, samples=1)
    renderer.release()
    return image


def on_ground(**more: Any) -> Scene:
    what = scene("torus-knot", weave(32), source="slices", ground=Ground(albedo=0.4))
    return dataclasses.replace(what, camera=frame(what.mesh.positions, SIZE[0] / SIZE[1]), **more)


def test_the_ground_has_the_predicted_radiance_and_fills_the_lower_image(gl: Any) -> None:
    what = on_ground(lamps=())
    image, bare = draw(gl, what), draw(gl, dataclasses.replace(what, ground=None))
    new = (image[..., 3] == 1.0) & (bare[..., 3] == 0.0)
    assert new[-1].all()
    assert not new[0].any()
    up = float(dot(normalize(what.light), np.array([0.0, 1.0, 0.0])))
    np.testing.assert_allclose(image[new][:, :3], 0.4 / np.pi * up * what.irradiance, rtol=1e-5)
    assert np.array_equal(image[bare[..., 3] == 1.0], bare[bare[..., 3] == 1.0]), "the model is what it was"


@pytest.mark.parametrize("height", [None, -0.3, 0.1])
def test_gpu_and_cpu_show_the_same_ground(gl: Any, height: float | None) -> None:
    what = on_ground(ground=Ground(height=height, albedo=0.7, extent=1.5))
    gpu, cpu = draw(gl, what), drain(radiance(what, SIZE, samples=1))
    alike = gpu[..., 3] == cpu[..., 3]
    assert alike.mean() >= 0.998
    apart = np.abs(gpu - cpu).max(axis=-1)
    assert np.mean(apart > 2e-3) <= 5e-3, "edges where the model meets the ground"


def test_the_ground_seen_from_below_is_lit_from_below(gl: Any) -> None:
    base = on_ground(light=(0.0, -1.0, 0.0), irradiance=2.0)
    camera = Camera(tuple(base.mesh.centre - (0.0, 5.0, 3.0)), tuple(base.mesh.centre))
    what = dataclasses.replace(base, camera=camera)
    for image in (draw(gl, what), drain(radiance(what, SIZE, samples=1))):
        np.testing.assert_allclose(image[45, 60, :3], 0.4 / np.pi * 2.0, rtol=1e-5)


def test_a_changed_ground_is_drawn_anew_and_nothing_is_left_behind(gl: Any) -> None:
    renderer = DirectRenderer(gl)
    first = renderer.radiance(on_ground(), SIZE, samples=1)
    renderer.radiance(on_ground(ground=Ground(albedo=0.9)), SIZE, samples=1)
    renderer.radiance(on_ground(ground=None), SIZE, samples=1)
    assert np.array_equal(renderer.radiance(on_ground(), SIZE, samples=1), first)
    renderer.release()


def test_the_ground_of_a_mesh_far_from_its_origin(gl: Any) -> None:
    near = on_ground(material=None)
    away = np.array([1e5, -2e5, 3e5])
    mesh = dataclasses.replace(shape("torus-knot"), positions=near.mesh.positions + away, health=near.mesh.health)
    camera = frame(mesh.positions, SIZE[0] / SIZE[1])
    far = dataclasses.replace(near, mesh=mesh, camera=camera)
    assert np.mean(np.abs(draw(gl, far) - draw(gl, near)).max(axis=-1) > 1e-3) <= 0.01

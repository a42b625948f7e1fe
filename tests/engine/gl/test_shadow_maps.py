"""Shadow maps of OpenGL against the rays of the CPU renderer."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.geometry.camera import frame
from engine.geometry.ground import Ground
from engine.geometry.shapes import shape
from engine.gl.direct import DirectRenderer
from engine.light.lamps import Lamp
from engine.light.near_lamps import near_lamp_from_text
from engine.render.direct import radiance
from engine.scene.scene import Scene

LAMPS = (Lamp((1.0, 1.0, 0.4), (3.0, 2.0, 1.0)), Lamp((-0.5, 1.0, 1.0), (0.5, 1.0, 2.0)))


def knot(brdf: str = "ggx:kd=0.5,alpha=0.3,f0=0.1", **options: Any) -> Scene:
    mesh = shape("torus-knot")
    options = {"irradiance": 0.0, "ground": Ground(), "shadows": True, **options}
    return Scene(mesh, frame(mesh.positions), brdf_from_text(brdf), **options)


def compare(gl: Any, scene: Scene, size: tuple[int, int] = (160, 120)) -> tuple[float, float]:
    """The relative differences of OpenGL's image from the CPU's, with shadows and without."""
    renderer = DirectRenderer(gl)
    exact = drain(radiance(scene, size, samples=1))[..., :3]
    try:
        found, unshadowed = (renderer.radiance(each, size, samples=1)[..., :3] for each in (scene, without(scene)))
    finally:
        renderer.release()
    return relative(found, exact), relative(unshadowed, exact)


def without(scene: Scene) -> Scene:
    return dataclasses.replace(scene, shadows=False)


def relative(found: NDArray[np.float32], exact: NDArray[np.float32]) -> float:
    return float(np.linalg.norm(found - exact) / np.linalg.norm(exact))


@pytest.mark.parametrize("brdf", ["lambert", "ward:ks=0.4,alpha_x=0.05,alpha_y=0.3"])
def test_shadows_of_distant_lamps_are_those_of_rays(gl: Any, brdf: str) -> None:
    error, unshadowed = compare(gl, knot(brdf, lamps=LAMPS))
    assert error < 0.1 * unshadowed
    assert error < 0.03


@pytest.mark.parametrize(
    "light",
    [
        "x=2,y=3,z=2,power=60",
        "x=2,y=3,z=2,radius=0.3,power=60",
        "x=0,y=0.1,z=0,power=20",
        "shape=rectangle,x=2,y=3,z=1,facing_theta_deg=145,facing_phi_deg=63,power=60",
    ],
)
@pytest.mark.parametrize("brdf", ["ggx:kd=0.4,alpha=0.3,f0=0.2", "phong:ks=0.3,exponent=20"])
def test_shadows_of_near_lights_are_those_of_rays(gl: Any, light: str, brdf: str) -> None:
    error, unshadowed = compare(gl, knot(brdf, near_lamps=(near_lamp_from_text(light),), directions=16))
    assert error < 0.25 * unshadowed
    assert error < 0.1


def test_a_sphere_casts_no_shadow_on_itself(gl: Any) -> None:
    mesh = shape("sphere")
    scene = Scene(mesh, frame(mesh.positions), brdf_from_text("lambert"), light=(1.0, 0.2, 0.3), shadows=True)
    error, _ = compare(gl, scene)
    assert error < 2e-3


def test_maps_are_drawn_again_where_light_or_model_change_and_not_for_another_view(gl: Any) -> None:
    renderer = DirectRenderer(gl)
    scene, size = knot("lambert", lamps=LAMPS), (80, 60)
    renderer.radiance(scene, size)
    first = renderer._shadows
    camera = dataclasses.replace(scene.camera, eye=tuple(1.1 * np.array(scene.camera.eye)))
    renderer.radiance(dataclasses.replace(scene, camera=camera), size)
    assert renderer._shadows is first
    moved = dataclasses.replace(scene, lamps=LAMPS[:1])
    image = renderer.radiance(moved, size)
    assert renderer._shadows is not first
    renderer.release()
    fresh = DirectRenderer(gl)
    np.testing.assert_array_equal(image, fresh.radiance(moved, size))
    fresh.release()

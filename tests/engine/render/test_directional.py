"""Directional maps on models: photographs come back from above, and light turns with the texture."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.brdf.brdf import brdf_from_text
from engine.core.directions import surface_direction
from engine.core.steps import drain
from engine.geometry.camera import Camera
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import shape
from engine.light.lamps import Lamp
from engine.render.direct import radiance, texture_axes
from engine.render.reference import reference
from engine.scene.scene import Scene
from engine.shading.directional.planes import DirectionalMap
from tests.engine.domes import dome_material

Array = NDArray[Any]

#: Seven by nine pixels for each of the 9 × 7 texels.
SIZE = (63, 63)


def from_above(light: Array, *, mesh: Mesh | None = None, brdf: str = "lambert:albedo=0.5", **options: Any) -> Scene:
    """The plane, seen from far above and filled by one repeat of the texture."""
    camera = Camera((0.0, 0.0, 400.0), fov_deg=float(2.0 * np.degrees(np.arctan(1.0 / 400.0))))
    towards = (float(light[0]), float(light[1]), float(light[2]))
    options = {"repeats": 1.0, **options}
    return Scene(mesh or shape("plane"), camera, brdf_from_text(brdf), dome_material(), light=towards, **options)


def directional() -> DirectionalMap:
    found = dome_material().directional
    assert found is not None
    return found


def show(scene: Scene) -> Array:
    """Values at the centres of texels."""
    return drain(radiance(scene, SIZE, samples=1))[4::9, 3::7, :3]


@pytest.mark.parametrize("brdf", ["lambert:albedo=0.5", "phong:exponent=20", "ggx:alpha=0.4"])
@pytest.mark.parametrize("turn", [0.3, 2.0, 4.4])
def test_photographs_come_back_from_above(brdf: str, turn: float) -> None:
    """Whatever the BRDF: a lamp of the capture's strength shows the image of its direction."""
    light = surface_direction(0.7, turn)
    assert show(from_above(light, brdf=brdf)) == pytest.approx(directional().image(light), rel=0.02, abs=0.004)


def test_lambert_looks_alike_from_every_view() -> None:
    light = surface_direction(0.7, 2.0)
    above = from_above(light)
    aside = dataclasses.replace(above, camera=Camera((300.0, 100.0, 250.0), fov_deg=0.45))
    seen = drain(radiance(aside, SIZE, samples=1))[31, 31, :3]
    assert seen == pytest.approx(drain(radiance(above, SIZE, samples=1))[31, 31, :3], rel=0.01)


def test_a_turned_model_under_a_turned_light_is_the_same() -> None:
    """A quarter turn: the axes of the texture turn with the model, and so does the azimuth."""
    plane = shape("plane")
    turned = dataclasses.replace(plane, positions=plane.positions[:, (1, 0, 2)] * (-1.0, 1.0, 1.0))
    x, y, z = light = surface_direction(0.8, 0.4)
    expected = drain(radiance(from_above(light), SIZE, samples=1))
    found = drain(radiance(from_above(np.array([-y, x, z]), mesh=turned), SIZE, samples=1))
    assert np.rot90(expected)[..., :3] == pytest.approx(found[..., :3], abs=2e-3)


def test_a_mirrored_texture_is_lit_from_the_other_side() -> None:
    plane = shape("plane")
    mirrored = dataclasses.replace(plane, uv=(plane.uv * (-1.0, 1.0) + (1.0, 0.0)).astype(np.float32))
    x, y, z = light = surface_direction(0.8, 0.4)
    expected = drain(radiance(from_above(light), SIZE, samples=1))
    found = drain(radiance(from_above(np.array([-x, y, z]), mesh=mirrored), SIZE, samples=1))
    assert expected[:, ::-1, :3] == pytest.approx(found[..., :3], abs=2e-3)


def test_the_back_of_a_texture_is_seen_mirrored() -> None:
    """From behind, right is left: a lamp on the left of the photographs stands on the right of the viewer."""
    x, y, z = light = surface_direction(0.8, 0.4)
    front = drain(radiance(from_above(light), SIZE, samples=1))
    behind = from_above(np.array([x, y, -z]))
    camera = dataclasses.replace(behind.camera, eye=(0.0, 0.0, -400.0))
    found = drain(radiance(dataclasses.replace(behind, camera=camera), SIZE, samples=1))
    assert front[:, ::-1, :3] == pytest.approx(found[..., :3], abs=2e-3)


def test_axes_of_a_texture_follow_its_coordinates() -> None:
    triangle = np.array([[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0]]])
    uv = np.array([[[0.0, 1.0], [0.0, 0.0], [1.0, 1.0]]])  # right is +y in space, up is +x: mirrored
    axes = texture_axes(triangle, uv, np.array([[0.0, 0.0, 1.0]]))
    assert axes[0] == pytest.approx(np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]))


def test_several_lights_add_up_as_radiance() -> None:
    """Codes are summed for each light, and light is added after they are decoded."""
    one, two = surface_direction(0.4, 1.0), surface_direction(1.0, 3.5)
    lamp = Lamp((float(two[0]), float(two[1]), float(two[2])), (2.0, 1.0, 0.5))
    both = show(from_above(one, lamps=(lamp,)))
    expected = directional().image(one) + directional().image(two) * (2.0, 1.0, 0.5)
    assert both == pytest.approx(expected, rel=0.02, abs=0.006)


@pytest.mark.parametrize("lookup", ["angle", "texture", "outgoing"])
def test_other_look_ups_agree_where_one_light_is_overhead(lookup: Any) -> None:
    """A Lambertian plane from above, lit from its normal: all four are the image of that light."""
    overhead = np.array([0.0, 0.0, 1.0])
    assert show(from_above(overhead, lookup=lookup)) == pytest.approx(directional().image(overhead), rel=0.02)


def test_light_from_below_is_black_and_low_light_is_dimmed() -> None:
    assert not show(from_above(np.array([0.6, 0.0, -0.8]))).any()
    lowest = directional().lowest
    half = show(from_above(surface_direction(np.arccos(0.5 * lowest), 1.0)))
    assert half == pytest.approx(directional().image(surface_direction(np.arccos(0.5 * lowest), 1.0)), abs=0.004)


def test_the_reference_sees_what_direct_light_shows() -> None:
    """One directional lamp and one bounce: paths find the same radiance, at pixels that change little within."""
    scene = from_above(surface_direction(0.7, 2.0))
    traced = drain(reference(scene, (21, 21), samples=16, max_depth=1)).image
    direct = drain(radiance(scene, (21, 21), samples=4))
    assert np.abs(traced[..., :3].mean() / direct[..., :3].mean() - 1.0) < 0.01

"""Environment light on both renderers: closed forms, single texels, rotation, agreement, and the measured error."""

from __future__ import annotations

import dataclasses
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from benchmarks.directions import directions_sweeps
from engine.core.steps import drain
from engine.gl.direct import DirectRenderer
from engine.light.environment import DistantLights, EnvironmentMap, all_lights, texel_directions
from engine.light.environment_file import open_environment
from engine.render.direct import Shader, radiance
from engine.render.display import Display, display
from engine.render.environment_error import environment_error, error_ladder
from engine.scene.material import Material
from engine.scene.scene import LOOKUPS, Scene
from engine.shading.shading_map import ShadingMap
from tests.engine.scenes import head_on, scene, weave

SIZE = (60, 45)


@pytest.fixture(scope="module")
def studio() -> EnvironmentMap:
    return open_environment("studio")


def linear_map(colour: tuple[float, float, float] = (0.3, 0.6, 0.2), slices: int = 5) -> Material:
    """S(r) = colour r / r_max."""
    share = np.linspace(0, 1, slices)[:, None, None, None]
    images = (share * np.ones((1, 4, 4, 1)) * colour).astype(np.float32)
    return Material(ShadingMap(images, 1.0, images.mean(axis=(1, 2, 3), dtype=np.float64)), None, sigma=np.pi)


def single_texel(row: int, column: int, colour: tuple[float, float, float]) -> EnvironmentMap:
    image = np.zeros((64, 128, 3), np.float32)
    image[row, column] = colour
    return EnvironmentMap(image)


def centre(what: Scene, lights: DistantLights | None = None) -> np.ndarray:
    return Shader(what, SIZE)(np.array([22]), np.array([30]), lights)[0, :3]


def test_constant_light_on_a_linear_map_has_its_closed_form() -> None:
    """Lambert with sigma f = r_max: the integral of S(cos) dw is colour times pi, for every look-up that is linear."""
    environment = EnvironmentMap(np.ones((64, 128, 3), np.float32))
    what = head_on(linear_map(), brdf="lambert:albedo=1", environment=environment)
    expected = np.pi * np.array([0.3, 0.6, 0.2])
    np.testing.assert_allclose(centre(what, all_lights(environment)), expected, rtol=1e-3)
    np.testing.assert_allclose(centre(dataclasses.replace(what, directions=1024)), expected, rtol=5e-3)
    texture = dataclasses.replace(what, lookup="texture", directions=1024)
    np.testing.assert_allclose(centre(texture), expected, rtol=5e-3)


def test_constant_light_without_a_material_gives_the_albedo() -> None:
    environment = EnvironmentMap(np.ones((64, 128, 3), np.float32))
    what = head_on(brdf="lambert:albedo=0.5", environment=environment)
    np.testing.assert_allclose(centre(what, all_lights(environment)), 0.5, rtol=1e-3)


def test_the_look_up_is_inside_the_sum() -> None:
    """Two equal lights under a map that bends: twice S(r) and not S(2 r)."""
    what = head_on(weave(8), brdf="lambert:albedo=1")
    towards = np.array([[0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]])
    one, both = (DistantLights(towards[:count], np.full((count, 3), 0.5)) for count in (1, 2))
    np.testing.assert_allclose(centre(what, both), 2 * centre(what, one), rtol=1e-12)
    outside = dataclasses.replace(what, lookup="outgoing")
    assert np.abs(centre(outside, both) / (2 * centre(outside, one)) - 1).max() > 0.05


@pytest.mark.parametrize("lookup", LOOKUPS)
@pytest.mark.parametrize("source", ["slices", "power-law"])
def test_a_single_texel_is_a_directional_light(gl: Any, lookup: str, source: str) -> None:
    environment = single_texel(20, 60, (7.0, 7.0, 7.0))
    irradiance = float(all_lights(environment).irradiance.max())
    direction = tuple(texel_directions(64, 128)[20, 60])
    lit = scene("sphere", weave(), light=direction, irradiance=irradiance, lookup=lookup, source=source)
    from_map = dataclasses.replace(lit, irradiance=1.0, environment=environment, directions=32)
    renderer = DirectRenderer(gl)
    for draw in (
        lambda what: drain(radiance(what, SIZE, samples=1)),
        lambda what: renderer.radiance(what, SIZE, samples=1),
    ):
        difference = display(draw(lit), Display()).astype(int) - display(draw(from_map), Display())
        assert np.abs(difference).max() <= 4, "the texel is 2.8 degrees wide"
        assert np.abs(difference).mean() < 0.2
    renderer.release()


@pytest.mark.parametrize("lookup", LOOKUPS)
@pytest.mark.parametrize("source", [None, "slices", "power-law"])
@pytest.mark.parametrize("above", ["clamp", "scale"])
def test_GL8_gpu_and_cpu_agree_under_an_environment(
    gl: Any, studio: EnvironmentMap, lookup: str, source: str | None, above: str
) -> None:
    material = weave(48) if source else None
    options = {"lookup": lookup, "source": source or "slices", "above": above, "brdf": "ggx:alpha=0.3"}
    what = scene("sphere", material, environment=studio, environment_rotation=0.7, directions=16, **options)
    renderer = DirectRenderer(gl)
    gpu = renderer.radiance(what, SIZE, samples=1)
    renderer.release()
    cpu = drain(radiance(what, SIZE, samples=1))
    assert cpu[..., :3].max() > 0.1
    assert np.abs(display(gpu, Display()).astype(int) - display(cpu, Display())).max() <= 1


@pytest.mark.parametrize("slices", [2, 3, 64, 300])
def test_any_number_of_slices_is_summed_alike(gl: Any, studio: EnvironmentMap, slices: int) -> None:
    what = scene("sphere", weave(8, slices), environment=studio, directions=8)
    renderer = DirectRenderer(gl)
    gpu = renderer.radiance(what, (24, 18), samples=1)
    renderer.release()
    np.testing.assert_allclose(gpu, drain(radiance(what, (24, 18), samples=1)), atol=2e-3)


def test_EN11_turning_the_environment_is_rolling_its_map(studio: EnvironmentMap) -> None:
    """A quarter turn about +Y moves what came from +Z to +X: the columns move left by a quarter."""
    rolled = EnvironmentMap(np.roll(studio.radiance, -64, axis=1))
    turned = all_lights(studio).rotate(np.pi / 2)
    np.testing.assert_allclose(turned.direction[turned.irradiance[:, 0].argmax()], _brightest(rolled), atol=1e-9)
    what = scene("sphere", weave(16), environment=studio, directions=256)
    a = drain(radiance(dataclasses.replace(what, environment_rotation=np.pi / 2), (24, 18), samples=1))
    b = drain(radiance(dataclasses.replace(what, environment=rolled), (24, 18), samples=1))
    assert np.linalg.norm(a - b) / np.linalg.norm(b) < 0.05
    assert all_lights(studio).rotate(0.0).direction is not None


def _brightest(environment: EnvironmentMap) -> np.ndarray:
    lights = all_lights(environment)
    return lights.direction[lights.irradiance[:, 0].argmax()]


def test_a_light_of_one_colour_tints() -> None:
    what = head_on(weave(8), brdf="lambert:albedo=1", environment=single_texel(32, 64, (9.0, 0.0, 0.0)))
    for lookup in LOOKUPS:
        value = centre(dataclasses.replace(what, lookup=lookup))
        assert value[0] > 0.0
        assert value[1:].max() == 0.0


def sun_in_one_texel() -> EnvironmentMap:
    height = np.clip(texel_directions(256, 512)[..., 1:2], 0, 1)
    radiance = np.array((0.2 + 0.8 * height) * (0.3, 0.5, 1.0), np.float32)
    radiance[75, 200] = (3e4, 2.7e4, 2e4)
    return EnvironmentMap(radiance)


MAPS = {
    "studio": lambda _data: open_environment("studio"),
    "sky": lambda _data: open_environment("sky"),
    "constant": lambda _data: EnvironmentMap(np.ones((64, 128, 3), np.float32)),
    "sun": lambda _data: sun_in_one_texel(),
} | {
    name: lambda data, name=name: open_environment(data(f"hdr/debevec/{name}_probe_latlong.hdr"))
    for name in ("grace", "stpeters", "galileo")
}


@pytest.mark.parametrize(
    "name", ["sun", *(pytest.param(name, marks=pytest.mark.long) for name in MAPS if name != "sun")]
)
def test_T7_more_directions_never_cost_accuracy(shared_data: Any, name: str) -> None:
    """Above 50 % a shiny image is a few spots, of which the pixels that are compared see many or few by chance."""
    sweeps = drain(directions_sweeps(weave(32), MAPS[name](shared_data), pixels=64))
    for sweep, largest in zip(sweeps, (0.001, 0.02), strict=True):
        errors = [error.rmse_rel for error in sweep.errors]
        assert all(b <= 1.01 * a or a > 0.5 for a, b in pairwise(errors)), (sweep.brdf, errors)
        assert errors[-1] < largest
        assert sweep.errors[0].reference_size == (128, 64)
        assert sweep.errors[0].pixels == 64


@pytest.mark.parametrize(
    ("brdf", "most"),
    [pytest.param("lambert", 0.001, marks=pytest.mark.long), ("phong:kd=0.2,ks=0.6,exponent=100", 0.01)],
)
def test_the_cells_of_the_reference_stand_for_all_texels(studio: EnvironmentMap, brdf: str, most: float) -> None:
    what = scene("sphere", weave(32), brdf=brdf, environment=studio)
    shade = Shader(what, SIZE)
    row, column = np.full(4, 22), np.arange(24, 40, 4)
    every, gathered = (shade(row, column, all_lights(studio, rows))[:, :3] for rows in (None, 64))
    assert np.linalg.norm(gathered - every) / np.linalg.norm(every) < most


def test_the_dense_sum_has_no_error_for_a_single_texel() -> None:
    what = scene("sphere", weave(8), brdf="lambert", environment=single_texel(30, 64, (5.0, 4.0, 3.0)), directions=64)
    assert drain(environment_error(what, SIZE, pixels=16)).rmse_rel < 0.01
    with pytest.raises(ValueError, match="without an environment"):
        drain(error_ladder(scene("sphere"), SIZE, (8,)))


@pytest.mark.parametrize("options", [{"directions": 0}, {"directions": 5000}, {"environment_rotation": np.nan}])
def test_an_environment_that_makes_no_sense_is_refused(options: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="not possible"):
        head_on(**options)

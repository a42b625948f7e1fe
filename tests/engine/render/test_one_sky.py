"""One rotated sky, seen alike by all that takes light from it: a convention that is wrong in one place fails here.

Every texel has a colour of its own, and the sky is rotated by a number of texels that leaves no symmetry. Then the
column of a direction is known by counting, without any code of the project.
"""

from __future__ import annotations

import dataclasses
import importlib
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.core.steps import drain
from engine.light.cube_map import CubeMap, cube_directions, cube_of, cube_solid_angles, face_coordinates
from engine.light.environment import EnvironmentMap, all_lights
from engine.light.gaussian_prefilter import prefilter
from engine.render.direct import Shader
from engine.render.light_sampling import environment_sampler
from engine.render.reference import reference
from engine.scene.scene import Scene
from engine.transport.sh.basis import evaluate
from engine.transport.sh.lighting import project, scene_coefficients
from tests.engine.scenes import scene

Floats = NDArray[np.float64]

#: Rows of the map, and how far it is rotated: a quarter of its columns less one.
ROWS, COLUMNS, TURNED = 8, 16, 3
ANGLE = TURNED * 2.0 * np.pi / COLUMNS


def sky() -> EnvironmentMap:
    return EnvironmentMap(np.random.default_rng(5).uniform(0.1, 4.0, (ROWS, COLUMNS, 3)).astype(np.float32))


def where(row: int, column: int) -> Floats:
    """The middle of a texel of a map that is not rotated: +Z is in the middle of the image, +X a quarter in."""
    azimuth, polar = 2.0 * np.pi * (column + 0.5) / COLUMNS, np.pi * (row + 0.5) / ROWS
    return np.array([np.sin(polar) * np.sin(azimuth), np.cos(polar), -np.sin(polar) * np.cos(azimuth)])


def world() -> tuple[Floats, Floats]:
    """World directions (N, 3) and the colours (N, 3) that come from there once the sky is rotated.

    What came from +Z (column 8) comes from +X (column 4) after a quarter turn, so colours move to lower columns.
    """
    places = [(row, column) for row in range(ROWS) for column in range(COLUMNS)]
    colours = [sky().radiance[row, (column + TURNED) % COLUMNS] for row, column in places]
    return np.array([where(*place) for place in places]), np.array(colours, np.float64)


def rotate() -> EnvironmentMap:
    """A map that is stored rotated, and shows what `sky` shows once it is rotated."""
    return EnvironmentMap(np.roll(sky().radiance, -TURNED, axis=1))


def light_up() -> Scene:
    what = scene("sphere", brdf="lambert:albedo=1", environment=sky(), directions=4096)
    return dataclasses.replace(what, environment_rotation=ANGLE)


def test_every_texel_is_where_the_convention_says() -> None:
    direction, colour = world()
    lights = all_lights(sky()).rotate(ANGLE)
    nearest = np.argmax(direction @ lights.direction.T, axis=1)
    area = 2.0 * np.pi / COLUMNS * -np.diff(np.cos(np.linspace(0.0, np.pi, ROWS + 1)))
    np.testing.assert_allclose(lights.irradiance[nearest] / np.repeat(area, COLUMNS)[:, None], colour, rtol=1e-6)


def test_the_reference_sees_the_same_colours() -> None:
    direction, colour = world()
    sampler = environment_sampler(sky(), 1.0, ANGLE)
    assert sampler is not None
    np.testing.assert_array_equal(sampler.look_up(direction, direction)[0], colour)
    random = np.random.default_rng(1)
    drawn, light, _ = sampler.draw(random.random((500, 2)), np.tile((0.0, 1.0, 0.0), (500, 1)))
    np.testing.assert_array_equal(light, sampler.look_up(drawn, drawn)[0])


def test_cube_maps_and_narrow_gaussians_see_the_same_colours() -> None:
    direction, colour = world()
    cube = cube_of(rotate(), 128)
    face, s, t = face_coordinates(direction)
    found = cube.radiance[face, (t * 128).astype(int), (s * 128).astype(int)]
    np.testing.assert_allclose(found, colour, rtol=1e-5)
    wide = np.abs(direction[:, 1]) < 0.8  # texels near the poles are narrower than the Gaussian
    np.testing.assert_allclose(prefilter(cube, [0.02]).lookup(direction[wide], 0.02), colour[wide], rtol=1e-3)


def test_harmonics_of_the_turned_sky_are_the_sums_over_its_texels() -> None:
    order, fine = 6, np.repeat(np.repeat(rotate().radiance, 16, axis=0), 16, axis=1)
    lights = all_lights(EnvironmentMap(fine))
    expected = evaluate(order, lights.direction).T @ lights.irradiance
    size = np.abs(expected).max()
    np.testing.assert_allclose(scene_coefficients(light_up(), order), expected, atol=2e-3 * size)
    np.testing.assert_allclose(project(cube_of(rotate(), 128), order), expected, atol=2e-3 * size)


def test_the_directions_chosen_for_images_bring_the_same_vector_of_light() -> None:
    """The first moment of the light: along it the most arrives, and a map that is mirrored or rotated has another."""
    direction, area = cube_directions(64).reshape(-1, 3), np.tile(cube_solid_angles(64).ravel(), 6)
    cube: CubeMap = cube_of(rotate(), 64)
    expected = (direction * area[:, None]).T @ cube.radiance.reshape(-1, 3)
    lights = light_up().lights
    found = lights.direction.T @ lights.irradiance
    np.testing.assert_allclose(found, expected, atol=0.02 * np.abs(expected).max())


def test_images_of_the_reference_are_the_sums_over_the_turned_sky() -> None:
    what, size = light_up(), (12, 12)
    fine = EnvironmentMap(np.repeat(np.repeat(rotate().radiance, 4, axis=0), 4, axis=1))
    row, column = np.mgrid[: size[1] * 4, : size[0] * 4].reshape(2, -1)
    dense = Shader(what, (size[0] * 4, size[1] * 4))(row, column, all_lights(fine))
    expected = dense.reshape(size[1], 4, size[0], 4, 4).mean(axis=(1, 3))
    found = drain(reference(what, size, samples=1024))
    assert found.variance is not None
    inside = (found.image[..., 3] == 1.0) & (expected[..., 3] == 1.0)
    assert inside.sum() > 30
    apart = np.abs(found.image - expected)[inside][:, :3]
    assert (apart < 5.0 * np.sqrt(found.variance[inside]) + 0.01 * expected[inside][:, :3]).all()
    assert np.sqrt(np.mean(apart**2)) < 0.03 * expected[inside].mean()


def test_mitsuba_sees_the_same_colours() -> None:
    mitsuba: Any
    try:
        mitsuba = importlib.import_module("mitsuba")
    except (ImportError, NameError) as error:
        pytest.skip(f"Mitsuba cannot be loaded: {error}")
    mitsuba.set_variant("scalar_rgb")
    fine = np.repeat(np.repeat(sky().radiance, 16, axis=0), 16, axis=1)  # between texels Mitsuba mixes them
    turn = mitsuba.ScalarTransform4f().rotate([0, 1, 0], np.degrees(ANGLE))
    emitter = mitsuba.load_dict({"type": "envmap", "bitmap": mitsuba.Bitmap(fine), "to_world": turn})
    direction, colour = world()
    found = []
    for towards in direction:
        interaction = mitsuba.SurfaceInteraction3f()
        interaction.wi = mitsuba.Vector3f([float(-x) for x in towards])
        found.append(np.array(emitter.eval(interaction)))
    np.testing.assert_allclose(found, colour, rtol=1e-4)

"""Gaussian transport as the graphics device draws it, beside the CPU's image."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from engine.core.directions import normalize
from engine.core.steps import drain
from engine.geometry.camera import Camera, frame
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import shape
from engine.gl.context import Limits
from engine.gl.transported import TransportRenderer
from engine.light.cube_map import CubeMap
from engine.light.environment import EnvironmentMap, texel_directions
from engine.light.gaussian_prefilter import gaussian_integral, prefilter
from engine.light.lamps import Lamp
from engine.render.transported import image_of
from engine.transport.gaussian.fitting.lobes import Lobes
from engine.transport.gaussian.fitting.views import VIEWS, view_directions
from engine.transport.gaussian.gpu_layout import atlas_of, pack, unpack
from engine.transport.gaussian.lighting import GaussianLight, filter_for, levels_between
from engine.transport.gaussian.transfer import GaussianTransport, diffuse_radiance
from engine.transport.relight import RelightGaussians
from tests.engine.gl.relit_scenes import SIZE, sphere
from tests.engine.gl_objects import living_objects
from tests.engine.transport.gaussian.synthetic_lobes import mirror_lobes, random_lobes, transport_of


def sky(rows: int = 64) -> EnvironmentMap:
    x, y, z = np.moveaxis(texel_directions(rows, 2 * rows), -1, 0)
    radiance = np.stack([1.0 + 0.8 * x, np.exp(2.0 * y), np.exp(6.0 * (0.6 * x + 0.8 * z - 1.0))], axis=-1)
    return EnvironmentMap(radiance.astype(np.float32), "smooth")


LEVELS = levels_between(0.05, 0.8)


def around(rotation: float = 0.0, factor: float = 1.0, lamps: tuple[Lamp, ...] = ()) -> GaussianLight:
    return GaussianLight(filter_for(sky(), LEVELS), factor, rotation, lamps)


def vary_lobes(mesh: Mesh, seed: int = 0) -> Lobes:
    """Mirrored views whose widths and colours change over the model and the views."""
    lobes = mirror_lobes(normalize(mesh.normals))
    rng = np.random.default_rng(seed)
    waves = mesh.positions @ rng.normal(size=(3, 3)) + (view_directions() @ rng.normal(size=(3, 3)))[:, None]
    waves = np.moveaxis(waves, 0, 1)
    lobes.weight[..., 0, :] *= (1.2 + np.sin(waves)).astype(np.float32)
    lobes.sigma[..., 0] = 0.15 * np.exp(0.8 * np.sin(waves[..., 0]))
    return lobes


def relight_by(transport: GaussianTransport, light: GaussianLight) -> RelightGaussians:
    coefficients = np.zeros((25, 3))
    coefficients[:4] = [[2.0, 1.5, 1.0], [0.3, 0.1, 0.2], [0.1, 0.4, 0.0], [0.2, 0.0, 0.1]]
    return RelightGaussians(transport, light, diffuse_radiance(transport, coefficients))


def both(gl: Any, relit: RelightGaussians, camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """Pixels that both images cover, drawn and computed."""
    renderer = TransportRenderer(gl, debug=True)
    found = renderer.radiance(relit, camera, SIZE, samples=1)
    assert renderer.invalid_samples == 0
    renderer.release()
    expected = drain(image_of(relit, camera, SIZE, 1)).image
    inside = (found[..., 3] == 1.0) & (expected[..., 3] == 1.0)
    assert inside.sum() > 0.99 * (expected[..., 3] == 1.0).sum() > 2000
    return found[inside][:, :3], expected[inside][:, :3]


def assert_alike(gl: Any, relit: RelightGaussians, camera: Camera, within: float = 2e-3) -> None:
    """But for pixels whose centre is on an edge, where either face may win."""
    found, expected = both(gl, relit, camera)
    error = np.abs(found - expected).max(axis=1)
    assert np.mean(error < within * (expected.max(axis=1) + expected.mean())) > 0.995, np.sort(error / expected.mean())
    assert expected.std() > 0.1 * expected.mean(), "an image of nothing"


CAMERA = Camera((1.2, 0.8, 2.0), (0.0, 0.0, 0.0))


@pytest.mark.parametrize("lobes", [1, 2, 3])
@pytest.mark.parametrize("rotation", [0.0, 1.1])
def test_fragments_look_mixed_lobes_up(gl: Any, lobes: int, rotation: float) -> None:
    mesh = sphere(3)
    transport = transport_of(mesh, *(vary_lobes(mesh, seed) for seed in range(lobes)))
    assert_alike(gl, relight_by(transport, around(rotation, 0.7)), CAMERA)


def test_a_component_of_two_lobes_is_drawn_whole(gl: Any) -> None:
    mesh = sphere(3)
    one, other = vary_lobes(mesh, 1), vary_lobes(mesh, 2)
    pairs = Lobes(*(np.concatenate([getattr(x, n) for x in (one, other)], axis=2) for n in ("weight", "mean", "sigma")))
    relit = relight_by(transport_of(mesh, pairs, vary_lobes(mesh, 3)), around())
    assert_alike(gl, relit, CAMERA)


@pytest.mark.parametrize("grazing", [False, True])
def test_the_diffuse_part_and_the_ground_are_drawn(gl: Any, grazing: bool) -> None:
    mesh = sphere(3)
    transport = transport_of(mesh, vary_lobes(mesh), ground=Ground(albedo=0.4, cells=8), grazing=grazing)
    assert_alike(gl, relight_by(transport, around()), Camera((1.5, 1.2, 3.0), (0.0, -0.3, 0.0)))


def test_lamps_and_discs_are_those_of_the_cpu(gl: Any) -> None:
    mesh = sphere(3)
    transport = transport_of(mesh, vary_lobes(mesh))
    point, disc = Lamp((0.3, 0.5, 0.8), (3.0, 2.0, 1.0)), Lamp((0.9, 0.2, 0.4), (1.0, 2.0, 3.0), math.radians(20.0))
    for light in (GaussianLight(lamps=(point,)), GaussianLight(lamps=(disc, point)), around(0.4, 1.0, (disc,))):
        assert_alike(gl, relight_by(transport, light), CAMERA)


def test_views_are_chosen_as_on_the_cpu(gl: Any) -> None:
    """Every view has a lobe of its own colour, so that each pixel tells which views were mixed."""
    mesh = sphere(4)
    lobes = random_lobes(len(mesh.positions), 1, narrow=0.3)
    colours = np.random.default_rng(0).random((VIEWS, 3)).astype(np.float32)
    lobes.weight[:] = colours[None, :, None]
    lobes.mean[:] = (0.0, 1.0, 0.0)
    lobes.sigma[:] = 0.4
    for eye in ((1.2, 0.8, 2.0), (-2.0, 0.1, 0.3), (0.0, -2.4, 0.01), (0.0, 2.4, 0.0)):
        assert_alike(
            gl, relight_by(transport_of(mesh, lobes), around()), Camera(eye, (0.0, 0.0, 0.0), up=(0.0, 0.3, 1.0))
        )


def test_lobes_of_any_kind_leave_no_pixel_that_is_not_finite(gl: Any) -> None:
    """G11: among random means some nearly cancel."""
    mesh = shape("torus-knot")
    lobes = random_lobes(len(mesh.positions), 1, narrow=0.0016, wide=2.0)
    lobes.mean[:, ::2] = (0.0, 0.6, 0.8)
    lobes.mean[:, 1::2] = (0.0, -0.6, -0.8)
    renderer = TransportRenderer(gl, debug=True)
    relit = relight_by(transport_of(mesh, lobes), around())
    image = renderer.radiance(relit, frame(mesh.positions, 4 / 3), SIZE, samples=1)
    assert renderer.invalid_samples == 0
    assert np.isfinite(image).all()
    renderer.release()


def test_levels_that_are_not_evenly_spaced_are_found(gl: Any) -> None:
    mesh = sphere(3)
    rng = np.random.default_rng(0)
    cube = CubeMap((rng.random((6, 32, 32, 3)) ** 8).astype(np.float32))
    filtered = prefilter(cube, (0.06, 0.07, 0.15, 0.4, 0.45, 1.2))
    assert not atlas_of(filtered).is_even
    assert_alike(gl, relight_by(transport_of(mesh, vary_lobes(mesh)), GaussianLight(filtered)), CAMERA)


def test_EN7_light_brighter_than_half_floats_is_scaled(gl: Any) -> None:
    mesh = sphere(3)
    radiance = np.ones((6, 32, 32, 3), np.float32)
    radiance[4, 10:12, 10:12] = 1e7
    filtered = prefilter(CubeMap(radiance), (0.06, 0.12, 0.24))
    assert max(level.max() for level in filtered.levels) > 70_000.0
    assert_alike(gl, relight_by(transport_of(mesh, vary_lobes(mesh)), GaussianLight(filtered)), CAMERA)


def test_small_textures_take_thinner_levels_and_say_so(gl: Any) -> None:
    mesh = sphere(2)
    relit = relight_by(transport_of(mesh, vary_lobes(mesh)), around())
    renderer = TransportRenderer(gl, texture_limits=Limits(1024, 128))
    image = renderer.radiance(relit, CAMERA, (40, 30), samples=1)
    assert not renderer.messages
    renderer.release()
    smaller = atlas_of(filter_for(sky(), LEVELS), 200)
    assert max(smaller.texels.shape[1:3]) <= 200
    assert smaller.reduced > 0
    assert np.isfinite(image).all()
    with pytest.raises(ValueError, match="do not fit"):
        atlas_of(filter_for(sky(), LEVELS), 8)
    with pytest.raises(ValueError, match="more than the"):
        TransportRenderer(gl, texture_limits=Limits(64, 16)).radiance(relit, CAMERA, (40, 30), samples=1)


def test_too_many_lobes_are_refused_in_words(gl: Any) -> None:
    mesh = sphere(0)
    relit = relight_by(transport_of(mesh, random_lobes(len(mesh.positions), 9)), around())
    with pytest.raises(ValueError, match="9 lobes"):
        TransportRenderer(gl).radiance(relit, CAMERA, (40, 30), samples=1)


def test_a_model_without_lobes_shows_its_diffuse_part(gl: Any) -> None:
    mesh = sphere(3)
    assert_alike(gl, relight_by(transport_of(mesh, diffuse=True), around()), CAMERA)


def test_turning_the_light_uploads_nothing_and_leaves_nothing_behind(gl: Any) -> None:
    mesh = sphere(2)
    transport = transport_of(mesh, vary_lobes(mesh))
    renderer = TransportRenderer(gl)
    still = relight_by(transport, around())
    first = renderer.radiance(still, CAMERA, SIZE, samples=1)
    held = dict(living_objects())
    turned = [renderer.radiance(relight_by(transport, around(0.1 * k)), CAMERA, SIZE, samples=1) for k in range(1, 6)]
    assert living_objects() == held
    assert not any(np.array_equal(first, image) for image in turned)
    assert np.array_equal(first, renderer.radiance(relight_by(transport, around()), CAMERA, SIZE, samples=1))
    renderer.radiance(relight_by(transport, GaussianLight()), CAMERA, SIZE, samples=1)
    renderer.release()
    left = living_objects()
    assert left.pop("Program") <= 1, "the one in use goes when another is used"
    assert left.pop("Shader") <= 2
    assert set(left.values()) == {0}


def test_words_of_lobes_are_right_to_what_they_promise() -> None:
    lobes = random_lobes(20, 2, narrow=0.0016, wide=2.0)
    energy, mean, sigma = unpack(pack([lobes]))
    expected = (lobes.weight * gaussian_integral(lobes.sigma)[..., None]).reshape(-1, 3)
    np.testing.assert_allclose(energy, expected, rtol=5e-4, atol=1e-7)
    np.testing.assert_allclose(sigma, lobes.sigma.ravel(), rtol=6e-5)
    assert np.arccos(np.clip(np.sum(mean.astype(float) * lobes.mean.reshape(-1, 3), axis=1), -1, 1)).max() < 1e-3
    assert np.linalg.norm(mean - lobes.mean.reshape(-1, 3), axis=1).max() < 7e-5
    two = pack([lobes, random_lobes(20, 1, 5)]).reshape(20, VIEWS, 3, 3)
    np.testing.assert_array_equal(two[:, :, :2].reshape(-1, 3), pack([lobes]))

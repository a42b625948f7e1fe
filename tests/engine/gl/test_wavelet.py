"""Wavelet transport as the graphics device draws it, beside the formula and beside the CPU's image."""

from __future__ import annotations

import contextlib
import math
from typing import Any, cast

import numpy as np
import pytest

from engine.core.steps import drain
from engine.factor.hemisphere_map import MapKind
from engine.factor.separable_factors import SeparableFactors
from engine.geometry.camera import Camera, frame
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import plane, shape
from engine.gl import transported as drawing
from engine.gl.screen import Image
from engine.gl.transported import TransportRenderer
from engine.gl.wavelet import MAX_TERMS
from engine.render.transported import image_of
from engine.transport.relight import RelightWavelets
from tests.engine.gl.relit_scenes import SIZE, factors, hits, local_views, relight_wavelets, sphere
from tests.engine.gl_objects import living_objects


def draw(gl: Any, relit: RelightWavelets, camera: Camera, size: tuple[int, int] = SIZE) -> np.ndarray:
    renderer = TransportRenderer(gl, debug=True)
    image = renderer.radiance(relit, camera, size, samples=1)
    assert renderer.invalid_samples == 0
    renderer.release()
    return image


def observe_from(mesh: Mesh, eye: tuple[float, float, float]) -> Camera:
    return Camera(tuple(mesh.centre + mesh.radius * np.array(eye)), tuple(mesh.centre))


def per_fragment(relit: RelightWavelets, camera: Camera) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pixels of the model where frames are one, their radiance by the formula, and the mean of the corners'."""
    transport, first, terms = relit.transport, relit.flat_vertex, relit.transport.factors.terms
    pixels, corners, weights = hits(relit.mesh, camera)
    model = (corners < first).all(axis=1)
    pixels, corners, weights = pixels[model], corners[model], weights[model]
    views = local_views(relit.mesh, transport.frames, camera)
    tuples = relit.rows[: first * terms].reshape(first, terms, 3)

    def product(view: np.ndarray, tuple_: np.ndarray) -> np.ndarray:
        maps = (transport.factors.hemisphere_map.look_up(one, view) for one in transport.factors.first)
        return sum(one * tuple_[:, k] for k, one in enumerate(maps))

    view = np.einsum("nk,nki->ni", weights, views[corners])
    view /= np.linalg.norm(view, axis=1, keepdims=True)
    along = np.einsum("nk,nki->ni", weights, transport.frames[corners][..., 0])
    value = product(view, np.einsum("nk,nktc->ntc", weights, tuples[corners]))
    corner = sum(weights[:, k, None] * product(views[corners[:, k]], tuples[corners[:, k]]) for k in range(3))
    one_frame = np.clip((np.sum(along**2, axis=1) - 0.75) / (0.93 - 0.75), 0.0, 1.0)
    share = (one_frame**2 * (3.0 - 2.0 * one_frame))[:, None]
    return pixels, share * value + (1.0 - share) * corner, share


def close(image: np.ndarray, pixels: np.ndarray, expected: np.ndarray) -> None:
    """All but those pixels whose centre is on an edge, where either face may win, are within a thousandth."""
    found = image.reshape(-1, 4)[pixels]
    covered = found[:, 3] == 1.0
    assert covered.mean() > 0.99
    error = np.abs(found[:, :3] - np.maximum(expected, 0.0)).max(axis=1)[covered]
    scale = np.abs(expected).mean()
    assert np.mean(error < 1e-3 * scale) > 0.995, np.sort(error / scale)[-20:]


@pytest.mark.parametrize("kind", ["orthographic", "polar", "parabolic"])
@pytest.mark.parametrize("terms", [1, 4, MAX_TERMS])
def test_fragments_look_their_terms_up(gl: Any, kind: MapKind, terms: int) -> None:
    mesh = sphere(3)
    relit = relight_wavelets(mesh, factors(terms, kind))
    camera = observe_from(mesh, (1.4, 0.9, 2.0))
    pixels, expected, _ = per_fragment(relit, camera)
    assert len(pixels) > 2000
    close(draw(gl, relit, camera), pixels, expected)


@pytest.mark.parametrize("terms", [1, 3, 4, 9, MAX_TERMS + 1])
def test_maps_without_colour_are_packed_and_give_the_same(gl: Any, terms: int) -> None:
    coloured = factors(terms)
    maps = np.repeat(coloured.first[..., :1], 3, axis=-1)
    relit = relight_wavelets(sphere(3), SeparableFactors(coloured.hemisphere_map, "in-out", maps, maps, isotropic=True))
    camera = observe_from(relit.mesh, (1.4, 0.9, 2.0))
    if terms <= MAX_TERMS:
        pixels, expected, _ = per_fragment(relit, camera)
    else:
        image = drain(image_of(relit, camera, SIZE, 1)).image.reshape(-1, 4)
        pixels = np.flatnonzero(image[:, 3])
        expected = image[pixels, :3]
    close(draw(gl, relit, camera), pixels, expected)


@pytest.mark.parametrize("name", ["torus-knot", "blob"])
def test_radiance_at_vertices_is_spared_where_no_fragment_asks_for_it(name: str) -> None:
    """Beside vertices that are not marked, the mean of the tangents of a face is long whatever its weights."""
    mesh = shape(name)
    transport = relight_wavelets(mesh, factors(1)).transport
    spared = mesh.faces[~transport.turning[mesh.faces].all(axis=1)]
    weights = np.random.default_rng(0).dirichlet((0.5, 0.5, 0.5), len(spared))
    along = np.einsum("nk,nki->ni", weights, transport.frames[spared][..., 0])
    assert len(spared) > 0.9 * len(mesh.faces)
    assert np.sum(along**2, axis=1).min() > 0.93


def test_around_the_turn_of_frames_corners_are_mixed(gl: Any) -> None:
    mesh = sphere(3)
    relit = relight_wavelets(mesh, factors(4))
    camera = observe_from(mesh, (0.1, -2.4, 0.2))
    pixels, expected, share = per_fragment(relit, camera)
    assert 20 < np.count_nonzero(share < 0.5) < len(share) / 4
    close(draw(gl, relit, camera), pixels, expected)


def test_brushed_brdfs_use_the_frames_of_the_texture(gl: Any) -> None:
    mesh = shape("torus-knot")
    relit = relight_wavelets(mesh, factors(3, isotropic=False))
    camera = observe_from(mesh, (0.5, 0.7, 2.2))
    pixels, expected, _ = per_fragment(relit, camera)
    close(draw(gl, relit, camera), pixels, expected)


@pytest.mark.parametrize("terms", [MAX_TERMS + 1, 40])
def test_with_many_terms_the_image_is_the_processors(gl: Any, terms: int) -> None:
    mesh = sphere(2)
    relit = relight_wavelets(mesh, factors(terms), Ground(albedo=0.4, cells=5))
    camera = observe_from(relit.mesh, (0.5, 0.6, 1.2))
    expected = drain(image_of(relit, camera, SIZE, 1)).image
    pixels = np.flatnonzero(expected.reshape(-1, 4)[:, 3])
    close(draw(gl, relit, camera), pixels, expected.reshape(-1, 4)[pixels, :3])


def test_on_a_fine_mesh_both_paths_show_one_image(gl: Any) -> None:
    mesh = sphere(5)
    relit = relight_wavelets(mesh, factors(4, size=48), Ground(albedo=0.4))
    camera = observe_from(mesh, (0.8, 1.4, 3.0))
    expected = drain(image_of(relit, camera, SIZE, 1)).image
    found = draw(gl, relit, camera)
    both = (found[..., 3] == 1.0) & (expected[..., 3] == 1.0)
    error = np.sqrt(np.mean((found[both] - expected[both]) ** 2) / np.mean(expected[both] ** 2))
    assert both.mean() > 0.3
    assert error < 2e-3


def test_a_ground_shows_its_albedo_over_pi_times_its_light(gl: Any) -> None:
    mesh = sphere(1)
    relit = relight_wavelets(mesh, factors(2), Ground(albedo=0.4, cells=4, extent=8.0))
    rows = np.array(relit.rows)
    rows[2 * relit.flat_vertex :] = (1.0, 2.0, 3.0)
    below = float(relit.mesh.positions[relit.flat_vertex, 1])
    camera = Camera((5.0, below + 1.0, 0.0), (5.0, below, 0.01), fov_deg=20.0)
    image = draw(gl, RelightWavelets(relit.transport, rows), camera, (8, 6))
    np.testing.assert_allclose(
        image[..., :3], np.broadcast_to(np.array([1, 2, 3]) * 0.4 / math.pi, (6, 8, 3)), rtol=1e-5
    )


def test_sums_below_0_and_faces_from_behind_are_black(gl: Any) -> None:
    mesh = plane()
    relit = relight_wavelets(mesh, factors(1))
    dark = RelightWavelets(relit.transport, -np.abs(relit.rows))
    for what, eye in ((dark, (0.0, 0.0, 1.5)), (relit, (0.0, 0.0, -1.5))):
        image = draw(gl, what, Camera(eye, (0.0, 0.0, 0.0)))
        assert image[60, 80].tolist() == [0.0, 0.0, 0.0, 1.0]


def test_numbers_that_are_not_finite_are_refused_and_never_shown(gl: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    relit = relight_wavelets(sphere(1), factors(2))
    rows = np.array(relit.rows)
    rows[::3] = np.nan
    with pytest.raises(ValueError, match="not finite"):
        RelightWavelets(relit.transport, rows)
    monkeypatch.setattr("engine.transport.relight._check", lambda *_: None)
    renderer = TransportRenderer(gl, debug=True)
    image = renderer.radiance(RelightWavelets(relit.transport, rows), frame(relit.mesh.positions), SIZE, samples=1)
    assert renderer.invalid_samples > 0
    assert np.isfinite(image).all()
    renderer.release()


def test_another_light_or_bake_is_uploaded_and_nothing_stays_behind(gl: Any) -> None:
    mesh = sphere(2)
    camera = frame(mesh.positions)
    one, other = relight_wavelets(mesh, factors(2)), relight_wavelets(mesh, factors(3), Ground(cells=3))
    turned = RelightWavelets(one.transport, one.rows[::-1])
    renderer = TransportRenderer(gl)
    images = [renderer.radiance(relit, camera, SIZE, samples=1) for relit in (one, turned, other, one)]
    assert np.array_equal(images[0], images[3])
    assert not np.array_equal(images[0], images[1])
    renderer.release()
    left = living_objects()
    assert left.pop("Program") <= 1, "the one in use goes when another is used"
    assert left.pop("Shader") <= 2
    assert set(left.values()) == {0}
    again = renderer.radiance(turned, camera, SIZE, samples=1)
    assert np.array_equal(again, images[1])
    renderer.release()


def test_bands_are_the_image(gl: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.gl.tiles.TILE", 128)
    relit = relight_wavelets(sphere(2), factors(2))
    camera = frame(relit.mesh.positions)
    renderer, image = TransportRenderer(gl), Image(gl, SIZE)
    bands = renderer.bands(relit, camera, image.framebuffer, SIZE, samples=2)
    next(bands)
    with contextlib.suppress(StopIteration):
        while True:
            bands.send(37)
    np.testing.assert_allclose(image.read(), renderer.radiance(relit, camera, SIZE, samples=2), atol=1e-6)
    image.release()
    renderer.release()


def test_lights_of_more_vertices_than_fit_are_refused(gl: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    renderer = TransportRenderer(gl, texture_limits=cast(Any, drawing).Limits(16, 16))
    with pytest.raises(ValueError, match="more than the 256 that fit"):
        renderer._upload(relight_wavelets(sphere(3), factors(2)))
    renderer._upload(relight_wavelets(sphere(0), factors(2)))
    renderer.release()

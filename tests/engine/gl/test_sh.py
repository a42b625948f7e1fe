"""Transported spherical harmonics as the graphics device draws them, beside the table of the BRDF."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.directions import frames_along, normalize
from engine.core.steps import drain
from engine.geometry.camera import Camera, frame
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import shape
from engine.gl.transported import TransportRenderer
from engine.transport.relight import RelightSh, RelightWavelets
from engine.transport.sh.brdf_table import BrdfTable, lambert_table, tabulate
from engine.transport.sh.brdf_table_varying import Table, VariedTable
from engine.transport.sh.rotation import rotate_into_frames
from engine.transport.sh.transfer import ShTransport
from tests.engine.gl.relit_scenes import SIZE, factors, hits, local_views, relight_wavelets, sphere


def frames_of(mesh: Mesh) -> np.ndarray:
    return frames_along(normalize(mesh.normals), mesh.tangents)


def sky(order: int) -> np.ndarray:
    """(order², 3), bright enough everywhere that sums stay above 0."""
    light = np.random.default_rng(5).normal(size=(order**2, 3)) * 0.2
    light[0] = (3.0, 2.0, 2.5)
    return light


def compute_unshadowed(mesh: Mesh, table: Table, flat: int = 0) -> RelightSh:
    kept = len(mesh.positions) - flat
    light = rotate_into_frames(sky(table.order), frames_of(mesh))[:kept]
    return relight_by(mesh, table, light, np.random.default_rng(2).random((flat, 3)))


def relight_by(mesh: Mesh, table: Table, light: np.ndarray, flat: np.ndarray) -> RelightSh:
    """`light` (n, order², 3) at the first vertices and the radiance `flat` of the others."""
    rows = np.concatenate([light.reshape(-1, 3), flat])
    matrices = np.broadcast_to(np.float32(0.0), (len(rows), 1, table.order**2))
    return RelightSh(ShTransport(mesh, len(light), False, 1.0, table, False, matrices), rows)


def random_table(order: int, side: int | None) -> BrdfTable:
    """Smooth coefficients that no BRDF has to have; a map of `side` texels, or rows of an isotropic one."""
    rng = np.random.default_rng(1)
    place = np.linspace(0.0, 1.0, side or 64)
    waves = np.stack([np.ones_like(place), np.cos(3.0 * place), np.sin(2.0 * place)], axis=-1)
    if side is None:
        return BrdfTable(order, 1.0 + 0.2 * np.einsum("rw,wic->ric", waves, rng.normal(size=(3, order**2, 3))))
    values = np.einsum("rw,sv,wvic->rsic", waves, waves, rng.normal(size=(3, 3, order**2, 3)))
    return BrdfTable(order, 1.0 + 0.2 * values)


def make_varied_table(order: int, side: int | None, steps: tuple[int, ...], vertices: int) -> VariedTable:
    """Random tables, each with a brightness of its own, and vertices all over their grid, its corners included."""
    rng = np.random.default_rng(8)
    table = random_table(order, side)
    count = int(np.prod(steps))
    tables = tuple(BrdfTable(order, table.values * size) for size in rng.uniform(0.5, 2.0, count))
    numbers = rng.random((vertices, len(steps)))
    numbers[:2] = [[0.0] * len(steps), [1.0] * len(steps)]
    nodes = tuple(np.linspace(0.0, 1.0, some) ** 2 if some > 1 else np.zeros(1) for some in steps)
    return VariedTable(tables, nodes, numbers * [some > 1 for some in steps])


def expect(relit: RelightSh, camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """Pixels and their radiance: the mean of what the corners show, 0 at the least."""
    pixels, corners, weights = hits(relit.mesh, camera)
    views = local_views(relit.mesh, frames_of(relit.mesh), camera)[: relit.flat_vertex]
    light = relit.rows[: relit.flat_vertex * relit.table.order**2].reshape(relit.flat_vertex, relit.table.order**2, 3)
    at_vertices = np.concatenate([relit.table.radiance(light, views, np.arange(relit.flat_vertex)), relit.flat])
    return pixels, np.maximum(np.einsum("nk,nkc->nc", weights, at_vertices[corners]), 0.0)


def assert_drawn(gl: Any, relit: RelightSh, camera: Camera) -> None:
    renderer = TransportRenderer(gl, debug=True)
    image = renderer.radiance(relit, camera, SIZE, samples=1).reshape(-1, 4)
    assert renderer.invalid_samples == 0
    renderer.release()
    pixels, value = expect(relit, camera)
    assert len(pixels) > 1500
    found = image[pixels]
    covered = found[:, 3] == 1.0
    assert covered.mean() > 0.99
    error = np.abs(found[:, :3] - value).max(axis=1)[covered]
    assert np.mean(error < 1e-3 * value.mean()) > 0.995, np.sort(error / value.mean())[-20:]


@pytest.mark.parametrize("order", [1, 3, 5, 15])
@pytest.mark.parametrize("side", [None, 32])
def test_vertices_show_the_sum_over_the_table(gl: Any, order: int, side: int | None) -> None:
    relit = compute_unshadowed(sphere(3), random_table(order, side))
    assert_drawn(gl, relit, Camera((1.2, 0.8, 2.0), (0.0, 0.0, 0.0)))


@pytest.mark.parametrize("steps", [(1,), (4,), (3, 2), (2, 1), (1, 5)])
@pytest.mark.parametrize("side", [None, 32])
def test_vertices_mix_the_tables_about_their_place(gl: Any, steps: tuple[int, ...], side: int | None) -> None:
    mesh = sphere(3)
    for flat in (0, 100):
        table = make_varied_table(4, side, steps, len(mesh.positions) - flat)
        assert_drawn(gl, compute_unshadowed(mesh, table, flat), Camera((1.2, 0.8, 2.0), (0.0, 0.0, 0.0)))


@pytest.mark.parametrize("brdf", ["ggx:alpha=0.3", "ashikhmin-shirley:kd=0.5,ks=0.05,nu=10,nv=10"])
def test_brdfs_show_what_their_tables_say(gl: Any, brdf: str) -> None:
    mesh = shape("torus-knot")
    assert_drawn(gl, compute_unshadowed(mesh, drain(tabulate(brdf_from_text(brdf), 5))), frame(mesh.positions, 4 / 3))


def test_flat_vertices_show_their_own_radiance(gl: Any) -> None:
    mesh = sphere(3)
    table = lambert_table(brdf_from_text("lambert"), 5)  # type: ignore[arg-type]
    camera = Camera((1.2, 0.8, 2.0), (0.0, 0.0, 0.0))
    for flat in (len(mesh.positions), len(mesh.positions) // 2):
        assert_drawn(gl, compute_unshadowed(mesh, table, flat), camera)


def test_light_that_is_alike_everywhere_shows_the_albedo(gl: Any) -> None:
    """Lambert's radiance under a sky of 1 is its albedo at every pixel, whatever the frames."""
    mesh, table = shape("torus-knot"), lambert_table(brdf_from_text("lambert:albedo=0.3/0.6/0.9"), 5)  # type: ignore[arg-type]
    even = np.zeros((25, 3))
    even[0] = np.sqrt(4.0 * np.pi)
    light = rotate_into_frames(even, frames_of(mesh))
    renderer = TransportRenderer(gl)
    relit = relight_by(mesh, table, light, np.zeros((0, 3)))
    image = renderer.radiance(relit, frame(mesh.positions, 4 / 3), SIZE, samples=1)
    renderer.release()
    inside = image[..., 3] == 1.0
    lit_up = inside & (image[..., 0] > 0.0)  # what is seen from behind is black
    assert lit_up.sum() > 0.99 * inside.sum()
    np.testing.assert_allclose(image[lit_up][:, :3], np.broadcast_to((0.3, 0.6, 0.9), (lit_up.sum(), 3)), rtol=1e-4)


def test_one_renderer_takes_either_method_in_turn(gl: Any) -> None:
    mesh = sphere(2)
    camera = frame(mesh.positions)
    isotropic, map_ = compute_unshadowed(mesh, random_table(5, None)), compute_unshadowed(mesh, random_table(5, 16), 40)
    lights: list[RelightSh | RelightWavelets] = [isotropic, relight_wavelets(mesh, factors(2)), map_]
    renderer = TransportRenderer(gl)
    first = [renderer.radiance(relit, camera, SIZE, samples=1) for relit in lights]
    again = [renderer.radiance(relit, camera, SIZE, samples=1) for relit in lights]
    renderer.release()
    assert all(np.array_equal(one, other) for one, other in zip(first, again, strict=True))
    assert not any(np.array_equal(first[0], other) for other in first[1:])


def test_a_diffuse_model_shows_its_albedo_times_its_rows(gl: Any) -> None:
    """Rows of vectors are irradiance / π: the model has its table's albedo, the ground its own."""
    mesh = sphere(2)
    table = lambert_table(brdf_from_text("lambert:albedo=0.3/0.6/0.9"), 5)  # type: ignore[arg-type]
    vectors = np.broadcast_to(np.float32(0.0), (len(mesh.positions), 1, 25))
    for first, albedo in ((len(mesh.positions), (0.3, 0.6, 0.9)), (0, (0.4, 0.4, 0.4))):
        relit = RelightSh(ShTransport(mesh, first, True, 0.4, table, False, vectors), np.full((len(vectors), 3), 2.0))
        renderer = TransportRenderer(gl)
        image = renderer.radiance(relit, frame(mesh.positions), SIZE, samples=1)
        renderer.release()
        np.testing.assert_allclose(image[60, 80], (*(2.0 * np.array(albedo)), 1.0), rtol=1e-5)


def test_light_that_does_not_fit_its_vertices_is_refused() -> None:
    relit = compute_unshadowed(sphere(1), random_table(3, None))
    with pytest.raises(ValueError, match="rows has the shape"):
        RelightSh(relit.transport, relit.rows[1:])
    with pytest.raises(ValueError, match="not finite"):
        RelightSh(relit.transport, np.full_like(relit.rows, np.inf))

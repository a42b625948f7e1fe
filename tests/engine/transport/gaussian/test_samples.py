"""Tabulated transport: its integrals, what hides it, and light that comes by way of the model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.directions import normalize
from engine.core.steps import drain
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.light.cube_map import cube_directions, cube_solid_angles
from engine.transport.baking.diffuse_specular import parts
from engine.transport.baking.held_visibility import hold_visibility, merge_texels
from engine.transport.baking.spatially_varying import Variation
from engine.transport.baking.visibility import receivers, visibility_shares
from engine.transport.gaussian.fitting.views import VIEWS, view_directions
from engine.transport.gaussian.indirect import EDGE, arrivals, bin_values, indirect_samples, spread
from engine.transport.gaussian.sample_kernel import shares_along
from engine.transport.gaussian.samples import (
    GlossySurface,
    direct,
    direct_samples,
    draw,
    glossy_surface,
    transport_at,
)

BRDFS = (
    "ggx:kd=0.5,alpha=0.3,f0=0.04",
    "ggx:kd=0,alpha=0.03,f0=0.9/0.7/0.4",
    "ashikhmin-shirley:kd=0.5,ks=0.05,nu=10,nv=200",
    "metallic-roughness:metallic=0,roughness=0.4",
)


def sphere(rows: int = 7, radius: float = 1.0) -> Mesh:
    """A coarse sphere with its exact normals."""
    turns = 2 * rows
    theta, phi = np.pi * np.arange(1, rows + 1) / (rows + 1), 2.0 * np.pi * np.arange(turns) / turns
    ring = [[np.sin(t) * np.sin(p), np.cos(t), np.sin(t) * np.cos(p)] for t in theta for p in phi]
    places = np.array([[0.0, 1.0, 0.0], *ring, [0.0, -1.0, 0.0]])
    last, faces = 1 + (rows - 1) * turns, []
    for column in range(turns):
        beside = (column + 1) % turns
        faces += [(0, 1 + column, 1 + beside), (last + column, len(places) - 1, last + beside)]
        for row in range(rows - 1):
            a, b = 1 + row * turns + column, 1 + row * turns + beside
            faces += [(a, a + turns, b + turns), (a, b + turns, b)]
    uv = np.zeros((len(places), 2), np.float32)
    return Mesh(radius * places, places.astype(np.float32), uv, np.array(faces, np.int32), "ball")


def inside_another(small: Mesh) -> Mesh:
    """`small` and around it a closed sphere."""
    large = sphere(radius=3.0)
    return Mesh(
        np.concatenate([small.positions, large.positions]),
        np.concatenate([small.normals, large.normals]),
        np.concatenate([small.uv, large.uv]),
        np.concatenate([small.faces, large.faces + len(small.positions)]),
        "enclosed",
    )


def above(surface: GlossySurface, vertex: int) -> np.ndarray:
    views = view_directions()
    return views[views @ surface.frames[vertex, :, 2] > 0.15]


@pytest.mark.parametrize("text", BRDFS)
def test_sums_over_samples_are_integrals(text: str) -> None:
    brdf = brdf_from_text(text)
    surface = glossy_surface(sphere(), brdf)
    glossy = parts(brdf)[1]
    assert glossy is not None
    vertex, edge = 20, 256
    frame, views = surface.frames[vertex], above(surface, vertex)[::6]
    drawn = draw(surface, vertex, views, 512)
    wi = cube_directions(edge).reshape(-1, 3) @ frame
    area = np.tile(cube_solid_angles(edge).reshape(-1), 6)
    for view, values, weight in zip(views, drawn.value, drawn.weight, strict=True):
        exact = glossy.f(wi, np.broadcast_to(view @ frame, wi.shape)) * np.maximum(wi[:, 2:], 0.0)
        energy, square = area @ exact, area @ exact**2
        assert np.abs(weight @ values - energy).max() < 0.01 * energy.max()
        assert np.abs(weight @ values**2 - square).max() < 0.03 * square.max()
        assert weight.sum() == pytest.approx(4.0 * np.pi, rel=0.1)


def test_open_vertices_have_the_brdf_and_nothing_else() -> None:
    brdf = brdf_from_text(BRDFS[0])
    surface = glossy_surface(sphere(), brdf)
    assert surface.of.free.all()
    vertex = 33
    frame, view = surface.frames[vertex], above(surface, vertex)[2]
    drawn = direct(surface, vertex, view[None], 64)
    wi = drawn.direction[0] @ frame
    whole = brdf.f(wi, np.broadcast_to(view @ frame, wi.shape)) * np.maximum(wi[:, 2:], 0.0)
    diffuse = np.asarray(0.5 / np.pi * np.maximum(wi[:, 2:], 0.0))
    assert np.abs(drawn.value[0] + diffuse - whole).max() < 1e-12 * whole.max()
    assert np.abs(transport_at(surface, vertex, view, drawn.direction[0]) - drawn.value[0]).max() < 1e-12
    assert not transport_at(surface, vertex, -frame[:, 2], drawn.direction[0]).any()


def test_what_is_enclosed_gets_exactly_nothing() -> None:
    surface = glossy_surface(inside_another(sphere()), brdf_from_text(BRDFS[2]))
    vertices = np.array([0, 20, 60])
    samples = direct_samples(surface, vertices, 64)
    assert not samples.value.any()
    assert samples.area.sum() > 0.0
    assert len(indirect_samples(surface, vertices, 64).area) == 0


def test_views_below_the_horizon_have_no_samples() -> None:
    surface = glossy_surface(sphere(), brdf_from_text(BRDFS[0]))
    vertices = np.array([3, 40])
    samples = direct_samples(surface, vertices, 48)
    counts = np.diff(samples.start).reshape(2, VIEWS)
    facing = surface.frames[vertices, :, 2] @ view_directions().T > 0.0
    assert np.array_equal(counts, np.where(facing, 48, 0))


def test_a_ground_hides_what_lies_below_it() -> None:
    surface = glossy_surface(sphere(), brdf_from_text(BRDFS[1]), Ground(extent=50.0))
    vertex = 1 + 3 * 14  # on the equator
    assert not surface.of.free[vertex]
    views = above(surface, vertex)
    free, seen = draw(surface, vertex, views, 128), direct(surface, vertex, views, 128)
    down = free.direction[..., 1] < -0.03
    up = free.direction[..., 1] > 0.0
    assert not seen.value[down].any()
    assert np.array_equal(seen.value[up], free.value[up])


def test_a_lossless_model_on_white_ground_sends_back_all_light() -> None:
    """White furnace: under even light, direct and indirect transport together are the albedo of an open point."""
    surface = glossy_surface(sphere(), brdf_from_text("ggx:kd=0,alpha=0.05,f0=1"), Ground(albedo=1.0, extent=20.0))
    for vertex in (1 + 3 * 14, 1 + 5 * 14):
        views = above(surface, vertex)[::3]
        whole = draw(surface, vertex, views, 256)
        part = direct(surface, vertex, views, 256)
        found = arrivals(surface, vertex, views, 256, bounces=40)
        direct_energy = np.einsum("ms,msc->mc", part.weight, part.value)
        indirect = np.stack([np.bincount(found.view, found.value[:, k], len(views)) for k in range(3)], axis=-1)
        open_energy = np.einsum("ms,msc->mc", whole.weight, whole.value)
        assert (indirect.sum(axis=0) > 0.2).all()
        difference = direct_energy + indirect - open_energy
        assert np.abs(difference).max() < 0.06  # some 500 paths for a view
        assert np.abs(difference.mean()) < 0.01


def test_texels_hold_what_arrived() -> None:
    surface = glossy_surface(sphere(), brdf_from_text(BRDFS[2]), Ground(albedo=0.7))
    views = above(surface, 60)
    found = arrivals(surface, 60, views, 64)
    value = bin_values(found, len(views), EDGE)
    area = np.tile(cube_solid_angles(EDGE).reshape(-1), 6)
    assert np.einsum("mtc,t->c", value, area) == pytest.approx(found.value.sum(axis=0), rel=1e-12)
    wide = np.einsum("mtc,t->mc", spread(value), area)
    assert np.abs(wide - np.einsum("mtc,t->mc", value, area)).max() < 1e-12
    assert (spread(value).max(axis=(1, 2)) < value.max(axis=(1, 2)))[value.any(axis=(1, 2))].all()
    texel = cube_directions(EDGE).reshape(-1, 3)[value[found.view[0]].sum(axis=1).argmax()]
    assert (found.direction[found.view == found.view[0]] @ texel).max() > np.cos(np.radians(16.0))


def test_samples_depend_on_the_vertex_alone() -> None:
    varied = (Variation("alpha", 0.1, 0.6, "y"),)
    surface = glossy_surface(sphere(), brdf_from_text(BRDFS[0]), Ground(), varied)
    for of in (direct_samples, indirect_samples):
        alone, together = of(surface, np.array([44]), 32), of(surface, np.array([10, 44]), 32)
        assert np.array_equal(together.value[-len(alone.value) :], alone.value)
        assert np.array_equal(together.direction[-len(alone.value) :], alone.direction)


def test_parameters_move_from_vertex_to_vertex() -> None:
    surface = glossy_surface(sphere(), brdf_from_text(BRDFS[0]), None, (Variation("alpha", 0.1, 0.6, "y"),))
    top, bottom = surface.material_at(0).whole, surface.material_at(len(sphere().positions) - 1).whole
    assert (top.alpha, bottom.alpha) == pytest.approx((0.6, 0.1))  # type: ignore[attr-defined]
    kind, made = surface.coarse
    assert [material.whole.alpha for material in made] == sorted(material.whole.alpha for material in made)  # type: ignore[attr-defined]
    exact = np.array([surface.material_at(vertex).whole.alpha for vertex in range(len(kind))])  # type: ignore[attr-defined]
    rounded = np.array([made[number].whole.alpha for number in kind])
    assert np.abs(exact - rounded).max() <= 0.5 * 0.5 / 15 + 1e-12


def test_vertices_turned_inwards_see_nothing() -> None:
    mesh = sphere()
    surface = glossy_surface(replace(mesh, normals=-mesh.normals), brdf_from_text(BRDFS[0]))
    assert not surface.of.free.any()
    assert direct_samples(surface, np.array([20]), 64).value.sum() == 0.0


def held(surface: GlossySurface, vertices: np.ndarray, edge: int = 64) -> GlossySurface:
    return replace(surface, seen=drain(hold_visibility(surface.of, edge, 4, vertices)))


@pytest.mark.parametrize("text", BRDFS)
def test_a_table_gives_open_vertices_the_integrals_of_the_brdf(text: str) -> None:
    surface, vertices, count = glossy_surface(sphere(), brdf_from_text(text)), np.array([5, 40, 70]), 256
    samples = direct_samples(held(surface, vertices), vertices, count)
    drawn = direct_samples(surface, vertices, count)
    assert np.array_equal(samples.start, drawn.start)
    lit = samples.start[:-1][np.diff(samples.start) > 0]
    found, wanted = (np.add.reduceat(each.area[:, None] * each.value, lit) for each in (samples, drawn))
    assert np.abs(found - wanted).max() < 0.02 * wanted.max()
    assert np.abs(np.linalg.norm(samples.direction, axis=1) - 1.0).max() < 1e-12
    peaks = [each.direction[each.value[:, 0].argmax()] for each in (samples, drawn)]
    assert peaks[0] @ peaks[1] > np.cos(np.radians(3.0))


@pytest.mark.parametrize("text", [BRDFS[0], "ggx-anisotropic:kd=0.2,alpha_x=0.1,alpha_y=0.4"])
def test_held_visibility_hides_what_rays_hide(text: str) -> None:
    """But for texels at the border, whose share they get; on a ground the horizontal texels are halves."""
    surface = glossy_surface(sphere(), brdf_from_text(text), Ground(extent=50.0))
    vertices = np.array([1 + 3 * 14, 1 + 5 * 14])
    samples, drawn = (direct_samples(each, vertices, 128) for each in (held(surface, vertices), surface))
    below, over = samples.direction[:, 1] < -0.06, samples.direction[:, 1] > 0.03
    assert not samples.value[below].any()
    lit = samples.start[:-1][np.diff(samples.start) > 0]
    found, wanted = (np.add.reduceat(each.area[:, None] * each.value, lit) for each in (samples, drawn))
    assert np.abs(found - wanted).max() < 0.05 * wanted.max()
    free = replace(surface, of=replace(surface.of, free=np.ones_like(surface.of.free)))
    assert np.array_equal(samples.value[over], direct_samples(held(free, vertices), vertices, 128).value[over])


def test_parts_of_a_texel_below_the_horizon_are_not_shadows() -> None:
    """A free vertex sees all of each texel that is above its horizon, also where only a part is."""
    surface = glossy_surface(sphere(), brdf_from_text(BRDFS[0]))
    vertex = 40
    counts = held(surface, np.array([vertex]), 8).seen.counts(np.array([vertex]))[0]  # type: ignore[union-attr]
    normal = np.ascontiguousarray(surface.frames[vertex, :, 2])
    directions = normalize(np.random.default_rng(3).standard_normal((4000, 3)))
    shares = np.empty(len(directions))
    shares_along(directions, normal, counts, 8, 4, shares)
    height = directions @ normal
    assert (shares[height > 0.12] == 1.0).all()
    assert not shares[height < -0.4].any()
    near = (height > 0.0) & (height < 0.12)
    assert (shares[near] == 1.0).mean() > 0.9  # others lie in a texel whose parts' middles are all below


def test_held_visibility_is_that_of_rays_in_any_order() -> None:
    of = receivers(inside_another(sphere()))
    vertices = np.array([0, 7, 20, 150])
    seen = drain(hold_visibility(of, 8, 4, vertices))
    known = np.concatenate([counts for _, counts in visibility_shares(of, 8, 4, vertices)])
    assert np.array_equal(seen.counts(vertices[::-1]), known[::-1])
    sums = merge_texels(known, 8).reshape(-1, 6, 4, 4)
    assert sums[3, 2, 1, 3] == known.reshape(-1, 6, 8, 8)[3, 2, 2:4, 6:8].sum()

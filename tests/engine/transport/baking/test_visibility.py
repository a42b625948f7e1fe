"""Visibility from vertices: convex meshes, horizons known in closed form, scales, grazing rays, touching surfaces."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from engine.core.directions import normalize
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import RayCaster, offset_origins
from engine.geometry.shapes import shape
from engine.light.cube_map import cube_directions, cube_solid_angles
from engine.transport.baking import visibility
from engine.transport.baking.visibility import (
    Receivers,
    chunk_bytes,
    miss_rate,
    occlusion,
    receivers,
    visibility_cube,
    visibility_shares,
)


def mesh_of(positions: ArrayLike, faces: ArrayLike, normals: ArrayLike) -> Mesh:
    positions = np.array(positions, np.float64)
    normals = np.array(np.broadcast_to(normals, positions.shape), np.float32)
    return Mesh(positions, normals, np.zeros((len(positions), 2), np.float32), np.array(faces, np.int32), "test")


def bumpy_sphere(bumps: float = 0.2) -> Mesh:
    mesh = shape("sphere")
    x, y, z = mesh.positions.T
    radius = 1.0 + bumps * np.sin(7 * x) * np.sin(5 * y + 1) * np.sin(6 * z + 2)
    seam = np.round(mesh.positions, 12)
    place = np.unique(seam, axis=0, return_index=True, return_inverse=True)
    positions = (radius[:, None] * mesh.positions)[place[1]][place[2].reshape(-1)]
    return mesh_of(positions, mesh.faces, mesh.normals)


def join(*meshes: Mesh) -> Mesh:
    first = np.cumsum([0] + [len(mesh.positions) for mesh in meshes])
    return mesh_of(
        np.concatenate([mesh.positions for mesh in meshes]),
        np.concatenate([mesh.faces + start for mesh, start in zip(meshes, first, strict=False)]),
        np.concatenate([mesh.normals for mesh in meshes]),
    )


def square(centre: ArrayLike, across: Any, up: Any, cells: int = 4) -> Mesh:
    """A square about `centre` from −1 to 1 along two axes, facing across × up."""
    side = np.linspace(-1.0, 1.0, cells + 1)
    v, u = np.meshgrid(side, side, indexing="ij")
    positions = np.asarray(centre) + u[..., None] * np.asarray(across) + v[..., None] * np.asarray(up)
    index = np.arange((cells + 1) ** 2).reshape(cells + 1, -1)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    faces = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], 2).reshape(-1, 3)
    return mesh_of(positions.reshape(-1, 3), faces, normalize(np.cross(across, up)))


def box(cells: int = 4) -> Mesh:
    """The cube from −1 to 1 with a normal of its own on each side: corners have three vertices."""
    axes = np.eye(3)
    sides = [(sign * axes[k], axes[(k + 1) % 3], sign * axes[(k + 2) % 3]) for k in range(3) for sign in (1, -1)]
    return join(*(square(*side, cells) for side in sides))


def bits_of(of: Receivers, edge: int, vertices: ArrayLike | None = None, *, skip: bool = True) -> NDArray[np.bool_]:
    vertices = None if vertices is None else np.asarray(vertices)
    packed = np.concatenate([bits for _, bits in visibility_cube(of, edge, vertices, skip=skip)])
    return np.unpackbits(packed, axis=1, count=6 * edge * edge).astype(bool)


def above(of: Receivers, edge: int) -> NDArray[np.bool_]:
    return of.normal @ cube_directions(edge).reshape(-1, 3).T > 0.0


def part_of(of: Receivers, vertices: NDArray[np.int64]) -> Receivers:
    return Receivers(of.caster, of.origin[vertices], of.normal[vertices], of.free[vertices])


def place(mesh: Mesh, position: ArrayLike, normal: ArrayLike) -> Receivers:
    """One receiver that is no vertex of `mesh`."""
    caster = RayCaster(mesh.positions, mesh.faces)
    return Receivers(caster, np.array([position], float), np.array([normal], float), np.zeros(1, bool))


def test_V1_a_closed_bumpy_sphere_lets_no_ray_out() -> None:
    assert miss_rate(bumpy_sphere(), rays=200_000) <= 2e-5
    caster = RayCaster(bumpy_sphere().positions, bumpy_sphere().faces)
    rng = np.random.default_rng(1)
    corner = caster.positions[caster.faces]
    between = corner[:, 0] + rng.random((len(corner), 1)) * (corner[:, 1] - corner[:, 0])
    aimed = np.concatenate([caster.positions, between, rng.normal(size=(100_000, 3))])
    origin = np.array([0.013, 0.027, -0.031]) * np.ones_like(aimed)
    assert np.mean(~caster.occluded(origin, aimed - origin)) <= 2e-5


def test_V1_open_meshes_have_no_miss_rate() -> None:
    with pytest.raises(ValueError, match="open edges"):
        miss_rate(shape("plane"))


def test_V2_convex_mesh_is_not_occluded() -> None:
    """From every vertex, and from a million points of faces, towards everything above the horizon."""
    for mesh in (shape("sphere"), box(12)):
        of = receivers(mesh)
        assert (occlusion(mesh, of=of, skip=False) == 1.0).all()
        rng = np.random.default_rng(2)
        face = rng.integers(len(mesh.faces), size=500_000)
        a, b, c = (mesh.positions[mesh.faces[face, corner]] for corner in range(3))
        normal = normalize(np.cross(b - a, c - a))
        share = rng.dirichlet((1, 1, 1), len(face))
        point = share[:, :1] * a + share[:, 1:2] * b + share[:, 2:] * c
        direction = normalize(rng.normal(size=point.shape))
        direction *= np.sign(np.einsum("ni,ni->n", direction, normal))[:, None]
        assert not of.caster.occluded(offset_origins(point, normal, of.caster), direction).any()


def test_T1_skipping_a_convex_mesh_changes_no_bit() -> None:
    for mesh in (box(), shape("sphere")):
        of = receivers(mesh)
        assert of.free.all()
        vertices = np.arange(0, len(of), max(1, len(of) // 25))
        np.testing.assert_array_equal(bits_of(of, 16, vertices), bits_of(of, 16, vertices, skip=False))
        np.testing.assert_array_equal(bits_of(of, 16, vertices), above(of, 16)[vertices])
        some = part_of(of, vertices)
        np.testing.assert_array_equal(occlusion(mesh, of=some), occlusion(mesh, of=some, skip=False))


def test_free_vertices_are_those_with_nothing_above() -> None:
    """Against every vertex of the mesh, one by one."""
    for mesh in (
        bumpy_sphere(0.02),
        shape("torus-knot"),
        shape("plane"),
        join(box(), square((0, 0, 1.5), (1, 0, 0), (0, 1, 0))),
    ):
        of = receivers(mesh)
        vertices = np.arange(0, len(of), max(1, len(of) // 500))
        height = of.normal[vertices] @ mesh.positions.T
        rise = height.max(axis=1) - np.einsum("vi,vi->v", of.normal[vertices], mesh.positions[vertices])
        np.testing.assert_array_equal(of.free[vertices], rise <= visibility.RISE * of.caster.offset)
    assert 0.0 < of.free.mean() < 1.0


@pytest.mark.parametrize("scale", [1e-6, 2.0**-10, 1e-3, 2.0**10, 1e3, 1e6])
def test_V3_visibility_does_not_depend_on_the_scale(scale: float) -> None:
    mesh = shape("torus-knot")
    vertices = np.arange(0, len(mesh.positions), 1500)
    plain = bits_of(receivers(mesh), 32, vertices)
    scaled = bits_of(receivers(mesh_of(mesh.positions * scale, mesh.faces, mesh.normals)), 32, vertices)
    assert 0.1 < plain.mean() < 0.45
    if np.log2(scale) % 1.0 == 0.0:
        np.testing.assert_array_equal(scaled, plain)
    assert np.mean(scaled != plain) <= 1e-3


def test_V3_visibility_does_not_depend_on_the_place() -> None:
    mesh = shape("torus-knot")
    vertices = np.arange(0, len(mesh.positions), 1500)
    plain = bits_of(receivers(mesh), 32, vertices)
    moved = bits_of(
        receivers(mesh_of(mesh.positions + np.array([2e5, -1e5, 3e5]), mesh.faces, mesh.normals)), 32, vertices
    )
    assert np.mean(moved != plain) <= 1e-3
    sphere = shape("sphere")
    far = mesh_of(sphere.positions + 2e5, sphere.faces, sphere.normals)
    assert (occlusion(far, skip=False) == 1.0).all()


def test_V4_grazing_rays_neither_hit_their_face_nor_miss_what_rises() -> None:
    """Directions 1e-7 above and below the plane of a floor, on which a wall stands."""
    floor = square((0, 0, 0), (1, 0, 0), (0, 1, 0))
    wall = square((1, 0, 0.5), (0, 1, 0), (0, 0, 0.5))
    mesh = join(floor, wall)
    caster = RayCaster(mesh.positions, mesh.faces)
    azimuth = np.linspace(0.0, 2.0 * np.pi, 1000, endpoint=False) + 1e-3
    origin = offset_origins(np.zeros((1000, 3)), np.tile((0.0, 0.0, 1.0), (1000, 1)), caster)
    for height in (1e-7, 0.0, -1e-7):
        direction = np.stack([np.cos(azimuth), np.sin(azimuth), np.full(1000, height)], -1)
        towards_wall = np.abs(np.tan(azimuth)) < 1.0
        meets = towards_wall & (np.cos(azimuth) > 0.0)
        np.testing.assert_array_equal(caster.occluded(origin, direction), meets)


def test_V5_touching_and_coincident_surfaces_give_the_same_answer_each_time() -> None:
    ground = square((0, 0, -1), (3, 0, 0), (0, 3, 0))
    fighting = square((0, 0, -1 + 1e-9), (2, 0, 0), (0, 2, 0))
    mesh = join(box(), ground, fighting, ground)
    first = bits_of(receivers(mesh), 16)
    for _ in range(3):
        np.testing.assert_array_equal(bits_of(receivers(mesh), 16), first)
    above_ground = len(box().positions) + len(ground.positions)
    assert first[:above_ground].any()


def test_a_corner_of_a_room_neither_leaks_nor_hides_itself() -> None:
    """Three walls meet at a vertex of each: from there, exactly the octant between them is visible."""
    room = join(
        square((1, 1, 0), (1, 0, 0), (0, 1, 0)),
        square((0, 1, 1), (0, 1, 0), (0, 0, 1)),
        square((1, 0, 1), (0, 0, 1), (1, 0, 0)),
    )
    corners = np.flatnonzero((room.positions == 0.0).all(axis=1))
    assert len(corners) == 3
    seen = bits_of(receivers(room), 16, corners)
    octant = (cube_directions(16).reshape(-1, 3) > 0.0).all(axis=1)
    np.testing.assert_array_equal(seen, np.tile(octant, (3, 1)))


def test_a_narrow_groove_opens_only_upwards() -> None:
    """Two slopes that meet at 2 · 15 degrees; each vertex of the bottom has the normal of its slope."""
    lean = np.radians(15.0)
    right = square((np.sin(lean), 0, np.cos(lean)), (0, -50, 0), (np.sin(lean), 0, np.cos(lean)))
    left = square((-np.sin(lean), 0, np.cos(lean)), (0, 50, 0), (-np.sin(lean), 0, np.cos(lean)))
    groove = join(left, right)
    bottom = np.flatnonzero((np.abs(groove.positions[:, ::2]) < 1e-12).all(axis=1) & (groove.positions[:, 1] == 0.0))
    assert len(bottom) == 2
    directions = cube_directions(32).reshape(-1, 3)
    angle = np.abs(np.arctan2(directions[:, 0], directions[:, 2]))
    clear = np.abs(directions[:, 1]) < 0.9
    seen = bits_of(receivers(groove), 32, bottom)
    texel = 2.0 / 32
    assert seen[:, clear & (angle < lean - texel)].all()
    assert not seen[:, clear & (angle > lean + texel)].any()


def test_a_sheet_of_two_sides_sees_both_sides() -> None:
    """Faces of both sides share their places; each side's vertices see its own half of the sphere."""
    sheet = join(square((0, 0, 0), (1, 0, 0), (0, 1, 0)), square((0, 0, 0), (0, 1, 0), (1, 0, 0)))
    of = receivers(sheet)
    np.testing.assert_array_equal(bits_of(of, 16, skip=False), above(of, 16))


def test_V10_half_of_the_sphere_is_hidden_by_a_plane() -> None:
    plane = square((0, 0, 0), (1e4, 0, 0), (0, 1e4, 0), cells=1)
    for edge in (16, 64):
        upright = place(plane, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
        share = bits_of(upright, edge).reshape(6, edge, edge) * cube_solid_angles(edge) / (2.0 * np.pi)
        assert abs(share.sum() - 0.5) <= 1.0 / edge


@pytest.mark.parametrize("sides", [3, 4, 7, 24])
def test_V10_the_horizon_of_a_well_is_where_its_walls_end(sides: int) -> None:
    """From the middle of the bottom of a prism with inner radius 1 and height 1.2 the horizon is atan(1.2 cos φ)."""
    edge, height = 64, 1.2
    azimuth = 2.0 * np.pi * np.arange(sides) / sides
    radius = 1.0 / np.cos(np.pi / sides)
    ring = np.stack([radius * np.cos(azimuth), np.zeros(sides), radius * np.sin(azimuth)], -1)
    index = np.arange(sides)
    after = (index + 1) % sides
    faces = np.concatenate(
        [np.stack([index, after, after + sides], -1), np.stack([index, after + sides, index + sides], -1)]
    )
    well = mesh_of(np.concatenate([ring, ring + np.array([0, height, 0])]), faces, (0.0, 1.0, 0.0))
    seen = bits_of(place(well, (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)), edge)[0]
    directions = cube_directions(edge).reshape(-1, 3)
    around = (np.arctan2(directions[:, 2], directions[:, 0]) - np.pi / sides + np.pi / sides) % (2.0 * np.pi / sides)
    horizon = np.arctan(height * np.cos(around - np.pi / sides))
    elevation = np.arcsin(directions[:, 1])
    texel = np.sqrt(2.0) * 2.0 / edge
    assert seen[elevation > horizon + texel].all()
    assert not seen[elevation < horizon - texel].any()


def test_V11_shares_are_exact_means_of_the_finer_map() -> None:
    mesh = shape("torus-knot")
    of = receivers(mesh)
    vertices = np.arange(0, len(of), 5000)
    fine = bits_of(of, 64, vertices).reshape(-1, 6, 16, 4, 16, 4).sum(axis=(3, 5)).reshape(len(vertices), -1)
    counts = np.concatenate([counts for _, counts in visibility_shares(of, 16, 4, vertices)])
    coarse = np.concatenate([counts for _, counts in visibility_shares(of, 16, 1, vertices)])
    beside = visibility._neighbours(16)
    partial = (coarse[:, beside] != coarse[..., None]).any(axis=-1)
    between = partial & (counts > 0) & (counts < 16)
    assert np.mean(between) > 0.02
    np.testing.assert_array_equal(counts[between], fine[between])
    assert np.mean(counts != fine) < 0.01
    whole = np.concatenate([counts for _, counts in visibility_shares(of, 16, 4, vertices, skip=False)])
    np.testing.assert_array_equal(whole, counts)


def test_neighbours_of_texels_lie_beside_them() -> None:
    for edge in (1, 2, 5, 16):
        directions = cube_directions(edge).reshape(-1, 3)
        beside = visibility._neighbours(edge)
        assert beside.shape == (6 * edge * edge, 4)
        assert (np.sort(beside, axis=1)[:, 1:] != np.sort(beside, axis=1)[:, :-1]).all()
        cosine = np.einsum("ti,tki->tk", directions, directions[beside])
        assert np.arccos(np.clip(cosine, -1, 1)).max() <= 2.0 / edge + 1e-9
        back = (beside[beside] == np.arange(6 * edge * edge)[:, None, None]).any(axis=-1)
        assert back.all()


def test_the_answer_does_not_depend_on_chunks_or_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = shape("torus-knot")
    of = receivers(mesh)
    vertices = np.arange(0, len(of), 2000)

    def answers() -> Iterator[NDArray]:
        yield bits_of(of, 16, vertices)
        yield np.concatenate([counts for _, counts in visibility_shares(of, 16, 3, vertices)])
        yield occlusion(mesh, 16, of=of)

    before = list(answers())
    monkeypatch.setattr(visibility, "TEXELS", 3 * 6 * 16 * 16)
    monkeypatch.setattr(visibility, "CHUNK", 5000)
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    for one, other in zip(before, answers(), strict=True):
        np.testing.assert_array_equal(one, other)
    backwards = bits_of(of, 16, vertices[::-1])
    np.testing.assert_array_equal(backwards[::-1], before[0])


def test_occlusion_is_the_cosine_weighted_open_share() -> None:
    """Half a wall: seen from its foot, a wall without end hides half of the sky; against the cube map elsewhere."""
    mesh = join(square((0, 0, 0), (1, 0, 0), (0, 1, 0), 8), square((0, 0, 500), (0, 500, 0), (0, 0, 500)))
    foot = np.flatnonzero((mesh.positions == 0.0).all(axis=1))[:1]
    assert abs(occlusion(mesh, 1024)[foot[0]] - 0.5) < 0.02
    knot = shape("torus-knot")
    of = receivers(knot)
    vertices = np.arange(0, len(of), 4000)
    weight = np.maximum(of.normal[vertices] @ cube_directions(64).reshape(-1, 3).T, 0.0) * np.tile(
        cube_solid_angles(64).ravel(), 6
    )
    expected = (bits_of(of, 64, vertices) * weight).sum(axis=1) / np.pi
    some = part_of(of, vertices)
    np.testing.assert_allclose(occlusion(knot, 1024, of=some), expected, atol=0.02)
    np.testing.assert_allclose(occlusion(knot, of=some), expected, atol=0.1)


def test_shares_need_a_number_of_parts_that_a_byte_holds() -> None:
    of = receivers(shape("plane"))
    with pytest.raises(ValueError, match="1 to 15"):
        next(visibility_shares(of, 4, 16))
    assert chunk_bytes(64) > 6 * 64 * 64

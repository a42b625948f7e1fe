"""Connectivity of faces: closed forms on solids, the rules V6 to V9, and brute force on random meshes."""

from __future__ import annotations

from collections import Counter
from typing import Any, cast

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.core.errors import InputError
from engine.geometry import mesh_repair
from engine.geometry.mesh import complete
from engine.geometry.mesh_repair import INSIDE_OUT, Topology, equal_rows, merge_points, topology, with_count

SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])


def make(mesh: trimesh.Trimesh) -> Topology:
    return topology(np.array(mesh.vertices), np.array(mesh.faces, np.int64))


@pytest.mark.parametrize(
    ("solid", "convex", "volume"),
    [
        (trimesh.creation.box((1, 2, 3)), True, 6.0),
        (trimesh.creation.icosphere(3), True, None),
        (trimesh.creation.torus(2.0, 0.5), False, None),
        (trimesh.creation.annulus(1.0, 2.0, 1.0), False, None),
    ],
)
@pytest.mark.parametrize(("scale", "shift"), [(1.0, 0.0), (1e-6, 0.0), (1e6, 0.0), (1.0, 1e5)])
def test_V8_solids_are_closed_and_their_volume_is_known(
    solid: trimesh.Trimesh, convex: bool, volume: float | None, scale: float, shift: float
) -> None:
    found = topology(np.array(solid.vertices) * scale + shift, np.array(solid.faces, np.int64))
    assert (found.closed, found.convex, found.components, found.inside_out) == (True, convex, 1, 0)
    assert found.volume == pytest.approx((volume or solid.volume) * scale**3, rel=1e-6)
    assert found.open_edges == found.crowded_edges == found.clashing_edges == found.junctions == 0
    assert found.findings == ()


@pytest.mark.parametrize(
    ("text", "one"),
    [
        ("edges have faces that are turned against each other", "1 edge has faces that are turned against each other"),
        ("repeated faces excluded", "1 repeated face excluded"),
        ("points lie within edges of other faces", "1 point lies within edges of other faces"),
        ("normals were none and taken from the faces", "1 normal was none and taken from the faces"),
    ],
)
def test_one_is_not_spoken_of_as_many(text: str, one: str) -> None:
    assert with_count(1, text) == one
    assert with_count(2, text) == f"2 {text}"


def test_a_star_that_winds_twice_about_its_axis_is_not_convex() -> None:
    angle = 2 * np.pi * 2 / 5 * np.arange(5)
    points = np.concatenate([np.stack([np.cos(angle), np.sin(angle), 0 * angle], -1), [[0, 0, 3], [0, 0, -3.0]]])
    around = np.arange(5)
    above = np.stack([around, (around + 1) % 5, np.full(5, 5)], -1)
    below = np.stack([(around + 1) % 5, around, np.full(5, 6)], -1)
    found = topology(points, np.concatenate([above, below]))
    assert (found.closed, found.components, found.convex) == (True, 1, False)


def test_V8_a_surface_that_is_inside_out_is_noticed_and_can_be_flipped() -> None:
    box = trimesh.creation.box()
    found = topology(np.array(box.vertices), np.array(box.faces[:, ::-1], np.int64))
    assert found.volume == pytest.approx(-1.0)
    assert (found.closed, found.convex, found.inside_out) == (True, False, 1)
    assert [finding.text for finding in found.findings] == [INSIDE_OUT]


def test_V8_the_hollow_of_a_thick_wall_is_right_as_it_is() -> None:
    outer, inner = trimesh.creation.icosphere(2, radius=2.0), trimesh.creation.icosphere(2, radius=1.0)
    inner.invert()
    found = make(trimesh.util.concatenate([outer, inner]))
    assert (found.closed, found.components, found.inside_out) == (True, 2, 1)
    assert found.findings == ()


def test_V7_open_crowded_and_clashing_edges_are_counted_and_said() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]])
    three_on_one_edge = np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    found = topology(points, three_on_one_edge)
    assert (found.open_edges, found.crowded_edges, found.clashing_edges) == (6, 1, 0)
    found = topology(points, np.array([[0, 1, 2], [0, 1, 3]]))
    assert (found.open_edges, found.crowded_edges, found.clashing_edges) == (4, 0, 1)
    assert [finding.text.split()[0] for finding in found.findings] == ["4", "1"]
    assert not found.closed


def test_V7_points_within_open_edges_of_others_are_found() -> None:
    points = np.array([[0.0, 0, 0], [2, 0, 0], [1, 2, 0], [1, 0, 0], [0.5, -1, 0], [1.5, -1, 0]])
    assert topology(points, np.array([[0, 1, 2], [3, 0, 4], [1, 3, 5]])).junctions == 1
    points[3, 1] = -0.01
    assert topology(points, np.array([[0, 1, 2], [3, 0, 4], [1, 3, 5]])).junctions == 0


def test_V7_opposite_faces_at_the_same_place_keep_a_normal_each() -> None:
    arrays = complete(SQUARE, np.array([[0, 1, 2], [0, 2, 1]]), None, None, "sheet")
    assert len(arrays["faces"]) == 2
    assert np.linalg.norm(arrays["normals"], axis=1) == pytest.approx(np.ones(6))
    a, b, c = (arrays["positions"][arrays["faces"][:, corner]] for corner in range(3))
    flat = np.cross(b - a, c - a)
    assert np.all(np.einsum("fi,fci->fc", flat, arrays["normals"][arrays["faces"]]) > 0)


def test_V6_vertices_at_one_place_become_one_and_idle_ones_are_dropped() -> None:
    positions = np.concatenate([SQUARE, SQUARE * 1.0, [[7.0, 7, 7]]])
    arrays = complete(positions, np.array([[0, 1, 2], [4, 6, 7]]), None, None, "square")
    assert len(arrays["positions"]) == 4
    assert arrays["figures"]["vertices_without_faces_dropped"] == 3
    assert arrays["figures"]["vertices_at_the_same_place"] == 2
    assert arrays["figures"]["open_edges"] == 4


def test_V9_one_triangle_is_a_mesh_and_no_face_is_none() -> None:
    arrays = complete(SQUARE[:3], np.array([[0, 1, 2]]), None, None, "one")
    assert (len(arrays["faces"]), arrays["figures"]["open_edges"]) == (1, 3)
    with pytest.raises(InputError, match="no usable triangle"):
        complete(SQUARE[:1], np.array([[0, 0, 0]]), None, None, "point")


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(3, 12), st.integers(1, 30))
def test_counts_are_those_of_brute_force(seed: int, points: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    faces = np.stack([rng.permutation(points)[:3] for _ in range(count)])
    found = topology(rng.normal(size=(points, 3)), faces)
    edges = Counter(frozenset((f[k], f[(k + 1) % 3])) for f in faces.tolist() for k in range(3))
    directed = Counter((f[k], f[(k + 1) % 3]) for f in faces.tolist() for k in range(3))
    assert found.open_edges == sum(number == 1 for number in edges.values())
    assert found.crowded_edges == sum(number > 2 for number in edges.values())
    twice = [edge for edge, number in edges.items() if number == 2]
    assert found.clashing_edges == sum(2 in (directed[tuple(edge)], directed[tuple(edge)[::-1]]) for edge in twice)
    parts = {vertex: vertex for vertex in range(points)}

    def root(vertex: int) -> int:
        return vertex if parts[vertex] == vertex else root(parts[vertex])

    for a, b, c in faces.tolist():
        parts[root(b)] = parts[root(c)] = root(a)
    assert found.components == len({root(vertex) for vertex in faces.ravel().tolist()})


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(0, 60), st.integers(1, 4))
def test_equal_rows_are_found_as_numpy_finds_them(seed: int, rows: int, columns: int) -> None:
    table = np.random.default_rng(seed).integers(-1, 2, (rows, columns)) * 0.1
    first, index = equal_rows(cast(Any, table))
    assert np.array_equal(table[first][index], table)
    assert len(first) == len(np.unique(table, axis=0))
    assert np.all(np.diff(first) > 0)


def test_places_do_not_depend_on_the_sign_of_zero() -> None:
    points, place = merge_points(np.array([[0.0, 1, 0], [-0.0, 1, -0.0], [np.nan, 1, 0]]))
    assert len(points) == 1
    assert place.tolist() == [0, 0, 0]


@pytest.mark.parametrize("many", [0, 1 << 16])
def test_equal_rows_are_those_of_a_search(many: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """By sorting and by the table of hashes: sets in the order of their first rows; −0 is 0."""
    monkeypatch.setattr(mesh_repair, "MANY_ROWS", many)
    random = np.random.default_rng(4)
    for count in (1, 7, 1000):
        rows = random.integers(-2, 3, (count, 3)) * np.array([0.5, -1.0, 1e-300])
        first, index = mesh_repair.equal_rows(rows)
        known: dict[tuple[float, ...], int] = {}
        wanted = [known.setdefault(tuple(row), len(known)) for row in (rows + 0.0).tolist()]
        assert index.tolist() == wanted
        assert first.tolist() == [wanted.index(at) for at in range(len(known))]

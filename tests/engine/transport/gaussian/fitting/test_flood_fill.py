"""The order of a flood fill: every vertex once, each beside one that is done."""

from __future__ import annotations

import numpy as np
import pytest

from engine.geometry.mesh import Mesh
from engine.geometry.shapes import shape
from engine.transport.gaussian.fitting.flood_fill import flood


def grid(size: int, offset: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    y, x = np.mgrid[:size, :size]
    positions = np.stack([x + offset, y, 0 * x], axis=-1).reshape(-1, 3).astype(np.float64)
    at = np.arange(size * size).reshape(size, size)
    a, b, c, d = (part.ravel() for part in (at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]))
    return positions, np.concatenate([np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)])


def mesh_of(*parts: tuple[np.ndarray, np.ndarray]) -> Mesh:
    starts = np.cumsum([0, *(len(positions) for positions, _ in parts)])
    positions = np.concatenate([positions for positions, _ in parts])
    faces = np.concatenate([faces + start for (_, faces), start in zip(parts, starts, strict=False)]).astype(np.int32)
    normals = np.broadcast_to(np.array([0, 0, 1], np.float32), positions.shape).copy()
    return Mesh(positions, normals, np.zeros((len(positions), 2), np.float32), faces, "grids")


def test_G16_the_flood_visits_every_component() -> None:
    lone = np.array([[50.0, 0.0, 0.0]]), np.zeros((0, 3), np.int64)
    mesh = mesh_of(grid(5), grid(7, 10.0), lone, grid(3, 30.0))
    order = flood(mesh)
    assert order.components == 4
    assert np.array_equal(np.sort(np.concatenate(order.fronts)), np.arange(len(mesh.positions)))
    assert order.fronts[0].tolist() == [0, 25, 74, 75]  # the lowest of each part


@pytest.mark.parametrize("name", ["sphere", "torus-knot"])
def test_every_vertex_is_reached_from_the_front_before(name: str) -> None:
    order = flood(shape(name))
    for number, front in enumerate(order.fronts):
        assert (order.front_of[front] == number).all()
        for vertex in front[:20]:
            around = order.front_of[order.neighbours(int(vertex))]
            assert np.abs(around - number).max() <= 1  # edges never skip a front
            assert number == 0 or (around == number - 1).any()


def test_neighbours_are_those_of_the_faces_both_ways() -> None:
    positions, faces = grid(4)
    order = flood(mesh_of((positions, faces)))
    joined = np.zeros((16, 16), bool)
    for a, b, c in faces:
        joined[[a, b, b, c, c, a], [b, a, c, b, a, c]] = True
    for vertex in range(16):
        assert order.neighbours(vertex).tolist() == np.flatnonzero(joined[vertex]).tolist()


def test_a_seam_is_crossed_and_a_ground_is_left_out() -> None:
    left, right = grid(3), grid(3, 2.0)  # they meet at x = 2 without sharing a vertex
    assert flood(mesh_of(left, right)).components == 1
    both = mesh_of(grid(3), grid(4, 20.0))
    own = flood(both, 9)
    assert own.components == 1
    assert len(own.front_of) == 9

"""The built-in models: what shape they are, and that their surfaces hang together."""

from __future__ import annotations

import numpy as np
import pytest

from engine.geometry.shapes import BASE, SHAPES, distance, shape


@pytest.mark.parametrize(
    ("name", "closed", "convex"),
    [("sphere", True, True), ("torus-knot", True, False), ("blob", True, False), ("plane", False, False)],
)
def test_built_in_models_hang_together(name: str, closed: bool, convex: bool) -> None:
    topology = shape(name).topology
    assert (topology.closed, topology.convex) == (closed, convex)
    assert topology.components == 1
    assert topology.inside_out == topology.crowded_edges == topology.clashing_edges == 0
    assert (topology.open_edges > 0) != closed


def test_the_bust_is_where_its_distance_is_zero_and_smooth() -> None:
    mesh = shape("blob")
    assert np.abs(distance(mesh.positions)).max() < 2e-3
    assert mesh.positions[:, 1].min() == pytest.approx(BASE, abs=0.02)
    a, b, c = (mesh.positions[mesh.faces[:, corner]] for corner in range(3))
    flat = np.cross(b - a, c - a)
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    against = np.einsum("fi,fci->fc", flat, mesh.normals[mesh.faces].astype(float))
    assert np.mean(against > 0.95) > 0.99


def test_the_bust_looks_the_same_from_left_and_right() -> None:
    mesh = shape("blob")
    rows = mesh.positions.reshape(-1, 385, 3)
    assert rows[:, ::-1] * (-1.0, 1.0, 1.0) == pytest.approx(rows, abs=1e-6)


@pytest.mark.parametrize("name", SHAPES)
def test_flipping_a_model_twice_gives_it_back(name: str) -> None:
    mesh = shape(name)
    once, twice = mesh.flipped(), mesh.flipped().flipped()
    assert np.array_equal(twice.faces, mesh.faces)
    assert np.array_equal(twice.normals, mesh.normals)
    assert once.topology.volume == pytest.approx(-mesh.topology.volume, rel=1e-9, abs=1e-12)
    assert once.topology.inside_out == int(mesh.topology.closed)

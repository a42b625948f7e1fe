"""Parts of a model: each vertex belongs to one, by counting."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from engine.geometry.mesh import Mesh, mesh_of_arrays
from engine.geometry.parts import parts_of_vertices, split_parts


def strip(part: list[int]) -> Mesh:
    """Two triangles with a common edge from vertex 1 to vertex 2."""
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]
    made = mesh_of_arrays(points, [[0, 1, 2], [2, 1, 3]], name="strip")
    colours = np.linspace(0.0, 1.0, 12, dtype=np.float32).reshape(4, 3)
    return replace(made, part=np.array(part, np.int32), part_names=("a", "b"), colours=colours)


def test_vertices_of_a_seam_are_there_for_both_parts() -> None:
    mesh = strip([0, 1])
    whole = split_parts(mesh)
    assert len(whole.positions) == 6
    assert whole.colours is not None
    assert mesh.colours is not None
    for name in ("positions", "normals", "uv", "colours"):
        assert np.array_equal(getattr(whole, name)[whole.faces], getattr(mesh, name)[mesh.faces])
    assert np.array_equal(parts_of_vertices(whole)[whole.faces], [[0, 0, 0], [1, 1, 1]])
    with pytest.raises(ValueError, match="two parts"):
        parts_of_vertices(mesh)


def test_a_model_without_seams_is_itself() -> None:
    mesh = strip([1, 1])
    assert split_parts(mesh) is mesh
    assert parts_of_vertices(mesh).tolist() == [1, 1, 1, 1]

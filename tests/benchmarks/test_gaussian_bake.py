"""Benchmark of Gaussian bakes: the knot faces outwards, and errors have names."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.transport import gaussian_bake
from engine.core.steps import drain
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import sphere
from engine.light.environment_file import open_environment


def test_the_knot_with_fewer_vertices_is_turned_outwards() -> None:
    mesh = gaussian_bake._knot(*gaussian_bake.FEW)
    assert len(mesh.positions) == 17 * 65
    a, b, c = (mesh.positions[mesh.faces[:, corner]] for corner in range(3))
    flat = np.cross(b - a, c - a)
    assert (np.einsum("fi,fi->f", flat, mesh.normals[mesh.faces[:, 0]]) > 0.0).mean() > 0.99
    assert mesh.faces.max() == len(mesh.positions) - 1


def test_errors_lie_where_they_should(monkeypatch: pytest.MonkeyPatch) -> None:
    """Coarse limits: one lobe is off a highlight by a quarter to a half, and two are nearer than one."""
    monkeypatch.setattr(gaussian_bake, "EDGE", 32)
    monkeypatch.setattr(gaussian_bake, "SAMPLES", 64)
    monkeypatch.setattr(gaussian_bake, "ERRORS", gaussian_bake.ERRORS[:2])
    whole = sphere()
    chosen = np.linspace(0, len(whole.positions) - 1, 60).astype(int)
    faces = np.arange(60, dtype=np.int32).reshape(-1, 3)
    some = Mesh(whole.positions[chosen], whole.normals[chosen], whole.uv[chosen], faces, "some")
    found = {
        each.name: each.error for each in drain(gaussian_bake.errors_of(some, open_environment("sky"), vertices=12))
    }
    one, two = (found[f"gaussian-ashikhmin-shirley-{number}-fit"] for number in (0, 1))
    assert 0.1 < two < one < 0.5
    assert 0.0 < found["gaussian-ashikhmin-shirley-0-radiance"] < 0.2
    assert found["gaussian-ashikhmin-shirley-0-radiance"] == min(
        found[f"gaussian-ashikhmin-shirley-0-{name}"] for name in ("plain", "preserving")
    )

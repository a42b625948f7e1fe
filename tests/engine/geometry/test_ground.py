"""The ground under a model: where it lies, how large it is, and that the model stays what it was."""

from __future__ import annotations

import numpy as np
import pytest

from engine.geometry.ground import GAP, Ground, with_ground
from engine.geometry.shapes import SHAPES, shape


@pytest.mark.parametrize("name", SHAPES)
def test_the_ground_lies_level_under_the_model_and_faces_up(name: str) -> None:
    mesh = shape(name)
    both, first = with_ground(mesh, Ground(extent=3.0, cells=5))
    ground = both.faces[first:]
    assert len(ground) == 2 * 5**2
    assert ground.min() == len(mesh.positions)
    a, b, c = (both.positions[ground[:, corner]] for corner in range(3))
    area = np.cross(b - a, c - a) / 2.0
    assert area[:, [0, 2]] == pytest.approx(0.0)
    assert area[:, 1].min() > 0.0
    assert area[:, 1].sum() == pytest.approx((2 * 3.0 * mesh.radius) ** 2)
    heights = both.positions[len(mesh.positions) :, 1]
    assert np.ptp(heights) == 0.0
    assert mesh.positions[:, 1].min() - heights[0] == pytest.approx(GAP * mesh.radius)
    middle = both.positions[len(mesh.positions) :].mean(axis=0)
    assert middle[[0, 2]] == pytest.approx(mesh.centre[[0, 2]], abs=1e-12)


@pytest.mark.parametrize("name", SHAPES)
def test_the_model_stays_as_it_was(name: str) -> None:
    mesh = shape(name)
    both, first = with_ground(mesh, Ground())
    count = len(mesh.positions)
    assert first == len(mesh.faces)
    for field in ("positions", "normals", "uv", "tangents"):
        assert np.array_equal(getattr(both, field)[:count], getattr(mesh, field)), field
    assert np.array_equal(both.faces[:first], mesh.faces)
    assert (both.name, both.health) == (mesh.name, mesh.health)


def test_the_texture_of_the_ground_is_as_dense_as_made_ones_and_not_mirrored() -> None:
    mesh = shape("torus-knot")
    both, first = with_ground(mesh, Ground(cells=3))
    ground = both.faces[first:]
    a, b, c = (both.positions[ground[:, corner]] for corner in range(3))
    p, q, r = (both.uv[ground[:, corner]].astype(float) for corner in range(3))
    in_texture = (q - p)[:, 0] * (r - p)[:, 1] - (q - p)[:, 1] * (r - p)[:, 0]
    in_space = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    assert in_texture == pytest.approx(in_space / np.max(np.ptp(mesh.positions, axis=0)) ** 2, rel=1e-4)


def test_a_stated_height_is_kept() -> None:
    both, _ = with_ground(shape("sphere"), Ground(height=-0.25))
    assert np.all(both.positions[len(shape("sphere").positions) :, 1] == -0.25)


@pytest.mark.parametrize(
    "wrong",
    [
        {"height": float("nan")},
        {"height": float("inf")},
        {"albedo": 1.5},
        {"albedo": float("nan")},
        {"albedo": -0.1},
        {"extent": 0.0},
        {"extent": float("inf")},
        {"cells": 0},
        {"cells": 1 << 20},
    ],
)
def test_an_impossible_ground_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="not possible"):
        Ground(**wrong)  # type: ignore[arg-type]

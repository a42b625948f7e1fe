"""Rays against meshes: brute force in float64, watertightness, scales, and what is refused."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.ray_caster import RayCaster
from engine.shapes import shape


def brute_force(positions: NDArray, faces: NDArray, origin: NDArray, direction: NDArray) -> tuple[NDArray, NDArray]:
    """Face and distance of the nearest hit by solving for each face on its own (Cramer's rule), in float64."""
    best, nearest = np.full(len(origin), -1), np.full(len(origin), np.inf)
    for index, (a, b, c) in enumerate(positions[faces]):
        matrix = np.stack(np.broadcast_arrays(b - a, c - a, -direction), axis=-1)
        u, v, t = np.linalg.solve(matrix, (origin - a)[..., None])[..., 0].T
        closer = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0) & (t < nearest)
        best[closer], nearest[closer] = index, t[closer]
    return best, nearest


def random_rays(count: int, seed: int = 0) -> tuple[NDArray, NDArray]:
    rng = np.random.default_rng(seed)
    return 2.0 * rng.normal(size=(count, 3)), rng.normal(size=(count, 3))


def test_hits_are_those_of_brute_force() -> None:
    rng = np.random.default_rng(1)
    positions, faces = rng.normal(size=(40, 3)), rng.integers(0, 40, (60, 3))
    faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])]
    origin, direction = random_rays(5000)
    face, distance = brute_force(positions, faces, origin, direction)
    caster = RayCaster(positions, faces)
    hits = caster.intersect(origin, direction)
    assert np.mean(hits.face >= 0) > 0.1
    np.testing.assert_array_equal(hits.face, face)
    np.testing.assert_allclose(hits.distance, distance, rtol=1e-9)
    np.testing.assert_array_equal(caster.occluded(origin, direction), face >= 0)
    hit = hits.face >= 0
    met = np.einsum("nk,nki->ni", hits.barycentric[hit], positions[faces[hits.face[hit]]])
    np.testing.assert_allclose(met, (origin + distance[:, None] * direction)[hit], atol=1e-9)


def test_rays_without_meaning_meet_nothing() -> None:
    mesh = shape("sphere")
    caster = RayCaster(mesh.positions, mesh.faces)
    origin, direction = np.zeros((6, 3)), np.tile((0.0, 0.0, 1.0), (6, 1))
    origin[0], origin[1, 2], direction[2, 0], direction[3], direction[4] = np.nan, np.inf, np.nan, np.inf, 0.0
    np.testing.assert_array_equal(caster.occluded(origin, direction), [False] * 5 + [True])
    hits = caster.intersect(origin, direction)
    np.testing.assert_array_equal(hits.face[:5], -1)
    assert np.isinf(hits.distance[:5]).all()
    assert not hits.barycentric[:5].any()
    assert abs(hits.distance[5] - 1.0) < 1e-12


def test_nothing_asked_or_nothing_there_is_answered() -> None:
    mesh = shape("sphere")
    empty = np.zeros((0, 3))
    assert RayCaster(mesh.positions, mesh.faces).occluded(empty, empty).shape == (0,)
    nowhere = RayCaster(empty, np.zeros((0, 3), np.int32))
    assert not nowhere.occluded(*random_rays(3)).any()
    assert (nowhere.intersect(*random_rays(3)).face == -1).all()

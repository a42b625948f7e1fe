"""Rays against meshes: brute force in float64, watertightness, scales, and what is refused."""

from __future__ import annotations

import numpy as np
import psutil
import pytest
from numpy.typing import NDArray

from engine.geometry import embree, ray_caster
from engine.geometry.ray_caster import RayCaster
from engine.geometry.shapes import shape


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


def test_classes_and_packets_agree(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without embree's functions, embreex's class answers the same."""
    mesh = shape("torus-knot")
    assert embree.embree_functions() is not None
    packets = RayCaster(mesh.positions, mesh.faces)
    monkeypatch.setattr(embree, "embree_functions", lambda: None)
    singles = RayCaster(mesh.positions, mesh.faces)
    assert isinstance(singles._scene, embree.ClassScene)
    origin, direction = random_rays(5000)
    origin[7], direction[9] = np.nan, 0.0
    np.testing.assert_array_equal(singles.occluded(origin, direction), packets.occluded(origin, direction))
    one, many = singles.intersect(origin, direction), packets.intersect(origin, direction)
    assert 0.05 < np.mean(many.face >= 0) < 0.95
    np.testing.assert_array_equal(one.face, many.face)
    np.testing.assert_array_equal(one.distance, many.distance)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_answer_does_not_depend_on_chunks_threads_or_coherence(
    dtype: type[np.floating], monkeypatch: pytest.MonkeyPatch
) -> None:
    mesh = shape("torus-knot")
    caster = RayCaster(mesh.positions, mesh.faces)
    origin, direction = (rays.astype(dtype) for rays in random_rays(70_001))
    occluded, hits = caster.occluded(origin, direction), caster.intersect(origin, direction)
    np.testing.assert_array_equal(caster.occluded(origin, direction, coherent=True), occluded)
    np.testing.assert_array_equal(caster.intersect(origin, direction, coherent=True).distance, hits.distance)
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    monkeypatch.setattr(ray_caster.in_chunks, "__defaults__", (999,))
    np.testing.assert_array_equal(caster.occluded(origin, direction), occluded)
    np.testing.assert_array_equal(caster.intersect(origin, direction).barycentric, hits.barycentric)


@pytest.mark.parametrize("scale", [1e-300, 1e-6, 2.0**-20, 1e-3, 1e3, 2.0**20, 1e6, 1e150])
def test_V3_hits_scale_with_the_mesh(scale: float) -> None:
    mesh = shape("torus-knot")
    origin, direction = random_rays(20_000)
    plain = RayCaster(mesh.positions, mesh.faces).intersect(origin, direction)
    scaled = RayCaster(mesh.positions * scale, mesh.faces).intersect(origin * scale, direction)
    same = plain.face == scaled.face
    if np.log2(scale) % 1.0 == 0.0:
        assert same.all()
        np.testing.assert_array_equal(scaled.distance, plain.distance * scale)
    assert np.mean(~same) <= 1e-3
    np.testing.assert_allclose(scaled.distance[same], plain.distance[same] * scale, rtol=1e-9)


def test_V12_denormal_and_single_points_are_no_danger() -> None:
    faces = np.array([[0, 1, 2]])
    for positions in (np.eye(3) * 1e-320, np.zeros((3, 3)), np.full((3, 3), 1e300)):
        hits = RayCaster(positions, faces).intersect(*random_rays(100))
        assert not np.isnan(hits.distance).any()
        assert np.isfinite(hits.barycentric).all()


def test_V5_of_coincident_faces_the_first_is_met() -> None:
    """Whichever way round the copies are, and however the vertices are numbered."""
    positions = np.tile([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], (3, 1))
    faces = np.array([[0, 1, 2], [1, 3, 2]])
    copies = np.concatenate([faces, faces[:, ::-1] + 4, faces[:, [1, 2, 0]] + 8])
    rng = np.random.default_rng(0)
    origin = np.concatenate([rng.random((1000, 2)), np.ones((1000, 1))], axis=1)
    hits = RayCaster(positions, copies).intersect(origin, np.tile((0.0, 0.0, -1.0), (1000, 1)))
    assert set(hits.face) == {0, 1}
    np.testing.assert_array_equal(hits.face == 0, origin[:, 0] + origin[:, 1] <= 1.0)


def test_wrong_meshes_are_refused() -> None:
    with pytest.raises(ValueError, match="do not exist"):
        RayCaster(np.eye(3), [[0, 1, 3]])
    with pytest.raises(ValueError, match="do not exist"):
        RayCaster(np.eye(3), [[0, 1, -1]])
    with pytest.raises(ValueError, match="not finite"):
        RayCaster(np.full((3, 3), np.inf), [[0, 1, 2]])
    unused = np.concatenate([np.eye(3), np.full((1, 3), np.nan)])
    assert RayCaster(unused, [[0, 1, 2]]).occluded(np.zeros((1, 3)), np.ones((1, 3))).all()


def test_scenes_come_and_go() -> None:
    """Scenes are released with their casters, and a caster outlives the arrays that it was made from."""
    mesh = shape("sphere")
    before = psutil.Process().memory_info().rss
    for _ in range(40):
        positions = mesh.positions.copy()
        caster = RayCaster(positions, mesh.faces)
        del positions
        assert caster.occluded(np.zeros((1, 3)), np.ones((1, 3))).all()
    assert psutil.Process().memory_info().rss - before < 200e6

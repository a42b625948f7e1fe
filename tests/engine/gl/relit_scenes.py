"""Transport with made-up light, and what each fragment of it must be by rays, for tests of its drawing."""

from __future__ import annotations

from typing import Any

import numpy as np
import trimesh

from engine.core.directions import normalize
from engine.factor.hemisphere_map import HemisphereMap, MapKind
from engine.factor.separable_factors import SeparableFactors
from engine.geometry.camera import Camera
from engine.geometry.ground import Ground, with_ground
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import RayCaster
from engine.transport.relight import RelightWavelets
from engine.transport.wavelet.transfer import GRAZING, Vectors16, WaveletTransport

SIZE = (160, 120)


def sphere(halvings: int) -> Mesh:
    """A sphere of 20 · 4^halvings triangles of one size."""
    made = trimesh.creation.icosphere(subdivisions=halvings)
    positions = np.asarray(made.vertices, np.float64)
    uv = np.zeros((len(positions), 2), np.float32)
    return Mesh(positions, positions.astype(np.float32), uv, np.asarray(made.faces, np.int32), "ball")


def smooth(positions: np.ndarray, count: int, seed: int) -> np.ndarray:
    """(V, count, 3) numbers that vary slowly over a model."""
    rng = np.random.default_rng(seed)
    across = rng.normal(size=(3, count, 3))
    return np.asarray(rng.uniform(0.2, 1.0, (count, 3)) + 0.3 * np.einsum("vi,ick->vck", positions, across))


def factors(terms: int, kind: MapKind = "orthographic", *, isotropic: bool = True, size: int = 16) -> SeparableFactors:
    """View maps that are smooth functions of the direction, some of them negative."""
    hemisphere_map = HemisphereMap(kind, size)
    values = smooth(hemisphere_map.directions, terms, 7)
    maps = np.stack([hemisphere_map.image(values[:, k]) for k in range(terms)]).astype(np.float32)
    return SeparableFactors(hemisphere_map, "in-out", maps, maps, isotropic=isotropic)


def relight_wavelets(mesh: Mesh, of: SeparableFactors, ground: Ground | None = None, seed: int = 3) -> RelightWavelets:
    surface, first = (with_ground(mesh, ground)[0] if ground else mesh), len(mesh.positions)
    count = first * of.terms + len(surface.positions) - first
    vectors = Vectors16(
        np.zeros((count, 1), np.uint16),
        np.zeros((count, 1), np.uint32),
        np.zeros((count, 3), np.float32),
        np.zeros(count, np.uint16),
    )
    transport = WaveletTransport(surface, first, of, ground.albedo if ground else 0.0, 16, vectors)
    rows = smooth(surface.positions / surface.radius, of.terms, seed)
    return RelightWavelets(transport, np.concatenate([rows[:first].reshape(-1, 3), rows[first:, 0]]))


def hits(mesh: Mesh, camera: Camera, size: tuple[int, int] = SIZE) -> tuple[Any, Any, Any]:
    """Pixels (n,) that show the front of a face, their corners (n, 3) and the weights of these (n, 3)."""
    row, column = np.mgrid[0 : size[1], 0 : size[0]].reshape(2, -1)
    rays = camera.rays(column + 0.5, row + 0.5, *size)
    found = RayCaster(mesh.positions, mesh.faces).intersect(np.broadcast_to(camera.eye, rays.shape), rays)
    seen = np.flatnonzero(found.face >= 0)
    corners = mesh.faces[found.face[seen]].astype(np.int64)
    a, b, c = (mesh.positions[corners[:, k]] for k in range(3))
    front = np.einsum("ni,ni->n", np.cross(b - a, c - a), rays[seen]) < 0.0
    return seen[front], corners[front], found.barycentric[seen[front]]


def local_views(mesh: Mesh, frames: np.ndarray, camera: Camera) -> np.ndarray:
    """(V, 3) directions to the eye in the frames of the vertices, lifted above the horizon."""
    local = np.einsum("nij,ni->nj", frames, normalize(np.asarray(camera.eye) - mesh.positions))
    local[:, 2] = np.maximum(local[:, 2], GRAZING)
    return np.asarray(normalize(local))

"""Built-in models for looking at a material: sphere, plane, torus knot, a draped cloth, and a blob like a bust.

Each is about 2 units across, is made on demand, and has texture coordinates of even density, none of them mirrored.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.bust import bust
from engine.directions import normalize
from engine.errors import InputError
from engine.mesh import Mesh, read_mesh

Points = NDArray[np.float64]

RESOURCES = Path(__file__).resolve().parents[1] / "resources"


def grid_mesh(name: str, positions: Points, normals: Points, uv: Points) -> Mesh:
    """A mesh from grids (rows, columns, …) whose u rises along the columns and v along the rows."""
    rows, columns = positions.shape[:2]
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    faces = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], axis=2).reshape(-1, 3)
    return Mesh(
        np.ascontiguousarray(positions.reshape(-1, 3)),
        normals.reshape(-1, 3).astype(np.float32),
        uv.reshape(-1, 2).astype(np.float32),
        faces.astype(np.int32),
        name,
    )


def _grid(rows: int, columns: int) -> tuple[Points, Points]:
    """u along the columns and v along the rows, both (rows, columns) in [0, 1]."""
    u, v = np.meshgrid(np.linspace(0.0, 1.0, columns), np.linspace(0.0, 1.0, rows))
    return u, v


def _grid_normals(positions: Points) -> Points:
    return normalize(np.cross(np.gradient(positions, axis=1), np.gradient(positions, axis=0)))


def plane() -> Mesh:
    """The square [−1, 1]² in the plane z = 0, facing +Z."""
    u, v = _grid(2, 2)
    positions = np.stack([2 * u - 1, 2 * v - 1, np.zeros_like(u)], -1)
    return grid_mesh("plane", positions, np.broadcast_to((0.0, 0.0, 1.0), positions.shape), np.stack([u, v], -1))


def sphere() -> Mesh:
    """The unit sphere; u goes round the axis twice, v once from pole to pole, so the density is even at the equator."""
    u, v = _grid(129, 257)
    theta, phi = np.pi * (1 - v), 2 * np.pi * u
    positions = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], -1)
    positions[:, -1], positions[0], positions[-1] = positions[:, 0], (0.0, -1.0, 0.0), (0.0, 1.0, 0.0)
    return _without_slivers(grid_mesh("sphere", positions, positions, np.stack([2 * u, v], -1)))


def _without_slivers(mesh: Mesh) -> Mesh:
    """Without the triangles that have no area because a whole row of the grid is one point."""
    a, b, c = (mesh.positions[mesh.faces[:, corner]] for corner in range(3))
    has_area = np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-9
    return Mesh(mesh.positions, mesh.normals, mesh.uv, np.ascontiguousarray(mesh.faces[has_area]), mesh.name)


def torus_knot() -> Mesh:
    """The (2, 3) torus knot as a tube of radius 0.28."""
    u, v = _grid(65, 769)

    def curve(t: Points) -> Points:
        ring = 2.0 + np.cos(3 * t)
        return 0.4 * np.stack([ring * np.cos(2 * t), ring * np.sin(2 * t), 1.2 * np.sin(3 * t)], -1)

    t, around = 2 * np.pi * u, 2 * np.pi * v
    step = 1e-4
    before, centre, after = curve(t - step), curve(t), curve(t + step)
    tangent = normalize(after - before)
    inward = normalize(after - 2 * centre + before)
    across = np.cross(tangent, inward)
    normals = np.cos(around)[..., None] * across + np.sin(around)[..., None] * inward
    length = np.sum(np.linalg.norm(np.diff(centre[0], axis=0), axis=1))
    repeats = round(length / (2 * np.pi * 0.28))
    positions = centre + 0.28 * normals
    positions[:, -1], positions[-1] = positions[:, 0], positions[0]
    return grid_mesh("torus-knot", positions, normals, np.stack([repeats * u, v], -1))


def cloth() -> Mesh:
    """A square cloth that hangs over a ball and lies out on the ground, made by `engine.drape`; refined fourfold."""
    from scipy.ndimage import zoom

    coarse = np.load(RESOURCES / "models" / "cloth.npy", allow_pickle=False).astype(np.float64)
    size = [4 * (points - 1) + 1 for points in coarse.shape[:2]]
    positions = zoom(coarse, (size[0] / coarse.shape[0], size[1] / coarse.shape[1], 1.0), order=3, mode="nearest")
    u, v = _grid(*size)
    return grid_mesh("cloth", positions, _grid_normals(positions), np.stack([u, v], -1))


def blob() -> Mesh:
    """Head and shoulders, made by `engine.bust`; u goes round once, v from the base to the crown."""
    positions, normals = bust(257, 385)
    u, v = _grid(*positions.shape[:2])
    around = np.linalg.norm(np.diff(positions, axis=1), axis=-1).sum(axis=1).mean()
    upwards = np.linalg.norm(np.diff(positions, axis=0), axis=-1).sum(axis=0).mean()
    return _without_slivers(grid_mesh("blob", positions, normals, np.stack([u, v * upwards / around], -1)))


#: The built-in models by the name that the command line and the window use.
SHAPES: dict[str, Callable[[], Mesh]] = {
    "sphere": sphere,
    "plane": plane,
    "torus-knot": torus_knot,
    "cloth": cloth,
    "blob": blob,
}


@lru_cache(maxsize=len(SHAPES))
def shape(name: str) -> Mesh:
    """The built-in model `name`; KeyError for another name."""
    return SHAPES[name]()


def open_mesh(name_or_path: str) -> Mesh:
    """A built-in model by its name, or else the mesh in that file; InputError says what would be right."""
    if name_or_path in SHAPES:
        return shape(name_or_path)
    if not Path(name_or_path).suffix and not Path(name_or_path).exists():
        raise InputError(name_or_path, "is neither a built-in model nor a file", f"Give a file or {', '.join(SHAPES)}")
    return read_mesh(name_or_path)

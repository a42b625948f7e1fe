"""Built-in models for looking at a material: sphere, plane, torus knot, a draped cloth, and a blob like a bust.

Each is about 2 units across, is made on demand, and has texture coordinates of even density, none of them mirrored.

The 'blob': head and shoulders of nobody, to see how a material looks on something like a face.

A distance field of a few rounded bodies that run into each other (polynomial smooth minimum, Quilez2013) is met by
rays that leave a spine: upwards and downwards at its ends, slanting under the chin. What they meet is a grid.
Cost: about 1 s, once.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import normalize
from engine.core.errors import InputError
from engine.core.suggestion import suggest
from engine.geometry.camera import FRAMING_DIRECTION, Camera, frame
from engine.geometry.mesh import Mesh, read_mesh
from engine.geometry.orientation import Orientation

#: Rounded bodies: centre, radii along x, y, z, and how far they run into what came before. Those off the middle have
#: a counterpart on the other side.
BODIES = (
    ((0.0, 0.45, -0.06), (0.355, 0.41, 0.42), 0.0),  # skull
    ((0.0, 0.27, 0.12), (0.27, 0.38, 0.28), 0.12),  # face
    ((0.0, 0.0, 0.23), (0.10, 0.07, 0.09), 0.13),  # chin
    ((0.16, 0.10, 0.08), (0.09, 0.11, 0.15), 0.12),  # jaw
    ((0.17, 0.26, 0.25), (0.08, 0.07, 0.09), 0.09),  # cheeks
    ((0.12, 0.47, 0.30), (0.10, 0.04, 0.065), 0.09),  # brows
    ((0.0, 0.35, 0.395), (0.03, 0.10, 0.05), 0.06),  # bridge of the nose
    ((0.0, 0.275, 0.455), (0.042, 0.04, 0.06), 0.045),  # its tip
    ((0.042, 0.262, 0.42), (0.03, 0.026, 0.035), 0.03),  # its wings
    ((0.0, 0.165, 0.385), (0.085, 0.02, 0.035), 0.03),  # upper lip
    ((0.0, 0.122, 0.377), (0.068, 0.022, 0.035), 0.022),  # lower lip
    ((0.365, 0.34, -0.02), (0.03, 0.10, 0.065), 0.03),  # ears
    ((0.0, -0.1, -0.08), (0.19, 0.5, 0.2), 0.08),  # neck
    ((0.0, -0.62, -0.08), (0.72, 0.17, 0.22), 0.2),  # shoulders
    ((0.0, -0.84, 0.0), (0.56, 0.42, 0.31), 0.16),  # chest
)

#: Hollows, likewise: the sockets of the eyes, and the eyes that lie in them.
SOCKETS = ((0.132, 0.395, 0.395), (0.072, 0.04, 0.06), 0.07)
EYES = ((0.13, 0.392, 0.325), (0.052, 0.036, 0.042), 0.012)

#: Height at which the body is cut off, and radius of the round edge.
BASE, EDGE = -0.98, 0.05

#: Places along the spine: share of the rows, height of the ray's origin, and its elevation in degrees.
SPINE = np.array([(0.0, -0.72, -90.0), (0.22, -0.72, 0.0), (0.42, -0.35, 0.0), (0.62, 0.33, -42.0), (1.0, 0.33, 90.0)])

REACH = 1.4


def bust(rows: int, columns: int) -> tuple[Points, Points]:
    """Positions and unit normals (rows, columns, 3), rows from below to above, columns once round from behind."""
    along = _evenly_spaced(rows)
    positions = _find_surface_points(along[:, None], np.linspace(-np.pi, np.pi, columns)[None, :])
    positions[:, -1] = positions[:, 0]
    positions[[0, -1]] = positions[[0, -1]].mean(axis=1, keepdims=True)
    return positions, _normals(positions)


def _evenly_spaced(rows: int) -> Points:
    """Shares of the spine whose rays meet the surface at even distances, in the mean over all sides."""
    fine = np.linspace(0.0, 1.0, 4 * rows + 1)
    met = _find_surface_points(fine[:, None], np.linspace(-np.pi, np.pi, 16, endpoint=False)[None, :])
    steps = np.linalg.norm(np.diff(met, axis=0), axis=-1).mean(axis=1)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    return np.interp(np.linspace(0.0, length[-1], rows), length, fine)


def _find_surface_points(along: Points, azimuth: Points) -> Points:
    """Points at which rays from the spine leave the body, found by halving."""
    height = np.interp(along, SPINE[:, 0], SPINE[:, 1])
    elevation = np.radians(np.interp(along, SPINE[:, 0], SPINE[:, 2]))
    along, azimuth = np.broadcast_arrays(along, azimuth)
    direction = np.stack(
        [np.cos(elevation) * np.sin(azimuth), np.sin(elevation) + 0.0 * azimuth, np.cos(elevation) * np.cos(azimuth)],
        axis=-1,
    )
    origin = np.stack([0.0 * along, height + 0.0 * along, 0.0 * along], axis=-1)
    low, high = np.zeros(along.shape), np.full(along.shape, REACH)
    for _ in range(30):
        middle = (low + high) / 2.0
        inside = distance(origin + middle[..., None] * direction) < 0.0
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return origin + ((low + high) / 2.0)[..., None] * direction


def distance(points: Points) -> Points:
    """Roughly the distance (...) of points (..., 3) from the surface, negative inside; both sides are alike."""
    # Arrays of one coordinate: sums over the last axis of three elements would take most of the time.
    place = (np.abs(points[..., 0]), points[..., 1].copy(), points[..., 2].copy())
    body = _ellipsoid(place, *BODIES[0][:2])
    for centre, radii, blend in BODIES[1:]:
        body = _smaller(body, _ellipsoid(place, centre, radii), blend)
    body = -_smaller(-body, _ellipsoid(place, *SOCKETS[:2]), SOCKETS[2])
    body = _smaller(body, _ellipsoid(place, *EYES[:2]), EYES[2])
    return -_smaller(-body, place[1] - BASE, EDGE)


def _ellipsoid(place: tuple[Points, ...], centre: tuple[float, ...], radii: tuple[float, ...]) -> Points:
    offset = [(coordinate - middle) / radius for coordinate, middle, radius in zip(place, centre, radii, strict=True)]
    near = _length(offset)
    slope = _length([along / radius for along, radius in zip(offset, radii, strict=True)])
    return near * (near - 1.0) / np.maximum(slope, 1e-9)


def _length(vector: list[Points]) -> Points:
    x, y, z = vector
    return np.asarray(np.sqrt(x * x + y * y + z * z))


def _smaller(a: Points, b: Points, blend: float) -> Points:
    """The smaller of both, rounded over a width of `blend`."""
    if blend == 0.0:
        return np.minimum(a, b)
    return np.minimum(a, b) - np.maximum(blend - np.abs(a - b), 0.0) ** 2 / (4.0 * blend)


def _normals(points: Points) -> Points:
    step = 1e-4 * np.eye(3)
    gradient = [distance(points + step[axis]) - distance(points - step[axis]) for axis in range(3)]
    return normalize(np.stack(gradient, axis=-1))


Points = NDArray[np.float64]

RESOURCES = Path(__file__).resolve().parents[2] / "resources"


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
    """A square cloth that hangs over a ball and lies out on the ground, made by `packaging.make_cloth`; refined
    fourfold.
    """
    from scipy.ndimage import zoom

    coarse = np.load(RESOURCES / "models" / "cloth.npy", allow_pickle=False).astype(np.float64)
    size = [4 * (points - 1) + 1 for points in coarse.shape[:2]]
    positions = zoom(coarse, (size[0] / coarse.shape[0], size[1] / coarse.shape[1], 1.0), order=3, mode="nearest")
    u, v = _grid(*size)
    return grid_mesh("cloth", positions, _grid_normals(positions), np.stack([u, v], -1))


def blob() -> Mesh:
    """Head and shoulders, made by `engine.geometry.shapes`; u goes round once, v from the base to the crown."""
    positions, normals = bust(257, 385)
    u, v = _grid(*positions.shape[:2])
    around = np.linalg.norm(np.diff(positions, axis=1), axis=-1).sum(axis=1).mean()
    upwards = np.linalg.norm(np.diff(positions, axis=0), axis=-1).sum(axis=0).mean()
    return _without_slivers(grid_mesh("blob", positions, normals, np.stack([u, v * upwards / around], -1)))


#: Name of the models that `flat_image` makes.
FLAT = "flat image"


def flat_image(width: int, height: int) -> Mesh:
    """A rectangle in the plane z = 0 that faces +Z and has the proportions of an image of `width` × `height` texels.

    Its longer side is 2 units, and its texture coordinates are [0, 1]², so that a material shows on it once.
    """
    u, v = _grid(2, 2)
    x, y = np.array([width, height]) / max(width, height)
    positions = np.stack([(2 * u - 1) * x, (2 * v - 1) * y, np.zeros_like(u)], -1)
    return grid_mesh(FLAT, positions, np.broadcast_to((0.0, 0.0, 1.0), positions.shape), np.stack([u, v], -1))


def frame_mesh(mesh: Mesh, aspect: float = 1.0) -> Camera:
    """The camera that shows `mesh` first, in an image of `aspect` (width over height): a flat image from the front."""
    return frame(mesh.positions, aspect, direction=(0.0, 0.0, 1.0) if mesh.name == FLAT else FRAMING_DIRECTION)


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


def open_mesh(name_or_path: str, orientation: Orientation = "auto") -> Mesh:
    """A built-in model by its name, or else the mesh in that file; InputError says what would be right."""
    if name_or_path in SHAPES:
        return shape(name_or_path).flipped() if orientation == "flip" else shape(name_or_path)
    if not Path(name_or_path).suffix and not Path(name_or_path).exists():
        problem = f"is neither a built-in model nor a file{suggest(name_or_path, SHAPES)}"
        raise InputError(name_or_path, problem, f"Give a file or {', '.join(SHAPES)}")
    return read_mesh(name_or_path, orientation)

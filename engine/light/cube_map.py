"""Cube maps: six square faces of radiance, exact texel areas, and resampling from and to equirectangular maps.

Faces +X −X +Y −Y +Z −Z in OpenGL orientation: column s and row t of a face run, in this order, towards
(−Z, −Y), (+Z, −Y), (+X, +Z), (+X, −Z), (+X, −Y), (−X, −Y); row 0 is at t = 0 and a texel's centre at (i + ½) / N.
Radiance is constant within a texel on both sides, so resampling is a sum over overlaps
(`engine.light.cube_map_kernel`). A map of 1024 × 512 to 6 × 512² takes some 0.25 s of CPU time.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.core.health import Health
from engine.light.cube_map_kernel import to_faces, to_rows
from engine.light.environment import EnvironmentMap, solid_angles

#: Directions of s, t and the axis of each face, as rows: direction = (2 s − 1) s_axis + (2 t − 1) t_axis + axis.
FACES = np.array(
    [
        [[0, 0, -1], [0, -1, 0], [1, 0, 0]],
        [[0, 0, 1], [0, -1, 0], [-1, 0, 0]],
        [[1, 0, 0], [0, 0, 1], [0, 1, 0]],
        [[1, 0, 0], [0, 0, -1], [0, -1, 0]],
        [[1, 0, 0], [0, -1, 0], [0, 0, 1]],
        [[-1, 0, 0], [0, -1, 0], [0, 0, -1]],
    ],
    np.float64,
)

#: Fewest meridians along which overlaps are added up.
_MERIDIANS = 4096


@dataclass(frozen=True, eq=False)
class CubeMap:
    """Radiance arriving from every direction; `radiance` (6, N, N, 3) float32 linear sRGB, finite and not negative."""

    radiance: NDArray[np.float32]
    name: str = "environment"
    health: Health = field(default_factory=Health)

    def __post_init__(self) -> None:
        shape = self.radiance.shape
        if len(shape) != 4 or shape[0] != 6 or shape[1] != shape[2] or shape[3] != 3 or shape[1] == 0:
            raise ValueError(f"a cube map has shape (6, N, N, 3), not {shape}")
        if not np.isfinite(self.radiance).all() or self.radiance.min() < 0:
            raise ValueError("the radiance of a cube map must be finite and not negative")
        self.radiance.flags.writeable = False

    @property
    def edge(self) -> int:
        """Texels along an edge."""
        return self.radiance.shape[1]


def cube_directions(n: int) -> NDArray[np.float64]:
    """(6, N, N, 3) unit vectors through the centres of the texels."""
    centres = (np.arange(n) + 0.5) / n
    t, s = np.meshgrid(centres, centres, indexing="ij")
    return direction_on_face(np.arange(6)[:, None, None], s[None], t[None])


def direction_on_face(face: NDArray[np.int64], s: NDArray[np.float64], t: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., 3) unit vectors for faces and coordinates in [0, 1]; beyond that the face's plane goes on."""
    axes = FACES[face]
    across, down = 2.0 * s[..., None] - 1.0, 2.0 * t[..., None] - 1.0
    point = across * axes[..., 0, :] + down * axes[..., 1, :] + axes[..., 2, :]
    return point / np.sqrt(1.0 + across * across + down * down)


def face_coordinates(
    direction: NDArray[np.float64],
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Face (...), s and t in [0, 1] of directions (..., 3) of any length but 0; on an edge the earlier axis wins."""
    direction = np.asarray(direction, np.float64)
    axis = np.argmax(np.abs(direction), axis=-1)
    longest = np.take_along_axis(direction, axis[..., None], axis=-1)[..., 0]
    face = 2 * axis + (longest < 0.0)
    axes = FACES[face]
    across, down = (np.einsum("...i,...i->...", direction, axes[..., row, :]) / np.abs(longest) for row in (0, 1))
    return face, 0.5 * (across + 1.0), 0.5 * (down + 1.0)


def texel_numbers(direction: NDArray[np.float64], n: int) -> NDArray[np.int64]:
    """(...) flat numbers, in (6, N, N), of the texels that directions (..., 3) of any length but 0 fall into."""
    face, s, t = face_coordinates(direction)
    row, column = (np.minimum((place * n).astype(np.int64), n - 1) for place in (t, s))
    return np.asarray((face * n + row) * n + column)


def cube_solid_angles(n: int) -> NDArray[np.float64]:
    """(N, N) exact solid angle in sr of the texels of a face; the six faces sum to 4 π.

    The area towards the corner (x, y) of the face's plane is atan2(x y, √(x² + y² + 1)).
    """
    edges = np.linspace(-1.0, 1.0, n + 1)
    corner = np.arctan2(np.outer(edges, edges), np.sqrt(1.0 + edges[:, None] ** 2 + edges[None] ** 2))
    return corner[1:, 1:] - corner[:-1, 1:] - corner[1:, :-1] + corner[:-1, :-1]


def mean_radiance(cube: CubeMap) -> NDArray[np.float64]:
    """(3,) mean over the sphere."""
    weighted = np.einsum("fijc,ij->fc", cube.radiance.astype(np.float64), cube_solid_angles(cube.edge))
    return weighted.sum(axis=0) / (4.0 * np.pi)


def cube_of(environment: EnvironmentMap, n: int) -> CubeMap:
    """`environment` as a cube map of edge `n`, averaged by area on the sphere.

    A constant stays as it is, and the flux of each face is that of the same part of the map: the whole is kept.
    """
    if n < 1:
        raise ValueError(f"the edge of a cube map is at least 1 texel, not {n}")
    summed, area = to_faces(environment.radiance, n, *_meridians(environment.radiance.shape[1], n))
    mean = summed / area[..., None]
    flux = summed.sum(axis=(1, 2))
    obtained = np.einsum("fijc,ij->fc", mean, cube_solid_angles(n))
    mean *= _ratio(flux, obtained)[:, None, None]
    return CubeMap(mean.astype(np.float32), environment.name, environment.health)


def environment_of(cube: CubeMap, rows: int) -> EnvironmentMap:
    """`cube` as an equirectangular map of `rows` × 2 `rows` texels, averaged by area; the flux is kept."""
    if rows < 1:
        raise ValueError(f"an environment map has at least 1 row, not {rows}")
    summed, area = to_rows(cube.radiance, rows, *_meridians(2 * rows, cube.edge))
    mean = summed / area[..., None]
    obtained = (mean * solid_angles(rows, 2 * rows)[..., None]).sum(axis=(0, 1))
    mean *= _ratio(4.0 * np.pi * mean_radiance(cube), obtained)
    return EnvironmentMap(mean.astype(np.float32), cube.name, cube.health)


def _ratio(wanted: NDArray[np.float64], obtained: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(obtained > 0.0, wanted, 1.0) / np.where(obtained > 0.0, obtained, 1.0)


class Meridians(NamedTuple):
    """Lines of longitude along which overlaps are exact, in the order of azimuth; each stands for a narrow slice.

    `azimuth` (M,) as atan2(x, −z) in [0, 2 π), `width` (M,) the slice in rad, `column` (M,) of the equirectangular map,
    `side` (M,) of the columns of the four upright faces counted from −45°.
    """

    azimuth: NDArray[np.float64]
    width: NDArray[np.float64]
    column: NDArray[np.int64]
    side: NDArray[np.int64]


def _meridians(columns: int, n: int) -> Meridians:
    """Two Gauss points in each slice between the edges of the columns of both maps."""
    within = np.arctan(np.linspace(-1.0, 1.0, n + 1))
    sides = (np.pi / 2 * np.arange(4)[:, None] + within[None, :-1]).ravel()
    lowest = -np.pi / 4
    edges = np.concatenate([sides, (2.0 * np.pi * np.arange(columns) / columns - lowest) % (2 * np.pi) + lowest])
    edges = np.unique(np.append(edges, lowest + 2.0 * np.pi))
    pieces = -(-_MERIDIANS // (2 * len(edges)))
    share = np.arange(pieces) / pieces
    edges = np.append((edges[:-1, None] + np.diff(edges)[:, None] * share).ravel(), edges[-1])
    middle, half = 0.5 * (edges[:-1] + edges[1:]), 0.5 * np.diff(edges)
    middle, half = middle[half > 0.0], half[half > 0.0]
    azimuth = (middle[:, None] + half[:, None] * np.array([-1.0, 1.0]) / np.sqrt(3.0)).ravel()
    side = np.minimum(np.searchsorted(sides, np.repeat(middle, 2), side="right") - 1, 4 * n - 1)
    column = np.floor(np.repeat(middle, 2) % (2.0 * np.pi) * (columns / (2.0 * np.pi))).astype(np.int64)
    return Meridians(azimuth, np.repeat(half, 2), np.minimum(column, columns - 1), np.maximum(side, 0))


def resize(cube: CubeMap, n: int) -> CubeMap:
    """`cube` with another edge, averaged by area; a constant stays as it is, and the flux of each face is kept."""
    if n == cube.edge:
        return cube
    share = _shares(cube.edge, n)
    area = cube_solid_angles(cube.edge)
    flux = np.einsum("ai,fijc->fajc", share, cube.radiance * area[..., None], optimize=True)
    flux = np.einsum("bj,fajc->fabc", share, flux, optimize=True)
    mean = flux / (share @ area @ share.T)[..., None]
    mean *= _ratio(flux.sum(axis=(1, 2)), np.einsum("fijc,ij->fc", mean, cube_solid_angles(n)))[:, None, None]
    return CubeMap(mean.astype(np.float32), cube.name, cube.health)


def _shares(old: int, new: int) -> NDArray[Any]:
    """(new, old) share of each old texel of a row in each new one."""
    a, b = np.linspace(0.0, 1.0, old + 1), np.linspace(0.0, 1.0, new + 1)
    common = np.minimum(a[1:], b[1:, None]) - np.maximum(a[:-1], b[:-1, None])
    return np.maximum(common, 0.0) * old


@lru_cache(maxsize=16)
def texels_beside(n: int, depth: int = 0) -> NDArray[np.int64]:
    """(6, 4, N) flat numbers of the texels beyond the upper, lower, left and right edge of each face.

    Those of a greater `depth` lie further from the edge on the same faces, in rows along it.
    """
    out = 1.0 / (
        1.0 - 2.0 * (depth + 1e-6) / n
    )  # what lies that deep in the next face appears there in this one's plane
    low, high, along = 0.5 - 0.5 * out, 0.5 + 0.5 * out, 0.5 + ((np.arange(n) + 0.5) / n - 0.5) * out
    face, found = np.arange(6)[:, None], []
    for s, t in ((along, low), (along, high), (low, along), (high, along)):
        place = np.broadcast_arrays(face, np.asarray(s)[None], np.asarray(t)[None])
        found.append(texel_numbers(direction_on_face(*place), n))
    return np.stack(found, axis=1)

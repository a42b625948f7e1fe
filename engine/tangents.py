"""Which way a brushed surface runs: tangents from texture coordinates, and frames along any direction.

The tangent is dP/du, the direction in which u grows, and the bitangent n × t: frames are right-handed also where the
texture is mirrored, which the sign beside the tangent tells. Where texture coordinates say nothing (no area in the
texture, or neighbours that cancel) the tangent is that of `world_from_tangent`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.directions import Vectors, dot, normalize, world_from_tangent

#: A direction whose part in the surface is smaller than this share of it counts as one along the normal.
ALONG_NORMAL = 1e-6


def frames_along(normal: ArrayLike, direction: ArrayLike) -> Vectors:
    """Frames (..., 3, 3) with columns tangent, bitangent, normal, their determinant +1.

    The tangent is `direction` (..., 3), of any length, projected into the plane of the unit `normal` (..., 3). Where
    that leaves nothing, or is not finite, it is the tangent of `world_from_tangent`.
    """
    n, along = np.broadcast_arrays(np.asarray(normal, np.float64), np.asarray(direction, np.float64))
    along = normalize(along, fallback=(0.0, 0.0, 0.0))
    inside = along - dot(n, along)[..., None] * n
    usable = np.sqrt(dot(inside, inside)) > ALONG_NORMAL
    frames = world_from_tangent(n)
    tangent = normalize(inside)
    # once more, because where little is left the first projection has lost digits
    tangent = normalize(tangent - dot(n, tangent)[..., None] * n)
    tangent = np.where(usable[..., None], tangent, frames[..., 0])
    bitangent = np.where(usable[..., None], np.cross(n, tangent), frames[..., 1])
    return np.stack([tangent, bitangent, n], axis=-1)


def uv_tangents(
    positions: NDArray[np.float64], normals: NDArray[np.float32], uv: NDArray[np.float32], faces: NDArray[np.int32]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Unit tangents (V, 3) of vertices, weighted by the area of the faces that meet there, and signs (V,).

    The sign is −1 where the texture is seen mirrored: v then grows against n × t.
    """
    corners, texture = positions[faces], uv[faces].astype(np.float64)
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    one, two = texture[:, 1] - texture[:, 0], texture[:, 2] - texture[:, 0]
    area_in_texture = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]
    sign = np.sign(area_in_texture)
    grows = normalize(first * two[:, 1:] - second * one[:, 1:], fallback=(0.0, 0.0, 0.0)) * sign[:, None]
    directed = np.cross(first, second)
    area = np.sqrt(dot(directed, directed))
    vertex, count = faces.ravel(), len(positions)
    parts = np.column_stack([grows, sign]) * area[:, None]
    summed = np.stack([np.bincount(vertex, np.repeat(part, 3), count) for part in parts.T], axis=-1)
    frames = frames_along(normalize(normals), summed[:, :3])
    return frames[..., 0], np.where(summed[:, 3] < 0.0, -1.0, 1.0)

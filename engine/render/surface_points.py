"""Surface points that rays meet: the point, its frame, and the origin of its rays towards light.

Shading follows `engine.render.direct`: the interpolated normal on the side that is seen, bent where it would point
away from the viewer. Both sides of a surface are alike. Rays towards light leave from the interpolated point, lifted
onto the smooth surface that the normals describe where that bulges over the triangle (after Hanika, *Hacking the
Shadow Terminator*, Ray Tracing Gems II, 2021, but edge by edge): a convex model then casts no shadow on itself above
the horizon of its normals, as it casts none on its vertices, and the coarseness of its triangles does not show at the
terminator. Where normals are those of the triangles, nothing is lifted.
"""

from __future__ import annotations

import numpy as np

from engine.core.kernels import scalar

#: Least cosine between the normal that shades and the direction of view.
MIN_FACING = 0.01


@scalar
def surface_points(
    faces: np.ndarray,
    barycentric: np.ndarray,
    incoming: np.ndarray,
    positions: np.ndarray,
    normals: np.ndarray,
    triangles: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """For hits (N,) with weights (N, 3) of rays along `incoming` (N, 3), in order:

    the lifted points (N, 3), the normals of the triangles on the side that is seen (N, 3), frames (N, 3, 3) with
    columns tangent, bitangent and normal, where the tangent is any, and the viewer in that frame (N, 3).
    """
    count = faces.size
    point, flat = np.empty((count, 3)), np.empty((count, 3))
    frame, viewer = np.empty((count, 3, 3)), np.empty((count, 3))
    corner, edge, away, shading = np.empty((3, 3)), np.empty((2, 3)), np.empty(3), np.empty(3)
    for n in range(count):
        triangle = triangles[faces[n]]
        weight = barycentric[n]
        for k in range(3):
            for i in range(3):
                corner[k, i] = positions[triangle[k], i]
        for i in range(3):
            point[n, i] = weight[0] * corner[0, i] + weight[1] * corner[1, i] + weight[2] * corner[2, i]
            edge[0, i], edge[1, i] = corner[1, i] - corner[0, i], corner[2, i] - corner[0, i]
            away[i] = -incoming[n, i]
            shading[i] = 0.0
            for k in range(3):
                shading[i] += weight[k] * normals[triangle[k], i]
        side = _flat_normal(edge, away, flat[n])
        _visible_normal(shading, flat[n], away, side)
        _frame(shading, frame[n])
        for j in range(3):
            viewer[n, j] = frame[n, 0, j] * away[0] + frame[n, 1, j] * away[1] + frame[n, 2, j] * away[2]
        _lift(point[n], corner, weight, normals, triangle, side)
    return point, flat, frame, viewer


@scalar
def _flat_normal(edge: np.ndarray, away: np.ndarray, flat: np.ndarray) -> float:
    """Put the unit normal of a triangle on the side of `away` into `flat`; return which side that is, 1 or −1."""
    scale = max(np.abs(edge).max(), 1e-300)
    ax, ay, az = edge[0, 0] / scale, edge[0, 1] / scale, edge[0, 2] / scale
    bx, by, bz = edge[1, 0] / scale, edge[1, 1] / scale, edge[1, 2] / scale
    x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    length = np.sqrt(x * x + y * y + z * z)
    side = -1.0 if x * away[0] + y * away[1] + z * away[2] < 0.0 else 1.0
    if length > 0.0:
        flat[0], flat[1], flat[2] = side * x / length, side * y / length, side * z / length
    else:
        flat[:] = away
    return side


@scalar
def _visible_normal(shading: np.ndarray, flat: np.ndarray, away: np.ndarray, side: float) -> None:
    """Make the interpolated normal in `shading` the unit one that `engine.render.direct` shades with."""
    length = np.sqrt(shading[0] ** 2 + shading[1] ** 2 + shading[2] ** 2)
    for i in range(3):
        shading[i] = shading[i] * side / length if length > 0.0 else flat[i]
    facing = shading[0] * away[0] + shading[1] * away[1] + shading[2] * away[2]
    if facing < MIN_FACING:
        for i in range(3):
            shading[i] += (MIN_FACING - facing) * away[i]
        length = np.sqrt(shading[0] ** 2 + shading[1] ** 2 + shading[2] ** 2)
        for i in range(3):
            shading[i] /= length


@scalar
def _frame(normal: np.ndarray, frame: np.ndarray) -> None:
    """Columns tangent, bitangent, normal, of which the normal alone is given (Duff2017)."""
    x, y, z = normal[0], normal[1], normal[2]
    sign = -1.0 if z < 0.0 else 1.0
    a = -1.0 / (sign + z)
    b = x * y * a
    frame[0, 0], frame[1, 0], frame[2, 0] = 1.0 + sign * x * x * a, sign * b, -sign * x
    frame[0, 1], frame[1, 1], frame[2, 1] = b, sign + y * y * a, -y
    frame[0, 2], frame[1, 2], frame[2, 2] = x, y, z


@scalar
def _lift(
    point: np.ndarray, corner: np.ndarray, weight: np.ndarray, normals: np.ndarray, triangle: np.ndarray, side: float
) -> None:
    """Move `point` towards the planes through the corners perpendicular to their normals.

    How far the surface bulges over an edge is the lesser of what the normals at its two ends say, and nothing where
    one of them does not see the other end below its plane: normals that all lean one way lift nothing.
    """
    for k in range(3):
        height = 0.0
        for j in range(3):
            if j != k:
                here, there = 0.0, 0.0
                for i in range(3):
                    edge = side * (corner[k, i] - corner[j, i])
                    here += edge * normals[triangle[k], i]
                    there -= edge * normals[triangle[j], i]
                height += weight[j] * max(min(here, there), 0.0)
        for i in range(3):
            point[i] += side * weight[k] * height * normals[triangle[k], i]

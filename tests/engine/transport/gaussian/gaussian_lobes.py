"""Samples of transport functions that tests of the Gaussian fit share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from engine.brdf.brdf import brdf_from_text
from engine.core.directions import world_from_tangent
from engine.geometry.mesh import Mesh
from engine.light.gaussian_prefilter import gaussian_integral
from engine.transport.gaussian.fitting.fit import TransportSamples
from engine.transport.gaussian.fitting.lobes import gaussian
from engine.transport.gaussian.fitting.views import view_directions

#: Transport at a vertex: RGB of a direction, a view and the number of the vertex.
Transport = Callable[[np.ndarray], np.ndarray]


def unit(vector: ArrayLike) -> np.ndarray:
    array = np.asarray(vector, np.float64)
    return array / np.linalg.norm(array, axis=-1)[..., None]


def spiral(count: int) -> np.ndarray:
    """(count, 2) places in the unit square, even in both."""
    index = np.arange(count) + 0.5
    return np.column_stack([index / count, index * 0.6180339887498949 % 1.0])


def around(mean: np.ndarray, sigma: float, count: int) -> np.ndarray:
    """(count, 3) directions as dense as a Gaussian."""
    u, v = spiral(count).T
    z = np.clip(1.0 + sigma**2 * np.log1p(u * np.expm1(-2.0 / sigma**2)), -1.0, 1.0)
    frame, across = world_from_tangent(mean), np.sqrt(1.0 - z * z)
    local = np.column_stack([across * np.cos(2 * np.pi * v), across * np.sin(2 * np.pi * v), z])
    return local @ frame.T


def places(lobes: Sequence[tuple[np.ndarray, float, int]], even: int) -> tuple[np.ndarray, np.ndarray]:
    """Directions and solid angles: so many about each mean, as dense as Gaussians, and `even` ones everywhere."""
    direction = np.concatenate([around(np.array([0.0, 0.0, 1.0]), 1e3, even), *(around(*lobe) for lobe in lobes)])
    density = np.full(len(direction), even / (4.0 * np.pi))
    for mean, sigma, count in lobes:
        density += count * gaussian(direction, mean, sigma) / gaussian_integral(sigma)
    return direction, 1.0 / density


def one_gaussian(
    mean: ArrayLike = (0.0, 0.6, 0.8), sigma: float = 0.2, weight: ArrayLike = (1.0, 2.0, 0.5)
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Direction, value and area of samples of a Gaussian."""
    centre = unit(mean)
    direction, area = places([(centre, 1.3 * sigma, 200), (centre, min(3.0 * sigma, 1.5), 100)], 150)
    return direction, gaussian(direction, centre, sigma)[:, None] * np.asarray(weight), area


def gather(views: Sequence[tuple[np.ndarray, np.ndarray, np.ndarray] | None]) -> TransportSamples:
    """Samples of direction, value and area for each vertex and view in turn; None where nothing is reflected."""
    count = [0 if view is None else len(view[2]) for view in views]
    lit = [view for view in views if view is not None]
    start = np.concatenate([[0], np.cumsum(count)]).astype(np.int64)
    if not lit:
        return TransportSamples(start, np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))
    return TransportSamples(start, *(np.concatenate([view[part] for view in lit]) for part in range(3)))


def reflecting(normals: np.ndarray, brdf: str, widths: tuple[float, float] = (0.25, 0.8)) -> TransportSamples:
    """f cos of an analytic model at vertices (B, 3) that nothing hides, towards the 92 views."""
    model = brdf_from_text(brdf)
    found: list[Any] = []
    for normal in normals:
        frame = world_from_tangent(normal)
        for view in view_directions():
            cosine = view @ normal
            if cosine <= 1e-3:
                found.append(None)
                continue
            mirror = unit(2.0 * cosine * normal - view)
            direction, area = places([(mirror, widths[0], 130), (mirror, widths[1], 90)], 120)
            up = np.maximum(direction @ normal, 0.0)
            value = model.f(direction @ frame, (view @ frame)[None]) * up[:, None]
            found.append((direction, value, area))
    return gather(found)


def icosphere(subdivisions: int) -> Mesh:
    """A sphere of 42, 162, … vertices."""
    import trimesh

    made = trimesh.creation.icosphere(subdivisions=subdivisions)
    positions = np.array(made.vertices, np.float64)
    uv = np.zeros((len(positions), 2), np.float32)
    return Mesh(positions, positions.astype(np.float32), uv, np.array(made.faces, np.int32), "sphere")

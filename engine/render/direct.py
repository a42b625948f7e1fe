"""Draws a `Scene` on the processor: embree finds what each pixel sees, numpy shades it.

The twin of `engine.gl.direct`, for machines without OpenGL and as its reference: the same sub-pixels, the same formulas
in float64, the same mip-maps chosen from differences over the same 2 × 2 blocks. About 1 s per million sub-pixels.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.colour import luminance
from engine.directions import dot, normalize, world_from_tangent
from engine.scene import Scene
from engine.shading.lookup import neighbours, share_and_gain
from engine.shading.power_law import PowerLawMap
from engine.shading.shading_map import ShadingMap
from engine.steps import Step, Steps

Array = NDArray[np.float64]

#: A shading map, or scale and exponent side by side (H, W, 6), at falling sizes.
Levels = list[ShadingMap | NDArray[np.float32]]

#: Sub-pixels of one band, about 50 ms of work.
BAND = 40_000


def radiance(scene: Scene, size: tuple[int, int], *, samples: int = 2) -> Steps[NDArray[np.float32]]:
    """The picture (height, width, 4) float32 of `size` (width, height): linear radiance times coverage, and coverage.

    Equal to `DirectRenderer.radiance`. Samples that are not finite are 0.
    """
    width, height = size
    if samples < 1:
        raise ValueError(f"samples = {samples} must be at least 1")
    picture = np.zeros((height, width, 4), np.float32)
    if min(size) < 1:
        return picture
    tracer = _tracer(scene)
    levels = _mip_levels(scene.shading)
    band = max(1, BAND // (width * samples * samples))
    for top in range(0, height, band):
        rows = slice(top, min(top + band, height))
        samples_of_band = _shade_band(scene, tracer, levels, size, rows, samples)
        blocks = samples_of_band.reshape(rows.stop - top, samples, width, samples, 4)
        picture[rows] = blocks.mean(axis=(1, 3))
        yield Step(rows.stop / height, "Rendering on the processor", picture)
    return picture


def _tracer(scene: Scene) -> Any:
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    tracer = EmbreeScene()
    TriangleMesh(tracer, _vertices(scene).astype(np.float32), scene.mesh.faces)
    return tracer


def _vertices(scene: Scene) -> Array:
    return scene.mesh.positions - scene.mesh.centre


def _shade_band(
    scene: Scene,
    tracer: Any,
    levels: Levels,
    size: tuple[int, int],
    rows: slice,
    samples: int,
) -> Array:
    """(sub-pixels, 4) of the pixel rows `rows`: radiance and coverage 1 where the mesh is hit, else 0."""
    width, height = size[0] * samples, size[1] * samples
    row, column = np.mgrid[rows.start * samples : rows.stop * samples, 0:width].reshape(2, -1)
    rays = scene.camera.rays(column + 0.5, row + 0.5, width, height)
    eye = np.subtract(scene.camera.eye, scene.mesh.centre)
    origins = np.broadcast_to(eye.astype(np.float32), rays.shape)
    hit = tracer.run(np.ascontiguousarray(origins), rays.astype(np.float32))
    seen = np.flatnonzero(hit >= 0)
    picture = np.zeros((len(rays), 4))
    if seen.size == 0:
        return picture
    row, column, faces = row[seen], column[seen], scene.mesh.faces[hit[seen]]
    triangle = _vertices(scene)[faces]

    def at(column: Array, row: Array) -> Array:
        return _barycentric(eye, scene.camera.rays(column, row, width, height), triangle)

    weights = at(column + 0.5, row + 0.5)
    position = np.einsum("nc,nci->ni", weights, triangle)
    wo = normalize(eye - position)
    normal = _visible_normal(np.einsum("nc,nci->ni", weights, scene.mesh.normals[faces]), triangle, wo)
    tangent_from_world = np.swapaxes(world_from_tangent(normal), -1, -2)
    wi_local = tangent_from_world @ np.asarray(scene.light)
    f = scene.brdf.f(wi_local, np.einsum("nij,nj->ni", tangent_from_world, wo))
    cosine = np.maximum(wi_local[:, 2], 0.0)
    if scene.shading is None:
        value = f * (cosine * scene.irradiance)[:, None]
    else:
        uv = _texture_coordinates(scene, faces)
        first_column, last_row = column - column % 2, row + (height - 1 - row) % 2
        here = np.einsum("nc,nci->ni", weights, uv)
        along = [
            np.einsum("nc,nci->ni", at(first_column + 1.5, row + 0.5) - at(first_column + 0.5, row + 0.5), uv),
            np.einsum("nc,nci->ni", at(column + 0.5, last_row - 0.5) - at(column + 0.5, last_row + 0.5), uv),
        ]
        value = _looked_up(scene, levels, here, along, luminance(f).astype(np.float64), cosine)
    picture[seen, :3] = np.where(np.isfinite(value).all(axis=1, keepdims=True), np.maximum(value, 0.0), 0.0)
    picture[seen, 3] = 1.0
    return picture


def _barycentric(eye: Array, rays: Array, triangle: Array) -> Array:
    """(N, 3) weights of the corners where each ray meets the plane of its triangle, inside it or not."""
    first, second = triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0]
    across = np.cross(rays, second)
    determinant = dot(first, across)
    determinant = np.where(determinant == 0.0, np.finfo(float).tiny, determinant)
    offset = eye - triangle[:, 0]
    u = dot(offset, across) / determinant
    v = dot(rays, np.cross(offset, first)) / determinant
    return np.stack([1.0 - u - v, u, v], axis=-1)


def _visible_normal(normal: Array, triangle: Array, wo: Array) -> Array:
    """The shading normal on the side that is seen, bent where it would point away from the viewer (direct.frag)."""
    directed = np.cross(triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0])
    side = np.where(dot(directed, wo) < 0.0, -1.0, 1.0)[:, None]
    flat = normalize(directed) * side
    length = np.sqrt(dot(normal, normal))[:, None]
    normal = np.where(length > 0.0, normal / np.where(length > 0.0, length, 1.0), flat * side) * side
    facing = dot(normal, wo)[:, None]
    return np.where(facing < 0.01, normalize(normal + (0.01 - facing) * wo), normal)


def _texture_coordinates(scene: Scene, faces: NDArray[np.int32]) -> Array:
    """(N, 3, 2) of the corners, v down, one unit per repeat."""
    uv = scene.mesh.uv[faces].astype(np.float64)
    return np.stack([uv[..., 0], 1.0 - uv[..., 1]], axis=-1) * scene.repeats


def _looked_up(scene: Scene, levels: Levels, uv: Array, along: list[Array], f: Array, cosine: Array) -> Array:
    """Radiance (N, 3) by the scene's kind of look-up; `f` is the luminance of the BRDF, `along` d(uv)/d(pixel)."""
    assert scene.shading is not None
    r_max = scene.shading.r_max
    reflectance = scene.sigma * f
    r = reflectance * cosine
    layer, gain = {
        "radiance": (r, np.full_like(r, scene.irradiance)),
        "outgoing": (r * scene.irradiance, np.ones_like(r)),
        "texture": (np.full_like(r, r_max), r / r_max * scene.irradiance),
        "angle": (r_max * cosine, reflectance / r_max * scene.irradiance),
    }[scene.lookup]
    detail = _level_of_detail(levels, along)
    if isinstance(scene.shading, ShadingMap):

        def at(level: Any, row: Array, column: Array, used: NDArray[np.bool_]) -> Array:
            return np.asarray(level.lookup(row, column, layer[used], scene.above), np.float64)

        value = _filtered(levels, uv, detail, 3, at)
    else:
        pair = _filtered(levels, uv, detail, 6, _bilinear)
        share, above = share_and_gain(layer, r_max, scene.above)
        share = share[:, None]
        power = np.where(share > 0.0, np.where(share > 0.0, share, 1.0) ** np.maximum(pair[:, 3:], 0.0), 0.0)
        value = pair[:, :3] * power * above[:, None]
    return value * gain[:, None]


def _level_of_detail(levels: Levels, along: list[Array]) -> Array:
    height, width = _image_size(levels[0])
    texels = [step * (width, height) for step in along]
    squared = np.maximum(np.maximum(dot(texels[0], texels[0]), dot(texels[1], texels[1])), 1e-30)
    return np.clip(0.5 * np.log2(squared), 0.0, len(levels) - 1)


def _filtered(levels: Levels, uv: Array, detail: Array, channels: int, at: Callable[..., Array]) -> Array:
    """Mix of the two mip levels nearest to `detail`, (N, channels); `at(level, row, column, used)` looks one up."""
    value = np.zeros((len(uv), channels))
    for number, level in enumerate(levels):
        weight = np.maximum(1.0 - np.abs(detail - number), 0.0)
        used = weight > 0.0
        rows, columns = _image_size(level)
        value[used] += weight[used, None] * at(level, uv[used, 1] * rows, uv[used, 0] * columns, used)
    return value


def _bilinear(image: Any, row: Array, column: Array, _used: NDArray[np.bool_]) -> Array:
    value = np.zeros((len(row), image.shape[2]))
    for rows, columns, weight in neighbours(row, column, *image.shape[:2]):
        value += weight[:, None] * image[rows, columns]
    return value


def _image_size(level: ShadingMap | NDArray[np.float32]) -> tuple[int, int]:
    shape = level.slices.shape[1:3] if isinstance(level, ShadingMap) else level.shape[:2]
    return shape[0], shape[1]


def _mip_levels(shading: ShadingMap | PowerLawMap | None) -> Levels:
    """The map at full size, at half, at a quarter … down to one texel, as OpenGL makes mip-maps.

    The power law's pair is one image of six channels: as on the GPU, the pair is filtered and then evaluated.
    """
    levels: Levels = []
    if isinstance(shading, ShadingMap):
        levels.append(shading)
    elif shading is not None:
        levels.append(np.concatenate([shading.scale, shading.exponent], axis=-1))
    while levels and max(_image_size(levels[-1])) > 1:
        last = levels[-1]
        if isinstance(last, ShadingMap):
            slices = np.stack([_half(image) for image in last.slices])
            levels.append(dataclasses.replace(last, slices=slices, clipped=None))
        else:
            levels.append(np.concatenate([_half(last[..., :3]), _half(last[..., 3:])], axis=-1))
    return levels


def _half(image: NDArray[np.float32]) -> NDArray[np.float32]:
    import cv2

    height, width = image.shape[:2]
    size = (max(1, width // 2), max(1, height // 2))
    half: NDArray[np.float32] = cv2.resize(np.ascontiguousarray(image), size, interpolation=cv2.INTER_LINEAR)
    return half.reshape(size[1], size[0], 3)

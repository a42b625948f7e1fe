"""The images of a material at falling sizes, and their filtered values at points: the mip-maps of OpenGL, in numpy.

A material's images are layers of three channels: the slices of a shading map, the pair of a power law and its kept
tiles, the planes of a directional map by three, whose small sizes stand for mean radiance, or PBR maps (base colour;
roughness, metallic and f0; normals; the products of their components, whose means tell the spread of normals; what
joins base colour and metallic; and how roughness and metallic differ). Bound by memory: some 40 ns a point and layer.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.models.multiple_scattering import SMOOTHEST
from engine.core.directions import dot
from engine.shading.directional.planes import DirectionalMap
from engine.shading.lookup import neighbours
from engine.shading.power_law import PowerLawMap
from engine.shading.shading_map import ShadingMap
from engine.surface.pbr_maps import PbrMaps

Array = NDArray[np.float64]

#: The images that are looked up, (layers, H, W, 3), at falling sizes.
Levels = list[NDArray[np.float32]]


def level_of_detail(levels: Levels, along: list[Array]) -> Array:
    """(N,) the mip level for the change of coordinates between pixels, `along` is d(uv) / d(pixel) in x and in y."""
    height, width = levels[0].shape[1:3]
    texels = [step * (width, height) for step in along]
    squared = np.maximum(np.maximum(dot(texels[0], texels[0]), dot(texels[1], texels[1])), 1e-30)
    return np.clip(0.5 * np.log2(squared), 0.0, len(levels) - 1)


def filter_levels(levels: Levels, layer: int, uv: Array, detail: Array) -> Array:
    """One layer, bilinear in the two mip levels nearest to `detail`, (N, 3)."""
    value = np.zeros((len(uv), 3))
    for number, level in enumerate(levels):
        weight = np.maximum(1.0 - np.abs(detail - number), 0.0)
        used = np.flatnonzero(weight)
        rows, columns = level.shape[1:3]
        for row, column, share in neighbours(uv[used, 1] * rows, uv[used, 0] * columns, rows, columns):
            value[used] += (weight[used] * share)[:, None] * level[layer, row, column]
    return value


def mip_levels(shading: ShadingMap | PowerLawMap | DirectionalMap | PbrMaps | None) -> Levels:
    """The map at full size, at half, at a quarter … down to one texel, as OpenGL makes mip-maps."""
    if shading is None:
        return []
    if isinstance(shading, DirectionalMap):
        return [full_size(shading), *map(planes_by_three, shading.smaller)]
    if isinstance(shading, PowerLawMap):
        return power_law_levels(full_size(shading))
    if isinstance(shading, PbrMaps):
        return pbr_levels(full_size(shading))
    return halves(full_size(shading))


def halves(layers: NDArray[np.float32]) -> Levels:
    """The layers (L, H, W, 3) and their means at half the size, at a quarter … down to one texel."""
    levels = [layers]
    while max(levels[-1].shape[1:3]) > 1:
        levels.append(np.stack([half(image) for image in levels[-1]]))
    return levels


def power_law_levels(layers: NDArray[np.float32]) -> Levels:
    """Scale, exponent and what else follows (L, H, W, 3) at falling sizes, which keep the mean radiance.

    The mean of k (r / r_max)^K over texels is no such power. The one that is shown is as bright under the brightest
    light, and its mean over r is the same: k / (1 + K) is averaged, and not K.
    """
    scale, exponent = layers[:2]
    means = halves(np.concatenate([np.stack([scale, scale / (1.0 + exponent), exponent]), layers[2:]]))
    smaller = []
    for scale, area, exponent, *others in means[1:]:
        lit = area > 0.0
        found = np.where(lit, np.maximum(scale / np.where(lit, area, 1.0) - 1.0, 0.0), exponent)
        smaller.append(np.stack([scale, found, *others]).astype(np.float32))
    return [layers, *smaller]


def full_size(shading: ShadingMap | PowerLawMap | DirectionalMap | PbrMaps) -> NDArray[np.float32]:
    """(layers, H, W, 3) the images of a map."""
    if isinstance(shading, DirectionalMap):
        return planes_by_three(shading.planes)
    if isinstance(shading, PbrMaps):
        return pbr_layers(shading)
    return shading.slices if isinstance(shading, ShadingMap) else _layers(shading)


def planes_by_three(planes: NDArray[np.uint8] | NDArray[np.float16]) -> NDArray[np.float32]:
    """(ceil(K / 3), H, W, 3) the codes of planes (K, H, W) as the channels of layers, the last filled up with 0."""
    filled = np.concatenate([planes, np.zeros((-len(planes) % 3, *planes.shape[1:]), planes.dtype)])
    layers = filled.reshape(-1, 3, *planes.shape[1:])
    return np.ascontiguousarray(np.moveaxis(layers, 1, 3), np.float32)


def pbr_layers(maps: PbrMaps) -> NDArray[np.float32]:
    """(4, H, W, 3): base colour; roughness, metallic and f0; the components of normals; their products xx, yy, xy."""
    x, y = maps.normal[..., 0], maps.normal[..., 1]
    gloss = np.stack([maps.roughness, maps.metallic, maps.f0], axis=2)
    return np.stack([maps.base_colour, gloss, maps.normal, np.stack([x * x, y * y, x * y], axis=2)])


def pbr_levels(layers: NDArray[np.float32]) -> Levels:
    """PBR maps (4, H, W, 3) at falling sizes, (6, H, W, 3) each, with how texels differ below one in two more layers.

    These are the covariances of base colour and metallic, as metal may be brighter than what is none; and the variance
    and the third moment about the mean of the logarithm of roughness, and the variance of metallic. They are taken
    between texels, where filters show neither the one nor the other. All are 0 at full size.
    """
    centre = np.log(np.maximum(layers[1, ..., 0], SMOOTHEST)).mean()

    def powers(fine: NDArray[np.float32]) -> NDArray[np.float32]:
        base, gloss = fine[:2]
        logarithm = np.log(np.maximum(gloss[..., 0], SMOOTHEST)) - centre
        square = np.broadcast_to(gloss[..., 1:2] ** 2, base.shape)
        return np.stack([base * gloss[..., 1:2], np.stack([logarithm, logarithm**2, logarithm**3], axis=-1), square])

    def differences(level: NDArray[np.float32]) -> NDArray[np.float32]:
        metallic, (first, second, third) = level[1, ..., 1], np.moveaxis(level[5], -1, 0)
        joint = level[4] - level[0] * metallic[..., None]
        about_mean = third - 3.0 * first * second + 2.0 * first**3
        return np.stack([joint, np.stack([second - first**2, about_mean, level[6, ..., 0] - metallic**2], axis=-1)])

    means = halves(np.concatenate([layers, _mean_between(layers, powers)]))
    levels = [np.concatenate([layers, np.zeros_like(layers[:2])])]
    for level in means[1:]:
        levels.append(np.concatenate([level[:4], _mean_between(level, differences)]).astype(np.float32))
    return levels


def _mean_between(layers: NDArray[np.float32], of: Callable[[NDArray[np.float32]], NDArray[np.float32]]) -> Any:
    """The mean over each texel of what `of` makes of layers there: at four places, a quarter of a texel off."""
    return 0.25 * sum(of(_between_texels(layers, down, along)) for down in (-1, 1) for along in (-1, 1))


def _between_texels(layers: NDArray[np.float32], down: int, along: int) -> NDArray[np.float32]:
    """Layers (L, H, W, 3) a quarter of a texel down or up, and to the right or left, as filters show them."""
    rows = 0.75 * layers + 0.25 * np.roll(layers, -down, axis=1)
    return np.asarray(0.75 * rows + 0.25 * np.roll(rows, -along, axis=2))


def _layers(power_law: PowerLawMap) -> NDArray[np.float32]:
    """Scale and exponent, and where tiles are kept their coverage and their slices, which are 0 elsewhere."""
    pair = np.stack([power_law.scale, power_law.exponent])
    if power_law.kept is None:
        return pair
    height, width = power_law.error_map.shape
    covered = np.repeat(power_law.kept.covers(height, width)[None, ..., None].astype(np.float32), 3, axis=3)
    return np.concatenate([pair, covered, power_law.kept.slice_images(height, width)])


def half(image: NDArray[Any]) -> NDArray[np.float32]:
    """(H // 2, W // 2, channels) an image (H, W, channels) at half its size, at least one texel each way."""
    import cv2

    height, width, channels = image.shape
    size = (max(1, width // 2), max(1, height // 2))
    smaller = cv2.resize(np.ascontiguousarray(image, np.float32), size, interpolation=cv2.INTER_LINEAR)
    return np.asarray(smaller, np.float32).reshape(size[1], size[0], channels)

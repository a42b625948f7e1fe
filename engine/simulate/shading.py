"""Radiance of a height field under a lamp, seen by an orthographic camera straight above.

Physics. A texel at height h with unit normal n = (-dh/dx, -dh/dy, 1) / sqrt(1 + |grad h|^2) is lit by a lamp in
direction l = (cos e cos a, cos e sin a, sin e) for elevation e and azimuth a. A lamp whose irradiance on a surface
that faces it is E makes it reflect

    L = E V max(0, n . l) (rho / pi + f_s(l, v)),    v = (0, 0, 1)

with albedo rho, the share V of the lamp that relief leaves visible (`shadows`), and a specular lobe f_s: GGX with
Smith's height-correlated masking and Schlick's Fresnel term (Walter2007; Heitz2014). The camera measures
radiance, so the tilt of a texel towards the viewer enters only through n . l: foreshortening scales the projected area
of a facet and the light it sends alike. For a flat diffuse sample L = E rho sin(e) / pi.

Near lamp. A lamp at distance D from the middle of the image lights the texel at p from the direction of
u = l - p / D with the irradiance E / |u|^2; a distant one is the case 1 / D = 0. E is that in the middle.

Interreflection, where asked for, is diffuse: the part of a texel's hemisphere that its horizons hide is taken to shine
with the mean radiance of the neighbourhood, of which the lamp and all earlier bounces are part,

    L = L_0 + rho (1 - open) A,    A = blur(L)

solved by `BOUNCES` steps from A = 0. With g the largest rho (1 - open), what is left out is below g^(BOUNCES + 1) of
the light, and light stays below L_0 / (1 - g).
Cost: 40 ms per megatexel and light, 0.1 s more with all bounces, which are followed at half resolution.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import parallel, prange, scalar
from engine.simulate.camera import blur
from engine.simulate.height_fields import Sample

BOUNCES = 4


def light_direction(elevation: float, azimuth: float) -> NDArray[np.float64]:
    """(3,) unit vector towards the lamp; azimuth counts from +x (right) towards +y (up the image)."""
    across = math.cos(elevation)
    return np.array([across * math.cos(azimuth), across * math.sin(azimuth), math.sin(elevation)])


def surface_slope(height: NDArray[np.float32]) -> NDArray[np.float32]:
    """(H, W, 2) dh/dx and dh/dy of a periodic height field, by central differences over two texels."""
    across = (np.roll(height, -1, axis=1) - np.roll(height, 1, axis=1)) / np.float32(2)
    upward = (np.roll(height, 1, axis=0) - np.roll(height, -1, axis=0)) / np.float32(2)
    return np.stack([across, upward], axis=-1).astype(np.float32)


def radiance(
    sample: Sample,
    slope: NDArray[np.float32],
    visible: NDArray[np.float32],
    light: NDArray[np.float64],
    nearness: float = 0.0,
) -> NDArray[np.float32]:
    """(H, W, 3) radiance towards the camera, linear sRGB, where a surface that faces the lamp has irradiance one.

    `light` is the direction of the lamp from the middle of the image, `nearness` 1 / D in 1 / texels; heights count
    from their mean.
    """
    image = np.empty(sample.albedo.shape, np.float32)
    plane = float(sample.height.mean(dtype=np.float64))
    maps = (sample.height, slope, sample.albedo, sample.specular, sample.roughness, visible)
    _shade(*maps, plane, light, nearness, image)
    return image


def add_interreflection(
    direct: NDArray[np.float32], albedo: NDArray[np.float32], open_part: NDArray[np.float32], reach: float
) -> NDArray[np.float32]:
    """(H, W, 3) `direct` and what it lights in the relief within some `reach` texels; H and W are even."""
    returned = albedo * (np.float32(1) - open_part)[..., None]
    coarse_direct, coarse_returned = _halve(direct), _halve(returned)
    arriving = blur(coarse_direct, reach / 2)
    for _ in range(BOUNCES - 1):
        arriving = blur(coarse_direct + coarse_returned * arriving, reach / 2)
    returned *= _double(arriving)
    returned += direct
    return returned


def _halve(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Means of 2 x 2 texels."""
    return (image[0::2, 0::2] + image[1::2, 0::2] + image[0::2, 1::2] + image[1::2, 1::2]) * np.float32(0.25)


def _double(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """The periodic image at twice the resolution, linear between texel centres."""
    for axis in (0, 1):
        near, far = np.float32(0.75), np.float32(0.25)
        halves = [near * image + far * np.roll(image, towards, axis) for towards in (1, -1)]
        image = np.stack(halves, axis=axis + 1).reshape([(1 + (a == axis)) * n for a, n in enumerate(image.shape)])
    return image


@parallel
def _shade(
    height: np.ndarray,
    slope: np.ndarray,
    albedo: np.ndarray,
    specular: np.ndarray,
    roughness: np.ndarray,
    visible: np.ndarray,
    plane: float,
    light: np.ndarray,
    nearness: float,
    image: np.ndarray,
) -> None:
    """Bound by arithmetic: three square roots and some sixty operations to a texel."""
    rows, columns = roughness.shape
    for row in prange(rows):
        for column in range(columns):
            to_x = light[0] - nearness * (column + 0.5 - 0.5 * columns)
            to_y = light[1] + nearness * (row + 0.5 - 0.5 * rows)
            to_z = light[2] - nearness * (height[row, column] - plane)
            far = 1.0 / math.sqrt(to_x * to_x + to_y * to_y + to_z * to_z)
            to_x, to_y, to_z = to_x * far, to_y * far, to_z * far
            dx, dy = slope[row, column, 0], slope[row, column, 1]
            n_z = 1.0 / math.sqrt(1.0 + dx * dx + dy * dy)
            cosine = max(0.0, (to_z - dx * to_x - dy * to_y) * n_z)
            half = 1.0 / math.sqrt(2.0 + 2.0 * to_z)
            n_h = (to_z + 1.0 - dx * to_x - dy * to_y) * n_z * half
            lobe = _ggx(max(cosine, 1e-6), n_z, n_h, roughness[row, column])
            fresnel = (1.0 - (to_z + 1.0) * half) ** 5
            arriving = visible[row, column] * cosine * far * far
            for channel in range(3):
                base = specular[row, column, channel]
                gloss = lobe * (base + (1.0 - base) * fresnel) if base > 0.0 else 0.0
                image[row, column, channel] = arriving * (albedo[row, column, channel] / math.pi + gloss)


@scalar
def _ggx(n_l: float, n_v: float, n_h: float, alpha: float) -> float:
    """D G / (4 (n.l) (n.v)) with Smith's height-correlated G (Heitz2014 Eq. 99), in 1/sr, without the cosine."""
    squared = alpha * alpha
    spread = n_h * n_h * (squared - 1.0) + 1.0
    density = squared / (math.pi * spread * spread)
    masking_l = n_v * math.sqrt(n_l * n_l * (1.0 - squared) + squared)
    masking_v = n_l * math.sqrt(n_v * n_v * (1.0 - squared) + squared)
    return density * 0.5 / (masking_l + masking_v)

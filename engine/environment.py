"""Distant light all around: equirectangular environment maps and directions chosen by their importance.

Layout as OpenEXR's latitude-longitude maps: linear radiance, +Y up, row 0 at +Y, the centre of the picture looks along
+Z, +X at u = 1/4: u = atan2(x, -z) / 2 pi mod 1, v = acos(y) / pi. Texel solid angles are exact,
dw = (2 pi / W) (cos theta_top - cos theta_bottom), and enter an integral exactly once.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from engine.colour import luminance
from engine.health import Health

if TYPE_CHECKING:
    from scipy.sparse import csr_array

#: Rows to which larger maps are averaged before directions are chosen: texels of 0.35 degrees, the sun's disc and less.
CHOICE_ROWS = 512


@dataclass(frozen=True, eq=False)
class EnvironmentMap:
    """Radiance arriving from every direction; `radiance` (H, W, 3) float32 linear sRGB, finite and not negative.

    `health` tells what was repaired in the file it came from.
    """

    radiance: NDArray[np.float32]
    name: str = "environment"
    health: Health = field(default_factory=Health)

    def __post_init__(self) -> None:
        if self.radiance.ndim != 3 or self.radiance.shape[2] != 3 or 0 in self.radiance.shape:
            raise ValueError(f"an environment map has shape (H, W, 3), not {self.radiance.shape}")
        if not np.isfinite(self.radiance).all() or self.radiance.min() < 0:
            raise ValueError("the radiance of an environment map must be finite and not negative")
        self.radiance.flags.writeable = False


@dataclass(frozen=True, eq=False)
class DistantLights:
    """Directional lights: `direction` (N, 3) float64 unit vectors towards them, `irradiance` (N, 3) float64 each.

    Their sum of f cos(theta) irradiance approximates the integral of f cos(theta) L dw.
    """

    direction: NDArray[np.float64]
    irradiance: NDArray[np.float64]

    def turned(self, angle: float) -> DistantLights:
        """The same lights turned about +Y by `angle` in radians: what came from +Z comes from +X after pi / 2."""
        cosine, sine = np.cos(angle), np.sin(angle)
        about_y = np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
        return DistantLights(self.direction @ about_y.T, self.irradiance) if angle else self


def solid_angles(height: int, width: int) -> NDArray[np.float64]:
    """(H, 1) solid angle in sr of a texel in each row; the whole map sums to 4 pi."""
    edges = np.cos(np.linspace(0, np.pi, height + 1))
    return (2 * np.pi / width * (edges[:-1] - edges[1:]))[:, None]


def texel_directions(height: int, width: int) -> NDArray[np.float64]:
    """(H, W, 3) unit vectors through the centres of the texels."""
    v, u = np.meshgrid((np.arange(height) + 0.5) / height, (np.arange(width) + 0.5) / width, indexing="ij")
    return direction_at(u, v)


def direction_at(u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., 3) unit vectors for map coordinates in [0, 1]."""
    azimuth, polar = 2 * np.pi * u, np.pi * v
    return np.stack(
        [np.sin(polar) * np.sin(azimuth), np.cos(polar), -np.sin(polar) * np.cos(azimuth)],
        axis=-1,
    )


def map_coordinates(direction: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(u, v) in [0, 1) and [0, 1] of unit vectors (..., 3)."""
    u = np.arctan2(direction[..., 0], -direction[..., 2]) / (2 * np.pi) % 1.0
    return u, np.arccos(np.clip(direction[..., 1], -1, 1)) / np.pi


def reduced(environment: EnvironmentMap, rows: int) -> EnvironmentMap:
    """The map averaged by area on the sphere to `rows` x 2 `rows` texels; itself where it is not larger.

    New texels may cut old ones: the shares are exact, and so is the whole flux.
    """
    height, width = environment.radiance.shape[:2]
    if height <= rows and width <= 2 * rows:
        return environment
    down = _overlaps(np.cos(np.linspace(0, np.pi, height + 1)), np.cos(np.linspace(0, np.pi, rows + 1)))
    across = _overlaps(np.linspace(0, 1, width + 1), np.linspace(0, 1, 2 * rows + 1))
    summed = (down @ environment.radiance.reshape(height, -1)).reshape(rows, width, 3)
    averaged = np.stack([(across @ summed[..., channel].T).T for channel in range(3)], axis=-1)
    return EnvironmentMap(averaged.astype(np.float32), environment.name, environment.health)


def _overlaps(edges: NDArray[np.float64], wider: NDArray[np.float64]) -> csr_array:
    """Share that each cell between `edges` has of each cell between `wider`, (wider cells, cells); rows sum to 1."""
    start, stop = np.minimum(edges[:-1], edges[1:]), np.maximum(edges[:-1], edges[1:])
    first, last = np.minimum(wider[:-1], wider[1:])[:, None], np.maximum(wider[:-1], wider[1:])[:, None]
    common = np.maximum(np.minimum(stop, last) - np.maximum(start, first), 0.0)
    from scipy.sparse import csr_array  # slow to load, and the window must open at once

    return csr_array(common / common.sum(axis=1, keepdims=True))


@lru_cache(maxsize=4)
def chosen_lights(environment: EnvironmentMap, count: int) -> DistantLights:
    """`important_lights` of the map at no more than CHOICE_ROWS rows, remembered for the maps that are in use."""
    return important_lights(reduced(environment, CHOICE_ROWS), count)


def all_lights(environment: EnvironmentMap) -> DistantLights:
    """Every texel as a light: the dense sum that a choice of directions is measured against."""
    height, width = environment.radiance.shape[:2]
    irradiance = environment.radiance * solid_angles(height, width)[..., None]
    return DistantLights(texel_directions(height, width).reshape(-1, 3), irradiance.reshape(-1, 3))


def important_lights(environment: EnvironmentMap, count: int, seed: int = 0) -> DistantLights:
    """`count` directions drawn where the light is, by inversion of the luminance's distribution at Sobol points.

    Each stands for an equal share of the luminous flux, so the estimate is unbiased over seeds; its error falls about
    as 1 / count for smooth integrands. A map without any light gives lights of zero irradiance. Powers of two are
    spread best. Raises ValueError for a count below 1.
    """
    if count < 1:
        raise ValueError(f"{count} directions are too few")
    height, width = environment.radiance.shape[:2]
    weight = luminance(environment.radiance).astype(np.float64) * solid_angles(height, width)
    total = weight.sum()
    from scipy.stats import qmc  # slow to load, and the window must open at once

    points = qmc.Sobol(2, seed=np.random.default_rng(seed)).random_base2(int(np.ceil(np.log2(count))))[:count]
    if total == 0:
        return DistantLights(direction_at(points[:, 0], points[:, 1]), np.zeros((count, 3)))
    row, v = _invert(np.broadcast_to(weight.sum(axis=1), (count, height)), points[:, 1])
    column, u = _invert(weight[row], points[:, 0])
    colour = environment.radiance[row, column].astype(np.float64)
    share = total / count / luminance(colour)
    return DistantLights(direction_at(u, v), colour * share[:, None])


def _invert(weights: NDArray[np.float64], points: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Cell and continuous coordinate in [0, 1] at which each row of `weights` reaches the fraction in `points`."""
    summed = np.cumsum(weights, axis=1)
    target = points * summed[:, -1]
    cell = np.minimum((summed <= target[:, None]).sum(axis=1), weights.shape[1] - 1)
    before = np.take_along_axis(summed, cell[:, None], 1)[:, 0] - np.take_along_axis(weights, cell[:, None], 1)[:, 0]
    inside = (target - before) / np.take_along_axis(weights, cell[:, None], 1)[:, 0]
    return cell, (cell + np.clip(inside, 0, 1)) / weights.shape[1]

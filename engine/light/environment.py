"""Distant light all around: equirectangular environment maps, and directional lights in their place.

Layout as OpenEXR's latitude-longitude maps: linear radiance, +Y up, row 0 at +Y, the centre of the image looks along
+Z, +X at u = 1/4: u = atan2(x, -z) / 2 pi mod 1, v = acos(y) / pi. Texel solid angles are exact,
dw = (2 pi / W) (cos theta_top - cos theta_bottom), and enter an integral exactly once.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from engine.core.colour import luminance, to_display8
from engine.core.directions import normalize
from engine.core.health import Health
from engine.core.summary import Summary

if TYPE_CHECKING:
    from scipy.sparse import csr_array


@dataclass(frozen=True, eq=False, repr=False)
class EnvironmentMap(Summary):
    """Radiance arriving from every direction; `radiance` (H, W, 3) float32 linear sRGB, finite and not negative.

    `health` says what was repaired in the file it came from.
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

    def summary(self) -> dict[str, Any]:
        """Return what `repr` says."""
        height, width = self.radiance.shape[:2]
        facts = {"name": self.name, "size": f"{width} × {height} texels", "largest": float(self.radiance.max())}
        return {**facts, "warnings": len(self.health.warnings)}

    def _repr_png_(self) -> bytes:
        """Return the map as PNG, at most 384 texels wide, exposed by its median."""
        from engine.images.encode import encode_png

        step = max(1, -(-self.radiance.shape[1] // 384))
        image = self.radiance[::step, ::step]
        return encode_png(to_display8(0.5 * image / max(float(np.median(image)), 1e-9)))


@dataclass(frozen=True, eq=False)
class DistantLights:
    """Directional lights: `direction` (N, 3) float64 unit vectors towards them, `irradiance` (N, 3) float64 each.

    Their sum of f cos(theta) irradiance approximates the integral of f cos(theta) L dw.
    """

    direction: NDArray[np.float64]
    irradiance: NDArray[np.float64]

    def rotate(self, angle: float) -> DistantLights:
        """The same lights rotated about +Y by `angle` in radians: what came from +Z comes from +X after pi / 2."""
        cosine, sine = np.cos(angle), np.sin(angle)
        about_y = np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
        return DistantLights(self.direction @ about_y.T, self.irradiance) if angle else self

    def beside(self, others: DistantLights) -> DistantLights:
        """These lights and then the `others`."""
        return DistantLights(
            np.concatenate([self.direction, others.direction]), np.concatenate([self.irradiance, others.irradiance])
        )


#: No directional light.
NO_LIGHTS = DistantLights(np.zeros((0, 3)), np.zeros((0, 3)))


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


@dataclass(frozen=True, eq=False)
class Cells:
    """Light of a map by cells of equal steps in longitude and latitude.

    `flux` (R, C, 3) float64 is the irradiance that each brings to a surface that faces it, `moment` (R, C, 3) float64
    the luminance of the same times its mean direction, so that a sun smaller than a cell stays where it is.
    """

    flux: NDArray[np.float64]
    moment: NDArray[np.float64]


def reduce(environment: EnvironmentMap, rows: int) -> EnvironmentMap:
    """The map averaged by area on the sphere to `rows` x 2 `rows` texels; itself where it is not larger.

    New texels may cut old ones: the shares are exact, and so is the whole flux.
    """
    height, width = environment.radiance.shape[:2]
    if height <= rows and width <= 2 * rows:
        return environment
    averaged = _average(environment.radiance, rows).astype(np.float32)
    return EnvironmentMap(averaged, environment.name, environment.health)


def _average(image: NDArray[Any], rows: int) -> NDArray[np.float64]:
    """`image` (H, W, 3) averaged by area on the sphere to (`rows`, 2 `rows`, 3)."""
    height, width = image.shape[:2]
    down = _overlaps(np.cos(np.linspace(0, np.pi, height + 1)), np.cos(np.linspace(0, np.pi, rows + 1)))
    across = _overlaps(np.linspace(0, 1, width + 1), np.linspace(0, 1, 2 * rows + 1))
    summed = (down @ image.reshape(height, -1)).reshape(rows, width, 3)
    return np.stack([(across @ summed[..., channel].T).T for channel in range(3)], axis=-1)


def _overlaps(edges: NDArray[np.float64], wider: NDArray[np.float64]) -> csr_array:
    """Share that each cell between `edges` has of each cell between `wider`, (wider cells, cells); rows sum to 1."""
    start, stop = np.minimum(edges[:-1], edges[1:]), np.maximum(edges[:-1], edges[1:])
    first, last = np.minimum(wider[:-1], wider[1:])[:, None], np.maximum(wider[:-1], wider[1:])[:, None]
    common = np.maximum(np.minimum(stop, last) - np.maximum(start, first), 0.0)
    from scipy.sparse import csr_array  # slow to load, and the window must open at once

    return csr_array(common / common.sum(axis=1, keepdims=True))


def cells(environment: EnvironmentMap, rows: int) -> Cells:
    """The light of the map in `rows` x 2 `rows` cells; any map is averaged or refined, and the whole flux is kept."""
    height, width = environment.radiance.shape[:2]
    seen_from = texel_directions(height, width) if height > rows else texel_directions(rows, 2 * rows)
    radiance = environment.radiance.astype(np.float64)
    if height <= rows:
        radiance = _average(radiance, rows)
    moment = luminance(radiance)[..., None].astype(np.float64) * seen_from
    size = solid_angles(rows, 2 * rows)[..., None]
    if height > rows:
        radiance, moment = _average(radiance, rows), _average(moment, rows)
    return Cells(radiance * size, moment * size)


def all_lights(environment: EnvironmentMap, rows: int | None = None) -> DistantLights:
    """Every texel as a light: the dense sum that a choice of directions is measured against.

    With `rows`, every one of `cells` as a light, in the mean direction of what it holds: for integrands that bend
    little over a cell as good as all texels, and quicker.
    """
    height, width = environment.radiance.shape[:2]
    if rows is None:
        irradiance = environment.radiance * solid_angles(height, width)[..., None]
        return DistantLights(texel_directions(height, width).reshape(-1, 3), irradiance.reshape(-1, 3))
    held = cells(environment, rows)
    lit = held.flux.any(axis=-1)
    return DistantLights(normalize(held.moment[lit]), held.flux[lit])

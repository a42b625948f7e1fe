"""The environment behind a model: its radiance along the rays of a camera that miss the model, sharp or blurred.

An image holds radiance times coverage (`engine.render.display`), so what is behind it is added by the rest of the
coverage. A blurred environment is the mean over a cap of the sphere, sum L w dω / sum w dω with w the normalised
Gaussian exp((cos − 1) / radius²) around each direction, on a grid that is fine enough for it.

Cost: one look-up with four texels for each pixel; a blur is one product of two small matrices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.geometry.camera import Camera
from engine.light.environment import EnvironmentMap, map_coordinates, reduce, solid_angles, texel_directions

#: Rows of the grid on which an environment is blurred: texels of 2.8°, an eighth of the least blur.
ROWS = 64

#: Rows of pixels that are looked up at a time, so that memory does not grow with the image.
STRIP = 64


@dataclass(frozen=True)
class Backdrop:
    """An environment, blurred already, as a camera sees it; `rotation` in radians and `gain` are the light's."""

    environment: EnvironmentMap
    camera: Camera
    rotation: float = 0.0
    gain: float = 1.0

    def behind(self, image: NDArray[np.float32]) -> NDArray[np.float32]:
        """`image` (H, W, 4) before it."""
        return in_front_of(image, self.camera, self.environment, self.rotation, self.gain)


def in_front_of(
    image: NDArray[np.float32], camera: Camera, environment: EnvironmentMap, rotation: float = 0.0, gain: float = 1.0
) -> NDArray[np.float32]:
    """`image` (H, W, 4) with the environment behind it, so that its coverage is 1 everywhere.

    `rotation` in radians and `gain` are those of the scene's light.
    """
    height, width = image.shape[:2]
    whole = np.empty_like(image)
    whole[..., 3] = 1.0
    for first in range(0, height, STRIP):
        rows = slice(first, min(first + STRIP, height))
        row, column = np.mgrid[rows, 0:width] + 0.5
        rays = camera.rays(column, row, width, height)
        behind = gain * observe(environment, rays, rotation)
        whole[rows, :, :3] = image[rows, :, :3] + (1.0 - image[rows, :, 3:]) * behind
    return whole


def observe(environment: EnvironmentMap, directions: NDArray[np.float64], rotation: float = 0.0) -> NDArray[np.float64]:
    """Radiance (..., 3) from world `directions` (..., 3), between four texels; it wraps around and ends at the poles.

    The environment is rotated about +Y as lights are (`DistantLights.rotated`), so directions are rotated back.
    """
    x, y, z = np.moveaxis(directions, -1, 0)
    cosine, sine = np.cos(rotation), np.sin(rotation)
    u, v = map_coordinates(np.stack([cosine * x - sine * z, y, sine * x + cosine * z], axis=-1))
    height, width = environment.radiance.shape[:2]
    column, row = u * width - 0.5, np.clip(v * height - 0.5, 0.0, height - 1.0)
    left, above = np.floor(column).astype(np.int64), np.floor(row).astype(np.int64)
    right_share, below_share = (column - left)[..., None], (row - above)[..., None]
    below = np.minimum(above + 1, height - 1)
    texels = environment.radiance
    upper = texels[above, left % width] * (1.0 - right_share) + texels[above, (left + 1) % width] * right_share
    lower = texels[below, left % width] * (1.0 - right_share) + texels[below, (left + 1) % width] * right_share
    return np.asarray(upper * (1.0 - below_share) + lower * below_share, np.float64)


def blur(environment: EnvironmentMap, radius: float) -> EnvironmentMap:
    """The environment, each direction the mean around it with a Gaussian of `radius` in radians; 0 leaves it sharp."""
    if radius <= 0.0:
        return environment
    small = reduce(environment, ROWS) if environment.radiance.shape[0] > ROWS else environment
    height, width = small.radiance.shape[:2]
    direction = texel_directions(height, width).reshape(-1, 3)
    weight = np.exp((direction @ direction.T - 1.0) / radius**2)
    weight *= np.broadcast_to(solid_angles(height, width), (height, width)).reshape(1, -1)
    weight /= weight.sum(axis=1, keepdims=True)
    mean = weight @ small.radiance.reshape(-1, 3).astype(np.float64)
    return EnvironmentMap(mean.reshape(height, width, 3).astype(np.float32), environment.name)

"""Texture of an image: where it is, how strong beyond the noise, and what of it lamps of any direction leave alike."""

from __future__ import annotations

import itertools

import cv2
import numpy as np
from numpy.typing import NDArray

Grey = NDArray[np.float32]

#: Images are compared at no more pixels than this.
WORK_PIXELS = 600_000

#: Tiles off one line that must have texture to support each motion.
_NEEDED_TILES = {"translation": 1, "euclidean": 2, "affine": 3, "homography": 4}

_TILES = 4


def reduction(height: int, width: int) -> int:
    """By which whole number an image is reduced before it is compared."""
    return max(1, int(np.ceil(np.sqrt(height * width / WORK_PIXELS))))


def reduce(image: Grey, factor: int) -> Grey:
    """Means of factor × factor pixels of (H, W) or (H, W, C), without what fills no block at the right and bottom."""
    height, width = (size // factor for size in image.shape[:2])
    whole = image[: height * factor, : width * factor]
    return whole if factor == 1 else cv2.resize(whole, (width, height), interpolation=cv2.INTER_AREA)


def texture(image: Grey) -> float:
    """Mean gradient of the image beyond what its noise makes: the larger, the better to align to."""
    return max(0.0, float(slope(image, 2.0).mean(dtype=np.float64)) - noise_slope(image))


def choose_supported_motion(image: Grey, motion: str) -> str:
    """`motion`, or 'translation' where too few tiles of the image have texture, or all of them on one line."""
    steep, floor = slope(image, 2.0), 3.0 * noise_slope(image)
    found = [(float(steep[tile].mean()), centre) for tile, centre in tiles(image.shape)]
    strongest = max(strength for strength, _ in found)
    centres = np.array([centre for strength, centre in found if strength > max(floor, 0.05 * strongest)]).reshape(-1, 2)
    needed = _NEEDED_TILES[motion]
    if len(centres) < needed:
        return "translation"
    spread = np.linalg.svd(centres - centres.mean(axis=0), compute_uv=False)
    return motion if needed < 3 or spread[-1] > 0.1 * spread[0] else "translation"


def slope(image: Grey, deviation: float) -> Grey:
    """Gradient magnitude per pixel after a Gaussian blur.

    The root is numpy's, because `cv2.magnitude` gives other last bits for other places in memory.
    """
    smooth = cv2.GaussianBlur(image, (0, 0), deviation)
    across, down = (cv2.Sobel(smooth, cv2.CV_32F, axis, 1 - axis, scale=1 / 8) for axis in (1, 0))
    return np.sqrt(across * across + down * down)


def noise_slope(image: Grey) -> float:
    """Mean of `slope(image, 2.0)` for noise as strong as that of the image (from the median of its Laplacian)."""
    deviation = float(np.median(np.abs(cv2.Laplacian(image, cv2.CV_32F)))) / 3.0
    return 0.0627 * deviation


def feature(image: Grey) -> Grey:
    """Gradient magnitude over its local mean: what lamps of any direction and strength leave alike."""
    steep = slope(image, 1.5)
    local = cv2.GaussianBlur(steep, (0, 0), 16.0)
    return steep / (local + np.float32(1e-3 * float(steep.max()) + 1e-30))


def tiles(shape: tuple[int, ...]) -> list[tuple[tuple[slice, slice], tuple[float, float]]]:
    """The slices and centres (x, y) of 4 × 4 tiles."""
    rows, columns = (np.linspace(0, size, _TILES + 1).astype(int) for size in shape)
    return [
        ((slice(top, bottom), slice(left, right)), ((left + right) / 2, (top + bottom) / 2))
        for top, bottom in itertools.pairwise(rows)
        for left, right in itertools.pairwise(columns)
    ]

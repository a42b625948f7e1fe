"""Lobes in three words each, as shaders read them: mean on an octahedron, logarithm of the width, energy.

    word 0   mean: x | y << 16, each of 16 bits over −1 … 1 on the octahedron |x| + |y| + |z| = 1, folded at z = 0
    word 1   logarithm of sigma in 16 bits over the widths that lobes may have | red << 16
    word 2   green | blue << 16, half floats of the energy, w ∫ G

Right to 7e-5 rad, 6e-5 of sigma and 5e-4 of the energy.

A filtered environment as one texture: the levels below one another on six layers, as half floats.

    texel of (s, t) of face f on a level   (s M + ½, t M + ½ + line) of layer f

Corner nodes of a level lie on the edges of its face, so that look-ups which filter linearly never leave it. What is
brighter than a half float holds is scaled, and the scale reported.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.light.gaussian_prefilter import PrefilteredCube, gaussian_integral
from engine.transport.gaussian.fitting.lobes import NARROWEST, WIDEST_LOBE, Lobes

#: Highest energy that a half float holds.
MAX_ENERGY = 65504.0

#: Lobes that are packed at once.
AT_ONCE = 1 << 18

_LEVELS = 65535


def sigma_span() -> tuple[float, float]:
    """The logarithm that stands for 0, and the step from one number to the next."""
    return math.log(NARROWEST), (math.log(WIDEST_LOBE) - math.log(NARROWEST)) / _LEVELS


def pack(components: Sequence[Lobes]) -> NDArray[np.uint32]:
    """(V · views · K, 3) words, lobe by lobe of each view of each vertex; about 0.1 µs each."""
    counts = [lobes.count for lobes in components]
    vertices, views = components[0].sigma.shape[:2] if components else (0, 0)
    words = np.empty((vertices, views, sum(counts), 3), np.uint32)
    step = max(1, AT_ONCE // max(1, views * max(counts, default=1)))
    first = 0
    for lobes, count in zip(components, counts, strict=True):
        for start in range(0, vertices, step):
            part = slice(start, start + step)
            words[part, :, first : first + count] = _words(lobes.weight[part], lobes.mean[part], lobes.sigma[part])
        first += count
    return words.reshape(-1, 3)


def _words(weight: NDArray[np.float32], mean: NDArray[np.float32], sigma: NDArray[np.float32]) -> NDArray[np.uint32]:
    octahedron = mean[..., :2] / np.abs(mean).sum(axis=-1, keepdims=True)
    folded = (1.0 - np.abs(octahedron[..., ::-1])) * np.where(octahedron >= 0.0, 1.0, -1.0)
    place = np.where(mean[..., 2:] < 0.0, folded, octahedron)
    x, y = np.moveaxis(np.rint((0.5 * place + 0.5) * _LEVELS).astype(np.uint32), -1, 0)
    first, step = sigma_span()
    width = np.clip(np.rint((np.log(sigma) - first) / step), 0, _LEVELS).astype(np.uint32)
    energy = np.minimum(weight * gaussian_integral(sigma)[..., None], MAX_ENERGY)
    red, green, blue = np.moveaxis(energy.astype(np.float16).view(np.uint16).astype(np.uint32), -1, 0)
    return np.stack([x | y << 16, width | red << 16, green | blue << 16], axis=-1)


def unpack(words: NDArray[np.uint32]) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """Energies (n, 3), unit means (n, 3) and widths (n,) of `words` (n, 3): what a shader reads."""
    place = np.stack([words[:, 0] & 0xFFFF, words[:, 0] >> 16], axis=-1) * (2.0 / _LEVELS) - 1.0
    height = 1.0 - np.abs(place).sum(axis=-1)
    below = np.maximum(-height, 0.0)[:, None]
    mean = np.concatenate([place - np.where(place >= 0.0, below, -below), height[:, None]], axis=-1)
    mean /= np.linalg.norm(mean, axis=-1, keepdims=True)
    first, step = sigma_span()
    sigma = np.exp(first + step * (words[:, 1] & 0xFFFF))
    halves = np.stack([words[:, 1] >> 16, words[:, 2] & 0xFFFF, words[:, 2] >> 16], axis=-1)
    energy = halves.astype(np.uint16).view(np.float16)
    return energy.astype(np.float32), mean.astype(np.float32), sigma.astype(np.float32)


#: Brightest that is stored; half floats end at 65,504.
BRIGHTEST = 60_000.0

#: Texels along a side of textures that graphics devices of this century take.
MAX_TEXELS = 16384


@dataclass(frozen=True, eq=False)
class Atlas:
    """`texels` (6, H, W, 4) float16 with radiance over `scale`; of each level sigma, its logarithm, M and first line.

    `reduced` is the number of nodes along a face where the largest levels had to be thinned out, else 0.
    """

    texels: NDArray[np.float16]
    scale: float
    levels: NDArray[np.float64]
    mean: NDArray[np.float64]
    reduced: int = 0

    @property
    def is_even(self) -> bool:
        """True if the logarithms of the widths are evenly spaced."""
        logarithms = self.levels[:, 1]
        return bool(np.allclose(logarithms, np.linspace(logarithms[0], logarithms[-1], len(logarithms)), atol=1e-4))


def atlas_of(cube: PrefilteredCube | None, most: int = MAX_TEXELS) -> Atlas:
    """The atlas of `cube`, black without one, with at most `most` texels along a side of its layers."""
    levels, sigma = _levels(cube)
    reduced = 0
    while sum(level.shape[1] for level in levels) > most:
        reduced = (max(level.shape[1] for level in levels) + 1) // 2
        if reduced < 3:
            raise ValueError(f"{len(levels)} levels of light do not fit textures of {most} texels")
        levels = [level[:, ::2, ::2] if level.shape[1] > reduced else level for level in levels]
    lines = np.cumsum([0, *(level.shape[1] for level in levels)])
    texels = np.zeros((6, lines[-1], max(level.shape[2] for level in levels), 4), np.float16)
    scale = max(1.0, max(float(level.max()) for level in levels) / BRIGHTEST)
    for line, level in zip(lines, levels, strict=False):
        size = level.shape[1]
        texels[:, line : line + size, :size, :3] = level * np.float32(1.0 / scale)
    cells = [level.shape[1] - 1 for level in levels]
    mean = np.zeros(3) if cube is None else cube.mean
    return Atlas(texels, scale, np.stack([sigma, np.log(sigma), cells, lines[:-1]], axis=1), mean, reduced)


def _levels(cube: PrefilteredCube | None) -> tuple[list[NDArray[np.float32]], NDArray[np.float64]]:
    """Two levels at the least, so that there is always something between them."""
    if cube is None:
        return [np.zeros((6, 2, 2, 3), np.float32)] * 2, np.array([0.5, 1.0])
    if len(cube.levels) > 1:
        return list(cube.levels), cube.sigma
    return [cube.levels[0]] * 2, cube.sigma[0] * np.array([1.0, 1.001])

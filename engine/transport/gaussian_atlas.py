"""A filtered environment as one texture: the levels below one another on six layers, as half floats.

    texel of (s, t) of face f on a level   (s M + ½, t M + ½ + line) of layer f

Corner nodes of a level lie on the edges of its face, so that look-ups which filter linearly never leave it. What is
brighter than a half float holds is scaled, and the scale told.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.prefilter import PrefilteredCube

#: Brightest that is stored; half floats end at 65,504.
BRIGHTEST = 60_000.0

#: Texels along a side of textures that graphics devices of this century take.
MOST_TEXELS = 16384


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
        """Whether the logarithms of the widths are evenly spaced."""
        logarithms = self.levels[:, 1]
        return bool(np.allclose(logarithms, np.linspace(logarithms[0], logarithms[-1], len(logarithms)), atol=1e-4))


def atlas_of(cube: PrefilteredCube | None, most: int = MOST_TEXELS) -> Atlas:
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

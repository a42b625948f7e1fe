"""A directional map from afar: smaller planes, whose weighted sums are the codes of mean radiance.

Seen from afar, a texel is the mean radiance of many. Means of planes give the mean of their codes, and codes are bent
against radiance, so that light and dark side by side would become too dark: by 10 % at an eighth of the size on a
glossy ring. So the codes of four texels are decoded and averaged as radiance for a few lights, and the planes of the
texel in their place are those that come nearest to it: their means, of which the first, in which texels vary most, are
corrected (least squares). Planes of a level are made of the level before.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from engine.core.colour import srgb_decode
from engine.core.directions import Vectors
from engine.shading.directional.minified_kernel import halve

if TYPE_CHECKING:
    from engine.shading.directional.planes import DirectionalMap

#: Planes that are corrected, and lights for which radiance is averaged, or as many as these planes need.
CORRECTED, LIGHTS = 27, 16

#: Part of the plane that counts most below which one is rounding: no light tells its codes.
MIN_SEEN = 1e-6

#: Steps of the table of radiance by code, and the largest code in it, twice white.
STEPS, LARGEST = 1 << 12, 510.0


def minify(directional: DirectionalMap) -> list[NDArray[np.float16]]:
    """The planes (K, h, w) as codes at half the size, at a quarter … down to one texel."""
    count = min(len(directional.planes), CORRECTED)
    lights = spread_lights(directional.lights, max(LIGHTS, -(-2 * count // 3)))
    functions = directional.functions(lights).reshape(3 * len(lights), -1)
    inverse = np.linalg.pinv(functions[:, 1 : 1 + count], rcond=MIN_SEEN)
    given = functions.astype(np.float32), inverse.astype(np.float32)
    table = srgb_decode(np.linspace(0.0, LARGEST / 255.0, STEPS + 1)).astype(np.float32)
    levels: list[NDArray[np.float16]] = []
    last: NDArray[np.uint8] | NDArray[np.float32] = np.asarray(directional.planes)
    while max(last.shape[1:]) > 1:
        count, height, width = last.shape
        half = np.empty((count, max(1, height // 2), max(1, width // 2)), np.float32)
        halve(last, *given, table, np.float32(STEPS / LARGEST), half)
        levels.append(half.astype(np.float16))
        last = half
    return levels


def spread_lights(lights: Vectors, count: int) -> Vectors:
    """At most `count` of the `lights` (N, 3): the highest, then each the farthest from those before."""
    chosen = [int(lights[:, 2].argmax())]
    nearest = lights @ lights[chosen[0]]
    while len(chosen) < min(count, len(lights)):
        chosen.append(int(nearest.argmin()))
        nearest = np.maximum(nearest, lights @ lights[chosen[-1]])
    return lights[chosen]

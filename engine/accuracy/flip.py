"""ꟻLIP, the difference that a user sees between two images who flips between them.

Andersson2020 for images as they are displayed ('LDR') and Andersson2021 for linear radiance ('HDR':
the largest difference over a range of exposures), computed by NVIDIA's `flip_evaluator` for 67 pixels per degree (a
0.7 m wide 4K screen at 0.7 m). It is called for one tile and exposure at a time, with a margin of as many pixels as its
filters reach: the value of every pixel is that of the whole image, tiles without wanted pixels cost nothing, and its
hold on Python's interpreter is short. About 2 µs per pixel and exposure of one core with large tiles, twice that with
small.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.colour import luminance
from engine.core.interrupts import interrupts_held
from engine.core.steps import Step, Steps, part

#: Pixels that the filters of ꟻLIP reach at 67 pixels per degree: 3 standard deviations of its widest, rounded up.
MARGIN = 12

#: Side of a tile in pixels where a window waits beside it, and where nothing does.
SMALL_TILE, LARGE_TILE = 48, 512

#: Radiance above this is taken for it.
BRIGHTEST = 1e15

Floats = NDArray[Any]


def flip_map(
    test: Floats,
    reference: Floats,
    mask: NDArray[np.bool_] | None = None,
    *,
    displayed: bool = False,
    tile: int = LARGE_TILE,
) -> Steps[NDArray[np.float32]]:
    """ꟻLIP of each pixel (H, W) in [0, 1], 0 outside `mask` (H, W), of two images (H, W, 3) of linear light.

    `displayed`: the images are what a screen shows, in [0, 1]; otherwise radiance, of which negative values are 0.
    """
    top = 1.0 if displayed else BRIGHTEST
    images = [np.clip(np.nan_to_num(image), 0.0, top).astype(np.float32) for image in (reference, test)]
    height, width = images[0].shape[:2]
    wanted = np.ones((height, width), np.bool_) if mask is None else mask
    found = np.zeros((height, width), np.float32)
    exposures = None if displayed else _exposures(images[0], wanted)
    corners = _corners(wanted, tile)
    for number, (row, column) in enumerate(corners):
        inside = slice(row, row + tile), slice(column, column + tile)
        done = number / len(corners)
        found[inside] = yield from part(_tile(images, row, column, tile, exposures), done, done)
    found[~wanted] = 0.0
    return found


def flip_estimate(test: Floats, reference: Floats, mask: NDArray[np.bool_], tiles: int = 12) -> Steps[float]:
    """Mean ꟻLIP of radiance inside `mask`, from so many small tiles spread evenly over it; exact where there are fewer.

    For a window that cannot wait for all of them.
    """
    images = [np.clip(np.nan_to_num(image), 0.0, BRIGHTEST).astype(np.float32) for image in (reference, test)]
    corners, exposures = _corners(mask, SMALL_TILE), _exposures(images[0], mask)
    chosen = np.unique(np.round(np.linspace(0, len(corners) - 1, min(tiles, len(corners)))).astype(int))
    total, pixels = 0.0, 0
    for number, place in enumerate(chosen):
        row, column = corners[place]
        inside = mask[row : row + SMALL_TILE, column : column + SMALL_TILE]
        done = number / len(chosen)
        found = yield from part(_tile(images, row, column, SMALL_TILE, exposures), done, done)
        total += float(found[inside].sum(dtype=np.float64))
        pixels += int(inside.sum())
    return total / max(1, pixels)


def _corners(wanted: NDArray[np.bool_], tile: int) -> list[tuple[int, int]]:
    """Row and column of the tiles that hold wanted pixels."""
    height, width = wanted.shape
    corners = [(row, column) for row in range(0, height, tile) for column in range(0, width, tile)]
    return [(row, column) for row, column in corners if wanted[row : row + tile, column : column + tile].any()]


def _tile(
    images: list[NDArray[np.float32]], row: int, column: int, tile: int, exposures: list[float] | None
) -> Steps[NDArray[np.float32]]:
    """ꟻLIP of one tile; of radiance the largest over all exposures, a step for each."""
    top, left = max(row - MARGIN, 0), max(column - MARGIN, 0)
    parts = [image[top : row + tile + MARGIN, left : column + tile + MARGIN] for image in images]
    inside = slice(row - top, row - top + tile), slice(column - left, column - left + tile)
    found = np.zeros(parts[0][inside].shape[:2], np.float32)
    if np.array_equal(parts[0], parts[1]):
        return found
    for exposure in exposures if exposures is not None else [None]:
        shown = parts if exposure is None else [_aces(part, exposure) for part in parts]
        np.maximum(found, _display(shown)[inside], out=found)
        yield Step(0.0, "comparing as an eye does")
    return found


def _display(parts: list[NDArray[np.float32]]) -> NDArray[np.float32]:
    """ꟻLIP (H, W) of two images of linear light that a screen shows."""
    import flip_evaluator

    contiguous = [np.ascontiguousarray(part) for part in parts]
    with interrupts_held():
        values, _, _ = flip_evaluator.evaluate(
            *contiguous, "LDR", inputsRGB=False, applyMagma=False, computeMeanError=False
        )
    return np.asarray(values[..., 0], np.float32)


def _aces(radiance: NDArray[np.float32], exposure: float) -> NDArray[np.float32]:
    """Tone-mapped radiance by the fit of `flip_evaluator`, at an exposure in stops, in [0, 1]."""
    a, b, c, d, e = _ACES
    x = np.minimum(radiance * 2.0**exposure, BRIGHTEST).astype(np.float64)
    return np.clip((a * x * x + b * x) / (c * x * x + d * x + e), 0.0, 1.0).astype(np.float32)


def _exposures(reference: NDArray[np.float32], wanted: NDArray[np.bool_]) -> list[float]:
    """In stops, from the brightest pixel at 85 % of white to the median there (Andersson2021 Sec. 4.1).

    The median is that of the wanted pixels, or of those that are lit where more than half of them are black.
    """
    light = luminance(reference[wanted]).astype(np.float64) if wanted.any() else np.zeros(1)
    lit = light[light > 0.0]
    if lit.size == 0:
        return [0.0]
    middle = float(np.median(light)) or float(np.median(lit))
    start, stop = (np.log2(_ACES_85 / value) for value in (float(light.max()), middle))
    return [float(at) for at in np.unique(np.linspace(start, stop, max(2, int(np.ceil(stop - start)))))]


#: The ACES fit of `flip_evaluator` (Narkowicz2015, of 0.6 times the radiance).
_ACES = (0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14)


def _aces_inverse(share: float) -> float:
    """The luminance that the ACES fit takes to `share` of white."""
    a, b, c, d, e = _ACES
    return float(np.roots([a - share * c, b - share * d, -share * e]).max())


_ACES_85 = _aces_inverse(0.85)

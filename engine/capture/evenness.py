"""Photographs of even brightness: the slow change of a lamp over the sample, divided out before a material is tiled.

Where a lamp is near, or its beam is narrow, one side of the sample is brighter than the other, in each photograph in
another way. Cut into a tile and repeated, that is a pattern of bands which the eye finds at once, however well the
seams match. So each photograph is divided by the brightness that a surface without texture would have there: exp of a
polynomial of `DEGREE` in column and row, fitted by least squares to the logarithm of the mean luminance of blocks. Its
mean stays what it was. The logarithm makes a lamp's 1/d² nearly a parabola, and a low degree leaves patterns alone that
repeat within the sample. All channels are divided alike, so colours stay.

What the material itself has of so slow a change goes too, which a tile cannot show anyway.

Cost: two readings of the photographs and one copy.
"""

from __future__ import annotations

import dataclasses
import itertools
from types import MappingProxyType

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from engine.capture.stack import ImageStack
from engine.core.colour import LUMINANCE
from engine.core.figure_text import percent
from engine.core.health import Finding, Health, Verdict
from engine.core.steps import Step, Steps
from engine.storage.scratch import release, scratch_array

#: Total degree of the polynomial: half a wave more than the sample is wide.
DEGREE = 4

#: Blocks along each side at most, and pixels of a block along each side at least.
BLOCKS, BLOCK_PX = 16, 4

#: Darker blocks than this share of the mean count as so bright; no place is made more than so many times brighter.
DARKEST, MAX_GAIN = 0.01, 8.0

#: Unevenness beyond this is not a lamp's: one that hangs half a sample's width above its edge makes 2.7.
MAX_OF_A_LAMP = 4.0

#: Rows of a photograph that are read at once.
ROWS = 256


def even_out(stack: ImageStack) -> Steps[tuple[ImageStack, Health]]:
    """`stack` with every photograph divided by its slow change of brightness, and how large that was.

    The figure `unevenness` of the health is the difference of the brightest and the darkest place of the slow change
    over its mean, of the most uneven photograph. Photographs of fewer than `(DEGREE + 1) * BLOCK_PX` pixels along a
    side stay as they are.
    """
    count = len(stack.sources)
    radiance = scratch_array(stack.radiance.shape, np.float32, stack.folder)
    means = np.empty(count)
    unevenness = np.zeros(count)
    for place in range(count):
        yield Step(place / count, "evening out the brightness")
        photograph = stack.radiance[place]
        coefficients = slow_change(photograph)
        unevenness[place] = _range_of(coefficients)
        radiance[place] = divide(photograph, coefficients)
        means[place] = radiance[place].mean(axis=(0, 1), dtype=np.float64) @ LUMINANCE
        release(radiance)
    return dataclasses.replace(stack, radiance=radiance, mean_radiance=means, diffuse=None), _health(stack, unevenness)


def slow_change(photograph: NDArray[np.float32]) -> NDArray[np.float64]:
    """Coefficients (DEGREE + 1, DEGREE + 1) of the logarithm of slow brightness in Legendre polynomials.

    `photograph` is linear radiance (H, W, 3). Row i and column j belong to P_i of the row and P_j of the column, each
    of which runs over [-1, 1] between the edges of the photograph. That of degree 0 is 0, and all are where the
    photograph is black or too small.
    """
    means = _block_means(photograph)
    coefficients = np.zeros((DEGREE + 1, DEGREE + 1))
    mean = float(means.mean())
    if min(means.shape) <= DEGREE or mean <= 0.0:
        return coefficients
    down, across = (legendre.legvander(_middles(side), DEGREE) for side in means.shape)
    pairs = [(i, j) for i in range(DEGREE + 1) for j in range(DEGREE + 1 - i)]
    basis = np.stack([np.outer(down[:, i], across[:, j]).ravel() for i, j in pairs], axis=1)
    logarithms = np.log(np.maximum(means, DARKEST * mean)).ravel()
    solved = np.linalg.lstsq(basis, logarithms, rcond=None)[0]
    for (i, j), value in zip(pairs, solved, strict=True):
        coefficients[i, j] = value
    coefficients[0, 0] = 0.0
    return coefficients


def divide(photograph: NDArray[np.float32], coefficients: NDArray[np.float64]) -> NDArray[np.float32]:
    """`photograph` (H, W, 3) over the slow brightness of `slow_change`, scaled to the mean luminance that it had."""
    height, width = photograph.shape[:2]
    if not coefficients.any():
        return np.array(photograph)
    across = legendre.legvander(_middles(width), DEGREE) @ coefficients.T
    down = legendre.legvander(_middles(height), DEGREE)
    made = np.empty(photograph.shape, np.float32)
    before = after = 0.0
    for start in range(0, height, ROWS):
        band = np.asarray(photograph[start : start + ROWS])
        gain = np.exp(-np.clip(down[start : start + ROWS] @ across.T, -np.log(MAX_GAIN), np.log(MAX_GAIN)))
        made[start : start + ROWS] = band * gain[..., None].astype(np.float32)
        before += float(band.sum(axis=(0, 1), dtype=np.float64) @ LUMINANCE)
        after += float(made[start : start + ROWS].sum(axis=(0, 1), dtype=np.float64) @ LUMINANCE)
    made *= np.float32(before / after) if after > 0.0 else np.float32(1.0)
    return made


def _block_means(photograph: NDArray[np.float32]) -> NDArray[np.float64]:
    """Mean luminance of blocks of nearly equal size, at most `BLOCKS` along each side."""
    down, across = (_edges(side) for side in photograph.shape[:2])
    means = np.empty((len(down) - 1, len(across) - 1))
    for row, (top, bottom) in enumerate(itertools.pairwise(down)):
        columns = photograph[top:bottom].sum(axis=0, dtype=np.float64) @ LUMINANCE
        means[row] = np.add.reduceat(columns, across[:-1]) / (np.diff(across) * (bottom - top))
    return means


def _edges(side: int) -> NDArray[np.int64]:
    """The pixels at which blocks begin along a side, and its end."""
    return np.linspace(0, side, max(1, min(BLOCKS, side // BLOCK_PX)) + 1).astype(np.int64)


def _middles(count: int) -> NDArray[np.float64]:
    """The middles of `count` equal parts of [-1, 1]."""
    return (2.0 * np.arange(count) + 1.0) / count - 1.0


def _range_of(coefficients: NDArray[np.float64]) -> float:
    """The difference of the largest and the least slow brightness over its mean."""
    values = legendre.legvander(_middles(64), DEGREE)
    field = np.exp(values @ coefficients @ values.T)
    return float(np.ptp(field) / field.mean())


def _health(stack: ImageStack, unevenness: NDArray[np.float64]) -> Health:
    worst = int(unevenness.argmax())
    text = f"changes its brightness slowly by {percent(float(unevenness[worst]))} over the sample, the most of all"
    verdict, text = Verdict.NOTE, f"{text}, which was evened out before the material was tiled"
    if unevenness[worst] > MAX_OF_A_LAMP:
        verdict = Verdict.WARNING
        text += "; no lamp does so much, as an object before a dark background does: import the material alone, by its "
        text += "framing, or leave the brightness as it is"
    finding = Finding(verdict, text, stack.sources[worst])
    return Health(MappingProxyType({"unevenness": float(unevenness[worst])}), (finding,))

"""The lens of the virtual light arc: blur, exact shifts and turns of a periodic image, and fall-off to the corners.

A shift by d multiplies the spectrum by exp(-2 pi i f d) and a Gaussian of deviation s by exp(-2 pi^2 s^2 f^2) (f in
periods per texel), so any fraction of a texel is as sharp as a whole one, and the mean is kept exactly. A turn is
sampled from the spline of degree five through the texels, whose error is below 0.1 % of any wave of four texels.
Cost: two real Fourier transforms of each channel, 0.1 s per megatexel on one thread; 0.6 s more for a turn.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import fft, ndimage


def blurred(image: NDArray[np.float32], deviation: float, right: float = 0.0, down: float = 0.0) -> NDArray[np.float32]:
    """(H, W, 3) periodic `image` blurred by a Gaussian and moved, all in texels, without negative radiance.

    The transform of an image with sharp edges undershoots by less than 1 % for deviations of one texel and more;
    what is below zero is set to zero.
    """
    rows, columns = image.shape[:2]
    f_row, f_column = fft.fftfreq(rows), fft.rfftfreq(columns)
    by_row = np.exp(-2 * (np.pi * deviation * f_row) ** 2 - 2j * np.pi * f_row * down)
    by_column = np.exp(-2 * (np.pi * deviation * f_column) ** 2 - 2j * np.pi * f_column * right)
    transfer = (by_row[:, None] * by_column).astype(np.complex64)
    moved = np.empty_like(image)
    for channel in range(image.shape[2]):
        spectrum = fft.rfft2(image[..., channel], workers=2)
        moved[..., channel] = fft.irfft2(spectrum * transfer, s=(rows, columns), workers=2)
    return np.maximum(moved, 0, out=moved)


def turned(image: NDArray[np.float32], angle: float, right: float, down: float, step: int = 1) -> NDArray[np.float32]:
    """(H / step, W / step, 3) periodic `image` turned about its middle, then moved, at every `step`-th place.

    `angle` is in radians, counter-clockwise as seen; shifts are in texels. A result stands for the middle of its
    `step` x `step` texels.
    """
    rows, columns = image.shape[:2]
    row, column = np.mgrid[0 : rows // step, 0 : columns // step] * step + 0.5 * step
    x, y = column - right - columns / 2, row - down - rows / 2
    source_column = math.cos(angle) * x - math.sin(angle) * y + columns / 2 - 0.5
    source_row = math.sin(angle) * x + math.cos(angle) * y + rows / 2 - 0.5
    planes = [
        ndimage.map_coordinates(image[..., channel], (source_row, source_column), np.float32, 5, "grid-wrap")
        for channel in range(image.shape[2])
    ]
    return np.maximum(np.stack(planes, axis=-1), 0)


def falloff(height: int, width: int, loss: float) -> NDArray[np.float32]:
    """(H, W) share of the light that reaches the sensor: cos^4 of the angle off the axis, 1 - `loss` in the corners.

    The angle's tangent grows in proportion to the distance from the middle, as for a lens without distortion, so with
    q = (1 - loss)^(-1/2) - 1 the share at the share s of the way to the corners is (1 + q s^2)^(-2).
    """
    if not 0.0 <= loss < 1.0:
        raise ValueError(f"a lens cannot lose {loss:g} of the light in the corners")
    x = (2 * np.arange(width) + 1 - width)[None, :]
    y = (2 * np.arange(height) + 1 - height)[:, None]
    squared = (x * x + y * y) / (width * width + height * height)
    return ((1 + ((1 - loss) ** -0.5 - 1) * squared) ** -2).astype(np.float32)

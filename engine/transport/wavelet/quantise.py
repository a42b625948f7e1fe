"""Coefficients in few bits: 8 bits for each colour of a transport vector, in words of 32, and 16 for light.

A vector of transport (Wang2004 Sec. 3.3) is stored as a peak for each channel, the largest
magnitude there, and for each coefficient that is kept its index in 16 bits and its three quantised coefficients in 32:
red in bits 0–10, green in 11–21, blue in 22–31, each in two's complement. value = peak · quantised / bound with the
bounds ±1023, ±1023 and ±511. A word has room for the 11, 11 and 10 bits of the paper, which scaling coefficients take
because they carry the flux; details are multiples of `STEP`, `STEP` and STEP/2, 127 for either sign and colour, which
take a third fewer bytes in a file (`engine.transport.baking.packing`). The peak is scaled so that the largest multiple
is the largest magnitude. The error of a value is at most that over 254, of scaling coefficients over 2032 or 1016, and
that of a relit image some 0.2 %.
Quantised coefficients are rounded to even at halves and never reach −1024 or −512, where a value just above its peak
would change sign.

The light (Sec. 3.4) has one quantum for all its details: 1/32767 of the largest. Details of a magnitude below the
threshold are dropped. The six scaling coefficients are kept as they are, in float64: with a small and very bright
source in the map one scale for all would round the sky's to nothing.

The product of a code and a light code needs 26 bits with its sign, and 65 of them can overflow 32: sums are taken over
up to 64 products in 32 bits and those sums in 64, which is exact in any order.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.colour import luminance
from engine.core.kernels import scalar
from engine.transport.wavelet.haar import FACES, check_edge, cube_coefficients, cube_of_coefficients

#: Largest magnitude of the quantised coefficients of red, green and blue.
BOUNDS = (1023, 1023, 511)

#: Quantised coefficients of red and green are multiples of this power of two, those of blue of half of it.
STEP = 8

#: Largest magnitude of a code of light.
LIGHT_BOUND = 32767

#: Vectors that tell the error of rounding.
ROUNDED_ROWS = 2048

#: Details of light below this magnitude are dropped; the paper's threshold is 1024.
THRESHOLD = 32

#: Products of quantised coefficients whose sum is sure to fit into 32 bits: 64 · 1023 · 32767 < 2^31.
SAFE_PRODUCTS = 64


def pack(quantised: ArrayLike) -> NDArray[np.uint32]:
    """(...) little-endian words of `quantised` (..., 3), in [−1024, 1023] twice, and [−512, 511]; ValueError else."""
    quantised = np.asarray(quantised, np.int64)
    low, high = np.array([-1024, -1024, -512]), np.array([1023, 1023, 511])
    if ((quantised < low) | (quantised > high)).any():
        raise ValueError("a code does not fit into 11, 11 and 10 bits")
    red, green, blue = np.moveaxis(quantised, -1, 0)
    words = (red & 0x7FF) | (green & 0x7FF) << 11 | (blue & 0x3FF) << 22
    return words.astype("<u4")


def unpack(words: NDArray[np.uint32]) -> NDArray[np.int32]:
    """Codes (..., 3) of packed words (...)."""
    signed = np.asarray(words).astype(np.uint32).view(np.int32)
    return np.stack([signed << 21 >> 21, signed << 10 >> 21, signed >> 22], axis=-1)


@scalar
def quantise_vectors(
    values: NDArray[np.floating], peak: NDArray[np.floating], word: NDArray[np.integer], step: int, exact: int
) -> int:
    """Quantise `values` (M, 3) float32 into `word` (M,) and `peak` (3,); how many words are not 0.

    Codes are multiples of `step` (blue: of its half, rounded up), a power of two, but for the first `exact` values.
    """
    for channel in range(3):
        peak[channel] = 0.0
        for m in range(len(values)):
            peak[channel] = max(peak[channel], abs(values[m, channel]))
    lit = 0
    for m in range(len(values)):
        packed = np.int64(0)
        for channel in range(3):
            each = (step + 1) // 2 if channel == 2 else step
            bound = (511 if channel == 2 else 1023) // each
            if m < exact:
                bound, each = bound * each, 1
            if peak[channel] > 0.0:
                scaled = np.rint(np.float64(values[m, channel]) / np.float64(peak[channel]) * bound)
                code = int(min(max(scaled, -bound), bound)) * each
                packed |= (code & (0x3FF if channel == 2 else 0x7FF)) << (11 * channel)
        word[m] = np.uint32(packed)
        if packed != 0:
            lit += 1
    for channel in range(3):
        each, whole = (step + 1) // 2 if channel == 2 else step, 511 if channel == 2 else 1023
        peak[channel] = np.float64(peak[channel]) * whole / (whole // each * each)
    return lit


def quantise(values: ArrayLike, step: int = 1) -> tuple[NDArray[np.uint32], NDArray[np.float32]]:
    """Words (..., M) and peaks (..., 3) float32 of the coefficients `values` (..., M, 3), taken as float32.

    `step` is as for `quantise_vectors`, `STEP` in a bake. ValueError where they are not finite.
    """
    values = np.asarray(values, np.float32)
    if not np.isfinite(values).all():
        raise ValueError("coefficients must be finite numbers")
    words = np.zeros(values.shape[:-1], "<u4")
    peaks = np.zeros((*values.shape[:-2], 3), np.float32)
    for place in np.ndindex(values.shape[:-2]):
        quantise_vectors(np.ascontiguousarray(values[place]), peaks[place], words[place], step, 0)
    return words, peaks


def dequantise(words: NDArray[np.uint32], peaks: NDArray[np.float32]) -> NDArray[np.float64]:
    """Coefficients (..., M, 3) of words (..., M) and peaks (..., 3)."""
    return unpack(words) * (peaks.astype(np.float64) / BOUNDS)[..., None, :]


def rounding_error_rel(words: NDArray[np.uint32], peaks: NDArray[np.float32], step: int) -> float:
    """Root mean square error of coefficients by rounding over that of the coefficients themselves, of some vectors.

    Parameters
    ----------
    words : (R, N); peaks : (R, 3). step : as for `quantise_vectors`.

    Of rounded values nothing is known but that errors are alike within ± half a step (variance step²/12), which they
    are where there are many. It is also the error of radiance under white noise; large lights hide most of it.
    """
    some = np.unique(np.linspace(0, max(0, len(words) - 1), ROUNDED_ROWS).astype(np.int64))[: len(words)]
    scale = peaks[some].astype(np.float64) / BOUNDS
    steps = scale * (step, step, (step + 1) // 2)
    squares = float((unpack(words[some]).astype(np.float64) ** 2).sum(axis=1).ravel() @ (scale**2).ravel())
    errors = words.shape[1] * float((steps**2).sum()) / 12.0
    return float(np.sqrt(errors / squares)) if squares > 0.0 else 0.0


@dataclass(frozen=True, eq=False)
class WaveletLight:
    """Light from all around in the form that relighting takes.

    Attributes
    ----------
    scaling : (6, 3) float64, the scaling coefficients of the faces, as they are.
    quantised : (6 · N², 3) int16 by index, the details over `quantum`; 0 where dropped and at the scaling coefficients.
    quantum : the value of one code, in units of radiance.
    rmse_rel : ‖approximation − map‖/‖map‖ over texels and channels.
    energy_error_rel : Σ |flux of the approximation − flux of the map| over the quarters of the faces, over the whole
        flux (luminance, texels weighted alike). The flux of whole faces is kept as it is.
    """

    scaling: NDArray[np.float64]
    quantised: NDArray[np.int16]
    quantum: float
    rmse_rel: float
    energy_error_rel: float

    @property
    def edge(self) -> int:
        return round((len(self.quantised) / FACES) ** 0.5)

    @property
    def kept(self) -> int:
        """Number of coefficients that are not 0 in every channel."""
        return int(self.scaling.any(axis=1).sum() + self.quantised.any(axis=1).sum())

    @property
    def coefficients(self) -> NDArray[np.float64]:
        """(6 · N², 3) what the quantised coefficients stand for."""
        values = self.quantised.astype(np.float64) * self.quantum
        values[:FACES] = self.scaling
        return values


def encode_light(radiance: NDArray[Any], threshold: int = THRESHOLD, quantum: float | None = None) -> WaveletLight:
    """The faces (6, N, N, 3) of a cube map as wavelets.

    Parameters
    ----------
    threshold : details of quantised coefficients with a magnitude below it are dropped; 0 and 1 drop only what rounds
    to 0.
    quantum : that of another light, which keeps them comparable; then they saturate at ±32767.

    Raises ValueError for an edge without wavelets, radiance that is not finite, and a threshold out of range.
    """
    radiance = np.asarray(radiance, np.float64)
    if radiance.ndim != 4 or radiance.shape[0] != FACES or radiance.shape[1] != radiance.shape[2]:
        raise ValueError(f"a cube map has six square faces, not the shape {radiance.shape}")
    check_edge(radiance.shape[1])
    if not np.isfinite(radiance).all():
        raise ValueError("the radiance of a cube map must be finite")
    if not 0 <= threshold <= LIGHT_BOUND:
        raise ValueError(f"a threshold of {threshold} is outside 0 … {LIGHT_BOUND}")
    values = cube_coefficients(radiance)
    details = values[FACES:]
    largest = float(np.abs(details).max())
    step = largest / LIGHT_BOUND if quantum is None else quantum
    quantised = np.zeros(values.shape, np.int16)
    if step > 0.0:
        rounded = np.clip(np.rint(details / step), -LIGHT_BOUND, LIGHT_BOUND)
        dropped = np.abs(rounded).max(axis=1, keepdims=True) < threshold
        quantised[FACES:] = np.where(dropped, 0, rounded)
    light = WaveletLight(values[:FACES], quantised, step, 0.0, 0.0)
    return WaveletLight(values[:FACES], quantised, step, *_errors(cube_of_coefficients(light.coefficients), radiance))


def _errors(approximation: NDArray[np.float64], radiance: NDArray[np.float64]) -> tuple[float, float]:
    norm = float(np.linalg.norm(radiance))
    if norm == 0.0:
        return 0.0, 0.0
    half = radiance.shape[1] // 2
    change, whole = (
        np.abs(luminance(image).reshape(FACES, 2, half, 2, half).sum(axis=(2, 4))).sum()
        for image in (approximation - radiance, radiance)
    )
    return float(np.linalg.norm(approximation - radiance)) / norm, float(change / whole) if whole > 0.0 else 0.0

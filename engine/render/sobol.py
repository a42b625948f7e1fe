"""Numbers between 0 and 1 for Monte Carlo sums: scrambled Sobol points that need no state.

Every number is worked out from (seed, pixel, dimension, sample) alone, so it depends neither on the order of the work
nor on the number of threads. For a pixel and a dimension, the first two dimensions of Sobol's sequence are taken at a
shuffled index and scrambled after Owen; any 2^k samples that begin at a multiple of 2^k lie in as many boxes of every
shape of equal area, one in each. Shuffling makes the dimensions independent of each other (Burley, *Practical
Hash-based Owen Scrambling*, JCGT 9(4), 2020). The permutation of the bits is the one that Vegdahl published in 2021,
which mixes the low bits better than the original by Laine and Karras.

Costs about 30 ns a pair.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import scalar

#: The largest float64 below 1, and 2^-32.
BELOW_ONE = float(np.nextafter(1.0, 0.0))
_STEP = 2.0**-32

_U64 = np.uint64


def seed_state(seed: int, stream: int) -> np.uint64:
    """64 bits that a seed of any size ≥ 0 and the number of a stream stand for."""
    if seed < 0:
        raise ValueError(f"seed = {seed} must not be negative")
    low, high = np.random.SeedSequence(seed, spawn_key=(stream,)).generate_state(2)
    return _U64(int(low) | int(high) << 32)


def _second_sobol_dimension() -> NDArray[np.uint32]:
    """(4, 256): what each byte of an index adds to the second Sobol number, from direction numbers v ^ v >> 1."""
    directions = [1 << 31]
    while len(directions) < 32:
        directions.append(directions[-1] ^ directions[-1] >> 1)
    table = np.zeros((4, 256), np.uint32)
    for byte in range(4):
        for value in range(256):
            for bit in range(8):
                if value >> bit & 1:
                    table[byte, value] ^= np.uint32(directions[8 * byte + bit])
    return table


SOBOL = _second_sobol_dimension()


@scalar
def mix(state: np.uint64, number: int) -> np.uint64:
    """64 bits from 64 bits and a whole number: the finaliser of SplitMix64 (Steele2014)."""
    x = _U64(state) + (_U64(number) + _U64(1)) * _U64(0x9E3779B97F4A7C15)
    x = (x ^ (x >> _U64(30))) * _U64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> _U64(27))) * _U64(0x94D049BB133111EB)
    return x ^ (x >> _U64(31))


@scalar
def _reverse(x: np.uint32) -> np.uint32:
    x = (x >> np.uint32(16)) | (x << np.uint32(16))
    x = ((x & np.uint32(0xFF00FF00)) >> np.uint32(8)) | ((x & np.uint32(0x00FF00FF)) << np.uint32(8))
    x = ((x & np.uint32(0xF0F0F0F0)) >> np.uint32(4)) | ((x & np.uint32(0x0F0F0F0F)) << np.uint32(4))
    x = ((x & np.uint32(0xCCCCCCCC)) >> np.uint32(2)) | ((x & np.uint32(0x33333333)) << np.uint32(2))
    return ((x & np.uint32(0xAAAAAAAA)) >> np.uint32(1)) | ((x & np.uint32(0x55555555)) << np.uint32(1))


@scalar
def _permute(x: np.uint32, seed: np.uint32) -> np.uint32:
    """Bits of which each is flipped or not by a hash of those below it."""
    x = np.uint32(x ^ np.uint32(x * np.uint32(0x3D20ADEA)))
    x = np.uint32(x + seed)
    x = np.uint32(x * ((seed >> np.uint32(16)) | np.uint32(1)))
    x = np.uint32(x ^ np.uint32(x * np.uint32(0x05526C56)))
    return np.uint32(x ^ np.uint32(x * np.uint32(0x53A22864)))


@scalar
def pair(state: np.uint64, dimension: int, sample: int, sobol: np.ndarray) -> tuple[float, float]:
    """Two numbers in [0, 1) for a pixel's `state`, a dimension and a sample; `sobol` is `SOBOL`."""
    first = mix(state, 2 * dimension)
    second = mix(state, 2 * dimension + 1)
    index = _reverse(_permute(_reverse(np.uint32(sample)), np.uint32(first >> _U64(32))))
    x = _permute(index, np.uint32(first & _U64(0xFFFFFFFF)))
    y = sobol[0, index & np.uint32(255)] ^ sobol[1, (index >> np.uint32(8)) & np.uint32(255)]
    y ^= sobol[2, (index >> np.uint32(16)) & np.uint32(255)] ^ sobol[3, index >> np.uint32(24)]
    y = _permute(_reverse(y), np.uint32(second & _U64(0xFFFFFFFF)))
    return _reverse(x) * _STEP, _reverse(y) * _STEP


@scalar
def pairs(state: np.uint64, pixel: np.ndarray, dimension: int, sample: np.ndarray, sobol: np.ndarray) -> np.ndarray:
    """(N, 2) numbers in [0, 1) for pixels (N,) and their samples (N,)."""
    numbers = np.empty((pixel.size, 2))
    for n in range(pixel.size):
        numbers[n, 0], numbers[n, 1] = pair(mix(state, pixel[n]), dimension, sample[n], sobol)
    return numbers

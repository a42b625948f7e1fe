"""The compiled loops of wavelet transport: from visibility to packed vectors, and from light to the K-tuples.

`transfer` goes through a vertex term by term and colour by colour, so that what it works on (a face of one colour, one
texture of the BRDF) stays in the fastest memory: some 0.8 ms of one core for 6 × 64² texels, 4 terms and 3 colours.
`relight` reads six bytes for each coefficient and one 64-bit word of the light; three products of integers for each
bound it beside the memory.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.factor.maps import taps
from engine.kernels import parallel, prange, scalar
from engine.transport.haar import FACES, select
from engine.transport.wavelet_codes import quantised

#: Vertices that a thread takes at a time, with one room for all of them.
BLOCK = 8


@scalar
def _in_place(square: Any, room: Any, edge: int) -> None:
    """Haar transform of one face (edge, edge) in place; `room` is as large."""
    half = np.float32(0.5)
    size = edge
    while size > 1:
        middle = size // 2
        for i in range(middle):
            for j in range(middle):
                p, q = square[2 * i, 2 * j], square[2 * i, 2 * j + 1]
                r, s = square[2 * i + 1, 2 * j], square[2 * i + 1, 2 * j + 1]
                room[i, j] = half * ((p + q) + (r + s))
                room[i, middle + j] = half * ((p - q) + (r - s))
                room[middle + i, j] = half * ((p + q) - (r + s))
                room[middle + i, middle + j] = half * ((p - q) - (r - s))
        square[:size, :size] = room[:size, :size]
        size = middle


@scalar
def _lit(
    frame: Any, visible: Any, direction: Any, area: Any, kind: int, size: int, lit: Any, place: Any, weight: Any
) -> int:
    """The texels above the horizon that see the sky, where the light maps are looked up there, and how many they are.

    `weight` (M, 4) holds the four weights of the look-up times visibility, cosine and solid angle.
    """
    tap, share = np.empty(4, np.int64), np.empty(4)
    count = 0
    for m in range(len(direction)):
        if visible[m] <= 0.0:
            continue
        x, y, z = direction[m, 0], direction[m, 1], direction[m, 2]
        up = frame[0, 2] * x + frame[1, 2] * y + frame[2, 2] * z
        if up <= 0.0:
            continue
        right = frame[0, 0] * x + frame[1, 0] * y + frame[2, 0] * z
        ahead = frame[0, 1] * x + frame[1, 1] * y + frame[2, 1] * z
        taps(kind, size, right, ahead, min(up, 1.0), tap, share)
        factor = visible[m] * up * area[m]
        lit[count] = m
        for k in range(4):
            place[count, k] = tap[k]
            weight[count, k] = share[k] * factor
        count += 1
    return count


@parallel
def transfer(
    frames: Any,
    visible: Any,
    direction: Any,
    area: Any,
    kind: int,
    size: int,
    maps: Any,
    order: Any,
    indices: Any,
    words: Any,
    peaks: Any,
    counts: Any,
) -> None:
    """Packed transport vectors of vertices.

    Parameters
    ----------
    frames : (B, 3, 3) float64 with columns tangent, bitangent, normal. visible : (B, M) float32 in [0, 1].
    direction : (M, 3) float64 of the texels, face by face. area : (M,) float64 their solid angles.
    kind, size : of the map of the light maps (`DirectionMap`). maps : (K, P, texels) float32; P is 1 where all colours
        are alike, else 3.
    order : (M,) where each index lies (`haar.places`).
    indices, words, peaks, counts : filled, (B, K, N_l) uint16, (B, K, N_l) uint32, (B, K, 3) float32, (B, K) uint16.
    """
    vertices, texels = visible.shape
    edge = int(np.sqrt(texels // FACES))
    terms, planes = maps.shape[0], maps.shape[1]
    wanted = indices.shape[2]
    for block in prange((vertices + BLOCK - 1) // BLOCK):
        lit, place, weight = (
            np.empty(texels, np.int64),
            np.empty((texels, 4), np.int32),
            np.empty((texels, 4), np.float32),
        )
        cube = np.empty((planes, texels), np.float32)
        squared, room, square = (
            np.empty(texels, np.float32),
            np.empty(texels, np.float32),
            np.empty((edge, edge), np.float32),
        )
        kept, values = np.empty(wanted, np.int64), np.zeros((wanted, 3), np.float32)
        for v in range(block * BLOCK, min((block + 1) * BLOCK, vertices)):
            count = _lit(frames[v], visible[v], direction, area, kind, size, lit, place, weight)
            for k in range(terms):
                for p in range(planes):
                    _project(maps[k, p], lit[:count], place, weight, cube[p].reshape((FACES, edge, edge)), square)
                for index in range(texels):
                    at = order[index]
                    total = cube[0, at] * cube[0, at]
                    for p in range(1, planes):
                        total += cube[p, at] * cube[p, at]
                    squared[index] = total
                number = select(squared, kept, room)
                for n in range(number):
                    for channel in range(3):
                        values[n, channel] = cube[channel if planes == 3 else 0, order[kept[n]]]
                counts[v, k] = _store(values[:number], kept, indices[v, k], words[v, k], peaks[v, k])


@scalar
def _project(light_map: Any, lit: Any, place: Any, weight: Any, cube: Any, square: Any) -> None:
    """Coefficients of one colour of one term: the light map at all texels that are lit, transformed face by face."""
    edge = cube.shape[1]
    flat = cube.reshape(-1)
    flat[:] = np.float32(0.0)
    for n in range(len(lit)):
        flat[lit[n]] = (weight[n, 0] * light_map[place[n, 0]] + weight[n, 1] * light_map[place[n, 1]]) + (
            weight[n, 2] * light_map[place[n, 2]] + weight[n, 3] * light_map[place[n, 3]]
        )
    start = 0
    for face in range(FACES):
        stop = start
        while stop < len(lit) and lit[stop] < (face + 1) * edge * edge:
            stop += 1
        if stop > start:
            _in_place(cube[face], square, edge)
        start = stop


@scalar
def _store(values: Any, kept: Any, index: Any, word: Any, peak: Any) -> int:
    """Quantise `values` (n, 3) and keep those whose codes are not all 0; how many."""
    quantised(values, peak, word)
    count = 0
    for n in range(len(values)):
        if word[n] != 0:
            word[count], index[count] = word[n], kept[n]
            count += 1
    for n in range(count, len(index)):
        word[n], index[n] = 0, 0
    return count


def packed_light(codes: NDArray[np.int16]) -> NDArray[np.int64]:
    """(M,) words of light codes (M, 3): red in bits 0–15, green in 16–31, blue in the highest 16."""
    four = np.zeros((len(codes), 4), "<i2")
    four[:, :2], four[:, 3] = codes[:, :2], codes[:, 2]
    return four.view("<i8").reshape(-1)


@parallel
def relight(
    indices: Any, words: Any, peaks: Any, counts: Any, light: Any, scaling: Any, quantum: float, result: Any
) -> None:
    """`result` (R, 3) float64: for each vector the sum over its coefficients of transport times light.

    `light` (M,) as `packed_light`, `scaling` (6, 3) float64 for the indices below 6. Sums of the details are exact.
    """
    for r in prange(len(words)):
        count = np.int64(counts[r])
        m = np.int64(0)
        first, second, third = 0.0, 0.0, 0.0
        while m < count and indices[r, m] < FACES:
            word, i = words[r, m], indices[r, m]
            first += scaling[i, 0] * np.int32(np.int32(word << 21) >> 21)
            second += scaling[i, 1] * np.int32(np.int32(word << 10) >> 21)
            third += scaling[i, 2] * (np.int32(word) >> 22)
            m += 1
        red, green, blue = np.int64(0), np.int64(0), np.int64(0)
        for n in range(m, count):
            word, of_light = words[r, n], light[indices[r, n]]
            red += np.int64(np.int32(np.int32(word << 21) >> 21)) * (np.int64(of_light << 48) >> 48)
            green += np.int64(np.int32(np.int32(word << 10) >> 21)) * (np.int64(of_light << 32) >> 48)
            blue += np.int64(np.int32(word) >> 22) * np.int64(of_light >> 48)
        result[r, 0] = np.float64(peaks[r, 0]) / 1023.0 * (first + quantum * red)
        result[r, 1] = np.float64(peaks[r, 1]) / 1023.0 * (second + quantum * green)
        result[r, 2] = np.float64(peaks[r, 2]) / 511.0 * (third + quantum * blue)

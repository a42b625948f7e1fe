"""The compiled loops of wavelet transport: from visibility to packed vectors, and from light to the K-tuples.

`transfer` goes through a vertex face by face, and looks all colours of all terms up at once, which lie side by side:
some 0.45 ms of one core for 6 × 64² texels and 4 terms, 0.9 ms where these have 3 colours.
`relight` reads six bytes for each coefficient and one 64-bit word of the light; three products of integers for each
bound it beside the memory.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import parallel, prange, scalar
from engine.factor.hemisphere_map import taps
from engine.transport.wavelet.haar import FACES, select
from engine.transport.wavelet.quantise import quantise_vectors

Bools = NDArray[np.bool_]
Integers = NDArray[np.integer]
Floats = NDArray[np.floating]

#: Vertices that a thread takes at a time, with one scratch buffer for all of them.
BLOCK = 8


@scalar
def _transform(face: int, image: Floats, scratch: Floats, coefficients: Floats) -> None:
    """Put the Haar coefficients of one face (N, N) where their indices say; `image` and `scratch` (N/2, N/2) are used
    up.

    The details of the level of `size` begin at 6 size², and those of a face there at 3 size² for each face before.
    """
    half = np.float32(0.5)
    size = len(image) // 2
    source, target = image, scratch
    while size > 0:
        block = size * size
        across = 6 * block + 3 * face * block
        for i in range(size):
            at = across + i * size
            for j in range(size):
                p, q = source[2 * i, 2 * j], source[2 * i, 2 * j + 1]
                r, s = source[2 * i + 1, 2 * j], source[2 * i + 1, 2 * j + 1]
                target[i, j] = half * ((p + q) + (r + s))
                coefficients[at + j] = half * ((p - q) + (r - s))
                coefficients[at + block + j] = half * ((p + q) - (r + s))
                coefficients[at + 2 * block + j] = half * ((p - q) - (r - s))
        source, target = target, source
        size //= 2
    coefficients[face] = source[0, 0]


@scalar
def inner_cells(kind: int, size: int) -> NDArray[np.bool_]:
    """(size, size) bool: cells of a disk map of which all four corners (r, c) … (r + 1, c + 1) lie in the disk."""
    inner = np.zeros((size, size), np.bool_)
    if kind == 1:
        return inner
    for r in range(size - 1):
        for c in range(size - 1):
            x, y = max(abs(2 * c + 1 - size), abs(2 * c + 3 - size)), max(abs(2 * r + 1 - size), abs(2 * r + 3 - size))
            inner[r, c] = x * x + y * y <= size * size
    return inner


@scalar
def _find_lit(
    frame: Floats,
    visible: Integers,
    full: int,
    direction: Floats,
    area: Floats,
    kind: int,
    size: int,
    inner: Bools,
    lit: Integers,
    place: Integers,
    weight: Floats,
) -> int:
    """The texels above the horizon that see the sky, where the light maps are looked up there, and how many they are.

    `weight` (M, 4) holds the four weights of the look-up times visibility, cosine and solid angle.
    """
    tap, share = np.empty(4, np.int64), np.empty(4)
    count = 0
    for m in range(len(direction)):
        if visible[m] == 0:
            continue
        x, y, z = direction[m, 0], direction[m, 1], direction[m, 2]
        up = frame[0, 2] * x + frame[1, 2] * y + frame[2, 2] * z
        if up <= 0.0:
            continue
        right = frame[0, 0] * x + frame[1, 0] * y + frame[2, 0] * z
        ahead = frame[0, 1] * x + frame[1, 1] * y + frame[2, 1] * z
        factor = visible[m] * up * area[m] / full
        lit[count] = m
        stretch = 0.5 / (1.0 + up) if kind == 2 else 0.5
        column, row = (right * stretch + 0.5) * size - 0.5, (ahead * stretch + 0.5) * size - 0.5
        left, low = int(column), int(row)
        if column >= 0.0 and row >= 0.0 and left < size and low < size and inner[low, left]:
            # inside a disk nothing is to be shared out anew: bilinear weights as they are
            along, across = row - low, column - left
            first = low * size + left
            place[count, 0], place[count, 1], place[count, 2], place[count, 3] = (
                first,
                first + 1,
                first + size,
                first + size + 1,
            )
            weight[count, 0] = (1.0 - along) * (1.0 - across) * factor
            weight[count, 1] = (1.0 - along) * across * factor
            weight[count, 2] = along * (1.0 - across) * factor
            weight[count, 3] = along * across * factor
        else:
            taps(kind, size, right, ahead, min(up, 1.0), tap, share)
            for k in range(4):
                place[count, k] = tap[k]
                weight[count, k] = share[k] * factor
        count += 1
    return count


@parallel
def transfer(
    frames: Floats,
    visible: Integers,
    full: int,
    direction: Floats,
    area: Floats,
    kind: int,
    size: int,
    maps: Floats,
    capacity: int,
    step: int,
    indices: Integers,
    words: Integers,
    peaks: Floats,
    counts: Integers,
) -> None:
    """Packed transport vectors of vertices.

    Parameters
    ----------
    frames : (B, 3, 3) float64 with columns tangent, bitangent, normal.
    visible : (B, M) uint8, how many of the `full` parts of each texel see the sky.
    direction : (M, 3) float64 of the texels, face by face. area : (M,) float64 their solid angles.
    kind, size : of the map of the light maps (`HemisphereMap`). maps : (K, P, texels) float32; P is 1 where all colours
        are alike, else 3.
    capacity : of candidates for the strongest coefficients (`haar.candidates`). step : as for `quantise_vectors`.
    indices, words, peaks, counts : filled, (B, K, N_l) uint16, (B, K, N_l) uint32, (B, K, 3) float32, (B, K) uint16.
    """
    vertices, texels = visible.shape
    edge = int(np.sqrt(texels // FACES))
    terms, planes = maps.shape[0], maps.shape[1]
    wanted = indices.shape[2]
    inner = inner_cells(kind, size)
    light_maps = np.ascontiguousarray(maps.reshape(terms * planes, -1).T)
    for block in prange((vertices + BLOCK - 1) // BLOCK):
        lit, place = np.empty(texels, np.int64), np.empty((texels, 4), np.int32)
        weight, cubes = np.empty((texels, 4), np.float32), np.empty((terms * planes, texels), np.float32)
        images, square = (
            np.empty((terms * planes, edge * edge), np.float32),
            np.empty((edge // 2, edge // 2), np.float32),
        )
        kept, values = np.empty(wanted, np.int64), np.zeros((wanted, 3), np.float32)
        held, scratch = np.empty(capacity, np.float32), np.empty(capacity, np.float32)
        index = np.empty(capacity, np.int64)
        for v in range(block * BLOCK, min((block + 1) * BLOCK, vertices)):
            count = _find_lit(frames[v], visible[v], full, direction, area, kind, size, inner, lit, place, weight)
            _project(light_maps, lit[:count], place, weight, images, square, cubes)
            for k in range(terms):
                cube = cubes[k * planes : (k + 1) * planes]
                number = select(cube, kept, held, scratch, index)
                for n in range(number):
                    for channel in range(3):
                        values[n, channel] = cube[channel if planes == 3 else 0, kept[n]]
                counts[v, k] = store_vector(values[:number], kept, step, indices[v, k], words[v, k], peaks[v, k])


@scalar
def _project(
    light_maps: Floats,
    lit: Integers,
    place: Integers,
    weight: Floats,
    images: Floats,
    square: Floats,
    coefficients: Floats,
) -> None:
    """Coefficients (Q, M) of all colours of all terms: light maps (texels, Q) where it is lit, transformed by faces."""
    texels = images.shape[1]
    edge = len(square) * 2
    coefficients[:] = np.float32(0.0)
    n = 0
    for face in range(FACES):
        if n == len(lit) or lit[n] >= (face + 1) * texels:
            continue
        images[:] = np.float32(0.0)
        while n < len(lit) and lit[n] < (face + 1) * texels:
            m = lit[n] - face * texels
            a, b, c, d = place[n, 0], place[n, 1], place[n, 2], place[n, 3]
            for q in range(len(images)):
                images[q, m] = (weight[n, 0] * light_maps[a, q] + weight[n, 1] * light_maps[b, q]) + (
                    weight[n, 2] * light_maps[c, q] + weight[n, 3] * light_maps[d, q]
                )
            n += 1
        for q in range(len(images)):
            _transform(face, images[q].reshape(edge, edge), square, coefficients[q])


@scalar
def store_vector(values: Floats, kept: Integers, step: int, index: Integers, word: Integers, peak: Floats) -> int:
    """Quantise `values` (n, 3) and keep those that are not all 0 then; how many."""
    exact = 0
    while exact < len(values) and kept[exact] < FACES:
        exact += 1
    quantise_vectors(values, peak, word, step, exact)
    count = 0
    for n in range(len(values)):
        if word[n] != 0:
            word[count], index[count] = word[n], kept[n]
            count += 1
    for n in range(count, len(index)):
        word[n], index[n] = 0, 0
    return count


def pack_light(quantised: NDArray[np.int16]) -> NDArray[np.int64]:
    """(M,) words of the quantised light (M, 3): red in bits 0–15, green in 16–31, blue in the highest 16."""
    four = np.zeros((len(quantised), 4), "<i2")
    four[:, :2], four[:, 3] = quantised[:, :2], quantised[:, 2]
    return four.view("<i8").reshape(-1)


@parallel
def relight(
    indices: Integers,
    words: Integers,
    peaks: Floats,
    counts: Integers,
    light: Integers,
    scaling: Floats,
    quantum: float,
    result: Floats,
) -> None:
    """`result` (R, 3) float64: for each vector the sum over its coefficients of transport times light.

    `light` (M,) as `pack_light`, `scaling` (6, 3) float64 for the indices below 6. Sums of the details are exact.
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


@scalar
def by_coefficient(
    indices: Integers, words: Integers, counts: Integers, coefficients: int
) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.uint32]]:
    """The vectors sorted by coefficient: where each begins (M + 1,), and the row (E,) and word (E,) of each entry."""
    start = np.zeros(coefficients + 1, np.int64)
    for r in range(len(words)):
        for m in range(counts[r]):
            start[np.int64(indices[r, m]) + 1] += 1
    for m in range(coefficients):
        start[m + 1] += start[m]
    row, word = np.empty(start[coefficients], np.int32), np.empty(start[coefficients], np.uint32)
    next_free = start[:-1].copy()
    for r in range(len(words)):
        for m in range(counts[r]):
            place = next_free[indices[r, m]]
            row[place], word[place] = r, words[r, m]
            next_free[indices[r, m]] += 1
    return start, row, word


@scalar
def add_changes(
    start: Integers,
    row: Integers,
    word: Integers,
    changed: Integers,
    change: NDArray[np.number],
    sums: NDArray[np.number],
) -> None:
    """Add to `sums` (R, 3), of integers or floats, what the coefficients `changed` change by `change` (M, 3)."""
    for m in changed:
        for place in range(start[m], start[m + 1]):
            r, packed = row[place], word[place]
            sums[r, 0] += np.int32(np.int32(packed << 21) >> 21) * change[m, 0]
            sums[r, 1] += np.int32(np.int32(packed << 10) >> 21) * change[m, 1]
            sums[r, 2] += (np.int32(packed) >> 22) * change[m, 2]


@scalar
def finish_sums(peaks: Floats, sums: NDArray[np.number], scaling: Floats, quantum: float, result: Floats) -> None:
    """`result` (R, 3) of sums over details and over scaling coefficients, as in `relight`."""
    for r in range(len(peaks)):
        for channel in range(3):
            bound = 511.0 if channel == 2 else 1023.0
            total = scaling[r, channel] + quantum * sums[r, channel]
            result[r, channel] = np.float64(peaks[r, channel]) / bound * total

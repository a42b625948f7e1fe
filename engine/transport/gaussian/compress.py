"""Lobes in few bytes: views that reflect nothing are left out, and the others are coded with some thousandths of error.

    lit      12 bytes a vertex     which of the 92 views reflect anything, as bits
    mean     3 bytes a lobe        on an octahedron, 12 bits a coordinate: right to 1e-3 rad
    sigma    1 byte a lobe         its logarithm in 255 steps of 3 % between the widths that lobes may have
    energy   4 bytes a lobe        w ∫ G in RGB with one exponent, 9 bits a channel: right to 1/512 of the largest

Energy stands for the weight because it is what a lobe reflects of even light: an error of the width leaves it. Where
the widths and energies of all lobes are close to few thousand pairs of both, `clustered` puts the numbers of these in
their place, 2 bytes a lobe. Views that were left out get the mean direction and width of the views beside them, ring
by ring; they only serve to mix between views near the horizon of a vertex.

Green2006 Sec. 6.1, name both as what their 7 floats for every view leave to do. Bound
by memory: some 0.1 µs a lobe.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from engine.core.kernels import parallel, prange
from engine.light.gaussian_prefilter import gaussian_integral
from engine.storage.scratch import scratch_array
from engine.transport.gaussian.fitting.lobes import NARROWEST, WIDEST_LOBE, Lobes
from engine.transport.gaussian.fitting.views import VIEWS, view_directions, view_neighbours

#: Steps of a coordinate on the octahedron, of the logarithm of sigma, and of a channel beside the shared exponent.
MEAN_STEPS, SIGMA_STEPS, CHANNEL_STEPS = 4095, 255, 511

#: The exponent that stands for 0, of 32.
BIAS = 20

#: Clusters of widths and energies, and how far the pairs may be from them: root mean square of logarithms, by energy.
CLUSTERS, CLOSE = 4096, 0.01

#: Lobes that clusters are found from, and rounds of Lloyd's.
TRAINED, ROUNDS = 60_000, 12

#: Arrays that lobes are stored as.
NAMES = ("lit", "mean", "sigma", "energy", "book")

#: Lengths of means may be off by this; vertices and lobes that are worked on at once, so that memory need not hold what
#: is computed from all.
UNIT, ROWS, POINTS = 1e-3, 4096, 1 << 18


def compress(lobes: Lobes) -> dict[str, NDArray[Any]]:
    """`lobes` as the arrays `NAMES`; "book" is empty where clusters would be too far off."""
    lit = np.empty((len(lobes), VIEWS), np.bool_)
    for rows in _rows(len(lobes)):
        lit[rows] = lobes.weight[rows].any(axis=(2, 3))
    shape = int(np.count_nonzero(lit)), lobes.count
    sigma, energy = scratch_array(shape, np.float32), scratch_array((*shape, 3), np.float64)
    means = scratch_array((*shape, 3), np.uint8)
    for rows, some in _rows_of_lit(lit):
        seen = lit[rows]
        sigma[some], energy[some] = lobes.sigma[rows][seen], _energy(lobes, rows)[seen]
        means[some] = _mean_codes(lobes.mean[rows][seen])
    found = cluster(sigma, energy)
    if found is not None:
        book, widths, energies = *found, np.zeros((0, lobes.count), np.uint32)
    else:
        book = np.zeros((0, 4), np.float32)
        widths, energies = scratch_array(shape, np.uint8), scratch_array(shape, np.uint32)
        for _, some in _rows_of_lit(lit):
            widths[some], energies[some] = _sigma_codes(sigma[some]), _energy_codes(energy[some])
    return dict(zip(NAMES, (np.packbits(lit, axis=1), means, widths, energies, book), strict=True))


def restore(arrays: Mapping[str, NDArray[Any]], vertices: int, lobes: int) -> Lobes:
    """The lobes of so many `vertices` that `compress` made arrays of; ValueError where these cannot be.

    What is too large for memory lies in files.
    """
    codes, book = arrays["lit"], arrays["book"]
    if codes.shape != (vertices, (VIEWS + 7) // 8) or codes.dtype != np.uint8:
        raise ValueError("its lit views are those of other vertices")
    lit = np.unpackbits(codes, axis=1, count=VIEWS).astype(bool)
    count = int(lit.sum())
    clusters = len(book) > 0
    kinds = {"mean": ("|u1", (count, lobes, 3)), "sigma": ("<u2" if clusters else "|u1", (count, lobes))}
    kinds["energy"] = ("<u4", (0 if clusters else count, lobes))
    kinds["book"] = ("<f4", (len(book), 4))
    for name, (kind, shape) in kinds.items():
        if arrays[name].dtype.str != kind or arrays[name].shape != shape:
            raise ValueError(f"its {name} of lobes has the shape {arrays[name].shape} or type of others")
    if clusters and arrays["sigma"].max(initial=0) >= len(book):
        raise ValueError("its lobes name clusters that do not exist")
    if not np.isfinite(book).all():
        raise ValueError("its lobes have widths that cannot be")
    shape = (vertices, VIEWS, lobes)
    whole = Lobes(*(scratch_array(each, np.float32) for each in ((*shape, 3), (*shape, 3), shape)))
    for rows, some in _rows_of_lit(lit):
        if clusters:
            sigma, energy = book[arrays["sigma"][some], 0], book[arrays["sigma"][some], 1:]
        else:
            sigma, energy = _sigma_of(arrays["sigma"][some]), _energy_of(arrays["energy"][some])
        if not sigma.min(initial=1.0) > 0.0:
            raise ValueError("its lobes have widths that cannot be")
        weight, mean, width, seen = whole.weight[rows], whole.mean[rows], whole.sigma[rows], lit[rows]
        width[...] = 1.0
        weight[seen] = energy / gaussian_integral(sigma)[..., None]
        mean[seen], width[seen] = _mean_of(arrays["mean"][some]), sigma
        fill(seen, mean, width, view_neighbours()[0], view_directions())
    check(whole)
    return whole


def _rows(count: int) -> Iterator[slice]:
    """Some of so many vertices after the other."""
    return (slice(start, start + ROWS) for start in range(0, count, ROWS))


def _rows_of_lit(lit: NDArray[np.bool_]) -> Iterator[tuple[slice, slice]]:
    """Some vertices after the other, and where their views that are `lit` (V, 92) lie among all of these."""
    stop = 0
    for rows in _rows(len(lit)):
        start, stop = stop, stop + int(np.count_nonzero(lit[rows]))
        yield rows, slice(start, stop)


def size_bytes(arrays: Mapping[str, NDArray[Any]]) -> int:
    return sum(array.nbytes for array in arrays.values())


def check(lobes: Lobes) -> None:
    """ValueError unless lobes are finite, not negative, as wide as they may be, with means of length 1."""
    largest, least = lobes.weight.max(initial=0.0), lobes.weight.min(initial=0.0)
    if not 0.0 <= least <= largest < math.inf:  # not if any is none
        raise ValueError("its lobes have weights that cannot be")
    low, high = float(lobes.sigma.min(initial=1.0)), float(lobes.sigma.max(initial=1.0))
    if not 0.0 < low <= high < math.inf:
        raise ValueError("its lobes have widths that cannot be")
    for start in range(0, len(lobes), ROWS):
        mean = lobes.mean[start : start + ROWS]
        if not np.abs(np.einsum("...i,...i->...", mean, mean) - 1.0).max(initial=0.0) < UNIT:
            raise ValueError("its lobes have means that are not directions")


def cluster(
    sigma: NDArray[np.float32], energy: NDArray[np.float64]
) -> tuple[NDArray[np.float32], NDArray[np.uint16]] | None:
    """Pairs of sigma and energy (K, 4), and for each lobe (N, L) the number of one; None where they are not close.

    Lloyd's algorithm on logarithms, from lobes that lie evenly in their order; nothing is random.
    """
    if sigma.size < 8 * CLUSTERS:
        return None
    floor = max(float(energy.max()) * 1e-6, 1e-12)
    widths, energies = sigma.reshape(-1), energy.reshape(-1, 3)
    every = max(1, len(widths) // TRAINED)
    some, some_weight = _points(widths[::every], energies[::every], floor)
    order = np.lexsort(some.T)
    centres = some[order[np.linspace(0, len(order) - 1, CLUSTERS).astype(np.int64)]]
    for _ in range(ROUNDS):
        nearest = cKDTree(centres).query(some)[1]
        total = np.bincount(nearest, some_weight, CLUSTERS)
        sums = np.stack([np.bincount(nearest, some_weight * column, CLUSTERS) for column in some.T], axis=-1)
        centres = np.where(total[:, None] > 0.0, sums / np.where(total > 0.0, total, 1.0)[:, None], centres)
    number, tree = scratch_array((len(widths),), np.uint16), cKDTree(centres)
    square_sum = weight_sum = 0.0
    for start in range(0, len(widths), POINTS):
        part = slice(start, start + POINTS)
        points, weight = _points(widths[part], energies[part], floor)
        number[part] = nearest = tree.query(points)[1]
        square_sum += float(weight @ ((points - centres[nearest]) ** 2).max(axis=1))
        weight_sum += float(weight.sum())
    if math.sqrt(square_sum / weight_sum) > CLOSE:
        return None
    book = np.exp(centres + np.array([0.0, *(math.log(floor),) * 3]))
    book[:, 1:][book[:, 1:] <= 1.5 * floor] = 0.0
    return book.astype(np.float32), number.reshape(sigma.shape)


def _points(
    sigma: NDArray[np.float32], energy: NDArray[np.float64], floor: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Logarithms (N, 4) of widths and of energies over `floor`, and the weight (N,) of each."""
    sigma, energy = np.ascontiguousarray(sigma), np.ascontiguousarray(energy)
    points = np.column_stack([np.log(sigma), np.log(np.maximum(energy, floor))])
    points[:, 1:] -= math.log(floor)
    return points, np.maximum(energy.sum(axis=1), floor)


def _energy(lobes: Lobes, rows: slice) -> NDArray[np.float64]:
    return np.asarray(lobes.weight[rows] * gaussian_integral(lobes.sigma[rows])[..., None])


def _mean_codes(mean: NDArray[np.float32]) -> NDArray[np.uint8]:
    x, y, z = np.moveaxis(mean.astype(np.float64), -1, 0)
    size = np.abs(x) + np.abs(y) + np.abs(z)
    x, y = x / size, y / size
    folded = z < 0.0
    x, y = (
        np.where(folded, (1.0 - np.abs(y)) * np.where(x < 0.0, -1.0, 1.0), x),
        np.where(folded, (1.0 - np.abs(x)) * np.where(y < 0.0, -1.0, 1.0), y),
    )
    a, b = (np.round((part * 0.5 + 0.5) * MEAN_STEPS).astype(np.uint32) for part in (x, y))
    return np.stack([a & 255, a >> 8 | (b & 15) << 4, b >> 4], axis=-1).astype(np.uint8)


def _mean_of(codes: NDArray[np.uint8]) -> NDArray[np.float32]:
    low, middle, high = (codes[..., k].astype(np.uint32) for k in range(3))
    x = (low | (middle & 15) << 8) * (2.0 / MEAN_STEPS) - 1.0
    y = (middle >> 4 | high << 4) * (2.0 / MEAN_STEPS) - 1.0
    z = 1.0 - np.abs(x) - np.abs(y)
    fold = np.maximum(-z, 0.0)
    x, y = x - np.where(x < 0.0, -fold, fold), y - np.where(y < 0.0, -fold, fold)
    mean = np.stack([x, y, z], axis=-1)
    return np.asarray(mean / np.sqrt((mean**2).sum(axis=-1))[..., None], np.float32)


def _sigma_codes(sigma: NDArray[np.float32]) -> NDArray[np.uint8]:
    span = math.log(WIDEST_LOBE / NARROWEST)
    place = np.log(sigma.astype(np.float64) / NARROWEST) / span
    return np.round(np.clip(place, 0.0, 1.0) * SIGMA_STEPS).astype(np.uint8)


def _sigma_of(codes: NDArray[np.uint8]) -> NDArray[np.float32]:
    span = math.log(WIDEST_LOBE / NARROWEST)
    return np.asarray(NARROWEST * np.exp(codes.astype(np.float64) / SIGMA_STEPS * span), np.float32)


def _energy_codes(energy: NDArray[np.float64]) -> NDArray[np.uint32]:
    largest = energy.max(axis=-1)
    exponent = np.clip(np.ceil(np.log2(np.maximum(largest, 1e-30))).astype(np.int64), -BIAS, 31 - BIAS)
    steps = np.round(np.clip(energy / 2.0 ** exponent[..., None], 0.0, 1.0) * CHANNEL_STEPS).astype(np.uint32)
    code: NDArray[np.uint32] = steps[..., 0] | steps[..., 1] << 9 | steps[..., 2] << 18
    return code | (exponent + BIAS).astype(np.uint32) << 27


def _energy_of(codes: NDArray[np.uint32]) -> NDArray[np.float64]:
    scale = 2.0 ** ((codes >> 27).astype(np.int64) - BIAS) / CHANNEL_STEPS
    return np.stack([(codes >> shift & 511) * scale for shift in (0, 9, 18)], axis=-1)


@parallel
def fill(
    lit: NDArray[np.bool_],
    mean: NDArray[np.floating],
    sigma: NDArray[np.floating],
    neighbours: NDArray[np.integer],
    directions: NDArray[np.floating],
) -> None:
    """Give views of V vertices that are not `lit` (V, 92) the mean of the views beside them, ring by ring."""
    views, lobes = sigma.shape[1], sigma.shape[2]
    for vertex in prange(len(lit)):
        ring = np.empty(views, np.int64)
        for view in range(views):
            ring[view] = 0 if lit[vertex, view] else views
        left, number = True, 0
        while left:
            left, number = False, number + 1
            for view in range(views):
                if ring[view] < number:
                    continue
                count = 0
                for k in range(neighbours.shape[1]):
                    other = neighbours[view, k]
                    count += other >= 0 and ring[other] < number
                if count == 0:
                    continue
                ring[view], left = number, True
                for lobe in range(lobes):
                    x = y = z = width = 0.0
                    for k in range(neighbours.shape[1]):
                        other = neighbours[view, k]
                        if other >= 0 and ring[other] < number:
                            x += mean[vertex, other, lobe, 0]
                            y += mean[vertex, other, lobe, 1]
                            z += mean[vertex, other, lobe, 2]
                            width += sigma[vertex, other, lobe]
                    length = math.sqrt(x * x + y * y + z * z)
                    sigma[vertex, view, lobe] = width / count
                    if length > 1e-6:
                        mean[vertex, view, lobe, 0] = x / length
                        mean[vertex, view, lobe, 1] = y / length
                        mean[vertex, view, lobe, 2] = z / length
                    else:
                        for axis in range(3):
                            mean[vertex, view, lobe, axis] = directions[view, axis]
        for view in range(views):
            if ring[view] == views:
                for lobe in range(lobes):
                    sigma[vertex, view, lobe] = 0.5
                    for axis in range(3):
                        mean[vertex, view, lobe, axis] = directions[view, axis]

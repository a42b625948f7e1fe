"""Match lobes between neighbouring vertices and views; count and repair swaps.

Two neighbours (vertices joined by an edge, towards the same view; or neighbouring views of a vertex) are flipped when
numbering the lobes of one of them otherwise would bring them nearer, by Σ |mean − other|² + (sigma − other)² over the
lobes. Of two lobes as wide as each other that is where ⟨a, b⟩ of Green2006 Eq. 10 is negative. A pair
counts where two lobes at least hold a hundredth of the energy on both sides, and only such lobes are exchanged: what is
not seen cannot flip.

Bound by memory: about 0.3 s of a core for all pairs of 10,000 vertices with two lobes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph

from engine.core.kernels import parallel, prange, scalar
from engine.transport.gaussian.fitting.flood_fill import Flood
from engine.transport.gaussian.fitting.lobes import Lobes
from engine.transport.gaussian.fitting.vertex_kernel import ORDERS, apart, reorder
from engine.transport.gaussian.fitting.view_kernel import integral
from engine.transport.gaussian.fitting.views import view_neighbours

#: Share of the energy of its view from which on a lobe is seen, and by how much another number must be better.
SEEN, BETTER = 0.01, 1e-9

Bools = NDArray[np.bool_]
Indices = NDArray[np.int64]
Floats = NDArray[np.floating]


@dataclass(frozen=True)
class Flips:
    """Numbers of flipped pairs of neighbouring vertices and of neighbouring views, and of all pairs."""

    vertices: int
    vertices_compared: int
    views: int
    views_compared: int


def flips(lobes: Lobes, order: Flood) -> Flips:
    """All pairs, each counted once."""
    counts = _counts(lobes, lobes, np.arange(len(lobes)), order).sum(axis=0)
    return Flips(int(counts[0]) // 2, int(counts[1]) // 2, int(counts[2]), int(counts[3]))


def compute_flipped_share(
    lobes: Lobes, order: Flood, own: Lobes | None = None, vertices: Indices | None = None
) -> Floats:
    """(B,) of `vertices` (all by default): the share of the pairs in which a vertex takes part that are flipped.

    With `own` (B, 92, L), of vertices of which no two are neighbours, as if they had these lobes.
    """
    if vertices is None:
        counts = _counts(lobes, lobes, np.arange(len(lobes)), order)
    else:
        counts = _counts(_make(lobes, vertices) if own is None else own, lobes, vertices, order)
    return counts[:, [0, 2]].sum(axis=1) / np.maximum(counts[:, [1, 3]].sum(axis=1), 1)


def _make(lobes: Lobes, vertices: Indices) -> Lobes:
    return Lobes(lobes.weight[vertices], lobes.mean[vertices], lobes.sigma[vertices])


def _counts(own: Lobes, lobes: Lobes, vertices: Indices, order: Flood) -> NDArray[np.int64]:
    """(B, 4) of each vertex: flipped pairs with neighbours, those compared, flipped pairs of views, those compared."""
    counts = np.zeros((len(vertices), 4), np.int64)
    if lobes.count > 1:
        orders, (neighbours, _) = ORDERS[lobes.count - 1], view_neighbours()
        count_flips(
            *(vertices, own.weight, own.mean, own.sigma, lobes.weight, lobes.mean, lobes.sigma),
            *(order.start, order.neighbour, neighbours, orders, counts),
        )
    return counts


def align(lobes: Lobes, order: Flood) -> Bools:
    """Number lobes anew in place, all views of a vertex alike, so that fronts of the flood agree where they meet.

    Along the spanning tree of the edges that are surest of their numbering (Σ over views of the second best distance
    less the best) each vertex takes over from the one before. `renumber` alone cannot move such a border: every single
    view has most of its neighbours on its own side. Returns which vertices (V,) have changed.
    """
    count, rows = len(lobes), np.repeat(np.arange(len(lobes)), np.diff(order.start))
    orders = ORDERS[lobes.count - 1]
    surety = np.zeros(len(rows))
    compare_edges(lobes.mean, lobes.sigma, rows, order.neighbour, orders, surety)
    largest = surety.max(initial=0.0) + 1.0
    root = np.full(count, count), np.arange(count), np.full(count, 2.0 * largest)  # joins what no edge joins
    beside = rows, order.neighbour, largest - surety
    ends, others, lengths = (np.concatenate(pair) for pair in zip(beside, root, strict=True))
    graph = sparse.coo_array((lengths, (ends, others)), (count + 1, count + 1)).tocsr()
    tree = csgraph.minimum_spanning_tree(graph)
    sequence, before = csgraph.breadth_first_order(tree, count, directed=False)
    changed = np.zeros(count, np.bool_)
    follow(lobes.weight, lobes.mean, lobes.sigma, sequence, before, orders, changed)
    return changed


def renumber(lobes: Lobes, order: Flood, sweeps: int) -> Bools:
    """Number lobes anew in place, vertex by vertex and view by view, while that brings neighbours nearer.

    The sum over all pairs of neighbours never grows, so this ends. Returns which vertices (V,) have changed.
    """
    changed = np.zeros(len(lobes), np.bool_)
    sequence, (neighbours, _) = np.concatenate(order.fronts), view_neighbours()
    orders = ORDERS[lobes.count - 1]
    for _ in range(sweeps):
        if not renumber_once(
            lobes.weight, lobes.mean, lobes.sigma, sequence, order.start, order.neighbour, neighbours, orders, changed
        ):
            break
    return changed


@scalar
def _observe(weight: Floats, sigma: Floats, seen: Bools) -> int:
    """Fill `seen` (L,): whether each lobe holds enough of the energy; how many do."""
    total = 0.0
    energy = np.empty(len(sigma))
    for lobe in range(len(sigma)):
        width = max(float(sigma[lobe]), 1e-9)
        energy[lobe] = (weight[lobe, 0] + weight[lobe, 1] + weight[lobe, 2]) * integral(width)
        total += energy[lobe]
    count = 0
    for lobe in range(len(sigma)):
        seen[lobe] = energy[lobe] > SEEN * total
        count += seen[lobe]
    return count


@scalar
def compare(
    weight: Floats,
    mean: Floats,
    sigma: Floats,
    other_weight: Floats,
    other_mean: Floats,
    other_sigma: Floats,
    orders: Indices,
) -> int:
    """Comparison of two neighbours: 1 flipped, 0 not, −1 not compared."""
    lobes = len(sigma)
    seen, other_seen = np.empty(lobes, np.bool_), np.empty(lobes, np.bool_)
    _observe(weight, sigma, seen)
    _observe(other_weight, other_sigma, other_seen)
    both = 0
    for lobe in range(lobes):
        seen[lobe] = seen[lobe] and other_seen[lobe]
        both += seen[lobe]
    if both < 2:
        return -1
    now = apart(orders[0], mean, sigma, other_mean, other_sigma)
    for way in range(1, len(orders)):
        allowed = True
        for lobe in range(lobes):
            allowed = allowed and (orders[way, lobe] == lobe or seen[lobe])
        if allowed and apart(orders[way], mean, sigma, other_mean, other_sigma) < now - BETTER:
            return 1
    return 0


@parallel
def count_flips(
    vertices: Indices, own_weight: Floats, own_mean: Floats, own_sigma: Floats, weight: Floats, mean: Floats,
    sigma: Floats, start: Indices, neighbour: Indices, neighbours: Indices, orders: Indices, counts: Indices,
) -> None:  # fmt: skip
    """Fill `counts` (B, 4) as `_counts` says."""
    for row in prange(len(vertices)):
        vertex = vertices[row]
        for view in range(sigma.shape[1]):
            w, m, s = own_weight[row, view], own_mean[row, view], own_sigma[row, view]
            for k in range(start[vertex], start[vertex + 1]):
                other = neighbour[k]
                found = compare(w, m, s, weight[other, view], mean[other, view], sigma[other, view], orders)
                counts[row, 0] += max(found, 0)
                counts[row, 1] += found >= 0
            for k in range(neighbours.shape[1]):
                beside = neighbours[view, k]
                if beside > view:
                    found = compare(
                        w, m, s, own_weight[row, beside], own_mean[row, beside], own_sigma[row, beside], orders
                    )
                    counts[row, 2] += max(found, 0)
                    counts[row, 3] += found >= 0


@scalar
def _sum_apart(way: Indices, mean: Floats, sigma: Floats, other_mean: Floats, other_sigma: Floats) -> float:
    """Distance of all views of a vertex, lobes (92, L, …) taken in one order, from those of another."""
    total = 0.0
    for view in range(len(sigma)):
        total += apart(way, mean[view], sigma[view], other_mean[view], other_sigma[view])
    return total


@parallel
def compare_edges(
    mean: Floats, sigma: Floats, rows: Indices, neighbour: Indices, orders: Indices, surety: Floats
) -> None:
    """Fill `surety` (E,) of the edges from `rows` to `neighbour`: the second lowest distance less the lowest."""
    for edge in prange(len(rows)):
        one, other = rows[edge], neighbour[edge]
        lowest, second = np.inf, np.inf
        for way in range(len(orders)):
            unlike = _sum_apart(orders[way], mean[one], sigma[one], mean[other], sigma[other])
            second = min(second, max(lowest, unlike))
            lowest = min(lowest, unlike)
        surety[edge] = second - lowest


@scalar
def follow(
    weight: Floats, mean: Floats, sigma: Floats, sequence: Indices, before: Indices, orders: Indices, changed: Bools
) -> None:
    """Number each vertex of `sequence` as the one `before` it; those behind the root, the last number, stay."""
    for vertex in sequence:
        if vertex == len(sigma) or before[vertex] == len(sigma):
            continue
        best, lowest = 0, np.inf
        for way in range(len(orders)):
            unlike = _sum_apart(orders[way], mean[vertex], sigma[vertex], mean[before[vertex]], sigma[before[vertex]])
            if unlike < lowest - BETTER:
                best, lowest = way, unlike
        if best > 0:
            changed[vertex] = True
            for view in range(sigma.shape[1]):
                reorder(orders[best], mean[vertex, view], sigma[vertex, view], weight[vertex, view])


@scalar
def renumber_once(
    weight: Floats, mean: Floats, sigma: Floats, sequence: Indices, start: Indices, neighbour: Indices,
    neighbours: Indices, orders: Indices, changed: Bools,
) -> bool:  # fmt: skip
    """One sweep of `renumber`; whether anything has changed."""
    any_change = False
    for vertex in sequence:
        for view in range(sigma.shape[1]):
            best, lowest = 0, np.inf
            for way in range(len(orders)):
                unlike = 0.0
                for k in range(start[vertex], start[vertex + 1]):
                    other = neighbour[k]
                    unlike += apart(
                        orders[way], mean[vertex, view], sigma[vertex, view], mean[other, view], sigma[other, view]
                    )
                for k in range(neighbours.shape[1]):
                    beside = neighbours[view, k]
                    if beside >= 0:
                        unlike += apart(
                            orders[way], mean[vertex, view], sigma[vertex, view], mean[vertex, beside],
                            sigma[vertex, beside],
                        )  # fmt: skip
                if unlike < lowest - BETTER:
                    best, lowest = way, unlike
            if best == 0:
                continue
            any_change = changed[vertex] = True
            reorder(orders[best], mean[vertex, view], sigma[vertex, view], weight[vertex, view])
    return any_change

"""A few directional lights in place of an environment map: a tree of regions, each one light of all that it holds.

Like median cut (Debevec, *A Median Cut Algorithm for Light Probe Sampling*, 2005), the map is cut into rectangles, and
each becomes a light in the mean direction of its light that carries the whole of it, in every channel. As by Viriyothai
and Debevec (*Variance Minimization Light Probe Sampling*, 2009), a rectangle is cut where the spread of directions in
its halves is least; spread is the sum over cells of E |d - mean d|^2 with luminance E. What is cut next is the region
of the largest spread times sqrt(E), between the error of one sign that its spread bounds and the square of that error.
So one tree serves every number of lights, each choice refines the one before, and no light has a colour by chance.

Points drawn by inversion of the luminance, which this replaces, showed 4.6 % error with 64 lights under Grace Cathedral
on a diffuse material, 27 % on a shiny one (Phong, exponent 100), and 4.5 and 9.3 % with 512; the tree shows 0.5, 9.4,
0.1 and 0.8 %. Ten rounds of Lloyd's relaxation after each choice gain a tenth or less, cost seconds, and the choices no
longer refine each other.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from engine.core.colour import luminance
from engine.core.directions import normalize
from engine.light.environment import Cells, DistantLights, EnvironmentMap, cells

#: Rows of the cells that are gathered, of 0.7 degrees; light keeps its direction inside its cell.
CELL_ROWS = 256

#: Trees are grown to this many lights at least, so that trying several numbers costs one tree.
GROWN = 512

#: The tree of each map, and the leaves that it was grown to.
_trees: WeakKeyDictionary[EnvironmentMap, tuple[int, LightTree]] = WeakKeyDictionary()

#: Rows, columns (each from, to) of a region of cells.
Region = tuple[int, int, int, int]


@dataclass(frozen=True, eq=False)
class LightTree:
    """Lights of which some stand for others: of n lights, those with `made` <= n < `cut`.

    Attributes
    ----------
    lights : of all M nodes of the tree.
    made, cut : (M,) number of lights with which a node appears, and with which its two halves take its place.
    """

    lights: DistantLights
    made: NDArray[np.int64]
    cut: NDArray[np.int64]

    def choice(self, count: int) -> DistantLights:
        """`count` lights, or all there are; they carry the whole flux, and the first choice that of one light."""
        chosen = (self.made <= count) & (count < self.cut)
        return DistantLights(self.lights.direction[chosen], self.lights.irradiance[chosen])


def choose_lights(environment: EnvironmentMap, count: int) -> DistantLights:
    """At most `count` lights that stand for the map: fewer where fewer cells are lit, a black one where none is.

    A map has its tree as long as it lives; the first choice from a map takes about 0.5 s, the next none. Raises
    ValueError for a count below 1.
    """
    if count < 1:
        raise ValueError(f"{count} directions are too few")
    grown, tree = _trees.get(environment, (0, None))
    if tree is None or grown < count:
        grown = max(GROWN, 1 << (count - 1).bit_length())
        tree = light_tree(cells(environment, CELL_ROWS), grown)
        _trees[environment] = grown, tree
    return tree.choice(count)


def light_tree(held: Cells, most: int) -> LightTree:
    """The tree of the light in `held` with `most` leaves, or one for each lit cell where these are fewer.

    About 0.3 s for 512 leaves of 256 x 512 cells: each level of the tree reads every cell once.
    """
    weight = np.stack([luminance(held.flux), *np.moveaxis(held.moment, -1, 0)])
    last = most + 1
    made, cut, regions = [1], [last], [_find_lit(weight, (0, weight.shape[1], 0, weight.shape[2]))]
    waiting: list[tuple[float, int, tuple[Region, Region]]] = []

    def consider(node: int) -> None:
        found = _halves(weight, regions[node])
        if found is not None:
            heapq.heappush(waiting, (-found[0], node, found[1]))

    consider(0)
    for count in range(2, last):
        if not waiting:
            break
        _, parent, halves = heapq.heappop(waiting)
        cut[parent] = count
        for half in halves:
            made.append(count)
            cut.append(last)
            regions.append(_find_lit(weight, half))
            consider(len(regions) - 1)
    ends = np.array(cut)
    ends[ends == last] = np.iinfo(np.int64).max
    flux = np.array([held.flux[_slices(region)].sum(axis=(0, 1)) for region in regions])
    moment = np.array([held.moment[_slices(region)].sum(axis=(0, 1)) for region in regions])
    return LightTree(DistantLights(normalize(moment), flux), np.array(made), ends)


def _slices(region: Region) -> tuple[slice, slice]:
    return slice(*region[:2]), slice(*region[2:])


def _find_lit(weight: NDArray[np.float64], region: Region) -> Region:
    """The smallest region around what is lit in `region`; empty where nothing is."""
    lit = weight[0][_slices(region)] > 0.0
    rows, columns = np.flatnonzero(lit.any(axis=1)), np.flatnonzero(lit.any(axis=0))
    if rows.size == 0:
        return (0, 0, 0, 0)
    return region[0] + rows[0], region[0] + rows[-1] + 1, region[2] + columns[0], region[2] + columns[-1] + 1


def _halves(weight: NDArray[np.float64], region: Region) -> tuple[float, tuple[Region, Region]] | None:
    """Priority of cutting `region`, and its two halves; None for one cell, or none."""
    top, bottom, left, right = region
    if (bottom - top) * (right - left) < 2:
        return None
    block = weight[:, top:bottom, left:right]
    best: tuple[float, tuple[Region, Region]] | None = None
    for axis in (0, 1):
        before = np.cumsum(block.sum(axis=2 - axis), axis=1)
        whole, before = before[:, -1:], before[:, :-1]
        if before.size == 0:
            continue
        spread = _spread(before) + _spread(whole - before)
        at = int(np.argmin(spread))
        if best is None or spread[at] < best[0]:
            place = (top, left)[axis] + at + 1
            one, other = (
                ((top, place, left, right), (place, bottom, left, right)),
                ((top, bottom, left, place), (top, bottom, place, right)),
            )[axis]
            best = float(spread[at]), (one, other)
    assert best is not None
    return float(_spread(whole)[0] * np.sqrt(whole[0, 0])), best[1]


def _spread(weight: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sum of E |d - mean d|^2 over unit vectors d, from the sums (4, N) of E and E d: E - |sum E d|^2 / E."""
    light, moment = weight[0], weight[1:]
    safe = np.where(light > 0.0, light, 1.0)
    return np.maximum(light - (moment * moment).sum(axis=0) / safe, 0.0)

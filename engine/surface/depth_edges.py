"""Depth edges: lines along which one surface stands before another, which no slope shows.

A wall that is narrower than a texel leaves no slope in the photographs: the integral of the slopes runs through it as
if it were not there, and heights on both sides lie on one level. The shadow that it casts tells it (Raskar2004): a lamp
lights a texel, and the next but one, away from the lamp, is dark. A continuous surface that is resolved by its texels
turns away from the lamp in between, and darkens over several. Each texel is compared with its own brightness under the
other lamps, so that colours do not matter, and lamps on one side have to agree. What the fit of the texels explains, by
a slope or by the end of a highlight, is no edge. Low steps, which hardly cast a shadow, are found where the height is
torn from its slopes.

Edges divide the image into regions: gaps of up to `2 GAP` texels in an outline are closed, and a border between two
regions counts where edges were seen along at least a quarter of it. Within a region heights follow from slopes; the
steps between regions are unknown.
Memory: a block of rows under all lamps, one byte each. Bound by the reading of the photographs, one more time.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from engine.capture.stack import ImageStack
from engine.core.budget import block_values
from engine.core.kernels import parallel, prange
from engine.core.quickselect import nth_smallest
from engine.core.steps import Step, Steps

Array = NDArray[np.float64]
Labels = NDArray[np.int32]
Levels = NDArray[np.uint8]

#: Level of the brightness of which a fifth of the lamps show more, of a saturated texel, and of one that is not known.
UPPER, SATURATED, UNKNOWN = 160, 254, 255

#: Least radiance of the upper brightness, over the white level.
MIN_RADIANCE = 0.004

#: Brightness of a texel that no lamp lights: its share of the brightest, and over the white level; and the share of the
#: image of the smallest part that is lit or not.
UNLIT_SHARE, MAX_UNLIT, MIN_PART = 0.01, 0.003, 5e-4

#: Level from which a texel is lit, and share of it below which the next but one is in a shadow.
LIT, DARK_SHARE = 24, 0.3

#: Lamps on one side that must show an edge: their number, and their share of those that light the texel before it; a
#: smaller share is enough where a line goes on.
MIN_LAMPS, MIN_LAMP_SHARE, MIN_SHARE_ON_A_LINE = 2, 0.5, 0.25

#: Brightness of a texel in a shadow over that of the lit one before it, by the fit, from which the shadow is one that
#: is cast; cosine over that of a flat texel from which it faces the lamp; and the share of the lamps for which both
#: must hold.
PREDICTED_SHARE, FACING, MIN_HELD_SHARE = 0.4, 0.3, 0.5

#: Distance (texels) from the middle of an edge to the texels on its sides, and rows that this reaches.
REACH, ROWS = 1.3, 2

#: Least number of lamps that are left where others are in a shadow, and distance from an edge at which shadows count.
MIN_LIT, SHADOW_REACH = 5, 40

#: Difference of a step and a slope (texels), and excess of squares, at which a height is torn, and texels of such a
#: line.
TORN, TORN_EXCESS, MIN_LINE = 0.2, 9.0, 12

#: Half of the gaps (texels) in an outline that are closed, least texels of a region, and least share of a border that
#: is seen.
GAP, MIN_REGION, SEEN_SHARE = 2.5, 64, 0.25

#: Length of edges that end within a region, over the root of its area, from which its heights are doubted.
OPEN_SHARE = 0.25

#: Values of all photographs in a block of rows at most, and bytes that one takes.
BLOCK_VALUES, VALUE_BYTES = 1 << 24, 8


@dataclass(frozen=True, eq=False)
class Division:
    """Texels on depth edges `edges` (H, W), and the number of the region of each texel `region` (H, W), from 0 by
    falling size."""

    edges: NDArray[np.bool_]
    region: Labels

    @property
    def count(self) -> int:
        """Number of regions."""
        return int(self.region.max()) + 1


@dataclass(frozen=True, eq=False)
class ShadowEdges:
    """Texels on which shadows begin: their rows and columns (E, 2), and under which lamps (E, N); and the lamps'
    directions (N, 3). `upper` (H, W) is the radiance of each texel of which a fifth of the lamps show more."""

    places: NDArray[np.int64]
    shadowed: NDArray[np.bool_]
    directions: Array
    upper: NDArray[np.float32]

    def mark(self, shape: tuple[int, int]) -> NDArray[np.bool_]:
        """(H, W) the texels."""
        edges = np.zeros(shape, np.bool_)
        edges[self.places[:, 0], self.places[:, 1]] = True
        return edges

    def confirm(
        self,
        slope: NDArray[np.float32],
        predict: Callable[[NDArray[np.int64], NDArray[np.int64]], Array],
    ) -> NDArray[np.bool_]:
        """(H, W) the texels beside which a texel is dark although its fit is not.

        `slope` (H, W, 2) are n_x / n_z and n_y / n_z, `predict` gives the radiance (N, E) of the fit of texels at rows
        and columns (E,). A steep surface that has turned away from a lamp, or from the mirror image of one, is no edge.
        """
        shape = slope.shape[:2]
        edges = np.zeros(shape, np.bool_)
        if not len(self.places):
            return edges
        bright = []
        for sign in (1, -1):
            # the neighbour differs from lamp to lamp: that of the mean direction of those that show the edge
            step = np.rint(REACH * self._mean_side() * (1.0, -1.0)).astype(np.int64)
            rows = np.clip(self.places[:, 0] + sign * step[:, 1], 0, shape[0] - 1)
            columns = np.clip(self.places[:, 1] + sign * step[:, 0], 0, shape[1] - 1)
            shown = predict(rows, columns)
            bright.append(shown / np.maximum(np.quantile(shown, 0.8, axis=0), 1e-6))
        near, far = bright
        behind = slope[rows, columns].astype(np.float64)
        cosine = (behind @ self.directions[:, :2].T + self.directions[:, 2]).T
        cosine /= np.sqrt(1.0 + (behind**2).sum(axis=1))
        faces = cosine > FACING * self.directions[:, 2:]
        held = (self.shadowed.T & faces & (far > PREDICTED_SHARE * near)).sum(axis=0)
        kept = (held >= MIN_LAMPS) & (held >= MIN_HELD_SHARE * self.shadowed.sum(axis=1))
        edges[self.places[kept, 0], self.places[kept, 1]] = True
        return edges

    def find_contradicted(self, height: Array) -> NDArray[np.bool_]:
        """(H, W) the texels beside which `height` (H, W) does not fall as far as the shadow that begins there needs.

        The ray from the dark side to a lamp meets the lit side, which is at least as high as that ray there. The
        second highest of the lamps that show the shadow counts, so that one that is out does not.
        """
        found = np.zeros(height.shape, np.bool_)
        if not len(self.places):
            return found
        step = np.rint(REACH * self._mean_side() * (1.0, -1.0)).astype(np.int64)
        lit, dark = (
            height[
                np.clip(self.places[:, 0] + sign * step[:, 1], 0, height.shape[0] - 1),
                np.clip(self.places[:, 1] + sign * step[:, 0], 0, height.shape[1] - 1),
            ]
            for sign in (1, -1)
        )
        rise = self.directions[:, 2] / np.maximum(np.hypot(self.directions[:, 0], self.directions[:, 1]), 1e-9)
        rises = np.sort(np.where(self.shadowed, rise, 0.0), axis=1)
        needed = 2.0 * np.hypot(*step.T) * rises[:, -2]
        at = self.places[lit - dark < needed]
        found[at[:, 0], at[:, 1]] = True
        return found

    def _mean_side(self) -> Array:
        """(E, 2) unit vectors towards the lamps that show an edge."""
        mean = self.shadowed.astype(np.float64) @ _towards(self.directions)[0]
        return np.asarray(mean / np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-9))


def _towards(directions: Array) -> tuple[Array, NDArray[np.int64]]:
    """(N, 2) unit vectors to lamps in the image, and steps towards them in columns and rows."""
    across = np.hypot(directions[:, 0], directions[:, 1])
    side = directions[:, :2] / np.maximum(across, 1e-9)[:, None]
    return side, np.rint(REACH * side * (1.0, -1.0)).astype(np.int64)


def find_depth_edges(stack: ImageStack, used: NDArray[np.int64], directions: Array) -> Steps[ShadowEdges]:
    """The edges that photographs `used` show under lamps in `directions` (N, 3)."""
    height, width = stack.radiance.shape[1:3]
    places, shadowed = [np.empty((0, 2), np.int64)], [np.empty((0, len(used)), np.bool_)]
    side, towards = _towards(directions)
    upper, share = np.empty((height, width), np.float32), np.zeros((height, width), np.float32)
    block = max(2 * ROWS, block_values(BLOCK_VALUES, VALUE_BYTES) // (3 * len(used) * width))
    for first in range(0, height, block):
        yield Step(first / height, "looking for depth edges")
        last = min(first + block, height)
        top, bottom = max(first - ROWS, 0), min(last + ROWS, height)
        radiance = np.asarray(stack.radiance[used, top:bottom])
        levels = np.empty(radiance.shape[:3], np.uint8)
        brightness = np.empty(radiance.shape[1:3], np.float32)
        _rank(radiance, np.asarray(stack.saturated[used, top:bottom]), levels, brightness)
        upper[first:last] = brightness[first - top : last - top]
        seen = np.zeros(levels.shape[1:], np.float32)
        _find_edges(levels, side, towards, seen)
        seen[: first - top] = seen[last - top :] = 0.0
        share[first:last] = seen[first - top : last - top]
        rows, columns = np.nonzero(seen >= MIN_SHARE_ON_A_LINE)
        places.append(np.stack([rows + top, columns], axis=1))
        shadowed.append(_find_shadowing(levels, towards, rows, columns))
    lines, number = ndimage.label(share >= MIN_SHARE_ON_A_LINE, np.ones((3, 3)))
    holds = np.zeros(number + 1, np.bool_)
    holds[lines[share >= MIN_LAMP_SHARE]] = True
    at = np.concatenate(places)
    kept = holds[lines[at[:, 0], at[:, 1]]]
    return ShadowEdges(at[kept], np.concatenate(shadowed)[kept], directions, upper)


def _find_shadowing(
    levels: Levels, towards: NDArray[np.int64], rows: NDArray[np.int64], columns: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """(E, N) lamps that light the texel before those at `rows` and `columns` (E,), and leave the one behind dark."""
    found = np.zeros((len(rows), len(levels)), np.bool_)
    for i, (across, down) in enumerate(towards):
        ends = [(rows + sign * down, columns + sign * across) for sign in (1, -1)]
        inside = np.all([(r >= 0) & (r < levels.shape[1]) & (c >= 0) & (c < levels.shape[2]) for r, c in ends], axis=0)
        near, far = (levels[i, r[inside], c[inside]].astype(np.float64) for r, c in ends)
        found[inside, i] = (near >= LIT) & (near < UNKNOWN) & (far < DARK_SHARE * near)
    return found


def find_unlit(upper: NDArray[np.float32]) -> NDArray[np.bool_]:
    """(H, W) texels of the upper brightness (H, W) that hardly any light reaches, in parts of some size.

    They are black beside the brightest, and of a brightness of which a photograph of 8 bits shows some ten levels:
    what differs from lamp to lamp in them is noise and compression.
    """
    unlit = upper < min(UNLIT_SHARE * float(np.quantile(upper, 0.99)), MAX_UNLIT)
    for dark in (False, True):  # specks of the one in the other
        parts, _ = ndimage.label(unlit == dark)
        sizes = np.bincount(parts.ravel())
        unlit ^= (parts > 0) & (sizes < max(MIN_REGION, MIN_PART * unlit.size))[parts]
    return np.asarray(unlit)


def find_beside(edges: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(H, W) texels within `SHADOW_REACH` of edges (H, W)."""
    distance = cv2.distanceTransform((~edges).astype(np.uint8), cv2.DIST_L2, 3)
    return np.asarray(distance < SHADOW_REACH)


def find_shadows(stack: ImageStack, used: NDArray[np.int64], first: int, last: int) -> NDArray[np.bool_]:
    """(N, T) texels of rows from `first` to before `last` that are in a shadow under a lamp, or beside one.

    Beside a depth edge more than half of the lamps may be hidden, more than a robust fit takes for outliers. Where
    hardly any lamp is left, nothing is taken for a shadow.
    """
    top, bottom = max(first - 1, 0), min(last + 1, stack.radiance.shape[1])
    radiance = np.asarray(stack.radiance[used, top:bottom])
    levels = np.empty(radiance.shape[:3], np.uint8)
    _rank(radiance, np.asarray(stack.saturated[used, top:bottom]), levels, np.empty(radiance.shape[1:3], np.float32))
    dark = np.stack([cv2.erode(each, np.ones((3, 3), np.uint8)) for each in levels])[:, first - top : last - top] < LIT
    dark &= (~dark).sum(axis=0) >= max(MIN_LIT, len(used) // 6)
    return np.asarray(dark.reshape(len(used), -1))


@parallel
def _rank(radiance: np.ndarray, saturated: np.ndarray, levels: np.ndarray, brightness: np.ndarray) -> None:
    """Fill `levels` (N, R, W) with the brightness of texels over their upper one, which is put into `brightness`."""
    count, rows, columns = levels.shape
    for row in prange(rows):
        grey, scratch = np.empty(count), np.empty(count)
        for column in range(columns):
            for i in range(count):
                grey[i] = radiance[i, row, column, 0] + radiance[i, row, column, 1] + radiance[i, row, column, 2]
                scratch[i] = grey[i]
            upper = nth_smallest(scratch, count, count - 1 - count // 5)
            brightness[row, column] = upper / 3.0
            for i in range(count):
                if upper < 3.0 * MIN_RADIANCE:
                    levels[i, row, column] = UNKNOWN
                elif saturated[i, row, column]:
                    levels[i, row, column] = SATURATED
                else:
                    levels[i, row, column] = min(max(UPPER * grey[i] / upper, 0.0), 253.0)


@parallel
def _find_edges(levels: np.ndarray, side: np.ndarray, towards: np.ndarray, seen: np.ndarray) -> None:
    """Fill `seen` (R, W) with the share of lamps that light a texel and leave the next but one, away from them, in a
    shadow, of those on one side that light it."""
    count, rows, columns = levels.shape
    for row in prange(rows):
        number, right, up = np.zeros(columns), np.zeros(columns), np.zeros(columns)
        for i in range(count):
            across, down = towards[i, 0], towards[i, 1]
            if not (0 <= row + down < rows and 0 <= row - down < rows):
                continue
            for column in range(abs(across), columns - abs(across)):
                near = levels[i, row + down, column + across]
                far = levels[i, row - down, column - across]
                if LIT <= near < UNKNOWN and far < DARK_SHARE * near:
                    number[column] += 1.0
                    right[column] += side[i, 0]
                    up[column] += side[i, 1]
        for column in range(columns):
            length = math.sqrt(right[column] ** 2 + up[column] ** 2)
            if number[column] < MIN_LAMPS or length < 0.5 * number[column]:
                continue
            agree, tell = 0, 0
            for i in range(count):
                if side[i, 0] * right[column] + side[i, 1] * up[column] < 0.5 * length:
                    continue
                across, down = towards[i, 0], towards[i, 1]
                if not (0 <= row + down < rows and 0 <= row - down < rows):
                    continue
                if not (0 <= column + across < columns and 0 <= column - across < columns):
                    continue
                near = levels[i, row + down, column + across]
                far = levels[i, row - down, column - across]
                if LIT <= near < UNKNOWN and far < UNKNOWN:
                    tell += 1
                    agree += far < DARK_SHARE * near
            if agree >= MIN_LAMPS:
                seen[row, column] = agree / tell


def add_torn(edges: NDArray[np.bool_], off: Array, excess: Array) -> NDArray[np.bool_]:
    """Edges (H, W) with lines along which the height is torn from its slopes.

    `off` (H, W) is the largest difference between a step of the height to a neighbour and the slope, in widths of a
    texel, and `excess` (H, W) the factor by which squared differences exceed what errors of slopes explain. Slopes of
    a low step that casts hardly a shadow belong to no surface, because the step changes along its line.
    """
    torn = (off > TORN) & (excess > TORN_EXCESS)
    parts, _ = ndimage.label(torn | edges, np.ones((3, 3)))
    sizes = np.bincount(parts.ravel())
    return np.asarray(edges | (torn & (sizes[parts] >= MIN_LINE)))


def doubt_open_outlines(
    contradicted: NDArray[np.bool_], division: Division | None, height: Array, outside: NDArray[np.bool_]
) -> Array:
    """(H, W) deviation of `height` (H, W) by edges that end within a region.

    Around the end of an edge a region goes on from one of its sides to the other, and slopes are summed up along that
    way, although the outline was missed there. Where edges that the height contradicts (H, W), which are no border of
    regions, are long beside the size of their region, its heights are known no better than their range. Texels
    `outside` (H, W) do not count.
    """
    region = np.zeros(height.shape, np.int32) if division is None else division.region
    border = outside.copy()
    border[:, 1:] |= region[:, 1:] != region[:, :-1]
    border[1:] |= region[1:] != region[:-1]
    inner = contradicted & ~ndimage.binary_dilation(border, iterations=math.ceil(2.0 * GAP) + 1)
    lines, _ = ndimage.label(inner, np.ones((3, 3)))
    inner &= (np.bincount(lines.ravel()) >= MIN_LINE)[lines]
    count = int(region.max()) + 1
    length = np.bincount(region[inner], minlength=count)
    area = np.bincount(region[~outside], minlength=count)
    found = np.zeros(height.shape)
    for each in np.flatnonzero(length > OPEN_SHARE * np.sqrt(area)):
        here = (region == each) & ~outside
        low, high = np.quantile(height[here], (0.05, 0.95))
        found[here] = high - low
    return found


def divide(edges: NDArray[np.bool_]) -> Division | None:
    """The regions into which edges (H, W) divide the image; None without edges.

    Texels next to an edge are counted to it, since a lens mixes both sides in them, and so are gaps in outlines and
    parts of less than `MIN_REGION` texels.
    """
    if not edges.any():
        return None
    region = _find_regions(edges)
    wide = ndimage.binary_dilation(edges)
    wide[:, 1:] |= region[:, 1:] != region[:, :-1]
    wide[1:] |= region[1:] != region[:-1]
    parts, _ = ndimage.label(~wide)
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    wide |= (sizes < MIN_REGION)[parts]
    if wide.all():
        return Division(wide, np.zeros(edges.shape, np.int32))
    rank = np.zeros(len(sizes), np.int32)
    rank[np.argsort(-sizes, kind="stable")] = np.arange(len(sizes))
    nearest = ndimage.distance_transform_edt(wide, return_distances=False, return_indices=True)
    return Division(wide, np.asarray(rank[parts[tuple(nearest)]], np.int32))


def _find_regions(edges: NDArray[np.bool_]) -> Labels:
    """(H, W) regions that edges (H, W) divide the image into."""
    distance = cv2.distanceTransform((~edges).astype(np.uint8), cv2.DIST_L2, 3)
    seeds, number = ndimage.label(distance > GAP)
    parts, _ = ndimage.label(~edges)
    # parts that are too narrow for a seed are seeds
    has_seed = np.zeros(int(parts.max()) + 1, np.bool_)
    has_seed[parts[seeds > 0]] = True
    seeds = np.where((parts > 0) & ~has_seed[parts], parts + number, seeds)
    sizes = np.bincount(seeds.ravel())
    # regions grow from their seeds, edges last, so that borders lie in edges and in gaps between them
    kept = (sizes >= MIN_REGION / 4.0) & (np.arange(len(sizes)) > 0)
    if kept.sum() < 2:
        return np.zeros(edges.shape, np.int32)
    order = np.cumsum(kept) * kept
    markers = order[seeds].astype(np.int32)
    depth = (255.0 - 32.0 * np.minimum(distance, 7.0)).astype(np.uint8)
    regions = _grow(markers, depth)
    return _join(regions, ndimage.binary_dilation(edges))


def _grow(markers: Labels, depth: NDArray[np.uint8]) -> Labels:
    """(H, W) labels from 0 of markers from 1 that grow over all texels of 0, those of small `depth` first."""
    grown = cv2.watershed(np.repeat(depth[..., None], 3, axis=2), markers.copy())
    # the watershed leaves lines of −1, also around the image
    missing = grown < 1
    nearest = ndimage.distance_transform_edt(missing, return_distances=False, return_indices=True)
    filled = np.where(markers > 0, markers, grown[tuple(nearest)])
    return np.asarray(filled - 1, np.int32)


def _join(regions: Labels, edges: NDArray[np.bool_]) -> Labels:
    """Regions with those made one whose border is seen along less than `SEEN_SHARE` of it."""
    count = int(regions.max()) + 1
    pairs, seen = [], []
    for one, other in ((np.s_[:, 1:], np.s_[:, :-1]), (np.s_[1:], np.s_[:-1])):
        border = regions[one] != regions[other]
        both = np.stack([regions[one][border], regions[other][border]])
        pairs.append(np.sort(both, axis=0))
        seen.append((edges[one] | edges[other])[border])
    first, second = np.concatenate(pairs, axis=1)
    shape = (count, count)
    total = coo_matrix((np.ones(len(first)), (first, second)), shape).tocsr()
    along = coo_matrix((np.concatenate(seen).astype(float), (first, second)), shape).tocsr()
    unseen = (total - along / SEEN_SHARE).tocsr()
    unseen.data[unseen.data <= 0.0] = 0.0
    unseen.eliminate_zeros()
    _, label = connected_components(unseen, directed=False)
    return np.asarray(label[regions], np.int32)

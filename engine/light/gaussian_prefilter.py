"""Environment cube maps under spherical Gaussians of rising width, for looking up (direction, sigma) at once.

Green2006 Sec. 5: G(w; mu, sigma) = exp((w·mu − 1) / sigma²), sigma in rad, here divided
by its integral 2 π sigma² (1 − exp(−2 / sigma²)), so that a constant stays as it is.

A level is a grid of nodes on each face whose outermost nodes lie ON the edges, (6, M + 1, M + 1, 3): both faces at an
edge hold the same values there, so that bilinear look-ups within a face are seamless and need no border. In GLSL, as
a 2D array texture with linear filtering: texture(level, vec3((st * M + 0.5) / (M + 1), face)), st in [0, 1]. M is
chosen so that cells are at most a quarter of sigma wide (bilinear look-ups are then right to 2 % of the highest value),
but never more than the texels of the map.

Narrow Gaussians are summed over the texels themselves. Wider ones are summed over fewer, at nodes about as far apart
as they are wide, and refined by a cubic B-spline; what both widen is taken off the Gaussian beforehand, in either
direction of a texel. From 4 / N rad on nodes are right to 2 % of the height for a single bright texel anywhere, and
what is bright stays where it is to half a texel or 2 % of sigma. Half a texel wide they are off by 5 %, because texels
so far apart cannot show such a Gaussian, and look-ups between nodes a texel apart by what bilinear interpolation is.
What that takes for 6 × 512²: `python -m benchmarks --only prefilter`; most of it goes to the levels below 9 / N rad.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.cached import cached_property
from engine.light.cube_map import (
    FACES,
    CubeMap,
    cube_directions,
    cube_solid_angles,
    direction_on_face,
    face_coordinates,
    mean_radiance,
    resize,
    texels_beside,
)
from engine.light.gaussian_prefilter_kernel import convolve, energy, halve, look_up, refine

#: Fewest texels along an edge that sums are taken over, and ratio of one width to the next that keeps look-ups between
#: two levels right to 2 %.
_FEWEST, RATIO = 16, math.sqrt(2.0)

#: A Gaussian of this over N may be summed over N / 2 texels along an edge: then it is √2 times as wide as a texel in
#: the middle of a face. Where the sphere is curved within texels it must be wider to be right to 2 % of its height.
_WIDEST_SUMMED, _WIDE = 5.5, {64: 6.3, 32: 14.0}

#: Wider than this over N, summed over many texels along an edge, it needs a node for every two of them only.
_DENSE = 4.15

#: Edge beyond which a map is large.
_LARGE = 256

#: Width of the widest Gaussian; beyond it only the mean and the first moment count.
WIDEST = 2.0

#: Directions from which on look-ups take all threads.
_MANY = 512


@dataclass(frozen=True, eq=False)
class PrefilteredCube:
    """Mean radiance under Gaussians, by direction and width.

    `levels` are (6, M + 1, M + 1, 3) float32, one for each of the rising `sigma` (S,) in rad; `mean` (3,) is the mean
    over the sphere, which widths beyond the last go towards.
    """

    levels: tuple[NDArray[np.float32], ...]
    sigma: NDArray[np.float64]
    mean: NDArray[np.float64]
    texels: NDArray[np.float32]

    def lookup(self, direction: ArrayLike, sigma: ArrayLike) -> NDArray[np.float64]:
        """(..., 3) radiance for unit vectors (..., 3) and widths (...) in rad ≥ 0.

        Widths below the first take the first; between two levels the mixture is the one whose height is that of the
        Gaussian asked for, which is linear in 1 / sigma².
        """
        direction = np.asarray(direction, np.float64)
        widths = np.broadcast_to(np.asarray(sigma, np.float64), direction.shape[:-1])
        level, share, mean_share = self._between(widths.ravel())
        cells = np.array([level.shape[1] - 1 for level in self.levels])
        starts = np.concatenate([[0], np.cumsum(6 * (cells + 1) ** 2)])[:-1]
        towards = np.ascontiguousarray(direction.reshape(-1, 3))
        values = np.empty((len(towards), 3))
        look_up[len(towards) >= _MANY](
            self.texels, starts, cells, level, share, self.mean, mean_share, FACES, towards, values
        )
        found: NDArray[np.float64] = values.reshape(direction.shape)
        return found

    def _between(
        self, sigma: NDArray[np.float64]
    ) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
        """Lower level, share of the next, and share of the mean."""
        if not (sigma >= 0.0).all():
            raise ValueError("the width of a Gaussian must not be negative")
        first, last = self.sigma[0], self.sigma[-1]
        inside = np.clip(sigma, first, last)
        level = np.clip(np.searchsorted(self.sigma, inside, side="right") - 1, 0, max(len(self.sigma) - 2, 0))
        low, high = self.sigma[level], self.sigma[np.minimum(level + 1, len(self.sigma) - 1)]
        share = np.where(high > low, (1 - (low / inside) ** 2) / np.where(high > low, 1 - (low / high) ** 2, 1), 0.0)
        rest: NDArray[np.float64] = 1.0 - (last / np.maximum(sigma, last)) ** 2
        return level, np.clip(share, 0.0, 1.0), rest


def gaussian_integral(sigma: ArrayLike) -> NDArray[np.float64]:
    """∫ exp((w·mu − 1) / sigma²) dw = 2 π sigma² (1 − exp(−2 / sigma²)) over the sphere, for any width > 0."""
    square = np.asarray(sigma, np.float64) ** 2
    result: NDArray[np.float64] = -2.0 * np.pi * square * np.expm1(-2.0 / square)
    return result


def texel_width(n: int) -> float:
    """Mean width in rad of a texel along the middle of a face, (π / 2) / N."""
    return 0.5 * math.pi / n


def geometric_sigmas(n: int, ratio: float = RATIO) -> NDArray[np.float64]:
    """Widths in rad for a cube map of edge `n`: from 2 / N on, each is `ratio` times the one before.

    Below that look-ups are off by the width of a texel anyway: half a texel and one more must do. Of large maps, whose
    narrow sums are the dearest, these are half a texel and 2 / N, and the rise starts at 4.2 / N.
    """
    narrowest = 0.5 * texel_width(n)
    narrow, first = (
        ([narrowest, 2.0 / n], 4.2 / n) if n > _LARGE else ([narrowest, math.sqrt(narrowest * 2 / n)], 2 / n)
    )
    steps = np.arange(max(math.ceil(math.log(WIDEST / first) / math.log(ratio)), 0) + 1, dtype=np.float64)
    return np.concatenate([narrow, first * ratio**steps])


def prefilter(cube: CubeMap, sigmas: Sequence[float] | NDArray[np.float64] | None = None) -> PrefilteredCube:
    """The levels of `cube` for rising widths in rad, at least half a texel each; `geometric_sigmas` by default.

    The edge is brought to a power of two first. Raises ValueError for widths that are not rising or too narrow.
    """
    widths = geometric_sigmas(cube.edge) if sigmas is None else np.asarray(sigmas, np.float64)
    if widths.ndim != 1 or not len(widths) or not (np.diff(widths) > 0).all() or not np.isfinite(widths).all():
        raise ValueError("the widths of Gaussians must be finite and rise")
    if widths[0] < 0.5 * texel_width(cube.edge) * (1 - 1e-9):
        raise ValueError(f"a Gaussian of width {widths[0]:.3g} is narrower than half a texel")
    edge = max(_FEWEST, 1 << (cube.edge - 1).bit_length())
    grids = [_grid(sigma, edge) for sigma in widths]
    starts = np.concatenate([[0], np.cumsum([6 * (grid.cells + 1) ** 2 for grid in grids])])
    texels = np.empty((starts[-1], 3), np.float32)
    levels = tuple(
        texels[start:stop].reshape(6, grid.cells + 1, grid.cells + 1, 3)
        for start, stop, grid in zip(starts[:-1], starts[1:], grids, strict=True)
    )
    mean = mean_radiance(cube)
    halves = _halve(resize(cube, edge))
    source = next(halves)
    for sigma, grid, level in zip(widths, grids, levels, strict=True):
        while source.edge > grid.summed:
            source = next(halves)
        _fill(source, sigma, grid, level)
        _keep_energy(level, mean)
    texels.flags.writeable = False
    return PrefilteredCube(levels, widths, mean, texels)


class _Grid(NamedTuple):
    """Texels along an edge that a level is summed over, nodes for every two of them, and cells of the level."""

    summed: int
    dense: int
    cells: int


def _grid(sigma: float, edge: int) -> _Grid:
    """For a width and an edge that is a power of two."""
    summed = edge
    while summed > _FEWEST and sigma * summed >= _WIDE.get(summed, _WIDEST_SUMMED):
        summed //= 2
    dense = 1 if summed > 64 and sigma * summed > _DENSE else 2
    along = dense * summed // 2
    factor = math.ceil(8.0 / (sigma * along) - 1e-6)
    return _Grid(summed, dense, edge if summed == edge and dense == 2 else min(factor * along, edge))


@dataclass(frozen=True, eq=False)
class _Source:
    """Flux and solid angle (4, 6, N, N) of texels; `widened` is the variance in each direction that they stand for."""

    flux: NDArray[np.float32]
    widened: float

    @cached_property
    def split(self) -> NDArray[np.float32]:
        """(4, 6, N, 2, N / 2), the even columns before the odd ones."""
        n = self.edge
        return np.ascontiguousarray(self.flux.reshape(4, 6, n, n // 2, 2).swapaxes(3, 4))

    @cached_property
    def texels(self) -> NDArray[np.float32]:
        """Flat copy, the four side by side."""
        return np.ascontiguousarray(np.moveaxis(self.flux, 0, 3)).ravel()

    @property
    def edge(self) -> int:
        return self.flux.shape[2]


def _halve(cube: CubeMap) -> Iterator[_Source]:
    """The texels of a cube map, and ever half as many along an edge."""
    n = cube.edge
    area = cube_solid_angles(n).astype(np.float32)
    flux = np.empty((4, 6, n, n), np.float32)
    np.multiply(np.moveaxis(cube.radiance, 3, 0), area, out=flux[:3])
    flux[3] = area
    source = _Source(flux, 0.0)
    while True:
        yield source
        n //= 2
        coarse = np.empty((4, 6, n, n), np.float32)
        halve(_pad(source.flux), coarse)
        source = _Source(coarse, 5 / 16 + source.widened / 4)


def _pad(flux: NDArray[np.float32]) -> NDArray[np.float32]:
    """With two texels of the adjoining faces beyond each edge, for `halve`; nothing beyond the corners.

    What a face spreads over its edge lies half a coarse texel behind it in its own plane. There the next face is
    slanted: its texels are met up to a texel nearer to the middle of the edge, and linearly moved by that.
    """
    n = flux.shape[2]
    padded = np.zeros((4, 6, n + 4, n + 4), np.float32)
    inner = padded[..., 2:-2, 2:-2]
    inner[:] = flux
    nearer = (np.abs(2 * np.arange(n) + 1 - n) / (n + 2)).astype(np.float32)
    spread = _spread_at_corner(nearer[:2])
    for rows in (slice(2), slice(-1, -3, -1)):
        for columns in (slice(2), slice(-1, -3, -1)):
            inner[..., rows, columns] /= spread
    flat = inner.reshape(4, -1)
    for depth in range(2):
        before, behind, beside = 1 - depth, n + 2 + depth, texels_beside(n, depth)
        edges = padded[:, :, before], padded[:, :, behind], padded[..., before], padded[..., behind]
        for side, edge in enumerate(edges):
            strip = flat[:, beside[:, side]]
            moved = nearer * strip
            edge[..., 2:-2] = strip - moved
            edge[..., 3 : n // 2 + 3] += moved[..., : n // 2]
            edge[..., n // 2 + 1 : -3] += moved[..., n // 2 :]
    return padded


def _spread_at_corner(nearer: NDArray[np.float32]) -> NDArray[np.float32]:
    """(2, 2) how often `halve` takes the texels at a corner of the cube, where it is not once.

    A face keeps what leaves over neither edge; the next one gets what leaves over theirs, but for what leaves it again.
    """
    out = np.array([5 / 16, 1 / 16, 0.0], np.float32)
    again = (1 - nearer) * out[:2] + nearer * out[1:]
    out = out[:2]
    return (1 - out[:, None]) * (1 - out) + out[:, None] * (1 - again) + out * (1 - again[:, None])


@lru_cache(maxsize=8)
def _towards(n: int) -> NDArray[np.float32]:
    """(3, 6, N, N) directions of texels, planar."""
    return np.ascontiguousarray(np.moveaxis(cube_directions(n), 3, 0), np.float32)


@lru_cache(maxsize=16)
def _inverse(n: int) -> NDArray[np.float32]:
    """(N, 2, N / 2) 1 / (1 + x² + y²) of texels, for places (x, y) on a face's plane, even columns before odd ones."""
    square = ((2.0 * np.arange(n) + 1.0) / n - 1.0) ** 2
    inverse = 1.0 / (1.0 + square[:, None] + square)
    return np.ascontiguousarray(inverse.reshape(n, n // 2, 2).swapaxes(1, 2), np.float32)


@lru_cache(maxsize=16)
def _turn(n: int) -> NDArray[np.int64]:
    """(6, 6, 3) flat place of the first texel, and steps to the next row and column, of each face of a rotated cube.

    The first index is the face that is rotated to where +Z is (there s runs along +x and t along −y).
    """
    t, s = np.array([[0.5, 1.5, 0.5], [0.5, 0.5, 1.5]]) / n
    seen = direction_on_face(np.arange(6)[:, None], np.broadcast_to(s, (6, 3)), np.broadcast_to(t, (6, 3)))
    face, s, t = face_coordinates(np.einsum("gki,fij->fgkj", seen * (1, -1, 1), FACES))
    place = (face * n + (t * n).astype(np.int64)) * n + (s * n).astype(np.int64)
    return np.stack([place[..., 0], place[..., 1] - place[..., 0], place[..., 2] - place[..., 0]], axis=-1)


def _fill(source: _Source, sigma: float, grid: _Grid, level: NDArray[np.float32]) -> None:
    """Compute one level of width `sigma` from texels."""
    n = source.edge
    sources = source.split, source.texels, _inverse(n), _towards(n), FACES, _turn(n)
    along = grid.dense * n // 2
    if grid.cells == along:
        convolve(*sources, sigma, source.widened, grid.dense, 0, level)
    else:
        nodes = np.empty((6, along + 3, along + 3, 3), np.float32)
        convolve(*sources, sigma, source.widened + 4 / (3 * grid.dense**2), grid.dense, 1, nodes)
        refine(nodes, grid.cells // along, level)
    _join(level)


def _keep_energy(level: NDArray[np.float32], mean: NDArray[np.float64]) -> None:
    """Scale a level to the mean of the map: light from a single texel at a corner of the cube is off by a percent."""
    obtained = energy(level, _node_weights(level.shape[1] - 1)).sum(axis=(0, 1)) / (4.0 * np.pi)
    scale = np.where(obtained > 0.0, mean, 1.0) / np.where(obtained > 0.0, obtained, 1.0)
    if np.abs(scale - 1.0).max() > 1e-6:
        level *= scale.astype(np.float32)


@lru_cache(maxsize=16)
def _node_weights(cells: int, parts: int = 4) -> NDArray[np.float64]:
    """(M + 1, M + 1) solid angle in sr that each node of a face counts for when cells are bilinear."""
    weights = cube_solid_angles(parts * cells)
    for _ in range(2):
        spread = np.zeros((cells + 1, weights.shape[1]))
        for part in range(parts):
            share = (part + 0.5) / parts
            spread[:-1] += (1.0 - share) * weights[part::parts]
            spread[1:] += share * weights[part::parts]
        weights = np.ascontiguousarray(spread.T)
    return weights


def _join(level: NDArray[np.float32]) -> None:
    """Give the two or three nodes at the same place of an edge or corner their mean."""
    flat = level.reshape(-1, 3)
    index, place, count = _share(level.shape[1] - 1)
    sums = np.stack([np.bincount(place, flat[index, c].astype(np.float64)) for c in range(3)], axis=-1)
    flat[index] = (sums / count[:, None])[place]


@lru_cache(maxsize=16)
def _share(cells: int) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Flat numbers of the nodes on edges, the number of the place where each lies, and nodes at each place."""
    at = np.arange(cells + 1)
    on_edge = (at[:, None] % cells == 0) | (at % cells == 0)
    i, j = np.nonzero(on_edge)
    across, down = 2 * j - cells, 2 * i - cells
    axes = FACES.astype(np.int64)
    point = across[:, None] * axes[:, None, 0] + down[:, None] * axes[:, None, 1] + cells * axes[:, None, 2]
    _, place, count = np.unique(point.reshape(-1, 3), axis=0, return_inverse=True, return_counts=True)
    index = (np.arange(6)[:, None] * (cells + 1) ** 2 + i * (cells + 1) + j).ravel()
    return index, place.ravel(), count

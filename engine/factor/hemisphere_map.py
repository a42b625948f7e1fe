"""Hemisphere maps: the three maps from directions to the square textures that factors are stored in.

    orthographic   (x, y), the unit disk; Wang2004 Eq. 7
    parabolic      (x, y)/(1 + z), the unit disk; even towards the horizon where orthographic texels grow long: the
                   last of 48 spans 16.6° of elevation there, and 2.4° here
    polar          (azimuth, √(1 − z)), a rectangle that closes on itself in azimuth; Wang2004 Eq. 8. √(1 − z) is
                   written √2 sin(θ/2) = |(x, y)|/√(1 + z), which does not cancel near the normal

Texel (row, column) of a disk has its centre at ((2 column + 1)/N − 1, (2 row + 1)/N − 1) and is used where that lies
in the disk. Between centres the look-up is bilinear; near the rim the texels outside have no weight and the others
share it, so nothing from outside is mixed in. A polar texture has one row more: row 0 stands at the normal, where the
azimuth means nothing, and holds the mean of row 1; row r has its centres at √(1 − z) = (r − ½)/N, column c at azimuth
2π (c + ½)/N.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.cached import cached_property
from engine.core.directions import Vectors
from engine.core.kernels import parallel, prange, scalar

Floats = NDArray[np.float64]

MapKind = Literal["orthographic", "polar", "parabolic"]

#: The kinds by the number that kernels and shaders know them by.
KINDS: tuple[MapKind, ...] = get_args(MapKind)

#: Largest side of a factor's texture: the matrix of a map of N texels a side has N⁴ entries.
LARGEST_SIZE = 1024

#: Parabolic coordinates end at z = −1; nearer than this to it they are refused.
OPPOSITE_NORMAL = 1e-12


@dataclass(frozen=True)
class HemisphereMap:
    """A map of the upper hemisphere onto a texture of `size` texels a side; ValueError for any other kind or size."""

    kind: MapKind
    size: int

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ValueError(f"unknown map {self.kind!r}; choose from {', '.join(KINDS)}")
        if not 1 <= self.size <= LARGEST_SIZE:
            raise ValueError(f"a map has 1 to {LARGEST_SIZE} texels a side, not {self.size}")

    @property
    def number(self) -> int:
        """The kind as a number for kernels and shaders."""
        return KINDS.index(self.kind)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of a texture."""
        return (self.size + 1, self.size) if self.kind == "polar" else (self.size, self.size)

    @cached_property
    def mask(self) -> NDArray[np.bool_]:
        """(size, size): the texels that hold a direction, all of a polar map."""
        if self.kind == "polar":
            return np.ones((self.size, self.size), bool)
        odd = 2 * np.arange(self.size) + 1 - self.size
        return np.asarray(odd[:, None] ** 2 + odd**2 <= self.size**2)

    @cached_property
    def directions(self) -> Vectors:
        """(n, 3) unit directions of the n texels of `mask`, row by row; all are above the horizon."""
        rows, columns = np.nonzero(self.mask)
        if self.kind == "polar":
            y, phi = (rows + 0.5) / self.size, 2.0 * np.pi * (columns + 0.5) / self.size
            sine = y * np.sqrt(2.0 - y * y)
            return np.stack([sine * np.cos(phi), sine * np.sin(phi), 1.0 - y * y], axis=-1)
        x, y = (2 * columns + 1) / self.size - 1.0, (2 * rows + 1) / self.size - 1.0
        squared = x * x + y * y
        if self.kind == "orthographic":
            return np.stack([x, y, np.sqrt(np.maximum(1.0 - squared, 0.0))], axis=-1)
        return np.stack([2.0 * x, 2.0 * y, 1.0 - squared], axis=-1) / (1.0 + squared)[:, None]

    @cached_property
    def solid_angles(self) -> Floats:
        """(n,) sr that the texels of `mask` stand for: texel area times dω/dA at its centre."""
        z = self.directions[:, 2]
        if self.kind == "polar":
            return 4.0 * np.pi / self.size**2 * np.sqrt(1.0 - z)
        per_area = 1.0 / z if self.kind == "orthographic" else (1.0 + z) ** 2
        return 4.0 / self.size**2 * per_area

    def coordinates(self, direction: ArrayLike) -> Floats:
        """Texture coordinates (..., 2) in [0, 1] of unit directions (..., 3) at or above the horizon.

        ValueError for parabolic coordinates at z = −1, which are infinite.
        """
        x, y, z = np.moveaxis(np.asarray(direction, np.float64), -1, 0)
        if self.kind == "polar":
            on_axis = (x == 0.0) & (y == 0.0)
            phi = np.where(on_axis, 0.0, np.arctan2(y, np.where(on_axis, 1.0, x)))
            theta = np.arctan2(np.hypot(x, y), z)
            return np.stack([phi / (2.0 * np.pi) % 1.0, math.sqrt(2.0) * np.sin(0.5 * theta)], axis=-1)
        if self.kind == "parabolic":
            if np.any(1.0 + z <= OPPOSITE_NORMAL):
                raise ValueError("parabolic coordinates do not reach the direction opposite to the normal")
            x, y = x / (1.0 + z), y / (1.0 + z)
        return np.stack([0.5 * (x + 1.0), 0.5 * (y + 1.0)], axis=-1)

    @property
    def flips(self) -> tuple[NDArray[np.intp], NDArray[np.intp]] | None:
        """Index of each of the n texels after x, and after y, changes its sign; None if some texels are on an axis."""
        if self.size % (4 if self.kind == "polar" else 2):
            return None
        number = np.full(self.mask.shape, -1)
        number[self.mask] = np.arange(len(self.directions))
        if self.kind == "polar":
            half = self.size // 2
            return np.roll(number[:, ::-1], -half, axis=1)[self.mask], number[:, ::-1][self.mask]
        return number[:, ::-1][self.mask], number[::-1][self.mask]

    def image(self, values: ArrayLike) -> Floats:
        """A texture (rows, columns, ...) of values (n, ...) at the texels of `mask`; 0 outside, means at the pole."""
        values = np.asarray(values, np.float64)
        texture = np.zeros((self.size, self.size, *values.shape[1:]))
        texture[self.mask] = values
        return np.concatenate([_pole(texture), texture]) if self.kind == "polar" else texture

    def look_up(self, texture: ArrayLike, direction: ArrayLike) -> Floats:
        """Values (..., C) of a texture (rows, columns, C) in unit directions (..., 3) above the horizon."""
        texture, direction = np.asarray(texture, np.float64), np.asarray(direction, np.float64)
        if texture.ndim != 3 or texture.shape[:2] != self.shape:
            raise ValueError(f"a texture of this map has {self.shape} texels, not {texture.shape}")
        values = np.empty((direction.size // 3, texture.shape[2]))
        flat = np.ascontiguousarray(direction.reshape(-1, 3))
        _look_up(self.number, self.size, texture.reshape(-1, texture.shape[2]), flat, values)
        return values.reshape(*direction.shape[:-1], texture.shape[2])


def _pole(texture: Floats) -> Floats:
    return np.broadcast_to(texture[:1].mean(axis=1, keepdims=True), texture[:1].shape)


@scalar
def _inside(row: int, column: int, size: int) -> bool:
    x, y = 2 * column + 1 - size, 2 * row + 1 - size
    return x * x + y * y <= size * size


@scalar
def taps(
    kind: int, size: int, x: float, y: float, z: float, place: NDArray[np.integer], weight: NDArray[np.floating]
) -> None:
    """The four texels of a texture, as row · columns + column, between which a direction lies, and their weights."""
    if kind == 1:
        radius = math.sqrt(x * x + y * y)
        turn = math.atan2(y, x) / (2.0 * math.pi) if radius > 0.0 else 0.0
        column = (turn - math.floor(turn)) * size - 0.5
        left = math.floor(column)
        across = column - left
        row = radius / math.sqrt(1.0 + z) * size
        low, along = 0, 2.0 * row
        if row >= 0.5:
            low = min(int(row + 0.5), size)
            along = row + 0.5 - low if low < size else 0.0
        first, second = int(left) % size, (int(left) + 1) % size
        for k in range(4):
            above, right = k // 2, k % 2
            place[k] = min(low + above, size) * size + (second if right else first)
            weight[k] = (along if above else 1.0 - along) * (across if right else 1.0 - across)
        return
    if kind == 2:
        x, y = x / (1.0 + z), y / (1.0 + z)
    column = min(max(0.5 * (x + 1.0) * size - 0.5, 0.0), size - 1.0)
    row = min(max(0.5 * (y + 1.0) * size - 0.5, 0.0), size - 1.0)
    left, low = min(int(column), max(size - 2, 0)), min(int(row), max(size - 2, 0))
    across, along = column - left, row - low
    total = 0.0
    for k in range(4):
        above, right = k // 2, k % 2
        r, c = min(low + above, size - 1), min(left + right, size - 1)
        place[k] = r * size + c
        share = (along if above else 1.0 - along) * (across if right else 1.0 - across)
        weight[k] = share if _inside(r, c, size) else 0.0
        total += weight[k]
    if total <= 0.0:
        # beyond the disk, where only a direction below the horizon or its rounding leads: the nearest corner to n
        inner = (2 if 2 * low + 1 < size else 0) + (1 if 2 * left + 1 < size else 0)
        weight[inner] = total = 1.0
    for k in range(4):
        weight[k] /= total


@parallel
def _look_up(
    kind: int, size: int, texels: NDArray[np.floating], direction: NDArray[np.floating], values: NDArray[np.floating]
) -> None:
    """`values` (P, C) of `texels` (T, C); bound by fetching four rows of texels for each direction."""
    for p in prange(len(direction)):
        place, weight = np.empty(4, np.int64), np.empty(4)
        taps(kind, size, direction[p, 0], direction[p, 1], direction[p, 2], place, weight)
        for c in range(values.shape[1]):
            total = 0.0
            for k in range(4):
                total += weight[k] * texels[place[k], c]
            values[p, c] = total

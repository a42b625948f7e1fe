"""A BRDF as a matrix over the texels of a map: a row for each viewer and a column for each light, a matrix a channel.

Mirrored scenes look alike: where the BRDF keeps its value when x, y or both change sign in both directions, rows of a
mirrored viewer hold the same numbers in mirrored columns. One row of each such set is sampled, and the matrix falls
apart into smaller ones, its sectors, over vectors that are even or odd under each mirror; the singular values of all
sectors together are those of the matrix. Four sectors of a quarter's rows and columns take a fourth of the sampling
and a sixteenth of the arithmetic of each product. The symmetry is not taken on trust: it is looked for at random pairs.

Over half and difference vectors an isotropic BRDF has the same row for all half vectors of one angle from the normal;
that row is sampled once and weighs as often as it stands there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import Brdf
from engine.brdf.half_difference import classical_frame
from engine.core.directions import Vectors, normalize
from engine.core.errors import UsageError
from engine.core.steps import Step, Steps
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.separable_factors import Parametrisation

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

#: Random pairs at which a mirror symmetry is looked for, and the relative difference that is rounding.
PROBES = 4096
PROBE_TOLERANCE = 1e-12

#: Directions of half and difference vectors that lead below the horizon are raised to this cosine.
RAISED = 0.01

#: Entries sampled between two steps; always as many, because the last bits may depend on it.
_ENTRIES_AT_ONCE = 80_000


@dataclass(frozen=True, eq=False)
class Sector:
    """A part of the matrix: M holds `matrix` between vectors that `left` and `right` bring to all texels, (n, K)."""

    matrix: Floats
    left: Callable[[Floats], Floats]
    right: Callable[[Floats], Floats]


@dataclass(frozen=True, eq=False)
class BrdfMatrix:
    """The sampled rows of a BRDF's matrix and what the other rows have to do with them.

    Attributes
    ----------
    rows : (3, r, n) in 1/sr, for the r viewers or half vectors that were sampled.
    images : (g, r) texels that the g members of the mirror group bring the sampled ones to; the first is themselves.
    characters : (g, g), ±1: how vectors of each sector (row) change under each member (column).
    sampled : (n,), which sampled row each texel has, where rows repeat (half-diff), else None.
    """

    hemisphere_map: HemisphereMap
    parametrisation: Parametrisation
    rows: Floats
    images: Indices
    characters: Floats
    sampled: Indices | None = None

    def sectors(self, channel: int, row_weight: Floats, column_weight: Floats) -> list[Sector]:
        """The sectors of diag(row_weight) M diag(column_weight); weights (n,) must be the same in mirrored texels."""
        texels = len(column_weight)
        if self.sampled is not None:
            times = np.sqrt(np.bincount(self.sampled, minlength=self.rows.shape[1]))
            matrix = self.rows[channel] * (row_weight[self.images[0]] * times)[:, None] * column_weight
            sampled = self.sampled
            return [Sector(matrix, lambda vectors: (vectors / times[:, None])[sampled], lambda vectors: vectors)]
        rows = self.rows[channel] * row_weight[self.images[0]][:, None] * column_weight
        scale = 1.0 / np.sqrt(len(self.images))

        def sector(character: Floats) -> Sector:
            matrix = np.zeros((rows.shape[0], rows.shape[0]))
            for sign, image in zip(character, self.images, strict=True):
                matrix += sign * rows[:, image]

            def everywhere(vectors: Floats) -> Floats:
                full = np.empty((texels, vectors.shape[1]))
                for sign, image in zip(character, self.images, strict=True):
                    full[image] = (sign * scale) * vectors
                return full

            return Sector(matrix, everywhere, everywhere)

        return [sector(character) for character in self.characters]

    def whole(self, channel: int, row_weight: Floats, column_weight: Floats) -> Sector:
        """The matrix in one piece, weighted as in `sectors`; of rows that repeat, each once."""
        if self.sampled is not None:
            return self.sectors(channel, row_weight, column_weight)[0]
        texels = len(column_weight)
        matrix, moved = np.empty((texels, texels)), np.empty(texels, np.intp)
        for member, image in enumerate(self.images):
            for other, before in enumerate(self.images):
                moved[before] = self.images[member ^ other]  # mirrors are their own inverse, and the order is of bits
            matrix[image[:, None], moved[None]] = self.rows[channel]
        return Sector(matrix * row_weight[:, None] * column_weight, lambda vectors: vectors, lambda vectors: vectors)


def brdf_matrix(brdf: Brdf, hemisphere_map: HemisphereMap, parametrisation: Parametrisation) -> Steps[BrdfMatrix]:
    """Sample `brdf` at the texels of `hemisphere_map`.

    Half and difference vectors whose light or viewer would lie below the horizon are sampled where these are raised to
    a cosine of `RAISED`: look-ups near the horizon mix in such texels, which 0 would darken. Raises UsageError, naming
    the pair of directions, for a value that is not a finite number.
    """
    directions = hemisphere_map.directions
    texels = len(directions)
    sampled: Indices | None = None
    images, characters = np.arange(texels)[None], np.ones((1, 1))
    if parametrisation == "in-out":
        images, characters = _mirrors(brdf, hemisphere_map)
    elif brdf.isotropic:
        _, first, sampled = np.unique(np.round(directions[:, 2], 12), return_index=True, return_inverse=True)
        images, sampled = first[None], sampled.reshape(-1)
    viewers = directions[images[0]]
    rows = np.empty((3, len(viewers), texels))
    at_once = max(1, _ENTRIES_AT_ONCE // texels)
    for start in range(0, len(viewers), at_once):
        block = slice(start, min(start + at_once, len(viewers)))
        wi, wo = _pairs(viewers[block], directions, parametrisation)
        values = np.asarray(brdf.f(wi, wo), np.float64)
        _check(values, wi, wo)
        rows[:, block] = np.moveaxis(values, -1, 0)
        yield Step(block.stop / len(viewers), "sampling the BRDF")
    return BrdfMatrix(hemisphere_map, parametrisation, rows, images, characters, sampled)


def _pairs(viewers: Vectors, directions: Vectors, parametrisation: Parametrisation) -> tuple[Vectors, Vectors]:
    """(wi, wo), which broadcast to (viewers, directions, 3)."""
    if parametrisation == "in-out":
        return directions[None], viewers[:, None]
    half = viewers[:, None]
    x_axis, y_axis = classical_frame(half)
    aside = directions[:, :1] * x_axis + directions[:, 1:2] * y_axis
    along = directions[:, 2:] * half
    return _raise_error(along + aside), _raise_error(along - aside)


def _raise_error(directions: Vectors) -> Vectors:
    low = directions[..., 2] < RAISED
    flat = normalize(directions * (1.0, 1.0, 0.0), fallback=(1.0, 0.0, 0.0)) * np.sqrt(1.0 - RAISED**2)
    flat[..., 2] = RAISED
    return np.where(low[..., None], flat, directions)


def _check(values: Floats, wi: Vectors, wo: Vectors) -> None:
    if np.isfinite(values).all():
        return
    place = tuple(np.argwhere(~np.isfinite(values))[0][:-1])
    angles = [np.degrees(np.arccos(np.broadcast_to(side, values.shape)[place][2])) for side in (wi, wo)]
    raise UsageError(f"the BRDF is not a finite number for light at {angles[0]:.1f}° and viewer at {angles[1]:.1f}°")


def _mirrors(brdf: Brdf, hemisphere_map: HemisphereMap) -> tuple[Indices, Floats]:
    """Images of one texel of each mirrored set, and the characters, of the mirrors that `brdf` has."""
    texels = np.arange(len(hemisphere_map.directions))
    flips = hemisphere_map.flips
    if flips is None:
        return texels[None], np.ones((1, 1))
    x, y = flips
    known = [sign for sign in ((-1.0, 1.0, 1.0), (1.0, -1.0, 1.0), (-1.0, -1.0, 1.0)) if _is_mirror(brdf, sign)]
    members = {(-1.0, 1.0, 1.0): x, (1.0, -1.0, 1.0): y, (-1.0, -1.0, 1.0): x[y]}
    if len(known) == 3:
        group, characters = [texels, x, y, x[y]], [[1, 1, 1, 1], [1, 1, -1, -1], [1, -1, 1, -1], [1, -1, -1, 1]]
    elif known:
        group, characters = [texels, members[known[0]]], [[1, 1], [1, -1]]
    else:
        group, characters = [texels], [[1]]
    images = np.stack(group)
    return images[:, images.min(axis=0) == texels], np.array(characters, np.float64)


def _is_mirror(brdf: Brdf, sign: tuple[float, float, float]) -> bool:
    """True if `brdf` keeps its value, but for rounding, when both directions are multiplied by `sign`."""
    wi, wo = normalize(np.random.default_rng(0).normal(size=(2, PROBES, 3)))
    wi[:, 2], wo[:, 2] = np.abs(wi[:, 2]), np.abs(wo[:, 2])
    value, mirrored = brdf.f(wi, wo), brdf.f(wi * sign, wo * sign)
    return bool((np.abs(value - mirrored) <= PROBE_TOLERANCE * np.abs(value)).all())

"""Projections of a pair of directions, four numbers, to the two coordinates of a texture (Cole2002 Ch. 2 and 3.2).

A pair is a point of four dimensions: the parabolic coordinates (x, y)/(1 + z) of both directions ("in-out"), or those
of the half and the difference vector ("half-diff", Cole2002 Eq. 1.4), two unit disks either way. A linear
projection is two orthonormal rows; dividing by `scale` puts the image of the two disks just inside [−1, 1]², or that of
the 4-cube around them, as the thesis has it, which is up to √2 larger. Others are fixed, for either parametrisation:

    wi, wo      the parabolic coordinates of one direction, and
    half        those of the half vector (McCool2001)
    wi-dot-h    the angles of the half and the difference vector, as parabolic radii: tan(θ_h/2) and tan(θ_d/2), where
                cos θ_d = wi·h
    elevations  those of the two directions: tan(θ_i/2) and tan(θ_o/2)

    half-mean, wi-dot-h-mean    θ_h or θ_d with θ_m, again as radii, where cos² θ_m = cos θ_i cos θ_o

The last four, and the same angles on other scales, suit isotropic surfaces: facets reflect a function of wi-dot-h times
one of elevations, and θ_h, θ_d and θ_m do not change with exchange. A name with -cosines, -sines or -squares has cos θ,
sin θ or the square of the radius in place of the radius, and so its texels elsewhere: close where those of the others
are wide. -turned is the radii turned by 45°. Two textures of the same angles on two scales describe a narrow highlight
better than one.

Exchanging wi and wo exchanges the disks, or turns the second by half: that gives the conjugate of a linear projection;
wi and wo are each other's, as are elevations and their exchange; the others are their own. Sums are written so that a
projection of (wi, wo) and its conjugate of (wo, wi) agree bit for bit: reciprocity is exact, not nearly so.

Mask. The image of the 4-cube is the set Σ c_k g_k with |c_k| ≤ 1 and g_k the columns of the matrix. A point is inside
if, for the normal of each column, it is no farther out than Σ |n·g_k|: four comparisons instead of a convex hull of
sixteen corners, of which many coincide or lie on a line. With a texel's cell for two further columns these are exactly
the texels that some bilinear look-up can touch.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.half_difference import cole_frame, half_vector
from engine.core.directions import dot
from engine.core.kernels import scalar
from engine.factor.solvers.quaternions import Pair, matrix

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

Parametrisation = Literal["in-out", "half-diff"]
Extent = Literal["disks", "cube"]
Kind = Literal[
    "wi",
    "wo",
    "half",
    "wi-dot-h",
    "elevations",
    "elevations-exchanged",
    "half-mean",
    "wi-dot-h-mean",
    "wi-dot-h-cosines",
    "wi-dot-h-sines",
    "wi-dot-h-squares",
    "wi-dot-h-turned",
    "half-mean-cosines",
    "half-mean-sines",
    "half-mean-squares",
    "half-mean-turned",
    "wi-dot-h-mean-cosines",
    "wi-dot-h-mean-sines",
    "wi-dot-h-mean-squares",
    "wi-dot-h-mean-turned",
]
Measure = Literal["radii", "cosines", "sines", "squares", "turned"]

KINDS: tuple[Kind, ...] = get_args(Kind)
_MEASURES: tuple[Measure, ...] = get_args(Measure)
_ANGLES = {"wi-dot-h": [0, 1], "half-mean": [0, 2], "wi-dot-h-mean": [1, 2]}
_EXCHANGED: dict[Kind, Kind] = {
    "wi": "wo",
    "wo": "wi",
    "elevations": "elevations-exchanged",
    "elevations-exchanged": "elevations",
}

PARAMETRISATIONS: tuple[Parametrisation, ...] = ("in-out", "half-diff")

_ORTHONORMAL = 1e-9


class Points(NamedTuple):
    """Pairs of directions: `flat` (N, 4) for linear projections; wi, wo, half (N, 2); angles (N, 3) in [0, 1].

    The angles are θ_h, θ_d and θ_m as parabolic radii.
    """

    flat: Floats
    wi: Floats
    wo: Floats
    half: Floats
    angles: Floats


def points_of(wi: ArrayLike, wo: ArrayLike, parametrisation: Parametrisation) -> Points:
    """The points of unit directions (N, 3) above the horizon."""
    wi, wo = np.asarray(wi, np.float64), np.asarray(wo, np.float64)
    both, between = 0.5 * (wi + wo), 0.5 * (wi - wo)
    cosine, sine = np.sqrt(dot(both, both)), np.sqrt(dot(between, between))
    unit = half_vector(wi, wo)
    half, incident, outgoing = parabolic(unit), parabolic(wi), parabolic(wo)
    # 1 − cos θ_i cos θ_o as a sum, in which nothing cancels near the normal
    squares = (incident**2).sum(axis=1), (outgoing**2).sum(axis=1)
    deficit = 2.0 * (squares[0] + squares[1]) / ((1.0 + squares[0]) * (1.0 + squares[1]))
    mean = np.sqrt(deficit) / (1.0 + np.sqrt(np.maximum(wi[:, 2] * wo[:, 2], 0.0)))
    angles = np.column_stack([np.hypot(half[:, 0], half[:, 1]), sine / (1.0 + cosine), mean])
    if parametrisation == "in-out":
        return Points(np.hstack([incident, outgoing]), incident, outgoing, half, angles)
    x_axis, y_axis = cole_frame(unit)
    difference = np.column_stack([dot(x_axis, between), dot(y_axis, between)]) / (1.0 + cosine)[:, None]
    return Points(np.hstack([half, difference]), incident, outgoing, half, angles)


def parabolic(directions: ArrayLike) -> Floats:
    """(x, y)/(1 + z) (…, 2) of unit directions (…, 3) that do not point straight down."""
    directions = np.asarray(directions, np.float64)
    return directions[..., :2] / (1.0 + directions[..., 2:])


@dataclass(frozen=True, eq=False)
class LinearProjection:
    """Two orthonormal rows (2, 4), and what the image is divided by, from `extent`."""

    rows: Floats
    extent: Extent = "disks"
    scale: Floats = field(init=False)

    def __post_init__(self) -> None:
        rows = np.array(self.rows, np.float64)
        small = rows.shape == (2, 4) and np.abs(rows).max() <= 2.0
        if not small or not np.abs(rows @ rows.T - np.eye(2)).max() <= _ORTHONORMAL:
            raise ValueError("a linear projection needs two orthonormal rows of four numbers")
        if self.extent == "cube":
            scale = np.abs(rows).sum(axis=1)
        else:
            scale = np.hypot(rows[:, 0], rows[:, 1]) + np.hypot(rows[:, 2], rows[:, 3])
        for name, array in (("rows", rows), ("scale", scale)):
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    @property
    def name(self) -> str:
        return "linear"

    def conjugate(self, parametrisation: Parametrisation) -> LinearProjection:
        """The projection that sees (wo, wi) where this one sees (wi, wo)."""
        if parametrisation == "in-out":
            return LinearProjection(self.rows[:, [2, 3, 0, 1]], self.extent)
        return LinearProjection(self.rows * (1.0, 1.0, -1.0, -1.0), self.extent)

    def coordinates(self, points: Points) -> Floats:
        """Texture coordinates (N, 2), in [−1, 1] for directions above the horizon."""
        out = np.empty((len(points.flat), 2))
        _project(points.flat, self.rows, self.scale, out)
        return out

    def mask(self, size: int) -> Mask:
        """The texels (size, size), row = second coordinate, that a pair in the 4-cube can touch."""
        columns = self.rows / self.scale[:, None]
        step = 2.0 / (size - 1)
        generators = np.column_stack([columns, [step, 0.0], [0.0, step]])
        normals = np.column_stack([-generators[1], generators[0]])
        reach = np.abs(normals @ generators).sum(axis=1)
        axis = np.linspace(-1.0, 1.0, size)
        across, down = normals.T[:, :, None, None]
        outside = np.abs(across * axis + down * axis[:, None]) > reach[:, None, None] + 1e-9
        return np.asarray(~outside.any(axis=0))


@dataclass(frozen=True)
class FixedProjection:
    """One of the projections that are not searched."""

    kind: Kind

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ValueError(f"unknown projection {self.kind!r}; choose from {', '.join(KINDS)}")

    @property
    def name(self) -> str:
        return self.kind

    @property
    def angles(self) -> str:
        """The pair of angles, without their measure; empty for directions and elevations."""
        base = self.kind.removesuffix(f"-{self.measure}")
        return base if base in _ANGLES else ""

    @property
    def of_angles(self) -> bool:
        """True if the coordinates are polar angles only."""
        return bool(self.angles) or self.kind in ("elevations", "elevations-exchanged")

    @property
    def measure(self) -> Measure:
        """Measure of the angles that the coordinates are."""
        return next((measure for measure in _MEASURES if self.kind.endswith(f"-{measure}")), "radii")

    def conjugate(self, parametrisation: Parametrisation) -> FixedProjection:
        """The projection that sees (wo, wi) where this one sees (wi, wo), in either parametrisation."""
        return FixedProjection(_EXCHANGED.get(self.kind, self.kind))

    def coordinates(self, points: Points) -> Floats:
        """Texture coordinates (N, 2) in [−1, 1]."""
        if self.angles:
            return _measure(points.angles[:, _ANGLES[self.angles]], self.measure)
        if self.kind in ("elevations", "elevations-exchanged"):
            radii = np.column_stack([np.hypot(*points.wi.T), np.hypot(*points.wo.T)])
            return 2.0 * (radii if self.kind == "elevations" else radii[:, ::-1]) - 1.0
        return {"wi": points.wi, "wo": points.wo, "half": points.half}[self.kind]

    def mask(self, size: int) -> Mask:
        """The texels (size, size) that a pair above the horizon can touch."""
        axis = np.linspace(-1.0, 1.0, size)
        if self.measure == "turned":
            return np.abs(axis[:, None]) + np.abs(axis) <= 1.0 + 4.0 / (size - 1) + 1e-9
        if self.kind not in ("wi", "wo", "half"):
            return np.ones((size, size), bool)
        nearest = np.maximum(np.abs(axis) - 2.0 / (size - 1), 0.0)
        return np.asarray(np.hypot(nearest[:, None], nearest) <= 1.0 + 1e-9)


def _measure(radii: Floats, measure: Measure) -> Floats:
    """Coordinates (N, 2) in [−1, 1] of angles given as radii tan(θ/2) (N, 2) in [0, 1]."""
    squares = radii * radii
    if measure == "turned":
        first, second = (2.0 * radii - 1.0).T
        return np.column_stack([0.5 * (first + second), 0.5 * (first - second)])
    if measure == "cosines":
        return 2.0 * (1.0 - squares) / (1.0 + squares) - 1.0
    if measure == "sines":
        return 4.0 * radii / (1.0 + squares) - 1.0
    return 2.0 * (squares if measure == "squares" else radii) - 1.0


Projection = LinearProjection | FixedProjection

INCIDENT = FixedProjection("wi")
OUTGOING = FixedProjection("wo")
HALF = FixedProjection("half")
WI_DOT_H = FixedProjection("wi-dot-h")
ELEVATIONS = FixedProjection("elevations")


def linear(rows: ArrayLike, extent: Extent = "disks") -> LinearProjection:
    """A linear projection of any two independent rows (2, 4), made orthonormal from the first on."""
    first, second = np.asarray(rows, np.float64)
    first = first / np.sqrt(first @ first)
    second = second - (second @ first) * first
    length = float(np.sqrt(second @ second))
    if not length > 1e-9:
        raise ValueError("the rows of a projection must be independent")
    return LinearProjection(np.stack([first, second / length]), extent)


def linear_of_pair(pair: Pair, extent: Extent = "disks") -> LinearProjection:
    """The first two axes, turned by a pair of quaternions."""
    return linear(matrix(pair)[:, :2].T, extent)


#: Guesses that need no search: either of the two disks, their sum and their difference.
FIRST = LinearProjection(np.eye(4)[:2])
SECOND = LinearProjection(np.eye(4)[2:])
SUM = linear([[1.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, 1.0]])
DIFFERENCE = linear([[1.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, -1.0]])


def mccool_projections(reciprocal: bool) -> tuple[Projection, ...]:
    """McCool's fixed set: wi, h and wo, or, with wi and wo in one texture, two of them."""
    return (INCIDENT, HALF) if reciprocal else (INCIDENT, HALF, OUTGOING)


def look_ups(
    projection: Projection, points: Points, parametrisation: Parametrisation, reciprocal: bool
) -> tuple[Floats, ...]:
    """The coordinates (N, 2) at which a term reads its texture: once, or, where reciprocal, also by the conjugate."""
    coordinates = projection.coordinates(points)
    conjugate = projection.conjugate(parametrisation)
    if not reciprocal or conjugate == projection:
        return (coordinates,)
    return coordinates, conjugate.coordinates(points)


def texture_mask(projection: Projection, parametrisation: Parametrisation, reciprocal: bool, size: int) -> Mask:
    """The texels (size, size) that some look-up of a term can touch."""
    mask = projection.mask(size)
    return mask | projection.conjugate(parametrisation).mask(size) if reciprocal else mask


@scalar
def _project(flat: np.ndarray, rows: np.ndarray, scale: np.ndarray, out: np.ndarray) -> None:
    for i in range(len(flat)):
        for k in range(2):
            first = flat[i, 0] * rows[k, 0] + flat[i, 1] * rows[k, 1]
            second = flat[i, 2] * rows[k, 2] + flat[i, 3] * rows[k, 3]
            out[i, k] = (first + second) / scale[k]

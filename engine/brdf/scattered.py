"""A BRDF made smooth from scattered measurements by radial basis functions (Kautz, Sloan and Snyder 2002, Sec. 3).

    log(f + c) = mean + Σ_j a_j K(x, x_j)          K(x, y) = mean over the symmetries g of φ(|x − g y| / δ)

Coordinates x. Isotropic: (p d, λ θ_d) with p = asinh(θ_h/t)/asinh(π/2t), the half angle stretched where highlights
are, and d the unit difference vector in the classical frame of the half vector (Rusinkiewicz 1998). Pairs that a turn
about the normal makes equal are one point, also at θ_h = 0 and θ_d = 0 where angles have none. Anisotropic:
(p cos φ_h, p sin φ_h, λ (wi − wo)/2).
Symmetries. Mirroring at the plane of incidence negates d_y, exchanging wi and wo (reciprocity) d_x and d_y or
wi − wo. Each is imposed exactly, through K, if no two samples contradict it and the logarithmic leave-one-out error
does not grow by more than `SYMMETRY_SLACK` with it; Cornell's paints turn out not to be reciprocal as measured. Where
one sample in a hundred or more has its exchanged partner in the list, with the same value, reciprocity is a fact.
Isotropy is taken where it predicts left-out samples better, and where all light comes from one azimuth, which says
nothing against it.
Kernels φ: Wendland's (1995), positive definite in up to five dimensions: (1 − r)³₊, or (1 − r)⁵₊(5r + 1), which is
smooth. Kernel, t and λ are those of the least logarithmic leave-one-out error (Rippa 1999) on up to `SEARCH_SAMPLES`
samples: a_j / (A⁻¹)_jj is what sample j misses the rest by, without a second solution.
Logarithm: highlights over six decades do not ring. It is taken of XYZ where the samples are spectra, whose sRGB may be
negative, and of RGB otherwise; in that space f cannot be negative. c is a tenth of the median value. Results are held
between 0 and the largest sample of the channel there, so extrapolation towards grazing angles is bounded.
Samples are met to rounding unless `smoothing` adds a ridge; samples that coincide are replaced by their mean in log f.
Above `PATCH_SAMPLES` samples the domain is split into overlapping boxes, each with its own expansion, blended by a
smooth partition of unity (Wendland 2005, ch. 29); boxes are split only along coordinates that no symmetry negates,
so that the blend is as symmetric as K. Interpolation and the leave-one-out formula carry over exactly.

scipy's RBFInterpolator knows neither symmetries nor leave-one-out errors nor condition numbers, and its only remedy
for many samples, nearest neighbours, is not continuous.
Cost on two cores: 1,439 samples of Cornell 2.3 s of processor time and then 5e5 values per second, 7,405 samples of a
tape 2.6 s and 4e5 per second, 30,000 samples 5 s and 1e5 per second; below 100 MB. Evaluation is bound
by the distances to the samples, and their images, of one to four boxes, about 1.2 ns each.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import lapack

from engine.brdf.samples import BrdfSamples
from engine.directions import Vectors, dot
from engine.health import Finding, Health, Verdict
from engine.kernels import parallel, prange, scalar
from engine.one_thread import one_thread
from engine.steps import Step, Steps, drain

Floats = NDArray[np.float64]

#: Most samples that choose kernel and scales, and most that one expansion is made of.
SEARCH_SAMPLES = 800
PATCH_SAMPLES = 1600

#: How many samples a box is split down to, and how far it reaches beyond its sides, in their length.
_LEAF_SAMPLES = 600
_OVERLAP = 0.15

#: Mirroring and exchange may cost this factor in the logarithmic leave-one-out error.
SYMMETRY_SLACK = 1.05

#: Points closer than this in the coordinates are one direction pair; values that differ by more are a contradiction.
_SAME_POINT = 1e-6
_SAME_VALUE = 1e-4

#: Reach of the kernels in the coordinates, several times the domain.
_REACH = 4.0

#: Half angles in radians below which the stretch is linear, and weights of the difference angle, that are tried.
_BENDS = (0.05, 0.5)
_DIFFERENCE_WEIGHTS = (0.3, 1.5)

#: A condition number from which digits are missing that someone may look for.
_ILL_CONDITIONED = 1e12

_OFFSET = 0.1
_LEAST_OFFSET = 1e-300
_CHUNK = 1 << 16


class Symmetry(NamedTuple):
    """Which turns and exchanges leave the BRDF as it is, and the signs (G, D) that they give the coordinates."""

    isotropic: bool
    reciprocal: bool
    signs: tuple[tuple[int, ...], ...]


#: From the most symmetric to none; the first that the data bear is taken.
SYMMETRIES = (
    Symmetry(True, True, ((1, 1, 1, 1), (1, -1, 1, 1), (-1, -1, 1, 1), (-1, 1, 1, 1))),
    Symmetry(True, False, ((1, 1, 1, 1), (1, -1, 1, 1))),
    Symmetry(True, False, ((1, 1, 1, 1),)),
    Symmetry(False, True, ((1, 1, 1, 1, 1), (1, 1, -1, -1, -1))),
    Symmetry(False, False, ((1, 1, 1, 1, 1),)),
)


#: The signs above that exchange wi and wo, with or without a mirror.
_EXCHANGES = ((-1, -1, 1, 1), (-1, 1, 1, 1), (1, 1, -1, -1, -1))


class Shape(NamedTuple):
    """The coordinates and the kernel: what leave-one-out chooses."""

    symmetry: Symmetry
    bend: float
    difference_weight: float
    smooth: bool

    @property
    def signs(self) -> Floats:
        return np.array(self.symmetry.signs, np.float64)


@dataclass(frozen=True, eq=False)
class ScatteredBrdf:
    """The smooth BRDF through scattered samples, made by `fit_scattered`; see the head of this file.

    Attributes
    ----------
    measured : the samples.
    shape : coordinates, symmetries and kernel.
    condition_number : of the interpolation matrix in the 1-norm, from its inverse; the largest of all boxes.
    leave_one_out : ‖prediction from all other samples − sample‖ / ‖sample‖ over all samples and channels,
        in 1/sr, of XYZ for spectra.
    leave_one_out_log : root mean square of the same differences in log(f + c): the typical relative error.
    health : that of the samples, and these figures.
    """

    measured: BrdfSamples
    shape: Shape
    condition_number: float
    leave_one_out: float
    leave_one_out_log: float
    health: Health
    _offset: float
    _mean: Floats
    _patches: _Patches

    @property
    def isotropic(self) -> bool:
        return self.shape.symmetry.isotropic

    @property
    def reciprocal(self) -> bool:
        return self.shape.symmetry.reciprocal

    @property
    def energy_conserving(self) -> bool:
        return False

    @property
    def name(self) -> str:
        return self.measured.name

    @property
    def kind(self) -> str:
        return self.measured.kind

    @property
    def samples(self) -> int:
        return self.measured.samples

    @property
    def invalid_samples(self) -> int:
        return self.measured.invalid_samples

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Values (..., 3) in 1/sr for unit directions (..., 3) that broadcast; 0 at and below the horizon."""
        wi, wo = np.broadcast_arrays(np.asarray(wi, np.float64), np.asarray(wo, np.float64))
        values = np.zeros(wi.shape)
        incident, outgoing, out = wi.reshape(-1, 3), wo.reshape(-1, 3), values.reshape(-1, 3)
        largest = self.measured.positive.max(axis=0)
        srgb_from_positive = np.linalg.inv(self.measured.positive_from_srgb)
        for first in range(0, len(out), _CHUNK):
            part = slice(first, first + _CHUNK)
            above = (incident[part, 2] > 0.0) & (outgoing[part, 2] > 0.0)
            points = coordinates(incident[part][above], outgoing[part][above], self.shape)
            logs = self._patches.evaluate(points, self.shape.smooth) + self._mean
            logs = np.minimum(logs, np.log(largest + self._offset))
            out[part][above] = np.clip(np.exp(logs) - self._offset, 0.0, largest) @ srgb_from_positive.T
        return values


def scattered_brdf(samples: BrdfSamples, smoothing: float = 0.0) -> ScatteredBrdf:
    """`fit_scattered`, run to its end."""
    return drain(fit_scattered(samples, smoothing))


def fit_scattered(samples: BrdfSamples, smoothing: float = 0.0) -> Steps[ScatteredBrdf]:
    """The smooth BRDF through `samples`.

    `smoothing` ≥ 0 is added to the diagonal of the interpolation matrix, whose own diagonal is about 1: the result
    then minimises Σ (log residual)² + smoothing · ‖log f‖² in the norm of the kernel, and no longer meets the samples.
    Takes 1 to 15 s; the generator returns the BRDF. Raises ValueError for a negative `smoothing`.
    """
    if not 0.0 <= smoothing < np.inf:
        raise ValueError(f"smoothing must be at least 0 and finite, not {smoothing}")
    values = samples.positive
    lit = values[values > 0.0]
    offset = max(_OFFSET * float(np.median(lit)), _LEAST_OFFSET) if len(lit) else 1.0
    logs = np.log(values + offset)
    shape = yield from _chosen_shape(samples, logs, smoothing)
    points, logs_kept, merged = _merged(coordinates(samples.wi, samples.wo, shape), logs, shape)
    mean = logs_kept.mean(axis=0)
    targets = logs_kept - mean
    boxes = list(_boxes(points, _fixed_axes(shape)))
    fitted: list[_Expansion] = []
    for number, box in enumerate(boxes):
        yield Step(0.4 + 0.6 * number / len(boxes), f"interpolation, box {number + 1} of {len(boxes)}")
        members = np.flatnonzero(box.weight(points) > 0.0)
        fitted.append(_expanded(points[members], targets[members], shape, smoothing, box, members))
    patches = _Patches.of(points, fitted, shape.signs)
    residual = _blended_residual(points, fitted)
    predicted = np.clip(np.exp(logs_kept - residual) - offset, 0.0, values.max(axis=0))
    truth = np.exp(logs_kept) - offset
    scale = float(np.linalg.norm(truth))
    condition = max(expansion.condition for expansion in fitted)
    left_out = float(np.linalg.norm(predicted - truth)) / scale if scale else 0.0
    left_out_log = float(np.sqrt((residual**2).mean()))
    figures = {
        "condition number": condition,
        "leave-one-out, relative": left_out,
        "leave-one-out, logarithmic": left_out_log,
        "samples merged": float(merged),
        "boxes": float(len(boxes)),
    }
    findings = []
    if condition > _ILL_CONDITIONED:
        text = f"the interpolation is ill-conditioned ({condition:.1e}); smoothing helps"
        findings.append(Finding(Verdict.WARNING, text))
    if merged:
        text = f"{merged} samples repeat the directions of another, or are its image by symmetry; their mean is kept"
        findings.append(Finding(Verdict.NOTE, text))
    health = samples.health.merged(Health(MappingProxyType(figures), tuple(findings)))
    return ScatteredBrdf(samples, shape, condition, left_out, left_out_log, health, offset, mean, patches)


def coordinates(wi: Floats, wo: Floats, shape: Shape) -> Floats:
    """The points (N, 4) or (N, 5) of pairs (N, 3) above the horizon in which distances are taken."""
    both, apart = wi + wo, 0.5 * (wi - wo)
    length = np.sqrt(dot(both, both))
    half = both / length[:, None]
    across = np.hypot(half[:, 0], half[:, 1])
    theta_h = np.arctan2(across, half[:, 2])
    stretched = np.arcsinh(theta_h / shape.bend) / np.arcsinh(0.5 * np.pi / shape.bend)
    tilted = across > 1e-12
    safe = np.where(tilted, across, 1.0)
    x, y = np.where(tilted, half[:, 0] / safe, 1.0), np.where(tilted, half[:, 1] / safe, 0.0)
    if not shape.symmetry.isotropic:
        return np.column_stack([stretched * x, stretched * y, shape.difference_weight * apart])
    along = (apart[:, 0] * x + apart[:, 1] * y) * half[:, 2] - apart[:, 2] * across
    beside = apart[:, 1] * x - apart[:, 0] * y
    theta_d = np.arctan2(np.sqrt(dot(apart, apart)), 0.5 * length)
    difference = np.column_stack([along, beside, 0.5 * length])
    return np.column_stack([stretched[:, None] * difference, shape.difference_weight * theta_d / (0.5 * np.pi)])


def _chosen_shape(samples: BrdfSamples, logs: Floats, smoothing: float) -> Steps[Shape]:
    """The most symmetric shape that the data bear, with the scales that predict left-out samples best."""
    count = len(logs)
    subset = np.sort(np.random.default_rng(0).permutation(count)[:SEARCH_SAMPLES])
    wi, wo = samples.wi[subset], samples.wo[subset]
    targets = logs[subset] - logs[subset].mean(axis=0)
    found: list[tuple[float, Shape]] = []
    possible = _possible(samples)
    for number, symmetry in enumerate(possible):
        errors: list[tuple[float, Shape]] = []
        for bend, weight, smooth in itertools.product(_BENDS, _DIFFERENCE_WEIGHTS, (False, True)):
            yield Step(0.4 * (number + len(errors) / 8) / len(possible), "choice of coordinates and kernel")
            shape = Shape(symmetry, bend, weight, smooth)
            points, values, _ = _merged(coordinates(wi, wo, shape), targets, shape)
            solved = _solved(_kernel_matrix(points, shape.signs, smooth), values, smoothing)
            if solved is not None:
                errors.append((float(np.sqrt((solved.residual**2).mean())), shape))
        found.append(min(errors, key=lambda error: error[0], default=(np.inf, shape)))
    best, winner = min(found, key=lambda pair: pair[0])
    alike = [pair for pair in found if pair[1].symmetry.isotropic == winner.symmetry.isotropic]
    return next(shape for error, shape in alike if error <= SYMMETRY_SLACK * best)


def _possible(samples: BrdfSamples) -> list[Symmetry]:
    """The symmetries that no two samples contradict; those with reciprocity alone where samples show it."""
    single = any(_one_azimuth(directions) for directions in (samples.wi, samples.wo))
    asked = [symmetry for symmetry in SYMMETRIES if symmetry.isotropic or not single]
    seen = {symmetry: _evidence(samples, symmetry) for symmetry in asked}
    borne = [symmetry for symmetry in asked if seen[symmetry] is not None]
    shown = [
        symmetry for symmetry in borne if symmetry.reciprocal and (seen[symmetry] or 0) >= len(samples.value) / 100
    ]
    # Where all light comes from one azimuth nothing can contradict isotropy, not even samples of noise.
    return shown or borne or [SYMMETRIES[2]]


def _evidence(samples: BrdfSamples, symmetry: Symmetry) -> int | None:
    """How many samples have a partner of the same value where the exchange of wi and wo takes them.

    None where two samples that the symmetry makes one point differ in value, other than the same pair measured twice.
    """
    pairs = np.rint(np.hstack([samples.wi, samples.wo]) / _SAME_POINT).astype(np.int64)
    _, once = np.unique(pairs, axis=0, return_index=True)
    points = coordinates(samples.wi[once], samples.wo[once], Shape(symmetry, _BENDS[-1], 1.0, False))
    groups, place = np.unique(_keys(points, symmetry.signs), axis=0, return_inverse=True)
    low, high = np.full((len(groups), 3), np.inf), np.zeros((len(groups), 3))
    values = samples.positive
    np.minimum.at(low, place, values[once])
    np.maximum.at(high, place, values[once])
    if (high - low > _SAME_VALUE * high + 1e-6 * values.max()).any():
        return None
    without = [signs for signs in symmetry.signs if signs not in _EXCHANGES]
    return len(np.unique(_keys(points, without), axis=0)) - len(groups)


def _keys(points: Floats, all_signs: Sequence[tuple[int, ...]]) -> NDArray[np.int64]:
    """Whole numbers (N, D) that are equal for points that the signs make one: the least of all images."""
    images = [np.rint(points * signs / _SAME_POINT).astype(np.int64) for signs in np.array(all_signs, np.float64)]
    least = images[0]
    for image in images[1:]:
        axis = (image != least).argmax(axis=1)[:, None]
        least = np.where(np.take_along_axis(image < least, axis, axis=1), image, least)
    return least


def _one_azimuth(directions: Vectors) -> bool:
    """True where all directions lie in one plane through the normal."""
    flat = directions[:, :2]
    furthest = flat[np.argmax(np.hypot(flat[:, 0], flat[:, 1]))]
    return bool((np.abs(flat[:, 0] * furthest[1] - flat[:, 1] * furthest[0]) < 1e-6).all())


def _merged(points: Floats, logs: Floats, shape: Shape) -> tuple[Floats, Floats, int]:
    """Points and values with those that the symmetries make one replaced by their mean, and how many go."""
    keys = _keys(points, shape.symmetry.signs)
    _, kept, place, counts = np.unique(keys, axis=0, return_index=True, return_inverse=True, return_counts=True)
    sums = np.zeros((len(kept), logs.shape[1]))
    np.add.at(sums, place, logs)
    return points[kept], sums / counts[:, None], len(points) - len(kept)


class _Solved(NamedTuple):
    weights: Floats
    residual: Floats
    condition: float


def _solved(matrix: Floats, targets: Floats, smoothing: float) -> _Solved | None:
    """Weights, leave-one-out residuals and condition number; None where the matrix is singular to rounding."""
    matrix[np.diag_indices_from(matrix)] += smoothing
    # Threads that wait for each other take ten times as long where the processors are busy otherwise.
    with one_thread():
        factor, failed = lapack.dpotrf(matrix, lower=1, clean=1)
        if failed:
            return None
        inverse = lapack.dpotrs(factor, np.eye(len(matrix)), lower=1)[0]
        if not np.isfinite(inverse).all():
            return None
        weights = lapack.dpotrs(factor, targets, lower=1)[0]
        weights += lapack.dpotrs(factor, targets - matrix @ weights, lower=1)[0]
    condition = float(np.abs(matrix).sum(axis=0).max() * np.abs(inverse).sum(axis=0).max())
    return _Solved(weights, weights / np.diag(inverse)[:, None], condition)


class _Box(NamedTuple):
    """A box with sides `low` to `high` (D,), endless where infinite, that fades out over `margin` (D,) beyond them."""

    low: Floats
    high: Floats
    margin: Floats

    def weight(self, points: Floats) -> Floats:
        """Weights (N,) before they are made to sum to 1."""
        outside = np.maximum(np.maximum(self.low - points, points - self.high), 0.0) / self.margin
        rest = np.maximum(1.0 - outside, 0.0)
        weights: Floats = np.prod(rest * rest * (3.0 - 2.0 * rest), axis=1)
        return weights


@scalar
def _fade(outside: float) -> float:
    """1 at the side of a box, 0 where its margin ends, with slope 0 at both."""
    rest = max(1.0 - outside, 0.0)
    return rest * rest * (3.0 - 2.0 * rest)


def _fixed_axes(shape: Shape) -> NDArray[np.intp]:
    """Coordinates that no symmetry negates."""
    return np.flatnonzero((shape.signs > 0.0).all(axis=0))


def _boxes(points: Floats, axes: NDArray[np.intp]) -> Iterator[_Box]:
    """Boxes that tile all space, split at medians until each holds at most `_LEAF_SAMPLES` points."""
    dimensions = points.shape[1]
    endless = np.full(dimensions, np.inf)
    if len(points) <= PATCH_SAMPLES:
        yield _Box(-endless, endless, np.ones(dimensions))
        return
    stack = [(-endless, endless, np.arange(len(points)))]
    while stack:
        low, high, members = stack.pop()
        inside = points[members]
        extent = np.ptp(inside, axis=0)
        axis = axes[np.argmax(extent[axes])]
        middle = float(np.median(inside[:, axis]))
        left = inside[:, axis] <= middle
        if len(members) <= _LEAF_SAMPLES or left.all():
            yield _Box(low, high, np.maximum(_OVERLAP * extent, 1e-3))
            continue
        below, above = high.copy(), low.copy()
        below[axis] = above[axis] = middle
        stack += [(low, below, members[left]), (above, high, members[~left])]


class _Expansion(NamedTuple):
    """The expansion of one box: its samples by number, their weights, and what each misses the others by."""

    box: _Box
    members: NDArray[np.intp]
    weights: Floats
    residual: Floats
    condition: float


def _expanded(
    points: Floats, targets: Floats, shape: Shape, smoothing: float, box: _Box, members: NDArray[np.intp]
) -> _Expansion:
    """The expansion in one box; where the matrix is singular to rounding, with the least ridge that mends it."""
    ridge = 0.0
    while True:
        solved = _solved(_kernel_matrix(points, shape.signs, shape.smooth), targets, smoothing + ridge)
        if solved is not None:
            return _Expansion(box, members, solved.weights, solved.residual, solved.condition)
        ridge = max(10.0 * ridge, 1e-13 * len(points))


def _blended_residual(points: Floats, expansions: list[_Expansion]) -> Floats:
    """What each sample misses the prediction from all others by, in the blend of all boxes."""
    channels = expansions[0].residual.shape[1]
    sums, weights = np.zeros((len(points), channels)), np.zeros((len(points), 1))
    for expansion in expansions:
        weight = expansion.box.weight(points[expansion.members])[:, None]
        sums[expansion.members] += weight * expansion.residual
        weights[expansion.members] += weight
    return sums / weights


@dataclass(frozen=True, eq=False)
class _Patches:
    """All boxes in one piece, as the kernel wants them.

    `centres` (5, M) are the samples of box after box with all their images, weights (3, M) divided by the number of
    images; those of box b are starts[b] … starts[b + 1]. Sides and margins are (B, 5).
    """

    low: Floats
    high: Floats
    margin: Floats
    starts: NDArray[np.int64]
    centres: Floats
    weights: Floats

    @staticmethod
    def of(points: Floats, expansions: list[_Expansion], signs: Floats) -> _Patches:
        centres = [(points[part.members] * image) for part in expansions for image in signs]
        weights = [part.weights / len(signs) for part in expansions for _ in signs]
        counts = [len(signs) * len(part.members) for part in expansions]
        return _Patches(
            _five(np.array([part.box.low for part in expansions]), -np.inf),
            _five(np.array([part.box.high for part in expansions]), np.inf),
            _five(np.array([part.box.margin for part in expansions]), 1.0),
            np.cumsum([0, *counts]).astype(np.int64),
            np.ascontiguousarray(_five(np.concatenate(centres), 0.0).T),
            np.ascontiguousarray(np.concatenate(weights).T),
        )

    def evaluate(self, points: Floats, smooth: bool) -> Floats:
        """The blended sums (N, 3) at points (N, D); neighbours are taken together, for they share their boxes."""
        points = _five(points, 0.0)
        order = np.argsort(_homes(points, self.low, self.high), kind="stable")
        sums = np.empty((len(points), 3))
        _blend(points[order], self.low, self.high, self.margin, self.starts, self.centres, self.weights, smooth, sums)
        out = np.empty_like(sums)
        out[order] = sums
        return out


def _five(points: Floats, filling: float) -> Floats:
    """Points (N, D) with `filling` for the coordinates that they have not."""
    return np.pad(points, ((0, 0), (0, 5 - points.shape[1])), constant_values=filling)


def _kernel_matrix(points: Floats, signs: Floats, smooth: bool) -> Floats:
    """K (N, N) of points (N, D) with each other."""
    out = np.zeros((len(points), len(points)))
    images = np.stack([np.ascontiguousarray(_five(points * image, 0.0).T) for image in signs])
    _matrix(_five(points, 0.0), images, smooth, out)
    return out


@scalar
def _phi(squared: float, smooth: bool) -> float:
    """The kernel for a squared distance."""
    r = np.sqrt(squared) / _REACH
    q = max(1.0 - r, 0.0)
    cube = q * q * q
    return cube * q * q * (5.0 * r + 1.0) if smooth else cube


@parallel
def _matrix(points: Floats, images: Floats, smooth: bool, out: Floats) -> None:
    for row in prange(points.shape[0]):
        a, b, c, d, e = points[row]
        for image in range(images.shape[0]):
            for column in range(points.shape[0]):
                squared = (
                    (a - images[image, 0, column]) ** 2
                    + (b - images[image, 1, column]) ** 2
                    + (c - images[image, 2, column]) ** 2
                    + (d - images[image, 3, column]) ** 2
                    + (e - images[image, 4, column]) ** 2
                )
                out[row, column] += _phi(squared, smooth) / images.shape[0]


@parallel
def _homes(points: Floats, low: Floats, high: Floats) -> NDArray[np.int64]:
    """The first box (N,) in which each point lies."""
    homes = np.zeros(points.shape[0], np.int64)
    for query in prange(points.shape[0]):
        for box in range(low.shape[0]):
            inside = True
            for axis in range(5):
                inside &= low[box, axis] <= points[query, axis] <= high[box, axis]
            if inside:
                homes[query] = box
                break
    return homes


@parallel
def _blend(
    points: Floats,
    low: Floats,
    high: Floats,
    margin: Floats,
    starts: NDArray[np.int64],
    centres: Floats,
    weights: Floats,
    smooth: bool,
    out: Floats,
) -> None:
    # Sixteen points at a time: the inner loop over them has no sum across its turns and becomes vector instructions.
    for tile in prange((points.shape[0] + 15) // 16):
        first, count = 16 * tile, min(16, points.shape[0] - 16 * tile)
        x, sums, share, total = np.zeros((5, 16)), np.zeros((3, 16)), np.zeros(16), np.zeros(16)
        blended = np.zeros((3, 16))
        for lane in range(count):
            for axis in range(5):
                x[axis, lane] = points[first + lane, axis]
        for box in range(low.shape[0]):
            touched = False
            for lane in range(count):
                share[lane] = 1.0
                for axis in range(5):
                    outside = max(low[box, axis] - x[axis, lane], x[axis, lane] - high[box, axis])
                    if outside > 0.0:
                        share[lane] *= _fade(outside / margin[box, axis])
                touched |= share[lane] > 0.0
            if not touched:
                continue
            sums[:] = 0.0
            for centre in range(starts[box], starts[box + 1]):
                a, b, c = centres[0, centre], centres[1, centre], centres[2, centre]
                d, e = centres[3, centre], centres[4, centre]
                red, green, blue = weights[0, centre], weights[1, centre], weights[2, centre]
                for lane in range(16):
                    squared = (
                        (x[0, lane] - a) ** 2
                        + (x[1, lane] - b) ** 2
                        + (x[2, lane] - c) ** 2
                        + (x[3, lane] - d) ** 2
                        + (x[4, lane] - e) ** 2
                    )
                    value = _phi(squared, smooth)
                    sums[0, lane] += value * red
                    sums[1, lane] += value * green
                    sums[2, lane] += value * blue
            for lane in range(count):
                total[lane] += share[lane]
                for channel in range(3):
                    blended[channel, lane] += share[lane] * sums[channel, lane]
        for lane in range(count):
            for channel in range(3):
                out[first + lane, channel] = blended[channel, lane] / total[lane]

"""A BRDF made smooth from scattered measurements by radial basis functions (Kautz2002 Sec. 3).

    log(f + c) = mean + Σ_j a_j K(x, x_j)          K(x, y) = mean over the symmetries g of φ(|x − g y| / δ)

Coordinates x. Isotropic: (p d, λ θ_d) with p = asinh(θ_h/t)/asinh(π/2t), the half angle stretched where highlights
are, and d the unit difference vector in the classical frame of the half vector (Rusinkiewicz1998). Pairs that a turn
about the normal makes equal are one point, also at θ_h = 0 and θ_d = 0 where angles have none. Anisotropic:
(p cos φ_h, p sin φ_h, λ (wi − wo)/2).
Symmetries. Mirroring at the plane of incidence negates d_y, exchanging wi and wo (reciprocity) d_x and d_y or
wi − wo. Each is imposed exactly, through K, if no two samples contradict it and the logarithmic leave-one-out error
does not grow by more than `SYMMETRY_SLACK` with it; Cornell's paints turn out not to be reciprocal as measured. Where
one sample in a hundred or more has its exchanged partner in the list, with the same value, reciprocity is a fact.
Isotropy is taken where it predicts left-out samples better, and where all light comes from one azimuth, which says
nothing against it.
Kernels φ: Wendland's (1995), positive definite in up to five dimensions: (1 − r)³₊, or (1 − r)⁵₊(5r + 1), which is
smooth. Kernel, t and λ are those of the least logarithmic leave-one-out error (Rippa1999) on up to `SEARCH_SAMPLES`
samples: a_j / (A⁻¹)_jj is what sample j misses the rest by, without a second solution.
Logarithm: highlights over six decades do not ring. It is taken of XYZ where the samples are spectra, whose sRGB may be
negative, and of RGB otherwise; in that space f cannot be negative. c is a tenth of the median value. Results are held
between 0 and the largest sample of the channel there, so extrapolation towards grazing angles is bounded.
Samples are met to rounding unless `smoothing` adds a ridge; samples that coincide are replaced by their mean in log f.
Above `radial_basis.PATCH_SAMPLES` samples the domain is split into boxes, which are blended.

Cost on two cores: 1,439 samples of Cornell 2.3 s of CPU time and then 5e5 values per second, 7,405 samples of a
tape 2.6 s and 4e5 per second, 30,000 samples 5 s and 1e5 per second; below 100 MB. Evaluation is bound
by the distances to the samples, and their images, of one to four boxes, about 1.2 ns each.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.models.sampling import Reflectance
from engine.brdf.radial_basis import Expansion, Patches, boxes, compute_blended_residual, expand, kernel_matrix, solve
from engine.brdf.samples import BrdfSamples
from engine.core.directions import Vectors, dot
from engine.core.health import Finding, Health, Verdict
from engine.core.steps import Step, Steps
from engine.core.summary import Summary

Floats = NDArray[np.float64]

#: Most samples that choose kernel and scales.
SEARCH_SAMPLES = 800

#: Mirroring and exchange may cost this factor in the logarithmic leave-one-out error.
SYMMETRY_SLACK = 1.05

#: Points closer than this in the coordinates are one direction pair; values that differ by more are a contradiction.
_SAME_POINT = 1e-6
_SAME_VALUE = 1e-4

#: Half angles in radians below which the stretch is linear, and weights of the difference angle, that are tried.
_BENDS = (0.05, 0.5)
_DIFFERENCE_WEIGHTS = (0.3, 1.5)

#: A condition number from which digits are missing that someone may look for.
_ILL_CONDITIONED = 1e12

_OFFSET = 0.1
_MIN_OFFSET = 1e-300
_CHUNK = 1 << 16


class Symmetry(NamedTuple):
    """Rotations and exchanges that leave the BRDF as it is, and the signs (G, D) that they give the coordinates."""

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


@dataclass(frozen=True, eq=False, repr=False)
class ScatteredBrdf(Reflectance, Summary):
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
    _patches: Patches

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

    def summary(self) -> dict[str, Any]:
        """Return what `repr` says."""
        return {"name": self.name, "samples": len(self.measured.value), "leave_one_out": float(self.leave_one_out)}


def fit_scattered(samples: BrdfSamples, smoothing: float = 0.0, shape: Shape | None = None) -> Steps[ScatteredBrdf]:
    """The smooth BRDF through `samples`.

    `smoothing` ≥ 0 is added to the diagonal of the interpolation matrix, whose own diagonal is about 1: the result
    then minimises Σ (log residual)² + smoothing · ‖log f‖² in the norm of the kernel, and no longer meets the samples.
    `shape` is chosen by the samples where none is given. Takes 1 to 15 s; the generator returns the BRDF. Raises
    ValueError for a negative `smoothing`.
    """
    if not 0.0 <= smoothing < np.inf:
        raise ValueError(f"smoothing must be at least 0 and finite, not {smoothing}")
    values = samples.positive
    lit = values[values > 0.0]
    offset = max(_OFFSET * float(np.median(lit)), _MIN_OFFSET) if len(lit) else 1.0
    logs = np.log(values + offset)
    if shape is None:
        shape = yield from _choose_shape(samples, logs, smoothing)
    points, logs_kept, merged = _merge(coordinates(samples.wi, samples.wo, shape), logs, shape)
    mean = logs_kept.mean(axis=0)
    targets = logs_kept - mean
    tiles = list(boxes(points, shape.signs))
    fitted: list[Expansion] = []
    for number, box in enumerate(tiles):
        yield Step(0.4 + 0.6 * number / len(tiles), f"interpolation, box {number + 1} of {len(tiles)}")
        members = np.flatnonzero(box.weight(points) > 0.0)
        fitted.append(expand(points[members], targets[members], shape.signs, shape.smooth, smoothing, box, members))
    patches = Patches.of(points, fitted, shape.signs)
    residual = compute_blended_residual(points, fitted)
    predicted = np.clip(np.exp(logs_kept - residual) - offset, 0.0, values.max(axis=0))
    left_out_values = np.exp(logs_kept) - offset
    scale = float(np.linalg.norm(left_out_values))
    condition = max(expansion.condition for expansion in fitted)
    left_out = float(np.linalg.norm(predicted - left_out_values)) / scale if scale else 0.0
    left_out_log = float(np.sqrt((residual**2).mean()))
    figures = {
        "condition number": condition,
        "leave-one-out, relative": left_out,
        "leave-one-out, logarithmic": left_out_log,
        "samples merged": float(merged),
        "boxes": float(len(tiles)),
    }
    findings = []
    if condition > _ILL_CONDITIONED:
        text = f"the interpolation is ill-conditioned ({condition:.1e}); smoothing helps"
        findings.append(Finding(Verdict.WARNING, text))
    if merged:
        text = f"{merged} samples repeat the directions of another, or are its image by symmetry; their mean is kept"
        findings.append(Finding(Verdict.NOTE, text))
    health = samples.health.merge(Health(MappingProxyType(figures), tuple(findings)))
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


def _choose_shape(samples: BrdfSamples, logs: Floats, smoothing: float) -> Steps[Shape]:
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
            points, values, _ = _merge(coordinates(wi, wo, shape), targets, shape)
            tried = solve(kernel_matrix(points, shape.signs, smooth), values, smoothing)
            if tried is not None:
                errors.append((float(np.sqrt((tried.residual**2).mean())), shape))
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
    # Nothing can contradict isotropy if all light comes from one azimuth, not even samples of noise.
    return shown or borne or [SYMMETRIES[2]]


def _evidence(samples: BrdfSamples, symmetry: Symmetry) -> int | None:
    """Number of samples that have a partner of the same value at their place after the exchange of wi and wo.

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


def _merge(points: Floats, logs: Floats, shape: Shape) -> tuple[Floats, Floats, int]:
    """Points and values with those that the symmetries make one replaced by their mean, and how many go."""
    keys = _keys(points, shape.symmetry.signs)
    _, kept, place, counts = np.unique(keys, axis=0, return_index=True, return_inverse=True, return_counts=True)
    sums = np.zeros((len(kept), logs.shape[1]))
    np.add.at(sums, place, logs)
    return points[kept], sums / counts[:, None], len(points) - len(kept)

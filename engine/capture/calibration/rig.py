"""The rig that lit a capture: distance of its lamps, intensity of each, and room light, estimated from photographs.

A texel at the position p of the image (widths from its middle) whose albedo times normal is b has, under lamp i in the
direction l_i with the gain g_i, the radiance

    R_i = g_i b·v_i / |v_i|³ + b·a,    v_i = l_i − s p

where s is the inverse of the distance of the lamps in widths and a the room light. b is eliminated texel by texel by
weighted least squares (variable projection, Golub1973); s, log g_i and a follow by Gauss-Newton steps on what remains.
Weights leave out shadows and highlights: first by rank, then by Tukey's biweight, wider below than above.

The normal equations of the log gains are a diagonal less a product of rank three per texel, so that an iteration costs
one matrix product of (N, 3 T) with its transpose: 20 ms for 1500 texels of 64 photographs, and a tenth of it for the
texels.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import scalar
from engine.core.quickselect import nth_smallest
from engine.texel.kernel import (
    C_A,
    C_B,
    COLUMNS,
    DIFFUSE,
    ROUGHNESS,
    S_A,
    S_B,
    S_R,
    SPECULAR,
    VAR_ROUGHNESS,
    VAR_SPECULAR,
    C,
    S,
    differentiate,
    fit_texels,
    show_texels,
)

Array = NDArray[np.float64]

#: Models of a texel.
Kind = Literal["matte", "glossy"]

#: The terms that can be estimated.
TERMS = ("distance", "gains", "ambient")

#: Rounds of reweighting at most, Gauss-Newton steps in each, and the change of any term at which they end.
ROUNDS, STEPS, SETTLED = {"matte": 6, "glossy": 14}, {"matte": 2, "glossy": 1}, 2e-3

#: Biweight: deviations below and above the fit at which a photograph of a texel no longer counts.
BELOW, ABOVE = 4.0, 3.0

#: Prior deviations: of the inverse distance, of the logarithm of gains, and of room light over the lamps.
PRIOR_NEARNESS, PRIOR_GAIN, PRIOR_AMBIENT = 1.0, 0.7, 0.3

#: Largest inverse distance: a lamp at 0.8 widths.
MAX_NEARNESS = 1.25

#: Mean weight below which the gain of a lamp is not heard, and its largest logarithm over the others'.
UNHEARD, MAX_LOG_GAIN = 0.25, 2.0

#: Prior of glossy texels: mean and deviation of roughness, and of specular reflectance over the mean radiance; and the
#: least deviations of texels that are alike.
GLOSSY, MIN_SPREAD = np.array([0.5, 0.25, 0.3, 1.0]), (0.08, 0.5)

#: Texels whose numbers stay in the cache of a core with those of 64 photographs.
FEW_TEXELS = 32

#: Share of the photographs of a texel, those with the least residuals, that judge a fit.
JUDGED = 0.7


@dataclass(frozen=True, eq=False)
class Sample:
    """Texels of a capture.

    Attributes
    ----------
    values : (T, N) radiance of each texel over its mean over photographs.
    usable : (T, N) where it is not clipped.
    positions : (T, 2) right and up from the middle of the image, in widths of the image.
    brightness : (T,) the means.
    block : (T,) part of the image in which each texel lies, from 0.
    """

    values: Array
    usable: NDArray[np.bool_]
    positions: Array
    brightness: Array
    block: NDArray[np.int64]

    def of(self, chosen: NDArray[np.bool_]) -> Sample:
        """The texels `chosen` (T,)."""
        return Sample(
            self.values[chosen],
            self.usable[chosen],
            self.positions[chosen],
            self.brightness[chosen],
            self.block[chosen],
        )


@dataclass(frozen=True, eq=False)
class Rig:
    """Terms of a rig.

    Attributes
    ----------
    nearness : inverse of the distance of the lamps in widths of the image, 0 for distant ones.
    log_gains : (N,) logarithm of the intensity of each lamp over the geometric mean.
    ambient : (3,) room light as a vector, over the irradiance of a lamp.
    """

    nearness: float
    log_gains: Array
    ambient: Array

    @staticmethod
    def plain(count: int) -> Rig:
        """Distant, equal lamps in a dark room."""
        return Rig(0.0, np.zeros(count), np.zeros(3))


@dataclass(frozen=True, eq=False)
class Model:
    """Texels as they are fitted under a given rig.

    Attributes
    ----------
    values : (T, N) radiance.
    tangent : (T, N, k) its derivatives by the parameters of each texel.
    lit : (T, N) its part by lamps, which is its derivative by the logarithm of their gains.
    by_nearness : (T, N) its derivative by the inverse distance.
    albedo_normals : (T, 3) albedo times normal, its derivative by room light.
    alike : (4,) mean and deviation of roughness and of specular reflectance of glossy texels.
    """

    values: Array
    tangent: Array
    lit: Array
    by_nearness: Array
    albedo_normals: Array
    alike: Array | None = None


@dataclass(frozen=True, eq=False)
class Fit:
    """A rig fitted to a sample.

    Attributes
    ----------
    rig : the terms.
    model : the texels under it.
    weights : (T, N) of each photograph of each texel.
    covariance : (K, K) of nearness, ambient (3) and log gains (N), zero for terms that were not fitted; by the scatter
        of scores over blocks of the image, so that errors that neighbours share count.
    """

    rig: Rig
    model: Model
    weights: Array
    covariance: Array

    @property
    def albedo_normals(self) -> Array:
        """(T, 3) albedo times normal of each texel."""
        return self.model.albedo_normals


def lamp_vectors(directions: Array, positions: Array, nearness: float) -> Array:
    """(T, N, 3) irradiance of each texel by each lamp, as a vector towards the lamp."""
    towards = directions[None] - nearness * np.pad(positions, ((0, 0), (0, 1)))[:, None]
    return np.asarray(towards / (towards**2).sum(axis=-1, keepdims=True) ** 1.5)


def fit(sample: Sample, directions: Array, terms: Sequence[str], start: Rig | None = None, kind: Kind = "matte") -> Fit:
    """Fit `terms` of a rig whose lamps stand in `directions` (N, 3); the other terms are as in `start`.

    `kind` is the model of a texel: 'matte' or 'glossy'.
    """
    rig = start or Rig.plain(len(directions))
    weights = _rank(sample)
    free = _free(terms, len(directions))
    if kind == "matte" and not free.any():
        model = _matte(sample, directions, rig, weights, ROUNDS[kind])
        return Fit(rig, model, weights, np.zeros((len(free), len(free))))
    model = _model(sample, directions, rig, weights, kind)
    for _ in range(ROUNDS[kind]):
        heard, before, shown = free.copy(), rig, model.values
        if "gains" in terms:
            unheard = weights.sum(axis=0) < UNHEARD * sample.usable.sum(axis=0)
            rig = _with_unheard(sample, model, rig, unheard)
            heard[4:] &= ~unheard
        for _ in range(STEPS[kind] if free.any() else 0):
            rig, _, _ = _step(sample, model, rig, weights, heard)
            model = _model(sample, directions, rig, weights, kind, model)
        if kind == "glossy" and not free.any():
            model = _glossy(sample, directions, rig, model)
        weights = _biweights(sample, sample.values - model.values)
        if kind == "matte":  # glossy texels are weighted by their own fit
            model = _matte(sample, directions, rig, weights)
        elif np.abs(_state(rig) - _state(before)).max() < SETTLED and np.abs(model.values - shown).mean() < SETTLED:
            break
    covariance = np.zeros((len(free), len(free)))
    if free.any():
        _, inverse, scores = _step(sample, model, rig, weights, free)
        covariance[np.ix_(free, free)] = inverse @ (scores.T @ scores) @ inverse
    return Fit(rig, model, weights, covariance)


def _state(rig: Rig) -> Array:
    return np.array([rig.nearness, *rig.ambient, *rig.log_gains])


def _with_unheard(sample: Sample, model: Model, rig: Rig, unheard: NDArray[np.bool_]) -> Rig:
    """`rig` with gains of lamps that hardly a weight speaks for, by the median over texels: a lamp that is weaker or
    stronger than all others is everywhere at the end of the rank."""
    if not unheard.any():
        return rig
    lit = sample.usable & (model.values > 0.1) & (sample.values > 0.0)
    ratio = np.where(lit, sample.values / np.where(lit, model.values, 1.0), np.nan)
    log_gains = rig.log_gains.copy()
    for lamp in np.flatnonzero(unheard & (lit.sum(axis=0) > 10)):
        log_gains[lamp] += np.log(np.nanmedian(ratio[:, lamp]))
    return replace(rig, log_gains=np.clip(log_gains - log_gains.mean(), -MAX_LOG_GAIN, MAX_LOG_GAIN))


def measure_held_out(
    sample: Sample, directions: Array, rig: Rig, kind: Kind = "matte", found: Fit | None = None
) -> Array:
    """(T, N) residuals of photographs that are left out, each in turn, by the others of its texel."""
    if found is None:
        found = fit(sample, directions, (), rig, kind)
    weights, tangent = found.weights, found.model.tangent
    inverse, leverage = np.linalg.inv(_normal_matrix(tangent, weights)), np.empty(weights.shape)
    _find_leverage(np.ascontiguousarray(tangent), np.ascontiguousarray(weights), inverse, leverage)
    return np.asarray((sample.values - found.model.values) / np.maximum(1.0 - leverage, 0.05))


@scalar
def _find_leverage(tangent: np.ndarray, weights: np.ndarray, inverse: np.ndarray, leverage: np.ndarray) -> None:
    """Fill `leverage` (T, N), by which photographs move the fit of their texel, with w tᵀ M t; bound by arithmetic."""
    width = tangent.shape[2]
    for t in range(len(tangent)):
        for n in range(tangent.shape[1]):
            total = 0.0
            for i in range(width):
                moved = 0.0
                for j in range(width):
                    moved += inverse[t, i, j] * tangent[t, n, j]
                total += moved * tangent[t, n, i]
            leverage[t, n] = weights[t, n] * total


def typical(residuals: Array, usable: NDArray[np.bool_]) -> Array:
    """(T,) root mean square of the least `JUDGED` of the residuals of each texel, which shadows do not reach."""
    squares = np.sort(np.where(usable, residuals**2, np.inf), axis=1)
    count = np.maximum(1, (JUDGED * usable.sum(axis=1)).astype(np.int64))
    kept = np.arange(squares.shape[1])[None] < count[:, None]
    return np.asarray(np.sqrt(np.where(kept, squares, 0.0).sum(axis=1) / count))


def _model(
    sample: Sample, directions: Array, rig: Rig, weights: Array, kind: Kind, before: Model | None = None
) -> Model:
    """The model of the texels of `sample` that fits best under a given rig."""
    return _matte(sample, directions, rig, weights) if kind == "matte" else _glossy(sample, directions, rig, before)


def _matte(sample: Sample, directions: Array, rig: Rig, weights: Array, rounds: int = 0) -> Model:
    """Weighted least squares for the albedo times normal; in each of so many rounds, `weights` become those of what is
    left, and all is fitted anew."""
    shape = sample.values.shape
    found = Model(np.empty(shape), np.empty((*shape, 3)), np.empty(shape), np.empty(shape), np.empty((shape[0], 3)))
    values, usable, positions, towards, ambient = (
        np.ascontiguousarray(each) for each in (sample.values, sample.usable, sample.positions, directions, rig.ambient)
    )
    lamps = towards, np.exp(rig.log_gains), rig.nearness, ambient
    made = found.values, found.tangent, found.lit, found.by_nearness, found.albedo_normals
    _settle_matte(values, usable, weights, positions, *lamps, rounds, *made)
    return found


@scalar
def _settle_matte(
    values: np.ndarray,
    usable: np.ndarray,
    weights: np.ndarray,
    positions: np.ndarray,
    directions: np.ndarray,
    gains: np.ndarray,
    nearness: float,
    ambient: np.ndarray,
    rounds: int,
    shown: np.ndarray,
    tangent: np.ndarray,
    lit: np.ndarray,
    by_nearness: np.ndarray,
    found: np.ndarray,
) -> None:
    """`_fit_matte` and in each round `_weigh` before it, for so few texels at once that they stay in the cache."""
    left = np.empty((FEW_TEXELS, values.shape[1]))
    for first in range(0, len(values), FEW_TEXELS):
        last = min(first + FEW_TEXELS, len(values))
        for turn in range(rounds + 1):
            if turn > 0:
                for t in range(first, last):
                    for n in range(values.shape[1]):
                        left[t - first, n] = values[t, n] - shown[t, n]
                _weigh(left[: last - first], usable[first:last], weights[first:last])
            lamps = directions, gains, nearness, ambient
            made = shown[first:last], tangent[first:last], lit[first:last], by_nearness[first:last], found[first:last]
            _fit_matte(values[first:last], weights[first:last], positions[first:last], *lamps, *made)


@scalar
def _fit_matte(
    values: np.ndarray,
    weights: np.ndarray,
    positions: np.ndarray,
    directions: np.ndarray,
    gains: np.ndarray,
    nearness: float,
    ambient: np.ndarray,
    shown: np.ndarray,
    tangent: np.ndarray,
    lit: np.ndarray,
    by_nearness: np.ndarray,
    found: np.ndarray,
) -> None:
    """Fill the arrays of a `Model` texel by texel; bound by arithmetic, some 5 ns for each photograph of a texel."""
    count = len(directions)
    right_of, above = np.empty(count), np.empty(count)
    scale, squared = np.empty(count), np.empty(count)
    matrix, right = np.empty((3, 3)), np.empty(3)
    for t in range(len(values)):
        x, y = positions[t, 0], positions[t, 1]
        for n in range(count):  # loops that a CPU takes several lamps at once for
            across, along, up = directions[n, 0] - nearness * x, directions[n, 1] - nearness * y, directions[n, 2]
            right_of[n], above[n] = across, along
            squared[n] = across * across + along * along + up * up
            scale[n] = gains[n] / (squared[n] * np.sqrt(squared[n]))
        xx, xy, yy, xz, yz, zz, xv, yv, zv = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for n in range(count):
            tx = scale[n] * right_of[n] + ambient[0]
            ty = scale[n] * above[n] + ambient[1]
            tz = scale[n] * directions[n, 2] + ambient[2]
            tangent[t, n, 0], tangent[t, n, 1], tangent[t, n, 2] = tx, ty, tz
            wx, wy, wz = weights[t, n] * tx, weights[t, n] * ty, weights[t, n] * tz
            xx += wx * tx
            xy += wy * tx
            yy += wy * ty
            xz += wz * tx
            yz += wz * ty
            zz += wz * tz
            xv += wx * values[t, n]
            yv += wy * values[t, n]
            zv += wz * values[t, n]
        matrix[0, 0], matrix[1, 0], matrix[1, 1] = xx, xy, yy
        matrix[2, 0], matrix[2, 1], matrix[2, 2] = xz, yz, zz
        right[0], right[1], right[2] = xv, yv, zv
        _solve_three(matrix, right, found[t])
        bx, by, bz = found[t, 0], found[t, 1], found[t, 2]
        room = ambient[0] * bx + ambient[1] * by + ambient[2] * bz
        level = x * bx + y * by
        for n in range(count):
            lamps = scale[n] * (right_of[n] * bx + above[n] * by + directions[n, 2] * bz)
            shown[t, n], lit[t, n] = lamps + room, lamps
            towards = lamps * (right_of[n] * x + above[n] * y)
            by_nearness[t, n] = 3.0 * towards / squared[n] - scale[n] * level


@scalar
def _solve_three(matrix: np.ndarray, right: np.ndarray, out: np.ndarray) -> None:
    """Solve normal equations of three unknowns, of which the lower triangle is given, by Cholesky's decomposition."""
    ridge = 1e-7 * (matrix[0, 0] + matrix[1, 1] + matrix[2, 2]) + 1e-12
    for i in range(3):
        matrix[i, i] += ridge
        for j in range(i + 1):
            for k in range(j):
                matrix[i, j] -= matrix[i, k] * matrix[j, k]
            matrix[i, j] = np.sqrt(matrix[i, i]) if i == j else matrix[i, j] / matrix[j, j]
    for i in range(3):
        out[i] = right[i]
        for k in range(i):
            out[i] -= matrix[i, k] * out[k]
        out[i] /= matrix[i, i]
    for i in range(2, -1, -1):
        for k in range(i + 1, 3):
            out[i] -= matrix[k, i] * out[k]
        out[i] /= matrix[i, i]


def _glossy(sample: Sample, directions: Array, rig: Rig, before: Model | None) -> Model:
    """The texels of `engine.texel.kernel`, with slopes, roughness, a diffuse and a specular reflectance each.

    What `before` says of the room light is taken off first. The roughness and the specular reflectance that texels
    have in common are the prior of those in which no highlight is seen.
    """
    normals = np.zeros((len(sample.values), 3)) if before is None else before.albedo_normals
    room = (normals @ rig.ambient)[:, None]
    values = np.ascontiguousarray(np.repeat((sample.values - room).T[..., None], 3, axis=-1), np.float32)
    usable, gains = np.ascontiguousarray(sample.usable.T), np.exp(rig.log_gains)

    def lights(nearness: float) -> Array:
        vectors = lamp_vectors(directions, sample.positions, nearness) if nearness else directions[None]
        return np.ascontiguousarray((gains[None, :, None] * vectors).swapaxes(0, 1))

    found = np.zeros((len(sample.values), COLUMNS))
    alike = GLOSSY if before is None or before.alike is None else before.alike
    kind, lit = np.zeros(len(found), np.int64), lights(rig.nearness)
    fit_texels(values, usable, lit, np.ones((len(directions), 2)), True, alike[None], kind, False, found)
    own = np.empty((len(found), 7, len(directions)))
    differentiate(found[:, :2], found[:, ROUGHNESS], lit, own)
    diffuse, specular = found[:, DIFFUSE, None], found[:, SPECULAR, None]
    shown = diffuse * own[:, C] + specular * own[:, S]
    tangent = [own[:, C], own[:, S], diffuse * own[:, C_A] + specular * own[:, S_A]]
    tangent += [diffuse * own[:, C_B] + specular * own[:, S_B], specular * own[:, S_R]]
    moved, step = np.empty((len(directions), len(found), 3), np.float32), 1e-3
    texels = found[:, :2], found[:, ROUGHNESS], np.repeat(diffuse, 3, axis=1), np.repeat(specular, 3, axis=1)
    show_texels(*texels, lights(rig.nearness + step), moved)
    normals = np.column_stack([found[:, :2], np.ones(len(found))])
    normals *= (diffuse + specular) / np.linalg.norm(normals, axis=1, keepdims=True)
    return Model(
        shown + (normals @ rig.ambient)[:, None],
        np.stack(tangent, axis=-1),
        shown,
        (moved[..., 0].T - shown) / step,
        normals,
        _alike(found),
    )


def _alike(found: Array) -> Array:
    """Mean and deviation of roughness and specular reflectance of texels that tell theirs, the prior of all."""
    made = GLOSSY.copy()
    for place, (column, variance) in enumerate(((ROUGHNESS, VAR_ROUGHNESS), (SPECULAR, VAR_SPECULAR))):
        known = np.isfinite(found[:, variance]) & (found[:, variance] < 0.25 * GLOSSY[2 * place + 1] ** 2)
        if known.sum() >= 20:
            middle = float(np.median(found[known, column]))
            spread = 1.4826 * float(np.median(np.abs(found[known, column] - middle)))
            made[2 * place : 2 * place + 2] = middle, max(spread, MIN_SPREAD[place])
    return made


def _normal_matrix(tangent: Array, weights: Array) -> Array:
    matrix = (tangent * weights[..., None]).swapaxes(1, 2) @ tangent
    trace = np.einsum("tii->t", matrix)
    matrix += (1e-7 * trace + 1e-12)[:, None, None] * np.eye(tangent.shape[-1])
    return np.asarray(matrix)


def _free(terms: Sequence[str], count: int) -> NDArray[np.bool_]:
    unknown = set(terms) - set(TERMS)
    if unknown:
        raise ValueError(f"unknown terms {sorted(unknown)}; choose from {', '.join(TERMS)}")
    return np.array(["distance" in terms, *["ambient" in terms] * 3, *["gains" in terms] * count])


def _rank(sample: Sample) -> Array:
    """Weights (T, N) without the darkest and the brightest fifth of each texel."""
    usable = sample.usable
    number = usable.sum(axis=1)
    tail = np.where(number - 2 * (number // 5) >= 4, number // 5, 0)
    order = np.argsort(np.where(usable, sample.values, np.inf), axis=1)
    rank = np.empty_like(order)
    np.put_along_axis(rank, order, np.arange(order.shape[1])[None], axis=1)
    return np.asarray((rank >= tail[:, None]) & (rank < (number - tail)[:, None]), np.float64)


def _biweights(sample: Sample, residuals: Array) -> Array:
    """(T, N) Tukey's biweights, by the median of the usable residuals of each texel."""
    weights = np.empty(residuals.shape)
    _weigh(np.ascontiguousarray(residuals), np.ascontiguousarray(sample.usable), weights)
    return weights


@scalar
def _weigh(residuals: np.ndarray, usable: np.ndarray, weights: np.ndarray) -> None:
    """Fill weights (T, N) texel by texel; bound by the medians, some 10 ns for each photograph of a texel."""
    count = residuals.shape[1]
    sizes = np.empty(count)
    for t in range(len(residuals)):
        known = 0
        for n in range(count):
            if usable[t, n]:
                sizes[known] = abs(residuals[t, n])
                known += 1
        deviation = 2e-3
        if known > 0:
            upper = nth_smallest(sizes, known, known // 2)
            lower = upper if known % 2 else sizes[: known // 2].max()  # which holds none that is larger
            deviation = max(1.4826 * 0.5 * (lower + upper), deviation)
        for n in range(count):
            off = residuals[t, n] / (deviation * (BELOW if residuals[t, n] < 0.0 else ABOVE))
            rest = 1.0 - off * off
            weights[t, n] = rest * rest if usable[t, n] and abs(off) < 1.0 else 0.0


def _step(sample: Sample, model: Model, rig: Rig, weights: Array, free: NDArray[np.bool_]) -> tuple[Rig, Array, Array]:
    """A Gauss-Newton step: the rig, the inverse of its normal equations, and scores (blocks, K) of free parameters."""
    count = len(rig.log_gains)
    width = model.tangent.shape[-1]
    along_gains, along = np.empty((len(weights), width, count)), np.empty((len(weights), width, 4))
    dense, across, squares_of_lit = np.zeros((4, 4)), np.zeros((4, count)), np.zeros(count)
    scores = np.zeros((int(sample.block.max()) + 1, 4 + count))
    values, weights, shown, tangent, lit, by_nearness = (
        np.ascontiguousarray(each)
        for each in (sample.values, weights, model.values, model.tangent, model.lit, model.by_nearness)
    )
    texels = values, weights, shown, tangent, lit, by_nearness, np.ascontiguousarray(model.albedo_normals), sample.block
    squares = _eliminate(*texels, along_gains, along, dense, across, squares_of_lit, scores)
    if not np.isfinite(along).all():
        raise np.linalg.LinAlgError("the normal equations of a texel are singular")
    flat_gains, flat_dense = along_gains.reshape(-1, count), along.reshape(-1, 4)
    normal = np.empty((4 + count, 4 + count))
    normal[:4, :4] = dense - flat_dense.T @ flat_dense
    normal[:4, 4:] = across - flat_dense.T @ flat_gains
    normal[4:, :4] = normal[:4, 4:].T
    normal[4:, 4:] = np.diag(squares_of_lit) - flat_gains.T @ flat_gains
    freedom = weights.sum() - width * len(weights)
    variance = float(squares / max(freedom, 1.0)) + 1e-12
    prior = variance / np.array([PRIOR_NEARNESS**2, *[PRIOR_AMBIENT**2] * 3, *[PRIOR_GAIN**2] * count])
    state = _state(rig)
    normal += np.diag(prior)
    normal[4:, 4:] += float(np.abs(np.diag(normal)[4:]).mean())  # the mean of log gains is that of the albedo
    gradient = scores.sum(axis=0) - prior * state
    inverse = np.asarray(np.linalg.inv(normal[np.ix_(free, free)]), np.float64)
    state[free] += np.clip(inverse @ gradient[free], -0.3, 0.3)
    log_gains = np.clip(state[4:] - state[4:].mean(), -MAX_LOG_GAIN, MAX_LOG_GAIN)
    nearness = float(np.clip(state[0], 0.0, MAX_NEARNESS))
    return replace(rig, nearness=nearness, ambient=state[1:4], log_gains=log_gains), inverse, scores[:, free]


@scalar
def _eliminate(
    values: np.ndarray,
    weights: np.ndarray,
    shown: np.ndarray,
    tangent: np.ndarray,
    lit: np.ndarray,
    by_nearness: np.ndarray,
    albedo_normals: np.ndarray,
    block: np.ndarray,
    along_gains: np.ndarray,
    along: np.ndarray,
    dense: np.ndarray,
    across: np.ndarray,
    squares_of_lit: np.ndarray,
    scores: np.ndarray,
) -> float:
    """Eliminate the parameters of texels from normal equations; the sum of squares of what is left of the photographs.

    With the derivatives d (4) of the values of a photograph by nearness and ambient and l by its gain, times the roots
    of weights, and the orthonormal basis q (k) of the tangent: `along_gains` (T, k, N) is filled with q l, `along`
    (T, k, 4) with Σ q dᵀ; `dense` (4, 4) grows by Σ d dᵀ, `across` (4, N) by d l, `squares_of_lit` (N,) by l², and
    `scores` (blocks, 4 + N) by the products of d and l with what is left. Bound by arithmetic, some 15 ns for each
    photograph of a matte texel.
    """
    count, width = values.shape[1], tangent.shape[2]
    matrix, basis = np.empty((width, width)), np.empty((width, count))
    root, left, of_lit, by = np.empty(count), np.empty(count), np.empty(count), np.empty(count)
    total = 0.0
    for t in range(values.shape[0]):
        of_block, normal = scores[block[t]], albedo_normals[t]
        matrix[...] = 0.0
        for n in range(count):
            root[n] = np.sqrt(weights[t, n])
            left[n], of_lit[n] = root[n] * (values[t, n] - shown[t, n]), root[n] * lit[t, n]
            by[n] = root[n] * by_nearness[t, n]
            for i in range(width):
                weighted = weights[t, n] * tangent[t, n, i]
                for j in range(i + 1):
                    matrix[i, j] += weighted * tangent[t, n, j]
        trace = 0.0
        for i in range(width):
            trace += matrix[i, i]
        for i in range(width):  # Cholesky's decomposition
            matrix[i, i] += 1e-7 * trace + 1e-12
            for j in range(i + 1):
                for k in range(j):
                    matrix[i, j] -= matrix[i, k] * matrix[j, k]
                matrix[i, j] = np.sqrt(matrix[i, i]) if i == j else matrix[i, j] / matrix[j, j]
        for i in range(width):
            scale = 1.0 / matrix[i, i]
            for n in range(count):
                basis[i, n] = root[n] * tangent[t, n, i]
            for j in range(i):
                for n in range(count):
                    basis[i, n] -= matrix[i, j] * basis[j, n]
            for n in range(count):
                basis[i, n] *= scale
                along_gains[t, i, n] = basis[i, n] * of_lit[n]
        for i in range(width):
            of_left, of_by, of_root = 0.0, 0.0, 0.0
            for n in range(count):
                of_left += basis[i, n] * left[n]
                of_by += basis[i, n] * by[n]
                of_root += basis[i, n] * root[n]
            along[t, i, 0] = of_by
            for axis in range(3):
                along[t, i, 1 + axis] = normal[axis] * of_root
            for n in range(count):
                left[n] -= basis[i, n] * of_left
        squares, weight, by_left, root_left, by_root, by_by = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for n in range(count):
            squares += left[n] * left[n]
            weight += weights[t, n]
            by_left += by[n] * left[n]
            root_left += root[n] * left[n]
            by_root += by[n] * root[n]
            by_by += by[n] * by[n]
        for n in range(count):
            squares_of_lit[n] += of_lit[n] * of_lit[n]
            of_block[4 + n] += of_lit[n] * left[n]
            across[0, n] += by[n] * of_lit[n]
            for axis in range(3):
                across[1 + axis, n] += normal[axis] * root[n] * of_lit[n]
        total += squares
        dense[0, 0] += by_by
        of_block[0] += by_left
        for axis in range(3):
            of_block[1 + axis] += normal[axis] * root_left
            dense[0, 1 + axis] += normal[axis] * by_root
            dense[1 + axis, 0] = dense[0, 1 + axis]
            for other in range(3):
                dense[1 + axis, 1 + other] += normal[axis] * normal[other] * weight
    return total

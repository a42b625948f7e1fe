"""Alignment of a whole light arc at once: what photographs of one surface span tells camera motion from shading.

Without shadows a diffuse surface under a moving distant lamp spans few images (three, and two along one arc: Shashua
1997; Basri2003), and a photograph that is out of place leaves that span. All motions are therefore found
together, as those that leave least outside the best span of rank `RANK` (in the spirit of RASL, Peng2012), by
Gauss-Newton steps on the trailing singular values (variable projection, Kaufman's approximation), coarse to fine.
With Y the aligned images as columns, P and Q the projections on their leading left and right singular vectors and G
the derivatives of the images by their parameters, a step solves

    [(G_a . (I - P) G_b) (I - Q)_ij] step = - G_a . Y (I - Q)_i     for parameters a of image i, b of image j,

for which the inner products of Y and G are enough. Pixels that the span explains badly (edges of shadows, gloss) count
less.

No image shows shading drift: relief seems to move towards the lamp as the lamp sinks; `without_shading_drift` takes
that off.
Cost: about a second of CPU time per photograph at one megapixel with Euclidean motion.

Separation of the motions along a light arc into knocks of the camera and shading drift.

Relief seems to drift towards the lamp as the lamp sinks, along a smooth curve from light to light, mostly along the
lamp's azimuth. A motion is therefore taken for the sum of a jump, independent from photograph to photograph (hands,
knocks), a drift, which is a Gaussian process over the distance between lights (zero for equal lights; its size is free
along each axis), and a small error. Sizes are not chosen but averaged over, each weighted by how likely it makes what
was seen. Where the data are not clearly likelier with jumps than without, all is left alone.

Jumps are first drawn from one normal distribution: a camera that moves at each photograph. If one of them is far out
when they are drawn from Student's distribution instead, few photographs were moved, and that is used: it leaves the
others nearly alone.

A camera that moves as smoothly as the shading does cannot be told from it, and the standard deviation of the jumps says
how far.
Cost: some 0.1 s for ten photographs, growing with the cube of their number.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.core.steps import Step, Steps, part

#: Sizes of drift that are tried (pixels of the compared images), the usual one, and by what power of e others differ.
_DRIFTS_PX = np.array([0.05, 0.1, 0.2, 0.4, 0.8, 1.6])
_USUAL_DRIFT_PX, _DRIFT_SPREAD = 0.8, 1.0
#: Distance between lights over which drift changes, and the shortest where few photographs were moved: motion that
#: drift could explain there is not taken for a knock.
_DRIFT_LENGTH, _FASTEST_DRIFT = 0.6, 0.4
#: Error of a single motion that is well determined.
_NOISE_PX = 0.03
#: Sizes of jumps that are tried, and by what power of e they must be likelier than none.
_JUMPS_PX = np.array([0.0, *np.geomspace(0.02, 300.0, 30)])
_MIN_EVIDENCE = 10.0
#: Degrees of freedom of Student's distribution, steps towards it, and a variance that is far out, in usual ones.
_FREEDOM, _STEPS, _FAR_OUT = 1.0, 8, 15.0


class _Jumps(NamedTuple):
    """Expected jumps relative to the reference and their variance, both (N, P); what each (N,) of them is squared, in
    units of the usual jump, added over P; by what power of e jumps are likelier than none."""

    expected: Matrix
    variance: Matrix
    square: Matrix
    evidence: float


def without_shading_drift(moved: Matrix, distance: Matrix, reference: int) -> tuple[Matrix, Matrix]:
    """The part of motions (N, P) in pixels relative to the photograph `reference` that jumps from light to light.

    `distance` (N,) is how far the light has changed up to each photograph. Returned are the expected jumps relative
    to that of the reference and their standard deviation (N,), of each of the P parameters. Both are zero where nothing
    moved; jumps that are smaller than their standard deviation are taken for none.
    """
    count, parameters = moved.shape
    weight = np.ones(count)
    apart = distance[:, None] - distance
    jumps = _expect(moved, apart / _DRIFT_LENGTH, reference, weight)
    if jumps.evidence < _MIN_EVIDENCE:
        return np.zeros_like(moved), np.zeros(count)
    few = jumps
    for _ in range(_STEPS):
        weight = (_FREEDOM + few.square) / (_FREEDOM + parameters)
        few = _expect(moved, apart / _FASTEST_DRIFT, reference, weight)
    chosen = few if weight.max() > _FAR_OUT else jumps
    doubt = np.sqrt(chosen.variance.mean(axis=1))
    known = (chosen.expected**2).mean() > (doubt**2).mean()
    return chosen.expected * known, doubt


def _expect(moved: Matrix, apart: Matrix, reference: int, weight: Matrix) -> _Jumps:
    """Jumps of the variances `weight` (N,) times one that is averaged over, as the size of drift is.

    `apart` (N, N) is the distance between lights in lengths over which drift changes.

    Arrays have the axes (sizes of jumps, sizes of drift, photographs, parameters) as far as they need them.
    """
    count = len(moved)
    to_reference = np.delete(np.eye(count), reference, axis=0)
    to_reference[:, reference] -= 1.0
    seen = np.delete(moved, reference, axis=0)
    smooth, noise = (to_reference @ one @ to_reference.T for one in (np.exp(-0.5 * apart**2), np.eye(count)))
    jump = to_reference * weight
    size = (_JUMPS_PX**2)[:, None, None, None]
    covariance = size * (jump @ to_reference.T) + (_DRIFTS_PX**2)[:, None, None] * smooth + _NOISE_PX**2 * noise
    both = np.hstack([seen, jump])
    solved = np.linalg.solve(covariance, np.broadcast_to(both, (*covariance.shape[:2], *both.shape)))
    explained, shrunk = np.split(solved, [seen.shape[1]], axis=-1)
    usual = -0.5 * (np.log(_DRIFTS_PX / _USUAL_DRIFT_PX) / _DRIFT_SPREAD) ** 2
    likely = -0.5 * ((explained * seen).sum(axis=2) + np.linalg.slogdet(covariance)[1][..., None]) + usual[:, None]
    by_size = np.logaddexp.reduce(likely, axis=1).sum(axis=1)
    share = (_shares(by_size[1:])[:, None, None] * _shares(likely[1:], axis=1))[:, :, None]
    size, explained, shrunk = size[1:], explained[1:], shrunk[1:]
    mean = size * (jump.T @ explained)
    spread = size * np.diag(weight) - size**2 * (jump.T @ shrunk)
    own = np.diagonal(spread, axis1=2, axis2=3)[..., None]
    relative = mean - mean[:, :, reference, None]
    doubt = own - 2.0 * spread[..., reference, None] + own[:, :, reference, None]
    expected = (share * relative).sum(axis=(0, 1))
    variance = (share * (doubt + relative**2)).sum(axis=(0, 1)) - expected**2
    square = (share * (mean**2 + own) / size).sum(axis=(0, 1, 3))
    return _Jumps(expected, np.maximum(variance, 0.0), square, float(by_size[1:].max() - by_size[0]))


def _shares(likely: Matrix, axis: int = 0) -> Matrix:
    """Probabilities from their logarithms up to a constant along `axis`."""
    raised = np.exp(likely - likely.max(axis=axis, keepdims=True))
    shares: Matrix = raised / raised.sum(axis=axis, keepdims=True)
    return shares


Grey = NDArray[np.float32]
Matrix = NDArray[np.float64]

#: Images that the span is made of, and the fewest photographs that say something about their motion beyond it.
RANK, MIN_PHOTOGRAPHS = 2, 5

#: With more than this share in one image the lights are alike, and a second image would only hide a knock.
_ONE_LIGHT = 0.97

#: Derivatives of (x, y, 1) by the parameters of each motion, in coordinates where the image's half-diagonal is 1.
_SHIFTS = [(0, 2), (1, 2)]
_ENTRIES = {"translation": _SHIFTS, "affine": [*_SHIFTS, (0, 0), (0, 1), (1, 0), (1, 1)]}
_ENTRIES["homography"] = [*_ENTRIES["affine"], (2, 0), (2, 1)]
_ITERATIONS = (6, 4, 2)
_LEVELS = 3
_MIN_SIDE = 64
_MARGIN = 8
_BAND_ROWS = 64
_LARGEST_WORK = 1.2e10


@dataclass(frozen=True, eq=False)
class ArcMotion:
    """Motions of N photographs relative to `reference`, before shading drift is taken off.

    Attributes
    ----------
    matrix : (N, 3, 3) from pixels of the reference to pixels of each photograph.
    product : (N, N) inner products of the aligned, band-passed images of unit energy.
    """

    matrix: Matrix
    product: Matrix


def arc_motion(images: Sequence[Grey], start: Matrix, reference: int, motion: str, note: str) -> Steps[ArcMotion]:
    """Find the motions (N, 3, 3) of all `images` (luminance, linear in radiance) together from `start`."""
    basis = _basis(motion)
    matrix = start.copy()
    product = np.eye(len(images))
    for level in range(_LEVELS - 1, -1, -1):
        factor = 2**level
        if min(images[0].shape) // factor < _MIN_SIDE and level > 0:
            continue
        work = (len(images) * (1 + len(basis))) ** 2 * images[0].size / factor**2
        if work > _LARGEST_WORK and level < _LEVELS - 1:
            break
        photographs = [band_passed(image, factor) for image in images]
        small = np.stack([_scale(one, 1 / factor) for one in matrix])
        weight = np.ones(photographs[0].shape, np.float32)
        for iteration in range(_ITERATIONS[_LEVELS - 1 - level]):
            before = (_LEVELS - 1 - level + iteration / _ITERATIONS[0]) / _LEVELS
            system = _inner_products(photographs, small, basis, weight, note)
            product, kept, weight = yield from part(system, before, before + 0.5 / _LEVELS)
            small = _step(small, kept, basis, reference, photographs[0].shape, motion)
        matrix = np.stack([_scale(one, factor) for one in small])
    return ArcMotion(matrix, product[: len(images), : len(images)])


def light_distance(product: Matrix) -> NDArray[np.float64]:
    """(N,) how far the light has changed up to each photograph: the sines between neighbours, added up."""
    cosine = np.array(
        [product[i, i + 1] / np.sqrt(product[i, i] * product[i + 1, i + 1]) for i in range(len(product) - 1)]
    )
    return np.concatenate([[0.0], np.cumsum(np.sqrt(np.clip(1.0 - cosine**2, 0.0, 1.0)))])


def one_light(photographs: Sequence[Grey], matrix: Matrix) -> bool:
    """True if the aligned images (of `band_passed`) are so alike that no shading can imitate motion."""
    size = photographs[0].shape[::-1]
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    seen = _mask_seen_by_all(matrix, photographs[0].shape).ravel()
    moved = [cv2.warpPerspective(one, m, size, flags=flags).ravel() for one, m in zip(photographs, matrix, strict=True)]
    table = np.stack(moved) * seen
    values = np.linalg.eigvalsh((table @ table.T).astype(np.float64))
    return bool(values[-1] > _ONE_LIGHT * values.sum())


def predict(photographs: Sequence[Grey], matrix: Matrix) -> Steps[tuple[list[Grey], NDArray[np.float64]]]:
    """Each aligned image (of `band_passed`) as the best mixture of all others, and its correlation with that."""
    size = photographs[0].shape[::-1]
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    table = np.empty((len(photographs), photographs[0].size), np.float32)
    for index, (photograph, motion) in enumerate(zip(photographs, matrix, strict=True)):
        yield Step(0.5 * index / len(photographs), "Checking the alignment")
        table[index] = cv2.warpPerspective(
            photograph, motion, size, flags=flags, borderMode=cv2.BORDER_REPLICATE
        ).ravel()
    product = (table @ table.T).astype(np.float64)
    product += np.diag(1e-6 * np.diag(product) + 1e-30)
    mixtures, correlation = [], np.zeros(len(photographs))
    for index in range(len(photographs)):
        yield Step(0.5 + 0.5 * index / len(photographs), "Checking the alignment")
        others = np.flatnonzero(np.arange(len(photographs)) != index)
        share = np.linalg.solve(product[np.ix_(others, others)], product[others, index])
        correlation[index] = np.sqrt(np.clip(share @ product[others, index] / product[index, index], 0.0, 1.0))
        mixture = share.astype(np.float32) @ table[others]
        mixtures.append(mixture.reshape(photographs[0].shape))
    return mixtures, correlation


def jumps(
    motion_found: ArcMotion, reference: int, motion: str, shape: tuple[int, ...]
) -> tuple[Matrix, NDArray[np.float64]]:
    """(N, 3, 3) what remains of the motions without drift, of the same kind of motion; how far off (N,) in pixels,
    as a standard deviation, the shifts may be because drift cannot be separated from them."""
    basis = _basis(motion)
    unit = _unit(shape)
    size = unit[0, 0]
    normal = np.linalg.inv(unit) @ motion_found.matrix @ unit
    normal /= normal[:, 2:, 2:]
    energy = (basis**2).sum(axis=(1, 2))
    moved = size * np.einsum("nij,pij->np", normal - np.eye(3), basis) / energy
    distance = light_distance(motion_found.product)
    shifts, doubt = without_shading_drift(moved[:, :2], distance, reference)
    kept = np.hstack([shifts, without_shading_drift(moved[:, 2:], distance, reference)[0]]) / size
    matrix = np.stack([unit @ _motion_of(one, basis, motion) @ np.linalg.inv(unit) for one in kept])
    return matrix, np.sqrt(2.0) * doubt


def _basis(motion: str) -> Matrix:
    """(parameters, 3, 3) generators of the motion; the first two are the shifts."""
    if motion == "euclidean":
        turn = np.zeros((3, 3, 3))
        turn[0, 0, 2] = turn[1, 1, 2] = turn[2, 1, 0] = 1.0
        turn[2, 0, 1] = -1.0
        return turn
    entries = _ENTRIES[motion]
    basis = np.zeros((len(entries), 3, 3))
    for number, entry in enumerate(entries):
        basis[number][entry] = 1.0
    return basis


def _motion_of(parameters: NDArray[np.float64], basis: Matrix, motion: str) -> Matrix:
    """The motion with these parameters, near the identity; a Euclidean one is a true turn."""
    matrix = np.eye(3) + np.tensordot(parameters, basis, 1)
    if motion == "euclidean":
        matrix[:2, :2] /= np.hypot(matrix[0, 0], matrix[1, 0])
    return matrix


def _unit(shape: tuple[int, ...]) -> Matrix:
    """From coordinates about the middle, in half-diagonals, to pixels."""
    height, width = shape
    half = 0.5 * float(np.hypot(height, width))
    return np.array([[half, 0, (width - 1) / 2], [0, half, (height - 1) / 2], [0, 0, 1.0]])


def _scale(matrix: Matrix, factor: float) -> Matrix:
    """The same motion in pixels of an image `factor` times as large (pixel centres at integers)."""
    offset = (factor - 1) / 2
    scale = np.array([[factor, 0, offset], [0, factor, offset], [0, 0, 1.0]])
    return scale @ matrix @ np.linalg.inv(scale)


def band_passed(image: Grey, factor: int = 1) -> Grey:
    """Details of one to twelve pixels of the image reduced by `factor`, of unit energy."""
    height, width = (size // factor for size in image.shape)
    small = image[: height * factor, : width * factor]
    if factor > 1:
        small = cv2.resize(small, (width, height), interpolation=cv2.INTER_AREA)
    detail = cv2.GaussianBlur(small, (0, 0), 1.0) - cv2.GaussianBlur(small, (0, 0), 12.0)
    deviation = float(detail.std(dtype=np.float64))
    return detail / np.float32(deviation) if deviation > 0.0 else detail


def _inner_products(
    photographs: Sequence[Grey], matrix: Matrix, basis: Matrix, weight: Grey, note: str
) -> Steps[tuple[Matrix, tuple[Matrix, Matrix], Grey]]:
    """Inner products of the aligned images; (hessian, gradient) of a step; the weights for the next one."""
    height, width = photographs[0].shape
    count, parameters = len(photographs), len(basis)
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    slopes = []
    for index, (photograph, motion) in enumerate(zip(photographs, matrix, strict=True)):
        yield Step(0.5 * index / count, note)
        moved = cv2.warpPerspective(photograph, motion, (width, height), flags=flags, borderMode=cv2.BORDER_REPLICATE)
        slopes.append((moved, *(cv2.Sobel(moved, cv2.CV_32F, axis, 1 - axis, scale=1 / 8) for axis in (1, 0))))
    seen = _mask_seen_by_all(matrix, (height, width))
    inverse = np.linalg.inv(_unit((height, width))).astype(np.float64)
    product = np.zeros((count * (1 + parameters), count * (1 + parameters)))
    inside = np.s_[_MARGIN : width - _MARGIN]
    bands = range(_MARGIN, height - _MARGIN, _BAND_ROWS)
    for first in bands:
        yield Step(0.5 + 0.5 * first / height, note)
        rows = np.s_[first : min(first + _BAND_ROWS, height - _MARGIN), inside]
        y, x = (place.astype(np.float32) for place in np.mgrid[rows])
        flow = _flow(basis, inverse, x, y)
        columns = [moved[rows].ravel() for moved, _, _ in slopes]
        columns += [(across[rows] * one[0] + down[rows] * one[1]).ravel() for _, across, down in slopes for one in flow]
        table = np.stack(columns)
        product += (table * (weight * seen)[rows].ravel()) @ table.T
    values, vectors = np.linalg.eigh(product[:count, :count])
    rank = 1 if values[-1] > _ONE_LIGHT * values.sum() else RANK
    leading, strength = vectors[:, -rank:], np.maximum(values[-rank:], 1e-12 * values[-1] + 1e-30)
    outside = np.eye(count) - leading @ leading.T
    among = product[count:, :count] @ leading / np.sqrt(strength)
    hessian = (product[count:, count:] - among @ among.T) * np.kron(outside, np.ones((parameters, parameters)))
    gradient = np.einsum("kn,nk->k", product[count:, :count], np.repeat(outside, parameters, axis=1))
    return product[:count, :count], (hessian, gradient), _weights([moved for moved, _, _ in slopes], outside)


def _mask_seen_by_all(matrix: Matrix, shape: tuple[int, ...]) -> Grey:
    """1 where all images have data, else 0; 1 everywhere where they share less than a quarter of the frame."""
    row, column = np.mgrid[: shape[0], : shape[1]].astype(np.float32)
    inside = np.ones(shape, np.bool_)
    for one in matrix.astype(np.float32):
        depth = one[2, 0] * column + one[2, 1] * row + one[2, 2]
        x, y = ((one[k, 0] * column + one[k, 1] * row + one[k, 2]) / depth for k in (0, 1))
        inside &= (x >= 2) & (y >= 2) & (x <= shape[1] - 3) & (y <= shape[0] - 3)
    return np.where(inside | (inside.mean() < 0.25), np.float32(1), np.float32(0))


def _flow(basis: Matrix, inverse: Matrix, x: Grey, y: Grey) -> NDArray[np.float32]:
    """(parameters, 2, h, w) how a point moves with each parameter, in half-diagonals."""
    u, v = (
        np.float32(inverse[0, 0]) * x + np.float32(inverse[0, 2]),
        np.float32(inverse[1, 1]) * y + np.float32(inverse[1, 2]),
    )
    place = np.stack([u, v, np.ones_like(u)])
    moved = np.tensordot(basis.astype(np.float32), place, axes=(2, 0))
    flow: NDArray[np.float32] = moved[:, :2] - moved[:, 2:] * place[:2]
    return flow


def _weights(moved: Sequence[Grey], outside: Matrix) -> Grey:
    """1 / (1 + r^2 / 2 m) for the squared distance r^2 of a pixel to the span and its median m."""
    stack = np.stack([one.ravel() for one in moved])
    squared = ((outside.astype(np.float32) @ stack) ** 2).sum(axis=0)
    middle = np.float32(2.0 * float(np.median(squared)) + 1e-12)
    weight: Grey = (1.0 / (1.0 + squared / middle)).astype(np.float32).reshape(moved[0].shape)
    return weight


def _step(
    matrix: Matrix, system: tuple[Matrix, Matrix], basis: Matrix, reference: int, shape: tuple[int, ...], motion: str
) -> Matrix:
    """The motions after one step of at most three pixels; the reference stays."""
    hessian, gradient = system
    count, parameters = len(matrix), len(basis)
    free = np.flatnonzero(np.repeat(np.arange(count) != reference, parameters))
    among = hessian[np.ix_(free, free)]
    among += np.diag(1e-9 * np.diag(among) + 1e-30)
    step = np.zeros(count * parameters)
    step[free] = -np.linalg.lstsq(among, gradient[free], rcond=1e-12)[0]
    unit = _unit(shape)
    size = unit[0, 0]
    steps = np.clip(step, -3.0, 3.0).reshape(count, parameters) / size
    changes = [unit @ _motion_of(one, basis, motion) @ np.linalg.inv(unit) for one in steps]
    moved = np.stack([one @ change for one, change in zip(matrix, changes, strict=True)])
    return moved / moved[:, 2:, 2:]

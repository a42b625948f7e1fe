"""Alignment of a whole light arc at once: what photographs of one surface span tells camera motion from shading.

Without shadows a diffuse surface under a moving distant lamp spans few pictures (three, and two along one arc: Shashua
1997; Basri and Jacobs 2003), and a photograph that is out of place leaves that span. All motions are therefore found
together, as those that leave least outside the best span of rank `RANK` (in the spirit of RASL, Peng et al. 2012), by
Gauss-Newton steps on the trailing singular values (variable projection, Kaufman's approximation), coarse to fine.
With Y the aligned pictures as columns, P and Q the projections on their leading left and right singular vectors and G
the derivatives of the pictures by their parameters, a step solves

    [(G_a . (I - P) G_b) (I - Q)_ij] step = - G_a . Y (I - Q)_i     for parameters a of picture i, b of picture j,

for which the inner products of Y and G are enough. Pixels that the span explains badly (edges of shadows, gloss) count
less.

What no picture can tell. Relief seems to creep towards the lamp as the lamp sinks; `creep` takes that off.
Cost: about a second of processor time per photograph at one megapixel with Euclidean motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.capture.creep import without_creep
from engine.steps import Step, Steps, part

Grey = NDArray[np.float32]
Matrix = NDArray[np.float64]

#: Pictures that the span is made of, and the fewest photographs that say something about their motion beyond it.
RANK, LEAST_PHOTOGRAPHS = 2, 5

#: With more than this share in one picture the lights are alike, and a second picture would only hide a knock.
_ONE_LIGHT = 0.97

#: Derivatives of (x, y, 1) by the parameters of each motion, in coordinates where the picture's half-diagonal is 1.
_SHIFTS = [(0, 2), (1, 2)]
_ENTRIES = {"translation": _SHIFTS, "affine": [*_SHIFTS, (0, 0), (0, 1), (1, 0), (1, 1)]}
_ENTRIES["homography"] = [*_ENTRIES["affine"], (2, 0), (2, 1)]
_ITERATIONS = (6, 4, 2)
_LEVELS = 3
_LEAST_SIDE = 64
_MARGIN = 8
_BAND_ROWS = 64
_LARGEST_WORK = 1.2e10


@dataclass(frozen=True, eq=False)
class ArcMotion:
    """Motions of N photographs relative to `reference`, before creep is taken off.

    Attributes
    ----------
    matrix : (N, 3, 3) from pixels of the reference to pixels of each photograph.
    product : (N, N) inner products of the aligned, band-passed pictures of unit energy.
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
        if min(images[0].shape) // factor < _LEAST_SIDE and level > 0:
            continue
        work = (len(images) * (1 + len(basis))) ** 2 * images[0].size / factor**2
        if work > _LARGEST_WORK and level < _LEVELS - 1:
            break
        pictures = [band_passed(image, factor) for image in images]
        small = np.stack([_scaled(one, 1 / factor) for one in matrix])
        weight = np.ones(pictures[0].shape, np.float32)
        for iteration in range(_ITERATIONS[_LEVELS - 1 - level]):
            before = (_LEVELS - 1 - level + iteration / _ITERATIONS[0]) / _LEVELS
            system = _inner_products(pictures, small, basis, weight, note)
            product, kept, weight = yield from part(system, before, before + 0.5 / _LEVELS)
            small = _stepped(small, kept, basis, reference, pictures[0].shape, motion)
        matrix = np.stack([_scaled(one, factor) for one in small])
    return ArcMotion(matrix, product[: len(images), : len(images)])


def light_distance(product: Matrix) -> NDArray[np.float64]:
    """(N,) how far the light has changed up to each photograph: the sines between neighbours, added up."""
    cosine = np.array(
        [product[i, i + 1] / np.sqrt(product[i, i] * product[i + 1, i + 1]) for i in range(len(product) - 1)]
    )
    return np.concatenate([[0.0], np.cumsum(np.sqrt(np.clip(1.0 - cosine**2, 0.0, 1.0)))])


def one_light(pictures: Sequence[Grey], matrix: Matrix) -> bool:
    """Whether the aligned pictures (of `band_passed`) are so alike that no shading can imitate motion."""
    size = pictures[0].shape[::-1]
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    seen = _seen_by_all(matrix, pictures[0].shape).ravel()
    moved = [cv2.warpPerspective(one, m, size, flags=flags).ravel() for one, m in zip(pictures, matrix, strict=True)]
    table = np.stack(moved) * seen
    values = np.linalg.eigvalsh((table @ table.T).astype(np.float64))
    return bool(values[-1] > _ONE_LIGHT * values.sum())


def predicted(pictures: Sequence[Grey], matrix: Matrix) -> Steps[tuple[list[Grey], NDArray[np.float64]]]:
    """Each aligned picture (of `band_passed`) as the best mixture of all others, and its correlation with that."""
    size = pictures[0].shape[::-1]
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    table = np.empty((len(pictures), pictures[0].size), np.float32)
    for index, (picture, motion) in enumerate(zip(pictures, matrix, strict=True)):
        yield Step(0.5 * index / len(pictures), "Checking the alignment")
        table[index] = cv2.warpPerspective(picture, motion, size, flags=flags, borderMode=cv2.BORDER_REPLICATE).ravel()
    product = (table @ table.T).astype(np.float64)
    product += np.diag(1e-6 * np.diag(product) + 1e-30)
    mixtures, correlation = [], np.zeros(len(pictures))
    for index in range(len(pictures)):
        yield Step(0.5 + 0.5 * index / len(pictures), "Checking the alignment")
        others = np.flatnonzero(np.arange(len(pictures)) != index)
        share = np.linalg.solve(product[np.ix_(others, others)], product[others, index])
        correlation[index] = np.sqrt(np.clip(share @ product[others, index] / product[index, index], 0.0, 1.0))
        mixture = share.astype(np.float32) @ table[others]
        mixtures.append(mixture.reshape(pictures[0].shape))
    return mixtures, correlation


def jumps(
    motion_found: ArcMotion, reference: int, motion: str, shape: tuple[int, ...]
) -> tuple[Matrix, NDArray[np.float64]]:
    """(N, 3, 3) what remains of the motions without creep, of the same kind of motion; how far off (N,) in pixels,
    as a standard deviation, the shifts may be because creep cannot be told from them."""
    basis = _basis(motion)
    unit = _unit(shape)
    size = unit[0, 0]
    normal = np.linalg.inv(unit) @ motion_found.matrix @ unit
    normal /= normal[:, 2:, 2:]
    energy = (basis**2).sum(axis=(1, 2))
    moved = size * np.einsum("nij,pij->np", normal - np.eye(3), basis) / energy
    distance = light_distance(motion_found.product)
    shifts, doubt = without_creep(moved[:, :2], distance, reference)
    kept = np.hstack([shifts, without_creep(moved[:, 2:], distance, reference)[0]]) / size
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


def _scaled(matrix: Matrix, factor: float) -> Matrix:
    """The same motion in pixels of a picture `factor` times as large (pixel centres at integers)."""
    offset = (factor - 1) / 2
    scale = np.array([[factor, 0, offset], [0, factor, offset], [0, 0, 1.0]])
    return scale @ matrix @ np.linalg.inv(scale)


def band_passed(image: Grey, factor: int = 1) -> Grey:
    """Details of one to twelve pixels of the picture reduced by `factor`, of unit energy."""
    height, width = (size // factor for size in image.shape)
    small = image[: height * factor, : width * factor]
    if factor > 1:
        small = cv2.resize(small, (width, height), interpolation=cv2.INTER_AREA)
    detail = cv2.GaussianBlur(small, (0, 0), 1.0) - cv2.GaussianBlur(small, (0, 0), 12.0)
    deviation = float(detail.std(dtype=np.float64))
    return detail / np.float32(deviation) if deviation > 0.0 else detail


def _inner_products(
    pictures: Sequence[Grey], matrix: Matrix, basis: Matrix, weight: Grey, note: str
) -> Steps[tuple[Matrix, tuple[Matrix, Matrix], Grey]]:
    """Inner products of the aligned pictures; (hessian, gradient) of a step; the weights for the next one."""
    height, width = pictures[0].shape
    count, parameters = len(pictures), len(basis)
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    slopes = []
    for index, (picture, motion) in enumerate(zip(pictures, matrix, strict=True)):
        yield Step(0.5 * index / count, note)
        moved = cv2.warpPerspective(picture, motion, (width, height), flags=flags, borderMode=cv2.BORDER_REPLICATE)
        slopes.append((moved, *(cv2.Sobel(moved, cv2.CV_32F, axis, 1 - axis, scale=1 / 8) for axis in (1, 0))))
    seen = _seen_by_all(matrix, (height, width))
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


def _seen_by_all(matrix: Matrix, shape: tuple[int, ...]) -> Grey:
    """1 where all pictures have data, else 0; 1 everywhere where they share less than a quarter of the frame."""
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


def _stepped(
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

"""The motion between two photographs, where their light is not too unlike.

Phase correlation proposes shifts (Kuglin1975), normalised correlation of the overlap judges them, and ECC
maximisation refines from coarse to fine (Evangelidis2008, OpenCV's `findTransformECC`).

Alignment of the photographs of a stack, found by registration or from marked control points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.capture.registration.texture import Grey, feature, reduce, tiles
from engine.core.health import Finding
from engine.core.steps import Step, Steps

Matrix = NDArray[np.float64]

#: Kinds of motion from stiff to free.
MOTIONS = ("translation", "euclidean", "affine", "homography")


@dataclass(frozen=True, eq=False)
class Alignment:
    """Alignment of N photographs with the reference.

    Attributes
    ----------
    matrix : (N, 3, 3) float64, from pixels of the reference to pixels of each photograph; identity where not aligned.
    residual_px : (N,) root mean square of what is left in the tiles, 0 for the reference, NaN where it
        cannot be measured: not aligned, or texture in one direction only.
    aligned : (N,) bool.
    confidence : (N,) correlation with the reference after alignment, in [0, 1].
    reference : index of the photograph that the others lie on.
    findings : what was flagged, naming the photographs.
    """

    matrix: Matrix
    residual_px: NDArray[np.float64]
    aligned: NDArray[np.bool_]
    confidence: NDArray[np.float64]
    reference: int
    findings: tuple[Finding, ...] = ()


_MIN_CONFIDENCE = 0.2
#: Below this correlation, shading may imitate shifts of up to so many pixels of the compared images.
SURE, _SHADING_PX = 0.5, 8.0
_LARGEST_CONDITION = 1e6
#: Correlation that counts as the best one does, and for a small shift: patterns repeat, and tripods move little.
_EQUALLY_GOOD, _NEARLY_AS_GOOD = 0.9, 0.6
_COARSE = 320

#: Pixels along the shorter side that alignment needs.
MIN_SIDE = 32
#: Distance from no shift, and from the neighbour's shift, within which a lower peak is looked for too.
_NEAR = 8
_ITERATIONS, _PRECISION = 30, 1e-6


#: OpenCV's codes of the motions.
_ECC = {
    "translation": cv2.MOTION_TRANSLATION,
    "euclidean": cv2.MOTION_EUCLIDEAN,
    "affine": cv2.MOTION_AFFINE,
    "homography": cv2.MOTION_HOMOGRAPHY,
}


class Refused(Exception):
    """The pair cannot be aligned; the message says why, as the end of a sentence."""


class TooUnlike(Refused):
    """The pair cannot be aligned because of its light; together with other photographs it may be."""


def pyramid(image: Grey) -> list[Grey]:
    """Features of the image and of its halves, fine to coarse; refuses images below `MIN_SIDE` or texture."""
    if min(image.shape) < MIN_SIDE:
        raise Refused(f"at {image.shape[1]} × {image.shape[0]} pixels they are smaller than {MIN_SIDE} on a side")
    levels = [image]
    while max(levels[-1].shape) > _COARSE and min(levels[-1].shape) >= 64:
        levels.append(reduce(levels[-1], 2))
    return [feature(level) for level in levels]


def first_shift(target: Grey, levels: list[Grey], neighbour: Matrix) -> tuple[Matrix, float]:
    """The shift (as a matrix at the coarsest level) that fits best, and how far off the next one is that fits alike."""
    image = levels[-1]
    known = enlarge(neighbour, 1 / 2 ** (len(levels) - 1))[:2, 2]
    near = [np.zeros(2), np.round(known)]
    shifts = [*near, *_phase_peaks(target, image, near)]
    scored = sorted(((_overlap_correlation(target, image, shift), shift) for shift in shifts), key=lambda s: -s[0])
    best = scored[0][0]
    upside_down = np.ascontiguousarray(image[::-1, ::-1])
    turned = max(_overlap_correlation(target, upside_down, shift) for shift in _phase_peaks(target, upside_down))
    if turned > max(best + 0.1, 2.0 * best):
        raise Refused("it looks rotated by 180°")
    if best < _MIN_CONFIDENCE / 2:
        raise Refused("no shift of up to half the frame makes it like the reference, or there is no texture")
    sure = [(score * np.sqrt(_overlap_share(target, shift)), shift) for score, shift in scored]
    surest = max(score for score, _ in sure)
    good = [
        shift
        for score, shift in sure
        if score >= (_NEARLY_AS_GOOD if np.abs(shift).max() <= _NEAR else _EQUALLY_GOOD) * surest
    ]
    chosen = min(good, key=lambda shift: float(np.hypot(*shift)))
    others = [float(np.hypot(*(shift - chosen))) for shift in good]
    matrix = np.eye(3)
    matrix[:2, 2] = chosen
    apart = [distance for distance in others if distance > 4.0]
    return matrix, min(apart, default=0.0) * 2 ** (len(levels) - 1)


def _phase_peaks(
    target: Grey, image: Grey, near: Sequence[NDArray[np.float64]] = (), count: int = 6
) -> list[NDArray[np.float64]]:
    """The highest peaks (x, y) of the phase correlation, up to half a frame, and those about the shifts `near`."""
    taper = cv2.createHanningWindow(target.shape[::-1], cv2.CV_32F)
    one, other = (np.fft.rfft2((image - image.mean()) * taper) for image in (target, image))
    cross = other * np.conj(one)
    strength = np.abs(cross)
    surface = np.fft.irfft2(cross / (strength + 1e-3 * strength.mean() + 1e-30), s=target.shape).astype(np.float32)
    surface = cv2.GaussianBlur(np.fft.fftshift(surface), (0, 0), 1.0)
    middle = np.array(surface.shape) // 2
    peaks = []
    for place in near:
        beside, below = (int(value) + int(at) for value, at in zip(place, middle[::-1], strict=True))
        top, left = max(0, below - _NEAR), max(0, beside - _NEAR)
        window = surface[top : below + _NEAR + 1, left : beside + _NEAR + 1]
        if window.size:
            down, across = np.unravel_index(int(np.argmax(window)), window.shape)
            peaks.append(np.array([left + across - middle[1], top + down - middle[0]], np.float64))
    for _ in range(count):
        row, column = np.unravel_index(int(np.argmax(surface)), surface.shape)
        peaks.append(np.array([column - middle[1], row - middle[0]], np.float64))
        surface[max(0, row - 3) : row + 4, max(0, column - 3) : column + 4] = -np.inf
    return peaks


def _overlap_correlation(target: Grey, image: Grey, shift: NDArray[np.float64]) -> float:
    """Correlation in [-1, 1] of what both show when `image` is moved back by whole pixels; 0 where that is flat."""
    column, row = (int(value) for value in shift)
    height, width = target.shape
    if abs(column) > width // 2 or abs(row) > height // 2:
        return 0.0
    there = image[max(0, row) : height + min(0, row), max(0, column) : width + min(0, column)]
    here = target[max(0, -row) : height + min(0, -row), max(0, -column) : width + min(0, -column)]
    return _correlation(here, there)


def _overlap_share(target: Grey, shift: NDArray[np.float64]) -> float:
    """Of the frame, for an image moved by `shift`: the correlation of few pixels is less sure."""
    height, width = target.shape
    return max(0.0, 1.0 - abs(float(shift[0])) / width) * max(0.0, 1.0 - abs(float(shift[1])) / height)


def _correlation(one: Grey, other: Grey) -> float:
    a, b = (image.astype(np.float64) - image.mean(dtype=np.float64) for image in (one, other))
    energy = float((a * a).sum() * (b * b).sum())
    return float((a * b).sum() / np.sqrt(energy)) if energy > 0.0 else 0.0


def refine(
    target: list[Grey], levels: list[Grey], start: Matrix, motion: str, note: str
) -> Steps[tuple[Matrix, float]]:
    """ECC from the coarsest level (shifts only) to the finest; refuses what diverges, degenerates or fits badly."""
    matrix = start
    for level in range(len(levels) - 1, -1, -1):
        kind = "translation" if level == len(levels) - 1 and level > 0 else motion
        matrix = _maximise(target[level], levels[level], matrix, kind)
        yield Step(1.0 - level / len(levels), note)
        if level > 0:
            matrix = enlarge(matrix, 2)
    refuse_degenerate(matrix, target[0].shape)
    confidence = _correlation(*_overlap(target[0], levels[0], matrix))
    if confidence < _MIN_CONFIDENCE:
        raise TooUnlike(f"it stays unlike the reference (correlation {max(0.0, confidence):.2f})")
    if confidence < SURE and largest_move(matrix, target[0].shape) < _SHADING_PX:
        raise TooUnlike(
            f"its light is too unlike (correlation {confidence:.2f}) to separate a small shift from shading"
        )
    return matrix, min(1.0, confidence)


def largest_move(matrix: Matrix, shape: tuple[int, ...]) -> float:
    """Displacement of the corner that moves most, in pixels."""
    height, width = shape
    corners = np.array([[0, 0, 1], [width, 0, 1], [width, height, 1], [0, height, 1.0]])
    moved = corners @ matrix.T
    return float(np.hypot(*(moved[:, :2] / moved[:, 2:] - corners[:, :2]).T).max())


def _maximise(target: Grey, image: Grey, matrix: Matrix, motion: str) -> Matrix:
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, _ITERATIONS, _PRECISION)
    rows = 3 if motion == "homography" else 2
    start = matrix[:rows].astype(np.float32)
    try:
        found = cv2.findTransformECC(target, image, start, _ECC[motion], criteria, None, 1)[1]
    except cv2.error:
        raise Refused("the search for its position did not converge") from None
    refined = np.eye(3)
    refined[:rows] = found
    if not np.isfinite(refined).all():
        raise Refused("its texture does not determine its position")
    return refined / refined[2, 2]


def refuse_degenerate(matrix: Matrix, shape: tuple[int, ...]) -> None:
    """Condition in coordinates that run from -1 to 1 over the image; corners must stay within half a frame."""
    height, width = shape
    unit = np.array([[width / 2, 0, width / 2], [0, height / 2, height / 2], [0, 0, 1.0]])
    normalised = np.linalg.inv(unit) @ matrix @ unit
    corners = np.array([[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1.0]])
    moved = corners @ normalised.T
    if np.linalg.cond(normalised) > _LARGEST_CONDITION or (moved[:, 2] <= 0).any() or np.linalg.det(normalised) <= 0:
        raise Refused("the motion found is degenerate")
    if np.abs(moved[:, :2] / moved[:, 2:] - corners[:, :2]).max() > 1.0:
        raise Refused("the motion found moves it by more than half the frame")


def _overlap(target: Grey, image: Grey, matrix: Matrix) -> tuple[Grey, Grey]:
    """Target and moved-back image, both flattened to where the image has content."""
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    size = target.shape[::-1]
    moved = cv2.warpPerspective(image, matrix, size, flags=flags)
    inside = cv2.warpPerspective(np.ones_like(image), matrix, size, flags=flags) > 0.999
    return target[inside], moved[inside]


def tile_residual(target: Grey, image: Grey, matrix: Matrix) -> float:
    """Root mean square of the shifts left in the tiles, each solved for by least squares with a gain and an offset."""
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    moved = cv2.warpPerspective(image, matrix, target.shape[::-1], flags=flags, borderMode=cv2.BORDER_REPLICATE)
    across, down = (cv2.Sobel(target, cv2.CV_32F, x, 1 - x, scale=1 / 8) for x in (1, 0))
    squares = []
    for tile, _ in tiles(target.shape):
        columns = [moved[tile].ravel(), np.ones(moved[tile].size), across[tile].ravel(), down[tile].ravel()]
        solution, _, rank, _ = np.linalg.lstsq(np.stack(columns, axis=1).astype(np.float64), target[tile].ravel())
        if rank == 4:
            squares.append(float(solution[2] ** 2 + solution[3] ** 2))
    return float(np.sqrt(np.mean(squares))) if squares else float("nan")


def enlarge(matrix: Matrix, factor: float) -> Matrix:
    """The same motion in pixels of an image `factor` times as large (pixel centres at integers)."""
    offset = (factor - 1) / 2
    scale = np.array([[factor, 0, offset], [0, factor, offset], [0, 0, 1.0]])
    return scale @ matrix @ np.linalg.inv(scale)

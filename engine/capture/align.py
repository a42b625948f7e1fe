"""Alignment of the photographs of a stack to the best-textured one.

A moving lamp turns valleys into hills, so what is compared is the magnitude of the gradient, divided by its local
mean. Phase correlation proposes shifts (Kuglin and Hines 1975), normalised correlation of the overlap judges them,
and ECC maximisation refines from coarse to fine (Evangelidis and Psarakis 2008, OpenCV's `findTransformECC`).

A matrix (3, 3) takes pixel positions (x, y, 1) of the reference to positions in the photograph; pixel centres are at
integers. What cannot be aligned keeps the identity and is flagged: no texture, unlike pictures, shifts over half the
frame, upside-down pictures, degenerate matrices. A pattern that repeats is aligned by the smallest of the shifts
that fit equally well, and reported.

Relief lit from one side seems to move towards the lamp as the lamp sinks, by up to some pixels. From five photographs
on, what was found pair by pair is therefore only a start: all are then aligned together (`arc_motion`), also those
whose light is too unlike the reference's to be compared with it, and what creeps smoothly from light to light is taken
for shading. Fewer photographs are left where they were unless their light is like the reference's.

The residual is not what the fit minimised: the aligned picture is compared with the reference (from five photographs
on with what the others predict of it) tile by tile (4 × 4), each tile's own remaining shift is solved for, and their
root mean square is given, in pixels of the photograph. It sees wrong motion models, bending and noise. It cannot see
a shift of all photographs along one smooth curve, which shading imitates.

Cost: about 0.8 s of processor time per photograph at 0.6 megapixels, the size to which larger pictures are reduced.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.capture.arc_motion import LEAST_PHOTOGRAPHS, arc_motion, band_passed, jumps, one_light, predicted
from engine.capture.control_points import marked_motion
from engine.health import Finding, Verdict
from engine.steps import Step, Steps, part

Grey = NDArray[np.float32]
Matrix = NDArray[np.float64]

#: Motions from stiff to free, with OpenCV's code and how many tiles off one line must have texture to support them.
MOTIONS = {
    "translation": (cv2.MOTION_TRANSLATION, 1),
    "euclidean": (cv2.MOTION_EUCLIDEAN, 2),
    "affine": (cv2.MOTION_AFFINE, 3),
    "homography": (cv2.MOTION_HOMOGRAPHY, 4),
}

#: Pictures are compared at no more pixels than this.
WORK_PIXELS = 600_000

_LEAST_CONFIDENCE = 0.2
#: Below this correlation, shading may imitate shifts of up to so many pixels of the compared pictures.
_SURE, _SHADING_PX = 0.5, 8.0
_LARGEST_CONDITION = 1e6
#: A motion below this is not worth the blur of resampling.
_STILL_PX = 0.02
_EQUALLY_GOOD = 0.9
_COARSE = 320
_TILES = 4
_ITERATIONS, _PRECISION = 30, 1e-6


@dataclass(frozen=True, eq=False)
class Alignment:
    """How N photographs lie on the reference.

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


class _Refused(Exception):
    """The pair cannot be aligned; the message says why, as the end of a sentence."""


class _TooUnlike(_Refused):
    """The pair cannot be aligned because of its light; together with other photographs it may be."""


def with_control_points(
    alignment: Alignment, marked: Mapping[int, Sequence[Sequence[float]]], names: Sequence[str], motion: str
) -> Alignment:
    """The alignment with the motions of some photographs taken from points that a person marked.

    `marked` maps the index of a photograph to pairs (x and y in the reference, x and y in it, pixels of the
    photographs). Their residual is that of the points. Points that determine only a stiffer motion are reported.
    """
    matrix, residual, aligned = alignment.matrix.copy(), alignment.residual_px.copy(), alignment.aligned.copy()
    confidence, findings = alignment.confidence.copy(), list(alignment.findings)
    for index, pairs in marked.items():
        found = marked_motion(pairs, motion)
        matrix[index], residual[index], aligned[index], confidence[index] = found.matrix, found.rms_px, True, 1.0
        findings = [one for one in findings if one.source != names[index]]
        if found.motion != motion:
            findings.append(Finding(Verdict.NOTE, _STIFFER.format(motion, found.motion), names[index]))
    return replace(
        alignment,
        matrix=matrix,
        residual_px=residual,
        aligned=aligned,
        confidence=confidence,
        findings=tuple(findings),
    )


_STIFFER = "its control points do not determine a motion of kind {}: {} was used"


def reduction(height: int, width: int) -> int:
    """By which whole number a picture is reduced before it is compared."""
    return max(1, int(np.ceil(np.sqrt(height * width / WORK_PIXELS))))


def reduced(image: Grey, factor: int) -> Grey:
    """Means of factor × factor pixels; what does not fill a block at the right and bottom is left out."""
    height, width = (size // factor for size in image.shape)
    whole = image[: height * factor, : width * factor]
    return whole if factor == 1 else cv2.resize(whole, (width, height), interpolation=cv2.INTER_AREA)


def texture(image: Grey) -> float:
    """Mean gradient of the picture beyond what its noise makes: the larger, the better to align to."""
    return max(0.0, float(slope(image, 2.0).mean(dtype=np.float64)) - _noise_slope(image))


def align(
    images: Sequence[Grey],
    names: Sequence[str],
    motion: str = "euclidean",
    factor: int = 1,
    reference: int | None = None,
) -> Steps[Alignment]:
    """Align `images` (luminance, equal sizes, at most about `WORK_PIXELS`, reduced by `factor`) to one of them.

    Without `reference` that is the best textured one. `names` are the photographs' for the findings. The matrices and
    residuals are in pixels before the reduction. Raises ValueError for an unknown motion or images of different sizes.
    """
    if motion not in MOTIONS:
        raise ValueError(f"unknown motion {motion!r}; known are {', '.join(MOTIONS)}")
    if len({image.shape for image in images}) != 1 or len(images) != len(names):
        raise ValueError("images to align need one size and a name each")
    count = len(images)
    if reference is None:
        reference = int(np.argmax([texture(image) for image in images]))
    target = _pyramid(images[reference])
    supported = supported_motion(images[reference], motion)
    findings = [] if supported == motion else [Finding(Verdict.NOTE, _UNSUPPORTED.format(motion), names[reference])]
    matrix = np.tile(np.eye(3), (count, 1, 1))
    residual, confidence = np.full(count, np.nan), np.zeros(count)
    unlike: dict[int, Finding] = {}
    for done, index in enumerate(_outwards(reference, count), start=1):
        yield Step(0.5 * done / count, f"Aligning {done + 1} of {count}")
        try:
            levels = _pyramid(images[index])
            start, ambiguous = _start(target[-1], levels, matrix[index + (1 if index < reference else -1)])
            refining = _refined(target, levels, start, supported, f"Aligning {done + 1} of {count}")
            spent = 0.5 * done / count
            matrix[index], confidence[index] = yield from part(refining, spent + 0.1 / count, spent + 0.4 / count)
            residual[index] = _tile_residual(target[0], levels[0], matrix[index])
            if ambiguous:
                findings.append(Finding(Verdict.WARNING, _AMBIGUOUS.format(ambiguous * factor), names[index]))
        except _Refused as refusal:
            flagged = Finding(Verdict.WARNING, _REFUSED.format(refusal), names[index])
            if isinstance(refusal, _TooUnlike):
                unlike[index] = flagged
            else:
                findings.append(flagged)
    joined = sorted({reference, *np.flatnonzero(confidence), *unlike})
    if len(joined) >= LEAST_PHOTOGRAPHS:
        together = _together([images[n] for n in joined], matrix[joined], joined.index(reference), supported)
        matrix[joined], residual[joined], confidence[joined], creep, doubt = yield from part(together, 0.5, 1.0)
        unlike = {
            index: Finding(Verdict.WARNING, _REFUSED.format("it stays unlike what the others predict"), names[index])
            for index in joined
            if not confidence[index]
        }
        unsure = [names[index] for index, one in zip(joined, doubt, strict=True) if one * factor >= 1.0]
        if unsure:
            text = _UNDETERMINED.format(", ".join(unsure), doubt.max() * factor)
            findings.append(Finding(Verdict.WARNING, text))
        if creep * factor >= 1.0:
            findings.append(Finding(Verdict.NOTE, _CREEPS.format(creep * factor)))
    findings += unlike.values()
    aligned = confidence > 0.0
    if aligned.any():
        residual[reference], confidence[reference], aligned[reference] = 0.0, 1.0, True
    whole = np.stack([_enlarged(one, factor) for one in matrix])
    return Alignment(whole, residual * factor, aligned, confidence, reference, tuple(findings))


_REFUSED = "could not be aligned and stays as it was: {}"
_UNSUPPORTED = "has too little texture, or texture in one line only, for a motion of kind {}: shifts are used instead"
_CREEPS = (
    "The photographs seem to creep by {:.1f} px along one smooth curve from light to light, as shading makes relief "
    "seem to. This was not followed; if the camera did creep, mark control points"
)
_UNDETERMINED = (
    "The shifts of {} are not determined to better than about {:.1f} px: the camera moved, and shading seems to move "
    "relief as well. Check these, and mark control points where it matters"
)
_AMBIGUOUS = "repeats: a shift that differs by {:.0f} px fits as well. The smallest was taken; check it"


def _together(
    images: list[Grey], start: Matrix, reference: int, motion: str
) -> Steps[tuple[Matrix, NDArray[np.float64], NDArray[np.float64], float, NDArray[np.float64]]]:
    """Matrices, residuals and confidences of photographs aligned together, how far they seem to creep in pixels, and
    how far off each may be because of that (standard deviation).

    Motions too small to be worth the blur of resampling are left out; what fits badly stays as it was.
    """
    shape = images[0].shape
    pictures = [band_passed(image) for image in images]
    matrix, found, doubt = start, start, np.zeros(len(images))
    if not one_light(pictures, start):
        motions = yield from part(arc_motion(images, start, reference, motion, "Aligning all together"), 0.0, 0.7)
        (matrix, doubt), found = jumps(motions, reference, motion, shape), motions.matrix
    still = np.array([_largest_move(one, shape) < _STILL_PX for one in matrix])
    matrix = np.where(still[:, None, None], np.eye(3), matrix)
    mixtures, confidence = yield from part(predicted(pictures, matrix), 0.7, 0.9)
    residual = np.full(len(images), np.nan)
    for index, (mixture, picture) in enumerate(zip(mixtures, pictures, strict=True)):
        yield Step(0.9 + 0.1 * index / len(images), "Checking the alignment")
        try:
            _refuse_degenerate(matrix[index], shape)
            if confidence[index] < _SURE:
                raise _TooUnlike
            residual[index] = _tile_residual(mixture, picture, matrix[index])
        except _Refused:
            matrix[index], confidence[index] = np.eye(3), 0.0
    middle = np.array([shape[1] / 2, shape[0] / 2, 1.0])
    there, kept = (places[:, :2] / places[:, 2:] for places in (found @ middle, matrix @ middle))
    crept = (there - kept)[confidence > 0]
    creep = float(np.hypot(*(crept.max(axis=0) - crept.min(axis=0)))) if len(crept) else 0.0
    return matrix, residual, confidence, creep, np.where(confidence > 0, doubt, 0.0)


def supported_motion(image: Grey, motion: str) -> str:
    """`motion`, or 'translation' where too few tiles of the picture have texture, or all of them on one line."""
    steep, floor = slope(image, 2.0), 3.0 * _noise_slope(image)
    tiles = [(float(steep[tile].mean()), centre) for tile, centre in _tiles(image.shape)]
    strongest = max(strength for strength, _ in tiles)
    centres = np.array([centre for strength, centre in tiles if strength > max(floor, 0.05 * strongest)]).reshape(-1, 2)
    needed = MOTIONS[motion][1]
    if len(centres) < needed:
        return "translation"
    spread = np.linalg.svd(centres - centres.mean(axis=0), compute_uv=False)
    return motion if needed < 3 or spread[-1] > 0.1 * spread[0] else "translation"


def _outwards(reference: int, count: int) -> list[int]:
    """All others, each after its neighbour on the side of the reference, whose motion it starts from."""
    return [*range(reference - 1, -1, -1), *range(reference + 1, count)]


def slope(image: Grey, deviation: float) -> Grey:
    """Gradient magnitude per pixel after a Gaussian blur.

    The root is numpy's, because `cv2.magnitude` gives other last bits for other places in memory.
    """
    smooth = cv2.GaussianBlur(image, (0, 0), deviation)
    across, down = (cv2.Sobel(smooth, cv2.CV_32F, axis, 1 - axis, scale=1 / 8) for axis in (1, 0))
    return np.sqrt(across * across + down * down)


def _noise_slope(image: Grey) -> float:
    """Mean of `slope(image, 2.0)` for noise as strong as that of the picture (from the median of its Laplacian)."""
    deviation = float(np.median(np.abs(cv2.Laplacian(image, cv2.CV_32F)))) / 3.0
    return 0.0627 * deviation


def _feature(image: Grey) -> Grey:
    """Gradient magnitude over its local mean: what lamps of any direction and strength leave alike."""
    steep = slope(image, 1.5)
    local = cv2.GaussianBlur(steep, (0, 0), 16.0)
    return steep / (local + np.float32(1e-3 * float(steep.max()) + 1e-30))


def _pyramid(image: Grey) -> list[Grey]:
    """Features of the picture and of its halves, fine to coarse; refuses pictures without texture."""
    if min(image.shape) < 32:
        raise _Refused("it is smaller than 32 pixels")
    levels = [image]
    while max(levels[-1].shape) > _COARSE and min(levels[-1].shape) >= 64:
        levels.append(reduced(levels[-1], 2))
    return [_feature(level) for level in levels]


def _start(target: Grey, levels: list[Grey], neighbour: Matrix) -> tuple[Matrix, float]:
    """The shift (as a matrix at the coarsest level) that fits best, and how far off the next one is that fits alike."""
    image = levels[-1]
    known = _enlarged(neighbour, 1 / 2 ** (len(levels) - 1))[:2, 2]
    shifts = [np.zeros(2), np.round(known), *_phase_peaks(target, image)]
    scored = sorted(((_overlap_correlation(target, image, shift), shift) for shift in shifts), key=lambda s: -s[0])
    best = scored[0][0]
    upside_down = np.ascontiguousarray(image[::-1, ::-1])
    turned = max(_overlap_correlation(target, upside_down, shift) for shift in _phase_peaks(target, upside_down))
    if turned > best + 0.1:
        raise _Refused("it looks turned by 180°")
    if best < _LEAST_CONFIDENCE / 2:
        raise _Refused("no shift of up to half the frame makes it like the reference, or there is no texture")
    good = [shift for score, shift in scored if score >= _EQUALLY_GOOD * best]
    chosen = min(good, key=lambda shift: float(np.hypot(*shift)))
    others = [float(np.hypot(*(shift - chosen))) for shift in good]
    matrix = np.eye(3)
    matrix[:2, 2] = chosen
    apart = [distance for distance in others if distance > 4.0]
    return matrix, min(apart, default=0.0) * 2 ** (len(levels) - 1)


def _phase_peaks(target: Grey, image: Grey, count: int = 6) -> list[NDArray[np.float64]]:
    """The highest peaks (x, y) of the phase correlation, up to half a frame."""
    window = cv2.createHanningWindow(target.shape[::-1], cv2.CV_32F)
    one, other = (np.fft.rfft2((picture - picture.mean()) * window) for picture in (target, image))
    cross = other * np.conj(one)
    strength = np.abs(cross)
    surface = np.fft.irfft2(cross / (strength + 1e-3 * strength.mean() + 1e-30), s=target.shape).astype(np.float32)
    surface = cv2.GaussianBlur(np.fft.fftshift(surface), (0, 0), 1.0)
    middle = np.array(surface.shape) // 2
    peaks = []
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


def _correlation(one: Grey, other: Grey) -> float:
    a, b = (picture.astype(np.float64) - picture.mean(dtype=np.float64) for picture in (one, other))
    energy = float((a * a).sum() * (b * b).sum())
    return float((a * b).sum() / np.sqrt(energy)) if energy > 0.0 else 0.0


def _refined(
    target: list[Grey], levels: list[Grey], start: Matrix, motion: str, note: str
) -> Steps[tuple[Matrix, float]]:
    """ECC from the coarsest level (shifts only) to the finest; refuses what diverges, degenerates or fits badly."""
    matrix = start
    for level in range(len(levels) - 1, -1, -1):
        kind = "translation" if level == len(levels) - 1 and level > 0 else motion
        matrix = _maximised(target[level], levels[level], matrix, kind)
        yield Step(1.0 - level / len(levels), note)
        if level > 0:
            matrix = _enlarged(matrix, 2)
    _refuse_degenerate(matrix, target[0].shape)
    confidence = _correlation(*_overlap(target[0], levels[0], matrix))
    if confidence < _LEAST_CONFIDENCE:
        raise _TooUnlike(f"it stays unlike the reference (correlation {max(0.0, confidence):.2f})")
    if confidence < _SURE and _largest_move(matrix, target[0].shape) < _SHADING_PX:
        raise _TooUnlike(f"its light is too unlike (correlation {confidence:.2f}) to tell a small shift from shading")
    return matrix, min(1.0, confidence)


def _largest_move(matrix: Matrix, shape: tuple[int, ...]) -> float:
    """How far the corner that moves most moves, in pixels."""
    height, width = shape
    corners = np.array([[0, 0, 1], [width, 0, 1], [width, height, 1], [0, height, 1.0]])
    moved = corners @ matrix.T
    return float(np.hypot(*(moved[:, :2] / moved[:, 2:] - corners[:, :2]).T).max())


def _maximised(target: Grey, image: Grey, matrix: Matrix, motion: str) -> Matrix:
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, _ITERATIONS, _PRECISION)
    rows = 3 if motion == "homography" else 2
    start = matrix[:rows].astype(np.float32)
    try:
        found = cv2.findTransformECC(target, image, start, MOTIONS[motion][0], criteria, None, 1)[1]
    except cv2.error:
        raise _Refused("the search for its position did not converge") from None
    refined = np.eye(3)
    refined[:rows] = found
    if not np.isfinite(refined).all():
        raise _Refused("its texture does not determine its position")
    return refined / refined[2, 2]


def _refuse_degenerate(matrix: Matrix, shape: tuple[int, ...]) -> None:
    """Condition in coordinates that run from -1 to 1 over the picture; corners must stay within half a frame."""
    height, width = shape
    unit = np.array([[width / 2, 0, width / 2], [0, height / 2, height / 2], [0, 0, 1.0]])
    normalised = np.linalg.inv(unit) @ matrix @ unit
    corners = np.array([[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1.0]])
    moved = corners @ normalised.T
    if np.linalg.cond(normalised) > _LARGEST_CONDITION or (moved[:, 2] <= 0).any() or np.linalg.det(normalised) <= 0:
        raise _Refused("the motion found is degenerate")
    if np.abs(moved[:, :2] / moved[:, 2:] - corners[:, :2]).max() > 1.0:
        raise _Refused("the motion found moves it by more than half the frame")


def _overlap(target: Grey, image: Grey, matrix: Matrix) -> tuple[Grey, Grey]:
    """Target and moved-back image, both flattened to where the image has content."""
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    size = target.shape[::-1]
    moved = cv2.warpPerspective(image, matrix, size, flags=flags)
    inside = cv2.warpPerspective(np.ones_like(image), matrix, size, flags=flags) > 0.999
    return target[inside], moved[inside]


def _tile_residual(target: Grey, image: Grey, matrix: Matrix) -> float:
    """Root mean square of the shifts left in the tiles, each solved for by least squares with a gain and an offset."""
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    moved = cv2.warpPerspective(image, matrix, target.shape[::-1], flags=flags, borderMode=cv2.BORDER_REPLICATE)
    across, down = (cv2.Sobel(target, cv2.CV_32F, x, 1 - x, scale=1 / 8) for x in (1, 0))
    squares = []
    for tile, _ in _tiles(target.shape):
        columns = [moved[tile].ravel(), np.ones(moved[tile].size), across[tile].ravel(), down[tile].ravel()]
        solution, _, rank, _ = np.linalg.lstsq(np.stack(columns, axis=1).astype(np.float64), target[tile].ravel())
        if rank == 4:
            squares.append(float(solution[2] ** 2 + solution[3] ** 2))
    return float(np.sqrt(np.mean(squares))) if squares else float("nan")


def _tiles(shape: tuple[int, ...]) -> list[tuple[tuple[slice, slice], tuple[float, float]]]:
    """The slices and centres (x, y) of 4 × 4 tiles."""
    rows, columns = (np.linspace(0, size, _TILES + 1).astype(int) for size in shape)
    return [
        ((slice(top, bottom), slice(left, right)), ((left + right) / 2, (top + bottom) / 2))
        for top, bottom in itertools.pairwise(rows)
        for left, right in itertools.pairwise(columns)
    ]


def _enlarged(matrix: Matrix, factor: float) -> Matrix:
    """The same motion in pixels of a picture `factor` times as large (pixel centres at integers)."""
    offset = (factor - 1) / 2
    scale = np.array([[factor, 0, offset], [0, factor, offset], [0, 0, 1.0]])
    return scale @ matrix @ np.linalg.inv(scale)

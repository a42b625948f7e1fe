"""Alignment of the photographs of a stack to the best-textured one.

A moving lamp turns valleys into hills, so what is compared is the magnitude of the gradient, divided by its local
mean, first pair by pair (`pair_motion`).

A matrix (3, 3) takes pixel positions (x, y, 1) of the reference to positions in the photograph; pixel centres are at
integers. What cannot be aligned keeps the identity and is flagged: no texture, unlike images, shifts over half the
frame, upside-down images, degenerate matrices. A pattern that repeats is aligned by the smallest of the shifts
that fit equally well, and reported.

Relief lit from one side seems to move towards the lamp as the lamp sinks, by up to some pixels. From five photographs
on, what was found pair by pair is therefore only a start: all are then aligned together (`arc_motion`), also those
whose light is too unlike the reference's to be compared with it, and smooth drift from light to light is taken
for shading. Fewer photographs are left where they were unless their light is like the reference's.

The residual is not what the fit minimised: the aligned image is compared with the reference (from five photographs
on with what the others predict of it) tile by tile (4 × 4), each tile's own remaining shift is solved for, and their
root mean square is given, in pixels of the photograph. It sees wrong motion models, bending and noise. It cannot see
a shift of all photographs along one smooth curve, which shading imitates.

Cost: about 0.8 s of CPU time per photograph at 0.6 megapixels, the size to which larger images are reduced.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from engine.capture.registration.arc_motion import (
    MIN_PHOTOGRAPHS,
    arc_motion,
    band_passed,
    jumps,
    one_light,
    predict,
)
from engine.capture.registration.pair_motion import (
    MOTIONS,
    SURE,
    Alignment,
    Matrix,
    Refused,
    TooUnlike,
    enlarge,
    first_shift,
    largest_move,
    pyramid,
    refine,
    refuse_degenerate,
    tile_residual,
)
from engine.capture.registration.texture import Grey, choose_supported_motion, texture
from engine.core.health import Finding, Verdict
from engine.core.steps import Step, Steps, part

#: A motion below this is not worth the blur of resampling.
_STILL_PX = 0.02


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
        raise ValueError(f"unknown motion {motion!r}; choose from {', '.join(MOTIONS)}")
    if len({image.shape for image in images}) != 1 or len(images) != len(names):
        raise ValueError("images to align need one size and a name each")
    count = len(images)
    if reference is None:
        reference = int(np.argmax([texture(image) for image in images]))
    matrix = np.tile(np.eye(3), (count, 1, 1))
    residual, confidence = np.full(count, np.nan), np.zeros(count)
    try:
        target = pyramid(images[reference])
    except Refused as refusal:
        stays = Finding(Verdict.WARNING, _NONE_ALIGNED.format(refusal))
        return Alignment(matrix, residual, confidence > 0.0, confidence, reference, (stays,))
    supported = choose_supported_motion(images[reference], motion)
    findings = [] if supported == motion else [Finding(Verdict.NOTE, _UNSUPPORTED.format(motion), names[reference])]
    unlike: dict[int, Finding] = {}
    for done, index in enumerate(_outwards(reference, count), start=1):
        yield Step(0.5 * done / count, f"Aligning {done + 1} of {count}")
        try:
            levels = pyramid(images[index])
            start, ambiguous = first_shift(target[-1], levels, matrix[index + (1 if index < reference else -1)])
            refining = refine(target, levels, start, supported, f"Aligning {done + 1} of {count}")
            spent = 0.5 * done / count
            matrix[index], confidence[index] = yield from part(refining, spent + 0.1 / count, spent + 0.4 / count)
            residual[index] = tile_residual(target[0], levels[0], matrix[index])
            if ambiguous:
                findings.append(Finding(Verdict.WARNING, _AMBIGUOUS.format(ambiguous * factor), names[index]))
        except Refused as refusal:
            flagged = Finding(Verdict.WARNING, _REFUSED.format(refusal), names[index])
            if isinstance(refusal, TooUnlike):
                unlike[index] = flagged
            else:
                findings.append(flagged)
    joined = sorted({reference, *np.flatnonzero(confidence), *unlike})
    if len(joined) >= MIN_PHOTOGRAPHS:
        together = _together([images[n] for n in joined], matrix[joined], joined.index(reference), supported)
        matrix[joined], residual[joined], confidence[joined], drift, doubt = yield from part(together, 0.5, 1.0)
        unlike = {
            index: Finding(Verdict.WARNING, _REFUSED.format("it stays unlike what the others predict"), names[index])
            for index in joined
            if not confidence[index]
        }
        unsure = [names[index] for index, one in zip(joined, doubt, strict=True) if one * factor >= 1.0]
        if unsure:
            text = _UNDETERMINED.format(", ".join(unsure), doubt.max() * factor)
            findings.append(Finding(Verdict.WARNING, text))
        if doubt.any() and np.array_equal(matrix[joined], np.tile(np.eye(3), (len(joined), 1, 1))):
            findings.append(Finding(Verdict.NOTE, _TOO_LITTLE.format(doubt.max() * factor)))
        if drift * factor >= 1.0:
            findings.append(Finding(Verdict.NOTE, _DRIFTS.format(drift * factor)))
    findings += unlike.values()
    aligned = confidence > 0.0
    if aligned.any():
        residual[reference], confidence[reference], aligned[reference] = 0.0, 1.0, True
    whole = np.stack([enlarge(one, factor) for one in matrix])
    return Alignment(whole, residual * factor, aligned, confidence, reference, tuple(findings))


_NONE_ALIGNED = "The photographs could not be aligned and stay as they were: {}"
_REFUSED = "could not be aligned and stays as it was: {}"
_UNSUPPORTED = "has too little texture, or texture in one line only, for a motion of kind {}: shifts are used instead"
_DRIFTS = (
    "The photographs seem to drift by {:.1f} px along one smooth curve from light to light, as shading lets relief "
    "seem to. This was not followed; if the camera did drift, mark control points"
)
_TOO_LITTLE = (
    "The camera seems to have moved by less than can be separated from shading, which is about {:.1f} px: the "
    "photographs stay as they were. Mark control points where it matters"
)
_UNDETERMINED = (
    "The shifts of {} are not determined to better than about {:.1f} px: the camera moved, and shading seems to move "
    "relief as well. Check these, and mark control points where it matters"
)
_AMBIGUOUS = "repeats: a shift that differs by {:.0f} px fits as well. The smallest was taken; check it"


def _together(
    images: list[Grey], start: Matrix, reference: int, motion: str
) -> Steps[tuple[Matrix, NDArray[np.float64], NDArray[np.float64], float, NDArray[np.float64]]]:
    """Matrices, residuals and confidences of photographs aligned together, their apparent drift in pixels, and
    how far off each may be because of that (standard deviation).

    Motions too small to be worth the blur of resampling are left out; what fits badly stays as it was.
    """
    shape = images[0].shape
    photographs = [band_passed(image) for image in images]
    matrix, found, doubt = start, start, np.zeros(len(images))
    if not one_light(photographs, start):
        motions = yield from part(arc_motion(images, start, reference, motion, "Aligning all together"), 0.0, 0.7)
        (matrix, doubt), found = jumps(motions, reference, motion, shape), motions.matrix
    still = np.array([largest_move(one, shape) < _STILL_PX for one in matrix])
    matrix = np.where(still[:, None, None], np.eye(3), matrix)
    mixtures, confidence = yield from part(predict(photographs, matrix), 0.7, 0.9)
    residual = np.full(len(images), np.nan)
    for index, (mixture, photograph) in enumerate(zip(mixtures, photographs, strict=True)):
        yield Step(0.9 + 0.1 * index / len(images), "Checking the alignment")
        try:
            refuse_degenerate(matrix[index], shape)
            if confidence[index] < SURE:
                raise TooUnlike
            residual[index] = tile_residual(mixture, photograph, matrix[index])
        except Refused:
            matrix[index], confidence[index] = np.eye(3), 0.0
    middle = np.array([shape[1] / 2, shape[0] / 2, 1.0])
    there, kept = (places[:, :2] / places[:, 2:] for places in (found @ middle, matrix @ middle))
    drifted = (there - kept)[confidence > 0]
    drift = float(np.hypot(*(drifted.max(axis=0) - drifted.min(axis=0)))) if len(drifted) else 0.0
    return matrix, residual, confidence, drift, np.where(confidence > 0, doubt, 0.0)


def _outwards(reference: int, count: int) -> list[int]:
    """All others, each after its neighbour on the side of the reference, whose motion it starts from."""
    return [*range(reference - 1, -1, -1), *range(reference + 1, count)]

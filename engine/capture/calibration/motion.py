"""Motion of the camera during a capture under lamps all around: a shift for each photograph.

Photographs under neighbouring lamps are alike once the logarithm of their radiance is normalised locally. Each is
registered with its neighbours in the direction of the light (a minimum spanning tree and the two nearest of each
lamp; phase correlation, then ECC, Evangelidis2008), and the shifts that agree best with all of these follow by least
absolute deviations. Relief seems to move with the light, though, so this is only a start: each photograph is then
compared with what the others of its texels predict for its own lamp (`rig`), whose shading is the same, and moved by
Gauss-Newton steps (Lucas1981).

Shifts are used only where they lower the error of photographs that are left out by more than `MIN_GAIN`.
Cost: 1 s of one core for 25 photographs, in windows of at most `WINDOW_PIXELS` of photographs of at most 0.6
megapixels.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.sparse.csgraph import minimum_spanning_tree

from engine.capture.calibration.rig import TERMS, Array, Kind, Rig, Sample, fit, measure_held_out, typical
from engine.capture.registration.texture import Grey, reduce
from engine.core.kernels import serial_kernels
from engine.core.one_thread import one_thread
from engine.core.side_by_side import list_side_by_side
from engine.core.steps import Step, Steps

#: Pixels of the images that are registered as wholes, and of the windows in which shifts are refined.
COARSE_PIXELS, WINDOW_PIXELS, WINDOW_SIDE = 40_000, 12_000, 56

#: Least number of lamps, smallest side in pixels, and share of the held-out error that shifts have to take away: of
#: small shifts, which noise and shading imitate, and of those of `SURE_SHIFT` pixels and more.
FEWEST, MIN_SIDE, MIN_GAIN, SURE_GAIN, SURE_SHIFT = 8, 40, 0.25, 0.1, 0.6

#: Error before shifts are taken off below which a matte model is good enough, and the share of it that a glossy one may
#: leave.
MATTE_ENOUGH, CLEARLY_GLOSSY = 0.05, 0.9

#: Deviation of a shift in pixels that scatter over the image does not show, and the factor by which shifts of glossy
#: texels are less certain: highlights that move with the lamp move alike over the image.
HIDDEN_PX, GLOSSY_GROWTH = 0.1, 2.2

#: Deviation in pixels of the Gaussian whose mean of what is left is shading, and no shift.
BROAD_PX = 6.0

#: Rounds of refinement at most, the largest step in pixels, and the one at which they end.
ROUNDS, LARGEST_STEP, SETTLED_PX = 12, 1.0, 0.01

#: Turns of the refinement before which the rig is fitted, after which photographs are searched anew, their held-out
#: error over the median of all from which they are, and the factor by which the deviation of their shift grows with it
#: at most.
REFITTED, SEARCHED, LOST, MAX_GROWTH = (0, 2), (1, 4), 1.6, 3.0

#: Smallest of the largest shifts, in pixels of the images, that is worth resampling.
MIN_SHIFT = 0.05


@dataclass(frozen=True, eq=False)
class Motion:
    """Shifts (N, 2) of the sample in pixels right and down from the first photograph, and what they leave.

    `residual_px` (N,) is the deviation of each shift, `before` and `after` the held-out errors over the brightness,
    `moved` whether the camera did.
    """

    shifts: Array
    residual_px: Array
    before: float
    after: float
    moved: bool


def camera_motion(images: Sequence[Grey], directions: Array) -> Steps[Motion]:
    """The motion of the camera between luminance `images` (H, W) under lamps in `directions` (N, 3)."""
    count, (height, width) = len(images), images[0].shape
    still = Motion(np.zeros((count, 2)), np.full(count, np.nan), 0.0, 0.0, False)
    if count < FEWEST or min(height, width) < MIN_SIDE:
        return still
    yield Step(0.0, "Looking for motion of the camera")
    factor = max(1, int(np.ceil(np.sqrt(height * width / COARSE_PIXELS))))
    coarse = list_side_by_side(lambda image: _normalise(reduce(image, factor)), images)
    start = factor * _chain(coarse, directions)
    windows = _windows(images)
    best = still
    with one_thread(), serial_kernels():
        starts = [np.zeros((count, 2)), start]
        tried = [_refine(images, directions, each, windows, 0, "matte") for each in starts]
        kind, before = _choose_model(images, directions, windows, tried[0])
        nearer = starts[int(tried[1].after < tried[0].after)]
        found = _refine(images, directions, nearer, windows, ROUNDS, kind)
        gain = 1.0 - found.after / max(before.after, 1e-9)
        largest = float(np.hypot(*(found.shifts - np.median(found.shifts, axis=0)).T).max())
        moved = gain >= (MIN_GAIN if largest < SURE_SHIFT else SURE_GAIN) and largest >= MIN_SHIFT
        shifts = found.shifts if moved else still.shifts
        best = Motion(shifts, found.residual_px, before.after, found.after, moved)
    return best


def _choose_model(
    images: Sequence[Grey], directions: Array, windows: list[tuple[slice, slice]], matte: Motion
) -> tuple[Kind, Motion]:
    """The model of a texel that predicts photographs better before they are shifted, and its error."""
    if matte.after < MATTE_ENOUGH:
        return "matte", matte
    glossy = _refine(images, directions, np.zeros((len(images), 2)), windows, 0, "glossy")
    return ("glossy", glossy) if glossy.after < CLEARLY_GLOSSY * matte.after else ("matte", matte)


def _normalise(image: Grey) -> Grey:
    """Logarithm of radiance over its local mean, over its local deviation."""
    lit = np.maximum(image, 0.0)
    logarithm = np.log(lit + np.float32(0.02 * float(lit.mean()) + 1e-9))
    blur = max(2.0, min(image.shape) / 16.0)
    detail = logarithm - cv2.GaussianBlur(logarithm, (0, 0), blur)
    deviation = np.sqrt(cv2.GaussianBlur(detail * detail, (0, 0), blur))
    return np.asarray(np.clip(detail / (deviation + 1e-3), -3.0, 3.0), np.float32)


def _chain(images: Sequence[Grey], directions: Array) -> Array:
    """(N, 2) shifts that agree best with those between neighbours."""
    edges = _neighbours(directions)
    taper = cv2.createHanningWindow(images[0].shape[::-1], cv2.CV_32F)
    pairs = list_side_by_side(lambda edge: _pair(images[edge[0]], images[edge[1]], taper), edges)
    measured = [shift for shift, _ in pairs]
    sure = [max(confidence, 1e-3) ** 2 for _, confidence in pairs]
    count = len(images)
    matrix = np.zeros((len(edges), count))
    for row, edge in enumerate(edges):
        matrix[row, edge] = -1.0, 1.0
    wanted, weight = np.array(measured), np.array(sure)
    found = np.zeros((count, 2))
    for _ in range(30):
        root = np.sqrt(weight)[:, None]
        found[1:] = np.linalg.lstsq(root * matrix[:, 1:], root * wanted, rcond=None)[0]
        off = np.hypot(*(matrix @ found - wanted).T)
        weight = np.array(sure) / np.maximum(off, 0.05)
    return found


def _neighbours(directions: Array) -> list[tuple[int, int]]:
    """Pairs of lamps: a minimum spanning tree of angles, and the two nearest of each."""
    angle = np.arccos(np.clip(directions @ directions.T, -1.0, 1.0)) + 1e-6
    np.fill_diagonal(angle, 0.0)
    tree = minimum_spanning_tree(angle).tocoo()
    edges = {(min(a, b), max(a, b)) for a, b in zip(tree.row.tolist(), tree.col.tolist(), strict=True)}
    np.fill_diagonal(angle, np.inf)
    for one, row in enumerate(angle):
        edges |= {(min(one, other), max(one, other)) for other in np.argsort(row)[:2].tolist()}
    return sorted(edges)


def _pair(one: Grey, other: Grey, taper: Grey) -> tuple[Array, float]:
    """The shift of `other` from `one`, and how alike they then are."""
    starts = [np.zeros(2), np.array(cv2.phaseCorrelate(one, other, taper)[0])]
    limit = 0.3 * min(one.shape)
    found, best = np.zeros(2), 0.0
    for start in starts:
        if np.hypot(*start) > limit:
            continue
        warp = np.array([[1.0, 0.0, start[0]], [0.0, 1.0, start[1]]], np.float32)
        criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 40, 1e-4)
        try:
            alike, warp = cv2.findTransformECC(one, other, warp, cv2.MOTION_TRANSLATION, criteria, None, 3)
        except cv2.error:
            continue
        if alike > best and np.hypot(*warp[:, 2]) <= limit:
            found, best = warp[:, 2].astype(np.float64), float(alike)
    return found, best


def _windows(images: Sequence[Grey]) -> list[tuple[slice, slice]]:
    """Parts of the image of most texture; all of it where it is small."""
    height, width = images[0].shape
    if height * width <= WINDOW_PIXELS:
        return [(slice(0, height), slice(0, width))]
    mean = images[0].copy()
    for image in images[1:]:
        mean += image
    mean /= len(images)
    steep = np.hypot(*np.gradient(np.asarray(cv2.GaussianBlur(mean, (0, 0), 1.0), np.float64))) / (
        mean + 0.05 * float(mean.mean()) + 1e-9
    )
    side = min(WINDOW_SIDE, height, width)
    found = [
        (float(np.median(steep[top : top + side, left : left + side])), top, left)
        for top in range(0, height - side + 1, side)
        for left in range(0, width - side + 1, side)
    ]
    chosen = sorted(found, reverse=True)[: max(1, WINDOW_PIXELS // side**2)]
    return [(slice(top, top + side), slice(left, left + side)) for _, top, left in chosen]


def _refine(
    images: Sequence[Grey], directions: Array, start: Array, windows: list[tuple[slice, slice]], rounds: int, kind: Kind
) -> Motion:
    """Shifts refined against what the other photographs predict, and the held-out error that they leave."""
    shifts, rig = start - start[0], Rig.plain(len(directions))
    terms = TERMS
    steps = np.zeros((1, len(images), 2))
    for turn in range(rounds + 1):
        parts = [_align(images, window, shifts) for window in windows]
        values = np.concatenate([part.reshape(len(images), -1) for part in parts], axis=1).T.astype(np.float64)
        sample = _sample(values, images[0].shape, windows)
        if turn in REFITTED:
            some = np.arange(len(values)) % max(1, len(values) // 600) == 0
            rig = fit(sample.of(some), directions, terms, rig, kind).rig
        left = _measure_by_chunks(sample, directions, rig, kind)
        error = typical(left, sample.usable)
        if turn == rounds:
            break
        steps = _steps(values, left * sample.brightness[:, None], windows)
        step = np.clip(np.median(steps, axis=0), -LARGEST_STEP, LARGEST_STEP)
        if turn in SEARCHED:
            step = _search(parts, left * sample.brightness[:, None], step)
        shifts = shifts + step - step[0]
        is_searched = turn > max(SEARCHED) or (turn >= REFITTED[-1] and not (_relative_errors(left) > LOST).any())
        if is_searched and np.abs(step - step[0]).max() < SETTLED_PX:
            rounds = turn + 1
    scatter = 1.2533 * steps.std(axis=0) / np.sqrt(max(len(steps), 1)) if rounds else np.zeros((len(images), 2))
    residual = np.hypot(np.hypot(*(2.0 * scatter + np.abs(np.median(steps, axis=0))).T), HIDDEN_PX)
    # a photograph that fits elsewhere scatters little there
    residual *= np.clip((_relative_errors(left) / LOST) ** 2, 1.0, MAX_GROWTH)
    residual *= GLOSSY_GROWTH if kind == "glossy" else 1.0
    return Motion(shifts, residual, 0.0, float(np.mean(error)), False)


def _measure_by_chunks(sample: Sample, directions: Array, rig: Rig, kind: Kind) -> Array:
    """(T, N) held-out residuals, of some texels at once."""
    texels, count = sample.values.shape
    chunks = np.array_split(np.arange(texels), max(1, texels * count // 100_000))

    def measure(chunk: NDArray[np.int64]) -> Array:
        return measure_held_out(sample.of(np.isin(np.arange(texels), chunk)), directions, rig, kind)

    return np.concatenate(list_side_by_side(measure, chunks))


def _relative_errors(left: Array) -> Array:
    """(N,) held-out errors of photographs, of residuals (T, N), over their median."""
    errors = np.median(np.abs(left), axis=0)
    return np.asarray(errors / max(float(np.median(errors)), 1e-9))


def _search(parts: Sequence[Grey], left: Array, step: Array) -> Array:
    """`step` (N, 2) with those of photographs that fit badly, by correlation with what the others predict of them.

    Grain that repeats, and highlights, make a photograph fit its neighbours some texels beside its place, from where no
    small step leads back. `parts` are the windows (N, h, w) of all photographs, `left` (T, N) the residuals in them.
    """
    found = step.copy()
    largest = max(range(len(parts)), key=lambda place: parts[place][0].size)
    first = sum(part[0].size for part in parts[:largest])
    shape = parts[largest].shape
    off = left[first : first + parts[largest][0].size].T.reshape(shape)
    taper = cv2.createHanningWindow(shape[:0:-1], cv2.CV_32F)
    for index in np.flatnonzero(_relative_errors(left) > LOST):
        seen = parts[largest][index]
        shown = np.asarray(seen - off[index], np.float32)
        shift, alike = _pair(_normalise(shown), _normalise(seen), taper)
        if alike > 0.0:
            found[index] = shift
    return found


def _align(images: Sequence[Grey], window: tuple[slice, slice], shifts: Array) -> NDArray[np.float32]:
    """(N, h, w) a window of the images, each moved back by its shift."""
    rows, columns = window
    size = (columns.stop - columns.start, rows.stop - rows.start)
    found = []
    for image, (across, down) in zip(images, shifts, strict=True):
        matrix = np.array([[1.0, 0.0, columns.start + across], [0.0, 1.0, rows.start + down]])
        flags = cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP
        found.append(cv2.warpAffine(image, matrix, size, flags=flags, borderMode=cv2.BORDER_REPLICATE))
    return np.stack(found)


def _sample(values: Array, shape: tuple[int, ...], windows: list[tuple[slice, slice]]) -> Sample:
    mean = np.maximum(values.mean(axis=1), 1e-6)
    height, width = shape
    places = []
    for rows, columns in windows:
        down, right = np.mgrid[rows, columns]
        places.append(np.stack([(right + 0.5) / width - 0.5, (0.5 * height - 0.5 - down) / width], axis=-1))
    positions = np.concatenate([each.reshape(-1, 2) for each in places])
    usable = values < 0.98
    return Sample(values / mean[:, None], usable, positions, mean, np.zeros(len(values), np.int64))


def _steps(values: Array, left: Array, windows: list[tuple[slice, slice]]) -> Array:
    """(blocks, N, 2) shifts left in each block of the windows, of photographs (T, N) with held-out residuals (T, N)."""
    sizes = [(rows.stop - rows.start, columns.stop - columns.start) for rows, columns in windows]
    ends = np.cumsum([height * width for height, width in sizes])
    parts = 2 if len(windows) > 1 else 3

    def find(place: int) -> list[Array]:
        here = slice(ends[place] - math.prod(sizes[place]), ends[place])
        return _steps_in_window(values[here], left[here], sizes[place], parts)

    return np.stack([each for found in list_side_by_side(find, range(len(windows))) for each in found])


def _steps_in_window(values: Array, left: Array, size: tuple[int, int], parts: int) -> list[Array]:
    """(N, 2) of each of `parts` times as many blocks of one window of this `size`."""
    count = values.shape[1]
    shown, off = ((each.T).reshape(count, *size) for each in (values - left, left))
    limit = 4.0 * 1.4826 * np.median(np.abs(off), axis=(1, 2), keepdims=True) + 1e-9
    weight = (np.abs(off) < limit).astype(np.float64)
    rows, columns = (ndimage.gaussian_filter1d(np.eye(side), BROAD_PX, axis=0) for side in size)
    broad = rows @ (off * weight) @ columns.T / (rows @ weight @ columns.T + 1e-9)
    off = off - broad
    down, right = (np.asarray(np.gradient(shown, axis=axis), np.float64) for axis in (1, 2))
    weight[:, :2], weight[:, -2:], weight[:, :, :2], weight[:, :, -2:] = 0.0, 0.0, 0.0, 0.0
    found = []
    for row in range(parts):
        for column in range(parts):
            lines, across = (
                slice(k * n // parts, (k + 1) * n // parts) for k, n in zip((row, column), size, strict=True)
            )
            w, r, d, e = (each[:, lines, across] for each in (weight, right, down, off))
            rr, rd, dd = ((w * a * b).sum(axis=(1, 2)) for a, b in ((r, r), (r, d), (d, d)))
            re, de = (-(w * a * e).sum(axis=(1, 2)) for a in (r, d))
            determinant = rr * dd - rd * rd + 1e-3 * (rr + dd) ** 2 + 1e-30
            found.append(np.stack([(dd * re - rd * de) / determinant, (rr * de - rd * re) / determinant], axis=-1))
    return found

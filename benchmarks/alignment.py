"""Error of alignment against known motions: simulated light arcs, each photograph moved, rotated and bent.

Ten lights from 5 to 90 degrees fall on a sample of the virtual arc; each photograph is warped by a motion of the kind
that alignment is asked for, whose shift is up to so many pixels along both axes and which moves the corners by about as
much more, and has noise at a signal-to-noise ratio of 30 dB. Errors are root mean squares over the image and the
photographs from 20 degrees on, once relative to the reference, and once relative to the photographs' mean: on that
depends how sharp a shading map is, while a shift of all together only moves it.
Cost: some 15 s and as much again for each motion, per sample.
"""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.measure import Accuracy
from engine.capture.registration.align import align
from engine.capture.registration.pair_motion import MOTIONS, Alignment
from engine.core.colour import luminance
from engine.core.steps import Steps, part
from engine.simulate.arc import ELEVATIONS_DEG, LightArc
from engine.simulate.simulate import renderings

Grey = NDArray[np.float32]
Matrix = NDArray[np.float64]

SIZE, BORDER = 512, 48
SAMPLES = ("woven", "hammered", "leather")
#: Largest shift, and how many of the photographs are moved.
CASES = ((0.6, 10), (3.0, 10), (3.0, 2))
SNR_DB = 30.0
_FROM_DEG = 20.0


def measures(folder: Path) -> Steps[list[Accuracy]]:
    """Errors of all samples, motions and cases; `folder` is not used."""
    found: list[Accuracy] = []
    for index, sample in enumerate(SAMPLES):
        first, last = index / len(SAMPLES), (index + 1) / len(SAMPLES)
        found += yield from part(_measure_sample(sample), first, last)
    return found


def _measure_sample(sample: str) -> Steps[list[Accuracy]]:
    arc = LightArc(sample, size=SIZE + 2 * BORDER, misalignment_px=0.0)
    images = yield from part(renderings(arc, [math.radians(angle) for angle in ELEVATIONS_DEG]), 0.0, 0.3)
    luminances = [luminance(image).astype(np.float32) for image in images]
    found: list[Accuracy] = []
    runs = [(motion, case) for motion in MOTIONS for case in CASES]
    for index, (motion, (shift_px, count)) in enumerate(runs):
        photographs, truth = move(luminances, motion, shift_px, count)
        names = [f"{angle:g}" for angle in ELEVATIONS_DEG]
        start = 0.3 + 0.7 * index / len(runs)
        alignment = yield from part(align(photographs, names, motion), start, start + 0.7 / len(runs))
        before, after = errors_px(None, truth, alignment.reference), errors_px(alignment, truth, alignment.reference)
        name = f"{sample}-{motion}-{shift_px:g}px-{count}"
        what = f"of {before[0]:.2f}, relative to the reference, pixels"
        found.append(Accuracy(name, after[0], what))
        found.append(
            Accuracy(f"{name}-mean", after[1], f"of {before[1]:.2f}, relative to the photographs' mean, pixels")
        )
    return found


def move(
    images: list[Grey], motion: str, shift_px: float, count: int, seed: int = 1
) -> tuple[list[Grey], list[Matrix]]:
    """The middle of the images, of which `count` are moved by known motions (from the still frame), with noise."""
    random = np.random.default_rng(seed)
    chosen = set(random.choice(len(images), count, replace=False))
    size = images[0].shape[0] - 2 * BORDER
    truth = [_motion(motion, shift_px, size, random) for _ in images]
    truth = [matrix if index in chosen else np.eye(3) for index, matrix in enumerate(truth)]
    inner = np.array([[1, 0, BORDER], [0, 1, BORDER], [0, 0, 1.0]])
    photographs = []
    for image, matrix in zip(images, truth, strict=True):
        flags = cv2.INTER_LANCZOS4 | cv2.WARP_INVERSE_MAP
        seen = cv2.warpPerspective(image, inner @ np.linalg.inv(matrix), (size, size), flags=flags)
        noise = math.sqrt(float(np.mean(seen.astype(np.float64) ** 2)) * 10 ** (-SNR_DB / 10))
        photographs.append((seen + random.normal(0, noise, seen.shape)).astype(np.float32))
    return photographs, truth


def errors_px(alignment: Alignment | None, truth: list[Matrix], reference: int) -> tuple[float, float]:
    """Root mean square error relative to the reference and to the mean; None stands for no alignment at all."""
    places = np.stack(np.meshgrid(*[np.linspace(0, SIZE - 1, 5)] * 2), axis=-1).reshape(-1, 2)
    base = np.linalg.inv(truth[reference])
    missed = []
    for index, matrix in enumerate(truth):
        found = places if alignment is None else _at(alignment.matrix[index], places)
        missed.append(found - _at(matrix @ base, places))
    errors = np.array(missed)[np.array(ELEVATIONS_DEG) >= _FROM_DEG]
    return _rms(errors), _rms(errors - errors.mean(axis=0))


def _rms(errors: Matrix) -> float:
    return float(np.sqrt((errors**2).sum(axis=-1).mean()))


def _at(matrix: Matrix, places: Matrix) -> Matrix:
    there = places @ matrix[:, :2].T + matrix[:, 2]
    moved_places: Matrix = there[:, :2] / there[:, 2:]
    return moved_places


def _motion(motion: str, shift_px: float, size: int, random: np.random.Generator) -> Matrix:
    """A motion of the kind about the middle of the image; each parameter moves the edges by up to `shift_px`."""
    half = size / 2
    turn, drawn = random.uniform(-shift_px, shift_px) / half, random.uniform(-shift_px, shift_px, 8)
    matrix = np.eye(3)
    if motion != "translation":
        matrix[:2, :2] = [[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]]
    if motion in ("affine", "homography"):
        matrix[:2, :2] += drawn[:4].reshape(2, 2) / half
    if motion == "homography":
        matrix[2, :2] = drawn[4:6] / half**2
    matrix[:2, 2] = drawn[6:]
    middle = np.array([[1, 0, (size - 1) / 2], [0, 1, (size - 1) / 2], [0, 0, 1.0]])
    return middle @ matrix @ np.linalg.inv(middle)

"""The reference: direct or path-traced light by Monte Carlo, with its own uncertainty, against which errors are
measured.

Samples are taken in passes whose numbers are independent of each other; inside a pass the samples of a pixel are
stratified (`engine.render.sobol`). The mean over passes is the image, and how passes of one length differ tells the
variance of that mean, pixel by pixel, whatever stratification gained. Sums are in float64. A pass is cut into batches
that all threads share and whose sums are added in one order: the image depends on the scene, the size, the numbers
of samples and the seed alone, not on the number of threads.

An image without end is taken in rounds. Each round has one pass of the same length for each of a few parts, which are
independent images of equal quality. Longer passes are stratified better than short ones, so that passes of several
lengths would not tell the variance; parts do, at the end of each round.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from itertools import count

import numpy as np
from numpy.typing import NDArray

from engine.core.budget import thread_count
from engine.core.steps import Step, Steps
from engine.render.path import Paths, Traced
from engine.render.sobol import seed_state
from engine.scene.scene import Scene

Floats = NDArray[np.float64]

#: Passes that a number of samples is divided into, at least, where there are as many samples.
PASSES = 16

#: Samples of a pixel in a pass of an image without end, once it has as many.
LONGEST_PASS = 16

#: Parts of an image without end, of small and of large images, and pixels of the largest that counts as small.
PARTS, FEW_PARTS, SMALL = 8, 4, 1 << 18

#: Paths of one batch: some 30 ms of work, and arrays that stay in the cache.
BATCH = 1 << 14

#: Seconds between images that are shown on the way.
SHOWN_EVERY = 0.2

#: Bytes that a pixel takes while its image is made.
BYTES_PER_PIXEL = 240


@dataclass(frozen=True, eq=False)
class ReferenceImage:
    """An image and how sure it is.

    Attributes
    ----------
    image : (height, width, 4) float32, linear radiance times coverage, and coverage; finite, not negative.
    variance : (height, width, 3) float64, of the mean that `image` is, without end of what it was at the last round;
        None before two passes, or one round, are complete.
    samples : of each pixel; while a pass is under way, some have more.
    passes : complete ones.
    rays : cast so far.
    rejected : samples that were not finite and count as 0.
    parts : (parts, height, width, 3) float32, independent images of equally many samples of all complete rounds; None
        where there is no complete round, and of an image with an end.
    """

    image: NDArray[np.float32]
    variance: Floats | None
    samples: int
    passes: int
    rays: int
    rejected: int
    parts: NDArray[np.float32] | None = None

    @property
    def uncertainty_rmse_rel(self) -> float | None:
        """The standard error of the whole image relative to its root mean square; None before two passes.

        It is what `rmse_rel` of this image against a converged image is expected to be.
        """
        if self.variance is None:
            return None
        power = float(np.sum(np.square(self.image[..., :3], dtype=np.float64)))
        return float(np.sqrt(self.variance.sum() / power)) if power > 0.0 else 0.0


def reference(
    scene: Scene,
    size: tuple[int, int],
    *,
    samples: int | None = 64,
    max_depth: int = 1,
    seed: int = 0,
    threads: int | None = None,
) -> Steps[ReferenceImage]:
    """The image of `size` (width, height) with `samples` for each pixel, or without end where that is None.

    Steps carry a `ReferenceImage` of what there is so far as `partial`, some of them, about every 0.2 s. `max_depth`
    is the number of points of the surface that light may touch; 1 is direct light with shadows. Raises ValueError for
    numbers below 1, a seed below 0, and a look-up that has no reference (`engine.render.path`).
    """
    width, height = size
    if samples is not None and samples < 1:
        raise ValueError(f"samples = {samples} must be at least 1")
    seed_state(seed, 0)
    parts = 0 if samples is not None else PARTS if width * height <= SMALL else FEW_PARTS
    progress = _Progress(height, width, parts)
    if min(size) < 1:
        return progress.image()
    paths = Paths(scene, size, max_depth)
    workers = threads or thread_count()
    waiting: deque[tuple[_Batch, Future[Traced]]] = deque()
    shown = time.monotonic()
    pool = ThreadPoolExecutor(workers)
    try:
        for batch in _batches(width * height, samples, parts):
            waiting.append((batch, pool.submit(_trace, paths, seed, batch)))
            if len(waiting) <= 2 * workers:
                continue
            progress.add(*_first(waiting))
            partial = None
            if time.monotonic() - shown >= SHOWN_EVERY:
                partial, shown = progress.image(), time.monotonic()
            yield Step(progress.done(samples), f"Reference, {progress.samples} samples", partial)
        while waiting:
            progress.add(*_first(waiting))
            yield Step(progress.done(samples), f"Reference, {progress.samples} samples")
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
    return progress.image()


@dataclass(frozen=True)
class _Batch:
    """Samples `first_sample` … + `samples` of pixels `first` … + `pixels` in a pass; `ends` one of `length` samples."""

    number: int
    first: int
    pixels: int
    first_sample: int
    samples: int
    length: int
    ends: bool


def _batches(pixels: int, samples: int | None, parts: int) -> Iterator[_Batch]:
    """All batches in order: few samples of all pixels come before more samples of any."""
    for number, length in enumerate(pass_lengths(samples, parts)):
        together = min(length, max(1, BATCH // pixels))
        for first_sample in range(0, length, together):
            taken = min(together, length - first_sample)
            for first in range(0, pixels, BATCH):
                here = min(BATCH, pixels - first)
                ends = first + here == pixels and first_sample + taken == length
                yield _Batch(number, first, here, first_sample, taken, length, ends)


def pass_lengths(samples: int | None, parts: int = 0) -> Iterator[int]:
    """Samples of each pass: powers of two, which are stratified best, and what is left over.

    Without end there are rounds of as many passes as `parts`, of 1, 1, 2, 4, 8 … `LONGEST_PASS` samples each, so that
    images and their variance are there soon.
    """
    if samples is None:
        of_part = 0
        for _ in count():
            length = min(max(of_part, 1), LONGEST_PASS)
            of_part += length
            yield from [length] * parts
        return
    length = 1 << max(samples // PASSES, 1).bit_length() - 1
    yield from [length] * (samples // length)
    if samples % length:
        yield samples % length


def _trace(paths: Paths, seed: int, batch: _Batch) -> Traced:
    """The sums over the samples of each pixel of a batch."""
    pixel = np.tile(np.arange(batch.first, batch.first + batch.pixels), batch.samples)
    sample = np.repeat(np.arange(batch.first_sample, batch.first_sample + batch.samples), batch.pixels)
    traced = paths(seed_state(seed, batch.number), pixel, sample)
    shape = (batch.samples, batch.pixels)
    radiance, coverage = traced.radiance.reshape(*shape, 3).sum(axis=0), traced.coverage.reshape(shape).sum(axis=0)
    return Traced(radiance, coverage, traced.rays, traced.rejected)


def _first(waiting: deque[tuple[_Batch, Future[Traced]]]) -> tuple[_Batch, Traced]:
    batch, future = waiting.popleft()
    return batch, future.result()


class _Progress:
    """Sums of radiance and coverage, and of squares of what passes differ by (Welford1962, weighted by samples).

    Without end there are sums of each of the `parts` in place of squares.
    """

    def __init__(self, height: int, width: int, parts: int) -> None:
        self._shape = (height, width)
        self._of_parts = np.zeros((parts, height * width, 3), np.float32)
        self._parts: NDArray[np.float32] | None = None
        self._variance: Floats | None = None
        pixels = height * width
        self._sum, self._pass = np.zeros((pixels, 4)), np.zeros((pixels, 4))
        self._mean, self._squares = np.zeros((pixels, 3)), np.zeros((pixels, 3))
        self._taken = np.zeros(pixels, np.int64)
        self._before = 0
        self._passes = self._rays = self._rejected = 0

    @property
    def samples(self) -> int:
        return int(self._taken.min()) if self._taken.size else 0

    def done(self, samples: int | None) -> float:
        return 0.0 if samples is None else float(self._taken.mean()) / samples

    def add(self, batch: _Batch, traced: Traced) -> None:
        pixels = slice(batch.first, batch.first + batch.pixels)
        self._pass[pixels, :3] += traced.radiance
        self._pass[pixels, 3] += traced.coverage
        self._taken[pixels] += batch.samples
        self._rays += traced.rays
        self._rejected += traced.rejected
        if batch.ends:
            self._end_pass(batch.length)

    def _end_pass(self, length: int) -> None:
        self._sum += self._pass
        self._before += length
        if len(self._of_parts):
            self._add_to_parts()
            return
        step = self._pass[:, :3] / length - self._mean
        self._mean += step * (length / self._before)
        self._squares += length * step * (self._pass[:, :3] / length - self._mean)
        self._pass[:] = 0.0
        self._passes += 1

    def _add_to_parts(self) -> None:
        """Add a pass to its part; at the end of a round, say how parts differ."""
        count = len(self._of_parts)
        self._of_parts[self._passes % count] += self._pass[:, :3]
        self._pass[:] = 0.0
        self._passes += 1
        if self._passes % count == 0:
            self._parts = (self._of_parts * np.float32(count / self._before)).reshape(count, *self._shape, 3)
            self._variance = self._parts.var(axis=0, ddof=1, dtype=np.float64) / count

    def image(self) -> ReferenceImage:
        mean = (self._sum + self._pass) / np.maximum(self._taken, 1)[:, None]
        variance = self._variance
        if self._passes > 1 and not len(self._of_parts):
            variance = (self._squares / (self._before * (self._passes - 1))).reshape(*self._shape, 3)
        image = np.clip(mean, 0.0, np.finfo(np.float32).max).astype(np.float32).reshape(*self._shape, 4)
        return ReferenceImage(image, variance, self.samples, self._passes, self._rays, self._rejected, self._parts)

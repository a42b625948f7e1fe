"""The error of image A on screen against image B, computed off the window's thread once both are complete.

What OpenGL has drawn is read back strip by strip between events; the figures come from a job. The mask is what both
images cover completely, so that silhouettes, which each method places a little differently, do not count.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, QTimer, Signal

from app.jobs.jobs import Jobs
from app.jobs.newest import Latest
from engine.accuracy.flip import flip_estimate
from engine.core.figure_text import percent_within
from engine.core.steps import Step, Steps

Pixels = NDArray[np.float32]

#: Coverage from which a pixel is taken to be covered completely.
COVERED = 0.999

#: Share of an error, and error, that may be uncertain without anybody wanting to know more.
CERTAIN, NOTHING = 0.04, 2e-4


@dataclass(frozen=True)
class ImageError:
    """Relative RMSE of A against B with its uncertainty (95 %), FLIP (None before it is known), the largest difference.

    `scale` is a round luminance for the image of the difference, `pixels` how many both cover, and `samples` those of
    each pixel of a reference that is uncertain, 0 where there is none.
    """

    rmse_rel: float
    uncertainty: float
    flip: float | None
    max_abs: float
    pixels: int
    scale: float
    samples: int = 0

    @property
    def is_certain(self) -> bool:
        """True if the uncertainty is small beside the error, or absolutely: more samples would change no reading."""
        return self.uncertainty <= max(CERTAIN * self.rmse_rel, NOTHING)

    @property
    def text(self) -> str:
        """'1.2 ± 0.1 %': as many digits as are certain, at most two behind the point."""
        return percent_within(self.rmse_rel, self.uncertainty)


@dataclass(frozen=True, eq=False)
class Side:
    """One image (H, W, 4).

    An image by Monte Carlo has the variance of its values (H, W, 3), its number of samples, and the independent `parts`
    (P, H, W, 3) that it is the mean of.
    """

    image: Pixels
    variance: NDArray[np.float64] | float = 0.0
    samples: int = 0
    parts: NDArray[np.float32] | None = None


class Comparing(QObject):
    """Computes the error of the newest pair. `found(error)` follows, and again with FLIP if that is requested."""

    found = Signal(object)

    def __init__(self, jobs: Jobs) -> None:
        super().__init__()
        self._figures = Latest(jobs, "Comparing images")
        self._eye = Latest(jobs, "Comparing images as an eye does", lane="background")
        self._timer = QTimer(self)
        self._timer.setInterval(0)
        self._timer.timeout.connect(self._read)
        self._strips: Iterator[Pixels] = iter(())
        self._rows: list[Pixels] = []
        self._done: Callable[[Pixels], None] | None = None
        self._images = 0

    def read(self, strips: Iterator[Pixels], done: Callable[[Pixels], None]) -> None:
        """Collect an image from its `strips` and hand it to `done`; an unfinished one is dropped."""
        self._strips, self._rows, self._done = strips, [], done
        self._timer.start()

    @property
    def reading(self) -> bool:
        return self._timer.isActive()

    def _read(self) -> None:
        rows = next(self._strips, None)
        if rows is not None:
            self._rows.append(rows)
            return
        self._timer.stop()
        if self._rows and self._done is not None:
            self._done(np.concatenate(self._rows))

    def weigh(self, a: Side) -> None:
        """Estimate the error of `a` from its own noise."""
        asked = self._images

        def show(error: ImageError | None) -> None:
            if error is not None and asked == self._images:
                self.found.emit(error)

        self._figures.ask(lambda: _noise(a), show)

    def compare(self, a: Side, b: Side, *, with_flip: bool) -> None:
        """Find the error of `a` against `b`, unless something newer comes first."""
        asked = self._images

        def show(error: ImageError | None) -> None:
            if error is None or asked != self._images:
                return  # what was found is of images that are gone
            self.found.emit(error)
            if with_flip and error.flip is None:
                self._eye.ask(lambda: _with_flip(a, b, error), show)

        self._figures.ask(lambda: _figures(a, b), show)

    def drop(self) -> None:
        """The images are others: forget these."""
        self._images += 1
        self._timer.stop()
        self._done = None
        self._figures.drop()
        self._eye.drop()


def _alike(a: Side, b: Side) -> tuple[Side, Side]:
    """Both with the pixels of the smaller one, of which each is the mean of what it covers."""
    sizes = [(side.image.shape[1], side.image.shape[0]) for side in (a, b)]
    if sizes[0] == sizes[1]:
        return a, b
    shape = min(sizes)[::-1]
    made = [replace(side, image=_resize(side.image, shape)) for side in (a, b)]
    return made[0], made[1]


def _resize(image: Pixels, shape: tuple[int, ...]) -> Pixels:
    """`image` with as many rows and columns as `shape` has, of which each is the mean of what it covers."""
    if image.shape[:2] == shape[:2]:
        return image
    import cv2

    return cv2.resize(image, shape[1::-1], interpolation=cv2.INTER_AREA)


def _measure_coverage(a: Side, b: Side) -> NDArray[np.bool_]:
    return np.asarray((a.image[..., 3] >= COVERED) & (b.image[..., 3] >= COVERED), np.bool_)


def _figures(a: Side, b: Side) -> Steps[ImageError | None]:
    """None where the images have nothing in common."""
    yield Step(0.0, "comparing images")
    from engine.accuracy.compare import error_against, error_against_parts
    from engine.accuracy.difference import compute_signed_difference

    a, b = _alike(a, b)
    mask = _measure_coverage(a, b)
    if not mask.any():
        return None
    first, second = a.image[mask][None, :, :3], b.image[mask][None, :, :3]
    yield Step(0.3, "comparing images")
    parts = b.parts if b.parts is not None else a.parts
    if parts is None:
        found = error_against(first, second)
    else:
        estimates = np.array([_resize(part, mask.shape)[mask][None] for part in parts])
        is_first = b.parts is None
        found = error_against_parts(second if is_first else first, estimates, relative_to_a=is_first)
    yield Step(0.6, "comparing images")
    _, scale = compute_signed_difference(first, second)
    largest = float(np.abs(first - second).max())
    samples = max(a.samples, b.samples)
    return ImageError(found.rmse_rel, found.uncertainty, None, largest, int(mask.sum()), scale, samples)


def _noise(a: Side) -> Steps[ImageError | None]:
    """The error of a Monte Carlo image, from its own variance; None where it shows nothing.

    The squared error is a sum over pixels, each of which has twice the square of its variance as variance where its
    channels rise and fall together.
    """
    yield Step(0.0, "weighing noise")
    from engine.accuracy.compare import DEVIATIONS

    mask = a.image[..., 3] >= COVERED
    power = float(np.sum(np.square(a.image[mask][:, :3], dtype=np.float64)))
    if power <= 0.0:
        return None
    of_pixel = np.broadcast_to(a.variance, (*mask.shape, 3))[mask].sum(axis=-1)
    squared = float(of_pixel.sum())
    spread = DEVIATIONS * math.sqrt(2.0 * float(np.sum(of_pixel**2)))
    low, middle, high = (math.sqrt(max(value, 0.0) / power) for value in (squared - spread, squared, squared + spread))
    pixels = int(mask.sum())
    return ImageError(middle, max(high - middle, middle - low), None, 0.0, pixels, 0.0, a.samples)


def _with_flip(a: Side, b: Side, error: ImageError) -> Steps[ImageError]:
    a, b = _alike(a, b)
    found = yield from flip_estimate(a.image[..., :3], b.image[..., :3], _measure_coverage(a, b))
    return replace(error, flip=found)

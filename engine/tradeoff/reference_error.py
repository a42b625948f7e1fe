"""The one reference that all settings are measured against, refined as far as there is time.

Its noise is taken off every error and stated as their uncertainty (`engine.accuracy.compare.error_against`). Only
pixels count that the model covers completely, in the reference and in an image drawn of it: silhouettes, which each
method places a little differently, do not.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.accuracy.compare import ErrorEstimate, comparison, error_against, error_against_parts, noise_of
from engine.core.errors import UsageError
from engine.core.steps import Step, Steps
from engine.render.reference import ReferenceImage, reference
from engine.scene.scene import Scene

#: Coverage from which a pixel is taken to be covered completely.
COVERED = 0.999

#: Passes from which the variance between them is believed, and where it is only a first glance.
PASSES, FEW_PASSES = 8, 3

#: Noise, relative to the image, below which the reference is not refined any further, and samples at most.
QUIET, MAX_SAMPLES = 0.002, 1 << 14


@dataclass(frozen=True, eq=False)
class NoisyReference:
    """A reference, the mask (height, width) of what is compared, and its noise as relative RMSE."""

    reference: ReferenceImage
    mask: NDArray[np.bool_]
    noise: float

    def error(self, image: NDArray[np.float32]) -> ErrorEstimate:
        parts = self.reference.parts
        if parts is not None:
            return error_against_parts(image, parts, self.mask)
        return error_against(image, self.reference.image, self._variance, self.mask)

    def flip(self, image: NDArray[np.float32]) -> Steps[float]:
        """Mean ꟻLIP of an image against it."""
        return (yield from comparison(image, self.reference.image, self.mask)).flip

    @property
    def _variance(self) -> NDArray[np.float64]:
        variance = self.reference.variance
        assert variance is not None
        return variance


class Refining:
    """A reference under way. `refine` goes on where it stopped; `close` ends it."""

    def __init__(self, scene: Scene, size: tuple[int, int], max_depth: int, seed: int) -> None:
        self._steps = reference(scene, size, samples=None, max_depth=max_depth, seed=seed)
        self.covered = np.ones((size[1], size[0]), np.bool_)
        self.found: ReferenceImage | None = None

    def refine(self, seconds: float, noise: float = QUIET, passes: int = PASSES) -> Steps[NoisyReference]:
        """Take samples for so many seconds, or until the noise is low; at least so many `passes`.

        UsageError where nothing is covered.
        """
        started = time.monotonic()
        while True:
            step = next(self._steps)
            if step.partial is not None:
                self.found = step.partial
                if self._is_known(self.found, passes) and self._is_enough(started, seconds, noise):
                    return self.current()
            passed = (time.monotonic() - started) / max(seconds, 1e-9)
            yield Step(min(1.0, passed), "refining the reference")

    def _is_known(self, found: ReferenceImage, passes: int) -> bool:
        return found.passes >= passes and found.variance is not None

    def _is_enough(self, started: float, seconds: float, noise: float) -> bool:
        assert self.found is not None
        late = time.monotonic() - started >= seconds
        return late or self.found.samples >= MAX_SAMPLES or self.current().noise <= noise

    def current(self) -> NoisyReference:
        """As far as it is now."""
        found = self.found
        assert found is not None
        assert found.variance is not None
        mask = self.covered & (found.image[..., 3] >= COVERED)
        if not mask.any():
            raise UsageError("no pixel is covered completely: the image is too small, or the model is out of sight")
        return NoisyReference(found, mask, noise_of(found.image, found.variance, mask))

    def close(self) -> None:
        self._steps.close()

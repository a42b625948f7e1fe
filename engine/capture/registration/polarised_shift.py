"""The shift between the two photographs of pairs under polarisers: turning a filter moves a camera.

Both photographs of a pair have the same lamp, so that they differ by highlights alone. ECC (Evangelidis2008) compares
the logarithms of both, without their slow change. All pairs are moved by the median where they agree, which they do
when all photographs were taken through one polariser after the other, else each by its own shift.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.capture.registration.texture import Grey

Array = NDArray[np.float64]

#: Shifts in pixels of the compared images that are not told from none, and scatter of pairs that have one each.
NO_SHIFT, OWN_SHIFTS = 0.05, 0.15

#: Shortest side that is compared, and standard deviation of what counts as slow change, in pixels.
MIN_SIDE, SLOW = 32, 6.0


@dataclass(frozen=True, eq=False)
class PairShift:
    """Positions of crossed photographs beside parallel ones: (N, 2) pixels to the right and down, zero if unmoved, and
    the median over pairs of what they differ by."""

    shifts: Array
    scatter: float

    def as_json(self) -> dict[str, Any]:
        """Return the numbers for records."""
        return {"shifts_px": self.shifts.tolist(), "shift_scatter_px": self.scatter}

    def text(self) -> str:
        """Return a sentence for the user, empty where nothing moved."""
        if not self.shifts.any():
            return ""
        largest = float(np.hypot(*self.shifts.T).max())
        alike = "all alike" if np.ptp(self.shifts, axis=0).max() == 0.0 else "each by its own shift"
        return f"Crossed photographs lie up to {largest:.2g} px from parallel ones and were moved back, {alike}"


def measure_shift(parallel: Grey, crossed: Grey) -> Array:
    """(2,) pixels to the right and down by which a crossed photograph lies beside the parallel one; NaN if not told."""
    if min(parallel.shape) < MIN_SIDE:
        return np.full(2, np.nan)
    one, other = _detail(parallel), _detail(crossed)
    start = np.eye(2, 3, dtype=np.float32)
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-6)
    try:
        correlation, found = cv2.findTransformECC(one, other, start, cv2.MOTION_TRANSLATION, criteria, None, 3)
    except cv2.error:
        return np.full(2, np.nan)
    shift = np.asarray(found[:, 2], np.float64)
    return shift if correlation > 0.5 and np.isfinite(shift).all() else np.full(2, np.nan)


def decide_shifts(measured: Sequence[Array], factor: int) -> PairShift:
    """The shifts of pairs as measured in images `factor` times smaller."""
    found = np.array(measured).reshape(-1, 2)
    known = np.isfinite(found).all(axis=1)
    if known.sum() < max(2, len(found) // 2):
        return PairShift(np.zeros_like(found), 0.0)
    middle = np.median(found[known], axis=0)
    scatter = float(np.median(np.hypot(*(found[known] - middle).T)))
    shifts = np.tile(middle, (len(found), 1))
    if scatter > OWN_SHIFTS:
        shifts[known] = found[known]
    elif np.hypot(*middle) < max(NO_SHIFT, 3.0 * scatter / np.sqrt(known.sum())):
        shifts[:] = 0.0
    return PairShift(factor * shifts, factor * scatter)


def _detail(image: Grey) -> Grey:
    """The logarithm without its slow change, with highlights and shadows bounded."""
    floor = np.float32(0.02 * float(np.quantile(image, 0.9)) + 1e-6)
    log = np.log(np.maximum(image, 0.0) + floor).astype(np.float32)
    detail = log - cv2.GaussianBlur(log, (0, 0), SLOW)
    limit = 3.0 * float(np.median(np.abs(detail))) + 1e-6
    return np.clip(detail, -limit, limit).astype(np.float32)

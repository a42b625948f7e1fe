"""After how many frames a bake has paid off against the progressive reference at equal error.

The error of the reference is its noise, which falls with the root of the samples, and its time grows with them:
error² · time is one number for a scene, found from pictures of a few numbers of samples. A frame as exact as a bake's
therefore takes the reference t = number / error², and the bake has paid off after bake_s / (t − frame_s) frames.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from engine.tradeoff.point import Point
from engine.transport import method as transport


def effort(points: Sequence[Point]) -> float | None:
    """error² · time in s of the reference, the median over its points; None where none is certain enough."""
    found = [
        point.error_rmse_rel**2 * point.frame_s
        for point in points
        if point.mode == "reference" and point.error_rmse_rel > 2.0 * point.error_uncertainty
    ]
    return sorted(found)[len(found) // 2] if found else None


def break_even_frames(point: Point, reference_effort: float | None) -> int | None:
    """Frames from which on `point` has taken less time than the reference at its error.

    None where the mode bakes nothing, where the reference is quicker in each frame, and where its effort is not known.
    """
    if point.mode not in transport.names() or reference_effort is None:
        return None
    error = max(point.error_rmse_rel, point.error_uncertainty)
    if error <= 0.0:
        return None
    saved = reference_effort / error**2 - point.frame_s
    return max(1, math.ceil((point.bake_s + point.relight_s) / saved)) if saved > 0.0 else None

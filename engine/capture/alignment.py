"""How the photographs of a stack lie on each other: what alignment finds, or a person who marks control points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.health import Finding

Matrix = NDArray[np.float64]

#: Kinds of motion from stiff to free.
MOTIONS = ("translation", "euclidean", "affine", "homography")


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

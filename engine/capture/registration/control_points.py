"""The motion of a photograph from points that a user has marked in it and in the reference.

The motion of the wanted kind with the least sum of squared distances in the photograph is found in coordinates about
the points' middle, scaled to unit spread (Hartley2004 Sec. 4.4): a Euclidean motion by Procrustes
(Umeyama1991), an affine one linearly, a homography by the direct linear transform and Gauss-Newton on the distances.
Points that do not determine the motion, because there are too few or they lie on one line, give the freest stiffer one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from engine.capture.lights.azimuth_spread import usual_motion
from engine.core.health import Finding, Verdict

if TYPE_CHECKING:
    from engine.capture.registration.pair_motion import Alignment

Matrix = NDArray[np.float64]
Points = NDArray[np.float64]

#: Motions from stiff to free, and the points that determine them.
MIN_POINTS = {"translation": 1, "euclidean": 2, "affine": 3, "homography": 4}

_LARGEST_CONDITION = 1e6
_MIN_SPREAD = 0.02
_ITERATIONS = 20


@dataclass(frozen=True, eq=False)
class MarkedMotion:
    """`matrix` (3, 3) from the reference to the photograph, the kind of `motion` it is, and `missed_px` (N,), the
    distance in pixels by which each point misses it (0 where there are no more points than needed)."""

    matrix: Matrix
    motion: str
    missed_px: NDArray[np.float64]

    @property
    def rms_px(self) -> float:
        """Root mean square of the distances."""
        return float(np.sqrt((self.missed_px**2).mean()))


def fit_marked_motion(pairs: Sequence[Sequence[float]], motion: str = "homography") -> MarkedMotion:
    """The motion from `pairs`, each x, y in the reference and x, y in the photograph (pixel centres at integers).

    Raises ValueError for an unknown motion, no pairs, and numbers that are not finite.
    """
    table = np.asarray(pairs, np.float64)
    if motion not in MIN_POINTS:
        raise ValueError(f"unknown motion {motion!r}; choose from {', '.join(MIN_POINTS)}")
    if table.ndim != 2 or table.shape[1] != 4 or not len(table) or not np.isfinite(table).all():
        raise ValueError("control points need four finite numbers each: x and y in the reference, x and y in the image")
    here, there = table[:, :2], table[:, 2:]
    kinds = list(MIN_POINTS)
    for kind in reversed(kinds[: kinds.index(motion) + 1]):
        if kind == "translation" or _determines(here, there, kind):
            matrix = _FITS[kind](here, there)
            if kind == "translation" or _sound(matrix, here):
                break
    return MarkedMotion(matrix, kind, np.hypot(*(move(matrix, here) - there).T))


def choose_marked_kind(motion: str, azimuth: NDArray[np.float64] | None) -> str:
    """The kind of motion that control points are fitted with, where an import is asked for `motion`."""
    decided = motion if motion != "auto" else usual_motion(azimuth)
    return decided if decided != "none" else "homography"


def with_control_points(
    alignment: Alignment, marked: Mapping[int, Sequence[Sequence[float]]], names: Sequence[str], motion: str
) -> Alignment:
    """The alignment with the motions of some photographs taken from points that a user marked.

    `marked` maps the index of a photograph to pairs (x and y in the reference, x and y in it, pixels of the
    photographs). Their residual is that of the points. Points that determine only a stiffer motion are reported.
    """
    matrix, residual, aligned = alignment.matrix.copy(), alignment.residual_px.copy(), alignment.aligned.copy()
    confidence, findings = alignment.confidence.copy(), list(alignment.findings)
    for index, pairs in marked.items():
        found = fit_marked_motion(pairs, motion)
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


def _determines(here: Points, there: Points, motion: str) -> bool:
    """Enough points, apart for a turn, off one line for an affine motion, four of them so for a homography."""
    if len(np.unique(here, axis=0)) < MIN_POINTS[motion] or len(np.unique(there, axis=0)) < MIN_POINTS[motion]:
        return False
    if motion == "euclidean":
        return True
    if motion == "homography" and len(here) == 4:
        return all(_off_line(np.delete(points, left_out, axis=0)) for points in (here, there) for left_out in range(4))
    return _off_line(here) and _off_line(there)


def _off_line(points: Points) -> bool:
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[-1] > _MIN_SPREAD * spread[0])


def _sound(matrix: Matrix, here: Points) -> bool:
    """Neither mirrored nor nearly singular, with all points in front of the camera."""
    unit = np.linalg.inv(_unit(here))
    normal = np.linalg.inv(unit) @ matrix @ unit
    depth = np.hstack([here, np.ones((len(here), 1))]) @ matrix[2]
    return bool(
        np.isfinite(matrix).all()
        and (depth > 0).all()
        and np.linalg.det(matrix[:2, :2]) > 0
        and np.linalg.cond(normal - np.outer(normal[:, 2] - [0, 0, normal[2, 2]], [0, 0, 1])) <= _LARGEST_CONDITION
    )


def move(matrix: Matrix, points: Points) -> Points:
    """Image of `points` (N, 2) under `matrix` (3, 3)."""
    there = points @ matrix[:, :2].T + matrix[:, 2]
    places: Points = there[:, :2] / there[:, 2:]
    return places


def _unit(points: Points) -> Matrix:
    """To coordinates about the middle of the points in which their mean distance is sqrt 2."""
    middle = points.mean(axis=0)
    scale = np.sqrt(2.0) / max(float(np.hypot(*(points - middle).T).mean()), 1e-12)
    return np.array([[scale, 0, -scale * middle[0]], [0, scale, -scale * middle[1]], [0, 0, 1.0]])


def _translation(here: Points, there: Points) -> Matrix:
    matrix = np.eye(3)
    matrix[:2, 2] = (there - here).mean(axis=0)
    return matrix


def _euclidean(here: Points, there: Points) -> Matrix:
    one, other = here - here.mean(axis=0), there - there.mean(axis=0)
    along, across = (one * other).sum(), (one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]).sum()
    angle = np.arctan2(across, along)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    matrix = np.eye(3)
    matrix[:2, :2] = turn
    matrix[:2, 2] = there.mean(axis=0) - turn @ here.mean(axis=0)
    return matrix


def _affine(here: Points, there: Points) -> Matrix:
    unit = _unit(here)
    table = np.hstack([move(unit, here), np.ones((len(here), 1))])
    matrix = np.eye(3)
    matrix[:2] = np.linalg.lstsq(table, there, rcond=None)[0].T
    return matrix @ unit


def _homography(here: Points, there: Points) -> Matrix:
    """Direct linear transform, then Gauss-Newton on the distances in the photograph."""
    from_unit, to_unit = _unit(here), _unit(there)
    one, other = move(from_unit, here), move(to_unit, there)
    rows = []
    for (x, y), (u, v) in zip(one, other, strict=True):
        rows += [[x, y, 1, 0, 0, 0, -u * x, -u * y, -u], [0, 0, 0, x, y, 1, -v * x, -v * y, -v]]
    matrix = np.linalg.svd(np.array(rows))[2][-1].reshape(3, 3)
    for _ in range(_ITERATIONS):
        matrix = matrix / np.linalg.norm(matrix)
        change = _newton_step(matrix, one, other)
        matrix = matrix + change
        if np.abs(change).max() < 1e-13:
            break
    whole = np.linalg.inv(to_unit) @ matrix @ from_unit
    return whole / whole[2, 2]


def _newton_step(matrix: Matrix, here: Points, there: Points) -> Matrix:
    """The change of the nine entries of least size that lowers the distances most."""
    whole = np.hstack([here, np.ones((len(here), 1))])
    seen = whole @ matrix.T
    u, v, w = seen.T
    zero = np.zeros_like(whole)
    by_u = np.hstack([whole, zero, -(u / w)[:, None] * whole]) / w[:, None]
    by_v = np.hstack([zero, whole, -(v / w)[:, None] * whole]) / w[:, None]
    missed = there - seen[:, :2] / w[:, None]
    change = np.linalg.lstsq(np.vstack([by_u, by_v]), np.concatenate([missed[:, 0], missed[:, 1]]), rcond=1e-12)[0]
    step: Matrix = change.reshape(3, 3)
    return step


_FITS = {"translation": _translation, "euclidean": _euclidean, "affine": _affine, "homography": _homography}

"""What projections are called: a linear one by how it weighs the two directions."""

from __future__ import annotations

from typing import Any

import numpy as np

FIXED = {
    "wi": "light",
    "wo": "view",
    "half": "half vector",
    "wi-dot-h": "angles θh, θd",
    "elevations": "angles θi, θo",
    "elevations-exchanged": "angles θo, θi",
    "half-mean": "angles θh, θm",
    "wi-dot-h-mean": "angles θd, θm",
}
MEASURES = {
    "radii": "angles",
    "cosines": "cosines of",
    "sines": "sines of",
    "squares": "squares of",
    "turned": "turned angles",
}
DISKS = {"in-out": ("light", "view"), "half-diff": ("half vector", "difference")}

#: How far from a named one a projection may be to have its name, as a share of its length.
NEAR = 0.12


def projection_name(projection: Any, parametrisation: str) -> str:
    """A few words: 'light', 'sum', 'difference', 'turned sum', 'mixture'; McCool's are as he has them.

    Turning or mirroring a texture changes nothing, so a name stands for all projections that differ by that only.
    """
    if projection.name != "linear":
        words = FIXED[projection.angles or projection.name]
        return words.replace("angles", MEASURES[projection.measure], 1)
    first, second = projection.rows[:, :2], projection.rows[:, 2:]
    one, other = DISKS[parametrisation]
    if np.linalg.norm(second) < NEAR * np.sqrt(2.0):
        return one
    if np.linalg.norm(first) < NEAR * np.sqrt(2.0):
        return other
    if parametrisation == "in-out" and _even(first) and _even(second):
        turn = np.linalg.solve(first, second)
        if np.linalg.norm(turn - np.eye(2)) < 2.0 * NEAR:
            return "sum"
        if np.linalg.norm(turn + np.eye(2)) < 2.0 * NEAR:
            return "difference"
        if np.linalg.norm(turn.T @ turn - np.eye(2)) < 2.0 * NEAR:
            return "turned sum" if np.linalg.det(turn) > 0.0 else "mirrored sum"
    return "mixture"


def shares(projection: Any) -> tuple[float, float]:
    """How much of a linear projection comes from each of the two disks; the two add up to 1."""
    squares = (np.asarray(projection.rows) ** 2).reshape(2, 2, 2).sum(axis=(0, 2)) / 2.0
    return float(squares[0]), float(squares[1])


def _even(part: Any) -> bool:
    """Whether a disk keeps its shape under this half of a projection."""
    long, short = np.linalg.svd(part, compute_uv=False)
    return bool(short > (1.0 - 2.0 * NEAR) * long)

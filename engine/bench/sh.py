"""Spherical harmonics: lighting turned into the frames of 50,000 vertices, and projected environment maps."""

from __future__ import annotations

import time

import numpy as np

from engine.bench.measure import Measure, best_of
from engine.directions import normalize, world_from_tangent
from engine.environment import EnvironmentMap
from engine.transport.sh_lighting import project
from engine.transport.sh_rotation import rotated_into_frames

FRAMES = 50_000
SIZE = (512, 1024)


def sh_rotate() -> Measure:
    """RGB lighting of order 5 in float32 turned into each frame, against a copy of what is read and written."""
    random = np.random.default_rng(0)
    coefficients = random.normal(size=(25, 3)).astype(np.float32)
    frames = world_from_tangent(normalize(random.normal(size=(FRAMES, 3)))).astype(np.float32)
    local = rotated_into_frames(coefficients, frames)
    time_s = best_of(lambda: rotated_into_frames(coefficients, frames))
    start = time.process_time()
    rotated_into_frames(coefficients, frames)
    more = {"frames": FRAMES, "order": 5, "processor_s": time.process_time() - start}
    limit_s = best_of(lambda: (frames.copy(), local.copy()))
    return Measure("sh-rotate", time_s, limit_s, "copying the frames and the coefficients", more)


def sh_project() -> Measure:
    """A map of 1024 × 512 projected at order 5, against adding up its texels in float64."""
    return _projected("sh-project", 5)


def sh_project_15() -> Measure:
    """The same at order 15."""
    return _projected("sh-project-15", 15)


def _projected(name: str, order: int) -> Measure:
    environment = EnvironmentMap(np.random.default_rng(0).random((*SIZE, 3), np.float32))
    time_s = best_of(lambda: project(environment, order))
    limit_s = best_of(lambda: environment.radiance.sum(axis=(0, 1), dtype=np.float64))
    return Measure(name, time_s, limit_s, "adding up the texels", {"order": order, "texels": SIZE[0] * SIZE[1]})

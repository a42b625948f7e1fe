"""Resampling an environment to a cube map, and all its levels under Gaussians, against copies of what is written."""

from __future__ import annotations

import numpy as np

from benchmarks.measure import Measure, best_of
from engine.light.cube_map import CubeMap, cube_of
from engine.light.environment import EnvironmentMap
from engine.light.gaussian_prefilter import prefilter as prefilter_map

EDGE = 512
ROWS = 512


def cube_map() -> Measure:
    """A map of 1024 × 512 texels to 6 × 512²."""
    radiance = np.random.default_rng(0).random((ROWS, 2 * ROWS, 3)).astype(np.float32)
    environment = EnvironmentMap(radiance)
    cube = cube_of(environment, EDGE)
    time_s = best_of(lambda: cube_of(environment, EDGE), repeats=3)
    limit_s = best_of(lambda: (radiance.copy(), cube.radiance.copy()), repeats=3)
    return Measure("cube-map", time_s, limit_s, "copying both maps", {"edge": EDGE})


def prefilter() -> Measure:
    """All levels of 6 × 512² from half a texel up."""
    cube = CubeMap(np.random.default_rng(0).random((6, EDGE, EDGE, 3)).astype(np.float32))
    filtered = prefilter_map(cube)
    time_s = best_of(lambda: prefilter_map(cube), repeats=3)
    limit_s = best_of(lambda: (cube.radiance.copy(), filtered.texels.copy()), repeats=3)
    more = {"levels": len(filtered.levels), "size_bytes": filtered.texels.nbytes}
    return Measure("prefilter", time_s, limit_s, "copying the map and all levels", more)


def prefilter_lookup() -> Measure:
    """A million look-ups at random directions and widths."""
    random = np.random.default_rng(0)
    filtered = prefilter_map(CubeMap(random.random((6, EDGE, EDGE, 3)).astype(np.float32)))
    direction = random.normal(size=(1_000_000, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    sigma = np.exp(random.uniform(np.log(0.002), np.log(1.0), len(direction)))
    values = filtered.lookup(direction, sigma)
    time_s = best_of(lambda: filtered.lookup(direction, sigma), repeats=3)
    limit_s = best_of(lambda: (direction.copy(), sigma.copy(), values.copy()), repeats=3)
    return Measure("prefilter-lookup", time_s, limit_s, "copying directions, widths and values")

"""Another environment for Gaussian transport: its cube map and the levels that lobes need, as they are looked up."""

from __future__ import annotations

import time

import numpy as np

from benchmarks.measure import Measure, best_of
from engine.light.environment import EnvironmentMap
from engine.transport.gaussian.gpu_layout import atlas_of
from engine.transport.gaussian.lighting import filter_levels, levels_between

#: Texels of the environment, and widths of lobes in rad: of rough to glossy BRDFs, and of nearly a mirror.
SIZE, ROUGH, SHARP = (512, 1024), (0.06, 0.5), (0.004, 0.05)


def gaussian_environment() -> Measure:
    """For lobes of rough to glossy BRDFs (alpha from 0.1)."""
    return _change("gaussian-environment", ROUGH)


def gaussian_environment_sharp() -> Measure:
    """For lobes of BRDFs that are nearly mirrors, at the finest map."""
    return _change("gaussian-environment-sharp", SHARP)


def _change(name: str, widths: tuple[float, float]) -> Measure:
    radiance = np.random.default_rng(0).random((*SIZE, 3)).astype(np.float32)
    environment, levels = EnvironmentMap(radiance), levels_between(*widths)
    cube = filter_levels(environment, levels)
    atlas = atlas_of(cube)
    time_s = best_of(lambda: atlas_of(filter_levels(environment, levels)), repeats=3)
    limit_s = best_of(lambda: (radiance.copy(), cube.texels.copy(), atlas.texels.copy()), repeats=3)
    start = time.process_time()
    atlas_of(filter_levels(environment, levels))
    more = {
        "processor_s": time.process_time() - start,
        "edge": levels.edge,
        "levels": len(levels.sigma),
        "size_bytes": atlas.texels.nbytes,
        "target_s": 0.5,
    }
    return Measure(name, time_s, limit_s, "copying the map, the levels and their texture", more)

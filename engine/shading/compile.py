"""Compiling the kernels of this package before they are needed, so that neither users nor clocks wait for it later.

Compiling takes half a minute on a new machine; afterwards the kernels come from the cache in a second.
"""

from __future__ import annotations

import numpy as np

from engine.capture.stack import ImageStack
from engine.core.steps import Step, Steps, drain
from engine.shading.power_law import fit
from engine.shading.shading_map import build


def prepare_kernels() -> Steps[None]:
    """Build and fit a map of one texel."""
    yield Step(0.0, "Compiling (first use only)")
    stack = ImageStack(
        radiance=np.full((2, 1, 1, 3), 0.5, np.float32),
        saturated=np.zeros((2, 1, 1), np.bool_),
        elevation=np.array([0.5, 1.0]),
        azimuth=None,
        mean_radiance=np.array([0.5, 0.5]),
        sources=("dark", "bright"),
        angle_source="assumed",
    )
    shading_map = drain(build(stack, 2))
    yield Step(0.5, "Compiling (first use only)")
    drain(fit(shading_map))

"""P11: how well a power law describes the four materials of the virtual light arc.

The paper's table 1 has an RMS of 0.040 to 0.065 for suede, plastic, wood and stone. Of ours the hammered metal lies
in that range; cloth and leather without shadows of large relief are easier, and a plane is a power law almost exactly.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest

from engine.capture.stack import ImageStack
from engine.core.colour import LUMINANCE
from engine.core.steps import drain
from engine.shading.power_law import fit
from engine.shading.shading_map import build
from engine.simulate.arc import LightArc
from engine.simulate.simulate import renderings

ELEVATION = np.radians([5.0, 10, 20, 30, 40, 50, 60, 70, 80, 90])

#: RMS with k_s of the last slice and of least squares, 128 x 128 texels, 8 slices.
RMS = {
    "woven": (0.0111, 0.0086),
    "hammered": (0.0593, 0.0402),
    "leather": (0.0178, 0.0132),
    "plain": (0.0, 0.0),
}


@pytest.mark.parametrize("sample", RMS)
def test_P11_rms_of_the_synthetic_materials(sample: Any) -> None:
    radiance = np.stack(drain(renderings(LightArc(sample=sample, size=128), cast(Any, ELEVATION))))
    stack = ImageStack(
        radiance=radiance,
        saturated=np.zeros(radiance.shape[:3], np.bool_),
        elevation=ELEVATION,
        azimuth=None,
        mean_radiance=radiance.mean(axis=(1, 2), dtype=np.float64) @ LUMINANCE,
        sources=tuple(f"{index}" for index in range(len(ELEVATION))),
        angle_source="user",
    )
    shading_map = drain(build(stack, 8))
    fixed, free = (drain(fit(shading_map, scale)).rms for scale in ("last-slice", "least-squares"))
    assert (fixed, free) == pytest.approx(RMS[sample], rel=0.05, abs=1e-4)


def test_P11_the_hardest_material_lies_in_the_range_of_the_paper() -> None:
    assert 0.040 <= RMS["hammered"][0] <= 0.065

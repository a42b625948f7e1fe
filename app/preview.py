"""The preview of a bundle: the project's scene, drawn on the processor, so that no viewport has to be on screen.

A picture of 640 x 480 pixels takes about a second on two cores, and as many times longer as there are lights.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from app.document import Look
from engine.steps import Step, Steps

if TYPE_CHECKING:
    from engine.scene import Scene

SIZE = (640, 480)

#: Most directions that stand for an environment.
DIRECTIONS = 16


def drawn(scene: Scene, look: Look) -> Steps[NDArray[np.uint8]]:
    """(480, 640, 3) uint8, sRGB-coded: `scene` with the exposure and tone mapping of `look`, over dark grey."""
    yield Step(0.0, "preparing kernels")
    from engine.render.direct import radiance
    from engine.render.display import Display, displayed

    scene = dataclasses.replace(scene, directions=min(scene.directions, DIRECTIONS))
    picture = yield from radiance(scene, SIZE, samples=1)
    return displayed(picture, Display(look.exposure_ev, look.tone_map))

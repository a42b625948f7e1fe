"""The noise of the reference, told from a picture of a few pixels: the samples that an error takes follow from it.

The error of a mean over n samples is that of one over √n. A thousand pixels of some samples know it to about a tenth
unless single paths carry most of the light, and a picture framed by another camera may be noisier than this one.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

from engine.camera import frame
from engine.mesh import Mesh
from engine.render.reference import reference
from engine.scene import Scene
from engine.steps import drain

#: Side of the picture, samples of each pixel, and what the noise that is found is raised by.
SIDE, SAMPLES, MARGIN = 32, 16, 1.1

#: Points of the surface that light touches where light between parts of the model counts.
REFERENCE_DEPTH = 4


@lru_cache(maxsize=8)
def probed(mesh: Mesh, brdf: Any, depth: int, **place: Any) -> float:
    """The relative error of a reference of one sample for each pixel, light touching up to `depth` points.

    `place` are fields of the `Scene`: its environment, ground, and so on. Remembered; some 0.1 s.
    """
    scene = Scene(mesh, frame(mesh.positions), brdf, **place)
    found = drain(reference(scene, (SIDE, SIDE), samples=SAMPLES, max_depth=depth))
    return MARGIN * (found.uncertainty_rmse_rel or 0.0) * math.sqrt(SAMPLES)

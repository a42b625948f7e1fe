"""Errors by the number of directions of an environment, against the whole map, for a diffuse and a shiny BRDF.

On the sphere with a coloured weave as material. An error's bound is that of half as many directions and one percent:
more directions do not cost accuracy. A shiny lobe of some 10 degrees must hold several lights before they look like one
reflection: with few directions the image is a few spots, and while its error is above 50 %, which depends on how many
of the spots the compared pixels meet, nothing is promised of the next step. Cost: some 10 s for each map.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.measure import Accuracy
from engine.brdf.brdf import brdf_from_text
from engine.core.steps import Steps, part
from engine.geometry.camera import frame
from engine.geometry.shapes import shape
from engine.light.environment import EnvironmentMap
from engine.light.environment_file import open_environment
from engine.render.environment_error import DirectionsError, error_ladder
from engine.scene.material import Material
from engine.scene.scene import Scene
from engine.shading.shading_map import ShadingMap

COUNTS = (8, 16, 32, 64, 128, 256, 512)
BRDFS = ("lambert", "phong:kd=0.2,ks=0.6,exponent=100")
SIZE = (160, 120)
SLACK, SPOTS = 1.01, 0.5


@dataclass(frozen=True)
class Sweep:
    """The errors of one BRDF by rising number of directions; a curve of a plot."""

    brdf: str
    errors: tuple[DirectionsError, ...]


def directions(_folder: Path) -> Steps[list[Accuracy]]:
    """The sweeps under the built-in environments and under light from everywhere; nothing is written."""
    maps = [open_environment("studio"), open_environment("sky")]
    maps.append(EnvironmentMap(np.ones((64, 128, 3), np.float32), "constant"))
    found: list[Accuracy] = []
    for index, environment in enumerate(maps):
        steps = directions_sweeps(_weave(), environment)
        sweeps = yield from part(steps, index / len(maps), (index + 1) / len(maps))
        for sweep in sweeps:
            what = f"RMS difference from all light of the map, relative to the image's RMS radiance, {sweep.brdf}"
            model, bound = sweep.brdf.partition(":")[0], None
            for error in sweep.errors:
                name = f"{environment.name}-{model}-{error.directions}"
                found.append(Accuracy(name, error.rmse_rel, what, bound))
                bound = SLACK * error.rmse_rel if error.rmse_rel <= SPOTS else None
    return found


def directions_sweeps(material: Material, environment: EnvironmentMap, *, pixels: int = 64) -> Steps[list[Sweep]]:
    """The sweeps of `BRDFS` for `material` on the sphere; about 3 s each with 64 pixels."""
    mesh = shape("sphere")
    camera = frame(mesh.positions, SIZE[0] / SIZE[1])
    sweeps = []
    for index, text in enumerate(BRDFS):
        scene = Scene(mesh, camera, brdf_from_text(text), material, environment=environment)
        steps = error_ladder(scene, SIZE, COUNTS, pixels=pixels)
        errors = yield from part(steps, index / len(BRDFS), (index + 1) / len(BRDFS))
        sweeps.append(Sweep(text, tuple(errors)))
    return sweeps


def _weave() -> Material:
    """Threads that brighten at their own pace, so that the look-up bends differently from texel to texel."""
    y, x = np.mgrid[:64, :64] / 64
    height = 0.5 + 0.5 * np.sin(16 * np.pi * x) * np.sin(16 * np.pi * y)
    share = np.linspace(0.0, 1.0, 8)[:, None, None, None]
    slices = (0.3 + 0.7 * height)[..., None] * (0.3, 0.45, 0.8) * share ** (1.6 - height)[..., None]
    means = np.linspace(0.0, 0.3, 8)
    return Material(ShadingMap(slices.astype(np.float32), 0.3, means), None, elevation_deg=(10.0, 45.0, 80.0))

"""What the cost model says of settings on the scene of a sweep."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from engine.effects.calibration import ray_scale
from engine.effects.cost_model import CostModel, Load
from engine.effects.sample import of_surface
from engine.effects.setting import Setting
from engine.scene import Scene
from engine.tradeoff.prediction import FIGURES
from engine.transport.sh_transfer import is_diffuse
from engine.transport.visibility import receivers


class Predictions:
    """Asks a cost model about settings on one scene, in pictures of so many shaded `pixels`."""

    def __init__(self, costs: CostModel, scene: Scene, pixels: int, paths: int, max_depth: int) -> None:
        """`paths` are the pixels of the reference, which shades each once a sample; it is known for a depth of 1."""
        surface = of_surface(scene.mesh, scene.ground)
        of = receivers(surface)
        occluded, faces = float(1.0 - np.mean(of.free)), len(surface.faces)
        look = (is_diffuse(scene.brdf), bool(scene.brdf.isotropic))
        self.costs, self.paths, self.max_depth = costs, paths, max_depth
        rays = ray_scale(costs, of)
        self.load = Load(len(surface.positions), pixels, faces, occluded, *look, ray_scale=rays, lamps=len(scene.lamps))

    def of(self, setting: Setting) -> dict[str, float]:
        """The `FIGURES` of which the model knows something."""
        if setting.mode == "reference" and self.max_depth > 1:
            return {}
        pixels = self.paths if setting.mode == "reference" else self.load.pixels
        try:
            cost = self.costs.predict(setting, self.load.vertices, pixels, load=replace(self.load, pixels=pixels))
        except ValueError:
            return {}
        known = FIGURES if cost.bake_s > 0.0 else ("frame_s",)
        return {name: getattr(cost, name) for name in known}

"""What the cost model says of settings on the scene of a sweep."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from engine.effects.cost_model import CostModel, Load
from engine.effects.load import TEXELS, covered, rays_of, shaded
from engine.effects.sample import of_surface
from engine.effects.setting import Setting
from engine.effects.simplified import albedos
from engine.scene import Scene
from engine.sun import split_sun
from engine.tradeoff.prediction import FIGURES
from engine.transport.sh_transfer import is_diffuse
from engine.transport.visibility import receivers


class Predictions:
    """Asks a cost model about settings on one scene, in pictures of a `size` (width, height) as it is drawn."""

    def __init__(self, costs: CostModel, scene: Scene, size: tuple[int, int], samples: int, max_depth: int) -> None:
        """`samples` along each side of a pixel are drawn, but one by the reference for each of its own."""
        surface = of_surface(scene.mesh, scene.ground)
        of, (width, height) = receivers(surface), size
        rays, model = rays_of(of), len(scene.mesh.positions)
        brdf: Any = scene.brdf
        suns = () if scene.environment is None else split_sun(scene.environment)[1]
        texels = TEXELS if scene.environment is None else int(np.prod(scene.environment.radiance.shape[:2]))
        self.costs, self.paths = costs, width * height
        self.load = Load(
            len(surface.positions),
            samples**2 * self.paths,
            len(surface.faces),
            float(1.0 - np.mean(of.free)),
            is_diffuse(brdf),
            bool(brdf.isotropic),
            bool(np.ptp(albedos(brdf).mean) > 1e-9),
            closed=rays.closed,
            covered=covered(of.caster, scene.camera, width / height),
            shaded=shaded(of.caster, scene.camera, width / height),
            visibility=rays.visibility,
            ray_scale=costs.ray_scale(rays),
            lamps=len(scene.lamps) + len(suns),
            texels=texels,
            depth=max_depth,
            ground=len(surface.positions) - model,
            tables_made=True,
        )

    def of(self, setting: Setting) -> dict[str, float]:
        """The `FIGURES` of which the model knows something."""
        pixels = self.paths if setting.mode == "reference" else self.load.pixels
        try:
            cost = self.costs.predict(setting, self.load.vertices, pixels, load=replace(self.load, pixels=pixels))
        except ValueError:
            return {}
        known = FIGURES if cost.bake_s > 0.0 else ("frame_s",)
        return {name: getattr(cost, name) for name in known}

"""Costs that the cost model predicts for settings on the scene of a sweep."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from engine.geometry.camera import Camera
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import caster_of
from engine.light.sun_split import split_sun
from engine.planning.costs.cost_model import CostModel, Load
from engine.planning.costs.load import TEXELS, measure_closed_share, measure_coverage, shade
from engine.planning.costs.setting import Setting
from engine.planning.effects.sample import sample_surface
from engine.planning.effects.simplified import albedos
from engine.render.shadowed import with_and_without
from engine.scene.mode import is_traced
from engine.scene.scene import Scene
from engine.tradeoff.point import FIGURES
from engine.transport.baking.visibility import receivers
from engine.transport.sh.transfer import is_diffuse

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf


def predict_frame_s(
    costs: CostModel, mesh: Mesh, setting: Setting, camera: Camera, size: tuple[int, int], samples: int, **more: Any
) -> float:
    """Seconds of a frame of `mesh`, a ground included, in a mode that is not traced: some 0.1 s to tell.

    `samples` along each side of a pixel are drawn; `more` of the fields of `Load`.
    """
    (width, height), caster = size, caster_of(mesh)
    load = Load(
        len(mesh.positions),
        samples**2 * width * height,
        len(mesh.faces),
        covered=measure_coverage(caster, camera, width / height),
        shaded=shade(caster, camera, width / height),
        **more,
    )
    return costs.predict(setting, load.vertices, load.pixels, load=load).frame_s


class Predictions:
    """Asks a cost model about settings on one scene, in images of a `size` (width, height) as it is drawn."""

    def __init__(
        self,
        costs: CostModel,
        scene: Scene,
        size: tuple[int, int],
        samples: int,
        max_depth: int,
        *,
        tables_made: bool = True,
    ) -> None:
        """`samples` along each side of a pixel are drawn, but one by the reference for each of its own.

        `tables_made` is that of `Load`.
        """
        surface = sample_surface(scene.mesh, scene.ground)
        of, (width, height) = receivers(surface), size
        model = len(scene.mesh.positions)
        brdf: Brdf = scene.brdf
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
            closed=measure_closed_share(of),
            covered=measure_coverage(of.caster, scene.camera, width / height),
            shaded=shade(of.caster, scene.camera, width / height),
            lamps=len(scene.lamps) + len(suns),
            texels=texels,
            depth=max_depth,
            shadows=len(replace(scene, shadows=True).sharp_lights.direction),
            texel_lights=len(with_and_without(scene)[0].lights.direction) if scene.has_texels else 0,
            ground=len(surface.positions) - model,
            tables_made=tables_made,
        )

    def of(self, setting: Setting) -> dict[str, float]:
        """The `FIGURES` of which the model knows something."""
        pixels = self.paths if is_traced(setting.mode) else self.load.pixels
        cost = self.costs.predict(setting, self.load.vertices, pixels, load=replace(self.load, pixels=pixels))
        known = FIGURES if cost.bake_s > 0.0 else ("frame_s",)
        return {name: getattr(cost, name) for name in known}

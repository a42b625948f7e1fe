"""Wavelets as a plan sees them: what a setting costs, its error, and its bake (`planned.Planning`)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from engine.core.steps import Steps
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.separable_factors import SeparableFactors
from engine.geometry.mesh import Mesh
from engine.planning.costs.cost_model import Cost, CostModel, Load
from engine.planning.costs.planned import PlannedBake
from engine.planning.costs.setting import Setting
from engine.planning.costs.sizes import wavelets
from engine.planning.costs.spread import MODEL_BYTES, SEEN_BYTES, Stage
from engine.planning.effects.mode_error import ModeErrors, can_be_factored, wavelet_error
from engine.scene.mode import Spread
from engine.transport import wavelet_method
from engine.transport.baking.occluder import Occluder
from engine.transport.baking.settings import BOUNCES, WaveletSettings
from engine.transport.baking.visibility import Receivers, every_ray
from engine.transport.method import Subject, method_of
from engine.transport.relight import RelightWavelets
from engine.transport.wavelet import bake as wavelet_bake
from engine.transport.wavelet.haar import FACES
from engine.transport.wavelet.interreflection import SHARE
from engine.transport.wavelet.transfer import Vectors16, WaveletTransport

if TYPE_CHECKING:
    from engine.planning.effects.estimates import Scenery

#: Rays of a bounce over those of one in spherical harmonics, and the time of its rows over that of direct light's at an
#: edge of 64, as measured on a torus knot over a floor: one without open places would take more.
BOUNCE_RAYS, BOUNCE_ROW = 0.5, 0.5

#: Bytes of a coefficient, of the rest of a vector as it is stored, and as bounces take it (`Vectors16`, `Coarse`).
COEFFICIENT_BYTES, ROW_BYTES, START_BYTES = 6.0, 14.0, 20.0

#: Ratios of measured to predicted errors.
SPREAD = Spread(by_camera=(0.2, 4.0), around=(0.04, 1.6))


@dataclass(frozen=True, eq=False)
class _EveryRay(Occluder):
    """The model itself, asked from every vertex."""

    edge: int = 32
    fine: int = 4

    def receivers(self, mesh: Mesh) -> Receivers:
        return every_ray(super().receivers(mesh), self.edge, self.fine)


def cost(model: CostModel, setting: Setting, load: Load) -> Cost:
    terms, edge = setting["terms"], setting["cube"]
    kept = min(setting["coefficients"], FACES * edge * edge)
    rows = load.model * terms + load.ground
    cutting = model.rate("wavelet-coefficients", kept) / model.rate("wavelet-coefficients", 96)
    rays_s = model.rays_s(edge, load)
    bake_s = model.rate("wavelet-fixed") + rays_s
    bake_s += rows * model.rate("wavelet-row", edge) * cutting
    if setting["interreflection"]:
        bake_s += BOUNCES * _bounce_s(model, load, rows)
    relit = kept * (1.0 + 1.0 / SHARE if setting["interreflection"] else 1.0)
    relight_s = model.measure_turning_s("light-wavelet", edge, load) + model.rate("relight-wavelet", relit) * rows
    relight_s += load.lamps * load.vertices * model.rate("ray") * load.ray_scale
    sizes = wavelets(setting, load)
    bake_s += model.rate("file-byte") * sizes.file
    frame_s = model.frame_s("wavelet", terms, load)
    return Cost(
        bake_s,
        relight_s,
        frame_s,
        sizes.memory,
        method_of(setting.mode).estimate_file_bytes(sizes.file),
        bake_s - rays_s,
    )


def stages(model: CostModel, setting: Setting, load: Load, _mesh: Mesh) -> tuple[Stage, ...]:
    """Chunks of vectors with their visibility, then bounces."""
    edge, rows = setting["cube"], load.model * setting["terms"] + load.ground
    kept = min(setting["coefficients"], FACES * edge * edge)
    cutting = model.rate("wavelet-coefficients", kept) / model.rate("wavelet-coefficients", 96)
    seconds = model.visibility_s(edge, load) + rows * model.rate("wavelet-row", edge) * cutting
    sizes = np.diff(wavelet_bake.vertex_bounds(load.vertices, load.model, edge))
    each = rows / load.vertices
    back = (COEFFICIENT_BYTES * kept + ROW_BYTES) * each + SEEN_BYTES * edge / 64
    chunks = Stage(seconds, sizes, 0.0, back)
    if not setting["interreflection"]:
        return (chunks,)
    bounced = (COEFFICIENT_BYTES * (kept // SHARE) + ROW_BYTES) * each
    shared = [
        each * (COEFFICIENT_BYTES * few + START_BYTES) + MODEL_BYTES for few in (kept, *[kept // SHARE] * (BOUNCES - 1))
    ]
    first, *others = (
        Stage(_bounce_s(model, load, rows), sizes, 0.0, 2.0 * bounced, shared_bytes=load.vertices * some)
        for some in shared
    )
    return chunks, first, *(replace(other, sent_bytes=bounced) for other in others)


def _bounce_s(model: CostModel, load: Load, rows: float) -> float:
    rays_s = load.vertices * model.rate("bounce-rays") * load.ray_scale
    return BOUNCE_RAYS * rays_s + BOUNCE_ROW * rows * model.rate("wavelet-row", 64)


def error(errors: ModeErrors, setting: Setting) -> float:
    """That of its terms and coefficients, and of the texels of the light."""
    return wavelet_error(errors, setting)


def can_draw(scene: Scenery) -> bool:
    """Not every set of factors can be used."""
    return can_be_factored(scene.brdf)


def suits(offers: Any, _skipped: frozenset[str]) -> bool:
    """True if a BRDF can be factored: its simplified forms then can be, too."""
    return can_draw(offers.scene)


def adapt(setting: Setting, diffuse: bool) -> Setting:
    """One term is a diffuse BRDF."""
    return setting.replace(terms=1) if diffuse else setting


def draw(_kind: str, parameter: int, mesh: Mesh) -> RelightWavelets:
    """So many terms."""
    count = len(mesh.positions)
    rows, maps = count * parameter, np.ones((parameter, 48, 48, 3), np.float32)
    factors = SeparableFactors(HemisphereMap("orthographic", 48), "in-out", maps, maps, True, True, "frames")
    nothing = Vectors16(
        np.zeros((rows, 1), np.uint16),
        np.zeros((rows, 1), np.uint32),
        np.zeros((rows, 3), np.float32),
        np.zeros(rows, np.uint16),
    )
    return RelightWavelets(WaveletTransport(mesh, count, factors, 0.0, 64, nothing), np.ones((rows, 3)))


def setting_of(relit: RelightWavelets) -> Setting:
    """That of its terms: coefficients end with the light."""
    return Setting("wavelet", {"terms": relit.transport.factors.terms})


def prepare(plan: Any, subject: Subject, settings: WaveletSettings) -> Steps[PlannedBake]:
    """Work of a bake; if shadows are forced on, rays of the model itself are cast from every vertex, free ones too."""
    forced = plan.decision("self-shadowing") == "forced on"
    asked = replace(settings, occluder_cells=0) if forced else settings
    work = yield from wavelet_method.prepare(subject, asked)
    if forced:
        work = replace(work, occluder=_EveryRay(work.occluder.caster, 0.0, asked.cube, asked.fine))
    return PlannedBake(work, plan.cost.bake_s, lambda path: wavelet_bake.bake(path, work))

"""Gaussians as a plan sees them: what a setting costs, its error, and its bake (`planned.Planning`)."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from engine.core.steps import Steps
from engine.geometry.mesh import Mesh
from engine.light.environment import EnvironmentMap
from engine.planning.costs.cost_model import Cost, CostModel, Load
from engine.planning.costs.planned import PlannedBake
from engine.planning.costs.setting import Setting
from engine.planning.costs.sizes import DIFFUSE_ORDER, LOBE_BYTES, gaussians
from engine.planning.costs.spread import MODEL_BYTES, SEEN_BYTES, Stage
from engine.planning.effects.lobe_error import lobe_error
from engine.planning.effects.mode_error import FLOOR, ModeErrors
from engine.scene.mode import Spread
from engine.transport import gaussian_method
from engine.transport.baking.diffuse_specular import parts
from engine.transport.baking.settings import BOUNCES, GaussianSettings
from engine.transport.baking.visibility import TEXELS, every_ray
from engine.transport.gaussian import bake as gaussian_bake
from engine.transport.gaussian.diffuse import BLOCK, CHUNK
from engine.transport.gaussian.fitting.fit import blocks, list_touching
from engine.transport.gaussian.fitting.flood_fill import flood
from engine.transport.gaussian.fitting.lobes import Lobes
from engine.transport.gaussian.fitting.views import VIEWS
from engine.transport.gaussian.transfer import GaussianTransport
from engine.transport.method import Subject, method_of
from engine.transport.relight import RelightGaussians, relight_gaussians
from engine.transport.sh.transfer import is_diffuse
from engine.transport.wavelet.haar import FACES

if TYPE_CHECKING:
    from engine.planning.effects.estimates import Scenery

#: Ratios of measured to predicted errors: by a camera those of seven scenes, which hold those of 50 of 50 others.
SPREAD = Spread(by_camera=(0.3, 5.2), around=(0.02, 1.0))

#: Effects without which the BRDF is no longer that of a model, which alone is cut into lobes.
_PARTS = {"glossy", "anisotropy", "fresnel", "retro-reflection"}


#: Time of drawing the samples of a vertex from a BRDF over that of taking them from its table.
DRAWN = 7.2


def cost(model: CostModel, setting: Setting, load: Load) -> Cost:
    """Lobes of all views of a vertex, and vectors of the diffuse part."""
    lobes, bounces = setting["lobes"], bool(setting["interreflection"])
    shaded = load.model * load.occluded
    drawn_s, rays_s = DRAWN * model.rate("gaussian-table"), model.rays_s(gaussian_bake.EDGE, load)
    samples_s = model.rate("gaussian-table") if load.isotropic else drawn_s
    bake_s = rays_s + load.model * (samples_s + model.rate("gaussian-fit", lobes))
    bake_s += load.vertices * model.vector_s(DIFFUSE_ORDER)
    if bounces:
        fitted_s = model.rate("gaussian-fit", lobes) * model.rate("gaussian-indirect-fit")
        bake_s += shaded * (drawn_s + fitted_s)
        bake_s += load.model * load.closed * model.rate("gaussian-indirect")
        bake_s += (BOUNCES + 1) * load.vertices * model.bounce_s("vector", DIFFUSE_ORDER, load)
    values = load.vertices * DIFFUSE_ORDER**2 * (3 if bounces else 1)
    relight_s = (
        model.measure_turning_s("light-sh", DIFFUSE_ORDER, load) + model.rate("relight-sh", DIFFUSE_ORDER) * values
    )
    frame_s = model.frame_s("gaussian", lobes * (2 if bounces else 1), load)
    sizes = gaussians(setting, load)
    bake_s += model.rate("file-byte") * sizes.file
    return Cost(
        bake_s,
        relight_s,
        frame_s,
        sizes.memory,
        method_of(setting.mode).estimate_file_bytes(sizes.file),
        bake_s if bounces else bake_s - rays_s,
    )


def stages(model: CostModel, setting: Setting, load: Load, mesh: Mesh) -> tuple[Stage, ...]:
    """Visibility, fits in the order of the flood, bounces but for the last, and the diffuse part with the last."""
    lobes, bounces = setting["lobes"], bool(setting["interreflection"])
    drawn_s = DRAWN * model.rate("gaussian-table")
    fit_s, samples_s = model.rate("gaussian-fit", lobes), model.rate("gaussian-table") if load.isotropic else drawn_s
    order = flood(mesh, load.model)
    parts = blocks(order)
    sizes, pairs = np.array([len(part) for part in parts]), list_touching(order, parts)
    starts, fitted = LOBE_BYTES * lobes * VIEWS, 4 * VIEWS * (7 * lobes + 6)
    fits = [Stage(load.model * (samples_s + fit_s), sizes, SEEN_BYTES + starts, fitted, *pairs)]
    rows_s, channels = load.vertices * model.vector_s(DIFFUSE_ORDER), 3 if bounces else 1
    if bounces:
        shaded, fitted_s = load.model * load.occluded, fit_s * model.rate("gaussian-indirect-fit")
        indirect_s = shaded * (drawn_s + fitted_s) + load.model * load.closed * model.rate("gaussian-indirect")
        fits.append(Stage(indirect_s, sizes, starts, fitted, *pairs))
        bounce_s, sent = load.vertices * model.bounce_s("vector", DIFFUSE_ORDER, load), 12.0 * DIFFUSE_ORDER**2
        shared = (sent + MODEL_BYTES) * load.vertices
        fits += BOUNCES * [Stage(bounce_s, _split(load.vertices, BLOCK), 8.0, sent, shared_bytes=shared)]
        rows_s += bounce_s
    seen = _split(load.vertices, max(1, TEXELS // (FACES * gaussian_bake.EDGE**2)))
    return (
        Stage(model.visibility_s(gaussian_bake.EDGE, load), seen, 8.0, SEEN_BYTES),
        *fits,
        Stage(rows_s, _split(load.vertices, CHUNK), SEEN_BYTES, 4.0 * channels * DIFFUSE_ORDER**2),
    )


def _split(vertices: int, size: int) -> NDArray[np.int64]:
    """Sizes of pieces of `size` at most."""
    return np.diff(np.append(np.arange(0, vertices, size), vertices))


def error(errors: ModeErrors, setting: Setting) -> float:
    """The least with so many lobes."""
    found = [lobe_error(errors.scene, lobes) for lobes in range(1, setting["lobes"] + 1)]
    return max(FLOOR, min(each for each in found if each is not None))


def can_draw(scene: Scenery) -> bool:
    """Something has to be glossy."""
    return parts(scene.brdf)[1] is not None


def suits(offers: Any, skipped: frozenset[str]) -> bool:
    """True where what is left has a model's own parts, without which nothing is cut into lobes."""
    if any(offers.estimate(name) != 0.0 for name in skipped & _PARTS):
        return False
    brdf, force = offers.scene.brdf, offers.wishes.force
    if {"glossy", "anisotropy"} & force and (is_diffuse(brdf) or ("anisotropy" in force and brdf.isotropic)):
        return False
    return can_draw(offers.scene)


def adapt(setting: Setting, _diffuse: bool) -> Setting:
    """Nothing diffuse is drawn with lobes."""
    return setting


def draw(_kind: str, parameter: int, mesh: Mesh) -> RelightGaussians:
    """So many lobes that point up, all alike."""
    count = len(mesh.positions)
    up = np.broadcast_to(np.array([0.0, 1.0, 0.0], np.float32), (count, VIEWS, parameter, 3))
    alike = Lobes(np.ones_like(up), up, np.full(up.shape[:3], 0.2, np.float32))
    environment = EnvironmentMap(np.ones((32, 64, 3), np.float32))
    return relight_gaussians(GaussianTransport(mesh, count, 0.0, (alike,), None), environment)


def setting_of(relit: RelightGaussians) -> Setting:
    """That of its lobes, of which light from the model itself has as many."""
    components = relit.transport.components
    return Setting("gaussian", {"lobes": components[0].sigma.shape[2], "interreflection": len(components) - 1})


def prepare(plan: Any, subject: Subject, settings: GaussianSettings) -> Steps[PlannedBake]:
    """Work of a bake; if shadows are forced on, rays are cast from every vertex, free ones too."""
    work = yield from gaussian_method.prepare(subject, settings)
    if plan.decision("self-shadowing") == "forced on":
        of = every_ray(work.model.of, work.settings.edge, settings.fine)
        work = replace(work, model=replace(work.model, of=of))
    return PlannedBake(work, gaussian_bake.estimate_s(work), lambda path: gaussian_bake.bake(path, work))

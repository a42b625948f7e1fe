"""Spherical harmonics as a plan sees them: what a setting costs, its error, and its bake (`planned.Planning`)."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from engine.brdf.models.diffuse import Lambert
from engine.core.steps import Steps
from engine.geometry.mesh import Mesh
from engine.planning.costs.cost_model import Cost, CostModel, Load, basis_values
from engine.planning.costs.planned import PlannedBake
from engine.planning.costs.setting import Setting
from engine.planning.costs.sizes import channels, spherical_harmonics
from engine.planning.costs.spread import MODEL_BYTES, SEEN_BYTES, Stage
from engine.planning.effects.mode_error import FLOOR, ModeErrors, between, together
from engine.scene.mode import Spread
from engine.transport.baking.parts import kinds_of
from engine.transport.baking.settings import BOUNCES, ShSettings
from engine.transport.baking.visibility import every_ray
from engine.transport.method import Subject, method_of
from engine.transport.relight import RelightSh
from engine.transport.sh import bake as sh_bake
from engine.transport.sh.bake import default_edge
from engine.transport.sh.brdf_table import BrdfTable, lambert_table
from engine.transport.sh.transfer import ShTransport
from engine.transport.sh_method import bake_settings
from engine.transport.wavelet.haar import FACES

if TYPE_CHECKING:
    import os

    from engine.planning.effects.estimates import Scenery

#: Ratios of measured to predicted errors.
SPREAD = Spread(by_camera=(0.14, 2.6), around=(0.04, 3.0))


def cost(model: CostModel, setting: Setting, load: Load) -> Cost:
    order, edge = setting["order"], default_edge(setting["order"])
    matrices = 0 if load.diffuse else load.model
    bake_s = (
        model.rays_s(edge, load)
        + matrices * _matrix_s(model, order)
        + (load.vertices - matrices) * model.vector_s(order)
    )
    if not load.tables_made:
        bake_s += _tables_s(model, order, load.diffuse)
    if setting["interreflection"]:
        bake_s += (BOUNCES - 1) * load.vertices * model.bounce_s("vector", order, load)
        bake_s += matrices * model.bounce_s("matrix", order, load)
        bake_s += (load.vertices - matrices) * model.bounce_s("vector", order, load)
    sizes = spherical_harmonics(setting, load)
    bake_s += model.rate("file-byte") * sizes.file
    rows = load.vertices - matrices + matrices * order**2
    values = rows * order**2 * channels(setting, load)
    relight_s = model.measure_turning_s("light-sh", order, load) + model.rate("relight-sh", order) * values
    frame_s = model.frame_s("sh-flat" if load.diffuse else "sh", order**2, load)
    another_s = bake_s if setting["interreflection"] else None
    return Cost(
        bake_s, relight_s, frame_s, sizes.memory, method_of(setting.mode).estimate_file_bytes(sizes.file), another_s
    )


def stages(model: CostModel, setting: Setting, load: Load, _mesh: Mesh) -> tuple[Stage, ...]:
    """Bounces but for the last, and chunks of rows with their visibility and the last bounce."""
    order, edge = setting["order"], default_edge(setting["order"])
    matrices = 0 if load.diffuse else load.model
    seconds = model.visibility_s(edge, load) + matrices * _matrix_s(model, order)
    seconds += (load.vertices - matrices) * model.vector_s(order)
    if setting["interreflection"]:
        seconds += matrices * model.bounce_s("matrix", order, load)
        seconds += (load.vertices - matrices) * model.bounce_s("vector", order, load)
    bounds = sh_bake.vertex_bounds(load.vertices, load.model, sh_bake.BakeSettings(order, edge))
    rows, each = matrices * order**2 + load.vertices - matrices, 4.0 * order**2 * channels(setting, load)
    chunks = Stage(seconds, np.diff(bounds), 0.0, each * rows / load.vertices + SEEN_BYTES * edge / 64)
    if not setting["interreflection"]:
        return (chunks,)
    bounce_s, sent = load.vertices * model.bounce_s("vector", order, load), each * load.vertices
    bounce = Stage(bounce_s, np.diff(bounds), 8.0, each, shared_bytes=sent + MODEL_BYTES * load.vertices)
    return (*(BOUNCES - 1) * (bounce,), replace(chunks, shared_bytes=sent))


def _matrix_s(model: CostModel, order: int) -> float:
    """Seconds of a vertex's matrix, its visibility being known: SH of that, products, and a rotation."""
    return FACES * default_edge(order) ** 2 * model.rate("sh-seen", 2 * order - 1) + model.rate("sh-matrix", order)


def _tables_s(model: CostModel, order: int, diffuse: bool) -> float:
    """Seconds of the tables that a process makes once: integrals over texels, and of products of three."""
    if diffuse:
        return model.rate("sh-basis") * basis_values(default_edge(order), order)
    integrals = model.rate("sh-basis") * basis_values(default_edge(order), 2 * order - 1)
    return integrals + model.rate("sh-products", order)


def error(errors: ModeErrors, setting: Setting) -> float:
    """That of the truncated sums, and of radiance between the vertices."""
    return max(FLOOR, together(between(errors.spherical_harmonics, setting["order"]), errors.interpolated))


def can_draw(_scene: Scenery) -> bool:
    """Every BRDF can be tabulated."""
    return True


def suits(_offers: object, _skipped: frozenset[str]) -> bool:
    """Also one from which something is left out."""
    return True


def adapt(setting: Setting, _diffuse: bool) -> Setting:
    """All parameters matter of a diffuse BRDF too."""
    return setting


def draw(kind: str, parameter: int, mesh: Mesh) -> RelightSh:
    """So many coefficients, of a table or, where it is flat, of a diffuse BRDF."""
    count, order, flat = len(mesh.positions), math.isqrt(parameter), kind == "sh-flat"
    table = lambert_table(Lambert((0.5, 0.5, 0.5)), order) if flat else BrdfTable(order, np.ones((256, parameter, 3)))
    rows = count * (1 if flat else parameter)
    nothing_yet = np.broadcast_to(np.float32(0.0), (rows, 1, parameter))
    return RelightSh(ShTransport(mesh, count, flat, 0.0, table, False, nothing_yet), np.ones((rows, 3), np.float32))


def setting_of(relit: RelightSh) -> Setting:
    """That of its order: bounces lie in the rows."""
    return Setting("sh", {"order": relit.transport.order})


def prepare(plan: Any, subject: Subject, settings: ShSettings) -> Steps[PlannedBake]:
    """Without shadows no ray is cast; where they are forced on, rays are cast from every vertex, free ones too."""
    shadows = plan.shows("self-shadowing") or plan.shows("interreflection")
    asked = bake_settings(settings, shadows=shadows)
    mesh, ground, varied = subject.mesh, subject.ground, subject.variations
    kinds = kinds_of(mesh, subject.parts)
    work = replace((yield from sh_bake.prepare(mesh, subject.brdf, asked, ground, varied, kinds)), kept=subject.kept)

    def start(path: str | os.PathLike[str]) -> Steps[Any]:
        forced = plan.decision("self-shadowing") == "forced on"
        of = every_ray(sh_bake.receivers_of(work), asked.edge, asked.fine) if forced else None
        return (yield from sh_bake.bake(path, work, of))

    return PlannedBake(work, plan.cost.bake_s, start)

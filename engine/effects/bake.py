"""Baking what a plan calls for, and nothing else: what is left out costs no call and no byte.

    self-shadowing   left out: no ray, no tree of the triangles; forced on: rays from every vertex, free ones too
    interreflection  left out: no bounce
    glossy           left out: vectors instead of matrices; forced on: matrices whatever the reflectance
    anisotropy       left out: one row of the table instead of a map; forced on: the map
    all-frequency    left out: few harmonics
    varying gloss    left out: one reflectance, at the mean of what varies, and one table of it

Whatever is decided for the whole, vertices that see their whole hemisphere have no visibility, unless it is forced.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from engine.effects.choices import BAKED
from engine.effects.cost_model import BOUNCES, MATT_ORDER
from engine.effects.plan import EffectsPlan, brdf_of
from engine.ground import Ground
from engine.mesh import Mesh
from engine.steps import Steps
from engine.transport import gaussian_bake, sh_bake, wavelet_bake
from engine.transport.occluder import Occluder
from engine.transport.variation import Variation
from engine.transport.visibility import Receivers, every_ray

__all__ = ["BAKED", "BOUNCES", "PlannedBake", "prepare"]


@dataclass(frozen=True, eq=False)
class PlannedBake:
    """A bake that follows a plan and is ready to begin: its work, how long it may take, and what does it."""

    work: Any
    estimated_s: float
    start: Callable[[str | os.PathLike[str]], Steps[Any]]


@dataclass(frozen=True, eq=False)
class _EveryRay(Occluder):
    """The model itself, asked from every vertex."""

    edge: int = 32
    fine: int = 4

    def receivers(self, mesh: Mesh) -> Receivers:
        return every_ray(super().receivers(mesh), self.edge, self.fine)


def prepare(
    plan: EffectsPlan,
    mesh: Mesh,
    brdf: Any,
    ground: Ground | None = None,
    *,
    variations: Sequence[Variation] = (),
    fine: int = 4,
) -> Steps[PlannedBake]:
    """Lay out the bake of `mesh` with the reflectance `brdf` that `plan` calls for; nothing is written.

    `variations` are those that the plan was made with. ValueError where the plan's mode is not baked.
    """
    setting, reflectance = plan.setting, brdf_of(plan, brdf)
    forced = plan.decision("self-shadowing") == "forced on"
    varying = tuple(variations) if plan.shows("spatially-varying-gloss") else ()
    if setting.mode == "sh":
        settings = sh_bake.BakeSettings(
            setting["order"],
            sh_bake.default_edge(setting["order"]),
            fine,
            BOUNCES if setting["interreflection"] else 0,
            shadows=plan.shows("self-shadowing") or plan.shows("interreflection"),
        )
        work = yield from sh_bake.prepare(mesh, reflectance, settings, ground, varying)

        def start(path: str | os.PathLike[str]) -> Steps[Any]:
            of = every_ray(sh_bake.receivers_of(work), settings.edge, fine) if forced else None
            return (yield from sh_bake.bake(path, work, of))

        return PlannedBake(work, plan.cost.bake_s, start)
    if setting.mode == "wavelet":
        factors = yield from wavelet_bake.factors_for(reflectance, setting["terms"])
        wanted = wavelet_bake.BakeSettings(setting["cube"], setting["coefficients"], fine)
        laid = wavelet_bake.prepare(mesh, factors, wanted, ground)
        if forced:
            laid = replace(laid, occluder=_EveryRay(laid.occluder.caster, 0.0, wanted.edge, fine))
        return PlannedBake(laid, plan.cost.bake_s, lambda path: wavelet_bake.bake(path, laid))
    if setting.mode == "gaussian":
        edge = sh_bake.default_edge(MATT_ORDER)
        asked = gaussian_bake.BakeSettings(
            setting["lobes"], bool(setting["interreflection"]), order=MATT_ORDER, edge=edge, fine=fine
        )
        cut = yield from gaussian_bake.prepare(mesh, reflectance, asked, ground, varying)
        if forced:
            cut = replace(cut, model=replace(cut.model, of=every_ray(cut.model.of, edge, fine)))
        return PlannedBake(cut, gaussian_bake.estimate_s(cut), lambda path: gaussian_bake.bake(path, cut))
    raise ValueError(f"the mode {setting.mode} is not baked")

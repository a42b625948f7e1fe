"""Baking what a plan calls for, and nothing else: what is left out costs no call and no byte.

    self-shadowing   left out: no ray, no tree of the triangles; forced on: rays from every vertex, free ones too
    interreflection  left out: no bounce
    glossy           left out: vectors instead of matrices; forced on: matrices whatever the BRDF
    anisotropy       left out: one row of the table instead of a map; forced on: the map
    all-frequency    left out: spherical harmonics of a low order
    varying gloss    left out: one BRDF, at the mean of what varies, and one table of it

Whatever is decided for the whole, vertices that see their whole hemisphere have no visibility, unless it is forced.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from engine.core.errors import UsageError
from engine.core.steps import Steps
from engine.geometry.backs import with_backs
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.geometry.parts import split_parts
from engine.planning.costs.planned import PlannedBake, planning_of
from engine.planning.plan import EffectsPlan, brdf_of
from engine.transport import method as transport
from engine.transport.baking.spatially_varying import Variation
from engine.transport.method import Subject

if TYPE_CHECKING:
    from pathlib import Path

    from engine.brdf.brdf import Brdf


def prepare(
    plan: EffectsPlan,
    mesh: Mesh,
    brdf: Brdf,
    ground: Ground | None = None,
    *,
    variations: Sequence[Variation] = (),
    settings: Any = None,
    fine: int | None = None,
    kept: Path | None = None,
    parts: tuple[Brdf, ...] = (),
) -> Steps[PlannedBake]:
    """Lay out the bake of `mesh` with the BRDF `brdf` that `plan` calls for; nothing is written.

    `variations` are those that the plan was made with. `settings` of the method stand beside the parameters of the
    plan, their defaults where there are none, with `fine` of its own. `kept` is the folder of records of visibility,
    and `parts` the BRDFs of the parts of the model, where these have their own.
    UsageError where the plan's mode is not baked.
    """
    if plan.mode not in transport.names():
        raise UsageError(f"the mode {plan.mode} is not baked")
    method = transport.method_of(plan.mode)
    base = method.settings() if settings is None else settings
    own = {**plan.setting.parameters, **({} if fine is None else {"fine": fine})}
    varying = tuple(variations) if plan.shows("spatially-varying-gloss") else ()
    whole, shown = split_parts(mesh) if parts else mesh, tuple(brdf_of(plan, each) for each in parts)
    subject = Subject(with_backs(whole, ground), brdf_of(plan, brdf), ground, varying, kept, shown)
    return (yield from planning_of(plan.mode).prepare(plan, subject, method.with_values(own, base)))

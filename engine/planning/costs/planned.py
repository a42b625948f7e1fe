"""A bake that a plan has laid out, and what the planning module of a method offers (`Method.planning`)."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, cast

from engine.core.steps import Steps
from engine.planning.costs.setting import Setting
from engine.scene.mode import Spread
from engine.transport.method import Subject, method_of

if TYPE_CHECKING:
    from engine.geometry.mesh import Mesh
    from engine.planning.costs.cost_model import Cost, CostModel
    from engine.planning.costs.load import Load
    from engine.planning.costs.spread import Stage
    from engine.transport.relight import RelightTransport


@dataclass(frozen=True, eq=False)
class PlannedBake:
    """A bake that follows a plan and is ready to begin: its work, how long it may take, and what does it."""

    work: Any
    estimated_s: float
    start: Callable[[str | os.PathLike[str]], Steps[Any]]


class Planning(Protocol):
    """The module that plans a method.

    Attributes
    ----------
    SPREAD : how far measured errors are from the predicted ones.
    """

    SPREAD: Spread

    def cost(self, model: CostModel, setting: Setting, load: Load) -> Cost:
        """Cost of a setting, as a `cost_model.Cost`, by the rates of a `cost_model.CostModel`."""

    def stages(self, model: CostModel, setting: Setting, load: Load, mesh: Mesh) -> tuple[Stage, ...]:
        """Parts of the bake of `mesh` that workers of a cluster do; the rest of its cost is done here."""

    def error(self, errors: Any, setting: Setting) -> float:
        """The relative error of a setting, from the `mode_error.ModeErrors` of a scene."""

    def can_draw(self, scene: Any) -> bool:
        """True where settings can draw the BRDF of a `estimates.Scenery` at all."""

    def suits(self, offers: Any, skipped: frozenset[str]) -> bool:
        """True where they can draw what is left of it without `skipped` effects, for `choices.Choices`."""

    def adapt(self, setting: Setting, diffuse: bool) -> Setting:
        """The setting without parameters that change nothing of a diffuse BRDF."""

    def draw(self, kind: str, parameter: int, mesh: Mesh) -> RelightTransport:
        """Something of a kind of `Method.frames` on `mesh` that can be drawn; its numbers mean nothing."""

    def setting_of(self, relit: RelightTransport) -> Setting:
        """The setting whose images cost what those of `relit` do; ValueError where it is none of a plan."""

    def prepare(self, plan: Any, subject: Subject, settings: Any) -> Steps[PlannedBake]:
        """Lay out the bake that a `plan.EffectsPlan` of this method calls for, with the rest of the settings."""


def planning_of(mode: str) -> Planning:
    """The planning module of a method; KeyError for a mode that is not a method."""
    return cast(Planning, method_of(mode).planning)

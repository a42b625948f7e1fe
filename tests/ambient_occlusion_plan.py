"""Ambient occlusion (`tests.ambient_occlusion`) as a plan sees it."""

from __future__ import annotations

from typing import Any

from engine.core.steps import Steps
from engine.planning.costs.cost_model import Cost
from engine.planning.costs.planned import PlannedBake
from engine.planning.costs.setting import Setting
from engine.scene.mode import Spread
from engine.transport.method import Subject
from tests import ambient_occlusion

#: Ratios of measured to predicted errors.
SPREAD = Spread((0.1, 10.0), (0.1, 10.0))


def cost(_model: Any, setting: Any, load: Any) -> Cost:
    size = 4 * load.vertices
    return Cost(1e-9 * load.vertices * setting["rays"], 1e-9, 1e-9, load.mesh_bytes + size, load.mesh_bytes + size)


def error(_errors: Any, setting: Any) -> float:
    return 0.2 + 0.8 / float(setting["rays"])


def can_draw(_scene: Any) -> bool:
    return True


def suits(_offers: Any, _skipped: frozenset[str]) -> bool:
    return True


def adapt(setting: Any, _diffuse: bool) -> Any:
    return setting


def setting_of(_relit: Any) -> Setting:
    return Setting(ambient_occlusion.NAME)


def prepare(plan: Any, subject: Subject, settings: Any) -> Steps[PlannedBake]:
    work = yield from ambient_occlusion.prepare(subject, settings)
    return PlannedBake(work, plan.cost.bake_s, lambda path: ambient_occlusion.bake(path, work))

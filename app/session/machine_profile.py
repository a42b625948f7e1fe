"""The machine profile: measured once, kept in the person's cache folder, measured again if it is missing."""

from __future__ import annotations

import logging
import time
from pathlib import Path
from typing import TYPE_CHECKING

from app.session.settings import cache_folder
from engine.core.figure_text import percent
from engine.core.steps import Step, Steps

if TYPE_CHECKING:
    from collections.abc import Sequence

    from engine.planning.costs.cost_model import CostModel
    from engine.tradeoff.point import Point

log = logging.getLogger(__name__)

NAME = "cost-model.json"


def cost_path() -> Path | None:
    """The file of the machine profile; None if the system names no usable folder."""
    folder = cache_folder()
    return folder / NAME if folder is not None else None


def cost_model(*, anew: bool = False) -> Steps[CostModel]:
    """The kept profile of this machine, or one measured now (some ten seconds) and kept if possible.

    One that was kept too long, or measured beside other programs, is measured again.
    """
    from engine.planning.costs.cost_model import BUSY, load_model
    from engine.planning.costs.machine_profile import calibrate

    path = cost_path()
    kept = load_model(path) if path is not None and not anew else None
    if kept is not None and not kept.expired(time.time()):
        yield Step(1.0, "the machine profile is known")
        return kept
    model = yield from calibrate()
    if model.background_load > BUSY:
        log.warning(
            "Other programs used %s of the processors during this measurement, so predicted times are too long. "
            "Measure it again when it is idle, with: lightarc plan … --calibrate",
            percent(model.background_load),
        )
    if path is not None:
        _keep(model, path)
    return model


def learn(method: str, predicted_s: float, bake_s: float) -> None:
    """Tell the kept profile what a bake of `method` really took, from its start to its end without a pause."""
    from engine.planning.costs.cost_model import load_model

    path = cost_path()
    kept = load_model(path) if path is not None else None
    if path is not None and kept is not None:
        found = kept.learned(method, predicted_s, bake_s)
        if found is not kept:
            _keep(found, path)


def learn_from(points: Sequence[Point]) -> None:
    """Tell the kept profile what the bakes of a tradeoff took: of each method the one in the middle."""
    ratios: dict[str, list[tuple[float, float, float]]] = {}
    for point in points:
        predicted_s = point.predicted.get("bake_s", 0.0)
        if predicted_s > 0.0:
            ratios.setdefault(point.mode, []).append((point.bake_s / predicted_s, predicted_s, point.bake_s))
    for method, found in ratios.items():
        _, predicted_s, bake_s = sorted(found)[len(found) // 2]
        learn(method, predicted_s, bake_s)


def _keep(model: CostModel, path: Path) -> None:
    from engine.core.errors import OutputError
    from engine.planning.costs.cost_model import save

    try:
        save(model, path)
    except OutputError as error:
        log.warning("The machine profile cannot be saved: %s", error)

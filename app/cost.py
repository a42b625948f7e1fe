"""The costs of this machine: measured once, kept in the person's cache folder, measured anew where they are gone."""

from __future__ import annotations

import logging
import os
from pathlib import Path
from typing import TYPE_CHECKING

import platformdirs

from engine.steps import Step, Steps

if TYPE_CHECKING:
    from engine.effects.cost_model import CostModel

log = logging.getLogger(__name__)

NAME = "cost-model.json"

#: Share of the processors that other programs may have without a word about it.
BUSY = 0.2


def cost_path() -> Path | None:
    """Where the model is kept; None where the system names no usable place."""
    folder = Path(os.path.expandvars(platformdirs.user_cache_dir("lightarc", appauthor=False)))
    return folder / NAME if folder.is_absolute() else None


def cost_model(*, anew: bool = False) -> Steps[CostModel]:
    """The kept model of this machine, or one that is measured now (some ten seconds) and kept where that can be."""
    from engine.effects.calibration import calibrate
    from engine.effects.cost_model import load_model, save
    from engine.errors import OutputError

    path = cost_path()
    kept = load_model(path) if path is not None and not anew else None
    if kept is not None:
        yield Step(1.0, "the costs of this machine are known")
        return kept
    model = yield from calibrate()
    if model.others > BUSY:
        words = (
            "Other programs had %.0f %% of the processors while this machine was measured, so times are told too long"
        )
        log.warning(
            f"{words}. Measure it again when it is idle, with: lightarc plan … --calibrate", 100.0 * model.others
        )
    if path is not None:
        try:
            save(model, path)
        except OutputError as error:
            log.warning("The costs of this machine are not kept: %s", error)
    return model

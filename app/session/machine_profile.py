"""The machine profile: measured once, kept in the person's cache folder, measured again if it is missing."""

from __future__ import annotations

import logging
import os
from pathlib import Path
from typing import TYPE_CHECKING

import platformdirs

from engine.core.steps import Step, Steps

if TYPE_CHECKING:
    from engine.planning.costs.cost_model import CostModel

log = logging.getLogger(__name__)

NAME = "cost-model.json"

#: Share of the processors that other programs may have without a word about it.
BUSY = 0.2


def cost_path() -> Path | None:
    """The file of the machine profile; None if the system names no usable folder."""
    folder = Path(os.path.expandvars(platformdirs.user_cache_dir("lightarc", appauthor=False)))
    return folder / NAME if folder.is_absolute() else None


def cost_model(*, anew: bool = False) -> Steps[CostModel]:
    """The kept profile of this machine, or one measured now (some ten seconds) and kept if possible."""
    from engine.core.errors import OutputError
    from engine.planning.costs.cost_model import load_model, save
    from engine.planning.costs.machine_profile import calibrate

    path = cost_path()
    kept = load_model(path) if path is not None and not anew else None
    if kept is not None:
        yield Step(1.0, "the machine profile is known")
        return kept
    model = yield from calibrate()
    if model.background_load > BUSY:
        words = "Other programs used %.0f %% of the processors during this measurement, so predicted times are too long"
        log.warning(
            f"{words}. Measure it again when it is idle, with: lightarc plan … --calibrate",
            100.0 * model.background_load,
        )
    if path is not None:
        try:
            save(model, path)
        except OutputError as error:
            log.warning("The machine profile cannot be saved: %s", error)
    return model

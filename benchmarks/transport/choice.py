"""The choice of a plan beside the best of all settings, by errors that are measured, on generated scenes.

Every setting of a scene below the ceilings of plans is measured (`benchmarks.transport.predictions`), and counts as
what it costs where its error is within the budget. Beyond the budget it counts as what it costs times the square of
the error over the budget, as of the reference, which takes four times as long for half the error. Costs are those of
the machine profile. Nothing that shows is left out, and images are of direct light.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np

from benchmarks.measure import Accuracy
from benchmarks.transport.generated_scenes import generate
from benchmarks.transport.plan import costs
from benchmarks.transport.predictions import (
    LEFT_OUT,
    STEPS,
    check_campaign,
    errors_of,
    list_baked_modes,
    measure,
)
from engine.accuracy.compare import ErrorEstimate
from engine.core.figure_text import number, percent
from engine.core.steps import Step, Steps
from engine.planning.ceilings import usual
from engine.planning.choices import Choice, Choices, Wishes
from engine.planning.costs.cost_model import CostModel
from engine.planning.costs.setting import Setting, parameters_of
from engine.planning.effects.sample import COMPARED
from engine.planning.plan import best, offer
from engine.tradeoff.draw import Drawer, drawing

#: Scenes where nobody says how many, how much dearer a choice may be than the best, and the share that may be more.
SCENES, DEARER, SHARE = 10, 1.2, 0.1

#: Least and largest budget of error, settings that are few, and directions of lights.
BUDGETS, FEW, DIRECTIONS = (0.01, 0.2), 3, (16, 64, 256)


@dataclass(frozen=True)
class Chosen:
    """The choice of one scene: `ratio` is what it counts as, over what the best of `settings` counts as."""

    seed: int
    scene: str
    budget: float
    choice: Setting
    choice_error: float
    best: Setting
    best_error: float
    ratio: float
    settings: int

    def __str__(self) -> str:
        one, other = (f"{setting} ({percent(error)})" for setting, error in self._both)
        return f"{self.scene}: {one} for a budget of {percent(self.budget)}; best of {self.settings}: {other}"

    @property
    def _both(self) -> tuple[tuple[Setting, float], ...]:
        return (self.choice, self.choice_error), (self.best, self.best_error)


def choices(_folder: Path, *, scenes: int = SCENES, seed: int = 0, data: Path | None = None) -> Steps[list[Accuracy]]:
    """A row for each scene, from `seed` on, and the share of those where the choice is not nearly the best.

    Files of the folder `data` join the models and the BRDFs. UsageError for no scene, InputError for no folder.
    """
    check_campaign(scenes, data)
    model, found = costs(), list[Chosen]()
    with ExitStack() as stack:
        drawer = stack.enter_context(drawing((COMPARED, COMPARED)))
        for place in range(scenes):
            yield Step(place / scenes, f"planning and measuring scene {seed + place}")
            found.append(choose(seed + place, drawer, model, data))
    return summary(found)


def summary(found: Sequence[Chosen]) -> list[Accuracy]:
    rows = [Accuracy(f"choice-{each.seed}", each.ratio, str(each), DEARER) for each in found]
    share = float(np.mean([each.ratio > DEARER for each in found]))
    words = f"share of {len(found)} scenes whose choice is more than {number(DEARER)} times as dear as the best"
    return [*rows, Accuracy("choices-dearer", share, words, SHARE)]


def choose(seed: int, drawer: Drawer, model: CostModel, data: Path | None = None) -> Chosen:
    """The scene of `seed`, planned, and all its settings measured."""
    rng = np.random.default_rng((31, seed))
    low, high = np.log(BUDGETS)
    budget = float(np.exp(rng.uniform(low, high)))
    name, scene = generate(seed, data)
    errors = errors_of(scene)
    offers = Choices(errors.scene, errors.found, model, Wishes(skip=frozenset({LEFT_OUT})), errors.noise)
    settings = _settings(seed, rng)
    every = [each for each in offers.all(budget) if each.setting in settings or each.setting.mode == "reference"]
    least = min((each.skipped for each in every), key=len)
    every = [each for each in every if each.skipped == least]
    every = offer(every, usual())
    planned, _ = best(every, budget, None)
    exact = measure(scene, [each.setting for each in every], drawer)
    counted = {each.setting: _count(each, exact[each.setting], budget) for each in every if each.setting in exact}
    least_of_all = min(counted, key=lambda setting: counted[setting])
    return Chosen(
        *(seed, name, budget),
        *(planned.setting, exact[planned.setting].rmse_rel),
        *(least_of_all, exact[least_of_all].rmse_rel),
        counted[planned.setting] / counted[least_of_all],
        len(counted),
    )


def _settings(seed: int, rng: np.random.Generator) -> frozenset[Setting]:
    """The first steps of every sweep; of a mode with many sweeps a few."""
    found = [Setting("direct", {"directions": directions}) for directions in DIRECTIONS]
    for mode in list_baked_modes(seed):
        sweeps = {name: parameter.sweep[:STEPS] for name, parameter in parameters_of(mode).items()}
        if LEFT_OUT in sweeps:
            sweeps[LEFT_OUT] = (0,)
        turned = [Setting(mode, dict(zip(sweeps, values, strict=True))) for values in product(*sweeps.values())]
        is_many = len(turned) > 2 * FEW
        found += [turned[at] for at in rng.choice(len(turned), FEW, replace=False)] if is_many else turned
    return frozenset(found)


def _count(each: Choice, error: ErrorEstimate, budget: float) -> float:
    """Price of a setting, its error being as small as its uncertainty allows."""
    least = max(error.rmse_rel - error.uncertainty, 0.0)
    return each.price * max(1.0, least / budget) ** 2

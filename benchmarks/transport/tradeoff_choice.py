"""The choices of `lightarc tradeoff` in a minute beside the best of all settings, on generated scenes.

In a scene that is swept with little time the setting is chosen for each budget of error. Then every setting that the
sweep could have measured is, and the best is the cheapest that is not further off than the chosen one, as far as the
reference knows. Both are counted by the machine profile: a frame with its share of the bake.
"""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.measure import Accuracy
from benchmarks.transport.generated_scenes import generate_varied
from benchmarks.transport.plan import costs
from benchmarks.transport.predictions import check_campaign, measure
from engine.accuracy.compare import ErrorEstimate
from engine.core.figure_text import number, percent
from engine.core.steps import Step, Steps
from engine.planning.choices import PIXELS
from engine.planning.costs.cost_model import CostModel
from engine.planning.costs.setting import Setting
from engine.scene.mode import is_traced
from engine.scene.scene import Scene
from engine.tradeoff.agenda import modes_of, settings_of
from engine.tradeoff.draw import Drawer, drawing
from engine.tradeoff.expect import price
from engine.tradeoff.front import Budget, choose
from engine.tradeoff.sweep import sweep

#: Scenes where nobody says how many, vertices of a model at most, and seconds of a sweep.
SCENES, MAX_VERTICES, SECONDS = 5, 3_000, 60.0

#: Pixels of the images, budgets of error, how much dearer a choice may be than the best, and the share that may be.
SIZE, BUDGETS, DEARER, SHARE = (96, 72), (0.02, 0.05, 0.1, 0.2), 1.2, 0.1


@dataclass(frozen=True)
class Chosen:
    """The choice for a budget in one scene: `ratio` is its price over that of the best of `settings`."""

    seed: int
    budget: float
    choice: Setting
    error: float
    best: Setting
    ratio: float
    settings: int

    def __str__(self) -> str:
        return f"{self.choice} ({percent(self.error)}); best of {self.settings} at equal error: {self.best}"


def tradeoff_choices(_folder: Path, *, scenes: int = SCENES, seed: int = 0) -> Steps[list[Accuracy]]:
    """A row for each scene and budget that a setting was found for, and the share of choices that are too dear."""
    check_campaign(scenes, None)
    model, found = costs(), list[Chosen]()
    with ExitStack() as stack:
        drawer = stack.enter_context(drawing(SIZE))
        done = 0
        while done < scenes:
            _, scene = generate_varied(seed)
            if len(scene.mesh.positions) <= MAX_VERTICES:
                yield Step(done / scenes, f"sweeping scene {seed}")
                found += yield from _judge(seed, scene, drawer, model)
                done += 1
            seed += 1
    rows = [Accuracy(f"tradeoff-{each.seed}-{percent(each.budget)}", each.ratio, str(each), DEARER) for each in found]
    share = float(np.mean([each.ratio > DEARER for each in found])) if found else 0.0
    words = f"share of {len(found)} choices that are more than {number(DEARER)} times as dear as the best"
    return [*rows, Accuracy("tradeoff-choices-dearer", share, words, SHARE)]


def _judge(seed: int, scene: Scene, drawer: Drawer, model: CostModel) -> Steps[list[Chosen]]:
    settings = settings_of(scene, modes_of(scene))
    swept = yield from sweep(scene, settings, SIZE, seconds=SECONDS, costs=model)
    chosen = {budget: choose(swept.points, Budget(error=budget)).point for budget in BUDGETS}
    every = [each.setting for each in swept.points] + [each.setting for each in swept.left_out]
    exact = measure(scene, [each for each in dict.fromkeys(every) if not is_traced(each.mode)], drawer)
    prices = {each: _price(each, scene, model) for each in exact}
    return [
        compare_choice(seed, budget, point.setting, exact, prices)
        for budget, point in chosen.items()
        if point is not None and point.setting in exact
    ]


def compare_choice(
    seed: int, budget: float, choice: Setting, exact: dict[Setting, ErrorEstimate], prices: dict[Setting, float]
) -> Chosen:
    """A choice beside the cheapest setting whose error is not larger, as far as it is known."""
    error = exact[choice].rmse_rel
    equal = [each for each in exact if exact[each].rmse_rel + exact[each].uncertainty <= error]
    best = min((choice, *equal), key=lambda each: prices[each])
    return Chosen(seed, budget, choice, error, best, prices[choice] / prices[best], len(exact))


def _price(setting: Setting, scene: Scene, model: CostModel) -> float:
    cost = model.predict(setting, len(scene.mesh.positions), PIXELS)
    return price(cost.frame_s, cost.bake_s)

"""The prior of predicted errors: what predictions and small images said of generated scenes, and what was measured.

    python -m benchmarks.transport.prior collect FOLDER --scenes 50 --seed 0
    python -m benchmarks.transport.prior fit FOLDER
    python -m benchmarks.transport.prior judge FOLDER

`collect` keeps a JSON file of each scene in the folder and goes on where it stopped. `fit` learns the prior of
`engine.planning.prior` from them and writes it; `judge` compares intervals and probabilities with what was measured.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from benchmarks.transport.generated_scenes import generate_varied
from benchmarks.transport.predictions import LEFT_OUT, errors_of, measure
from engine.core.steps import drain
from engine.planning.choices import BYTE_S, DIRECTIONS, FRAMES, LIGHTS, PIXELS
from engine.planning.costs.cost_model import Cost
from engine.planning.costs.machine_profile import quick_profile
from engine.planning.costs.setting import Setting, setting_of
from engine.planning.effects.mode_error import mode_errors
from engine.planning.plan import QUICK_DIRECTIONS, select_doubtful
from engine.planning.plan import SMALL as STAGES
from engine.planning.predicted_error import MIDDLES, spread
from engine.planning.prior import (
    LEVELS,
    MINIMUM,
    SHIPPED,
    SURE,
    Deviations,
    Distribution,
    Posterior,
    Prior,
    read_prior,
)
from engine.planning.small_images import Measured, as_record, measure_small
from engine.scene.scene import Scene
from engine.storage.atomic import write_json
from engine.tradeoff.draw import drawing

#: Settings of small images.
SMALL = tuple(setting for stage in STAGES for setting in stage)

#: Settings of small images of which a plan measures those that its first answer asks for.
FINER = tuple(
    setting
    for setting in (
        *(Setting("direct", {"directions": count}) for count in DIRECTIONS if count <= QUICK_DIRECTIONS),
        *(Setting("sh", {"order": order}) for order in (3, 5, 12)),
    )
    if setting not in SMALL
)

#: Pixels of the images that count as the truth, and the seconds that their reference may take.
SIZE, REFERENCE_S = (96, 72), 10.0

#: Gaussians take as long as all else together, cube maps of an edge of 64 half of it: they are measured in one scene of
#: so many. Models of more vertices than these are left out.
GAUSSIANS, FINE, MAX_VERTICES = 12, 6, 3_000

#: Settings whose errors are measured, the last two over cube maps of an edge of 64.
ASKED = (
    *(Setting("direct", {"directions": directions}) for directions in DIRECTIONS),
    *(Setting("sh", {"order": order}) for order in (3, 5, 8)),
    *(
        Setting("wavelet", {"terms": terms, "coefficients": kept, "cube": 32})
        for terms, kept in ((1, 24), (1, 96), (2, 48), (4, 24), (4, 96), (4, 384))
    ),
    Setting("reference", {"samples": 4}),
    Setting("sh", {"order": 12}),
    Setting("wavelet", {"terms": 4, "coefficients": 192, "cube": 64}),
)


def collect(folder: Path, seed: int) -> dict[str, Any]:
    """Predict and measure the scene of `seed`."""
    name, scene = generate_varied(seed)
    times = [time.process_time()]
    errors = errors_of(scene)
    modes = mode_errors(errors.scene)
    asked = [each for each in ASKED if each.mode in ("direct", "reference") or modes.knows(each.mode)]
    if seed % FINE != 1:
        asked = [each for each in asked if each not in ASKED[-2:]]
    if seed % GAUSSIANS == 2 and modes.knows("gaussian"):
        asked.append(Setting("gaussian", {"lobes": 1}))
    skipped = frozenset({LEFT_OUT})
    predicted = {each: errors.predict(each, skipped) for each in asked}
    times.append(time.process_time())
    small = drain(measure_small(scene, [each for each in (*SMALL, *FINER) if each in asked]))
    times.append(time.process_time())
    with drawing(SIZE) as drawer:
        measured = measure(scene, asked, drawer, REFERENCE_S)
    times.append(time.process_time())
    rows = [
        {
            **each.as_json(),
            "predicted": predicted[each],
            "interval": [predicted[each] * ratio for ratio in spread(each.mode).by_camera],
            "measured": measured[each].rmse_rel,
            "uncertainty": measured[each].uncertainty,
        }
        for each in asked
        if each in measured
    ]
    facts = {"seed": seed, "scene": name, "vertices": len(scene.mesh.positions), "isotropic": _is_isotropic(scene)}
    seconds = [late - early for early, late in itertools.pairwise(times)]
    return {**facts, "seconds": seconds, "small": as_record(small), "rows": rows}


def collect_small(path: Path) -> None:
    """Measure the small images of a scene anew that was collected."""
    record = json.loads(path.read_text("utf-8"))
    _, scene = generate_varied(record["seed"])
    asked = {setting_of(each) for each in record["rows"]}
    record["small"] = as_record(drain(measure_small(scene, [each for each in (*SMALL, *FINER) if each in asked])))
    write_json(path, record)


def _is_isotropic(scene: Scene) -> bool:
    return bool(scene.brdf.isotropic)


#: Degrees of freedom of the distribution that the fit takes errors to have: some scenes are far off.
FREEDOM = 5.0

#: Parts of the scenes, each judged by a prior of the others.
FOLDS = 5

#: Deviations below which nothing is fitted, and the modes that the fit knows.
SMALLEST, MODES = 0.02, ("direct", "sh", "wavelet", "gaussian", "reference")

#: Budgets that choices and promises are judged by.
BUDGETS = (0.02, 0.05, 0.1, 0.2)

#: An error that is known worse than this share of it tells nothing of predictions.
KNOWN = 0.2


@dataclass(frozen=True, eq=False)
class Judged:
    """A scene that was collected: by setting what is `predicted`, `measured`, and its stated `intervals`.

    `small` are its small images, `finer` those that are measured where a first choice asks for them.
    """

    seed: int
    scene: str
    vertices: int
    predicted: dict[Setting, float]
    measured: dict[Setting, float]
    intervals: dict[Setting, tuple[float, float]]
    small: dict[Setting, Measured]
    finer: dict[Setting, Measured]


def read_scenes(folder: Path) -> list[Judged]:
    """The scenes of a folder, without errors that the noise of the reference hides."""
    found = []
    for path in sorted(folder.glob("*.json")):
        record = json.loads(path.read_text("utf-8"))
        rows = {setting_of(each): each for each in record["rows"]}
        known = {
            setting: each
            for setting, each in rows.items()
            if each["uncertainty"] <= KNOWN * max(each["measured"], MINIMUM)
        }
        small = {setting_of(each): Measured(each["error_rel"], each["deviation"]) for each in record["small"]}
        finer = {setting: each for setting, each in small.items() if setting in FINER}
        small = {setting: each for setting, each in small.items() if setting in SMALL}
        found.append(
            Judged(
                record["seed"],
                record["scene"],
                record["vertices"],
                {setting: each["predicted"] for setting, each in rows.items()},
                {setting: each["measured"] for setting, each in known.items()},
                {setting: tuple(each["interval"]) for setting, each in rows.items()},
                small,
                finer,
            )
        )
    return found


def _prior(values: NDArray[np.float64], quantiles: tuple[float, ...] = ()) -> Prior:
    """The prior of the numbers that are fitted: logarithms of deviations, and means."""
    common, small = np.exp(values[:2])
    rest = values[2:].reshape(len(MODES), 3)
    modes = {
        mode: Deviations(float(mean), float(np.exp(scene)), float(np.exp(own)))
        for mode, (mean, scene, own) in zip(MODES, rest, strict=True)
    }
    pooled = Deviations(float(np.mean(rest[:, 0])), *(float(np.exp(rest[:, k].max())) for k in (1, 2)))
    return Prior({**modes, "": pooled}, float(common), float(small), quantiles)


def _standardise(prior: Prior, scene: Judged) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Errors over their deviation, and these."""
    posterior = Posterior(prior, scene.small, scene.predicted)
    found = [
        (posterior.condition(setting, scene.predicted[setting]), error) for setting, error in scene.measured.items()
    ]
    deviation = np.array([each.deviation for each, _ in found])
    apart = np.array([math.log(max(error, MINIMUM)) - each.mean for each, error in found])
    return apart / deviation, deviation


def fit(scenes: Sequence[Judged], start: NDArray[np.float64] | None = None, steps: int = 40) -> NDArray[np.float64]:
    """The numbers of the prior under which the measured errors are most likely, each given the small images."""
    begin = np.concatenate([np.log([0.1, 0.1]), np.tile([-0.1, math.log(0.3), math.log(0.2)], len(MODES))])

    def loss(values: NDArray[np.float64]) -> float:
        prior, total = _prior(values), 0.0
        for scene in scenes:
            apart, deviation = _standardise(prior, scene)
            each = 0.5 * (FREEDOM + 1.0) * np.log1p(apart**2 / FREEDOM) + np.log(deviation)
            total += float(each.mean())
        weak = (values - begin) / 1.5  # a mode of which few errors are known stays near where it began
        return total + 0.5 * float(weak @ weak)

    bounds = [(math.log(SMALLEST), math.log(2.0))] * 2 + [
        (-2.0, 2.0),
        *[(math.log(SMALLEST), math.log(2.0))] * 2,
    ] * len(MODES)
    found = minimize(
        loss, begin if start is None else start, method="L-BFGS-B", bounds=bounds, options={"maxiter": steps}
    )
    return np.asarray(found.x)


def hold_out(scenes: Sequence[Judged], values: NDArray[np.float64]) -> list[tuple[Prior, Judged, NDArray[np.float64]]]:
    """Each scene with a prior of four fifths of the others, and its errors over their deviation by that."""
    found = []
    for fold in range(FOLDS):
        prior = _prior(fit([each for number, each in enumerate(scenes) if number % FOLDS != fold], values, 8))
        found += [(prior, each, _standardise(prior, each)[0]) for each in scenes[fold::FOLDS]]
    return found


def quantiles_of(apart: Sequence[NDArray[np.float64]]) -> tuple[float, ...]:
    """Quantiles of errors over their deviation, each scene as much as any other; a little wider at the ends."""
    values = np.concatenate(apart)
    weight = np.concatenate([np.full(len(each), 1.0 / len(each)) for each in apart])
    order = np.argsort(values)
    level = (np.cumsum(weight[order]) - 0.5 * weight[order]) / weight.sum()
    found = np.interp(LEVELS, level, values[order])
    # as many scenes as there are tell levels only to their inverse: one more scene may be beyond all
    edge = 1.0 / (len(apart) + 1.0)
    found = np.interp(np.clip((LEVELS - 0.5) * (1.0 + edge) + 0.5, 0.0, 1.0), LEVELS, found)
    return tuple(float(value) for value in np.maximum.accumulate(found + 1e-6 * np.arange(len(found))))


def learn(folder: Path) -> None:
    """Fit the prior and write it."""
    scenes = read_scenes(folder)
    values = fit(scenes)
    apart = [each for _, _, each in hold_out(scenes, values)]
    write_json(SHIPPED, _prior(values, quantiles_of(apart)).as_record())


def judge(scenes: Sequence[Judged], prior: Prior, budgets: Sequence[float] = BUDGETS) -> dict[str, float]:
    """Judge intervals and probabilities of scenes that the prior has not seen, and the intervals of before."""
    inside, width, before, wide, sure, kept = [], [], [], [], [], []
    for scene in scenes:
        posterior = Posterior(prior, scene.small, scene.predicted)
        for setting, error in scene.measured.items():
            if setting.mode == "reference":
                continue
            found = posterior.condition(setting, scene.predicted[setting])
            low, high = found.interval
            inside.append(low <= max(error, MINIMUM) <= high or (high < MINIMUM and error <= MINIMUM))
            width.append(high / low)
            low, high = scene.intervals[setting]
            before.append(low <= error <= high)
            wide.append(high / max(low, MINIMUM))
            for budget in budgets:
                if found.probability_below(budget) >= SURE:
                    sure.append(1.0)
                    kept.append(error <= budget)
    return {
        "settings": len(inside),
        "coverage": float(np.mean(inside)),
        "width": float(np.median(width)),
        "coverage before": float(np.mean(before)),
        "width before": float(np.median(wide)),
        "satisfied": len(sure),
        "satisfied and true": float(np.mean(kept)) if kept else 1.0,
    }


#: How much dearer a choice may be than the best of the measured settings.
DEARER = 1.2


def judge_choices(scenes: Sequence[Judged], prior: Prior, budgets: Sequence[float] = BUDGETS) -> dict[str, float]:
    """Judge what is chosen of the measured settings of each scene, for each budget.

    At equal error, the best is the cheapest of the settings that are not further off than the chosen one. Beside it
    stand the stated intervals of the choices; the shares of choices within the budget, where a setting is, and near
    the cheapest setting within it; and that of choices near the best where a setting beyond the budget counts as its
    price times the square of its overrun.
    """
    model = drain(quick_profile())
    equal, counted, within, cheap, width, inside = [], [], [], [], [], []
    for scene in scenes:
        posterior = Posterior(prior, scene.small, scene.predicted)
        errors = {setting: error for setting, error in scene.measured.items() if setting.mode != "reference"}
        prices = {each: _price(model.predict(each, scene.vertices, PIXELS)) for each in errors}
        ranked = sorted(errors, key=lambda each: prices[each])
        for budget in budgets:
            chosen, known = _choose(posterior, prices, scene, budget), posterior
            asked = select_doubtful(chosen, scene.small)
            finer = {each: scene.finer[each] for each in asked if each in scene.finer}
            if finer:
                known = Posterior(prior, {**scene.small, **finer}, scene.predicted)
                chosen = _choose(known, prices, scene, budget)
            low, high = known.condition(chosen, scene.predicted[chosen]).interval
            width.append(high / low)
            inside.append(low <= max(errors[chosen], MINIMUM) <= high)
            equal.append(prices[chosen] / min(prices[each] for each in ranked if errors[each] <= errors[chosen]))
            counts = {each: prices[each] * max(1.0, errors[each] / budget) ** 2 for each in ranked}
            counted.append(counts[chosen] / min(counts.values()))
            meeting = [each for each in ranked if errors[each] <= budget]
            if meeting:
                within.append(errors[chosen] <= budget)
                cheap.append(within[-1] and prices[chosen] <= DEARER * prices[meeting[0]])
    return {
        "choices": len(equal),
        "width of the choice": float(np.median(width)),
        "coverage of the choice": float(np.mean(inside)),
        "within 1.2 of the best at equal error": float(np.mean(np.array(equal) <= DEARER)),
        "within the budget where a setting is": float(np.mean(within)),
        "within 1.2 of the cheapest within the budget": float(np.mean(cheap)),
        "within 1.2 of the best by overrun": float(np.mean(np.array(counted) <= DEARER)),
    }


def _choose(posterior: Posterior, prices: dict[Setting, float], scene: Judged, budget: float) -> Setting:
    """The cheapest setting that almost surely meets a budget, or the least price times mean overrun."""
    predicted = {each: posterior.condition(each, scene.predicted[each]) for each in prices}
    ranked = sorted(prices, key=lambda each: prices[each])
    sure = [each for each in ranked if predicted[each].probability_below(budget) >= SURE]
    return sure[0] if sure else min(ranked, key=lambda each: prices[each] * _overrun(predicted[each], budget))


def _overrun(error: Distribution, budget: float) -> float:
    """Mean of the square of an error over the budget, which counts as 1 below it."""
    return float(np.mean([max(1.0, error.quantile(level) / budget) ** 2 for level in MIDDLES]))


def _price(cost: Cost) -> float:
    return cost.frame_s + cost.relight_s / LIGHTS + cost.bake_s / FRAMES + BYTE_S * cost.memory_bytes


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("verb", choices=("collect", "small", "fit", "judge"))
    parser.add_argument("folder", type=Path)
    parser.add_argument("--scenes", type=int, default=50)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    if arguments.verb == "small":
        for path in sorted(arguments.folder.glob("*.json")):
            collect_small(path)
        return
    if arguments.verb == "fit":
        learn(arguments.folder)
        return
    if arguments.verb == "judge":
        scenes, prior = read_scenes(arguments.folder), read_prior()
        print(json.dumps({**judge(scenes, prior), **judge_choices(scenes, prior)}, indent=2))
        return
    for seed in range(arguments.seed, arguments.seed + arguments.scenes):
        path = arguments.folder / f"{seed:05d}.json"
        if not path.exists() and len(generate_varied(seed)[1].mesh.positions) <= MAX_VERTICES:
            write_json(path, collect(arguments.folder, seed))
            print(path, json.loads(path.read_text())["seconds"], flush=True)


if __name__ == "__main__":
    main()

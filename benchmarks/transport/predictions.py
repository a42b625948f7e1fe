"""Predicted errors of generated scenes against those of images, one setting of each mode a scene.

What a plan would predict of a setting is compared with the relative RMSE of a small image of it, by the camera that
frames the model, against a path-traced reference of direct light. Pixels of silhouettes do not count.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.measure import Accuracy
from benchmarks.transport.generated_scenes import generate
from engine.accuracy.compare import ErrorEstimate
from engine.core.errors import InputError, UsageError
from engine.core.figure_text import number, percent
from engine.core.steps import Step, Steps, drain
from engine.planning.bake_group import bake_alone, bake_group, groups, relight_transport
from engine.planning.choices import probe
from engine.planning.costs.setting import Setting, parameters_of
from engine.planning.effects.estimates import Estimate, estimates, scenery
from engine.planning.effects.mode_error import factors_by_terms, mode_errors
from engine.planning.effects.sample import COMPARED
from engine.planning.predicted_error import PredictedErrors
from engine.render.reference import reference
from engine.scene.scene import Scene
from engine.tradeoff.draw import SAMPLES, Drawer, Image, drawing, find_shown_vertices
from engine.tradeoff.sweep import COVERED, FEW_PASSES, OTHER_SEED, Refining, scene_of
from engine.transport import method as transport

#: Noise of an image's reference, relative to the image.
NOISE = 0.01

#: An error below which an image shows nothing.
MINIMUM = 1e-3

#: Seconds after which a reference is taken as it is; the errors then say how uncertain they are.
MAX_S = 45.0

#: The mode that bakes most takes as long as all else together: it is measured in one scene of so many.
EVERY = 6

#: Modes that draw an environment without a bake, and steps of each sweep from which settings are drawn, from below.
AT_ONCE, STEPS = ("reference", "direct"), 3

#: The effect that images of direct light do not have.
LEFT_OUT = "interreflection"

#: Scenes where nobody says how many, and the share of errors that may be outside their intervals.
SCENES, OUTSIDE = 10, 0.05


@dataclass(frozen=True)
class Compared:
    """A setting of a scene: its error as predicted, as measured, and how uncertain the measured one is.

    `interval` is what the plan tells beside the predicted error: the least and the most of 95 of 100 scenes. `between`
    is the part of it that light between the vertices may add.
    """

    seed: int
    scene: str
    setting: Setting
    predicted: float
    interval: tuple[float, float]
    measured: float
    uncertainty: float
    between: float = 0.0

    @property
    def own(self) -> float:
        """The ratio without what may come from between the vertices."""
        least = max(self.measured - self.uncertainty, 0.0)
        apart = math.sqrt(max(least**2 - self.between**2, 0.0))
        return max(apart, MINIMUM) / max(self.predicted, MINIMUM)

    @property
    def ratio(self) -> float:
        """The measured error over the predicted one, as near to 1 as the uncertainty of the measured one allows.

        Errors below `LEAST` count as that.
        """
        nearest = min(max(self.predicted, self.measured - self.uncertainty), self.measured + self.uncertainty)
        return max(nearest, MINIMUM) / max(self.predicted, MINIMUM)

    @property
    def factor(self) -> float:
        """The larger of both errors over the smaller."""
        return max(self.ratio, 1.0 / self.ratio)

    @property
    def covered(self) -> bool:
        """True if the measured error may lie within the interval; what is below `LEAST` is 0 there."""
        low, high = self.interval
        below = low > MINIMUM and self.measured + self.uncertainty < low
        return not below and self.measured - self.uncertainty <= max(high, MINIMUM)


def draw_settings(seed: int, modes: Sequence[str]) -> list[Setting]:
    """A setting of each of `modes` by seed."""
    settings = []
    for mode in modes:
        rng = np.random.default_rng((29, seed, *mode.encode()))
        sweeps = {name: parameter.sweep[:STEPS] for name, parameter in parameters_of(mode).items()}
        if LEFT_OUT in sweeps:
            sweeps[LEFT_OUT] = (0,)  # the reference has none either
        settings.append(Setting(mode, {name: steps[rng.integers(len(steps))] for name, steps in sweeps.items()}))
    return settings


def list_baked_modes(seed: int) -> tuple[str, ...]:
    """The modes that are baked of a scene: all in one of `EVERY`, else without the one that bakes most."""
    return transport.names()[:-1] if seed % EVERY else transport.names()


def predictions(
    _folder: Path,
    *,
    scenes: int = SCENES,
    seed: int = 0,
    data: Path | None = None,
    modes: Sequence[str] | None = None,
) -> Steps[list[Accuracy]]:
    """Errors of predictions of so many scenes, from `seed` on, against what is measured.

    Files of the folder `data` join the models and the BRDFs. With `modes`, these alone are drawn, in every scene that
    they can draw. UsageError for no scene and where none can be drawn, InputError for no folder.
    """
    check_campaign(scenes, data)
    found: list[Compared] = []
    with drawing((COMPARED, COMPARED)) as drawer:
        for number in range(scenes):
            yield Step(number / scenes, f"predicting and measuring scene {seed + number}")
            found += compare_with(seed + number, drawer, data, modes)
    if not found:
        raise UsageError(f"none of these {scenes} scenes can be drawn with {', '.join(modes or ())}: ask for more")
    return summary(found)


def check_campaign(scenes: int, data: Path | None) -> None:
    """UsageError for no scene, InputError for no folder."""
    if scenes < 1:
        raise UsageError(f"{scenes} scenes are too few: at least one is measured")
    if data is not None and not data.is_dir():
        raise InputError(data, "it is not a folder", "name one with models and measured BRDFs")


def summary(found: Sequence[Compared]) -> list[Accuracy]:
    """The figures of a campaign. A prediction of a few times too much is dear, one of too little is wrong."""
    worst = max(found, key=lambda each: each.factor)
    above = np.mean([each.measured > each.predicted for each in found])
    count = f"{len(found)} settings on {len({each.seed for each in found})} scenes"
    apart = [
        Accuracy(f"predictions-beyond-{times:g}", float(np.mean([each.factor > times for each in found])), what)
        for times in (1.5, 2.0)
        for what in [f"share of {count} where one error is more than {times:g} times the other"]
    ]
    farthest = (
        f"farthest factor between both: {worst.setting} of seed {worst.seed}, {percent(worst.measured)} where "
        f"{percent(worst.predicted)} was predicted ({worst.scene})"
    )
    widths = [each.interval[1] / max(each.interval[0], MINIMUM) for each in found if each.interval[1] > MINIMUM]
    wide = "median of the largest over the smallest error of an interval"
    return [
        Accuracy("predictions-above", float(above), f"share of {count} whose error is above the predicted one"),
        *apart,
        Accuracy("predictions-worst", worst.factor, farthest),
        Accuracy(
            "predictions-outside",
            float(np.mean([not each.covered for each in found])),
            f"share of {count} whose error is outside the interval that a plan tells",
            OUTSIDE,
        ),
        Accuracy("predictions-width", float(np.median(widths or [1.0])), wide),
        *(_spread(mode, [each for each in found if each.setting.mode == mode]) for mode in modes_of(found)),
    ]


def modes_of(found: Sequence[Compared]) -> list[str]:
    return list(dict.fromkeys(each.setting.mode for each in found))


def spread(found: Sequence[Compared]) -> tuple[float, float]:
    """The least and the most ratio of 95 of 100, also of one more that is drawn alike (split conformal prediction).

    The most is of errors without what light between the vertices may add.
    """
    cut = max(1, math.floor(0.5 * OUTSIDE * (len(found) + 1)))
    return sorted(each.ratio for each in found)[cut - 1], sorted(each.own for each in found)[-cut]


def _spread(mode: str, found: Sequence[Compared]) -> Accuracy:
    low, high = spread(found)
    outside = float(np.mean([not each.covered for each in found]))
    said = (
        f"95 of 100 errors of {len(found)} settings of {mode} are {number(low)} to {number(high)} times the predicted"
    )
    return Accuracy(f"predictions-spread-{mode}", high / low, f"{said}; {percent(outside)} outside their intervals")


def compare_with(
    seed: int, drawer: Drawer, data: Path | None = None, modes: Sequence[str] | None = None
) -> list[Compared]:
    """The scene of `seed`, predicted and measured: all of `modes` that can draw it, else what `baked_modes` names."""
    name, scene = generate(seed, data)
    errors = errors_of(scene)
    skipped = frozenset({LEFT_OUT})
    known = mode_errors(errors.scene)
    asked = (*AT_ONCE, *list_baked_modes(seed)) if modes is None else modes
    drawn = [mode for mode in asked if mode in AT_ONCE or known.knows(mode)]
    if not drawn:
        return []
    found = measure(scene, draw_settings(seed, drawn), drawer)
    return [
        Compared(
            *(seed, name, each),
            *(errors.of(each, skipped), errors.interval(each, skipped)),
            *(error.rmse_rel, error.uncertainty, errors.between(each)),
        )
        for each, error in found.items()
    ]


def errors_of(scene: Scene) -> PredictedErrors:
    """Predictions that a plan makes of the direct light of a scene."""
    assert scene.environment is not None
    brdf: Any = scene.brdf
    place = {"environment": scene.environment, "environment_rotation": scene.environment_rotation}
    looked = scenery(scene.mesh, brdf, scene.environment, rotation=scene.environment_rotation, camera=scene.camera)
    found = {**estimates(looked), LEFT_OUT: Estimate(LEFT_OUT, 0.0, "")}
    return PredictedErrors(looked, found, lambda depth: probe(scene.mesh, brdf, depth, **place))


def measure(
    scene: Scene, settings: Sequence[Setting], drawer: Drawer, seconds: float = MAX_S
) -> dict[Setting, ErrorEstimate]:
    """The error of an image of each setting, against a reference whose noise is low, or that took so many seconds."""
    size = drawer.size
    with closing(Refining(scene, size, 1, 0)) as refining:
        plain = drain(drawer.draw(dataclasses.replace(scene, directions=4)))
        refining.covered = plain.image[..., 3] >= COVERED
        exact = drain(refining.refine(seconds, NOISE, FEW_PASSES))
    return {setting: exact.error(image) for setting, image in _images(scene, settings, drawer)}


def _images(scene: Scene, settings: Sequence[Setting], drawer: Drawer) -> Iterator[tuple[Setting, Image]]:
    shown = find_shown_vertices(scene, drawer.size, SAMPLES)
    baked = [each for each in settings if each.mode in transport.names()]
    known: dict[Any, Any] = {}
    if any("terms" in each.parameters for each in baked):
        known |= factors_by_terms(scene.brdf)
    shared = groups(baked)
    alone = [each for each in baked if not any(each in group for group in shared)]
    jobs = [bake_group(scene, group, shown=shown, known=known) for group in shared]
    for job in (*jobs, *(bake_alone(scene, each, shown=shown) for each in alone)):
        for bake in drain(job)[0]:
            lit = dataclasses.replace(scene, relit=relight_transport(bake, scene))
            yield bake.setting, drain(drawer.draw(lit)).image
    for each in settings:
        if each.mode == "reference":
            found = drain(reference(scene, drawer.size, samples=each["samples"], max_depth=1, seed=OTHER_SEED))
            yield each, found.image
        elif each.mode == "direct":
            yield each, drain(drawer.draw(scene_of(each, scene))).image

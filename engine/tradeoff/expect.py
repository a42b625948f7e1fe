"""What a sweep expects of settings before it measures them, and what measuring one is worth.

Errors have the distribution that plans tell (`engine.planning.prior`), the settings that are measured already in place
of small images; costs are those of the machine profile. What a setting is worth is the expected fall of the logarithm
of the error below the best that is known at its price (expected improvement, Jones1998); a sweep buys what is worth
most for the seconds that it takes.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from scipy.special import ndtr

from engine.planning.choices import FRAMES
from engine.planning.costs.planned import planning_of
from engine.planning.costs.setting import Setting
from engine.planning.effects.estimates import Estimate, estimates, scenery
from engine.planning.predicted_error import BETWEEN_PARTS, PredictedErrors
from engine.planning.prior import MINIMUM, Distribution, Posterior, read_prior
from engine.planning.small_images import Measured
from engine.scene.mode import is_traced
from engine.scene.scene import Scene
from engine.tradeoff.point import Point
from engine.transport import method as transport

#: Deviation of the logarithm of an error that is measured, beside its uncertainty.
EXACT = 1e-3


@dataclass(frozen=True)
class Expected:
    """A setting that was not measured: its error, in 95 of 100 scenes within `interval`, and predicted costs."""

    setting: Setting
    error_rel: float
    interval: tuple[float, float]
    predicted: Mapping[str, float] = field(default_factory=dict, hash=False)

    def as_json(self) -> dict[str, Any]:
        figures = {f"predicted_{name}": value for name, value in self.predicted.items()}
        return {"error_rmse_rel": self.error_rel, "error_interval_rel": list(self.interval), **figures}


@dataclass(frozen=True, eq=False)
class Expectations:
    """Errors of the settings of a scene whose images have light that touches up to `max_depth` points.

    `small` are errors of small images of some settings.
    """

    scene: Scene
    max_depth: int
    small: dict[Setting, Measured] = field(default_factory=dict)

    @cached_property
    def _errors(self) -> PredictedErrors:
        scene = self.scene
        assert scene.environment is not None
        looked = scenery(
            scene.mesh,
            scene.brdf,
            scene.environment,
            rotation=scene.environment_rotation,
            ground=scene.ground,
            camera=scene.camera,
            material=scene.material,
        )
        found = dict(estimates(looked))
        if self.max_depth == 1:
            found[BETWEEN_PARTS] = Estimate(BETWEEN_PARTS, 0.0, "")
        return PredictedErrors(looked, found, None)

    def can_draw(self, mode: str) -> bool:
        """False where the BRDF has nothing that a mode is of, as Gaussians are of gloss."""
        return mode not in transport.names() or planning_of(mode).can_draw(self.scene)

    def expect(self, setting: Setting, points: Sequence[Point]) -> Distribution | None:
        """The error of `setting` beside measured `points`; None of the reference, and of what `can_draw` denies."""
        if is_traced(setting.mode) or not self.can_draw(setting.mode):
            return None
        measured = {**self.small, **{each.setting: _convert(each) for each in points if not is_traced(each.mode)}}
        prior = read_prior() if not points else replace(read_prior(), small=EXACT)
        predicted = {each: self._predict(each) for each in measured}
        return Posterior(prior, measured, predicted).condition(setting, self._predict(setting))

    def _predict(self, setting: Setting) -> float:
        return self._errors.predict(setting, frozenset())


def _convert(point: Point) -> Measured:
    error = max(point.error_rmse_rel, MINIMUM)
    return Measured(error, min(0.5 * point.error_uncertainty / error, 1.0))


def price(frame_s: float, bake_s: float) -> float:
    """Seconds of a frame with its share of a bake."""
    return frame_s + bake_s / FRAMES


def measure_worth(error: Distribution, at: float, points: Iterable[Point]) -> float:
    """Expected fall of log(error) below the best of `points` that cost at most `at`, or below all of them."""
    cheaper = [each.error_rmse_rel for each in points if price(each.frame_s, each.bake_s) <= at]
    best = min(cheaper, default=max((each.error_rmse_rel for each in points), default=1.0))
    apart = (math.log(max(best, MINIMUM)) - error.mean) / error.deviation
    density = math.exp(-0.5 * apart**2) / math.sqrt(2.0 * math.pi)
    return error.deviation * (apart * float(ndtr(apart)) + density)

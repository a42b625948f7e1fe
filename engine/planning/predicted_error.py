"""The error that a plan tells of a setting together with the effects that it leaves out.

It is at most the sum of the errors of what is left out (`estimates`) and of the method's own (`mode_error`), by the
triangle inequality. That of the reference is its noise.

Beside it stands the interval that holds the error of 95 of 100 generated scenes, and the probability that it is below
a budget. For the image of a camera both come from the distribution that `engine.planning.prior` tells of direct light,
after small images of some settings where there are any; light between the parts of the model that a setting lacks
comes on top. From all around the intervals are those of `benchmarks.transport.predictions`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from engine.core.cached import cached_property
from engine.planning.costs.planned import planning_of
from engine.planning.costs.setting import Setting, shows, shows_of_sharp
from engine.planning.effects.estimates import Estimate, Scenery, observe_as
from engine.planning.effects.mode_error import ModeErrors, mode_errors
from engine.planning.effects.simplified import lambertian
from engine.planning.prior import SURE, Distribution, Posterior, normal, read_prior
from engine.planning.small_images import Measured
from engine.scene.mode import MODES, REFERENCE, Spread, is_traced
from engine.transport import method as transport
from engine.transport.sh.transfer import is_diffuse

#: Ratios of measured to predicted errors: of effects that are left out, and of modes that nothing is predicted of.
#: Methods name their own (`Planning.SPREAD`), as modes do.
LEFT_OUT_SPREAD = Spread(by_camera=(0.2, 1.0 / 0.83), around=(0.05, 1.0 / 0.83))
_UNKNOWN = Spread(by_camera=(0.0, math.inf), around=(0.0, math.inf))

#: Error of light that is baked at vertices and interpolated between them, on a model of `FEW`: shadows and highlights
#: end somewhere on a face, and the share of the image that such faces have is as their side.
BETWEEN, FEW = 0.05, 2048

#: Error of texels in baked light (`engine.render.shadowed`), over what all shadows are worth: a light that is shadowed
#: is taken to meet them as the others do. 0.07 to 0.23 on a ball on a ground, of Lambertian and glossy texels.
IN_SHADOW = 0.15

#: Levels that stand for all of a distribution.
MIDDLES = np.arange(0.025, 1.0, 0.05)

#: The effect that small images do not have.
BETWEEN_PARTS = "interreflection"

#: Points of the surface that light touches where light between parts of the model counts.
REFERENCE_DEPTH = 4


@dataclass(frozen=True, eq=False)
class PredictedErrors:
    """Errors of a scene that has been looked at, without a bake.

    Attributes
    ----------
    found : the estimate of each effect. noise : that of a reference of one sample, by the points of the surface that
        light may touch; None where no reference is asked about.
    small : errors of small images of settings with nothing left out but light between the parts of the model.
    """

    scene: Scenery
    found: Mapping[str, Estimate]
    noise: Callable[[int], float] | None
    small: Mapping[Setting, Measured] = field(default_factory=dict)

    def of(self, setting: Setting, skipped: frozenset[str]) -> float:
        """The error that is predicted; by a camera half of all scenes are below it."""
        if not self.has_camera:
            return self.predict(setting, skipped)
        return self._direct(setting, skipped).median + self._between_parts(setting, skipped)

    def predict(self, setting: Setting, skipped: frozenset[str]) -> float:
        """The same before the prior corrects it."""
        return self._own(setting, skipped) + self.left_out(setting, skipped)

    def probability(self, setting: Setting, skipped: frozenset[str], error: float) -> float:
        """The probability that the error is at most `error`."""
        if self.has_camera:
            most = LEFT_OUT_SPREAD.by_camera[1] * self._between_parts(setting, skipped)
            return self._direct(setting, skipped).probability_below(error - most)
        return normal(*self.interval(setting, skipped)).probability_below(error)

    @property
    def sure_noise(self) -> float:
        """Noise of a reference that is almost never exceeded, over the predicted one."""
        return self._posterior.condition(Setting(REFERENCE.name), 1.0).quantile(SURE) if self.has_camera else 1.0

    def overrun(self, setting: Setting, skipped: frozenset[str], budget: float) -> float:
        """The mean of the square of the error over `budget`, which counts as 1 below it.

        Half an error is worth four times the price, as it is of the reference.
        """
        if not self.has_camera:
            return max(1.0, self.predict(setting, skipped) / budget) ** 2
        missing, direct = self._between_parts(setting, skipped), self._direct(setting, skipped)
        errors = np.array([direct.quantile(level) + missing for level in MIDDLES])
        return float(np.mean(np.maximum(1.0, errors / budget) ** 2))

    def interval(self, setting: Setting, skipped: frozenset[str]) -> tuple[float, float]:
        """The least and the most that the error of 95 of 100 scenes is where `of` is predicted."""
        if self.has_camera:
            missing = self._between_parts(setting, skipped)
            low, high = self._direct(setting, skipped).interval
            least, most = LEFT_OUT_SPREAD.by_camera
            return max(low, least * missing), high + most * missing
        own, missing = self._own(setting, skipped), self.left_out(setting, skipped)
        least, most = spread(setting.mode).of(self.has_camera)
        left_out = LEFT_OUT_SPREAD.of(self.has_camera)
        largest = math.hypot(most * own, self.between(setting))
        return max(least * own, left_out[0] * missing), largest + left_out[1] * missing

    @cached_property
    def _posterior(self) -> Posterior:
        asked = frozenset({BETWEEN_PARTS})
        predicted = {
            setting: self.predict(setting, asked) - self._between_parts(setting, asked) for setting in self.small
        }
        return Posterior(read_prior(), self.small, predicted)

    def _direct(self, setting: Setting, skipped: frozenset[str]) -> Distribution:
        """The error of direct light."""
        return self._posterior.condition(
            setting, self.predict(setting, skipped) - self._between_parts(setting, skipped)
        )

    def _between_parts(self, setting: Setting, skipped: frozenset[str]) -> float:
        """The error of light between the parts of the model, where a setting does not show it."""
        return 0.0 if shows_bounces(setting, skipped) else self.found[BETWEEN_PARTS].error_rel

    @property
    def has_camera(self) -> bool:
        """True if errors are those of the image of one camera."""
        return self.scene.between is not None

    def between(self, setting: Setting) -> float:
        """Error that an image may add between the vertices, where alone a prediction from all around looks.

        0 of what is not baked, and for a camera, whose errors contain it.
        """
        if setting.mode not in transport.names() or self.has_camera:
            return 0.0
        return BETWEEN * (FEW / self.scene.sample.model_vertices) ** 0.25

    def _own(self, setting: Setting, skipped: frozenset[str]) -> float:
        """Error of the method itself; of the reference, noise."""
        if is_traced(setting.mode) and self.noise is not None:
            return self.noise(depth_of(skipped)) / math.sqrt(setting["samples"])
        if self.casts(setting, skipped):
            return self._select_modes(skipped).with_shadows(setting)
        own = self._select_modes(skipped).of(setting)
        if setting.mode not in transport.names() or "mesostructure" in skipped:
            return own
        has_texels = self.found["mesostructure"].error_rel > 0.0
        return math.hypot(own, IN_SHADOW * self.found["self-shadowing"].error_rel) if has_texels else own

    def left_out(self, setting: Setting, skipped: frozenset[str]) -> float:
        """Error of the effects that the setting does not show."""
        missing = {name: self.found[name].error_rel for name in skipped if name != "all-frequency-light"}
        if not shows_bounces(setting, skipped):
            missing["interreflection"] = self.found["interreflection"].error_rel
        for name in ("self-shadowing", "glossy", "mesostructure"):
            if not shows(setting.mode, name):
                missing[name] = self.found[name].error_rel
        if self.casts(setting, skipped):  # what the shadows of other lights are worth is part of its own error
            missing.pop("self-shadowing", None)
        if not shows(setting.mode, "sun-split"):
            missing.pop("sun-split", None)
        return sum(missing.values())

    def casts(self, setting: Setting, skipped: frozenset[str]) -> bool:
        """True if sharp lights cast shadows in a sum over lights, and there are such."""
        asked = "self-shadowing" not in skipped and not shows(setting.mode, "self-shadowing")
        has_lamps = len(self.scene.sample.lamp_direction) > 0
        return asked and has_lamps and shows_of_sharp(setting.mode, "self-shadowing")

    def shows_shadows(self, setting: Setting, skipped: frozenset[str]) -> bool:
        """True if images have the shadows of all lights that count."""
        if shows(setting.mode, "self-shadowing"):
            return "self-shadowing" not in skipped
        return self.casts(setting, skipped) and self.scene.sample.light.is_sharp

    def _select_modes(self, skipped: frozenset[str]) -> ModeErrors:
        """Of the scene, or of the diffuse one that is left without gloss."""
        flat = "glossy" in skipped and not is_diffuse(self.scene.brdf)
        even = self.scene.varied is not None and "spatially-varying-gloss" in skipped
        if flat:
            return mode_errors(scenery_without_gloss(self.scene))
        return mode_errors(scenery_of_the_mean(self.scene) if even else self.scene)


def spread(mode: str) -> Spread:
    """Ratios of measured errors of a mode to the predicted ones."""
    return planning_of(mode).SPREAD if mode in transport.names() else MODES[mode].spread or _UNKNOWN


def shows_bounces(setting: Setting, skipped: frozenset[str]) -> bool:
    """True if images show interreflection."""
    if is_traced(setting.mode):
        return "interreflection" not in skipped
    return bool(setting.parameters.get("interreflection"))


def depth_of(skipped: frozenset[str]) -> int:
    """Points of the surface that light of the reference may touch."""
    return 1 if "interreflection" in skipped else REFERENCE_DEPTH


@lru_cache(maxsize=8)
def scenery_without_gloss(scene: Scenery) -> Scenery:
    """The same with the diffuse reflectance of equal albedo."""
    return observe_as(
        lambertian(scene.brdf), scene.sample, scene.fine, scene.bounced, scene.material, None, scene.between
    )


@lru_cache(maxsize=8)
def scenery_of_the_mean(scene: Scenery) -> Scenery:
    """The same with one BRDF for the whole surface."""
    return observe_as(scene.brdf, scene.sample, scene.fine, scene.bounced, scene.material, None, scene.between)

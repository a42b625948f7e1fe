"""The error of a setting as a distribution: what is predicted, corrected by what small images measured.

Let p be the predicted error of a setting and e its error in an image. On generated scenes log(e/p) is close to normal,
with a mean of its mode and with parts that are common to all settings of a scene, to all of a mode, and of a setting
alone; a small image measures log e with a deviation of its own and the one that is known (`small_images`). Given the
small images the error of each setting is then again normal in its logarithm, by conditioning (Rasmussen2006, eq. 2.19).

The deviations are fitted to scenes that `benchmarks.transport.prior` generates, and so are the quantiles of errors over
their deviation, each scene by what the others say (conformal prediction, Vovk2005): they take the place of those of the
normal distribution in intervals and probabilities.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from engine.core.cached import cached_property
from engine.planning.costs.setting import Setting
from engine.planning.small_images import Measured
from engine.scene.mode import is_traced

#: The prior that the program ships: `python -m benchmarks.transport.prior fit` writes it.
SHIPPED = Path(__file__).resolve().parents[2] / "resources" / "rates" / "errors.json"

#: Errors below this show nothing, and none is told apart from another.
MINIMUM = 1e-3

#: Probability from which a budget counts as met.
SURE = 0.95

#: Levels of the quantiles that are kept.
LEVELS = np.linspace(0.0, 1.0, 41)


@dataclass(frozen=True)
class Deviations:
    """Mean of log(measured / predicted) of the settings of a mode, and deviations of its scenes and settings."""

    mean: float
    scene: float
    own: float


@dataclass(frozen=True)
class Prior:
    """Knowledge of predicted errors before a scene is seen.

    Attributes
    ----------
    modes : by mode, and by "" of modes that were not measured. common : deviation that all settings of a scene share.
    small : deviation of small images, beside the known one.
    quantiles : of errors over their deviation at `LEVELS`, rising.
    """

    modes: Mapping[str, Deviations]
    common: float
    small: float
    quantiles: tuple[float, ...]

    def select(self, mode: str) -> Deviations:
        return self.modes.get(mode, self.modes[""])

    def as_record(self) -> dict[str, Any]:
        modes = {name: [each.mean, each.scene, each.own] for name, each in self.modes.items()}
        return {"modes": modes, "common": self.common, "small": self.small, "quantiles": list(self.quantiles)}


def prior_of(record: Mapping[str, Any]) -> Prior:
    """The prior that `as_record` wrote."""
    modes = {name: Deviations(*values) for name, values in record["modes"].items()}
    return Prior(modes, record["common"], record["small"], tuple(record["quantiles"]))


@cache
def read_prior() -> Prior:
    """The prior that the program ships."""
    return prior_of(json.loads(SHIPPED.read_text("utf-8")))


@dataclass(frozen=True)
class Distribution:
    """An error whose logarithm has a `mean` and a `deviation`, and whose quantiles are those of `prior`."""

    mean: float
    deviation: float
    quantiles: tuple[float, ...] = field(repr=False)

    @property
    def median(self) -> float:
        return self.quantile(0.5)

    def quantile(self, level: float) -> float:
        """The error that a share `level` of such scenes is below."""
        return math.exp(self.mean + self.deviation * float(np.interp(level, LEVELS, self.quantiles)))

    @property
    def interval(self) -> tuple[float, float]:
        """The least and the most of 95 of 100 scenes."""
        return self.quantile(0.025), self.quantile(0.975)

    def probability_below(self, error: float) -> float:
        """The share of such scenes whose error is at most `error`."""
        if error <= 0.0:
            return 0.0
        at = (math.log(max(error, MINIMUM)) - self.mean) / max(self.deviation, 1e-9)
        return float(np.interp(at, self.quantiles, LEVELS))


def direct_light(setting: Setting) -> Setting:
    """The setting without light from the model itself: small images are of direct light."""
    return setting.replace(interreflection=0) if setting.parameters.get("interreflection") else setting


def normal(low: float, high: float) -> Distribution:
    """The log-normal distribution of which 95 of 100 are between `low` and `high`."""
    low, high = max(low, 1e-2 * MINIMUM), max(high, 1e-2 * MINIMUM)
    deviation = math.log(max(high / low, 1.0)) / (2.0 * float(ndtri(0.975)))
    return Distribution(0.5 * math.log(low * high), deviation, _NORMAL)


_NORMAL = tuple(float(value) for value in ndtri(np.clip(LEVELS, 1e-3, 1.0 - 1e-3)))


@dataclass(frozen=True, eq=False)
class Posterior:
    """The errors of the settings of a scene after small images of some.

    Attributes
    ----------
    predicted : predicted errors of those that were measured.
    """

    prior: Prior
    measured: Mapping[Setting, Measured]
    predicted: Mapping[Setting, float]

    def condition(self, setting: Setting, predicted: float) -> Distribution:
        """The error of `setting`, of which `predicted` is predicted."""
        own = self.prior.select(setting.mode)
        mean, variance = math.log(max(predicted, MINIMUM)) + own.mean, self._common(setting, setting)
        if self.measured:
            alike = np.array([self._common(setting, each) for each in self.measured])
            inverse, surprise = self._known
            mean, variance = mean + float(alike @ inverse @ surprise), variance - float(alike @ inverse @ alike)
        return Distribution(mean, math.sqrt(max(variance, 1e-6)), self.prior.quantiles)

    def _common(self, one: Setting, other: Setting) -> float:
        """Covariance of the logarithms of two errors over the predicted ones; noise has nothing to do with others."""
        found = 0.0 if is_traced(one.mode) or is_traced(other.mode) else self.prior.common**2
        if one.mode == other.mode:
            own = self.prior.select(one.mode)
            found += own.scene**2 + (own.own**2 if direct_light(one) == direct_light(other) else 0.0)
        return found

    @cached_property
    def _known(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The inverse covariance of what was measured, and by how much its logarithms are beyond what was expected."""
        shared = np.array([[self._common(one, other) for other in self.measured] for one in self.measured])
        noise = np.array([self.prior.small**2 + each.deviation**2 for each in self.measured.values()])
        surprise = [
            math.log(max(each.error_rel, MINIMUM) / max(self.predicted[setting], MINIMUM))
            - self.prior.select(setting.mode).mean
            for setting, each in self.measured.items()
        ]
        return np.linalg.inv(shared + np.diag(noise)), np.array(surprise)

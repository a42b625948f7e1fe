"""Fits of one or all models to the same data in two norms, which need not agree.

A fit makes one norm small: of logarithms, where dim values count as much as a highlight, or of f cos(theta_i) itself,
which the highlight outweighs. The other norm may grow meanwhile, and an image with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from engine.brdf.fit import Fit, FitData, Weighting, fit, fit_error
from engine.core.figure_text import number, percent
from engine.core.steps import Steps, part

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf

Norm = Literal["linear", "log"]
NORMS: tuple[Norm, ...] = ("linear", "log")

#: The other weighting, which makes the other norm small.
OTHER: dict[Weighting, Weighting] = {"joint": "cosine", "log": "cosine", "cosine": "log"}

#: Share by which a norm may grow unsaid: a fit has converged to about that.
SLACK = 1e-3

#: A linear error from which a fit misses the highlights: black has 1.
MISSED = 0.5


@dataclass(frozen=True, eq=False)
class Offer:
    """A model with parameters, and its error against data in both norms.

    Attributes
    ----------
    linear : RMS of the difference in f cos(theta_i), relative to the RMS of the data.
    log : RMS of the difference in log(1 + f cos(theta_i) / m), as `engine.brdf.fit` has it.
    """

    brdf: Brdf
    linear: float
    log: float

    def error(self, norm: Norm) -> float:
        return self.linear if norm == "linear" else self.log


def offer(brdf: Brdf, data: FitData) -> Offer:
    """`brdf` with its errors against `data`."""
    error = fit_error(brdf, data, "log")
    return Offer(brdf, error.rmse_rel, error.objective)


def warning(before: Offer, after: Offer) -> str:
    """A sentence where one norm falls while the other grows, else ""."""
    falls = {norm: after.error(norm) < before.error(norm) for norm in NORMS}
    grows = {norm: after.error(norm) > before.error(norm) * (1.0 + SLACK) for norm in NORMS}
    if grows["linear"] and falls["log"]:
        grown = f"the linear error grows from {percent(before.linear, 3)} to {percent(after.linear, 3)}"
        return f"{grown} while the logarithmic one falls: highlights are worse than before"
    if grows["log"] and falls["linear"]:
        grown = f"the logarithmic error grows from {number(before.log, 3)} to {number(after.log, 3)}"
        return f"{grown} while the linear one falls: dim values are worse than before"
    return ""


def miss(nearest: Offer) -> str:
    """A sentence where even the fit that is nearest in the linear norm misses the highlights, else ""."""
    if nearest.linear < MISSED:
        return ""
    return f"the fit misses the values by {percent(nearest.linear, 3)} (RMS): its highlights are not those of the data"


def best(offers: Sequence[Offer]) -> dict[Norm, Offer]:
    """The offer with the least error in each norm."""
    return {norm: min(offers, key=lambda each, norm=norm: each.error(norm)) for norm in NORMS}  # type: ignore[misc]


def fit_both(
    data: FitData, start: Brdf, found: Fit, *, weighting: Weighting, fixed: tuple[str, ...] = (), seed: int = 0
) -> Steps[dict[Norm, Offer]]:
    """The best in each norm of `start`, of `found`, which was fitted by `weighting`, and of a fit by the other one."""
    other = yield from fit(data, start, weighting=OTHER[weighting], fixed=fixed, seed=seed)
    return best([offer(each, data) for each in (start, found.brdf, other.brdf)])


def rank(data: FitData, models: Sequence[Any], *, weighting: Weighting = "joint", seed: int = 0) -> Steps[list[Offer]]:
    """Each of `models` fitted by `weighting`, from the least error in its norm up."""
    offers = []
    for index, start in enumerate(models):
        steps = fit(data, start, weighting=weighting, seed=seed)
        found = yield from part(steps, index / len(models), (index + 1) / len(models))
        offers.append((found.after.objective, offer(found.brdf, data)))
    return [each for _, each in sorted(offers, key=lambda one: one[0])]

"""Fits any analytic model to any BRDF or list of measured samples, by least squares within the parameters' ranges.

The residual of a sample and channel is the difference of g(f cos(theta_i)) between model and data, where g is

    log      log(1 + f cos(theta_i) / m), m the median of the data's luminance f cos(theta_i): every part counts,
             the dim ones as much as the highlight (after Low2012)
    cosine   f cos(theta_i) / RMS of the data: what light carries; a highlight outweighs all else

The shape of such a sum of squares has several valleys. So a Sobol set of starts over the declared ranges (parameters
declared `log` by their logarithm) is evaluated on a part of the data, the best few are refined there with
`scipy.optimize.least_squares` (trust region reflective, Branch1999), and the best of these on all data. What a
user starts from is among the starts, so that a fit never ends worse than it began.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Generic, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import Brdf
from engine.brdf.half_difference import directions, half_difference
from engine.brdf.table import DirectionTable
from engine.core.colour import luminance
from engine.core.directions import Vectors, normalize, surface_direction
from engine.core.errors import UsageError
from engine.core.params import Parameter, parameters
from engine.core.steps import Step, Steps, part
from engine.core.summary import Summary

Floats = NDArray[np.float64]
Weighting = Literal["log", "cosine"]

#: The model that is fitted.
Fitted = TypeVar("Fitted", bound=Brdf)
WEIGHTINGS: tuple[Weighting, ...] = ("log", "cosine")

STARTS = 64
REFINED = 4
#: Samples on which starts are compared, and most samples of a fit.
FEW, MANY = 600, 8000
#: Directions with a smaller cosine, within 3° of the horizon, are not compared.
_GRAZING = float(np.sin(np.radians(3.0)))
#: Evaluations of the residual between two steps of the generator.
EVALUATIONS = 8


@dataclass(frozen=True, eq=False)
class FitData:
    """Data of a fit: unit directions `wi`, `wo` (N, 3) above the horizon and values (N, 3) in 1/sr."""

    wi: Vectors
    wo: Vectors
    value: Vectors

    def __post_init__(self) -> None:
        if not (self.wi.shape == self.wo.shape == self.value.shape and self.wi.ndim == 2 and len(self.wi)):
            raise ValueError("fit data needs equal shapes (N, 3) with N > 0")
        if not np.isfinite(self.value).all():
            raise ValueError("fit data must be finite")

    def first(self, count: int) -> FitData:
        return FitData(self.wi[:count], self.wo[:count], self.value[:count])


@dataclass(frozen=True)
class FitError:
    """Error of a model against data: RMS of g's difference (minimised), and RMS of f cos relative to data's."""

    objective: float
    rmse_rel: float


@dataclass(frozen=True, eq=False)
class Residual:
    """RMS of f cos(theta_i)'s error relative to the data's RMS, by bands of an angle; `edges` in radians.

    `rms` (bands,) is 0 where `count` (bands,) is.
    """

    edges: Floats
    rms: Floats
    count: NDArray[np.int64]


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Summary, Generic[Fitted]):
    """The fitted model, its errors before and after, and what remains by theta_h, theta_d and theta_i."""

    brdf: Fitted
    before: FitError
    after: FitError
    by_angle: dict[str, Residual]
    evaluations: int

    def summary(self) -> dict[str, Any]:
        """Return what `repr` says."""
        before, after = self.before.rmse_rel, self.after.rmse_rel
        return {"brdf": self.brdf, "rmse_rel": f"{after:.4g} (before {before:.4g})", "evaluations": self.evaluations}


def fit_data(brdf: Brdf, *, count: int = MANY, seed: int = 0) -> FitData:
    """Samples to fit: those that were measured, of a list or a table of directions, else values at stratified pairs.

    Between the entries of a table of directions, 15° apart, nothing was measured, and highlights are narrower. The
    pairs are uniform in √theta_h, theta_d, phi_d (and phi_h where the BRDF is brushed), as tables are, so that narrow
    highlights are seen; those with a direction within 3° of the horizon are left out, and the order is random.
    """
    measured = getattr(brdf, "measured", None)
    rng = np.random.default_rng(seed)
    if measured is not None:
        usable = np.minimum(measured.wi[:, 2], measured.wo[:, 2]) > 0.0
        chosen = rng.permutation(np.flatnonzero(usable))[:count]
        return FitData(measured.wi[chosen], measured.wo[chosen], measured.value[chosen])
    if isinstance(brdf, DirectionTable) and len(entries := _find_measured_entries(brdf)):
        at = np.unravel_index(rng.permutation(entries)[:count], brdf.missing.shape)
        wi = surface_direction(brdf.theta_i[at[0]], brdf.phi_i[at[1]])
        wo = surface_direction(brdf.theta_o[at[2]], brdf.phi_o[at[3]])
        return FitData(wi, wo, brdf.values[at].astype(np.float64))
    from scipy.stats import qmc  # slow to load, and the window must open at once

    points = qmc.Sobol(4, seed=rng).random_base2(int(np.ceil(np.log2(4 * count))))
    theta_h, theta_d = 0.5 * np.pi * points[:, 0] ** 2, 0.5 * np.pi * points[:, 1]
    phi_h = 2.0 * np.pi * points[:, 3] * (not brdf.isotropic)
    wi, wo = directions(theta_h, phi_h, theta_d, 2.0 * np.pi * points[:, 2])
    high = np.minimum(wi[:, 2], wo[:, 2]) > _GRAZING
    wi, wo = normalize(wi[high][:count]), normalize(wo[high][:count])
    return FitData(wi, wo, brdf.f(wi, wo))


def _find_measured_entries(table: DirectionTable) -> NDArray[np.intp]:
    """Places of the entries that were measured more than 3° above the horizon, at the pole one of all azimuths."""
    measured = ~table.missing
    for theta, phi, shape in (
        (table.theta_i, table.phi_i, (..., None, None)),
        (table.theta_o, table.phi_o, (...,)),
    ):
        once = (theta[:, None] > 0.0) | (np.arange(len(phi)) == 0)
        measured &= (once & (np.cos(theta)[:, None] > _GRAZING))[shape]
    return np.flatnonzero(measured)


def fit_error(brdf: Brdf, data: FitData, weighting: Weighting = "log") -> FitError:
    """The errors of `brdf` against `data`."""
    g = _Objective(data, weighting)
    cosine = data.wi[:, 2:]
    difference = (brdf.f(data.wi, data.wo) - data.value) * cosine
    size = float(np.sqrt(np.mean((data.value * cosine) ** 2)))
    return FitError(
        objective=float(np.sqrt(np.mean(g(brdf) ** 2))),
        rmse_rel=float(np.sqrt(np.mean(difference**2))) / size if size > 0.0 else 0.0,
    )


class _Objective:
    """Residuals (3 N,) of a BRDF against data."""

    def __init__(self, data: FitData, weighting: Weighting) -> None:
        if weighting not in WEIGHTINGS:
            raise ValueError(f"unknown weighting {weighting!r}; choose from {', '.join(WEIGHTINGS)}")
        self.data = data
        seen = np.maximum(data.value, 0.0) * data.wi[:, 2:]
        brightness = luminance(seen)
        lit = brightness[brightness > 0.0]
        if weighting == "log":
            middle = float(np.median(lit)) if len(lit) else 1.0
            self.g = lambda seen: np.log1p(seen / middle)
        else:
            size = float(np.sqrt(np.mean(seen**2))) or 1.0
            self.g = lambda seen: seen / size
        self.target = self.g(seen)

    def __call__(self, brdf: Brdf) -> Floats:
        seen = brdf.f(self.data.wi, self.data.wo) * self.data.wi[:, 2:]
        return np.asarray((self.g(seen) - self.target).ravel())


@dataclass(frozen=True)
class _Space(Generic[Fitted]):
    """The parameters of a model as a vector in which ranges are boxes: colours by channel, `log` ones by logarithm."""

    model: type[Fitted]
    declared: tuple[Parameter, ...]
    fixed: dict[str, Any]

    def _columns(self) -> list[Parameter]:
        return [parameter for parameter in self.declared for _ in range(3 if parameter.is_colour else 1)]

    def bounds(self) -> tuple[Floats, Floats]:
        columns = self._columns()
        return (
            np.array([self._forward(p, _lowest(p)) for p in columns]),
            np.array([self._forward(p, p.high) for p in columns]),
        )

    def usual(self) -> tuple[Floats, Floats]:
        """The narrower ranges of the sliders, from which starts are drawn."""
        columns = self._columns()
        low, high = self.bounds()
        return (
            np.maximum(low, [self._forward(p, max(p.slider[0], _lowest(p))) for p in columns]),
            np.minimum(high, [self._forward(p, p.slider[1]) for p in columns]),
        )

    @staticmethod
    def _forward(parameter: Parameter, value: float) -> float:
        return float(np.log(max(value, _lowest(parameter)))) if parameter.log else float(value)

    def vector(self, brdf: Brdf) -> Floats:
        numbers: list[float] = []
        for parameter in self.declared:
            value = getattr(brdf, parameter.name)
            for number in value if parameter.is_colour else (value,):
                numbers.append(self._forward(parameter, number))
        return np.array(numbers)

    def brdf(self, vector: Floats) -> Fitted:
        values, numbers = dict(self.fixed), iter(vector)
        for parameter in self.declared:
            found = [
                min(max(float(np.exp(x) if parameter.log else x), parameter.low), parameter.high)
                for x in (next(numbers) for _ in range(3 if parameter.is_colour else 1))
            ]
            values[parameter.name] = tuple(found) if parameter.is_colour else found[0]
        return self.model(**values)

    def jacobian(self, of: _Objective, vector: Floats) -> Floats:
        """Derivatives (3 N, columns) of the residuals by forward differences, one evaluation per parameter.

        A channel of a colour changes its own channel of the value only, so the three are stepped together.
        """
        low, high = self.bounds()
        here = of(self.brdf(vector)).reshape(-1, 3)
        derivatives = np.zeros((len(here), 3, len(vector)))
        first = 0
        for parameter in self.declared:
            columns = slice(first, first + (3 if parameter.is_colour else 1))
            step = 1e-7 * (high[columns] - low[columns])
            step = np.where(vector[columns] + step > high[columns], -step, step)
            moved = vector.copy()
            moved[columns] += step
            slope = (of(self.brdf(moved)).reshape(-1, 3) - here) / step
            if parameter.is_colour:
                for channel in range(3):
                    derivatives[:, channel, first + channel] = slope[:, channel]
            else:
                derivatives[:, :, first] = slope
            first = columns.stop
        return derivatives.reshape(-1, len(vector))


def _lowest(parameter: Parameter) -> float:
    """The lower end of the fitted range: for a logarithm it must be above 0."""
    return parameter.low if parameter.low > 0.0 or not parameter.log else 0.01 * parameter.slider[0]


def fit(
    data: FitData,
    start: Fitted,
    *,
    weighting: Weighting = "log",
    fixed: tuple[str, ...] = (),
    seed: int = 0,
) -> Steps[Fit]:
    """Fit the model of which `start` is an instance; parameters in `fixed`, or never fitted, keep their values.

    Yields steps whose `partial` is the best BRDF so far. Raises UsageError for a parameter that does not exist, and
    where nothing is left to fit.
    """
    from scipy.optimize import least_squares  # slow to load, and the window must open at once
    from scipy.stats import qmc

    names = [parameter.name for parameter in parameters(start)]
    unknown = [name for name in fixed if name not in names]
    if unknown:
        raise UsageError(f"unknown parameter {unknown[0]!r}; choose from {', '.join(names)}")
    free = tuple(each for each in parameters(start) if each.fitted and each.name not in fixed)
    if not free:
        raise UsageError("all parameters are fixed, so that nothing is left to fit")
    kept = {each.name: getattr(start, each.name) for each in parameters(start) if each not in free}
    space = _Space(type(start), free, kept)
    objective, few = _Objective(data, weighting), _Objective(data.first(FEW), weighting)
    low, high = space.bounds()
    usual_low, usual_high = space.usual()
    evaluations = 0

    points = qmc.Sobol(len(low), seed=np.random.default_rng(seed)).random_base2(int(np.log2(STARTS)))
    starts = [space.vector(start), *(usual_low + (usual_high - usual_low) * points)]
    costs = []
    for index, vector in enumerate(starts):
        costs.append(float(np.sum(few(space.brdf(vector)) ** 2)))
        evaluations += 1
        if index % 16 == 15:
            yield Step(0.2 * index / len(starts), "comparing starts", space.brdf(starts[int(np.argmin(costs))]))

    def refine(vector: Floats, of: _Objective, most: int) -> Steps[tuple[float, Floats]]:
        nonlocal evaluations
        cost, asked = np.inf, 0
        while asked < most:
            inside = np.clip(vector, low + 1e-9 * (high - low), high - 1e-9 * (high - low))
            found = least_squares(
                lambda x: of(space.brdf(x)),
                inside,
                jac=lambda x: space.jacobian(of, x),
                bounds=(low, high),
                x_scale=high - low,
                max_nfev=EVALUATIONS,
            )
            asked += int(found.nfev)
            evaluations += int(found.nfev) + int(found.njev) * (1 + len(free))
            better = 2.0 * found.cost < cost * (1.0 - 1e-9)
            if 2.0 * found.cost < cost:
                cost, vector = 2.0 * float(found.cost), found.x
            yield Step(min(1.0, asked / most), "refining", space.brdf(vector))
            if found.status > 0 or not better:
                break
        return cost, vector

    candidates = []
    for rank, index in enumerate([0, *(1 + np.argsort(costs[1:])[:REFINED])]):
        steps = refine(starts[int(index)], few, 40)
        candidates.append((yield from part(steps, 0.2 + 0.1 * rank, 0.3 + 0.1 * rank)))
    best = min(candidates, key=lambda found: found[0])[1]
    _, polished = yield from part(refine(best, objective, 200), 0.7, 1.0)
    ends = [start, *(space.brdf(vector) for vector in (polished, best))]
    brdf = min(ends, key=lambda made: float(np.sum(objective(made) ** 2)))
    return Fit(
        brdf=brdf,
        before=fit_error(start, data, weighting),
        after=fit_error(brdf, data, weighting),
        by_angle=residual_by_angle(brdf, data),
        evaluations=evaluations,
    )


def residual_by_angle(brdf: Brdf, data: FitData, *, bands: int = 9) -> dict[str, Residual]:
    """Residual of `brdf` against the data, by theta_h, theta_d and theta_i in equal bands from 0 to pi/2."""
    cosine = data.wi[:, 2]
    difference = (brdf.f(data.wi, data.wo) - data.value) * cosine[:, None]
    size = float(np.sqrt(np.mean((data.value * cosine[:, None]) ** 2))) or 1.0
    squared = np.mean(difference**2, axis=1) / size**2
    theta_h, _, theta_d, _ = half_difference(data.wi, data.wo)
    edges = np.linspace(0.0, 0.5 * np.pi, bands + 1)
    residuals = {}
    for name, angle in (("theta_h", theta_h), ("theta_d", theta_d), ("theta_i", np.arccos(np.minimum(cosine, 1.0)))):
        band = np.clip(np.digitize(angle, edges) - 1, 0, bands - 1)
        count = np.bincount(band, minlength=bands)
        total = np.bincount(band, weights=squared, minlength=bands)
        residuals[name] = Residual(edges, np.sqrt(total / np.maximum(count, 1)), count)
    return residuals

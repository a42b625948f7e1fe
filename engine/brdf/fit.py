"""Fits any analytic model to any BRDF or list of measured samples, by least squares within the parameters' ranges.

The residual of a sample and channel is the difference of g(f cos(theta_i)) between model and data, where g is

    joint    as log, but differences above `ROBUST` count by their size and not its square; beside it the logarithm of
             the albedo at several angles, where it is off by more than it is known to, with so much weight that it all
             but holds, that of the light of a sphere in `SKIES`, with less weight, and the logarithm of what rises
             above the ceiling of the samples (`engine.brdf.ceiling`)
    log      log(1 + f cos(theta_i) / m), m the median of the data's luminance f cos(theta_i): every part counts,
             the dim ones as much as the highlight (after Low2012)
    cosine   f cos(theta_i) / RMS of the data: what light carries; a highlight outweighs all else

A highlight that few samples meet is free in the logarithmic norm, and may be brighter than all light that arrives. In
the other it is the only thing that counts, and the colour of what lies around it gets lost. The albedo, for each
channel the light that is reflected to all sides, is what an image in wide light shows, so the joint norm is the
default. Where samples are so few that the smooth BRDF through them reflects more than arrives, and of tables of
directions 15° apart, no albedo is known.

The shape of such a sum of squares has several valleys. So a Sobol set of starts over the declared ranges (parameters
declared `log` by their logarithm) is evaluated on a part of the data, the best few are refined there with
`scipy.optimize.least_squares` (trust region reflective, Branch1999), and the best of these on all data. What a
user starts from is among the starts, so that a fit never ends worse than it began.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Generic, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import Brdf
from engine.brdf.ceiling import ceiling_of
from engine.brdf.half_difference import directions, half_difference
from engine.brdf.models.sampling_lobes import CosineLobe, GaussianHalfVectors, HalfVectorLobe, Mixture, Sampler
from engine.brdf.table import DirectionTable
from engine.core.colour import luminance
from engine.core.directions import Vectors, normalize, surface_direction
from engine.core.errors import UsageError
from engine.core.params import Parameter, parameters
from engine.core.steps import Step, Steps, part
from engine.core.suggestion import suggest
from engine.core.summary import Summary
from engine.light.sky import softboxes, studio

Floats = NDArray[np.float64]
Weighting = Literal["joint", "log", "cosine"]

#: The model that is fitted.
Fitted = TypeVar("Fitted", bound=Brdf)
WEIGHTINGS: tuple[Weighting, ...] = ("joint", "log", "cosine")

#: Difference of logarithms above which it counts by its size in the joint norm.
ROBUST = 0.5
#: Weight there, beside that of all samples together, of the logarithm of the albedo under even light, of the light
#: of a sphere in `SKIES`, of the albedo of single beams, and of what rises above the ceiling; the least albedo that
#: counts.
CONSTRAINT, SHOWN, BEAM, OVERSHOOT, DARKEST = 20.0, 2.0, 1.0, 0.1, 2e-3
#: Share by which the albedo may be wrong: always, for each of the error that left-out samples have, and at most.
KNOWN, LEFT_OUT, MAX_DOUBT = 0.005, 0.1, 0.03
#: Albedo above which something is wrong with the data; estimates of it are off by a few per cent.
MOST = 1.1
#: Angles of the beams whose albedo is taken, their azimuths where the BRDF is brushed, and directions for each.
BEAMS, AROUND, DIRECTIONS = np.radians([10.0, 25.0, 40.0, 55.0, 70.0]), 4, 512
#: Roughness of the half vectors that are drawn for them beside a cosine lobe.
_ROUGHNESS = (0.4, 0.12, 0.03, 0.006)
#: Skies in which a sphere has to look alike, and sides of it for each angle of a beam.
SKIES, SIDES = (studio, softboxes), 8

STARTS = 64
REFINED = 4
#: Samples on which starts are compared, and most samples of a fit.
FEW, MANY = 600, 8000
#: Directions with a smaller cosine, within 3° of the horizon, are not compared.
_GRAZING = float(np.sin(np.radians(3.0)))
#: Evaluations of the residual between two steps of the generator.
EVALUATIONS = 8


@dataclass(frozen=True, eq=False)
class Beams:
    """Beams of light and the share that is reflected of them, to compare a model with.

    Attributes
    ----------
    wi, wo : (B, D, 3) unit directions above the horizon, `wi` the same for each beam.
    weight : (B, D) in sr: Σ f weight over D is the albedo.
    albedo : (B, 3) of the data, of what is not negative.
    lit : (L, B, D, 3) in sr: as `weight`, times the light of each of `SKIES` that a sphere gets from there where it
        turns the beam to the viewer, over that of a white sphere.
    doubt : share by which the albedo may be wrong.
    seen : (L, 3) share of the light of the white sphere that one of the data shows.
    ceiling : (B, D, 3) in 1/sr, what the values may not exceed; infinite where nothing bounds them.
    """

    wi: Vectors
    wo: Vectors
    weight: Floats
    albedo: Floats
    lit: Floats
    seen: Floats
    doubt: float
    ceiling: Floats


@dataclass(frozen=True, eq=False)
class FitData:
    """Data of a fit: unit directions `wi`, `wo` (N, 3) above the horizon and values (N, 3) in 1/sr.

    `beams` are known where the data are a BRDF and not samples alone; without them the joint norm has no albedo.
    """

    wi: Vectors
    wo: Vectors
    value: Vectors
    beams: Beams | None = None

    def __post_init__(self) -> None:
        if not (self.wi.shape == self.wo.shape == self.value.shape and self.wi.ndim == 2 and len(self.wi)):
            raise ValueError("fit data needs equal shapes (N, 3) with N > 0")
        if not np.isfinite(self.value).all():
            raise ValueError("fit data must be finite")

    def first(self, count: int) -> FitData:
        return FitData(self.wi[:count], self.wo[:count], self.value[:count], self.beams)


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
    """Samples of `brdf` (`sample`) and the albedo of beams (`beams_of`): the data of a fit."""
    data = sample(brdf, count=count, seed=seed)
    return replace(data, beams=beams_of(brdf, data, seed=seed))


def beams_of(brdf: Brdf, data: FitData, *, seed: int = 0) -> Beams | None:
    """The albedo of `brdf` at `BEAMS`, and the ceiling of `data` where they are measured samples of it.

    None where `brdf` reflects more of a beam than arrives, and of a table of directions, whose highlights are wrong
    between its entries, 15° apart.

    Directions are drawn from a cosine lobe and half vectors of several widths, so that no highlight of a model falls
    between those of a data set that has none.
    """
    from scipy.stats import qmc  # slow to load, and the window must open at once

    if isinstance(brdf, DirectionTable):
        return None
    lobes: tuple[Sampler, ...] = (
        CosineLobe(),
        *(HalfVectorLobe(GaussianHalfVectors(alpha, alpha)) for alpha in _ROUGHNESS),
    )
    sampler = Mixture(lobes, (0.4, 0.2, 0.15, 0.15, 0.1))
    azimuths = np.zeros(1) if brdf.isotropic else np.pi * (np.arange(AROUND) + 0.5) / AROUND
    beams = surface_direction(*(each.ravel() for each in np.meshgrid(BEAMS, azimuths)))
    points = qmc.Sobol(3, seed=np.random.default_rng(seed)).random_base2(int(np.log2(DIRECTIONS)))
    wi = np.repeat(beams[:, None], len(points), axis=1)
    wo = np.stack([sampler.sample(each, points) for each in wi])
    density = np.stack([sampler.pdf(to, each) for each, to in zip(wi, wo, strict=True)])
    seen = wo[..., 2] > _GRAZING
    weight = np.where(seen, wo[..., 2], 0.0) / (density * len(points))
    wo = np.where(seen[..., None], wo, (0.0, 0.0, 1.0))
    # colours outside sRGB are negative in a channel, which no model is and a display shows black
    albedo = np.einsum("bdc,bd->bc", np.maximum(brdf.f(wi, wo), 0.0), weight)
    if albedo.max() > MOST:
        return None
    ceiling = np.full(wo.shape, np.inf)
    if getattr(brdf, "measured", None) is not None:
        above = ceiling_of(data.wi, data.wo, np.maximum(data.value, 0.0), reciprocal=brdf.reciprocal)
        ceiling = np.maximum(above.look_up(wi, wo), 1e-12)
    doubt = KNOWN + LEFT_OUT * float(getattr(brdf, "leave_one_out", 0.0))
    lit = np.stack([_light(sky, beams, wo) for sky in SKIES]) * weight[..., None]
    share = _shares(beams)
    lit /= np.einsum("b,lbdc->lc", share, lit)[:, None, None] / np.pi
    seen = np.einsum("b,bdc,lbdc->lc", share, np.maximum(brdf.f(wi, wo), 0.0), lit)
    return Beams(wi, wo, weight, albedo, lit, seen, min(doubt, MAX_DOUBT), ceiling)


def _shares(beams: Floats) -> Floats:
    """(B,) what the beams have of the area that a sphere shows, and of the light that comes evenly from all sides."""
    share = beams[:, 2] * np.hypot(beams[:, 0], beams[:, 1])
    return np.asarray(share / share.sum())


def _light(sky: Callable[[Vectors], Vectors], beams: Floats, wo: Floats) -> Floats:
    """(B, D, 3) radiance of a sky from `wo` (B, D, 3) in the frames of a sphere, each beam turned to +Z.

    It is the mean over all sides of the sphere where the beam is as far from the normal.
    """
    total = np.zeros(wo.shape)
    angle = 2.0 * np.pi * (np.arange(SIDES) + 0.5) / SIDES
    for beam, (towards, light) in enumerate(zip(wo, total, strict=True)):
        across = normalize(beams[beam] * (1.0, 1.0, 0.0))
        own = np.stack([across, np.cross((0.0, 0.0, 1.0), across), (0.0, 0.0, 1.0)])  # the beam is in the plane of two
        sine, cosine = np.hypot(*beams[beam, :2]), beams[beam, 2]
        for cos, sin in zip(np.cos(angle), np.sin(angle), strict=True):
            normal = np.array([-sine * cos, -sine * sin, cosine])
            tangent = np.array([cosine * cos, cosine * sin, sine])
            light += sky((towards @ own.T) @ np.stack([tangent, np.cross(normal, tangent), normal]))
    return total / SIDES


def sample(brdf: Brdf, *, count: int = MANY, seed: int = 0) -> FitData:
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


def fit_error(brdf: Brdf, data: FitData, weighting: Weighting = "joint") -> FitError:
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
    """Residuals (3 R,) of a BRDF against data, a row of three channels for each sample, and in the joint norm for each
    beam and each of its directions."""

    def __init__(self, data: FitData, weighting: Weighting) -> None:
        if weighting not in WEIGHTINGS:
            raise ValueError(f"unknown weighting {weighting!r}; choose from {', '.join(WEIGHTINGS)}")
        self.data = data
        seen = np.maximum(data.value, 0.0) * data.wi[:, 2:]
        brightness = luminance(seen)
        lit = brightness[brightness > 0.0]
        self.joint = weighting == "joint"
        if weighting != "cosine":
            middle = float(np.median(lit)) if len(lit) else 1.0
            self.g = lambda seen: np.log1p(seen / middle)
        else:
            size = float(np.sqrt(np.mean(seen**2))) or 1.0
            self.g = lambda seen: seen / size
        self.target = self.g(seen)

    def __call__(self, brdf: Brdf) -> Floats:
        seen = brdf.f(self.data.wi, self.data.wo) * self.data.wi[:, 2:]
        difference = self.g(seen) - self.target
        if not self.joint:
            return np.asarray(difference.ravel())
        # a residual whose square is Huber's smooth loss (Charbonnier)
        rows = [difference * np.sqrt(2.0 / (1.0 + np.hypot(1.0, difference / ROBUST)))]
        if self.data.beams is not None:
            rows += self._beams(brdf, self.data.beams)
        return np.concatenate(rows).ravel()

    def _beams(self, brdf: Brdf, beams: Beams) -> list[Floats]:
        """Rows (1, 3) and (B, 3) of the albedo, and (B D, 3) of what rises above the ceiling."""
        values = brdf.f(beams.wi, beams.wo)
        albedo = np.maximum(np.einsum("bdc,bd->bc", values, beams.weight), 0.0)
        change = _beyond(np.log((albedo + DARKEST) / (beams.albedo + DARKEST)), beams.doubt)
        share = _shares(beams.wi[:, 0])
        even = _beyond(np.log((share @ albedo + DARKEST) / (share @ beams.albedo + DARKEST)), beams.doubt)[None]
        seen = np.maximum(np.einsum("b,bdc,lbdc->lc", share, values, beams.lit), 0.0)
        shown = _beyond(np.log((seen + DARKEST) / (beams.seen + DARKEST)), beams.doubt)
        above = np.log(np.maximum(values / beams.ceiling, 1.0)).reshape(-1, 3)
        weighted = ((CONSTRAINT, even), (SHOWN, shown), (BEAM, change), (OVERSHOOT, above))
        return [weight * np.sqrt(len(self.data.wi) / len(rows)) * rows for weight, rows in weighted]


def _beyond(difference: Floats, doubt: float) -> Floats:
    """What differences are beyond `doubt`, and 0 within."""
    return difference - np.clip(difference, -doubt, doubt)


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
        """Derivatives (3 R, columns) of the residuals by forward differences, one evaluation per parameter.

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
    weighting: Weighting = "joint",
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
        meant = suggest(unknown[0], names)
        raise UsageError(f"unknown parameter {unknown[0]!r}{meant}; choose from {', '.join(names)}")
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

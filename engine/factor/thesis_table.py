"""A table like Fig. 4.2 of the thesis (Cole2002): every BRDF, parametrisation and reciprocity, by every method.

    search       five textures, both parametrisations, with and without reciprocity
    mccool       wi, h and wo, with and without reciprocity; it knows no parametrisation. Once with textures of the
                 search's size, and once with larger ones, as many bytes as all of the search's
    separable    both parametrisations, maps of 16², as many terms as fit into the bytes of the search's textures

All methods see the same samples, and the cosine-weighted error is taken over the same random pairs. Formulas are
sampled up to the angle that every row states; measured data as they are (`engine.factor.data`).
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from engine.brdf.brdf import Brdf
from engine.core.steps import Step, Steps, part, relay
from engine.factor.data import COUNT, MAX_THETA, SEED, FactorData, factor_data
from engine.factor.errors import PAIRS, Factorisation, Metrics, Reference, metrics, reference
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.projection_search import search
from engine.factor.projections import PARAMETRISATIONS, Parametrisation, mccool_projections
from engine.factor.separable import separate
from engine.factor.separable_factors import SeparableFactors
from engine.factor.settings import LARGEST_SIZE, SMALLEST_SIZE
from engine.factor.textures import THESIS, SearchSettings, mccool

Result = TypeVar("Result")

#: Texels a side of the separable maps that `separable_of_bytes` makes, as the search's own.
SEPARABLE_SIZE = 16

_TEXEL_BYTES = 3 * 4

#: The thesis's textures of Fig. 4.2.
FIGURE_4_2 = replace(THESIS, size=24)


@dataclass(frozen=True)
class Row:
    """One line of the table.

    Attributes
    ----------
    brdf : its name. method : "search", "mccool" or "separable".
    parametrisation : "in-out" or "half-diff"; "" where the method has none. reciprocal : whether it is enforced.
    textures, size_bytes : of the factors. projections : by name.
    metrics : over the samples. rms_cosine_weighted : over random pairs, in 1/sr.
    max_theta_deg : what formulas are sampled up to. samples : how many. time_s : of the method.
    """

    brdf: str
    method: str
    parametrisation: str
    reciprocal: bool
    textures: int
    size_bytes: int
    projections: tuple[str, ...]
    metrics: Metrics
    rms_cosine_weighted: float
    max_theta_deg: float
    samples: int
    time_s: float


def separable_of_bytes(
    brdf: Brdf, size_bytes: int, parametrisation: Parametrisation, pairs: Reference
) -> Steps[SeparableFactors]:
    """Maps of 16², as many terms as fit into `size_bytes`, at least one.

    Orthographic of light and viewer; of half and difference vector polar, whose pole has many texels for a highlight.
    """
    terms = max(1, size_bytes // (2 * SEPARABLE_SIZE**2 * _TEXEL_BYTES))
    hemisphere_map = HemisphereMap("polar" if parametrisation == "half-diff" else "orthographic", SEPARABLE_SIZE)
    found = yield from separate(brdf, hemisphere_map, terms, parametrisation=parametrisation, reference=pairs)
    return found.factors


def thesis_table(
    brdfs: Mapping[str, Brdf],
    settings: SearchSettings = FIGURE_4_2,
    *,
    count: int = COUNT,
    max_theta: float = MAX_THETA,
    seed: int = SEED,
    pairs: int = PAIRS,
) -> Steps[tuple[Row, ...]]:
    """The rows for all `brdfs`, by name; each step's `partial` are those that are there. ValueError for a black one.

    Every BRDF takes four searches, of a minute or so each with five textures.
    """
    rows: list[Row] = []
    for index, (name, brdf) in enumerate(brdfs.items()):
        steps = _rows(name, brdf, settings, factor_data(brdf, count, max_theta, seed), max_theta, pairs)
        for_all = part(steps, index / len(brdfs), (index + 1) / len(brdfs))
        rows.extend((yield from _beside(for_all, rows)))
    return tuple(rows)


def _beside(steps: Steps[Result], rows: Sequence[Row], note: str = "") -> Steps[Result]:
    """`steps`, whose partial results are `rows` and the rows of their own, if they have any."""

    def beside(step: Step) -> Step:
        own = step.partial if isinstance(step.partial, tuple) else ()
        return Step(step.done, note + step.note, (*rows, *own))

    return relay(steps, beside)


def _rows(
    name: str,
    brdf: Brdf,
    settings: SearchSettings,
    data: FactorData,
    max_theta: float,
    random_pairs: int,
) -> Steps[list[Row]]:
    pairs = reference(brdf, random_pairs)
    degrees = float(np.degrees(max_theta))
    rows: list[Row] = []

    def record_search(found: Factorisation, parametrisation: str, reciprocal: bool) -> Row:
        last = found.term_errors[-1]
        return Row(
            name,
            found.method,
            parametrisation,
            reciprocal,
            last.textures,
            last.size_bytes,
            tuple(projection.name for projection in found.projections),
            last.metrics,
            last.rms_cosine_weighted,
            degrees,
            len(data),
            last.time_s,
        )

    def fit_mccool(size_bytes: int | None) -> Steps[None]:
        """Fixed projections, with textures of the search's size or of so many bytes in all."""
        for reciprocal in (True, False):
            textures = len(mccool_projections(reciprocal))
            size = settings.size if size_bytes is None else math.isqrt(size_bytes // (textures * _TEXEL_BYTES))
            steps = mccool(
                data,
                min(max(size, SMALLEST_SIZE), LARGEST_SIZE),
                reciprocal,
                smoothing=settings.smoothing,
                held_out=settings.held_out,
                epsilon=settings.epsilon,
                reference=pairs,
            )
            fixed = yield from relay(steps, lambda _: Step(0.0, f"{name}: fixed projections", tuple(rows)))
            rows.append(record_search(fixed, "", reciprocal))
            yield Step(0.0, f"{name}: fixed projections", tuple(rows))

    yield from fit_mccool(None)
    choices = [(form, reciprocal) for form in PARAMETRISATIONS for reciprocal in (True, False)]
    for index, (form, reciprocal) in enumerate(choices):
        chosen = replace(settings, parametrisation=form, reciprocal=reciprocal)
        steps = part(search(data, chosen, reference=pairs), 0.95 * index / 4, 0.95 * (index + 1) / 4)
        found = yield from _beside(steps, rows, f"{name}, {form}: ")
        rows.append(record_search(found, form, reciprocal))
    size_bytes = max(row.size_bytes for row in rows if row.method == "search")
    yield from part(fit_mccool(size_bytes), 0.95, 0.96)
    for index, form in enumerate(PARAMETRISATIONS):
        started = time.perf_counter()
        sums = part(separable_of_bytes(brdf, size_bytes, form, pairs), 0.96 + 0.02 * index, 0.98 + 0.02 * index)
        factors = yield from _beside(sums, rows, f"{name}: ")
        rows.append(
            _record_separable(name, factors, data, pairs, settings.epsilon, degrees, time.perf_counter() - started)
        )
    yield Step(1.0, f"{name}: done", tuple(rows))
    return rows


def _record_separable(
    name: str,
    factors: SeparableFactors,
    data: FactorData,
    pairs: Reference,
    epsilon: float,
    max_theta_deg: float,
    time_s: float,
) -> Row:
    return Row(
        name,
        "separable",
        factors.parametrisation,
        factors.reciprocal,
        2 * factors.terms,
        factors.size_bytes,
        (),
        metrics(factors.f(data.wi, data.wo), data, epsilon),
        pairs.rms(factors)[0],
        max_theta_deg,
        len(data),
        time_s,
    )

"""Cole's search: one inner evaluation of the thesis's size, and whole searches beside McCool's fixed projections.

Separable factors of the size that Wang2004 use, beside sampling the BRDF alone.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from benchmarks.measure import Measure, best_of
from engine.brdf.brdf import Brdf, brdf_from_text
from engine.core.steps import drain
from engine.factor.brdf_matrix import brdf_matrix
from engine.factor.data import factor_data
from engine.factor.errors import reference
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.homomorphic import LogSpace
from engine.factor.projection_search import search
from engine.factor.projections import DIFFERENCE, linear_of_pair
from engine.factor.separable import SeparableMethod, Weighting, separate
from engine.factor.solvers.least_squares_rows import own_products, products
from engine.factor.solvers.quaternions import random_pair
from engine.factor.textures import DEFAULT, Level, SearchSettings, mccool
from engine.factor.thesis_table import FIGURE_4_2

BRDF = "lafortune:preset=blue-paint"

#: Textures that are read twice each, as in the thesis.
RECIPROCAL = replace(DEFAULT, reciprocal=True)


def inner_evaluation() -> Measure:
    """The error of one projection: 45,000 samples, two textures of 16² solved together, read twice each; one thread.

    The limit are the products of the weights that any least-squares matrix of these samples is made of.
    """
    data = factor_data(brdf_from_text(BRDF))
    level = Level(data, LogSpace.of(data.value), RECIPROCAL, RECIPROCAL.size)
    level.chosen = [DIFFERENCE]
    level.solve_all()
    level.prepare()
    projection = linear_of_pair(random_pair(np.random.default_rng(0)))
    time_s = best_of(lambda: level.error(projection))
    rows, before = level.rows(projection), level.rows(DIFFERENCE)
    limit_s = best_of(lambda: (own_products(rows), products(rows, before)))
    return Measure(
        "factor-inner",
        time_s,
        limit_s,
        "adding up the products of bilinear weights",
        {"samples": len(data), "textures": 2, "size": RECIPROCAL.size},
    )


def whole_search(settings: SearchSettings, name: str, max_theta_deg: float) -> Measure:
    """Five textures, six restarts, reciprocal; `…_cut` is by how much the mean squared log error of McCool's falls.

    The thesis (Sec. 4.4) has a cut of more than 83 % with two textures of 32² and does not say how far from the normal
    its samples reach. To 55° two textures of 16² reach 70 to 75 %, of 24² 84 %, of 32² 86 %; those of 16² reach 65 % to
    70°, 54 % to 80° and 45 % to 88°, where grazing light is what both sets miss. So `thesis_…` has textures of 24².

    The limit is the time that as many inner evaluations of full size would take, one after the other.
    """
    data = factor_data(brdf_from_text(BRDF), max_theta=np.radians(max_theta_deg))
    fixed = drain(mccool(data, settings.size, settings.reciprocal)).term_errors[-1].metrics.sq_log
    inner = inner_evaluation()
    found = drain(search(data, settings))
    errors = [term_error.metrics.sq_log for term_error in found.term_errors]
    more = {
        "max_theta_deg": max_theta_deg,
        "evaluations": found.evaluations,
        "mccool_sq_log": fixed,
        "sq_log": errors,
        "two_textures_cut": 1.0 - errors[1] / fixed,
        "five_over_two": errors[-1] / errors[1],
        "condition_number": found.condition_number,
    }
    limit_s = found.evaluations * inner.time_s
    return Measure(name, found.term_errors[-1].time_s, limit_s, "as many inner evaluations of full size", more)


search_55 = partial(whole_search, RECIPROCAL, "factor-search-55-large", 55.0)
search_88 = partial(whole_search, RECIPROCAL, "factor-search-88-large", 88.0)
thesis_55 = partial(whole_search, FIGURE_4_2, "factor-thesis-55-large", 55.0)
thesis_88 = partial(whole_search, FIGURE_4_2, "factor-thesis-88-large", 88.0)


SIZE, TERMS = 48, 16


def separable() -> Measure:
    """16 terms of three channels on maps of 48² by eigenvectors: Lafortune's blue paint, which has every mirror."""
    return _measure("separable-48", "symmetric", "cosine")


def separable_svd() -> Measure:
    """The same by singular vectors."""
    return _measure("separable-48-svd", "svd", "cosine")


def separable_power() -> Measure:
    """The same by the block power iteration."""
    return _measure("separable-48-power", "power", "cosine")


def separable_auto() -> Measure:
    """The same with both norms, compared over 80,000 pairs."""
    return _measure("separable-48-auto", "auto", "auto")


def _measure(name: str, method: SeparableMethod, weighting: Weighting) -> Measure:
    brdf: Brdf = brdf_from_text("lafortune:preset=blue-paint")
    hemisphere_map = HemisphereMap("orthographic", SIZE)
    pairs = reference(brdf)

    def make() -> object:
        return drain(separate(brdf, hemisphere_map, TERMS, method=method, weighting=weighting, reference=pairs))

    time_s = best_of(make, repeats=3)
    limit_s = best_of(lambda: drain(brdf_matrix(brdf, hemisphere_map, "in-out")), repeats=3)
    more = {"texels": len(hemisphere_map.directions), "terms": TERMS, "target_s": 1.0}
    return Measure(name, time_s, limit_s, "sampling the reflectance for the matrix", more)

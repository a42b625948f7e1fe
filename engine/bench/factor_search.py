"""Cole's search: one inner evaluation of the thesis's size, and whole searches beside McCool's fixed projections."""

from __future__ import annotations

from functools import partial

import numpy as np

from engine.bench.measure import Measure, best_of
from engine.brdf.brdf import brdf_from_text
from engine.factor.data import factor_data
from engine.factor.log_space import LogSpace
from engine.factor.projections import DIFFERENCE, linear_of_pair
from engine.factor.quaternions import random_pair
from engine.factor.search import search
from engine.factor.texel_rows import own_products, products
from engine.factor.textures import DEFAULT, THESIS, Level, SearchSettings, mccool
from engine.steps import drain

BRDF = "lafortune:preset=blue-paint"


def inner_evaluation() -> Measure:
    """The error of one projection: 45,000 samples, two textures of 16² solved together, read twice each; one thread.

    The limit are the products of the weights that any least-squares matrix of these samples is made of.
    """
    data = factor_data(brdf_from_text(BRDF))
    level = Level(data, LogSpace.of(data.value), DEFAULT, DEFAULT.size)
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
        {"samples": len(data), "textures": 2, "size": DEFAULT.size},
    )


def whole_search(settings: SearchSettings, name: str, max_theta_deg: float) -> Measure:
    """Five textures, six restarts, reciprocal; `…_cut` is by how much the mean squared log error of McCool's falls.

    The limit is the time that as many inner evaluations of full size would take, one after the other.
    """
    data = factor_data(brdf_from_text(BRDF), max_theta=np.radians(max_theta_deg))
    fixed = mccool(data, settings.size).ladder[-1].metrics.sq_log
    inner = inner_evaluation()
    found = drain(search(data, settings))
    errors = [rung.metrics.sq_log for rung in found.ladder]
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
    return Measure(name, found.ladder[-1].time_s, limit_s, "as many inner evaluations of full size", more)


search_55 = partial(whole_search, DEFAULT, "factor-search-55-large", 55.0)
search_88 = partial(whole_search, DEFAULT, "factor-search-88-large", 88.0)
thesis_55 = partial(whole_search, THESIS, "factor-thesis-55-large", 55.0)
thesis_88 = partial(whole_search, THESIS, "factor-thesis-88-large", 88.0)

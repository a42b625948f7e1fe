"""A million evaluations of every BRDF model, beside a copy of the bytes that each reads and writes."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from benchmarks.measure import Measure, best_of
from engine.brdf.brdf import MODELS
from engine.core.directions import normalize

PAIRS = 1_000_000


def evaluation(model: str) -> Measure:
    """`PAIRS` values of the model with its default parameters, for random directions above the surface."""
    brdf = MODELS[model]()
    wi, wo = _directions(0), _directions(1)
    value = brdf.f(wi, wo)
    time_s = best_of(lambda: brdf.f(wi, wo), repeats=3)
    limit_s = best_of(lambda: [array.copy() for array in (wi, wo, value)], repeats=3)
    return Measure(f"brdf-{model}", time_s, limit_s, "copying the directions and the values", {"pairs": PAIRS})


lambert = partial(evaluation, "lambert")
oren_nayar = partial(evaluation, "oren-nayar")
phong = partial(evaluation, "phong")
blinn_phong = partial(evaluation, "blinn-phong")
lafortune = partial(evaluation, "lafortune")
lafortune_three_lobes = partial(evaluation, "lafortune-three-lobes")
ward = partial(evaluation, "ward")
ashikhmin_shirley = partial(evaluation, "ashikhmin-shirley")
cook_torrance = partial(evaluation, "cook-torrance")
ggx = partial(evaluation, "ggx")
ggx_anisotropic = partial(evaluation, "ggx-anisotropic")
poulin_fournier = partial(evaluation, "poulin-fournier")
metallic_roughness = partial(evaluation, "metallic-roughness")
openpbr = partial(evaluation, "openpbr")
openpbr_anisotropic = partial(evaluation, "openpbr-anisotropic")


def _directions(seed: int) -> NDArray[np.float64]:
    directions = normalize(np.random.default_rng(seed).normal(size=(PAIRS, 3)))
    directions[:, 2] = np.abs(directions[:, 2])
    return directions

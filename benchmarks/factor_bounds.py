"""Factors of generated measurements against what was measured near: how often, and how far, they rise above it.

Pairs are random, uniform over the parabolic disks to 80° of both directions, and the limit of each is three times the
largest sample within 12° (`engine.brdf.ceiling`); of pairs without such a sample nothing is asked. A thousandth of the
pairs may lie above it, which is what the steps of the ceiling's table cost.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.generated_brdfs import generate
from benchmarks.measure import Accuracy
from engine.brdf.readers.read import read_brdf_steps
from engine.brdf.samples import BrdfSamples
from engine.brdf.scattered import fit_scattered
from engine.core.errors import InputError
from engine.core.steps import Step, Steps
from engine.factor.data import parabolic_directions
from engine.factor.factor import factor
from engine.factor.settings import FactorSettings
from engine.factor.solvers.regions import compute_squared_distance

#: Generated materials where no number is asked for, pairs, and the share that may be above the limit.
SAMPLINGS, PAIRS, SHARE = 24, 4000, 1e-3

#: Methods, of sums as small as a first look needs them.
METHODS: tuple[Any, ...] = ("search", "homomorphic", "svd", "nonnegative")
SETTINGS = FactorSettings(side=16, products=4, textures=3, restarts=2)

NEAR = (2.0 * np.sin(np.radians(6.0))) ** 2


def bounds(_folder: Path, data: Path | None = None, samplings: int = SAMPLINGS, seed: int = 0) -> Steps[list[Accuracy]]:
    """A row for each generated material and scattered file and each method: the share of pairs above the limit.

    `more` has the share without the ceiling, and how far the worst pair is above. Some seconds for each row.
    """
    rows: list[Accuracy] = []
    paths = sorted(path for path in data.rglob("*") if path.is_file()) if data is not None else []
    measured: list[BrdfSamples] = []
    for path in paths:
        try:
            brdf: Any = yield from read_brdf_steps(path)
        except InputError:
            continue
        if getattr(brdf, "measured", None) is not None:
            measured.append(brdf.measured)
    measured += [generate(number).samples for number in range(seed, seed + samplings)]
    for place, samples in enumerate(measured):
        brdf = yield from fit_scattered(samples)
        rng = np.random.default_rng(99)
        wi, wo = (parabolic_directions(rng, PAIRS, np.radians(80.0)) for _ in range(2))
        limit = find_limit(samples, wi, wo)
        for method in METHODS:
            yield Step(place / len(measured), f"factoring {samples.name}: {method}")
            found = yield from factor(brdf, replace(SETTINGS, method=method))
            rows.append(_row(f"bounds {samples.name}, {method}", found.factors, limit, wi, wo))
    return rows


def find_limit(samples: BrdfSamples, wi: NDArray[np.float64], wo: NDArray[np.float64]) -> NDArray[np.float64]:
    """(P, 3) three times the largest value near each pair, one pair after the other; NaN where none is near."""
    found = np.full((len(wi), 3), np.nan)
    for pair in range(len(wi)):
        near = compute_squared_distance(samples.wi, samples.wo, wi[pair], wo[pair]) <= NEAR
        if near.any():
            found[pair] = 3.0 * np.maximum(samples.value[near], 0.0).max(axis=0)
    return found


def _row(name: str, factors: Any, limit: NDArray[np.float64], wi: Any, wo: Any) -> Accuracy:
    known = np.isfinite(limit[:, 0])
    shares, worst = {}, {}
    for words, each in (("bounded", factors), ("unbounded", replace(factors, ceiling=None))):
        above = each.f(wi, wo)[known] - limit[known] * (1.0 + 1e-6)
        shares[words] = float((above > 0.0).any(axis=1).mean())
        worst[words] = float(np.maximum(above, 0.0).max())
    more = {
        "pairs": int(known.sum()),
        "unbounded_share": shares["unbounded"],
        "worst_per_sr": worst["bounded"],
        "unbounded_worst_per_sr": worst["unbounded"],
    }
    return Accuracy(name, shares["bounded"], "share of pairs above three times what was measured near", SHARE, more)

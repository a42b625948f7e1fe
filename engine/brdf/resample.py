"""Any BRDF as an isotropic table in half and difference angles, with the error that this makes, measured.

The table is reciprocal and isotropic by its nature. Of a BRDF that is not reciprocal it holds the mean of both ways;
of an anisotropic one the mean over azimuths of the half vector, with a warning. Bins whose directions lie below the
horizon, or within 0.3° of it, are missing and filled as all others are: BRDF may grow there without bound, and
one such bin would shine into all that is interpolated from it.
"""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import DTypeLike, NDArray

from engine.brdf.brdf import MODELS, Brdf
from engine.brdf.half_difference import half_difference
from engine.brdf.table import LARGEST, HalfDifferenceTable, bin_directions, fill_holes
from engine.core.directions import Vectors, surface_direction
from engine.core.figure_text import percent
from engine.core.health import Finding, Health, Verdict
from engine.core.steps import Step, Steps, drain, part

#: The resolution of MERL data.
SHAPE = (90, 90, 180)

#: Azimuths of the half vector over which an anisotropic BRDF is averaged.
AZIMUTHS = 16

#: Random pairs, cosine-weighted on both sides, on which the error is measured.
PAIRS = 20_000

#: Least cosine of both directions of a bin that is sampled.
HORIZON = 0.005

#: Sampled order of the directions: the mean of both, the given one, or light and viewer exchanged.
Way = Literal["mean", "given", "exchanged"]

_ROWS_AT_ONCE = 3


def table_from(
    brdf: Brdf, shape: tuple[int, int, int] = SHAPE, name: str = "", dtype: DTypeLike = np.float64
) -> HalfDifferenceTable:
    """`brdf` sampled at the bin centres of a table of `shape`; see `resample`."""
    return drain(resample(brdf, shape, name, dtype))


def resample(
    brdf: Brdf, shape: tuple[int, int, int] = SHAPE, name: str = "", dtype: DTypeLike = np.float64, way: Way = "mean"
) -> Steps[HalfDifferenceTable]:
    """Sample `brdf` at the bin centres of a table of `shape` (H, D, P), some rows of theta_h at a time.

    The health of the table holds `resampling_rms_rel`, the RMS difference from `brdf` over 20,000 random pairs of
    directions, cosine-weighted on both sides, relative to the RMS of `brdf`, and `resampling_max_rel`, the largest
    difference relative to the largest value.
    """
    values = np.zeros((*shape, 3), dtype)
    missing = np.zeros(shape, bool)
    azimuths = np.arange(1 if brdf.isotropic else AZIMUTHS) * (2.0 * np.pi / AZIMUTHS)
    for first in range(0, shape[0], _ROWS_AT_ONCE):
        rows = slice(first, min(first + _ROWS_AT_ONCE, shape[0]))
        for phi_h in azimuths:
            wi, wo = bin_directions(shape, rows, phi_h)
            visible = (wi[..., 2] > HORIZON) & (wo[..., 2] > HORIZON)
            missing[rows] = ~visible
            pairs = _sample(brdf, wi[visible], wo[visible], way)
            values[rows][visible] += np.clip(pairs, 0.0, LARGEST) / len(azimuths)
        yield Step(0.95 * rows.stop / shape[0], "sampling the reflectance")
    fill_holes(values, missing)
    name = name or str(getattr(brdf, "name", _model_name(brdf)))
    table = HalfDifferenceTable(values, missing, name, "resampled table")
    yield Step(0.98, "measuring the error")
    return replace(table, health=_health(brdf, table))


def _sample(brdf: Brdf, wi: Vectors, wo: Vectors, way: Way) -> Vectors:
    if way == "exchanged":
        return brdf.f(wo, wi)
    if way == "given" or brdf.reciprocal:
        return brdf.f(wi, wo)
    return 0.5 * (brdf.f(wi, wo) + brdf.f(wo, wi))


def whole_turn(brdf: Brdf, shape: tuple[int, int, int] = SHAPE) -> Steps[tuple[NDArray[np.float32], float]]:
    """A lattice (H + 1, D + 1, 2 P, 3) whose phi_d goes once around, for BRDFs that are not reciprocal, and its error.

    Its second half is what a table holds of the BRDF with light and viewer exchanged, as phi_d + π is their exchange.
    The error is that of `resample`, `resampling_rms_rel`.
    """
    given = yield from part(resample(brdf, shape, dtype=np.float32, way="given"), 0.0, 0.5)
    exchanged = yield from part(resample(brdf, shape, dtype=np.float32, way="exchanged"), 0.5, 1.0)
    lattice = np.concatenate([given.lattice, exchanged.lattice], axis=2)
    lattice[0] = lattice[0].mean(axis=1, keepdims=True)
    lattice[:, 0] = lattice[:, 0].mean(axis=1, keepdims=True)
    wi, wo = random_pairs(PAIRS)
    second = half_difference(wi, wo).phi_d < 0.0
    found = np.where(second[:, None], exchanged.f(wi, wo), given.f(wi, wo))
    return lattice, _errors(found, brdf.f(wi, wo))[0]


def _model_name(brdf: Brdf) -> str:
    return next((name for name, model in MODELS.items() if type(brdf) is model), "table")


def _health(brdf: Brdf, table: HalfDifferenceTable) -> Health:
    wi, wo = random_pairs(PAIRS)
    rms, worst = _errors(table.f(wi, wo), brdf.f(wi, wo))
    findings = [Finding(Verdict.NOTE, f"Resampling to a table has an error of {percent(rms)} RMS.")]
    if not brdf.isotropic:
        text = "The BRDF is anisotropic; the table is its mean over the azimuths of the half vector."
        findings.append(Finding(Verdict.WARNING, text))
    if not brdf.reciprocal:
        text = "The BRDF is not reciprocal; the table is the mean of both directions of the light."
        findings.append(Finding(Verdict.NOTE, text))
    figures = {"resampling_rms_rel": rms, "resampling_max_rel": worst, "samples": float(table.samples)}
    return Health(MappingProxyType(figures), tuple(findings))


def _errors(found: Vectors, wanted: Vectors) -> tuple[float, float]:
    """RMS difference relative to the RMS of `wanted`, and the largest relative to its largest; 0 where that is 0."""
    difference = found - wanted
    scale, largest = np.sqrt(np.mean(wanted**2)), np.abs(wanted).max()
    rms = float(np.sqrt(np.mean(difference**2)) / scale) if scale > 0.0 else 0.0
    return rms, float(np.abs(difference).max() / largest) if largest > 0.0 else 0.0


def random_pairs(count: int, seed: int = 0) -> tuple[Vectors, Vectors]:
    """`count` pairs of directions (count, 3), each cosine-weighted over the upper hemisphere."""
    one, two = np.random.default_rng(seed).random((2, 2, count))
    return _cosine_weighted(*one), _cosine_weighted(*two)


def _cosine_weighted(u: NDArray[np.float64], v: NDArray[np.float64]) -> Vectors:
    return surface_direction(np.arcsin(np.sqrt(u)), 2.0 * np.pi * v)

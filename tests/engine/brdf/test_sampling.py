"""Samplers against their densities by chi-square, and their densities against what they are meant to serve."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2

from engine.brdf.brdf import Brdf, brdf_from_text
from engine.brdf.models.sampling import sampler_of
from engine.brdf.models.sampling_lobes import (
    GaussianHalfVectors,
    HalfVectorLobe,
    Mixture,
    PowerHalfVectors,
    PowerLobe,
    Sampler,
    TabulatedHalfVectors,
    TabulatedLobe,
    VisibleGgxLobe,
)
from engine.brdf.resample import table_from
from engine.brdf.samples import BrdfSamples
from engine.brdf.table import DirectionTable
from engine.core.directions import surface_direction
from tests.cases import few
from tests.engine.brdf.fitted import fit_scattered_brdf

#: Cells of the test over the hemisphere, and points a side of each for the expected counts. The edges and the viewers
#: lie on those of the tables, inside whose cells the density is constant.
CELLS = (48, 64)
POINTS = 8
COUNT = 1_000_000
PORTION = 12_500  # samples drawn together, which fit into the cache
SIGNIFICANCE = 0.01

MODELS = (
    "lambert:albedo=0.5",
    "phong:kd=0.3,ks=0.4,exponent=20",
    "phong:kd=0,ks=0.4,exponent=0",
    "blinn-phong:kd=0.1,ks=0.6,exponent=50",
    "oren-nayar:albedo=0.5,sigma_deg=30",
    "lafortune:kd=0.1,ks=0.3,cxy=0.5,cz=0.2,exponent=6",
    "lafortune:preset=blue-paint",
    "ward:kd=0.1,ks=0.4,alpha_x=0.2,alpha_y=0.5",
    "ashikhmin-shirley:kd=0.3,ks=0.1,nu=10,nv=100",
    "cook-torrance:kd=0.2,ks=0.8,m=0.3,f0=0.5",
    "ggx:kd=0.2,alpha=0.3,f0=0.04/0.5/1",
    "ggx:kd=0,alpha=1,f0=1",
    "ggx:kd=0.1,alpha_x=0.2,alpha_y=0.6,f0=0.5",
    "metallic-roughness:base_color=0.8/0.6/0.3,metallic=0.6,roughness=0.5",
    "metallic-roughness:base_color=0.8/0.6/0.3,metallic=0.6,roughness=0.5,coat_weight=0.9,coat_roughness=0.4",
    "metallic-roughness:base_color=0.2,roughness=0.5,sheen_color=0.9/0.7/0.5,sheen_roughness=0.3",
    "openpbr:base_color=0.8/0.6/0.3,specular_roughness=0.4,coat_weight=0.8,coat_roughness=0.4,fuzz_weight=0.3",
    "openpbr:base_metalness=1,specular_roughness=0.4,specular_roughness_anisotropy=0.6",
)
LOBES: dict[str, Sampler] = {
    "mirror": PowerLobe(12.0),
    "retro": PowerLobe(7.0, (0.8, 0.8, 0.5)),
    "power": HalfVectorLobe(PowerHalfVectors(4.0, 60.0)),
    "gaussian": HalfVectorLobe(GaussianHalfVectors(0.2, 0.5)),
    "rough": HalfVectorLobe(GaussianHalfVectors(1.0, 1.0)),
    "visible": VisibleGgxLobe(0.15, 0.6),
    "two": Mixture((PowerLobe(3.0), VisibleGgxLobe(0.4, 0.4)), (0.25, 0.75)),
}
#: Of each kind of lobe one; the albedos of all models are found in every suite.
ORDINARY = (
    "lambert:albedo=0.5",
    "lafortune:kd=0.1,ks=0.3,cxy=0.5,cz=0.2,exponent=6",
    "ashikhmin-shirley:kd=0.3,ks=0.1,nu=10,nv=100",
    "ggx:kd=0.1,alpha_x=0.2,alpha_y=0.6,f0=0.5",
)
VIEWERS_DEG = ((0.0, 0.0), (35.0, 22.5), (85.0, 247.5))


def p_value(sampler: Sampler, wo: np.ndarray, seed: int = 1) -> float:
    """Pearson's test of COUNT samples against the density over cells equal in sin² theta and in azimuth.

    The expected count of a cell is the density's integral by the midpoint rule, in cos(theta) and phi. Rare cells and
    all below the horizon, where nothing reflects and densities over half vectors have a pole, are one cell.
    """
    rows, columns = CELLS
    edges = np.sqrt(1 - np.arange(rows + 1) / rows)
    heights = (edges[:-1] - edges[1:])[:, None]
    cosine = (edges[1:, None] + heights * (np.arange(POINTS) + 0.5) / POINTS).ravel()
    phi = 2 * np.pi * (np.arange(columns * POINTS) + 0.5) / (columns * POINTS)
    w = surface_direction(np.arccos(cosine)[:, None], phi[None, :]).reshape(-1, 3)
    density = sampler.pdf(w, np.broadcast_to(wo, w.shape)).reshape(rows, POINTS, columns, POINTS)
    expected = COUNT * density.mean(axis=(1, 3)) * heights * 2 * np.pi / columns

    random = np.random.default_rng(seed)
    many = np.broadcast_to(wo, (PORTION, 3)).copy()
    found = np.zeros(rows * columns, int)
    for _ in range(COUNT // PORTION):
        wi = sampler.sample(many, random.random((PORTION, 3)))
        assert np.abs(np.linalg.norm(wi, axis=1) - 1).max() < 1e-12
        wi = wi[wi[:, 2] > 0]
        row = np.minimum(((wi[:, 0] ** 2 + wi[:, 1] ** 2) * rows).astype(int), rows - 1)
        column = np.minimum((np.arctan2(wi[:, 1], wi[:, 0]) / (2 * np.pi) % 1 * columns).astype(int), columns - 1)
        found += np.bincount(row * columns + column, minlength=rows * columns)
    observed = found.reshape(rows, columns)

    common = expected >= 25
    counts = np.append(observed[common], COUNT - observed[common].sum()).astype(float)
    hopes = np.append(expected[common], COUNT - expected[common].sum())
    if hopes[-1] < 5:
        assert counts[-1] < 25
        counts, hopes = counts[:-1], hopes[:-1]
    return float(chi2.sf(((counts - hopes) ** 2 / hopes).sum(), len(counts) - 1))


def check(sampler: Sampler) -> None:
    for theta, phi in VIEWERS_DEG:
        level = 1 - (1 - SIGNIFICANCE) ** (1 / (len(VIEWERS_DEG) * (len(MODELS) + len(LOBES))))
        assert p_value(sampler, surface_direction(np.radians(theta), np.radians(phi))) > level, (theta, phi)


@pytest.mark.parametrize("name", few(LOBES, lambda name: name not in ("retro", "rough")))
def test_BR11_lobes_are_drawn_at_their_density(name: str) -> None:
    check(LOBES[name])


@pytest.mark.parametrize("text", few(MODELS, ORDINARY.__contains__))
def test_BR11_models_are_drawn_at_their_density(text: str) -> None:
    check(sampler_of(brdf_from_text(text)))


@pytest.mark.parametrize(
    "text", ["ggx:kd=0.2,alpha=0.4,f0=0.5", pytest.param("phong:kd=0.1,ks=0.4,exponent=15", marks=pytest.mark.long)]
)
@pytest.mark.parametrize("table", [TabulatedLobe, TabulatedHalfVectors])
def test_BR11_tables_are_drawn_at_their_density(table: Any, text: str) -> None:
    tabulated = table.of(brdf_from_text(text))
    check(HalfVectorLobe(tabulated) if isinstance(tabulated, TabulatedHalfVectors) else tabulated)


@pytest.mark.parametrize("table", [TabulatedLobe, TabulatedHalfVectors])
def test_BR11_tables_of_brushed_materials_are_drawn_at_their_density(table: Any) -> None:
    class Brushed:
        isotropic = reciprocal = energy_conserving = False

        def f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
            wi, wo = np.broadcast_arrays(wi, wo)
            return (0.2 + np.maximum(wi[..., 0] * wo[..., 0], 0.0) * (wi[..., 2] > 0))[..., None] * np.ones(3)

    tabulated = table.of(Brushed())
    check(HalfVectorLobe(tabulated) if isinstance(tabulated, TabulatedHalfVectors) else tabulated)


def estimate(brdf: Brdf, sampler: Sampler, wo: np.ndarray, count: int = 1 << 16) -> tuple[float, float, float]:
    """The albedo by importance sampling, its standard error, and the largest weight."""
    many = np.broadcast_to(wo, (count, 3)).copy()
    wi = sampler.sample(many, np.random.default_rng(3).random((count, 3)))
    seen = wi[:, 2] > 0
    weight = np.zeros(count)
    weight[seen] = brdf.f(wi[seen], wo)[:, 1] * wi[seen, 2] / sampler.pdf(wi[seen], many[seen])
    return float(weight.mean()), float(weight.std() / count**0.5), float(weight.max())


@pytest.mark.parametrize(
    "text", ["lafortune:ks=5e-324", "phong:kd=0,ks=5e-324", "phong:kd=5e-324,ks=5e-324", "ward:ks=1e-17"]
)
def test_lobes_of_hardly_any_energy_leave_shares_that_can_be_divided_by(text: str) -> None:
    mixture = sampler_of(brdf_from_text(text))
    assert isinstance(mixture, Mixture)
    assert sum(mixture.shares) == pytest.approx(1.0, rel=1e-12)
    assert min(mixture.shares) > 1e-10


@pytest.mark.parametrize("text", MODELS)
@pytest.mark.parametrize("theta_deg", [0.0, 40.0, 80.0])
def test_sampled_albedo_equals_quadrature(text: str, theta_deg: float) -> None:
    brdf, wo = brdf_from_text(text), surface_direction(np.radians(theta_deg))
    u, phi = np.meshgrid((np.arange(300) + 0.5) / 300, 2 * np.pi * (np.arange(300) + 0.5) / 300)
    exact = np.pi * brdf.f(surface_direction(np.arccos(np.sqrt(u)), phi), wo)[..., 1].mean()
    for sampler in (sampler_of(brdf), TabulatedLobe.of(brdf)):
        mean, error, _ = estimate(brdf, sampler, wo)
        assert abs(mean - exact) <= 4 * error + 2e-3 * exact


@pytest.mark.parametrize("text", ["phong:kd=0,ks=0.5,exponent=1000000", "ggx:kd=0,alpha=0.0001,f0=1"])
def test_narrow_lobes_are_found_by_their_own_sampler(text: str) -> None:
    brdf, wo = brdf_from_text(text), surface_direction(0.3)
    mean, error, largest = estimate(brdf, sampler_of(brdf), wo)
    assert error < 0.01 * mean
    assert largest < 5 * mean


MEASURED = ("half-difference table", "direction table", "scattered samples")


def measure(kind: str) -> Brdf:
    """A BRDF of each kind that files hold, with values of a model."""
    model = brdf_from_text("ggx:kd=0.2,alpha=0.3,f0=0.3")
    if kind == "half-difference table":
        return table_from(model, (30, 20, 24))
    theta, phi = np.radians([5.0, 25.0, 45.0, 65.0, 85.0]), np.radians(np.arange(0.0, 360.0, 45.0))
    if kind == "direction table":
        wi = surface_direction(theta[:, None], phi[None, :])
        values = brdf_from_text("ggx:kd=0.2,alpha_x=0.2,alpha_y=0.6,f0=0.3").f(wi[:, :, None, None], wi[None, None])
        return DirectionTable(theta, phi, theta, phi, values, np.zeros(values.shape[:-1], bool))
    directions = surface_direction(theta[:, None], phi[None, :]).reshape(-1, 3)
    wi, wo = np.repeat(directions[::8], 40, axis=0), np.tile(directions, (5, 1))
    return fit_scattered_brdf(BrdfSamples(wi, wo, model.f(wi, wo)))


@pytest.mark.parametrize("kind", few(MEASURED, lambda kind: kind == "direction table"))
def test_BR11_measurements_are_drawn_at_their_density(kind: str) -> None:
    check(sampler_of(measure(kind)))


@pytest.mark.parametrize("kind", MEASURED)
def test_BR11_samplers_of_measurements_find_their_albedo(kind: str) -> None:
    brdf = measure(kind)
    sampler = sampler_of(brdf)
    wo = surface_direction(0.6, 0.3)
    mean, error, largest = estimate(brdf, sampler, wo)
    uniform, spread, _ = estimate(brdf, Mixture((PowerLobe(0.0, (0.0, 0.0, 1.0)),), (1.0,)), wo)
    assert abs(mean - uniform) <= 4 * (error + spread)
    assert error < spread
    assert largest < 10 * mean

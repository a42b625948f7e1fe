"""Radial basis functions through scattered samples: exactness, symmetries, bounds, and their own figures recomputed."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from engine.brdf import radial_basis, scattered
from engine.brdf.brdf import brdf_from_text
from engine.brdf.models.microfacet import Ggx
from engine.brdf.readers.alta import read_alta
from engine.brdf.readers.cornell import read_cornell
from engine.brdf.samples import BrdfSamples
from engine.brdf.scattered import SYMMETRIES, ScatteredBrdf, Shape, coordinates, fit_scattered
from engine.core.directions import Vectors, surface_direction
from engine.core.steps import drain
from tests.engine.brdf.fitted import fit_scattered_brdf

RANDOM = np.random.default_rng(7)
MODEL = Ggx(kd=cast(Any, 0.2), alpha=0.4, f0=cast(Any, 0.3))


def hemisphere(count: int, min_cosine: float = 0.05, seed: int = 1) -> Vectors:
    random = np.random.default_rng(seed)
    theta = np.arccos(random.uniform(min_cosine, 1.0, count))
    return surface_direction(theta, random.uniform(0.0, 2.0 * np.pi, count))


def model_samples(count: int) -> BrdfSamples:
    wi, wo = hemisphere(count, 0.2, 2), hemisphere(count, 0.2, 3)
    return BrdfSamples(wi, wo, MODEL.f(wi, wo) * (1.0, 0.5, 0.2))


@cache
def smooth() -> ScatteredBrdf:
    return fit_scattered_brdf(model_samples(300))


def test_samples_are_met() -> None:
    brdf = smooth()
    values = brdf.f(brdf.measured.wi, brdf.measured.wo)
    np.testing.assert_allclose(values, brdf.measured.value, rtol=1e-6, atol=0.0)


def test_between_the_samples_it_is_near_the_model() -> None:
    wi, wo = hemisphere(2000, 0.3, 8), hemisphere(2000, 0.3, 9)
    truth = MODEL.f(wi, wo) * (1.0, 0.5, 0.2)
    error = np.abs(fit_scattered_brdf(model_samples(500)).f(wi, wo) - truth)
    assert np.median(error / truth) < 0.005
    assert np.linalg.norm(error) < 0.05 * np.linalg.norm(truth)


def test_symmetries_that_the_data_have_are_found_and_exact() -> None:
    brdf = smooth()
    assert brdf.isotropic
    assert brdf.reciprocal
    wi, wo = hemisphere(500, seed=4), hemisphere(500, seed=5)
    values = brdf.f(wi, wo)
    np.testing.assert_allclose(brdf.f(wo, wi), values, rtol=1e-9)
    np.testing.assert_allclose(brdf.f(wi * (1, -1, 1), wo * (1, -1, 1)), values, rtol=1e-9)
    turn = np.array([[np.cos(1.0), -np.sin(1.0), 0.0], [np.sin(1.0), np.cos(1.0), 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(brdf.f(wi @ turn.T, wo @ turn.T), values, rtol=1e-9)


def test_what_contradicts_a_symmetry_is_still_met() -> None:
    """One pair in both orders and one beside its mirror image, with values that differ."""
    base = model_samples(120)
    wi = np.concatenate([base.wi, base.wo[:1], base.wi[1:2] * (1, -1, 1)])
    wo = np.concatenate([base.wo, base.wi[:1], base.wo[1:2] * (1, -1, 1)])
    value = np.concatenate([base.value, base.value[:1] * 1.5, base.value[1:2] * 0.5])
    brdf = fit_scattered_brdf(BrdfSamples(wi, wo, value))
    assert not brdf.reciprocal
    np.testing.assert_allclose(brdf.f(wi, wo), value, rtol=1e-6)


def test_reciprocal_pairs_that_agree_keep_reciprocity() -> None:
    base = model_samples(150)
    wi, wo = np.concatenate([base.wi, base.wo[:50]]), np.concatenate([base.wo, base.wi[:50]])
    brdf = fit_scattered_brdf(BrdfSamples(wi, wo, np.concatenate([base.value, base.value[:50]])))
    assert brdf.reciprocal
    np.testing.assert_allclose(brdf.f(wo, wi), brdf.f(wi, wo), rtol=1e-9)
    assert brdf.health.figures["samples merged"] == 50


def test_brushed_metal_is_seen_to_be_brushed() -> None:
    wi, wo = hemisphere(400, 0.3, 12), hemisphere(400, 0.3, 13)
    brushed = brdf_from_text("ggx:kd=0.02,alpha_x=0.25,alpha_y=0.7,f0=0.5")
    brdf = fit_scattered_brdf(BrdfSamples(wi, wo, brushed.f(wi, wo)))
    assert not brdf.isotropic
    assert brdf.reciprocal
    np.testing.assert_allclose(brdf.f(wi, wo), brdf.measured.value, rtol=1e-6)
    np.testing.assert_allclose(brdf.f(wo, wi), brdf.measured.value, rtol=1e-6)


def test_light_from_one_azimuth_says_nothing_against_isotropy() -> None:
    theta = np.repeat(np.radians([10.0, 30.0, 50.0, 70.0]), 30)
    wi, wo = surface_direction(theta, np.zeros(120)), hemisphere(120, 0.2, 6)
    assert fit_scattered_brdf(BrdfSamples(wi, wo, MODEL.f(wi, wo))).isotropic


def test_BR_never_negative_never_above_the_samples_finite_everywhere_and_0_below_the_horizon() -> None:
    brdf = smooth()
    edge = surface_direction(np.pi / 2 - np.array([0.0, 1e-15, 1e-8, 1e-3]), np.zeros(4))
    poles = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
    every = np.concatenate([hemisphere(200, -1.0, 10), edge, poles])
    values = brdf.f(every[:, None], every[None, :])
    assert np.isfinite(values).all()
    assert (values >= 0.0).all()
    assert (values <= brdf.measured.value.max(axis=0)).all()
    below = (every[:, 2] <= 0.0)[:, None] | (every[:, 2] <= 0.0)[None, :]
    assert not values[below].any()
    assert values[~below].all()


def test_noise_with_zeros_stays_within_the_samples() -> None:
    samples = model_samples(120)
    random = np.random.default_rng(22)
    wild = BrdfSamples(samples.wi, samples.wo, random.lognormal(0.0, 4.0, (120, 3)) * (random.random((120, 3)) < 0.6))
    values = fit_scattered_brdf(wild).f(hemisphere(4000, seed=23), hemisphere(4000, seed=24))
    assert (values >= 0.0).all()
    assert (values <= wild.value.max(axis=0)).all()


def test_highlights_over_six_decades_do_not_ring() -> None:
    wi, wo = hemisphere(500, 0.2, 14), hemisphere(500, 0.2, 15)
    sharp = Ggx(kd=cast(Any, 0.001), alpha=0.05, f0=cast(Any, 0.04))
    brdf = fit_scattered_brdf(BrdfSamples(wi, wo, sharp.f(wi, wo)))
    np.testing.assert_allclose(brdf.f(wi, wo), brdf.measured.value, rtol=1e-6)
    far_wi, far_wo = hemisphere(3000, 0.2, 16), hemisphere(3000, 0.2, 17)
    half = far_wi + far_wo
    far = half[:, 2] / np.linalg.norm(half, axis=1) < np.cos(np.radians(40.0))
    assert (brdf.f(far_wi, far_wo)[far] < 0.01).all()


def refit(points: Vectors, logs: Vectors, shape: Shape, left_out: int) -> Vectors:
    """The prediction of all other samples for the one left out, by solving without it."""
    rest = np.arange(len(points)) != left_out
    matrix = radial_basis.kernel_matrix(points, shape.signs, shape.smooth)
    return matrix[left_out, rest] @ np.linalg.solve(matrix[np.ix_(rest, rest)], logs[rest])


def test_leave_one_out_in_closed_form_is_what_leaving_out_gives() -> None:
    samples = model_samples(90)
    shape = Shape(SYMMETRIES[0], 0.5, 1.5, False)
    points = coordinates(samples.wi, samples.wo, shape)
    logs = np.log(samples.value)
    solved = radial_basis.solve(radial_basis.kernel_matrix(points, shape.signs, False), logs, 0.0)
    assert solved is not None
    for one in range(0, 90, 9):
        np.testing.assert_allclose(solved.residual[one], logs[one] - refit(points, logs, shape, one), rtol=1e-6)


def test_condition_number_is_that_of_the_matrix() -> None:
    samples = model_samples(200)
    shape = Shape(SYMMETRIES[1], 0.5, 1.5, False)
    matrix = radial_basis.kernel_matrix(coordinates(samples.wi, samples.wo, shape), shape.signs, False)
    solved = radial_basis.solve(matrix.copy(), samples.value, 0.0)
    assert solved is not None
    assert solved.condition == pytest.approx(np.linalg.cond(matrix, 1), rel=1e-6)


@pytest.mark.parametrize("symmetry", SYMMETRIES)
@pytest.mark.parametrize("is_smooth", [False, True])
def test_kernels_are_positive_definite_and_equal_plain_sums(symmetry: scattered.Symmetry, is_smooth: bool) -> None:
    samples = model_samples(60)
    shape = Shape(symmetry, 0.5, 1.0, is_smooth)
    points = coordinates(samples.wi, samples.wo, shape)
    apart = np.stack([points[:, None] - points[None] * signs for signs in shape.signs])
    r = np.minimum(np.linalg.norm(apart, axis=-1) / 4.0, 1.0)
    expected = ((1 - r) ** 5 * (5 * r + 1) if is_smooth else (1 - r) ** 3).mean(axis=0)
    matrix = radial_basis.kernel_matrix(points, shape.signs, is_smooth)
    np.testing.assert_allclose(matrix, expected, atol=1e-14)
    assert np.linalg.eigvalsh(matrix)[0] > 0.0


def test_boxes_change_neither_exactness_nor_symmetry_and_predict_as_well(monkeypatch: pytest.MonkeyPatch) -> None:
    samples = model_samples(500)
    whole = fit_scattered_brdf(samples)
    monkeypatch.setattr(radial_basis, "PATCH_SAMPLES", 300)
    monkeypatch.setattr(radial_basis, "_LEAF_SAMPLES", 90)
    boxed = fit_scattered_brdf(samples)
    assert boxed.health.figures["boxes"] >= 6
    np.testing.assert_allclose(boxed.f(samples.wi, samples.wo), samples.value, rtol=1e-6)
    wi, wo = hemisphere(1000, 0.2, 18), hemisphere(1000, 0.2, 19)
    values = boxed.f(wi, wo)
    np.testing.assert_allclose(boxed.f(wo, wi), values, rtol=1e-9)
    assert np.linalg.norm(values - whole.f(wi, wo)) < 0.05 * np.linalg.norm(values)
    assert boxed.leave_one_out_log < 2.0 * whole.leave_one_out_log
    # Continuous across the sides of the boxes: steps along a path shrink with it.
    theta = np.linspace(0.05, 1.3, 40001)
    path = boxed.f(surface_direction(0.5, 0.0), surface_direction(theta, 0.3 * theta))
    jump = np.abs(np.diff(np.log(path), axis=0)).max()
    assert jump < 20.0 * np.diff(theta)[0]


def test_smoothing_trades_exactness_for_condition() -> None:
    samples = model_samples(200)
    noisy = BrdfSamples(samples.wi, samples.wo, samples.value * np.exp(RANDOM.normal(0.0, 0.1, (200, 1))))
    exact, softened = fit_scattered_brdf(noisy), fit_scattered_brdf(noisy, smoothing=0.03)
    assert softened.condition_number < exact.condition_number
    assert softened.leave_one_out_log < exact.leave_one_out_log
    wi, wo = hemisphere(1000, 0.3, 20), hemisphere(1000, 0.3, 21)
    truth = np.log(MODEL.f(wi, wo) * (1.0, 0.5, 0.2))
    errors = [np.std(np.log(brdf.f(wi, wo)) - truth) for brdf in (exact, softened)]
    assert errors[1] < errors[0]
    with pytest.raises(ValueError, match="smoothing"):
        drain(fit_scattered(noisy, -1.0))


def test_L10_duplicates_with_conflicting_values_become_their_mean_in_log() -> None:
    base = model_samples(60)
    doubled = BrdfSamples(
        np.concatenate([base.wi, base.wi[:1]]),
        np.concatenate([base.wo, base.wo[:1]]),
        np.concatenate([base.value, base.value[:1] * 4.0]),
    )
    brdf = fit_scattered_brdf(doubled)
    value = brdf.f(base.wi[:1], base.wo[:1])[0]
    offset = 0.1 * np.median(doubled.value)
    expected = np.sqrt((base.value[0] + offset) * (4.0 * base.value[0] + offset)) - offset
    np.testing.assert_allclose(value, expected, rtol=1e-9)
    assert any("repeat" in finding.text for finding in brdf.health.findings)


def test_one_direction_pair_a_hundred_thousand_times_is_one_sample() -> None:
    base = model_samples(3)
    brdf = fit_scattered_brdf(
        BrdfSamples(*cast(Any, (np.repeat(part, 40_000, axis=0) for part in (base.wi, base.wo, base.value))))
    )
    assert brdf.health.figures["samples merged"] == 120_000 - 3
    np.testing.assert_allclose(brdf.f(base.wi, base.wo), base.value, rtol=1e-6)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_few_samples_suffice(count: int) -> None:
    samples = model_samples(300)
    few = BrdfSamples(samples.wi[:count], samples.wo[:count], samples.value[:count])
    brdf = fit_scattered_brdf(few)
    np.testing.assert_allclose(brdf.f(few.wi, few.wo), few.value, rtol=1e-6)


def test_black_and_constant_samples() -> None:
    samples = model_samples(50)
    for value in (0.0, 5e-324, 0.25, 1e30):
        brdf = fit_scattered_brdf(BrdfSamples(samples.wi, samples.wo, np.full((50, 3), value)))
        np.testing.assert_allclose(brdf.f(hemisphere(50), hemisphere(50, seed=9)), value, rtol=1e-9, atol=1e-12)
        assert brdf.leave_one_out == pytest.approx(0.0, abs=1e-9)


def test_directions_broadcast() -> None:
    brdf = smooth()
    wi, wo = hemisphere(4), hemisphere(5, seed=2)
    values = brdf.f(wi[:, None], wo)
    assert values.shape == (4, 5, 3)
    np.testing.assert_allclose(values[2, 3], brdf.f(wi[2], wo[3]), rtol=1e-12)
    assert brdf.f(wi[:0], wo[:0]).shape == (0, 3)


@pytest.mark.parametrize(
    "name", ["cornell/krylon_blue.astm", pytest.param("alta/retro-gray-tape.dat", marks=pytest.mark.long)]
)
def test_real_measurements_are_met(shared_data: Callable[[str], Path], name: str) -> None:
    path = shared_data(f"brdf/{name}")
    samples = read_alta(path) if path.suffix == ".dat" else read_cornell(path)
    brdf = fit_scattered_brdf(samples)
    scale = samples.value.max()
    np.testing.assert_allclose(brdf.f(samples.wi, samples.wo), samples.value, rtol=1e-6, atol=1e-9 * scale)
    assert brdf.isotropic
    assert brdf.leave_one_out_log < (0.1 if path.suffix == ".dat" else 0.15)
    assert brdf.condition_number < 1e12

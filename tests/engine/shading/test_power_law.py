"""The power-law fit against closed forms, a dense grid and scipy."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from engine.core.steps import drain
from engine.shading.power_law import SCALES, PowerLawMap, fit
from engine.shading.power_law_kernel import (
    AT,
    LANES,
    SCALE,
    exponent_grid,
    exponential,
    fit_lanes,
    largest_exponent,
    log_positions,
)
from engine.shading.quantise import quantisation_bound, quantise_exponent
from engine.shading.shading_map import ShadingMap

SLICES = 8
X = np.arange(SLICES) / (SLICES - 1)


def fit_samples(samples: Any, scale: str = "last-slice") -> tuple[Any, Any]:
    """(k, K) of texels (T, S), slice 0 included, in the float64 of the kernel, which `fit` rounds."""
    values = np.maximum(np.asarray(samples, np.float64)[:, 1:].T, 0.0)
    slices, texels = len(values) + 1, values.shape[1]
    grid, log_x = exponent_grid(slices), log_positions(slices)
    powers = np.exp(np.outer(log_x, grid)).astype(np.float32)
    padded = np.pad(values, ((0, 0), (0, -texels % LANES)))
    found = []
    for left in range(0, padded.shape[1], LANES):
        block = np.ascontiguousarray(padded[:, left : left + LANES])
        held = np.zeros(block.shape[1], np.bool_)
        work = fit_lanes(block, np.ones_like(block), held, scale == "least-squares", grid, log_x, powers)
        found.append([work[part : part + LANES] for part in (SCALE, AT)])
    k, exponent = np.concatenate(found, axis=1)[:, :texels]
    return k, exponent


def map_of(samples: Any, **more: Any) -> ShadingMap:
    """A shading map with one texel for each row of samples (T, S) or (T, S, 3)."""
    samples = np.asarray(samples, np.float32)
    if samples.ndim == 2:
        samples = np.repeat(samples[..., None], 3, axis=2)
    slices = np.ascontiguousarray(samples.transpose(1, 0, 2)[:, None])
    return ShadingMap(slices, 1.0, np.linspace(0.0, 1.0, len(slices)), **more)


def compute_squared_error(samples: Any, k: Any, exponent: Any) -> Any:
    return ((samples[:, 1:] - k[:, None] * X[1:] ** exponent[:, None]) ** 2).sum(axis=1)


def dense_grid_error(samples: Any, scale: Any) -> Any:
    """Oracle: the least SSE of texels (T, S) over a dense grid of exponents."""
    grid = np.concatenate([np.linspace(0, 8, 1000), np.geomspace(8, largest_exponent(SLICES), 400)])
    powers = X[1:, None] ** grid
    energy = (powers**2).sum(axis=0)
    best = []
    for chunk in np.array_split(samples, max(1, len(samples) // 2000)):
        cross = chunk[:, 1:] @ powers
        k = chunk[:, -1:] if scale == "last-slice" else cross / energy
        node = (k * (k * energy - 2 * cross)).argmin(axis=1)
        k = chunk[:, -1] if scale == "last-slice" else k[np.arange(len(chunk)), node]
        best.append(compute_squared_error(chunk, k, grid[node]))
    return np.concatenate(best)


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("exponent", [0.01, 0.3, 1.0, 5.0, 40.0, 64.0])
def test_P1_exact_powers_are_recovered(exponent: float, scale: Any) -> None:
    k, found = fit_samples([0.7 * X**exponent], scale)
    assert abs(found[0] - exponent) <= 1e-10
    assert k[0] == pytest.approx(0.7, rel=1e-12)


@given(st.floats(0.0, 100.0), st.floats(1e-30, 1e30), st.sampled_from(SCALES))
@example(10.5625, 1.0, "least-squares")
def test_P1_any_exact_power_is_recovered(exponent: Any, scale: Any, mode: Any) -> None:
    k, found = fit_samples([scale * X**exponent], mode)
    assert abs(found[0] - exponent) <= 1e-10 * max(1.0, exponent)
    assert k[0] == pytest.approx(scale, rel=1e-10)


def test_P2_black_texels_are_zero_by_convention_and_counted() -> None:
    power_law = drain(fit(map_of([np.zeros(SLICES), X, np.zeros(SLICES)])))
    np.testing.assert_array_equal(power_law.scale[0, :, 0], [0, 1, 0])
    np.testing.assert_allclose(power_law.exponent[0, :, 0], [1, 1, 1], rtol=1e-6)
    assert power_law.exponent[0, 0, 0] == 1
    assert power_law.health.figures["black_fraction"] == pytest.approx(2 / 3)
    assert not power_law.slice_image(1.0)[0, 0].any()


def test_P3_a_black_last_slice_does_not_lose_the_texel() -> None:
    samples = np.array([[0, 0.1, 0.3, 0.4, 0.5, 0.4, 0.2, 0.0]])
    k, exponent = fit_samples(samples)
    assert k[0] > 0.1
    assert compute_squared_error(samples, k, exponent) <= dense_grid_error(samples, "least-squares") * 1.001


def test_P4_constant_texels_have_exponent_0_and_are_black_at_0() -> None:
    constant = np.full((1, SLICES), 0.25)
    constant[:, 0] = 0
    power_law = drain(fit(map_of(constant)))
    assert np.all(power_law.exponent == 0)
    assert np.all(power_law.scale == np.float32(0.25))
    assert power_law.rms == 0
    assert not power_law.slice_image(0.0).any()
    assert not power_law.lookup(0.5, 0.5, 0.0).any()
    assert np.all(power_law.slice_image(1e-30) == np.float32(0.25))


def test_P5_darkening_texels_are_held_at_0_and_shown() -> None:
    power_law = drain(fit(map_of([1 - 0.9 * X, X])))
    assert np.all(power_law.exponent[0, 0] == 0)
    assert power_law.error_map[0, 0] > 100 * power_law.error_map[0, 1]
    assert power_law.health.figures["flat_or_darkening_fraction"] == pytest.approx(0.5)


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("bad", [1, 4, 7])
def test_P6_an_excluded_outlier_does_not_matter(scale: Any, bad: int) -> None:
    exponent = np.array([0.4, 1.0, 2.5])
    samples = 0.8 * X ** exponent[:, None]
    samples[:, bad] = 3.0
    excluded = np.zeros((SLICES, 1, 3), np.bool_)
    excluded[bad] = True
    power_law = drain(fit(map_of(samples), scale, excluded))
    np.testing.assert_allclose(power_law.exponent[0, :, 0], exponent, atol=1e-5)
    np.testing.assert_allclose(power_law.scale[0, :, 0], 0.8, rtol=1e-5)
    clipped = drain(fit(map_of(samples, clipped=excluded), scale))
    assert np.array_equal(clipped.exponent, power_law.exponent)
    assert np.all(power_law.error_map > 0.5)


@pytest.mark.parametrize("scale", SCALES)
def test_P6_clipped_slices_extrapolate_no_further_than_two_stops(scale: Any) -> None:
    generator = np.random.default_rng(1)
    samples = generator.uniform(0.0, 1.0, (400, SLICES)) ** generator.integers(1, 9, (400, 1))
    samples[:, 0] = 0.0
    samples[0] = [0, 0, 0, 0, 0, 0.0486, 0.2153, 0.3564]
    clipped = np.zeros((SLICES, 1, 400), np.bool_)
    clipped[-2:] = True
    power_law = drain(fit(map_of(samples, clipped=clipped), scale))
    brightest = samples.max(axis=1)
    k, exponent = power_law.scale[0, :, 0].astype(np.float64), power_law.exponent[0, :, 0].astype(np.float64)
    assert np.all(k <= 4.0 * brightest * (1 + 1e-6))
    assert np.all(power_law.error_map < 4.0)
    held = k > 3.999 * brightest
    assert held[0]
    assert power_law.health.figures["extrapolation_held_fraction"] == pytest.approx(held.mean())
    trials = np.linspace(0.0, 128.0, 20_001)
    for texel in np.flatnonzero(held):
        model = k[texel] * X[1:-2] ** trials[:, None]
        best = ((model - samples[texel, 1:-2]) ** 2).sum(axis=1).min()
        found = ((k[texel] * X[1:-2] ** exponent[texel] - samples[texel, 1:-2]) ** 2).sum()
        assert found <= best * (1 + 1e-6) + 1e-12


def test_P6_where_all_is_excluded_all_counts() -> None:
    everything = np.ones((SLICES, 1, 1), np.bool_)
    samples = [0.8 * X**1.7]
    with_mask, without = drain(fit(map_of(samples), excluded=everything)), drain(fit(map_of(samples)))
    assert np.array_equal(with_mask.exponent, without.exponent)


def test_P7_negative_samples_count_as_0() -> None:
    samples = np.array([0.5 * X**2.0 - 0.02])
    zeroed = np.maximum(samples, 0)
    assert fit_samples(samples) == fit_samples(zeroed)
    negative = drain(fit(map_of(samples)))
    assert np.array_equal(negative.exponent, drain(fit(map_of(zeroed))).exponent)
    assert np.isfinite(negative.rms)


@pytest.mark.parametrize("slices", [2, 3, 8, 16, 40])
def test_P8_the_cap_of_the_exponent_costs_less_than_a_thousandth(slices: int) -> None:
    samples = np.zeros((1, slices))
    samples[0, -1] = 1.0
    power_law = drain(fit(map_of(samples)))
    images = [power_law.slice_image(r)[0, 0, 0] for r in np.linspace(0, 1, slices)]
    np.testing.assert_allclose(images, samples[0], atol=1 / 1024)
    assert power_law.exponent.max() <= largest_exponent(slices)


@pytest.mark.parametrize("exponent", [8.6, 44.9, 60.0, 128.0])
def test_P8_underflow_is_silent_and_small(exponent: float) -> None:
    shape = (1, 1, 3)
    power_law = PowerLawMap(
        np.ones(shape, np.float32), np.full(shape, exponent, np.float32), 1.0, 0.0, np.zeros(3), np.zeros((1, 1), "f4")
    )
    with np.errstate(all="raise"):
        values = [power_law.slice_image(r)[0, 0, 0] for r in X]
    np.testing.assert_allclose(values, X**exponent, atol=1 / 1024)


@pytest.mark.parametrize("bits", [8, 16])
def test_P9_the_bound_of_quantised_exponents_holds(bits: int) -> None:
    rng = np.random.default_rng(0)
    exponent = np.concatenate([[0.0], rng.gamma(2.0, 1.0, 500), [40.0]])
    scale = rng.random(exponent.size)
    codes, step = quantise_exponent(exponent, bits)
    assert codes.dtype.itemsize * 8 == bits
    stored = codes * step
    assert np.all(np.abs(stored - exponent) <= step / 2 * (1 + 1e-12))
    r = np.linspace(0, 1, 2001)[1:, None]
    change = np.abs(scale * r**exponent - scale * r**stored).max(axis=0)
    bound = quantisation_bound(scale, exponent, stored)
    assert np.all(change <= bound * (1 + 1e-12))
    large = exponent > 10 * step
    assert np.all(bound[large] <= 1.06 * scale[large] * (step / 2) / (np.e * exponent[large]))


def test_P9_the_bound_is_nearly_attained() -> None:
    exponent, stored = 2.0, 2.001
    r = np.linspace(0, 1, 100001)[1:]
    change = np.abs(r**exponent - r**stored).max()
    assert quantisation_bound(1.0, exponent, stored) == pytest.approx(change, rel=2e-3)


@given(st.floats(-700, 0))
def test_the_exponential_is_exact_to_rounding(x: Any) -> None:
    assert exponential(x) == pytest.approx(np.exp(x), rel=5e-16)


def random_texels(count: int, seed: int = 0) -> Any:
    """Samples of every kind: powers with noise, pure noise, bumps, steps, and sums of two powers."""
    rng = np.random.default_rng(seed)
    share = count // 5
    power = X ** np.exp(rng.normal(0, 1.2, (share, 1)))
    noise = rng.random((share, SLICES))
    bump = np.exp(-(((X - rng.random((share, 1))) / rng.uniform(0.05, 0.5, (share, 1))) ** 2))
    step = (rng.random((share, 1)) < X) * rng.random((share, 1)) + 0.3 * rng.random((share, 1)) * X
    mixed = rng.random((share, 1)) * X**0.05 + rng.random((share, 1)) * X ** rng.uniform(3, 60, (share, 1))
    noisy = np.maximum(power * (1 + 0.2 * rng.normal(size=power.shape)), 0)
    samples = np.concatenate([noisy, noise, bump, step, mixed])
    samples[:, 0] = 0
    return samples


@pytest.mark.parametrize("scale", SCALES)
def test_P10_the_lower_of_two_minima_is_found(scale: Any) -> None:
    samples = random_texels(100_000)
    found = compute_squared_error(samples, *fit_samples(samples, scale))
    assert np.all(found <= 1.001 * dense_grid_error(samples, scale) + 1e-18)


@pytest.mark.parametrize(
    ("scale", "texel"),
    [
        ("last-slice", [0, 0.23611626, 0.41776566, 0.61417155, 0.53569103, 0.20044987, 0.02803851, 0.96743638]),
        ("least-squares", [0, 0.87927825, 0.25647413, 0.03062383, 0.01285102, 0.17523726, 0.32007097, 0.90975483]),
    ],
)
def test_P10_minima_that_the_grid_confuses_are_both_followed(scale: str, texel: Any) -> None:
    samples = np.repeat([texel], 7 * 201, axis=0)
    for index, part in enumerate(np.array_split(np.arange(len(samples)), 7)):
        samples[part, index + 1] *= np.linspace(0.98, 1.02, len(part))
    found = compute_squared_error(samples, *fit_samples(samples, scale))
    assert np.all(found <= 1.001 * dense_grid_error(samples, scale))


@settings(max_examples=60)
@given(st.lists(st.floats(0, 1), min_size=SLICES - 1, max_size=SLICES - 1), st.sampled_from(SCALES))
def test_P10_scipy_finds_nothing_lower_near_the_minimum(values: Any, scale: Any) -> None:
    samples = np.array([[0.0, *values]])
    k, exponent = fit_samples(samples, scale)
    if samples[0, -1] == 0:
        scale = "least-squares"

    def error(trial: Any) -> Any:
        powers = X[1:] ** trial
        factor = samples[0, -1] if scale == "last-slice" else samples[0, 1:] @ powers / (powers @ powers)
        return ((samples[0, 1:] - factor * powers) ** 2).sum()

    near = minimize_scalar(error, bounds=(0.9 * exponent[0], 1.1 * exponent[0] + 1e-6), method="bounded")
    assert compute_squared_error(samples, k, exponent)[0] <= near.fun * (1 + 1e-9) + 1e-15


def test_P10_least_squares_is_never_worse() -> None:
    samples = random_texels(20_000, seed=3)
    fixed, free = (compute_squared_error(samples, *fit_samples(samples, scale)) for scale in SCALES)
    assert np.all(free <= fixed * (1 + 1e-9) + 1e-18)


@pytest.mark.parametrize("rows", [1, 3, 17])
def test_tiles_do_not_change_a_bit(monkeypatch: pytest.MonkeyPatch, rows: int) -> None:
    samples = random_texels(17 * 19 * 3 * 5, seed=5)[: 17 * 19 * 3].astype(np.float32)
    slices = np.ascontiguousarray(samples.reshape(17, 19, 3, SLICES).transpose(3, 0, 1, 2))
    shading_map = ShadingMap(slices, 1.0, np.linspace(0, 1, SLICES))
    whole = drain(fit(shading_map))
    monkeypatch.setattr("engine.shading.power_law.TILE_TEXELS", 19 * rows)
    tiled = drain(fit(shading_map))
    assert np.array_equal(whole.exponent, tiled.exponent)
    assert np.array_equal(whole.scale, tiled.scale)
    assert whole.rms == tiled.rms


def test_the_errors_are_those_of_the_reconstruction() -> None:
    samples = random_texels(500, seed=7)
    shading_map = map_of(np.stack([samples, samples**2, -0.1 * samples], axis=2))
    power_law = drain(fit(shading_map))
    rebuilt = np.stack([power_law.slice_image(r) for r in shading_map.target_radiance]).astype(np.float64)
    squares = (rebuilt - shading_map.slices) ** 2
    assert power_law.rms == pytest.approx(np.sqrt(squares.mean()), rel=1e-5)
    np.testing.assert_allclose(power_law.rms_per_channel, np.sqrt(squares.mean(axis=(0, 1, 2))), rtol=1e-5)
    np.testing.assert_allclose(power_law.error_map, np.sqrt(squares.mean(axis=(0, 3))), rtol=1e-4, atol=1e-6)


def test_lookup_filters_scale_and_exponent() -> None:
    rng = np.random.default_rng(2)
    scale, exponent = rng.random((2, 3, 4, 3), np.float32)
    power_law = PowerLawMap(scale, exponent, 2.0, 0.0, np.zeros(3), np.zeros((3, 4), np.float32))
    rows, columns = np.mgrid[:3, :4] + 0.5
    assert np.array_equal(power_law.lookup(rows, columns, 1.3), power_law.slice_image(1.3))
    between = power_law.lookup(1.5, 4.0, 1.0)
    expected = (scale[1, 3] + scale[1, 0]) / 2 * 0.5 ** ((exponent[1, 3] + exponent[1, 0]) / 2)
    np.testing.assert_allclose(between, expected, rtol=1e-6)
    assert np.array_equal(power_law.slice_image(4.0, "scale"), 2 * scale)
    assert np.array_equal(power_law.slice_image(4.0, "clamp"), scale)


@pytest.mark.parametrize("exponent", [0.0, 1e-30, 1.0, 128.0])
@pytest.mark.parametrize("r", [0.0, -0.0, -1.0, np.nan, -np.inf, np.inf])
def test_X9_powers_of_what_is_not_positive_are_black(exponent: float, r: float) -> None:
    shape = (1, 1, 3)
    power_law = PowerLawMap(
        np.ones(shape, np.float32), np.full(shape, exponent, np.float32), 1.0, 0.0, np.zeros(3), np.zeros((1, 1), "f4")
    )
    for above in ("clamp", "scale"):
        assert not power_law.slice_image(r, above).any()
        assert not power_law.lookup(0.5, 0.5, [r, 0.0], above).any()


def test_samples_that_are_not_finite_do_not_count() -> None:
    samples = np.array([0.6 * X**1.5])
    samples[0, 3] = np.nan
    samples[0, 5] = np.inf
    power_law = drain(fit(map_of(samples)))
    assert power_law.exponent[0, 0, 0] == pytest.approx(1.5, rel=1e-5)


def test_wrong_calls_are_refused() -> None:
    shading_map = map_of([X])
    with pytest.raises(ValueError, match="least-squares"):
        drain(fit(shading_map, cast(Any, "best")))
    with pytest.raises(ValueError, match="excluded"):
        drain(fit(shading_map, excluded=np.zeros((2, 1, 1), np.bool_)))
    with pytest.raises(ValueError, match="bits"):
        quantise_exponent([1.0], 12)

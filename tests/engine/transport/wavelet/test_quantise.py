"""Quantising and packing of transport and light."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from engine.transport.wavelet.haar import cube_of_coefficients
from engine.transport.wavelet.quantise import (
    BOUNDS,
    LIGHT_BOUND,
    SAFE_PRODUCTS,
    dequantise,
    encode_light,
    pack,
    quantise,
    rounding_error_rel,
    unpack,
)

STEPS = np.array([2046.0, 2046.0, 1022.0])


def test_Z10_every_word_unpacks_and_packs_to_itself() -> None:
    words = np.random.default_rng(1).integers(0, 2**32, 1_000_000, dtype=np.uint32)
    assert np.array_equal(pack(unpack(words)), words)
    corners = np.array(np.meshgrid([-1024, -1, 0, 1, 1023], [-1024, -1, 0, 1, 1023], [-512, -1, 0, 1, 511]))
    corners = corners.reshape(3, -1).T
    assert np.array_equal(unpack(pack(corners)), corners)
    assert pack([[1, 0, 0], [0, 1, 0], [0, 0, 1]]).tobytes().hex() == "010000000008000000004000"


def test_coefficients_that_do_not_fit_are_refused() -> None:
    for quantised in ([1024, 0, 0], [0, -1025, 0], [0, 0, 512], [0, 0, -513]):
        with pytest.raises(ValueError, match="does not fit"):
            pack(quantised)


@given(arrays(np.float32, (7, 3), elements=st.floats(-1e6, 1e6, width=32)))
def test_Z9_values_err_by_half_a_step_and_never_change_sign(values: np.ndarray) -> None:
    words, peaks = quantise(values)
    found = dequantise(words, peaks)
    assert (np.abs(found - values) <= peaks / STEPS * (1.0 + 1e-6)).all()
    assert (found * values >= 0.0).all()
    assert (np.abs(unpack(words)) <= BOUNDS).all()


def test_Z9_halves_are_rounded_to_even() -> None:
    values = np.zeros((5, 3), np.float32)
    values[:, 0] = [1023.0, 0.5, 1.5, 2.5, -0.5]
    assert unpack(quantise(values)[0])[:, 0].tolist() == [1023, 0, 2, 2, 0]


@pytest.mark.parametrize("size", [1e-42, 1e-38, 1.0, 1e30, 3.4e38])
def test_Z11_tiny_and_huge_peaks(size: float) -> None:
    values = (np.array([[1.0, -0.5, 0.25], [0.1, 1.0, -1.0]]) * size).astype(np.float32)
    words, peaks = quantise(values)
    assert (np.abs(dequantise(words, peaks) - values) <= peaks / STEPS * (1.0 + 1e-6)).all()
    assert np.array_equal(peaks, np.abs(values).max(axis=0))


def test_Z7_nothing_stays_nothing_and_Z16_a_dark_channel_dark() -> None:
    words, peaks = quantise(np.zeros((4, 96, 3)))
    assert [words.any(), peaks.any(), dequantise(words, peaks).any()] == [False] * 3
    values = np.random.default_rng(3).standard_normal((96, 3))
    values[:, 1] = 0.0
    assert not dequantise(*quantise(values))[:, 1].any()


@pytest.mark.parametrize("step", [1, 2, 4, 8, 16])
def test_rounding_to_steps_errs_as_is_said(step: int) -> None:
    rng = np.random.default_rng(8)
    values = rng.laplace(size=(300, 96, 3)) * rng.random((300, 1, 3)) ** 4
    words, peaks = quantise(values, step)
    found = dequantise(words, peaks)
    codes = unpack(words)
    assert not (codes % (step, step, max(step // 2, 1))).any()
    assert (np.abs(codes) <= BOUNDS).all()
    whole = np.array(BOUNDS) // (step, step, max(step // 2, 1))
    largest = np.abs(values).max(axis=1)
    assert (np.abs(found - values) <= (largest / (2.0 * whole))[:, None] * (1.0 + 1e-4)).all()
    np.testing.assert_allclose(np.abs(found).max(axis=1), largest, rtol=1e-5)
    true = np.linalg.norm(found - values) / np.linalg.norm(values)
    assert rounding_error_rel(words, peaks, step) == pytest.approx(true, rel=0.03)


def test_coefficients_that_are_no_numbers_are_refused() -> None:
    with pytest.raises(ValueError, match="finite"):
        quantise([[np.nan, 0.0, 0.0]])


def test_X4_so_many_products_fit_into_32_bits_and_one_more_does_not() -> None:
    largest = max(BOUNDS) * LIGHT_BOUND
    assert SAFE_PRODUCTS * largest < 2**31 <= (SAFE_PRODUCTS + 1) * largest


def sky(edge: int = 64) -> np.ndarray:
    """A smooth sky of mean 1.1 with clouds."""
    rng = np.random.default_rng(4)
    coarse = np.repeat(np.repeat(rng.random((6, edge // 8, edge // 8, 3)), 8, 1), 8, 2)
    radiance = coarse + 0.2 * rng.random((6, edge, edge, 3))
    return radiance * 1.1 / radiance.mean()


def test_light_without_a_threshold_errs_by_half_a_quantum() -> None:
    radiance = sky()
    light = encode_light(radiance, threshold=0)
    error = cube_of_coefficients(light.coefficients) - radiance
    assert np.sqrt((error**2).mean()) <= 0.5 * light.quantum
    assert light.rmse_rel == pytest.approx(np.linalg.norm(error) / np.linalg.norm(radiance), rel=1e-9)
    assert light.kept <= 6 * 64 * 64


def test_a_higher_threshold_keeps_less_and_errs_more() -> None:
    lights = [encode_light(sky(), threshold) for threshold in (0, 32, 1024, 8192)]
    assert np.all(np.diff([light.kept for light in lights]) < 0)
    assert np.all(np.diff([light.rmse_rel for light in lights]) > 0)
    assert lights[0].energy_error_rel < 1e-5 < lights[-1].energy_error_rel


@pytest.mark.parametrize("sun", [0.0, 1e3, 1e4, 1e6])
def test_X6_the_flux_of_every_face_is_kept_whatever_shines(sun: float) -> None:
    radiance = sky()
    radiance[2, 20, 30] += sun
    light = encode_light(radiance, threshold=1024)
    found = cube_of_coefficients(light.coefficients)
    np.testing.assert_allclose(found.sum(axis=(1, 2)), radiance.sum(axis=(1, 2)), rtol=1e-12)
    assert np.isfinite([light.rmse_rel, light.energy_error_rel]).all()


def test_a_constant_light_has_scaling_coefficients_alone() -> None:
    light = encode_light(np.full((6, 16, 16, 3), 0.7))
    assert (light.quantum, light.kept, light.rmse_rel) == (0.0, 6, 0.0)
    np.testing.assert_array_equal(light.scaling, np.full((6, 3), 0.7 * 16))


def test_darkness_is_a_light() -> None:
    light = encode_light(np.zeros((6, 16, 16, 3)))
    assert (light.kept, light.rmse_rel, light.energy_error_rel) == (0, 0.0, 0.0)


def test_a_given_quantum_keeps_codes_comparable() -> None:
    first = encode_light(sky(), threshold=0)
    second = encode_light(2.0 * sky(), threshold=0, quantum=first.quantum)
    assert second.quantum == first.quantum
    assert np.abs(second.quantised.astype(int)).max() == LIGHT_BOUND


@pytest.mark.parametrize(
    ("radiance", "threshold", "message"),
    [
        (np.zeros((6, 128, 128, 3)), 0, "16-bit"),
        (np.zeros((6, 48, 48, 3)), 0, "power of two"),
        (np.zeros((5, 16, 16, 3)), 0, "six square"),
        (np.full((6, 16, 16, 3), np.inf), 0, "finite"),
        (np.zeros((6, 16, 16, 3)), 32768, "threshold"),
        (np.zeros((6, 16, 16, 3)), -1, "threshold"),
    ],
)
def test_light_that_cannot_be_is_refused(radiance: np.ndarray, threshold: int, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        encode_light(radiance, threshold)

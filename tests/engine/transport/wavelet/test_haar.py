"""The Haar transform of cube faces and the choice of coefficients, against PyWavelets and against laws."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import pywt
from hypothesis import given
from hypothesis import strategies as st

from engine.transport.wavelet.haar import (
    EDGES,
    check_edge,
    cube_coefficients,
    cube_of_coefficients,
    haar,
    inverse_haar,
    places,
    strongest,
)
from tests.threads import threads


def random(*shape: int, seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(shape)


def by_pywavelets(image: np.ndarray) -> np.ndarray:
    """The same square of coefficients; PyWavelets calls its details by other names and signs agree."""
    coefficients = pywt.wavedec2(image, "haar", mode="periodization")
    square = np.zeros_like(image)
    square[:1, :1] = coefficients[0]
    for down, across, both in coefficients[1:]:
        size = len(down)
        square[:size, size : 2 * size] = across
        square[size : 2 * size, :size] = down
        square[size : 2 * size, size : 2 * size] = both
    return square


@pytest.mark.parametrize("edge", [1, *EDGES, 128])
def test_coefficients_are_those_of_pywavelets(edge: int) -> None:
    image = random(edge, edge)
    np.testing.assert_allclose(haar(image), by_pywavelets(image), atol=1e-13)


def test_Z1_integers_are_exact_while_their_bits_fit() -> None:
    rng = np.random.default_rng(2)
    small = rng.integers(0, 2**12, (6, 64, 64))
    back = inverse_haar(haar(small.astype(np.float32)))
    assert np.array_equal(back, small)
    assert np.array_equal(haar(small.astype(np.float32)), haar(small.astype(np.float64)))
    large = rng.integers(0, 2**16, (6, 64, 64))
    assert not np.array_equal(haar(large.astype(np.float32)), haar(large.astype(np.float64)))
    assert np.array_equal(inverse_haar(haar(large.astype(np.float64))), large)


@pytest.mark.parametrize(("kind", "bound"), [(np.float64, 1e-15), (np.float32, 5e-8)])
def test_Z2_energy_is_kept(kind: type, bound: float) -> None:
    image: Any = random(6, 64, 64).astype(kind)
    energy = (image.astype(np.float64) ** 2).sum()
    assert abs((haar(image).astype(np.float64) ** 2).sum() / energy - 1.0) <= bound


def test_Z2_back_again() -> None:
    image = random(3, 6, 32, 32)
    np.testing.assert_allclose(inverse_haar(haar(image)), image, atol=1e-14)


@pytest.mark.parametrize("shape", [(6, 6), (3, 64, 32), (64,), (0, 0), (2, 48, 48)])
def test_Z3_other_shapes_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="Haar transform needs"):
        haar(np.zeros(shape))


def test_the_scaling_coefficient_is_the_sum_over_the_edge() -> None:
    image = random(6, 16, 16)
    np.testing.assert_allclose(haar(image)[:, 0, 0], image.sum(axis=(1, 2)) / 16.0, atol=1e-14)
    np.testing.assert_allclose(cube_coefficients(image[..., None])[:6, 0], image.sum(axis=(1, 2)) / 16.0, atol=1e-14)


def test_results_do_not_depend_on_the_number_of_threads() -> None:
    image = random(24, 64, 64)
    with threads(2):
        together = haar(image)
    with threads(1):
        assert np.array_equal(haar(image), together)


@pytest.mark.parametrize("edge", EDGES)
def test_indices_number_every_coefficient_once_from_coarse_to_fine(edge: int) -> None:
    order = places(edge)
    assert np.array_equal(np.sort(order), np.arange(6 * edge * edge))
    row, column = order // edge % edge, order % edge
    level = np.ceil(np.log2(np.maximum(row, column) + 1))
    assert (np.diff(level) >= 0).all()
    assert (order[:6] == np.arange(6) * edge * edge).all()


def test_a_cube_map_goes_to_coefficients_and_back() -> None:
    radiance = random(6, 32, 32, 3)
    coefficients = cube_coefficients(radiance)
    assert coefficients.shape == (6 * 32 * 32, 3)
    np.testing.assert_allclose(cube_of_coefficients(coefficients), radiance, atol=1e-13)
    np.testing.assert_allclose((coefficients**2).sum(), (radiance**2).sum(), rtol=1e-13)


@pytest.mark.parametrize("edge", [1, 3, 48, 96, 104, 105, 128, 256, 0, -2])
def test_X5_edges_that_indices_or_wavelets_cannot_have_are_refused(edge: int) -> None:
    with pytest.raises(ValueError, match="16-bit" if edge > 104 else "power of two"):
        check_edge(edge)


def test_X5_the_bound_is_where_the_indices_end() -> None:
    assert 6 * 104**2 - 1 <= np.iinfo(np.uint16).max < 6 * 105**2 - 1


def test_Z4_ties_go_to_the_lower_index() -> None:
    values = np.ones((1000, 3))
    values[500:] *= -1.0
    assert strongest(values, 96).tolist() == list(range(96))
    mixed = np.zeros((1000, 1))
    mixed[::7] = 2.0
    mixed[3] = 5.0
    assert strongest(mixed, 4).tolist() == [0, 3, 7, 14]


def test_Z5_no_coefficient_all_and_more_than_all() -> None:
    values = random(40, 3)
    assert strongest(values, 0).tolist() == []
    assert strongest(values, 40).tolist() == list(range(40))
    assert strongest(values, 1000).tolist() == list(range(40))
    with pytest.raises(ValueError, match="not negative"):
        strongest(values, -1)


def test_Z6_the_error_is_what_was_dropped_and_no_choice_drops_less() -> None:
    coefficients = cube_coefficients(random(6, 16, 16, 3))
    kept = strongest(coefficients, 96)
    cut = np.zeros_like(coefficients)
    cut[kept] = coefficients[kept]
    error = ((cube_of_coefficients(cut) - cube_of_coefficients(coefficients)) ** 2).sum()
    squared = (coefficients**2).sum(axis=1)
    assert error == pytest.approx(np.sort(squared)[:-96].sum(), rel=1e-12)


def test_Z7_of_nothing_nothing_is_kept() -> None:
    assert strongest(np.zeros((24, 3)), 10).tolist() == []


def test_Z8_a_single_spike_is_kept_alone() -> None:
    values = np.zeros((6 * 64 * 64, 3))
    values[24_575, 2] = -1e-30
    assert strongest(values, 96).tolist() == [24_575]


@given(
    st.lists(st.integers(0, 6), min_size=1, max_size=60),
    st.integers(0, 70),
)
def test_the_choice_is_that_of_a_stable_sort(values: list[int], count: int) -> None:
    column = np.array(values, np.float64)[:, None]
    order = np.argsort(-(column[:, 0] ** 2), kind="stable")[:count]
    expected = sorted(index for index in order if values[index])
    assert strongest(column, count).tolist() == expected

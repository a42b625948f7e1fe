"""Spherical harmonics: the basis against pyshtools and its laws, discs and cosines in closed form, windows."""

from __future__ import annotations

import math
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.transport.sh.basis import (
    apply_window,
    bands,
    cosine_zonal,
    disc_zonal,
    evaluate,
    integral,
    order_of,
    turn_zonal,
    window,
)


def sphere(order: int) -> tuple[np.ndarray, np.ndarray]:
    """Directions (N, 3) and weights of a quadrature that is exact for products of two functions of `order`."""
    z, weight = np.polynomial.legendre.leggauss(order)
    phi = np.arange(2 * order) * np.pi / order
    across = np.sqrt(1 - z * z)[:, None]
    points = np.stack([across * np.cos(phi), across * np.sin(phi), z[:, None] + 0 * phi], axis=-1)
    return points.reshape(-1, 3), np.repeat(weight, 2 * order) * np.pi / order


def random_directions(count: int, seed: int = 0) -> np.ndarray:
    direction = np.random.default_rng(seed).normal(size=(count, 3))
    return direction / np.linalg.norm(direction, axis=1, keepdims=True)


def test_band_one_is_y_z_x() -> None:
    direction = random_directions(20)
    expected = math.sqrt(3 / (4 * math.pi)) * direction[:, [1, 2, 0]]
    np.testing.assert_allclose(evaluate(2, direction)[:, 1:], expected, atol=1e-15)


def test_the_basis_is_that_of_pyshtools() -> None:
    spharm = pytest.importorskip("pyshtools").expand.spharm
    order = 20
    direction = random_directions(30)
    theta, phi = np.degrees(np.arccos(direction[:, 2])), np.degrees(np.arctan2(direction[:, 1], direction[:, 0]))
    for values, t, p in zip(evaluate(order, direction), theta, phi, strict=True):
        oracle = spharm(order - 1, t, p, normalization="ortho", csphase=1, kind="real", degrees=True)
        for degree in range(order):
            cosines, sines = oracle[0, degree, : degree + 1], oracle[1, degree, 1 : degree + 1]
            expected = np.concatenate([sines[::-1], cosines])
            np.testing.assert_allclose(values[degree**2 : (degree + 1) ** 2], expected, atol=2e-12)


@pytest.mark.parametrize("order", [5, 15, 30, 60])
def test_H1_H3_the_basis_is_orthonormal(order: int) -> None:
    direction, weight = sphere(order)
    values = evaluate(order, direction)
    chosen = np.random.default_rng(0).permutation(order**2)[:225]  # at order 60 all pairs take too long
    np.testing.assert_allclose(
        (values[:, chosen] * weight[:, None]).T @ values, np.eye(order**2)[chosen], atol=2e-14 * order
    )


@pytest.mark.parametrize("order", [5, 15])
@pytest.mark.parametrize(
    "direction", [(0, 0, 1), (0, 0, -1), (1e-9, 0, 1), (1e-300, 1e-300, -1), (0, 1, 0), (0.6, 0, 0.8)]
)
def test_H2_addition_theorem_holds_at_the_poles(order: int, direction: Any) -> None:
    values = evaluate(order, direction)
    assert np.isfinite(values).all()
    assert (values**2).sum() == pytest.approx(order**2 / (4 * math.pi), abs=2e-14)


def test_H2_addition_theorem_holds_everywhere() -> None:
    """Elsewhere the rounding of the unit vectors counts as well, once for each degree."""
    np.testing.assert_allclose((evaluate(15, random_directions(1000)) ** 2).sum(axis=1), 225 / (4 * np.pi), rtol=1e-13)


@pytest.mark.parametrize("z", [1.0, -1.0])
def test_H2_at_the_poles_only_zonal_functions_are_left(z: float) -> None:
    values = evaluate(60, (0.0, 0.0, z))
    band = bands(60)
    zonal = np.arange(60) * (np.arange(60) + 1)
    np.testing.assert_array_equal(np.delete(values, zonal), 0.0)
    np.testing.assert_allclose(
        values[zonal], np.sqrt((2 * np.arange(60) + 1) / (4 * np.pi)) * z ** np.arange(60), rtol=1e-13
    )
    assert band[zonal].tolist() == list(range(60))


@given(st.floats(1e-150, 1e150))
@settings(max_examples=25)
def test_H4_lengths_of_directions_do_not_matter(length: Any) -> None:
    direction = np.array([0.36, -0.48, 0.8])
    np.testing.assert_allclose(evaluate(8, length * direction), evaluate(8, direction), atol=1e-13)


@pytest.mark.parametrize("direction", [(0, 0, 0), (math.nan, 0, 1), (math.inf, 0, 0), (1, 2)])
def test_H4_no_direction_is_refused(direction: Any) -> None:
    with pytest.raises(ValueError, match="direction"):
        evaluate(5, direction)


@pytest.mark.parametrize("order", [0, -1, 65])
def test_orders_out_of_reach_are_refused(order: int) -> None:
    with pytest.raises(ValueError, match="outside 1 … 64"):
        evaluate(order, (0, 0, 1))


def test_no_directions_give_no_values() -> None:
    assert evaluate(5, np.zeros((0, 3))).shape == (0, 25)


@pytest.mark.parametrize(
    ("kind", "lowest", "peak"), [("none", -0.152, 1.0), ("hanning", -0.038, 0.41), ("lanczos", -0.056, 0.53)]
)
def test_H9_ringing_of_a_delta_under_windows(kind: Any, lowest: float, peak: float) -> None:
    theta = np.linspace(0, math.pi, 20_001)
    profile = evaluate(5, np.stack([np.sin(theta), 0 * theta, np.cos(theta)], axis=-1))
    delta = turn_zonal(disc_zonal(5, 0.0), (0.0, 0.0, 1.0))
    ringing = profile @ apply_window(delta, kind)
    assert ringing.min() / ringing[0] == pytest.approx(lowest, abs=1e-3)
    assert ringing[0] / (profile[0] @ delta) == pytest.approx(peak, abs=5e-3)


def test_H9_windows_leave_the_mean_untouched() -> None:
    coefficients = np.random.default_rng(0).normal(size=(49, 3))
    for kind in ("none", "hanning", "lanczos"):
        weights = window(7, kind)
        assert weights[0] == 1.0
        assert (np.diff(weights) <= 0).all()
        np.testing.assert_array_equal(apply_window(coefficients, kind)[0], coefficients[0])
    with pytest.raises(ValueError, match="choose from none, hanning, lanczos"):
        window(5, cast(Any, "hamming"))


def test_H9_clamped_cosine_at_order_five() -> None:
    theta = np.linspace(0, math.pi, 20_001)
    profile = evaluate(5, np.stack([np.sin(theta), 0 * theta, np.cos(theta)], axis=-1))
    zonal = cosine_zonal(5)
    cosine = profile @ turn_zonal(zonal, (0.0, 0.0, 1.0))
    assert cosine.min() == pytest.approx(-0.031, abs=1e-3)
    assert np.abs(cosine - np.maximum(np.cos(theta), 0)).max() == pytest.approx(0.059, abs=1e-3)
    assert (zonal**2).sum() / (2 * math.pi / 3) == pytest.approx(0.9980, abs=1e-4)


def test_H9_hemisphere_over_and_undershoots() -> None:
    """Half the sphere is a disc of radius 90 degrees; what Gibbs adds at order 5 is 0.114 at either end."""
    theta = np.linspace(0, math.pi, 20_001)
    profile = evaluate(5, np.stack([np.sin(theta), 0 * theta, np.cos(theta)], axis=-1))
    step = profile @ turn_zonal(disc_zonal(5, math.pi / 2) * math.pi, (0.0, 0.0, 1.0))
    assert step.min() == pytest.approx(-0.114, abs=1e-3)
    assert step.max() == pytest.approx(1.114, abs=1e-3)


@pytest.mark.parametrize("radius", [1e-9, 1e-4, 0.00465, 0.1, 0.7, math.pi / 2])
def test_discs_are_integrals_over_their_cap(radius: float) -> None:
    """Gauss's rule in the cosine over the cap, which is exact for polynomials; half chords keep tiny caps exact."""
    node, share = np.polynomial.legendre.leggauss(20)
    depth = 2 * math.sin(radius / 2) ** 2  # 1 - cos(radius)
    down = depth * (node + 1) / 2
    direction = np.stack([np.sqrt(down * (2 - down)), 0 * down, 1 - down], axis=-1)
    zonal = evaluate(30, direction)[:, np.arange(30) * (np.arange(30) + 1)]
    expected = 2 * np.pi * (share * depth / 2) @ zonal / (np.pi * math.sin(radius) ** 2)
    np.testing.assert_allclose(disc_zonal(30, radius), expected, rtol=2e-12, atol=2e-13)


def test_a_disc_of_no_radius_is_a_direction() -> None:
    np.testing.assert_allclose(disc_zonal(30, 0.0), np.sqrt((2 * np.arange(30) + 1) / (4 * np.pi)), rtol=1e-14)
    direction = random_directions(5)
    np.testing.assert_allclose(turn_zonal(disc_zonal(30, 0.0), direction), evaluate(30, direction), atol=1e-13)


@pytest.mark.parametrize("radius", [-0.1, 1.6, math.nan])
def test_impossible_discs_are_refused(radius: float) -> None:
    with pytest.raises(ValueError, match="not between 0 and 90"):
        disc_zonal(5, radius)


def test_cosines_are_integrals_over_the_hemisphere() -> None:
    node, share = np.polynomial.legendre.leggauss(40)
    z = (node + 1) / 2
    direction = np.stack([np.sqrt(1 - z * z), 0 * z, z], axis=-1)
    zonal = evaluate(30, direction)[:, np.arange(30) * (np.arange(30) + 1)]
    np.testing.assert_allclose(cosine_zonal(30), 2 * np.pi * (share / 2 * z) @ zonal, atol=5e-14)
    for order in range(1, 6):
        np.testing.assert_array_equal(cosine_zonal(order), cosine_zonal(30)[:order])


def test_H10_constant_light_on_a_white_diffuse_surface_is_one() -> None:
    constant = np.zeros((25, 3))
    constant[0] = math.sqrt(4 * math.pi)
    radiance = turn_zonal(cosine_zonal(5), random_directions(50)) @ constant / math.pi
    np.testing.assert_allclose(radiance, 1.0, atol=1e-12)


def test_H12_orders_that_differ_are_refused() -> None:
    with pytest.raises(ValueError, match="order 5 and 4 do not belong together"):
        integral(np.ones(25), np.ones((16, 3)))
    for count in (0, 2, 24, 65**2):
        with pytest.raises(ValueError, match="order"):
            order_of(count)
    a, b = np.random.default_rng(0).normal(size=(2, 25, 3))
    np.testing.assert_allclose(integral(a, b), a.T @ b, rtol=1e-13)

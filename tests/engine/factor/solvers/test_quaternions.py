"""Quaternion pairs: powers near ±1 against mpmath, the group laws, signs and matrices."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from engine.factor.solvers.quaternions import (
    BASIS,
    IDENTITY,
    ONE,
    Pair,
    canonical,
    compose,
    conjugate,
    inverse,
    matrix,
    multiply,
    pair_of_rows,
    polar,
    power,
    raise_error,
    random_pair,
    tangent,
    unit,
)

U = 2.0**-53


def exact_power(q: np.ndarray, exponent: float) -> np.ndarray:
    """q^t with 50 digits, from the float64 parts."""
    with mpmath.workdps(50):
        w, *v = (mpmath.mpf(float(part)) for part in q)
        length = mpmath.sqrt(sum(part * part for part in v))
        angle = mpmath.atan2(length, w)
        parts = [mpmath.cos(exponent * angle), *(mpmath.sin(exponent * angle) * part / length for part in v)]
        return np.array([float(part) for part in parts])


@pytest.mark.parametrize("d", [1e-300, 1e-160, 1e-10, 1e-5, 0.3, 1.5])
@pytest.mark.parametrize("exponent", [0.5, 1.0, -1.0, 1.7])
def test_Q1_powers_near_one_keep_their_digits(d: float, exponent: float) -> None:
    q = np.array([np.cos(d), 0.6 * np.sin(d), 0.0, -0.8 * np.sin(d)])
    np.testing.assert_allclose(power(q, exponent), exact_power(q, exponent), rtol=0.0, atol=4.0 * U)
    if d < 1e-4:
        np.testing.assert_allclose(power(q, exponent)[1:], exact_power(q, exponent)[1:], rtol=8.0 * U, atol=0.0)


@pytest.mark.parametrize("d", [1e-12, 1e-10, 1e-8, 1e-3])
def test_Q2_powers_near_minus_one_keep_their_digits(d: float) -> None:
    q = np.array([-np.cos(d), np.sin(d), 0.0, 0.0])
    for exponent in (0.5, 1.0, 0.25):
        np.testing.assert_allclose(power(q, exponent), exact_power(q, exponent), rtol=0.0, atol=4.0 * U)


def test_Q3_minus_one_takes_the_first_axis_and_says_so() -> None:
    found = polar(-ONE)
    assert found.conventional
    assert found.angle == np.pi
    np.testing.assert_array_equal(found.axis, [1.0, 0.0, 0.0])
    np.testing.assert_allclose(power(-ONE, 0.5), [0.0, 1.0, 0.0, 0.0], atol=4.0 * U)
    assert polar(ONE).conventional
    assert polar(ONE).angle == 0.0
    assert not polar(np.array([-1.0, 1e-200, 0.0, 0.0])).conventional


def test_X15_Q4_only_both_signs_together_leave_the_rotation() -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        pair = random_pair(rng)
        both, one = Pair(-pair.s, -pair.t), Pair(-pair.s, pair.t)
        np.testing.assert_array_equal(matrix(both), matrix(pair))
        np.testing.assert_array_equal(matrix(one), -matrix(pair))
        for first, second in zip(canonical(both), canonical(pair), strict=True):
            np.testing.assert_array_equal(first, second)
        np.testing.assert_array_equal(matrix(canonical(one)), -matrix(pair))


def test_Q5_a_million_compositions_do_not_drift() -> None:
    pair, turn = random_pair(np.random.default_rng(1)), random_pair(np.random.default_rng(2))
    block = turn
    for _ in range(1000):
        pair = compose(turn, pair)
    for _ in range(999):
        block = compose(turn, block)
    for _ in range(999):
        pair = compose(block, pair)
    for side in pair:
        assert abs(np.linalg.norm(side) - 1.0) <= 1e-12
    turned = matrix(pair)
    assert np.abs(turned @ turned.T - np.eye(4)).max() <= 1e-13
    assert abs(np.linalg.det(turned) - 1.0) <= 1e-13


def test_Q5_renormalising_is_what_holds_the_length() -> None:
    q = unit(np.array([0.3, 0.5, -0.2, 0.7])) * (1.0 + 1e-3)
    assert np.linalg.norm(multiply(q, q)) > 1.0 + 1e-3
    assert abs(np.linalg.norm(compose(Pair(q, ONE), Pair(q, ONE)).s) - 1.0) <= 2.0 * U


def test_Q6_powers_of_one_rotation_add_up() -> None:
    rng = np.random.default_rng(3)
    for _ in range(200):
        pair = random_pair(rng)
        a, b = rng.uniform(-3.0, 3.0, 2)
        difference = matrix(compose(raise_error(pair, a), raise_error(pair, b))) - matrix(raise_error(pair, a + b))
        assert np.abs(difference).max() <= 1e-14 * (1.0 + abs(a + b))


def test_products_are_hamiltons() -> None:
    _, i, j, k = np.eye(4)
    np.testing.assert_array_equal(multiply(i, j), k)
    np.testing.assert_array_equal(multiply(j, i), -k)
    np.testing.assert_array_equal(multiply(i, i), -ONE)
    np.testing.assert_array_equal(conjugate(i), -i)


def test_composition_and_inverse_are_those_of_matrices() -> None:
    rng = np.random.default_rng(4)
    a, b = random_pair(rng), random_pair(rng)
    np.testing.assert_allclose(matrix(compose(a, b)), matrix(a) @ matrix(b), atol=1e-15)
    np.testing.assert_allclose(matrix(inverse(a)), matrix(a).T, atol=1e-15)
    np.testing.assert_array_equal(matrix(IDENTITY), np.eye(4))


def test_the_six_directions_span_all_movements_and_square_to_minus_one() -> None:
    assert abs(np.linalg.det(np.stack([tangent(direction) for direction in BASIS]))) == 1.0
    for direction in BASIS:
        np.testing.assert_allclose(matrix(raise_error(direction, 2.0)), -np.eye(4), atol=4.0 * U)


def test_a_pair_is_found_for_any_two_rows() -> None:
    rng = np.random.default_rng(5)
    rows = [matrix(random_pair(rng))[:, :2].T for _ in range(200)]
    rows += [
        np.eye(4)[[a, b]] * [[p], [q]] for a in range(4) for b in range(4) if a != b for p in (1, -1) for q in (1, -1)
    ]
    for wanted in rows:
        np.testing.assert_allclose(matrix(pair_of_rows(wanted))[:, :2].T, wanted, atol=1e-14)


def test_nothing_has_no_direction() -> None:
    for bad in (np.zeros(4), np.full(4, np.nan)):
        with pytest.raises(ValueError, match="not a direction"):
            unit(bad)
    np.testing.assert_array_equal(tangent(IDENTITY), np.zeros(6))

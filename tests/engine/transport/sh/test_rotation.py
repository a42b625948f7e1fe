"""Rotation of spherical harmonics: its laws, the traps of Euler angles, and the counterpart that turns many at once."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from engine.core.directions import world_from_tangent
from engine.transport.sh.basis import evaluate
from engine.transport.sh.rotation import (
    nearest_rotation,
    rotate,
    rotate_from_frames,
    rotate_into_frames,
    rotation,
    swap,
)
from tests.engine.transport.sh.test_basis import random_directions

ANGLES = [0.0, 1e-300, 1e-16, 1e-12, 1e-9, 1e-6, 1e-3, 0.5, np.pi / 2, 3.0, np.pi - 1e-9, np.pi, -1e-9, -1.0]

unit_angles = st.floats(-np.pi, np.pi)


def euler(alpha: float, beta: float, gamma: float) -> np.ndarray:
    """Rz(alpha) Ry(beta) Rz(gamma)."""

    def z(angle: float) -> np.ndarray:
        return np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]])

    y = np.array([[np.cos(beta), 0, np.sin(beta)], [0, 1, 0], [-np.sin(beta), 0, np.cos(beta)]])
    return z(alpha) @ y @ z(gamma)


@pytest.mark.parametrize("beta", ANGLES)
@pytest.mark.parametrize(("alpha", "gamma"), [(0.0, 0.0), (1.1, -2.3), (np.pi, 0.4)])
def test_X10_H5_rotated_functions_are_exact_for_every_angle(beta: Any, alpha: float, gamma: float) -> None:
    """The strongest predicate: the rotated coefficients give f(R^-1 s) everywhere."""
    matrix = euler(alpha, beta, gamma)
    rotated = rotation(6, matrix)
    direction = random_directions(40)
    np.testing.assert_allclose(evaluate(6, direction) @ rotated, evaluate(6, direction @ matrix), atol=5e-15)
    np.testing.assert_allclose(rotated @ rotated.T, np.eye(36), atol=1e-13)


@pytest.mark.parametrize("order", [5, 15])
def test_H5_rotations_multiply(order: int) -> None:
    for first, second in Rotation.random(20, random_state=0).as_matrix().reshape(10, 2, 3, 3):
        product = rotation(order, first) @ rotation(order, second)
        np.testing.assert_allclose(rotation(order, first @ second), product, atol=1e-13)


def test_H5_nothing_leaves_its_band() -> None:
    matrix = rotation(8, Rotation.random(random_state=3).as_matrix())
    band = np.repeat(np.arange(8), 2 * np.arange(8) + 1)
    assert (matrix[band[:, None] != band] == 0.0).all()
    assert matrix[0, 0] == 1.0


def test_H6_the_identity_is_exact() -> None:
    np.testing.assert_array_equal(rotation(15, np.eye(3)), np.eye(225))
    coefficients = np.random.default_rng(0).normal(size=(225, 3))
    np.testing.assert_array_equal(rotate(coefficients, np.eye(3)), coefficients)


def test_H7_what_is_no_rotation_is_refused() -> None:
    with pytest.raises(ValueError, match="reflection"):
        rotation(5, np.diag([1.0, 1.0, -1.0]))
    with pytest.raises(ValueError, match="singular"):
        rotation(5, np.zeros((3, 3)))
    with pytest.raises(ValueError, match="finite"):
        rotation(5, np.full((3, 3), np.nan))
    with pytest.raises(ValueError, match=r"differs by 0\.17.* nearest rotation"):
        rotation(5, 1.1 * np.eye(3))


def test_H7_the_nearest_rotation_and_its_distance() -> None:
    matrix = euler(0.3, 1.0, -0.7)
    skewed = matrix + 1e-3 * np.random.default_rng(0).normal(size=(3, 3))
    nearest, distance = nearest_rotation(skewed)
    np.testing.assert_allclose(nearest @ nearest.T, np.eye(3), atol=1e-15)
    assert distance == pytest.approx(np.linalg.norm(nearest - skewed))
    assert 1e-4 < distance < 5e-3
    assert distance <= np.linalg.norm(matrix - skewed)


def test_H7_float32_rotations_are_near_enough() -> None:
    matrix = euler(0.3, 1.0, -0.7).astype(np.float32)
    np.testing.assert_allclose(rotation(5, matrix), rotation(5, euler(0.3, 1.0, -0.7)), atol=2e-6)


def test_H8_energy_of_each_band_is_kept() -> None:
    coefficients = np.random.default_rng(0).normal(size=225)
    rotated = rotate(coefficients, Rotation.random(random_state=5).as_matrix())
    for degree in range(15):
        band = slice(degree**2, (degree + 1) ** 2)
        np.testing.assert_allclose((rotated[band] ** 2).sum(), (coefficients[band] ** 2).sum(), rtol=1e-14)


@given(unit_angles, st.floats(0, np.pi), unit_angles)
@settings(max_examples=20)
def test_rotations_are_those_of_pyshtools(alpha: Any, beta: Any, gamma: Any) -> None:
    """pyshtools turns the body by alpha about z, then beta about the new y, then gamma about the new z."""
    pyshtools = pytest.importorskip("pyshtools")
    order = 8
    coefficients = np.random.default_rng(0).normal(size=order**2)
    cilm = np.zeros((2, order, order))
    for i, value in enumerate(coefficients):
        degree = int(np.sqrt(i))
        m = i - degree * (degree + 1)
        cilm[int(m < 0), degree, abs(m)] = value
    given_ = pyshtools.SHCoeffs.from_array(cilm, normalization="ortho", csphase=1)
    rotated = given_.rotate(alpha, beta, gamma, degrees=False, convention="y", body=True).coeffs
    mine = rotate(coefficients, euler(alpha, beta, gamma))
    for i, value in enumerate(mine):
        degree = int(np.sqrt(i))
        m = i - degree * (degree + 1)
        assert value == pytest.approx(rotated[int(m < 0), degree, abs(m)], abs=1e-9)


def test_the_swap_changes_y_and_z() -> None:
    direction = random_directions(30)
    for degree in (0, 1, 4, 9, 20):
        band = slice(degree**2, (degree + 1) ** 2)
        here, there = (evaluate(degree + 1, d)[:, band] for d in (direction, direction[:, [0, 2, 1]]))
        np.testing.assert_allclose(here @ swap(degree), there, atol=2e-13)
        np.testing.assert_allclose(swap(degree) @ swap(degree), np.eye(2 * degree + 1), atol=1e-14)


def frames() -> np.ndarray:
    """Stereographic frames of normals all around, and both poles of the world, where Euler angles run out."""
    poles = [(0, 0, 1), (0, 0, -1), (0, 1, 0), (0, -1, 0), (1e-9, 0, 1), (0, 1e-200, -1)]
    normal = np.concatenate([random_directions(64), np.array(poles, float)])
    return world_from_tangent(normal)


@pytest.mark.parametrize(("dtype", "close"), [(np.float64, 1e-13), (np.float32, 2e-5)])
@pytest.mark.parametrize("order", [1, 5, 9])
def test_many_frames_at_once_are_like_one_after_the_other(order: int, dtype: Any, close: float) -> None:
    coefficients = np.random.default_rng(0).normal(size=(order**2, 3))
    local = rotate_into_frames(coefficients.astype(dtype), frames().astype(dtype))
    assert local.dtype == dtype
    expected = [rotate(coefficients, frame.T) for frame in frames()]
    np.testing.assert_allclose(local, expected, atol=close)
    back = rotate_from_frames(local, frames().astype(dtype))
    np.testing.assert_allclose(back, np.broadcast_to(coefficients, back.shape), atol=close)


def test_light_in_a_frame_is_the_light_seen_from_it() -> None:
    coefficients = np.random.default_rng(1).normal(size=(25, 3))
    local = rotate_into_frames(coefficients, frames())
    wi = random_directions(len(frames()), 7)  # in each frame
    world = np.einsum("nij,nj->ni", frames(), wi)
    seen = np.einsum("ni,nic->nc", evaluate(5, wi), local)
    np.testing.assert_allclose(seen, evaluate(5, world) @ coefficients, atol=1e-13)


def test_columns_of_matrices_are_rotated_alike() -> None:
    matrices = np.random.default_rng(2).normal(size=(len(frames()), 16, 16))
    local = rotate_into_frames(matrices, frames())
    for frame, matrix, rotated in zip(frames(), matrices, local, strict=True):
        np.testing.assert_allclose(rotated, rotation(4, frame.T) @ matrix, atol=1e-13)


def test_no_frames_and_wrong_shapes() -> None:
    assert rotate_into_frames(np.ones((25, 3)), np.zeros((0, 3, 3))).shape == (0, 25, 3)
    with pytest.raises(ValueError, match="do not fit"):
        rotate_into_frames(np.ones((7, 25, 3)), frames())
    with pytest.raises(ValueError, match="no order"):
        rotate_into_frames(np.ones((24, 3)), frames())

"""Half and difference angles: mpmath as oracle, both frames at both singularities, there and back, exchange."""

from __future__ import annotations

from collections.abc import Callable
from typing import get_args

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

from engine.brdf.half_difference import (
    Frame,
    classical_frame,
    cole_frame,
    directions,
    half_difference,
    half_vector,
    polar,
)
from engine.core.directions import dot, surface_direction

U = np.finfo(np.float64).eps / 2
FrameOf = Callable[[NDArray[np.float64]], tuple[NDArray[np.float64], NDArray[np.float64]]]
FRAMES = get_args(Frame)


def random_directions(count: int, seed: int = 0) -> NDArray[np.float64]:
    """Uniform over the upper hemisphere."""
    random = np.random.default_rng(seed)
    z = 1.0 - random.random(count)
    phi = 2.0 * np.pi * random.random(count)
    radius = np.sqrt(1.0 - z * z)
    return np.stack([radius * np.cos(phi), radius * np.sin(phi), z], axis=-1)


def test_M1_theta_h_agrees_with_mpmath_down_to_a_microradian() -> None:
    theta = np.geomspace(1e-6, np.pi / 2, 400)
    vectors = surface_direction(theta, np.linspace(0, 6, 400))
    found = polar(vectors)[0]
    with mpmath.workdps(40):
        for vector, value in zip(vectors, found, strict=True):
            x, y, z = map(mpmath.mpf, map(float, vector))
            exact = mpmath.atan2(mpmath.sqrt(x * x + y * y), z)
            assert abs(mpmath.mpf(float(value)) / exact - 1) <= 4 * U


def test_M1_an_arc_cosine_in_float32_would_take_other_bins() -> None:
    theta = np.linspace(1e-4, 0.02, 20_000)
    half = surface_direction(theta, 1.0)
    bins = np.floor(np.sqrt(theta / (np.pi / 2) * 8100))
    found = np.floor(np.sqrt(polar(half)[0] / (np.pi / 2) * 8100))
    trap = np.floor(np.sqrt(np.arccos(half[:, 2].astype(np.float32)) / (np.pi / 2) * 8100))
    edge = np.abs(np.sqrt(theta / (np.pi / 2) * 8100) % 1.0 - 0.5) > 0.5 - 1e-9
    assert np.array_equal(found[~edge], bins[~edge])
    assert np.mean(trap != bins) > 0.002


def test_M2_at_the_normal_phi_h_is_zero() -> None:
    wi = surface_direction(0.7, np.linspace(0, 6, 20))
    wo = wi * (-1.0, -1.0, 1.0)
    angles = half_difference(wi, wo)
    assert np.all(angles.theta_h == 0.0)
    assert np.all(angles.phi_h == 0.0)
    assert angles.theta_d == pytest.approx(np.full(20, 0.7), abs=4e-16)


def test_M3_opposite_directions_have_the_normal_as_half_vector() -> None:
    for tilt in (0.0, 1e-12, 1e-14, 1e-300):
        wi = np.array([1.0, 0.0, tilt])
        wo = np.array([-1.0, 0.0, tilt])
        assert np.array_equal(half_vector(wi, wo), (0.0, 0.0, 1.0))
        angles = half_difference(wi, wo)
        assert np.all(np.isfinite(angles))
        assert angles.theta_d == pytest.approx(np.pi / 2, abs=1e-11)


def test_M4_exchange_turns_the_difference_by_half_a_turn() -> None:
    wi, wo = random_directions(50_000), random_directions(50_000, 1)
    one, other = half_difference(wi, wo), half_difference(wo, wi)
    assert np.array_equal(one.theta_h, other.theta_h)
    assert np.array_equal(one.phi_h, other.phi_h)
    assert np.array_equal(one.theta_d, other.theta_d)
    assert np.abs(np.abs(one.phi_d - other.phi_d) - np.pi).max() <= 4 * np.pi * U


@pytest.mark.parametrize("frame", FRAMES)
def test_M5_directions_and_angles_there_and_back(frame: Frame) -> None:
    random = np.random.default_rng(2)
    count = 50_000
    theta_h = random.uniform(1e-3, np.pi / 2 - 1e-3, count)
    phi_h, phi_d = random.uniform(-3.1, 3.1, (2, count))
    theta_d = random.uniform(1e-3, np.radians(89.9), count)
    found = half_difference(*directions(theta_h, phi_h, theta_d, phi_d, frame), frame)
    conditioning = 1.0 / (np.sin(theta_h) * np.sin(theta_d))
    assert np.abs(found.theta_h - theta_h).max() <= 1e-12
    assert np.abs(found.theta_d - theta_d).max() <= 1e-12
    assert (np.abs(found.phi_h - phi_h) / conditioning).max() <= 1e-12
    assert (np.abs(found.phi_d - phi_d) / conditioning).max() <= 1e-12

    grazing = np.radians(89.9999)
    found = half_difference(*directions(theta_h, phi_h, grazing, phi_d, frame), frame)
    assert np.abs(found.theta_h - theta_h).max() <= 1e-9
    assert np.abs(found.theta_d - grazing).max() <= 1e-9


def test_M5_angles_and_directions_there_and_back() -> None:
    wi, wo = random_directions(50_000, 3), random_directions(50_000, 4)
    for frame in FRAMES:
        back = directions(*half_difference(wi, wo, frame), frame)
        assert np.abs(back[0] - wi).max() <= 1e-12
        assert np.abs(back[1] - wo).max() <= 1e-12


@pytest.mark.parametrize("frame_of", [classical_frame, cole_frame])
@pytest.mark.parametrize("distance", [0.0, 1e-300, 1e-16, 1e-9, 9.9e-7, 1.01e-6, 1e-3])
def test_M6_X13_both_frames_are_orthonormal_at_both_singularities(frame_of: FrameOf, distance: float) -> None:
    axes = [(0, 0, 1), (1, 0, 0), (-1, 0, 0)]
    aside = [(1, 0, 0), (0, 1, 0), (-0.6, 0.8, 0), (0, 0.6, 0.8), (0, 0, 1), (0, -1, 0)]
    halves = np.array([np.array(axis) + distance * np.array(way) for axis in axes for way in aside], np.float64)
    halves /= np.sqrt(dot(halves, halves))[:, None]
    x, y = frame_of(halves)
    matrix = np.stack([x, y, halves], axis=-2)
    gram = matrix @ np.swapaxes(matrix, -1, -2)
    assert np.abs(gram - np.eye(3)).max() <= 4 * U
    assert np.linalg.det(matrix) == pytest.approx(np.ones(len(halves)), abs=8 * U)


def test_X13_the_frames_agree_with_their_printed_formulas_elsewhere() -> None:
    half = random_directions(20_000, 5)
    theta, phi = polar(half)
    wi = random_directions(20_000, 6)
    x, y = classical_frame(half)
    turned = np.stack(
        [np.cos(phi) * wi[:, 0] + np.sin(phi) * wi[:, 1], np.cos(phi) * wi[:, 1] - np.sin(phi) * wi[:, 0]], axis=-1
    )
    assert dot(x, wi) == pytest.approx(np.cos(theta) * turned[:, 0] - np.sin(theta) * wi[:, 2], abs=1e-14)
    assert dot(y, wi) == pytest.approx(turned[:, 1], abs=1e-14)
    printed = np.array([1.0, 0.0, 0.0]) - half[:, :1] * half
    away = np.sqrt(dot(printed, printed)) > 1e-3
    printed = printed[away] / np.sqrt(dot(printed, printed))[away, None]
    assert np.abs(cole_frame(half)[0][away] - printed).max() <= 1e-12


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_X13_coles_frame_is_continuous_along_the_arc_to_the_tangent(sign: float) -> None:
    theta = np.pi / 2 - np.geomspace(1e-9, 1e-3, 200)
    half = np.stack([sign * np.sin(theta), np.zeros(200), np.cos(theta)], axis=-1)
    r, _ = cole_frame(half)
    assert np.abs(r - np.stack([np.cos(theta), np.zeros(200), -sign * np.sin(theta)], axis=-1)).max() <= 1e-9


def test_M6_where_one_frame_is_singular_the_other_is_steady() -> None:
    around = np.linspace(0, 2 * np.pi, 13)
    at_normal = surface_direction(1e-9, around)
    assert np.ptp(cole_frame(at_normal)[0], axis=0).max() <= 1e-8
    assert np.ptp(classical_frame(at_normal)[0], axis=0).max() > 1.0
    at_tangent = np.stack([np.ones(13), 1e-5 * np.cos(around), 1e-5 * np.sin(around)], axis=-1)
    assert np.ptp(classical_frame(at_tangent)[0], axis=0).max() <= 1e-4
    assert np.ptp(cole_frame(at_tangent)[0], axis=0).max() > 1.0

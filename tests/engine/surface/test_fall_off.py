"""Diffuse parts that are not Lambert's: their fall-off, and the normals of surfaces that have it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.fall_off import angle, generate
from engine.core.steps import drain
from engine.surface.fall_off import find_falls
from engine.surface.lamps import lamps
from engine.surface.recover import recover
from engine.surface.reflectance import kinds
from engine.texel.kernel import C_A, C_B, C, evaluate, fall_off, lobes

FALLS = [(0.5, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.6), (0.3, -0.5, 0.4)]


@pytest.mark.parametrize("fall", FALLS)
def test_a_fall_off_is_one_where_the_normal_points_to_lamp_and_viewer(fall: tuple[float, float, float]) -> None:
    assert fall_off(1.0, 1.0, 1.0, np.array(fall))[0] == pytest.approx(1.0)


def test_a_rough_surface_is_that_of_oren_and_nayar() -> None:
    """In the form of Fujii: β over the constant part, towards the lamp and away from it."""
    squared = 0.5**2
    constant, towards = 1.0 - 0.5 * squared / (squared + 0.33), 0.45 * squared / (squared + 0.09)
    for normal_deg, light_deg in ((30.0, 60.0), (30.0, -40.0), (-20.0, 50.0), (10.0, 80.0)):
        normal, light = math.radians(normal_deg), math.radians(light_deg)
        n_l, n_z, l_z = math.cos(light - normal), math.cos(normal), math.cos(light)
        s = l_z - n_l * n_z
        expected = constant + towards * (s / max(n_l, n_z) if s > 0.0 else s)
        fall = np.array([0.0, 0.0, towards / constant])
        assert constant * fall_off(n_l, n_z, l_z, fall)[0] == pytest.approx(expected)


@pytest.mark.parametrize("fall", FALLS)
def test_derivatives_of_the_diffuse_part_are_differences(fall: tuple[float, float, float]) -> None:
    rng = np.random.default_rng(4)
    light = rng.normal(size=(9, 3)) + np.array([0.0, 0.0, 1.5])
    light *= (0.8 / np.linalg.norm(light, axis=1))[:, None]
    light[:, 2] = np.abs(light[:, 2])
    length = np.linalg.norm(light, axis=1)
    lamp = np.stack([*light.T, 1.0 / length, 1.0 / np.sqrt(2.0 + 2.0 * light[:, 2] / length), np.ones(9), np.ones(9)])

    def diffuse(a: float, b: float) -> np.ndarray:
        lobe = np.zeros((7, 9))
        evaluate(a, b, 0.5, lamp, np.array(fall), lobe)
        return lobe

    a, b, step = 0.3, -0.2, 1e-6
    found = diffuse(a, b)
    plain = np.array([lobes(a, b, 0.25, *each)[0] for each in light])
    n_z = 1.0 / math.sqrt(1.0 + a * a + b * b)
    factor = [
        fall_off(received / size, n_z, each[2] / size, np.array(fall))[0]
        for received, each, size in zip(plain, light, length, strict=True)
    ]
    assert found[C] == pytest.approx(plain * factor)
    assert found[C_A] == pytest.approx((diffuse(a + step, b)[C] - diffuse(a - step, b)[C]) / (2.0 * step), abs=1e-6)
    assert found[C_B] == pytest.approx((diffuse(a, b + step)[C] - diffuse(a, b - step)[C]) / (2.0 * step), abs=1e-6)


@pytest.mark.parametrize("law", ["transmitted", "oren-nayar"])
def test_normals_do_not_take_a_surface_for_lambertian(law: str) -> None:
    """By trimmed least squares they err by 2 to 8°."""
    stack, normal, white = generate(law, 4)
    maps = drain(recover(stack, np.arange(len(stack.sources)), white=white, left_out=False)).maps
    apart = angle(maps.normal, normal)
    assert math.degrees(apart.mean()) < 1.5
    assert maps.uncertainty is not None
    assert np.mean(apart < 2.0 * maps.uncertainty.normal) > 0.95


def test_a_lambertian_surface_has_no_fall_off() -> None:
    stack, _, white = generate("lambert", 1)
    used = np.arange(len(stack.sources))
    assert drain(kinds(stack, used, lamps(stack, used), white)).falls is None


@pytest.mark.parametrize(
    ("best", "extreme"), [((0.0, 1.0, 0.0), False), ((0.55, 0.0, 0.3), False), ((0.0, 0.0, 0.9), True)]
)
def test_the_search_finds_the_least_and_doubts_the_ends(best: tuple[float, float, float], extreme: bool) -> None:
    """Of what is left by the distance from the best, for two kinds; at an end of the range Lambert's is as likely."""

    def measure(falls: np.ndarray) -> np.ndarray:
        return np.asarray(1.0 + 3.0 * np.abs(falls - best).sum(axis=1))

    falls, others = find_falls(2, measure, measure)
    assert falls is not None
    assert falls == pytest.approx(np.tile(best, (2, 1)))
    assert not others[-1][0].any()
    assert others[-1][1].tolist() == [extreme, extreme]


def test_lambert_stays_where_others_are_hardly_better() -> None:
    def measure(falls: np.ndarray) -> np.ndarray:
        return np.asarray(1.0 - 0.04 * (falls[:, 0] > 0.2))

    assert find_falls(3, measure, measure)[0] is None


def test_a_fall_off_that_predicts_nothing_is_a_doubt() -> None:
    """The second kind predicts worse with it, so that it is Lambert's, and what the fall-off would change is stated."""

    def measure(falls: np.ndarray) -> np.ndarray:
        return np.asarray(1.0 + np.abs(falls - (0.4, 0.0, 0.0)).sum(axis=1))

    def predict(falls: np.ndarray) -> np.ndarray:
        return np.asarray(measure(falls) * np.where(falls.any(axis=1), [0.9, 1.5], 1.0))

    falls, others = find_falls(2, measure, predict)
    assert falls is not None
    assert falls == pytest.approx(np.array([[0.4, 0.0, 0.0], [0.0, 0.0, 0.0]]))
    assert any(
        other[1] == pytest.approx([0.4, 0.0, 0.0]) and kinds.tolist() == [False, True] for other, kinds in others
    )
    refused = find_falls(2, measure, lambda falls: 2.0 - measure(falls))
    assert refused[0] is None
    assert [kinds.tolist() for _, kinds in refused[1]] == [[True, True]]

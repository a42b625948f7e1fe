"""Regions against a search over turns, and the pairs that no measurement is near."""

from __future__ import annotations

import numpy as np

from engine.core.directions import surface_direction
from engine.factor.solvers.regions import PARTS, compute_squared_distance, gaps, parts_of
from tests.engine.factor.test_projections import hemisphere


def turn(vectors: np.ndarray, angle: float) -> np.ndarray:
    cosine, sine = np.cos(angle), np.sin(angle)
    return vectors @ np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def samples_of(wi: np.ndarray, wo: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return wi, wo, np.arange(len(wi))


def test_distance_is_the_least_over_turns_mirrors_and_exchange() -> None:
    wi, wo = hemisphere(40, 1), hemisphere(40, 2)
    least = np.full(40, np.inf)
    for angle in np.linspace(0.0, 2.0 * np.pi, 2000):
        for flip in (1.0, -1.0):
            first, second = (turn(side[:1] * (1.0, flip, 1.0), angle) for side in (wi, wo))
            for a, b in ((first, second), (second, first)):
                least = np.minimum(least, ((wi - a) ** 2).sum(axis=1) + ((wo - b) ** 2).sum(axis=1))
    np.testing.assert_allclose(compute_squared_distance(wi, wo, wi[0], wo[0]), least, atol=1e-5)


def test_parts_hold_whole_measurements_and_regions_far_from_the_others() -> None:
    wi, wo = hemisphere(400, 3), hemisphere(400, 4)
    angles = np.random.default_rng(0).uniform(0.0, 6.0, 3)
    measurement = np.tile(np.arange(400), 3)
    many = [np.concatenate([turn(side, angle) for angle in angles]) for side in (wi, wo)]
    mirror = np.array([1.0, -1.0, 1.0])
    parts = parts_of(many[0], many[1], measurement)
    assert parts is not None
    assert set(parts) == set(range(PARTS))
    np.testing.assert_array_equal(parts, np.tile(parts[:400], 3))
    np.testing.assert_array_equal(parts_of(*samples_of(wo * mirror, wi * mirror)), parts_of(*samples_of(wi, wo)))
    near = np.array([compute_squared_distance(wi, wo, wi[k], wo[k]) for k in range(400)])
    np.fill_diagonal(near, np.inf)
    other = np.where(parts[:400, None] != parts[None, :400], near, np.inf).min(axis=1)
    at_random = np.random.default_rng(1).integers(0, PARTS, 400)
    beside = np.where(at_random[:, None] != at_random[None], near, np.inf).min(axis=1)
    assert np.sqrt(other).mean() > 1.3 * np.sqrt(beside).mean()


def test_too_few_measurements_have_no_regions() -> None:
    assert parts_of(*samples_of(hemisphere(9, 5), hemisphere(9, 6))) is None
    assert parts_of(*samples_of(np.tile(hemisphere(1, 5), (50, 1)), np.tile(hemisphere(1, 6), (50, 1)))) is None


def test_what_lies_far_from_every_sample_is_told() -> None:
    rng = np.random.default_rng(2)
    low = [surface_direction(np.radians(40.0) * np.sqrt(rng.random(800)), 6.3 * rng.random(800)) for _ in range(2)]
    wi, wo = hemisphere(500, 7), hemisphere(500, 8)
    found, none = gaps(samples_of(*low), wi, wo), gaps(samples_of(hemisphere(3000, 9), hemisphere(3000, 10)), wi, wo)
    assert found is not None
    assert none is not None
    assert found.share > 0.4
    assert 40.0 <= found.beyond_deg <= 60.0
    assert f"beyond {found.beyond_deg:.0f}°" in found.sentence
    assert none.share < 0.2 < found.share

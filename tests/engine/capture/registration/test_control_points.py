"""Motions from marked points against known ones, and points that determine less than was asked for."""

from typing import Any

import numpy as np
import pytest

from engine.capture.registration.control_points import choose_marked_kind, fit_marked_motion

TURN = np.radians(3.0)
TRUTH = {
    "translation": np.array([[1, 0, 12.5], [0, 1, -7.25], [0, 0, 1.0]]),
    "euclidean": np.array([[np.cos(TURN), -np.sin(TURN), 20], [np.sin(TURN), np.cos(TURN), -9], [0, 0, 1.0]]),
    "affine": np.array([[1.02, 0.03, -4], [-0.01, 0.97, 11], [0, 0, 1.0]]),
    "homography": np.array([[1.02, 0.03, -4], [-0.01, 0.97, 11], [2e-5, -1e-5, 1.0]]),
}
PLACES = np.array([[100, 120], [3900, 200], [3800, 2900], [150, 2800], [2000, 1500], [1000, 2100.0]])


def pairs(matrix: Any, places: Any = PLACES, error_px: float = 0.0) -> Any:
    there = np.hstack([places, np.ones((len(places), 1))]) @ matrix.T
    error = np.random.default_rng(1).normal(0, error_px, (len(places), 2)) if error_px else 0.0
    return np.hstack([places, there[:, :2] / there[:, 2:] + error])


@pytest.mark.parametrize("motion", TRUTH)
@pytest.mark.parametrize("spare", [0, 2])
def test_motions_are_recovered_from_as_few_points_as_needed(motion: str, spare: int) -> None:
    needed = ["translation", "euclidean", "affine", "homography"].index(motion) + 1
    found = fit_marked_motion(pairs(TRUTH[motion])[: needed + spare], motion)
    assert found.motion == motion
    assert np.abs(pairs(found.matrix) - pairs(TRUTH[motion])).max() < 1e-6
    assert found.rms_px < 1e-7


def test_errors_of_marking_are_spread_and_reported() -> None:
    found = fit_marked_motion(pairs(TRUTH["homography"], error_px=0.5), "homography")
    assert 0.05 < found.rms_px < 0.7
    better = fit_marked_motion(pairs(TRUTH["homography"], error_px=0.5), "affine")
    assert found.rms_px < better.rms_px


def test_a_homography_misses_the_points_least_of_its_kind() -> None:
    marked = pairs(TRUTH["homography"], error_px=0.5)
    found = fit_marked_motion(marked, "homography")

    def miss(matrix: Any) -> Any:
        return float(((pairs(matrix) - marked)[:, 2:] ** 2).sum())

    for entry in np.ndindex(3, 3):
        for change in (1e-4, -1e-4):
            other = found.matrix.copy()
            other[entry] *= 1 + change
            assert miss(other) >= miss(found.matrix) - 1e-9


@pytest.mark.parametrize(
    ("motion", "places", "instead"),
    [
        ("homography", [[0, 0], [100, 0], [200, 0], [300, 0]], "euclidean"),
        ("homography", [[0, 0], [100, 0], [200, 0], [50, 300]], "affine"),
        ("homography", [[0, 0], [100, 0], [0, 100]], "affine"),
        ("affine", [[0, 0], [100, 100], [200, 200], [300, 300]], "euclidean"),
        ("affine", [[5, 5], [5, 5], [5, 5]], "translation"),
        ("euclidean", [[5, 5]], "translation"),
    ],
)
def test_AL6_points_that_do_not_determine_the_motion_give_a_stiffer_one(motion: str, places: Any, instead: str) -> None:
    shift = np.array([[1, 0, 3.0], [0, 1, -2.0], [0, 0, 1]])
    found = fit_marked_motion(pairs(shift, np.array(places, float)), motion)
    assert found.motion == instead
    assert np.abs(found.matrix - shift).max() < 1e-9


def test_AL6_mirrored_points_give_no_mirrored_motion() -> None:
    table = pairs(np.eye(3))
    table[:, 2] = 4000 - table[:, 2]
    found = fit_marked_motion(table, "homography")
    assert found.motion in ("translation", "euclidean")
    assert np.linalg.det(found.matrix) > 0
    assert found.rms_px > 100


@pytest.mark.parametrize("wrong", [[], [[1, 2, 3]], [[0, 0, float("nan"), 1]]])
def test_wrong_calls(wrong: Any) -> None:
    with pytest.raises(ValueError, match="four finite numbers"):
        fit_marked_motion(wrong)
    with pytest.raises(ValueError, match="unknown motion"):
        fit_marked_motion([[0, 0, 0, 0]], "spline")


def test_each_point_says_by_how_much_it_misses_the_motion() -> None:
    """One point of four is off by 4 px: a shift is their mean, so it misses by 3 px and the others by 1 px."""
    pairs = [[0, 0, 5, 0], [50, 0, 55, 0], [0, 50, 5, 50], [50, 50, 55, 54]]
    found = fit_marked_motion(pairs, "translation")
    assert found.missed_px == pytest.approx([1, 1, 1, 3])
    assert found.rms_px == pytest.approx(np.sqrt(3))


def test_the_kind_for_points_follows_what_the_import_is_asked_for() -> None:
    assert choose_marked_kind("auto", None) == "euclidean"
    assert choose_marked_kind("auto", np.array([0.0, 2.0])) == "homography"
    assert (choose_marked_kind("none", None), choose_marked_kind("affine", None)) == ("homography", "affine")

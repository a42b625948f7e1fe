"""Predicted costs beside measured ones."""

from __future__ import annotations

import dataclasses

import pytest

from engine.brdf.brdf import brdf_from_text
from engine.geometry.camera import frame
from engine.geometry.ground import Ground
from engine.geometry.shapes import shape
from engine.light.environment_file import open_environment
from engine.planning.costs.cost_model import NAMES, CostModel
from engine.planning.costs.setting import Setting
from engine.scene.scene import Scene
from engine.tradeoff.point import Point, check, compare_with
from engine.tradeoff.predict import Predictions
from tests.engine.tradeoff.points import point

SH = Setting("sh", {"order": 3})


def describe(**predicted: float) -> Point:
    measured = point(0.1, 0.1, 1000, SH, relight_s=0.2, bake_s=4.0)
    return dataclasses.replace(measured, predicted=predicted)


def test_misses_are_reported_worst_first_whichever_way_they_go() -> None:
    found = check([describe(frame_s=0.14, relight_s=0.02), describe(bake_s=8.0, size_bytes=900.0), point(0.3)])
    assert (found["compared"], found["within"]) == (4, 2)
    assert [(miss["figure"], miss["factor"]) for miss in found["misses"]] == [
        ("relight_s", pytest.approx(10.0)),
        ("bake_s", pytest.approx(2.0)),
    ]
    assert {"mode", "knobs", "predicted", "measured"} <= found["misses"][0].keys()


def test_what_is_nothing_is_not_compared() -> None:
    free = point(0.1, 0.1, setting=Setting("direct"))
    assert compare_with([dataclasses.replace(free, predicted={"frame_s": 0.1, "bake_s": 1.0})])[0].figure == "frame_s"
    assert compare_with([describe(frame_s=0.0)]) == []


def test_the_record_says_null_for_what_was_not_predicted() -> None:
    record = describe(frame_s=0.14).as_json()
    assert (record["predicted_frame_s"], record["predicted_bake_s"]) == (0.14, None)


@pytest.mark.parametrize("bad", [{"frame_s": -1.0}, {"frame_s": float("nan")}, {"error_flip": 0.1}, {"bake_s": "1"}])
def test_other_predictions_are_refused(bad: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="predicted"):
        describe(**bad)


def test_a_mode_without_a_bake_has_a_frame_only_and_a_ground_is_more_to_bake() -> None:
    mesh = shape("plane")
    costs = CostModel("test", "test", dict.fromkeys(NAMES, ((1.0, 1e-6),)))
    scene = Scene(mesh, frame(mesh.positions), brdf_from_text("lambert"), environment=open_environment("sky"))
    alone = Predictions(costs, scene, (10, 10), 2, 1)
    assert alone.of(Setting("direct")).keys() == {"frame_s"}
    assert alone.of(SH).keys() == {"frame_s", "relight_s", "bake_s", "size_bytes"}
    assert alone.of(Setting("reference")).keys() == {"frame_s"}
    standing = Predictions(costs, dataclasses.replace(scene, ground=Ground()), (10, 10), 2, 1)
    assert standing.of(SH)["bake_s"] > alone.of(SH)["bake_s"]


def test_longer_paths_of_the_reference_are_predicted_too() -> None:
    """A plane meets no second point, and a knot does."""
    costs = CostModel("test", "test", dict.fromkeys(NAMES, ((1.0, 1e-6),)))
    for name, longer in (("plane", False), ("torus-knot", True)):
        mesh = shape(name)
        scene = Scene(mesh, frame(mesh.positions), brdf_from_text("lambert"), environment=open_environment("sky"))
        direct, deep = (
            Predictions(costs, scene, (10, 10), 2, depth).of(Setting("reference"))["frame_s"] for depth in (1, 4)
        )
        assert (deep > direct) == longer

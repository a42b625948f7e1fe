"""What a sweep expects of settings that it has not measured, and what measuring one is worth."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.geometry.camera import frame
from engine.planning.costs.setting import Setting
from engine.planning.prior import normal
from engine.planning.small_images import Measured
from engine.scene.scene import Scene
from engine.tradeoff.expect import Expectations, measure_worth
from engine.tradeoff.sweep import sweep
from tests.engine.planning.brute_force import bowl, lamp_sky
from tests.engine.planning.conftest import every_rate
from tests.engine.tradeoff.points import point

LOW, HIGH = Setting("sh", {"order": 3}), Setting("sh", {"order": 8})


@pytest.fixture(scope="module")
def scene() -> Scene:
    mesh, brdf = bowl(), brdf_from_text("phong:kd=0.4,ks=0.02,exponent=10")
    return Scene(mesh, frame(mesh.positions, 4 / 3), brdf, environment=lamp_sky())


def test_T1_the_worth_is_the_mean_fall_below_the_best_at_the_price() -> None:
    """Against draws of the error, and one by one: an error that cannot be below the best is worth nothing."""
    error, best = normal(0.02, 0.2), point(0.05, setting=LOW)
    drawn = np.random.default_rng(5).normal(error.mean, error.deviation, 200_000)
    assert measure_worth(error, math.inf, [best]) == pytest.approx(
        np.maximum(math.log(0.05) - drawn, 0.0).mean(), rel=0.02
    )
    assert measure_worth(normal(0.5, 0.6), math.inf, [best]) < 1e-6
    dear = replace(best, frame_s=10.0)
    assert measure_worth(error, 1.0, [dear, point(0.5, setting=HIGH)]) > measure_worth(error, math.inf, [dear])


def test_a_measured_setting_moves_what_is_expected_of_its_mode(scene: Scene) -> None:
    expected = Expectations(scene, 1)
    before = expected.expect(HIGH, [])
    assert before is not None
    measured = point(2.0 * before.median, setting=LOW)
    near = expected.expect(LOW, [measured])
    assert near is not None
    assert near.median == pytest.approx(measured.error_rmse_rel, rel=0.05)
    assert expected.expect(Setting("reference"), []) is None
    small = Expectations(scene, 1, {HIGH: Measured(3.0 * before.median, 0.01)}).expect(HIGH, [])
    assert small is not None
    assert small.median > 2.0 * before.median


def test_nothing_is_expected_of_a_mode_that_cannot_draw_the_brdf(scene: Scene) -> None:
    """Gaussians are of gloss, which a diffuse BRDF lacks; a sweep of one ended in an error."""
    diffuse = Expectations(replace(scene, brdf=brdf_from_text("lambert")), 1)
    assert diffuse.expect(Setting("gaussian"), []) is None
    assert diffuse.expect(LOW, []) is not None


def test_a_mode_for_which_there_is_no_time_is_extrapolated(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """A sweep of few seconds with costs of which a bake takes minutes: it says what error it would have."""
    monkeypatch.setattr("engine.planning.small_images.SIZE", (24, 18))
    rates = every_rate()
    slow = {name: tuple((at, 1e4 * rate) for at, rate in rates.tables[name]) for name in ("sh-vector", "sh-matrix")}
    costs = replace(rates, tables={**rates.tables, **slow})
    monkeypatch.setattr("engine.tradeoff.sweep._Run._group", lambda run, group: _leave_out(run, group))
    found = drain(sweep(scene, [LOW, Setting("direct", {"directions": 4})], (32, 24), seconds=2.0, costs=costs))
    assert [each.setting for each in found.left_out] == [LOW]
    (expected,) = found.expected
    assert expected.setting == LOW
    low, high = expected.interval
    assert 0.0 < low < expected.error_rel < high
    assert expected.predicted["bake_s"] > 0.0


def _leave_out(run: object, group: list[Setting]):  # type: ignore[no-untyped-def]
    run._too_late(group, 0.0)  # type: ignore[attr-defined]
    yield run._step("left out")  # type: ignore[attr-defined]

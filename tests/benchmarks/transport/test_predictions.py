"""Generated scenes and the figures of predictions on them."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from benchmarks.transport import predictions as campaign
from benchmarks.transport.generated_scenes import generate
from benchmarks.transport.predictions import MINIMUM, Compared, draw_settings, predictions, spread, summary
from engine.accuracy.compare import ErrorEstimate
from engine.core.directions import dot
from engine.core.errors import InputError, UsageError
from engine.core.steps import drain
from engine.planning.costs.setting import Setting

ROW = Compared(3, "a ball under a sky", Setting("sh", {"order": 3}), 0.1, (0.05, 0.2), 0.1, 0.001)


def errors(*measured: float) -> dict[str, float]:
    rows = [dataclasses.replace(ROW, seed=seed, measured=value, uncertainty=0.0) for seed, value in enumerate(measured)]
    return {each.name: each.error for each in summary(rows)}


def test_predictions_are_judged_whichever_way_they_miss() -> None:
    assert errors(0.11, 0.09, 0.06, 0.01) == {
        "predictions-above": 0.25,
        "predictions-beyond-1.5": 0.5,
        "predictions-beyond-2": 0.25,
        "predictions-worst": pytest.approx(10.0),
        "predictions-outside": 0.25,
        "predictions-width": pytest.approx(4.0),
        "predictions-spread-sh": pytest.approx(11.0),
    }


def test_an_uncertain_measurement_counts_as_it_is_nearest() -> None:
    assert dataclasses.replace(ROW, predicted=0.1, measured=0.0, uncertainty=0.05).factor == pytest.approx(2.0)
    assert dataclasses.replace(ROW, predicted=0.1, measured=0.12, uncertainty=0.05).factor == 1.0


def test_an_interval_covers_what_may_lie_in_it() -> None:
    for measured, uncertainty, covered in (
        (0.2, 0.0, True),
        (0.22, 0.01, False),
        (0.22, 0.03, True),
        (0.04, 0.0, False),
    ):
        assert dataclasses.replace(ROW, measured=measured, uncertainty=uncertainty).covered == covered
    assert dataclasses.replace(ROW, interval=(0.0, 0.0), measured=0.5 * MINIMUM).covered


def test_a_spread_leaves_out_what_five_of_a_hundred_and_one_more_would_be() -> None:
    rows = [dataclasses.replace(ROW, measured=0.1 * ratio, uncertainty=0.0) for ratio in np.linspace(0.5, 2.5, 199)]
    ratios = sorted(each.ratio for each in rows)
    assert spread(rows) == (ratios[4], ratios[-5])
    assert spread(rows[:10]) == (ratios[0], ratios[9])


def test_errors_that_no_image_shows_are_alike() -> None:
    assert dataclasses.replace(ROW, predicted=0.0, measured=0.5 * MINIMUM).factor == 1.0


def test_the_worst_is_named_with_the_seed_that_repeats_it() -> None:
    rows = summary([ROW, dataclasses.replace(ROW, seed=17, measured=0.3)])
    worst = next(each for each in rows if each.name == "predictions-worst")
    assert "seed 17, 30 % where 10 % was predicted (a ball under a sky)" in worst.what


def test_a_seed_draws_one_scene_and_its_settings() -> None:
    names = set()
    for seed in range(8):
        (name, scene), (again, same) = generate(seed), generate(seed)
        assert name == again
        assert np.array_equal(scene.mesh.positions, same.mesh.positions)
        assert np.allclose(dot(scene.mesh.normals, scene.mesh.normals), 1.0)
        assert scene.environment is not None
        assert np.isfinite(scene.environment.radiance).all()
        assert draw_settings(seed, ["direct", "sh"]) == draw_settings(seed, ["direct", "sh"])
        names.add(name)
    assert len(names) == 8


def test_closed_models_are_turned_outwards() -> None:
    for seed in range(8):
        mesh = generate(seed)[1].mesh
        a, b, c = (mesh.positions[mesh.faces[:, corner]] for corner in range(3))
        flat = np.cross(b - a, c - a)
        assert np.mean(dot(flat, mesh.normals[mesh.faces[:, 0]]) >= 0.0) > 0.99


def test_files_of_a_folder_join_where_they_can_be_read(tmp_path: Path) -> None:
    (tmp_path / "broken.obj").write_bytes(b"v nonsense")
    (tmp_path / "broken.bsdf").write_bytes(b"")
    assert all(generate(seed, tmp_path)[1].mesh.positions.size for seed in range(8))


def test_wrong_wishes_are_said(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="0 scenes"):
        drain(predictions(tmp_path, scenes=0))
    with pytest.raises(InputError, match="not a folder"):
        drain(predictions(tmp_path, data=tmp_path / "absent"))


def test_modes_that_are_asked_for_are_drawn_in_every_scene_that_they_can_draw(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[Setting] = []

    def draw(_scene: object, settings: list[Setting], _drawer: object) -> dict[Setting, ErrorEstimate]:
        drawn.extend(settings)
        return dict.fromkeys(settings, ErrorEstimate(0.1, 0.001))

    monkeypatch.setattr(campaign, "measure", draw)
    diffuse = next(seed for seed in range(100, 200) if generate(seed)[0].split(", ")[1].startswith("lambert"))
    with pytest.raises(UsageError, match="none of these 1 scenes can be drawn with gaussian"):
        drain(predictions(tmp_path, scenes=1, seed=diffuse, modes=["gaussian"]))
    rows = drain(predictions(tmp_path, scenes=1, seed=diffuse, modes=["gaussian", "direct"]))
    assert [each.mode for each in drawn] == ["direct"]
    assert [each.name for each in rows if "spread" in each.name] == ["predictions-spread-direct"]


@pytest.mark.long
def test_intervals_hold_the_errors_of_scenes_that_they_were_not_set_by(tmp_path: Path) -> None:
    rows = drain(predictions(tmp_path, scenes=100, seed=300))
    outside = next(each for each in rows if each.name == "predictions-outside")
    assert outside.error <= (outside.bound or 0.0), "\n".join(
        f"{each.name} {each.error:.3g} {each.what}" for each in rows
    )

"""Sweeps on a small sphere: what is measured, that bakes which share rays are bakes, and that errors are right."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest
import trimesh

from engine.accuracy.compare import DEVIATIONS
from engine.brdf.brdf import brdf_from_text
from engine.camera import frame
from engine.effects.setting import Setting
from engine.environment_file import open_environment
from engine.factor.errors import reference as random_pairs
from engine.mesh import Mesh, read_mesh
from engine.render.reference import reference
from engine.scene import Scene
from engine.shapes import shape
from engine.steps import Step, drain
from engine.tradeoff.baked import bake_group, groups, lit
from engine.tradeoff.front import front
from engine.tradeoff.sweep import Tradeoff, ladders_of, modes_of, settings_of, sweep
from engine.tradeoff.truth import Truth
from engine.tradeoff.write import label_of, write
from engine.transport import sh_bake, wavelet_bake
from tests.engine.scenes import weave
from tests.engine.tradeoff.points import point

SIZE = (32, 24)


@pytest.fixture(scope="module")
def mesh(tmp_path_factory: pytest.TempPathFactory) -> Mesh:
    path = tmp_path_factory.mktemp("mesh") / "sphere.obj"
    trimesh.creation.icosphere(2).export(path)
    return read_mesh(path)


@pytest.fixture(scope="module")
def scene(mesh: Mesh) -> Scene:
    return Scene(
        mesh, frame(mesh.positions, 4 / 3), brdf_from_text("phong:exponent=5"), environment=open_environment("sky")
    )


@pytest.fixture(scope="module")
def found(scene: Scene) -> Tradeoff:
    settings = [
        Setting("wavelet", {"terms": 2, "cube": 16, "coefficients": 24}),
        Setting("wavelet", {"terms": 1, "cube": 16, "coefficients": 24}),
        Setting("sh", {"order": 3}),
        Setting("sh", {"order": 4}),
        Setting("direct", {"directions": 4}),
        Setting("reference", {"samples": 1}),
        Setting("reference", {"samples": 4}),
    ]
    steps: list[Step] = []
    result = drain(sweep(scene, settings, SIZE, seconds=60.0), steps.append)
    shown = [step.partial for step in steps if step.partial is not None]
    assert all(isinstance(partial, Tradeoff) for partial in shown)
    assert [len(partial.points) for partial in shown] == sorted(len(partial.points) for partial in shown)
    assert [step.done for step in steps] == sorted(step.done for step in steps)
    assert not result.left_out
    assert {each.setting for each in result.points} == set(settings)
    return result


def test_what_needs_no_bake_comes_first_and_takes_none(found: Tradeoff) -> None:
    baked = [each.bake_s > 0.0 for each in found.points]
    assert baked == sorted(baked)
    assert [each.size_bytes > 0 for each in found.points] == baked
    assert baked == [each.mode in ("sh", "wavelet") for each in found.points]


def test_the_noise_of_a_reference_halves_with_four_times_the_samples(found: Tradeoff) -> None:
    (ladder,) = ladders_of(found.points, "reference", "samples")
    coarse, fine = (each.error_rmse_rel for each in ladder)
    assert coarse / fine == pytest.approx(2.0, rel=0.25)


def test_T7_errors_fall_along_ladders(found: Tradeoff) -> None:
    assert found.not_monotone("sh", "order") == []
    assert found.not_monotone("wavelet", "terms") == []


def test_a_record_a_table_and_plots_are_written(found: Tradeoff, tmp_path: Path) -> None:
    record = drain(write(found, tmp_path / "out", "A sphere", mesh="sphere.obj"))
    assert record == json.loads((tmp_path / "out" / "tradeoff.json").read_text())
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == sorted(record["files"])
    assert (tmp_path / "out" / "tradeoff.png").read_bytes().startswith(b"\x89PNG")
    best = [each.setting.as_json() for each in front(found.points)]
    marked = [{"mode": row["mode"], "knobs": row["knobs"]} for row in record["points"] if row["on_front"]]
    assert sorted(map(str, marked)) == sorted(map(str, best))
    rows = list(csv.DictReader(io.StringIO((tmp_path / "out" / "tradeoff.csv").read_text())))
    assert [float(row["error_rmse_rel"]) for row in rows] == [row["error_rmse_rel"] for row in record["points"]]
    assert rows[0].keys() >= {"mode", "samples", "terms", "frame_s", "on_front"}


def test_labels_name_what_differs() -> None:
    points = [point(0.1, setting=Setting("wavelet", {"terms": terms})) for terms in (1, 2)]
    assert [label_of(each, points) for each in points] == ["terms 1", "terms 2"]


def test_bakes_on_shared_rays_are_those_of_bakes_alone(scene: Scene, mesh: Mesh, tmp_path: Path) -> None:
    order, wavelets = Setting("sh", {"order": 4}), Setting("wavelet", {"terms": 2, "cube": 32, "coefficients": 20})
    assert groups([wavelets, order]) == [[wavelets, order]]
    bakes, left_out = drain(bake_group(scene, [wavelets, order]))
    assert not left_out
    alone = drain(sh_bake.bake(tmp_path / "sh", drain(sh_bake.prepare(mesh, scene.brdf, sh_bake.BakeSettings(4)))))
    np.testing.assert_array_equal(bakes[1].transport.rows, alone.transport.rows)
    factors = drain(wavelet_bake.factors_for(scene.brdf, 2))
    work = wavelet_bake.prepare(mesh, factors, wavelet_bake.BakeSettings(32, 20))
    of_file = drain(wavelet_bake.bake(tmp_path / "wavelet", work))
    np.testing.assert_array_equal(bakes[0].transport.vectors.words, of_file.transport.vectors.words)
    assert bakes[0].size_bytes == (tmp_path / "wavelet").stat().st_size
    assert lit(bakes[0], scene).rows.shape == (bakes[0].transport.rows, 3)


def test_what_takes_too_long_is_left_out_with_the_reason(scene: Scene) -> None:
    settings = [Setting("wavelet", {"cube": 16}), Setting("sh", {"order": 3})]
    bakes, left_out = drain(bake_group(scene, groups(settings)[0], seconds=0.0))
    assert bakes == []
    assert "for which there is no time" in left_out[0].reason
    result = drain(sweep(scene, settings, SIZE, seconds=1e-3))
    assert result.points == ()
    assert {each.setting for each in result.left_out} == set(settings)


def test_knobs_that_change_nothing_stay(scene: Scene) -> None:
    settings = settings_of(scene, ("sh", "direct"))
    assert {each["interreflection"] for each in settings if each.mode == "sh"} == {0}
    dark = Scene(scene.mesh, scene.camera, scene.brdf)
    assert settings_of(dark, ("direct",)) == [Setting("direct")]
    assert {each["interreflection"] for each in settings_of(scene, ("sh",), bounces=True)} == {0, 1}
    base = Setting("wavelet", {"terms": 2})
    assert base in settings_of(scene, ("wavelet",), [base])
    assert modes_of(Scene(shape("plane"), scene.camera, scene.brdf, weave(16)))[0] == "shading-map"


def test_a_scene_out_of_sight_is_refused(scene: Scene) -> None:
    away = Scene(scene.mesh, frame(scene.mesh.positions + 100.0, 4 / 3), scene.brdf, environment=scene.environment)
    with pytest.raises(ValueError, match="covered"):
        drain(sweep(away, [Setting("direct")], SIZE, seconds=5.0))


def test_cancelling_leaves_nothing_behind(scene: Scene) -> None:
    steps = sweep(scene, [Setting("direct"), Setting("sh")], SIZE, seconds=30.0)
    for _ in range(5):
        next(steps)
    steps.close()
    with pytest.raises(StopIteration):
        next(steps)


def test_T8_the_reported_error_covers_the_true_one(scene: Scene) -> None:
    """Against forty references of few paths by other random numbers; of the truth, noise is a sixteenth of theirs."""
    size = (24, 18)
    truth = drain(reference(scene, size, samples=4096, seed=12345)).picture
    wrong = truth.copy()
    wrong[..., :3] *= 1.05
    told = [drain(reference(scene, size, samples=16, seed=seed)) for seed in range(40)]
    mask = np.logical_and.reduce([each.picture[..., 3] >= 0.999 for each in told])
    picked, right = (picture[mask][:, :3].astype(float) for picture in (wrong, truth))
    true = np.linalg.norm(picked - right) / np.linalg.norm(right)
    errors = [Truth(each, mask, 0.0).error(wrong) for each in told]
    assert np.mean([error.rmse_rel + error.uncertainty >= true for error in errors]) >= 0.95
    assert np.median([error.uncertainty for error in errors]) < 2.0 * true


@pytest.mark.parametrize("terms", [1, 3])
def test_T8_the_error_of_factors_holds_on_directions_that_they_were_not_told_by(terms: int) -> None:
    """80,000 random pairs each time, as Wang et al. 2004, section 4.3, within what so many pairs leave open."""
    brdf = brdf_from_text("phong:exponent=10")
    factors = drain(wavelet_bake.factors_for(brdf, terms))
    pairs = random_pairs(brdf)
    reported = pairs.rms(factors)[0]
    square = (((factors.f(pairs.wi, pairs.wo) - pairs.value) * pairs.wi[:, 2:]) ** 2).mean(axis=1)
    unsure = DEVIATIONS * np.sqrt(2.0) * square.std() / np.sqrt(len(square)) / (2.0 * reported)
    held_out = [random_pairs(brdf, seed=seed).rms(factors)[0] for seed in range(2, 22)]
    assert np.mean([reported + unsure >= each for each in held_out]) >= 0.95

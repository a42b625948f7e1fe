"""Sweeps on a small sphere: what is measured, that bakes which share rays are bakes, and that errors are right."""

from __future__ import annotations

import csv
import dataclasses
import io
import json
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from engine.accuracy.compare import DEVIATIONS
from engine.brdf.brdf import brdf_from_text
from engine.core.steps import Step, Steps, drain
from engine.factor.errors import reference as random_pairs
from engine.geometry.camera import frame
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh, read_mesh
from engine.geometry.shapes import shape
from engine.light.environment_file import open_environment
from engine.planning.bake_group import bake_alone, bake_group, groups, relight_transport
from engine.planning.costs.setting import Setting
from engine.render.reference import ReferenceImage, reference
from engine.render.transported import image_of
from engine.scene.scene import Scene
from engine.tradeoff.agenda import modes_of, quick_first, reduce, settings_of
from engine.tradeoff.draw import SAMPLES, find_shown_vertices
from engine.tradeoff.front import front
from engine.tradeoff.sweep import NoisyReference, Tradeoff, sweep, sweeps_of
from engine.tradeoff.write import label_of, write
from engine.transport.sh import bake as sh_bake
from engine.transport.wavelet import bake as wavelet_bake
from tests.engine.scenes import weave
from tests.engine.transport.gaussian.gaussian_lobes import icosphere

SIZE, SMALL = (32, 24), (24, 18)


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
    result = drain(sweep(scene, settings, SIZE, seconds=300.0), steps.append)
    shown = [step.partial for step in steps if step.partial is not None]
    assert all(isinstance(partial, Tradeoff) for partial in shown)
    assert [len(partial.points) for partial in shown] == sorted(len(partial.points) for partial in shown)
    assert [step.done for step in steps] == sorted(step.done for step in steps)
    assert not result.left_out
    assert {each.setting for each in result.points} == set(settings)
    return result


def test_one_of_each_mode_comes_first_and_then_what_needs_no_bake(found: Tradeoff) -> None:
    baked = [each.bake_s > 0.0 for each in found.points]
    assert {each.mode for each in found.points[:4]} == {each.mode for each in found.points}
    assert baked[:4] == sorted(baked[:4])
    assert baked[4:] == sorted(baked[4:])
    assert [each.size_bytes > 0 for each in found.points] == baked
    assert baked == [each.mode in ("sh", "wavelet") for each in found.points]


def test_settings_that_are_one_are_measured_once(mesh: Mesh) -> None:
    """Of a Lambertian BRDF, factors have a single term, and 4 and 8 are the same bake of the same size."""
    scene = Scene(mesh, frame(mesh.positions, 4 / 3), brdf_from_text("lambert"), environment=open_environment("sky"))
    many = [Setting("wavelet", {"terms": terms, "cube": 16, "coefficients": 24}) for terms in (8, 4, 1)]
    result = drain(sweep(scene, many, SMALL, seconds=300.0))
    (only,) = result.points
    assert only.setting == many[-1]
    assert not result.left_out
    assert reduce(Setting("wavelet", {"coefficients": 4000, "cube": 16}), 8)["coefficients"] == 6 * 16**2


def test_what_a_plan_chooses_is_measured_first(scene: Scene) -> None:
    chosen = Setting("sh", {"order": 4})
    settings = [
        Setting("direct", {"directions": 4}),
        Setting("direct", {"directions": 16}),
        Setting("sh", {"order": 3}),
    ]
    result = drain(sweep(scene, settings, SMALL, seconds=300.0, first=[chosen]))
    assert {each.setting for each in result.points[:3]} == {chosen, settings[0], settings[2]}


def test_a_bake_of_seconds_does_not_wait_for_one_of_a_minute() -> None:
    """A plan's choice of a high order comes before Gaussians where these are predicted to take longer."""
    predicted_s = {"direct": 0.0, "wavelet": 2.0, "gaussian": 60.0}
    settings = [Setting("gaussian", {"lobes": 1}), Setting("sh", {"order": 15}), Setting("wavelet"), Setting("direct")]
    jobs = quick_first(settings, lambda setting: predicted_s.get(setting.mode, 3.0))
    assert [[each.mode for each in job] for job in jobs] == [["direct"], ["wavelet"], ["sh"], ["gaussian"]]


def test_a_budget_holds_also_where_a_bake_takes_longer_than_it_said(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A bake that would never end is given up in time, and said to be left out. Time passes in its steps alone."""
    clock = SimpleNamespace(now_s=100.0)

    def endless(*_: Any) -> Steps[Any]:
        while True:
            clock.now_s += 0.5
            yield Step(0.0, "baking")

    monkeypatch.setattr(
        "engine.tradeoff.sweep.time", SimpleNamespace(monotonic=lambda: clock.now_s, perf_counter=lambda: clock.now_s)
    )
    monkeypatch.setattr("engine.tradeoff.sweep.bake_alone", endless)
    lobes = Setting("gaussian")
    result = drain(sweep(scene, [Setting("direct", {"directions": 4}), lobes], SMALL, seconds=4.0))
    assert [each.setting for each in result.left_out] == [lobes]
    assert [each.mode for each in result.points] == ["direct"]
    assert 2.0 <= result.time_s <= 4.5


def test_the_noise_of_a_reference_halves_with_four_times_the_samples(found: Tradeoff) -> None:
    (sweep,) = sweeps_of(found.points, "reference", "samples")
    coarse, fine = (each.error_rmse_rel for each in sweep)
    assert coarse / fine == pytest.approx(2.0, rel=0.25)


def test_T7_errors_fall_along_sweeps(found: Tradeoff) -> None:
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
    settings = [Setting("wavelet", {"terms": terms}) for terms in (1, 2)]
    assert [label_of(each, settings) for each in settings] == ["terms 1", "terms 2"]


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
    assert 0.3 < bakes[0].size_bytes / (tmp_path / "wavelet").stat().st_size < 3.0
    assert 0.0 < (bakes[0].another_s or 0.0) < bakes[0].bake_s
    assert bakes[1].another_s is None  # any BRDF is put into it
    assert cast(Any, relight_transport(bakes[0], scene)).rows.shape == (bakes[0].transport.rows, 3)


@pytest.mark.parametrize("on_ground", [pytest.param(False, marks=pytest.mark.long), True])
def test_a_image_needs_no_other_vertices_than_those_it_shows(scene: Scene, on_ground: bool) -> None:
    scene = dataclasses.replace(scene, ground=Ground(cells=6) if on_ground else None)
    shown = find_shown_vertices(scene, SIZE, SAMPLES)
    vertices = len(scene.surface.positions)
    assert 0.3 * vertices < len(shown) < 0.8 * vertices
    group = [Setting("wavelet", {"terms": 2, "cube": 32, "coefficients": 20}), Setting("sh", {"order": 4})]
    whole, _ = drain(bake_group(scene, group))
    some, _ = drain(bake_group(scene, group, shown=shown))
    for one, other in zip(whole, some, strict=True):
        of_whole, of_some = (
            drain(image_of(relight_transport(bake, scene), scene.camera, SIZE, SAMPLES)).image for bake in (one, other)
        )
        # products of matrices round as the number of their rows decides, on some CPUs
        np.testing.assert_allclose(of_some, of_whole, rtol=0.0, atol=float(4.0 * np.finfo(np.float32).eps))
        assert one.memory_bytes == other.memory_bytes
        assert one.size_bytes == other.size_bytes
        assert (
            cast(Any, relight_transport(one, scene)).rows.shape == cast(Any, relight_transport(other, scene)).rows.shape
        )


def test_lobes_of_what_is_shown_draw_nearly_the_same(scene: Scene) -> None:
    """Each vertex is fitted beside those that were fitted before, and these are others."""
    brdf = brdf_from_text("ggx:kd=0.3,alpha=0.4,f0=0.3")
    glossy = dataclasses.replace(scene, mesh=icosphere(1), brdf=brdf, ground=Ground(cells=4))
    setting = Setting("gaussian")
    whole, _ = drain(bake_alone(glossy, setting))
    some, _ = drain(bake_alone(glossy, setting, shown=find_shown_vertices(glossy, SIZE, SAMPLES)))
    one, other = (
        drain(image_of(relight_transport(bake[0], glossy), glossy.camera, SIZE, SAMPLES)).image
        for bake in (whole, some)
    )
    assert np.linalg.norm(one - other) < 0.02 * np.linalg.norm(one)
    assert (whole[0].memory_bytes, whole[0].size_bytes) == (some[0].memory_bytes, some[0].size_bytes)


def test_what_takes_too_long_is_left_out_with_the_reason(scene: Scene) -> None:
    settings = [Setting("wavelet", {"cube": 16}), Setting("sh", {"order": 3})]
    bakes, left_out = drain(bake_group(scene, groups(settings)[0], seconds=0.0))
    assert bakes == []
    assert "s, for which there was no time" in left_out[0].reason
    result = drain(sweep(scene, settings, SIZE, seconds=1e-3))
    assert result.points == ()
    assert {each.setting for each in result.left_out} == set(settings)


def test_parameters_that_change_nothing_stay(scene: Scene) -> None:
    settings = settings_of(scene, ("sh", "direct"))
    assert {each["interreflection"] for each in settings if each.mode == "sh"} == {0}
    dark = Scene(scene.mesh, scene.camera, scene.brdf)
    assert settings_of(dark, ("direct",)) == [Setting("direct")]
    assert {each["interreflection"] for each in settings_of(scene, ("sh",), bounces=True)} == {0, 1}
    base = Setting("wavelet", {"terms": 2})
    assert base in settings_of(scene, ("wavelet",), [base])
    assert base.replace(cube=16, terms=8) in settings_of(scene, ("wavelet",), [base])
    unbaked = ("direct", "reference")
    assert modes_of(scene)[-2:] == unbaked
    assert modes_of(Scene(shape("plane"), scene.camera, scene.brdf, weave(16)))[-3:] == ("shading-map", *unbaked)


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


@pytest.fixture(scope="module")
def exact(scene: Scene) -> NDArray[np.float32]:
    """An image whose noise is an eighth of that of its references, or less."""
    return drain(reference(scene, SMALL, samples=4096, seed=12345)).image


def brighter(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Five hundredths brighter everywhere."""
    wrong = image.copy()
    wrong[..., :3] *= 1.05
    return wrong


def move(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """A pixel further to the right: wrong at edges of shade and highlights."""
    wrong = image.copy()
    wrong[:, 1:, :3] = image[:, :-1, :3]
    return wrong


@lru_cache(maxsize=1)
def seed(scene: Scene, samples: int, count: int) -> list[ReferenceImage]:
    return [drain(reference(scene, SMALL, samples=samples, seed=seed)) for seed in range(count)]


@pytest.mark.parametrize("spoilt", [brighter, move])
@pytest.mark.parametrize(
    ("samples", "count"),
    [(16, 40), *(pytest.param(*step, marks=pytest.mark.long) for step in ((8, 60), (64, 40)))],
)
def test_T8_the_reported_error_covers_the_true_one(
    scene: Scene,
    exact: NDArray[np.float32],
    samples: int,
    count: int,
    spoilt: Callable[[NDArray[np.float32]], NDArray[np.float32]],
) -> None:
    """Against references of few paths by other random numbers, and seldom by far too much."""
    wrong = spoilt(exact)
    references = seed(scene, samples, count)
    mask = np.logical_and.reduce([each.image[..., 3] >= 0.999 for each in references])
    picked, right = (image[mask][:, :3].astype(float) for image in (wrong, exact))
    true = np.linalg.norm(picked - right) / np.linalg.norm(right)
    errors = [NoisyReference(each, mask, 0.0).error(wrong) for each in references]
    assert np.mean([error.rmse_rel + error.uncertainty >= true for error in errors]) >= 0.95
    assert np.mean([error.rmse_rel - error.uncertainty <= true for error in errors]) >= 0.95
    assert np.median([error.uncertainty for error in errors]) < 2.0 * true


@pytest.mark.parametrize("terms", [1, pytest.param(3, marks=pytest.mark.long)])
def test_T8_the_error_of_factors_holds_on_directions_that_they_were_not_fitted_to(terms: int) -> None:
    """80,000 random pairs each time, as Wang et al. 2004, section 4.3, within what so many pairs leave open."""
    brdf = brdf_from_text("phong:exponent=10")
    factors = drain(wavelet_bake.factors_for(brdf, terms))
    pairs = random_pairs(brdf)
    reported = pairs.rms(factors)[0]
    square = (((factors.f(pairs.wi, pairs.wo) - pairs.value) * pairs.wi[:, 2:]) ** 2).mean(axis=1)
    unsure = DEVIATIONS * np.sqrt(2.0) * square.std() / np.sqrt(len(square)) / (2.0 * reported)
    held_out = [random_pairs(brdf, seed=seed).rms(factors)[0] for seed in range(2, 22)]
    assert np.mean([reported + unsure >= each for each in held_out]) >= 0.95

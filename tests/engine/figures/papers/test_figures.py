"""The papers' figures: panels are what the modes draw, errors are those of the files, sweeps fall."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from engine.accuracy.compare import ErrorEstimate
from engine.brdf.brdf import brdf_from_text
from engine.core.errors import OutputError
from engine.core.steps import Step, Steps, drain
from engine.factor.errors import reference
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.separable import separate
from engine.figures import figure as figures
from engine.figures.figure import Figure, Settings, Shown, ShownRow, coarse_bust, error_text, records, sheet_of
from engine.figures.papers.kautz_6 import kautz_6, light_at_vertices
from engine.figures.papers.kautz_7 import kautz_7
from engine.figures.papers.shading_maps import _shading_map, shading_map_lookups, shading_map_table
from engine.figures.papers.vertex_images import view_of
from engine.figures.papers.wang_2 import wang_2, wang_5
from engine.figures.papers.wang_3 import wang_3
from engine.figures.papers.wang_4 import wang_4
from engine.figures.papers.wavelet_rays import Kept, bake_together
from engine.figures.write import MARKER, draw_into
from engine.geometry.camera import frame
from engine.geometry.ground import Ground, with_ground
from engine.geometry.shapes import shape
from engine.images.decode import read_image
from engine.light.environment import EnvironmentMap
from engine.light.environment_file import open_environment
from engine.render.transported import image_of
from engine.shading.power_law import fit
from engine.transport.relight import RelightWavelets
from engine.transport.sh import bake as sh_bake
from engine.transport.sh.lighting import project
from engine.transport.sh.transfer import STEP, transfer
from engine.transport.wavelet import bake as wavelet_bake
from engine.transport.wavelet.bake import factors_for
from engine.transport.wavelet.lighting import lighting_of
from engine.transport.wavelet.transfer import relight_transport, sum_signed_radiance

BUST = coarse_bust(9, 13)


@pytest.fixture(autouse=True)
def quick_tables(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.transport.sh.brdf_table.SAMPLES", 256)
    monkeypatch.setattr("engine.transport.sh.brdf_table.SAMPLES_OF_MAP", 64)


def test_images_from_vertices_are_those_of_the_mode_that_draws_them(tmp_path: Path) -> None:
    brdf, ground = brdf_from_text("ggx:alpha=0.4"), Ground(cells=3)
    factors = drain(factors_for(brdf, 2))
    work = wavelet_bake.prepare(BUST, factors, wavelet_bake.BakeSettings(8, 24, 4), ground)
    transport = drain(wavelet_bake.bake(tmp_path / "a.transport", work)).transport
    rows = relight_transport(transport, lighting_of(open_environment("studio"), 8).light)
    camera, size = frame(transport.mesh.positions), (40, 30)
    view = view_of(transport.mesh, camera, size)
    everything = np.arange(len(transport.mesh.positions))
    image = view.image(sum_signed_radiance(transport, rows, view.local(transport.frames), everything))
    expected = drain(image_of(RelightWavelets(transport, rows), camera, size, 2)).image
    assert np.abs(expected).max() > 0.1
    np.testing.assert_allclose(image, expected, atol=1e-6)


def test_bakes_that_share_rays_are_bit_for_bit_those_alone(tmp_path: Path) -> None:
    ground = Ground(cells=3)
    factors = [drain(factors_for(brdf_from_text(text), 2)) for text in ("ggx:alpha=0.4", "lambert")]
    surface = with_ground(BUST, ground)[0]
    kept = [Kept(factors[0], 24), Kept(factors[0], 8), Kept(factors[1], 24)]
    together = drain(bake_together(surface, len(BUST.positions), ground.albedo, 8, kept))
    for number, (each, transport) in enumerate(zip(kept, together, strict=True)):
        work = wavelet_bake.prepare(BUST, each.factors, wavelet_bake.BakeSettings(8, each.coefficients, 4), ground)
        alone = drain(wavelet_bake.bake(tmp_path / f"{number}.transport", work)).transport
        for name in ("indices", "words", "peaks", "counts"):
            np.testing.assert_array_equal(getattr(transport.vectors, name), getattr(alone.vectors, name))


@pytest.mark.parametrize("mesh", [BUST, coarse_bust(5, 7), shape("plane")], ids=["shaded", "coarse", "free"])
def test_light_of_every_order_is_that_of_its_own_bake(mesh: Any, tmp_path: Path) -> None:
    light = project(open_environment("studio"), 4)
    both = drain(light_at_vertices(mesh, [light[:9], light], edge=16))
    for order, found in zip((3, 4), both, strict=True):
        settings = sh_bake.BakeSettings(order, 16, 4)
        work = drain(sh_bake.prepare(mesh, brdf_from_text("phong:exponent=5"), settings))
        transport = drain(sh_bake.bake(tmp_path / f"{order}.transport", work)).transport
        expected = transfer(transport, light[: order**2]).reshape(found.shape)
        # the visibility of order 2 n − 1 that makes a corner of a larger matrix is that of the smaller one
        # and a file keeps it to multiples of STEP, where light in memory is exact
        rounding = 0.5 * STEP * np.abs(light[: order**2]).sum(axis=0).max()
        np.testing.assert_allclose(found, expected, atol=2e-5 + rounding)


def small(**changes: Any) -> Settings:
    return Settings(mesh=changes.pop("mesh", BUST), quick=True, **changes)


def errors_of(figure: Figure) -> list[float]:
    return [shown.error.rmse_rel for row in figure.rows for shown in row.images if shown.error is not None]


def test_more_terms_come_nearer_to_the_analytic_model() -> None:
    for row in drain(wang_2(small())).rows:
        found = [shown.error.rmse_rel for shown in row.images if shown.error is not None]
        assert len(found) == 3
        assert found == sorted(found, reverse=True)
        assert found[0] > 0.1


def test_terms_weighted_by_cosines_come_nearer_than_a_diffuse_surface_and_than_terms_over_a_polar_map() -> None:
    rows = {
        row.heading: [shown.error.rmse_rel for shown in row.images if shown.error]
        for row in drain(wang_5(small())).rows
    }
    weighted = rows["Polar map, weighted by cosines"]
    assert weighted == sorted(weighted, reverse=True)
    assert weighted[1] < rows["Polar map, texels count alike"][1]


def test_a_brushed_surface_is_nearest_to_the_reference_of_its_own_direction() -> None:
    figure = drain(kautz_7(small()))
    images = [[shown.image for shown in row.images] for row in figure.rows]
    for own, other in ((1, 2), (2, 1)):
        apart = [np.abs(images[own][1] - images[which][-1]).mean() for which in (own, other)]
        assert apart[0] < 0.85 * apart[1]


def test_more_coefficients_come_nearer_to_the_reference() -> None:
    figure = drain(wang_3(small()))
    found = errors_of(figure)
    assert found == sorted(found, reverse=True)
    assert [shown.parameters.get("coefficients") for shown in figure.rows[0].images] == [24, 48, 96, None]


def test_higher_orders_come_nearer_and_without_a_window_nearest_to_the_light() -> None:
    figure = drain(kautz_6(small(mesh=shape("plane"))))
    for row in figure.rows:
        low, high, windowed = (shown.error.rmse_rel for shown in row.images[:3] if shown.error)
        assert low > high
        if row.heading == "Light":  # of all sums of these spherical harmonics the projection is the nearest
            assert windowed > high


def test_curves_are_the_errors_of_the_factors_that_they_are_about() -> None:
    figure = drain(wang_4(small()))
    [text] = {line["brdf"] for line in figure.table}
    rms = {(line["map_size"], line["terms"]): line["rms_cosine_weighted"] for line in figure.table}
    brdf, hemisphere_map = brdf_from_text(text), HemisphereMap("orthographic", 16)
    factors = drain(separate(brdf, hemisphere_map, 3, reference=reference(brdf))).factors
    wi, wo = np.abs(np.random.default_rng(5).standard_normal((2, 20_000, 3)))
    signs = np.random.default_rng(6).choice([-1.0, 1.0], (2, 20_000, 2))
    wi[:, :2] *= signs[0]
    wo[:, :2] *= signs[1]
    wi, wo = (each / np.linalg.norm(each, axis=1, keepdims=True) for each in (wi, wo))
    apart = (factors.f(wi, wo) - brdf.f(wi, wo)) * wi[:, 2:]
    assert rms[16, 3] == pytest.approx(np.sqrt(np.mean(apart**2)), rel=0.1)
    assert rms[48, 8] < rms[48, 1]
    assert len(figure.plots) == 1
    assert [shown.error is None for shown in figure.rows[0].images] == [False, True]


def one_image(seed: int = 0) -> Figure:
    rng = np.random.default_rng(seed)
    truth = np.concatenate([rng.random((6, 8, 3)), np.ones((6, 8, 1))], axis=2).astype(np.float32)
    truth[0, :, 3] = 0.5
    variance = 1e-4 * rng.random((6, 8, 3))
    reference = cast(Any, figures).ReferenceImage(truth, variance, 4, 4, 0, 0)
    near = truth + np.float32(0.05) * rng.standard_normal(truth.shape).astype(np.float32) * [1, 1, 1, 0]
    images = figures.compare_with([("near", {"terms": 4}, near.astype(np.float32))], reference, "reference")
    return Figure("test-1", "Title", "Words", (ShownRow("Row", images),))


def steps_of(figure: Figure) -> Steps[Figure]:
    yield Step(0.5, "half")
    return figure


def test_the_stated_error_is_that_of_the_files(tmp_path: Path) -> None:
    record = drain(draw_into(tmp_path / "out", "test-1", steps_of(one_image())))
    folder = tmp_path / "out" / "test-1"
    assert json.loads((folder / MARKER).read_text())["pictures"] == record["pictures"]
    [image, reference] = record["pictures"]
    assert image["reference"] == reference["radiance"]
    a, b = (read_image(folder / "radiance" / each["radiance"]).pixels[1:] for each in (image, reference))
    noise = np.sum(read_variance(folder / "radiance" / reference["radiance"])[1:])
    expected = np.sqrt((np.sum((a - b) ** 2.0) - noise) / (np.sum(b.astype(float) ** 2) - noise))
    assert image["error_rmse_rel"] == pytest.approx(expected, rel=1e-5)
    [line, _] = csv.DictReader((folder / "pictures.csv").open())
    assert float(line["error_rmse_rel"]) == image["error_rmse_rel"]
    assert line["terms"] == "4"


def read_variance(path: Path) -> Any:
    import OpenEXR

    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    return np.stack([channels[f"standard_error.{name}"].pixels.astype(float) ** 2 for name in "RGB"], axis=-1)


def test_a_figure_that_is_not_finished_leaves_the_old_one(tmp_path: Path) -> None:
    drain(draw_into(tmp_path, "test-1", steps_of(one_image(0))))
    before = (tmp_path / "test-1" / MARKER).read_bytes()
    steps = draw_into(tmp_path, "test-1", steps_of(one_image(1)))
    next(steps)
    steps.close()
    assert [path.name for path in tmp_path.iterdir()] == ["test-1"]
    assert (tmp_path / "test-1" / MARKER).read_bytes() == before
    drain(draw_into(tmp_path, "test-1", steps_of(one_image(1))))
    assert (tmp_path / "test-1" / MARKER).read_bytes() != before


def test_a_folder_of_somebody_else_is_refused_before_the_work(tmp_path: Path) -> None:
    (tmp_path / "test-1").mkdir()
    (tmp_path / "test-1" / "letters.txt").write_text("dear")
    with pytest.raises(OutputError, match="not ours"):
        next(draw_into(tmp_path, "test-1", steps_of(one_image())))


def test_files_have_names_of_their_own() -> None:
    image = np.ones((2, 2, 4), np.float32)
    row = ShownRow("Row", tuple(Shown("N = 24 (0.1 %)", image, error=ErrorEstimate(0.1, 0.0)) for _ in range(3)))
    figure = Figure("a", "b", "c", (row, row))
    names = [record["radiance"] for record in records(figure)]
    assert len(set(names)) == 6
    assert names[0] == "1-1-n-24-0-1.exr"


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (ErrorEstimate(0.1234, 0.004), "12.3 ± 0.4 %"),
        (ErrorEstimate(0.0123, 1e-5), "1.23 ± 0.01 %"),
        (ErrorEstimate(0.8, 0.0), "80 %"),
    ],
)
def test_errors_are_reported_with_as_many_digits_as_they_have(error: ErrorEstimate, words: str) -> None:
    assert error_text(error) == words


def test_a_image_of_nothing_is_shown_and_has_no_error() -> None:
    nothing = np.zeros((4, 4, 4), np.float32)
    reference = cast(Any, figures).ReferenceImage(nothing, None, 1, 1, 0, 0)
    images = figures.compare_with([("empty", {}, nothing)], reference, "reference")
    assert images[0].error == ErrorEstimate(0.0, 0.0)
    assert sheet_of(Figure("a", "b", "c", (ShownRow("Row", images),))).any()


def test_a_black_reference_gives_no_relative_error_and_a_file_all_the_same(tmp_path: Path) -> None:
    nothing = np.concatenate([np.zeros((4, 4, 3)), np.ones((4, 4, 1))], axis=2).astype(np.float32)
    reference = cast(Any, figures).ReferenceImage(nothing, None, 1, 1, 0, 0)
    images = figures.compare_with([("lit", {}, np.ones((4, 4, 4), np.float32))], reference, "reference")
    record = drain(draw_into(tmp_path, "test-1", steps_of(Figure("test-1", "b", "c", (ShownRow("Row", images),)))))
    assert [image["error_rmse_rel"] for image in record["pictures"]] == [None, None]


def test_a_black_light_is_drawn_exactly() -> None:
    black = EnvironmentMap(np.zeros((8, 16, 3), np.float32))
    figure = drain(kautz_6(small(mesh=shape("plane"), environment=black)))
    assert set(errors_of(figure)) == {0.0}


def test_the_power_law_is_compared_with_the_slices_that_it_stands_for() -> None:
    figure = drain(shading_map_table(Settings(quick=True)))
    assert [row["paper"] for row in figure.table] == ["suede", "plastic", "wood", "stone"]
    shading_map = drain(_shading_map("hammered", Settings(quick=True)))
    law = drain(fit(shading_map))
    squares = [(law.slice_image(r) - shading_map.slice_image(r)) ** 2 for r in shading_map.target_radiance]
    assert figure.table[-1]["rms"] == pytest.approx(float(np.sqrt(np.mean(squares))), rel=1e-5)
    assert len(figure.extra) == 4
    assert "simulated samples" in figure.subtitle


def test_each_look_up_is_that_of_the_renderer_and_the_last_is_the_measure() -> None:
    figure = drain(shading_map_lookups(Settings(quick=True)))
    assert [[shown.parameters.get("lookup") for shown in row.images] for row in figure.rows] == [
        ["texture", "outgoing", "angle", None]
    ] * 5
    glossy = {shown.parameters.get("lookup"): shown.error for shown in figure.rows[1].images}
    assert glossy[None] is None
    assert all(error is not None and error.rmse_rel > 0.1 for lookup, error in glossy.items() if lookup is not None)
    matte = figure.rows[0].images[-1].image
    assert not np.allclose(matte, figure.rows[1].images[-1].image)

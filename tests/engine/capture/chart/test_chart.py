"""A colour chart: found in drawn photographs, wrong ones refused, colours corrected within ΔE2000 of 1."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from engine.capture.chart.correction import fit_correction, lab_of
from engine.capture.chart.file import as_json, read_chart, save_chart, summary
from engine.capture.chart.find import find_chart
from engine.capture.chart.reference import LAB, REFERENCE_RGB
from engine.core.colour import LUMINANCE, to_display8
from engine.core.colour_difference import delta_e_2000
from engine.core.errors import InputError, UsageError
from tests.engine.capture.chart.chart_images import CAMERA, ILLUMINANTS, photograph


@pytest.mark.parametrize(
    ("one", "other", "difference"),
    [  # Sharma2005, table 1: pairs 1, 4, 7, 9, 13, 15, 17, 21, 25, 31 and 34
        ((50, 2.6772, -79.7751), (50, 0, -82.7485), 2.0425),
        ((50, -1.3802, -84.2814), (50, 0, -82.7485), 1.0000),
        ((50, 0, 0), (50, -1, 2), 2.3669),
        ((50, 2.49, -0.001), (50, -2.49, 0.0009), 7.1792),
        ((50, -0.001, 2.49), (50, 0.0009, -2.49), 4.8045),
        ((50, -0.001, 2.49), (50, 0.0011, -2.49), 4.7461),
        ((50, 2.5, 0), (73, 25, -18), 27.1492),
        ((50, 2.5, 0), (50, 3.1736, 0.5854), 1.0000),
        ((60.2574, -34.0099, 36.2677), (60.4626, -34.1751, 39.4387), 1.2644),
        ((22.7233, 20.0904, -46.694), (23.0331, 14.973, -42.5619), 2.0373),
        ((2.0776, 0.0795, -1.135), (0.9033, -0.0636, -0.5514), 0.9082),
    ],
)
def test_the_published_pairs_of_ciede2000(one: Any, other: Any, difference: float) -> None:
    assert float(delta_e_2000(one, other)) == pytest.approx(difference, abs=1e-4)
    assert float(delta_e_2000(other, one)) == pytest.approx(difference, abs=1e-4)


#: Middles of the patches of a chart from the front.
POSITIONS = np.stack(np.meshgrid(np.arange(6.0), np.arange(4.0)), axis=-1).reshape(-1, 2)


def find(image: Any) -> Any:
    image = np.minimum(image, 1.0)
    return find_chart(image, (image >= 1.0).any(axis=-1))


@pytest.mark.campaign(rounds=3)
@pytest.mark.parametrize("illuminant", ILLUMINANTS)
def test_charts_in_perspective_with_vignetting_and_noise(illuminant: str, seed: int) -> None:
    rng = np.random.default_rng([seed, 7])
    # No camera sees as the eye does: every patch is off by a per cent of each channel.
    seen = REFERENCE_RGB * (1 + rng.normal(0, 0.01, (24, 3)))
    image, _ = photograph(rng, illuminant, seen)
    found = find(image)
    assert found is not None
    _, correction = found
    figures = summary(correction)
    assert figures["after"]["mean"] <= 1.0 < figures["before"]["mean"]
    assert figures["after"]["largest"] <= 3.0
    assert [each["grade"] for each in figures["grades"]] == ["4 stars", "Full"]
    # Colours far from those of the chart are as they were before the camera, but for their brightness.
    colours = rng.uniform(0.05, 0.8, (50, 3))
    shown = correction.apply(((colours * ILLUMINANTS[illuminant]) @ CAMERA.T).astype(np.float32)[None])[0]
    shown = shown * np.median(colours.sum(axis=1) / shown.sum(axis=1))
    assert delta_e_2000(lab_of(shown), lab_of(colours)).mean() <= 1.5


@pytest.mark.campaign(rounds=3)
def test_wrong_charts_are_never_accepted(seed: int) -> None:
    board = np.indices((4, 6)).sum(axis=0).ravel() % 2 * 0.85 + 0.05
    rng = np.random.default_rng([seed, 8])
    random = rng.uniform(0.02, 0.9, (24, 3))
    for colours in (np.repeat(board[:, None], 3, axis=1), random, REFERENCE_RGB[rng.permutation(24)]):
        assert find(photograph(rng, "D50", colours)[0]) is None
    assert find(np.zeros((60, 80, 3), np.float32)) is None
    assert find(rng.uniform(0, 1, (200, 300, 3)).astype(np.float32)) is None


def test_clipped_patches_do_not_count_and_the_correction_keeps_the_luminance_of_white() -> None:
    image, _ = photograph(np.random.default_rng(3), "D50")
    whole = find(image)
    chart, correction = whole
    before = chart.colours[18].astype(np.float32)[None, None]
    after = correction.apply(before)
    assert (after @ LUMINANCE).item() == pytest.approx((before @ LUMINANCE).item(), rel=1e-3)
    clipped = chart.colours.copy()
    clipped[18] = np.nan
    fitted = fit_correction(clipped, chart.positions)
    assert fitted is not None
    assert np.isnan(fitted.after).tolist() == [at == 18 for at in range(24)]
    clipped[:8] = np.nan
    assert fit_correction(clipped, chart.positions) is None


def test_uneven_light_on_the_chart_is_told_from_its_colours() -> None:
    light = np.linspace(0.7, 1.3, 6)[np.arange(24) % 6]
    seen = 0.5 * (REFERENCE_RGB * light[:, None]) @ CAMERA.T
    correction = fit_correction(seen, POSITIONS)
    assert correction is not None
    assert correction.after.max() < 0.5
    assert correction.unevenness == pytest.approx(0.6, abs=0.08)


@pytest.mark.campaign(rounds=3)
def test_colours_that_are_only_like_those_of_a_chart_are_none(seed: int) -> None:
    rng = np.random.default_rng(seed)
    assert fit_correction(REFERENCE_RGB * (1 + rng.normal(0, 0.03, (24, 3))), POSITIONS) is not None
    assert fit_correction(REFERENCE_RGB * np.exp(rng.normal(0, 0.5, (24, 3))), POSITIONS) is None


def test_a_camera_that_no_matrix_describes_gets_root_polynomials() -> None:
    red, green, blue = np.maximum(REFERENCE_RGB, 0).T
    bent = REFERENCE_RGB @ CAMERA.T + 0.25 * np.stack([np.sqrt(red * green), np.sqrt(green * blue), 0 * red], axis=-1)
    correction = fit_correction(bent, POSITIONS)
    assert correction is not None
    assert correction.form == "root-polynomial"
    assert correction.held_out < 1.5
    # Twice the light gives twice the colour.
    some = np.random.default_rng(1).uniform(0, 1, (4, 5, 3)).astype(np.float32)
    np.testing.assert_allclose(correction.apply(2 * some), 2 * correction.apply(some), rtol=1e-4, atol=1e-5)


def test_a_correction_in_a_file(tmp_path: Path) -> None:
    found = find(photograph(np.random.default_rng(5), "A")[0])
    record = as_json(found[1], "chart <b>.tif")
    save_chart(tmp_path / "lamps.chart", record)
    correction, name = read_chart(tmp_path / "lamps.chart")
    assert name == "chart <b>.tif"
    assert as_json(correction, name) == record
    save_chart(tmp_path / "report.html", record)
    page = (tmp_path / "report.html").read_text()
    assert page.count("<tr>") == 25
    images = [base64.b64decode(each) for each in re.findall(r"data:image/png;base64,([^\"]*)", page)]
    decoded = [np.asarray(cv2.imdecode(np.frombuffer(each, np.uint8), cv2.IMREAD_COLOR)) for each in images]
    shown = [each[20:28, 20:28, ::-1] for each in decoded]
    assert found is not None
    near = [to_display8(each[None, None])[0, 0] for each in found[1].measured]
    off = [np.abs(one.mean(axis=(0, 1)) - other).max() for one, other in zip(shown, near, strict=True)]
    assert len(off) == 24
    assert max(off) < 16.0  # vignetting, which the measured colours are without
    assert "chart &lt;b&gt;.tif" in page
    assert "<b>.tif" not in page
    with pytest.raises(UsageError, match=r"not to \.txt"):
        save_chart(tmp_path / "a.txt", record)
    changes: list[dict[str, Any]] = [
        {"form": "magic"},
        {"matrix": [[1e9, 0, 0]] * 3},
        {"matrix": [[1, 0]] * 3},
        {"patches": []},
        {"patches": [{**record["patches"][0], "crop": "A"}, *record["patches"][1:]]},
        {"patches": [{**record["patches"][0], "crop": '"><script>'}, *record["patches"][1:]]},
    ]
    for change in changes:
        (tmp_path / "wrong.chart").write_text(json.dumps({**record, **change}))
        with pytest.raises(InputError, match="does not hold a chart"):
            read_chart(tmp_path / "wrong.chart")


def test_references_agree_with_those_of_opencv() -> None:
    """Which has the chart of before 2014, as 8-bit sRGB."""
    detector = cv2.mcc.CCheckerDetector.create()
    detector.setColorChartType(cv2.mcc.MCC24)
    codes = np.asarray(detector.getRefColors(), np.float64).reshape(24, 3)[:, ::-1] / 255
    linear = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
    assert np.median(delta_e_2000(lab_of(linear), LAB)) < 2.5

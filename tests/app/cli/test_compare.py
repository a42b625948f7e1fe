"""`lightarc compare` as a script meets it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from engine.images.decode import read_image
from engine.images.encode import encode_png, rgb_channels, write_exr

Run = Callable[..., SimpleNamespace]

RADIANCE = (0.05 + np.random.default_rng(1).random((24, 32, 3))).astype(np.float32)


def exr(path: Path, radiance: np.ndarray) -> Path:
    write_exr(path, rgb_channels(radiance), half=False)
    return path


def compare_with(lightarc: Run, *words: object) -> dict:
    done = lightarc("compare", *words, "--json")
    assert done.code == 0, done.err
    return json.loads(done.out)


def test_a_gain_of_ten_percent(lightarc: Run, tmp_path: Path) -> None:
    a, b = exr(tmp_path / "a.exr", 1.1 * RADIANCE), exr(tmp_path / "b.exr", RADIANCE)
    found = compare_with(lightarc, a, b)
    assert found["rmse_rel"] == pytest.approx(0.1, rel=1e-5)
    assert found["max_abs"] == pytest.approx(0.1 * RADIANCE.max(), rel=1e-4)
    assert found["pixels"] == 24 * 32
    assert 0.0 < found["flip"] < 0.2
    assert (found["invalid_pixels"], found["flip_range"], found["warnings"]) == (0, "radiance", [])


def test_a_image_and_itself(lightarc: Run, tmp_path: Path) -> None:
    a = exr(tmp_path / "a.exr", RADIANCE)
    found = compare_with(lightarc, a, a)
    assert (found["rmse_rel"], found["flip"], found["max_abs"]) == (0.0, 0.0, 0.0)
    assert "0 %" in lightarc("compare", a, a).out


def test_a_mask_and_the_image_of_the_difference(lightarc: Run, tmp_path: Path) -> None:
    other = RADIANCE.copy()
    other[:, :16] *= 3.0
    other[:12, 16:] *= 0.5
    a, b = exr(tmp_path / "a.exr", other), exr(tmp_path / "b.exr", RADIANCE)
    mask = np.zeros((24, 32), np.uint8)
    mask[:12, 16:], mask[12:] = 255, 100
    (tmp_path / "mask.png").write_bytes(encode_png(mask))
    found = compare_with(lightarc, a, b, "--mask", tmp_path / "mask.png", "--difference", tmp_path / "d.png")
    assert found["pixels"] == 12 * 16
    assert found["rmse_rel"] == pytest.approx(0.5, rel=1e-5)
    assert found["difference_scale_radiance"] in (0.5, 1.0)
    shown = read_image(tmp_path / "d.png").pixels
    assert shown.shape == (24 + 56, 256, 3)
    left = (256 - 32) // 2
    assert shown[5, left + 20, 2] > shown[5, left + 20, 0], "darker than the reference is blue"
    assert np.ptp(shown[20, left + 4]) < 0.01, "outside the mask nothing is said"


def test_what_is_not_finite_is_counted_and_said(lightarc: Run, tmp_path: Path) -> None:
    broken = RADIANCE.copy()
    broken[0, :5] = np.nan
    broken[1, 0] = np.inf
    a, b = exr(tmp_path / "a.exr", broken), exr(tmp_path / "b.exr", RADIANCE)
    found = compare_with(lightarc, a, b)
    assert (found["invalid_pixels"], found["pixels"], found["rmse_rel"]) == (6, 24 * 32 - 6, 0.0)
    assert any("6 pixels" in words for words in found["warnings"])


def test_a_black_reference_has_no_relative_error(lightarc: Run, tmp_path: Path) -> None:
    black, a = exr(tmp_path / "black.exr", 0 * RADIANCE), exr(tmp_path / "a.exr", RADIANCE)
    found = compare_with(lightarc, a, black)
    assert found["rmse_rel"] is None
    assert any("is black" in words for words in found["warnings"])
    assert compare_with(lightarc, black, black)["rmse_rel"] == 0.0
    assert "–" in lightarc("compare", a, black).out


def test_images_for_the_screen_are_compared_as_such(lightarc: Run, tmp_path: Path) -> None:
    for name, value in (("a.png", 255), ("b.png", 0)):
        (tmp_path / name).write_bytes(encode_png(np.full((16, 16, 3), value, np.uint8)))
    found = compare_with(lightarc, tmp_path / "b.png", tmp_path / "a.png")
    assert found["flip_range"] == "displayed"
    assert found["rmse_rel"] == 1.0
    assert found["flip"] == pytest.approx(0.967, abs=1e-3)
    mixed = compare_with(lightarc, exr(tmp_path / "c.exr", RADIANCE[:16, :16]), tmp_path / "a.png")
    assert mixed["flip_range"] == "radiance"
    assert len(mixed["warnings"]) == 1


@pytest.mark.parametrize("case", ["sizes", "mask size", "mask empty", "missing", "text", "nothing finite"])
def test_what_cannot_be_compared_is_refused_in_words(lightarc: Run, tmp_path: Path, case: str) -> None:
    a, b = exr(tmp_path / "a.exr", RADIANCE), exr(tmp_path / "b.exr", RADIANCE)
    words: list[object] = [a, b]
    if case == "sizes":
        words[0] = exr(tmp_path / "small.exr", RADIANCE[:10])
    elif case == "mask size":
        words += ["--mask", exr(tmp_path / "mask.exr", RADIANCE[:, :10])]
    elif case == "mask empty":
        words += ["--mask", exr(tmp_path / "mask.exr", 0 * RADIANCE)]
    elif case == "missing":
        words[1] = tmp_path / "none.exr"
    elif case == "text":
        (tmp_path / "b.exr").write_text("not an image")
    else:
        words[0] = exr(tmp_path / "nan.exr", np.nan * RADIANCE)
    done = lightarc("compare", *words, "--difference", tmp_path / "d.png", "--json")
    assert (done.code, done.out) == (3, "")
    assert "Traceback" not in done.err
    assert len(done.err.strip().splitlines()) == 1
    assert not (tmp_path / "d.png").exists()


def test_a_difference_that_is_no_png_is_wrong_usage(lightarc: Run, tmp_path: Path) -> None:
    a = exr(tmp_path / "a.exr", RADIANCE)
    done = lightarc("compare", a, a, "--difference", tmp_path / "d.jpg")
    assert done.code == 2
    assert ".png" in done.err

"""Dark frame, flat field and near lamp against simulated photographs with known ground truth."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.capture.photograph.calibrate import flat_field_gain, near_lamp_gain
from engine.capture.photograph.calibration import Calibration
from engine.capture.photograph.decode import read_photograph
from engine.images.encode import write_exr


def test_vignetting_and_dark_current_are_divided_out() -> None:
    random = np.random.default_rng(0)
    truth = random.uniform(0.1, 0.9, (40, 60, 3)).astype(np.float32)
    y, x = np.mgrid[-1:1:40j, -1:1:60j]
    fall_off = np.array(1 / (1 + 0.4 * (x * x + y * y)) ** 2, np.float32)[..., None]
    dark = random.uniform(0, 0.02, truth.shape).astype(np.float32)
    gain, unknown = flat_field_gain(0.8 * fall_off + dark, dark)
    assert not unknown.any()
    recovered = (truth * fall_off + dark - dark) * gain
    ratio = recovered / truth
    np.testing.assert_allclose(ratio, ratio.mean(), rtol=1e-5)
    assert ratio.mean() == pytest.approx(fall_off.mean(), rel=1e-5)


def test_the_mean_of_the_flat_field_is_kept() -> None:
    flat = np.random.default_rng(1).uniform(0.4, 0.6, (20, 20, 3)).astype(np.float32)
    gain, _ = flat_field_gain(flat)
    np.testing.assert_allclose(flat * gain, np.broadcast_to(flat.mean(axis=(0, 1)), flat.shape), rtol=1e-5)


def test_dead_parts_of_a_flat_field_are_named_not_amplified() -> None:
    flat = np.full((10, 10, 3), 0.5, np.float32)
    flat[2, 3, 1] = 0.0
    gain, unknown = flat_field_gain(flat)
    assert np.argwhere(unknown).tolist() == [[2, 3]]
    np.testing.assert_array_equal(gain[2, 3], 1)


def test_flat_fields_without_light_or_of_another_size_are_refused() -> None:
    black = np.zeros((4, 4, 3), np.float32)
    with pytest.raises(ValueError, match="not brighter"):
        flat_field_gain(black)
    with pytest.raises(ValueError, match="dark frame is 5 x 4"):
        flat_field_gain(black + 1, np.zeros((4, 5, 3), np.float32))


@pytest.mark.parametrize("azimuth", [0.0, np.pi / 2, 2.5])
def test_near_lamp_against_point_light_by_hand(azimuth: float) -> None:
    height, width, distance, elevation = 30, 50, 1.5, 0.6
    gain = near_lamp_gain(height, width, distance, elevation, azimuth)
    lamp = distance * np.array(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    )
    for row, column in ((0, 0), (29, 0), (7, 44)):
        point = np.array([(column + 0.5) / width - 0.5, (height / 2 - row - 0.5) / width, 0])
        away = lamp - point
        irradiance = away[2] / np.linalg.norm(away) ** 3
        distant = np.sin(elevation) / distance**2
        assert irradiance * gain[row, column] == pytest.approx(distant, rel=1e-6)


@pytest.mark.parametrize("distance", [1e6, 1e300])
def test_a_distant_lamp_needs_no_gain(distance: float) -> None:
    np.testing.assert_allclose(near_lamp_gain(8, 8, distance, 0.7), 1, rtol=1e-5)


def test_a_lamp_on_the_sample_is_refused() -> None:
    with pytest.raises(ValueError, match="touch"):
        near_lamp_gain(8, 8, 0.4, 0.7)


def test_a_flat_field_alone_is_applied_and_an_empty_calibration_changes_nothing(tmp_path: Path) -> None:
    write_exr(tmp_path / "a.exr", {name: np.full((3, 4), 0.25, np.float32) for name in "RGB"})
    photograph = read_photograph(tmp_path / "a.exr")
    assert Calibration().applied(photograph, 1.0, 0.0, 1.0) is photograph
    gain = np.linspace(0.5, 2.0, 36, dtype=np.float32).reshape(3, 4, 3)
    found = Calibration(gain=gain).applied(photograph, 1.0, 0.0, 1.0)
    np.testing.assert_allclose(found.radiance, 0.25 * gain, rtol=1e-6)

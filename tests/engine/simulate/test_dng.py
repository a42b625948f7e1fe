"""DNG files as LibRaw and an EXIF reader see them."""

from __future__ import annotations

import io
from typing import Any

import exifread
import numpy as np
import pytest
import rawpy
from numpy.typing import NDArray

from engine.simulate import camera


def noise_image(rows: int = 62, columns: int = 94) -> NDArray[np.float32]:
    return np.random.default_rng(5).uniform(0, 1, (rows, columns, 3)).astype(np.float32)


def write(levels: Any, image: Any) -> tuple[Any, Any]:
    samples = camera.quantise(camera.mosaic(image, levels.neutral), levels)
    return samples, io.BytesIO(camera.dng_bytes(samples, levels, exposure_s=1 / 60))


@pytest.mark.parametrize("black", [((512, 512), (512, 512)), ((500, 512), (520, 530)), ((0, 0), (0, 0))])
@pytest.mark.parametrize(("rows", "columns"), [(62, 94), (63, 95)])
def test_libraw_gives_back_every_sample_and_level(black: Any, rows: int, columns: int) -> None:
    levels = camera.Levels(black=black, white=16383)
    samples, file = write(levels, noise_image(rows, columns))
    with rawpy.imread(file) as raw:
        assert np.array_equal(raw.raw_image_visible, samples)
        site_black = np.array(raw.black_level_per_channel)[raw.raw_pattern]
        assert np.array_equal(site_black, black)
        assert raw.white_level == 16383
        np.testing.assert_allclose(raw.camera_whitebalance[:3], [2.0, 1.0, 1.6], rtol=1e-6)


def test_black_subtracted_values_are_the_signal_to_half_a_sample() -> None:
    levels = camera.Levels(black=((500, 512), (520, 530)))
    image = noise_image()
    samples, _ = write(levels, image)
    black = np.tile(np.array(levels.black), (31, 47))
    value = (samples.astype(float) - black) / (levels.white - black)
    signal = camera.mosaic(image, levels.neutral)
    assert np.abs(value - signal).max() <= 0.5001 / (levels.white - 530)


def test_converter_gives_back_the_linear_image() -> None:
    image = np.broadcast_to(np.array([0.4, 0.3, 0.2], np.float32), (64, 64, 3))
    _, file = write(camera.Levels(), image)
    with rawpy.imread(file) as raw:
        linear = raw.postprocess(gamma=(1, 1), no_auto_bright=True, use_camera_wb=True, output_bps=16) / 65535
    np.testing.assert_allclose(linear[20:40, 20:40].mean(axis=(0, 1)), image[0, 0], rtol=2e-3)


def test_exposure_is_in_the_exif_directory() -> None:
    _, file = write(camera.Levels(), noise_image())
    tags = exifread.process_file(file)
    assert str(tags["EXIF ExposureTime"]) == "1/60"
    assert str(tags["EXIF ISOSpeedRatings"]) == "100"


def test_signal_is_held_within_the_samples_range() -> None:
    levels = camera.Levels()
    samples = camera.quantise(np.array([[-1.0, 2.0], [0.0, 1.0]], np.float32), levels)
    assert samples.tolist() == [[0, 16383], [512, 16383]]


def test_impossible_levels_are_refused() -> None:
    with pytest.raises(ValueError, match="below white"):
        camera.Levels(black=((512, 512), (512, 600)), white=512)
    with pytest.raises(ValueError, match="neutral"):
        camera.Levels(neutral=(0.5, 1.2, 0.5))

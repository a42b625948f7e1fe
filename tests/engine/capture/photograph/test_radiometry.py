"""Hard cases R1–R5, R7–R10 on arrays; the same through files stands in test_raw.py."""

import itertools
from typing import Any, cast

import numpy as np
import pytest

from engine.capture.photograph import demosaic, radiometry
from engine.capture.photograph.bayer import develop, is_bayer
from engine.images.colour_space import LINEAR_CURVE, ColourSpace
from engine.images.decode import _linear
from engine.images.exif import rational
from engine.images.raster import Raster, white_code
from tests.present import present

RNG = np.random.default_rng(23)
BAYER = np.array([[0, 1], [1, 2]])
X_TRANS = np.array(
    [
        *([1, 2, 1, 1, 0, 1], [0, 1, 0, 2, 1, 2], [1, 2, 1, 1, 0, 1]),
        *([1, 0, 1, 1, 2, 1], [2, 1, 2, 0, 1, 0], [1, 0, 1, 1, 2, 1]),
    ]
)


def develop_mosaic(mosaic: Any, colours: Any = BAYER, white: float = np.inf) -> tuple[Any, Any]:
    """Colour and mask of a Bayer mosaic whose samples are radiance already."""
    radiance, saturated = np.empty((*mosaic.shape, 3), np.float32), np.empty(mosaic.shape, bool)
    zero, one, most = (np.full((2, 2), value, float) for value in (0, 1, white))
    develop(
        mosaic, zero, one, most, np.ascontiguousarray(colours), np.eye(3, dtype=np.float32), 0, 0, radiance, saturated
    )
    return radiance, saturated


def test_R1_samples_below_black_stay_negative() -> None:
    samples = np.array([[500, 512, 4095]], np.uint16)
    radiance = radiometry.linearise(samples, 512, 4095)
    assert radiance[0].tolist() == [np.float32((500 - 512) / (4095 - 512)), 0, 1]


def test_R1_a_dark_frame_averages_to_zero() -> None:
    sigma, count = 8.0, 400 * 600
    samples = np.clip(np.rint(RNG.normal(512, sigma, (400, 600))), 0, 65535).astype(np.uint16)
    radiance = radiometry.linearise(samples, 512, 16383).astype(np.float64) * (16383 - 512)
    assert abs(radiance.mean()) <= 4 * sigma / np.sqrt(count)
    full, _ = develop_mosaic(radiance.astype(np.float32))
    assert abs(full.mean(dtype=np.float64)) <= 4 * sigma / np.sqrt(count) + 1e-2


@pytest.mark.parametrize(("black", "white"), [(512, 512), (512, 100), (0, 0), (np.nan, 4095), (0, np.inf)])
def test_R2_white_not_above_black_is_refused_with_both_values(black: float, white: float) -> None:
    with pytest.raises(ValueError, match=r"white level .* black level"):
        radiometry.linearise(np.ones((2, 2), np.uint16), black, white)


def test_R3_saturation_mask_is_exact() -> None:
    samples = RNG.integers(0, 4000, (61, 83)).astype(np.uint16)
    clipped = RNG.random(samples.shape) < 0.01
    samples[clipped] = 4095
    assert np.array_equal(radiometry.at_white(samples, 4095), clipped)
    whites = np.array([[4095, 3990], [3980, 4000]])
    truth = samples >= np.tile(whites, (31, 42))[:61, :83]
    assert np.array_equal(radiometry.at_white(samples, whites), truth)


def test_R3_mask_marks_the_pixels_that_a_clipped_sample_enters_and_no_other() -> None:
    for row, column in itertools.product((10, 11), (20, 21)):
        mosaic = np.zeros((32, 48), np.float32)
        mosaic[row, column] = 1
        full, marked = develop_mosaic(mosaic, white=1)
        changed = (full != 0).any(axis=2)
        assert not (changed & ~marked).any()
        assert marked.sum() == 13


@pytest.mark.parametrize("shape", [(8, 8), (7, 9), (9, 7), (1, 5)])
@pytest.mark.parametrize("offset", [(0, 0), (1, 0), (0, 1), (1, 1)])
def test_R4_per_site_black_levels(shape: Any, offset: Any) -> None:
    black = np.array([[60.0, 61.0], [62.0, 67.0]])
    white = np.array([[4095.0, 4000.0], [4001.0, 4090.0]])
    crop = np.roll(black, tuple(-o for o in offset), (0, 1)), np.roll(white, tuple(-o for o in offset), (0, 1))
    samples = RNG.integers(0, 4096, shape).astype(np.uint16)
    expected = np.empty(shape, np.float32)
    for row, column in np.ndindex(shape):
        low, high = (levels[(row + offset[0]) % 2, (column + offset[1]) % 2] for levels in (black, white))
        expected[row, column] = np.float32((float(samples[row, column]) - low) * (1 / (high - low)))
    assert np.array_equal(radiometry.linearise(samples, *crop), expected)


def test_R5_low_and_high_aligned_12_bit_are_the_same_image() -> None:
    low = RNG.integers(0, 4096, (50, 60)).astype(np.uint16)
    low[0, 0] = 4095
    high = low << 4
    assert white_code(cast(Any, high), 16) == 65520
    of_low, of_high = radiometry.linearise(low, 0, 4095), radiometry.linearise(high, 0, white_code(cast(Any, high), 16))
    assert np.all(np.abs(of_low - of_high) <= 2.0**-24 * of_low)
    rasters = [Raster(codes, white, 16, "linear", "TIFF") for codes, white in ((low, 4095), (high, 65520))]
    images = [_linear(raster, ColourSpace("", (LINEAR_CURVE,)), 1)[0] for raster in rasters]
    assert np.all(np.abs(images[0] - images[1]) <= 2.0**-24 * images[0])


def test_R5_few_values_are_not_mistaken_for_a_shift() -> None:
    assert white_code(np.full((4, 4), 0x8000, np.uint16), 16) == 65535
    assert white_code(np.zeros((4, 4), np.uint16), 16) == 65535
    assert white_code(RNG.integers(0, 65536, (50, 50)).astype(np.uint16), 16) == 65535


def test_R7_bad_multipliers_are_recognised() -> None:
    for bad in ((0, 1, 1), (1, np.nan, 1), (2, 1, -1), (1, np.inf, 1), (1, 1), (1e9, 1, 1)):
        assert radiometry.white_balance(bad) is None
    assert present(radiometry.white_balance((2.0, 1.0, 1.5, 0.0))).tolist() == [2, 1, 1.5]
    assert present(radiometry.white_balance((4, 2, 3))).tolist() == [2, 1, 1.5]


def test_R8_merge_recovers_radiance_and_flags_what_no_exposure_saw() -> None:
    truth = np.exp(RNG.uniform(np.log(1e-3), np.log(200), (40, 50, 1))) * np.array([1, 0.8, 0.6], np.float32)
    truth[0, 0], truth[0, 1] = 1e6, 0
    frames: list[Any] = []
    for exposure_s in (1.0, 1 / 16, 1 / 256):
        noisy = truth * exposure_s + RNG.normal(0, 1e-6, truth.shape)
        frame = np.minimum(noisy, 1).astype(np.float32)
        frame[0, 1] = -1e-6
        frames.append((frame, (frame >= 1).any(axis=2), exposure_s))
    merged = radiometry.merge_exposures(iter(frames))
    assert merged.saturated[0, 0]
    assert merged.saturated.sum() == (truth * (1 / 256) >= 1).any(axis=2).sum()
    assert merged.radiance[0, 0] == pytest.approx([256] * 3)
    assert merged.black[0, 1]
    assert merged.radiance[0, 1].tolist() == [0, 0, 0]
    seen = ~merged.saturated & ~merged.black
    assert np.all(np.abs(merged.radiance - truth)[seen] <= 0.01 * truth[seen])
    assert np.isfinite(merged.radiance).all()


def test_R8_impossible_exposures_are_wrong_calls() -> None:
    frame = np.ones((2, 2, 3), np.float32), np.zeros((2, 2), bool)
    for exposure_s in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match="exposure time"):
            radiometry.merge_exposures([(*frame, exposure_s)])
    with pytest.raises(ValueError, match="differ in size"):
        radiometry.merge_exposures([(*frame, 1.0), (np.ones((3, 2, 3), np.float32), np.zeros((3, 2), bool), 1.0)])
    with pytest.raises(ValueError, match="no exposures"):
        radiometry.merge_exposures([])


def test_R9_impossible_rationals_are_unknown() -> None:
    for numerator, denominator in ((0, 0), (1, 0), (0, 1), (np.nan, 1), (-1, 60), (1e300, 1), (1e-300, 1)):
        assert rational(numerator, denominator) is None
    assert rational(1, 60) == 1 / 60


def test_R10_mean_of_24_megapixels_is_accumulated_in_float64() -> None:
    row = np.full((1, 6000, 3), 0.1, np.float32)
    image = np.broadcast_to(row, (4000, 6000, 3))
    assert radiometry.mean_radiance(image) == pytest.approx(float(np.float32(0.1)), rel=1e-7)


def test_bayer_reproduces_a_linear_gradient_inside() -> None:
    rows, columns = np.mgrid[0:40, 0:50].astype(np.float32)
    truth = np.stack([rows + columns, 2 * rows + columns, 3 * columns - rows], axis=-1) * np.array(
        [1, 1, 1], np.float32
    )
    grey = (rows + 2 * columns)[..., None] * np.ones(3, np.float32)
    for image, tolerance in ((grey, 1e-4), (np.ones_like(truth), 1e-6)):
        for colours in (BAYER, BAYER[:, ::-1], BAYER[::-1], 2 - BAYER):
            sites = np.tile(colours, (20, 25))
            mosaic = np.take_along_axis(image, sites[..., None], axis=2)[..., 0]
            full, _ = develop_mosaic(mosaic, colours)
            assert np.abs(full - image)[2:-2, 2:-2].max() <= tolerance


def test_demosaic_gives_the_same_for_any_strip_height(monkeypatch: pytest.MonkeyPatch) -> None:
    mosaic = RNG.random((67, 41)).astype(np.float32)
    whole = demosaic.demosaic(mosaic, X_TRANS)
    for rows in (1, 7, 16, 33):
        monkeypatch.setattr(demosaic, "_STRIP_ROWS", rows)
        assert np.array_equal(demosaic.demosaic(mosaic, X_TRANS), whole)


def test_demosaic_of_other_arrays_keeps_constants_and_own_samples() -> None:
    assert not is_bayer(X_TRANS)
    assert np.abs(demosaic.demosaic(np.full((30, 31), 0.5, np.float32), X_TRANS) - 0.5).max() <= 1e-6
    mosaic = RNG.random((600, 13)).astype(np.float32)
    full = demosaic.demosaic(mosaic, X_TRANS)
    sites = np.tile(X_TRANS, (100, 3))[:, :13]
    assert np.array_equal(np.take_along_axis(full, sites[..., None], axis=2)[..., 0], mosaic)


def test_R3_mask_of_other_arrays_covers_what_a_clipped_sample_enters() -> None:
    mosaic = np.zeros((32, 48), np.float32)
    mosaic[10, 20] = 1
    changed = (demosaic.demosaic(mosaic, X_TRANS) != 0).any(axis=2)
    assert not (changed & ~demosaic.spread(mosaic == 1)).any()

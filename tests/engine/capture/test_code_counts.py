"""Tallies of photographs by numbers of their codes are those of the pixels, bit for bit."""

from __future__ import annotations

import numpy as np
import pytest

from engine.capture.code_counts import DARK, CodeCounts
from engine.capture.coded_pixels import Curve, Decoding, FallOff, count_by_codes
from engine.capture.tally import Tally
from engine.core.colour import srgb_decode

SRGB = srgb_decode(np.arange(256) / 255.0).astype(np.float32)
LINEAR = (np.arange(256) / 255.0).astype(np.float32)


def count(codes: np.ndarray, white: int, step: int, rows: int) -> CodeCounts:
    found = CodeCounts(white, step, codes.shape[1])
    for first in range(0, len(codes), rows):
        found.add(codes[first : first + rows], first)
    return found


def tally_of_pixels(codes: np.ndarray, tables: np.ndarray, white: int, step: int) -> Tally:
    every = np.broadcast_to(codes, (*codes.shape[:2], 3))
    radiance = np.stack([tables[channel, every[..., channel]] for channel in range(3)], axis=-1)
    found = Tally(step)
    found.add(radiance, np.asarray((every >= white).any(axis=-1)), 0)
    return found


@pytest.mark.parametrize("seed", range(40))
def test_a_tally_by_codes_is_that_of_the_pixels(seed: int) -> None:
    random = np.random.default_rng(seed)
    shape = int(random.integers(1, 90)), int(random.integers(1, 3000 if seed % 8 == 0 else 120))
    codes = np.clip(
        random.normal(random.uniform(0, 255), random.uniform(1, 90), (*shape, random.choice([1, 3]))), 0, 255
    )
    codes = codes.astype(np.uint8)
    white, step = int(random.integers(200, 257)), int(random.integers(1, 9))
    curve = Curve((SRGB if random.random() < 0.7 else LINEAR)[None], white)
    red, green, blue = (float(np.float32(each)) for each in random.uniform(0.5, 2.0, 3))
    factors = red, green, blue
    decoding = Decoding(curve, factors, gain=float(np.float32(random.uniform(0.6, 1.7))))
    told = count_by_codes(count(codes, white, step, int(random.integers(1, 40))), decoding)
    assert told is not None
    tables = curve.tables * np.array(factors, np.float32)[:, None] * np.float32(decoding.gain)
    seen = tally_of_pixels(codes, tables, white, step)
    pixels = shape[0] * shape[1]
    assert told.mean_radiance(pixels) == seen.mean_radiance(pixels)
    assert (told.clipped, told.black) == (seen.clipped, seen.black)
    assert np.array_equal(np.concatenate(told.grid), np.concatenate(seen.grid))


@pytest.mark.parametrize(
    "decoding",
    [
        Decoding(Curve(SRGB[None], 255, np.eye(3, dtype=np.float32))),
        Decoding(Curve(SRGB[None], 255), found=FallOff(2.0, 0.5, 0.1)),
        Decoding(Curve(SRGB[None], 255), stated=FallOff(2.0, 0.5, 0.1)),
        Decoding(Curve(SRGB[None], 254)),
        Decoding(Curve(SRGB[None], 255), gain=0.01),
        Decoding(Curve((SRGB - np.float32(0.01))[None], 255)),
        Decoding(Curve(np.where(np.arange(256) == 3, np.float32(1e-20), SRGB)[None], 255)),
    ],
    ids=["matrix", "near lamp", "stated lamp", "white", "dark", "below black", "sums that depend on their order"],
)
def test_codes_that_do_not_tell_the_tally_are_not_used(decoding: Decoding) -> None:
    codes = np.random.default_rng(1).integers(0, 256, (40, 50, 3), np.uint8)
    assert count_by_codes(count(codes, 255, 4, 7), decoding) is None


def test_pixels_are_dark_by_all_channels() -> None:
    """Of pixels with the least code that is not counted as dark none is black, and with those below all are counted."""
    for channel, least in enumerate(DARK):
        codes = np.zeros((1, 2, 3), np.uint8)
        codes[0, 0, channel], codes[0, 1, channel] = least, least - 1
        found = count(codes, 255, 1, 1)
        assert found.of_dark.sum() == 1

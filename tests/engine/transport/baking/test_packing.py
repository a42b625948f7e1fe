"""Blocks of arrays: every number comes back, in few bytes where numbers are as bakes make them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.transport.baking.packing import Block, pack_block, unpack_block
from engine.transport.wavelet.quantise import pack, quantise

RNG = np.random.default_rng(5)


def packed(values: NDArray[Any]) -> Block:
    """The block of `values`, which come back from it bit for bit."""
    content = np.ascontiguousarray(values).reshape(-1).view(np.uint8)
    block = pack_block(content, values.dtype.str)
    found = np.full(len(content), 7, np.uint8)
    unpack_block(block, values.dtype.str, found)
    assert np.array_equal(found, content)
    return block


def rising(count: int) -> NDArray[np.uint16]:
    return np.sort(RNG.integers(0, 24576, (count, 96)), axis=1).astype("<u2")


@pytest.mark.parametrize(
    "values",
    [
        np.array([], "<f4"),
        np.array([-0.0, 0.0, np.inf, -np.inf, np.nan, 1e-45, -3e38], "<f4"),
        np.array([-0.0, 1.0], "<f4"),
        np.array([16.0, -16.0, 2.0**-11, -(2.0**-11)], "<f4"),
        np.array([2.0**-120, -(2.0**-121), 0.0], "<f4"),
        RNG.standard_normal(50_000).astype("<f4"),
        RNG.standard_normal(5_000),
        RNG.integers(0, 1 << 32, 50_000).astype("<u4"),
        RNG.integers(0, 1 << 16, 50_000).astype("<u2"),
        RNG.integers(-(1 << 15), 1 << 15, 999).astype("<i2"),
        RNG.integers(-(1 << 31), 1 << 31, 999).astype("<i4"),
        RNG.integers(0, 2, 77) > 0,
        np.arange(99, dtype="<i8"),
    ],
    ids=lambda values: f"{values.dtype.str}-{values.size}",
)
def test_any_number_comes_back(values: NDArray[Any]) -> None:
    packed(values)


def test_words_of_three_codes_take_the_bits_that_differ() -> None:
    codes = np.round(RNG.laplace(0.0, 20.0, (40_000, 1))).clip(-127, 127).astype(int) * np.array([8, 8, 4])
    near = (codes + np.array([0, 8, 4]) * RNG.integers(-1, 2, (40_000, 3))).clip(
        [-1016] * 2 + [-508], [1016] * 2 + [508]
    )
    grey, coloured = packed(pack(codes)), packed(pack(near))
    probability = np.unique(codes[:, 0], return_counts=True)[1] / len(codes)
    entropy = -float(probability @ np.log2(probability)) / 8.0
    assert entropy < len(grey.packed) / len(codes) < 1.05 * entropy
    assert len(coloured.packed) < len(grey.packed) + len(codes) * 2 * np.log2(3.0) / 8.0 * 1.5
    corners = np.array(np.meshgrid([-1024, -1, 0, 1, 1023], [-1024, -1, 0, 1, 1023], [-512, -1, 0, 1, 511]))
    packed(pack(corners.reshape(3, -1).T))


def test_indices_that_rise_and_rounded_coefficients_take_fewer_bytes() -> None:
    indices = rising(1000)
    entropy = math.log2(math.comb(24576, 96)) / 8.0 / 96.0
    assert entropy < len(packed(indices).packed) / indices.size < 1.2 * entropy
    rounded = (np.round(RNG.laplace(0.0, 0.02, 100_000) * 2048) / 2048 + 0.0).astype("<f4")
    assert len(packed(rounded).packed) < 0.27 * rounded.nbytes


@pytest.mark.parametrize("dtype", ["<f4", "<u4", "<u2", "|u1", "<f8"])
def test_damaged_blocks_are_refused_or_are_other_numbers(dtype: str) -> None:
    """A checksum of the file finds the latter; nothing else may happen, and nothing is written beside the target."""
    values = quantise(RNG.standard_normal((64, 96, 3)))[0].view(np.uint8)
    block = pack_block(values.reshape(-1), dtype)
    for number in range(300):
        content = bytearray(block.packed)
        content[int(RNG.integers(len(content)))] ^= 1 << int(RNG.integers(8))
        form = block.form if number % 3 else int(RNG.integers(256))
        shifts: Any = tuple(RNG.integers(0, 256, 3).tolist()) if number % 2 else block.shifts
        around = np.full(values.size + 16, 7, np.uint8)
        try:
            unpack_block(Block(bytes(content), form, shifts), dtype, around[8:-8])
        except ValueError as error:
            assert "block" in str(error)  # noqa: PT017 - both outcomes are allowed
        assert (around[:8] == 7).all()
        assert (around[-8:] == 7).all()


def test_a_block_that_unpacks_to_more_than_its_share_is_refused() -> None:
    block = pack_block(np.zeros(1 << 20, np.uint8), "<f4")
    for size in (1 << 18, 1 << 22):
        with pytest.raises(ValueError, match="block"):
            unpack_block(block, "<f4", np.empty(size, np.uint8))

"""CRC-32 of arrays, and of two pieces after each other: that of zlib, which reads them."""

from __future__ import annotations

import zlib

import numpy as np
import pytest

from engine.storage.crc32 import extend_crc32, join_crc32


@pytest.mark.parametrize("sizes", [(0, 0), (0, 5), (7, 0), (1, 1), (300, 4097), (65536, 12345)])
def test_pieces_have_the_checksum_of_the_whole(sizes: tuple[int, int]) -> None:
    random = np.random.default_rng(sum(sizes))
    first, second = (random.bytes(size) for size in sizes)
    assert join_crc32(zlib.crc32(first), zlib.crc32(second), len(second)) == zlib.crc32(first + second)


@pytest.mark.parametrize("shape", [(0,), (3,), (5, 7, 3)])
def test_checksums_are_those_of_zlib(shape: tuple[int, ...]) -> None:
    array = np.random.default_rng(1).random(shape, np.float32)
    array.flags.writeable = False
    assert extend_crc32(77, array.data) == zlib.crc32(array.data, 77)
    assert extend_crc32(0, array.data) == zlib.crc32(array.data)

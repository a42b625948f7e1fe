"""CRC-32 as zlib has it, twelve times as fast (libdeflate); and of two pieces after each other, of those of each.

A CRC-32 is the rest of a polynomial over two elements: before n bytes it counts times x^(8 n), modulo the polynomial
of the code. Numbers are polynomials whose highest bit is the constant, as in zlib.
"""

from __future__ import annotations

from functools import lru_cache
from typing import cast

import imagecodecs

_POLYNOMIAL, _ONE, _BYTE = 0xEDB88320, 1 << 31, 1 << 23


def extend_crc32(before: int, content: memoryview | bytes) -> int:
    """The CRC-32 of `content` after something whose CRC-32 is `before`, 0 for nothing; 0.02 s for a gigabyte."""
    return int(imagecodecs.deflate_crc32(cast(bytes, content), before))


def join_crc32(first: int, second: int, second_bytes: int) -> int:
    """The CRC-32 of two pieces of which each has its own, the second one of so many bytes."""
    return _multiply(_shift(second_bytes), first) ^ second


@lru_cache(maxsize=16)
def _shift(size_bytes: int) -> int:
    """x^(8 n)."""
    shift, power = _ONE, _BYTE
    while size_bytes:
        if size_bytes & 1:
            shift = _multiply(shift, power)
        power = _multiply(power, power)
        size_bytes >>= 1
    return shift


def _multiply(one: int, other: int) -> int:
    product = 0
    for bit in range(31, -1, -1):
        if one >> bit & 1:
            product ^= other
        other = other >> 1 ^ (_POLYNOMIAL if other & 1 else 0)
    return product

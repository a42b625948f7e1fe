"""Packed files give back every byte, and what is damaged or declares too much is refused before it is unpacked."""

from __future__ import annotations

import io
import os
import struct
from collections import deque
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from engine.core.errors import InputError
from engine.storage.packed import CHUNK_BYTES, PackedFile, pack

MAXIMUM = 1 << 30


def pack_values(content: bytes, item_bytes: int, piece: int = 1 << 20) -> bytes:
    file = io.BytesIO()
    pieces = [content[at : at + piece] for at in range(0, len(content), piece)]
    deque(pack(file, pieces, len(content), item_bytes), maxlen=0)
    return file.getvalue()


def unpack(path: Path, max_bytes: int = MAXIMUM) -> bytes:
    with path.open("rb") as file:
        return b"".join(chunk.tobytes() for chunk in PackedFile(path, file, max_bytes).chunks())


def contents() -> dict[str, tuple[bytes, int]]:
    chance = np.random.default_rng(1)
    noise = chance.normal(size=CHUNK_BYTES // 4 + 1000).astype(np.float32)
    return {
        "nothing": (b"", 1),
        "one byte": (b"x", 4),
        "noisy floats": (noise.tobytes(), 4),
        "doubles, cut": (chance.normal(size=1000).tobytes()[:-3], 8),
        "random bytes": (chance.bytes(CHUNK_BYTES + 5), 1),
        "zeros": (bytes(3 * CHUNK_BYTES), 4),
        "few values": (chance.choice(noise[:9], 50_000).tobytes(), 4),
        "long numbers": (chance.bytes(1600), 16),
    }


@pytest.mark.parametrize("name", contents())
def test_every_byte_comes_back_and_no_number_of_threads_changes_the_file(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    content, item_bytes = contents()[name]
    file = pack_values(content, item_bytes)
    monkeypatch.setattr(os, "cpu_count", lambda: 1)
    assert pack_values(content, item_bytes, piece=12_345) == file
    (tmp_path / "a").write_bytes(file)
    assert unpack(tmp_path / "a") == content
    assert len(file) <= len(content) + 24 + 12 * (len(content) // CHUNK_BYTES + 1)


def test_floats_grow_smaller_than_by_zstandard_alone() -> None:
    import imagecodecs

    smooth = np.cumsum(np.random.default_rng(0).normal(size=200_000)).astype(np.float32).tobytes()
    assert len(pack_values(smooth, 4)) < 0.9 * len(imagecodecs.zstd_encode(smooth, 1))


def test_any_damaged_byte_is_noticed(tmp_path: Path) -> None:
    content = np.arange(3000, dtype=np.float32).tobytes()
    whole = pack_values(content, 4)
    for at in range(0, len(whole), 7):
        damaged = bytearray(whole)
        damaged[at] ^= 0x55
        (tmp_path / "a").write_bytes(damaged)
        with suppress(InputError):
            assert unpack(tmp_path / "a") == content, at  # bytes of the head that mean nothing
    for length in (*range(0, len(whole), 11), len(whole) - 1):
        (tmp_path / "a").write_bytes(whole[:length])
        with pytest.raises(InputError, match="is damaged"):
            unpack(tmp_path / "a")


def test_what_declares_too_much_or_unpacks_to_more_than_it_declares_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(pack_values(bytes(10_000), 4))
    with pytest.raises(InputError, match="declares 10,000 bytes, more than 9,999"):
        unpack(path, 9_999)
    path.write_bytes(struct.pack("<8sQB7x", b"LARCPK01", 1 << 60, 4))
    with pytest.raises(InputError, match="more than"):
        unpack(path)
    path.write_bytes(struct.pack("<8sQB7x", b"LARCPK01", MAXIMUM, 4))
    with pytest.raises(InputError, match="cut short"):
        unpack(path)
    import imagecodecs

    bomb = imagecodecs.zstd_encode(bytes(1 << 24), 1)
    row = struct.pack("<IIB3x", len(bomb), 0, 1)
    path.write_bytes(struct.pack("<8sQB7x", b"LARCPK01", 100, 4) + bomb + row)
    with pytest.raises(InputError, match="not as it was written"):
        unpack(path)


def test_content_of_another_size_than_promised_is_a_mistake() -> None:
    with pytest.raises(ValueError, match="3 bytes instead of 4"):
        deque(pack(io.BytesIO(), [b"abc"], 4, 1), maxlen=0)

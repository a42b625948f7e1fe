"""PNGs that are packed some rows at a time."""

from __future__ import annotations

import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.images import png_rows
from engine.images.decode import read_image
from engine.images.encode import encode_png
from engine.images.png_rows import encode_png_rows, write_png
from engine.storage import scratch


def make_codes(shape: tuple[int, ...], dtype: Any) -> NDArray[Any]:
    """Waves, noise in a half, and a part that is flat."""
    random, top = np.random.default_rng(5), np.iinfo(dtype).max
    waves = 0.5 + 0.4 * np.sin(np.arange(np.prod(shape)) / 70.0).reshape(shape)
    waves[: shape[0] // 2] = random.random((shape[0] // 2, *shape[1:]))
    waves[-shape[0] // 8 :] = 0.25
    return (top * waves).astype(dtype)


@pytest.mark.parametrize("channels", [(), (3,), (4,)])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_the_bytes_are_those_of_opencv(dtype: Any, channels: tuple[int, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    """At parts that end within chunks, at whole rows, and in one part; a larger one than any window of zlib."""
    codes = make_codes((230, 211, *channels), dtype)
    words: dict[str, Any] = {"transfer": "linear", "software": "Lightarc", "comment": "4 % off"}
    wanted = encode_png(codes, **words)
    for part_bytes in (1, 40_000, codes.nbytes - 1, codes.nbytes):
        monkeypatch.setattr(png_rows, "_PART_BYTES", part_bytes)
        found = encode_png_rows(codes, **words)
        assert b"".join(found) == wanted
        assert len(found) == len(wanted)


def test_other_views_of_codes_are_read_as_they_are(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(png_rows, "_PART_BYTES", 1000)
    codes = make_codes((90, 61, 3), np.uint16)[::-1, ::2]
    write_png(tmp_path / "view.png", codes, transfer="linear")
    found = np.rint(65535.0 * read_image(tmp_path / "view.png").pixels.astype(np.float64))
    np.testing.assert_array_equal(found, codes)


def test_memory_is_that_of_some_rows() -> None:
    """40 MB of noise, which no packing makes smaller, where arrays and contents lie in files."""
    codes = np.random.default_rng(1).integers(0, 256, (3300, 4000, 3), np.uint8)
    with scratch.keep_in_memory(1):
        tracemalloc.start()
        try:
            pieces = encode_png_rows(codes)
            size_bytes = sum(len(piece) for piece in pieces)
            most_bytes = tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
    assert size_bytes == len(pieces) > 0.99 * codes.nbytes
    assert most_bytes < 7 * png_rows._PART_BYTES

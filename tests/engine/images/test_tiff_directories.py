"""TIFF and RAW whose directories would be walked for ever (safety S9), each made of a few hundred bytes."""

from __future__ import annotations

import io
import struct

import numpy as np
import pytest
import tifffile

from engine.capture.photograph.decode import decode_exposure, decode_photograph
from engine.core.errors import InputError
from engine.images.tiff_directories import BELOW_LIMIT, TAGS_LIMIT, check_directories
from engine.storage.untrusted import LARGEST_LIMIT_S, SMALLEST_LIMIT_S, time_limit_s

_STRIP_OFFSETS, _STRIP_BYTES, _SUB_DIRECTORIES = 273, 279, 330


def image(pages: int = 1, *, big: bool = False) -> bytes:
    """A sound TIFF of a few small pages."""
    stream = io.BytesIO()
    with tifffile.TiffWriter(stream, bigtiff=big) as file:
        for _ in range(pages):
            file.write(np.full((8, 8, 3), 99, np.uint8), photometric="rgb", metadata=None)
    return stream.getvalue()


def directory(*entries: tuple[int, int, int, int], after: int = 0) -> bytes:
    """A directory of tag, type, count and value, and the place of the one after it."""
    packed = b"".join(struct.pack("<HHII", *entry) for entry in entries)
    return struct.pack("<H", len(entries)) + packed + struct.pack("<I", after)


def after_header(content: bytes) -> bytes:
    return b"II*\0" + struct.pack("<I", 8) + content


CIRCLES = {
    "of one": after_header(directory((256, 4, 1, 8), after=8)),
    "of two": after_header(directory((256, 4, 1, 8), after=26) + directory((256, 4, 1, 8), after=8)),
    "below itself": after_header(directory((_SUB_DIRECTORIES, 4, 2, 26)) + struct.pack("<II", 8, 8)),
    "of what the camera noted": after_header(directory((34665, 4, 1, 26)) + directory((34665, 4, 1, 8))),
}


@pytest.mark.parametrize("kind", CIRCLES)
@pytest.mark.parametrize("name", ["a.kdc", "a.tif"])
def test_S9_directories_in_a_circle_are_refused(kind: str, name: str) -> None:
    for read in (
        lambda: decode_photograph(CIRCLES[kind], name, "camera", "auto", False),
        lambda: decode_exposure(CIRCLES[kind], name),
    ):
        with pytest.raises(InputError, match="its directories meet again"):
            read()


def test_S9_more_tags_and_directories_than_any_camera_writes_are_refused() -> None:
    tags = after_header(directory(*[(256, 4, 1, 8)] * (TAGS_LIMIT + 1)))
    with pytest.raises(InputError, match="too many"):
        check_directories(tags, "a", 10)
    below = after_header(directory((_SUB_DIRECTORIES, 4, BELOW_LIMIT + 1, 26)))
    with pytest.raises(InputError, match="101 below it"):
        check_directories(below, "a", 10)
    check_directories(image(10), "a", 10)
    with pytest.raises(InputError, match="too many"):
        check_directories(image(11), "a", 10)


def test_S9_tags_that_share_the_same_megabyte_are_refused() -> None:
    shared = after_header(directory(*[(700, 1, 1 << 20, 100)] * 4)) + bytes(1 << 20)
    with pytest.raises(InputError, match="hold more than the file"):
        check_directories(shared, "a", 10)


def test_S9_strips_that_lie_in_one_place_are_refused() -> None:
    strips = 200
    tags = [(256, 4, 1, 8), (257, 4, 1, strips), (258, 3, 1, 8), (259, 3, 1, 1), (262, 3, 1, 1)]
    lists = 8 + 2 + 12 * 9 + 4
    tags += [(_STRIP_OFFSETS, 4, strips, lists), (277, 3, 1, 1), (278, 4, 1, 1)]
    tags += [(_STRIP_BYTES, 4, strips, lists + 4 * strips)]
    offsets = np.full(strips, lists + 8 * strips, "<u4").tobytes() + np.full(strips, 1000, "<u4").tobytes()
    with pytest.raises(InputError, match="overlap"):
        decode_photograph(after_header(directory(*tags)) + offsets + bytes(1000), "a.tif", "camera", "auto", False)


@pytest.mark.parametrize("big", [False, True])
def test_S9_sound_images_pass(big: bool) -> None:
    check_directories(image(3, big=big), "a", 3)
    with pytest.raises(InputError, match="too many"):
        check_directories(image(3, big=big), "a", 2)


def test_S9_small_files_get_less_time_than_large_ones() -> None:
    assert time_limit_s(100) == pytest.approx(SMALLEST_LIMIT_S, abs=0.1)
    assert time_limit_s(10 << 20) > 1.2 * SMALLEST_LIMIT_S
    assert time_limit_s(1 << 30) == LARGEST_LIMIT_S

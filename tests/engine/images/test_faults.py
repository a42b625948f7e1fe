"""Fault 5 for every image reader: truncation at every 1/64 and at header boundaries, and flipped bits.

A cut file is an error, or decodes to exactly what the whole file holds (only padding was lost). A flipped bit may
change pixels where the format has no checksum, but the image keeps its shape, nothing crashes and nothing hangs.
"""

import io
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
import OpenEXR
import pytest
import tifffile
from PIL import Image

from engine.core.errors import InputError
from engine.images import encode

RNG = np.random.default_rng(11)
SMOOTH = cv2.resize(RNG.integers(30, 220, (6, 8, 3)).astype(np.uint8), (96, 80), interpolation=cv2.INTER_CUBIC)
NOISE = RNG.integers(0, 256, (80, 96, 3)).astype(np.uint8)
FLOATS = RNG.random((80, 96, 3)).astype(np.float32)


def tiff(samples: Any, **options: Any) -> bytes:
    stream = io.BytesIO()
    tifffile.imwrite(stream, samples, photometric="rgb", metadata=None, **options)
    return stream.getvalue()


def exr(**header: Any) -> bytes:
    stream = io.BytesIO()
    channels = {name: np.ascontiguousarray(FLOATS[..., index]) for index, name in enumerate("RGB")}
    OpenEXR.File({"type": OpenEXR.scanlineimage, **header}, channels).write(stream)
    return stream.getvalue()


def tga(samples: Any, **options: Any) -> bytes:
    stream = io.BytesIO()
    Image.fromarray(samples).save(stream, "TGA", **options)
    return stream.getvalue()


def tiles() -> Any:
    description = OpenEXR.TileDescription()
    description.xSize = description.ySize = 16
    return description


def jpeg(*options: Any) -> bytes:
    return cv2.imencode(".jpg", SMOOTH, list(options))[1].tobytes()


#: Kind → content. True where the format has checksums that cover the pixels, so that no flipped bit gets through.
FILES = {
    "jpeg": (lambda: jpeg(), False),
    "jpeg-progressive": (lambda: jpeg(cv2.IMWRITE_JPEG_PROGRESSIVE, 1), False),
    "jpeg-restart": (lambda: jpeg(cv2.IMWRITE_JPEG_RST_INTERVAL, 4), False),
    "png-8": (lambda: encode.encode_png(NOISE), True),
    "png-16": (lambda: encode.encode_png(NOISE.astype(np.uint16) * 257), True),
    "tiff": (lambda: tiff(NOISE, rowsperstrip=16), False),
    "tiff-big-tiles": (lambda: tiff(NOISE, tile=(32, 32), bigtiff=True), False),
    "tiff-lzw": (lambda: tiff(NOISE, compression="lzw", rowsperstrip=16), False),
    "tiff-zlib": (lambda: tiff(NOISE, compression="zlib", rowsperstrip=16), False),
    "tiff-jpeg": (lambda: tiff(SMOOTH, compression="jpeg", rowsperstrip=16), False),
    "tiff-packbits": (lambda: tiff(SMOOTH, compression="packbits"), False),
    "tiff-zstd": (lambda: tiff(SMOOTH, compression="zstd"), False),
    "tiff-float": (lambda: tiff(FLOATS, rowsperstrip=8), False),
    "exr-zip": (lambda: exr(compression=OpenEXR.ZIP_COMPRESSION), False),
    "exr-none": (lambda: exr(compression=OpenEXR.NO_COMPRESSION), False),
    "exr-piz": (lambda: exr(compression=OpenEXR.PIZ_COMPRESSION), False),
    "exr-tiles": (lambda: exr(type=OpenEXR.tiledimage, tiles=tiles()), False),
    "hdr": (lambda: cv2.imencode(".hdr", FLOATS)[1].tobytes(), False),
    "tga": (lambda: tga(NOISE), False),
    "tga-packed": (lambda: tga(SMOOTH, compression="tga_rle"), False),
}


@pytest.fixture(params=FILES)
def kind(request: pytest.FixtureRequest) -> Any:
    return request.param


def test_fault5_truncation_is_never_silent(read: Callable[..., Any], kind: Any) -> None:
    content = FILES[kind][0]()
    whole = read(content).pixels
    cuts = {len(content) * part // 64 for part in range(1, 64)} | {1, 2, 4, 8, 9, 16, 33, 64, len(content) - 1}
    survived = []
    for cut in sorted(cuts):
        try:
            pixels = read(content[:cut]).pixels
        except InputError:
            continue
        survived.append(cut)
        assert np.array_equal(pixels, whole), f"{kind} cut at {cut} of {len(content)} changes pixels silently"
    assert len(survived) <= 2, "a format whose cut files decode has not been cut where it matters"


def test_fault5_zeroed_tails_are_never_silent_where_the_data_is_coded(read: Callable[..., Any], kind: Any) -> None:
    if kind in ("tiff", "tiff-big-tiles", "tiff-float", "exr-none", "tiff-zstd", "hdr", "tga", "tga-packed"):
        pytest.skip("stored as plain numbers without checksum: zeros are a valid image")
    content = FILES[kind][0]()
    with pytest.raises(InputError):
        read(content[: len(content) // 2] + bytes(len(content) - len(content) // 2))


@pytest.mark.parametrize("lines", [16, 79])
def test_fault5_a_tiff_that_states_fewer_rows_than_it_holds_is_refused(read: Callable[..., Any], lines: int) -> None:
    for kind in ("tiff", "tiff-lzw", "tiff-zlib", "tiff-float"):
        content = FILES[kind][0]()
        entry = np.array([257, 4], "<u2").tobytes() + np.array([1, 80], "<u4").tobytes()
        short = np.array([257, 3], "<u2").tobytes() + np.array([1, 80], "<u4").tobytes()
        stored = entry if entry in content else short
        assert content.count(stored) == 1
        shorter = stored[:8] + np.array([lines], "<u4").tobytes()
        with pytest.raises(InputError):
            read(content.replace(stored, shorter))


@pytest.mark.parametrize(
    ("kind", "bottom"), [("exr-none", 71), ("exr-tiles", 47), ("exr-tiles", 111), ("exr-none", 99)]
)
def test_fault5_an_exr_that_states_another_size_than_it_holds_is_refused(
    read: Callable[..., Any], kind: str, bottom: int
) -> None:
    content = FILES[kind][0]()
    at = content.index(b"dataWindow\0box2i\0") + len(b"dataWindow\0box2i\0") + 4 + 12
    assert content[at : at + 4] == bytes([79, 0, 0, 0])
    with pytest.raises(InputError, match="chunks"):
        read(content[:at] + bytes([bottom]) + content[at + 1 :])


def test_fault5_fewer_lines_than_the_file_holds_are_refused(read: Callable[..., Any]) -> None:
    for content in (tga(NOISE), tga(NOISE)[:-26]):
        with pytest.raises(InputError, match="more rows than it states"):
            read(content[:14] + bytes([79]) + content[15:])
    content = cv2.imencode(".hdr", FLOATS)[1].tobytes()
    for lines in (b"40", b"79"):
        with pytest.raises(InputError, match="not all input decoded"):
            read(content.replace(b"-Y 80", b"-Y " + lines))


def test_fault5_flipped_bits_neither_crash_nor_change_the_shape(read: Callable[..., Any], kind: Any) -> None:
    content = FILES[kind][0]()
    checksummed = FILES[kind][1]
    whole = read(content).pixels
    places = np.concatenate([np.arange(0, min(400, len(content)), 9), RNG.integers(0, len(content), 25)])
    for place in places:
        flipped = bytearray(content)
        flipped[place] ^= 1 << int(RNG.integers(8))
        try:
            pixels = read(bytes(flipped)).pixels
        except InputError:
            continue
        assert pixels.shape == whole.shape, f"{kind}: byte {place} silently changes the size"
        if checksummed:
            assert np.array_equal(pixels, whole), f"{kind}: byte {place} changes pixels past the checksum"

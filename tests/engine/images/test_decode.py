"""Every kind of image of fault 6 is right or named; R5, R6, R9, R11, R13 through files; real files."""

import io
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import OpenEXR
import pytest
import tifffile
from numpy.typing import NDArray

from engine.core.colour import srgb_decode
from engine.core.errors import InputError
from engine.images import encode
from engine.images.decode import read_image

RNG = np.random.default_rng(5)
CODES8 = RNG.integers(0, 256, (37, 53, 3)).astype(np.uint8)
CODES16 = RNG.integers(0, 65536, (37, 53, 3)).astype(np.uint16)
CODES16[0, 0] = 1
FLOATS = RNG.normal(0.5, 1, (37, 53, 3)).astype(np.float32)


def tiff(samples: Any, **options: Any) -> bytes:
    stream = io.BytesIO()
    options.setdefault("photometric", "rgb" if samples.ndim == 3 else "minisblack")
    tifffile.imwrite(stream, samples, metadata=None, **options)
    return stream.getvalue()


def exr(channels: Any, **header: Any) -> bytes:
    stream = io.BytesIO()
    OpenEXR.File({"type": OpenEXR.scanlineimage, **header}, channels).write(stream)
    return stream.getvalue()


def linear(codes: Any, white: Any) -> NDArray[np.float32]:
    return srgb_decode(codes / white).astype(np.float32)


def test_R6_png_codes_are_decoded_exactly(read: Callable[..., Any]) -> None:
    for codes, white in ((CODES8, 255), (CODES16, 65535)):
        image = read(encode.encode_png(codes))
        assert np.array_equal(image.pixels, linear(codes, white))
        assert np.array_equal(image.saturated, (codes == white).any(axis=2))
        assert (image.container, image.transfer) == ("PNG", "srgb")
        assert image.bit_depth == codes.dtype.itemsize * 8
        assert not image.pixels.flags.writeable


def test_transfer_is_the_files_or_the_callers(read: Callable[..., Any]) -> None:
    as_linear = (CODES8 / 255).astype(np.float32)
    assert np.array_equal(read(encode.encode_png(CODES8, transfer="linear")).pixels, as_linear)
    assert np.array_equal(read(encode.encode_png(CODES8), transfer="linear").pixels, as_linear)
    image = read(encode.encode_png(CODES8, transfer="linear"), transfer="srgb")
    assert (image.transfer, image.pixels[3, 4, 1]) == ("srgb", linear(CODES8, 255)[3, 4, 1])


def test_jpeg_is_srgb_and_close(read: Callable[..., Any]) -> None:
    smooth = cv2.resize(CODES8[:4, :5], (53, 37), interpolation=cv2.INTER_CUBIC)
    for channels in (smooth, smooth[..., 0]):
        image = read(cv2.imencode(".jpg", channels, [cv2.IMWRITE_JPEG_QUALITY, 98])[1].tobytes())
        expected = linear(channels[..., ::-1] if channels.ndim == 3 else channels[..., None], 255)
        assert image.pixels.shape == (37, 53, 3)
        assert np.abs(image.pixels - expected).mean() < 0.02
        assert (image.container, image.transfer, image.bit_depth) == ("JPEG", "srgb", 8)


@pytest.mark.parametrize(
    ("options", "byteorder", "bigtiff"),
    [
        (options, byteorder, bigtiff)
        for options in (
            {},
            {"tile": (16, 32)},
            {"planarconfig": "separate"},
            {"planarconfig": "separate", "tile": (32, 16)},
            {"compression": "lzw", "predictor": True},
            {"compression": "zlib", "rowsperstrip": 7},
            {"compression": "packbits"},
            {"compression": "zstd", "tile": (16, 16)},
        )
        for byteorder, bigtiff in (("<", False), (">", True))
    ],
)
def test_fault6_tiff_layouts_are_right(read: Callable[..., Any], options: Any, byteorder: Any, bigtiff: Any) -> None:
    for codes, white in ((CODES8, 255), (CODES16, 65535)):
        stored = np.moveaxis(codes, 2, 0) if options.get("planarconfig") == "separate" else codes
        image = read(tiff(np.ascontiguousarray(stored), byteorder=byteorder, bigtiff=bigtiff, **options))
        assert np.array_equal(image.pixels, linear(codes, white))
        assert image.warnings == ()


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64])
@pytest.mark.parametrize("byteorder", ["<", ">"])
def test_fault6_float_tiff_is_linear(read: Callable[..., Any], dtype: Any, byteorder: str) -> None:
    for options in ({}, {"compression": "zlib", "predictor": dtype is not np.float64}):
        image = read(tiff(FLOATS.astype(dtype), byteorder=byteorder, **options))
        assert np.array_equal(image.pixels, FLOATS.astype(dtype).astype(np.float32))
        assert (image.transfer, image.bit_depth) == ("linear", np.dtype(dtype).itemsize * 8)
        assert not image.saturated.any()


def test_fault6_grey_alpha_palette_and_bilevel(read: Callable[..., Any]) -> None:
    grey = CODES8[..., 0]
    expected = np.repeat(linear(grey, 255)[..., None], 3, axis=2)
    for content in (tiff(grey), encode.encode_png(grey), tiff(255 - grey, photometric="miniswhite")):
        assert np.array_equal(read(content).pixels, expected)
    with_alpha = np.concatenate([CODES8, CODES8[..., :1]], axis=2)
    for content in (tiff(with_alpha, extrasamples=["unassalpha"]), encode.encode_png(with_alpha)):
        image = read(content)
        assert np.array_equal(image.pixels, linear(CODES8, 255))
        assert any("alpha" in warning for warning in image.warnings)
    palette = RNG.integers(0, 65536, (3, 256)).astype(np.uint16)
    image = read(tiff(grey, photometric="palette", colormap=palette))
    assert np.array_equal(image.pixels, linear(palette[:, grey].transpose(1, 2, 0), 65535))
    bilevel = read(tiff(grey > 128, bitspersample=1))
    assert np.array_equal(bilevel.pixels[..., 0], (grey > 128).astype(np.float32))
    assert any("1 bit" in warning for warning in bilevel.warnings)


@pytest.mark.parametrize("is_within", [False, True])
def test_a_thumbnail_before_the_image_of_a_tiff_is_passed_over(read: Callable[..., Any], is_within: bool) -> None:
    """Cameras put the thumbnail first, and the image after it or into its SubIFDs (TIFF/EP)."""
    buffer = io.BytesIO()
    with tifffile.TiffWriter(buffer) as file:
        kinds = {"photometric": "rgb", "metadata": None}
        file.write(CODES8[::4, ::4].copy(), subfiletype=1, subifds=int(is_within), **kinds)
        file.write(CODES8, subfiletype=0, **kinds)
    image = read(buffer.getvalue())
    assert np.array_equal(image.pixels, linear(CODES8, 255))
    assert image.warnings == ()


def test_colours_of_a_tiff_that_were_multiplied_by_alpha_come_back(read: Callable[..., Any]) -> None:
    alpha = np.linspace(0.25, 1.0, CODES16.shape[1])[None, :, None] * np.ones_like(CODES16)
    codes = np.dstack([np.rint(CODES16 * alpha), np.rint(65535 * alpha[..., :1])]).astype(np.uint16)
    image = read(tiff(codes, extrasamples=["assocalpha"]))
    assert np.abs(image.pixels - linear(CODES16, 65535)).max() < 2e-4
    assert any("multiplied by its alpha" in warning for warning in image.warnings)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (lambda: tiff(np.dstack([CODES8, CODES8[..., 0]]), photometric="separated"), "CMYK"),
        (lambda: tiff(CODES8, photometric="cielab"), r"L\*a\*b\*"),
        (lambda: tiff(CODES16.astype(np.int16)), "signed"),
        (
            lambda: tiff(np.zeros((9, 9, 100), np.uint8), photometric="minisblack", planarconfig="contig"),
            "100 samples",
        ),
        (lambda: tiff(np.zeros((5, 16, 16), np.uint8), photometric="minisblack", volumetric=True), "volume"),
        (lambda: exr({"RY": FLOATS[..., 0], "BY": FLOATS[..., 0], "Y": FLOATS[..., 0]}), "chroma"),
        (lambda: exr({"Z": FLOATS[..., 0]}), "no channels R, G, B but Z"),
        (lambda: exr({c: CODES16[..., 0].astype(np.uint32) for c in "RGB"}), "integer"),
        (lambda: b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "Git LFS"),
        (lambda: b"BM" + bytes(100), "BMP"),
        (lambda: b"GIF89a" + bytes(100), "GIF"),
        (lambda: b"<!DOCTYPE html><html></html>", "web page"),
        (lambda: b"\0\0\0\x18ftypheic" + bytes(100), "HEIF"),
        (lambda: b"hello", "known kind"),
        (lambda: b"#?RADIANCE\n\n-Y 2 +X 2\n\1\1\1\4", "runs repeat nothing"),
        (lambda: b"#?RADIANCE\n\n-Y 2 +X 2\n\x80\x80\x80\x80\1\1\1\2", "runs do not end where"),
    ],
)
def test_fault6_what_is_not_converted_is_named(read: Callable[..., Any], content: Any, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read(content())


def png_header(width: int, height: int, bits: int = 8, kind: int = 2) -> Any:
    body = struct.pack(">IIBBBBB", width, height, bits, kind, 0, 0, 0)
    chunks = (b"IHDR", body), (b"IDAT", zlib.compress(bytes(100))), (b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + b"".join(encode.write_png_chunk(*chunk) for chunk in chunks)


def tiff_header(width: int, height: int, **changes: Any) -> bytes:
    """A TIFF of 8×8 grey whose width and length tags are overwritten."""
    content = bytearray(tiff(np.zeros((8, 8), np.uint8)))
    with tifffile.TiffFile(io.BytesIO(content)) as file:
        for tag, value in ((256, width), (257, height)):
            struct.pack_into("<I", content, file.pages[0].tags[tag].valueoffset, value)
            content[file.pages[0].tags[tag].offset + 2] = 4
    return bytes(content)


def jpeg_header(width: int, height: int) -> bytes:
    content = bytearray(cv2.imencode(".jpg", CODES8)[1].tobytes())
    at = content.index(b"\xff\xc0")
    struct.pack_into(">HH", content, at + 5, height, width)
    return bytes(content)


def tga_header(width: int, height: int) -> Any:
    width, height = min(width, 65535), min(height, 65535)
    return struct.pack("<3B2HB4H2B", 0, 0, 2, 0, 0, 0, 0, 0, width, height, 24, 0) + bytes(1000)


def exr_header(width: int, height: int) -> bytes:
    content = bytearray(exr({"R": FLOATS[..., 0], "G": FLOATS[..., 0], "B": FLOATS[..., 0]}))
    at = content.index(b"dataWindow\0box2i\0") + 21
    struct.pack_into("<iiii", content, at, 0, 0, width - 1, height - 1)
    return bytes(content)


def hdr_header(width: int, height: int) -> Any:
    return b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (height, width) + bytes(1000)


SIZES = [(65535, 65535), (2**31 - 1, 2**31 - 1), (0, 5), (5, 0), (20000, 9000)]


MAKERS = (png_header, tiff_header, jpeg_header, exr_header, hdr_header, tga_header)
LIES = [(make, size) for make in MAKERS for size in SIZES if max(size) < 65536 or make is not jpeg_header]


@pytest.mark.parametrize(("make", "size"), [*LIES, (exr_header, (-3, 8))])
def test_fault6_sizes_that_a_file_cannot_hold_are_refused_unallocated(tmp_path: Path, make: Any, size: Any) -> None:
    path = tmp_path / "lies"
    path.write_bytes(make(*size))
    with pytest.raises(InputError):
        read_image(path)


def upright(stored: Any, orientation: Any) -> Any:
    return {
        1: stored,
        2: stored[:, ::-1],
        3: np.rot90(stored, 2),
        4: stored[::-1],
        5: stored.transpose(1, 0, 2),
        6: np.rot90(stored, -1),
        7: np.rot90(stored, 2).transpose(1, 0, 2),
        8: np.rot90(stored),
    }[orientation]


@pytest.mark.parametrize(
    ("orientation", "shape"), [(number, shape) for number in range(1, 9) for shape in ((20, 20, 3), (17, 23, 3))]
)
def test_R11_orientations_equal_rotations_and_flips(read: Callable[..., Any], orientation: Any, shape: Any) -> None:
    codes = np.ascontiguousarray(CODES8[: shape[0], : shape[1]])
    image = read(tiff(codes, extratags=[(274, "H", 1, orientation)]))
    assert np.array_equal(image.pixels, upright(linear(codes, 255), orientation))
    assert np.array_equal(image.saturated, image.pixels.max(axis=2) == 1)


def exif_segment(exposure: Any) -> Any:
    entries = struct.pack("<HHII", 0x0110, 2, 4, int.from_bytes(b"Cam\0", "little"))
    entries += struct.pack("<HHII", 0x8769, 4, 1, 38)
    ifd = struct.pack("<H", 2) + entries + struct.pack("<I", 0)
    sub = struct.pack("<H", 1) + struct.pack("<HHII", 0x829A, 5, 1, 56) + struct.pack("<I", 0)
    body = b"Exif\0\0" + b"II*\0" + struct.pack("<I", 8) + ifd + sub + struct.pack("<II", *exposure)
    return b"\xff\xe1" + struct.pack(">H", len(body) + 2) + body


@pytest.mark.parametrize(("exposure", "expected"), [((1, 50), 1 / 50), ((0, 0), None), ((1, 0), None), ((0, 1), None)])
def test_R9_exposure_times_of_a_jpeg(read: Callable[..., Any], exposure: Any, expected: float | None) -> None:
    content = cv2.imencode(".jpg", CODES8)[1].tobytes()
    image = read(content[:2] + exif_segment(exposure) + content[2:])
    assert image.exif.exposure_s == expected
    assert image.exif.camera == "Cam"
    assert any("exposure" in warning for warning in image.warnings) == (expected is None)
    assert read(content).exif.exposure_s is None


def test_R13_8_and_16_bit_of_one_scene_agree(read: Callable[..., Any]) -> None:
    scene = RNG.random((37, 53, 3))
    scene[0, 0] = 1
    of_8 = read(encode.encode_png(np.rint(scene * 255).astype(np.uint8)), transfer="linear").pixels
    of_16 = read(tiff(np.rint(scene * 65535).astype(np.uint16)), transfer="linear").pixels
    assert np.abs(of_8 - of_16).max() <= 0.5 / 255 + 1 / 65535


def test_R5_12_bit_stored_high_aligned_reaches_white(read: Callable[..., Any]) -> None:
    codes = (CODES16 >> 4) << 4
    codes[0, 0] = 65520
    image = read(tiff(codes), transfer="linear")
    assert image.pixels.max() == 1
    assert image.saturated[0, 0]


@pytest.mark.parametrize("half", [True, False])
def test_exr_colour_layers_and_luminance(read: Callable[..., Any], half: bool) -> None:
    stored = FLOATS.astype(np.float16) if half else FLOATS
    image = read(encode.encode_exr(encode.rgb_channels(FLOATS), half=half))
    assert np.array_equal(image.pixels, stored.astype(np.float32))
    assert (image.transfer, image.bit_depth) == ("linear", 16 if half else 32)
    layered = read(encode.encode_exr(encode.rgb_channels(FLOATS, "beauty"), half=half))
    assert np.array_equal(layered.pixels, image.pixels)
    assert any("beauty" in warning for warning in layered.warnings)
    grey = read(encode.encode_exr({"Y": FLOATS[..., 0]}, half=half))
    assert np.array_equal(grey.pixels, np.repeat(image.pixels[..., :1], 3, axis=2))


def test_exr_channels_may_have_small_letters(read: Callable[..., Any]) -> None:
    def planes(names: Any) -> dict[str, Any]:
        return {name: np.ascontiguousarray(FLOATS[..., c % 3]) + c // 3 for c, name in enumerate(names)}

    assert np.array_equal(read(exr(planes("rgb"))).pixels, FLOATS)
    layered = read(exr(planes(["beauty.r", "beauty.g", "beauty.b"])))
    assert np.array_equal(layered.pixels, FLOATS)
    assert "beauty" in layered.warnings[0]
    assert np.array_equal(read(exr(planes("rgbRGB"))).pixels, FLOATS + 1)


def test_exr_tiles_compressions_and_windows(read: Callable[..., Any]) -> None:
    channels = {name: np.ascontiguousarray(FLOATS[..., index]) for index, name in enumerate("RGB")}
    for name in ("NO", "RLE", "ZIPS", "ZIP", "PIZ", "ZSTD"):
        compression = getattr(OpenEXR, f"{name}_COMPRESSION")
        assert np.array_equal(read(exr(channels, compression=compression)).pixels, FLOATS)
    tiles = OpenEXR.TileDescription()
    tiles.xSize = tiles.ySize = 16
    assert np.array_equal(read(exr(channels, type=OpenEXR.tiledimage, tiles=tiles)).pixels, FLOATS)


def test_exr_of_tristimulus_values_and_of_other_primaries(read: Callable[..., Any]) -> None:
    white = np.full((4, 4), 1.0, np.float32)
    content = exr({"X": white * np.float32(0.95047), "Y": white, "Z": white * np.float32(1.08883)})
    image = read(content)
    assert image.pixels == pytest.approx(np.ones((4, 4, 3)), abs=2e-3)
    assert "tristimulus" in image.warnings[0]
    rgb = dict.fromkeys("RGB", white)
    wide = (0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329)
    found = read(exr({**rgb, "G": 0 * white, "B": 0 * white}, chromaticities=wide))
    assert (found.profile, found.warnings) == ("linear Rec.2020", ())
    assert found.pixels[0, 0] == pytest.approx((1.6605, -0.1246, -0.0182), abs=1e-3)
    assert not read(exr(rgb, chromaticities=(0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.329))).warnings


def test_values_that_are_not_finite_are_counted_and_masked(read: Callable[..., Any]) -> None:
    floats = FLOATS.copy()
    floats[3, 4, 1], floats[5, 6, 0], floats[7, 8, 2] = np.nan, np.inf, -np.inf
    for content in (encode.encode_exr(encode.rgb_channels(floats), half=False), tiff(floats)):
        image = read(content)
        assert np.isfinite(image.pixels).all()
        assert sorted(zip(*np.nonzero(image.saturated), strict=True)) == [(3, 4), (5, 6), (7, 8)]
        assert any("3 pixels that are not finite" in warning for warning in image.warnings)
    assert not read(tiff(np.full((4, 4, 3), 1e300))).pixels.any()


def test_hdr_in_all_orientations_and_exposures(read: Callable[..., Any]) -> None:
    image = np.exp(RNG.normal(0, 2, (20, 31, 3))).astype(np.float32)
    content = cv2.imencode(".hdr", image[..., ::-1])[1].tobytes()
    header, body = content.split(b"\n\n", 1)
    resolution, data = body.split(b"\n", 1)
    assert resolution == b"-Y 20 +X 31"
    plain = read(content).pixels
    assert np.all(np.abs(plain - image) <= image.max(axis=2, keepdims=True) / 128)
    for size, expected in (
        (b"+Y 20 +X 31", plain[::-1]),
        (b"-Y 20 -X 31", plain[:, ::-1]),
        (b"+X 20 -Y 31", plain.swapaxes(0, 1)),
        (b"+X 20 +Y 31", plain[:, ::-1].swapaxes(0, 1)),
        (b"-X 20 -Y 31", plain[::-1].swapaxes(0, 1)),
    ):
        assert np.array_equal(read(header + b"\n\n" + size + b"\n" + data).pixels, expected)
    exposed = read(header + b"\nEXPOSURE=2\nEXPOSURE=4\n\n" + body).pixels
    assert np.array_equal(exposed, plain / 8)
    with pytest.raises(InputError, match="exposure"):
        read(header + b"\nEXPOSURE=0\n\n" + body)


def test_EN8_runs_as_before_1991_and_every_exponent(read: Callable[..., Any]) -> None:
    """Old runs: a pixel of mantissas 1, 1, 1 repeats the last one, 256 times as often for each that follows another."""
    header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n"
    first, second = b"\x80\x40\x20\x81", b"\xff\x00\x10\x83"
    old = first + b"\1\1\1\x03" + second + b"\1\1\1\x04\1\1\1\x01"  # 4 of the first, 1 + 4 + 256 of the second
    written_out = first * 4 + second * 261
    for width, height in ((5, 53), (265, 1), (1, 265)):
        size = b"-Y %d +X %d\n" % (height, width)
        plain = read(header + size + written_out).pixels
        assert np.array_equal(read(header + size + old).pixels, plain)
    exponents = np.arange(256)
    pixels = np.stack([np.full(256, 200), np.full(256, 13), np.zeros(256), exponents], axis=-1).astype(np.uint8)
    for width in (4, 256):
        found = read(header + b"-Y %d +X %d\n" % (256 // width, width) + pixels.tobytes()).pixels.reshape(-1, 3)
        exact = np.ldexp(pixels[:, :3].astype(np.float64), exponents[:, None] - 136)
        exact[0] = 0.0
        assert np.isfinite(found).all()
        assert np.all(np.abs(found - exact) <= exact.max(axis=1, keepdims=True) / 256)


@pytest.mark.parametrize("width", [7, 8, 32767, 32768])
def test_EN8_lines_too_short_or_long_for_runs_are_plain(read: Callable[..., Any], width: int) -> None:
    pixels = np.random.default_rng(2).integers(129, 140, (2, width, 4)).astype(np.uint8)
    content = b"#?RADIANCE\n\n-Y 2 +X %d\n" % width + pixels.tobytes()
    exact = np.ldexp(pixels[..., :3].astype(np.float64), pixels[..., 3:].astype(int) - 136)
    assert np.all(np.abs(read(content).pixels - exact) <= exact.max(axis=2, keepdims=True) / 256)


def test_EN8_what_the_header_says_of_colour(read: Callable[..., Any]) -> None:
    body = b"-Y 1 +X 2\n\x80\x80\x80\x81\x80\x80\x80\x82"
    plain = read(b"#?RADIANCE\n\n" + body)
    assert not plain.warnings
    corrected = read(b"#?RADIANCE\nCOLORCORR=2 1 0.5\nEXPOSURE=2\n\n" + body).pixels
    assert np.array_equal(corrected, plain.pixels / np.array((4, 2, 1), np.float32))
    assert "gamma of 2.2" in read(b"#?RADIANCE\nGAMMA=2.2\n\n" + body).warnings[0]
    wide = b"#?RADIANCE\nPRIMARIES=0.708 0.292 0.17 0.797 0.131 0.046 0.3127 0.329\n\n"
    found = read(wide + body)
    assert (found.profile, found.warnings) == ("linear Rec.2020", ())
    matrix = np.array([(1.6605, -0.5876, -0.0728), (-0.1246, 1.1329, -0.0083), (-0.0182, -0.1006, 1.1187)])
    np.testing.assert_allclose(found.pixels, plain.pixels @ matrix.T, atol=1e-3 * plain.pixels.max())
    with pytest.raises(InputError, match="states primaries that are not eight numbers"):
        read(b"#?RADIANCE\nPRIMARIES=wide\n\n" + body)
    srgb = b"#?RADIANCE\nGAMMA=1\nPRIMARIES=0.64 0.33 0.30 0.60 0.15 0.06 0.3127 0.329\n\n"
    assert not read(srgb + body).warnings
    for line in (b"EXPOSURE=bright", b"COLORCORR=1 2", b"EXPOSURE=nan", b"EXPOSURE=1e99"):
        with pytest.raises(InputError, match="exposure"):
            read(b"#?RADIANCE\n" + line + b"\n\n" + body)


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("corner", [0x00, 0x10, 0x20, 0x30])
def test_targa_from_every_corner_with_and_without_a_footer(read: Callable[..., Any], corner: int, packed: bool) -> None:
    """The pixel order of the specification: blue, green, red, from the corner that bits 4 and 5 name."""
    stored = CODES8[:: 1 if corner & 0x20 else -1, :: -1 if corner & 0x10 else 1, ::-1]
    header = struct.pack("<3B2HB4H2B", 3, 0, 10 if packed else 2, 0, 0, 0, 0, 0, 53, 37, 24, corner)
    if packed:  # each row in one packet of raw pixels
        pixels = b"".join(bytes([52]) + np.ascontiguousarray(row).tobytes() for row in stored)
    else:
        pixels = np.ascontiguousarray(stored).tobytes()
    for footer in (b"", bytes(8) + b"TRUEVISION-XFILE.\0"):
        image = read(header + b"abc" + pixels + footer)
        assert np.array_equal(image.pixels, linear(CODES8, 255))
        assert (image.container, image.warnings) == ("TGA", ())


def test_targa_in_grey_by_a_palette_and_with_alpha(read: Callable[..., Any]) -> None:
    grey = CODES8[..., 0]
    header = struct.pack("<3B2HB4H2B", 0, 0, 3, 0, 0, 0, 0, 0, 53, 37, 8, 0x20)
    assert np.array_equal(read(header + grey.tobytes()).pixels[..., 1], linear(grey, 255))
    palette = np.arange(768, dtype=np.uint8).reshape(256, 3)
    header = struct.pack("<3B2HB4H2B", 0, 1, 1, 0, 256, 24, 0, 0, 53, 37, 8, 0x20)
    image = read(header + palette.tobytes() + grey.tobytes())
    assert np.array_equal(image.pixels, linear(palette[grey][..., ::-1], 255))
    header = struct.pack("<3B2HB4H2B", 0, 0, 2, 0, 0, 0, 0, 0, 53, 37, 32, 0x28)
    image = read(header + np.dstack([CODES8[..., ::-1], grey]).tobytes())
    assert np.array_equal(image.pixels, linear(CODES8, 255))
    assert "alpha" in image.warnings[0]


def test_half_size_averages(read: Callable[..., Any]) -> None:
    content = encode.encode_exr(encode.rgb_channels(FLOATS), half=False)
    half = read(content, half_size=True)
    assert half.pixels == pytest.approx(FLOATS[:36, :52].reshape(18, 2, 26, 2, 3).mean(axis=(1, 3)), abs=1e-6)
    assert read(tiff(np.ones((1, 1, 3), np.float32)), half_size=True).pixels.shape == (1, 1, 3)


def test_an_embedded_profile_that_is_none_is_refused(read: Callable[..., Any]) -> None:
    content = encode.encode_png(CODES8)
    profile = encode.write_png_chunk(b"iCCP", b"Adobe RGB\0\0" + zlib.compress(b"desc Adobe RGB (1998)"))
    with pytest.raises(InputError, match="colour profile"):
        read(content[:33] + profile + content[33:])


@pytest.mark.parametrize(
    ("name", "shape", "mean"),
    [
        ("tiff/flower-rgb-contig-16.tif", (43, 73, 3), 0.1382),
        ("tiff/flower-rgb-contig-10.tif", (43, 73, 3), 0.1379),
        ("tiff/flower-minisblack-16.tif", (43, 73, 3), 0.1506),
        ("tiff/cramps-tile.tif", (607, 800, 3), 0.6797),
        ("tiff/off_luv32.tif", (225, 333, 3), 0.8434),
        ("hdr/studio_small_03_1k.hdr", (512, 1024, 3), 1.88),
        ("hdr/openexr/WavyLinesLatLong.exr", (512, 1024, 3), 0.2029),
        ("hdr/pmndrs_cc0/studio.exr", (256, 512, 3), 1.883),
        ("stacks/uw_psm/cat/cat.0.tga", (340, 512, 3), 0.02062),
        ("stacks/ring_rti64/0000.jpg", (800, 800, 3), 0.0109),
    ],
)
def test_real_files(shared_data: Callable[[str], Path], name: str, shape: Any, mean: float) -> None:
    image = read_image(shared_data(name))
    assert image.pixels.shape == shape
    assert image.pixels.mean(dtype=np.float64) == pytest.approx(mean, rel=0.01)


@pytest.mark.parametrize(
    "name", ["asan_heap-oob_7f5a5030cdca_702_045a76649.exr", "asan_heap-oob_7f5cd523238e_878_03c277ec5.exr"]
)
def test_fault5_damaged_real_exr_is_refused(shared_data: Callable[[str], Path], name: str) -> None:
    with pytest.raises(InputError, match="damaged"):
        read_image(shared_data(f"hdr/damaged/{name}"))


@pytest.mark.parametrize(("rows", "words"), [(np.s_[30:], "its last ones among them"), (np.s_[10:13], "3 of 37 rows")])
def test_fault5_rows_of_zeros_are_warned_of(tmp_path: Path, rows: Any, words: str) -> None:
    samples = CODES16.copy()
    samples[rows] = 0
    path = tmp_path / "zeros.tif"
    path.write_bytes(tiff(samples))
    assert any(words in warning and "check that it is complete" in warning for warning in read_image(path).warnings)
    path.write_bytes(tiff(CODES16))
    assert read_image(path).warnings == ()
    path.write_bytes(tiff(np.zeros_like(CODES16)))
    assert read_image(path).warnings == ()
    path.write_bytes(exr({"RGB": np.where(samples > 0, FLOATS, np.float32(0))}))
    assert read_image(path).warnings == ()  # an image of a model in front of nothing, and its reader counts rows

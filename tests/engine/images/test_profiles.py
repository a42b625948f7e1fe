"""Colour profiles are applied: radiance of every kind against published matrices and closed forms."""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tifffile
from PIL import Image as PillowImage

from engine.core.errors import InputError
from engine.images import decode, encode
from engine.images.icc import MAX_PROFILE_BYTES, write_profile
from engine.storage.untrusted import decode_in_child
from tests.engine.images import profiles

RNG = np.random.default_rng(18)
SAMPLES = {8: RNG.integers(0, 256, (24, 24, 3), np.uint8), 16: RNG.integers(0, 65536, (24, 24, 3), np.uint16)}
for codes in SAMPLES.values():
    codes[0, 0], codes[0, 1] = np.iinfo(codes.dtype).max, 0

SPACES = ("sRGB", "Adobe RGB", "Display P3", "ProPhoto RGB", "Rec.2020", "eciRGB v2")


def png(codes: Any, profile: bytes = b"", *more: tuple[bytes, bytes], plain: bool = True) -> bytes:
    content = encode.encode_png(codes)
    if plain:
        content = content.replace(encode.write_png_chunk(b"sRGB", b"\1"), b"")
    chunks = [(b"iCCP", b"x\0\0" + zlib.compress(profile))] * bool(profile) + list(more)
    return content[:33] + b"".join(encode.write_png_chunk(*chunk) for chunk in chunks) + content[33:]


def tiff(codes: Any, profile: bytes = b"", description: str = "") -> bytes:
    stream = io.BytesIO()
    kind = "rgb" if codes.ndim == 3 else "minisblack"
    tifffile.imwrite(
        stream, codes, photometric=kind, iccprofile=profile or None, description=description, metadata=None
    )
    return stream.getvalue()


def jpeg(codes: Any, profile: bytes = b"", exif: Any = None) -> bytes:
    stream = io.BytesIO()
    more = {"exif": exif} if exif is not None else {}
    PillowImage.fromarray(codes).save(stream, "JPEG", quality=100, subsampling=0, icc_profile=profile or None, **more)
    return stream.getvalue()


def read(content: bytes, **options: Any) -> dict[str, Any]:
    return decode.decode(content, "some file", **options)


def worst(found: Any, truth: Any) -> float:
    """Largest error of a channel over the largest channel of its pixel, or over 1 % of white in what is darker."""
    size = np.maximum(np.abs(truth).max(axis=-1, keepdims=True), 0.01)
    return float((np.abs(found - truth) / size).max())


KINDS: dict[str, tuple[bytes, Callable[[Any], Any]]] = {
    **{name: (profiles.matrix_profile(name, name), partial(profiles.matrix_truth, name, name)) for name in SPACES},
    **{
        f"linear {name}": (
            profiles.matrix_profile(name, "linear"),
            partial(profiles.matrix_truth, name, "linear"),
        )
        for name in SPACES
    },
    "scanner": (profiles.scanner_profile(), profiles.scanner_truth),
    "scanner, colorimetric": (profiles.scanner_profile("A2B1"), profiles.scanner_truth),
    "missing": (b"", lambda x: profiles.matrix_truth("sRGB", "sRGB", x)),
}


@pytest.mark.parametrize("kind", KINDS)
def test_radiance_of_every_kind_of_profile(kind: str) -> None:
    profile, truth = KINDS[kind]
    errors = {}
    for bits, codes in SAMPLES.items():
        values = codes / np.iinfo(codes.dtype).max
        for name, write in (("PNG", png), ("TIFF", tiff)):
            errors[f"{name} {bits}"] = worst(read(write(codes, profile))["pixels"], truth(values))
    smooth = np.kron(SAMPLES[8][:3, :3], np.ones((16, 16, 1), np.uint8))
    stored = np.asarray(PillowImage.open(io.BytesIO(jpeg(smooth))))
    errors["JPEG"] = worst(read(jpeg(smooth, profile))["pixels"], truth(stored / 255))
    if profile:
        floats = (SAMPLES[16] / 65535).astype(np.float32)
        errors["float TIFF"] = worst(read(tiff(floats, profile))["pixels"], truth(np.float64(floats)))
    print(f"{kind}: " + ", ".join(f"{name} {error:.5%}" for name, error in errors.items()))
    assert max(errors.values()) <= 0.005
    white = read(png(np.full((1, 1, 3), 255, np.uint8), profile))
    assert white["saturated"].all()
    if "scanner" not in kind:
        np.testing.assert_allclose(white["pixels"], 1.0, atol=1e-4)


def test_grey_profiles() -> None:
    for curve, (formula, _) in profiles.CURVES.items():
        profile = profiles.grey_profile(curve)
        for bits, codes in SAMPLES.items():
            truth = formula(codes[..., :1] / (2**bits - 1)).repeat(3, axis=-1)
            for write in (png, tiff):
                assert worst(read(write(codes[..., 0], profile))["pixels"], truth) <= 0.005, (curve, bits)
    with pytest.raises(InputError, match="is for grey, and the image has colours"):
        read(png(SAMPLES[8], profiles.grey_profile("linear")))
    # Programs leave a colour profile in grey photographs: greys have the curve alone.
    grey = read(jpeg(SAMPLES[8][..., 0], profiles.matrix_profile("ProPhoto RGB", "linear")))
    assert np.ptp(grey["pixels"], axis=-1).max() < 1e-4
    assert grey["transfer"] == "linear"


def test_colours_outside_the_gamut_stay() -> None:
    red = read(tiff(np.array([[[65535, 0, 0]]], np.uint16), profiles.matrix_profile("Rec.2020", "linear")))
    np.testing.assert_allclose(red["pixels"][0, 0], (1.6605, -0.1246, -0.0182), atol=2e-4)


def test_floats_beyond_white_are_not_lost() -> None:
    values = np.array([[[4.0, 4.0, 4.0], [-0.5, -0.5, -0.5]]], np.float32)
    for curve, bright in (("linear", 4.0), ("sRGB", profiles._srgb(4.0)), ("ProPhoto RGB", 4.0**1.80078125)):
        found = read(tiff(values, profiles.matrix_profile("ProPhoto RGB", curve)))["pixels"]
        np.testing.assert_allclose(found[0, 0], bright, rtol=1e-3)
        assert (found[0, 1] < 0).all()
    # A sampled curve ends at 1; it goes on as it ends.
    found = read(tiff(values / 3, profiles.matrix_profile("eciRGB v2", "eciRGB v2")))["pixels"]
    np.testing.assert_allclose(found[0, 0], profiles._lightness(4 / 3), rtol=0.02)
    # A table can't go on: what is beyond it counts as clipped.
    assert read(tiff(values, profiles.scanner_profile()))["saturated"].tolist() == [[True, False]]


def test_samples_at_full_scale_are_masked_whatever_the_profile_makes_of_them() -> None:
    codes = np.array([[[255, 0, 0], [254, 254, 254], [0, 255, 0], [0, 0, 255]]], np.uint8)
    for profile in (profiles.matrix_profile("Adobe RGB", "Adobe RGB"), profiles.scanner_profile()):
        assert read(png(codes, profile))["saturated"].tolist() == [[True, False, True, True]]


def _invalid() -> dict[str, tuple[bytes, str]]:
    good, table = profiles.matrix_profile("Adobe RGB", "Adobe RGB"), profiles.scanner_profile()
    columns = {f"{one}XYZ": profiles.xyz_tag((0.1, 0.1, 0.1)) for one in "rgb"}
    curves = {f"{one}TRC": profiles.gamma_tag(2.2) for one in "rgb"}
    falling = {f"{one}TRC": profiles.curve_tag(np.linspace(1, 0, 64)) for one in "rgb"}
    named = {"desc": profiles.name_tag("odd")}
    primaries = {
        f"{one}XYZ": profiles.xyz_tag(each) for one, each in zip("rgb", profiles.to_d50("sRGB").T, strict=True)
    }
    return {
        "truncated": (good[:-20], "is truncated"),
        "truncated table": (table[: len(table) // 2], "is truncated"),
        "table that states fewer bytes": (
            struct.pack(">I", 600) + table[4:600],
            "a tag lies outside it",
        ),
        "CMYK": (profiles.profile(named, b"CMYK"), "is for CMYK"),
        "Lab": (profiles.profile(named, b"Lab "), "is for CIE L"),
        "device link": (profiles.profile({**named, **primaries, **curves}, kind=b"link"), "does not describe"),
        "text": (b"desc Adobe RGB (1998)", "is not an ICC profile"),
        "large": (bytes(MAX_PROFILE_BYTES + 1), "has more than 4 MiB"),
        "no curves": (profiles.profile({**named, **primaries}), "has no rTRC"),
        "no white": (profiles.profile({**named, **columns, **curves}), "do not add up to white"),
        "falling curve": (profiles.profile({**named, **primaries, **falling}), "does not rise"),
        "empty table": (
            profiles.profile({**named, "A2B0": b"mft2\0\0\0\0" + bytes(60)}),
            "has a table that cannot be read",
        ),
    }


@pytest.mark.parametrize("kind", _invalid())
def test_invalid_profiles_are_refused_with_their_cause(kind: str) -> None:
    profile, cause = _invalid()[kind]
    for content in (png(SAMPLES[8], profile), tiff(SAMPLES[16], profile), jpeg(SAMPLES[8], profile)):
        with pytest.raises(InputError, match=cause) as caught:
            read(content)
        assert "--transfer" in caught.value.remedy
        # A stated curve is enough to go on, with the effect named once.
        image = read(content, transfer="srgb", keep_primaries=True)
        assert len(image["warnings"]) == 1
        assert cause in image["warnings"][0]
        assert "not applied" in image["warnings"][0]


def test_a_stated_transfer_function_overrides_the_curve_and_not_the_primaries() -> None:
    content = tiff(SAMPLES[16], profiles.matrix_profile("ProPhoto RGB", "ProPhoto RGB"))
    image = read(content, transfer="linear", keep_primaries=True)
    truth = profiles.matrix_truth("ProPhoto RGB", "linear", SAMPLES[16] / 65535)
    assert worst(image["pixels"], truth) < 1e-3
    assert "curve is not applied" in image["warnings"][0]
    # Of the table of a scanner, the curve is no part of its own.
    table = read(tiff(SAMPLES[16], profiles.scanner_profile()), transfer="linear", keep_primaries=True)
    np.testing.assert_allclose(table["pixels"], SAMPLES[16] / 65535, atol=1e-6)
    assert "table" in table["warnings"][0]


def test_data_channels_are_not_changed_by_a_profile() -> None:
    content = png(SAMPLES[8], profiles.matrix_profile("ProPhoto RGB", "ProPhoto RGB"))
    image = read(content, transfer="linear")
    np.testing.assert_allclose(image["pixels"], SAMPLES[8] / 255, atol=1e-6)
    assert image["profile"] == ""
    assert image["warnings"] == []


def test_what_was_applied_is_named() -> None:
    image = read(png(SAMPLES[8], profiles.matrix_profile("ProPhoto RGB", "ProPhoto RGB")))
    assert (image["profile"], image["transfer"]) == ("ProPhoto RGB with ProPhoto RGB curve", "profile")
    assert read(png(SAMPLES[8], profiles.matrix_profile("sRGB", "sRGB")))["transfer"] == "srgb"
    # sRGB in a profile, which rounds, is the same sRGB as without.
    assert (read(png(SAMPLES[8], KINDS["sRGB"][0]))["pixels"] == read(png(SAMPLES[8]))["pixels"]).all()


def test_our_own_linear_files_and_a_profile_that_contradicts_them() -> None:
    mark = '{"transfer": "linear"}'
    plain = read(tiff(SAMPLES[16], description=mark))
    assert plain["transfer"] == "linear"
    assert plain["warnings"] == []
    both = read(tiff(SAMPLES[16], KINDS["sRGB"][0], description=mark))
    assert both["transfer"] == "srgb"
    assert "another curve" in both["warnings"][0]


def test_chunks_of_a_png_state_colours() -> None:
    adobe = struct.pack(">8I", 31270, 32900, 64000, 33000, 21000, 71000, 15000, 6000)
    values = SAMPLES[16] / 65535
    for chunks, truth in (
        ([(b"gAMA", struct.pack(">I", 55556))], values**1.8),
        ([(b"gAMA", struct.pack(">I", 45455))], profiles._srgb(values)),  # beside sRGB samples
        (
            [(b"gAMA", struct.pack(">I", 100000)), (b"cHRM", adobe)],
            profiles.matrix_truth("Adobe RGB", "linear", values),
        ),
        ([(b"cICP", bytes((12, 13, 0, 1)))], profiles.matrix_truth("Display P3", "sRGB", values)),
        ([(b"cICP", bytes((9, 8, 0, 1)))], profiles.matrix_truth("Rec.2020", "linear", values)),
    ):
        image = read(png(SAMPLES[16], b"", *chunks))
        assert worst(image["pixels"], truth) <= 0.005, chunks
    with pytest.raises(InputError, match="cICP"):
        read(png(SAMPLES[16], b"", (b"cICP", bytes((9, 16, 0, 1)))))
    with pytest.raises(InputError, match="gamma"):
        read(png(SAMPLES[16], b"", (b"gAMA", bytes(4))))
    # The sRGB chunk comes before gAMA and cHRM, and a profile before all but cICP.
    assert read(png(SAMPLES[16], b"", (b"gAMA", struct.pack(">I", 55556)), plain=False))["transfer"] == "srgb"


def test_the_colour_space_that_a_camera_notes() -> None:
    exif = PillowImage.Exif()
    exif.get_ifd(0x8769)[0xA001] = 65535
    exif.get_ifd(0x8769)[0xA005] = {1: "R03\0"}
    smooth = np.kron(SAMPLES[8][:3, :3], np.ones((16, 16, 1), np.uint8))
    stored = np.asarray(PillowImage.open(io.BytesIO(jpeg(smooth))))
    image = read(jpeg(smooth, exif=exif))
    assert image["profile"] == "Adobe RGB (1998)"
    assert worst(image["pixels"], profiles.matrix_truth("Adobe RGB", "Adobe RGB", stored / 255)) <= 0.005
    with_profile = read(jpeg(smooth, KINDS["Display P3"][0], exif=exif))
    assert with_profile["profile"].startswith("Display P3")
    plain = PillowImage.Exif()
    plain.get_ifd(0x8769)[0xA001] = 65535
    assert "not sRGB" in read(jpeg(smooth, exif=plain))["warnings"][0]


def test_chunks_of_a_profile_in_a_jpeg_are_put_in_order() -> None:
    profile = KINDS["Adobe RGB"][0]
    plain = jpeg(SAMPLES[8])
    parts = [profile[:300], profile[300:]]
    segments = [
        b"\xff\xe2" + struct.pack(">H", 16 + len(part)) + b"ICC_PROFILE\0" + bytes((at + 1, 2)) + part
        for at, part in enumerate(parts)
    ]
    assert read(plain[:2] + segments[1] + segments[0] + plain[2:])["profile"].startswith("Adobe RGB")


@pytest.mark.parametrize("share", [0.02])
def test_mutated_profiles_neither_end_nor_hang_the_decoder(share: float, tmp_path: Path) -> None:
    """Through the confined process, as every file goes; each is applied or refused in one sentence."""
    rng = np.random.default_rng(3)
    whole = [
        profiles.matrix_profile("eciRGB v2", "eciRGB v2"),
        profiles.scanner_profile(),
        profiles.grey_profile("sRGB"),
    ]
    codes = SAMPLES[8][:4, :4]
    path = tmp_path / "a.tif"
    for _ in range(round(2000 * share)):
        content = mutate(whole[rng.integers(len(whole))], rng)
        path.write_bytes(tiff(codes if content[16:20] != b"GRAY" else codes[..., 0], content))
        try:
            reply = decode_in_child("engine.images.decode:decode", path)
            assert np.isfinite(reply["pixels"]).all()
        except InputError as error:
            text = str(error)
        else:
            continue
        assert "colour profile" in text


def mutate(profile: bytes, rng: np.random.Generator) -> bytes:
    """Bytes changed in the header, the tags and the heads of bodies, where the meaning is, and sometimes cut."""
    damaged = bytearray(profile)
    for _ in range(rng.integers(1, 6)):
        at = int(rng.integers(len(damaged) if rng.random() < 0.3 else min(len(damaged), 700)))
        damaged[at] = int(rng.choice([0, 1, 127, 128, 255, int(rng.integers(256))]))
    return bytes(damaged[: int(rng.integers(len(damaged)))] if rng.random() < 0.1 else damaged)


def tagged(codes: Any, tags: list[tuple[int, str, int, Any]]) -> bytes:
    stream = io.BytesIO()
    extra = [(*tag, True) for tag in tags]
    tifffile.imwrite(stream, codes, photometric="rgb", metadata=None, extratags=extra)
    return stream.getvalue()


def fractions(*numbers: float) -> tuple[int, ...]:
    return tuple(part for number in numbers for part in (round(number * 10000), 10000))


@pytest.mark.parametrize("bits", [8, 16])
def test_colour_tags_of_tiff_say_what_a_profile_says(bits: int) -> None:
    """Display P3 with a power of 1.8, in the tags WhitePoint, PrimaryChromaticities and TransferFunction."""
    codes = SAMPLES[bits]
    levels = np.arange(1 << bits) / ((1 << bits) - 1)
    table = np.rint(65535 * levels**1.8).astype(np.uint16)
    p3 = (0.680, 0.320, 0.265, 0.690, 0.150, 0.060)
    tags = [(318, "2I", 2, fractions(0.3127, 0.3290)), (319, "2I", 6, fractions(*p3))]
    found = read(tagged(codes, [*tags, (301, "H", 3 << bits, tuple(np.tile(table, 3)))]))
    values = (codes / np.iinfo(codes.dtype).max) ** 1.8
    from_p3 = np.array([[1.2249, -0.2247, 0.0], [-0.0420, 1.0419, 0.0], [-0.0197, -0.0786, 1.0979]])
    assert worst(found["pixels"], values @ from_p3.T) < 0.005
    assert found["profile"] == "the colour tags of the TIFF"
    primaries_alone = read(tagged(codes, tags))["pixels"]
    assert (
        worst(primaries_alone, profiles.matrix_truth("Display P3", "sRGB", codes / np.iinfo(codes.dtype).max)) < 0.005
    )


def test_colour_tags_that_no_image_has_are_refused() -> None:
    codes = SAMPLES[8]
    for tags in (
        [(319, "2I", 6, fractions(0.3, 0.3, 0.3, 0.3, 0.3, 0.3))],
        [(301, "H", 100, tuple(range(100)))],
        [(301, "H", 256, tuple(range(65535, 65535 - 256, -1)))],
    ):
        with pytest.raises(InputError, match="colour profile that cannot be applied"):
            read(tagged(codes, tags))


@pytest.mark.parametrize("transfer", ["srgb", "linear"])
def test_tiff_of_our_own_says_its_colours_to_other_programs(tmp_path: Path, transfer: Any) -> None:
    """Little CMS reads the profile as that of sRGB, and as linear with its primaries."""
    from PIL import ImageCms

    encode.write_tiff16(tmp_path / "a.tif", SAMPLES[16], transfer=transfer)
    with tifffile.TiffFile(tmp_path / "a.tif") as file:
        content = bytes(file.pages[0].iccprofile)
    own = ImageCms.ImageCmsProfile(io.BytesIO(content))
    standard = ImageCms.createProfile("sRGB")
    shown = np.arange(256, dtype=np.uint8)
    image = PillowImage.fromarray(np.stack(np.broadcast_arrays(shown[:, None], shown[None], np.uint8(100)), axis=-1))
    through = np.asarray(ImageCms.profileToProfile(image, own, standard), int)
    straight = np.asarray(image, float) / 255
    coded = np.where(straight <= 0.0031308, 12.92 * straight, 1.055 * straight ** (1 / 2.4) - 0.055)
    wanted = 255 * (straight if transfer == "srgb" else coded)
    assert np.abs(through - wanted).max() <= 2
    assert content == write_profile(transfer)
    found = read((tmp_path / "a.tif").read_bytes())
    assert found["transfer"] == transfer

"""CO6–CO9: what is written is what is read back, coded once and only where it should be."""

from pathlib import Path
from typing import Any, cast

import numpy as np
import OpenEXR
import pytest

from engine.core import colour
from engine.core.errors import InputError, OutputError
from engine.images import encode
from engine.images.decode import read_image
from engine.images.exr import read_exr_channels

RNG = np.random.default_rng(7)


@pytest.mark.parametrize("write", ["png", "tiff"])
def test_CO6_16_bit_round_trip_loses_no_code(tmp_path: Path, write: str) -> None:
    codes = np.arange(65536, dtype=np.uint16).reshape(256, 256)
    codes = np.stack([codes, codes[::-1], codes.T], axis=-1)
    path = tmp_path / f"codes.{write}"
    for transfer, encoded in (("linear", lambda x: x), ("srgb", colour.srgb_encode)):
        if write == "png":
            path.write_bytes(encode.encode_png(codes, transfer=cast(Any, transfer)))
        else:
            encode.write_tiff16(path, codes, transfer=cast(Any, transfer))
        image = read_image(path)
        assert image.transfer == transfer
        back = np.rint(encoded(image.pixels.astype(np.float64)) * 65535)
        assert np.array_equal(back, codes)


def test_CO7_grey_018_is_code_118_through_every_exporter(tmp_path: Path) -> None:
    grey = np.full((4, 5, 3), 0.18, np.float32)
    shown = colour.to_display8(colour.tone_map(grey, 0, "none"))
    assert np.abs(shown.astype(int) - 118).max() <= 1
    (tmp_path / "8.png").write_bytes(encode.encode_png(shown))
    codes = np.rint(colour.srgb_encode(grey) * 65535).astype(np.uint16)
    assert np.abs(codes / 257 - 118).max() <= 1
    (tmp_path / "16.png").write_bytes(encode.encode_png(codes))
    encode.write_tiff16(tmp_path / "coded.tif", codes, transfer="srgb")
    encode.write_tiff16(tmp_path / "linear.tif", np.rint(grey * 65535).astype(np.uint16), transfer="linear")
    encode.write_exr(tmp_path / "half.exr", encode.rgb_channels(grey))
    tolerances = {"8.png": 2e-3, "16.png": 1e-5, "coded.tif": 1e-5, "linear.tif": 1e-5, "half.exr": 1e-4}
    for name, tolerance in tolerances.items():
        assert read_image(tmp_path / name).pixels == pytest.approx(0.18, abs=tolerance), name


def test_CO8_exr_comes_back_exactly(tmp_path: Path) -> None:
    sign = RNG.choice([-1, 1], (33, 47, 3))
    image = (sign * np.exp(RNG.normal(0, 4, sign.shape)).clip(0, 60000)).astype(np.float32)
    path = tmp_path / "table.exr"
    encode.write_exr(path, encode.rgb_channels(image), half=False)
    assert np.array_equal(read_image(path).pixels.view(np.uint32), image.view(np.uint32))
    encode.write_exr(path, encode.rgb_channels(image), half=True)
    back = read_image(path).pixels
    assert np.all(np.abs(back - image) <= np.spacing(np.abs(image).astype(np.float16)).astype(np.float32) / 2)


def test_CO9_parameter_maps_with_names_and_attributes(tmp_path: Path) -> None:
    exponent = RNG.uniform(0, 60, (12, 15)).astype(np.float32)
    scale = RNG.uniform(0, 2, (12, 15)).astype(np.float32)
    path = tmp_path / "maps – é.exr"
    attributes = {"lightarc:r_max": 0.25, "lightarc:note": 'ü {"a": 1}', "capturedBy": "x" * 5000}
    encode.write_exr(path, {"K.R": exponent, "k_s.R": scale}, half=False, attributes=attributes)
    with OpenEXR.File(str(path), separate_channels=True) as file:
        header, channels = dict(file.header()), file.channels()
        planes = {name: np.array(channel.pixels) for name, channel in channels.items()}
    assert np.array_equal(planes["K.R"], exponent)
    assert np.array_equal(planes["k_s.R"], scale)
    for name, value in attributes.items():
        assert header[name] == (pytest.approx(value) if isinstance(value, float) else value)
    assert header["chromaticities"] == pytest.approx(colour.CHROMATICITIES, abs=1e-6)


@pytest.mark.parametrize("size", [(1, 1), (1, 2), (5, 1), (17, 1), (33, 1)])
def test_exr_of_few_texels_comes_back(size: tuple[int, int]) -> None:
    """The chunk of the last rows is then a few bytes long."""
    values = np.full(size, 0.25, np.float16)
    for channels in ({"Y": values}, dict.fromkeys("RGB", values)):
        content = encode.encode_exr(channels)
        np.testing.assert_array_equal(read_exr_channels(content, "few.exr")[f"channel:{next(iter(channels))}"], values)
        with pytest.raises(InputError, match="incomplete"):
            read_exr_channels(content[:-9], "cut.exr")


def test_half_never_becomes_infinite_by_writing() -> None:
    image = np.array([[65504, 65519, 65520, 1e6], [-1e6, np.nan, np.inf, -np.inf]], np.float32)
    stored = encode.as_half(image)
    assert stored[0].tolist() == [65504] * 4
    assert stored[1, 0] == -65504
    assert np.isnan(stored[1, 1])
    assert stored[1, 2:].tolist() == [np.inf, -np.inf]


def test_other_programs_see_the_layers(tmp_path: Path) -> None:
    image = RNG.random((4, 5, 3)).astype(np.float32)
    path = tmp_path / "layers.exr"
    encode.write_exr(path, {**encode.rgb_channels(image, "slice0"), **encode.rgb_channels(2 * image, "slice1")})
    with OpenEXR.File(str(path), separate_channels=True) as file:
        assert sorted(file.channels()) == [f"slice{index}.{name}" for index in range(2) for name in "BGR"]


def test_a_failed_write_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(OutputError):
        encode.write_exr(tmp_path / "absent" / "image.exr", {"Y": np.zeros((2, 2), np.float32)})
    with pytest.raises(ValueError, match="alike"):
        encode.write_exr(tmp_path / "image.exr", {"R": np.zeros((2, 2)), "G": np.zeros((2, 3))})
    with pytest.raises(ValueError, match="uint16"):
        encode.write_tiff16(tmp_path / "image.tif", cast(Any, np.zeros((2, 2))), transfer="linear")
    with pytest.raises(ValueError, match="float64"):
        encode.encode_png(cast(Any, np.zeros((2, 2))))
    assert list(tmp_path.iterdir()) == []

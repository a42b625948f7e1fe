"""RAW files through LibRaw: R1–R4, R7, R9, R11, R12, CO2, and real files that are wrong without saying so."""

import itertools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.capture.photograph.decode import decode_photograph, read_photograph
from engine.capture.photograph.exposures import Noted, read_noted_exposure
from engine.core.errors import InputError
from engine.simulate.camera import Levels, dng_bytes
from engine.storage import untrusted

RNG = np.random.default_rng(31)


@pytest.fixture
def read(tmp_path: Path, dng: Any) -> Callable[..., Any]:
    """Write a DNG of these properties and read it back; options of `read_photograph` go by `options`."""

    def write_and_read(mosaic: Any, options: Any = None, **properties: Any) -> Any:
        path = tmp_path / "photograph.dng"
        path.write_bytes(dng(mosaic, **properties))
        return read_photograph(path, **(options or {}))

    return write_and_read


def noise(shape: Any = (64, 80), low: int = 100, high: int = 4000) -> NDArray[np.uint16]:
    return RNG.integers(low, high, shape).astype(np.uint16)


def test_a_grey_sensor_becomes_grey_radiance(read: Callable[..., Any]) -> None:
    photograph = read(np.full((64, 80), 64 + 1000, np.uint16), exposure=(1, 50))
    assert photograph.radiance.shape == (64, 80, 3)
    assert photograph.radiance == pytest.approx(1000 / (4095 - 64), rel=2e-4)
    assert not photograph.saturated.any()
    assert photograph.camera == "Test Camera"
    assert photograph.exposure_s == 1 / 50
    assert (photograph.container, photograph.transfer, photograph.bit_depth) == ("RAW", "linear", 12)
    assert photograph.black_level == (64,) * 4
    assert photograph.warnings == ()
    assert not photograph.radiance.flags.writeable


def test_R1_noise_around_black_keeps_its_sign(read: Callable[..., Any]) -> None:
    sigma = 8.0
    mosaic = np.rint(RNG.normal(64, sigma, (200, 300))).clip(1).astype(np.uint16)
    radiance = read(mosaic).radiance.astype(np.float64) * (4095 - 64)
    assert radiance.min() < -sigma
    assert abs(radiance.mean()) <= 4 * sigma / np.sqrt(mosaic.size)


def test_R2_white_below_black_names_both(read: Callable[..., Any]) -> None:
    with pytest.raises(InputError, match=r"photograph\.dng: .*white level 100 is not above black level 200"):
        read(noise(), white=100, black=(200,) * 4)


def test_R3_clipped_samples_are_masked(read: Callable[..., Any]) -> None:
    mosaic = noise(high=3000)
    mosaic[20, 30] = 4095
    saturated = read(mosaic).saturated
    assert saturated[20, 30]
    assert saturated.sum() == 13


@pytest.mark.parametrize("colours", [(0, 1, 1, 2), (2, 1, 1, 0), (1, 0, 2, 1), (1, 2, 0, 1)])
@pytest.mark.parametrize("shape", [(64, 80), (63, 81)])
def test_R4_per_site_black_levels(read: Callable[..., Any], colours: Any, shape: Any) -> None:
    black = (60, 61, 63, 67)
    sites = np.tile(np.reshape(black, (2, 2)), (40, 45))[: shape[0], : shape[1]]
    per_site = np.full(shape, 0.25) * (4095 - sites) + sites
    photograph = read(np.rint(per_site).astype(np.uint16), black=black, colours=colours)
    assert photograph.black_level == black
    assert photograph.radiance == pytest.approx(0.25, abs=3e-4)


def test_colours_are_at_their_sites(read: Callable[..., Any]) -> None:
    mosaic = np.full((64, 80), 64, np.uint16)
    mosaic[0::2, 0::2] = 4000
    assert np.argmax(read(mosaic).radiance.mean(axis=(0, 1))) == 0
    assert np.argmax(read(mosaic, colours=(2, 1, 1, 0)).radiance.mean(axis=(0, 1))) == 2
    assert np.argmax(read(mosaic, colours=(1, 0, 2, 1)).radiance.mean(axis=(0, 1))) == 1


@pytest.mark.parametrize("neutral", [((0, 1), (1, 1), (1, 1)), ((0, 0), (1, 1), (1, 1))])
def test_R7_bad_camera_white_balance_becomes_unit_and_a_warning(read: Callable[..., Any], neutral: Any) -> None:
    photograph = read(noise(), neutral=neutral)
    assert photograph.white_balance == (1, 1, 1)
    assert any("white balance" in warning for warning in photograph.warnings)


def test_R7_bad_given_white_balance_becomes_unit_and_a_warning(read: Callable[..., Any]) -> None:
    for multipliers in ((0, 1, 1), (1, float("nan"), 1), (1, 1, -2)):
        photograph = read(noise(), {"white_balance": multipliers})
        assert photograph.white_balance == (1, 1, 1)
        assert any("white balance" in warning for warning in photograph.warnings)


def test_white_balance_choices(read: Callable[..., Any]) -> None:
    mosaic = np.full((64, 80), 64 + 1000, np.uint16)
    neutral = ((1, 2), (1, 1), (2, 3))
    assert read(mosaic, neutral=neutral).white_balance == (2, 1, 1.5)
    assert read(mosaic, {"white_balance": "none"}, neutral=neutral).white_balance == (1, 1, 1)
    photograph = read(mosaic, {"white_balance": (4, 2, 1)}, neutral=neutral)
    assert photograph.white_balance == (2, 1, 0.5)
    assert photograph.radiance[10, 10] == pytest.approx(np.array([2, 1, 0.5]) * 1000 / 4031, rel=2e-3)
    with pytest.raises(ValueError, match="auto"):
        read(mosaic, {"white_balance": "auto"})


@pytest.mark.parametrize("exposure", [(0, 0), (1, 0), (0, 1), None])
def test_R9_impossible_exposure_is_unknown(read: Callable[..., Any], exposure: Any) -> None:
    assert read(noise(), exposure=exposure).exposure_s is None


@pytest.mark.parametrize("orientation", range(1, 9))
def test_R11_orientation_of_raw(read: Callable[..., Any], orientation: int) -> None:
    mosaic = noise((64, 80))
    upright = read(mosaic).radiance
    expected = {
        1: upright,
        2: upright[:, ::-1],
        3: np.rot90(upright, 2),
        4: upright[::-1],
        5: upright.transpose(1, 0, 2),
        6: np.rot90(upright, -1),
        7: np.rot90(upright, 2).transpose(1, 0, 2),
        8: np.rot90(upright),
    }[orientation]
    assert np.array_equal(read(mosaic, orientation=orientation).radiance, expected)


@pytest.mark.parametrize("orientation", [1, 6])
def test_pixels_of_an_answered_mosaic_are_those_that_the_decoder_makes(
    read: Callable[..., Any], dng: Any, orientation: int
) -> None:
    mosaic, properties = noise((64, 80)), {"orientation": orientation, "black": (60, 64, 66, 70)}
    mosaic[20, 33] = 4095
    expected = decode_photograph(dng(mosaic, **properties), "a.dng", "camera", "auto", False)
    photograph = read(mosaic, **properties)
    assert photograph.saturated.any()
    assert np.array_equal(photograph.radiance.view(np.uint32), expected["radiance"].view(np.uint32))
    assert np.array_equal(photograph.saturated, expected["saturated"])


@pytest.mark.parametrize(
    "change",
    [
        {"mosaic": np.ones((2, 80), np.uint16)},
        {"mosaic": np.ones((64, 80), np.float32)},
        {"colours": [0, 1, 1, 7]},
        {"colours": [0, 1, 1]},
        {"turn": 9},
        {"white_level": [50.0] * 4},
        {"white_balance": [1.0, 1.0]},
        {"camera_matrix": None},
        {"radiance": np.ones((64, 80, 3), np.float32), "mosaic": None},
    ],
)
def test_fault18_an_answer_that_is_no_mosaic_is_refused(
    read: Callable[..., Any], dng: Any, monkeypatch: pytest.MonkeyPatch, change: dict[str, Any]
) -> None:
    mosaic = noise()
    reply = decode_photograph(dng(mosaic), "a.dng", "camera", "auto", False, mosaic_alone=True)
    monkeypatch.setattr(untrusted, "decode_in_child", lambda *_, **__: {**reply, **change})
    with pytest.raises(InputError, match="invalid response"):
        read(mosaic)


def test_an_exposure_is_found_behind_the_samples(tmp_path: Path) -> None:
    path = tmp_path / "a.dng"
    path.write_bytes(dng_bytes(noise((600, 1000)), Levels(black=((64,) * 2,) * 2, white=4095), exposure_s=1 / 60))
    noted = read_noted_exposure(path)
    assert noted == Noted(noted.exposure_s, 100.0, 8.0)
    assert noted.exposure_s == pytest.approx(1 / 60, rel=1e-5)


@pytest.mark.parametrize("matrix", [np.zeros((3, 3)), np.ones((3, 3)), np.diag([1, 1, 0])])
def test_CO2_singular_camera_matrix_falls_back_to_srgb(read: Callable[..., Any], matrix: Any) -> None:
    photograph = read(np.full((64, 80), 1064, np.uint16), camera_from_xyz=matrix)
    assert any("colour matrix" in warning for warning in photograph.warnings)
    assert photograph.matrix_source == ""
    assert read(np.full((64, 80), 1064, np.uint16)).matrix_source == "the file"
    assert photograph.radiance == pytest.approx(1000 / 4031, rel=1e-6)


def test_half_size_averages_and_keeps_the_mask(read: Callable[..., Any]) -> None:
    mosaic = noise((65, 80))
    mosaic[20, 30] = 4095
    whole, half = read(mosaic), read(mosaic, {"half_size": True})
    assert half.radiance.shape == (32, 40, 3)
    blocks = whole.radiance[:64].reshape(32, 2, 40, 2, 3).mean(axis=(1, 3))
    assert half.radiance == pytest.approx(blocks, abs=1e-5)
    assert np.array_equal(half.saturated, whole.saturated[:64].reshape(32, 2, 40, 2).any(axis=(1, 3)))


@pytest.mark.parametrize("compression", [None, "jpeg"])
def test_R12_every_truncation_of_a_dng_is_an_error(tmp_path: Path, dng: Any, compression: str | None) -> None:
    mosaic = noise((96, 128), low=64, high=250) if compression else noise((96, 128))
    if compression:
        mosaic = mosaic.astype(np.uint8)
    content = dng(mosaic, compression=compression, white=255 if compression else 4095)
    path = tmp_path / "cut.dng"
    for part in range(1, 64):
        path.write_bytes(content[: len(content) * part // 64])
        with pytest.raises(InputError):
            read_photograph(path)
    path.write_bytes(content[:-1])
    with pytest.raises(InputError):
        read_photograph(path)


@pytest.mark.parametrize(("rows", "value", "words"), [
    (np.s_[95:], 0, "its last rows all hold the value 0"),
    (np.s_[40:44], 0, "some of its rows all hold the value 0"),
    (np.s_[30:50], 700, "some of its rows all hold the value 700"),
])  # fmt: skip
def test_R12_rows_that_were_never_filled_are_an_error(
    read: Callable[..., Any], rows: Any, value: int, words: str
) -> None:
    mosaic = noise((96, 128))
    mosaic[rows] = value
    with pytest.raises(InputError, match=words):
        read(mosaic)


@pytest.mark.parametrize("filled", [0, 1, 20])
def test_R12_a_file_without_its_image_is_refused_as_one_with_a_part_of_it(
    read: Callable[..., Any], filled: int
) -> None:
    """LibRaw gives zeros for all that is missing, and they lie below the black level."""
    mosaic = np.zeros((96, 128), np.uint16)
    mosaic[:filled] = noise((96, 128))[:filled]
    with pytest.raises(InputError, match="is an incomplete RAW file"):
        read(mosaic)


@pytest.mark.parametrize("value", [64, 4095])
def test_R12_rows_at_black_or_at_white_are_no_damage(read: Callable[..., Any], value: int) -> None:
    mosaic = noise((96, 128))
    mosaic[40:60] = value
    assert read(mosaic).radiance.shape == (96, 128, 3)


@pytest.mark.parametrize("name", ["raw/RAW_KODAK_DC50.KDC", "raw/canon_eos_6d.dng"])
def test_R12_every_truncation_of_real_raw_is_an_error_or_harmless(
    tmp_path: Path, shared_data: Callable[[str], Path], name: str
) -> None:
    source = shared_data(name)
    content = source.read_bytes()
    whole = read_photograph(source).radiance
    path = tmp_path / source.name
    for part in itertools.chain(range(4, 64, 6), (62, 63)):
        path.write_bytes(content[: len(content) * part // 64])
        try:
            radiance = read_photograph(path).radiance
        except InputError:
            continue
        assert np.array_equal(radiance, whole), f"cut at {part}/64 changes the image silently"


def test_fault5_a_dng_that_states_another_size_than_it_holds_is_refused(tmp_path: Path, dng: Any) -> None:
    content = dng(noise((64, 80)))
    path = tmp_path / "size.dng"
    for tag, stated, lie in ((256, 80, 64), (257, 64, 48)):
        entry = np.array([tag, 4], "<u2").tobytes() + np.array([1, stated], "<u4").tobytes()
        assert content.count(entry) == 1
        path.write_bytes(content.replace(entry, entry[:8] + np.array([lie], "<u4").tobytes()))
        with pytest.raises(InputError, match="damaged"):
            read_photograph(path)


BROKEN = [
    "exiftool_CanonRaw.cr2",
    "exiftool_CanonRaw.crw",
    "exiftool_FujiFilm.raf",
    "exiftool_Nikon.nef",
    "exiftool_Panasonic.rw2",
    "exiftool_SigmaDP2.x3f",
    "exiv2_Canon-R6-pruned.CR3",
    "exiv2_exiv2-canon-powershot-s40.crw",
    "exiv2_issue_857_poc.raf",
    "exiv2_issue_9324_poc.crw",
    "fake_test.dng",
]


@pytest.mark.parametrize("name", BROKEN)
def test_R12_fault5_broken_real_files_are_refused_with_a_reason(shared_data: Callable[[str], Path], name: str) -> None:
    path = shared_data(f"raw/broken/{name}")
    with pytest.raises(InputError, match="RAW") as caught:
        read_photograph(path)
    assert name in str(caught.value)
    assert "Traceback" not in str(caught.value)


def test_a_image_with_a_raw_suffix_is_read_and_named(shared_data: Callable[[str], Path]) -> None:
    photograph = read_photograph(shared_data("raw/broken/nikon_issue247-1.nef"))
    assert photograph.container == "JPEG"
    assert any("not camera RAW" in warning for warning in photograph.warnings)


def test_real_raw_has_plausible_values(shared_data: Callable[[str], Path]) -> None:
    kodak = read_photograph(shared_data("raw/RAW_KODAK_DC50.KDC"))
    assert kodak.radiance.shape == (512, 768, 3)
    assert 0.1 < kodak.radiance.mean() < 0.3
    canon = read_photograph(shared_data("raw/canon_eos_6d.dng"))
    assert canon.radiance.shape == (816, 1224, 3)
    assert canon.exposure_s == pytest.approx(1 / 60)
    assert (canon.camera, canon.iso, canon.aperture) == ("Canon EOS 6D", 1000, pytest.approx(5.6))


def test_unsupported_raw_says_how_to_convert(shared_data: Callable[[str], Path]) -> None:
    with pytest.raises(InputError, match="DNG"):
        read_photograph(shared_data("raw/gopro_hero6_GOPR0024.GPR"))

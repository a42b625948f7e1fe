"""Simulated captures against their own ground truth, read back with libraries that did not write them."""

from __future__ import annotations

import hashlib
import json
import math
import os
import tomllib
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import OpenEXR
import pytest
import rawpy
import tifffile

from engine.capture.lights.mirror_sphere import Circle, find_highlight, light_direction
from engine.capture.photograph.decode import read_photograph
from engine.core.colour import srgb_decode
from engine.core.errors import OutputError
from engine.core.steps import drain
from engine.simulate.arc import LightArc, shots
from engine.simulate.camera import LEVELS, with_noise
from engine.simulate.simulate import renderings, simulate
from tests.threads import threads

ANGLES = tuple(math.radians(angle) for angle in (10, 35, 60, 90))


def arc(**settings: Any) -> LightArc:
    return LightArc(**{"size": 48, "elevation": ANGLES, **settings})


def exr(path: Path) -> Any:
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = file.channels()
        return np.stack([channels[name].pixels for name in "RGB" if name in channels], axis=-1)


def photograph(path: Path) -> Any:
    return srgb_decode(tifffile.imread(path) / 65535.0)


def truth(folder: Path) -> Any:
    return json.loads((folder / "truth" / "truth.json").read_text())


def digest(folder: Path) -> dict[str, Any]:
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def test_capture_toml_lists_every_photograph_with_its_angle(tmp_path: Path) -> None:
    capture = drain(simulate(arc(), tmp_path / "c"))
    table = tomllib.loads((tmp_path / "c" / "capture.toml").read_text())
    assert [entry["file"] for entry in table["photographs"]] == [path.name for path in capture.photographs]
    assert [entry["elevation_deg"] for entry in table["photographs"]] == [10, 35, 60, 90]
    assert all(path.is_file() for path in capture.photographs)
    assert capture.photographs[0].name == "woven_10.tif"


def test_photographs_are_the_truth_within_the_noise(tmp_path: Path) -> None:
    folder = tmp_path / "c"
    drain(simulate(arc(size=96, noise=0.01), folder))
    for record in truth(folder)["photographs"]:
        clean = exr(folder / "truth" / record["radiance"]).astype(float)
        error = photograph(folder / record["file"]) - clean
        normal = (error / (0.01 * np.sqrt(0.99 * clean + 0.01)))[(clean > 0.05) & (clean < 0.9)]
        assert abs(normal.mean()) < 5 / math.sqrt(normal.size)
        assert abs(normal.std() - 1) < 5 / math.sqrt(2 * normal.size)


@pytest.mark.parametrize("format_", ["tiff", "exr"])
def test_import_reads_the_photographs_as_they_were_simulated(tmp_path: Path, format_: str) -> None:
    folder = tmp_path / "c"
    drain(simulate(arc(format=format_, noise=0.0), folder))
    for record in truth(folder)["photographs"][1:]:
        read = read_photograph(folder / record["file"])
        clean = exr(folder / "truth" / record["radiance"])
        np.testing.assert_allclose(read.radiance, np.minimum(clean, 1), rtol=6e-4, atol=2e-5)


def test_import_develops_the_raw_photographs_to_the_truth(tmp_path: Path) -> None:
    """A smooth card has the same colour in every pixel whatever the demosaicing does."""
    folder = tmp_path / "c"
    drain(simulate(arc(sample="plain", format="dng", noise=0.0), folder))
    for record in truth(folder)["photographs"]:
        read = read_photograph(folder / record["file"])
        clean = exr(folder / "truth" / record["radiance"])
        np.testing.assert_allclose(read.radiance[8:-8, 8:-8], clean[8:-8, 8:-8], atol=2e-4)
        assert read.exposure_s == pytest.approx(record["exposure_s"], rel=1e-4)


def test_noise_has_the_stated_variance_and_keeps_negatives() -> None:
    for level in (0.0, 0.25, 1.0):
        signal = np.full((400, 500), level, np.float32)
        noise = (with_noise(signal, 0.1, (7,)) - signal).astype(float)
        expected = 0.1**2 * (0.99 * level + 0.01)
        assert noise.var() == pytest.approx(expected, rel=5 * math.sqrt(2 / noise.size))
        assert abs(noise.mean()) < 5 * math.sqrt(expected / noise.size)
    assert with_noise(np.zeros((9, 9), np.float32), 0.1, (7,)).min() < 0


def test_mean_radiance_rises_with_the_lamp_and_the_brightest_is_well_exposed(tmp_path: Path) -> None:
    for sample in ("woven", "hammered", "leather", "plain"):
        drain(simulate(arc(sample=sample, size=96), tmp_path / sample))
        records = truth(tmp_path / sample)["photographs"]
        means = [record["mean_radiance"] for record in records]
        assert means == sorted(means)
        brightest = exr(tmp_path / sample / "truth" / records[-1]["radiance"])
        assert np.percentile(brightest, 99.9) == pytest.approx(0.9, abs=0.02)
        assert records[-1]["clipped_fraction"] < 2e-3


def test_plain_card_follows_the_sine(tmp_path: Path) -> None:
    drain(simulate(arc(sample="plain"), tmp_path / "c"))
    means = np.array([record["mean_radiance"] for record in truth(tmp_path / "c")["photographs"]])
    np.testing.assert_allclose(means, 0.9 * np.sin(ANGLES), rtol=1e-5)


def test_maps_of_the_surface_lie_beside_the_photographs(tmp_path: Path) -> None:
    """A card is flat and reflects what its photograph says; elsewhere normals follow the gradient of the height."""
    drain(simulate(arc(sample="plain", noise=0.0, azimuth=(0.0, 2.0)), tmp_path / "card"))
    known, folder = truth(tmp_path / "card"), tmp_path / "card" / "truth"
    np.testing.assert_allclose(exr(folder / "normal.exr"), np.broadcast_to((0.0, 0.0, 1.0), (48, 48, 3)))
    for record in known["photographs"]:
        sine = math.sin(math.radians(record["elevation_deg"]))
        expected = exr(folder / "albedo.exr") / math.pi * known["lamp_irradiance"] * sine
        np.testing.assert_allclose(exr(folder / record["radiance"]), expected, rtol=1e-4)
    drain(simulate(arc(sample="hammered", size=192), tmp_path / "brass"))
    folder = tmp_path / "brass" / "truth"
    with OpenEXR.File(str(folder / "height.exr"), separate_channels=True) as file:
        height = file.channels()["Y"].pixels.astype(float)
    slope = np.dstack([np.roll(height, -1, 1) - np.roll(height, 1, 1), np.roll(height, 1, 0) - np.roll(height, -1, 0)])
    normal = exr(folder / "normal.exr")
    np.testing.assert_allclose(np.linalg.norm(normal, axis=-1), 1.0, atol=1e-5)
    for axis in (0, 1):
        given = -normal[..., axis] / normal[..., 2]
        assert np.corrcoef(given.ravel(), 0.5 * slope[..., axis].ravel())[0, 1] > 0.9
        assert np.polyfit(0.5 * slope[..., axis].ravel(), given.ravel(), 1)[0] == pytest.approx(1.0, abs=0.1)


def test_shift_moves_the_image_by_what_the_truth_says(tmp_path: Path) -> None:
    """The phase of every well-lit low frequency of the moved photograph against the one left in place."""
    for name, misalignment in (("still", 0.0), ("moved", 1.5)):
        drain(simulate(arc(size=192, misalignment_px=misalignment, noise=0.0), tmp_path / name))
    still, moved = (truth(tmp_path / name)["photographs"] for name in ("still", "moved"))
    assert (moved[0]["shift_right_px"], moved[0]["shift_down_px"]) == (0, 0)
    for before, after in zip(still[1:], moved[1:], strict=True):
        a, b = (
            np.fft.fft2(exr(tmp_path / name / "truth" / record["radiance"])[..., 1])[:13, :13]
            for name, record in (("still", before), ("moved", after))
        )
        row, column = np.mgrid[0:13, 0:13] / 192
        predicted = np.exp(-2j * np.pi * (row * after["shift_down_px"] + column * after["shift_right_px"]))
        assert abs(after["shift_right_px"]) <= 1.5
        strong = np.abs(a) > 0.05 * np.abs(a).ravel()[1:].max()
        assert strong.sum() >= 3
        assert np.abs(b / a - predicted)[strong].max() < 0.02


@pytest.mark.parametrize("bits", [12, 14])
def test_raw_photographs_hold_the_known_levels(tmp_path: Path, bits: int) -> None:
    folder = tmp_path / "c"
    drain(simulate(arc(format="dng", raw_bits=bits, noise=0.0), folder))
    for record in truth(folder)["photographs"]:
        clean = exr(folder / "truth" / record["radiance"]).astype(float)
        with rawpy.imread(str(folder / record["file"])) as raw:
            black = np.array(raw.black_level_per_channel)[raw.raw_pattern]
            assert np.array_equal(black, LEVELS[bits].black)
            assert raw.white_level == 2**bits - 1
            site = np.tile(black, (24, 24))
            value = (raw.raw_image_visible - site) / (raw.white_level - site)
        half_a_sample = 0.501 / (2**bits - 1 - black.max())
        assert np.abs(value[0::2, 0::2] - clean[0::2, 0::2, 0] * 0.5).max() <= half_a_sample
        assert np.abs(value[1::2, 1::2] - clean[1::2, 1::2, 2] * 0.625).max() <= half_a_sample


def test_exr_photographs_are_linear_and_unclipped(tmp_path: Path) -> None:
    folder = tmp_path / "c"
    drain(simulate(arc(format="exr", noise=0.0), folder))
    for record in truth(folder)["photographs"]:
        clean = exr(folder / "truth" / record["radiance"])
        np.testing.assert_allclose(exr(folder / record["file"]).astype(float), clean, rtol=6e-4, atol=1e-7)


def test_interreflection_lifts_the_shadows(tmp_path: Path) -> None:
    for name, on in (("with", True), ("without", False)):
        drain(simulate(arc(sample="leather", size=96, interreflection=on, noise=0.0), tmp_path / name))
    shadow = {}
    for name in ("with", "without"):
        image = exr(tmp_path / name / "truth" / "radiance_leather_10.exr").mean(axis=2)
        shadow[name] = np.percentile(image, 2) / image.mean()
    assert shadow["with"] > 1.04 * shadow["without"]


@pytest.mark.parametrize("format_", ["tiff", "exr", "dng"])
def test_equal_settings_give_equal_bytes_on_any_number_of_threads(tmp_path: Path, format_: str) -> None:
    for name, count in (("one", 1), ("two", 2)):
        with threads(count):
            drain(simulate(arc(format=format_, azimuth=(0.0, 1.0)), tmp_path / name))
    assert digest(tmp_path / "one") == digest(tmp_path / "two")


def test_another_seed_gives_other_photographs(tmp_path: Path) -> None:
    drain(simulate(arc(sample="plain", seed=1), tmp_path / "a"))
    drain(simulate(arc(sample="plain", seed=2), tmp_path / "b"))
    assert not np.array_equal(photograph(tmp_path / "a/plain_35.tif"), photograph(tmp_path / "b/plain_35.tif"))


@pytest.mark.parametrize("stride", [3, pytest.param(1, marks=pytest.mark.long)])
def test_fault_17_cancelling_at_every_step_leaves_nothing(tmp_path: Path, stride: int) -> None:
    total = sum(1 for _ in simulate(arc(size=32), tmp_path / "whole"))
    assert total >= 2 * len(ANGLES)
    for stop in {*range(1, total + 1, stride), total}:
        steps = simulate(arc(size=32), tmp_path / "cancelled")
        for _ in range(stop):
            next(steps)
        steps.close()
        assert [path.name for path in tmp_path.iterdir()] == ["whole"]


def test_a_simulated_capture_is_replaced_and_another_folder_is_not(tmp_path: Path) -> None:
    folder = tmp_path / "c"
    drain(simulate(arc(sample="plain", size=32), folder))
    drain(simulate(arc(sample="woven", size=32), folder))
    assert not list(folder.glob("plain*"))
    own = tmp_path / "own"
    own.mkdir()
    (own / "capture.toml").write_text("notes = 'mine'")
    with pytest.raises(OutputError, match="own"):
        drain(simulate(arc(size=32), own))
    assert [path.name for path in own.iterdir()] == ["capture.toml"]


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="needs a user whom permissions bind")
def test_fault_14_read_only_folder_is_named(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(OutputError, match="permit"):
            drain(simulate(arc(size=32), tmp_path / "c"))
    finally:
        tmp_path.chmod(0o700)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"sample": "velvet"}, "unknown sample"),
        ({"format": "jpeg"}, "unknown format"),
        ({"size": 8}, "size 8 px"),
        ({"elevation": (0.0,)}, "elevations"),
        ({"elevation": (math.nan,)}, "elevations"),
        ({"elevation": ()}, "elevations"),
        ({"elevation": (0.5, 0.5)}, "same angles"),
        ({"azimuth": (7.0,)}, "azimuths"),
        ({"noise": -0.1}, "noise"),
        ({"exposure": (0.0,)}, "exposures"),
        ({"exposure": (1.0, 1.0)}, "two exposures"),
        ({"lamp_distance": 0.2}, "lamp"),
        ({"lamp_distance": math.nan}, "lamp"),
        ({"raw_bits": 10}, "12 or 14 bits"),
        ({"corner_loss": 1.0}, "corner_loss"),
        ({"turn": 1.0}, "turn"),
        ({"misalignment_px": math.inf}, "misalignment_px"),
    ],
)
def test_settings_out_of_range_are_refused(settings: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        arc(**settings)


def test_names_sort_by_azimuth_then_elevation() -> None:
    taken = shots(arc(azimuth=(0.0, math.pi / 2), elevation=(math.radians(7.5), math.radians(45))))
    assert [shot.file for shot in taken] == [
        "woven_azimuth000_07.5.tif",
        "woven_azimuth000_45.tif",
        "woven_azimuth090_07.5.tif",
        "woven_azimuth090_45.tif",
    ]


def test_exposures_of_a_light_differ_by_their_time_alone(tmp_path: Path) -> None:
    folder = tmp_path / "c"
    capture = drain(simulate(arc(format="exr", exposure=(0.25, 1.0, 4.0), noise=0.0, turn=0.02), folder))
    table = tomllib.loads((folder / "capture.toml").read_text())["photographs"]
    assert len(capture.shots) == len(table) == 3 * len(ANGLES)
    times = np.array([entry["exposure_s"] for entry in table[:3]])
    np.testing.assert_allclose(times / times[1], [0.25, 1, 4])
    for start in range(0, len(table), 3):
        short, usual, long = (exr(folder / entry["file"]).astype(float) for entry in table[start : start + 3])
        np.testing.assert_allclose(4 * short, usual, rtol=1.2e-3, atol=1e-6)
        np.testing.assert_allclose(long, 4 * usual, rtol=1.2e-3, atol=1e-6)
    assert len(list((folder / "truth").glob("radiance*"))) == len(ANGLES)


@pytest.mark.parametrize("format_", ["tiff", "exr", "dng"])
def test_dark_frame_and_flat_field_undo_sensor_and_lens(tmp_path: Path, format_: str) -> None:
    """(photograph - dark) / (flat - dark) is the ground truth, up to one factor."""
    folder = tmp_path / "c"
    settings = {"sample": "plain", "corner_loss": 0.5, "dark": 0.03, "noise": 0.0, "elevation": ANGLES[1:]}
    drain(simulate(arc(format=format_, calibration=True, **settings), folder))
    table = tomllib.loads((folder / "capture.toml").read_text())
    dark, flat = (read_photograph(folder / table[name]).radiance for name in ("dark", "flat"))
    assert dark.mean() > 0.02
    assert flat[:2, :2].mean() < 0.62 * flat[24, 24].mean()
    inside = np.s_[4:-4, 4:-4]
    for entry, record in zip(table["photographs"], truth(folder)["photographs"], strict=True):
        even = (read_photograph(folder / entry["file"]).radiance - dark) / (flat - dark) * 0.8
        clean = exr(folder / "truth" / record["radiance"])
        np.testing.assert_allclose(even[inside], clean[inside], rtol=3e-3)


def test_turned_photographs_lie_where_their_matrix_says(tmp_path: Path) -> None:
    """Blurred a little, because what is finer than two pixels cannot be resampled."""
    for name, turn in (("still", 0.0), ("turned", 0.05)):
        drain(simulate(arc(size=128, turn=turn, misalignment_px=2 * turn / 0.05, noise=0.0), tmp_path / name))
    for before, after in zip(*(truth(tmp_path / name)["photographs"] for name in ("still", "turned")), strict=True):
        a, b = (exr(tmp_path / n / "truth" / r["radiance"])[..., 1] for n, r in (("still", before), ("turned", after)))
        undone = cv2.warpAffine(
            b, np.array(after["alignment_matrix"]), (128, 128), flags=cv2.INTER_LANCZOS4 | cv2.WARP_INVERSE_MAP
        )
        inside = np.s_[16:-16, 16:-16]
        difference = cv2.GaussianBlur(undone - a, (0, 0), 2.0)[inside]
        assert np.sqrt(np.mean(difference**2)) < 0.01 * cv2.GaussianBlur(a, (0, 0), 2.0).std()


def test_sphere_shows_the_lamp_in_every_photograph(tmp_path: Path) -> None:
    folder = tmp_path / "c"
    drain(simulate(arc(size=240, sphere=True, lamp_distance=1.5, azimuth=(2.0,), noise=0.0), folder))
    place = tomllib.loads((folder / "capture.toml").read_text())["sphere"]
    for record in truth(folder)["photographs"]:
        right, down = record["shift_right_px"], record["shift_down_px"]
        ball = Circle(place["column_px"] + right, place["row_px"] + down, place["radius_px"])
        luminance = photograph(folder / record["file"]).mean(axis=2).astype(np.float32)
        found = light_direction(ball, *find_highlight(luminance, ball))
        a_third_of_a_pixel = 2 * 0.35 / ball.radius
        assert math.acos(min(1.0, float(found @ record["sphere_light"]))) < a_third_of_a_pixel


def test_near_lamp_is_noted_and_lights_one_side_more(tmp_path: Path) -> None:
    folder = tmp_path / "c"
    drain(simulate(arc(sample="plain", lamp_distance=1.0, misalignment_px=0.0, noise=0.0), folder))
    assert tomllib.loads((folder / "capture.toml").read_text())["lamp_distance"] == 1.0
    records = truth(folder)["photographs"]
    low, high = (exr(folder / "truth" / records[place]["radiance"])[..., 1] for place in (0, -1))
    assert low[24, 44] > 1.5 * low[24, 24] > 2 * low[24, 4]
    assert high[24, 44] == pytest.approx(high[24, 3], rel=1e-4)


def test_renderings_between_the_photographs_are_on_the_scale_of_the_capture(tmp_path: Path) -> None:
    settings = arc(misalignment_px=0.0)
    drain(simulate(settings, tmp_path / "c"))
    at_photograph, between = drain(renderings(settings, [ANGLES[1], math.radians(50)]))
    record = truth(tmp_path / "c")["photographs"][1]
    assert np.array_equal(at_photograph, exr(tmp_path / "c" / "truth" / record["radiance"]))
    after = truth(tmp_path / "c")["photographs"][2]["mean_radiance"]
    assert record["mean_radiance"] < between.mean() < 1.1 * after

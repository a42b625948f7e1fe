"""Stacks of codes: what is read has the bits of radiance that was written, and their records are not believed."""

from __future__ import annotations

import base64
import json
import math
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.capture import coded_pixels
from engine.capture.calibration.correction import Correction
from engine.capture.coded_pixels import Curve, Decoding, FallOff, Window, arrays_of, count_rows, radiance_of
from engine.capture.import_plan import ImportSettings
from engine.capture.import_stack import import_stack
from engine.capture.lights.sources import find
from engine.capture.photograph.calibration import Calibration
from engine.capture.photograph.decode import read_photograph
from engine.capture.stack import CODES, RADIANCE, RECORD, ROOM, SATURATED, ImageStack, npy_header, open_stack
from engine.capture.tally import Tally
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.images.codes import Coded
from engine.storage.file_array import FileArray
from engine.storage.records import seal
from tests.engine.capture.calibration.generated import Capture, render, write

HEIGHT, WIDTH, COUNT = 30, 40, 3


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("coded")
    write(render(Capture(seed=2, file_format="jpg", lamps=4, height=20, width=24)), place / "photographs")
    return place / "photographs"


@pytest.fixture(scope="module")
def stack(folder: Path) -> ImageStack:
    return drain(import_stack(find([folder]), ImportSettings(calibrate="none"), folder.with_name("stack")))


def _random(seed: int, folder: Path) -> tuple[tuple[Any, Any], NDArray[np.float32], NDArray[np.bool_]]:
    """Arrays of random codes in a file, and the radiance and saturation that the steps of an import make of them."""
    random = np.random.default_rng(seed)
    kind = np.uint16 if seed % 2 else np.uint8
    most, channels = 1 << 8 * np.dtype(kind).itemsize, 1 if seed % 5 == 4 else 3
    codes = random.integers(0, most, (COUNT, HEIGHT, WIDTH, channels), kind)
    nearness = 0.4 if seed % 3 == 0 else 0.0
    angles = random.uniform(0.2, 1.5, COUNT), random.uniform(-3.0, 6.0, COUNT)
    room = random.uniform(0.0, 0.4, (HEIGHT, WIDTH, 3)).astype(np.float32) if seed % 3 != 1 else None
    correction = Correction(random.uniform(0.5, 2.0, COUNT), nearness, *angles, room) if seed != 1 else None
    stated = 3.0 if seed % 4 == 2 else math.inf
    window = Window(HEIGHT, WIDTH, 3, 5) if seed % 3 else Window(HEIGHT, WIDTH)
    decodings, radiance, saturated = [], [], []
    for index in range(COUNT):
        tables = random.random((random.choice((1, 3)), most)).astype(np.float32)
        matrix = random.uniform(-0.3, 1.2, (3, 3)).astype(np.float32) if seed % 4 == 3 else None
        coded = Coded(codes[index], tables, int(0.9 * most), matrix)
        balance = tuple(random.uniform(0.5, 2.0, 3).tolist()) if seed != 1 else (1.0, 1.0, 1.0)
        calibration, lamp = Calibration(lamp_distance=stated, balance=balance), (float(angles[0][index]), 0.3)
        photograph: Any = type("Photograph", (), {"container": "JPEG"})
        light = coded.linear(0, HEIGHT)
        calibration.correct_rows(light, 0, photograph, HEIGHT, *lamp, 1.0)
        if correction is not None:
            correction.apply(index, light[0], 0, HEIGHT)
        radiance.append(light[0][window.top :, window.left :])
        saturated.append(light[1][window.top :, window.left :])
        factors = calibration.factors(photograph, 1.0).tolist()
        near = FallOff(stated, *lamp) if math.isfinite(stated) else None
        decodings.append(Decoding(Curve(tables, coded.white, matrix), factors, near).add_correction(correction, index))
    cut = np.ascontiguousarray(codes[:, window.top :, window.left :])
    path = folder / f"{seed}.npy"
    path.write_bytes(npy_header(cut.shape, kind) + cut.tobytes())
    array, of_room = FileArray(path, cut.shape, np.dtype(kind), 128, path.stat()), None
    if room is not None:
        shown, path = np.ascontiguousarray(room[None, window.top :, window.left :]), folder / f"{seed}_room.npy"
        path.write_bytes(npy_header(shown.shape, np.float32) + shown.tobytes())
        of_room = FileArray(path, shown.shape, np.dtype(np.float32), 128, path.stat())
    arrays = arrays_of(array, tuple(decodings), window, cut.shape[1:3], of_room)
    return arrays, np.stack(radiance), np.stack(saturated)


@pytest.mark.parametrize("seed", range(12))
def test_what_is_read_has_the_bits_of_what_an_import_makes(
    seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In parts and by several threads, of any kind of codes, tables, colours, lamps, room light and windows."""
    monkeypatch.setattr(coded_pixels, "_PART_PIXELS", 200)
    monkeypatch.setattr(coded_pixels, "FEW_PIXELS", 400)
    arrays, *expected = _random(seed, tmp_path)
    for array, values in zip(arrays, expected, strict=True):
        assert (array.shape, array.dtype, array.nbytes) == (values.shape, values.dtype, values.nbytes)
        thinned = np.s_[:, 2:20:3, 1:], np.s_[1, 2:20:3, 1:], np.s_[-1, ::2, ::4], np.s_[2, 1::5, 3]
        for key in (np.s_[:], np.s_[1], np.s_[[2, 0], 4:9], np.s_[2, 7, 3], *thinned):
            assert np.array_equal(array[key], values[key])
    rows = arrays[0].codes[0, 4:19]
    room = None if arrays[0].room is None else arrays[0].room[0, 4:19]
    made = radiance_of(rows, 4, rows.shape[:2], arrays[0].decodings[0], arrays[0].window, room)
    assert all(np.array_equal(found, values[0, 4:19]) for found, values in zip(made, expected, strict=True))
    tally, counted = Tally(3), Tally(3)
    tally.add(*made, 4)
    counted.join(*count_rows(rows, 4, rows.shape[:2], arrays[0].decodings[0], arrays[0].window, 3, room))
    assert (counted.clipped, counted.black) == (tally.clipped, tally.black)
    assert np.array_equal(counted.rows[0], tally.rows[0])
    assert np.array_equal(counted.grid[0], tally.grid[0])


def test_a_stack_of_codes_is_the_one_of_radiance(folder: Path, stack: ImageStack, tmp_path: Path) -> None:
    assert sorted(path.name for path in folder.with_name("stack").iterdir()) == [CODES, RECORD]
    other = drain(import_stack(find([folder]), ImportSettings(calibrate="none"), tmp_path / "radiance", as_codes=False))
    assert sorted(path.name for path in (tmp_path / "radiance").iterdir()) == [RADIANCE, SATURATED, RECORD]
    record = json.loads((tmp_path / "radiance" / RECORD).read_text())
    assert record["lightarc_stack"] == 1
    assert "codes" not in record
    for found, expected in ((stack.radiance, other.radiance), (stack.saturated, other.saturated)):
        assert np.array_equal(found[:], expected[:])
        assert np.array_equal(found[1, 3:5], np.load(tmp_path / "radiance" / expected.path.name)[1, 3:5])  # type: ignore[union-attr]
    assert stack.mean_radiance.tolist() == other.mean_radiance.tolist()
    assert stack.quality == other.quality
    assert stack.health == other.health
    assert set(stack.pixels) == {CODES}


def test_a_photograph_of_another_kind_than_the_first_makes_a_stack_of_radiance(folder: Path, tmp_path: Path) -> None:
    import cv2

    place = tmp_path / "mixed"
    place.mkdir()
    paths = sorted(folder.glob("*.jpg"))
    grey = np.round(65535 * read_photograph(paths[0]).radiance.mean(axis=-1)).astype(np.uint16)
    for at, path in enumerate(paths):
        (place / f"{at}_{20 + 20 * at}deg.jpg").write_bytes(path.read_bytes())
    cv2.imwrite(str(place / "4_10deg.png"), grey)
    found = drain(import_stack(find([place]), ImportSettings(motion="none"), tmp_path / "stack"))
    assert set(found.pixels) == {RADIANCE, SATURATED}
    assert len(found.radiance) == 5


@pytest.fixture(scope="module")
def lit(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Photographs in a lit room."""
    made = Capture(seed=8, file_format="jpg", lamps=18, height=48, width=56, room=0.15, distance=4.0)
    return write(render(made), tmp_path_factory.mktemp("lit") / "photographs")


@pytest.mark.parametrize("crop", [None, (3, 5, 30, 21)])
@pytest.mark.parametrize("calibrate", [("ambient",), ("ambient", "gains", "distance")])
def test_a_stack_of_codes_and_room_light_is_the_one_of_radiance(
    lit: Path, tmp_path: Path, calibrate: tuple[str, ...], crop: tuple[int, int, int, int] | None
) -> None:
    settings = ImportSettings(calibrate=calibrate, crop=crop)
    found = drain(import_stack(find([lit]), settings, tmp_path / "found"))
    expected = drain(import_stack(find([lit]), settings, tmp_path / "expected", as_codes=False))
    assert sorted(path.name for path in (tmp_path / "found").iterdir()) == [CODES, ROOM, RECORD]
    assert sorted(path.name for path in (tmp_path / "expected").iterdir()) == [RADIANCE, SATURATED, RECORD]
    for key in (np.s_[:], np.s_[[2, 0], 4:9], np.s_[1, 2:20:3, 1:], np.s_[2, 7, 3]):
        assert np.array_equal(found.radiance[key], expected.radiance[key])
        assert np.array_equal(found.saturated[key], expected.saturated[key])
    assert (found.quality, found.health, found.provenance) == (expected.quality, expected.health, expected.provenance)
    assert found.mean_radiance.tolist() == expected.mean_radiance.tolist()
    assert np.array_equal(open_stack(tmp_path / "found").radiance[3], found.radiance[3])


@pytest.mark.parametrize("damage", ["missing", "half", "another value", "no checksum", "another checksum", "older"])
def test_damaged_room_light_is_named(lit: Path, tmp_path: Path, damage: str) -> None:
    drain(import_stack(find([lit]), ImportSettings(calibrate=("ambient",)), tmp_path / "stack"))
    room, record = tmp_path / "stack" / ROOM, tmp_path / "stack" / RECORD
    content = room.read_bytes()
    if damage == "missing":
        room.unlink()
    elif damage in ("half", "another value"):
        room.write_bytes(content[:999] if damage == "half" else content[:-1] + bytes([content[-1] ^ 1]))
    else:
        value = json.loads(record.read_text())
        del value["record_sha256"]
        if damage == "older":
            value["lightarc_stack"] = 2
        elif damage == "no checksum":
            del value["codes"]["room_crc32"]
        else:
            value["codes"]["room_crc32"] ^= 1
        record.write_text(json.dumps({**value, "record_sha256": seal(value)}))
    named = RECORD if damage in ("no checksum", "older") else ROOM
    with pytest.raises(InputError, match=named):
        open_stack(tmp_path / "stack")


def test_a_stack_of_an_older_version_opens_as_it_was(tmp_path: Path) -> None:
    """Of radiance, with a record of all that was in one before there were codes."""
    radiance = np.random.default_rng(0).random((2, 4, 5, 3)).astype(np.float32)
    saturated = radiance[..., 0] > 0.9
    checksums = {}
    for name, array in (("radiance", radiance), ("saturated", saturated)):
        np.save(tmp_path / f"{name}.npy", array)
        checksums[f"{name}_crc32"] = zlib.crc32(array.tobytes())
    quality = {"clipped_fraction": 0.0, "black_fraction": 0.0, "noise": 0.1, "sharpness": 0.1}
    record: dict[str, Any] = {
        "lightarc_stack": 1,
        "height_px": 4,
        "width_px": 5,
        "sources": ["a.png", "b.png"],
        "elevations_deg": [20.0, 40.0],
        "azimuths_deg": None,
        "angle_source": "file names",
        "mean_radiance": [0.5, 0.6],
        **checksums,
        "diffuse_crc32": None,
        "quality": [quality, quality],
        "provenance": {"software": "lightarc 0.9"},
        "health": {"figures": {}, "findings": []},
    }
    (tmp_path / RECORD).write_text(json.dumps({**record, "record_sha256": seal(record)}))
    found = open_stack(tmp_path)
    assert np.array_equal(found.radiance[:], radiance)
    assert np.array_equal(found.saturated[:], saturated)
    assert not found.health.findings


@pytest.mark.parametrize("damage", ["missing", "half", "longer", "another kind", "another code"])
def test_damaged_codes_are_named(folder: Path, stack: ImageStack, tmp_path: Path, damage: str) -> None:
    content = folder.with_name("stack").joinpath(CODES).read_bytes()
    other = {
        "half": content[: len(content) // 2],
        "longer": content + b"x",
        "another kind": npy_header(stack.radiance.shape, np.int8) + content[128:],
        "another code": content[:-1] + bytes([content[-1] ^ 1]),
    }
    (tmp_path / RECORD).write_bytes(folder.with_name("stack").joinpath(RECORD).read_bytes())
    if damage != "missing":
        (tmp_path / CODES).write_bytes(other[damage])
    with pytest.raises(InputError, match=CODES):
        open_stack(tmp_path)


def _packed(content: bytes) -> str:
    return base64.b64encode(zlib.compress(content)).decode()


@pytest.mark.parametrize(
    ("part", "value"),
    [
        ("bits", 32), ("bits", 16), ("channels", 1), ("channels", 4), ("photograph_px", [4, 4]), ("corner_px", [1, 0]),
        ("corner_px", [-1, 0]), ("curves", []), ("photographs", []), ("curves.0.tables", "x"), ("curves.0.white", -1),
        ("curves.0.tables", _packed(bytes(1020))), ("curves.0.tables", _packed(bytes(1 << 28))),
        ("curves.0.tables", _packed(np.full(256, np.nan, np.float32).tobytes())),
        ("curves.0.tables", _packed(np.full(256, 1e30, np.float32).tobytes())), ("curves.0.matrix", [1.0] * 8),
        ("curves.0.matrix", [1e30] * 9), ("photographs.1.curve", 1), ("photographs.1.curve", -1),
        ("photographs.1.factors", [1.0, 1.0]), ("photographs.1.factors", [1.0, 0.0, 1.0]), ("photographs.1.gain", 1e20),
        ("photographs.1.found", {"distance": 0.3, "elevation_rad": 1.0, "azimuth_rad": 1.0}),
        ("photographs.1.stated", {"distance": 3.0, "elevation_rad": 1e9, "azimuth_rad": 1.0}),
        ("photographs.1.crc32", -1), ("photographs.1.crc32", 5), ("photographs.1.other", 5),
    ],
)  # fmt: skip
def test_records_of_codes_are_not_believed(
    folder: Path, stack: ImageStack, tmp_path: Path, part: str, value: Any
) -> None:
    record = json.loads(folder.with_name("stack").joinpath(RECORD).read_text())
    del record["record_sha256"]
    at, (*places, last) = record["codes"], part.split(".")
    for place in places:
        at = at[int(place) if place.isdigit() else place]
    at[last] = value
    (tmp_path / RECORD).write_text(json.dumps({**record, "record_sha256": seal(record)}))
    (tmp_path / CODES).write_bytes(folder.with_name("stack").joinpath(CODES).read_bytes())
    with pytest.raises(InputError):
        open_stack(tmp_path)

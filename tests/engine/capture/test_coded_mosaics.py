"""Stacks of mosaics: what is read has the bits of radiance that was written, in whatever parts and from wherever."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

import lightarc
from engine.capture import coded_pixels, import_codes, output
from engine.capture.ahead import WrittenAhead
from engine.capture.coded_pixels import CodedArray
from engine.capture.decoded import Decoded, mark_of
from engine.capture.import_plan import ImportSettings
from engine.capture.import_stack import import_stack
from engine.capture.lights.listed import read_listed
from engine.capture.lights.sources import find
from engine.capture.photograph.bayer import MARGIN, Mosaic, Sensor, find_span, turn_back
from engine.capture.photograph.decode import read_photograph
from engine.capture.registration.framing import Framing
from engine.capture.stack import CODES, RADIANCE, RECORD, ROOM, SATURATED, ImageStack, open_stack
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.images.exif import orient
from engine.storage.records import seal
from engine.storage.scratch import keep_in_memory
from tests.engine.capture.calibration.generated import Capture, render

CORNERS = ((3.0, 2.0), (55.0, 4.0), (52.0, 45.0), (2.0, 41.0))
OPTIONS: dict[str, Any] = {"white_balance": "camera", "transfer": "auto", "bands": ()}


def _write(
    folder: Path, dng: Callable[..., bytes], *, orientation: int = 1, balanced: bool = False, room: float = 0.0
) -> Path:
    """DNG files of a relief under lamps all around and the list of these; each balanced otherwise where `balanced`."""
    made = render(Capture(seed=3, lamps=10, height=57, width=64, gains=(0.5, 1.6), room=room))
    folder.mkdir(parents=True)
    lines = [str(len(made.photographs))]
    for at, (photograph, direction) in enumerate(zip(made.photographs, made.listed, strict=True)):
        lying = turn_back(np.clip(1.5 * photograph, 0.0, 1.0), orientation)
        samples = np.empty(lying.shape[:2])
        for site, colour in enumerate((0, 1, 1, 2)):
            rows, columns = np.s_[site // 2 :: 2], np.s_[site % 2 :: 2]
            samples[rows, columns] = np.rint((60, 64, 66, 70)[site] + 4025 * lying[rows, columns, colour])
        neutral = ((10 + at, 20), (1, 1), (3, 4)) if balanced else ((1, 2), (1, 1), (3, 4))
        content = dng(samples.astype(np.uint16), orientation=orientation, black=(60, 64, 66, 70), neutral=neutral)
        (folder / f"photo_{at}.dng").write_bytes(content)
        lines.append(f"photo_{at}.dng " + " ".join(f"{value:.6f}" for value in direction))
    (folder / "lights.lp").write_text("\n".join(lines) + "\n")
    return folder


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, dng: Callable[..., bytes]) -> Path:
    return _write(tmp_path_factory.mktemp("mosaics") / "raw", dng)


@pytest.fixture(scope="module")
def stack(folder: Path) -> ImageStack:
    return drain(import_stack(find([folder]), ImportSettings(crop=(5, 3, 21, 17)), folder.with_name("stack")))


def _compare(found: ImageStack, expected: ImageStack) -> None:
    """The same radiance, saturation and report, of codes and of radiance, read whole and in parts."""
    assert set(found.pixels) - {ROOM} == {CODES}
    assert set(expected.pixels) == {RADIANCE, SATURATED}
    assert isinstance(found.radiance, CodedArray)
    assert isinstance(found.radiance.decodings[0].curve, Sensor)
    for key in (
        np.s_[:],
        np.s_[1],
        np.s_[[2, 0], 4:9],
        np.s_[:, 2:14:3, 1:],
        np.s_[2, 7, 3],
        np.s_[1, -1],
        np.s_[0, :1],
    ):
        assert np.array_equal(_bits(found.radiance[key]), _bits(expected.radiance[key]))
        assert np.array_equal(found.saturated[key], expected.saturated[key])
    assert found.mean_radiance.tolist() == expected.mean_radiance.tolist()
    assert found.quality == expected.quality
    assert found.health == expected.health
    assert found.provenance == expected.provenance


def _bits(values: NDArray[np.float32]) -> NDArray[np.uint32]:
    return np.ascontiguousarray(values).view(np.uint32)


def _import_both(folder: Path, settings: ImportSettings, target: Path) -> tuple[ImageStack, ImageStack]:
    target.mkdir()
    first = drain(import_stack(find([folder]), settings, target / "codes"))
    return first, drain(import_stack(find([folder]), settings, target / "radiance", as_codes=False))


def test_mosaics_of_a_lit_room_are_the_stack_of_radiance(dng: Callable[..., bytes], tmp_path: Path) -> None:
    folder = _write(tmp_path / "raw", dng, room=0.15)
    settings = ImportSettings(calibrate=("ambient", "gains"), crop=(3, 5, 40, 31))
    found, expected = _import_both(folder, settings, tmp_path / "stacks")
    _compare(found, expected)
    assert json.loads((tmp_path / "stacks" / "codes" / RECORD).read_text())["lightarc_stack"] == 4


@pytest.mark.parametrize("seed", range(24))
def test_parts_of_a_mosaic_have_the_bits_of_the_whole(seed: int) -> None:
    """Of any pattern, levels, orientation, size and part, where samples lie in memory as they come."""
    random = np.random.default_rng(seed)
    pattern = np.array([[[0, 1], [1, 2]], [[1, 0], [2, 1]], [[2, 1], [1, 0]], [[1, 2], [0, 1]]][seed % 4])
    black, white = random.uniform(0.0, 90.0, (2, 2)), random.uniform(900.0, 1000.0, (2, 2))
    matrix = random.uniform(-0.4, 1.4, (3, 3)).astype(np.float32)
    samples = random.integers(0, 880, random.integers(3, 24, 2)).astype(np.uint16)
    samples[tuple(random.integers(0, samples.shape))] = 1023
    orientation = 1 + seed % 8
    plain = Mosaic.turn_upright(samples, Sensor(black, white, pattern, matrix, 1)).linear(0, len(samples))
    expected = [orient(each, orientation) for each in plain]
    mosaic = Mosaic.turn_upright(samples, Sensor(black, white, pattern, matrix, orientation))
    height, width = mosaic.shape
    for _ in range(12):
        (first, last), (left, right) = (np.sort(random.choice(size + 1, 2, replace=False)) for size in (height, width))
        top, bottom = find_span(first, last, height, MARGIN)
        begin, end = find_span(left, right, width, MARGIN)
        radiance = np.empty((last - first, right - left, 3), np.float32)
        saturated, alone = (np.empty(radiance.shape[:2], np.bool_) for _ in range(2))
        part = mosaic.codes[top:bottom][:, begin:end, 0]
        assert isinstance(part, np.ndarray)
        where = (top, begin), mosaic.shape, (first, left)
        mosaic.sensor.develop(part, *where, radiance, saturated)
        mosaic.sensor.find_saturated(part, *where, alone)
        shown = np.s_[first:last, left:right]
        assert np.array_equal(_bits(radiance), _bits(expected[0][shown]))
        assert np.array_equal(saturated, expected[1][shown])
        assert np.array_equal(alone, saturated)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_a_stack_of_mosaics_is_the_one_of_radiance(
    orientation: int, dng: Callable[..., bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As cameras turn their files, whole and cut, written at once and after an estimate of the rig, in small parts and
    by several threads."""
    monkeypatch.setattr(coded_pixels, "_PART_PIXELS", 200)
    monkeypatch.setattr(coded_pixels, "FEW_PIXELS", 400)
    monkeypatch.setattr(output, "BAND_PIXELS", 300)
    folder = _write(tmp_path / "raw", dng, orientation=orientation, balanced=orientation % 2 == 0)
    corner = (orientation - 1, orientation // 2)
    several = {
        "whole": ImportSettings(calibrate="none"),
        "cut": ImportSettings(calibrate="none", crop=(*corner, 20, 25 - orientation), lamp_distance=2.5),
        "estimated": ImportSettings(calibrate=("gains",)),
        "cut and estimated": ImportSettings(calibrate=("gains", "distance"), crop=(*corner, 23, 22)),
    }
    for name in several if orientation in (1, 6) else ("cut", "estimated"):
        found, expected = _import_both(folder, several[name], tmp_path / name)
        _compare(found, expected)
        assert bool(found.saturated[:].any()) or "cut" in name
        assert isinstance(found.radiance, CodedArray)
        assert any(each.gain != 1.0 for each in found.radiance.decodings) == ("estimated" in name)
        count, height, width, _ = found.radiance.shape
        most = 128 + 2 * count * (height + 2 * MARGIN) * (width + 2 * MARGIN)
        assert (tmp_path / name / "codes" / CODES).stat().st_size <= most
        record = json.loads((tmp_path / name / "codes" / RECORD).read_text())
        assert record["lightarc_stack"] == 3
        assert len(record["codes"]["sensors"]) == (len(found.sources) if orientation % 2 == 0 else 1)
        assert open_stack(tmp_path / name / "codes").health == found.health


def test_limited_memory_makes_the_same_stack(folder: Path, tmp_path: Path) -> None:
    """Where decoders make the pixels, since their parent has no room for them."""
    drain(import_stack(find([folder]), ImportSettings(), tmp_path / "expected"))
    with keep_in_memory(0):
        drain(import_stack(find([folder]), ImportSettings(), tmp_path / "found"))
    for name in (CODES, RECORD):
        assert (tmp_path / "found" / name).read_bytes() == (tmp_path / "expected" / name).read_bytes()


@pytest.mark.parametrize("settings", [ImportSettings(calibrate="none"), ImportSettings()])
def test_mosaics_that_were_written_before_the_import_are_taken(
    folder: Path, settings: ImportSettings, tmp_path: Path
) -> None:
    drain(import_stack(find([folder]), settings, tmp_path / "expected"))
    paths, listed = sorted(folder.glob("*.dng")), read_listed([folder / "lights.lp"])
    assert listed is not None
    with (
        closing(Decoded(OPTIONS)) as decoded,
        closing(WrittenAhead(tmp_path / "found", settings, decoded.options)) as ahead,
    ):
        for path in paths:
            mark = mark_of(path)
            assert mark is not None
            kept = decoded.keep(mark, read_photograph(path, **OPTIONS, keep_codes=True))
            assert isinstance(kept.coded, Mosaic)
            plain = {**OPTIONS, "white_balance": "none"}
            assert not np.array_equal(
                read_photograph(path, **OPTIONS).radiance, read_photograph(path, **plain).radiance
            )
        for _ in range(9):
            while ahead._output is not None and ahead._output.is_writing:
                pass
            ahead.write_next(paths, listed)
        drain(import_stack(find([folder]), settings, tmp_path / "found"))
    for name in (CODES, RECORD):
        assert (tmp_path / "found" / name).read_bytes() == (tmp_path / "expected" / name).read_bytes()


def test_grey_codes_and_a_mosaic_are_of_two_kinds(folder: Path, tmp_path: Path) -> None:
    """Both have 16 bits and one channel."""
    place = tmp_path / "mixed"
    place.mkdir()
    for at, path in enumerate(sorted(folder.glob("*.dng"))):
        (place / f"{at}_{20 + 5 * at}deg.dng").write_bytes(path.read_bytes())
    grey = np.round(30000 * read_photograph(place / "0_20deg.dng").radiance.clip(0.0, 1.0).mean(axis=-1))
    cv2.imwrite(str(place / "x_10deg.png"), grey.astype(np.uint16))
    found = drain(import_stack(find([place]), ImportSettings(motion="none"), tmp_path / "stack"))
    assert set(found.pixels) == {RADIANCE, SATURATED}
    assert {name.rsplit(".")[1] for name in found.sources} == {"dng", "png"}


@pytest.mark.parametrize(
    "settings",
    [
        ImportSettings(motion="translation", calibrate=("gains",)),
        ImportSettings(motion="none", calibrate=("gains",), framing=Framing(CORNERS, 40, 30)),
    ],
)
def test_mosaics_that_are_moved_make_a_stack_of_radiance(
    folder: Path, settings: ImportSettings, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The one of pixels, as which they wait where memory is limited."""
    found = [drain(import_stack(find([folder]), settings, tmp_path / "stack"))]
    with keep_in_memory(0):
        found.append(drain(import_stack(find([folder]), settings, tmp_path / "limited")))
    monkeypatch.setattr(import_codes, "waits_as_codes", lambda _: False)
    expected = drain(import_stack(find([folder]), settings, tmp_path / "expected", as_codes=False))
    for each in found:
        assert set(each.pixels) == {RADIANCE, SATURATED}
        assert np.array_equal(_bits(each.radiance[:]), _bits(expected.radiance[:]))
        assert np.array_equal(each.saturated[:], expected.saturated[:])


@pytest.mark.parametrize(
    ("part", "value"),
    [
        ("sensors", []), ("curves", [{"tables": "", "white": 3}]), ("bits", 8), ("channels", 3),
        ("photograph_px", [2, 57]), ("photograph_px", [64, 1 << 30]), ("photograph_px", [27, 57]),
        ("corner_px", [1, 3]), ("corner_px", [0, 0]), ("photographs.1.curve", 1), ("photographs.1.crc32", 5),
        ("sensors.0.demosaic", "ahd"),
        ("sensors.0.black", [60.0] * 3), ("sensors.0.black", [1e300] * 4), ("sensors.0.black", [4095.0] * 4),
        ("sensors.0.white", [60.0, 64.0, 66.0, 70.0]), ("sensors.0.white", [60.0 + 1e-9, 4095.0, 4095.0, 4095.0]),
        ("sensors.0.white", ["x"] * 4), ("sensors.0.colours", [0, 1, 1, 7]), ("sensors.0.colours", [0, 0, 1, 2]),
        ("sensors.0.colours", [0, 1, 2, 1]), ("sensors.0.colours", [0, 1, 1]), ("sensors.0.matrix", [1.0] * 8),
        ("sensors.0.matrix", [1e30] * 9), ("sensors.0.orientation", 0), ("sensors.0.orientation", 9),
        ("sensors.0.other", 1),
    ],
)  # fmt: skip
def test_records_of_mosaics_are_not_believed(
    folder: Path, stack: ImageStack, tmp_path: Path, part: str, value: Any
) -> None:
    assert set(stack.pixels) == {CODES}
    record = json.loads(folder.with_name("stack").joinpath(RECORD).read_text())
    del record["record_sha256"]
    at, (*places, last) = record["codes"], part.split(".")
    for place in places:
        at = at[int(place) if place.isdigit() else place]
    assert at.get(last) != value
    at[last] = value
    (tmp_path / RECORD).write_text(json.dumps({**record, "record_sha256": seal(record)}))
    (tmp_path / CODES).write_bytes(folder.with_name("stack").joinpath(CODES).read_bytes())
    with pytest.raises(InputError):
        open_stack(tmp_path)


@pytest.mark.parametrize("version", [1, 2, 4, 5])
def test_a_record_of_mosaics_has_its_version(folder: Path, stack: ImageStack, tmp_path: Path, version: int) -> None:
    assert set(stack.pixels) == {CODES}
    record = json.loads(folder.with_name("stack").joinpath(RECORD).read_text())
    del record["record_sha256"]
    record["lightarc_stack"] = version
    (tmp_path / RECORD).write_text(json.dumps({**record, "record_sha256": seal(record)}))
    (tmp_path / CODES).write_bytes(folder.with_name("stack").joinpath(CODES).read_bytes())
    with pytest.raises(InputError, match="another version" if version > 4 else "version of the record"):
        open_stack(tmp_path)


def test_what_is_made_of_mosaics_is_what_is_made_of_radiance(folder: Path, tmp_path: Path) -> None:
    """Normals with their viewer, a material and files for another program, byte for byte."""
    both = _import_both(folder, ImportSettings(calibrate="none"), tmp_path / "stacks")
    for place, stack in zip((tmp_path / "0", tmp_path / "1"), both, strict=True):
        place.mkdir()
        alone = replace(stack, folder=None)
        lightarc.recover_normals(alone, place / "normals")
        lightarc.export(lightarc.build_material(alone), place / "exported", to=["gltf", "rti"], stack=alone)
    found, expected = (
        {file.relative_to(place): file.read_bytes() for file in place.rglob("*") if file.is_file()}
        for place in (tmp_path / "0", tmp_path / "1")
    )
    record = Path("normals/surface.json")
    first, second = (json.loads(each.pop(record)) for each in (found, expected))
    assert len(found) > 5
    assert found == expected
    assert {**first, "seconds": 0} == {**second, "seconds": 0}

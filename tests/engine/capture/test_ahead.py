"""Lights that are written before the import: the stack of an import that begins with nothing, bit for bit."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

from engine.capture.ahead import WrittenAhead
from engine.capture.decoded import Decoded, mark_of
from engine.capture.import_plan import ImportSettings
from engine.capture.import_stack import import_stack
from engine.capture.lights.light_file import CalibratedLights, save_lights
from engine.capture.lights.light_positions import Light
from engine.capture.lights.listed import Listed, read_listed
from engine.capture.lights.sources import find
from engine.capture.output import Output
from engine.capture.photograph.decode import read_photograph
from engine.capture.stack import CODES, RECORD, ROOM
from engine.core.steps import drain
from tests.engine.capture.calibration.generated import Capture, render, write

OPTIONS: dict[str, Any] = {"white_balance": "camera", "transfer": "auto", "bands": ()}
KNOWN = ImportSettings(calibrate="none")


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = Capture(seed=5, file_format="jpg", lamps=6, height=40, width=48)
    return write(render(made), tmp_path_factory.mktemp("ahead") / "plain")


@pytest.fixture(scope="module")
def calibrated(plain: Path) -> Path:
    """The same under lamps whose distance and intensities a file states."""
    folder = shutil.copytree(plain, plain.with_name("calibrated"))
    lights = find([folder])
    assert lights.azimuth is not None
    lamps = zip(lights.photographs, lights.elevation.tolist(), lights.azimuth.tolist(), strict=True)
    stated = tuple(Light(path.name, high, around, at + 1) for at, (path, high, around) in enumerate(lamps))
    (folder / "lights.lp").unlink()
    save_lights(folder / "rig.lights", CalibratedLights(stated, (0.8, 1.1, 1.0, 0.9, 1.3, 1.0), 3.5, {}))
    return folder


@pytest.fixture
def ahead(tmp_path: Path) -> Iterator[tuple[Decoded, WrittenAhead]]:
    with ExitStack() as held:
        decoded = held.enter_context(closing(Decoded(OPTIONS)))
        yield decoded, held.enter_context(closing(WrittenAhead(tmp_path / "stack", KNOWN, decoded.options)))


def _decode(decoded: Decoded, folder: Path) -> tuple[list[Path], Listed]:
    paths = sorted(folder.glob("*.jpg"))
    for path in paths:
        mark = mark_of(path)
        assert mark is not None
        decoded.keep(mark, read_photograph(path, **OPTIONS, keep_codes=True))
    listed = read_listed([path for path in folder.iterdir() if path.suffix in (".lp", ".lights")])
    assert listed is not None
    return paths, listed


def _write(ahead: WrittenAhead, paths: list[Path], listed: Listed, times: int) -> None:
    for _ in range(times):
        while (output := ahead._output) is not None and output.is_writing:
            pass
        ahead.write_next(paths, listed)


def _import(folder: Path, target: Path, settings: ImportSettings = KNOWN) -> tuple[bytes, dict[str, Any]]:
    drain(import_stack(find([folder]), settings, target))
    return (target / CODES).read_bytes(), json.loads((target / RECORD).read_text())


@pytest.fixture
def places(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The places of the lights that have been written."""
    found: list[int] = []
    write = Output.write_codes

    def note(self: Output, index: int, *more: Any) -> Any:
        found.append(index)
        return write(self, index, *more)

    monkeypatch.setattr(Output, "write_codes", note)
    return found


@pytest.mark.parametrize("kind", ["plain", "calibrated"])
def test_an_import_takes_what_lies_at_its_place_and_gives_the_same_bits(
    kind: str,
    ahead: tuple[Decoded, WrittenAhead],
    places: list[int],
    tmp_path: Path,
    request: pytest.FixtureRequest,
) -> None:
    """All but one photograph, which come in any order, are written as they come, and the import writes that one."""
    folder: Path = request.getfixturevalue(kind)
    expected = _import(folder, tmp_path / "expected")
    assert places == list(range(6))
    places.clear()
    paths, listed = _decode(ahead[0], folder)
    _write(ahead[1], paths[::-1][:5], listed, times=7)
    before = sorted(places)
    assert len(before) == 5
    assert _import(folder, tmp_path / "stack") == expected
    assert places[5:] == [place for place in range(6) if place not in before]
    ahead[1].close()
    assert not list(tmp_path.glob(".*"))


def test_what_was_written_for_another_import_is_written_again(
    ahead: tuple[Decoded, WrittenAhead], plain: Path, calibrated: Path, places: list[int], tmp_path: Path
) -> None:
    """Lights of which the list has changed, and those of another part of the photographs."""
    paths, _ = _decode(ahead[0], plain)
    listed = read_listed([calibrated / "rig.lights"])
    assert listed is not None
    _write(ahead[1], paths, listed, times=6)
    places.clear()
    found = _import(plain, tmp_path / "stack")
    assert places == list(range(6))
    assert found == _import(plain, tmp_path / "expected")
    with closing(WrittenAhead(tmp_path / "cut", KNOWN, ahead[0].options)) as whole:
        _write(whole, paths, listed, times=6)
        cut = ImportSettings(calibrate="none", crop=(3, 4, 20, 10))
        assert whole.hand_over(cut, tmp_path) is None
        assert list(tmp_path.glob(".cut*"))
    assert not list(tmp_path.glob(".cut*"))


def test_a_disk_that_is_full_leaves_all_to_the_import(
    ahead: tuple[Decoded, WrittenAhead], plain: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    paths, listed = _decode(ahead[0], plain)
    expected = _import(plain, tmp_path / "expected")

    def fail(operation: str, path: Path) -> int | None:
        if operation == "write" and ".stack" in str(path):
            raise OSError(28, "")
        return None

    with monkeypatch.context() as patch:
        patch.setattr("engine.storage.atomic.fault", fail)
        _write(ahead[1], paths, listed, times=3)
    assert _import(plain, tmp_path / "stack") == expected
    ahead[1].close()
    assert not list(tmp_path.glob(".*"))


def test_what_is_found_of_all_photographs_changes_no_codes_unless_it_moves_them(
    ahead: tuple[Decoded, WrittenAhead], plain: Path, places: list[int], tmp_path: Path
) -> None:
    expected = _import(plain, tmp_path / "expected", ImportSettings())
    paths, listed = _decode(ahead[0], plain)
    places.clear()
    moved = ImportSettings(motion="translation", calibrate="none")
    for settings in (moved, ImportSettings(crop=(3, 4, 20, 10))):
        with closing(WrittenAhead(tmp_path / "other", settings, ahead[0].options)) as other:
            _write(other, paths, listed, times=2)
    assert places == []
    with closing(WrittenAhead(tmp_path / "found", ImportSettings(), ahead[0].options)) as other:
        _write(other, paths, listed, times=6)
        assert _import(plain, tmp_path / "found", ImportSettings()) == expected
    assert sorted(places) == list(range(6))


def test_room_light_that_is_found_changes_no_codes(
    ahead: tuple[Decoded, WrittenAhead], places: list[int], tmp_path: Path
) -> None:
    made = Capture(seed=8, file_format="jpg", lamps=18, height=48, width=56, room=0.15, distance=4.0)
    folder = write(render(made), tmp_path / "lit")
    expected = _import(folder, tmp_path / "expected", ImportSettings())
    paths, listed = _decode(ahead[0], folder)
    places.clear()
    with closing(WrittenAhead(tmp_path / "found", ImportSettings(), ahead[0].options)) as written:
        _write(written, paths, listed, times=18)
        assert _import(folder, tmp_path / "found", ImportSettings()) == expected
    assert sorted(places) == list(range(18))
    assert (tmp_path / "found" / ROOM).read_bytes() == (tmp_path / "expected" / ROOM).read_bytes()

"""`lightarc watch` as a user meets it; photographs that come late: `tests/engine/capture/test_arriving.py`."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from app.project.project_file import read
from engine.capture.stack import CODES, RECORD
from engine.simulate.camera import Levels, dng_bytes
from tests.app.command import Command, result

LEVELS = Levels(black=((64, 64), (64, 64)), white=4095)


@pytest.fixture(scope="module")
def photographs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("photographs")
    grain = cv2.GaussianBlur(np.random.default_rng(0).normal(size=(40, 48)), (0, 0), 2.0) / 0.14
    for number, level in enumerate((20, 60, 90, 110)):
        codes = np.clip(level * (1.0 + 0.2 * grain), 0, 255).astype(np.uint8)
        cv2.imwrite(str(folder / f"IMG_{number:04}.png"), codes)
    (folder / "notes.txt").write_text("not a photograph")
    return folder


def test_what_is_watched_is_what_is_imported(lightarc: Command, photographs: Path, tmp_path: Path) -> None:
    choices = ("--angles-deg", "10,30,50,70", "--no-align")
    found = result(lightarc("watch", photographs, "-o", tmp_path / "stack", "--json", *choices))
    assert (found["expected"], found["stopped"], found["coverage"]) == (4, False, None)
    assert sorted(one["name"] for one in found["photographs"]) == [f"IMG_{number:04}.png" for number in range(4)]
    assert {one["name"]: one["elevation_deg"] for one in found["photographs"]}["IMG_0002.png"] == 50.0
    assert found["seconds_after_last"] < found["time_s"]
    assert lightarc("import", photographs, "-o", tmp_path / "again", *choices).code == 0
    for name in (CODES, RECORD):
        assert (tmp_path / "stack" / name).read_bytes() == (tmp_path / "again" / name).read_bytes()


def test_raw_photographs_that_are_watched_are_what_is_imported(lightarc: Command, tmp_path: Path) -> None:
    """With a list of their lights."""
    folder, random = tmp_path / "raw", np.random.default_rng(1)
    folder.mkdir()
    lines = ["6"]
    for number in range(6):
        samples = random.integers(200 + 300 * number, 900 + 400 * number, (34, 46), np.uint16)
        (folder / f"IMG_{number}.dng").write_bytes(dng_bytes(samples, LEVELS, exposure_s=0.01))
        lines.append(f"IMG_{number}.dng {np.cos(number):.6f} {np.sin(number):.6f} {0.4 + 0.3 * number:.6f}")
    (folder / "lights.lp").write_text("\n".join(lines))
    assert lightarc("watch", folder, "-o", tmp_path / "stack", "--calibrate", "none").code == 0
    assert lightarc("import", folder, "-o", tmp_path / "again", "--calibrate", "none").code == 0
    for name in (CODES, RECORD):
        assert (tmp_path / "stack" / name).read_bytes() == (tmp_path / "again" / name).read_bytes()


def test_a_project_keeps_the_choices_and_the_material(lightarc: Command, photographs: Path, tmp_path: Path) -> None:
    words = ("watch", photographs, "-o", tmp_path / "cloth.lap", "--until-idle", "0.2", "--expect", "9")
    done = lightarc(*words, "--trust-angles", "--no-align", "--transfer", "linear")
    assert done.code == 0, done.err
    assert "4 of 9 photographs came" in done.out
    assert "3 of 9  IMG_0002.png  good" in done.err
    project = read(tmp_path / "cloth.lap").current
    assert project.stack is not None
    assert project.has_map
    assert (project.import_choices.motion, project.import_choices.transfer) == ("none", "linear")
    assert project.import_choices.trust_angles


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--lights", "1-3"), "a project does not keep this choice of an import: lights"),
        (("--until-idle", "-1"), "outside 0.1 s"),
        (("--expect", "1"), "not a number of photographs from 2"),
    ],
)
def test_wishes_that_cannot_be_are_refused(
    lightarc: Command, photographs: Path, tmp_path: Path, words: tuple[str, ...], said: str
) -> None:
    done = lightarc("watch", photographs, "-o", tmp_path / "a.lap", *words)
    assert done.code == 2
    assert said in done.err


def test_a_folder_that_is_none_is_refused(lightarc: Command, tmp_path: Path) -> None:
    done = lightarc("watch", tmp_path / "nowhere", "-o", tmp_path / "a.lap")
    assert done.code == 3
    assert "is not a folder" in done.err

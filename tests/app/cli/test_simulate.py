"""`lightarc simulate` as a user or a script meets it."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from app.cli import simulate


def test_json_names_what_was_made(lightarc: Callable[..., SimpleNamespace], tmp_path: Path) -> None:
    done = lightarc("simulate", "-o", tmp_path / "c", "--size", 32, "--elevations-deg", "20,90", "--json")
    assert done.code == 0
    result = json.loads(done.out)
    assert result["images"] == 2
    assert result["elevations_deg"] == [20.0, 90.0]
    assert result["shifts_px"][0] == [0.0, 0.0]
    assert sorted(path.name for path in (tmp_path / "c").iterdir()) == [
        "capture.toml",
        "truth",
        "woven_20.tif",
        "woven_90.tif",
    ]


def test_a_dome_is_asked_for_by_two_numbers(lightarc: Callable[..., SimpleNamespace], tmp_path: Path) -> None:
    done = lightarc("simulate", "-o", tmp_path / "c", "--size", 32, "--azimuths", 4, "--elevations", 3, "--json")
    assert done.code == 0
    result = json.loads(done.out)
    lamps = set(zip(result["elevations_deg"], result["azimuths_deg"], strict=True))
    assert lamps == {(elevation, azimuth) for elevation in (15, 45, 75) for azimuth in (0, 90, 180, 270)}


@pytest.mark.parametrize(
    "words",
    [
        ["--azimuths", "0"],
        ["--azimuths", "4", "--azimuths-deg", "0,90"],
        ["--elevations", "-3"],
        ["--elevations-deg", "20,x"],
        ["--elevations-deg", "120"],
        ["--elevations-deg", "nan"],
        ["--size", "0"],
        ["--noise", "nan"],
        ["--sample", "velvet"],
        ["--misalignment-px", "-1"],
        ["--seed", "-1"],
    ],
)
def test_wrong_usage_writes_nothing(lightarc: Callable[..., SimpleNamespace], tmp_path: Path, words: Any) -> None:
    done = lightarc("simulate", "-o", tmp_path / "c", *words)
    assert done.code == 2
    assert done.err
    assert "Traceback" not in done.err
    assert not list(tmp_path.iterdir())


def test_folder_of_somebody_else_is_left_alone(lightarc: Callable[..., SimpleNamespace], tmp_path: Path) -> None:
    (tmp_path / "holiday.jpg").write_bytes(b"precious")
    done = lightarc("simulate", "-o", tmp_path, "--size", 32, "--elevations-deg", 90, "--json")
    assert done.code == 3
    assert done.out == ""
    assert str(tmp_path) in done.err
    assert [path.name for path in tmp_path.iterdir()] == ["holiday.jpg"]


def test_missing_parent_folder_is_named(lightarc: Callable[..., SimpleNamespace], tmp_path: Path) -> None:
    done = lightarc("simulate", "-o", tmp_path / "no" / "such", "--size", 32, "--elevations-deg", 90)
    assert done.code in (0, 3)
    assert "Traceback" not in done.err


def test_the_verb_offers_what_the_engine_has() -> None:
    from engine.simulate.arc import ELEVATIONS_DEG, FORMATS, LightArc
    from engine.simulate.height_fields import SAMPLES

    parser = argparse.ArgumentParser()
    simulate.add_arguments(parser)
    choices = {action.dest: action.choices for action in parser._actions}
    assert choices["sample"] == tuple(SAMPLES)
    assert choices["format"] == tuple(FORMATS)
    defaults = parser.parse_args(["-o", "x"])
    assert defaults.elevations_deg == ELEVATIONS_DEG
    arc = LightArc()
    assert (defaults.size, defaults.noise, defaults.misalignment_px) == (arc.size, arc.noise, arc.misalignment_px)
    assert (defaults.sample, defaults.format, defaults.seed) == (arc.sample, arc.format, arc.seed)

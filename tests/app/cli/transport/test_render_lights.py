"""Lamps and a ground on the command line of `lightarc render`."""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path
from typing import Any, cast

import numpy as np
import OpenEXR
import pytest

from app import command_line
from app.cli.transport.render import add_arguments
from engine.geometry.shapes import SHAPES
from engine.light.sky import SKIES
from tests.app.command import replace_options

SMALL = ("--width", "64", "--height", "48", "--renderer", "cpu", "--samples", "1")
HEAD_ON = ("--camera", "eye=0,0,2 fov_deg=20", "--brdf", "lambert:albedo=0.5")


def render(capsys: pytest.CaptureFixture[str], *words: object, code: int = 0) -> Any:
    """Run the verb; its JSON object, or what it says on standard error."""
    try:
        ended = command_line.main(["render", *map(str, words), "--json"])
    except SystemExit as exit_of_the_parser:
        ended = cast(Any, exit_of_the_parser.code)
    assert ended == code
    said = capsys.readouterr()
    return said.err if code else json.loads(said.out)


@pytest.fixture(autouse=True)
def only_this_verb(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command_line, "VERBS", (("render", "app.cli.transport.render", ""),))


def centre(path: Path) -> np.ndarray:
    return np.asarray(OpenEXR.File(str(path)).channels()["RGB"].pixels, np.float64)[24, 32]


def test_a_lamp_gives_the_irradiance_it_was_given(capsys: Any, tmp_path: Path) -> None:
    path = tmp_path / "plane.exr"
    lamp = "theta_deg=90,phi_deg=0,irradiance=2,radius_deg=5,colour=1:0.8:0.6"
    result = render(capsys, "plane", "-o", path, *HEAD_ON, *SMALL, "--lamp", lamp)
    assert result["directional_lights"] == 35
    assert "light_direction" not in result  # only the lamp shines
    assert result["lamps"][0]["theta_deg"] == pytest.approx(90.0)
    assert result["lamps"][0]["irradiance"] == pytest.approx([2.0, 1.6, 1.2])
    np.testing.assert_allclose(centre(path), 0.5 / math.pi * np.array([2.0, 1.6, 1.2]), rtol=1e-3)


def test_lamps_stand_beside_a_light_that_was_asked_for(capsys: Any, tmp_path: Path) -> None:
    path = tmp_path / "plane.exr"
    lamps = ("--lamp", "theta_deg=90,phi_deg=0", "--lamp", "theta_deg=90,phi_deg=60,irradiance=4")
    result = render(capsys, "plane", "-o", path, *HEAD_ON, *SMALL, *lamps, "--light-deg", "90,0", "--intensity", 3)
    assert result["directional_lights"] == 3
    np.testing.assert_allclose(centre(path), 0.5 / math.pi * (3.0 + 1.0 + 2.0), rtol=1e-3)


def test_lamps_stand_beside_an_environment_and_its_error_is_measured(capsys: Any, tmp_path: Path) -> None:
    words = ("sphere", *SMALL, "--brdf", "lambert", "--env", "studio", "--directions", 8, "--measure-error", "-o")
    alone = render(capsys, *words, tmp_path / "a.exr")
    lit = render(capsys, *words, tmp_path / "b.exr", "--lamp", "theta_deg=60,phi_deg=10,irradiance=20")
    assert lit["environment"] == "studio"
    assert lit["directional_lights"] == 9
    assert 0.0 < lit["error_rmse_rel"] < 0.5 * alone["error_rmse_rel"]  # a lamp costs no error, and most light is its


@pytest.mark.parametrize(("words", "albedo"), [(("--ground",), 0.5), (("--ground=0.2",), 0.2)])
def test_a_ground_is_reported(capsys: Any, tmp_path: Path, words: tuple[str, ...], albedo: float) -> None:
    result = render(capsys, "sphere", "-o", tmp_path / "a.png", *SMALL, *words)
    assert result["ground_albedo"] == albedo


@pytest.mark.parametrize("words", [("--renderer", "cpu"), ("--mode", "reference", "--samples", "4")])
@pytest.mark.parametrize("ending", ["exr", "png"])
def test_light_beyond_what_a_image_holds_is_cut_and_stays_finite(
    capsys: Any, tmp_path: Path, words: tuple[str, ...], ending: str
) -> None:
    result = render(
        capsys, "sphere", "-o", tmp_path / f"a.{ending}", *replace_options(SMALL, words), "--intensity", "1e40", *words
    )
    assert 1e37 < result["mean_radiance"] <= np.finfo(np.float32).max


def test_the_error_of_a_reference_is_cut_like_its_light(capsys: Any, tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    words = ("--mode", "reference", "--samples", "2", "--env", "studio", "--intensity", "1e40")
    render(capsys, "sphere", "-o", path, *replace_options(SMALL, words), *words)
    file = OpenEXR.File(str(path))
    error = [channel.pixels for name, channel in file.channels().items() if name.startswith("standard_error")]
    assert len(error) > 0
    assert all(np.isfinite(pixels).all() for pixels in error)
    assert max(pixels.max() for pixels in error) > 1e37


@pytest.mark.parametrize("renderer", ["cpu", "gl"])
def test_a_model_is_lost_from_sight_a_world_away(capsys: Any, tmp_path: Path, renderer: str) -> None:
    drawn_by = ("--renderer", renderer)
    words = ("sphere", "-o", tmp_path / "a.png", *replace_options(SMALL, drawn_by), *drawn_by)
    assert render(capsys, *words, "--camera", "eye=1e90,0,0")["covered_fraction"] < 0.01
    assert "beyond" in render(capsys, *words, "--camera", "eye=1e300,0,0", code=2)


def test_help_names_every_built_in_environment_and_model(capsys: Any) -> None:
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    said = " ".join(parser.format_help().replace("-\n", "-").split())
    assert "one of " + ", ".join(SKIES) in said.replace("- ", "-")
    assert "a built-in (" + ", ".join(SHAPES) + ")" in said.replace("- ", "-")


@pytest.mark.parametrize(
    "words",
    [
        ("--lamp", "theta_deg=200"),
        ("--lamp", "power=3"),
        ("--lamp", "irradiance=-1"),
        ("--lamp", "irradiance=nan"),
        ("--lamp", "radius_deg=120"),
        ("--lamp", "colour=1:2"),
        ("--lamp", "40,20"),
        ("--lamp",),
        ("--ground=2",),
        ("--ground=nan",),
        ("--ground=sand",),
        tuple(["--lamp", "theta_deg=1"] * 65),
    ],
)
def test_impossible_lights_are_usage_errors(capsys: Any, tmp_path: Path, words: tuple[str, ...]) -> None:
    said = render(capsys, "plane", "-o", tmp_path / "x.png", *words, code=2)
    assert "Traceback" not in said
    assert len(said.strip()) > 20
    assert not list(tmp_path.iterdir())

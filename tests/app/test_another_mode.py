"""A mode that is not part of the package: on the command line, in the API, the window, a project and a sweep."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lightarc
from app.document.document import Look, Project
from app.document.modes import mode_named, modes, scene_of, why_not
from app.project.project_file import History, Writer, read
from app.window.main_window import MainWindow
from engine.planning.costs.setting import parameters_of
from engine.scene.mode import MODES, REFERENCE, Mode, register, unregister
from tests.clay import CLAY

TESTS = Path(__file__).resolve().parents[1]


@pytest.fixture
def clay() -> Iterator[Mode]:
    yield register(CLAY)
    unregister(CLAY)


def test_an_installed_package_adds_a_mode_to_the_command_line(tmp_path: Path) -> None:
    """A distribution of its own, which declares the mode by an entry point."""
    shutil.copy(TESTS / "clay.py", tmp_path / "moon_clay.py")
    info = tmp_path / "moon-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: moon\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[lightarc.modes]\nclay = moon_clay:CLAY\n")
    command = "import sys; sys.path.insert(0, sys.argv.pop(1)); from app.__main__ import main; sys.exit(main())"
    means = []
    for brdf in ("lambert:albedo=0.5", "phong:kd=0.1,ks=0.1"):
        words = [tmp_path, "render", "plane", "--brdf", brdf, "--mode", "clay", "--width", "8", "--height", "6"]
        words += ["--light-deg", "40,20", "--renderer", "cpu", "-o", tmp_path / "out.exr", "--json"]
        done = subprocess.run(
            [sys.executable, "-c", command, *map(str, words)], capture_output=True, text=True, cwd=TESTS.parent
        )
        assert done.returncode == 0, done.stderr
        means.append(json.loads(done.stdout)["mean_radiance"])
    assert means[0] == pytest.approx(means[1])


def test_the_api_draws_and_measures_it(clay: Mode) -> None:
    words: Any = {"light_deg": (40, 20), "size": (8, 6)}
    drawn = lightarc.render("plane", brdf="phong:kd=0.1,ks=0.1", mode="clay", **words)
    assert np.allclose(drawn, lightarc.render("plane", brdf="lambert:albedo=0.5", **words))
    with pytest.raises(lightarc.UsageError, match="choose from shading-map, direct, reference, clay"):
        lightarc.render("plane", mode="mud")
    with pytest.raises(lightarc.UsageError, match="needs a material"):
        lightarc.render("plane", mode="shading-map")
    found = lightarc.tradeoff("plane", "phong:kd=0.1,ks=0.1", "sky", modes=["clay"], seconds=1, size=(8, 6))
    assert {point.mode for point in found.points} == {"clay"}
    assert list(parameters_of("clay")) == ["directions"]


def test_the_window_has_a_button_and_a_key_for_it(clay: Mode, window: MainWindow) -> None:
    assert "clay" in window.view.mode.buttons
    (action,) = (action for action in window.view.actions() if action.shortcut().toString() == "Y")
    action.trigger()
    assert window.bench.document.project.look.mode == "clay"
    scene = lightarc.make_scene("plane", brdf="phong:kd=0.1,ks=0.1")
    assert scene_of(mode_named("clay"), scene).brdf == lightarc.Lambert((0.5, 0.5, 0.5))


def test_a_project_keeps_it_and_shows_another_where_it_is_missing(tmp_path: Path) -> None:
    register(CLAY)
    project = replace(Project(), look=Look(mode="clay"))
    writer = Writer(tmp_path / "moon.lap")
    writer.write(History(project, (), 0))
    writer.close()
    assert read(tmp_path / "moon.lap").current.look.mode == "clay"
    assert not why_not(mode_named("clay"), project)
    unregister(CLAY)
    assert read(tmp_path / "moon.lap").current.look.mode == "clay"
    assert "clay" not in {mode.value for mode in modes()}


@pytest.mark.parametrize(
    ("mode", "words"),
    [
        (replace(CLAY, name="direct"), "another mode direct"),
        (replace(CLAY, name="Two words"), "lower-case words"),
        (replace(CLAY, hint=""), "a title, a label and a hint"),
        (replace(CLAY, key="M"), "key M"),
        (replace(REFERENCE, name="other"), "reference alone"),
    ],
)
def test_what_lacks_a_part_is_refused(mode: Mode, words: str) -> None:
    before = dict(MODES)
    with pytest.raises(ValueError, match=words):
        register(mode)
    assert before == MODES

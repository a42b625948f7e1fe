"""The health of every verb: one name for it in JSON, `warnings`, and at the end of the text a line about it.

`app.command_line` builds the line of every result before it prints either, so that a verb without `warnings` fails in
each of its own tests too. Here all verbs are run once, on the small inputs of `test_extremes`.
"""

from __future__ import annotations

import json
import math
import time
from argparse import Namespace
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app import command_line
from app.arguments.usage import DONE
from app.document.document import Project
from app.project.project_file import History, Writer
from engine.brdf.ranking import rank
from engine.figures import demo as demos
from engine.geometry.shapes import shape
from engine.images.encode import encode_png, write_exr
from engine.planning.costs.cost_model import machine_name, save
from engine.simulate.arc import LightArc
from engine.tradeoff.point import COSTS
from tests.app.scenarios import SCENARIOS, photograph
from tests.app.test_extremes import BAKED, LINES, TINY_BAKE
from tests.engine.planning.conftest import every_rate

#: Verbs and actions that `LINES` of the extremes lack or are refused in, and the ways of a verb that state their health
#: on their own.
REFUSED = ("normals", "tradeoff", "export", "brdf info")
MORE = (
    "normals {inputs}/dome.stack -o {folder}/maps --no-errors",
    "tradeoff plane --brdf lambert --env {inputs}/sky.exr --modes direct --budget-s 1 --width 16 --height 16 "
    "-o {folder}/sweep",
    "export {inputs}/a.lightarc --to brdf -o {folder}/exported",
    "demo -o {folder}/demo",
    "brdf list",
    "brdf fit ggx --rank --samples 60",
    "brdf info {inputs}/clamped.csv",
    "brdf eval {inputs}/clamped.csv --wi-deg 10,20 --wo-deg 30,40",
    "brdf convert lambert -o {folder}/a.exr",
    "render {inputs}/mesh.obj -o {folder}/a.webp --width 8 --height 6 --samples 1 --turntable 2 --renderer cpu",
    f"{BAKED.replace('a.png', 'b.webp')} --turntable 2 --renderer cpu",
    "shade {inputs}/dome.stack --compare -o {folder}/compared",
    "batch {inputs}/dome -o {folder}/batch --to none --workers 1",
    "project info {inputs}/a.lap",
    "project verify {inputs}/a.lap",
    "project collect {inputs}/a.lap -o {folder}/b.lap",
    "bundle verify {inputs}/a.lightarc",
    "bundle show {inputs}/a.lightarc",
    "bundle extract {inputs}/a.lightarc -o {folder}/taken-apart",
    "bundle view {inputs}/a.lightarc",
    "figures wang-2 --mesh plane --quick -o {folder}/figures",
    "bench --only linearise",
    "selftest --only H1",
)


def on_plane(line: str) -> str:
    """`line` with a built-in model, which takes no process that reads a file."""
    return line.replace("{inputs}/mesh.obj", "plane")


RUN = (*(on_plane(lines[0]) for verb, lines in LINES.items() if verb not in REFUSED), *MORE)

pytestmark = pytest.mark.usefixtures("coarse")


@pytest.fixture(autouse=True)
def kept_costs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Costs that are known already, so that nothing is measured."""
    path = tmp_path / "cost-model.json"
    save(replace(every_rate(), machine=machine_name(), measured_at_s=time.time()), path)
    monkeypatch.setattr("app.session.machine_profile.cost_path", lambda: path)


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Files that the command lines read: a tiny capture with all that comes of it, and a project."""
    folder = tmp_path_factory.mktemp("health") / "inputs"
    photograph(folder)
    lines = [
        SCENARIOS["shade"].line(folder, folder),
        f"{on_plane(TINY_BAKE)} --mode sh --order 3".split(),
        [
            "simulate",
            "-o",
            "{folder}/dome",
            "--size",
            "24",
            "--azimuths",
            "3",
            "--elevations",
            "2",
            "--misalignment-px",
            "0",
        ],
        ["import", "{folder}/dome", "-o", "{folder}/dome.stack", "--no-align"],
    ]
    for line in lines:
        words = [word.format(inputs=folder, folder=folder) for word in line]
        assert command_line.main(words) == DONE
    (folder / "a.transport").rename(folder / "baked.transport")
    for name in ("a.png", "b.png"):
        (folder / name).write_bytes(encode_png(np.full((6, 8, 3), ord(name[0]), np.uint8)))
    write_exr(folder / "sky.exr", dict.fromkeys("RGB", np.ones((8, 16), np.float32)), half=False)
    rows = ["theta_i,phi_i,theta_o,phi_o,r,g,b"]
    rows += [f"{i},0,{o},{a},0.1,{-0.1 if i == 20 else 0.1},0.1" for i in (0, 20, 40) for o in (0, 30) for a in (0, 90)]
    (folder / "clamped.csv").write_text("\n".join(rows))
    writer = Writer(folder / "a.lap")
    writer.write(History(Project(mesh=shape("plane"), name="Felt"), (), 0))
    writer.close()
    return folder


def verb_of(line: str) -> str:
    return line.split(maxsplit=1)[0]


def test_every_verb_is_run() -> None:
    measures_nothing = {"gui", "completion", "desktop-install"}
    assert {verb_of(line) for line in RUN} == {verb for verb, _, _ in command_line.VERBS} - measures_nothing


@pytest.mark.parametrize("line", RUN)
def test_health_is_said_and_stands_in_json(
    line: str, inputs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    arc = LightArc(size=48, elevation=tuple(math.radians(angle) for angle in (20, 50, 90)))
    monkeypatch.setattr("app.batch.run.MAKE", "tests.app.batch.fast:make")
    monkeypatch.setattr(demos, "LightArc", lambda: arc)
    monkeypatch.setattr(demos, "IMAGE_SIZE", (32, 20))
    monkeypatch.setattr("benchmarks.shading.SIDE", 16)
    monkeypatch.setattr("engine.tradeoff.write.COSTS", {"frame": COSTS["frame"]})
    monkeypatch.setattr("engine.brdf.ranking.rank", lambda data, models, **options: rank(data, models[:2], **options))
    monkeypatch.setattr("engine.exchange.loss.DIAMETER", 16)
    monkeypatch.setattr("engine.exchange.loss.LIGHTS", 4)
    monkeypatch.setattr("engine.exchange.loss.ENVIRONMENTS", ("overcast",))
    monkeypatch.setattr("webbrowser.open", lambda _page: True)
    shown = command_line._print

    def both(options: Namespace, result: Any, *more: Any) -> None:
        shown(options, result, *more)
        print("\f", end="")
        options.json = True
        shown(options, result, *more)

    monkeypatch.setattr(command_line, "_print", both)
    code = command_line.main(line.format(inputs=inputs, folder=tmp_path).split())
    printed = capsys.readouterr()
    assert code == DONE, printed.err
    text, record = printed.out.split("\f")
    warnings = json.loads(record)["warnings"]
    assert all(isinstance(warning, str) and warning for warning in warnings)
    assert text.endswith(f"{command_line.health_text(warnings)}\n")
    assert text.count("Health: ") == 1


def test_what_is_doubtful_reaches_the_verbs_that_use_it(
    inputs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Values below 0 of a measured BRDF, and a light with texels that are no numbers."""
    light = np.ones((8, 16), np.float32)
    light[2, 3] = np.nan
    write_exr(tmp_path / "night.exr", dict.fromkeys("RGB", light), half=False)
    scene = ["--brdf", str(inputs / "clamped.csv"), "--env", str(tmp_path / "night.exr")]
    lines = (
        ["render", "plane", *scene, "--renderer", "cpu", "-o", str(tmp_path / "a.png"), "--width", "8"],
        ["plan", "plane", *scene, "--width", "8", "--height", "8"],
    )
    for line in lines:
        assert command_line.main([*line, "--json"]) == DONE
        warnings = json.loads(capsys.readouterr().out)["warnings"]
        assert any("night" in each for each in warnings), warnings
        assert any("4 of 12 measurements are not used (4 negative)" in each for each in warnings), warnings

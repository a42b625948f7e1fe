"""A further transport method is one entry in the list of methods: nothing else of the product has to know it."""

from __future__ import annotations

import ast
import dataclasses
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.cli.transport.tradeoff import MAX_S
from app.window.main_window import MainWindow
from engine.core.steps import Step, Steps
from engine.light.environment_file import open_environment
from engine.planning.costs.cost_model import NAMES, CostModel
from engine.transport import method as transport
from tests import ambient_occlusion
from tests.ambient_occlusion import METHOD, NAME
from tests.app.command import Command, result
from tests.app.view.test_baking import LONG, sphere

pytestmark = pytest.mark.usefixtures("coarse")

PROJECT = Path(__file__).resolve().parents[2]

#: Files of one method: its stem, in whatever folder of the engine.
OWN = re.compile(r"engine/.*/(sh|wavelet|gaussian)(_\w+)?\.py$")

#: Files that know the harmonics of other programs' files, which are called "sh" there too.
FOREIGN = ("engine/exchange/readers/rti.py", "engine/shading/directional/interpolation.py")

TYPE_TESTS = ("isinstance", "issubclass")


@pytest.fixture(autouse=True)
def _listed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The methods of the product and ambient occlusion; what this machine costs is made up."""

    def costs(*, anew: bool = False) -> Steps[CostModel]:
        del anew
        yield Step(1.0, "the costs of this machine are made up")
        return CostModel("test", "test", dict.fromkeys(NAMES, ((1.0, 1e-9),)))

    monkeypatch.setattr(transport, "METHODS", (*transport.METHODS, METHOD))
    monkeypatch.setattr("app.session.machine_profile.cost_model", costs)


def test_it_is_baked_and_drawn_by_the_command_line(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    output, image = tmp_path / "a.transport", tmp_path / "a.exr"
    words = ("bake", mesh, "--brdf", "lambert:albedo=0.5", "-o", output)
    made = result(lightarc(*words, "--mode", NAME, "--rays", "16", "--json"))
    assert made["knobs"] == {"mode": NAME, "brdf": "lambert:albedo=0.5", "ground_albedo": None, "rays": 16}
    assert made["open_mean"] == pytest.approx(0.5, abs=0.1), "a tetrahedron shades nothing"
    assert "--rays needs --mode" in lightarc(*words, "--rays", "16").err
    assert "--rays 2 is outside 4 … 32" in lightarc(*words, "--mode", NAME, "--rays", "2").err
    means = []
    for renderer in ("gl", "cpu"):
        drawn = result(lightarc("render", output, "--env", "studio", "--renderer", renderer, "-o", image, "--json"))
        assert drawn["mode"] == NAME
        means.append(drawn["mean_radiance"])
    assert means[0] == pytest.approx(means[1], rel=1e-2)
    assert means[0] > 0.0
    assert f"--mode {NAME}" in lightarc("bake", "-h").out


def test_a_sweep_measures_it(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    """Within a day, so that nothing is left out on whatever machine: the sweep ends when all is measured."""
    words = ("--width", "24", "--height", "18", "--modes", NAME, "direct", "--budget-s", MAX_S, "--json")
    found = lightarc("tradeoff", mesh, "--brdf", "lambert", "--env", "studio", "-o", tmp_path / "out", *words)
    assert found.code == 0, found.err
    record = json.loads(found.out)
    own = [point for point in record["points"] if point["mode"] == NAME]
    assert sorted(point["knobs"]["rays"] for point in own) == [4, 8, 16]  # the choice of the plan comes first
    assert all(point["bake_s"] > 0.0 and point["predicted_frame_s"] == 1e-9 for point in own)
    assert {(each["mode"], each["knob"]) for each in record["ladders"]} >= {(NAME, "rays")}
    assert "Ambient occlusion" in (tmp_path / "out" / "tradeoff.svg").read_text()


def test_a_plan_offers_it_and_its_bake_follows(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    scene = (mesh, "--brdf", "lambert:albedo=0.5", "--env", "studio")
    exact = result(lightarc("plan", *scene, "--error", "0.05", "--json"))
    assert exact["mode"] != NAME
    rough = result(
        lightarc("plan", *scene, "--error", "900%", "--json")
    )  # errors of 40 % are certain to a factor of 10
    assert (rough["mode"], rough["knobs"]["rays"]) == (NAME, 4)
    assert rough["predicted_error_rel"] >= 0.4
    output = tmp_path / "a.transport"
    made = result(lightarc("bake", *scene, "--mode", "auto", "--error", "900%", "-o", output, "--json"))
    assert made["knobs"]["chosen"] == NAME
    assert result(lightarc("render", output, "-o", tmp_path / "a.exr", "--json"))["mode"] == NAME


def test_the_window_has_it_with_a_panel(window: MainWindow, qtbot: Any) -> None:
    document, view = window.bench.document, window.view
    material = dataclasses.replace(document.project.material, brdf="lambert:albedo=0.5")
    document.change("Ball", mesh=sphere(), environment=open_environment("studio"), material=material)
    window.show_workspace("view")
    assert view.mode.buttons[NAME].text() == "AO"
    view.choose_mode(NAME)
    panel, baking = view.bake_panels[NAME], view.bakings[NAME]
    assert panel.isVisible()
    choice = panel.choices["rays"]
    assert [choice.itemData(at) for at in range(choice.count())] == [4, 8, 16]
    choice.setCurrentIndex(choice.findData(16))
    choice.activated.emit(choice.currentIndex())
    qtbot.waitUntil(panel.go.isEnabled, timeout=LONG)
    panel.go.click()
    qtbot.waitUntil(lambda: baking.is_made, timeout=LONG)
    assert view.setting.mode == NAME
    assert view.setting["rays"] == 16
    scene: Any = view.viewport.surface
    qtbot.waitUntil(
        lambda: scene.scene is not None and scene.scene.relit is not None and scene.is_finished, timeout=LONG
    )
    assert scene.scene is not None
    assert isinstance(scene.scene.relit, ambient_occlusion.RelitOcclusion)
    assert np.ptp(scene.scene.relit.rows) < 0.2
    assert window.docks.accuracy.modes.findData(NAME) >= 0


def test_no_file_of_the_product_names_it() -> None:
    """But for the exchange with other programs, which name textures of ambient occlusion so."""
    words = re.compile(r"ambient.?occlusion", re.IGNORECASE)
    folders = (PROJECT / name for name in ("app", "engine", "resources"))
    files = [
        path
        for folder in folders
        for path in folder.rglob("*")
        if path.suffix in (".py", ".glsl", ".vert", ".frag") and PROJECT / "engine" / "exchange" not in path.parents
    ]
    assert files
    assert [str(path) for path in files if words.search(path.read_text(encoding="utf-8"))] == []


def test_nothing_branches_on_the_name_or_the_types_of_a_method() -> None:
    """Outside the files of the method itself, and the list."""
    assert sorted(branches()) == []


def branches() -> Iterator[str]:
    """Comparisons and tables of names of methods, and tests of their types, as `file:line`."""
    paths = [path for folder in ("app", "engine") for path in sorted((PROJECT / folder).rglob("*.py"))]
    texts = {path.relative_to(PROJECT).as_posix(): path.read_text(encoding="utf-8") for path in paths}
    types = {
        node.name
        for name, text in texts.items()
        if OWN.match(name) or name == "engine/transport/relight.py"
        for node in ast.parse(text).body
        if isinstance(node, ast.ClassDef)
    }
    names = {method.name for method in transport.METHODS}
    mentioned = re.compile("|".join([*(f"[\"']{name}[\"']" for name in names), *(rf"\b{name}\b" for name in types)]))
    for name, text in texts.items():
        if OWN.match(name) or name in (*FOREIGN, "engine/transport/method.py") or not mentioned.search(text):
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Compare):
                found = any(_names_one(each, names) for each in (node.left, *node.comparators))
            elif isinstance(node, ast.Dict):
                found = any(key is not None and _names_one(key, names) for key in node.keys)
            elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in TYPE_TESTS:
                found = bool(types & {each.id for each in ast.walk(node.args[1]) if isinstance(each, ast.Name)})
            else:
                continue
            if found:
                yield f"{name}:{node.lineno}"


def _names_one(node: ast.expr, names: set[str]) -> bool:
    """True for the name of a method, or a list of such."""
    each = node.elts if isinstance(node, ast.Tuple | ast.List | ast.Set) else [node]
    return any(isinstance(one, ast.Constant) and one.value in names for one in each)

"""`lightarc plan`, `lightarc bake --mode auto` and `lightarc selftest`: their records, exit codes, and kept costs."""

from __future__ import annotations

import json
import math
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import app.session.machine_profile
from app.cli.transport.plan import report
from app.command_line import main
from app.document.document import Look, Project
from app.project.project_file import History, Writer
from engine.bundle.bundle import save_bundle
from engine.core.steps import drain
from engine.core.stopwatch import read_clock
from engine.geometry.camera import Camera
from engine.geometry.shapes import shape
from engine.light.sky import make_built_in
from engine.planning.costs.cost_model import CostModel, load_model, machine_name, save
from engine.planning.effects.estimates import EFFECTS
from engine.scene.material import Material
from tests.engine.planning.conftest import every_rate
from tests.engine.scenes import weave

pytestmark = pytest.mark.usefixtures("coarse")

LOOK = ["--brdf", "lambert:albedo=0.5", "--env", "sky"]


@pytest.fixture
def mesh(tmp_path: Path) -> str:
    """A tetrahedron."""
    path = tmp_path / "tetrahedron.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    return str(path)


@pytest.fixture(autouse=True)
def kept_costs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Costs that are known already, so that nothing is measured, on a machine without other programs."""
    monkeypatch.setattr(app.session.machine_profile, "background_load", lambda _before, _after: 0.0)
    path = tmp_path / "cache" / "cost-model.json"
    save(replace(every_rate(), machine=machine_name(), measured_at_s=time.time()), path)
    monkeypatch.setattr(app.session.machine_profile, "cost_path", lambda: path)
    return path


def record(words: list[str], capsys: pytest.CaptureFixture[str], code: int = 0) -> dict[str, Any]:
    assert main([*words, "--json"]) == code
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


def test_the_plan_of_a_project_is_that_of_its_scene(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, material = tmp_path / "a.lap", Material(None, None, brdf="lambert:albedo=0.5")
    writer = Writer(path)
    camera = Camera((0.0, 0.5, 4.0), (0.0, 0.0, 0.0), fov_deg=30.0)
    parts: dict[str, Any] = {"mesh": shape("plane"), "environment": make_built_in("sky"), "material": material}
    writer.write(History(Project(**parts, camera=camera, look=Look(mode="direct"))))
    writer.close()
    of_project = record(["plan", str(path), "--error", "0.2"], capsys)
    words = ["plan", "plane", *LOOK, "--camera", "eye=0,0.5,4 target=0,0,0 fov_deg=30", "--error", "0.2"]
    of_scene = record(words, capsys)
    for name in ("effects", "mode", "predicted_error_rel", "satisfied"):
        assert of_project[name] == of_scene[name], name


def test_a_plan_is_a_record_of_all_effects(mesh: str, capsys: pytest.CaptureFixture[str]) -> None:
    found = record(["plan", mesh, *LOOK, "--error", "0.2", "--skip", "fresnel"], capsys)
    assert [each["effect"] for each in found["effects"]] == list(EFFECTS)
    keys = {"effect", "decision", "reason", "estimated_error_rel", "saves_s", "saves_bytes"}
    assert all(set(each) == keys for each in found["effects"])
    assert found["mode"] in ("sh", "wavelet", "direct")
    assert found["predicted_error_rel"] <= 0.2
    assert found["predicted_frame_s"] > 0.0
    assert found["satisfied"]


def test_a_plan_is_reported_to_users(mesh: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plan", mesh, *LOOK, "--time-ms", "0.000001ms", "--cluster", "4", "--bandwidth-mb", "50"]) == 0
    shown = capsys.readouterr().out
    assert all(name in shown for name in EFFECTS)
    assert "No mode draws a frame in 1e-6 ms" in shown
    assert "On 4 workers like this machine, over a link of 50 MB a second" in shown
    assert all(f"\n    {workers} workers: " in shown for workers in (2, 4, 8))
    assert "Measured bakes took 0.7 to 1.4 times" in shown


def test_a_reference_that_nobody_waits_for_is_named_and_not_chosen(
    mesh: str, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["plan", mesh, "--brdf", "ggx:alpha=0.03", "--env", "sky", "--error", "0.005"]
    found = record(words, capsys)
    assert not found["satisfied"]
    assert found["mode"] != "reference"
    assert found["beyond"]["mode"] == "reference"
    assert found["beyond"]["exceeded"] == ["frame_s"]
    assert main(words) == 0
    shown = capsys.readouterr().out
    assert "The reference meets it" in shown
    assert f"--samples {found['beyond']['knobs']['samples']}" in shown
    once = record([*words, "--frames", "1"], capsys)
    assert (once["mode"], once["satisfied"], once["beyond"]) == ("reference", True, None)


def test_ceilings_are_told_and_raised_by_flags(mesh: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["plan", mesh, *LOOK, "--error", "0.01", "--max-frame-ms", "100000"]
    assert main(words) == 0
    said = "600 s of bake and 100,000 ms a frame (--max-memory-mb, --max-bake-s, --max-frame-ms)"
    assert said in capsys.readouterr().out
    free = record(words, capsys)
    assert (free["ceilings"]["bake_s"], free["ceilings"]["frame_s"], free["exceeded"]) == (600.0, 100.0, [])
    low = {"max_depth": 1, "error_rel": 0.01, "frame_s": 0.02, "bake_s": 1234.0, "memory_bytes": 5e6}
    beyond = {"mode": "sh", "knobs": {"order": 8}, **low, "exceeded": ["bake_s"]}
    shown = report({**free, "satisfied": False, "probability_within_budget": 0.1, "beyond": beyond})
    assert "No mode meets the budget below the ceilings" in shown
    assert "With --max-bake-s 1300 sh, order 8 meets it: 1 %, 20 ms a frame, 21 min to bake" in shown
    assert main([*words[:-2], "--max-frame-ms", "0.000001ms"]) == 0
    assert "Every mode is beyond the ceilings" in capsys.readouterr().out


@pytest.mark.parametrize(
    "words",
    [
        ["--max-bake-s", "0"],
        ["--error", "0"],
        ["--error", "nan"],
        ["--time-ms", "-3"],
        ["--force", "shine"],
        ["--force", "glossy", "--skip", "glossy"],
        ["--width", "0"],
        ["--cluster", "0"],
        ["--cluster", "tcp://192.168.0.10:8786"],
        ["--bandwidth-mb", "100"],
    ],
)
def test_what_is_no_plan_is_wrong_usage(mesh: str, words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plan", mesh, *LOOK, *words]) == 2
    assert "Traceback" not in capsys.readouterr().err


def test_a_bake_follows_its_plan(mesh: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = str(tmp_path / "a.transport")
    found = record(["bake", mesh, *LOOK, "--mode", "auto", "--error", "0.2", "-o", output], capsys)
    assert Path(output).stat().st_size == found["size_bytes"]
    assert any(line.startswith("No self-shadowing:") for line in found["skipped"])
    assert {each["decision"] for each in found["effects"]} <= {"needed", "skipped"}
    assert main(["bake", mesh, "--brdf", "lambert", "--mode", "auto", "-o", output]) == 2
    assert "--env" in capsys.readouterr().err


def test_a_image_follows_its_plan(mesh: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A tetrahedron shades nothing and needs no path; with shadows forced, paths are all that is left."""
    words = ["render", mesh, *LOOK, "--mode", "auto", "--width", "40", "--height", "30", "--renderer", "cpu"]
    output = ["-o", str(tmp_path / "a.png")]
    found = record([*words, *output, "--error", "0.3"], capsys)
    assert found["mode"] == "direct"
    assert found["directions"] == found["knobs"]["directions"]
    assert any(line.startswith("No self-shadowing:") for line in found["skipped"])
    forced = record([*words, *output, "--error", "0.3", "--force", "self-shadowing"], capsys)
    assert forced["mode"] == "reference"
    assert forced["samples"] == forced["knobs"]["samples"]
    assert {each["effect"]: each["decision"] for each in forced["effects"]}["self-shadowing"] == "forced on"
    for wrong in (["--lamp", "theta_deg=3,phi_deg=0"], ["--samples", "4"], ["--error", "0"], ["--force", "shine"]):
        assert main([*words, *output, *wrong]) == 2
    assert main(["render", mesh, *LOOK, *output, "--error", "0.1"]) == 2
    assert "--mode auto" in capsys.readouterr().err


def test_damaged_costs_are_measured_anew(
    kept_costs: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    from engine.core.steps import Step, Steps, drain
    from engine.planning.costs import machine_profile

    rates = replace(every_rate(), machine=machine_name(), measured_at_s=time.time())

    def quick_profile() -> Steps[Any]:
        yield Step(0.0, "measuring")
        return replace(rates, renderer="measured anew", calibrated=False)

    def calibrate() -> Steps[Any]:
        yield Step(0.0, "measuring")
        return replace(rates, renderer="calibrated", calibrated=busy < 0.2), busy

    busy = 0.4
    monkeypatch.setattr(machine_profile, "calibrate", calibrate)
    monkeypatch.setattr(machine_profile, "quick_profile", quick_profile)
    assert drain(app.session.machine_profile.cost_model()).renderer == "processor"
    kept_costs.write_text("{")
    assert drain(app.session.machine_profile.cost_model()).renderer == "measured anew"
    kept = load_model(kept_costs)
    assert kept is not None
    assert kept.renderer == "measured anew"
    assert drain(app.session.machine_profile.cost_model(anew=True)).renderer == "measured anew", "beside others"
    assert "Other programs used 40 % of the CPUs" in caplog.text
    busy = 0.1
    assert drain(app.session.machine_profile.cost_model(anew=True)).renderer == "calibrated"
    kept = load_model(kept_costs)
    assert kept is not None
    assert kept.renderer == "calibrated"


def test_a_bake_that_a_plan_laid_out_teaches_the_profile(kept_costs: Path) -> None:
    before = load_model(kept_costs)
    assert before is not None
    assert not before.bakes
    app.session.machine_profile.learn("sh", 4.0, 8.0, read_clock())
    points = [
        SimpleNamespace(mode="wavelet", predicted={"bake_s": 2.0}, bake_s=seconds, frame_s=0.0)
        for seconds in (2.0, 6.0, 600.0)
    ]
    points.append(SimpleNamespace(mode="direct", predicted={"frame_s": 2.0}, bake_s=0.0, frame_s=1.0))
    app.session.machine_profile.learn_from(points, read_clock())  # type: ignore[arg-type]
    after = load_model(kept_costs)
    assert after is not None
    assert dict(after.bakes) == {"sh": (pytest.approx(math.log(2.0)), 1), "wavelet": (pytest.approx(math.log(3.0)), 1)}
    assert dict(after.frames) == {"direct": (pytest.approx(math.log(0.5)), 1)}


def test_nothing_is_learnt_beside_other_programs(
    kept_costs: Path, mesh: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Other programs have 40 % of the CPUs while these bakes and frames are timed."""
    monkeypatch.setattr("engine.planning.costs.cost_model.TEACHES_S", 1e-9)
    monkeypatch.setattr("engine.planning.costs.cost_model.FRAME_TEACHES_S", 1e-9)
    monkeypatch.setattr("app.cli.transport.render_output.LONG_S", 0.0)
    monkeypatch.setattr("app.cli.transport.render_output.DRAWN_LONG_S", 0.0)
    before = kept_costs.read_bytes()
    monkeypatch.setattr(app.session.machine_profile, "background_load", lambda _before, _after: 0.4)
    bake, size = str(tmp_path / "a.transport"), ["--width", "16", "--height", "16", "--samples", "1"]
    record(["bake", mesh, "--brdf", "lambert", "--mode", "sh", "--order", "3", "-o", bake], capsys)
    record(["bake", mesh, *LOOK, "--mode", "auto", "--error", "0.2", "-o", str(tmp_path / "b.transport")], capsys)
    record(["render", bake, "--env", "studio", *size, "--renderer", "cpu", "-o", str(tmp_path / "a.png")], capsys)
    record(["render", mesh, *LOOK, *size, "--mode", "reference", "-o", str(tmp_path / "b.png")], capsys)
    point = SimpleNamespace(mode="sh", predicted={"bake_s": 2.0, "frame_s": 1.0}, bake_s=4.0, frame_s=2.0)
    app.session.machine_profile.learn_from([point], read_clock())  # type: ignore[list-item]
    assert kept_costs.read_bytes() == before
    monkeypatch.setattr(app.session.machine_profile, "background_load", lambda _before, _after: 0.05)
    app.session.machine_profile.learn_from([point], read_clock())  # type: ignore[list-item]
    assert kept_costs.read_bytes() != before


def test_a_bake_of_a_named_mode_teaches_the_profile_unless_plans_do_not_know_it(
    kept_costs: Path, mesh: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("engine.planning.costs.cost_model.TEACHES_S", 1e-9)
    line = ["bake", mesh, "--brdf", "lambert", "--mode", "sh", "--order", "3", "-o", str(tmp_path / "a.transport")]
    record([*line, "--cube", "16"], capsys)
    assert not load(kept_costs).bakes, "the edge of the cube map is none that a plan would choose"
    record(line, capsys)
    assert load(kept_costs).bakes["sh"][1] == 1


def test_frames_that_are_rendered_teach_the_profile(
    kept_costs: Path, mesh: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("engine.planning.costs.cost_model.FRAME_TEACHES_S", 1e-9)
    line = ["render", mesh, *LOOK, "--width", "16", "--height", "16", "--samples", "1", "--mode", "reference"]
    record([*line, "-o", str(tmp_path / "a.png")], capsys)
    assert not load(kept_costs).frames, "it took less time than its prediction"
    monkeypatch.setattr("app.cli.transport.render_output.LONG_S", 0.0)
    record([*line, "-o", str(tmp_path / "b.png")], capsys)
    record([*line, "--turntable", "3", "-o", str(tmp_path / "c.webp")], capsys)
    assert load(kept_costs).frames["reference"][1] == 2


def test_frames_of_bakes_and_of_shading_maps_teach_the_profile(
    kept_costs: Path, mesh: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("engine.planning.costs.cost_model.FRAME_TEACHES_S", 1e-9)
    monkeypatch.setattr("app.cli.transport.render_output.DRAWN_LONG_S", 0.0)
    size = ["--width", "16", "--height", "16", "--samples", "1", "--renderer", "cpu", "--env", "studio"]
    bake = str(tmp_path / "a.transport")
    record(["bake", mesh, "--brdf", "lambert", "--mode", "sh", "--order", "3", "-o", bake], capsys)
    record(["render", bake, *size, "-o", str(tmp_path / "a.png")], capsys)
    assert {mode: count for mode, (_, count) in load(kept_costs).frames.items()} == {"sh": 1}
    drain(save_bundle(tmp_path / "a.lightarc", weave(8)))
    record(["render", mesh, "--material", str(tmp_path / "a.lightarc"), *size, "-o", str(tmp_path / "b.png")], capsys)
    assert {mode: count for mode, (_, count) in load(kept_costs).frames.items()} == {"sh": 1, "shading-map": 1}


def load(path: Path) -> CostModel:
    kept = load_model(path)
    assert kept is not None
    return kept


def test_the_self_test_tells_its_cases(capsys: pytest.CaptureFixture[str]) -> None:
    found = record(["selftest", "--only", "CO", "H6"], capsys)
    assert [each["id"] for each in found["cases"]] == ["CO1", "CO5", "CO7", "H6"]
    assert all(each["pass"] and each["measured"] <= each["bound"] for each in found["cases"])
    assert main(["selftest", "--only", "Y3"]) == 2


def test_a_case_that_fails_is_the_exit_code(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from engine.selftest import run
    from engine.selftest.case import Question

    monkeypatch.setattr(run, "QUESTIONS", (Question("H6", "a figure that is too large", lambda: (2.0, 1.0)),))
    found = record(["selftest"], capsys, 1)
    assert [each["pass"] for each in found["cases"]] == [False]
    assert main(["selftest"]) == 1
    assert "FAIL" in capsys.readouterr().out

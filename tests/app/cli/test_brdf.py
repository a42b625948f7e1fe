"""`lightarc brdf` as a user types it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from engine.brdf.brdf import MODELS, brdf_from_text
from engine.core.directions import surface_direction
from tests.app.command import Command, result

#: A grid of directions in degrees: theta_i, phi_i, theta_o, phi_o.
PAIRS_DEG = np.array([(30, 0, 30, 180), (10, 20, 70, 300), (80, 0, 80, 180), (90, 0, 10, 0), (0, 0, 0, 0)], float)


def directions(degrees: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    theta_i, phi_i, theta_o, phi_o = np.radians(degrees).T
    return surface_direction(theta_i, phi_i), surface_direction(theta_o, phi_o)


@pytest.fixture
def pairs_file(tmp_path: Path) -> Path:
    path = tmp_path / "pairs.csv"
    rows = "\n".join(",".join(map(str, row)) for row in PAIRS_DEG)
    path.write_text(f"theta_i,phi_i,theta_o,phi_o\n{rows}\n")
    return path


@pytest.fixture
def measured_file(tmp_path: Path) -> Path:
    """A table of values that a Blinn–Phong material would have."""
    path = tmp_path / "plastic.csv"
    theta_i, phi_i, theta_o, phi_o = np.meshgrid(
        [5.0, 30.0, 60.0], [0.0], np.arange(0, 80, 6.0), np.arange(0, 360, 30.0)
    )
    degrees = np.column_stack([part.ravel() for part in (theta_i, phi_i, theta_o, phi_o)])
    values = brdf_from_text("blinn-phong:kd=0.3/0.2/0.1,ks=0.2,exponent=30").f(*directions(degrees))
    rows = "\n".join(",".join(map(repr, map(float, row))) for row in np.hstack([degrees, values]))
    path.write_text(f"theta_i,phi_i,theta_o,phi_o,R,G,B\n{rows}\n")
    return path


def test_list_names_every_model_with_its_parameters(lightarc: Command) -> None:
    found = result(lightarc("brdf", "list", "--json"))
    assert [model["name"] for model in found["models"]] == list(MODELS)
    assert all(model["parameters"] for model in found["models"])
    assert any("blue-paint" in preset["brdf"] for preset in found["presets"])
    assert "blue-paint" in lightarc("brdf", "list").out


def test_eval_gives_the_values_of_a_file_of_directions(lightarc: Command, pairs_file: Path) -> None:
    text = "ashikhmin-shirley:kd=0.5,ks=0.05,nu=10,nv=100"
    found = result(lightarc("brdf", "eval", text, "--directions", pairs_file, "--json"))
    wanted = brdf_from_text(text).f(*directions(PAIRS_DEG))
    wanted[3] = 0.0
    assert np.array_equal(found["values"], wanted)


@pytest.mark.parametrize("horizon", ["90", "-90", "270"])
def test_eval_at_the_horizon_is_0(lightarc: Command, horizon: str) -> None:
    for wi, wo in ((horizon, "10"), ("10", horizon)):
        command = lightarc("brdf", "eval", "lambert", f"--wi-deg={wi},20", f"--wo-deg={wo},70", "--json")
        assert result(command)["values"] == [[0.0, 0.0, 0.0]]


def test_eval_of_a_single_pair(lightarc: Command) -> None:
    found = result(lightarc("brdf", "eval", "lambert:albedo=0.5", "--wi-deg", "30,0", "--wo-deg", "30,180", "--json"))
    assert found["values"] == [pytest.approx([0.5 / np.pi] * 3)]


@pytest.mark.parametrize(
    "words",
    [
        ("eval", "lambert"),
        ("eval", "lambert", "--wi-deg", "30,0"),
        ("eval", "lambert", "--wi-deg", "30", "--wo-deg", "1,2"),
        ("eval", "lambert", "--wi-deg", "a,b", "--wo-deg", "1,2"),
        ("eval", "lambert", "--wi-deg", "1,nan", "--wo-deg", "1,2"),
        ("eval", "velvet", "--wi-deg", "30,0", "--wo-deg", "1,2"),
        ("info", "ggx:alpha=7"),
        ("fit", "lambert", "--model", "gloss"),
        ("fit", "lambert", "--model", "ggx", "--fix", "gloss"),
        ("fit", "absent.csv", "--model", "ggx", "--fix", "gloss"),
        ("fit", "lambert", "--model", "ggx", "--samples", "0"),
        ("fit", "lambert", "--model", "ggx", "--rank"),
        ("fit", "lambert", "--rank", "--fix", "kd"),
        ("fit", "lambert"),
        ("convert", "lambert", "-o", "table.txt"),
        (),
    ],
)
def test_wrong_words_are_wrong_usage(lightarc: Command, words: tuple[str, ...]) -> None:
    command = lightarc("brdf", *words)
    assert command.code == 2
    assert "Traceback" not in command.err
    assert "two_numbers" not in command.err


def test_angles_may_be_negative(lightarc: Command) -> None:
    words = ("brdf", "eval", "phong:kd=0,ks=1,exponent=5", "--json")
    separate = result(lightarc(*words, "--wi-deg", "-30,0", "--wo-deg", "40,-20.5"))
    joined = result(lightarc(*words, "--wi-deg=-30,0", "--wo-deg=40,-20.5"))
    turned = result(lightarc(*words, "--wi-deg", "30,180", "--wo-deg", "40,339.5"))
    assert separate["values"] == joined["values"]
    assert np.allclose(separate["values"], turned["values"], rtol=1e-12)


def test_bad_files_are_bad_input(lightarc: Command, tmp_path: Path) -> None:
    nothing = tmp_path / "nothing.binary"
    empty = tmp_path / "empty.binary"
    empty.write_bytes(b"")
    for path in (nothing, empty):
        command = lightarc("brdf", "info", path)
        assert command.code == 3
        assert path.name in command.err


def test_info_of_a_model(lightarc: Command) -> None:
    found = result(lightarc("brdf", "info", "lambert:albedo=0.2/0.4/0.6", "--json"))
    assert found["kind"] == "analytic model"
    assert found["reciprocity_max_rel"] == 0.0
    assert found["maximum_albedo"] == pytest.approx([0.2, 0.4, 0.6])


def test_info_of_a_measurement_says_what_was_measured_and_how_well_it_is_known(
    lightarc: Command, measured_file: Path
) -> None:
    found = result(lightarc("brdf", "info", measured_file, "--json"))
    assert found["name"] == "plastic"
    assert found["samples"] == 3 * 14 * 12
    assert (found["invalid_samples"], found["samples_below_horizon"]) == (0, 0)
    assert found["energy_conserving"]
    assert found["condition_number"] >= 1
    assert 0 < found["leave_one_out"] < 0.5
    assert 0.3 < max(found["maximum_albedo"]) < 1


def test_fit_finds_the_parameters_of_measured_values(lightarc: Command, measured_file: Path) -> None:
    found = result(lightarc("brdf", "fit", measured_file, "--model", "blinn-phong", "--json"))
    assert found["samples"] == 3 * 14 * 12
    assert found["parameters"]["exponent"] == pytest.approx(30, rel=1e-3)
    assert found["parameters"]["kd"] == pytest.approx([0.3, 0.2, 0.1], rel=1e-3)
    assert found["rmse_rel_after"] < 1e-3 < found["rmse_rel_before"]
    assert {band["samples"] for band in found["residual_by_angle"]["theta_h"]} != {0}
    assert brdf_from_text(found["fitted"]).f([0, 0, 1], [0, 0, 1])[0] > 0


def test_fit_writes_what_it_reports_and_replaces_only_its_own(lightarc: Command, tmp_path: Path) -> None:
    words = ("brdf", "fit", "phong:kd=0.2,ks=0.1,exponent=5", "--model", "lambert", "--samples", "100")
    found = result(lightarc(*words, "-o", tmp_path / "fit.json", "--json"))
    written = json.loads((tmp_path / "fit.json").read_text())
    assert written == {key: value for key, value in found.items() if key != "output"}
    assert found["objective_after"] < found["objective_before"]
    assert lightarc(*words, "-o", tmp_path / "fit.json").code == 0
    (tmp_path / "mine.json").write_text("{}")
    assert lightarc(*words, "-o", tmp_path / "mine.json").code != 0


def test_models_are_ranked_by_their_errors_in_both_norms(lightarc: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.cli.brdf.MODELS", {name: MODELS[name] for name in ("lambert", "phong")})
    words = ("brdf", "fit", "phong:kd=0.2,ks=0.1,exponent=5", "--rank", "--samples", "100")
    found = result(lightarc(*words, "--json"))
    assert [each["model"] for each in found["ranking"]] == ["phong", "lambert"]
    assert found["best"]["linear"] == found["best"]["log"] == found["ranking"][0]
    assert "best in the linear norm" in lightarc(*words).out


@pytest.mark.parametrize("suffix", [".binary", ".exr"])
def test_convert_writes_a_table_that_reads_back(lightarc: Command, tmp_path: Path, suffix: str) -> None:
    output = tmp_path / f"plastic{suffix}"
    text = "blinn-phong:kd=0.3/0.2/0.1,ks=0.2,exponent=30"
    found = result(lightarc("brdf", "convert", text, "-o", output, "--json"))
    assert found["size_bytes"] == output.stat().st_size
    assert found["resampling_rms_rel"] < 0.01
    back = result(lightarc("brdf", "eval", output, "--wi-deg", "30,0", "--wo-deg", "40,170", "--json"))
    exact = brdf_from_text(text).f(*directions(np.array([[30.0, 0.0, 40.0, 170.0]])))
    assert np.allclose(back["values"], exact, rtol=0.02)


def test_convert_leaves_nothing_half_written(lightarc: Command, tmp_path: Path) -> None:
    output = tmp_path / "missing" / "table.exr"
    command = lightarc("brdf", "convert", tmp_path / "absent.exr", "-o", output)
    assert command.code == 3
    assert not output.parent.exists()

"""`lightarc bake --mode sh` and `lightarc render` of what it made, as a user types them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from app.cli.transport.bake_report import UNCHECKED
from engine.bundle.bundle import save_bundle
from engine.core.figure_text import percent
from engine.core.steps import drain
from engine.images.decode import read_image
from tests.app.command import Command, result
from tests.engine.domes import dome_material

pytestmark = pytest.mark.usefixtures("coarse")

QUICK = ("--mode", "sh", "--order", "3", "--cube", "8", "--fine", "1", "--json")
SMALL = ("--width", "48", "--height", "36", "--samples", "1", "--json")


def test_a_model_is_baked_and_drawn_under_any_light_and_with_another_brdf(
    lightarc: Command, mesh: Path, tmp_path: Path
) -> None:
    output, image = tmp_path / "a.transport", tmp_path / "a.exr"
    made = lightarc("bake", mesh, "--brdf", "phong:exponent=5", "--ground", "--ground-cells", "4", "-o", output, *QUICK)
    found = result(made)
    assert {"vertices", "bake_s", "visibility_s", "size_bytes", "knobs", "skipped"} <= set(found)
    assert found["size_bytes"] == output.stat().st_size
    assert f"{12 + 25} vertices, about " in made.err
    assert found["stored"] == "matrices"
    lights = ("--env", "sky"), ("--light-deg", "20,30"), ("--lamp", "theta_deg=10,radius_deg=20", "--window", "hanning")
    for light in lights:
        drawn = result(lightarc("render", output, *light, "-o", image, *SMALL))
        assert drawn["mode"] == "sh"
        assert drawn["covered_fraction"] > 0.1
        assert drawn["mean_radiance"] > 0.0
        assert {"relight_s", "negative_rel", "order", "table_error_rel"} <= set(drawn)
    changed = result(lightarc("render", output, "--env", "sky", "--brdf", "lambert:albedo=0", "-o", image, *SMALL))
    assert changed["brdf"] == "lambert:albedo=0"


def test_turning_the_light_by_a_whole_turn_changes_nothing(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    output = tmp_path / "a.transport"
    assert result(lightarc("bake", mesh, "--brdf", "lambert", "-o", output, *QUICK))["stored"] == "vectors"
    means = []
    for angle in ("0", "360", "90"):
        command = ("render", output, "--env", "sunset", "--env-rotation-deg", angle, "-o", tmp_path / "a.exr", *SMALL)
        means.append(result(lightarc(*command))["mean_radiance"])
    assert means[1] == pytest.approx(means[0], rel=1e-6)
    assert means[2] != pytest.approx(means[0], rel=1e-3)


def test_the_texels_of_a_material_are_drawn_in_the_light_of_a_bake(
    lightarc: Command, mesh: Path, tmp_path: Path
) -> None:
    material, output, image = tmp_path / "a.lightarc", tmp_path / "a.transport", tmp_path / "a.exr"
    drain(save_bundle(material, dome_material()))
    made = result(
        lightarc("bake", mesh, "--material", material, "--ground", "--ground-cells", "4", *QUICK, "-o", output)
    )
    assert any("lightarc render BAKE --material" in each for each in made["warnings"])
    drawn = {}
    for name, renderer in (("plain", "gl"), ("gl", "gl"), ("cpu", "cpu")):
        texels = () if name == "plain" else ("--material", material)
        lit = ("--env", "sky", "--directions", "16", "--renderer", renderer, *texels)
        drawn[name] = result(lightarc("render", output, *lit, "-o", image, *SMALL))
        drawn[name]["picture"] = next(iter(OpenEXR.File(str(image)).channels().values())).pixels
    assert drawn["gl"]["texels_renderer"] == drawn["gl"]["gl_renderer"]
    assert drawn["cpu"]["mean_radiance"] == pytest.approx(drawn["gl"]["mean_radiance"], rel=0.02)
    contrast = {name: np.std(each["picture"]) / np.mean(each["picture"]) for name, each in drawn.items()}
    assert contrast["gl"] > 1.1 * contrast["plain"]
    shown, turn = tmp_path / "a.png", tmp_path / "turn"
    textured = ("render", output, "--material", material, "--env", "sky", "--directions", "16", *SMALL)
    assert result(lightarc(*textured, "--turntable", "2", "--turns", "light", "-o", turn))["frames"] == 2
    for at, rotation in enumerate(("0", "180")):
        result(lightarc(*textured, "--env-rotation-deg", rotation, "-o", shown))
        assert np.array_equal(read_image(turn / f"frame-{at:05}.png").pixels, read_image(shown).pixels)
    near = ("--near-lamp", "x=3,y=3,z=3,radius=0.1,power=40")
    nearby = result(lightarc("render", output, "--material", material, *near, "-o", image, *SMALL))
    film = ("--turntable", "2", "--turns", "light", "--overwrite", "-o", turn)
    assert result(lightarc("render", output, *near, *film, *SMALL))["frames"] == 2
    first, second = (read_image(turn / f"frame-{at:05}.png").pixels for at in range(2))
    assert not np.array_equal(first, second), "a light nearby turns with the others"
    seen = {"texels": next(iter(OpenEXR.File(str(image)).channels().values())).pixels}
    bare = result(lightarc("render", output, *near, "-o", image, *SMALL))
    seen["bare"] = next(iter(OpenEXR.File(str(image)).channels().values())).pixels
    assert nearby["mean_radiance"] > 0.0
    assert bare["mean_radiance"] > 0.0
    texels, bake = (np.std(seen[name]) / np.mean(seen[name]) for name in ("texels", "bare"))
    assert texels > 1.05 * bake, "texels have the contrast that light nearby gives them"


def test_what_cannot_be_is_refused_with_the_reason(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    output, image = tmp_path / "a.transport", tmp_path / "a.exr"
    result(lightarc("bake", mesh, "--brdf", "lambert", "--interreflection", "-o", output, *QUICK))
    for words, reason in {
        ("render", output, "--env", "sky", "--brdf", "phong", "-o", image, *SMALL): "bake again with the other BRDF",
        ("render", output, "--mode", "wavelet", "-o", image, *SMALL): "mode sh",
        ("render", output, "--ground", "0.3", "-o", image, *SMALL): "--ground is part of the bake",
        ("bake", mesh, "--brdf", "lambert", "-o", output, "--mode", "sh", "--order", "2"): "--order 2 is outside",
        ("bake", mesh, "--brdf", "lambert", "-o", output, "--indirect"): "needs --mode gaussian",
        ("render", output, "--env", "sky", "--intensity", "nan", "-o", image, *SMALL): "--intensity nan",
    }.items():
        refused = lightarc(*words)
        assert refused.code != 0
        assert reason in refused.err


def test_a_brdf_varies_over_a_model_in_the_bake_and_again_in_the_image(
    lightarc: Command, mesh: Path, tmp_path: Path
) -> None:
    output, image = tmp_path / "a.transport", tmp_path / "a.exr"
    bake = ("bake", mesh, "--brdf", "ggx:kd=0.2,alpha=0.3", "-o", output, *QUICK)
    made = result(lightarc(*bake, "--vary", "alpha=0.4:0.5:y", "--vary", "kd=0:0.8:x", "--error-env", "sky"))
    assert made["knobs"]["vary"] == ["alpha=0.4:0.5:y", "kd=0:0.8:x"]
    assert len(made["tables"]) == 2
    assert made["interpolation_rel"] < 0.02
    assert made["check"] is None
    assert UNCHECKED in made["skipped"]
    assert 0.0 < made["error_rmse_rel"] < 0.5
    assert 0.0 < abs(made["error_mean_rel"]) < made["error_rmse_rel"]
    lit = ("--env", "sky", "-o", image, *SMALL)
    baked = result(lightarc("render", output, *lit))["mean_radiance"]
    again = result(lightarc("render", output, "--vary", "alpha=0.4:0.5:y", "--vary", "kd=0:0.8:x", *lit))
    assert again["mean_radiance"] == pytest.approx(baked, rel=1e-4)
    darker = result(lightarc("render", output, "--vary", "kd=0:0.1:x", *lit))["mean_radiance"]
    assert darker < 0.9 * baked
    for words, reason in {
        (*bake, "--vary", "gloss=0:1:x"): "no parameter 'gloss'",
        (*bake, "--vary", "alpha=0.1:7:x"): "outside",
        (*bake, "--vary", "alpha=0.1:0.2"): "PARAMETER=FROM:TO:SOURCE",
        (*bake, "--vary", "alpha=0.1:0.2:nowhere.png"): "nowhere.png",
        (*bake, *(("--vary", "alpha=0.1:0.2:x") * 2)): "twice",
        (*bake, "--vary", "alpha=0.4:0.5:x", "--vary", "kd=0:1:x", "--vary", "f0=0:1:x"): "1 or 2",
        (*bake[:6], "--mode", "wavelet", "--vary", "alpha=0.1:0.2:x"): "--mode wavelet",
        ("render", output, "--vary", "kd=0:1", *lit): "PARAMETER=FROM:TO:SOURCE",
        ("render", mesh, "--vary", "kd=0:1:x", *lit): "--mode sh",
    }.items():
        refused = lightarc(*words)
        assert refused.code != 0
        assert reason in refused.err, refused.err


def test_lamps_nearby_fall_off_with_the_distance(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    output, image = tmp_path / "a.transport", tmp_path / "a.exr"
    result(lightarc("bake", mesh, "--brdf", "lambert", "--ground", "--ground-cells", "4", "-o", output, *QUICK))
    means = []
    for place in ("x=40,y=40,z=40", "x=80,y=80,z=80", "x=80,y=80,z=80,power=4"):
        drawn = result(lightarc("render", output, "--near-lamp", place, "-o", image, *SMALL))
        means.append(drawn["mean_radiance"])
        assert drawn["near_error_rel"] < 0.01
        assert len(drawn["near_points"]) == 2
    assert means[0] == pytest.approx(4.0 * means[1], rel=0.1)
    assert means[2] == pytest.approx(4.0 * means[1], rel=1e-4)
    both = ("--near-lamp", "x=40,y=40,z=40", "--near-lamp", "x=80,y=80,z=80", "--near-points", "3")
    total = result(lightarc("render", output, *both, "-o", image, *SMALL))
    assert total["mean_radiance"] == pytest.approx(means[0] + means[1], rel=0.02)
    assert total["near_points"] == [27, 9]
    assert not [text for text in total["warnings"] if "near lamps" in text]
    coarse = result(lightarc("render", output, "--near-lamp", "x=2,y=2,z=2", "--near-points", "1", "-o", image, *SMALL))
    assert coarse["near_error_rel"] > 0.1
    [reported] = [text for text in coarse["warnings"] if "near lamps" in text]
    assert percent(coarse["near_error_rel"], 3) in reported
    for words, reason in {
        ("--near-lamp", "x=0.2,y=0.2,z=0.2,radius=0.5"): "touches the model",
        ("--near-lamp", "w=1"): "choose from shape, x, y, z",
        ("--near-lamp", "x=3", "--near-points", "99"): "outside 1",
        ("--near-points", "3"): "needs --near-lamp",
    }.items():
        refused = lightarc("render", output, *words, "-o", image, *SMALL)
        assert refused.code != 0
        assert reason in refused.err, refused.err
    direct = result(lightarc("render", mesh, "--near-lamp", "shape=disc,y=3,radius=1,power=9", "-o", image, *SMALL))
    assert direct["near_lamps"][0]["shape"] == "disc"
    assert direct["mean_radiance"] > 0.0
    for text, reason in {
        "shape=cone": "shape is sphere, rectangle, disc",
        "shape=disc,width=1": "a disc has no width; it has facing_theta_deg, facing_phi_deg, radius",
        "shape=rectangle,width=0": "width = 0 is outside",
    }.items():
        refused = lightarc("render", mesh, "--near-lamp", text, "-o", image, *SMALL)
        assert refused.code == 2
        assert reason in refused.err

"""`lightarc bake` and `lightarc render` of what it made, as a user types them."""

from __future__ import annotations

import argparse
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.cli.transport import bake
from engine.accuracy import bake_check
from engine.core.steps import Step
from engine.images.decode import read_image
from engine.transport import method
from engine.transport.baking.check import LAMP, BakeCheck
from engine.transport.baking.file import open_transport
from tests.app.command import Command, replace_options, result
from tests.present import present

pytestmark = pytest.mark.usefixtures("coarse")

QUICK = ("--cube", "16", "--coefficients", "40", "--fine", "1", "--terms", "2", "--json")
SMALL = ("--width", "48", "--height", "36", "--samples", "1", "--json")


def test_a_model_is_baked_and_drawn_under_any_light(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    output = tmp_path / "a.transport"
    made = lightarc("bake", mesh, "--brdf", "phong:exponent=5", "--ground", "--ground-cells", "4", "-o", output, *QUICK)
    found = result(made)
    assert {"vertices", "bake_s", "visibility_s", "size_bytes", "knobs", "skipped"} <= set(found)
    assert found["size_bytes"] == output.stat().st_size
    assert f"{12 + 25} vertices, about " in made.err
    assert found["vertices"] == 12 + 25
    assert found["knobs"]["terms"] == 2
    for number, light in enumerate((("--env", "sky"), ("--light-deg", "20,30"), ("--lamp", "theta_deg=10"))):
        image = tmp_path / f"{number}.exr"
        drawn = result(lightarc("render", output, "--mode", "wavelet", *light, "-o", image, *SMALL))
        assert drawn["covered_fraction"] > 0.1
        assert drawn["mean_radiance"] > 0.0
        assert {"relight_s", "negative_rel", "sky_energy_error_rel", "light_rmse_rel"} <= set(drawn)
        assert image.exists()
    assert result(lightarc("render", output, "--env", "sky", "-o", tmp_path / "x.png", *SMALL))["mode"] == "wavelet"


def test_another_brdf_is_drawn_from_kept_visibility(
    lightarc: Command, mesh: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the error that it has, and without a change of the file; without the visibility a bake is priced."""
    output, other = tmp_path / "a.transport", tmp_path / "b.transport"
    result(lightarc("bake", mesh, "--brdf", "phong:exponent=5", "-o", output, "--no-check", *QUICK))
    before = output.read_bytes()
    changed = ("--brdf", "ggx:alpha=0.4", "--env", "sky", *SMALL)
    drawn = result(lightarc("render", output, *changed, "-o", tmp_path / "a.exr"))
    assert drawn["error_env"] == "sky"
    assert 0.0 < drawn["error_rmse_rel"] < 0.5
    assert output.read_bytes() == before
    words = ("--cube", "16", "--coefficients", "40", "--fine", "1", "--terms", "4", "--json")
    result(lightarc("bake", mesh, "--brdf", "ggx:alpha=0.4", "-o", other, "--no-check", *words))
    result(lightarc("render", other, "--env", "sky", "-o", tmp_path / "b.exr", *SMALL))
    first, second = (read_image(tmp_path / name).pixels for name in ("a.exr", "b.exr"))
    assert np.array_equal(first, second)
    drawing = ("render", output, *changed[:-1], "-o", tmp_path / "c.exr")
    assert "error under sky: " in lightarc(*drawing).out
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "empty"))
    refused = lightarc(*drawing)
    assert refused.code == 2
    assert "bake again with the other BRDF, which takes about" in refused.err


@pytest.mark.checked_bakes
@pytest.mark.parametrize("mode", method.names())
def test_a_bake_of_each_mode_ends_with_its_check(
    lightarc: Command, mesh: Path, tmp_path: Path, mode: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bake_check, "EDGE", 16)
    monkeypatch.setattr(bake_check, "SAMPLES", 8)
    output, own = tmp_path / "a.transport", {"wavelet": QUICK[:-1], "sh": ("--order", "3")}.get(mode, ())
    words = ("bake", mesh, "--brdf", "ggx:kd=0.3,alpha=0.5", "--mode", mode, "-o", output, *own, "--json")
    found = result(lightarc(*words, "--error-env", "overcast") if mode == "sh" else lightarc(*words))
    lights = [each["light"] for each in found["check"]["lights"]]
    assert lights == [*(["overcast"] if mode == "sh" else []), *bake_check.ENVIRONMENTS, LAMP]
    assert all(each["pixels"] > 0 for each in found["check"]["lights"])
    assert open_transport(output).check == BakeCheck.model_validate(found["check"])
    assert result(lightarc(*words, "--no-check"))["check"] is None
    assert open_transport(output).check is None


def test_lambert_under_a_lamp_is_what_the_direct_mode_draws(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    output = tmp_path / "a.transport"
    brdf = ("--brdf", "lambert:albedo=0.5")
    result(lightarc("bake", mesh, *brdf, "-o", output, *QUICK))
    images = []
    for name, words in {"a.png": (output,), "b.png": (mesh, *brdf, "--mode", "direct", "--renderer", "cpu")}.items():
        result(lightarc("render", *words, "--light-deg", "40,30", "-o", tmp_path / name, *SMALL))
        images.append(present(cv2.imread(str(tmp_path / name))).astype(float))
    assert np.abs(images[0] - images[1]).mean() < 1.0
    assert images[0].std() > 20.0


def test_what_is_cancelled_goes_on(mesh: Path, tmp_path: Path, lightarc: Command) -> None:
    parser = argparse.ArgumentParser()
    bake.add_arguments(parser)
    output = tmp_path / "a.transport"
    words = [str(mesh), "--brdf", "lambert", "--ground", "--ground-cells", "9", "-o", str(output), *QUICK[:-1]]

    def interrupt(step: Step) -> None:
        if step.done > 0.5:
            raise KeyboardInterrupt

    found = bake.run(parser.parse_args(words), interrupt)
    assert (found["cancelled"], found["exit_code"], output.exists()) == (True, 4, False)
    assert Path(found["unfinished"]).stat().st_size == found["unfinished_bytes"] > found["size_bytes"]
    assert f"goes on from here, with {found['unfinished']} (81.9 kB)" in bake.report(found)
    gone = bake.run(parser.parse_args([*words[:-2], "--terms", "1", "--restart"]), interrupt)
    assert (gone["cancelled"], gone["unfinished"], len(list(tmp_path.glob(".*")))) == (True, None, 0)
    assert "nothing was written" in bake.report(gone)
    bake.run(parser.parse_args(words), interrupt)
    again = result(lightarc("bake", *words, "--json"))
    assert again["chunks_resumed"] >= 1
    assert "kept from the cancelled bake" in bake.report(again)
    assert result(lightarc("render", output, "-o", tmp_path / "x.png", *SMALL))["vertices"] == again["vertices"]


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (("--cube", "128"), 2, "--cube 128 is outside 2 … 64"),
        (("--cube", "48"), 2, "2, 4, 8, 16, 32, 64 are"),
        (("--terms", "0"), 2, "--terms 0"),
        (("--terms", "1000"), 2, "--terms 1000"),
        (("--coefficients", "0"), 2, "coefficients"),
        (("--fine", "99"), 2, "--fine"),
        (("--ground", "1.5"), 2, "1.5 is 150%"),
        (("--ground", "nan"), 2, "albedo nan"),
        (("--brdf", "nonsense"), 2, "nonsense"),
        (("--cluster", "nonsense"), 2, "not an address of a Dask scheduler"),
        (("--cluster", "tcp://127.0.0.1:9"), 3, "no scheduler of a cluster answers"),
        (("-o", "/dev/null/all.transport"), 3, "/dev/null is a file"),
    ],
)
def test_what_cannot_be_baked_is_refused(
    words: tuple[str, str],
    code: int,
    message: str,
    lightarc: Command,
    mesh: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("engine.core.cluster.PATIENCE_S", 0.3)
    common = replace_options(("--brdf", "lambert", "-o", tmp_path / "a.transport", *QUICK), words)
    refused = lightarc("bake", mesh, *common, *words)
    assert (refused.code, message in refused.err) == (code, True), refused.err
    assert not list(tmp_path.glob("*.transport"))


def test_what_was_baked_is_not_changed_by_drawing(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    output = tmp_path / "a.transport"
    result(lightarc("bake", mesh, "--brdf", "lambert", "-o", output, *QUICK))
    for words in (("--ground",), ("--window", "hanning"), ("--measure-error",)):
        refused = lightarc("render", output, "--env", "sky", "-o", tmp_path / "a.png", *SMALL, *words)
        assert refused.code == 2
    damaged = bytearray(output.read_bytes())
    damaged[len(damaged) // 2] ^= 255
    output.write_bytes(damaged)
    broken = lightarc("render", output, "-o", tmp_path / "a.png", *SMALL)
    assert (broken.code, "damaged" in broken.err) == (3, True), broken.err


def test_a_model_in_place_of_a_bake_is_refused_with_the_way_to_bake_it(
    lightarc: Command, mesh: Path, tmp_path: Path
) -> None:
    for model in (mesh, "sphere"):
        refused = lightarc("render", model, "--mode", "wavelet", "-o", tmp_path / "a.png", *SMALL)
        assert refused.code == 3
        assert f"lightarc bake {model} --brdf TEXT --mode wavelet" in refused.err
        assert len(refused.err.strip().splitlines()) == 1


def test_options_of_another_mode_are_refused(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    for words, needed in {("--mode", "sh", "--terms", "2"): "wavelet", ("--order", "7"): "sh"}.items():
        refused = lightarc("bake", mesh, "--brdf", "lambert", "-o", tmp_path / "a.transport", *words)
        assert (refused.code, f"needs --mode {needed}" in refused.err) == (2, True)


def test_the_device_draws_what_the_cpu_draws(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    output, means = tmp_path / "a.transport", []
    result(lightarc("bake", mesh, "--brdf", "ggx:alpha=0.5,kd=0.5", "-o", output, *QUICK))
    for renderer in ("cpu", "gl"):
        drawn = result(
            lightarc("render", output, "--env", "sky", "-o", tmp_path / "a.exr", "--renderer", renderer, *SMALL)
        )
        assert drawn["gl_renderer"].startswith("none") == (renderer == "cpu")
        assert drawn["negative_rel"] >= 0.0
        means.append(drawn["mean_radiance"])
    assert means[1] == pytest.approx(means[0], rel=0.02)


def test_brdfs_are_mixed_over_a_model(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    output, image, black = tmp_path / "a.transport", tmp_path / "half.png", tmp_path / "black.png"
    cv2.imwrite(str(black), np.zeros((2, 2, 3), np.uint8))
    cv2.imwrite(str(image), np.full((2, 2, 3), 188, np.uint8))  # half, as sRGB codes it
    means = {}
    for name, words in {
        "white": (),
        "mixed": ("--blend", "phong:exponent=5:y"),
        "half": ("--albedo", image),
    }.items():
        made = lightarc("bake", mesh, "--brdf", "lambert:albedo=1", *words, "-o", output, *QUICK)
        assert result(made)["knobs"]["blend"] == ([] if name != "mixed" else ["phong:exponent=5:y"])
        drawn = result(lightarc("render", output, "--env", "sky", "-o", tmp_path / "a.exr", *SMALL))
        means[name] = drawn["mean_radiance"]
        assert drawn["terms"] == (3 if name == "mixed" else 1)
        if name == "mixed":
            for weight, of in (("y", "mixed"), (black, "white")):
                words = ("--env", "sky", "--weight", weight, "-o", tmp_path / "a.exr", *SMALL)
                assert result(lightarc("render", output, *words))["mean_radiance"] == pytest.approx(means[of], rel=1e-6)
            words = ("--env", "sky", "--weight", black, "--albedo", image, "-o", tmp_path / "a.exr", *SMALL)
            means["later"] = result(lightarc("render", output, *words))["mean_radiance"]
            refused = lightarc("render", output, "--weight", "x", "--weight", "y", "-o", tmp_path / "a.exr", *SMALL)
            assert (refused.code, "2 weights do not fit 2 reflectances" in refused.err) == (2, True), refused.err
    assert means["later"] == pytest.approx(means["half"], rel=1e-6)
    assert means["half"] == pytest.approx(0.5 * means["white"], rel=0.01)
    assert means["mixed"] != pytest.approx(means["white"], rel=0.01)
    for words, reason in {
        ("--blend", "phong"): "BRDF:SOURCE",
        ("--blend", "nonsense:y"): "nonsense",
        ("--blend", "phong:nothing.png"): "nothing.png",
        ("--albedo", "nothing.png"): "nothing.png",
        ("--mode", "sh", "--albedo", str(image)): "--albedo needs --mode wavelet",
    }.items():
        refused = lightarc("bake", mesh, "--brdf", "lambert", "-o", output, "--cube", "16", *words)
        assert (refused.code in (2, 3), reason in refused.err) == (True, True), refused.err


@pytest.mark.checked_bakes
def test_a_bake_that_was_not_compared_says_so_when_it_is_drawn(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    """Without a check, or with a BRDF that the check did not see; a bake that was checked needs no word."""
    said = "This bake was not compared with the reference"
    for name, options in (("checked", ()), ("unchecked", ("--no-check",))):
        output = tmp_path / f"{name}.transport"
        result(
            lightarc(
                "bake", mesh, "--mode", "sh", "--order", "3", "--brdf", "lambert", *options, "-o", output, "--json"
            )
        )
        image = ("render", output, "--env", "sky", "-o", tmp_path / f"{name}.png", *SMALL)
        assert result(lightarc(*image))["skipped"] == ([f"{said}."] if options else [])
    assert f"\n{said}.\n" in lightarc(*image[:-1], "--overwrite").out


def test_a_model_with_materials_is_baked_by_part(lightarc: Command, tmp_path: Path) -> None:
    """Each part has its own colour, from the library of an OBJ model, and its maps where it is drawn with these."""
    model, baked = tmp_path / "two.obj", tmp_path / "two.transport"
    corners = "v -1 0 0\nv 0 0 0\nv 0 1 0\nv -1 1 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    faces = "usemtl red\nf 1/1 2/2 3/3 4/4\nusemtl green\nf 2/1 5/2 6/3 3/4\n"
    model.write_text(f"mtllib two.mtl\n{corners}{faces}")
    (tmp_path / "two.mtl").write_text("newmtl red\nKd 0.8 0.1 0.1\nnewmtl green\nKd 1 1 1\nmap_Kd halves.png\n")
    halves = np.zeros((4, 8, 3), np.uint8)
    halves[:2, :, 1], halves[2:, :, 1] = 255, 60
    cv2.imwrite(str(tmp_path / "halves.png"), halves)
    made = lightarc("bake", model, "--mode", "sh", "--order", "3", "--cube", "8", "-o", baked, "--no-check", "--json")
    found = result(made)
    assert found["materials"] == ["red", "green"]
    assert any("the maps of 'green' are baked at their mean" in text for text in found["warnings"])
    drawn = []
    for number, material in enumerate(((), ("--material", model))):
        image = tmp_path / f"{number}.exr"
        result(lightarc("render", baked, *material, "--env", "sky", "--camera", "eye=0,0.5,4", "-o", image, *SMALL))
        drawn.append(read_image(image).pixels[:, :, :3])
    left, right = ([each[:, some].mean(axis=(0, 1)) for each in drawn] for some in (slice(0, 24), slice(24, None)))
    for each in left:
        assert each[0] > 3.0 * each[1]
    for each in right:
        assert each[1] > 3.0 * each[0]
    upper, lower = (drawn[1][some, 24:].sum(axis=(0, 1))[1] for some in (slice(0, 18), slice(18, None)))
    assert upper > 3.0 * lower

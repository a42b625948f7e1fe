"""The proof: what others draw of our files is our image of them, and what is absent is named."""

from __future__ import annotations

import dataclasses
import json
import os
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.core.directions import normalize
from engine.core.steps import drain
from engine.exchange import blender as exported_blender
from engine.exchange import gltf, loss, materialx, rti
from engine.exchange.subject import Contents, Settings, Subject
from engine.exchange.targets import has_blender
from engine.images.png import read_png
from engine.light.environment import DistantLights
from engine.proof import blender, programs, proof
from engine.proof.libraries import absent
from engine.proof.libraries import materialx as by_materialx
from engine.proof.programs import BROWSERS, three
from engine.proof.proof import linear, relight_hsh, relight_ptm
from engine.proof.square import SIDE, Drawn, draw_ourselves, lamp, middle, relative_rmse, windows
from engine.surface.pbr_maps import ObservedSlopes, PbrMaps
from tests.engine.exchange.materials import dome_material, dome_stack, woven_material, woven_subject


@pytest.fixture(scope="module")
def plastic() -> Subject:
    """A rough dielectric whose texels all differ: no model adds light to it that bounces between facets."""
    rng = np.random.default_rng(5)
    flat = np.zeros((9, 7, 3), np.float32)
    flat[..., 2] = 1.0
    maps = PbrMaps(
        base_colour=rng.uniform(0.1, 0.9, (9, 7, 3)).astype(np.float32),
        normal=flat,
        roughness=rng.uniform(0.4, 0.9, (9, 7)).astype(np.float32),
        metallic=np.zeros((9, 7), np.float32),
        f0=np.full((9, 7), 0.04, np.float32),
        observed=ObservedSlopes("none"),
    )
    return Subject(woven_material(9, 7), maps)


def put(folder: Path, contents: Contents) -> Path:
    for name, content in contents.files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    return folder


def ours(subject: Subject) -> Any:
    return draw_ourselves(subject.decode_as("png8"), subject.maps.size, 1.0 / subject.white)


def test_a_white_square_shows_the_cosine_of_the_lamp() -> None:
    """f = 1/pi and an irradiance of pi: the cosine, everywhere."""
    size = (3, 4)

    def white(view: Any, lights: DistantLights) -> Any:
        (direction,), (irradiance,) = lights.direction, lights.irradiance
        return np.tile(irradiance * direction[2] / np.pi, (len(view.row), 1))

    image = draw_ourselves(white, size, np.pi)
    assert image.shape == (3, 4, 3)
    np.testing.assert_allclose(image, lamp()[2])
    assert relative_rmse(1.1 * image, image) == pytest.approx(0.1)


def test_the_middle_of_large_maps_counts() -> None:
    image = np.zeros((SIDE + 10, 6, 3))
    image[5] = 1.0
    assert middle(image).shape == (SIDE, 6, 3)
    assert middle(image)[0, 0, 0] == 1.0
    assert windows((SIDE + 10, 6)) == ((SIDE, 6), (SIDE / (SIDE + 10), 1.0))


def test_as_many_texels_are_left_out_on_one_side_as_on_the_other() -> None:
    """Others draw the middle of the square, which no other rounding of an odd rest is."""
    image = np.arange(SIDE + 3.0)[:, None, None]
    assert windows((SIDE + 3, 1))[0] == (SIDE - 1, 1)
    assert middle(image)[0, 0, 0] + middle(image)[-1, 0, 0] == SIDE + 2


def test_materialx_draws_our_image_of_the_same_maps(plastic: Subject, tmp_path: Path) -> None:
    """Within 4 %: MaterialX leaves less light to the diffuse part; a flipped image is off by far more."""
    pytest.importorskip("MaterialX", reason="MaterialX is not installed")
    if not os.environ.get("DISPLAY") and shutil.which("xvfb-run") is None:
        pytest.skip("there is no display, and xvfb-run is not installed")
    folder = put(tmp_path, drain(materialx.contents(plastic, Settings(), "")))
    drawn = by_materialx(folder, "gltf_pbr", plastic.maps.size)
    assert drawn.image is not None, drawn.words
    assert drawn.words == "The document is valid."
    assert relative_rmse(drawn.image, ours(plastic)) < 0.04
    assert relative_rmse(drawn.image[::-1], ours(plastic)) > 0.3


def test_three_in_chromium_draws_our_image_of_the_same_maps(plastic: Subject, tmp_path: Path) -> None:
    folder = put(tmp_path, drain(gltf.contents(plastic, Settings(), "")))
    drawn = three(folder, plastic.maps.size)
    if drawn.is_sound is None:
        pytest.skip(drawn.words)
    assert any(map(shutil.which, BROWSERS))
    assert drawn.image is not None, drawn.words
    assert relative_rmse(drawn.image, ours(plastic)) < 0.06
    assert relative_rmse(drawn.image[::-1], ours(plastic)) > 0.3


def test_a_page_that_sends_nothing_is_said_to(
    plastic: Subject, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A browser that ends at once."""
    folder = put(tmp_path, drain(gltf.contents(plastic, Settings(), "")))
    monkeypatch.setattr(programs, "BROWSERS", ("true",))
    (tmp_path / "three").mkdir()
    (tmp_path / "three" / "package.json").write_text('{"version": "0"}')
    monkeypatch.setattr(programs, "NODE", (tmp_path,))
    drawn = three(folder, plastic.maps.size)
    assert drawn.is_sound is False
    assert drawn.words == "It draws nothing: the browser ended early."


def test_eevee_is_shown_a_white_surface_that_looks_the_law_up() -> None:
    """By hand: r / r_max is the cosine of the lamp where the brightest photograph was lit from overhead."""
    material = dataclasses.replace(woven_material(6, 5), elevation_deg=(20.0, 90.0), brdf="phong:exponent=20")
    law = material.power_law
    assert law is not None
    assert blender.our_power_law(material) == pytest.approx(law.scale * lamp()[2] ** law.exponent, rel=1e-5)


def test_blender_without_a_file_is_a_complaint(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(blender, "version_of", lambda _package: "5.0.1")
    drawn = blender.cycles(tmp_path, (4, 4))
    assert (drawn.name, drawn.words, drawn.is_sound) == ("Blender 5.0.1, Cycles", "No .blend was made.", False)


@pytest.mark.long
def test_cycles_draws_our_image_of_the_same_maps(plastic: Subject, tmp_path: Path) -> None:
    """Of maps whose texels and slopes all differ: a pixel shows one texel, so that no filter of pixels counts."""
    if not has_blender():
        pytest.skip("Blender's module (bpy) is not installed")
    slopes = np.random.default_rng(6).uniform(-0.8, 0.8, (9, 7, 2))
    normal = normalize(np.dstack([slopes, np.ones((9, 7))])).astype(np.float32)
    rough = dataclasses.replace(plastic, maps=dataclasses.replace(plastic.maps, normal=normal))
    folder = put(tmp_path, drain(exported_blender.contents(rough, Settings(), "")))
    drawn = blender.cycles(folder, rough.maps.size)
    assert drawn.image is not None, drawn.words
    assert relative_rmse(drawn.image, ours(rough)) < 0.02
    assert relative_rmse(drawn.image[::-1], ours(rough)) > 0.3


def test_rti_files_are_relit_as_we_show_them() -> None:
    subject = Subject(dome_material(), woven_subject().maps, stack=dome_stack())
    files = drain(rti.contents(subject, Settings(), "A loss that the header states.")).files
    shown = rti.show(subject, Settings())
    assert shown is not None
    wanted = draw_ourselves(shown, (8, 6), 1.0)
    np.testing.assert_allclose(linear(relight_hsh(files["dome.rti"])), wanted, atol=1e-4)
    polynomials = proof._our_ptm(subject)
    assert polynomials is not None
    assert relative_rmse(linear(relight_ptm(files["dome.ptm"])), polynomials) < 0.01
    assert relative_rmse(polynomials, wanted) < 0.1


def test_the_sheet_has_all_that_drew_and_names_what_is_absent(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def two_lamps(_name: str) -> DistantLights:
        return DistantLights(np.array([[0.0, 0.6, 0.8], [0.8, 0.0, 0.6]]), np.ones((2, 3)))

    monkeypatch.setattr(loss, "environment_lights", two_lamps)
    brief = dataclasses.replace(woven_material(12, 10), brdf="lambert")
    monkeypatch.setattr(proof, "NAMES", ("materialx", "gltf", "usd", "shaders"))
    drew = Drawn("materialx", "MaterialX", np.full((12, 10, 3), 0.1), "The document is valid.")
    monkeypatch.setattr(proof, "materialx", lambda *_given: drew)
    monkeypatch.setattr(proof, "three", lambda *_given: absent("gltf", "three.js", "no Chromium is installed"))
    wrong = Drawn("usd", "USD 1", None, "30 validators: a complaint.", False)
    monkeypatch.setattr(proof, "usd", lambda _folder: wrong)
    for name in ("validator", "glslang", "mitsuba", "cycles", "eevee"):
        monkeypatch.setattr(proof, name, lambda *_given, name=name: absent("gltf", name, "it is not installed"))
    result = drain(proof.prove(tmp_path / "out", brief))
    rows = {row["consumer"]: row for row in result["proof"]["consumers"]}
    assert rows["MaterialX"]["rmse_rel"] > 0.0
    assert rows["USD 1"]["is_sound"] is False
    assert rows["three.js"]["words"] == "Not asked: no Chromium is installed."
    assert rows["RTI"]["words"] == "Not asked: the lamps stood on one arc."
    assert json.loads((tmp_path / "out" / "proof.json").read_text())["consumers"] == result["proof"]["consumers"]
    sheet = read_png((tmp_path / "out" / "proof.png").read_bytes(), "proof.png").samples
    assert sheet.shape[1] == 2000
    assert sheet.shape[0] > 1500


def test_rows_say_the_error_of_what_they_show() -> None:
    """EEVEE draws the power law, whose error is its own; that of RTI is of the .rti."""
    errors: dict[str, float | None] = {"blender": 0.1, "rti": 0.2, proof.SHADER_TO_RGB: 0.3}
    headings = {
        name: proof._row(proof.Compared(Drawn(target, name, None, "", True), None), errors).heading
        for target, name in (("blender", "Blender 5, Cycles"), ("blender", "Blender 5, EEVEE"), ("rti", "PTM 1.2"))
    }
    assert headings["Blender 5, Cycles"].startswith("blender 10 % away")
    assert headings["Blender 5, EEVEE"].startswith("blender, Shader to RGB 30 % away")
    assert headings["PTM 1.2"].startswith("rti, the .rti 20 % away")

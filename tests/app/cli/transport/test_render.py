"""`lightarc render`, run as a user runs it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import pytest

from app import command_line
from app.cli.transport.render_textured import doubts_of_texels
from engine.brdf.brdf import brdf_from_text
from engine.brdf.readers.table_file import write_table
from engine.brdf.resample import table_from
from engine.bundle.bundle import save_bundle
from engine.core.errors import MissingCapability
from engine.core.steps import drain
from engine.exchange import loss
from engine.images.decode import read_image
from engine.images.encode import encode_exr, encode_png
from engine.light.environment import DistantLights
from engine.scene.material import material_of_maps
from tests.engine.brdf.test_table import direction_table
from tests.engine.exchange.materials import measure_maps
from tests.engine.scenes import weave

HEAD_ON = ("--camera", "eye=0,0,2 fov_deg=20", "--light-deg", "90,0", "--brdf", "lambert:albedo=0.5")
SMALL = ("--width", "64", "--height", "48")


def render(capsys: pytest.CaptureFixture[str], *words: object, code: int = 0) -> Any:
    """Run the verb; its JSON object, or what it says on standard error."""
    assert command_line.main(["render", *map(str, words), "--json"]) == code
    said = capsys.readouterr()
    if code:
        assert said.out == ""
        assert "Traceback" not in said.err
        return said.err
    return json.loads(said.out)


@pytest.fixture(autouse=True)
def only_this_verb(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command_line, "VERBS", (("render", "app.cli.transport.render", ""),))


@pytest.fixture
def bundle(tmp_path: Path) -> Path:
    path = tmp_path / "weave.lightarc"
    drain(save_bundle(path, weave(32)))
    return path


def exr(path: Path) -> np.ndarray:
    return np.asarray(OpenEXR.File(str(path)).channels()["RGB"].pixels, np.float64)


@pytest.mark.parametrize("renderer", ["gl", "cpu"])
def test_radiance_in_the_file_is_the_predicted_one(capsys: Any, tmp_path: Path, renderer: str) -> None:
    path = tmp_path / "plane.exr"
    result = render(capsys, "plane", "-o", path, *HEAD_ON, *SMALL, "--intensity", 2, "--renderer", renderer)
    pixels = exr(path)
    assert pixels.shape == (48, 64, 3)
    np.testing.assert_allclose(pixels, 1 / np.pi, rtol=1e-3)
    assert result["mean_radiance"] == pytest.approx(1 / np.pi, rel=1e-6)
    assert result["frame_s"] > 0
    assert result["gl_renderer"]
    assert (result["width_px"], result["height_px"]) == (64, 48)


def test_a_measured_brdf_is_drawn_by_both_renderers(capsys: Any, tmp_path: Path) -> None:
    table = table_from(brdf_from_text("ggx:kd=0.3,alpha=0.4,f0=0.2"), (30, 30, 60))
    write_table(tmp_path / "paint.exr", table)
    images = []
    for renderer in ("gl", "cpu"):
        path = tmp_path / f"{renderer}.exr"
        result = render(capsys, "sphere", "-o", path, "--brdf", tmp_path / "paint.exr", *SMALL, "--renderer", renderer)
        assert result["warnings"] == []
        images.append(exr(path))
    assert images[0].max() > 0.1
    assert np.median(np.abs(images[0] - images[1])) <= 1e-3 * images[0].max()


def test_measured_anisotropic_brdf_is_drawn_on_the_cpu_and_says_so(capsys: Any, tmp_path: Path) -> None:
    write_table(tmp_path / "cloth.exr", direction_table())
    words = ("sphere", "-o", tmp_path / "cloth.png", "--brdf", tmp_path / "cloth.exr", *SMALL)
    result = render(capsys, *words)
    assert "anisotropic and drawn on the CPU" in result["warnings"][0]
    assert "CPU" in result["gl_renderer"]
    assert any("mean over all azimuths" in text for text in render(capsys, *words, "--renderer", "gl")["warnings"])


def test_png_is_tone_mapped(capsys: Any, tmp_path: Path) -> None:
    path = tmp_path / "plane.png"
    options = (*HEAD_ON, *SMALL, "--tone-map", "none", "--exposure", "1")
    render(capsys, "plane", "-o", path, *options)
    np.testing.assert_allclose(read_image(path).pixels, 1 / np.pi, atol=0.005)


@pytest.mark.parametrize("source", ["slices", "power-law"])
@pytest.mark.parametrize("lookup", ["radiance", "texture", "outgoing", "angle"])
def test_a_material_is_looked_up_in_every_way(
    capsys: Any, tmp_path: Path, bundle: Path, source: str, lookup: str
) -> None:
    path = tmp_path / "out.exr"
    words = ("sphere", "--material", bundle, "--from", source, "--lookup", lookup, "-o", path, *SMALL)
    result = render(capsys, *words)
    assert result["mean_radiance"] > 0.005
    assert np.isfinite(exr(path)).all()


def test_the_brdf_alone_of_maps_says_what_it_costs(
    capsys: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Maps in a bundle, drawn as they are and as the one BRDF at their mean."""

    def two_lamps(_name: str) -> DistantLights:
        return DistantLights(np.array([[0.0, 0.6, 0.8], [0.8, 0.0, 0.6]]), np.ones((2, 3)))

    monkeypatch.setattr(loss, "environment_lights", two_lamps)
    path = drain(save_bundle(tmp_path / "rock.lightarc", material_of_maps(measure_maps(), "rock")))
    words = ("sphere", "--material", path, *SMALL, "--renderer", "cpu")
    whole = render(capsys, *words, "-o", tmp_path / "maps.exr")
    alone = render(capsys, *words, "--mode", "direct", "-o", tmp_path / "mean.exr")
    assert "material" not in whole
    assert 0.05 < alone["material"]["rmse_rel"] < 5.0
    assert any("the maps of rock are shown as the BRDF at their mean" in text for text in alone["warnings"])
    assert np.abs(exr(tmp_path / "maps.exr") - exr(tmp_path / "mean.exr")).mean() > 1e-3


@pytest.mark.parametrize("renderer", ["gl", "cpu"])
def test_an_environment_lights_the_model_and_its_error_is_measured(
    capsys: Any, tmp_path: Path, bundle: Path, renderer: str
) -> None:
    words = ("sphere", "--material", bundle, "--brdf", "lambert", "--width", 24, "--height", 18, "--samples", 1)
    environment = ("--env", "studio", "--env-rotation-deg", 30, "--directions", 8, "--measure-error")
    result = render(capsys, *words, *environment, "--renderer", renderer, "-o", tmp_path / "a.exr")
    assert result["directions"] == 8
    assert result["environment"] == "studio"
    assert 0.001 < result["error_rmse_rel"] < 0.5
    assert (result["error_reference_width_texels"], result["error_reference_height_texels"]) == (128, 64)
    assert result["mean_radiance"] > 0.01


def test_an_environment_s_repairs_are_warnings(capsys: Any, tmp_path: Path, shared_data: Any) -> None:
    path = shared_data("hdr/pmndrs_cc0/studio.exr")
    result = render(capsys, "plane", "--env", path, *SMALL, "-o", tmp_path / "a.exr")
    assert "798 texels are negative" in result["warnings"][0]


def test_the_same_camera_frames_alike_in_every_mode(capsys: Any, tmp_path: Path, bundle: Path) -> None:
    camera = ("--camera", "eye=1,2,4 target=0.1,0,0 fov_deg=30")
    covered = []
    for mode in ("direct", "shading-map"):
        path = tmp_path / f"{mode}.exr"
        words = ("torus-knot", "--material", bundle, "--mode", mode, "-o", path, *SMALL, *camera)
        covered.append(render(capsys, *words)["covered_fraction"])
    assert covered[0] == covered[1]


def test_GL5_without_opengl_the_cpu_draws_and_says_so(
    capsys: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing() -> None:
        raise MissingCapability("OpenGL 3.3 is not available (no EGL)", "Install a driver")

    monkeypatch.setattr("engine.gl.context.create_context", missing)
    result = render(capsys, "plane", "-o", tmp_path / "a.exr", *HEAD_ON, *SMALL)
    assert "CPU" in result["gl_renderer"]
    assert "Install a driver" in result["warnings"][0]
    assert "Install" in render(capsys, "plane", "-o", tmp_path / "b.exr", *HEAD_ON, "--renderer", "gl", code=5)
    assert not (tmp_path / "b.exr").exists()


@pytest.mark.parametrize(
    "words",
    [
        ("--brdf", "velvet"),
        ("--brdf", "phong:exponent=-3"),
        ("--camera", "eye=1,2"),
        ("--camera", "eye=0,0,0 target=0,0,0"),
        ("--width", "0"),
        ("--width", "100000", "--height", "100000"),
        ("--samples", "0"),
        ("--tile", "0"),
        ("--intensity", "nan"),
        ("--exposure", "nan"),
        ("--mode", "shading-map"),
        ("--measure-error",),
        ("--env", "studio", "--directions", "0"),
        ("--env", "studio", "--env-rotation-deg", "inf"),
        ("--mode", "reference", "--samples", "0"),
        ("--mode", "reference", "--max-depth", "0"),
        ("--mode", "reference", "--seed", "-1"),
        ("--mode", "direct", "--max-depth", "2"),
    ],
)
def test_wrong_words_are_usage_errors(capsys: Any, tmp_path: Path, words: tuple[str, ...]) -> None:
    render(capsys, "plane", "-o", tmp_path / "x.png", *words, code=2)
    assert not list(tmp_path.iterdir())


def test_the_reference_states_its_noise_and_keeps_that_of_each_pixel(capsys: Any, tmp_path: Path) -> None:
    path, words = tmp_path / "reference.exr", ("torus-knot", "--mode", "reference", "--env", "sky", "--ground", *SMALL)
    result = render(capsys, *words, "--samples", "16", "--max-depth", "2", "--seed", "7", "-o", path)
    assert (result["samples"], result["max_depth"], result["passes"], result["rejected_samples"]) == (16, 2, 16, 0)
    assert result["noise"] == result["uncertainty_rmse_rel"] > 0.0
    assert result["rays"] > 64 * 48 * 16
    assert result["rays_per_s"] > 0.0
    layers = OpenEXR.File(str(path)).channels()
    pixels, deviation = (np.asarray(layers[name].pixels, np.float64) for name in ("RGB", "standard_error"))
    assert layers["RGB"].pixels.dtype == np.float32
    assert np.sqrt(np.sum(deviation**2) / np.sum(pixels**2)) == pytest.approx(result["noise"], rel=1e-5)
    np.testing.assert_array_equal(read_image(path).pixels[..., :3], layers["RGB"].pixels)
    again = tmp_path / "again.exr"
    render(capsys, *words, "--samples", "16", "--max-depth", "2", "--seed", "7", "-o", again)
    np.testing.assert_array_equal(exr(again), pixels)


def test_a_reference_that_does_not_fit_in_memory_is_refused(
    capsys: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    free = type("Memory", (), {"available": 10**9, "total": 2 * 10**9})
    words = ("plane", "--mode", "reference", "--width", 3000, "--height", 2000, "-o", tmp_path / "a.png")
    monkeypatch.setattr("psutil.virtual_memory", lambda: free)
    assert "1.44 GB" in render(capsys, *words, code=2)


def test_one_sample_has_no_known_noise(capsys: Any, tmp_path: Path) -> None:
    result = render(capsys, "plane", "-o", tmp_path / "a.png", *HEAD_ON, *SMALL, "--mode", "reference", "--samples", 1)
    assert result["noise"] is None


def test_rough_metal_keeps_its_light_unless_one_reflection_is_asked_for(capsys: Any, tmp_path: Path) -> None:
    """White metal of roughness 1 loses 69 % of the light from above where it is seen from above."""
    textures = tmp_path / "metal"
    textures.mkdir()
    for name in ("base_color", "roughness", "metallic"):
        (textures / f"metal_{name}.png").write_bytes(encode_png(np.full((4, 4, 3), 255, np.uint8)))
    even = tmp_path / "even.exr"
    images: list[Path] = []
    even.write_bytes(encode_exr(dict.fromkeys("RGB", np.ones((8, 16), np.float32))))
    words = (
        "plane",
        "--material",
        textures,
        "--env",
        even,
        "--directions",
        1024,
        "--camera",
        "eye=0,0,2 fov_deg=10",
        *SMALL,
    )
    for more in ((), ("--single-scattering",)):
        images.append(tmp_path / f"{len(images)}.exr")
        render(capsys, *words, *more, "-o", images[-1])
    whole, single = (exr(path).mean() for path in images)
    assert whole == pytest.approx(0.995, abs=0.02)
    assert single == pytest.approx(0.31, abs=0.02)
    said = render(capsys, "plane", "--single-scattering", "-o", tmp_path / "x.exr", *SMALL, code=2)
    assert "--single-scattering needs a material of PBR maps" in said
    coated = tmp_path / "coated.mtlx"
    coat = '<input name="coat_weight" type="float" value="1"/>'
    surface = f'<open_pbr_surface name="s" type="surfaceshader">{coat}</open_pbr_surface>'
    coated.write_text(f'<materialx version="1.39">{surface}</materialx>')
    asked = ("plane", "--material", coated, "--single-scattering")
    said = render(capsys, *asked, "-o", tmp_path / "x.exr", *SMALL, code=2)
    assert "OpenPBR always scatters again" in said


def test_the_reference_shows_the_material(capsys: Any, tmp_path: Path, bundle: Path) -> None:
    both = [tmp_path / "direct.exr", tmp_path / "reference.exr"]
    words = ("plane", "--material", bundle, "--tile", "0.2", *HEAD_ON, *SMALL)
    render(capsys, *words, "--renderer", "cpu", "--samples", 4, "-o", both[0])
    render(capsys, *words, "--mode", "reference", "-o", both[1])
    one, other = (exr(path).mean(axis=(0, 1)) for path in both)
    np.testing.assert_allclose(one, other, rtol=2e-3)
    assert "at once" in render(
        capsys, *words, "--mode", "reference", "--lookup", "outgoing", "-o", tmp_path / "x.exr", code=2
    )


def test_an_unknown_kind_of_image_is_a_usage_error(capsys: Any, tmp_path: Path) -> None:
    assert ".png or .exr" in render(capsys, "plane", "-o", tmp_path / "x.jpg", code=2)


@pytest.mark.parametrize(
    "words",
    [
        ("nothing.obj",),
        ("teapot",),
        ("plane", "--material", "nothing.lightarc"),
        ("plane", "--env", "nothing.hdr"),
        ("plane", "--brdf", "nothing.binary"),
    ],
)
def test_missing_files_are_input_errors(capsys: Any, tmp_path: Path, words: tuple[str, ...]) -> None:
    said = render(capsys, *words, "-o", tmp_path / "x.png", code=3)
    assert words[-1] in said
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_not_there_is_made(capsys: Any, tmp_path: Path) -> None:
    render(capsys, "plane", "-o", tmp_path / "no" / "where" / "x.png", *SMALL)
    assert (tmp_path / "no" / "where" / "x.png").is_file()
    render(capsys, tmp_path / "absent.obj", "-o", tmp_path / "nowhere" / "x.png", *SMALL, code=3)
    assert not (tmp_path / "nowhere").exists()


def test_a_turntable_is_a_film_or_a_folder_and_its_first_frame_is_the_image(capsys: Any, tmp_path: Path) -> None:
    words = ("blob", "--brdf", "lambert:albedo=0.7", *SMALL, "--renderer", "cpu", "--samples", 1)
    result = render(capsys, *words, "--turntable", 3, "--turns", "light", "-o", tmp_path / "turn")
    assert (result["frames"], result["turns"]) == (3, "light")
    render(capsys, *words, "-o", tmp_path / "one.png")
    images = [read_image(tmp_path / "turn" / f"frame-{at:05}.png").pixels for at in range(3)]
    assert np.array_equal(images[0], read_image(tmp_path / "one.png").pixels)
    assert not np.array_equal(images[1], images[0])
    render(capsys, *words, "--turntable", 3, "-o", tmp_path / "turn.webp", "--background", "transparent")
    assert (tmp_path / "turn.webp").read_bytes()[8:12] == b"WEBP"
    said = render(capsys, *words, "--turntable", 3, "-o", tmp_path / "a.mp4", "--background", "transparent", code=2)
    assert "no transparency" in said
    assert "outside 2" in render(capsys, *words, "--turntable", 1, "-o", tmp_path / "a.mp4", code=2)


def test_the_background_is_the_environment_or_nothing(capsys: Any, tmp_path: Path) -> None:
    words = ("sphere", "--env", "sky", *SMALL, "--renderer", "cpu", "--samples", 1, "--directions", 4)
    for background in ("plain", "environment", "transparent"):
        render(capsys, *words, "--background", background, "-o", tmp_path / f"{background}.exr")
    plain, sky = exr(tmp_path / "plain.exr"), exr(tmp_path / "environment.exr")
    assert (plain[0, 0] == 0.0).all()
    assert (sky[0, 0] > 0.0).all()
    assert np.allclose(plain[24, 32], sky[24, 32])
    channels = OpenEXR.File(str(tmp_path / "transparent.exr")).channels()
    opacity = channels["RGBA"].pixels[..., 3] if "RGBA" in channels else channels["A"].pixels
    assert (float(opacity[0, 0]), float(opacity[24, 32])) == (0.0, 1.0)
    said = render(capsys, "sphere", *SMALL, "--background", "environment", "-o", tmp_path / "a.png", code=2)
    assert "--background environment needs --env" in said


def test_texels_that_a_bake_makes_brighter_than_without_shadows_are_doubted() -> None:
    image = np.ones((4, 4, 4), np.float32)
    assert doubts_of_texels(1.09 * image, image) == doubts_of_texels(0.2 * image, image) == []
    (said,) = doubts_of_texels(2.4 * image, image)
    assert said.startswith("the texels are 140 % brighter in the light of this bake than without its shadows")

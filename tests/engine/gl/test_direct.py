"""Images drawn by the GPU: predicted pixels, agreement with the CPU, limits, leaks, damage."""

from __future__ import annotations

import contextlib
import dataclasses
import itertools
import logging
from typing import Any

import cv2
import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.colour import OPERATORS
from engine.core.steps import drain
from engine.geometry.brushing import parse_brushing
from engine.geometry.camera import Camera
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import shape
from engine.gl import program as program_module
from engine.gl.context import Limits, create_context
from engine.gl.direct import DirectRenderer
from engine.gl.draw import draw_off_screen
from engine.gl.program import ShaderError
from engine.gl.screen import Image, Layer, Screen
from engine.light.environment_file import open_environment
from engine.light.near_lamps import near_lamp_from_text
from engine.render.direct import radiance
from engine.render.display import Display
from engine.render.display import display as display_image
from engine.scene.material import Material, auto_sigma
from engine.scene.scene import LOOKUPS, Scene
from tests.engine.gl_objects import living_objects
from tests.engine.scenes import head_on, scene, weave

SIZE = (120, 90)


def draw(gl: Any, what: Scene, size: tuple[int, int] = SIZE, samples: int = 1, **options: Any) -> np.ndarray:
    renderer = DirectRenderer(gl, **options)
    image = renderer.radiance(what, size, samples=samples)
    renderer.release()
    return image


def close(actual: np.ndarray, expected: Any, relative: float) -> None:
    np.testing.assert_allclose(actual, np.broadcast_to(expected, actual.shape), rtol=relative, atol=1e-7)


def show(gl: Any, what: Scene, display: Display, size: tuple[int, int] = SIZE, samples: int = 1) -> np.ndarray:
    """The tone-mapped image as a window gets it, row 0 on top."""
    renderer = DirectRenderer(gl)
    framebuffer = gl.simple_framebuffer(size, 3)
    renderer.draw(what, framebuffer, size, samples=samples, display=display)
    pixels = np.frombuffer(framebuffer.read(alignment=1), np.uint8).reshape(size[1], size[0], 3)[::-1]
    renderer.release()
    return pixels


def test_head_on_plane_has_the_predicted_radiance(gl: Any) -> None:
    image = draw(gl, head_on(brdf="lambert:albedo=0.5/0.25/1", irradiance=2.0), samples=2)
    close(image[..., :3], [1 / np.pi, 0.5 / np.pi, 2 / np.pi], 1e-6)
    assert (image[..., 3] == 1.0).all()


def test_light_at_60_degrees_halves_the_radiance_and_from_behind_is_dark(gl: Any) -> None:
    tilted = dataclasses.replace(head_on(), light=(np.sqrt(3) / 2, 0.0, 0.5))
    close(draw(gl, tilted)[..., 0], 0.25 / np.pi, 1e-5)
    behind = dataclasses.replace(head_on(), light=(0.0, 0.0, -1.0))
    assert draw(gl, behind)[..., :3].max() == 0.0


def test_S9_overhead_light_shows_the_brightest_slice_exactly(gl: Any) -> None:
    """Lambert with automatic sigma: r = r_max at every pixel; one texel covers one pixel, so the slice itself shows."""
    material = weave(64)
    camera = Camera((0.0, 0.0, 4.0), fov_deg=float(np.degrees(2 * np.arctan(1 / 4))))
    what = dataclasses.replace(head_on(material, repeats=1.0), camera=camera)
    image = draw(gl, what, (64, 64))
    assert material.shading_map is not None
    close(image[..., :3], material.shading_map.slices[-1], 2e-5)


@pytest.mark.parametrize("slices", [2, 3, 8, 17])
def test_S9_every_slice_is_hit_exactly(gl: Any, slices: int) -> None:
    """A stack of constant slices with values that no mixture reaches: r = i r_max / (S − 1) shows value i."""
    flat = np.random.default_rng(0).uniform(0.2, 1.0, (slices, 1, 1, 3)) * np.ones((1, 4, 4, 1))
    material = weave(4, slices)
    assert material.shading_map is not None
    shading = dataclasses.replace(material.shading_map, slices=flat.astype("f4"), r_max=1.0)
    for index in range(slices):
        share = index / (slices - 1)
        what = head_on(Material(shading, None, sigma=share * np.pi), brdf="lambert:albedo=1")
        close(draw(gl, what, (4, 4))[0, 0, :3], flat[index, 0, 0], 2e-6)


@pytest.mark.parametrize("above", ["clamp", "scale"])
def test_S8_above_the_brightest_photograph(gl: Any, above: str) -> None:
    material = weave(8)
    assert material.shading_map is not None
    brightest = draw(gl, head_on(material))
    sigma = 3.0 * auto_sigma(brdf_from_text("lambert"), (np.pi / 2,), material.shading_map.r_max)
    beyond = draw(gl, head_on(dataclasses.replace(material, sigma=sigma), above=above))
    close(beyond[..., :3], brightest[..., :3] * (3.0 if above == "scale" else 1.0), 1e-5)


def test_lookups_of_figure_6_differ_as_the_formulas_say(gl: Any) -> None:
    material = weave(8)
    tilted = dataclasses.replace(head_on(material, irradiance=0.5), light=(0.0, 0.8, 0.6))
    images = {lookup: draw(gl, dataclasses.replace(tilted, lookup=lookup))[..., :3] for lookup in LOOKUPS}
    close(images["angle"], images["radiance"], 1e-5)
    brightest = draw(gl, head_on(material))[..., :3]
    close(images["texture"], brightest * 0.6 * 0.5, 1e-5)
    dimmer = dataclasses.replace(tilted, irradiance=1.0, light=(0.0, np.sqrt(1 - 0.09), 0.3))
    close(images["outgoing"], draw(gl, dimmer)[..., :3], 1e-4)


def test_X9_GL2_power_law_is_guarded(gl: Any) -> None:
    """Exponents 0, huge and share 0, tiny: pow(0, 0) and pow(0, K) are black, nothing is NaN, as on the CPU."""
    material = weave(8)
    assert material.power_law is not None
    exponent = np.zeros((8, 8, 3), np.float32)
    exponent[::2] = 64.0
    law = dataclasses.replace(material.power_law, exponent=exponent)
    for share in (0.0, -0.0, 1e-30, 0.01, 0.5, 1.0, 2.0):
        what = head_on(
            Material(None, law, sigma=float(share * np.pi * law.r_max)), brdf="lambert:albedo=1", repeats=1.0
        )
        gpu = draw(gl, what, (16, 16))
        cpu = drain(radiance(what, (16, 16), samples=1))
        assert np.isfinite(gpu).all()
        assert np.abs(gpu - cpu).max() <= 2 / 255
        if share <= 0.0:
            assert gpu[..., :3].max() == 0.0


@pytest.mark.parametrize(
    ("brdf", "source"),
    [
        ("lambert", None),
        ("metallic-roughness:roughness=0.2,metallic=0.5,multiple_scattering=1", None),
        ("ggx:alpha=0.1", None),
        ("ggx:alpha_x=0.1,alpha_y=0.4", None),
        ("oren-nayar", None),
        ("lambert", "slices"),
        ("lambert", "power-law"),
    ],
)
def test_gpu_and_cpu_show_lights_near_the_model_alike(gl: Any, brdf: str, source: str | None) -> None:
    """A rectangle, a disc, a sphere and a point, on the model and the ground, and look-ups for each point of them."""
    texts = (
        "shape=rectangle,x=-0.5,y=1.4,z=0.8,facing_theta_deg=150,facing_phi_deg=148,rotation_deg=20,width=1.2,power=9",
        "shape=disc,x=0.7,y=1.2,z=0.9,facing_theta_deg=130,facing_phi_deg=-142,radius=0.4,power=9,colour=1:0.5:0.2",
        "x=0.9,y=-0.2,z=1.2,radius=0.3,power=9",
        "shape=disc,x=-1.2,z=1,facing_theta_deg=90,facing_phi_deg=120,power=2",
    )
    what = dataclasses.replace(
        scene("sphere", weave() if source else None, source=source or "slices"),
        brdf=brdf_from_text(brdf),
        near_lamps=tuple(near_lamp_from_text(text) for text in texts),
        ground=Ground(albedo=0.6),
        irradiance=0.2,
        directions=16,
    )
    for lookup in ("radiance", "texture") if source else ("radiance",):
        seen = dataclasses.replace(what, lookup=lookup)
        gpu = draw(gl, seen, (48, 36), debug=True)
        cpu = drain(radiance(seen, (48, 36), samples=1))
        assert gpu[..., 3].max() == 1.0, "a sample is not finite"
        alike = gpu[..., 3] == cpu[..., 3]
        assert alike.mean() > 0.99
        error = (gpu - cpu)[alike]
        assert np.linalg.norm(error) < 2e-3 * np.linalg.norm(cpu[alike]), brdf


@pytest.mark.parametrize("model", ["sphere", "torus-knot", "cloth"])
@pytest.mark.parametrize("source", [None, "slices", "power-law"])
def test_GL8_gpu_and_cpu_show_the_same(gl: Any, model: str, source: str | None) -> None:
    what = scene(model, weave() if source else None, source=source or "slices", above="scale")
    gpu, cpu = draw(gl, what, samples=2), drain(radiance(what, SIZE, samples=2))
    a, b = display_image(gpu, Display()), display_image(cpu, Display())
    difference = colour_difference(a, b)
    assert difference.mean() <= 0.5
    # the GPU places edges on a grid of 1/256 pixel, so now and then one sub-pixel falls on the other side of an edge
    on_edge = (gpu[..., 3] != cpu[..., 3]) | (np.abs(a.astype(int) - b).max(axis=-1) > 1)
    assert np.mean(on_edge) <= 1e-3
    assert difference[~on_edge].max() <= 2.0


@pytest.mark.parametrize("lookup", LOOKUPS)
def test_GL8_every_lookup_agrees_with_the_cpu(gl: Any, lookup: str) -> None:
    what = scene("sphere", weave(48), lookup=lookup, brdf="ggx:alpha=0.3", irradiance=0.7)
    gpu, cpu = draw(gl, what), drain(radiance(what, SIZE, samples=1))
    assert np.abs(display_image(gpu, Display()).astype(int) - display_image(cpu, Display())).max() <= 1


def colour_difference(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """CIE 1976 ΔE of two sRGB images."""
    lab = [cv2.cvtColor(image.astype(np.float32) / 255, cv2.COLOR_RGB2LAB) for image in (a, b)]
    return np.linalg.norm(lab[0] - lab[1], axis=-1)


@pytest.mark.parametrize("operator", OPERATORS)
@pytest.mark.parametrize("exposure_ev", [-3.0, 0.0, 6.0])
@pytest.mark.parametrize("samples", [1, 2])
def test_tone_mapping_in_the_window_is_the_engine_s(gl: Any, operator: Any, exposure_ev: float, samples: int) -> None:
    what = scene("sphere", brdf="phong:kd=0.5/0.1/0.02,ks=0.9,exponent=50")
    display = Display(exposure_ev, operator, (0.1, 0.2, 0.05))
    expected = display_image(draw(gl, what, samples=samples), display)
    assert np.abs(show(gl, what, display, samples=samples).astype(int) - expected).max() <= 1


@pytest.mark.parametrize("debug", [True, False])
@pytest.mark.parametrize("broken", ["position", "normal", "light"])
def test_GL1_what_is_not_finite_is_magenta_and_counted_or_black(gl: Any, debug: bool, broken: str) -> None:
    what = head_on()
    if broken == "light":
        object.__setattr__(what, "light", (float("nan"), 0.0, 1.0))
    else:
        plane = what.mesh
        normals = np.full_like(plane.normals, np.nan) if broken == "normal" else plane.normals
        positions = (
            np.where(np.arange(4)[:, None] == 3, np.nan, plane.positions) if broken == "position" else plane.positions
        )
        mesh = Mesh(positions, normals, plane.uv, plane.faces, "broken")
        mesh.__dict__.update(centre=np.zeros(3), radius=1.5)
        what = dataclasses.replace(what, mesh=mesh)
    renderer = DirectRenderer(gl, debug=debug)
    image = renderer.radiance(what, SIZE, samples=1)
    count = renderer.invalid_samples
    renderer.release()
    assert np.isfinite(image).all()
    if broken == "light":
        assert count == (SIZE[0] * SIZE[1] if debug else 0)
        assert image[5, 5, :3].tolist() == ([1.0, 0.0, 1.0] if debug else [0.0, 0.0, 0.0])


def test_GL3_missing_normals_are_taken_from_the_triangle(gl: Any) -> None:
    plane = shape("plane")
    bare = Mesh(plane.positions, np.zeros_like(plane.normals), plane.uv, plane.faces, "bare")
    what = head_on()
    close(draw(gl, dataclasses.replace(what, mesh=bare)), draw(gl, what), 1e-5)


@pytest.mark.parametrize(("limit", "reduced"), [(63, True), (64, False), (65, False)])
def test_GL4_textures_above_the_limit_are_reduced_with_a_message(gl: Any, limit: int, reduced: bool) -> None:
    material = weave(64)
    limits = Limits(limit, 2048)
    for source in ("slices", "power-law"):
        renderer = DirectRenderer(gl, texture_limits=limits)
        image = renderer.radiance(head_on(material, source=source, repeats=1.0), (32, 24), samples=1)
        assert image[..., :3].max() > 0.1
        assert [("63" in message and "64" in message) for message in renderer.messages] == [True] * reduced
        renderer.release()


@pytest.mark.parametrize(("limit", "reduced"), [(16, True), (17, False), (18, False)])
def test_GL4_layers_above_the_limit_are_reduced_with_a_message(gl: Any, limit: int, reduced: bool) -> None:
    material = weave(16, slices=17)
    renderer = DirectRenderer(gl, texture_limits=Limits(4096, limit))
    what = head_on(material)
    image = renderer.radiance(what, (32, 24), samples=1)
    assert len(renderer.messages) == int(reduced)
    renderer.release()
    close(image, draw(gl, what, (32, 24)), 1e-5)


def test_GL6_a_new_context_draws_the_same_bits() -> None:
    what = scene("torus-knot", weave())
    images = []
    for _ in range(2):
        context = create_context()
        with context:
            images.append(draw(context, what))
        context.release()
    assert np.array_equal(images[0], images[1])


def test_GL6_a_released_renderer_uploads_anew(gl: Any) -> None:
    what, renderer = scene("cloth", weave()), DirectRenderer(gl)
    before = renderer.radiance(what, SIZE, samples=1)
    renderer.release()
    assert np.array_equal(renderer.radiance(what, SIZE, samples=1), before)
    renderer.release()


@pytest.mark.parametrize("size", [(0, 0), (0, 5), (1, 1), (1, 300), (2049, 3), (16384, 2)])
def test_GL7_images_of_any_size(gl: Any, size: tuple[int, int]) -> None:
    image = draw(gl, head_on(), size)
    assert image.shape == (size[1], size[0], 4)
    if min(size):
        close(image[size[1] // 2, size[0] // 2, :3], 0.5 / np.pi, 1e-5)


def test_GL7_a_large_image_is_drawn_in_tiles_of_bounded_size(gl: Any) -> None:
    what = dataclasses.replace(head_on(), camera=Camera((0.0, 0.0, 2.0), fov_deg=5.0))
    renderer = DirectRenderer(gl)
    corners, size = 0, (16384, 2100)
    for (left, top, width, height), texture in renderer._tiles.each(renderer._painting(what, size), size, 1):
        assert max(texture.size) <= 2048
        if {left, left + width} & {0, 16384} and {top, top + height} & {0, 2100}:
            texel = np.frombuffer(texture.read(), np.float32)[:3]
            close(texel, 0.5 / np.pi, 1e-4)
            corners += 1
    renderer.release()
    assert corners == 4


@pytest.mark.parametrize("samples", [1, 2, 3])
def test_tiles_fit_together(gl: Any, monkeypatch: pytest.MonkeyPatch, samples: int) -> None:
    what = scene("sphere", brdf="lambert")
    whole = draw(gl, what, samples=samples)
    monkeypatch.setattr("engine.gl.tiles.TILE", 64)
    tiled = draw(gl, what, samples=samples)
    inside = (whole[..., 3] == 1) & (tiled[..., 3] == 1)
    assert inside.mean() > 0.3
    assert np.abs(tiled[inside] - whole[inside]).max() <= 2e-4
    assert np.mean(whole[..., 3] != tiled[..., 3]) < 0.01
    assert np.array_equal(show(gl, what, Display(), samples=samples)[45, 60], display_image(tiled, Display())[45, 60])


@pytest.mark.parametrize(
    ("lookup", "samples"),
    [
        pytest.param(lookup, samples, marks=[] if (number + samples) % 2 else [pytest.mark.long])
        for number, lookup in enumerate(LOOKUPS)
        for samples in (1, 2)
    ],
)
def test_a_image_in_bands_is_the_image_to_the_bit(
    gl: Any, monkeypatch: pytest.MonkeyPatch, lookup: str, samples: int
) -> None:
    """Bands of all heights, several tiles, and another size of target in between."""
    monkeypatch.setattr("engine.gl.tiles.TILE", 128)
    what = scene("torus-knot", weave(), lookup=lookup, environment=open_environment("studio"), directions=16)
    expected = show(gl, what, Display(), samples=samples)
    renderer, image = DirectRenderer(gl), Image(gl, SIZE)
    renderer.radiance(what, (7, 5), samples=1)
    rows = itertools.cycle((1, 2, 3, 7, 50, 1000))
    bands = renderer.bands(what, image.framebuffer, SIZE, samples=samples)
    next(bands)
    count = 0
    with contextlib.suppress(StopIteration):
        while True:
            bands.send(next(rows))
            gl.detect_framebuffer(0).use()
            count += 1
    framebuffer = gl.simple_framebuffer(SIZE, 3)
    Screen(gl).show(Layer(image), framebuffer, Display())
    pixels = np.frombuffer(framebuffer.read(alignment=1), np.uint8).reshape(SIZE[1], SIZE[0], 3)[::-1]
    linear = image.read()
    assert np.array_equal(linear, np.concatenate([image.read(0, 40), image.read(40, 999)]))
    np.testing.assert_allclose(linear, renderer.radiance(what, SIZE, samples=samples), rtol=1e-6, atol=1e-7)
    renderer.release()
    assert count >= 5
    assert np.array_equal(pixels, expected)


def test_GL9_a_thousand_materials_leave_no_object_behind(gl: Any) -> None:
    materials = [weave(4), dataclasses.replace(weave(4), shading_map=None), None]
    renderer = DirectRenderer(gl)
    scenes = [head_on(material, brdf=brdf) for material in materials for brdf in ("lambert", "phong", "ggx")]
    for what in scenes:
        renderer.radiance(what, (4, 4), samples=1)
    before = living_objects()
    assert before["Texture"] >= 1
    for index in range(1000):
        renderer.radiance(scenes[index % len(scenes)], (4 + index % 3, 4), samples=1)
    renderer.radiance(scenes[-1], (4, 4), samples=1)
    assert living_objects() == before
    renderer.release()
    left = living_objects()
    assert left.pop("Program") <= 1, "the one in use goes when another is used"
    assert left.pop("Shader") <= 2
    assert set(left.values()) == {0}


def test_GL10_a_broken_shader_names_file_and_line(gl: Any, shader: Any) -> None:
    folder = shader("brdf/lambert.glsl", "\n\nvec3 brdf(vec3 wi, vec3 wo)\n{\n    return wi + nonsense;\n}\n")
    with pytest.raises(ShaderError, match=r"brdf/lambert\.glsl:5"):
        program_module.load_program(
            gl, "direct.vert", "direct.frag", {"BRDF": "brdf/lambert.glsl", "SOURCE_NONE": "1"}, folder=folder
        )


def test_GL10_the_last_good_program_goes_on(gl: Any, monkeypatch: Any, caplog: pytest.LogCaptureFixture) -> None:
    renderer = DirectRenderer(gl)
    good = renderer.radiance(head_on(), SIZE, samples=1)

    def find_broken(*_: Any, **__: Any) -> Any:
        raise ShaderError("brdf/phong.glsl:7: error: it does not compile")

    monkeypatch.setattr("engine.gl.direct.load_program", find_broken)
    with caplog.at_level(logging.ERROR):
        assert np.array_equal(renderer.radiance(head_on(brdf="phong"), SIZE, samples=1), good)
    assert "brdf/phong.glsl:7" in caplog.text
    renderer.release()


def test_a_mesh_far_from_its_origin_is_drawn_alike(gl: Any) -> None:
    sphere = shape("sphere")
    far = Mesh(sphere.positions + 1e5, sphere.normals, sphere.uv, sphere.faces, "far")
    near = scene("sphere", brdf="lambert")
    eye, target = (tuple(np.add(v, 1e5)) for v in (near.camera.eye, near.camera.target))
    moved = dataclasses.replace(near, mesh=far, camera=dataclasses.replace(near.camera, eye=eye, target=target))
    assert np.abs(draw(gl, moved) - draw(gl, near)).max() <= 1e-4


def test_off_screen_drawing_reports_time_and_device(gl: Any) -> None:
    image, frame_s, name, messages = draw_off_screen(gl, head_on(), SIZE, 1)
    assert image.shape == (90, 120, 4)
    assert frame_s > 0.0
    assert name
    assert messages == []


@pytest.mark.parametrize("brushing", ["y", "1,2,0", "u:35", "x:70"])
def test_a_brushed_surface_is_that_of_the_cpu(gl: Any, brushing: str) -> None:
    what = scene("torus-knot", brdf="ggx:alpha_x=0.1,alpha_y=0.5,kd=0.1,f0=0.9")
    what = dataclasses.replace(what, mesh=what.mesh.brush(parse_brushing(brushing)))
    image, expected = draw(gl, what), drain(radiance(what, SIZE, samples=1))
    inside = (image[..., 3] == 1.0) & (expected[..., 3] == 1.0)
    error = np.abs(image[inside] - expected[inside])
    assert np.quantile(error, 0.995) < 2e-3 * expected[inside].max()
    plain = draw(gl, dataclasses.replace(what, mesh=shape("torus-knot")))
    assert np.abs(plain - image)[inside].mean() > 10.0 * error.mean()

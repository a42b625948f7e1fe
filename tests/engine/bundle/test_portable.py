"""The exported shader and the page show the numbers that the engine computes."""

from __future__ import annotations

import base64
import dataclasses
import json
import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from engine.brdf.brdf import MODELS, brdf_from_text
from engine.bundle.portable import VIEWER_SIDE, brdf_json, resolved_sigma, shader, viewer
from engine.core.colour import luminance, srgb_encode
from engine.core.directions import surface_direction
from engine.core.errors import MissingCapability
from engine.core.health import Health
from engine.scene.material import Material
from engine.shading.directional.effective_light import effective_cosine
from engine.shading.kept_tiles import cut_tiles
from engine.shading.power_law import PowerLawMap, Storage
from tests.engine.domes import dome_material

SCALE, EXPONENT, R_MAX = (0.8, 0.4, 0.2), (0.5, 1.0, 2.5), 0.6


def make_material(height: int = 8, width: int = 8, **changes: Any) -> Material:
    law = PowerLawMap(
        scale=np.full((height, width, 3), SCALE, np.float32),
        exponent=np.full((height, width, 3), EXPONENT, np.float32),
        r_max=R_MAX,
        rms=0.01,
        rms_per_channel=np.full(3, 0.01),
        error_map=np.zeros((height, width), np.float32),
    )
    return dataclasses.replace(Material(None, law, elevation_deg=(10.0, 40.0, 70.0), name="woven"), **changes)


def expected_radiance(material: Material, wi: Any, wo: Any) -> Any:
    r = resolved_sigma(material) * luminance(brdf_from_text(material.brdf).f(wi, wo)) * np.maximum(wi[..., 2], 0)
    return np.array(SCALE) * np.minimum(r / R_MAX, 1.0)[..., None] ** np.array(EXPONENT)


def page_data(page: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    assert found
    value: dict[str, Any] = json.loads(found[1])
    return value


def rgb(png: bytes) -> Any:
    picture: Any = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_UNCHANGED)
    return picture[..., ::-1]


def decoded(coded: dict[str, Any]) -> Any:
    """A map of the page back as floats."""
    high, low = (rgb(base64.b64decode(coded[plane])) for plane in ("high", "low"))
    return (high.astype(np.float64) * 256 + low) / 65535 * coded["largest"]


def test_brdf_json_says_what_the_engine_uses() -> None:
    value = json.loads(brdf_json(make_material(brdf="ggx:alpha=0.25")))
    assert (value["model"], value["parameters"]["alpha"], value["sigma_is_automatic"]) == ("ggx", 0.25, True)
    assert value["sigma"] == resolved_sigma(make_material(brdf="ggx:alpha=0.25"))
    assert json.loads(brdf_json(make_material(sigma=2.5)))["sigma"] == 2.5


HIGH = "".join(f"precision highp {kind};\n" for kind in ("float", "sampler2D", "sampler2DArray"))
HEADERS = {"desktop": "#version 330 core\n", "web": f"#version 300 es\n{HIGH}"}


def evaluate(context: Any, source: str, header: str, wi: Any, wo: Any) -> Any:
    """lightarc_radiance for each pair of directions, on the GPU."""
    program = context.program(
        vertex_shader=f"{header.splitlines()[0]}\nin vec2 at; void main() {{ gl_Position = vec4(at, 0, 1); }}",
        fragment_shader=f"""{header}{source}
        uniform sampler2D wi, wo;
        uniform vec3 scale, exponent;
        out vec4 result;
        void main() {{
            ivec2 at = ivec2(gl_FragCoord.xy);
            vec3 towards_light = texelFetch(wi, at, 0).xyz, towards_eye = texelFetch(wo, at, 0).xyz;
            result = vec4(lightarc_radiance(towards_light, towards_eye, scale, exponent), 1.0);
        }}""",
    )
    for unit, (name, directions) in enumerate({"wi": wi, "wo": wo}.items()):
        context.texture((len(wi), 1), 3, directions.astype("f4").tobytes(), dtype="f4").use(unit)
        program[name].value = unit
    program["scale"].value, program["exponent"].value = SCALE, EXPONENT
    target = context.framebuffer([context.texture((len(wi), 1), 4, dtype="f4")])
    target.use()
    corners = context.buffer(np.array([-1, -1, 3, -1, -1, 3], "f4").tobytes())
    context.vertex_array(program, [(corners, "2f", "at")]).render()
    return np.frombuffer(target.read(components=4, dtype="f4"), np.float32).reshape(-1, 4)[:, :3]


@pytest.mark.parametrize("header", HEADERS.values(), ids=HEADERS)
@pytest.mark.parametrize("model", MODELS)
def test_the_exported_shader_computes_what_the_engine_does(model: str, header: str) -> None:
    from engine.gl.context import create_context

    try:
        context = create_context()
    except MissingCapability as missing:
        pytest.skip(str(missing))
    material = make_material(brdf=model)
    random = np.random.default_rng(7)
    theta, phi = random.uniform(0, 1.7, (2, 256)), random.uniform(0, 2 * np.pi, (2, 256))
    wi, wo = (surface_direction(theta[i], phi[i]).astype(np.float32).astype(np.float64) for i in (0, 1))
    with context:
        shown = evaluate(context, shader(material), header, wi, wo)
    context.release()
    assert np.isfinite(shown).all()
    np.testing.assert_allclose(shown, expected_radiance(material, wi, wo), rtol=2e-4, atol=2e-5)
    assert (shown > 0.01).any()


def test_the_exported_shader_adds_kept_tiles_to_the_power_law() -> None:
    """lightarc_mixed, on one texel of coverage 0.25 with two layers, halfway up to r_max; the exponents are codes."""
    from engine.gl.context import create_context

    try:
        context = create_context()
    except MissingCapability as missing:
        pytest.skip(str(missing))
    law = make_material().power_law
    assert law is not None
    source = shader(make_material(power_law=dataclasses.replace(law, storage=Storage(8, 16, 0.02))))
    with context:
        program = context.program(
            vertex_shader="#version 330 core\nin vec2 at; void main() { gl_Position = vec4(at, 0, 1); }",
            fragment_shader=f"""#version 330 core\n{source}
            uniform sampler2DArray kept;
            out vec4 result;
            void main() {{
                vec3 exponent = vec3(0.5) * LIGHTARC_EXPONENT_RANGE;
                result = vec4(lightarc_mixed(0.5 * LIGHTARC_R_MAX, vec3(1), exponent, kept, 2.0, vec2(0.5)), 1.0);
            }}""",
        )
        layers = np.array([[0.0, 0.0, 0.0, 0.25], [0.1, 0.2, 0.4, 0.25]], "f4")
        context.texture_array((1, 1, 2), 4, layers.tobytes(), dtype="f4").use(0)
        target = context.framebuffer([context.texture((1, 1), 4, dtype="f4")])
        target.use()
        corners = context.buffer(np.array([-1, -1, 3, -1, -1, 3], "f4").tobytes())
        context.vertex_array(program, [(corners, "2f", "at")]).render()
        shown = np.frombuffer(target.read(components=3, dtype="f4"), np.float32)
    context.release()
    np.testing.assert_allclose(shown, np.array([0.05, 0.1, 0.2]) + 0.75 * 0.5 ** (0.5 * 255 * 0.02), rtol=1e-5)


def test_the_page_says_which_tiles_it_cannot_show() -> None:
    material = make_material(16, 16)
    assert material.power_law is not None
    tiles = cut_tiles(np.ones((2, 16, 16, 3), np.float32), np.eye(2, dtype=bool), 8)
    health = Health({"rms_without_kept_tiles": 0.5})
    kept = dataclasses.replace(material.power_law, kept=tiles, health=health)
    data = page_data(viewer(dataclasses.replace(material, power_law=kept)))
    assert (data["kept_percent"], data["rms"]) == (50.0, 0.5)
    plain = page_data(viewer(material))
    assert (plain["kept_percent"], plain["rms"]) == (0.0, 0.01)


def test_names_cannot_break_out_of_the_shader_or_the_page() -> None:
    name = "</script><script>alert(1)</script>\n#error\\\n*/ \u2028 ä @DATA@ @BRDF@"
    hostile = make_material(name=name)
    code = [line for line in shader(hostile).splitlines() if not line.startswith("//")]
    assert not any("#error" in line or "alert" in line for line in code)
    page = viewer(hostile)
    assert page.count("<script") == 2
    assert page_data(page)["name"] == name


class Links(HTMLParser):
    """Collects everything a page refers to."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, _tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.found += [value or "" for name, value in attributes if name in ("src", "href", "srcset", "action")]


def test_the_page_needs_no_network() -> None:
    page = viewer(make_material())
    links = Links()
    links.feed(page)
    assert links.found == []
    assert "default-src 'none'" in page
    assert not re.search(r"https?://|\bfetch\(|XMLHttpRequest|\bimport\b|url\(", page)


def test_CO9_maps_of_the_page_are_linear_codes() -> None:
    random = np.random.default_rng(3)
    material = make_material()
    assert material.power_law is not None
    scale = random.random((8, 8, 3), dtype=np.float32) * 3
    data = page_data(
        viewer(dataclasses.replace(material, power_law=dataclasses.replace(material.power_law, scale=scale)))
    )
    half_a_code = 0.5 / 65535
    assert np.abs(decoded(data["maps"]["scale"]) - scale).max() <= half_a_code * scale.max() * (1 + 1e-9)
    assert np.abs(decoded(data["maps"]["exponent"]) - EXPONENT).max() <= half_a_code * max(EXPONENT) * (1 + 1e-6)


@pytest.mark.parametrize(
    ("size", "shown"),
    [
        ((1, 1), (1, 1)),
        ((1, 3), (1, 3)),
        ((1024, 1024), (1024, 1024)),
        ((1500, 3000), (512, 1024)),
        ((1, 5000), (1, 1024)),
    ],
)
def test_large_maps_are_averaged_down_and_the_page_says_so(size: tuple[int, int], shown: tuple[int, int]) -> None:
    data = page_data(viewer(make_material(*size)))
    assert data["size"] == [size[1], size[0]]
    for name, constant in (("scale", SCALE), ("exponent", EXPONENT)):
        values = decoded(data["maps"][name])
        assert data["maps"][name]["size"] == [shown[1], shown[0]]
        assert values.shape[:2] == shown
        assert max(values.shape[:2]) <= VIEWER_SIDE
        np.testing.assert_allclose(values, np.broadcast_to(constant, values.shape), atol=1e-4)


BROWSERS = ("chromium", "chromium-browser", "google-chrome")

BROWSER_ARGUMENTS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--hide-scrollbars",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--use-gl=angle", "--use-angle=swiftshader-webgl", "--window-size=900,600", "--virtual-time-budget=10000",
)  # fmt: skip


def browse(folder: Path, page: str, address: str, *arguments: str) -> subprocess.CompletedProcess[bytes]:
    """Open the page in a real browser; `address` is the part after #."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        pytest.skip("no Chromium is installed to open the page with")
    (folder / "index.html").write_text(page, encoding="utf-8")
    place = f"{(folder / 'index.html').as_uri()}#{address}"
    words = [browser, *BROWSER_ARGUMENTS, f"--user-data-dir={folder / 'profile'}", *arguments, place]
    return subprocess.run(words, capture_output=True, timeout=120, check=True)


def picture_of(folder: Path, page: str, address: str) -> Any:
    """The browser's window (600, 900, 3), 8-bit sRGB."""
    browse(folder, page, address, f"--screenshot={folder / 'shot.png'}")
    return rgb((folder / "shot.png").read_bytes())


#: The picture is 620 x 600; the plane reaches from -1 to 1 at 1.15 per half height, seen from a distance of 3.
CENTRE = (300, 310)


@pytest.mark.parametrize("brdf", ["phong:exponent=30", "ggx:alpha=0.3"])
def test_a_browser_shows_the_radiance_of_the_plane(tmp_path: Path, brdf: str) -> None:
    material = make_material(brdf=brdf)
    picture = picture_of(tmp_path, viewer(material), "neutral=0&azimuth=30&elevation=50")
    light = surface_direction(np.radians(40), np.radians(30))
    for row, column in (CENTRE, (200, 220), (450, 430)):
        at = np.array([(column + 0.5 - 310) / 300, (300 - row - 0.5) / 300]) * 1.15
        towards_eye = np.array([-at[0], -at[1], 3.0])
        radiance = expected_radiance(material, light, towards_eye / np.linalg.norm(towards_eye))
        np.testing.assert_allclose(picture[row, column], 255 * srgb_encode(radiance), atol=1.5)
    assert picture[30, 310].tolist() == [24, 24, 24]


def test_a_browser_shows_the_sphere(tmp_path: Path) -> None:
    material = make_material(brdf="lambert", sigma=2.0)
    picture = picture_of(tmp_path, viewer(material), "sphere=1&neutral=0&azimuth=0&elevation=45")
    straight = expected_radiance(material, surface_direction(np.radians(45), 0.0), np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(picture[CENTRE], 255 * srgb_encode(straight), atol=1.5)
    assert picture[300, 60].max() <= 1
    assert picture[300, 470].astype(int).sum() > picture[300, 200].astype(int).sum()


def test_a_browser_shows_row_0_on_top_and_every_model_compiles(tmp_path: Path) -> None:
    material = make_material(name="half dark")
    assert material.power_law is not None
    scale = material.power_law.scale.copy()
    scale[:4, :, :] = 0
    scale[:, :4, 2] = 0
    law = dataclasses.replace(material.power_law, scale=scale)
    page = viewer(dataclasses.replace(material, power_law=law))
    picture = picture_of(tmp_path, page, "neutral=0&elevation=90")
    assert picture[150, 310].max() <= 1
    assert picture[450, 200][2] <= 1 < picture[450, 420][2]
    every_model = page.replace(
        'document.documentElement.dataset.state = "ready"',
        "for (const model of data.models) { state.model = model.name; draw(); } "
        'document.documentElement.dataset.state = gl.getError() ? "wrong" : `drew ${programs.size}`',
    )
    shown = browse(tmp_path, every_model, "", "--dump-dom").stdout.decode()
    assert f'data-state="drew {len(MODELS)}"' in shown
    assert "<title>half dark</title>" in shown


def test_a_browser_without_webgl_says_so(tmp_path: Path) -> None:
    page = viewer(make_material()).replace('canvas.getContext("webgl2"', 'canvas.getContext("absent"')
    shown = browse(tmp_path, page, "", "--dump-dom").stdout.decode()
    assert 'data-state="failed: This browser offers no WebGL 2.' in shown


def picture_in_texel(directional: Any, light: Any, row: int, column: int) -> Any:
    return 255.0 * srgb_encode(np.clip(directional.picture(light)[row, column], 0.0, 1.0))


@pytest.mark.parametrize("brdf", ["lambert", "ggx:alpha=0.4"])
def test_a_browser_shows_the_planes_of_a_directional_map(tmp_path: Path, brdf: str) -> None:
    """At the middle of the page's plane, which is seen straight from above: any BRDF shows the picture of the light."""
    material = dome_material(brdf)
    directional = material.directional
    assert directional is not None
    page, shown = viewer(material), []
    for azimuth in (0, 90, 200):
        light = surface_direction(np.radians(40), np.radians(azimuth))
        picture = picture_of(tmp_path, page, f"neutral=0&azimuth={azimuth}&elevation=50")
        shown.append(picture[CENTRE].astype(int))
        # texels of the picture: 9 columns over 1.15 of the half height, 7 rows in proportion
        np.testing.assert_allclose(picture[CENTRE], picture_in_texel(directional, light, 3, 4), atol=3.0)
    assert np.abs(shown[0] - shown[2]).max() > 8


def test_a_browser_turns_light_with_the_texture_of_the_sphere(tmp_path: Path) -> None:
    material = dome_material()
    page = viewer(material)
    left, right = (
        picture_of(tmp_path, page, f"sphere=1&neutral=0&azimuth={azimuth}&elevation=30").astype(int)
        for azimuth in (0, 180)
    )
    assert np.abs(left[CENTRE] - right[CENTRE]).max() > 8


def test_every_model_compiles_with_planes(tmp_path: Path) -> None:
    every_model = viewer(dome_material()).replace(
        'document.documentElement.dataset.state = "ready"',
        "for (const model of data.models) { state.model = model.name; draw(); } "
        'document.documentElement.dataset.state = gl.getError() ? "wrong" : `drew ${programs.size}`',
    )
    shown = browse(tmp_path, every_model, "", "--dump-dom").stdout.decode()
    assert f'data-state="drew {len(MODELS)}"' in shown
    assert "Directional map of" in shown


@pytest.mark.parametrize("sigma", [None, 0.7])
@pytest.mark.parametrize("model", ["lambert", "phong", "ggx"])
@pytest.mark.parametrize("header", HEADERS.values(), ids=HEADERS)
def test_the_shader_of_a_directional_map_computes_what_the_engine_does(
    model: str, header: str, sigma: float | None
) -> None:
    from engine.gl.context import create_context

    try:
        context = create_context()
    except MissingCapability as missing:
        pytest.skip(str(missing))
    material = dataclasses.replace(dome_material(model), sigma=sigma)
    directional, brdf = material.directional, brdf_from_text(material.brdf)
    assert directional is not None
    random = np.random.default_rng(7)
    theta, phi = random.uniform(0, 1.5, (2, 64)), random.uniform(0, 2 * np.pi, (2, 64))
    wi, wo = (surface_direction(theta[i], phi[i]).astype(np.float32).astype(np.float64) for i in (0, 1))
    with context:
        planes, weights = directional.planes, np.ascontiguousarray(np.moveaxis(directional.table, 3, 0))
        program = context.program(
            vertex_shader=f"{header.splitlines()[0]}\nin vec2 at; void main() {{ gl_Position = vec4(at, 0, 1); }}",
            fragment_shader=f"""{header}{shader(material)}
            uniform sampler2D wi, wo;
            uniform sampler2DArray planes, weights;
            out vec4 result;
            void main() {{
                ivec2 at = ivec2(gl_FragCoord.xy);
                vec3 towards_light = texelFetch(wi, at, 0).xyz, towards_eye = texelFetch(wo, at, 0).xyz;
                vec2 middle = vec2(2.5 / 9.0, 4.5 / 7.0);
                result = vec4(lightarc_radiance(towards_light, towards_eye, planes, weights, middle), 1.0);
            }}""",
        )
        size = (planes.shape[2], planes.shape[1], len(planes))
        textures = {
            "wi": context.texture((len(wi), 1), 3, wi.astype("f4").tobytes(), dtype="f4"),
            "wo": context.texture((len(wo), 1), 3, wo.astype("f4").tobytes(), dtype="f4"),
            "planes": context.texture_array(size, 1, (planes / 255.0).astype("f4").tobytes(), dtype="f4"),
            "weights": context.texture_array((*weights.shape[2:0:-1], len(weights)), 3, weights.tobytes(), dtype="f4"),
        }
        for unit, (name, texture) in enumerate(textures.items()):
            texture.use(unit)
            program[name].value = unit
        textures["weights"].repeat_y = False
        target = context.framebuffer([context.texture((len(wi), 1), 4, dtype="f4")])
        target.use()
        corners = context.buffer(np.array([-1, -1, 3, -1, -1, 3], "f4").tobytes())
        context.vertex_array(program, [(corners, "2f", "at")]).render()
        shown = np.frombuffer(target.read(components=3, dtype="f4"), np.float32).reshape(-1, 3)
    context.release()
    share = resolved_sigma(material) * luminance(brdf.f(wi, wo)) * wi[:, 2] / directional.r_max
    azimuth = np.arctan2(wi[:, 1], wi[:, 0])
    cosine = effective_cosine(brdf)(share, azimuth)
    expected = directional.looked_up(planes[:, 4, 2][None], cosine, azimuth)[0]
    np.testing.assert_allclose(shown, expected, rtol=5e-3, atol=2e-3)

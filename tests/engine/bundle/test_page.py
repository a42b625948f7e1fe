"""The page shows the numbers that the engine computes, in a browser that is driven as a user would."""

from __future__ import annotations

import base64
import dataclasses
import json
import re
import tracemalloc
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from engine.brdf.brdf import MODELS
from engine.bundle.page import VIEWER_SIDE, Extras, bytes_of, make_page, viewer, viewer_and_parts
from engine.core.colour import srgb_decode, srgb_encode
from engine.core.directions import surface_direction
from engine.core.health import Health
from engine.shading.kept_tiles import cut_tiles
from engine.storage.atomic import write_bytes
from engine.storage.scratch import keep_in_memory
from engine.surface.pbr_maps import PbrMaps
from tests.chromium import SHIFT, Page, chromium
from tests.engine.bundle.materials import EXPONENT, SCALE, compute_expected_radiance, make_material
from tests.engine.domes import dome_material
from tests.engine.render.test_hex_tiling import material_of


def page_data(page: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    assert found
    value: dict[str, Any] = json.loads(found[1])
    return value


def rgb(png: bytes) -> Any:
    image: Any = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_UNCHANGED)
    return image[..., ::-1]


def decode(data: dict[str, Any], name: str) -> Any:
    """A map of the page back as floats."""
    coded = data["maps"][name]
    high, low = (rgb(base64.b64decode(data["pictures"][coded[plane]])) for plane in ("high", "low"))
    return (high.astype(np.float64) * 256 + low) / 65535 * coded["largest"]


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


def test_names_cannot_break_out_of_the_page() -> None:
    name = "</script><script>alert(1)</script>\n#error\\\n*/ \u2028 ä @DATA@ @SCRIPT@"
    page = viewer(make_material(name=name))
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
    assert np.abs(decode(data, "scale") - scale).max() <= half_a_code * scale.max() * (1 + 1e-9)
    assert np.abs(decode(data, "exponent") - EXPONENT).max() <= half_a_code * max(EXPONENT) * (1 + 1e-6)


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
        values = decode(data, name)
        assert data["maps"][name]["size"] == [shown[1], shown[0]]
        assert values.shape[:2] == shown
        assert max(values.shape[:2]) <= VIEWER_SIDE
        np.testing.assert_allclose(values, np.broadcast_to(constant, values.shape), atol=1e-4)


@pytest.fixture(scope="module")
def browser() -> Iterator[Page]:
    with chromium() as page:
        yield page


def show(browser: Page, folder: Path, page: str, address: str = "", size: tuple[int, int] = (900, 600)) -> None:
    """Open the page in a browser, where it draws without an error and asks for nothing; `address` is what follows #."""
    (folder / "index.html").write_text(page, encoding="utf-8")
    browser.open(f"{(folder / 'index.html').as_uri()}#{address}", size, is_mobile=size[0] < 400)
    browser.drawn()
    assert browser.errors == []
    assert [place for place in browser.requests if not place.startswith(("file:", "data:"))] == []


def image_of(browser: Page, folder: Path, page: str, address: str) -> Any:
    """The browser's window (600, 900, 3), 8-bit sRGB."""
    show(browser, folder, page, address)
    return browser.image()


#: Draws with every model, and counts the programs.
EVERY_MODEL = """for (const model of data.models) { state.model = model.name; draw(); }
gl.getError() ? -1 : programs.size"""

#: The image is 620 x 600; the plane reaches from -1 to 1 at 1.15 per half height, seen from a distance of 3.
CENTRE = (300, 310)


@pytest.mark.parametrize("brdf", ["phong:exponent=30", "ggx:alpha=0.3"])
def test_a_browser_shows_the_radiance_of_the_plane(browser: Page, tmp_path: Path, brdf: str) -> None:
    material = make_material(brdf=brdf)
    image = image_of(browser, tmp_path, viewer(material), "neutral=0&azimuth=30&elevation=50")
    light = surface_direction(np.radians(40), np.radians(30))
    for row, column in (CENTRE, (200, 220), (450, 430)):
        at = np.array([(column + 0.5 - 310) / 300, (300 - row - 0.5) / 300]) * 1.15
        towards_eye = np.array([-at[0], -at[1], 3.0])
        radiance = compute_expected_radiance(material, light, towards_eye / np.linalg.norm(towards_eye))
        np.testing.assert_allclose(image[row, column], 255 * srgb_encode(radiance), atol=1.5)
    assert image[30, 310].tolist() == [24, 24, 24]


def test_a_browser_shows_the_sphere(browser: Page, tmp_path: Path) -> None:
    material = make_material(brdf="lambert", sigma=2.0)
    image = image_of(browser, tmp_path, viewer(material), "sphere=1&neutral=0&azimuth=0&elevation=45")
    straight = compute_expected_radiance(material, surface_direction(np.radians(45), 0.0), np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(image[CENTRE], 255 * srgb_encode(straight), atol=1.5)
    assert image[300, 60].max() <= 1
    assert image[300, 470].astype(int).sum() > image[300, 200].astype(int).sum()


def test_a_browser_shows_row_0_on_top_and_every_model_compiles(browser: Page, tmp_path: Path) -> None:
    material = make_material(name="half dark")
    assert material.power_law is not None
    scale = material.power_law.scale.copy()
    scale[:4, :, :] = 0
    scale[:, :4, 2] = 0
    law = dataclasses.replace(material.power_law, scale=scale)
    page = viewer(dataclasses.replace(material, power_law=law))
    image = image_of(browser, tmp_path, page, "neutral=0&elevation=90")
    assert image[150, 310].max() <= 1
    assert image[450, 200][2] <= 1 < image[450, 420][2]
    show(browser, tmp_path, page, size=(520, 200))
    assert browser.value(EVERY_MODEL) == len(MODELS)
    assert browser.value("document.title") == "half dark"


def test_a_browser_without_webgl_says_so(browser: Page, tmp_path: Path) -> None:
    page = viewer(make_material()).replace('canvas.getContext("webgl2"', 'canvas.getContext("absent"')
    (tmp_path / "index.html").write_text(page, encoding="utf-8")
    browser.open((tmp_path / "index.html").as_uri())
    state = browser.value("document.documentElement.dataset.state")
    assert state.startswith("failed: This browser offers no WebGL 2.")


def image_in_texel(directional: Any, light: Any, row: int, column: int) -> Any:
    return 255.0 * srgb_encode(np.clip(directional.image(light)[row, column], 0.0, 1.0))


@pytest.mark.parametrize("brdf", ["lambert", "ggx:alpha=0.4"])
def test_a_browser_shows_the_planes_of_a_directional_map(browser: Page, tmp_path: Path, brdf: str) -> None:
    """At the middle of the page's plane, which is seen straight from above: any BRDF shows the image of the light."""
    material = dome_material(brdf)
    directional = material.directional
    assert directional is not None
    page, shown = viewer(material), []
    for azimuth in (0, 90, 200):
        light = surface_direction(np.radians(40), np.radians(azimuth))
        image = image_of(browser, tmp_path, page, f"neutral=0&azimuth={azimuth}&elevation=50")
        shown.append(image[CENTRE].astype(int))
        # texels of the image: 9 columns over 1.15 of the half height, 7 rows in proportion
        np.testing.assert_allclose(image[CENTRE], image_in_texel(directional, light, 3, 4), atol=3.0)
    assert np.abs(shown[0] - shown[2]).max() > 8


def test_a_browser_turns_light_with_the_texture_of_the_sphere(browser: Page, tmp_path: Path) -> None:
    material = dome_material()
    page = viewer(material)
    left, right = (
        image_of(browser, tmp_path, page, f"sphere=1&neutral=0&azimuth={azimuth}&elevation=30").astype(int)
        for azimuth in (0, 180)
    )
    assert np.abs(left[CENTRE] - right[CENTRE]).max() > 8


def test_every_model_compiles_with_planes(browser: Page, tmp_path: Path) -> None:
    show(browser, tmp_path, viewer(dome_material()), size=(520, 200))
    assert browser.value(EVERY_MODEL) == len(MODELS)
    assert "Directional map of" in browser.value("byId('facts').textContent")


CONSTANT = {"roughness": 0.3, "metallic": 0.7, "f0": 0.04, "occlusion": 0.9}

#: A window with a canvas of 400 x 200, and the part of that which tools hide not.
SMALL, CLEAR = (680, 200), (slice(44, 156), slice(2, 398))

#: Of the image of 620 x 600: its middle, and the pixels from there to where the light stands at the horizon.
MIDDLE, RADIUS = (310, 300), 300 / 1.15

#: Shows linear radiance and takes no notice of the viewer, so that the image only moves.
PLAIN = "neutral=0&elevation=90"


def patchwork(**changes: Any) -> Any:
    """8 x 8 texels of different colours, diffuse."""
    material = make_material(brdf="lambert", **changes)
    assert material.power_law is not None
    scale = np.random.default_rng(5).uniform(0.05, 0.9, (8, 8, 3)).astype(np.float32)
    return dataclasses.replace(material, power_law=dataclasses.replace(material.power_law, scale=scale))


def test_dragging_moves_the_light(browser: Page, tmp_path: Path) -> None:
    show(browser, tmp_path, viewer(dome_material()), "neutral=0")
    images = []
    for side, azimuth in ((-1, 180), (1, 0)):
        browser.drag(MIDDLE, (310 + side * 60, 300), (310 + side * RADIUS / 2, 300))
        images.append(browser.image().astype(int))
        assert browser.value("Math.abs(state.azimuth)") == pytest.approx(azimuth, abs=1e-9)
        assert browser.value("state.elevation") == pytest.approx(60.0, abs=0.2)
    assert np.abs(images[0] - images[1])[CENTRE].max() > 8
    assert browser.value("state.zoom") == 1
    assert browser.value("state.centre") == [0, 0]


@pytest.mark.parametrize("how", ["right", "middle", "shift", "mode"])
def test_dragging_otherwise_moves_the_image(browser: Page, tmp_path: Path, how: str) -> None:
    show(browser, tmp_path, viewer(patchwork()), f"{PLAIN}&zoom=2")
    before = browser.image().astype(int)
    if how == "mode":
        browser.value("byId('mode-view').click()")
    button = how if how in ("right", "middle") else "left"
    browser.drag(MIDDLE, (330, 310), (370, 340), button=button, modifiers=SHIFT if how == "shift" else 0)
    after = browser.image().astype(int)
    # 60 to the right and 40 down, compared away from the tools; texels are 130 pixels wide
    moved = np.abs(after[200:500, 160:500] - before[160:460, 100:440])
    assert np.quantile(moved, 0.99) <= 2
    assert np.abs(after - before)[200:500, 160:500].max() > 30
    assert browser.value("state.elevation") == 90


def test_the_wheel_zooms_about_the_pointer(browser: Page, tmp_path: Path) -> None:
    show(browser, tmp_path, viewer(patchwork()), PLAIN)
    before = browser.image().astype(int)
    browser.wheel(200, 220, -400)
    after = browser.image().astype(int)
    zoom = browser.value("state.zoom")
    assert zoom == pytest.approx(np.exp(0.8), rel=1e-6)
    np.testing.assert_allclose(after[220, 200], before[220, 200], atol=2)
    # a pixel that was 20 to the right and 10 below is now further by the zoom
    np.testing.assert_allclose(after[220 + round(10 * zoom), 200 + round(20 * zoom)], before[230, 220], atol=6)
    browser.wheel(200, 220, 5000)
    assert browser.value("state.zoom") == pytest.approx(1.15 * 8 / 600), "a texel for each pixel is the least"


def test_two_fingers_zoom_and_move(browser: Page, tmp_path: Path) -> None:
    show(browser, tmp_path, viewer(patchwork()), PLAIN, (390, 844))
    before = browser.image().astype(int)
    browser.pinch(((150, 200), (200, 200)), ((140, 200), (210, 200)), ((125, 220), (225, 220)))
    after = browser.image().astype(int)
    assert browser.value("state.zoom") == pytest.approx(2.0, rel=1e-6)
    np.testing.assert_allclose(after[220, 175], before[200, 175], atol=3)
    assert browser.value("state.elevation") == 90, "the light stays"


FOCUS = "document.activeElement.id || document.activeElement.tagName.toLowerCase()"

#: All that a user can operate and that is shown.
CONTROLS = """[...document.querySelectorAll("canvas, button, select, input, summary")]
.filter((each) => each.offsetParent).map((each) => each.id || each.tagName.toLowerCase())"""


def test_the_keyboard_alone_reaches_and_works_everything(browser: Page, tmp_path: Path) -> None:
    show(browser, tmp_path, viewer(patchwork()), "neutral=0&azimuth=0&elevation=60")
    wanted, reached = browser.value(CONTROLS), []
    for _ in wanted:
        browser.key("Tab")
        reached.append(browser.value(FOCUS))
    assert sorted(reached) == sorted(wanted)
    browser.value("canvas.focus()")
    for name, key in (("azimuth", "ArrowUp"), ("zoom", "+"), ("moves", "m"), ("centre", "ArrowRight"), ("zoom", "0")):
        before = browser.value(f"JSON.stringify(state.{name})")
        browser.key(key)
        assert browser.value(f"JSON.stringify(state.{name})") != before, key
        assert browser.value("byId('status').textContent")
    browser.key("1")
    assert browser.value("state.zoom") == pytest.approx(1.15 * 8 / 600), "8 texels over 8 pixels"
    browser.key("p")
    assert browser.value("[byId('panel').hidden, canvas.clientWidth]") == [True, 900]
    browser.value("byId('toggle').focus()")
    browser.key("Enter")
    assert browser.value("[byId('panel').hidden, canvas.clientWidth]") == [False, 620]
    browser.value("byId('choice-model').focus()")
    browser.key("ArrowDown")
    assert browser.value("state.model") != "lambert"
    assert browser.value(FOCUS) == "choice-model", "the focus stays where the panel is built anew"


def test_everything_has_a_name_and_sliders_say_their_values(browser: Page, tmp_path: Path) -> None:
    show(browser, tmp_path, viewer(patchwork()), "azimuth=30")
    nodes = browser.call("Accessibility.getFullAXTree")["nodes"]
    names = [
        (node["role"]["value"], node["name"]["value"])
        for node in nodes
        if node["role"]["value"] in ("button", "slider", "combobox", "application", "group", "toolbar", "complementary")
    ]
    assert [role for role, name in names if not name.strip()] == []
    assert ("slider", "Azimuth") in names
    azimuth = "[...document.querySelectorAll('input')].find((each) => each.labels[0].textContent === 'Azimuth')"
    assert browser.value(f"{azimuth}.getAttribute('aria-valuetext')") == "30°"


def test_the_scale_bar_has_the_length_that_it_names(browser: Page, tmp_path: Path) -> None:
    """A plane of 80 mm is 600 / 1.15 = 521.7 pixels wide, 6.522 for each mm; a quarter of the image is 155 pixels."""
    page = viewer(patchwork(), Extras(width_mm=80.0))
    bar = "[byId('scale').textContent.trim(), byId('scale').getBoundingClientRect().width, byId('scale').ariaLabel]"
    for address, words, pixels in (
        ("", "2 cm", 130.43),
        ("zoom=4", "5 mm", 130.43),
        ("repeats=2", "2 cm", 65.22),
        ("zoom=8&width_mm=0.1", "2 µm", 83.48),
    ):
        show(browser, tmp_path, page, address)
        name, width, label = browser.value(bar)
        assert (name, label) == (words, f"Scale bar of {words}")
        assert width == pytest.approx(pixels, abs=0.02), "to 1/64 of a pixel"
    show(browser, tmp_path, page, "sphere=1")
    assert browser.value("byId('scale').hidden")
    show(browser, tmp_path, viewer(patchwork()))
    assert browser.value("byId('scale').hidden"), "the width is not known"


def test_channels_show_the_maps(browser: Page, tmp_path: Path) -> None:
    normal = np.zeros((8, 8, 3), np.float32)
    normal[...] = (0.6, 0.0, 0.8)
    alike: dict[str, Any] = {name: np.full((8, 8), value, np.float32) for name, value in CONSTANT.items()}
    maps = PbrMaps(base_colour=np.full((8, 8, 3), (0.5, 0.2, 0.1), np.float32), normal=normal, **alike)
    page = viewer(make_material(), Extras(maps=maps))
    channels = [name for name, _ in page_data(page)["channels"]]
    assert channels == [
        "picture", "brightest", "exponent", "base_colour", "roughness", "normal", "relief", "enhanced", "metallic",
        "occlusion",
    ]  # fmt: skip
    exponent = np.array(EXPONENT)
    wanted = {
        "brightest": 255 * srgb_encode(np.array(SCALE)),
        "exponent": 255 * srgb_encode(exponent / (1 + exponent)),
        "base_colour": 255 * srgb_encode(np.array([0.5, 0.2, 0.1])),
        "normal": 128 + 127 * np.array([0.6, 0.0, 0.8]),
        **{name: np.full(3, 255 * value) for name, value in CONSTANT.items() if name != "f0"},
    }
    show(browser, tmp_path, page, "neutral=0", SMALL)

    def middle(**state: Any) -> Any:
        browser.value(f"Object.assign(state, {json.dumps(state)}); changed()")
        return browser.image()[100, 200]

    for name, code in wanted.items():
        np.testing.assert_allclose(middle(channel=name), code, atol=1.5)
    left, right = (middle(channel="relief", azimuth=azimuth, elevation=45) for azimuth in (180, 0))
    facing = np.array([-0.6 + 0.8, 0.6 + 0.8]) / np.sqrt(2)
    np.testing.assert_allclose([left[0], right[0]], 255 * srgb_encode(0.8 * facing), atol=1.5)
    # half way between the viewer overhead and a light that the normal bisects: the highlight is full
    light = np.degrees(np.arcsin(0.8 * 0.8 - 0.6 * 0.6))
    full = middle(channel="enhanced", azimuth=0, elevation=light)
    np.testing.assert_allclose(full, 255 * srgb_encode(0.5 * 0.8 * np.array([0.5, 0.2, 0.1]) + 0.5), atol=2)


def test_flat_normals_are_no_channel() -> None:
    flat = np.zeros((8, 8, 3), np.float32)
    flat[..., 2] = 1.0
    alike: dict[str, Any] = {name: np.full((8, 8), 0.0, np.float32) for name in ("roughness", "metallic", "f0")}
    page = viewer(
        make_material(), Extras(maps=PbrMaps(base_colour=np.zeros((8, 8, 3), np.float32), normal=flat, **alike))
    )
    assert {"normal", "relief", "enhanced", "metallic", "occlusion"}.isdisjoint(dict(page_data(page)["channels"]))


def at_texels(browser: Page, folder: Path, page: str, address: str) -> Any:
    """The image at a texel for each pixel, when all tiles are there."""
    show(browser, folder, page, f"neutral=0&{address}", SMALL)
    browser.value("byId('sun').style.display = 'none'; byId('texels').click()")
    browser.drawn()
    browser.wait("canvas.ariaBusy === 'false'")
    return browser.image().astype(int)[CLEAR]


def texels_in_view(size: tuple[int, int]) -> tuple[Any, Any]:
    """Rows and columns of the texels of `at_texels`; the middle of the image is that of the map."""
    height, width = size
    return (
        np.arange(height // 2 - 100, height // 2 + 100)[CLEAR[0]] % height,
        np.arange(width // 2 - 200, width // 2 + 200)[CLEAR[1]] % width,
    )


def noisy(size: tuple[int, int]) -> Any:
    """Every texel of another colour than its neighbours; the exponents differ as well."""
    material, rng = make_material(brdf="lambert", elevation_deg=(90.0,)), np.random.default_rng(6)
    assert material.power_law is not None
    scale, exponent = (rng.uniform(low, 1.0, (*size, 3)).astype(np.float32) for low in (0.02, 0.3))
    law = dataclasses.replace(material.power_law, scale=scale, exponent=exponent, error_map=scale[..., 0])
    return dataclasses.replace(material, power_law=law)


@pytest.mark.parametrize("repeats", [1, 2])
@pytest.mark.parametrize("size", [(160, 1040), (1040, 300)])
def test_tiles_show_every_texel(browser: Page, tmp_path: Path, size: tuple[int, int], repeats: int) -> None:
    """Under light at 30 degrees a diffuse surface has half the r of light overhead."""
    material = noisy(size)
    law = material.power_law
    page = viewer(material)
    assert max(page_data(page)["maps"]["scale"]["size"]) == VIEWER_SIDE, "averaged, so that the whole cannot show them"
    found = at_texels(browser, tmp_path, page, f"elevation=30&azimuth=0&repeats={repeats}")
    place = np.ix_(*texels_in_view(size))
    wanted = 255 * srgb_encode(law.scale[place].astype(float) * 0.5 ** law.exponent[place].astype(float))
    beside = np.abs(np.arange(200) + 0.5 - 100)[CLEAR[0]] > repeats * size[0] / 2
    aside = np.abs(np.arange(400) + 0.5 - 200)[CLEAR[1]] > repeats * size[1] / 2
    background = beside[:, None] | aside
    assert np.abs(found - wanted)[~background].max() <= 2.5
    assert (found[background] == 24).all()


def test_tiles_show_planes_and_the_surface(browser: Page, tmp_path: Path) -> None:
    material, size, rng = dome_material(), (120, 1040), np.random.default_rng(8)
    assert material.directional is not None
    planes = rng.integers(64, 192, (len(material.directional.planes), *size), np.uint8)
    directional = dataclasses.replace(material.directional, planes=planes)
    normal = rng.normal((0.0, 0.0, 2.0), 1.0, (*size, 3))
    normal = (normal / np.linalg.norm(normal, axis=2, keepdims=True)).astype(np.float32)
    alike: dict[str, Any] = {name: np.zeros(size, np.float32) for name in ("roughness", "metallic", "f0")}
    maps = PbrMaps(base_colour=np.zeros((*size, 3), np.float32), normal=normal, **alike)
    page = viewer(dataclasses.replace(material, directional=directional), Extras(maps=maps))
    place = np.ix_(*texels_in_view(size))
    # straight in the middle the page sees the texel from above, as `image` does
    light = surface_direction(np.radians(40), np.radians(200))
    found = at_texels(browser, tmp_path, page, "azimuth=200&elevation=50")
    wanted = 255 * srgb_encode(np.clip(directional.image(light)[place], 0, 1))
    assert np.quantile(np.abs(found - wanted), 0.99) <= 2
    assert np.abs(found - wanted).max() <= 4
    browser.value("state.channel = 'normal'; changed()")
    browser.drawn()
    browser.wait("canvas.ariaBusy === 'false'")
    np.testing.assert_allclose(browser.image().astype(int)[CLEAR], 128 + 127 * normal[place], atol=1)


def test_tiles_that_are_lost_leave_the_whole(browser: Page, tmp_path: Path) -> None:
    page = viewer(noisy((160, 1040)))
    for name in page_data(page)["pictures"]:
        page = page.replace(f'"{name}"', f'"gone-{name}"') if name.startswith("tiles/") else page
    (tmp_path / "index.html").write_text(page, encoding="utf-8")
    browser.open(f"{(tmp_path / 'index.html').as_uri()}#neutral=0&zoom=4", SMALL)
    browser.drawn()
    browser.wait("canvas.ariaBusy === 'false'")
    assert browser.image()[100, 200].max() > 24


def test_one_file_leaves_out_what_is_too_large_and_says_so(
    browser: Page, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    size = (8, 2100)
    monkeypatch.setattr("engine.bundle.page.PIXELS_WITHIN", 12 * 4 * VIEWER_SIDE + bytes_of([size], 2) - 1)
    page, parts = viewer_and_parts(noisy(size))
    text = b"".join(page).decode()
    assert len(page) == len(text)
    tiles = {name for name in parts if name.startswith("tiles/")}
    assert {name[:15] for name in tiles} == {"tiles/look_up-0"}
    data = page_data(text)
    assert data["pyramid"]["finest"] == {"look_up": 1}
    assert set(data["pictures"]) == {name for name in parts if name.endswith(".png")} - tiles
    assert data["pictures"] == page_data(viewer(noisy(size)))["pictures"], "as the page of a bundle"
    show(browser, tmp_path, text, size=SMALL)
    assert "2100 × 8 texels, averaged down here to 1024 × 4." in browser.value("byId('facts').textContent")


def test_a_page_takes_the_memory_of_one_image(tmp_path: Path) -> None:
    material = noisy((200, 1030))
    with keep_in_memory(0):
        page = make_page(material)
    tracemalloc.start()
    write_bytes(tmp_path / "index.html", page)
    _, most_bytes = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    size_bytes = (tmp_path / "index.html").stat().st_size
    largest = max(page.files.size_bytes(name) for name in page.names)
    assert len(page) == size_bytes
    assert most_bytes < 3 * largest + (1 << 18) < size_bytes / 2
    assert (tmp_path / "index.html").read_bytes() == viewer(material).encode(), "wherever its images lay"


@pytest.mark.parametrize("form", ["power", "planes"])
def test_hexagonal_cells_repeat_nothing_and_keep_mean_and_contrast(browser: Page, tmp_path: Path, form: str) -> None:
    step = 130  # pixels of a repeat; the plane is 600 / 1.15 high
    place = f"neutral=0&azimuth=30&elevation=60&repeats={600 / 1.15 / step}"
    page = viewer(material_of("leather", form))
    images = [image_of(browser, tmp_path, page, f"{place}&hexagonal={hexagonal}") for hexagonal in (0, 1)]
    grid, cells = (srgb_decode(image[60:540, 70:550, 1] / 255.0) for image in images)

    def correlation(image: Any) -> float:
        apart = image - cv2.blur(image, (step, step))  # less what the highlight of the model adds
        return float((apart[:, :-step] * apart[:, step:]).mean() / apart.var())

    assert correlation(grid) > 0.35
    assert abs(correlation(cells)) < 0.2
    assert cells.mean() == pytest.approx(grid.mean(), rel=0.03)
    assert cells.std() == pytest.approx(grid.std(), rel=0.1)

"""The exported shader computes what the engine does."""

from __future__ import annotations

import dataclasses
import json
from typing import Any

import numpy as np
import pytest

from engine.brdf.brdf import MODELS, brdf_from_text
from engine.bundle.portable import brdf_json, resolve_sigma, shader
from engine.core.colour import luminance
from engine.core.directions import surface_direction
from engine.core.errors import MissingCapability
from engine.gl.program import find_uniform
from engine.shading.directional.effective_light import effective_cosine
from engine.shading.power_law import Storage
from tests.engine.bundle.materials import EXPONENT, SCALE, compute_expected_radiance, make_material
from tests.engine.domes import dome_material


def test_brdf_json_says_what_the_engine_uses() -> None:
    value = json.loads(brdf_json(make_material(brdf="ggx:alpha=0.25")))
    assert (value["model"], value["parameters"]["alpha"], value["sigma_is_automatic"]) == ("ggx", 0.25, True)
    assert value["sigma"] == resolve_sigma(make_material(brdf="ggx:alpha=0.25"))
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
    np.testing.assert_allclose(shown, compute_expected_radiance(material, wi, wo), rtol=2e-4, atol=2e-5)
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


def test_names_cannot_break_out_of_the_shader() -> None:
    hostile = make_material(name="</script><script>alert(1)</script>\n#error\\\n*/ \u2028 ä @DATA@ @BRDF@")
    code = [line for line in shader(hostile).splitlines() if not line.startswith("//")]
    assert not any("#error" in line or "alert" in line for line in code)


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
        textures: dict[str, Any] = {
            "wi": context.texture((len(wi), 1), 3, wi.astype("f4").tobytes(), dtype="f4"),
            "wo": context.texture((len(wo), 1), 3, wo.astype("f4").tobytes(), dtype="f4"),
            "planes": context.texture_array(size, 1, (planes / 255.0).astype("f4").tobytes(), dtype="f4"),
            "weights": context.texture_array((*weights.shape[2:0:-1], len(weights)), 3, weights.tobytes(), dtype="f4"),
        }
        for unit, (name, texture) in enumerate(textures.items()):
            texture.use(unit)
            find_uniform(program, name).value = unit
        textures["weights"].repeat_y = False
        target = context.framebuffer([context.texture((len(wi), 1), 4, dtype="f4")])
        target.use()
        corners = context.buffer(np.array([-1, -1, 3, -1, -1, 3], "f4").tobytes())
        context.vertex_array(program, [(corners, "2f", "at")]).render()
        shown = np.frombuffer(target.read(components=3, dtype="f4"), np.float32).reshape(-1, 3)
    context.release()
    share = resolve_sigma(material) * luminance(brdf.f(wi, wo)) * wi[:, 2] / directional.r_max
    azimuth = np.arctan2(wi[:, 1], wi[:, 0])
    cosine = effective_cosine(brdf)(share, azimuth)
    expected = directional.sample(planes[:, 4, 2][None], cosine, azimuth)[0]
    np.testing.assert_allclose(shown, expected, rtol=5e-3, atol=2e-3)

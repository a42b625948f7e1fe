"""Shaders: compiled by glslang and by Blender's OSL, evaluated as the engine does, with the errors in their heads."""

from __future__ import annotations

import dataclasses
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.brdf.brdf import MODELS
from engine.bundle.portable import brdf_source
from engine.core.directions import normalize
from engine.core.errors import UsageError
from engine.core.steps import drain
from engine.exchange.loss import View, material_shown
from engine.exchange.shaders import contents, hlsl_of, osl_of
from engine.exchange.subject import Settings, Subject
from engine.images.decode import read_image
from engine.light.environment import DistantLights
from engine.scene.material import Material
from engine.shading.directional.planes import fit

from .materials import dome_stack, linear_material, woven_subject

#: Pairs of light and view, and the texels that they are evaluated at.
PAIRS = 6
ROW, COLUMN = np.arange(PAIRS) % 5, 2 * np.arange(PAIRS) % 5


def directions() -> tuple[np.ndarray, np.ndarray]:
    """(PAIRS, 3) towards the light and the viewer, some of them low."""
    both = np.random.default_rng(2).normal(size=(2, PAIRS, 3))
    both[..., 2] = np.abs(both[..., 2]) + 0.2
    wi, wo = normalize(both)
    return wi, wo


def by_the_engine(material: Material) -> np.ndarray:
    """(PAIRS, 3) radiance of the texels under one light of irradiance 1."""
    shown, found = material_shown(material, "power-law"), []
    for wi, wo, row, column in zip(*directions(), ROW, COLUMN, strict=True):
        view = View(np.array([row]), np.array([column]), np.eye(3)[None], wo[None], np.ones((1, 1), np.bool_))
        found.append(shown(view, DistantLights(wi[None], np.ones((1, 3))))[0])
    return np.array(found)


def oblique_dome() -> Material:
    """A directional map of several planes, for its texels face all sides, that a glossy BRDF looks up."""
    stack = dome_stack()
    assert stack.azimuth is not None
    slope = np.random.default_rng(4).uniform(-0.5, 0.5, (2, *stack.radiance.shape[1:3]))
    around = np.stack([np.cos(stack.azimuth), np.sin(stack.azimuth)])
    tilted = 1.0 + np.einsum("in,ihw->nhw", around, slope) / np.tan(stack.elevation)[:, None, None]
    radiance = (np.maximum(tilted, 0.1)[..., None] * stack.radiance).astype(np.float32)
    found = drain(fit(dataclasses.replace(stack, radiance=radiance), np.arange(24)))
    assert len(found.planes) > 2
    return Material(None, None, brdf="ggx:alpha=0.4", name="dome", directional=found)


def with_brdf(brdf: str) -> Subject:
    subject = woven_subject()
    return dataclasses.replace(subject, material=dataclasses.replace(subject.material, brdf=brdf))


@pytest.fixture(scope="module")
def woven() -> Subject:
    return woven_subject()


GLSL = """#version 330 core
{shader}
uniform sampler2D power_law_scale, power_law_exponent;
in vec2 uv; in vec3 wi, wo; out vec4 colour;
void main() {{
    vec3 exponent = texture(power_law_exponent, uv).rgb * LIGHTARC_EXPONENT_RANGE;
    colour = vec4(lightarc_radiance(wi, wo, texture(power_law_scale, uv).rgb, exponent), 1.0);
}}
"""

HLSL = """{shader}
Texture2D power_law_scale, power_law_exponent;
Texture2DArray slices;
SamplerState state;
float4 main(float2 uv : TEXCOORD0, float3 wi : TEXCOORD1, float3 wo : TEXCOORD2) : SV_Target
{{
    float3 exponent = power_law_exponent.Sample(state, uv).rgb * LIGHTARC_EXPONENT_RANGE;
    float3 radiance = lightarc_radiance(wi, wo, power_law_scale.Sample(state, uv).rgb, exponent);
    return float4(radiance + lightarc_slices(lightarc_r(wi, wo), slices, state, 8.0, uv), 1.0);
}}
"""


def compile_shader(source: str, path: Path, *words: str) -> None:
    compiler = shutil.which("glslangValidator")
    if compiler is None:
        pytest.skip("glslangValidator is missing: install the Debian package glslang-tools")
    path.write_text(source)
    done = subprocess.run([compiler, *words, path], capture_output=True, text=True, timeout=60, cwd=path.parent)
    assert done.returncode == 0, done.stdout


def text_of(model: str) -> str:
    """A BRDF of the model, with parameters where its name alone is another's."""
    return {
        "ggx-anisotropic": "ggx:alpha_x=0.1",
        "lafortune-three-lobes": "lafortune:preset=blue-paint",
    }.get(model, model)


@pytest.mark.parametrize("model", MODELS)
def test_glslang_compiles_every_model_in_both_languages(model: str, woven: Subject, tmp_path: Path) -> None:
    material = dataclasses.replace(woven.material, brdf=text_of(model))
    files = drain(contents(dataclasses.replace(woven, material=material), Settings(), "")).files
    compile_shader(GLSL.format(shader=files["A_cloth_woven.glsl"].decode()), tmp_path / "x.frag")
    hlsl = HLSL.format(shader=files["A_cloth_woven.hlsl"].decode())
    compile_shader(hlsl, tmp_path / "x.hlsl", "-D", "-V", "-S", "frag", "-e", "main")


def test_casts_take_one_argument_and_constructors_several() -> None:
    glsl = "vec2 a = vec2(x(1.0, 2.0)); vec3 b = vec3(vec2(0.0), 1.0); const float K[2] = float[2](1.0, 2.0);"
    assert hlsl_of(glsl) == (
        "float2 a = ((float2)(x(1.0, 2.0))); float3 b = float3(((float2)(0.0)), 1.0); const float K[2] = {1.0, 2.0};"
    )
    assert hlsl_of("const float k = fract(mix(a, b, 0.5));") == "static const float k = frac(lerp(a, b, 0.5));"


def test_the_head_states_the_loss(woven: Subject) -> None:
    files = drain(contents(woven, Settings(), "An error of 3 %.")).files
    for name in ("A_cloth_woven.glsl", "A_cloth_woven.hlsl"):
        assert files[name].decode().splitlines()[1] == "// An error of 3 %."
    assert {"power_law_scale.exr", "power_law_exponent.exr"} < set(files)


def test_hlsl_has_the_constants_of_the_material(woven: Subject) -> None:
    source = hlsl_of(brdf_source(woven.material))
    assert "static const float brdf_exponent = 20.0;" in source
    assert "vec3" not in source


def test_osl_keeps_pairs_in_triples_and_constants_in_words() -> None:
    glsl = "const float K[2] = float[2](1.0, 2.0);\nconst vec3 c = vec3(1.0);\nvec2 f(vec3 a) { return a.yx * K[k]; }"
    assert osl_of(glsl) == (
        "float K(int k)\n{\n    float numbers[2] = {1.0, 2.0};\n    return numbers[k];\n}\n"
        "#define c vector(1.0)\n"
        "vector f(vector a) { return vector(a[1], a[0], 0.0) * K(k); }"
    )
    assert osl_of("vec2 a = vec2(b.x); a.y = 2.0;") == "vector a = vector(b[0], b[0], 0.0); a[1] = 2.0;"


DIRECTIONAL = """{shader}
Texture2DArray planes, weights;
SamplerState state, weights_state;
static const float3 WI[{count}] = {{{wi}}};
static const float3 WO[{count}] = {{{wo}}};
static const float2 UV[{count}] = {{{uv}}};
float4 main(float4 place : SV_Position) : SV_Target
{{
    int k = int(place.x);
    return float4(lightarc_radiance(WI[k], WO[k], planes, state, weights, weights_state, UV[k]), 1.0);
}}
"""


def arrays(values: np.ndarray) -> str:
    return ", ".join(f"float{values.shape[1]}({', '.join(f'{x:.9g}' for x in each)})" for each in values)


def test_hlsl_of_a_directional_map_shows_what_the_engine_shows(tmp_path: Path, gl: Any) -> None:
    """Compiled by glslang, put into GLSL by SPIRV-Cross, and run: a party that is not us reads every word."""
    material = oblique_dome()
    directional = material.directional
    assert directional is not None
    made = drain(contents(Subject(material, woven_subject().maps), Settings(), "An error of 3 %."))
    assert made.warnings == ()
    text = made.files["dome.hlsl"].decode()
    assert text.splitlines()[1] == "// An error of 3 %."
    assert "@" not in text
    height, width = material.size
    uv = np.column_stack([(COLUMN + 0.5) / width, (ROW + 0.5) / height])
    wi, wo = (arrays(each) for each in directions())
    source = DIRECTIONAL.format(shader=text, count=PAIRS, wi=wi, wo=wo, uv=arrays(uv))
    words = ["-D", "-V", "-S", "frag", "-e", "main", "-o", str(tmp_path / "x.spv")]
    compile_shader(source, tmp_path / "x.hlsl", *words)
    if shutil.which("spirv-cross") is None:
        pytest.skip("spirv-cross is missing: install the Debian package of that name")
    crossing = ["spirv-cross", "--version", "330", "--no-es", str(tmp_path / "x.spv")]
    glsl = subprocess.run(crossing, capture_output=True, text=True, timeout=60, check=True).stdout
    vertex = "#version 330\nin vec2 at; void main() { gl_Position = vec4(at, 0.0, 1.0); }"
    program = gl.program(vertex_shader=vertex, fragment_shader=glsl)
    codes = np.ascontiguousarray(directional.planes)
    planes = gl.texture_array((width, height, len(codes)), 1, codes.tobytes(), alignment=1)
    table = np.ascontiguousarray(np.moveaxis(directional.table, 3, 0), np.float32)
    weights = gl.texture_array((table.shape[2], table.shape[1], len(table)), 3, table.tobytes(), dtype="f4")
    weights.repeat_y = False
    for unit, (kind, texture) in enumerate((("planes", planes), ("weights", weights))):
        texture.filter = (gl.LINEAR, gl.LINEAR)
        texture.use(unit)
        for name in re.findall(rf"uniform sampler2DArray (\w*Combined{kind}\w*);", glsl):
            program[name] = unit
    target = gl.simple_framebuffer((PAIRS, 1), 4, dtype="f4")
    target.use()
    corners = gl.buffer(np.array([-1, -1, 3, -1, -1, 3], np.float32))
    gl.vertex_array(program, [(corners, "2f", "at")]).render()
    found = np.frombuffer(target.read(components=3, dtype="f4"), np.float32).reshape(PAIRS, 3)
    np.testing.assert_allclose(found, by_the_engine(material), rtol=2e-3, atol=1e-5)


@pytest.fixture(scope="module")
def blender() -> str:
    """An interpreter that has Blender's module, whose Cycles compiles and runs OSL."""
    chosen = os.environ.get("LIGHTARC_BLENDER_PYTHON", sys.executable)
    if subprocess.run([chosen, "-c", "import bpy"], capture_output=True, check=False).returncode:
        pytest.skip("Blender's module (bpy) is not installed, and LIGHTARC_BLENDER_PYTHON names no Python that has it")
    return chosen


def by_osl(blender: str, folder: Path, shader: Path, cases: list[dict[str, Any]]) -> np.ndarray:
    """(PAIRS, 3) radiance of each case; the shader is compiled first."""
    wi, wo = directions()
    for case, light, view in zip(cases, wi, wo, strict=True):
        case |= {"wi": light.tolist(), "wo": view.tolist()}
    (folder / "cases.json").write_text(json.dumps(cases))
    script = Path(__file__).with_name("evaluate_osl.py")
    words = [blender, script, shader, folder / "cases.json", folder / "found.exr"]
    subprocess.run([str(word) for word in words], check=True, capture_output=True, timeout=120)
    return read_image(folder / "found.exr").pixels[1, 1::4].astype(np.float64)


@pytest.mark.long
@pytest.mark.parametrize("model", MODELS)
def test_osl_of_every_model_shows_what_the_engine_shows(model: str, blender: str, tmp_path: Path) -> None:
    subject = with_brdf(text_of(model))
    law = subject.material.power_law
    assert law is not None
    files = drain(contents(subject, Settings(), "")).files
    (tmp_path / "x.osl").write_bytes(files["A_cloth_woven.osl"])
    texels = zip(law.scale[ROW, COLUMN], law.exponent[ROW, COLUMN], strict=True)
    cases = [{"scale": [*map(float, scale), 1.0], "exponent": [*map(float, power), 1.0]} for scale, power in texels]
    found = by_osl(blender, tmp_path, tmp_path / "x.osl", cases)
    np.testing.assert_allclose(found, by_the_engine(subject.material), rtol=1e-3, atol=1e-6)


@pytest.mark.long
def test_osl_of_a_directional_map_shows_what_the_engine_shows(blender: str, tmp_path: Path) -> None:
    material = oblique_dome()
    for name, content in drain(contents(Subject(material, woven_subject().maps), Settings(), "")).files.items():
        (tmp_path / name).write_bytes(content)
    height, width = material.size
    places = zip((COLUMN + 0.5) / width, (ROW + 0.5) / height, strict=True)
    cases = [{"across": float(across), "down": float(down), "folder": f"{tmp_path}/"} for across, down in places]
    found = by_osl(blender, tmp_path, tmp_path / "dome.osl", cases)
    np.testing.assert_allclose(found, by_the_engine(material), rtol=2e-3, atol=1e-5)


def test_what_a_language_cannot_look_up_is_said(woven: Subject) -> None:
    slices = linear_material((0.5, 0.4, 0.3), "lambert")
    made = drain(contents(dataclasses.replace(woven, material=slices), Settings(), ""))
    assert made.warnings == ("the material has no power law, which the OSL looks up; GLSL and HLSL look its slices up",)


def test_a_material_without_a_map_of_its_own_is_refused(woven: Subject) -> None:
    bare = dataclasses.replace(woven.material, power_law=None)
    with pytest.raises(UsageError, match="has none"):
        drain(contents(dataclasses.replace(woven, material=bare), Settings(), ""))

"""Shaders: compiled by glslang in both languages, with the errors in their heads."""

from __future__ import annotations

import dataclasses
import shutil
import subprocess
from pathlib import Path

import pytest

from engine.brdf.brdf import MODELS
from engine.bundle.portable import brdf_source
from engine.core.errors import UsageError
from engine.core.steps import drain
from engine.exchange.shaders import contents, hlsl_of
from engine.exchange.subject import Settings, Subject

from .materials import dome_material, woven_subject


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


def compiled(source: str, path: Path, *words: str) -> None:
    compiler = shutil.which("glslangValidator")
    if compiler is None:
        pytest.skip("glslangValidator is missing: install the Debian package glslang-tools")
    path.write_text(source)
    done = subprocess.run([compiler, *words, path], capture_output=True, text=True, timeout=60, cwd=path.parent)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("model", MODELS)
def test_glslang_compiles_every_model_in_both_languages(model: str, woven: Subject, tmp_path: Path) -> None:
    material = dataclasses.replace(woven.material, brdf={"ggx-anisotropic": "ggx:alpha_x=0.1"}.get(model, model))
    if model == "lafortune-three-lobes":
        material = dataclasses.replace(material, brdf="lafortune:preset=blue-paint")
    files = drain(contents(dataclasses.replace(woven, material=material), Settings(), "")).files
    compiled(GLSL.format(shader=files["A_cloth_woven.glsl"].decode()), tmp_path / "x.frag")
    hlsl = HLSL.format(shader=files["A_cloth_woven.hlsl"].decode())
    compiled(hlsl, tmp_path / "x.hlsl", "-D", "-V", "-S", "frag", "-e", "main")


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


def test_a_directional_map_leaves_in_glsl() -> None:
    material = dome_material()
    subject = Subject(material, woven_subject().maps)
    made = drain(contents(subject, Settings(), "An error of 3 %."))
    assert "dome.glsl" in made.files
    assert {name.rpartition(".")[2] for name in made.files} == {"glsl", "png", "json", "exr"}
    assert "dome.hlsl" not in made.files
    assert made.warnings == ("a directional map has a shader in GLSL alone",)
    assert made.files["dome.glsl"].decode().splitlines()[1] == "// An error of 3 %."


def test_a_material_without_a_map_of_its_own_is_refused(woven: Subject) -> None:
    bare = dataclasses.replace(woven.material, power_law=None)
    with pytest.raises(UsageError, match="has none"):
        drain(contents(dataclasses.replace(woven, material=bare), Settings(), ""))

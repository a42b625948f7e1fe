"""The GLSL counterpart of every model computes what Python does."""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from engine.brdf.brdf import Brdf, brdf_from_text, model_name
from engine.core.params import parameters
from engine.gl.program import load_program, set_uniforms
from tests.engine.brdf.all_models import LAYERED, TEXTS, pairs


@pytest.mark.parametrize("text", [*TEXTS, *LAYERED])
def test_glsl_twin_agrees(gl: Any, tmp_path: Any, text: str, shader: Callable[[str, str], None]) -> None:
    brdf = brdf_from_text(text)
    wi, wo = (w.astype(np.float32) for w in pairs(100_000, seed=9))
    on_gpu = evaluate_on_gpu(gl, brdf, wi, wo, shader)
    expected = brdf.f(wi, wo)
    lobe = expected > 1e-6 * expected.max()
    assert np.isfinite(on_gpu).all()
    digits = 1e-5 if text in TEXTS else 1e-4  # phases of films have few
    assert np.abs(on_gpu[lobe] / expected[lobe] - 1.0).max() <= digits
    assert np.abs(on_gpu[~lobe] - expected[~lobe]).max(initial=0.0) <= 1e-5 * expected.max()


@pytest.mark.parametrize("text", [*TEXTS, *LAYERED])
def test_BR1_BR2_glsl_twin_is_finite_at_the_horizon_and_at_the_normal(gl: Any, text: str, shader: Any) -> None:
    cosine = np.array([1.0, 1e-2, 1e-4, 1e-8, 1e-12, 0.0, -1e-8])
    directions = np.stack([np.sqrt(1 - cosine**2), 0 * cosine, cosine], axis=-1)
    directions = np.concatenate([directions * (1, 1, 1), directions * (-1, 1, 1), directions[:, [1, 0, 2]]])
    wi, wo = (w.reshape(-1, 3).astype(np.float32) for w in np.broadcast_arrays(directions[:, None], directions[None]))
    value = evaluate_on_gpu(gl, brdf_from_text(text), wi, wo, shader)
    assert np.isfinite(value).all()
    assert (value >= 0).all()
    assert not value[(wi[:, 2] <= 0) | (wo[:, 2] <= 0)].any()


def evaluate_on_gpu(gl: Any, brdf: Brdf, wi: np.ndarray, wo: np.ndarray, shader: Any) -> np.ndarray:
    source = (
        "#version 330 core\n#include BRDF\nin vec3 wi;\nin vec3 wo;\nout vec3 value;\n"
        "void main()\n{\n    value = brdf(wi, wo);\n}\n"
    )
    folder = shader("evaluate.vert", source)
    definitions = {"BRDF": f"brdf/{model_name(brdf)}.glsl"}
    program = load_program(gl, "evaluate.vert", None, definitions, folder=folder, varyings=["value"])
    set_uniforms(program, {f"brdf_{p.name}": getattr(brdf, p.name) for p in parameters(brdf)})
    given_ = gl.buffer(np.concatenate([wi, wo], axis=1).astype("f4").tobytes())
    result = gl.buffer(reserve=12 * len(wi))
    array = gl.vertex_array(program, [(given_, "3f 3f", "wi", "wo")])
    framebuffer = gl.simple_framebuffer((1, 1))
    framebuffer.use()
    array.transform(result, gl.POINTS, vertices=len(wi))
    values = np.frombuffer(result.read(), np.float32).reshape(-1, 3)
    for item in (framebuffer, array, result, given_, program):
        item.release()
    return values


def test_luminance_in_the_shader_is_the_engine_s() -> None:
    from engine.core.colour import LUMINANCE
    from engine.core.shader_files import SHADERS

    line = next(line for line in (SHADERS / "direct.frag").read_text().splitlines() if "LUMINANCE = vec3" in line)
    numbers = [float(number) for number in line.split("(")[1].split(")")[0].split(",")]
    assert [struct.pack("f", n) for n in numbers] == [struct.pack("f", n) for n in LUMINANCE]

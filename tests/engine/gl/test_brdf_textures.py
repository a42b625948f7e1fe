"""A table on the graphics device: the same numbers as in Python, in a shader by itself and in an image."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any, cast

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.brdf.resample import random_pairs, table_from
from engine.brdf.table import DirectionTable
from engine.core.steps import drain
from engine.geometry.camera import frame
from engine.geometry.shapes import open_mesh
from engine.gl.brdf_textures import TableTexture
from engine.gl.context import Limits, limits
from engine.gl.direct import DirectRenderer
from engine.gl.program import load_program
from engine.render.direct import radiance
from engine.scene.scene import Scene
from tests.engine.brdf.all_models import pairs
from tests.engine.brdf.test_table import direction_table, random_table

SOURCE = (
    '#version 330 core\n#include "brdf/table.glsl"\nin vec3 wi;\nin vec3 wo;\nout vec3 value;\n'
    "void main()\n{\n    value = brdf(wi, wo);\n}\n"
)


def evaluate(gl: Any, table: Any, wi: np.ndarray, wo: np.ndarray, shader: Any) -> np.ndarray:
    folder = shader("evaluate.vert", SOURCE)
    program = load_program(gl, "evaluate.vert", None, folder=folder, varyings=["value"])
    texture = TableTexture(gl, table, limits(gl))
    texture.bind(program)
    given = gl.buffer(np.concatenate([wi, wo], axis=1).astype("f4").tobytes())
    result = gl.buffer(reserve=12 * len(wi))
    array = gl.vertex_array(program, [(given, "3f 3f", "wi", "wo")])
    framebuffer = gl.simple_framebuffer((1, 1))
    framebuffer.use()
    array.transform(result, gl.POINTS, vertices=len(wi))
    values = np.frombuffer(result.read(), np.float32).reshape(-1, 3)
    for item in (framebuffer, array, result, given, program, texture):
        item.release()
    return values


@pytest.mark.parametrize("text", ["ggx:kd=0.2/0.3/0.4,alpha=0.1,f0=0.5", "phong:exponent=20", "lambert"])
def test_the_look_up_agrees_with_python_to_1e_5(gl: Any, text: str, shader: Callable[[str, str], Any]) -> None:
    table = table_from(brdf_from_text(text), dtype=np.float32)
    wi, wo = (w.astype(np.float32) for w in pairs(100_000, seed=9))
    expected = table.f(wi, wo)
    on_gpu = evaluate(gl, table, wi, wo, shader)
    lit = expected > 1e-6 * expected.max()
    assert np.abs(on_gpu[lit] / expected[lit] - 1.0).max() <= 1e-5
    assert np.abs(on_gpu[~lit] - expected[~lit]).max(initial=0.0) <= 1e-5 * expected.max()


def test_a_rough_table_of_other_dimensions_agrees_too(gl: Any, shader: Callable[[str, str], Any]) -> None:
    """Neighbours differ by all they can, so an error of position shows most; it is that of float32 angles."""
    table = random_table((6, 5, 8), np.float32)
    wi, wo = (w.astype(np.float32) for w in pairs(100_000, seed=3))
    wo[:50] = wi[:50]
    wo[50:100] = wi[50:100] * (-1, -1, 1)
    expected = table.f(wi, wo)
    on_gpu = evaluate(gl, table, wi, wo, shader)
    assert np.abs(on_gpu - expected).max() <= 1e-5 * expected.max()


def test_what_is_not_reciprocal_keeps_both_ways_of_the_light(gl: Any, shader: Callable[[str, str], Any]) -> None:
    """Values that grow with the light's azimuth against the viewer's, so that exchanging them changes all."""
    theta = np.linspace(0.0, np.pi / 2, 10)
    phi = np.arange(36) * (2.0 * np.pi / 36)
    values = 1.0 + 0.5 * np.sin(phi) * np.sin(theta)[:, None, None, None] * np.sin(theta)[:, None]
    values = np.repeat(values[..., None], 3, axis=-1)
    brdf = DirectionTable(theta, np.zeros(1), theta, cast(Any, phi), values, np.zeros(values.shape[:4], bool))
    assert brdf.isotropic
    assert not brdf.reciprocal
    wi, wo = (w.astype(np.float32) for w in random_pairs(20_000))
    on_gpu = evaluate(gl, brdf, wi, wo, shader)
    away = (wi[:, 2] > 0.1) & (wo[:, 2] > 0.1)
    assert np.abs(on_gpu - brdf.f(wi, wo))[away].max() <= 0.02
    assert np.abs(brdf.f(wo, wi) - brdf.f(wi, wo))[away].max() > 0.5


def test_a_image_of_a_table_is_the_same_on_both_renderers(gl: Any) -> None:
    mesh = open_mesh("sphere")
    table = table_from(brdf_from_text("ggx:kd=0.2/0.3/0.4,alpha=0.3,f0=0.5"), (45, 45, 90), dtype=np.float32)
    scene = Scene(mesh, frame(mesh.positions, 1.0), table)
    renderer = DirectRenderer(gl)
    drawn = renderer.radiance(scene, (96, 96), samples=1)
    assert renderer.messages == []
    wanted = drain(radiance(scene, (96, 96), samples=1))
    inside = (drawn[..., 3] == 1.0) & (wanted[..., 3] == 1.0)
    assert inside.sum() > 2000
    assert np.abs(drawn - wanted)[inside].max() <= 2e-4 * wanted.max()
    model = dataclasses.replace(scene, brdf=brdf_from_text("ggx:kd=0.2/0.3/0.4,alpha=0.3,f0=0.5"))
    smooth = renderer.radiance(model, (96, 96), samples=1)
    assert np.median(np.abs(smooth - drawn)[inside]) < 0.01 * smooth.max()
    again = renderer.radiance(scene, (96, 96), samples=1)
    assert np.array_equal(again, drawn)
    renderer.release()


def test_what_is_not_such_a_table_is_shown_with_a_message(gl: Any) -> None:
    mesh = open_mesh("sphere")
    scene = Scene(mesh, frame(mesh.positions, 1.0), direction_table())
    renderer = DirectRenderer(gl)
    assert renderer.radiance(scene, (16, 16), samples=1).max() > 0.0
    assert any("an error of" in message for message in renderer.messages)
    assert any("anisotropic" in message for message in renderer.messages)
    renderer.release()
    small = TableTexture(gl, random_table((40, 5, 8), np.float32), Limits(2048, 16))
    assert "an error of" in small.messages[0]
    small.release()

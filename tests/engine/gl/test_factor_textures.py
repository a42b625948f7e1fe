"""Factors on the graphics device: the same numbers as in Python, in a shader by itself and in an image."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.brdf.ceiling import NODES, Ceiling
from engine.core.steps import drain
from engine.factor import projections
from engine.factor.factor import factor
from engine.factor.hemisphere_map import KINDS, HemisphereMap
from engine.factor.homomorphic import HomomorphicFactors, LogSpace
from engine.factor.projections import (
    DIFFERENCE,
    FIRST,
    SECOND,
    SUM,
    FixedProjection,
    linear,
)
from engine.factor.separable_factors import PARAMETRISATIONS, SeparableFactors
from engine.factor.settings import MAX_TEXTURES, FactorSettings
from engine.geometry.camera import frame
from engine.geometry.shapes import open_mesh
from engine.gl.brdf_textures import MAX_TERMS, OWNERS, factor_source
from engine.gl.direct import DirectRenderer
from engine.gl.program import load_program
from engine.render.direct import radiance
from engine.scene.scene import Scene
from tests.engine.brdf.all_models import pairs


def evaluate(gl: Any, factors: Any, wi: np.ndarray, wo: np.ndarray, shader: Any) -> np.ndarray:
    owner = factor_source(factors)
    assert owner is not None
    text = (
        f'#version 330 core\n#include "brdf/{owner.SOURCE}.glsl"\nin vec3 wi;\nin vec3 wo;\nout vec3 value;\n'
        "void main()\n{\n    value = brdf(wi, wo);\n}\n"
    )
    program = load_program(gl, "evaluate.vert", None, folder=shader("evaluate.vert", text), varyings=["value"])
    textures = owner(gl, factors)
    textures.bind(program)
    given = gl.buffer(np.concatenate([wi, wo], axis=1).astype("f4").tobytes())
    result = gl.buffer(reserve=12 * len(wi))
    array = gl.vertex_array(program, [(given, "3f 3f", "wi", "wo")])
    framebuffer = gl.simple_framebuffer((1, 1))
    framebuffer.use()
    array.transform(result, gl.POINTS, vertices=len(wi))
    values = np.frombuffer(result.read(), np.float32).reshape(-1, 3)
    for item in (framebuffer, array, result, given, program, textures):
        item.release()
    return values


def directions(count: int = 20_000) -> tuple[np.ndarray, np.ndarray]:
    wi, wo = (w.astype(np.float32) for w in pairs(count, seed=9))
    wo[:50] = wi[:50]
    wo[50:100] = wi[50:100] * (-1, -1, 1)
    wi[100:150] = (0, 0, 1)
    wi[150:160], wo[160:170] = (0, 0, -1), (1, 0, 0)
    return wi, wo


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("form", PARAMETRISATIONS)
@pytest.mark.parametrize("size", [1, 5, 16])
def test_separable_factors_agree_with_python_to_1e_5(kind: Any, form: Any, size: int, gl: Any, shader: Any) -> None:
    """Random textures: neighbours differ by all they can, so an error of position shows most."""
    hemisphere_map = HemisphereMap(kind, size)
    rng = np.random.default_rng(size)
    values = rng.normal(size=(2, 3, len(hemisphere_map.directions), 3))
    first, second = (np.stack([hemisphere_map.image(term) for term in side]).astype(np.float32) for side in values)
    factors = SeparableFactors(hemisphere_map, form, first, second)
    wi, wo = directions()
    expected = factors.f(wi, wo)
    on_gpu = evaluate(gl, factors, wi, wo, shader)
    assert expected.max() > 0.1
    assert np.abs(on_gpu - expected).max() <= 1e-5 * np.abs(values).max() ** 2 * 3


@pytest.mark.parametrize("form", PARAMETRISATIONS)
@pytest.mark.parametrize("reciprocal", [False, True])
@pytest.mark.parametrize("kinds", [projections.KINDS[:8], projections.KINDS[8:14], projections.KINDS[14:]])
def test_homomorphic_factors_agree_with_python_to_1e_5(
    kinds: tuple[Any, ...], form: Any, reciprocal: bool, gl: Any, shader: Any
) -> None:
    rng = np.random.default_rng(3)
    linear_ones = (FIRST, SECOND, SUM, DIFFERENCE, linear(rng.normal(size=(2, 4)), "cube"))
    used = (*linear_ones, *(FixedProjection(kind) for kind in kinds))
    textures = tuple(0.3 * rng.normal(size=(9, 9, 3)) for _ in used)
    factors = HomomorphicFactors(textures, cast(Any, used), LogSpace(np.array([0.1, 0.2, 0.4])), form, reciprocal)
    wi, wo = directions()
    expected = factors.f(wi, wo)
    on_gpu = evaluate(gl, factors, wi, wo, shader)
    # half and difference vectors of Cole's frame turn round near h = ±t, where 32 bits do not know them
    half = wi.astype(float) + wo
    known = (half[:, 1] ** 2 + half[:, 2] ** 2 > 1e-3 * (half**2).sum(axis=1)) | (form == "in-out")
    known &= (half**2).sum(axis=1) > 1e-3
    # opposite directions keep a half vector, but 32 bits round it
    lit = expected > 1e-3 * expected.max()
    assert np.abs(on_gpu / np.where(lit, expected, 1.0) - 1.0)[lit & known[:, None]].max() <= 1e-5
    assert np.abs(on_gpu - expected)[~lit & known[:, None]].max(initial=0.0) <= 1e-5 * expected.max()
    assert np.isfinite(on_gpu).all()


@pytest.mark.parametrize("method", ["svd", "homomorphic"])
def test_the_ceiling_of_a_measurement_is_the_same_to_1e_5(method: Any, gl: Any, shader: Any) -> None:
    """Random nodes below the values of the factors: every value is that of the table."""
    settings = FactorSettings(method, side=8, products=2, size=8, samples=500)
    factors = drain(factor(brdf_from_text("lambert:albedo=0.9"), settings)).factors
    table = np.random.default_rng(6).random((NODES, NODES, NODES, 3)).astype(np.float32) * 0.2
    table[:, 0], table[:, :, 0] = table[0, 0], table[0, :, 0]
    bounded = replace(factors, ceiling=Ceiling(table))
    wi, wo = directions()
    expected = bounded.f(wi, wo)
    assert (expected < 0.9 * factors.f(wi, wo)).mean() > 0.8
    assert np.abs(evaluate(gl, bounded, wi, wo, shader) - expected).max() <= 1e-5


@pytest.mark.parametrize(
    "settings",
    [
        {"products": 4, "side": 16},
        {"products": 2, "side": 16, "map": "polar"},
        {"products": 3, "side": 16, "map": "parabolic", "parametrisation": "half-diff"},
        {"method": "homomorphic", "size": 12, "reciprocal": True},
        {"method": "homomorphic", "size": 12, "parametrisation": "half-diff"},
    ],
)
def test_a_image_lit_by_factors_is_the_same_on_both_renderers(settings: Any, gl: Any) -> None:
    brdf = brdf_from_text("lafortune:preset=blue-paint")
    factors = drain(factor(brdf, FactorSettings(samples=3000, **settings))).factors
    mesh = open_mesh("sphere")
    scene = Scene(mesh, frame(mesh.positions, 1.0), factors)
    renderer = DirectRenderer(gl)
    drawn = renderer.radiance(scene, (64, 64), samples=1)
    wanted = drain(radiance(scene, (64, 64), samples=1))
    inside = (drawn[..., 3] == 1.0) & (wanted[..., 3] == 1.0)
    assert inside.sum() > 1000
    assert wanted.max() > 0.05
    assert np.abs(drawn - wanted)[inside].max() <= 2e-4 * wanted.max()
    assert renderer.messages == []
    other = Scene(mesh, scene.camera, factors.truncate(1))
    assert np.abs(renderer.radiance(other, (64, 64), samples=1) - drawn).max() > 1e-3
    assert np.array_equal(renderer.radiance(scene, (64, 64), samples=1), drawn)
    renderer.release()


def test_a_model_has_no_textures() -> None:
    assert factor_source(brdf_from_text("lambert")) is None


def test_factors_are_recognised_by_their_kind_and_all_terms_have_room() -> None:
    assert set(OWNERS) == {SeparableFactors.kind, HomomorphicFactors.kind}
    assert MAX_TERMS == MAX_TEXTURES

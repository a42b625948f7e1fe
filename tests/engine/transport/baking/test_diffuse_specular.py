"""BRDFs in two parts: they sum to the whole, and the diffuse one shows every view the same, but for its gain."""

from __future__ import annotations

import numpy as np
import pytest

from engine.brdf.brdf import MODELS, brdf_from_text
from engine.brdf.models.diffuse import Lambert
from engine.core.directions import normalize, surface_direction
from engine.transport.baking.diffuse_specular import DiffusePart, parts

CUT_BY_FORMULA = ("phong", "blinn-phong", "lafortune", "ward", "ashikhmin-shirley", "cook-torrance", "ggx")


def upward(count: int, seed: int) -> np.ndarray:
    directions = normalize(np.random.default_rng(seed).normal(size=(count, 3)))
    directions[:, 2] = np.abs(directions[:, 2])
    return directions


@pytest.mark.parametrize("name", MODELS)
def test_the_parts_sum_to_the_brdf(name: str) -> None:
    brdf = MODELS[name]()
    diffuse, glossy = parts(brdf)
    wi, wo = upward(500, 0), upward(500, 1)
    total = diffuse.f(wi, wo) + (glossy.f(wi, wo) if glossy is not None else 0.0)
    exact = brdf.f(wi, wo)
    assert np.abs(total - exact).max() < 1e-13 * np.abs(exact).max()


@pytest.mark.parametrize("name", CUT_BY_FORMULA)
def test_models_with_a_diffuse_brdf_are_cut_there(name: str) -> None:
    black = brdf_from_text(f"{name}:kd=0")
    diffuse, glossy = parts(brdf_from_text(f"{name}:kd=0.7/0.5/0.3"))
    assert glossy == black
    assert diffuse.colour[0] / diffuse.colour[1] == pytest.approx(1.4)
    assert parts(black)[0].colour == (0.0, 0.0, 0.0)


def test_what_is_diffuse_has_no_glossy_part() -> None:
    assert parts(Lambert()) == (DiffusePart((0.5, 0.5, 0.5)), None)
    assert parts(brdf_from_text("ggx:kd=0.4,alpha=0.3,f0=0.04"))[1] is not None
    assert parts(brdf_from_text("phong:kd=0.4,ks=0"))[1] is None


def test_the_gain_of_ashikhmin_and_shirley_is_that_of_their_formula() -> None:
    brdf = brdf_from_text("ashikhmin-shirley:kd=0.6,ks=0.1,nu=1e6,nv=1e6")
    theta = np.radians([0.0, 30.0, 60.0, 85.0])
    wi, wo = surface_direction(theta), surface_direction(theta + 0.05, 1.0)  # so narrow a highlight is nowhere here
    diffuse, _ = parts(brdf)
    assert diffuse.grazing
    assert np.abs(diffuse.f(wi, wo)[:, 0] - brdf.f(wi, wo)[:, 0])[:3].max() < 1e-12
    assert diffuse.f(wi, -wo).max() == 0.0
    assert DiffusePart((1.0, 1.0, 1.0)).gain([-0.5, 0.3]).tolist() == [1.0, 1.0]


def test_the_least_value_is_the_diffuse_part_of_all_others() -> None:
    brdf = brdf_from_text("oren-nayar:albedo=0.6,sigma_deg=40")
    diffuse, glossy = parts(brdf)
    facing = brdf.coefficients[0]  # type: ignore[attr-defined]
    assert diffuse.colour == pytest.approx((0.6 * facing,) * 3, rel=1e-12)
    assert glossy is not None
    assert glossy.f(upward(2000, 2), upward(2000, 3)).min() > -1e-12

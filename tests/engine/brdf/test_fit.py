"""Fits find the parameters that made the data, and end no worse than they began."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from benchmarks.generated_brdfs import Layered
from engine.brdf.analysis import albedo
from engine.brdf.brdf import MODELS, brdf_from_text
from engine.brdf.fit import BEAMS, WEIGHTINGS, FitData, beams_of, fit, fit_data, fit_error, residual_by_angle, sample
from engine.brdf.models.microfacet import Ggx, GgxAnisotropic
from engine.brdf.readers.utia import PHI, THETA
from engine.brdf.table import DirectionTable
from engine.core.directions import surface_direction
from engine.core.params import parameters
from engine.core.steps import drain
from engine.geometry.camera import frame
from engine.geometry.shapes import sphere as make_sphere
from engine.light.sky import make_built_in
from engine.render.reference import reference
from engine.scene.scene import Scene

TRUTHS = (
    "lambert:albedo=0.2/0.5/0.9",
    "phong:kd=0.3/0.2/0.1,ks=0.4/0.3/0.2,exponent=35",
    "blinn-phong:kd=0.1/0.2/0.3,ks=0.6/0.3/0.2,exponent=300",
    "ggx:kd=0.3/0.2/0.1,alpha=0.12,f0=0.1/0.3/0.6",
    "cook-torrance:kd=0.1/0.2/0.3,ks=0.9/0.5/0.2,m=0.25,f0=0.5",
    "ward:kd=0.3/0.2/0.1,ks=0.4/0.3/0.2,alpha_x=0.1,alpha_y=0.3",
)


@pytest.mark.parametrize("weighting", WEIGHTINGS)
@pytest.mark.parametrize("text", TRUTHS)
def test_parameters_that_made_the_data_are_found(text: str, weighting: Any) -> None:
    truth = brdf_from_text(text)
    found = drain(fit(fit_data(truth, count=2000), type(truth)(), weighting=weighting))
    assert found.after.rmse_rel < 1e-4
    for parameter in parameters(truth):
        wanted, got = np.asarray(getattr(truth, parameter.name)), np.asarray(getattr(found.brdf, parameter.name))
        assert got == pytest.approx(wanted, rel=2e-3, abs=2e-4), parameter.name


#: Fits with many parameters; models that are like them in all but number are fitted in every suite.
SLOW = ("lafortune-three-lobes", "openpbr-anisotropic")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.long] if name in SLOW else []) for name in MODELS]
)
def test_a_fit_never_ends_worse_than_it_began(name: str) -> None:
    data = fit_data(brdf_from_text("ggx:kd=0.3/0.2/0.1,alpha=0.3,f0=0.04"), count=200)
    found = drain(fit(data, MODELS[name]()))
    assert found.after.objective <= found.before.objective
    assert found.after == fit_error(found.brdf, data)


def test_a_fit_repeats_and_keeps_fixed_parameters() -> None:
    data = fit_data(brdf_from_text("phong:kd=0.3,ks=0.2,exponent=40"), count=500)
    start = Ggx(alpha=0.37)
    first, again = (drain(fit(data, start, fixed=("alpha",), seed=4)).brdf for _ in range(2))
    assert first == again
    assert first.alpha == 0.37
    with pytest.raises(ValueError, match="unknown parameter 'gloss'"):
        drain(fit(data, start, fixed=("gloss",)))
    with pytest.raises(ValueError, match="nothing is left"):
        drain(fit(data, start, fixed=tuple(p.name for p in parameters(start))))


def test_steps_carry_ever_better_models_and_a_fit_can_be_left() -> None:
    data = fit_data(brdf_from_text("phong:kd=0.3,ks=0.2,exponent=40"), count=500)
    steps = fit(data, brdf_from_text("blinn-phong"))
    seen = [next(steps) for _ in range(6)]
    assert all(fit_error(step.partial, data).objective >= 0 for step in seen)
    assert [step.done for step in seen] == sorted(step.done for step in seen)
    steps.close()


def even_light(brdf: Any) -> np.ndarray:
    """The share (3,) of light from all sides alike that is reflected."""
    theta = np.radians(np.arange(2.5, 90.0, 5.0))
    share = np.sin(2.0 * theta)
    return np.asarray(share @ albedo(brdf, surface_direction(theta, 0.0 * theta), count=1024) / share.sum())


def test_the_albedo_of_beams_is_that_of_the_brdf() -> None:
    brdf = brdf_from_text("ggx:kd=0.3/0.2/0.1,alpha=0.15,f0=0.1/0.3/0.6")
    beams = beams_of(brdf, sample(brdf, count=100))
    assert beams is not None
    np.testing.assert_allclose(beams.albedo, albedo(brdf, surface_direction(BEAMS, 0.0 * BEAMS)), rtol=0.02)
    assert np.isinf(beams.ceiling).all()


def test_channels_that_are_negative_in_the_shade_count_where_they_are_not() -> None:
    """A paint outside sRGB under a white highlight: its red is that of the highlight."""
    highlight = brdf_from_text("ggx:kd=0,alpha=0.2,f0=0.5")
    paint = SimpleNamespace(isotropic=True, reciprocal=True, f=lambda wi, wo: highlight.f(wi, wo) - (1e-3, 0.0, 0.0))
    beams = beams_of(cast(Any, paint), sample(highlight, count=10))
    assert beams is not None
    np.testing.assert_allclose(beams.albedo[:, 0], beams.albedo[:, 1], rtol=0.02)


def test_data_that_reflect_more_than_arrives_have_no_albedo() -> None:
    assert fit_data(brdf_from_text("phong:kd=0.9,ks=0.9,exponent=5"), count=100).beams is None


def test_a_colourful_paint_keeps_its_light_and_colour_in_a_model_that_cannot_be_it() -> None:
    """A red base under a narrow and a wide highlight, fitted with one highlight: each other norm loses a channel."""
    parts = ("lambert:albedo=0.5/0.1/0.03", "ggx:kd=0,alpha=0.06,f0=0.08", "ggx:kd=0,alpha=0.6,f0=0.3/0.25/0.2")
    truth = Layered(tuple(map(brdf_from_text, parts)))
    data = fit_data(truth, count=2000)
    wrong = {
        weighting: np.abs(even_light(drain(fit(data, Ggx(), weighting=weighting)).brdf) / even_light(truth) - 1.0)
        for weighting in WEIGHTINGS
    }
    assert wrong["joint"].max() < 0.02
    assert wrong["joint"].max() < 0.5 * min(wrong["log"].max(), wrong["cosine"].max())


def test_residual_by_angle_adds_up_to_the_whole() -> None:
    data = fit_data(brdf_from_text("phong:kd=0.3,ks=0.2,exponent=40"), count=3000)
    model = brdf_from_text("lambert:albedo=0.3")
    whole = fit_error(model, data).rmse_rel
    for residual in residual_by_angle(model, data).values():
        assert residual.count.sum() == 3000
        assert np.sqrt((residual.rms**2 * residual.count).sum() / 3000) == pytest.approx(whole, rel=1e-12)


def test_black_data_and_a_single_sample_are_fitted() -> None:
    up = np.array([[0.0, 0.0, 1.0]])
    for value in (0.0, 0.2):
        found = drain(fit(FitData(up, up, np.full((1, 3), value)), brdf_from_text("lambert")))
        assert found.brdf.f(up, up) == pytest.approx(np.full((1, 3), value), abs=1e-4)
    with pytest.raises(ValueError, match="finite"):
        FitData(up, up, np.full((1, 3), np.nan))


def test_a_table_of_directions_is_fitted_at_its_own_directions() -> None:
    """15° apart a highlight is wrong between the entries, so that a fit there misses width and colour."""
    truth = brdf_from_text("ggx:kd=0.2/0.1/0.05,alpha_x=0.2,alpha_y=0.5,f0=0.04")
    places = np.meshgrid(THETA, PHI, THETA, PHI, indexing="ij")
    values = truth.f(surface_direction(*places[:2]), surface_direction(*places[2:]))
    missing = np.zeros(values.shape[:4], bool)
    missing[1, 0, :, :10] = True
    values[missing] = 7.0  # what filling made of them is not believed
    found = drain(fit(fit_data(DirectionTable(THETA, PHI, THETA, PHI, values, missing)), type(truth)()))
    assert found.after.rmse_rel < 1e-9
    assert isinstance(found.brdf, GgxAnisotropic)
    assert found.brdf.alpha_x == pytest.approx(0.2, rel=1e-6)
    assert found.brdf.alpha_y == pytest.approx(0.5, rel=1e-6)


def test_a_table_of_grazing_directions_alone_is_fitted_between_them() -> None:
    theta, phi = np.radians([88.0, 89.0]), np.radians([0.0, 180.0])
    table = DirectionTable(theta, phi, theta, phi, np.full((2, 2, 2, 2, 3), 0.1), np.zeros((2, 2, 2, 2), bool))
    assert len(fit_data(table, count=50).value) == 50


def test_the_light_of_a_sphere_in_the_studio_is_that_of_its_image() -> None:
    """The beams of a fit beside the mean of a path-traced image of a sphere, over that of a white one."""
    brdf = brdf_from_text("ggx:kd=0.3/0.2/0.1,alpha=0.4,f0=0.1/0.3/0.6")
    beams = beams_of(brdf, sample(brdf, count=100))
    assert beams is not None
    means = []
    for shown in (brdf, brdf_from_text("lambert:albedo=1")):
        mesh = make_sphere()
        far = replace(frame(mesh.positions), eye=(0.0, 0.0, 100.0), target=(0.0, 0.0, 0.0), fov_deg=1.3)
        scene = Scene(mesh, far, shown, environment=make_built_in("studio"))
        found = drain(reference(scene, (48, 48), samples=64, max_depth=1))
        means.append(found.image[..., :3].sum(axis=(0, 1), dtype=np.float64))
    np.testing.assert_allclose(beams.seen[0], means[0] / means[1], rtol=0.03)

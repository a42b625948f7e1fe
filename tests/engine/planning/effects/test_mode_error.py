"""Planned errors of the modes against those that their bakes measure: at least 0.83 times, at most 3 times.

Bakes judge themselves by sums over the texels of finer maps, at vertices of the whole model, from views of their own.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from engine.brdf.brdf import Brdf, brdf_from_text
from engine.core.steps import drain
from engine.geometry.mesh import Mesh
from engine.light.cube_map import cube_of
from engine.light.environment import EnvironmentMap
from engine.light.sun_split import split_sun
from engine.planning.costs.setting import Setting
from engine.planning.effects.estimates import Scenery, scenery
from engine.planning.effects.lobe_error import EDGES, fine_light, lobe_error
from engine.planning.effects.mode_error import compute_bake_frames, mode_errors
from engine.planning.effects.sample import light_of
from engine.transport.gaussian.diffuse import DiffuseTransfer
from engine.transport.gaussian.error import Known, gaussian_error
from engine.transport.gaussian.fitting.fit import Fit, FitSettings, fit_vertices
from engine.transport.gaussian.samples import direct_samples, glossy_surface
from engine.transport.sh import bake as sh_bake
from engine.transport.sh.error import sh_error
from engine.transport.sh.lighting import project
from engine.transport.wavelet import bake as wavelet_bake
from engine.transport.wavelet.error import wavelet_error
from engine.transport.wavelet.transfer import vertex_frames
from tests.engine.planning.brute_force import dent, even_sphere, gradient_sky, lamp_sky, spots

#: Bounds of a prediction over the measured error.
MINIMUM, MAXIMUM = 0.83, 3.0

#: Vertices and views of each at which bakes are judged: few views would miss what is bright at grazing angles.
VERTICES, VIEWS = 16, 100

PAINT, SEMI, SHARP = "ggx:kd=0.5,alpha=0.3,f0=0.04", "ggx:kd=0.2,alpha=0.2,f0=0.5", "ggx:kd=0,alpha=0.1,f0=1"


def small_lamp() -> EnvironmentMap:
    """A lamp hardly larger than a texel of the maps that plans look at."""
    return lamp_sky(0.08, 400.0)


#: Name, mesh, light, BRDF, and the modes that are measured there.
SCENES: tuple[tuple[str, Callable[[], Mesh], Callable[[], EnvironmentMap], str, str], ...] = (
    ("ball, softbox, paint", even_sphere, lamp_sky, PAINT, "sh wavelet"),
    ("dents, softbox, paint", dent, lamp_sky, PAINT, "sh gaussian"),
    ("dents, softbox, diffuse", dent, lamp_sky, "lambert:albedo=0.5", "sh wavelet"),
    ("ball, small lamps, metal", even_sphere, spots, SEMI, "wavelet gaussian"),
    ("ball, small lamp, metal", even_sphere, small_lamp, SEMI, "sh gaussian"),
    ("dents, small lamps, mirror", dent, spots, SHARP, "sh gaussian"),
    ("dents, sky, brushed", dent, gradient_sky, "ward:alpha_x=0.1,alpha_y=0.4", "sh gaussian"),
)

#: Every mode once; the other scenes take --long.
ORDINARY = ("ball, softbox, paint", "dents, sky, brushed")


@pytest.mark.parametrize(
    ("place", "sky", "text", "modes"),
    [pytest.param(*row[1:], id=row[0], marks=[] if row[0] in ORDINARY else [pytest.mark.long]) for row in SCENES],
)
def test_T7_errors_of_modes_are_those_of_their_bakes(
    place: Callable[[], Mesh], sky: Callable[[], EnvironmentMap], text: str, modes: str
) -> None:
    mesh, light, brdf = cache(place)(), sky(), brdf_from_text(text)
    found = scenery(mesh, brdf, light)
    measured = {
        "sh": lambda: estimate_harmonics(mesh, brdf, light),
        "wavelet": lambda: estimate_wavelets(mesh, brdf, light),
        "gaussian": lambda: estimate_gaussians(mesh, brdf, light),
    }
    ratios = {}
    for mode in modes.split():
        setting, error = measured[mode]()
        ratios[str(setting)] = mode_errors(found).of(setting) / error
    assert all(MINIMUM <= ratio <= MAXIMUM for ratio in ratios.values()), ratios


def estimate_harmonics(mesh: Mesh, brdf: Brdf, light: EnvironmentMap) -> tuple[Setting, float]:
    setting = Setting("sh", {"order": 5})
    work = drain(sh_bake.prepare(mesh, brdf, sh_bake.BakeSettings(setting["order"], 32, 2, 0)))
    return setting, drain(sh_error(work, brdf, cube_of(light, 32), vertices=VERTICES, views=VIEWS)).rmse_rel


def estimate_wavelets(mesh: Mesh, brdf: Brdf, light: EnvironmentMap) -> tuple[Setting, float]:
    """Without suns, which wavelets receive as lamps."""
    setting = Setting("wavelet", {"terms": 2, "coefficients": 96, "cube": 64})
    factors = drain(wavelet_bake.factors_for(brdf, setting["terms"]))
    settings = wavelet_bake.BakeSettings(setting["cube"], setting["coefficients"], 2)
    work = wavelet_bake.prepare(mesh, factors, settings, None)
    radiance = cube_of(split_sun(light)[0], settings.edge).radiance
    return setting, drain(wavelet_error(work, brdf, radiance, vertices=VERTICES, views=VIEWS)).rmse_rel


def estimate_gaussians(mesh: Mesh, brdf: Brdf, light: EnvironmentMap) -> tuple[Setting, float]:
    """The lobes of some vertices, as a bake fits those that it tries."""
    setting = Setting("gaussian", {"lobes": 1})
    model = glossy_surface(mesh, brdf)
    diffuse = DiffuseTransfer(model, 5, 32, 2)
    chosen = np.unique(np.linspace(0, model.ground_vertex - 1, VERTICES).astype(np.int64))
    alone = [np.zeros(0, np.int64)] * len(chosen)
    settings = FitSettings(lobes=setting["lobes"])
    tried = fit_vertices(direct_samples(model, chosen, 128), alone, Fit.empty(1, settings.lobes).lobes, settings)
    known = Known(chosen, tried, diffuse.rows(chosen))
    error = drain(gaussian_error(model, diffuse, known, cube_of(light, 48), views=VIEWS))
    return setting, error.of(error.better)


def test_larger_parameters_are_never_said_to_be_worse() -> None:
    found = mode_errors(shiny())
    for mode, parameter, values in (("sh", "order", (3, 5, 8, 15)), ("gaussian", "lobes", (1, 2, 3))):
        errors = [found.of(Setting(mode, {parameter: value})) for value in values]
        assert errors == sorted(errors, reverse=True)


@pytest.mark.parametrize("text", ["oren-nayar:sigma_deg=40", "ward:alpha_x=0.2,alpha_y=0.6"])
def test_wavelets_are_predicted_in_the_frames_that_they_are_baked_in(text: str) -> None:
    """Of a pair of terms that a turn of the frame mixes, one may be cut off: then its error turns with the frame."""
    found = scenery(even_sphere(200), brdf_from_text(text), lamp_sky())
    rows = np.arange(0, len(found.fine.vertices), 2)
    baked = vertex_frames(found.sample.surface, found.brdf.isotropic)[found.fine.vertices[rows]]
    assert compute_bake_frames(found, rows) == pytest.approx(baked, abs=1e-12)


@cache
def shiny() -> Scenery:
    return scenery(even_sphere(200), brdf_from_text(SHARP), lamp_sky())


def test_a_second_look_at_lobes_finds_the_same() -> None:
    first = lobe_error(shiny(), 1)
    lobe_error.cache_clear()
    assert lobe_error(shiny(), 1) == first


@pytest.mark.parametrize("sky", [spots, gradient_sky])
def test_few_texels_of_unequal_size_are_the_whole_light(sky: Callable[[], EnvironmentMap]) -> None:
    """They cover the sphere once, and spherical harmonics of low order are those of the map."""
    light = light_of(sky())
    fine = fine_light(light)
    assert fine.area.sum() == pytest.approx(4.0 * np.pi, rel=1e-12)
    assert len(fine.area) < 6 * EDGES[-1] ** 2 // 8
    whole = cube_of(light.rest, EDGES[-1])
    np.testing.assert_allclose(fine.incident.sum(axis=0), project(whole, 1)[0] * np.sqrt(4.0 * np.pi), rtol=1e-6)
    some = np.random.default_rng(1).integers(len(fine.area), size=200)
    np.testing.assert_array_equal(fine.at(fine.direction[some]), some)
    assert fine.radiance.max() > 0.5 * whole.radiance.max()

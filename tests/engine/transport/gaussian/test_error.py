"""The error of lobes in radiance: what they are compared with is the integral, however narrow the highlight."""

from __future__ import annotations

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.light.cube_map import cube_directions, cube_of, texel_numbers
from engine.light.environment_file import open_environment
from engine.transport.gaussian import error
from engine.transport.gaussian.diffuse import DiffuseTransfer
from engine.transport.gaussian.error import Known, _exact, gaussian_error
from engine.transport.gaussian.fitting.fit import Fit, FitSettings, fit_vertices
from engine.transport.gaussian.fitting.views import view_directions
from engine.transport.gaussian.samples import direct_samples, draw, glossy_surface
from tests.engine.transport.gaussian.test_samples import sphere


@pytest.mark.parametrize("alpha", [0.0005, 0.02, 0.5])
def test_the_reference_is_the_integral_for_any_width(alpha: float) -> None:
    """Under even light it is the energy of the highlight, and of the diffuse part its colour."""
    surface = glossy_surface(sphere(), brdf_from_text(f"ggx:kd=0.3,alpha={alpha},f0=0.8"))
    vertex, edge = 30, 32
    views = view_directions()[view_directions() @ surface.frames[vertex, :, 2] > 0.3][::5]
    lit = (cube_directions(edge).reshape(-1, 3) @ surface.frames[vertex, :, 2] > 0.0).astype(np.float64)
    glossy, diffuse = _exact(surface, vertex, lit, np.ones((6 * edge * edge, 3)), views)
    drawn = draw(surface, vertex, views, 8192)
    energy = np.einsum("ms,msc->mc", drawn.weight, drawn.value)
    assert np.abs(glossy / energy - 1.0).max() < 0.02
    assert np.abs(diffuse / 0.3 - 1.0).max() < 0.01


def test_a_narrow_highlight_sees_the_texel_it_points_at() -> None:
    surface = glossy_surface(sphere(), brdf_from_text("ggx:kd=0,alpha=0.0005,f0=1"))
    vertex, edge = 30, 16
    frame = surface.frames[vertex]
    view = frame @ np.array([0.3, 0.1, np.sqrt(0.9)])
    mirrored = frame @ np.array([-0.3, -0.1, np.sqrt(0.9)])
    light = np.zeros((6 * edge * edge, 3))
    light[texel_numbers(mirrored[None], edge)[0]] = 2.0
    everywhere = np.ones(6 * edge * edge)
    assert _exact(surface, vertex, everywhere, light, view[None])[0][0, 0] == pytest.approx(2.0, rel=0.01)
    assert np.array_equal(texel_numbers(cube_directions(8).reshape(-1, 3), 8), np.arange(6 * 64))


def test_lobes_are_off_by_their_distance_and_all_energy_helps_under_even_light() -> None:
    """Under light that is the same everywhere, lobes with all energy are right but for what mixing views adds."""
    surface = glossy_surface(sphere(), brdf_from_text("ggx:kd=0.2,alpha=0.3,f0=0.5"))
    vertices = np.arange(10, 60, 10)
    nobody = [np.zeros(0, np.int64)] * len(vertices)
    fitted = fit_vertices(direct_samples(surface, vertices, 96), nobody, Fit.empty(0, 1).lobes, FitSettings())
    diffuse = DiffuseTransfer(surface, 5, 16, 2)
    known = Known(vertices, fitted, diffuse.rows(vertices))
    cube = cube_of(open_environment("overcast"), 16)
    even = type(cube)(np.ones_like(cube.radiance), cube.name, cube.health)
    found = drain(gaussian_error(surface, diffuse, known, even, views=12))
    assert found.glossy_preserving_rmse_rel < 0.06 < found.glossy_plain_rmse_rel
    assert found.better == "preserving"
    assert found.of("plain") == found.plain_rmse_rel < found.glossy_plain_rmse_rel  # the diffuse part is right


def test_views_along_the_horizon_do_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is seen at a cosine of 0 covers no area."""
    surface = glossy_surface(sphere(), brdf_from_text("ggx:kd=0.2,alpha=0.3,f0=0.5"))
    vertices = np.array([10])
    surface.frames[10] = np.eye(3)
    nobody = [np.zeros(0, np.int64)]
    fitted = fit_vertices(direct_samples(surface, vertices, 16), nobody, Fit.empty(0, 1).lobes, FitSettings())
    diffuse = DiffuseTransfer(surface, 3, 8, 1)
    cube = cube_of(open_environment("overcast"), 8)
    towards = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    monkeypatch.setattr(error, "normalize", lambda _vectors: towards)
    known = Known(vertices, fitted, diffuse.rows(vertices))
    assert drain(gaussian_error(surface, diffuse, known, cube, views=3)).pairs == 1

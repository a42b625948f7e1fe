"""The lobe inspector's results for a vertex and a view."""

from __future__ import annotations

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.directions import normalize
from engine.core.steps import drain
from engine.figures.inspected import EDGE, PIXELS, inspect
from engine.transport.gaussian.fitting.views import view_directions
from engine.transport.gaussian.samples import GlossySurface, glossy_surface
from tests.engine.gl.relit_scenes import sphere
from tests.engine.transport.gaussian.synthetic_lobes import mirror_lobes, transport_of


@pytest.fixture(scope="module")
def surface() -> GlossySurface:
    return glossy_surface(sphere(1), brdf_from_text("ggx:kd=0,alpha=0.3,f0=1"))


def observe(surface: GlossySurface, vertex: int, tilt: float = 0.4) -> np.ndarray:
    frame = surface.frames[vertex]
    return np.asarray(np.cos(tilt) * frame[:, 2] + np.sin(tilt) * frame[:, 0])


def test_lobes_wavelets_and_harmonics_take_as_many_numbers(surface: GlossySurface) -> None:
    found = drain(inspect(surface, 3, observe(surface, 3), lobes=2))
    assert [each.numbers for each in found.approximations] == [14, 14, 16]
    assert not found.baked
    assert found.cosine == pytest.approx(np.cos(0.4))
    for each in found.approximations:
        assert 0.0 < each.error_rel < 1.0
        assert each.image.shape == (PIXELS, PIXELS)
    gaussians, wavelets, spherical_harmonics = (each.error_rel for each in found.approximations)
    assert gaussians < min(wavelets, spherical_harmonics)


def test_the_image_is_the_hemisphere_by_equal_areas(surface: GlossySurface) -> None:
    """Its mean over the disc times 2 π is the integral; the highlight lies opposite to the viewer."""
    found = drain(inspect(surface, 5, observe(surface, 5)))
    inside = np.isfinite(found.image)
    assert inside.mean() == pytest.approx(np.pi / 4.0, rel=0.01)
    row, column = np.unravel_index(np.nanargmax(found.image), found.image.shape)
    assert column < PIXELS / 2 - 10, "the view leans to the right, along the tangent"
    assert abs(row - PIXELS / 2) < 6
    assert found.highest >= np.nanmax(found.image)
    from engine.figures.lobe_fit import texels
    from engine.transport.gaussian.samples import transport_at

    direction, area = texels(EDGE)
    whole = float(area @ transport_at(surface, 5, normalize(observe(surface, 5)), direction)[:, 0])
    assert 2.0 * np.pi * np.nanmean(found.image) == pytest.approx(whole, rel=0.01)


def test_baked_lobes_are_shown_as_they_are_drawn(surface: GlossySurface) -> None:
    mesh = surface.mesh
    transport = transport_of(mesh, mirror_lobes(normalize(mesh.normals), 0.3, 2.0))
    view = view_directions()[int(np.argmax(view_directions() @ surface.frames[7][:, 2]))]
    found = drain(inspect(surface, 7, view, transport, lobes=3))
    assert found.baked
    assert found.approximations[0].numbers == 7
    expected = 2.0 * (0.2126 * 1.0 + 0.7152 * 0.7 + 0.0722 * 0.4)
    assert np.nanmax(found.approximations[0].image) == pytest.approx(expected, rel=0.01)


def test_views_from_behind_are_black(surface: GlossySurface) -> None:
    found = drain(inspect(surface, 2, -surface.frames[2][:, 2]))
    assert found.cosine < 0.0
    assert np.nanmax(found.image) == 0.0
    assert [each.error_rel for each in found.approximations] == [0.0, 0.0, 0.0]

"""Images of Gaussian lobes: those of the mode itself, brighter without shadows, and nearer with them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.figures.figure import Settings, coarse_bust
from engine.figures.papers.gaussian_lobes import ORDER, coarse_knot, fit_lobes, without_shadows
from engine.figures.papers.green_6 import green_6
from engine.figures.papers.green_7 import green_7
from engine.geometry.camera import frame
from engine.geometry.mesh import Mesh
from engine.light.environment import reduce
from engine.light.environment_file import open_environment
from engine.render.transported import image_of
from engine.transport.gaussian import bake as gaussian_bake
from engine.transport.gaussian.samples import glossy_surface
from engine.transport.relight import relight_gaussians

#: Light whose prefiltering takes milliseconds.
STUDIO = reduce(open_environment("studio"), 32)


def corner() -> Mesh:
    """A floor and a wall on it, of few vertices."""
    steps = np.linspace(-1.0, 1.0, 4)
    x, z = np.meshgrid(steps, steps, indexing="ij")
    floor = np.stack([x, np.zeros_like(x), z], -1).reshape(-1, 3)
    wall = np.stack([x, z + 1.0, np.full_like(x, -1.0)], -1).reshape(-1, 3)
    index = np.arange(16).reshape(4, 4)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]))
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)])
    normals = np.repeat([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], 16, axis=0).astype(np.float32)
    both = np.concatenate([faces, faces[:, ::-1] + 16]).astype(np.int32)
    uv = np.concatenate([floor[:, [0, 2]], wall[:, :2]]).astype(np.float32)
    return Mesh(np.concatenate([floor, wall]), normals, uv, both, "corner")


def test_lobes_in_memory_are_those_of_the_bake(tmp_path: Path) -> None:
    brdf = brdf_from_text("ggx:kd=0.2,alpha=0.4,f0=0.5")
    mesh = corner()
    settings = gaussian_bake.BakeSettings(samples=48, weights="plain", order=ORDER)
    work = drain(gaussian_bake.prepare(mesh, brdf, settings, probes=2))
    expected = drain(gaussian_bake.bake(tmp_path / "a.transport", work)).transport
    own = drain(fit_lobes(glossy_surface(mesh, brdf), 1, 48))
    found = own.transport(own.fit.lobes)
    camera, size = frame(mesh.positions), (24, 24)
    images = [drain(image_of(relight_gaussians(each, STUDIO), camera, size)).image for each in (expected, found)]
    assert images[0].max() > 0.01
    np.testing.assert_allclose(images[1], images[0], rtol=1e-4, atol=1e-6)


def test_without_shadows_nothing_is_darker() -> None:
    surface = glossy_surface(corner(), brdf_from_text("ggx:kd=0.2,alpha=0.4,f0=0.5"))
    assert not surface.of.free.all()
    energies = [drain(fit_lobes(each, 1, 48)).fit.energy.sum(axis=2) for each in (surface, without_shadows(surface))]
    assert (energies[1] >= energies[0] - 1e-6).all()
    assert energies[1].sum() > 1.05 * energies[0].sum()


def test_visibility_comes_nearer_to_the_reference() -> None:
    figure = drain(green_6(Settings(environment=STUDIO, quick=True)))
    with_it, without = (shown.error.rmse_rel for shown in figure.rows[0].images if shown.error)
    assert with_it < without


def test_both_numbers_of_lobes_are_drawn() -> None:
    figure = drain(green_7(Settings(mesh=corner(), environment=STUDIO, quick=True)))
    assert [shown.parameters.get("lobes") for shown in figure.rows[0].images] == [1, 2, None]
    assert all(shown.error.rmse_rel < 0.6 for shown in figure.rows[0].images if shown.error)


def test_the_coarse_knot_is_closed() -> None:
    mesh = coarse_knot(8, 48)
    assert len(mesh.positions) == 9 * 17
    ring = mesh.positions.reshape(9, 17, 3)
    np.testing.assert_allclose(ring[0], ring[-1], atol=1e-12)
    np.testing.assert_allclose(ring[:, 0], ring[:, -1], atol=1e-12)
    assert len(coarse_bust(9, 13).positions) == 117

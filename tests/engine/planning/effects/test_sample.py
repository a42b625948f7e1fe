"""Pixels that a camera's sample takes: none of a silhouette, and more where lamps are reflected, without a bias."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.brdf.brdf import Brdf, brdf_from_text
from engine.core.directions import normalize
from engine.geometry.camera import Camera
from engine.geometry.mesh import Mesh
from engine.light.environment import EnvironmentMap
from engine.light.lamps import Lamp, lights_of_all
from engine.planning.effects.sample import COMPARED, pixels_of, sample, sum_lamps
from engine.transport.baking.visibility import receivers
from tests.engine.planning.brute_force import sphere

EYE = Camera((0.0, 0.0, 4.0))
DARK = EnvironmentMap(np.zeros((16, 32, 3), np.float32))


def test_pixels_are_wholly_of_the_model() -> None:
    """The ball of radius 1 ends where sin θ = 1/4: no pixel lies nearer to its edge than half of its own side."""
    mesh = sphere(96)
    found = pixels_of(EYE, receivers(mesh), len(mesh.faces), 100_000, np.random.default_rng(0))
    across = math.tan(math.asin(0.25)) - np.hypot(found.direction[:, 0], found.direction[:, 1]) / -found.direction[:, 2]
    half = math.tan(math.radians(EYE.fov_deg) / 2.0) / COMPARED
    assert across.min() == pytest.approx(half, rel=0.5)
    assert across.min() > 0.9 * half


def test_a_model_thinner_than_a_pixel_keeps_what_shows_it() -> None:
    points = np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.015, 0.0], [-1.0, 0.015, 0.0]])
    normals = np.tile(np.array([0.0, 0.0, 1.0], np.float32), (4, 1))
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    wire = Mesh(points, normals, points[:, :2].astype(np.float32), faces, "wire")
    assert len(pixels_of(EYE, receivers(wire), 2, 1000, np.random.default_rng(0)).face) > 10


@pytest.mark.parametrize(
    "text", ["phong:kd=0.2,ks=0.4,exponent=200", pytest.param("lambert:albedo=0.5", marks=pytest.mark.long)]
)
def test_few_pixels_that_know_the_lamp_tell_the_energy_of_many(text: str) -> None:
    """Energy of the light of one lamp: 64 guided pixels against thousands, within three standard errors."""
    mesh, brdf = sphere(96), brdf_from_text(text)
    lamp = Lamp(tuple(normalize(np.array([0.5, 0.4, 1.0]))), (5.0, 5.0, 5.0))

    def energy(seed: int, points: int, guide: Brdf | None) -> float:
        looked = sample(mesh, DARK, points=points, views=2, edge=2, seed=seed, camera=EYE, lamps=(lamp,), brdf=guide)
        at = (looked.of, looked.vertices, looked.frames, looked.views[:, 0])
        radiance = sum_lamps(*at, lights_of_all((lamp,)), brdf)
        return float(((radiance**2).sum(axis=1) * looked.weight[:, 0]).mean())

    many = np.array([energy(seed, 2048, None) for seed in range(8)])
    guided, even = (np.array([energy(seed, 64, guide) for seed in range(60)]) for guide in (brdf, None))
    uncertain = math.hypot(many.std() / math.sqrt(8.0), guided.std() / math.sqrt(60.0))
    assert guided.mean() == pytest.approx(many.mean(), abs=3.0 * uncertain, rel=0.0)
    assert uncertain < 0.1 * many.mean()
    if text.startswith("phong"):
        assert guided.std() < 0.4 * even.std()

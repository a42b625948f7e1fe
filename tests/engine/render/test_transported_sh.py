"""Images of transport in spherical harmonics against the reference, under light that has no high bands."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.accuracy.compare import compare
from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.geometry.camera import Camera
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.light.environment import EnvironmentMap, texel_directions
from engine.render.reference import reference
from engine.render.transported import image_of
from engine.scene.scene import Scene
from engine.transport.relight import RelightSh
from engine.transport.sh.bake import BakeSettings, bake, prepare
from engine.transport.sh.lighting import scene_coefficients
from engine.transport.sh.transfer import transfer

SIZE = (48, 40)


def sphere(turns: int = 40, rows: int = 19) -> Mesh:
    """A sphere of `turns` × `rows` vertices between its poles."""
    theta, phi = np.meshgrid(np.pi * np.arange(1, rows + 1) / (rows + 1), 2.0 * np.pi * np.arange(turns) / turns)
    ring = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], axis=-1)
    positions = np.concatenate([[[0.0, 1.0, 0.0]], ring.reshape(-1, 3), [[0.0, -1.0, 0.0]]])
    faces = []
    for turn in range(turns):
        here, beside = 1 + turn * rows, 1 + (turn + 1) % turns * rows
        faces += [(0, here, beside), (here + rows - 1, len(positions) - 1, beside + rows - 1)]
        for a, b in ((here + row, beside + row) for row in range(rows - 1)):
            faces += [(a, a + 1, b + 1), (a, b + 1, b)]
    uv = np.zeros((len(positions), 2), np.float32)
    return Mesh(positions, positions.astype(np.float32), uv, np.array(faces, np.int32), "ball")


def smooth_sky() -> EnvironmentMap:
    """Of the bands 0 to 2, and positive."""
    x, y, z = np.moveaxis(texel_directions(64, 128), -1, 0)
    radiance = np.stack([1.0 + 0.8 * y, 1.0 + 0.5 * x * z + 0.3 * y, 1.0 - 0.6 * x], axis=-1)
    return EnvironmentMap(radiance.astype(np.float32), "smooth")


@pytest.mark.parametrize(
    ("text", "depth", "bound"),
    [
        pytest.param("lambert:albedo=0.7/0.5/0.3", 1, 0.02, marks=pytest.mark.long),
        ("lambert:albedo=0.7/0.5/0.3", 3, 0.02),
        pytest.param("ggx:alpha=0.4", 1, 0.02, marks=pytest.mark.long),
        ("ggx:alpha=0.4", 3, 0.02),
    ],
)
def test_a_sphere_on_the_ground_looks_as_in_the_reference(text: str, depth: int, bound: float, tmp_path: Path) -> None:
    ground = Ground(albedo=0.6, cells=24, extent=2.5)
    camera = Camera((3.0, 2.2, 4.0), (0.0, -0.3, 0.0))
    scene = Scene(
        sphere(), camera, brdf_from_text(text), environment=smooth_sky(), environment_rotation=0.7, ground=ground
    )
    settings = BakeSettings(order=5, edge=16, fine=4, bounces=depth - 1, gather=128)
    transport = drain(
        bake(tmp_path / "a.transport", drain(prepare(scene.mesh, scene.brdf, settings, ground)))
    ).transport
    rows = transfer(transport, scene_coefficients(scene, 5))
    image = drain(image_of(RelightSh(transport, rows), camera, SIZE, 2)).image
    truth = drain(reference(scene, SIZE, samples=128, max_depth=depth))
    inside = (image[..., 3] == 1.0) & (truth.image[..., 3] == 1.0)
    error, noise = compare(image, truth.image, inside).rmse_rel, truth.uncertainty_rmse_rel
    assert noise is not None
    assert error**2 - noise**2 < bound**2, (error, noise)
    # and the mean, in which the noise of some thousand pixels is gone
    assert image[inside].mean() == pytest.approx(truth.image[inside].mean(), rel=0.005)

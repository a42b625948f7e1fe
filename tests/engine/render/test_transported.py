"""Images of baked transport: what a pixel must be, and what must not be drawn."""

from __future__ import annotations

import numpy as np
import pytest

from engine.core.steps import drain
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.separable_factors import SeparableFactors
from engine.geometry.camera import Camera, frame
from engine.geometry.mesh import Mesh
from engine.render.transported import image_of
from engine.transport.relight import RelightWavelets
from engine.transport.wavelet.transfer import Vectors16, WaveletTransport, radiance_from


def quad(terms: int = 2) -> tuple[WaveletTransport, np.ndarray]:
    """A square that faces +Z, of random factors, and K-tuples that make every vertex another."""
    positions = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
    normals = np.tile(np.array([0.0, 0.0, 1.0], np.float32), (4, 1))
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    mesh = Mesh(positions, normals, np.zeros((4, 2), np.float32), faces, "quad")
    rng = np.random.default_rng(4)
    maps = rng.random((terms, 16, 16, 3)).astype(np.float32)
    factors = SeparableFactors(HemisphereMap("orthographic", 16), "in-out", maps, maps, isotropic=True)
    empty = np.zeros((4 * terms, 8))
    vectors = Vectors16(
        empty.astype(np.uint16), empty.astype(np.uint32), empty[:, :3].astype(np.float32), empty[:, 0].astype(np.uint16)
    )
    return WaveletTransport(mesh, 4, factors, 0.0, 16, vectors), rng.random((4 * terms, 3))


def test_near_a_vertex_the_image_is_its_radiance_and_between_them_their_mean() -> None:
    transport, rows = quad()
    camera = Camera((0.3, 0.2, 4.0), (0.0, 0.0, 0.0), fov_deg=30.0)
    found = drain(image_of(RelightWavelets(transport, rows), camera, (301, 301), 1))
    image, at_vertices = found.image, radiance_from(transport, rows, camera.eye).value
    covered = np.argwhere(image[..., 3] > 0.0)
    corner = covered[np.argmax(covered[:, 0] - covered[:, 1])]
    assert image[tuple(corner)][:3] == pytest.approx(at_vertices[0], rel=0.05)
    assert image[..., :3].max() <= at_vertices.max() * 1.001
    middle = image[150, 150, :3]
    assert middle == pytest.approx(0.5 * (at_vertices[0] + at_vertices[2]), rel=0.2)


def test_the_back_is_black_and_around_it_is_nothing() -> None:
    transport, rows = quad()
    found = drain(image_of(RelightWavelets(transport, rows), Camera((0.0, 0.0, -6.0)), (40, 30), 2)).image
    assert found[..., 3].max() == 1.0
    assert not found[..., :3].any()
    assert not found[0].any()


def test_coverage_is_that_of_the_sub_pixels_and_sums_below_0_are_reported() -> None:
    transport, rows = quad()
    camera = frame(transport.mesh.positions)
    one = drain(image_of(RelightWavelets(transport, rows), camera, (40, 30), 3))
    assert set(np.round(9.0 * one.image[..., 3]).ravel().astype(int)) <= set(range(10))
    assert one.negative_rel == 0.0
    mixed = drain(image_of(RelightWavelets(transport, rows - 0.5), camera, (40, 30), 3))
    assert mixed.negative_rel > 0.0
    assert mixed.image.min() >= 0.0
    np.testing.assert_allclose(
        drain(image_of(RelightWavelets(transport, 2.0 * rows), camera, (40, 30), 3)).image[..., :3],
        2.0 * one.image[..., :3],
        rtol=1e-5,
    )


@pytest.mark.parametrize(("size", "samples"), [((0, 4), 1), ((4, 4), 0)])
def test_images_that_cannot_be_are_refused(size: tuple[int, int], samples: int) -> None:
    transport, rows = quad()
    with pytest.raises(ValueError, match="not possible"):
        drain(image_of(RelightWavelets(transport, rows), frame(transport.mesh.positions), size, samples))

"""Light between parts of a model: what a wall sends, and that it sends nothing backwards."""

from __future__ import annotations

import numpy as np
import pytest

from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import caster_of
from engine.transport.baking.visibility import receivers
from engine.transport.sh.interreflection import Surroundings, gather

#: Rays of each vertex; as dense as the cosine, they count a wall's share to about one in their root.
RAYS = 4096


def floor_under_a_lid(facing_down: bool) -> Mesh:
    """One vertex of interest at the origin, looking up, and a square above it that covers all but little of the sky."""
    size, height = 20.0, 1.0
    corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
    floor = [(0.0, 0.0, 0.0), (0.01, 0.0, 0.0), (0.0, 0.0, -0.01)]
    lid = [(size * x, height, size * z) for x, z in corners]
    faces = np.array([(0, 1, 2), (3, 4, 5), (3, 5, 6)], np.int32)
    if not facing_down:
        faces[1:] = faces[1:, ::-1]
    side = -1.0 if facing_down else 1.0
    normals = np.array([(0.0, 1.0, 0.0)] * 3 + [(0.0, side, 0.0)] * 4, np.float32)
    return Mesh(np.array([*floor, *lid]), normals, np.zeros((7, 2), np.float32), faces, "lid")


@pytest.mark.parametrize("facing_down", [True, False])
def test_a_surface_lights_what_it_faces_and_is_black_from_behind(facing_down: bool) -> None:
    mesh = floor_under_a_lid(facing_down)
    around = Surroundings(mesh.positions, mesh.faces, receivers(mesh, caster_of(mesh)), 3, RAYS)
    sent = np.zeros((7, 1, 9), np.float32)
    sent[3:] = 2.0
    found = gather(around, np.array([0]), sent)
    if not facing_down:
        assert not found.any()
        return
    # the lid is a cone of half angle atan(20) at least and atan(20 √2) at most: sin² of it is its share of the cosine
    assert 2.0 * (400.0 / 401.0 - 0.01) <= found.min() <= found.max() <= 2.0 * (800.0 / 801.0 + 1e-6)

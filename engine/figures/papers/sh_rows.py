"""Light at vertices in spherical harmonics of several orders from one set of rays, without keeping any matrices.

The matrix of a lower order is a corner of that of the highest, so a sweep of orders takes no longer than its last
step. A matrix of order 15 takes 200 kB; what it makes of the light takes 2.7 kB.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from engine.core.one_thread import one_thread
from engine.core.steps import Step, Steps
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import caster_of
from engine.transport.baking.visibility import receivers, visibility_shares
from engine.transport.sh.bake import default_edge
from engine.transport.sh.basis import order_of
from engine.transport.sh.rotation import rotate_into_frames
from engine.transport.sh.transfer import matrices, tangent_frames, visibility_harmonics

#: Parts along a side into which a texel is cut where visibility changes.
FINE = 4

#: Vertices whose matrices are held at once.
CHUNK = 64

Floats = NDArray[np.float64]


def light_at_vertices(
    mesh: Mesh, lights: Sequence[Floats], edge: int | None = None
) -> Steps[list[NDArray[np.float32]]]:
    """For each of `lights` (order², 3) in the world what (V, order², 3) of it reaches each vertex, in its frame.

    Vertices that see their whole hemisphere need no rays: there light is rotated and nothing else.
    """
    most = max(order_of(len(light)) for light in lights)
    edge = edge or default_edge(most)
    frames, of = tangent_frames(mesh), receivers(mesh, caster_of(mesh))
    found = [np.empty((len(mesh.positions), *light.shape), np.float32) for light in lights]
    free = np.flatnonzero(of.free)
    for light, rows in zip(lights, found, strict=True):
        if free.size:
            rows[free] = rotate_into_frames(light, frames[free])
        yield Step(0.0, "turning the light into the frames of the vertices")
    shaded = np.flatnonzero(~of.free)
    for start in range(0, len(shaded), CHUNK):
        vertices = shaded[start : start + CHUNK]
        counts = np.concatenate([counts for _, counts in visibility_shares(of, edge, FINE, vertices)])
        with one_thread():
            seen = visibility_harmonics(counts, FINE**2, edge, 2 * most - 1)
        whole = matrices(seen, frames[vertices], np.zeros(len(vertices), np.bool_))
        for light, rows in zip(lights, found, strict=True):
            rows[vertices] = whole[:, : len(light), : len(light)] @ light.astype(np.float32)
        done = min(start + CHUNK, len(shaded))
        yield Step(done / len(shaded), f"shadows of vertex {done:,} of {len(shaded):,}")
    return found

"""A simpler model for rays to meet: as Wang2004 (Table 1) sample visibility on fewer triangles.

Vertices that share a cell of a grid become one, at their mean, and triangles that lose a corner go
(Rossignac1993). The surface moves by less than the
diagonal of a cell, so rays must start that far above it, and shadows of what is nearer are lost. What that costs and
saves is measured against the model itself.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import normalize
from engine.core.errors import UsageError
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import RayCaster
from engine.light.cube_map import cube_directions, cube_solid_angles
from engine.transport.baking.visibility import Receivers, receivers, visibility_shares

#: Cells along the longest side of the model.
FEWEST_CELLS, MAX_CELLS = 8, 4096


@dataclass(frozen=True, eq=False)
class Occluder:
    """Surface that rays meet, and the height above a vertex at which they start (0 for the model itself)."""

    caster: RayCaster
    lift: float = 0.0

    def receivers(self, mesh: Mesh) -> Receivers:
        """The vertices of `mesh` as places where light arrives, seen through this occluder."""
        of = receivers(mesh, self.caster)
        if self.lift == 0.0:
            return of
        return replace(of, origin=of.origin + self.lift * normalize(of.normal))


@dataclass(frozen=True)
class OccluderError:
    """Error and savings of a simpler occluder.

    `open_rms` is the root mean square difference of the open share of the cosine-weighted hemisphere, `faces` are left
    of all, `time_rel` is the time for the rays over that with the model itself.
    """

    open_rms: float
    faces: int
    time_rel: float


def simplify(mesh: Mesh, cells: int) -> Occluder:
    """`mesh` with its vertices merged in a grid of `cells` along its longest side; UsageError for too few or many."""
    if not FEWEST_CELLS <= cells <= MAX_CELLS:
        raise UsageError(f"an occluder of {cells} cells a side is outside {FEWEST_CELLS} … {MAX_CELLS}")
    low = mesh.positions.min(axis=0)
    size = float(np.ptp(mesh.positions, axis=0).max()) / cells
    cell = np.floor((mesh.positions - low) / size).astype(np.int64) if size > 0.0 else np.zeros((1, 3), np.int64)
    number = np.unique(cell, axis=0, return_inverse=True)[1].reshape(-1)
    count = np.bincount(number)
    merged = np.stack([np.bincount(number, mesh.positions[:, axis]) / count for axis in range(3)], axis=-1)
    faces = number[mesh.faces]
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return Occluder(RayCaster(merged, faces[whole]), size * 3.0**0.5)


def occluder_error(mesh: Mesh, occluder: Occluder, edge: int, vertices: NDArray[np.int64]) -> OccluderError:
    """Compare `occluder` with `mesh` itself at some vertices, on a cube map of `edge`."""
    weight = np.tile(cube_solid_angles(edge).reshape(-1), 6) / np.pi
    cosine = np.maximum(normalize(mesh.normals[vertices]) @ cube_directions(edge).reshape(-1, 3).T, 0.0)
    found, times = [], []
    for each in (Occluder(RayCaster(mesh.positions, mesh.faces)), occluder):
        of = each.receivers(mesh)
        started = time.perf_counter()
        shares = np.concatenate([counts for _, counts in visibility_shares(of, edge, 1, vertices, skip=False)])
        times.append(time.perf_counter() - started)
        found.append((shares * cosine) @ weight)
    difference = float(np.sqrt(np.mean((found[1] - found[0]) ** 2)))
    return OccluderError(difference, len(occluder.caster.faces), times[1] / times[0])

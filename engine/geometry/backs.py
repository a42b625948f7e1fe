"""Backs of open surfaces, which are lit and seen as their fronts are.

A model of triangles has one side. Direct light and the reference shade whichever side a camera sees; what is baked at
vertices is that of their normals. So a face whose back can be seen from outside gets another one behind it, at the same
place and turned the other way round, with vertices of its own; rays meet the one that faces them
(`engine.geometry.ray_caster`).
Cost: `RAYS` rays for each face of a surface with borders; nothing for closed ones.
"""

from __future__ import annotations

from types import MappingProxyType
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import normalize, world_from_tangent
from engine.core.health import Health
from engine.geometry.ground import Ground, with_ground
from engine.geometry.mesh import BACKS, Mesh
from engine.geometry.ray_caster import caster_of, offset_origins

#: Rays from the back of each face, and how many of them leave the scene where it counts as open: the inside of a
#: bunny whose base has holes, say, sees an eighth of the sky nowhere but beside them.
RAYS, OPEN = 16, 2

#: Faces whose rays are traced at a time.
FACES = 1 << 15


def with_backs(mesh: Mesh, ground: Ground | None = None) -> Mesh:
    """`mesh` with a face behind each that can be seen from its back, above `ground`; the mesh itself where none can.

    The faces with a back come first, then the backs in the same order, then the others; vertices keep their numbers.
    """
    known = _KNOWN.setdefault(mesh, {})
    if ground not in known:
        known[ground] = _add_backs(mesh, ground)
    return known[ground] or mesh


#: None for meshes without: a value that is the key itself would keep it for ever.
_KNOWN: WeakKeyDictionary[Mesh, dict[Ground | None, Mesh | None]] = WeakKeyDictionary()


def _add_backs(mesh: Mesh, ground: Ground | None) -> Mesh | None:
    if BACKS in mesh.health.figures or mesh.topology.open_edges == 0:
        return None
    seen = _see_backs(mesh, ground)
    if not seen.any():
        return None
    fronts = mesh.faces[seen]
    used, place = np.unique(fronts, return_inverse=True)
    behind = (place.reshape(-1, 3)[:, ::-1] + len(mesh.positions)).astype(np.int32)
    figures = {**mesh.health.figures, BACKS: float(len(fronts))}
    return Mesh(
        np.concatenate([mesh.positions, mesh.positions[used]]),
        np.concatenate([mesh.normals, -mesh.normals[used]]),
        np.concatenate([mesh.uv, mesh.uv[used]]),
        np.concatenate([fronts, behind, mesh.faces[~seen]]),
        mesh.name,
        Health(MappingProxyType(figures), mesh.health.findings),
        mesh.brushing,
        None if mesh.part is None else np.concatenate([mesh.part[seen], mesh.part[seen], mesh.part[~seen]]),
        mesh.part_names,
        None if mesh.colours is None else np.concatenate([mesh.colours, mesh.colours[used]]),
    )


def _see_backs(mesh: Mesh, ground: Ground | None) -> NDArray[np.bool_]:
    """(F,) the faces from whose backs `OPEN` rays leave the scene."""
    surface = mesh if ground is None else with_ground(mesh, ground)[0]
    caster = caster_of(surface)
    corners = mesh.positions[mesh.faces]
    middle = corners.mean(axis=1)
    down = normalize(-np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    towards = _spread_rays()
    seen = np.zeros(len(middle), np.bool_)
    for start in range(0, len(middle), FACES):
        part = slice(start, start + FACES)
        origins = np.repeat(offset_origins(middle[part], down[part], caster), RAYS, axis=0)
        rays = np.einsum("fij,rj->fri", world_from_tangent(down[part]), towards).reshape(-1, 3)
        seen[part] = (~caster.occluded(origins, rays)).reshape(-1, RAYS).sum(axis=1) >= OPEN
    return seen


def _spread_rays() -> NDArray[np.float64]:
    """(RAYS, 3) directions of even projected area above a surface: a spiral."""
    number = np.arange(RAYS) + 0.5
    radius, turn = np.sqrt(number / RAYS), number * np.pi * (3.0 - np.sqrt(5.0))
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), np.sqrt(1.0 - radius**2)], axis=-1)

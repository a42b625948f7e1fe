"""Error of SH transport against the sum over all texels, as defined in `radiance_error`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from engine.brdf.brdf import Brdf
from engine.core.steps import Step, Steps
from engine.light.cube_map import CubeMap, cube_directions, cube_solid_angles
from engine.transport.baking.parts import Kinds
from engine.transport.baking.radiance_error import Deviation, RadianceError, choose_tried_pairs, exact_radiance
from engine.transport.baking.spatially_varying import Variation, vary_brdf
from engine.transport.baking.visibility import receivers
from engine.transport.sh.bake import Work, baker_of
from engine.transport.sh.basis import Window, apply_window
from engine.transport.sh.brdf_table_varying import VariedTable
from engine.transport.sh.lighting import project
from engine.transport.sh.transfer import tangent_frames


def sh_error(
    work: Work,
    brdf: Brdf,
    cube: CubeMap,
    *,
    variations: Sequence[Variation] = (),
    kinds: Kinds | None = None,
    vertices: int = 400,
    views: int = 20,
    window: Window = "none",
    seed: int = 1,
) -> Steps[RadianceError]:
    """The error of the bake `work` of the BRDF `brdf` under a cube map, on vertices of the model.

    Where the BRDF varies, or parts have their own (`kinds`), each vertex is compared with its own.

    ValueError where the edge of the map is not that over which visibility is counted.
    """
    if cube.edge != work.settings.edge:
        raise ValueError(f"a cube map of edge {cube.edge} does not fit visibility over {work.settings.edge}")
    chosen, towards = choose_tried_pairs(work.ground_vertex, vertices, views, seed)
    yield Step(0.0, "casting rays")
    of = receivers(work.surface, work.caster)
    baker = baker_of(work, of)
    counts = baker.visible(chosen)
    light = apply_window(project(cube, work.settings.order), window)
    count = 1 if work.table.diffuse else work.settings.order**2
    step = max(1, 2**24 // work.settings.order**4)
    frames = tangent_frames(work.surface)
    albedo = np.broadcast_to(work.table.even_albedo, (work.ground_vertex, 3))
    directions = cube_directions(cube.edge).reshape(-1, 3)
    incident = cube.radiance.reshape(-1, 3) * np.tile(cube_solid_angles(cube.edge).reshape(-1), 6)[:, None]
    deviation, kept, cut = Deviation(), 0.0, 0.0
    for start in range(0, len(chosen), step):
        some = chosen[start : start + step]
        rows = baker.rows(some, counts[start : start + step])
        lit = np.einsum("rcj,jc->rc", np.broadcast_to(rows, (len(rows), 3, rows.shape[2])), light)
        for number, vertex in enumerate(some):
            frame = frames[vertex]
            local = towards @ frame
            seen = local[local[:, 2] > 0.0]
            visible = counts[start + number] / work.settings.fine**2
            base = kinds.at(int(vertex)) if kinds is not None else _brdf_at(work, brdf, variations, int(vertex))
            exact = exact_radiance(base, directions @ frame, visible, incident, seen)
            own = lit[number * count : (number + 1) * count]
            if work.table.diffuse:
                signed = np.broadcast_to(own * albedo[vertex], exact.shape)
            else:
                same = np.full(len(seen), vertex)
                signed = work.table.radiance(np.broadcast_to(own, (len(seen), *own.shape)), seen, same)
            value = np.maximum(signed, 0.0)
            kept, cut = kept + float(value.sum()), cut + float((value - signed).sum())
            deviation.add(seen[:, 2], value, exact)
        yield Step((start + len(some)) / len(chosen), "comparing with the sum over all texels")
    return deviation.error(cut / kept if kept > 0.0 else 0.0)


def _brdf_at(work: Work, brdf: Brdf, variations: Sequence[Variation], vertex: int) -> Brdf:
    """The BRDF of a vertex of the model."""
    if not isinstance(work.table, VariedTable):
        return brdf
    return vary_brdf(brdf, variations, [[number] for number in work.table.numbers[vertex]])[0]

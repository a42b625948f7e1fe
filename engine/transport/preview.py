"""A first image of a baked model with another BRDF: spherical harmonics of a low order from kept visibility.

Wavelets and Gaussians belong to one BRDF; until a bake of another one is there, these show it with its shadows. Shares
of texels are added up to a coarser cube map, whose harmonics of order 2 n − 1 all matrices of order n come from. The
matrices hold for every BRDF, so that only the first change of a model waits for them.

Bound by decompression of the record, 24 kB for each vertex at an edge of 64: 1.2 s of one core for 39,363 vertices.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import parallel, prange
from engine.core.steps import Step, Steps, part
from engine.geometry.ground import with_ground
from engine.transport.baking.visibility import Receivers, visibility_shares
from engine.transport.baking.visibility_record import VisibilityRecord, keep_visibility
from engine.transport.method import Subject
from engine.transport.sh.bake import Baker, BakeSettings, lay_out, receivers_of, recipe_of
from engine.transport.sh.brdf_table_varying import table_of
from engine.transport.sh.transfer import ShTransport

#: Order of the harmonics, and the edge of the cube map that shares are added up to.
ORDER, EDGE = 4, 16

#: Bytes of the matrices, at most; larger models have no preview.
MAX_BYTES = 1 << 29


def preview(subject: Subject) -> Steps[ShTransport | None]:
    """Transport of `subject` with its BRDF in spherical harmonics of order `ORDER`, in memory (Kautz2002 Sec. 5).

    Direct light alone, also where a bake of it has interreflection. None where visibility is not kept, where parameters
    vary or parts have BRDFs of their own, and where the matrices would take more than `MAX_BYTES`.
    """
    surface = subject.mesh if subject.ground is None else with_ground(subject.mesh, subject.ground)[0]
    if subject.variations or subject.parts or 4 * ORDER**4 * len(surface.positions) > MAX_BYTES:
        return None
    table = yield from part(table_of(subject.brdf, ORDER, (), subject.mesh), 0.0, 0.2)
    albedo, first = subject.ground.albedo if subject.ground else 0.0, len(subject.mesh.positions)
    work = lay_out(surface, first, albedo, subject.brdf, table, BakeSettings(ORDER, EDGE))
    of = keep_visibility(receivers_of(work), subject.kept)
    if not isinstance(of.record, VisibilityRecord):
        return None
    cube = of.record.find_whole(of)
    if cube is None or cube[0] % EDGE:
        return None
    edge, fine = cube
    baker = Baker({**recipe_of(work, of), "fine": fine * edge // EDGE, "diffuse": False}, of)
    rows = yield from part(_rows(baker, of, cube, first), 0.2, 1.0)
    return ShTransport(surface, first, False, albedo, table, False, rows)


def _rows(baker: Baker, of: Receivers, cube: tuple[int, int], first: int) -> Steps[NDArray[np.float32]]:
    """(R, 1, order²) the matrices of the model, and the vectors of its ground from vertex `first` on."""
    found = []
    for vertices, counts in visibility_shares(of, *cube):
        coarse = add_up(counts, cube[0], EDGE)
        for part_of in (vertices < first, vertices >= first):
            if part_of.any():
                found.append(baker.rows(vertices[part_of], coarse[part_of]))
        yield Step((vertices[-1] + 1) / len(of), "reading visibility")
    return np.concatenate(found)


def add_up(counts: NDArray[np.uint8], edge: int, coarse: int) -> NDArray[np.uint16]:
    """(B, 6 coarse²) sums of counts (B, 6 edge²) over the texels of a coarser cube map, whose edge divides `edge`.

    Examples
    --------
    >>> add_up(np.ones((1, 6 * 16), np.uint8), 4, 2)[0, :4]
    array([4, 4, 4, 4], dtype=uint16)
    """
    sums = np.zeros((len(counts), 6 * coarse**2), np.uint16)
    _add_up(counts, edge, coarse, sums)
    return sums


@parallel
def _add_up(counts: NDArray[np.integer], edge: int, coarse: int, sums: NDArray[np.integer]) -> None:
    """Fill `sums`, which holds zeros before; bound by reading the counts."""
    times = edge // coarse
    for b in prange(len(counts)):
        for line in range(6 * edge):
            below = line // times * coarse  # rows of all faces follow each other
            for column in range(coarse):
                total = 0
                for k in range(times):
                    total += counts[b, line * edge + column * times + k]
                sums[b, below + column] += total

"""Bytes of a transport file and of what a process holds while it draws one, by counting what lies in them.

A file is its header, the table of its chunks, and arrays that begin at pages (`engine.transport.baking.file_header`):
the mesh, what is known of the BRDF, and rows of transport.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from engine.planning.costs.load import Load
from engine.planning.costs.setting import Setting
from engine.transport.baking.file_header import PAGE
from engine.transport.baking.settings import GaussianSettings
from engine.transport.gaussian.fitting.views import VIEWS
from engine.transport.sh import bake as sh_bake
from engine.transport.sh import brdf_table
from engine.transport.wavelet import bake as wavelet_bake
from engine.transport.wavelet.haar import FACES

#: Order of the diffuse part beside Gaussians, in a plan as in a bake.
DIFFUSE_ORDER = GaussianSettings.order

#: Bytes of a Gaussian for one view: three heights, its mean and its width, in float32.
LOBE_BYTES = 28


@dataclass(frozen=True)
class Sizes:
    """Bytes of the file before it is packed, and of mesh, transport, tables and the light in its rows in memory."""

    file: int
    memory: int


def spherical_harmonics(setting: Setting, load: Load) -> Sizes:
    """Rows of a matrix for each vertex, or a vector, and the table of the BRDF (float32, read as float64)."""
    order = setting["order"]
    rows = load.model * (1 if load.diffuse else order**2) + load.ground
    values = order**2 * channels(setting, load)
    table = 12 * order**2 * _table_rows(load)
    chunk = max(1, sh_bake.CHUNK_VALUES // max(FACES * sh_bake.default_edge(order) ** 2, order**4))
    chunks = _chunks(load, chunk)
    file = _file([*_mesh(load), table, 8 * (chunks + 1), 4 * rows * values], chunks)
    return Sizes(file, load.mesh_bytes + 2 * table + 4 * rows * values + 12 * rows)


def wavelets(setting: Setting, load: Load) -> Sizes:
    """Two and four bytes for each coefficient, fourteen for each vector, both again for bounces, and maps of terms."""
    terms, edge = setting["terms"], setting["cube"]
    kept = min(setting["coefficients"], FACES * edge * edge)
    rows = load.model * terms + load.ground
    maps = 12 * terms * wavelet_bake.MAP_SIZE**2
    parts = 2 if setting["interreflection"] else 1
    chunks = parts * _chunks(load, max(1, wavelet_bake.CHUNK_TEXELS // (FACES * edge * edge)))
    streamed = [parts * size * rows for size in (2 * kept, 4 * kept, 12, 2)]
    file = _file([*_mesh(load), maps, maps, 8 * (chunks + 1), *streamed], chunks)
    return Sizes(file, load.mesh_bytes + 2 * maps + sum(streamed) + 24 * rows)


def gaussians(setting: Setting, load: Load) -> Sizes:
    """Lobes of all views of a vertex, of direct and of indirect light, and vectors of the diffuse part."""
    parts = 2 if setting["interreflection"] else 1
    count = load.model * VIEWS * setting["lobes"]
    diffuse = 4 * load.vertices * DIFFUSE_ORDER**2 * (3 if setting["interreflection"] else 1)
    file = _file([*_mesh(load), diffuse, *([12 * count, 12 * count, 4 * count] * parts), 8], 0)
    return Sizes(file, load.mesh_bytes + diffuse + LOBE_BYTES * count * parts + 24 * load.vertices)


def channels(setting: Setting, load: Load) -> int:
    """3 where light from other parts of the model is coloured, and kept so."""
    return 3 if setting["interreflection"] and load.coloured else 1


def _chunks(load: Load, size: int) -> int:
    """Chunks of `size` vertices; none holds both model and ground."""
    return math.ceil(load.model / size) + math.ceil(load.ground / size)


def _table_rows(load: Load) -> int:
    if load.diffuse:
        return 2
    return brdf_table.ROWS if load.isotropic else brdf_table.MAP_SIZE**2


def _mesh(load: Load) -> list[int]:
    return [24 * load.vertices, 12 * load.vertices, 8 * load.vertices, 12 * load.corners]


def _file(arrays: list[int], chunks: int) -> int:
    """Bytes of a file with arrays of these sizes behind a header and a table of chunks, and the page of its check."""
    return 2 * PAGE + sum(math.ceil(size / PAGE) * PAGE for size in (8 * chunks + 4, *arrays))

"""Load of a setting: the counts that costs grow with, and the cost of rays on the mesh, measured by casting some.

Rays are dearer on one mesh than on another, and cube maps are dearer at a fine edge by more or less, as shadows have
long or short borders: both are measured on the mesh itself, at vertices enough to keep every thread at work.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from engine.core.stopwatch import shortest
from engine.geometry.camera import Camera
from engine.geometry.ray_caster import RayCaster, offset_origins
from engine.transport.baking import visibility_kernel
from engine.transport.baking.visibility import Receivers, portion, visibility_shares

#: A table of rates: value of a parameter → seconds, in rising order.
Rates = tuple[tuple[float, float], ...]

#: Edges of cube maps at which visibility is measured; between them it is a power law.
RAY_EDGES = (16, 64)

#: Portions of vertices that each thread gets where visibility is measured, and vertices and rays of each otherwise.
PORTIONS, PROBES, RAYS = 4, 256, 64

#: Texels of the map that costs of a changed light are predicted for where nobody says, and rays along a side of a
#: image that tell how much of it the model covers.
TEXELS, GRID = 1024 * 512, 48

#: Layers of a surface behind each other that are looked for.
LAYERS = 8


@dataclass(frozen=True)
class Load:
    """Load of a setting.

    Attributes
    ----------
    vertices, pixels : of the surface and of the image, sub-pixels each by itself.
    faces : of the surface, twice the vertices where not given.
    ground : how many of the vertices are of a ground, which is diffuse.
    occluded : share of the vertices that do not see their whole hemisphere.
    closed : share of their hemispheres that other parts of the model close, weighted by the cosine.
    covered : share of the pixels that show the surface. shaded : how often a pixel is shaded, layers that are hidden
        later included; as often as it is covered where not given.
    diffuse, isotropic : of the BRDF. coloured : whether what it reflects on has a colour.
    visibility : seconds of visibility for a vertex that is not open, by the edge of the cube map; none: those of the
        mesh of the calibration.
    ray_scale : cost of a single ray on this mesh over that of the calibration.
    lamps : directions of suns and lamps, which cost a ray for each vertex when the light changes.
    texels : of the map that is the light.
    depth : points of the surface that light of the reference may touch.
    texel_lights : lights under which texels of a material are drawn in baked light; 0 without any.
    tables_made : whether tables that outlive a bake are there already, as in a process that has baked before.
    """

    vertices: int
    pixels: int
    faces: int = 0
    occluded: float = 1.0
    diffuse: bool = False
    isotropic: bool = True
    coloured: bool = True
    closed: float = 0.5
    covered: float = 1.0
    shaded: float | None = None
    visibility: Rates = ()
    ray_scale: float = 1.0
    lamps: int = 0
    texels: int = TEXELS
    depth: int = 1
    ground: int = 0
    texel_lights: int = 0
    tables_made: bool = False

    def __post_init__(self) -> None:
        if min(self.vertices, self.pixels, self.texels, self.depth) < 1:
            words = f"{self.vertices} vertices, {self.pixels} pixels, {self.texels} texels and a depth of {self.depth}"
            raise ValueError(f"{words} make no load")
        if not 0 <= self.ground <= self.vertices:
            raise ValueError(f"{self.ground} of {self.vertices} vertices on the ground make no load")
        shares = (self.occluded, self.closed, self.covered)
        if not all(0.0 <= share <= 1.0 for share in shares):
            raise ValueError(f"shares of {shares} occluded, closed and covered make no load")

    @property
    def fragments(self) -> float:
        """Number of times that pixels are shaded."""
        return self.pixels * (self.covered if self.shaded is None else self.shaded)

    @property
    def model(self) -> int:
        """Vertices that are not of the ground."""
        return self.vertices - self.ground

    @property
    def corners(self) -> int:
        """Triangles of the model."""
        return self.faces or 2 * self.vertices

    @property
    def mesh_bytes(self) -> int:
        """Positions in float64, normals, texture coordinates, and corners of the triangles."""
        return self.vertices * (24 + 12 + 8) + 12 * self.corners


@dataclass(frozen=True)
class Rays:
    """Cost of rays on a mesh, and the share of them that meet it.

    `visibility` is that of `Load`, `ray_s` the seconds of a ray that goes its own way, on one thread; both are nothing
    where every vertex is open. `closed` is that of `Load`.
    """

    visibility: Rates
    ray_s: float
    closed: float


@lru_cache(maxsize=4)
def rays_of(of: Receivers) -> Rays:
    """Cast some rays from vertices that are not open; remembered, some 0.3 s."""
    vertices = np.flatnonzero(~of.free)
    if not vertices.size:
        return Rays((), 0.0, 0.0)
    visibility = tuple((float(edge), _visibility_s(of, vertices, edge)) for edge in RAY_EDGES)
    some = _spread(vertices, PROBES)
    origin, direction = visibility_kernel.hemisphere_rays(some, of.origin, of.normal, hemisphere(RAYS))
    met = of.caster.occluded(origin, direction)
    ray_s = shortest(lambda: of.caster.occluded(origin, direction)) / len(origin)
    return Rays(visibility, ray_s, float(met.mean()) * len(vertices) / len(of))


def measure_coverage(caster: RayCaster, camera: Camera, aspect: float = 1.0) -> float:
    """The share of an image by `camera`, `aspect` times as wide as it is high, that shows what `caster` holds."""
    origin, direction = _grid(camera, aspect)
    return float(caster.occluded(origin, direction).mean())


def shade(caster: RayCaster, camera: Camera, aspect: float = 1.0) -> float:
    """Mean number of times that a pixel of an image is shaded, the parts of the surface being drawn in any order.

    What is drawn before what lies in front of it is shaded too: of n layers 1 + 1/2 + … + 1/n.
    """
    origin, direction = _grid(camera, aspect)
    times, layer = 0.0, 0
    while len(origin) and layer < LAYERS:
        layer += 1
        hits = caster.intersect(origin, direction)
        met = hits.face >= 0
        times += int(np.count_nonzero(met)) / layer
        corners = caster.positions[caster.faces[hits.face[met]]]
        point = np.einsum("nk,nki->ni", hits.barycentric[met], corners)
        origin, direction = offset_origins(point, direction[met], caster), direction[met]
    return times / (GRID * _width(aspect))


def _width(aspect: float) -> int:
    return max(1, round(GRID * aspect))


def _grid(camera: Camera, aspect: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Rays through a coarse image, evenly: where they start and where they go."""
    width = _width(aspect)
    column, row = np.meshgrid(np.arange(width) + 0.5, np.arange(GRID) + 0.5)
    direction = camera.rays(column, row, width, GRID).reshape(-1, 3)
    return np.broadcast_to(np.array(camera.eye), direction.shape), direction


def threads() -> int:
    return os.cpu_count() or 1


def _visibility_s(of: Receivers, vertices: NDArray[np.int64], edge: int) -> float:
    some = _spread(vertices, PORTIONS * threads() * portion(edge))
    list(visibility_shares(of, edge, 4, some[:1]))
    return shortest(lambda: list(visibility_shares(of, edge, 4, some)), 1) / len(some)


def _spread(vertices: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """At most `count` of `vertices`, evenly along the list."""
    chosen: NDArray[np.int64] = vertices[np.linspace(0, len(vertices) - 1, min(count, len(vertices))).astype(np.int64)]
    return chosen


def hemisphere(count: int) -> NDArray[np.float64]:
    """(count, 3) about +z in a spiral, as dense as the cosine."""
    index = np.arange(count)
    radius, azimuth = np.sqrt((index + 0.5) / count), index * math.pi * (3.0 - math.sqrt(5.0))
    return np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), np.sqrt(1.0 - radius**2)], axis=-1)

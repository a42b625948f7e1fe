"""Load of a setting: the counts that costs grow with. Nothing here is timed: the same scene is always the same load.

Rays are dearer on a mesh of more triangles, those of a cube map, which are alike, less so. Over ten meshes of 4,000 to
115,000 triangles powers of their number tell the time of a ray within a factor of 1.3, and of a cube map within 1.6.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from engine.core.budget import thread_count
from engine.geometry.camera import Camera
from engine.geometry.ray_caster import RayCaster, offset_origins
from engine.transport.baking import visibility_kernel
from engine.transport.baking.visibility import Receivers

#: A table of rates: value of a parameter → seconds, in rising order.
Rates = tuple[tuple[float, float], ...]

#: Vertices and rays of each that tell how much of the hemispheres is closed.
PROBES, RAYS = 256, 64

#: Triangles of the mesh on which a machine profile is measured, and the powers of their number that the time of a ray
#: and of a cube map of them grows with.
PROFILE_FACES, RAY_POWER, MAP_POWER = 98_304, 0.25, 0.125

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
    lamps : directions of suns and lamps, which cost a ray for each vertex when the light changes.
    texels : of the map that is the light.
    depth : points of the surface that light of the reference may touch.
    shadows : directions of lights that cast shadows where lights are summed.
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
    lamps: int = 0
    texels: int = TEXELS
    depth: int = 1
    ground: int = 0
    shadows: int = 0
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
    def ray_scale(self) -> float:
        """Time of a ray over that on the mesh of the machine profile."""
        return (self.corners / PROFILE_FACES) ** RAY_POWER

    @property
    def map_scale(self) -> float:
        """The same of a cube map of rays that start together."""
        return (self.corners / PROFILE_FACES) ** MAP_POWER

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


@lru_cache(maxsize=4)
def measure_closed_share(of: Receivers) -> float:
    """The share of all hemispheres that other parts of the surface close, weighted by the cosine; remembered."""
    vertices = np.flatnonzero(~of.free)
    if not vertices.size:
        return 0.0
    origin, direction = visibility_kernel.hemisphere_rays(
        spread(vertices, PROBES), of.origin, of.normal, hemisphere(RAYS)
    )
    return float(of.caster.occluded(origin, direction).mean()) * len(vertices) / len(of)


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
    return thread_count()


def spread(vertices: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """At most `count` of `vertices`, evenly along the list."""
    chosen: NDArray[np.int64] = vertices[np.linspace(0, len(vertices) - 1, min(count, len(vertices))).astype(np.int64)]
    return chosen


def hemisphere(count: int) -> NDArray[np.float64]:
    """(count, 3) about +z in a spiral, as dense as the cosine."""
    index = np.arange(count)
    radius, azimuth = np.sqrt((index + 0.5) / count), index * math.pi * (3.0 - math.sqrt(5.0))
    return np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), np.sqrt(1.0 - radius**2)], axis=-1)

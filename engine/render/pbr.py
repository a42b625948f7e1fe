"""PBR maps at points of a surface: the BRDF of the texel, and the frame that the map of normals bends.

Base colour, roughness, metallic, f0 and normals are filtered as colours are, normals to unit length again; a mean
normal over rough relief is therefore smoother than the relief. The axes of the texture are those of its coordinates, x
to the right and y up. A bent normal that would point away from the viewer is bent back until it just faces the viewer,
as an interpolated one is. Height and occlusion are not drawn: light that relief hides is not hidden here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import dot, normalize, world_from_tangent
from engine.render.mip_maps import Levels, filter_levels
from engine.surface.metallic_roughness import reflectance

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Least cosine between the normal that shades and the direction of view.
MIN_FACING = 0.01


@dataclass(frozen=True, eq=False)
class Texels:
    """The maps at N points: `base_colour` (N, 3), `roughness`, `metallic` and `f0` (N,), `normal` (N, 3) unit."""

    base_colour: Floats
    roughness: Floats
    metallic: Floats
    f0: Floats
    normal: Floats

    def f(self, point: Indices, wi: Floats, wo: Floats) -> Floats:
        """Values (K, 3) in 1/sr at the points (K,) for directions (K, 3) in their bent frames."""
        there = self.base_colour[point], self.roughness[point], self.metallic[point], self.f0[point]
        return reflectance(wi, wo, *there)

    def bend_frames(self, frame: Floats, axes: Floats, wo: Floats) -> Floats:
        """Frames (N, 3, 3) about the normals of the map, from those of the surface.

        `axes` (N, 2, 3) are those of the texture, `wo` (N, 3) leads to the viewer, in the world like `frame`.
        """
        x, y, z = (self.normal[:, at, None] for at in range(3))
        normal = normalize(x * axes[:, 0] + y * axes[:, 1] + z * frame[..., 2])
        facing = dot(normal, wo)[:, None]
        return world_from_tangent(np.where(facing < MIN_FACING, normalize(normal + (MIN_FACING - facing) * wo), normal))


def texels_at(levels: Levels, uv: Floats, detail: Floats) -> Texels:
    """The maps at `uv` (N, 2) with the mip levels `detail` (N,), from `engine.render.mip_maps.pbr_layers`."""
    base, gloss, normal = (filter_levels(levels, layer, uv, detail) for layer in range(3))
    return Texels(base, gloss[:, 0], gloss[:, 1], gloss[:, 2], normalize(normal))

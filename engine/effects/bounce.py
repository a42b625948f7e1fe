"""What light from other parts of a surface adds to a sample's points: one bounce by rays, and the rest as a series.

From each point rays go as dense as the cosine. Where one meets a surface from its front, the irradiance there is
estimated from a few directions drawn by the light, each with its own shadow ray; what is met reflects evenly to all
sides, as in `engine.transport.sh_bake`. Further bounces see, on average, as much of the model and as bright: with the
albedo A and the share h of rays that meet something, they multiply the first by 1 / (1 − A h). Two halves of the rays
are kept apart, because the product of two independent estimates has no bias from their noise.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.colour import luminance
from engine.directions import dot, normalize
from engine.effects.sample import Sample
from engine.effects.simplified import albedos
from engine.ray_caster import offset_origins

Array = NDArray[np.float64]

#: Rays from each point, and directions of the light for each surface that they meet.
RAYS, SHADOWS = 32, 8


def bounced(sample: Sample, brdf: Any, ground_albedo: float = 0.0, seed: int = 0) -> tuple[Array, Array]:
    """Two independent estimates (N, K, 3) of the radiance of each pair that has met another surface before.

    No ray is cast where no vertex of the model sees another surface.
    """
    count, views = sample.views.shape[:2]
    nothing = np.zeros((count, views, 3))
    asked = np.flatnonzero(~sample.of.free[sample.vertices])
    if not asked.size:
        return nothing, nothing
    rng = np.random.default_rng(seed)
    local = _pattern(rng, len(asked))
    world = np.einsum("nij,nrj->nri", sample.frames[asked], local).reshape(-1, 3)
    hits = sample.of.caster.intersect(np.repeat(sample.of.origin[sample.vertices[asked]], RAYS, axis=0), world)
    met = np.flatnonzero(hits.face >= 0)
    sent = np.zeros((len(world), 3))
    albedo = np.clip(albedos(brdf).mean, 0.0, 1.0)
    sent[met] = _sent(sample, hits.face[met], hits.barycentric[met], world[met], albedo, ground_albedo, rng)
    share = len(met) / len(world)
    sent *= 1.0 / (1.0 - np.minimum(albedo * share, 0.95))
    halves = []
    for half in range(2):
        rays = slice(half, None, 2)
        wi, value = local[:, rays], sent.reshape(len(asked), RAYS, 3)[:, rays]
        f = brdf.f(wi[:, None], sample.views[asked][:, :, None])
        result = nothing.copy()
        result[asked] = math.pi * np.einsum("nkrc,nrc->nkc", f, value) / wi.shape[1]
        halves.append(result)
    return halves[0], halves[1]


def _pattern(rng: np.random.Generator, count: int) -> Array:
    """(count, RAYS, 3) directions about +z, as dense as the cosine, turned for each point."""
    index = np.arange(RAYS) + 0.5
    radius = np.sqrt(index / RAYS)[None] * np.ones((count, 1))
    phi = index * np.pi * (3.0 - math.sqrt(5.0)) + 2.0 * np.pi * rng.random((count, 1))
    return np.stack([radius * np.cos(phi), radius * np.sin(phi), np.sqrt(1.0 - radius**2)], axis=-1)


def _sent(
    sample: Sample,
    faces: NDArray[np.int32],
    barycentric: Array,
    direction: Array,
    albedo: Array,
    ground_albedo: float,
    rng: np.random.Generator,
) -> Array:
    """(M, 3) what the places that are met send back of the distant light; 0 from behind."""
    surface = sample.surface
    corners = surface.positions[surface.faces[faces]]
    flat = normalize(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    smooth = normalize(np.einsum("nk,nki->ni", barycentric, surface.normals[surface.faces[faces]]))
    place = np.einsum("nk,nki->ni", barycentric, corners)
    front = dot(flat, direction) < 0.0
    origin = offset_origins(place, flat, sample.of.caster)
    incident = sample.incident
    bright = np.maximum(luminance(incident), 0.0)
    irradiance = np.zeros((len(faces), 3))
    if bright.sum() > 0.0:
        chance = bright / bright.sum()
        texel = rng.choice(len(chance), (len(faces), SHADOWS), p=chance)
        towards = sample.texels.direction[texel]
        cosine = np.maximum(np.einsum("nsi,ni->ns", towards, smooth), 0.0)
        rays = np.flatnonzero((cosine > 0.0) & front[:, None])
        lit = np.zeros(cosine.size)
        lit[rays] = ~sample.of.caster.occluded(np.repeat(origin, SHADOWS, axis=0)[rays], towards.reshape(-1, 3)[rays])
        weight = lit.reshape(cosine.shape) * cosine / (SHADOWS * chance[texel])
        irradiance += np.einsum("ns,nsc->nc", weight, incident[texel])
    for towards, flux in zip(sample.lamp_direction, sample.lamp_irradiance, strict=True):
        cosine = np.maximum(smooth @ towards, 0.0)
        open_ = ~sample.of.caster.occluded(origin, np.broadcast_to(towards, origin.shape))
        irradiance += (cosine * open_)[:, None] * flux
    colour = np.where((surface.faces[faces, 0] < sample.model_vertices)[:, None], albedo, ground_albedo)
    return np.where(front[:, None], irradiance * colour / math.pi, 0.0)

"""The radiance of a sample's pairs of point and view, with each effect and without it.

    full         Σ f(wi, wo) V(wi) cos θ_i L dω          over the texels of the light, and its lamps
    unshadowed   the same with V = 1
    diffuse         the same of the Lambertian BRDF of equal albedo
    even         the same of one BRDF for all points, where they have their own
    SH           Σ P_n[f cos θ](w) V(w) P_n[L](w) dω     at each order n, P_n the projection on SH below n

The last is what transfer matrices of order n compute, V being mirrored at the tangent plane as there; of a Lambertian
BRDF it is what vectors compute, without the first P_n. One evaluation of f serves all of them.

Interreflection at a sample's points is one bounce by rays, and the rest as a series.

From each point rays go as dense as the cosine. Where one meets a surface from its front, the irradiance there is
estimated from a few directions drawn by the light, each with its own shadow ray; what is met reflects evenly to all
sides, as in `engine.transport.sh.bake`. Further bounces see, on average, as much of the model and as bright: with the
albedo A and the share h of rays that meet something, they multiply the first by 1 / (1 − A h). Two halves of the rays
are kept apart, because the product of two independent estimates has no bias from their noise.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from engine.core.cached import remember
from engine.core.colour import luminance
from engine.core.directions import dot, normalize
from engine.core.one_thread import one_thread
from engine.geometry.ray_caster import in_chunks, offset_origins
from engine.light.environment import DistantLights
from engine.light.lamps import directions_for
from engine.light.light_tree import choose_lights
from engine.planning.effects.sample import Light, Sample
from engine.planning.effects.simplified import Unbrushed, WithoutRetro, albedos, lambertian
from engine.transport.sh.basis import evaluate
from engine.transport.sh.lighting import lamp_coefficients, project
from engine.transport.sh.transfer import is_diffuse, texel_basis
from engine.transport.wavelet.haar import cube_of_coefficients
from engine.transport.wavelet.quantise import encode_light
from engine.transport.wavelet.transfer import cube_texels

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf

Array = NDArray[np.float64]

#: Orders whose truncation is known, and numbers of lights in place of an environment.
ORDERS, LIGHTS = (3, 5, 8, 15), (4, 16, 64, 256)

#: Points whose brushed BRDF is averaged over turns: one in so many, because it costs as many evaluations.
FEWER = 3


@dataclass(frozen=True, eq=False)
class Radiances:
    """Radiance (N, K, 3) of each pair of a sample, in the ways that the module names.

    What was not asked for is 0. `unbrushed`, `unretro`, `even`, `lamps`, `unsplit` and `lit` are None where that is not
    an effect of the BRDF or the light; `unsplit` leaves the suns in the map, which is then kept in quantised wavelets.
    `spherical_harmonics` by order, `lights` by the number of directions; the latter cast no shadows, but in `lit` the
    lamps do, and directions stand for the rest.
    """

    full: Array
    unshadowed: Array
    diffuse: Array
    risen: Array
    unbrushed: Array | None
    unretro: Array | None
    even: Array | None
    lamps: Array | None
    unsplit: Array | None
    lit: dict[int, Array] | None
    coarse: Array
    spherical_harmonics: dict[int, Array]
    lights: dict[int, Array]


def radiances(
    sample: Sample, brdf: Brdf, *, own: Sequence[Any] | None = None, effects: bool = True, methods: bool = True
) -> Radiances:
    """Work them out, with and without `effects`, by all `methods`; most time is for values of the BRDF.

    Where points have their `own` BRDFs, `brdf` stands for all of them where albedos are asked for.
    """
    count, views = sample.views.shape[:2]
    shape = (count, views, 3)
    diffuse = is_diffuse(brdf)
    retro = np.zeros(shape) if brdf.isotropic and not diffuse and has_retro(brdf) else None
    brushed = None if brdf.isotropic else np.zeros(shape)
    found = Radiances(
        np.zeros(shape),
        np.zeros(shape),
        np.zeros(shape),
        np.zeros(shape),
        brushed,
        retro,
        None if own is None else np.zeros(shape),
        np.zeros(shape) if len(sample.lamp_direction) else None,
        np.zeros(shape) if sample.light.suns else None,
        {number: np.zeros(shape) for number in LIGHTS} if len(sample.lamp_direction) else None,
        np.zeros(shape),
        {order: np.zeros(shape) for order in ORDERS},
        {number: np.zeros(shape) for number in LIGHTS},
    )
    work = _Work(sample, brdf, own, diffuse, found, effects, methods)
    with one_thread():
        in_chunks(work, count, max(1, count // 16))
    found.risen[:] = found.full * albedos(brdf).rise(sample.views[..., 2])[..., None]
    return found


@remember(8)
def has_retro(brdf: Brdf) -> bool:
    """True if the BRDF reflects more to the light's side than across it anywhere, by a hundredth."""
    theta, phi = np.meshgrid(np.linspace(0.1, 1.4, 14), np.linspace(0.0, 0.45 * np.pi, 8), indexing="ij")
    wi = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1).reshape(-1, 1, 3)
    angle = np.linspace(0.1, 1.4, 14)
    wo = np.stack([np.sin(angle), np.zeros(14), np.cos(angle)], axis=-1)
    value, less = brdf.f(wi, wo), WithoutRetro(brdf).f(wi, wo)
    return bool((value - less > 0.01 * value.max()).any())


class _Work:
    """Fills the radiances of some points at a time."""

    def __init__(
        self,
        sample: Sample,
        brdf: Brdf,
        own: Sequence[Any] | None,
        diffuse: bool,
        found: Radiances,
        effects: bool,
        methods: bool,
    ) -> None:
        self._sample, self._brdf, self._own, self._diffuse, self._found = sample, brdf, own, diffuse, found
        self._effects, self._methods = effects, methods
        self._texels, self._incident = sample.texels, sample.incident
        if methods:
            self._basis = texel_basis(sample.edge, max(ORDERS))
            self._light = coefficients(sample.light)
            self._cut = {order: _cut(sample.light, order) for order in ORDERS}
            self._lights = {number: choose_lights(sample.light.whole, number) for number in LIGHTS}
            if found.lit is not None:
                self._rest = {number: choose_lights(sample.light.rest, number) for number in LIGHTS}
            self._unsplit = _unsplit(sample.light) if sample.light.suns else None
        self._colour = np.array(lambertian(brdf).albedo) / math.pi

    def __call__(self, rows: slice) -> None:
        for point in range(*rows.indices(len(self._sample.vertices))):
            self._point(point)

    def _point(self, point: int) -> None:
        sample, found = self._sample, self._found
        frame, views, visible = sample.frames[point], sample.views[point], sample.visible[point]
        local = self._texels.direction @ frame
        up = np.flatnonzero(local[:, 2] > 0.0)
        wi, cosine = local[up], local[up, 2]
        brdf = self._at(point)
        f = brdf.f(wi[None], views[:, None])
        weight = self._incident[up] * cosine[:, None]
        seen = weight * visible[up, None]
        found.unshadowed[point] = np.einsum("ktc,tc->kc", f, weight)
        found.full[point] = np.einsum("ktc,tc->kc", f, seen)
        found.diffuse[point] = self._colour * seen.sum(axis=0)
        if self._effects and found.even is not None:
            found.even[point] = np.einsum("ktc,tc->kc", self._brdf.f(wi[None], views[:, None]), seen)
        if self._effects and found.unretro is not None:
            found.unretro[point] = np.einsum("ktc,tc->kc", WithoutRetro(brdf).f(wi[None], views[:, None]), seen)
        if self._effects and found.unbrushed is not None and point % FEWER == 0:
            value = Unbrushed(brdf).f(wi[None], views[:, None])
            found.unbrushed[point] = np.einsum("ktc,tc->kc", value, seen)
        if self._methods:
            self._by_methods(point, f, cosine, up)
        self._directional(point)

    def _at(self, point: int) -> Any:
        """The BRDF of a point."""
        return self._brdf if self._own is None else self._own[point]

    def _by_methods(self, point: int, f: Array, cosine: Array, up: NDArray[np.int64]) -> None:
        sample, found = self._sample, self._found
        visible = sample.visible[point]
        found.coarse[point] = self._coarse(f, cosine, up, visible)
        if found.unsplit is not None and self._unsplit is not None:
            kept = (self._unsplit[up] * self._texels.area[up, None]) * cosine[:, None] * visible[up, None]
            found.unsplit[point] = np.maximum(np.einsum("ktc,tc->kc", f, kept), 0.0)
        self._spherical_harmonics(point, f, cosine, up)
        for number, lights in self._lights.items():
            found.lights[number][point] = self._sum(point, lights)
        if found.lit is not None:
            for number, lights in self._rest.items():
                found.lit[number][point] = self._sum(point, lights)

    def _sum(self, point: int, lights: DistantLights) -> Array:
        """(K, 3) of lights that reach everything."""
        sample = self._sample
        towards = lights.direction @ sample.frames[point]
        facing = towards[:, 2] > 0.0
        value = self._at(point).f(towards[None, facing], sample.views[point][:, None])
        return np.asarray(np.einsum("ktc,tc->kc", value, lights.irradiance[facing] * towards[facing, 2:]))

    def _coarse(self, f: Array, cosine: Array, up: NDArray[np.int64], visible: NDArray[np.bool_]) -> Array:
        """With light and visibility averaged over squares of four texels."""
        halved = (6, self._sample.edge // 2, 2, self._sample.edge // 2, 2)
        area = self._texels.area.reshape(halved)
        light = self._incident.reshape(*halved, 3).sum(axis=(2, 4)) / area.sum(axis=(2, 4))[..., None]
        share = (visible.reshape(halved) * area).sum(axis=(2, 4)) / area.sum(axis=(2, 4))
        both = np.repeat(np.repeat(light * share[..., None], 2, axis=1), 2, axis=2).reshape(-1, 3)[up]
        return np.asarray(np.einsum("ktc,tc->kc", f, both * (self._texels.area[up] * cosine)[:, None]))

    def _spherical_harmonics(self, point: int, f: Array, cosine: Array, up: NDArray[np.int64]) -> None:
        sample, found = self._sample, self._found
        area = self._texels.area
        if self._diffuse:
            # vectors hold V cos θ exactly: only the light is cut
            weight = (cosine * area[up] * sample.visible[point, up])[:, None]
            for order, light in self._cut.items():
                found.spherical_harmonics[order][point] = np.maximum(f[:, 0] * (light[up] * weight).sum(axis=0), 0.0)
            return
        views = len(f)
        product = (f * cosine[:, None]).transpose(0, 2, 1).reshape(views * 3, -1).astype(np.float32)
        own = (product @ self._basis[up]).reshape(views, 3, -1)
        blocked = np.flatnonzero(~sample.mirrored[point])
        basis = self._basis[blocked]
        for order, light in self._cut.items():
            n = order**2
            cut = self._light[:n] - basis[:, :n].T @ light[blocked]
            found.spherical_harmonics[order][point] = np.maximum(np.einsum("kcn,nc->kc", own[..., :n], cut), 0.0)

    def _directional(self, point: int) -> None:
        """The lamps, suns among them, in whatever knows them one by one."""
        sample, found = self._sample, self._found
        if found.lamps is None:
            return
        frame, views = sample.frames[point], sample.views[point]
        towards = sample.lamp_direction @ frame
        up = np.flatnonzero(towards[:, 2] > 0.0)
        brdf = self._at(point)
        f = brdf.f(towards[None, up], views[:, None])
        irradiance = sample.lamp_irradiance[up] * towards[up, 2:]
        lit = irradiance * sample.lamp_lit[point, up, None]
        value = np.einsum("ktc,tc->kc", f, lit)
        found.lamps[point] = value
        found.full[point] += value
        found.coarse[point] += value
        for each in found.lit.values() if self._methods and found.lit is not None else ():
            each[point] += value
        found.unshadowed[point] += np.einsum("ktc,tc->kc", f, irradiance)
        found.diffuse[point] += self._colour * lit.sum(axis=0)
        if found.unsplit is not None:
            beside = up >= sum(directions_for(sample.light.lamps)[: sample.light.suns])
            found.unsplit[point] += np.einsum("ktc,tc->kc", f[:, beside], lit[beside])
        if self._effects and found.even is not None:
            found.even[point] += np.einsum("ktc,tc->kc", self._brdf.f(towards[None, up], views[:, None]), lit)
        if self._effects and found.unretro is not None:
            less = WithoutRetro(brdf).f(towards[None, up], views[:, None])
            found.unretro[point] += np.einsum("ktc,tc->kc", less, lit)
        if self._effects and found.unbrushed is not None and point % FEWER == 0:
            less = Unbrushed(brdf).f(towards[None, up], views[:, None])
            found.unbrushed[point] += np.einsum("ktc,tc->kc", less, lit)


@lru_cache(maxsize=2)
def _unsplit(light: Light) -> Array:
    """(6 edge², 3) radiance of the whole map, suns and all, as quantised wavelets keep it."""
    kept = cube_of_coefficients(encode_light(light.whole_cube.radiance).coefficients)
    return np.asarray(kept.reshape(-1, 3), np.float64)


@lru_cache(maxsize=2)
def coefficients(light: Light) -> Array:
    """(n², 3) of all the light, at the highest of `ORDERS`."""
    total = project(light.rest, max(ORDERS))
    for lamp in light.lamps:
        total = total + lamp_coefficients(lamp, max(ORDERS))
    return total


@lru_cache(maxsize=2 * len(ORDERS))
def _cut(light: Light, order: int) -> NDArray[np.float32]:
    """(6 edge², 3) the radiance that coefficients of `order` stand for, at the texels."""
    return np.asarray(_values(order, light.cube.edge) @ coefficients(light)[: order**2], np.float32)


@lru_cache(maxsize=len(ORDERS))
def _values(order: int, edge: int) -> Array:
    return evaluate(order, cube_texels(edge).direction)


#: Rays from each point, and directions of the light for each surface that they meet.
RAYS, SHADOWS = 32, 8


def bounce(sample: Sample, brdf: Brdf, ground_albedo: float = 0.0, seed: int = 0) -> tuple[Array, Array]:
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
    sent[met] = _send(sample, hits.face[met], hits.barycentric[met], world[met], albedo, ground_albedo, rng)
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


def _send(
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

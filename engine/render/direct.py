"""Draws a `Scene` on the CPU: embree finds what each pixel sees, numpy shades it.

The counterpart of `engine.gl.direct`, for machines without OpenGL and as its reference: the same sub-pixels, the same
formulas in float64, the same mip-maps chosen from differences over the same 2 × 2 blocks. Time grows with the
sub-pixels times the lights, about 1 s per million of either. Lights that cast shadows take a ray each where they face
the surface, which leaves as those of the reference do (`engine.render.surface_points`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.models.diffuse import Lambert
from engine.core.colour import luminance, srgb_decode
from engine.core.directions import dot, frames_along, normalize, world_from_tangent
from engine.core.steps import Step, Steps
from engine.geometry.ray_caster import caster_of, offset_origins
from engine.light.environment import DistantLights
from engine.light.near_lamps import NearLamp, near_lights
from engine.render.gains import gains_at, place_of_direction, place_of_share
from engine.render.hex_tiling import Maps, maps_of_scene, values_at
from engine.render.mip_maps import level_of_detail
from engine.render.near_light import Reached, facets_of, facets_of_texels, reflect_near
from engine.render.near_light_sampling import distance_along
from engine.render.pbr import Texels, texels_at
from engine.render.surface_points import surface_points
from engine.scene.scene import Scene
from engine.shading.directional.effective_light import weights_at
from engine.shading.directional.planes import DirectionalMap
from engine.shading.lookup import share_and_gain
from engine.shading.shading_map import ShadingMap
from engine.surface.pbr_maps import PbrMaps

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Light by light: the points that it reaches, the BRDF and the cosine there, its irradiance (one, or one a point), and
#: its direction (M, 2) along the axes of the texture, or None where nothing asks for it.
Terms = Iterator[tuple[Indices, Array, Array, Array, Array | None]]

#: Look-up by look-up: the points, r / r_max in [0, 1], the factor on what is looked up, and the direction as above.
Shares = Iterator[tuple[Indices, Array, Array, Array | None]]

#: Sub-pixels times lights of one band, about 50 ms of work.
BAND = 40_000


def radiance(scene: Scene, size: tuple[int, int], *, samples: int = 2) -> Steps[NDArray[np.float32]]:
    """The image (height, width, 4) float32 of `size` (width, height): linear radiance times coverage, and coverage.

    Equal to `DirectRenderer.radiance`. Samples that are not finite are 0, and no value is beyond float32's.
    """
    width, height = size
    if samples < 1:
        raise ValueError(f"samples = {samples} must be at least 1")
    image = np.zeros((height, width, 4), np.float32)
    if min(size) < 1:
        return image
    shade = Shader(scene, (width * samples, height * samples))
    lights = len(scene.lights.direction) + scene.directions * len(scene.near_lamps)
    band = max(1, BAND // (width * samples * samples * lights))
    for top in range(0, height, band):
        rows = slice(top, min(top + band, height))
        row, column = np.mgrid[rows.start * samples : rows.stop * samples, 0 : width * samples].reshape(2, -1)
        blocks = shade(row, column).reshape(rows.stop - top, samples, width, samples, 4)
        image[rows] = np.minimum(blocks.mean(axis=(1, 3)), np.finfo(np.float32).max)
        yield Step(rows.stop / height, "Rendering on the CPU", image)
    return image


def _vertices(scene: Scene) -> Array:
    return scene.surface.positions - scene.mesh.centre


def _make_ground_scene(scene: Scene) -> Scene:
    """The same with the ground's BRDF on everything."""
    assert scene.ground is not None
    return replace(scene, brdf=Lambert((scene.ground.albedo,) * 3), material=None)


#: Of what has one BRDF everywhere.
NO_MAPS = Maps([])


def part_of(scene: Scene, face: NDArray[np.int32]) -> NDArray[np.int32]:
    """The place (N,) among `scene.parts` of each triangle of the surface, and after these the ground."""
    count, parts = len(scene.mesh.faces), len(scene.parts)
    if parts == 1 or scene.mesh.part is None:
        return np.where(face >= count, 1, 0).astype(np.int32)
    on_model = scene.mesh.part[np.minimum(face, count - 1)]
    return np.where(face >= count, parts, on_model).astype(np.int32)


class Shader:
    """Shades single sub-pixels of one scene in an image of `size` (width, height) sub-pixels."""

    def __init__(self, scene: Scene, size: tuple[int, int]) -> None:
        self.scene, self.size = scene, size
        self._eye = np.subtract(scene.camera.eye, scene.mesh.centre)
        self._surface, self._positions = scene.surface, _vertices(scene)
        self._ground = _make_ground_scene(scene) if scene.ground is not None else None
        self._caster = caster_of(self._surface)
        self._maps = [maps_of_scene(each) for each in scene.parts]

    def __call__(self, row: Indices, column: Indices, lights: DistantLights | None = None) -> Array:
        """(N, 4) radiance and coverage 1 where the mesh is hit, else 0.

        `lights` in place of the scene's own cast no shadows.
        """
        rays = self._rays(column + 0.5, row + 0.5)
        hit = self._caster.intersect(np.broadcast_to(self.scene.camera.eye, rays.shape), rays, coherent=True).face
        seen = np.flatnonzero(hit >= 0)
        image = np.zeros((len(rays), 4))
        if seen.size:
            value = self._shade_visible(row[seen], column[seen], hit[seen], lights)
            image[seen, :3] = np.where(np.isfinite(value).all(axis=1, keepdims=True), np.maximum(value, 0.0), 0.0)
            image[seen, 3] = 1.0
        return image

    def _rays(self, column: NDArray[Any], row: NDArray[Any]) -> Array:
        return self.scene.camera.rays(column, row, *self.size)

    def _shade_visible(self, row: Indices, column: Indices, face: NDArray[Any], lights: DistantLights | None) -> Array:
        """(N, 3) of the triangles that are seen: of the model, and of the ground behind them in the list."""
        value, number = np.empty((len(face), 3)), part_of(self.scene, face)
        scenes = [*zip(self.scene.parts, self._maps, strict=True), (self._ground, NO_MAPS)]
        for at, (scene, maps) in enumerate(scenes):
            points = np.flatnonzero(number == at)
            if points.size and scene is not None:
                value[points] = self._radiance(scene, maps, row[points], column[points], face[points], lights)
        return value

    def _radiance(
        self,
        scene: Scene,
        maps: Maps,
        row: Indices,
        column: Indices,
        face: NDArray[np.int32],
        lights: DistantLights | None,
    ) -> Array:
        surface, faces = self._surface, self._surface.faces[face]
        triangle = self._positions[faces]

        def at(column: NDArray[Any], row: NDArray[Any]) -> Array:
            return _barycentric(self._eye, self._rays(column, row), triangle)

        weights = at(column + 0.5, row + 0.5)
        place = np.einsum("nc,nci->ni", weights, triangle)
        wo = normalize(self._eye - place)
        normal = _visible_normal(np.einsum("nc,nci->ni", weights, surface.normals[faces]), triangle, wo)
        if scene.brdf.isotropic:
            frame = world_from_tangent(normal)
        else:
            frame = frames_along(normal, np.einsum("nc,nci->ni", weights, surface.tangents[faces]))
        viewer = np.einsum("nij,ni->nj", frame, wo)
        place = place + scene.mesh.centre
        lit = _Lit(scene.lights if lights is None else lights, place)
        if scene.shadows and lights is None:
            lit = self._cast_shadows(lit, face, weights, wo, frame[..., 2])
        if scene.shading is None and scene.pbr is None:
            facets = facets_of(scene.brdf, len(wo))
            near = None if facets is not None else scene
            value = _sum_of_reflections(_light_terms(scene.brdf.f, lit, frame, viewer, None, near), len(wo))
            if facets is None:
                return value
            return value + reflect_near(scene.near_lamps, place, frame, viewer, facets, reached=lit.reached)
        uv = texture_coordinates(scene, faces)
        is_directional = scene.pbr is not None or isinstance(scene.shading, DirectionalMap)
        axes = texture_axes(triangle, uv, frame[..., 2]) if is_directional else None
        left, bottom = column - column % 2, row + (self.size[1] - 1 - row) % 2
        steps = (
            at(left + 1.5, row + 0.5) - at(left + 0.5, row + 0.5),
            at(column + 0.5, bottom - 0.5) - at(column + 0.5, bottom + 0.5),
        )
        along = [np.einsum("nc,nci->ni", step, uv) for step in steps]
        seen = np.einsum("nc,nci->ni", weights, uv)
        if scene.pbr is not None:
            assert axes is not None
            colours = scene.colours
            tint = None if colours is None else np.einsum("nc,nci->ni", weights, colours[faces])
            return self._shade_texels(scene.pbr, maps, (seen, tint), along, frame, axes, wo, lit)
        terms = _light_terms(scene.brdf.f, lit, frame, viewer, axes, scene)
        return sample(scene, maps, seen, along, terms)

    def _cast_shadows(self, lit: _Lit, face: NDArray[np.int32], weights: Array, wo: Array, normal: Array) -> _Lit:
        """The lights as rays from the points, at `weights` (N, 3) of the triangles `face` (N,), find them."""
        caster, lights = self._caster, lit.lights
        normals = self._surface.normals
        point, flat, _, _ = surface_points(face, weights, -wo, caster.positions, normals, caster.faces)
        origin = offset_origins(point, flat, caster)
        visible = np.ones((len(lights.direction), len(face)), np.bool_)
        for number in self.scene.casting:
            direction = lights.direction[number]
            facing = np.flatnonzero((flat @ direction > 0.0) | (normal @ direction > 0.0))
            visible[number] = False
            towards = np.broadcast_to(direction, (len(facing), 3))
            visible[number, facing] = ~caster.occluded(origin[facing], towards)

        def reach(lamp: NearLamp, points: Indices, direction: Array) -> NDArray[np.bool_]:
            distance = distance_along(lamp, origin[points], direction)
            return np.asarray(caster.intersect(origin[points], direction).distance >= distance)

        return _Lit(lights, lit.place, visible, reach)

    def _shade_texels(
        self,
        pbr: PbrMaps,
        maps: Maps,
        seen: tuple[Array, Array | None],
        along: list[Array],
        frame: Array,
        axes: Array,
        wo: Array,
        lit: _Lit,
    ) -> Array:
        """Radiance (N, 3) of PBR maps; where normals within a pixel differ much, it is looked up in four parts.

        What is `seen` are texture coordinates (N, 2), and colours of vertices (N, 3) or None.
        """
        uv, tint = seen
        detail = level_of_detail(maps.levels, along)

        def shade(at: Indices, shift: Array, finer: float) -> tuple[Texels, Array]:
            lower = np.maximum(detail[at] - finer, 0.0)
            texels = texels_at(maps, uv[at] + shift, lower, pbr).tint(None if tint is None else tint[at])
            bent = texels.bend_frames(frame[at], axes[at], wo[at])
            texels = texels.in_frames(frame[at], bent)
            viewer = np.einsum("nij,ni->nj", bent, wo[at])
            value = np.zeros((len(viewer), 3))
            for weight, each in texels.parts():
                value += weight[:, None] * self._sum_of_part(each, lit.at(at), bent, viewer)
            return texels, value

        texels, value = shade(np.arange(len(uv)), np.zeros(2), 0.0)
        parts = np.flatnonzero(texels.differ_within)
        if parts.size:
            value[parts] = 0.0
            for right in (-0.25, 0.25):
                for up in (-0.25, 0.25):
                    value[parts] += 0.25 * shade(parts, right * along[0][parts] + up * along[1][parts], 1.0)[1]
        return value

    def _sum_of_part(self, texels: Texels, lit: _Lit, frame: Array, viewer: Array) -> Array:
        """Radiance (N, 3) of texels of one roughness under all lights."""
        value = _sum_of_texels(texels, lit, frame, viewer)
        if texels.layers is not None:
            return value + _sum_of_near_texels(texels, self.scene, lit, frame, viewer)
        near = self.scene.near_lamps
        return value + reflect_near(near, lit.place, frame, viewer, facets_of_texels(texels), reached=lit.reached)


@dataclass(frozen=True, eq=False)
class _Lit:
    """Lights and the points at `place` (N, 3) that they shine on.

    Attributes
    ----------
    visible : (L, N) whether each of the lights reaches each point; None where all do.
    reached : the same of lights near the model; None where all points are.
    """

    lights: DistantLights
    place: Array
    visible: NDArray[np.bool_] | None = None
    reached: Reached | None = None

    def at(self, points: Indices) -> _Lit:
        """Some of the points."""
        reached = self.reached
        if self.visible is None or reached is None:
            return replace(self, place=self.place[points])

        def reach(lamp: NearLamp, some: Indices, direction: Array) -> NDArray[np.bool_]:
            return reached(lamp, points[some], direction)

        return replace(self, place=self.place[points], visible=self.visible[:, points], reached=reach)

    def each(self, frame: Array) -> Iterator[tuple[Indices, Array, Array, Array]]:
        """For each light that reaches points: these, its direction (M, 3) in their frames, irradiance and direction."""
        for number, direction in enumerate(self.lights.direction):
            wi = np.einsum("nij,i->nj", frame, direction)
            facing = wi[:, 2] > 0.0
            points = np.flatnonzero(facing if self.visible is None else facing & self.visible[number])
            if points.size:
                yield points, wi[points], self.lights.irradiance[number], direction

    def each_near(self, scene: Scene) -> Iterator[tuple[Array, Array]]:
        """For each point of each near light: the direction (N, 3) towards it and its irradiance (N, 3)."""
        for lamp in scene.near_lamps:
            for direction, irradiance in near_lights(lamp, self.place, scene.directions):
                if self.reached is not None:
                    points = np.flatnonzero(irradiance.any(axis=1))
                    open_to = np.zeros(len(direction))
                    open_to[points] = self.reached(lamp, points, direction[points])
                    yield direction, irradiance * open_to[:, None]
                else:
                    yield direction, irradiance


def _light_terms(
    f: Callable[[Array, Array], Array], lit: _Lit, frame: Array, wo: Array, axes: Array | None, near: Scene | None
) -> Terms:
    """For each light: which points it reaches, f (M, 3) and cos(theta) (M,) there, and its irradiance (3,).

    Where the `axes` (N, 2, 3) of the texture are given, also the direction of the light along them. Of a scene with
    lights that are `near`, for their points too, with an irradiance (M, 3).
    """
    for points, wi, irradiance, direction in lit.each(frame):
        heading = None if axes is None else axes[points] @ direction
        yield points, f(wi, wo[points]), wi[:, 2], irradiance, heading
    for direction, irradiance in () if near is None else lit.each_near(near):
        wi = np.einsum("nij,ni->nj", frame, direction)
        points = np.flatnonzero((wi[:, 2] > 0.0) & irradiance.any(axis=1))
        if points.size:
            heading = None if axes is None else np.einsum("nai,ni->na", axes[points], direction[points])
            yield points, f(wi[points], wo[points]), wi[points, 2], irradiance[points], heading


def _sum_of_texels(texels: Texels, lit: _Lit, frame: Array, wo: Array) -> Array:
    """Radiance (N, 3) of the BRDFs of texels, in the frames that normals bend."""
    value = np.zeros((len(wo), 3))
    everywhere, lights = np.arange(len(wo)), lit.lights
    for number, (direction, irradiance) in enumerate(zip(lights.direction, lights.irradiance, strict=True)):
        product = texels.product(everywhere, np.einsum("nij,i->nj", frame, direction), wo) * irradiance
        value += product if lit.visible is None else product * lit.visible[number][:, None]
    return value


def _sum_of_near_texels(texels: Texels, scene: Scene, lit: _Lit, frame: Array, wo: Array) -> Array:
    """The same of points of lights near the model."""
    value = np.zeros((len(wo), 3))
    everywhere = np.arange(len(wo))
    for direction, irradiance in lit.each_near(scene):
        value += texels.product(everywhere, np.einsum("nij,ni->nj", frame, direction), wo) * irradiance
    return value


def _sum_of_reflections(terms: Terms, count: int) -> Array:
    value = np.zeros((count, 3))
    for lit, f, cosine, irradiance, _ in terms:
        value[lit] += f * cosine[:, None] * irradiance
    return value


def _barycentric(eye: Array, rays: Array, triangle: Array) -> Array:
    """(N, 3) weights of the corners where each ray meets the plane of its triangle, inside it or not."""
    first, second = triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0]
    across = np.cross(rays, second)
    determinant = dot(first, across)
    determinant = np.where(determinant == 0.0, np.finfo(float).tiny, determinant)
    offset = eye - triangle[:, 0]
    u = dot(offset, across) / determinant
    v = dot(rays, np.cross(offset, first)) / determinant
    return np.stack([1.0 - u - v, u, v], axis=-1)


def _visible_normal(normal: Array, triangle: Array, wo: Array) -> Array:
    """The shading normal on the side that is seen, bent where it would point away from the viewer (direct.frag)."""
    directed = np.cross(triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0])
    side = np.where(dot(directed, wo) < 0.0, -1.0, 1.0)[:, None]
    flat = normalize(directed) * side
    length = np.sqrt(dot(normal, normal))[:, None]
    normal = np.where(length > 0.0, normal / np.where(length > 0.0, length, 1.0), flat * side) * side
    facing = dot(normal, wo)[:, None]
    return np.where(facing < 0.01, normalize(normal + (0.01 - facing) * wo), normal)


def texture_coordinates(scene: Scene, faces: NDArray[np.int32]) -> Array:
    """(N, 3, 2) of the corners of `faces` (N, 3), v down, one unit per repeat."""
    uv = scene.mesh.uv[faces].astype(np.float64)
    return np.stack([uv[..., 0], 1.0 - uv[..., 1]], axis=-1) * scene.texture_scale


def texture_axes(triangle: Array, uv: Array, normal: Array) -> Array:
    """(N, 2, 3) unit vectors along which a texture runs to the right and upwards, perpendicular to `normal` (N, 3).

    `triangle` (N, 3, 3) are corners in space and `uv` (N, 3, 2) in the texture, v down. Where the texture is seen
    mirrored, the second is −n × the first. Without coordinates the frame is that of `world_from_tangent`.
    """
    first, second = triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0]
    one, two = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    sign = np.sign(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])[:, None]
    right = sign * (first * two[:, 1:] - second * one[:, 1:])
    up = sign * (first * two[:, :1] - second * one[:, :1])
    axis = frames_along(normal, right)
    mirrored = dot(axis[..., 1], up) < 0.0
    return np.stack([axis[..., 0], np.where(mirrored[:, None], -1.0, 1.0) * axis[..., 1]], axis=1)


def sample(scene: Scene, maps: Maps, uv: Array, along: list[Array], terms: Terms) -> Array:
    """Radiance (N, 3) at `uv` (N, 2), with the look-up inside the sum over lights; `along` is d(uv) / d(pixel)."""
    assert scene.shading is not None
    if isinstance(scene.shading, DirectionalMap):
        return _sum_of_planes(scene, _shares(scene, terms, len(uv)), maps, uv, level_of_detail(maps.levels, along))
    detail, shares = level_of_detail(maps.levels, along), _shares(scene, terms, len(uv))
    if isinstance(scene.shading, ShadingMap):
        return _sum_of_slices(shares, maps, uv, detail)
    if scene.shading.kept is None:
        return _sum_of_powers(shares, maps, uv, detail)
    return (_sum_of_both if maps.tables is None else _sum_of_slices)(shares, maps, uv, detail)


def _shares(scene: Scene, terms: Terms, count: int) -> Shares:
    """Look-ups of the map: points, their share r / r_max in [0, 1], and the weight (M, 3) of what is found."""
    assert scene.shading is not None
    r_max, everywhere = scene.shading.r_max, np.arange(count)
    outgoing, towards = np.zeros((count, 3)), np.zeros((count, 2))
    for lit, f, cosine, irradiance, heading in terms:
        reflectance = scene.sigma / r_max * luminance(f).astype(np.float64)
        if scene.lookup == "angle":
            yield lit, np.minimum(cosine, 1.0), reflectance[:, None] * irradiance, heading
        elif scene.lookup == "radiance":
            share, gain = share_and_gain(reflectance * cosine, 1.0, scene.above)
            yield lit, share, gain[:, None] * irradiance, heading
        else:
            reflected = (reflectance * cosine)[:, None] * irradiance
            outgoing[lit] += reflected
            towards[lit] += 0.0 if heading is None else luminance(reflected)[:, None] * heading
    if scene.lookup == "texture":
        yield everywhere, np.ones(count), outgoing, towards
    elif scene.lookup == "outgoing":
        ratio = luminance(outgoing)
        share, gain = share_and_gain(ratio, 1.0, scene.above)
        yield everywhere, share, outgoing * (gain / np.where(ratio > 0.0, ratio, 1.0))[:, None], towards


def _sum_of_slices(shares: Shares, maps: Maps, uv: Array, detail: Array, first: int = 0) -> Array:
    """S is linear between slices, layers from `first` on: their weights are summed, and each is looked up once."""
    last = len(maps.levels[0]) - 1 - first
    weights = np.zeros((last + 1, len(uv), 3))
    for point, share, weight, _ in shares:
        lower = np.minimum((share * last).astype(np.int64), last - 1)
        beyond = weight * (share * last - lower)[:, None]
        weights[lower, point] += weight - beyond
        weights[lower + 1, point] += beyond
    value = np.zeros((len(uv), 3))
    for layer, weight in enumerate(weights):
        used = np.flatnonzero(weight.any(axis=1))
        value[used] += weight[used] * values_at(maps, first + layer, uv[used], detail[used])
    return value


def _sum_of_powers(shares: Shares, maps: Maps, uv: Array, detail: Array) -> Array:
    """As on the GPU, scale and exponent are filtered and then evaluated."""
    scale, exponent = (values_at(maps, layer, uv, detail) for layer in (0, 1))
    exponent = np.maximum(exponent, 0.0)
    value = np.zeros((len(uv), 3))
    for point, share, weight, _ in shares:
        weight = weight * gains_at(maps.gains, detail[point], np.zeros(len(share)), place_of_share(share))
        power = np.exp(exponent[point] * np.log(np.where(share > 0.0, share, 1.0))[:, None])
        value[point] += np.where(share > 0.0, 1.0, 0.0)[:, None] * weight * power
    return scale * value


def _sum_of_both(shares: Shares, maps: Maps, uv: Array, detail: Array) -> Array:
    """The power law, and over it the kept tiles with their coverage."""
    found = list(shares)
    power_law = _sum_of_powers(iter(found), maps, uv, detail)
    kept = _sum_of_slices(iter(found), maps, uv, detail, first=3)
    return kept + (1.0 - values_at(maps, 2, uv, detail)) * power_law


def _sum_of_planes(scene: Scene, shares: Shares, maps: Maps, uv: Array, detail: Array) -> Array:
    """Planes are filtered once, and for each light summed to codes, which become radiance after the sum."""
    shading = scene.shading
    assert isinstance(shading, DirectionalMap)
    planes = np.concatenate([values_at(maps, layer, uv, detail) for layer in range(len(maps.levels[0]))], axis=1)
    planes = planes[:, : len(shading.planes)]
    value = np.zeros((len(uv), 3))
    for point, share, weight, heading in shares:
        assert heading is not None
        azimuth = np.arctan2(heading[:, 1], heading[:, 0])
        cosine = share if scene.lookup == "angle" else scene.effective_cosine(share, azimuth)
        functions = weights_at(shading.table, cosine, azimuth)
        codes = functions[..., 0] + np.einsum("mck,mk->mc", functions[..., 1:], planes[point])
        dimmed = np.minimum(cosine / shading.lowest, 1.0)[:, None]
        dimmed = dimmed * gains_at(maps.gains, detail[point], *place_of_direction(cosine, azimuth))
        value[point] += weight * dimmed * srgb_decode(np.maximum(codes, 0.0) / 255.0)
    return value

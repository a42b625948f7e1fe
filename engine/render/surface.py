"""Reflection at the points that paths meet: f cos, and directions drawn from it.

The diffuse share of a BRDF is followed by the cosine lobe and the rest, its highlights, by the BRDF's own sampler; a
material's look-up (`engine.scene.scene`) stands in place of f cos where there is one. Bound by the BRDF's arithmetic.
"""

from __future__ import annotations

import threading
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import MODELS
from engine.brdf.models.multiple_scattering import SMOOTHEST
from engine.brdf.models.sampling import sampler_of, samples_itself
from engine.brdf.models.sampling_lobes import BELOW_ONE, CosineLobe, Mixture, VisibleGgxLobe
from engine.core.kernels import scalar
from engine.render.direct import part_of, sample, texture_axes, texture_coordinates
from engine.render.hex_tiling import maps_of_scene
from engine.render.pbr import Texels, texels_at
from engine.scene.scene import Scene
from engine.shading.directional.planes import DirectionalMap


@scalar
def to_world(frame: np.ndarray, local: np.ndarray) -> np.ndarray:
    """World directions (N, 3) of directions (N, 3) in `frame` (N, 3, 3)."""
    world = np.empty_like(local)
    for n in range(len(local)):
        for i in range(3):
            world[n, i] = frame[n, i, 0] * local[n, 0] + frame[n, i, 1] * local[n, 1] + frame[n, i, 2] * local[n, 2]
    return world


@scalar
def to_local(frame: np.ndarray, world: np.ndarray) -> np.ndarray:
    """Directions (N, 3) in `frame` (N, 3, 3) of world directions (N, 3)."""
    local = np.empty_like(world)
    for n in range(len(world)):
        for j in range(3):
            local[n, j] = frame[n, 0, j] * world[n, 0] + frame[n, 1, j] * world[n, 1] + frame[n, 2, j] * world[n, 2]
    return local


Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Quantiles of the widths of highlights in PBR maps from which directions are drawn: the density is the same at all
#: texels, and each highlight is about as wide as one of them.
WIDTHS = (0.02, 0.3, 0.7, 0.98)

#: Quantiles of these where parts of a model have materials of their own, and the most widths of coats.
OF_ALL, MAX_COATS = (0.0, 0.3, 0.7, 1.0), 3

#: Pairs of directions that a BRDF evaluates at once without threads of its own.
BLOCK = 8192


@dataclass(frozen=True, eq=False)
class Points:
    """Points of the surface (M,): `origin` of rays, `frame` (M, 3, 3), `viewer` in that frame, what else is needed.

    `texels` are the PBR maps there, black on the ground; None without any.
    """

    face: NDArray[np.int32]
    barycentric: Floats
    origin: Floats
    frame: Floats
    viewer: Floats
    texels: Texels | None = None


class Reflector:
    """Reflection of a scene's surface: values f cos and densities, at the model and at its ground."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._diffuse_share, self._highlights = _lobes(scene)
        self._maps = [maps_of_scene(each) for each in scene.parts]
        self._ground_from = len(scene.mesh.faces) if scene.ground is not None else None
        brdfs = [each.brdf for each in scene.parts]
        measured = any(type(brdf) not in MODELS.values() for brdf in brdfs)
        # kernels of measurements use all threads by themselves, and not every pool of threads lets two callers in
        self._values: AbstractContextManager[Any] = threading.Lock() if measured else nullcontext()
        self._draws = self._values if any(map(samples_itself, brdfs)) else nullcontext()

    def product(self, at: Points, index: Indices, wi: Floats) -> Floats:
        """f cos, or what a material shows in its place, (K, 3) at the points `index` for light from `wi` (K, 3)."""
        ground = self._on_ground(at, index)
        if ground is None:
            return self._object(at, index, wi)
        value = np.empty((len(index), 3))
        assert self.scene.ground is not None
        value[ground] = (self.scene.ground.albedo / np.pi) * wi[ground, 2:]
        value[~ground] = self._object(at, index[~ground], wi[~ground])
        return value

    def texture(self, at: Points, away: Floats) -> Points:
        """The points with their texels and the frames that normals bend; `away` (M, 3) leads to the viewer.

        The same where there are no PBR maps.
        """
        scene = self.scene
        if scene.pbr is None:
            return at
        ground = self._on_ground(at, np.arange(len(at.face)))
        face = at.face if ground is None else np.where(ground, 0, at.face)
        corners = texture_coordinates(scene, scene.mesh.faces[face])
        uv = np.einsum("nc,nci->ni", at.barycentric, corners)
        texels = self._texels(face, uv)
        if scene.colours is not None:
            texels = texels.tint(np.einsum("nc,nci->ni", at.barycentric, scene.colours[scene.mesh.faces[face]]))
        axes = texture_axes(scene.mesh.positions[scene.mesh.faces[face]], corners, at.frame[..., 2])
        frame = texels.bend_frames(at.frame, axes, away)
        frame = frame if ground is None else np.where(ground[:, None, None], at.frame, frame)
        texels = texels.in_frames(at.frame, frame)
        return replace(at, frame=frame, viewer=to_local(frame, away), texels=texels)

    def _texels(self, face: NDArray[np.int32], uv: Floats) -> Texels:
        """The PBR maps of the part of each triangle (N,) of the model at `uv` (N, 2), with the layers of the first."""
        number, scenes = part_of(self.scene, face), self.scene.parts
        found: Texels | None = None
        for at, (scene, maps) in enumerate(zip(scenes, self._maps, strict=True)):
            points = np.flatnonzero(number == at)
            assert scene.pbr is not None
            own = scene.texture_scale / self.scene.texture_scale
            if len(points) == len(face):
                return texels_at(maps, uv * own, np.zeros(len(uv)), scene.pbr)
            if points.size:
                texels = texels_at(maps, uv[points] * own, np.zeros(len(points)), scene.pbr)
                found = texels.scatter(points, len(face), found)
        assert found is not None
        return found

    @property
    def has_highlight(self) -> bool:
        return self._highlights is not None

    def highlight(self, at: Points, index: Indices, wi: Floats) -> Floats:
        """The density (K,) in 1/sr of directions `wi` (K, 3) at the points `index`, drawn for highlights alone."""
        if self._highlights is None:
            return np.zeros(len(index))
        viewer, ground = at.viewer[index], self._on_ground(at, index)
        with self._draws:
            if ground is None:
                return self._highlights.pdf(wi, viewer)
            density = np.zeros(len(index))
            density[~ground] = self._highlights.pdf(wi[~ground], viewer[~ground])
            return density

    def density(self, at: Points, index: Indices, wi: Floats, highlight: Floats) -> Floats:
        """At which `draw` makes `wi` (K, 3) at the points `index`, (K,) in 1/sr, given that for highlights."""
        ground, diffuse = self._on_ground(at, index), np.maximum(wi[:, 2], 0.0) / np.pi
        share = self._diffuse_share if ground is None else np.where(ground, 1.0, self._diffuse_share)
        return np.asarray(share * diffuse + (1.0 - share) * highlight)

    def draw(self, at: Points, u: Floats, *, highlight: bool = False) -> Floats:
        """Directions (M, 3) towards light in the frame of each point, from u (M, 3) in [0, 1).

        Those for a `highlight` alone are made with its density, and point straight down where there is none.
        """
        ground = self._on_ground(at, np.arange(len(u)))
        share = np.full(len(u), 0.0 if highlight else self._diffuse_share)
        if ground is not None:
            share[ground] = 1.0
        diffuse = u[:, 0] < share
        wi = np.empty((len(u), 3))
        wi[diffuse] = (0.0, 0.0, -1.0) if highlight else CosineLobe().sample(at.viewer[diffuse], u[diffuse])
        if self._highlights is not None:
            rest = ~diffuse
            again = np.minimum((u[rest, :1] - share[rest, None]) / (1.0 - share[rest, None]), BELOW_ONE)
            with self._draws:
                wi[rest] = self._highlights.sample(at.viewer[rest], np.column_stack([again, u[rest, 1:]]))
        return wi

    def _on_ground(self, at: Points, index: Indices) -> NDArray[np.bool_] | None:
        return None if self._ground_from is None else at.face[index] >= self._ground_from

    def _object(self, at: Points, index: Indices, wi: Floats) -> Floats:
        if at.texels is not None:
            return self._reflect_texels(at, at.texels, index, wi)
        f = self._f(wi, at.viewer[index], at.face[index])
        if self.scene.shading is None or len(index) == 0:
            return f * wi[:, 2:]
        scene, everywhere = self.scene, np.arange(len(index))
        corners = texture_coordinates(scene, scene.mesh.faces[at.face[index]])
        uv = np.einsum("nc,nci->ni", at.barycentric[index], corners)
        along = [np.zeros_like(uv)] * 2
        heading = self._heading(at, index, wi, corners) if isinstance(scene.shading, DirectionalMap) else None
        return sample(scene, self._maps[0], uv, along, iter([(everywhere, f, wi[:, 2], np.ones(3), heading)]))

    def _reflect_texels(self, at: Points, texels: Texels, index: Indices, wi: Floats) -> Floats:
        scenes = self.scene.parts
        number = part_of(self.scene, at.face[index])
        value = np.zeros((len(index), 3))
        for part, scene in enumerate(scenes):
            assert scene.pbr is not None
            points = np.flatnonzero(number == part) if len(scenes) > 1 else np.arange(len(index))
            own = texels.with_layers_of(scene.pbr)
            value[points] = own.even_product(index[points], wi[points], at.viewer[index[points]])
        return value

    def _heading(self, at: Points, index: Indices, wi: Floats, corners: Floats) -> Floats:
        """Directions `wi` (K, 3) along the axes of the texture, (K, 2)."""
        mesh, frame = self.scene.mesh, at.frame[index]
        axes = texture_axes(mesh.positions[mesh.faces[at.face[index]]], corners, frame[..., 2])
        return np.asarray(np.einsum("nai,ni->na", axes, to_world(frame, wi)))

    def _f(self, wi: Floats, wo: Floats, face: NDArray[np.int32]) -> Floats:
        """Values (K, 3) of the BRDF of the part of each triangle (K,)."""
        value, number, scenes = np.empty((len(wi), 3)), part_of(self.scene, face), self.scene.parts
        with self._values:
            for part, scene in enumerate(scenes):
                points = np.flatnonzero(number == part) if len(scenes) > 1 else np.arange(len(wi))
                for start in range(0, len(points), BLOCK):
                    block = points[start : start + BLOCK]
                    value[block] = scene.brdf.f(wi[block], wo[block])
        return value


def _mixture_of(scene: Scene) -> Mixture:
    """The lobes of the BRDF, or of those of all parts, each as often; the cosine lobe is the first."""
    mixtures = []
    for brdf in dict.fromkeys(each.brdf for each in scene.parts):
        mixture = sampler_of(brdf)
        assert isinstance(mixture, Mixture)
        mixtures.append(mixture)
    if len(mixtures) == 1 or scene.pbr is not None:
        return mixtures[0]
    diffuse = sum(each.shares[0] for each in mixtures) / len(mixtures)
    lobes = [lobe for each in mixtures for lobe in each.lobes[1:]]
    shares = [share / len(mixtures) for each in mixtures for share in each.shares[1:]]
    return Mixture((mixtures[0].lobes[0], *lobes), (diffuse, *shares))


def _lobes(scene: Scene) -> tuple[float, Mixture | None]:
    """The share of the cosine lobe (more for materials, which are brighter than f where f is small), and the others."""
    mixture = _mixture_of(scene)
    if scene.pbr is not None:
        parts = [each.pbr for each in scene.parts if each.pbr is not None]
        of_parts = [np.quantile(np.maximum(each.roughness, SMOOTHEST) ** 2.0, WIDTHS) for each in parts]
        of_all = of_parts[0] if len(parts) == 1 else np.quantile(of_parts, OF_ALL)
        widths = np.unique(of_all.round(4))
        coats = [each.layers.coat_roughness for each in parts if each.layers and each.layers.coat_weight > 0.0]
        widths = np.append(widths, np.unique(np.maximum(coats, SMOOTHEST) ** 2)[:MAX_COATS])
        lobes = tuple(VisibleGgxLobe(width, width) for width in widths.tolist())
        return mixture.shares[0], Mixture(lobes, (1.0 / len(lobes),) * len(lobes))
    diffuse, rest = mixture.shares[0], mixture.lobes[1:]
    if not rest:
        return 1.0, None
    shares = tuple(share / (1.0 - diffuse) for share in mixture.shares[1:])
    return (diffuse if scene.shading is None else 0.5 + 0.5 * diffuse), Mixture(rest, shares)

"""What the surface of a scene does with light at points that paths meet: f cos, and directions drawn from it.

The matt share of a BRDF is followed by the cosine lobe and the rest, its highlights, by the BRDF's own sampler; a
material's look-up (`engine.scene`) stands in place of f cos where there is one. Bound by the BRDF's arithmetic.
"""

from __future__ import annotations

import threading
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import MODELS
from engine.brdf.lobes import BELOW_ONE, CosineLobe, Mixture
from engine.brdf.sampling import sampler_of
from engine.render.direct import looked_up, mip_levels, texture_coordinates
from engine.scene import Scene

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Pairs of directions that a BRDF evaluates at once without threads of its own.
BLOCK = 8192


@dataclass(frozen=True, eq=False)
class Points:
    """Points of the surface (M,): `origin` of rays, `frame` (M, 3, 3), `viewer` in that frame, what else is needed."""

    face: NDArray[np.int32]
    barycentric: Floats
    origin: Floats
    frame: Floats
    viewer: Floats


class Reflector:
    """What a scene's surface does with light: values f cos and densities, at the model and at its ground."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._matt_share, self._highlights = _lobes(scene)
        self._levels = mip_levels(scene.shading)
        self._ground_from = len(scene.mesh.faces) if scene.ground is not None else None
        measured = type(scene.brdf) not in MODELS.values()
        # kernels of measurements use all threads by themselves, and not every pool of threads lets two callers in
        self._values: AbstractContextManager[Any] = threading.Lock() if measured else nullcontext()
        self._draws = self._values if hasattr(scene.brdf, "sample") else nullcontext()

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
        ground, matt = self._on_ground(at, index), np.maximum(wi[:, 2], 0.0) / np.pi
        share = self._matt_share if ground is None else np.where(ground, 1.0, self._matt_share)
        return np.asarray(share * matt + (1.0 - share) * highlight)

    def draw(self, at: Points, u: Floats, *, highlight: bool = False) -> Floats:
        """Directions (M, 3) towards light in the frame of each point, from u (M, 3) in [0, 1).

        Those for a `highlight` alone are made with its density, and point straight down where there is none.
        """
        ground = self._on_ground(at, np.arange(len(u)))
        share = np.full(len(u), 0.0 if highlight else self._matt_share)
        if ground is not None:
            share[ground] = 1.0
        matt = u[:, 0] < share
        wi = np.empty((len(u), 3))
        wi[matt] = (0.0, 0.0, -1.0) if highlight else CosineLobe().sample(at.viewer[matt], u[matt])
        if self._highlights is not None:
            rest = ~matt
            again = np.minimum((u[rest, :1] - share[rest, None]) / (1.0 - share[rest, None]), BELOW_ONE)
            with self._draws:
                wi[rest] = self._highlights.sample(at.viewer[rest], np.column_stack([again, u[rest, 1:]]))
        return wi

    def _on_ground(self, at: Points, index: Indices) -> NDArray[np.bool_] | None:
        return None if self._ground_from is None else at.face[index] >= self._ground_from

    def _object(self, at: Points, index: Indices, wi: Floats) -> Floats:
        f = self._f(wi, at.viewer[index])
        if self.scene.shading is None or len(index) == 0:
            return f * wi[:, 2:]
        scene, everywhere = self.scene, np.arange(len(index))
        corners = texture_coordinates(scene, scene.mesh.faces[at.face[index]])
        uv = np.einsum("nc,nci->ni", at.barycentric[index], corners)
        along = [np.zeros_like(uv)] * 2
        return looked_up(scene, self._levels, uv, along, iter([(everywhere, f, wi[:, 2], np.ones(3))]))

    def _f(self, wi: Floats, wo: Floats) -> Floats:
        value = np.empty((len(wi), 3))
        with self._values:
            for start in range(0, len(wi), BLOCK):
                block = slice(start, start + BLOCK)
                value[block] = self.scene.brdf.f(wi[block], wo[block])
        return value


def _lobes(scene: Scene) -> tuple[float, Mixture | None]:
    """The share of the cosine lobe (more for materials, which are brighter than f where f is small), and the others."""
    mixture = sampler_of(scene.brdf)
    assert isinstance(mixture, Mixture)
    matt, rest = mixture.shares[0], mixture.lobes[1:]
    if not rest:
        return 1.0, None
    shares = tuple(share / (1.0 - matt) for share in mixture.shares[1:])
    return (matt if scene.shading is None else 0.5 + 0.5 * matt), Mixture(rest, shares)

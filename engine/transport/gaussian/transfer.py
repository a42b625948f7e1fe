"""Gaussian light transport (Green2006): lobes of vertices for 92 views, and a diffuse part.

    T(wi) ≈ sum over lobes of w exp((wi·mu − 1) / sigma²)   Green2006 Eq. 4; per sr of light from wi

Between views and between vertices the PARAMETERS are mixed (Green2006 Sec. 5), so that a highlight moves and is not
faded from one place into another: means by barycentric shares, made unit vectors again, and widths by their logarithms,
so that they rise evenly from the narrow to the wide. In place of w we mix energies, w times the integral of its
Gaussian: between a narrow lobe and a wide one that reflect the same, the height of neither fits the width of the
mixture. Where means cancel, the lobe points where that of the nearest view does. Views below the horizon of a vertex
have no light to give; energies are mixed over the views above it alone, so that a model neither darkens towards its
outline nor shines from behind it.

The light is `engine.transport.gaussian.lighting`'s; the counterpart that draws is `engine.gl.gaussian`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.cached import cached_property
from engine.core.directions import Vectors, dot, normalize
from engine.geometry.mesh import Mesh
from engine.transport.baking.diffuse_specular import DiffusePart
from engine.transport.gaussian import kernel as gaussian_kernel
from engine.transport.gaussian.fitting.lobes import Lobes
from engine.transport.gaussian.fitting.views import VIEWS, nearest_views, view_directions
from engine.transport.gaussian.gpu_layout import pack
from engine.transport.gaussian.lighting import GaussianLight, lobe_radiance, sigma_range
from engine.transport.sh.transfer import ShTransport, transfer

#: The lowest that a view of a vertex is taken for, as its cosine, where a face beside it is seen.
GRAZING = 0.01


@dataclass(frozen=True, eq=False)
class GaussianTransport:
    """Gaussian transport of every vertex, before there is light.

    Attributes
    ----------
    mesh : model, and after it the ground where there is one; `ground_vertex` is the first vertex of the ground.
    ground_albedo : of the ground.
    components : lobes of the vertices of the model: of direct light and, where it was baked, of light that comes by
        way of the model itself. Their radiances are added (Green2006 Eq. 5).
    diffuse : vectors of the diffuse part, and of the ground; None where neither is.
    brdf : name of the BRDF.
    grazing : True if the diffuse part gives way to the highlight at grazing views
    (`baking.diffuse_specular.DiffusePart.grazing`).
    """

    mesh: Mesh
    ground_vertex: int
    ground_albedo: float
    components: tuple[Lobes, ...]
    diffuse: ShTransport | None
    brdf: str = ""
    grazing: bool = False

    def __post_init__(self) -> None:
        for lobes in self.components:
            if lobes.weight.shape[:2] != (self.ground_vertex, VIEWS):
                raise ValueError(
                    f"lobes of {lobes.weight.shape[0]} vertices and {lobes.weight.shape[1]} views do not belong to "
                    f"{self.ground_vertex} and {VIEWS}"
                )
        if self.diffuse is not None and not (self.diffuse.diffuse and self.diffuse.mesh is self.mesh):
            raise ValueError("the diffuse part is transport in vectors of the same mesh")

    @property
    def lobes(self) -> int:
        """Lobes of one vertex and view, all components together."""
        return sum(lobes.sigma.shape[2] for lobes in self.components)

    @cached_property
    def sigma_range(self) -> tuple[float, float]:
        """Narrowest and widest of the lobes that carry light, in rad (`gaussian.lighting.sigma_range`)."""
        return sigma_range(self.components)

    @cached_property
    def texels(self) -> NDArray[np.uint32]:
        """(V · 92 · lobes, 3) the lobes as shaders read them (`engine.transport.gaussian.gpu_layout`)."""
        return pack(self.components)

    @cached_property
    def normals(self) -> Vectors:
        """(V, 3) unit normals."""
        return normalize(self.mesh.normals)


@dataclass(frozen=True, eq=False)
class SeenLobes:
    """Lobes towards one direction each: `energy` (n, K, 3), unit `mean` (n, K, 3) in the world, `sigma` (n, K) rad.

    Energy is the integral of a lobe over the sphere, its radiance under an even light of 1.
    """

    energy: NDArray[np.float64]
    mean: NDArray[np.float64]
    sigma: NDArray[np.float64]


def lobes_towards(
    transport: GaussianTransport, directions: ArrayLike, vertices: NDArray[np.int64] | None = None
) -> SeenLobes:
    """Lobes of `vertices` (n,) of the model, all of them by default, towards `directions` (n, 3) in the world.

    Energies are 0 for directions below the horizon of a vertex. About 0.1 µs for each lobe.
    """
    of = np.arange(transport.ground_vertex) if vertices is None else vertices
    wo = np.broadcast_to(np.asarray(directions, np.float64), (len(of), 3))
    index, share = nearest_views(wo)
    normals = transport.normals[of]
    above = dot(normals[:, None], view_directions()[index]) > 0.0
    counts = np.where(above, share, 0.0)
    total = counts.sum(axis=1, keepdims=True)
    counts = np.where((total > 0.0) & (dot(normals, wo) > 0.0)[:, None], counts, 0.0) / np.where(total > 0, total, 1.0)
    seen = _empty(len(of), transport.lobes)
    first = 0
    for lobes in transport.components:
        gaussian_kernel.towards(
            lobes.weight,
            lobes.mean,
            lobes.sigma,
            of,
            index,
            share,
            counts,
            first,
            seen.energy,
            seen.mean,
            seen.sigma,
        )
        first += lobes.sigma.shape[2]
    return seen


def lobes_seen_from(transport: GaussianTransport, eye: ArrayLike) -> SeenLobes:
    """Lobes (V, K) of all vertices towards the point `eye` (3,), as images show them: those of the ground are black.

    A vertex of a face that is seen may be turned away itself; its view is then taken for a grazing one.
    """
    model = lobes_towards(transport, _lift(transport, eye))
    rest = len(transport.mesh.positions) - transport.ground_vertex
    if not rest:
        return model
    black = _empty(rest, transport.lobes)
    black.mean[..., 1] = black.sigma[...] = 1.0
    return SeenLobes(
        np.concatenate([model.energy, black.energy]),
        np.concatenate([model.mean, black.mean]),
        np.concatenate([model.sigma, black.sigma]),
    )


def diffuse_radiance(transport: GaussianTransport, coefficients: NDArray[np.floating]) -> NDArray[np.float64]:
    """(V, 3) of the diffuse part and of the ground under light whose SH are `coefficients` (order², 3)."""
    diffuse, first = transport.diffuse, transport.ground_vertex
    if diffuse is None:
        return np.zeros((len(transport.mesh.positions), 3))
    value = transfer(diffuse, coefficients).astype(np.float64)
    value[:first] *= diffuse.albedo
    value[first:] *= transport.ground_albedo
    return value


def diffuse_gain(transport: GaussianTransport, eye: ArrayLike) -> NDArray[np.float64]:
    """(V,) what the diffuse radiance of each vertex is multiplied with towards the point `eye` (3,)."""
    gain = np.ones(len(transport.mesh.positions))
    if transport.grazing:
        model = transport.normals[: transport.ground_vertex]
        diffuse = DiffusePart((1.0, 1.0, 1.0), grazing=True)
        gain[: transport.ground_vertex] = diffuse.gain(dot(model, _lift(transport, eye)))
    return gain


def _lift(transport: GaussianTransport, eye: ArrayLike) -> Vectors:
    """Unit directions from the vertices of the model to `eye`, lifted above their horizons."""
    first = transport.ground_vertex
    wo = normalize(np.asarray(eye, np.float64) - transport.mesh.positions[:first])
    normals = transport.normals[:first]
    low = np.maximum(GRAZING - dot(normals, wo), 0.0)
    return normalize(wo + low[:, None] * normals)


def mix(seen: SeenLobes, corners: NDArray[np.int64], share: NDArray[np.float64]) -> SeenLobes:
    """Lobes (n, K) within triangles, from those of their `corners` (n, 3) by barycentric `share` (n, 3).

    Where means cancel, the lobe points where that of the nearest corner does.
    """
    energy = np.einsum("nk,nklc->nlc", share, seen.energy[corners])
    mean = np.einsum("nk,nklc->nlc", share, seen.mean[corners])
    sigma = np.exp(np.einsum("nk,nkl->nl", share, np.log(seen.sigma)[corners]))
    square = dot(mean, mean)
    nearest = corners[np.arange(len(corners)), share.argmax(axis=1)]
    cancelled = (square <= gaussian_kernel.NOWHERE)[..., None]
    mean = np.where(cancelled, seen.mean[nearest], mean / np.sqrt(np.where(square > 0.0, square, 1.0))[..., None])
    return SeenLobes(energy, mean, sigma)


def radiance_towards(
    transport: GaussianTransport, light: GaussianLight, diffuse: NDArray[np.floating] | None, eye: ArrayLike
) -> NDArray[np.float64]:
    """(V, 3) radiance of all vertices towards the point `eye` (3,), not clamped.

    `diffuse` (V, 3) is the diffuse radiance under the same light (`diffuse_radiance`), or None.
    """
    seen = lobes_seen_from(transport, eye)
    value = lobe_radiance(light, seen.energy, seen.mean, seen.sigma)
    if diffuse is not None:
        value += diffuse * diffuse_gain(transport, eye)[:, None]
    return value


def _empty(vertices: int, lobes: int) -> SeenLobes:
    return SeenLobes(np.zeros((vertices, lobes, 3)), np.zeros((vertices, lobes, 3)), np.zeros((vertices, lobes)))

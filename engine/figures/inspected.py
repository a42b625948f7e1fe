"""The glossy transport of one vertex towards one view, and what lobes, Haar wavelets and spherical harmonics make of
it.

The paper's Figure 5 (Green2006) at a vertex of one's own: the function is tabulated as
luminance at the texels of a cube map, its L lobes take 7 L numbers, so many Haar coefficients are kept, and spherical
harmonics are of the lowest order with at least as many. Images show the hemisphere above the surface, by equal areas.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.colour import luminance
from engine.core.directions import Vectors, dot, normalize
from engine.core.steps import Step, Steps, part
from engine.figures.lobe_fit import (
    NUMBERS,
    Floats,
    Sum,
    Tabulated,
    gaussians,
    order_for,
    spherical_harmonics,
    texels,
    wavelets,
)
from engine.light.cube_map import texel_numbers
from engine.light.gaussian_prefilter import gaussian_integral
from engine.transport.gaussian.samples import GlossySurface, transport_at
from engine.transport.gaussian.transfer import GaussianTransport, lobes_towards
from engine.transport.sh.basis import evaluate

#: Texels along an edge of the cube map; pixels of an image.
EDGE, PIXELS = 64, 192


@dataclass(frozen=True, eq=False)
class Approximation:
    """One way to store the function: its name, the numbers that it takes, its image and its relative L² distance."""

    name: str
    numbers: int
    image: NDArray[np.float32]
    error_rel: float


@dataclass(frozen=True, eq=False)
class Inspected:
    """A vertex and a view.

    Attributes
    ----------
    cosine : of the view and the normal; nothing is reflected where it is not above 0.
    baked : whether the lobes are those of a bake, and not fitted to this function alone.
    image : (PIXELS, PIXELS) float32 luminance of the function in 1/sr, NaN outside the disc.
    highest : its largest value.
    approximations : lobes, Haar wavelets and spherical harmonics.
    """

    vertex: int
    cosine: float
    baked: bool
    image: NDArray[np.float32]
    highest: float
    approximations: tuple[Approximation, ...]


def inspect(
    surface: GlossySurface, vertex: int, view: ArrayLike, transport: GaussianTransport | None = None, lobes: int = 1
) -> Steps[Inspected]:
    """Direct glossy transport of a vertex of the model towards the world `view` (3,), and what is made of it.

    The lobes are those of `transport` between its views, or without one `lobes` that are nearest to this function.
    """
    yield Step(0.0, "tabulating transport")
    wo = normalize(view)
    frame = surface.frames[vertex]
    cosine = float(wo @ frame[:, 2])
    direction, area = texels(EDGE)
    table = Tabulated(_luminance(surface, vertex, wo, direction), direction, area)
    above, inside = _disc(frame)
    exact = np.full(inside.shape, np.nan, np.float32)
    exact[inside] = _luminance(surface, vertex, wo, above)
    yield Step(0.4, "fitting lobes")
    sums = yield from part(_lobes(table, vertex, wo, transport, lobes), 0.4, 0.8)
    numbers = NUMBERS * len(sums.sigma)
    order = order_for(numbers)
    yield Step(0.8, "keeping wavelets and spherical harmonics")
    wavelet, coefficients = wavelets(table, [numbers])[0], spherical_harmonics(table, order)
    ways = (
        ("Gaussian" if len(sums.sigma) == 1 else "Gaussians", numbers, sums.at(direction), sums.at(above)),
        ("Haar wavelets", numbers, wavelet, wavelet[texel_numbers(above, EDGE)]),
        ("SH", order**2, evaluate(order, direction) @ coefficients, evaluate(order, above) @ coefficients),
    )
    found = []
    for name, count, at_texels, at_pixels in ways:
        image = np.full(inside.shape, np.nan, np.float32)
        image[inside] = at_pixels
        found.append(Approximation(name, count, image, table.distance(at_texels)))
    highest = max(float(table.value.max()), float(np.nanmax(exact)))
    return Inspected(vertex, cosine, transport is not None, exact, highest, tuple(found))


def _luminance(surface: GlossySurface, vertex: int, view: Vectors, direction: Vectors) -> Floats:
    """(n,) of the function at unit vectors (n, 3); rays are cast for the upper hemisphere alone."""
    value = np.zeros(len(direction))
    up = np.flatnonzero(dot(direction, surface.frames[vertex][:, 2]) > 0.0)
    if float(view @ surface.frames[vertex][:, 2]) > 0.0:
        value[up] = luminance(transport_at(surface, vertex, view, direction[up]))
    return value


def _lobes(table: Tabulated, vertex: int, view: Vectors, transport: GaussianTransport | None, lobes: int) -> Steps[Sum]:
    """Those of direct light in a bake, as luminance; or the nearest."""
    if transport is None:
        return (yield from gaussians(table, lobes))[-1]
    seen = lobes_towards(transport, view, np.array([vertex]))
    count = transport.components[0].count
    sigma = seen.sigma[0, :count]
    weight = luminance(seen.energy[0, :count]) / gaussian_integral(sigma)
    return Sum(seen.mean[0, :count], sigma, np.asarray(weight, np.float64))


def _disc(frame: Vectors) -> tuple[Vectors, NDArray[np.bool_]]:
    """World directions (n, 3) of the pixels of a hemisphere seen from above, tangent to the right, and which they are.

    A pixel at r from the middle of a disc of radius 1 is at 2 sin(θ/2) = √2 r: equal areas.
    """
    place = (np.arange(PIXELS) + 0.5) / PIXELS * 2.0 - 1.0
    x, y = np.broadcast_arrays(place, -place[:, None])
    square = x * x + y * y
    inside = square <= 1.0
    scale = np.sqrt(np.maximum(2.0 - square, 0.0))
    local = np.stack([x * scale, y * scale, 1.0 - square], axis=-1)[inside]
    return np.asarray(local @ frame.T), inside

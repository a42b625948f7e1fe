"""Green2006 Figure 5: Gaussians, Haar wavelets and spherical harmonics of as many numbers.

Three typical transport functions, BRDF times cosine times visibility towards one view: a small glossy lobe, a
large one with something in the way, and a narrow anisotropic one. N Gaussians take 7 N numbers; so many Haar
coefficients are kept (their places, which would have to be stored as well, are not counted against them), and spherical
harmonics are of the lowest order with at least as many.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from engine.accuracy.compare import ErrorEstimate
from engine.brdf.brdf import brdf_from_text
from engine.core.directions import Vectors, normalize, surface_direction, world_from_tangent
from engine.core.steps import Step, Steps, part
from engine.figures.figure import Figure, Image, Settings, Shown, ShownRow
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
from engine.figures.plot import Curve, curves
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import caster_of
from engine.transport.baking.visibility import occlusion, receivers
from engine.transport.sh.basis import evaluate

#: Gaussians that are shown.
MAXIMUM = 10

#: Texels along an edge of the cube map that functions are tabulated at.
EDGE = 64

#: Pixels of the image of a function: the hemisphere seen from above.
PIXELS = 320


@dataclass(frozen=True)
class Typical:
    """One of the three functions: its names, BRDF, the viewer's angle, and whether things are in the way."""

    name: str
    slug: str
    brdf: str
    view_deg: float
    shadowed: bool = False


TYPICAL = (
    Typical("Small glossy lobe", "small-glossy", "ggx:kd=0,alpha=0.12,f0=1", 30.0),
    Typical("Large lobe with visibility", "large-with-visibility", "ggx:kd=0,alpha=0.4,f0=1", 20.0, True),
    Typical("Narrow anisotropic lobe", "narrow-anisotropic", "ashikhmin-shirley:kd=0,ks=1,nu=15,nv=600", 40.0),
)

#: A function of unit vectors (n, 3) in the surface frame, grey (n,).
Function = Callable[[Vectors], Floats]


def green_5(settings: Settings) -> Steps[Figure]:
    """Errors over the number of Gaussians, and images at the most of them."""
    edge, most = (16, 3) if settings.quick else (EDGE, MAXIMUM)
    rows, plots, table = [], {}, []
    for number, typical in enumerate(TYPICAL):
        function = function_of(typical, settings.model)
        direction, area = texels(edge)
        tabulated = Tabulated(function(direction), direction, area)
        share = number / len(TYPICAL), (number + 0.95) / len(TYPICAL)
        sums = yield from part(gaussians(tabulated, most), *share)
        errors = errors_of(tabulated, sums)
        plots[typical.slug] = _plot(typical, errors)
        for name, row in errors.items():
            table += [
                {"function": typical.slug, "brdf": typical.brdf, "by": name, "numbers": NUMBERS * n, "error_l2_rel": e}
                for n, e in enumerate(row, 1)
            ]
        rows.append(_row(typical, function, tabulated, sums[-1], {name: row[-1] for name, row in errors.items()}))
        yield Step((number + 1) / len(TYPICAL), "drawing")
    return Figure(
        "green-5",
        "Gaussians, wavelets and spherical harmonics of as many numbers",
        "Transport towards one view, seen from above, after Green, Kautz, Matusik and Durand 2006, Figure 5; "
        "errors are relative L² over the sphere",
        tuple(rows),
        plots,
        tuple(table),
    )


def _plot(typical: Typical, errors: dict[str, list[float]]) -> Any:
    counts = range(1, len(errors["Gaussians"]) + 1)
    lines = [Curve(name, list(counts), [100.0 * error for error in row]) for name, row in errors.items()]
    return curves(
        lines,
        "Gaussians, of 7 numbers each",
        "Relative L² error in %",
        title=f"{typical.name}, {typical.brdf}",
        note=verdict(errors),
        y_from_zero=True,
    )


def verdict(errors: dict[str, list[float]]) -> str:
    """A sentence that names the counts at which Gaussians are not the nearest."""
    own = errors["Gaussians"]
    better = {
        name: [str(n) for n, (other, error) in enumerate(zip(row, own, strict=True), 1) if other < error]
        for name, row in errors.items()
    }
    words = [f"{name} at {', '.join(counts)}" for name, counts in better.items() if counts]
    return f"Nearer than as many Gaussians: {'; '.join(words)}." if words else "Gaussians are the nearest everywhere."


def function_of(typical: Typical, mesh: Mesh) -> Function:
    """Reflectance times cosine, and for one of them the visibility at the most shaded vertex of `mesh`."""
    brdf = brdf_from_text(typical.brdf)
    wo = surface_direction(math.radians(typical.view_deg), 0.3)
    seen = _visible_at(mesh) if typical.shadowed else None

    def value(wi: Vectors) -> Floats:
        above = wi[:, 2] > 0.0
        found = np.zeros(len(wi))
        found[above] = (brdf.f(wi[above], wo[None]) * wi[above, 2:]).mean(axis=1)
        return found if seen is None else found * seen(wi)

    return value


def _visible_at(mesh: Mesh) -> Function:
    """Visibility in the frame of a vertex that sees about half of its hemisphere."""
    of = receivers(mesh, caster_of(mesh))
    vertex = int(np.argmin(np.abs(occlusion(mesh, of=of) - 0.6)))
    frame = world_from_tangent(of.normal[vertex])

    def visible(wi: Vectors) -> Floats:
        origin = np.broadcast_to(of.origin[vertex], wi.shape)
        return (~of.caster.occluded(origin, wi @ frame.T)).astype(np.float64)

    return visible


def errors_of(table: Tabulated, sums: list[Sum]) -> dict[str, list[float]]:
    """The relative L² error of each representation with the numbers of 1, 2, … Gaussians."""
    numbers = [NUMBERS * len(each.sigma) for each in sums]
    return {
        "Gaussians": [table.distance(each.at(table.direction)) for each in sums],
        "Haar wavelets": [table.distance(each) for each in wavelets(table, numbers)],
        "Spherical harmonics": [
            table.distance(evaluate(order, table.direction) @ spherical_harmonics(table, order))
            for order in map(order_for, numbers)
        ],
    }


def _row(typical: Typical, function: Function, table: Tabulated, best: Sum, errors: dict[str, float]) -> ShownRow:
    """The function, and what each representation makes of it."""
    wi, inside = _disc()
    numbers = NUMBERS * len(best.sigma)
    order = order_for(numbers)
    texel = cKDTree(table.direction).query(wi)[1]
    drawn: list[tuple[str, dict[str, Any], str, Floats]] = [
        (f"{len(best.sigma)} Gaussians", {"lobes": len(best.sigma)}, "Gaussians", best.at(wi)),
        (f"{numbers} wavelets", {"coefficients": numbers}, "Haar wavelets", wavelets(table, [numbers])[0][texel]),
        (
            f"SH of order {order}",
            {"order": order},
            "Spherical harmonics",
            evaluate(order, wi) @ spherical_harmonics(table, order),
        ),
    ]
    whole = function(wi)
    stops = -math.log2(max(float(whole.max()), 1e-30) * 1.1)
    shown = [
        Shown(words, _image(value, inside), parameters, ErrorEstimate(errors[name], 0.0), stops)
        for words, parameters, name, value in drawn
    ]
    heading = f"{typical.name}: {typical.brdf}, seen from {typical.view_deg:g}°"
    return ShownRow(heading, (*shown, Shown("transport", _image(whole, inside), exposure_ev=stops)))


def _disc() -> tuple[Vectors, Any]:
    """Directions (n, 3) of the pixels within the disc, and which these are."""
    place = (np.arange(PIXELS) + 0.5) / PIXELS * 2.0 - 1.0
    x, y = np.meshgrid(place, -place)
    square = x * x + y * y
    inside = square < 1.0
    z = np.sqrt(np.maximum(1.0 - square, 0.0))
    return normalize(np.stack([x, y, z], axis=-1)[inside]), inside


def _image(value: Floats, inside: NDArray[np.bool_]) -> Image:
    image = np.zeros((*inside.shape, 4), np.float32)
    image[inside, :3], image[inside, 3] = np.maximum(value, 0.0)[:, None], 1.0
    return image

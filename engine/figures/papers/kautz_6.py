"""Kautz2002 Figure 6: the order of the spherical harmonics against the glossiness of the BRDF.

Columns are orders, the last but one windowed against ringing; the top row is the light itself, the others are a sphere
(or a model, with its shadows) of ever sharper highlights. The rightmost column is the reference.

Light at vertices in spherical harmonics of several orders from one set of rays, without keeping any matrices.

The matrix of a lower order is a corner of that of the highest, so a sweep of orders takes no longer than its last
step. A matrix of order 15 takes 200 kB; what it makes of the light takes 2.7 kB.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.accuracy.compare import ErrorEstimate
from engine.brdf.brdf import brdf_from_text
from engine.core.budget import free_bytes
from engine.core.errors import UsageError
from engine.core.figure_text import size_text
from engine.core.one_thread import one_thread
from engine.core.steps import Step, Steps, part
from engine.figures.figure import (
    Figure,
    Image,
    Settings,
    Shown,
    ShownRow,
    camera_of,
    compare_with,
    error_curve,
    exposure_of,
    reference_of,
)
from engine.figures.papers.vertex_images import View, view_of
from engine.figures.plot import curves
from engine.geometry.camera import Camera
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import caster_of
from engine.geometry.shapes import shape
from engine.light.environment import EnvironmentMap, reduce, solid_angles, texel_directions
from engine.light.environment_file import open_environment
from engine.scene.scene import Scene
from engine.transport.baking.visibility import receivers, visibility_shares
from engine.transport.sh.bake import default_edge
from engine.transport.sh.basis import apply_window, evaluate, order_of
from engine.transport.sh.brdf_table import BrdfTable, tabulate
from engine.transport.sh.lighting import project
from engine.transport.sh.rotation import rotate_into_frames
from engine.transport.sh.transfer import matrices, tangent_frames, visibility_harmonics

#: Parts along a side into which a texel is cut where visibility changes.
FINE = 4

#: Vertices whose matrices are held at once.
CHUNK = 64

Floats = NDArray[np.float64]


def light_at_vertices(
    mesh: Mesh, lights: Sequence[Floats], edge: int | None = None
) -> Steps[list[NDArray[np.float32]]]:
    """For each of `lights` (order², 3) in the world what (V, order², 3) of it reaches each vertex, in its frame.

    Vertices that see their whole hemisphere need no rays: there light is rotated and nothing else.
    """
    most = max(order_of(len(light)) for light in lights)
    edge = edge or default_edge(most)
    frames, of = tangent_frames(mesh), receivers(mesh, caster_of(mesh))
    found = [np.empty((len(mesh.positions), *light.shape), np.float32) for light in lights]
    free = np.flatnonzero(of.free)
    for light, rows in zip(lights, found, strict=True):
        if free.size:
            rows[free] = rotate_into_frames(light, frames[free])
        yield Step(0.0, "turning the light into the frames of the vertices")
    shaded = np.flatnonzero(~of.free)
    for start in range(0, len(shaded), CHUNK):
        vertices = shaded[start : start + CHUNK]
        counts = np.concatenate([counts for _, counts in visibility_shares(of, edge, FINE, vertices)])
        with one_thread():
            seen = visibility_harmonics(counts, FINE**2, edge, 2 * most - 1)
        whole = matrices(seen, frames[vertices], np.zeros(len(vertices), np.bool_))
        for light, rows in zip(lights, found, strict=True):
            rows[vertices] = whole[:, : len(light), : len(light)] @ light.astype(np.float32)
        done = min(start + CHUNK, len(shaded))
        yield Step(done / len(shaded), f"shadows of vertex {done:,} of {len(shaded):,}")
    return found


#: The paper's, from 9 to 225 coefficients; it uses 25 elsewhere.
ORDERS = (3, 5, 7, 10, 15)

#: The paper's anisotropic exponents.
EXPONENTS = ((12, 4), (24, 8), (48, 16))

#: Rows of the image of the light.
LIGHT_ROWS = 180

#: Vertices whose radiance is found at once.
AT_ONCE = 4096

#: Share of the free memory that light at vertices may take.
SHARE = 0.5

Coefficients = NDArray[np.float64]

#: Words over a column, its parameters, and the light (order², 3) in it.
Column = tuple[str, Mapping[str, Any], Coefficients]


def kautz_6(settings: Settings) -> Steps[Figure]:
    """The grid of orders and exponents."""
    environment = settings.environment or open_environment("studio")
    mesh = settings.mesh or (settings.model if settings.quick else shape("sphere"))
    orders = ORDERS[:2] if settings.quick else ORDERS
    columns = _columns(environment, orders)
    _check_memory(mesh, columns)
    arriving = yield from part(light_at_vertices(mesh, [light for *_, light in columns]), 0.0, 0.25)
    camera = camera_of(mesh, settings.size)
    view, frames = view_of(mesh, camera, settings.size), tangent_frames(mesh)
    rows = [_lights(environment, columns)]
    for number, exponents in enumerate(EXPONENTS[:1] if settings.quick else EXPONENTS):
        steps = _row(settings, mesh, camera, environment, exponents, view, view.local(frames), columns, arriving)
        rows.append((yield from part(steps, 0.25 + 0.25 * number, 0.5 + 0.25 * number)))
    return Figure(
        "kautz-6",
        "Order of the harmonics against glossiness",
        f"{mesh.name} under {environment.name}, after Kautz, Sloan and Snyder 2002, Figure 6; errors are relative RMSE "
        "against the reference",
        tuple(rows),
        {"errors": _plot(rows, orders)},
    )


def _check_memory(mesh: Mesh, columns: list[Column]) -> None:
    """UsageError where the light at all vertices takes more memory than there is."""
    needed = len(mesh.positions) * sum(light.size for *_, light in columns) * 4
    if needed > SHARE * free_bytes():
        raise UsageError(
            f"the light at {len(mesh.positions):,} vertices needs {size_text(needed)} of memory, more than is free"
        )


def _columns(environment: EnvironmentMap, orders: tuple[int, ...]) -> list[Column]:
    """The orders, and the highest once more with a window."""
    whole = project(environment, orders[-1])
    columns: list[Column] = [
        (f"order {order}{' *' if order == 5 else ''}", {"order": order, "window": "none"}, whole[: order**2])
        for order in orders
    ]
    last = {"order": orders[-1], "window": "hanning"}
    return [*columns, (f"order {orders[-1]}, Hanning", last, apply_window(whole, "hanning"))]


def _lights(environment: EnvironmentMap, columns: list[Column]) -> ShownRow:
    """The light as each column has it; errors are over the sphere, by solid angle, and exact."""
    small = reduce(environment, LIGHT_ROWS)
    height, width = small.radiance.shape[:2]
    area, directions = solid_angles(height, width), texel_directions(height, width)
    true = np.asarray(small.radiance, np.float64)
    whole = _opaque(true)
    shown, stops = [], exposure_of(whole)
    for words, parameters, light in columns:
        approximation = evaluate(parameters["order"], directions.reshape(-1, 3)) @ light
        apart = approximation.reshape(true.shape) - true
        whole_power = float(np.sum(true**2 * area[..., None]))
        error = np.sqrt(np.sum(apart**2 * area[..., None]) / whole_power) if whole_power > 0.0 else 0.0
        image = _opaque(np.maximum(approximation.reshape(true.shape), 0.0))
        shown.append(Shown(words, image, parameters, ErrorEstimate(float(error), 0.0), stops))
    return ShownRow("Light", (*shown, Shown("map", whole, exposure_ev=stops)))


def _opaque(radiance: NDArray[np.float64]) -> Image:
    return np.concatenate([radiance, np.ones((*radiance.shape[:2], 1))], axis=2).astype(np.float32)


def _row(
    settings: Settings,
    mesh: Mesh,
    camera: Camera,
    environment: EnvironmentMap,
    exponents: tuple[int, int],
    view: View,
    local: NDArray[np.float64],
    columns: list[Column],
    arriving: list[NDArray[np.float32]],
) -> Steps[ShownRow]:
    brdf = brdf_from_text(f"ashikhmin-shirley:kd=0,ks=0.5,nu={exponents[0]},nv={exponents[1]}")
    expected = yield from part(reference_of(Scene(mesh, camera, brdf, environment=environment), settings), 0.0, 0.5)
    table: BrdfTable = yield from part(
        tabulate(brdf, max(parameters["order"] for _, parameters, _ in columns)), 0.5, 0.8
    )
    panels = []
    for number, ((words, parameters, _), light) in enumerate(zip(columns, arriving, strict=True)):
        value = sum_at_vertices(table.reduce_order(parameters["order"]), light, local)
        panels.append((words, {**parameters, "nu": exponents[0], "nv": exponents[1]}, view.image(value)))
        yield Step(0.8 + 0.2 * (number + 1) / len(columns), f"drawing {words}")
    return ShownRow(f"Exponents {exponents[0]} and {exponents[1]}", compare_with(panels, expected, "reference"))


def sum_at_vertices(table: BrdfTable, light: NDArray[np.float32], local: NDArray[np.float64]) -> NDArray[np.float64]:
    """Radiance (V, 3) towards `local` (V, 3), a few vertices at a time: a row of a table of order 15 takes 5 kB."""
    some = [slice(start, start + AT_ONCE) for start in range(0, len(local), AT_ONCE)]
    return np.concatenate([table.radiance(light[each], local[each]) for each in some])


def _plot(rows: list[ShownRow], orders: tuple[int, ...]) -> Any:
    lines = [error_curve(row.heading, orders, row.images[: len(orders)]) for row in rows]
    return curves(lines, "Order", "Relative RMSE in %", title="Order against glossiness", y_from_zero=True)

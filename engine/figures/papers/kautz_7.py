"""Kautz2002 Figure 7: precomputed transfer of an isotropic BRDF, of an anisotropic one, and of another brushing.

The direction of brushing is a constant vector projected into the surface, as in the paper (Sec. 6).
"""

from __future__ import annotations

from engine.brdf.brdf import brdf_from_text
from engine.core.steps import Steps, part
from engine.figures.figure import Figure, Settings, ShownRow, camera_of, compare_with, reference_of
from engine.figures.papers.kautz_6 import light_at_vertices, sum_at_vertices
from engine.figures.papers.vertex_images import view_of
from engine.geometry.brushing import parse_brushing
from engine.light.environment_file import open_environment
from engine.scene.scene import Scene
from engine.transport.sh.brdf_table import tabulate
from engine.transport.sh.lighting import project
from engine.transport.sh.transfer import tangent_frames

#: What is drawn, the exponents of Ashikhmin and Shirley's model, and the brushing.
ROWS = (
    ("Isotropic", (16, 16), "y"),
    ("Anisotropic, brushed along y", (64, 4), "y"),
    ("Anisotropic, brushed along x", (64, 4), "x"),
)

#: The paper's order, and one that shows more.
ORDERS = (5, 10)


def kautz_7(settings: Settings) -> Steps[Figure]:
    """Two orders and the reference of each."""
    environment = settings.environment or open_environment("studio")
    camera = camera_of(settings.model, settings.size)
    rows = []
    for number, (heading, (nu, nv), direction) in enumerate(ROWS):
        share = number / len(ROWS), (number + 1) / len(ROWS)
        mesh = settings.model.brush(parse_brushing(direction))
        brdf = brdf_from_text(f"ashikhmin-shirley:kd=0.1,ks=0.5,nu={nu},nv={nv}")
        lights = [project(environment, order) for order in ORDERS]
        middle = 0.5 * (share[0] + share[1])
        expected = yield from part(
            reference_of(Scene(mesh, camera, brdf, environment=environment), settings), share[0], middle
        )
        arriving = yield from part(light_at_vertices(mesh, lights), middle, share[1])
        table = yield from part(tabulate(brdf, ORDERS[-1]), share[1], share[1])
        view = view_of(mesh, camera, settings.size)
        local = view.local(tangent_frames(mesh))
        panels = [
            (
                f"order {order}",
                {"order": order, "nu": nu, "nv": nv, "brushing": direction},
                view.image(sum_at_vertices(table.reduce_order(order), light, local)),
            )
            for order, light in zip(ORDERS, arriving, strict=True)
        ]
        rows.append(ShownRow(heading, compare_with(panels, expected, "reference")))
    return Figure(
        "kautz-7",
        "Directions of brushing",
        f"{settings.model.name} under {environment.name}, after Kautz, Sloan and Snyder 2002, Figure 7; errors are "
        "relative RMSE against the reference",
        tuple(rows),
    )

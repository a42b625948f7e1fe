"""Wang2004 Figures 2 and 5: terms of an anisotropic BRDF against the model itself, under one lamp.

The light is one direction, so wavelets have no part in it: what differs is the BRDF alone. Figure 2 is drawn once more
with non-negative terms, which the paper has not. Figure 5 compares one term and four with a grey diffuse surface, for
each map of the hemisphere; the paper, which has an environment there, shows one term over polar coordinates. Where all
texels count alike, as in the paper, the map decides what the terms are best at; weighted by solid angle and cosine they
are the same over all maps.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from engine.brdf.brdf import brdf_from_text
from engine.core.directions import world_direction
from engine.core.steps import Steps, part
from engine.factor.hemisphere_map import KINDS, HemisphereMap, MapKind
from engine.factor.separable import Weighting, separate
from engine.factor.separable_factors import SeparableFactors
from engine.figures.figure import Figure, Image, Settings, ShownRow, camera_of, compare_with, error_curve, reference_of
from engine.figures.papers.vertex_images import view_of
from engine.figures.papers.wavelet_rays import without_vectors
from engine.figures.plot import curves
from engine.geometry.shapes import shape
from engine.light.lamps import Lamp, lights_of_all
from engine.scene.scene import Scene
from engine.transport.wavelet.bake import MAP_SIZE, factors_for
from engine.transport.wavelet.lighting import lamp_tuples
from engine.transport.wavelet.transfer import sum_signed_radiance

#: The paper's.
BRDF = "ashikhmin-shirley:kd=0.5,ks=0.75,nu=10,nv=100"

#: The grey surface of Figure 5: the mean albedo of the other.
DIFFUSE = "lambert:albedo=0.5"

TERMS = (1, 2, 4, 8, 16)

#: Direction of the lamp, in degrees from above and towards the right, and its irradiance.
THETA_DEG, PHI_DEG, IRRADIANCE = 55.0, -35.0, 3.0


def wang_2(settings: Settings) -> Steps[Figure]:
    """The sweep of terms; the rightmost image is the analytic model."""
    brdf = brdf_from_text(BRDF)
    lit = _Lit(settings)
    expected = yield from part(reference_of(lit.scene, settings), 0.0, 0.3)
    counts = [terms for terms in TERMS if terms <= (4 if settings.quick else TERMS[-1])]
    factors = yield from part(factors_for(brdf, counts[-1], signs="signed"), 0.3, 0.5)
    signed = [(f"K = {terms}", {"terms": terms}, lit.draw(factors.truncate(terms))) for terms in counts]
    positive = []
    for number, terms in enumerate(counts):
        work = separate(brdf, HemisphereMap("orthographic", MAP_SIZE), terms, method="nonnegative", weighting="cosine")
        share = 0.5 + 0.5 * number / len(counts), 0.5 + 0.5 * (number + 1) / len(counts)
        found = yield from part(work, *share)
        positive.append((f"K = {terms}", {"terms": terms, "method": "nonnegative"}, lit.draw(found.factors)))
    rows = (
        ShownRow(f"{BRDF}, one lamp", compare_with(signed, expected, "analytic model")),
        ShownRow("Non-negative terms", compare_with(positive, expected, "analytic model")),
    )
    lines = [error_curve(name, counts, row.images) for name, row in zip(("signed", "non-negative"), rows, strict=True)]
    label, title = "Relative RMSE of the image in %", "Terms against the analytic model"
    return Figure(
        "wang-2",
        "Terms of the reflectance",
        f"{lit.scene.mesh.name} (the paper: Buddha) under one distant lamp, after Wang, Tran and Luebke 2004, Figure "
        "2; K terms; errors are relative RMSE against the reference",
        rows,
        {"errors": curves(lines, "Terms", label, title=title, y_from_zero=True)},
    )


def wang_5(settings: Settings) -> Steps[Figure]:
    """A diffuse surface, one term and four, for each map of the hemisphere."""
    brdf = brdf_from_text(BRDF)
    lit = _Lit(settings)
    grey = replace(lit.scene, brdf=brdf_from_text(DIFFUSE))
    expected = yield from part(reference_of(lit.scene, settings), 0.0, 0.2)
    diffuse = yield from part(reference_of(grey, settings), 0.2, 0.4)
    rows = []
    ways: list[tuple[MapKind, Weighting]] = [*((kind, "plain") for kind in KINDS), ("polar", "cosine")]
    for number, (kind, weighting) in enumerate(ways):
        share = 0.4 + 0.6 * number / len(ways), 0.4 + 0.6 * (number + 1) / len(ways)
        steps = separate(brdf, HemisphereMap(kind, MAP_SIZE), 4, weighting=weighting)
        factors = (yield from part(steps, *share)).factors
        panels: list[tuple[str, dict[str, Any], Image]] = [("diffuse", {"brdf": DIFFUSE}, diffuse.image)]
        for terms in (1, 4):
            parameters: dict[str, Any] = {"terms": terms, "map": kind, "weighting": weighting}
            panels.append((f"K = {terms}", parameters, lit.draw(factors.truncate(terms))))
        heading = f"{kind.capitalize()} map, " + (
            "texels count alike" if weighting == "plain" else "weighted by cosines"
        )
        rows.append(ShownRow(heading, compare_with(panels, expected, "analytic model")))
    return Figure(
        "wang-5",
        "One term over several maps of the hemisphere",
        f"{lit.scene.mesh.name} (the paper: Lucy) under one distant lamp (the paper: an environment), so that the BRDF "
        f"alone differs; {BRDF}; after Wang, Tran and Luebke 2004, Figure 5; errors are relative RMSE against the "
        "reference",
        tuple(rows),
    )


class _Lit:
    """The model under the lamp, and its images with factors."""

    def __init__(self, settings: Settings) -> None:
        mesh = settings.mesh or (settings.model if settings.quick else shape("blob"))
        camera = camera_of(mesh, settings.size)
        x, y, z = world_direction(np.radians(THETA_DEG), np.radians(PHI_DEG))
        self.scene = Scene(mesh, camera, brdf_from_text(BRDF), light=(x, y, z), irradiance=IRRADIANCE)
        self.lamp = lights_of_all([Lamp((x, y, z), (IRRADIANCE,) * 3)])
        self.view = view_of(mesh, camera, settings.size)

    def draw(self, factors: SeparableFactors) -> Image:
        transport = without_vectors(self.scene.mesh, factors)
        rows, everything = lamp_tuples(transport, self.lamp), np.arange(len(self.scene.mesh.positions))
        return self.view.image(sum_signed_radiance(transport, rows, self.view.local(transport.frames), everything))

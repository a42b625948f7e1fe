"""Wang2004 Figure 4: the first terms of four BRDFs, a model of four terms, and RMS curves.

The textures are light maps; those below 0 are shown as if above, as in the paper. Curves are the cosine-weighted RMS
error of the BRDF over 80,000 pairs of directions (`engine.factor.errors`), for maps of 16² to 64² texels.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from engine.brdf.brdf import Brdf, brdf_from_text
from engine.core.colour import to_display8
from engine.core.steps import Step, Steps, part
from engine.factor.errors import reference as pairs_of
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.separable import separate
from engine.factor.separable_factors import SeparableFactors
from engine.figures.contact_sheet import Panel, Row
from engine.figures.figure import Figure, Image, Settings, Shown, ShownRow, camera_of, compare_with, reference_of
from engine.figures.papers.vertex_images import View, view_of
from engine.figures.papers.wang_2 import BRDF
from engine.figures.papers.wavelet_rays import Kept, bake_together
from engine.figures.plot import Curve, curves
from engine.light.environment_file import open_environment
from engine.scene.scene import Scene
from engine.transport.wavelet.bake import MAP_SIZE, factors_for
from engine.transport.wavelet.lighting import Lighting, lighting_of, tuples
from engine.transport.wavelet.transfer import WaveletTransport, sum_signed_radiance

#: The paper's four: model, what it is, and text. The paper has no numbers for its plastic, which is therefore ours.
BRDFS = (
    ("Ashikhmin–Shirley", "brushed", BRDF),
    ("GGX", "brown plastic", "ggx:kd=0.45/0.28/0.16,alpha=0.25,f0=0.04"),
    ("Lafortune", "clay", "lafortune:preset=clay"),
    ("Lafortune", "skin", "lafortune:preset=skin"),
)

#: Terms that are shown, that the model is drawn with, and of the curves; texels a side of their maps.
SHOWN, DRAWN, MAXIMUM, SIZES = 8, 4, 20, (16, 32, 48, 64)

#: Pixels of a texture's image.
_EDGE = 224


def wang_4(settings: Settings) -> Steps[Figure]:
    """Terms, images and curves of the four BRDFs."""
    environment = settings.environment or open_environment("studio")
    mesh = settings.model
    camera, chosen = camera_of(mesh, settings.size), BRDFS[:1] if settings.quick else BRDFS
    models = [(f"{model}, {name}", name, text, brdf_from_text(text)) for model, name, text in chosen]
    maps, plots, table, kept = [], {}, [], []
    for number, (title, name, text, brdf) in enumerate(models):
        start, stop = 0.3 * number / len(models), 0.3 * (number + 1) / len(models)
        sweep, shown = yield from part(_curves(brdf, settings), start, stop)
        kept.append(Kept((yield from part(factors_for(brdf, DRAWN, signs="signed"), stop, stop))))
        table += [{"brdf": text, **line} for line in sweep]
        plots[f"rms-{name.replace(' ', '-')}"] = _plot(title, sweep)
        textures = tuple(_texture(shown, term) for term in range(SHOWN))
        maps.append(Row(f"{title}: light maps of the first {SHOWN} terms", textures))
    edge = min(settings.edge, 32)
    first = len(mesh.positions)
    baked = yield from part(bake_together(mesh, first, 0.0, edge, kept), 0.3, 0.6)
    lighting, view = lighting_of(environment, edge), view_of(mesh, camera, settings.size)
    drawn: list[Shown] = []
    for number, ((_, name, text, brdf), transport) in enumerate(zip(models, baked, strict=True)):
        share = 0.6 + 0.4 * number / len(models), 0.6 + 0.4 * (number + 1) / len(models)
        expected = yield from part(reference_of(Scene(mesh, camera, brdf, environment=environment), settings), *share)
        parameters = {"brdf": text, "terms": DRAWN, "coefficients": kept[number].coefficients, "cube": edge}
        drawn += compare_with([(name, parameters, _image(transport, lighting, view))], expected, "reference")
    return Figure(
        "wang-4",
        "Reflectances as sums of products",
        f"{mesh.name} (the paper: Bunny) under {environment.name}, after Wang, Tran and Luebke 2004, Figure 4; the "
        "paper has no numbers for its plastic; errors are relative RMSE against the reference",
        (ShownRow(f"Drawn with {DRAWN} terms", tuple(drawn)),),
        plots,
        tuple(table),
        tuple(maps),
    )


def _curves(brdf: Brdf, settings: Settings) -> Steps[tuple[list[dict[str, Any]], SeparableFactors]]:
    """The RMS error of each number of terms and size of the maps, and the factors at the size that bakes use."""
    pairs = pairs_of(brdf)
    most, sizes = (SHOWN, (16, MAP_SIZE)) if settings.quick else (MAXIMUM, SIZES)
    table, shown = [], None
    for number, size in enumerate(sizes):
        hemisphere_map = HemisphereMap("orthographic", size)
        share = number / len(sizes), (number + 1) / len(sizes)
        found = yield from part(separate(brdf, hemisphere_map, most, reference=pairs), *share)
        shown = found.factors if size == MAP_SIZE else shown
        for terms in range(1, found.factors.terms + 1):
            rms, _ = pairs.rms(found.factors.truncate(terms))
            table.append({"map_size": size, "terms": terms, "rms_cosine_weighted": rms})
        yield Step(share[1], f"terms of maps of {size} × {size}")
    assert shown is not None
    return table, shown


def _plot(name: str, table: list[dict[str, Any]]) -> Any:
    lines = []
    for size in dict.fromkeys(row["map_size"] for row in table):
        own = [row for row in table if row["map_size"] == size]
        terms = [row["terms"] for row in own]
        lines.append(Curve(f"{size} × {size}", terms, [row["rms_cosine_weighted"] for row in own]))
    return curves(lines, "Terms", "Cosine-weighted RMS error in 1/sr", title=name, y_from_zero=True)


def _texture(factors: SeparableFactors, term: int) -> Panel:
    """The light map of a term, or a field that says that there is none; texels outside of the disc are left dark."""
    if term >= factors.terms:
        return Panel(None, f"no term {term + 1}: the others are exact")
    values = np.abs(factors.second[term])
    inside = values[factors.hemisphere_map.mask]
    white = max(float(np.quantile(inside, 0.98)), 1e-30)
    shown = np.where(factors.hemisphere_map.mask[..., None], values / white, 0.0)[::-1]
    pixels = cv2.resize(to_display8(shown), (_EDGE, _EDGE), interpolation=cv2.INTER_NEAREST)
    return Panel(np.asarray(pixels, np.uint8), f"term {term + 1}, white is {white:.2g}")


def _image(transport: WaveletTransport, lighting: Lighting, view: View) -> Image:
    rows, everything = tuples(transport, lighting), np.arange(len(transport.mesh.positions))
    return view.image(sum_signed_radiance(transport, rows, view.local(transport.frames), everything))

"""Computations and exports of the Factor workspace beside the runs themselves; each is the work of a job."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from app.arguments.results import FACTORS
from engine.core.colour import luminance
from engine.core.steps import Step, Steps, part
from engine.render.display import diverging
from engine.storage.outputs import check_outputs

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf
    from engine.factor.errors import Factorisation
    from engine.scene.scene import Scene

Floats = NDArray[np.float64]
Pixels = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Difference:
    """An image (H, W, 4) uint8 of the difference in luminance, full colour at ±`scale`; the RMS over the model."""

    pixels: Pixels
    scale: float
    rms: float


def difference(factored: Scene, unfactored: Scene, size: tuple[int, int]) -> Steps[Difference]:
    """Both scenes on the CPU, which reads every BRDF as it is, and one minus the other."""
    yield Step(0.0, "compiling (first use only)")
    from engine.accuracy.difference import scale_of
    from engine.render.direct import radiance

    images = []
    for place, scene in enumerate((factored, unfactored)):
        images.append((yield from part(radiance(scene, size, samples=1), 0.5 * place, 0.5 * place + 0.5)))
    covered = images[1][..., 3] > 0.0
    apart = luminance(images[0][..., :3]) - luminance(images[1][..., :3])
    inside = np.abs(apart[covered])
    scale = scale_of(inside) if inside.size else 1.0
    pixels = np.zeros((*apart.shape, 4), np.uint8)
    pixels[..., :3] = diverging(apart / scale)
    pixels[..., 3] = np.where(covered, 255, 0)
    rms = float(np.sqrt((inside.astype(np.float64) ** 2).mean())) if inside.size else 0.0
    return Difference(pixels, scale, rms)


def judge(factorisation: Factorisation, terms: int, brdf: Brdf | None) -> Steps[tuple[str, ...]]:
    """Sentences on the possible uses of the first `terms` terms."""
    yield Step(0.0, "judging factors")

    from engine.factor.advice import advise
    from engine.factor.errors import uses

    found = _make(factorisation, terms)
    return uses(found) if brdf is None else (yield from advise(found, brdf))


def _make(factorisation: Factorisation, terms: int) -> Factorisation:
    """The same with so many terms at most."""
    if factorisation.factors.terms == terms:
        return factorisation
    factors = factorisation.factors.truncate(terms)
    term_errors = tuple(term_error for term_error in factorisation.term_errors if term_error.terms <= terms)
    return replace(
        factorisation,
        factors=factors,
        term_errors=term_errors,
        projections=getattr(factors, "projections", ()),
        searching=False,
    )


def export(factorisation: Factorisation, terms: int, folder: Path) -> Steps[str]:
    """Write so many terms to `folder`; says what stands there."""
    yield Step(0.0, "writing factors")

    from engine.factor.factor_file import write_factors

    check_outputs([(str(folder), FACTORS)], ())
    kept = write_factors(folder, _make(factorisation, terms))
    textures = kept.term_errors[-1].textures if kept.term_errors else 0
    return f"{folder.name} written: {textures} textures"

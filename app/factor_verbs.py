"""What the Factor workspace computes and writes beside the runs themselves; each is the work of a job."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from engine.colour import luminance, srgb_decode, srgb_encode
from engine.steps import Step, Steps, part

if TYPE_CHECKING:
    from engine.factor.errors import Factorisation
    from engine.scene import Scene

Floats = NDArray[np.float64]
Pixels = NDArray[np.uint8]

#: Blue where the factors are too dark and orange where they are too bright, after Okabe and Ito; no difference is grey.
BLUE, ORANGE = (0.0, 0.447, 0.698), (0.902, 0.624, 0.0)

#: The share of the largest differences that is cut off at the ends of their scale.
CUT = 0.005


@dataclass(frozen=True, eq=False)
class Difference:
    """A picture (H, W, 4) uint8 of the difference in luminance, full colour at ±`scale`; the RMS over the model."""

    pixels: Pixels
    scale: float
    rms: float


def difference(factored: Scene, unfactored: Scene, size: tuple[int, int]) -> Steps[Difference]:
    """Both scenes on the processor, which reads every reflectance as it is, and one minus the other."""
    yield Step(0.0, "preparing kernels")
    from engine.render.direct import radiance

    pictures = []
    for place, scene in enumerate((factored, unfactored)):
        pictures.append((yield from part(radiance(scene, size, samples=1), 0.5 * place, 0.5 * place + 0.5)))
    covered = pictures[1][..., 3] > 0.0
    apart = luminance(pictures[0][..., :3]) - luminance(pictures[1][..., :3])
    inside = np.abs(apart[covered])
    scale = _round_up(float(np.quantile(inside, 1.0 - CUT))) if inside.size else 1.0
    pixels = np.zeros((*apart.shape, 4), np.uint8)
    pixels[..., :3] = diverging(apart / scale)
    pixels[..., 3] = np.where(covered, 255, 0)
    rms = float(np.sqrt((inside.astype(np.float64) ** 2).mean())) if inside.size else 0.0
    return Difference(pixels, scale, rms)


def _round_up(value: float) -> float:
    """The next of 1, 2, 5 times a power of ten; a scale that one can say."""
    if not value > 1e-6:
        return 1e-6
    decade = 10.0 ** np.floor(np.log10(value))
    return float(next(step * decade for step in (1.0, 2.0, 5.0, 10.0) if step * decade >= value * (1.0 - 1e-9)))


def diverging(share: NDArray[Any]) -> Pixels:
    """(..., 3) uint8 of shares in [−1, 1] of a scale, cut off beyond."""
    share = np.clip(np.nan_to_num(share), -1.0, 1.0)[..., None]
    grey = srgb_decode([0.86, 0.86, 0.86])
    far = np.where(share < 0.0, srgb_decode(list(BLUE)), srgb_decode(list(ORANGE)))
    mixed = grey + np.abs(share) * (far - grey)
    return np.asarray(np.round(255.0 * srgb_encode(mixed)), np.uint8)


def judged(factorisation: Factorisation, terms: int, brdf: Any) -> Steps[tuple[str, ...]]:
    """What so many terms are good for, in sentences."""
    yield Step(0.0, "judging factors")
    from engine.factor.uses import uses

    return uses(_of(factorisation, terms), brdf)


def _of(factorisation: Factorisation, terms: int) -> Factorisation:
    """The same with so many terms at most."""
    if factorisation.factors.terms == terms:
        return factorisation
    factors = factorisation.factors.truncated(terms)
    ladder = tuple(rung for rung in factorisation.ladder if rung.terms <= terms)
    return replace(
        factorisation, factors=factors, ladder=ladder, projections=getattr(factors, "projections", ()), searching=False
    )


def exported(factorisation: Factorisation, terms: int, folder: Path) -> Steps[str]:
    """Write so many terms to `folder`; says what stands there."""
    yield Step(0.0, "writing factors")
    from engine.factor.factor_file import write_factors

    kept = write_factors(folder, _of(factorisation, terms))
    textures = kept.ladder[-1].textures if kept.ladder else 0
    return f"{folder.name} written: {textures} textures"

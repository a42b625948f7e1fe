"""What factors are good for, as sentences for a person."""

from __future__ import annotations

import math
from typing import Any

from engine.brdf.brdf import Brdf
from engine.factor.errors import Factorisation, reference
from engine.factor.separable_factors import SeparableFactors

#: Error relative to the reflectance itself above which its highlight counts as too narrow for the factors.
TOO_SPECULAR = 0.25

_GAUSSIAN = "for image-based light take the Gaussian mode, which follows the highlight itself"


def uses(factorisation: Factorisation, brdf: Brdf | None = None) -> tuple[str, ...]:
    """What the factors serve and what they do not; with `brdf` also whether it is too specular for them.

    That is judged by the cosine-weighted error of all terms relative to the RMS of the cosine-weighted reflectance:
    the singular values of a narrow highlight fall slowly, and no few terms describe it.
    """
    factors: Any = factorisation.factors
    sentences = list(_of_kind(factors))
    if brdf is not None and factorisation.ladder:
        share = factorisation.ladder[-1].rms_cosine_weighted / _size(brdf)
        if share > TOO_SPECULAR:
            sentences.append(
                "The highlight is too narrow for these factors, which are off by "
                f"{100.0 * share:.0f} % of the reflectance (RMS): {_GAUSSIAN}."
            )
    return tuple(sentences)


def _of_kind(factors: Any) -> tuple[str, ...]:
    terms = factors.terms
    if isinstance(factors, SeparableFactors):
        these = "this term" if terms == 1 else f"these {terms} terms"
        if factors.parametrisation == "in-out":
            return (
                f"Precomputed transport in wavelets can use {these}: light maps go into the transport, view maps are "
                "looked up while drawing.",
                "Direct light can use them too: two look-ups a term for each light.",
            )
        return (
            f"Direct light in the viewport can use {these}: textures of the half and the difference vector.",
            "Precomputed transport in wavelets cannot: it needs factors of the incident and the outgoing direction.",
        )
    looks = "two look-ups a texture" if factors.reciprocal else "one look-up a texture"
    these = "this texture" if terms == 1 else f"these {terms} textures"
    return (
        f"Direct light in the viewport can use {these}: {looks} for each light.",
        "Precomputed transport in wavelets cannot: it needs a sum of products, and this is one product.",
    )


def _size(brdf: Brdf) -> float:
    """Root mean square of f cos θ_i over random pairs, in 1/sr."""
    pairs = reference(brdf, 20_000)
    square = float(((pairs.value * pairs.wi[:, 2:]) ** 2).mean())
    return math.sqrt(square) if square > 0.0 else 1.0

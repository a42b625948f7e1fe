"""What factors are good for, as sentences for a person."""

from __future__ import annotations

from statistics import median
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from engine.brdf.brdf import Brdf
from engine.directions import Vectors
from engine.factor.errors import Factorisation, TermError, reference
from engine.factor.separable_factors import SeparableFactors

#: Error relative to the reflectance itself above which its highlight counts as too narrow for the factors.
TOO_SPECULAR = 0.25

_GAUSSIAN = "for image-based light take the Gaussian mode, which follows the highlight itself"


def uses(factorisation: Factorisation, brdf: Brdf | None = None) -> tuple[str, ...]:
    """What the factors serve and what they do not; with `brdf` also whether it is too specular for them.

    That is judged by the cosine-weighted error of all terms, relative to the reflectance: singular values of a narrow
    highlight fall slowly, and no few terms describe it.
    """
    factors: Any = factorisation.factors
    sentences = list(_of_kind(factors))
    if brdf is not None and factorisation.ladder:
        share = _missed(factorisation.ladder[-1], brdf)
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


def _missed(rung: TermError, brdf: Brdf) -> float:
    """Error relative to the reflectance itself: the median over bands of the viewer's elevation.

    Over all pairs together the last degrees before the horizon, where some measurements grow without bound, would
    drown the rest.
    """
    pairs = reference(brdf)
    _, bands = pairs.rms(_Black())
    shares = [error / size for error, size in zip(rung.rms_by_elevation_band, bands, strict=True) if size > 0.0]
    return median(shares) if shares else 0.0


class _Black:
    """Reflects nothing: its error is the size of what it is compared with."""

    isotropic = reciprocal = energy_conserving = True

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        return np.zeros(np.broadcast_shapes(np.shape(wi), np.shape(wo)))

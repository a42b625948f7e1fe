"""Uses of factors, and sums over half and difference vectors where those over light and view miss a highlight.

Over light and view a highlight is a ridge along all mirror directions, which few products cannot be: of Wang2004's BRDF
the best four in any order are 44 % off in an image under one lamp, and no other four of that form are much nearer (the
norm that they are best in is that image's, averaged over lamps). Over half and difference vectors it is one spot. One
product is then 4 % off, but transport, which needs the light apart, cannot use it.
"""

from __future__ import annotations

from engine.brdf.brdf import Brdf
from engine.core.figure_text import percent
from engine.core.steps import Steps, part
from engine.factor.errors import TOO_SPECULAR, Factorisation, reference, uses
from engine.factor.factor import MEASURED
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.separable import separate
from engine.factor.separable_factors import SeparableFactors

#: Share of the error that other factors must have to be spoken of.
BETTER = 0.5


def advise(found: Factorisation, brdf: Brdf) -> Steps[tuple[str, ...]]:
    """The sentences of `uses`, and one on half and difference vectors where as many terms of them are better.

    These are made to know it. Of measurements none are made: sampling their matrix takes a minute.
    """
    sentences = uses(found, brdf)
    factors = found.factors
    if not isinstance(factors, SeparableFactors) or factors.parametrisation != "in-out" or not found.term_errors:
        return sentences
    pairs = reference(brdf)
    share = pairs.miss(found.term_errors[-1].rms_by_elevation_band)
    if share <= TOO_SPECULAR or isinstance(brdf, MEASURED):
        return sentences
    polar = HemisphereMap("polar", factors.hemisphere_map.size)
    steps = separate(brdf, polar, factors.terms, method="svd", parametrisation="half-diff", weighting="cosine")
    other = (yield from part(steps, 0.0, 1.0)).factors
    apart = pairs.miss(pairs.rms(other)[1])
    if apart > BETTER * share:
        return sentences
    return (
        *sentences,
        "For direct light take half and difference vectors (parametrisation half-diff): as many terms of them are off "
        f"by {percent(apart)}, where these are by {percent(share)}.",
    )

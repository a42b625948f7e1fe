"""The diffuse part of pairs under polarisers in place of their whole radiance, for maps that are looked up by a BRDF.

A shading map with the highlights of its photographs shows them twice: once as they lay under the lamps of the capture,
and once as the BRDF has them under those of the scene.
Cost: one reading of the diffuse part.
"""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import Literal, get_args

import numpy as np

from engine.capture.stack import ImageStack
from engine.core.colour import LUMINANCE
from engine.core.errors import UsageError
from engine.core.figure_text import percent
from engine.core.health import Finding, Health, Verdict
from engine.core.steps import Step, Steps

#: Part of the light of pairs that a material is made of.
Part = Literal["diffuse", "whole"]
PARTS: tuple[Part, ...] = get_args(Part)

#: Rows of a photograph that are read at once.
ROWS = 256


def take_part(stack: ImageStack, wanted: Part) -> Steps[tuple[ImageStack, Health]]:
    """The stack with the wanted part of its light as its radiance, and a finding; as it is where it has no pairs.

    Raises UsageError for another part.
    """
    if wanted not in PARTS:
        raise UsageError(f"unknown part {wanted!r} of the light; choose from {', '.join(PARTS)}")
    if stack.diffuse is None:
        return stack, Health()
    if wanted == "whole":
        text = "Made of the whole light of the pairs: highlights of the photographs are in the map"
        return replace(stack, diffuse=None), Health(findings=(Finding(Verdict.NOTE, text),))
    count, height, width = stack.diffuse.shape[:3]
    means = np.zeros(count)
    for place in range(count):
        yield Step(place / count, "reading the diffuse part")
        for start in range(0, height, ROWS):
            band = np.asarray(stack.diffuse[place, start : start + ROWS])
            means[place] += float(band.sum(axis=(0, 1), dtype=np.float64) @ LUMINANCE) / (height * width)
    share = percent(1.0 - float(means.sum() / max(float(stack.mean_radiance.sum()), 1e-12)))
    text = f"Made of the diffuse part of the pairs: highlights, {share} of the light, are left to the BRDF"
    provenance = MappingProxyType({**stack.provenance, "part_of_light": "diffuse"})
    diffuse = replace(stack, radiance=stack.diffuse, diffuse=None, mean_radiance=means, provenance=provenance)
    return diffuse, Health(findings=(Finding(Verdict.NOTE, text),))

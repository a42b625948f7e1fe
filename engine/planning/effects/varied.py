"""A BRDF whose parameters differ over a model, as a plan looks at it: point by point, and on average.

Where a plan leaves the variation out, each parameter stands at its mean over the points of a sample, which lie as dense
as the surface, each weighted by the light that it receives: what is in the dark counts for nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import Brdf
from engine.core.colour import luminance
from engine.geometry.mesh import Mesh
from engine.planning.effects.sample import Sample
from engine.transport.baking.spatially_varying import (
    Variation,
    check_variations,
    vertex_values,
    with_parameters,
)

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Varied:
    """`brdf` with `values` (V,) of some parameters at each vertex of a model, as `variations` say."""

    brdf: Brdf
    variations: tuple[Variation, ...]
    values: Mapping[str, Array]

    def mean(self, sample: Sample) -> Mapping[str, float]:
        """Mean of each parameter over `sample`."""
        weight = measure_received(sample)
        if weight.sum() <= 0.0:
            weight = np.ones(len(weight))
        rows = sample.vertices
        means = {name: float(values[rows] @ weight / weight.sum()) for name, values in self.values.items()}
        return MappingProxyType(means)

    def at(self, vertices: NDArray[np.int64]) -> list[Brdf]:
        """The BRDF of each of `vertices`."""
        return [
            with_parameters(self.brdf, {name: float(values[vertex]) for name, values in self.values.items()})
            for vertex in vertices
        ]


def vary(mesh: Mesh, brdf: Brdf, variations: Sequence[Variation]) -> Varied:
    """The BRDF of `mesh`; ValueError for parameters that it does not have, InputError for what is not an image."""
    checked = check_variations(brdf, variations)
    values = {each.parameter: each.at(vertex_values(mesh, each.source)) for each in checked}
    return Varied(brdf, checked, MappingProxyType(values))


def measure_received(sample: Sample) -> Array:
    """(N,) luminance of the irradiance of each point."""
    normal = sample.frames[:, :, 2]
    cosine = np.maximum(normal @ sample.texels.direction.T, 0.0) * sample.visible
    total = cosine @ luminance(sample.incident)
    towards = np.maximum(normal @ sample.lamp_direction.T, 0.0) * sample.lamp_lit
    return np.asarray(total + towards @ luminance(sample.lamp_irradiance))

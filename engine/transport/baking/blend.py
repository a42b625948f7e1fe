"""Reflectances that are mixed over a model: weights of a few basis BRDFs at each vertex, and a colour.

    B(v, wo) = albedo(v) Σ_b weight_b(v) Σ_{k in b} view_k(wo) L_k(v)

The terms of all bases are baked beside each other, so weights and colours can change without another bake (Wang2004,
"All-frequency relighting of non-diffuse objects using separable BRDF approximation", Section 5.1):
they multiply what the light has made of each term, and everything that draws terms draws the mixture.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import UsageError
from engine.factor.separable_factors import SeparableFactors
from engine.geometry.mesh import Mesh
from engine.transport.baking.spatially_varying import vertex_colours, vertex_values

Floats = NDArray[np.floating[Any]]


@dataclass(frozen=True, eq=False)
class Mixture:
    """Mixture of the terms of a transport at the vertices of the model.

    Attributes
    ----------
    terms : of each basis, in the order of the transport's terms.
    weights : (V, B) in [0, 1], which add up to 1 at each vertex.
    albedo : (V, 3) in [0, 1], what all radiance of a vertex is multiplied by; None for 1.
    """

    terms: tuple[int, ...]
    weights: NDArray[np.float32]
    albedo: NDArray[np.float32] | None = None

    def __post_init__(self) -> None:
        if not self.terms or min(self.terms) < 1:
            raise ValueError(f"bases of {self.terms} terms cannot be")
        if self.weights.ndim != 2 or self.weights.shape[1] != len(self.terms):
            raise ValueError(f"weights of the shape {self.weights.shape} do not fit {len(self.terms)} reflectances")
        if self.albedo is not None and self.albedo.shape != (len(self.weights), 3):
            raise ValueError(f"colours of the shape {self.albedo.shape} do not fit {len(self.weights)} vertices")
        for name, values in (("weights", self.weights), ("colours", self.albedo)):
            if values is not None and not ((values >= 0.0) & (values <= 1.0)).all():
                raise ValueError(f"{name} are not all from 0 to 1")

    def applied(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """`rows` (V · K + ground, 3) of all terms, multiplied in place where they belong to the model; returned."""
        count, terms = len(self.weights), sum(self.terms)
        model = rows[: count * terms].reshape(count, terms, 3)
        if len(self.terms) > 1:
            model *= np.repeat(self.weights, self.terms, axis=1)[:, :, None]
        if self.albedo is not None:
            model *= self.albedo[:, None]
        return rows

    def of(self, vertices: NDArray[np.int64]) -> Mixture:
        """The mixture of some vertices alone."""
        return Mixture(self.terms, self.weights[vertices], None if self.albedo is None else self.albedo[vertices])


def mixture(
    mesh: Mesh, terms: Sequence[int], sources: Sequence[str | os.PathLike[str]], image: str | None = None
) -> Mixture:
    """The mixture of bases of so many `terms` over a model.

    `sources`, as of `engine.transport.baking.spatially_varying.vertex_values`, are the weights of all bases but the
    first, which has what is left; where they are more than 1 together, they share it. `image` has the albedo.
    UsageError where there are more or fewer sources; InputError for what is not an image.
    """
    if len(sources) != len(terms) - 1:
        count = "one reflectance" if len(terms) == 1 else f"{len(terms)} reflectances, of which the first has the rest"
        raise UsageError(f"{len(sources)} weights do not fit {count}")
    others = np.stack([vertex_values(mesh, source) for source in sources], axis=-1) if sources else None
    weights = np.ones((len(mesh.positions), 1))
    if others is not None:
        others /= np.maximum(others.sum(axis=1, keepdims=True), 1.0)
        weights = np.concatenate([np.maximum(1.0 - others.sum(axis=1, keepdims=True), 0.0), others], axis=1)
    albedo = None if image is None else vertex_colours(mesh, image).astype(np.float32)
    return Mixture(tuple(terms), weights.astype(np.float32), albedo)


def blend_from_text(text: str) -> tuple[str, str]:
    """`BRDF:SOURCE` as its two parts, say `ggx:alpha=0.1:y`; UsageError where there is only one."""
    brdf, _, source = text.rpartition(":")
    if source.startswith(("/", "\\")) and brdf[-2:-1] == ":" and brdf[-1].isalpha():  # the colon is that of a drive
        brdf, source = brdf[:-2], f"{brdf[-1]}:{source}"
    if not brdf or not source or "=" in source:
        raise UsageError(f"{text[:60]!r} is not of the form BRDF:SOURCE, say ggx:alpha=0.1:y or phong:mask.png")
    return brdf, source


def pad(base: SeparableFactors, terms: int) -> SeparableFactors:
    """`base` with as many `terms`, of which those that it does not have are black."""
    missing = ((0, terms - base.terms), (0, 0), (0, 0), (0, 0))
    return replace(base, first=np.pad(base.first, missing), second=np.pad(base.second, missing))


def together(bases: Sequence[SeparableFactors]) -> SeparableFactors:
    """All terms of `bases` as if they were of one BRDF, their sum; UsageError where their maps differ."""
    first = bases[0]
    if any(
        (other.hemisphere_map, other.parametrisation) != (first.hemisphere_map, first.parametrisation)
        for other in bases
    ):
        raise UsageError("factors over different maps cannot be mixed; give their reflectances, or equal maps")
    if len(bases) == 1:
        return first
    return SeparableFactors(
        first.hemisphere_map,
        first.parametrisation,
        np.concatenate([each.first for each in bases]),
        np.concatenate([each.second for each in bases]),
        all(each.isotropic for each in bases),
        all(each.reciprocal for each in bases),
        " + ".join(each.name for each in bases),
    )

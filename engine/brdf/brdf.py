"""What every reflectance model offers, the closed list of models, and their names as text.

A BRDF value is in 1/sr and does not contain the cosine. Directions are unit vectors in the surface frame (normal +z),
`wi` towards the light, `wo` towards the viewer; the value is 0 where either is at or below the horizon.
"""

from __future__ import annotations

from typing import Protocol

from numpy.typing import ArrayLike

from engine.brdf.diffuse import Lambert
from engine.brdf.microfacet import Ggx
from engine.brdf.phong import BlinnPhong, Phong
from engine.directions import Vectors
from engine.params import parse, unparse


class Brdf(Protocol):
    """A reflectance function. `energy_conserving` may depend on the parameters, the other two never do."""

    @property
    def isotropic(self) -> bool: ...

    @property
    def reciprocal(self) -> bool: ...

    @property
    def energy_conserving(self) -> bool: ...

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Values (..., 3) in 1/sr for unit directions (..., 3) that broadcast against each other."""
        ...


#: The analytic models by the name that files, the command line and the shaders use.
MODELS: dict[str, type] = {"lambert": Lambert, "phong": Phong, "blinn-phong": BlinnPhong, "ggx": Ggx}


def model_name(brdf: Brdf) -> str:
    """The name in `MODELS` of an analytic model; ValueError for anything else."""
    for name, model in MODELS.items():
        if type(brdf) is model:
            return name
    raise ValueError(f"{type(brdf).__name__} is not an analytic model; those are {', '.join(MODELS)}")


def brdf_from_text(text: str) -> Brdf:
    """Make a BRDF from `model` or `model:name=value,…`, e.g. `phong:exponent=20`; ValueError says what is known."""
    name, _, values = text.strip().partition(":")
    if name not in MODELS:
        raise ValueError(f"unknown BRDF {name!r}; known are {', '.join(MODELS)}")
    brdf: Brdf = parse(MODELS[name], values)
    return brdf


def brdf_to_text(brdf: Brdf) -> str:
    """The text that `brdf_from_text` turns back into `brdf`, with every parameter."""
    return f"{model_name(brdf)}:{unparse(brdf)}"

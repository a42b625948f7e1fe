"""The interface of every BRDF, the closed list of models, and their names as text.

A BRDF value is in 1/sr and does not contain the cosine. Directions are unit vectors in the surface frame (normal +z),
`wi` towards the light, `wo` towards the viewer; the value is 0 where either is at or below the horizon.
"""

from __future__ import annotations

from typing import Protocol

from numpy.typing import ArrayLike

from engine.brdf.models.diffuse import Lambert, OrenNayar
from engine.brdf.models.lafortune import Lafortune, LafortuneThreeLobes
from engine.brdf.models.microfacet import AshikhminShirley, CookTorrance, Ggx, GgxAnisotropic, MetallicRoughness, Ward
from engine.brdf.models.phong import BlinnPhong, Phong
from engine.brdf.models.poulin_fournier import PoulinFournier
from engine.brdf.models.presets import find_preset, text_of_preset
from engine.core.directions import Vectors
from engine.core.errors import UsageError
from engine.core.params import parameters, parse, unparse


class Brdf(Protocol):
    """A BRDF. `energy_conserving` may depend on the parameters, the other two never do."""

    @property
    def isotropic(self) -> bool: ...

    @property
    def reciprocal(self) -> bool: ...

    @property
    def energy_conserving(self) -> bool: ...

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Values (..., 3) in 1/sr for unit directions (..., 3) that broadcast against each other."""
        ...


#: The analytic models by the name that the window, the shaders and saved files use.
MODELS: dict[str, type] = {
    "lambert": Lambert,
    "oren-nayar": OrenNayar,
    "phong": Phong,
    "blinn-phong": BlinnPhong,
    "lafortune": Lafortune,
    "lafortune-three-lobes": LafortuneThreeLobes,
    "ward": Ward,
    "ashikhmin-shirley": AshikhminShirley,
    "cook-torrance": CookTorrance,
    "ggx": Ggx,
    "ggx-anisotropic": GgxAnisotropic,
    "poulin-fournier": PoulinFournier,
    "metallic-roughness": MetallicRoughness,
}

#: Names that stand for two models: the parameters that are given decide which is meant.
SECOND_FORMS = {"ggx": "ggx-anisotropic", "lafortune": "lafortune-three-lobes"}


def model_name(brdf: Brdf) -> str:
    """The name in `MODELS` of an analytic model; ValueError for anything else."""
    for name, model in MODELS.items():
        if type(brdf) is model:
            return name
    raise ValueError(f"{type(brdf).__name__} is not an analytic model; those are {', '.join(MODELS)}")


def brdf_from_text(text: str) -> Brdf:
    """Make a BRDF from `model`, `model:name=value,…` or `model:preset=name`; UsageError says what is known.

    `ggx:alpha=0.3` is isotropic, `ggx:alpha_x=0.1,alpha_y=0.4` is not.
    """
    name, _, values = text.strip().partition(":")
    if name not in MODELS:
        raise UsageError(f"unknown BRDF {name[:40]!r}; known are {', '.join(MODELS)}")
    given = [piece.partition("=")[0].strip() for piece in values.split(",")]
    if "preset" in given:
        if len(given) > 1:
            raise UsageError("a preset stands alone; known are model:preset=name and model:name=value,…")
        return find_preset(name, values.partition("=")[2].strip()).brdf
    brdf: Brdf = parse(MODELS[_form(name, given)], values)
    return brdf


def _form(name: str, given: list[str]) -> str:
    """`name`, or its second form where a parameter is given that only that one has."""
    if name not in SECOND_FORMS:
        return name
    first, second = ({p.name for p in parameters(MODELS[form])} for form in (name, SECOND_FORMS[name]))
    return SECOND_FORMS[name] if (second - first) & set(given) else name


def brdf_to_text(brdf: Brdf) -> str:
    """The text that `brdf_from_text` turns back into `brdf`: its preset, or every parameter."""
    name = model_name(brdf)
    named = {second: first for first, second in SECOND_FORMS.items()}.get(name, name)
    return text_of_preset(brdf) or f"{named}:{unparse(brdf)}"

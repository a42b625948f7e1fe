"""The models by name: those of the package and those that `register` or installed packages add; models as text."""

from __future__ import annotations

import dataclasses
import re

from engine.brdf.models.diffuse import Lambert, OrenNayar
from engine.brdf.models.lafortune import Lafortune, LafortuneThreeLobes
from engine.brdf.models.microfacet import AshikhminShirley, CookTorrance, Ggx, GgxAnisotropic, MetallicRoughness, Ward
from engine.brdf.models.model import Brdf as Brdf
from engine.brdf.models.model import Model
from engine.brdf.models.openpbr import OpenPbr, OpenPbrAnisotropic
from engine.brdf.models.phong import BlinnPhong, Phong
from engine.brdf.models.poulin_fournier import PoulinFournier
from engine.brdf.models.presets import find_preset, text_of_preset
from engine.core import plugins, shader_files
from engine.core.errors import UsageError
from engine.core.params import parameters, parse, unparse
from engine.core.suggestion import suggest

#: The analytic models by the name that the command line, the window, shaders and saved files use; `register` adds one.
MODELS: dict[str, type[Model]] = {}

#: Names that stand for two models: the parameters that are given decide which is meant.
SECOND_FORMS: dict[str, str] = {}

#: Group of the entry points by which installed packages bring further models.
ENTRY_POINTS = "lightarc.brdfs"

_NAME = re.compile(r"[a-z][a-z0-9-]{0,63}")


def register(model: type[Model]) -> type[Model]:
    """Declare a BRDF model; usable as a decorator of its class.

    Everything else follows: its text, its row in the library and in fits, its fields, its shader, projects and bundles.
    Raises ValueError where the class lacks something, or its name is taken.
    """
    if not (isinstance(model, type) and issubclass(model, Model) and dataclasses.is_dataclass(model)):
        raise ValueError(f"{model!r} must be a frozen dataclass derived from Model")
    for name in ("name", "label", "energy_conserving"):
        if getattr(model, name, "") == "":
            raise ValueError(f"the BRDF model {model.__name__} states no {name}")
    if not _NAME.fullmatch(model.name):
        raise ValueError(f"{model.name!r} is not a name of lower-case words joined by hyphens")
    others = [
        other for other in MODELS.values() if other.__qualname__ != model.__qualname__ or other.name != model.name
    ]
    if any(model.name == other.name or model.__name__ == other.__name__ for other in others):
        raise ValueError(f"there is another BRDF model {model.name} or class {model.__name__}")
    shader_files.add(f"brdf/{model.name}.glsl", model.shader)
    MODELS[model.name] = model
    if model.form_of:
        SECOND_FORMS[model.form_of] = model.name
    return model


def unregister(model: type[Model]) -> None:
    """Take back what `register` did."""
    if MODELS.get(model.name) is model:
        del MODELS[model.name]
        SECOND_FORMS.pop(model.form_of, None)
        shader_files.remove(f"brdf/{model.name}.glsl")


def label_of(name: str) -> str:
    """The label of a model by its name; the name itself where there is no such model."""
    return MODELS[name].label if name in MODELS else name


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
        raise UsageError(f"unknown BRDF {name[:40]!r}{suggest(name, MODELS)}; choose from {', '.join(MODELS)}")
    given = [piece.partition("=")[0].strip() for piece in values.split(",")]
    if "preset" in given:
        if len(given) > 1:
            raise UsageError("a preset takes no other parameters; write model:preset=name or model:name=value,…")
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


for _model in (
    *(Lambert, OrenNayar, Phong, BlinnPhong, Lafortune, LafortuneThreeLobes, Ward, AshikhminShirley, CookTorrance),
    *(Ggx, GgxAnisotropic, PoulinFournier, MetallicRoughness, OpenPbr, OpenPbrAnisotropic),
):
    register(_model)
plugins.load(ENTRY_POINTS, register)

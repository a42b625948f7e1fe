"""A material for other programs: brdf.json and a shader of its own; its page is `engine.bundle.page`.

The text shares the GLSL of the window (resources/shaders), includes written out.
"""

from __future__ import annotations

import base64
import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from engine.brdf.brdf import brdf_from_text, model_name
from engine.core import shader_files
from engine.core.errors import InputError
from engine.core.figure_text import percent
from engine.core.params import parameters
from engine.scene.material import Material, auto_sigma, compute_fit_error
from engine.shading.directional.effective_light import TILTS, TURNS, effective_cosine
from engine.shading.power_law import Storage
from engine.storage.records import TABLE
from engine.storage.untrusted import decode_content

RESOURCES = Path(__file__).resolve().parents[2] / "resources"

_INCLUDE = re.compile(r'^\s*#include "([^"]+)"\s*$', re.MULTILINE)
_UNIFORM = re.compile(r"^uniform (float|vec3) brdf_(\w+);$", re.MULTILINE)

#: Share by which a number may differ where another CPU worked it out.
_LAST_DIGITS = 1e-6

_IMAGE = re.compile(r'"(iVBOR[A-Za-z0-9+/=]*)"')
_NUMBER = re.compile(r"(\d+(?:\.\d+)?(?:e[-+]?\d+)?)")


def brdf_json(material: Material) -> str:
    """The BRDF as JSON: its text, model, parameters, and the sigma that goes with it.

    Where a measured table lies beside it, `measured` names that file, and the model is the one nearest to it.
    """
    brdf = brdf_from_text(material.brdf)
    value: dict[str, Any] = {
        "text": material.brdf,
        "model": model_name(brdf),
        "parameters": {parameter.name: getattr(brdf, parameter.name) for parameter in parameters(brdf)},
        "unit": "1/sr, the cosine is not included",
        "sigma": resolve_sigma(material),
        "sigma_is_automatic": material.sigma is None,
    }
    if material.measured is not None:
        value["measured"] = {
            "file": TABLE,
            "name": material.measured.name,
            "kind": material.measured.kind,
            "rmse_rel_of_model": compute_fit_error(material),
        }
    return json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def shader(material: Material, loss: str = "") -> str:
    """GLSL functions that evaluate `material`, with a usage comment; BRDF parameters are constants.

    Its head states the error of a fitted BRDF, and what else is known of the `loss`.
    """
    template = "lightarc.glsl" if material.directional is None else "directional.glsl"
    return shader_from(template, material, str, loss)


def brdf_source(material: Material) -> str:
    """GLSL of the BRDF that `material` names, its parameters as constants."""
    brdf = brdf_from_text(material.brdf)

    def constant(uniform: re.Match[str]) -> str:
        return f"const {uniform[1]} brdf_{uniform[2]} = {_glsl(getattr(brdf, uniform[2]))};"

    return _UNIFORM.sub(constant, brdf_glsl(model_name(brdf)))


def shader_from(template: str, material: Material, translated: Callable[[str], str], loss: str) -> str:
    """The functions of a template of resources/bundle, with GLSL `translated` to the language of the template."""
    return fill_in(
        (RESOURCES / "bundle" / template).read_text(encoding="utf-8"),
        NAME=_comment(material.name),
        LOSS=_comment(" ".join(filter(None, (fit_statement(material), loss))) or "The BRDF is not a fit.", 400),
        BRDF_TEXT=_comment(material.brdf),
        BRDF=translated(brdf_source(material)),
        **(_look_up_words(material) if material.directional is None else _directional_words(material, translated)),
    )


def _look_up_words(material: Material) -> dict[str, str]:
    return {
        "SIGMA": _glsl(resolve_sigma(material)),
        "R_MAX": _glsl(_r_max(material)),
        "EXPONENT_RANGE": _glsl(_exponent_range(material)),
    }


def _directional_words(material: Material, translated: Callable[[str], str]) -> dict[str, str]:
    directional = material.directional
    assert directional is not None
    largest = effective_cosine(brdf_from_text(material.brdf)).largest
    return {
        "PLANES": str(len(directional.planes)),
        "GAIN": _glsl(1.0 if material.sigma is None else material.sigma * largest / directional.r_max),
        "LOWEST": _glsl(directional.lowest),
        "TILTS": str(TILTS),
        "TURNS": str(TURNS),
        "SEARCH": translated(glsl_source("effective_light.glsl")),
    }


def resolve_sigma(material: Material) -> float:
    """The sigma of `material`, worked out where it is automatic."""
    if material.sigma is not None:
        return float(material.sigma)
    brdf = brdf_from_text(material.brdf)
    if material.directional is not None:
        largest = effective_cosine(brdf).largest
        return material.directional.r_max / largest if largest > 0.0 else 1.0
    return auto_sigma(brdf, np.radians(material.elevation_deg), _r_max(material))


def _r_max(material: Material) -> float:
    shading = material.power_law or material.shading_map
    return float(shading.r_max) if shading is not None else 1.0


def _exponent_range(material: Material) -> float:
    """Factor of a texture of stored exponents: the largest K of codes that are read as 0 to 1."""
    storage = material.power_law.storage if material.power_law is not None else Storage()
    return storage.exponent_step * (2**storage.exponent_bits - 1) if storage.exponent_bits < 32 else 1.0


def brdf_glsl(name: str) -> str:
    return glsl_source(f"brdf/{name}.glsl")


def glsl_source(name: str, written: set[str] | None = None) -> str:
    """A shader file with its includes written out, each once; those in `written` stand before it, and are added to."""
    written = set() if written is None else written
    written.add(name)
    text = shader_files.find(name).read_text(encoding="utf-8")

    def included(include: re.Match[str]) -> str:
        return "" if include[1] in written else glsl_source(include[1], written)

    return _INCLUDE.sub(included, text)


def _glsl(value: Any) -> str:
    if isinstance(value, tuple):
        return f"vec3({', '.join(_glsl(number) for number in value)})"
    digits = f"{min(float(value), float(np.finfo(np.float32).max)):.9g}"
    return digits if "." in digits or "e" in digits else f"{digits}.0"


def fit_statement(material: Material) -> str:
    """A sentence that states the error of the model in place of a measured BRDF; empty where nothing was measured."""
    error = compute_fit_error(material)
    if error is None or material.measured is None:
        return ""
    measured = f"the measured BRDF {material.measured.name!r}"
    return f"The BRDF is a fit of {measured}, with a relative RMSE of f cos(theta_i) of {percent(error, 3)}."


def _comment(text: str, most: int = 100) -> str:
    """`text` as part of one comment line: printable ASCII without the backslash that would continue the line."""
    return re.sub(r"[^ -\[\]-~]", "?", text)[:most]


def fill_in(template: str, **values: str) -> str:
    """`template` with each @NAME@ replaced once and nothing replaced within what was put in."""
    return re.sub("@(" + "|".join(values) + ")@", lambda found: values[found[1]], template)


def is_same_text(found: bytes, made: str) -> bool:
    """True where a text of a bundle is the one that was `made` here, but for the last digits of numbers.

    Images within it may be packed otherwise, as another version of zlib does, and must hold the same pixels.
    """
    try:
        text = found.decode("utf-8")
    except UnicodeDecodeError:
        return False
    if text == made:
        return True
    parts, own = _IMAGE.split(text), _IMAGE.split(made)
    if len(parts) != len(own) or not all(map(_is_same_but_for_digits, parts[::2], own[::2])):
        return False
    return all(map(_is_same_image, parts[1::2], own[1::2]))


def _is_same_but_for_digits(found: str, made: str) -> bool:
    parts, own = _NUMBER.split(found), _NUMBER.split(made)
    if len(parts) != len(own) or parts[::2] != own[::2]:
        return False
    return all(
        one == other or math.isclose(float(one), float(other), rel_tol=_LAST_DIGITS)
        for one, other in zip(parts[1::2], own[1::2], strict=True)
    )


def _is_same_image(found: str, made: str) -> bool:
    if found == made:
        return True
    try:
        pixels = [
            decode_content("engine.images.decode:decode", "image of the page", base64.b64decode(each))["pixels"]
            for each in (found, made)
        ]
    except (InputError, ValueError):
        return False
    return np.array_equal(*pixels)

"""A material for other programs: brdf.json, a shader of its own, and a page for any browser.

The page (resources/viewer/index.html) carries everything within itself, loads nothing and runs in WebGL 2. Its maps
are the power-law pair in 16 bits, each as two 8-bit PNG pictures (high and low byte), because browsers read no floats;
the error is half of 1/65535 of a map's largest value. Of a directional map they are the planes, three in a picture, and
the table of their weights in 16 bits. Maps above 1024 texels are averaged down, and the page says so.
Both texts share the GLSL of the window (resources/shaders), includes written out.
"""

from __future__ import annotations

import base64
import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import MODELS, Brdf, brdf_from_text, model_name
from engine.core.errors import InputError, UsageError
from engine.core.figure_text import percent
from engine.core.params import Parameter, parameters
from engine.render.mip_maps import planes_by_three
from engine.scene.material import Material, auto_sigma, fitted_error
from engine.shading.directional.effective_light import effective_cosine
from engine.shading.directional.planes import DirectionalMap
from engine.shading.power_law import PowerLawMap, Storage
from engine.storage.records import TABLE
from engine.storage.scratch import release
from engine.storage.untrusted import decode_content

RESOURCES = Path(__file__).resolve().parents[2] / "resources"

#: Longest side of the maps in the page, in texels.
VIEWER_SIDE = 1024

#: Share by which a number may differ where another processor worked it out.
_LAST_DIGITS = 1e-6

_PICTURE = re.compile(r'"(iVBOR[A-Za-z0-9+/=]*)"')
_NUMBER = re.compile(r"(\d+(?:\.\d+)?(?:e[-+]?\d+)?)")
_INCLUDE = re.compile(r'^\s*#include "([^"]+)"\s*$', re.MULTILINE)
_UNIFORM = re.compile(r"^uniform (float|vec3) brdf_(\w+);$", re.MULTILINE)


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
        "sigma": resolved_sigma(material),
        "sigma_is_automatic": material.sigma is None,
    }
    if material.measured is not None:
        value["measured"] = {
            "file": TABLE,
            "name": material.measured.name,
            "kind": material.measured.kind,
            "rmse_rel_of_model": fitted_error(material),
        }
    return json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def shader(material: Material, loss: str = "") -> str:
    """GLSL functions that evaluate `material`, with a usage comment; BRDF parameters are constants.

    Its head states the error of a fitted BRDF, and what else is known of the `loss`.
    """
    template = "lightarc.glsl" if material.directional is None else "directional.glsl"
    return shader_from(template, material, brdf_source(material), loss)


def brdf_source(material: Material) -> str:
    """GLSL of the BRDF that `material` names, its parameters as constants."""
    brdf = brdf_from_text(material.brdf)

    def constant(uniform: re.Match[str]) -> str:
        return f"const {uniform[1]} brdf_{uniform[2]} = {_glsl(getattr(brdf, uniform[2]))};"

    return _UNIFORM.sub(constant, _brdf_source(model_name(brdf)))


def shader_from(template: str, material: Material, brdf: str, loss: str) -> str:
    """The functions of a template of resources/bundle with the text of a BRDF in the same language."""
    return _filled(
        (RESOURCES / "bundle" / template).read_text(encoding="utf-8"),
        NAME=_comment(material.name),
        LOSS=_comment(" ".join(filter(None, (fit_statement(material), loss))) or "The BRDF is not a fit.", 400),
        BRDF_TEXT=_comment(material.brdf),
        BRDF=brdf,
        **(_look_up_words(material) if material.directional is None else _directional_words(material)),
    )


def _look_up_words(material: Material) -> dict[str, str]:
    return {
        "SIGMA": _glsl(resolved_sigma(material)),
        "R_MAX": _glsl(_r_max(material)),
        "EXPONENT_RANGE": _glsl(_exponent_range(material)),
    }


def _directional_words(material: Material) -> dict[str, str]:
    directional = material.directional
    assert directional is not None
    largest = effective_cosine(brdf_from_text(material.brdf)).largest
    return {
        "PLANES": str(len(directional.planes)),
        "GAIN": _glsl(1.0 if material.sigma is None else material.sigma * largest / directional.r_max),
        "LOWEST": _glsl(directional.lowest),
        "SEARCH": _source("effective_light.glsl"),
    }


def viewer(material: Material, loss: str = "") -> str:
    """The page that shows `material` on a plane and a sphere under a light that can be dragged.

    Of shading maps it shows the power law: tiles that keep their slices are shown by it too, with the error that it
    has, and the page says so. Of directional maps it shows the planes. UsageError for a material with neither.
    It states the error of a fitted BRDF, and what else is known of the `loss`.
    """
    brdf = brdf_from_text(material.brdf)
    sources = ["frame", "shading_map"]
    if material.directional is not None:
        shown, sources = _planes_data(material.directional), [*sources, "directional", "effective_light"]
    elif material.power_law is not None:
        shown = _power_law_data(material.power_law)
    else:
        raise UsageError("the page shows the compressed pair or planes, which this material does not have")
    written: set[str] = set()
    data = {
        "name": material.name,
        "brdf": model_name(brdf),
        "models": [_model(name, brdf) for name in MODELS],
        "sigma": material.sigma,
        "elevation_deg": _thinned(material.elevation_deg, 64),
        "fit": " ".join(filter(None, (fit_statement(material), loss))),
        **shown,
        "sources": {name: _source(f"{name}.glsl", written) for name in sources},
    }
    text = json.dumps(data, ensure_ascii=True, allow_nan=False).replace("<", "\\u003c")
    return _filled((RESOURCES / "viewer" / "index.html").read_text(encoding="utf-8"), DATA=text)


def _power_law_data(power_law: PowerLawMap) -> dict[str, Any]:
    height, width = power_law.scale.shape[:2]
    return {
        "r_max": power_law.r_max,
        "rms": power_law.health.figures.get("rms_without_kept_tiles", power_law.rms),
        "kept_percent": 0.0 if power_law.kept is None else 100.0 * float((power_law.kept.place >= 0).mean()),
        "size": [width, height],
        "maps": {"scale": _coded(power_law.scale), "exponent": _coded(power_law.exponent)},
    }


def _planes_data(directional: DirectionalMap) -> dict[str, Any]:
    """Planes by three as pictures, and their weights, (1 + 3 L, TILTS, TURNS, 3), as rows below each other."""
    from engine.images.encode import encode_png

    layers = [np.rint(_reduced(layer)).astype(np.uint8) for layer in planes_by_three(directional)]
    weights = np.zeros((1 + 3 * len(layers), *directional.table.shape[:3]))
    weights[: directional.table.shape[3]] = np.moveaxis(directional.table, 3, 0)
    low = weights.min(axis=(1, 2, 3))
    step = np.maximum(weights.max(axis=(1, 2, 3)) - low, np.finfo(np.float32).tiny) / 65535.0
    codes = np.rint((weights - low[:, None, None, None]) / step[:, None, None, None]).astype(np.uint16)
    (rows, columns), (height, width) = codes.shape[1:3], directional.planes.shape[1:]
    return {
        "r_max": directional.r_max,
        "size": [width, height],
        "planes": {
            "count": len(directional.planes),
            "lowest": directional.lowest,
            "leave_one_out": directional.leave_one_out,
            "size": [layers[0].shape[1], layers[0].shape[0]],
            "layers": [base64.b64encode(encode_png(layer, transfer="linear")).decode() for layer in layers],
        },
        "weights": {
            "size": [columns, rows],
            "lowest": low.tolist(),
            "step": step.tolist(),
            **_two_bytes(codes.reshape(-1, columns, 3)),
        },
    }


def is_same_text(found: bytes, made: str) -> bool:
    """True where a text of a bundle is the one that was `made` here, but for the last digits of numbers.

    Pictures within it may be packed otherwise, as another version of zlib does, and must hold the same pixels.
    """
    try:
        text = found.decode("utf-8")
    except UnicodeDecodeError:
        return False
    if text == made:
        return True
    parts, own = _PICTURE.split(text), _PICTURE.split(made)
    if len(parts) != len(own) or not all(map(_is_same_but_for_digits, parts[::2], own[::2])):
        return False
    return all(map(_is_same_picture, parts[1::2], own[1::2]))


def _is_same_but_for_digits(found: str, made: str) -> bool:
    parts, own = _NUMBER.split(found), _NUMBER.split(made)
    if len(parts) != len(own) or parts[::2] != own[::2]:
        return False
    return all(
        one == other or math.isclose(float(one), float(other), rel_tol=_LAST_DIGITS)
        for one, other in zip(parts[1::2], own[1::2], strict=True)
    )


def _is_same_picture(found: str, made: str) -> bool:
    if found == made:
        return True
    try:
        pixels = [
            decode_content("engine.images.decode:decode", "picture of the page", base64.b64decode(each))["pixels"]
            for each in (found, made)
        ]
    except (InputError, ValueError):
        return False
    return np.array_equal(*pixels)


def resolved_sigma(material: Material) -> float:
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


def _thinned(values: tuple[float, ...], most: int) -> list[float]:
    """At most `most` of `values`, evenly chosen, with the first and the last: uniforms are few."""
    chosen = np.linspace(0, len(values) - 1, min(len(values), most)).round().astype(int)
    return [float(values[index]) for index in chosen]


def _model(name: str, current: Brdf) -> dict[str, Any]:
    """A model for the page: its declared parameters (with the current values where it is the current one), its GLSL."""
    instance = current if name == model_name(current) else MODELS[name]()
    declared = [_parameter(parameter, getattr(instance, parameter.name)) for parameter in parameters(instance)]
    return {"name": name, "parameters": declared, "glsl": _brdf_source(name)}


def _parameter(parameter: Parameter, value: Any) -> dict[str, Any]:
    low, high = parameter.slider
    return {
        "name": parameter.name,
        "label": parameter.label,
        "doc": parameter.doc,
        "unit": parameter.unit,
        "low": low,
        "high": high,
        "log": parameter.log,
        "value": value,
    }


def _brdf_source(name: str) -> str:
    return _source(f"brdf/{name}.glsl")


def _source(name: str, written: set[str] | None = None) -> str:
    """A shader file with its includes written out, each once; those in `written` stand before it, and are added to."""
    written = set() if written is None else written
    written.add(name)
    text = (RESOURCES / "shaders" / name).read_text(encoding="utf-8")

    def included(include: re.Match[str]) -> str:
        return "" if include[1] in written else _source(include[1], written)

    return _INCLUDE.sub(included, text)


def _coded(values: NDArray[np.float32]) -> dict[str, Any]:
    """A map in 16 bits for the page: value = largest (256 high + low) / 65535."""
    small = _reduced(values)
    release(values)
    largest = float(small.max())
    codes = np.rint(small / (largest or 1.0) * 65535.0).astype(np.uint16)
    return {"largest": largest, "size": [small.shape[1], small.shape[0]], **_two_bytes(codes)}


def _two_bytes(codes: NDArray[np.uint16]) -> dict[str, str]:
    """The high and the low bytes of `codes` (H, W, 3) as two PNG pictures."""
    from engine.images.encode import encode_png

    planes = {"high": (codes >> 8).astype(np.uint8), "low": (codes & 255).astype(np.uint8)}
    return {name: base64.b64encode(encode_png(plane)).decode() for name, plane in planes.items()}


def _reduced(values: NDArray[np.float32]) -> NDArray[np.float64]:
    """The map averaged down to at most VIEWER_SIDE texels on its longer side."""
    height, width = values.shape[:2]
    share = VIEWER_SIDE / max(height, width)
    if share >= 1.0:
        return values.astype(np.float64)
    import cv2

    size = (max(1, round(width * share)), max(1, round(height * share)))
    return np.asarray(cv2.resize(values, size, interpolation=cv2.INTER_AREA), np.float64).reshape(size[1], size[0], 3)


def _glsl(value: Any) -> str:
    if isinstance(value, tuple):
        return f"vec3({', '.join(_glsl(number) for number in value)})"
    digits = f"{min(float(value), float(np.finfo(np.float32).max)):.9g}"
    return digits if "." in digits or "e" in digits else f"{digits}.0"


def fit_statement(material: Material) -> str:
    """A sentence that states the error of the model in place of a measured BRDF; empty where nothing was measured."""
    error = fitted_error(material)
    if error is None or material.measured is None:
        return ""
    measured = f"the measured BRDF {material.measured.name!r}"
    return f"The BRDF is a fit of {measured}, with a relative RMSE of f cos(theta_i) of {percent(error, 3)}."


def _comment(text: str, most: int = 100) -> str:
    """`text` as part of one comment line: printable ASCII without the backslash that would continue the line."""
    return re.sub(r"[^ -\[\]-~]", "?", text)[:most]


def _filled(template: str, **values: str) -> str:
    """`template` with each @NAME@ replaced once and nothing replaced within what was put in."""
    return re.sub("@(" + "|".join(values) + ")@", lambda found: values[found[1]], template)

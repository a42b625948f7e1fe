"""The BRDF of a material in the formats of researchers, and the model nearest to it as MaterialX.

| file | form | from |
|---|---|---|
| `NAME.csv` | theta_i, phi_i, theta_o, phi_o in degrees, R, G, B | values at the pairs of `engine.brdf.fit.fit_data` |
| `NAME_alta.dat` | ALTA text, CARTESIAN, INV_STERADIAN | the same pairs |
| `NAME.binary` | MERL | a table at the centres of its bins, or the measured table itself |
| `NAME.bsdf` | RGL's tensor_file | values over theta_i and the half vector, without adaptive warps |
| `NAME.mtlx` | MaterialX 1.39, a glTF PBR surface | the nearest `metallic-roughness`, with its error |
| | or an OpenPBR surface | the model `openpbr` itself |
| `loss.txt` | text | the error of each, for which CSV and MERL have no place |

Values are in 1/sr without the cosine, linear sRGB. RGL's form (Dupuy2018) stores f cos theta_o over the unit square of
half vectors, (√(2 theta_h / π), phi_h / 2π), warped by a density of them. With uniform densities the square is not
warped, and without the flag `jacobian` the value is not a multiple: a plain bilinear table, which readers of RGL open.
An error is stated for each form that is not exact. The MERL table bounds the time, some 5 s.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

import engine
from engine.brdf.brdf import Brdf, brdf_to_text
from engine.brdf.fit import FitData, fit, fit_data
from engine.brdf.models.microfacet import MetallicRoughness
from engine.brdf.models.openpbr import OpenPbr
from engine.brdf.readers.merl import SHAPE, encode_merl
from engine.brdf.readers.rgl import rgl_of
from engine.brdf.readers.tensor_file import MAGIC
from engine.brdf.resample import resample
from engine.brdf.table import HalfDifferenceTable
from engine.core.directions import normalize, surface_direction
from engine.core.figure_text import percent
from engine.core.steps import Step, Steps, part
from engine.exchange.layers import gltf_values, openpbr_inputs
from engine.exchange.loss import Shown, brdf_loss
from engine.exchange.subject import Contents, Settings, Subject

Floats = NDArray[np.float64]

#: Relative error of a file whose numbers were rounded, at most.
ROUNDING = 1e-9

#: Nodes of the RGL table along theta_i, and along both the half vector's angle and its azimuth.
INCIDENT, HALVES = 24, 64

#: The steepest incident direction of the table, just above the horizon.
_GRAZING = np.radians(89.0)

_FLOAT32, _BYTE = 10, 1


def show(_subject: Subject, _settings: Settings) -> Shown | None:
    """None: a BRDF alone shows no texels."""
    return None


def contents(subject: Subject, _settings: Settings, _loss: str) -> Steps[Contents]:
    """The files; `record` holds their errors."""
    brdf, name = subject.material.reflectance, subject.name
    yield Step(0.0, "evaluating the BRDF")
    data = fit_data(brdf)
    files = {f"{name}.csv": csv(data), f"{name}_alta.dat": alta(data)}
    table: HalfDifferenceTable | Any = brdf
    if not (isinstance(brdf, HalfDifferenceTable) and brdf.missing.shape == SHAPE):
        table = yield from part(resample(brdf, SHAPE), 0.05, 0.5)
    files[f"{name}.binary"] = encode_merl(table)
    errors = {f"{name}.binary": _error(table, data)}
    warnings = []
    if brdf.isotropic:
        yield Step(0.5, "writing RGL's table")
        tensor, errors[f"{name}.bsdf"] = rgl(brdf, data)
        files[f"{name}.bsdf"] = tensor
    else:
        warnings.append("the BRDF is anisotropic: MERL's table is its average over azimuth, and no .bsdf is written")
    nearest: Brdf = brdf
    if isinstance(brdf, OpenPbr):
        files[f"{name}.mtlx"] = openpbr_document(name, brdf)
        errors[f"{name}.mtlx"] = 0.0
        if brdf.anisotropies[2]:
            nearest = replace(brdf, rotation_deg=0.0)  # type: ignore[call-arg]
            errors[f"{name}.mtlx"] = _error(nearest, data)
            away = f"{percent(errors[f'{name}.mtlx'], 3)} away (relative RMSE of f cos)"
            warnings.append(f"{name}.mtlx leaves out the rotation of the anisotropy, {away}")
    else:
        own = brdf if isinstance(brdf, MetallicRoughness) else MetallicRoughness()
        start = MetallicRoughness(
            coat_weight=own.coat_weight,
            coat_roughness=own.coat_roughness,
            sheen_color=own.sheen_color,
            sheen_roughness=own.sheen_roughness,
        )
        found = yield from part(fit(data, start), 0.55, 0.95)
        nearest, error = found.brdf, found.after.rmse_rel
        files[f"{name}.mtlx"] = materialx(name, found.brdf, error)
        errors[f"{name}.mtlx"] = error
        away = f"{percent(error, 3)} away (relative RMSE of f cos)"
        warnings.append(f"{name}.mtlx is the nearest metallic-roughness, {away}")
    files["loss.txt"] = _find_stated(subject.material.brdf, data, files, errors)
    measured = yield from part(brdf_loss(nearest, brdf), 0.95, 1.0)
    record = {
        "brdf": subject.material.brdf,
        "fitted": subject.material.brdf if nearest is brdf else brdf_to_text(nearest),
        "rmse_rel_by_file": {**dict.fromkeys((f"{name}.csv", f"{name}_alta.dat"), 0.0), **errors},
        **measured.figures,
        "errors_are": f"rmse_rel_reference and flip: a ball of the BRDF alone under {', '.join(measured.flip)}, as "
        f"{name}.mtlx shows it; rmse_rel_by_file: f cos at pairs of directions, of which lists hold the very values; "
        "rmse_rel: null, as a BRDF alone has no texels to compare with photographs",
    }
    return Contents(files, None, tuple(warnings), record)


def csv(data: FitData) -> bytes:
    """A table with a header, one pair of directions a line."""
    rows = np.column_stack([_degrees(data.wi), _degrees(data.wo), data.value])
    lines = [",".join(f"{number:.9g}" for number in row) for row in rows]
    return "\n".join(["theta_i,phi_i,theta_o,phi_o,r,g,b", *lines, ""]).encode()


def alta(data: FitData) -> bytes:
    """ALTA's text: the view first, then the light, as unit vectors."""
    rows = np.column_stack([data.wo, data.wi, data.value])
    lines = [" ".join(f"{number:.9g}" for number in row) for row in rows]
    head = ["#DIM 6 3", "#PARAM_IN CARTESIAN", "#PARAM_OUT RGB_COLOR", "#VS 0", f"# {_collect_pairs(data)}"]
    return "\n".join([*head, *lines, ""]).encode()


def _collect_pairs(data: FitData) -> str:
    pairs = len(data.value)
    return f"Made by Lightarc {engine.__version__}. Values at {pairs} pairs of directions, exact there to nine digits."


def _find_stated(brdf: str, data: FitData, files: Mapping[str, bytes], errors: Mapping[str, float]) -> bytes:
    """The error of each file, one a line; lists hold nothing between their pairs of directions."""
    lines = [f"{brdf} alone: the texels of the material are not in these files."]
    for name in files:
        if name in errors:
            exact = errors[name] < ROUNDING
            error = f"a relative RMSE of f cos of {percent(errors[name], 3)}"
            lines.append(f"{name}: {'exact to the rounding of its numbers' if exact else error}.")
        else:
            lines.append(f"{name}: {_collect_pairs(data)} What lies between them is the reader's.")
    return "\n".join([*lines, ""]).encode()


def rgl(brdf: Brdf, data: FitData) -> tuple[bytes, float]:
    """A tensor_file that readers of RGL measurements open, and the error of its table at the pairs of `data`.

    Its description states the error.
    """
    theta_i = _GRAZING * (1.0 - np.linspace(1.0, 0.0, INCIDENT) ** 2)  # denser where Fresnel rises
    theta_h = 0.5 * np.pi * np.linspace(0.0, 1.0, HALVES) ** 2
    phi_h = np.linspace(0.0, 2.0 * np.pi, HALVES) - np.pi
    wi = surface_direction(theta_i, np.zeros(INCIDENT))[:, None, None]
    half = surface_direction(theta_h[:, None], phi_h[None])[None]
    wo = normalize(2.0 * np.sum(wi * half, axis=3, keepdims=True) * half - wi)
    f = brdf.f(np.broadcast_to(wi, wo.shape).reshape(-1, 3), wo.reshape(-1, 3)).reshape(*wo.shape) * wo[..., 2:]
    flat = np.ones((2, 2), np.float32)
    uniform = np.ones((1, INCIDENT, HALVES, HALVES), np.float32)
    fields: dict[str, NDArray[Any]] = {
        "phi_i": np.zeros(1, np.float32),
        "theta_i": theta_i.astype(np.float32),
        "ndf": flat,
        "sigma": flat,
        "vndf": uniform,
        "luminance": uniform,
        "rgb": np.maximum(f, 0.0).transpose(0, 3, 2, 1)[None].astype(np.float32),
        "jacobian": np.zeros(1, np.uint8),
    }
    error = _error(rgl_of(fields, "the table"), data)
    words = f"Lightarc {engine.__version__}. A table with a relative RMSE of f cos of {percent(error, 3)}."
    return tensor_file({"description": np.frombuffer(words.encode(), np.uint8), **fields}), error


def tensor_file(fields: Mapping[str, NDArray[Any]]) -> bytes:
    """The container of RGL, version 1.0 (`engine.brdf.readers.tensor_file`)."""
    names = [name.encode() for name in fields]
    start = 18 + sum(2 + len(name) + 11 + 8 * array.ndim for name, array in zip(names, fields.values(), strict=True))
    head, body = MAGIC + struct.pack("<BBI", 1, 0, len(fields)), b""
    for name, array in zip(names, fields.values(), strict=True):
        body += bytes(-(start + len(body)) % 8)
        kind = _FLOAT32 if array.dtype == np.float32 else _BYTE
        layout = struct.pack("<HBQ", array.ndim, kind, start + len(body))
        head += struct.pack("<H", len(name)) + name + layout + struct.pack(f"<{array.ndim}Q", *array.shape)
        body += np.ascontiguousarray(array).tobytes()
    return head + body


def materialx(name: str, fitted: MetallicRoughness, error: float) -> bytes:
    """A document with one glTF PBR surface of constant inputs."""
    colour = ", ".join(f"{channel:.6g}" for channel in fitted.base_color)
    words = f"Made by Lightarc {engine.__version__}. A fit with a relative RMSE of f cos of {percent(error, 3)}."
    inputs = [
        ("base_color", "color3", colour),
        ("metallic", "float", f"{fitted.metallic:.6g}"),
        ("roughness", "float", f"{fitted.roughness:.6g}"),
        *((name, "float", f"{value:.6g}") for name, value in gltf_values(fitted, fitted.roughness).items()),
    ]
    return _document(name, "gltf_pbr", words, inputs)


def openpbr_document(name: str, brdf: OpenPbr) -> bytes:
    """A document with one OpenPBR surface of constant inputs, the model itself but for the angle of its anisotropy."""
    words = f"Made by Lightarc {engine.__version__}."
    return _document(name, "open_pbr_surface", words, openpbr_inputs(brdf, ("rotation_deg",)))


def _document(name: str, surface: str, words: str, inputs: Iterable[tuple[str, str, str]]) -> bytes:
    lines = [
        '<?xml version="1.0"?>',
        f'<materialx version="1.39" colorspace="lin_rec709" doc={quoteattr(words)}>',
        f'  <{surface} name="shader" type="surfaceshader">',
        *(f'    <input name="{each}" type="{kind}" value="{value}" />' for each, kind, value in inputs),
        f"  </{surface}>",
        f'  <surfacematerial name="{name}" type="material">',
        '    <input name="surfaceshader" type="surfaceshader" nodename="shader" />',
        "  </surfacematerial>",
        "</materialx>",
        "",
    ]
    return "\n".join(lines).encode()


def _error(brdf: Brdf, data: FitData) -> float:
    """Relative RMSE of f cos theta_i at the pairs of `data`."""
    cosine = data.wi[:, 2:]
    apart = float(np.sum(((brdf.f(data.wi, data.wo) - data.value) * cosine) ** 2))
    whole = float(np.sum((data.value * cosine) ** 2))
    return float(np.sqrt(apart / whole)) if whole > 0.0 else 0.0


def _degrees(direction: Floats) -> Floats:
    """(N, 2) angles from the normal and about it."""
    x, y, z = direction.T
    return np.degrees(np.column_stack([np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)]))

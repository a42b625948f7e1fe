"""Layers of OpenPBR from what other surfaces put over their base: extensions of glTF, Standard Surface, USD.

A layer is one for the whole material; of a texture of it the reader takes the factor, which it says. Where another
standard has another lobe, the nearest is taken and named: Standard Surface's sheen is drawn as fuzz. glTF's sheen and
clear coat are drawn as glTF has them, over the model of its own base; beside other layers they are OpenPBR's fuzz and
coat, which neither darkens nor roughens what it covers. Light that is transmitted is lost, and what is scattered below
the surface leaves where it came, as from a diffuse surface of that colour: a BRDF has no other place.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import Any

from engine.brdf.models.microfacet import MetallicRoughness
from engine.brdf.models.openpbr import OpenPbr, OpenPbrAnisotropic
from engine.core.params import Parameter, parameters

#: The number of an input, or its colour, by name with the value where nothing is given.
Number = Callable[[str, float], float]
Colour = Callable[[str, Sequence[float]], Sequence[float]]

#: Weights without which a material has no layers.
WEIGHTS = ("coat_weight", "fuzz_weight", "thin_film_weight", "specular_roughness_anisotropy", "base_diffuse_roughness")

#: Colours of highlights that count as white.
WHITE = 1.0 - 1e-3

_TURNED = tuple(each.name for each in fields(OpenPbrAnisotropic) if each.name not in {f.name for f in fields(OpenPbr)})


def layers_of(values: dict[str, Any]) -> OpenPbr:
    """OpenPBR with the values of layers, brought into their ranges."""
    declared = {each.name: each for each in parameters(OpenPbrAnisotropic)}
    inside = {name: _inside(declared[name], value) for name, value in values.items()}
    if any(inside.get(name, 0.0) for name in _TURNED if name.endswith("anisotropy")):
        return OpenPbrAnisotropic(**{"specular_roughness_anisotropy": 0.0, **inside})
    return OpenPbr(**{name: value for name, value in inside.items() if name not in _TURNED})


def has_layers(values: dict[str, Any]) -> bool:
    """True if a layer is seen, or highlights of dielectrics have a colour, grey among them."""
    colour = values.get("specular_color", (1.0, 1.0, 1.0))
    return any(values.get(name, 0.0) for name in WEIGHTS) or min(colour) < WHITE


def openpbr_values(number: Number, colour: Colour) -> dict[str, Any]:
    """All layers of an `open_pbr_surface`, whose inputs have the names of the model's parameters."""
    values: dict[str, Any] = {}
    for each in parameters(OpenPbrAnisotropic):
        if each.name in ("base_color", "base_metalness", "specular_roughness", "specular_ior", "rotation_deg"):
            continue
        usual = 0.0 if each.name.endswith("anisotropy") else each.default
        values[each.name] = tuple(colour(each.name, usual)) if each.is_colour else number(each.name, usual)  # type: ignore[arg-type]
    return values


def standard_values(number: Number, colour: Colour) -> tuple[dict[str, Any], float, list[str]]:
    """Layers of a `standard_surface`, the factor on its roughness, and what is another lobe."""
    anisotropy = 0.9 * number("specular_anisotropy", 0.0)
    film = number("thin_film_thickness", 0.0)
    values = {
        "base_diffuse_roughness": number("diffuse_roughness", 0.0),
        "specular_color": colour("specular_color", (1.0, 1.0, 1.0)),
        "specular_roughness_anisotropy": anisotropy,
        "rotation_deg": 360.0 * number("specular_rotation", 0.0),
        "coat_weight": number("coat", 0.0),
        "coat_color": colour("coat_color", (1.0, 1.0, 1.0)),
        "coat_roughness": number("coat_roughness", 0.1),
        "coat_ior": number("coat_IOR", 1.5),
        "coat_darkening": 0.0,
        "fuzz_weight": number("sheen", 0.0),
        "fuzz_color": colour("sheen_color", (1.0, 1.0, 1.0)),
        "fuzz_roughness": number("sheen_roughness", 0.3),
        "thin_film_weight": float(film > 0.0),
        "thin_film_thickness": 1e-3 * film,
        "thin_film_ior": number("thin_film_IOR", 1.5),
    }
    # Standard Surface: αx = r²/√(1 − 0.9 a), αy = r² √(1 − 0.9 a)
    across = 1.0 - min(max(anisotropy, 0.0), 0.9)
    notes = ["sheen is drawn as OpenPBR's fuzz"] if values["fuzz_weight"] else []
    return values, ((1.0 + across * across) / (2.0 * across)) ** 0.25, notes


def gltf_layers(given: dict[str, Any], roughness: float) -> tuple[OpenPbr | MetallicRoughness | None, float, list[str]]:
    """Layers of glTF, None for none, the factor on the roughness, and what is another lobe; see `gltf_values`."""
    values, factor, notes = gltf_values(given, roughness)
    if has_layers({**values, "coat_weight": 0.0, "fuzz_weight": 0.0}):
        return layers_of(values), factor, notes
    own = {name: values[name] for name in ("coat_weight", "coat_roughness") if values["coat_weight"]}
    if values["fuzz_weight"]:
        own |= {"sheen_color": given["sheen_color"], "sheen_roughness": values["fuzz_roughness"]}
    if not own:
        return None, 1.0, []
    declared = {each.name: each for each in parameters(MetallicRoughness)}
    return MetallicRoughness(**{name: _inside(declared[name], value) for name, value in own.items()}), 1.0, []


def make_fuzz(colour: Sequence[float], roughness: float) -> dict[str, Any]:
    """Parameters of the fuzz of OpenPBR that stands for sheen of this colour, of the weight 0 for black."""
    weight = max(colour)
    tint = tuple(channel / weight for channel in colour) if weight else (1.0, 1.0, 1.0)
    return {"fuzz_weight": weight, "fuzz_color": tint, "fuzz_roughness": roughness}


def gltf_values(given: dict[str, Any], roughness: float) -> tuple[dict[str, Any], float, list[str]]:
    """Layers of OpenPBR for those of glTF, the factor on the roughness, and what is another lobe.

    `given` has clearcoat, clearcoat_roughness, sheen_color, sheen_roughness, iridescence, iridescence_ior,
    iridescence_thickness in nm, anisotropy_strength and anisotropy_rotation in radians, as far as they are there.
    `roughness` is that at which αx = α + (1 − α) strength², αy = α become OpenPBR's two widths.
    """
    sheen = tuple(given.get("sheen_color", (0.0, 0.0, 0.0)))
    strength = given.get("anisotropy_strength", 0.0)
    values = {
        "coat_weight": given.get("clearcoat", 0.0),
        "coat_roughness": given.get("clearcoat_roughness", 0.0),
        "coat_ior": 1.5,
        "coat_darkening": 0.0,
        **make_fuzz(sheen, given.get("sheen_roughness", 0.0)),
        "thin_film_weight": given.get("iridescence", 0.0),
        "thin_film_thickness": 1e-3 * given.get("iridescence_thickness", 100.0),
        "thin_film_ior": given.get("iridescence_ior", 1.3),
        "specular_color": tuple(given.get("specular_color", (1.0, 1.0, 1.0))),
    }
    factor = 1.0
    if strength:
        alpha = max(roughness, 0.02) ** 2
        along = alpha + (1.0 - alpha) * strength * strength
        across = alpha / along
        values["specular_roughness_anisotropy"] = 1.0 - across
        values["rotation_deg"] = math.degrees(given.get("anisotropy_rotation", 0.0))
        factor = (along / alpha * math.sqrt((1.0 + across * across) / 2.0)) ** 0.5
    notes = ["clear coat is drawn as OpenPBR's coat"]
    notes = notes if values["coat_weight"] else []
    return values, factor, [*notes, *(["sheen is drawn as OpenPBR's fuzz"] if values["fuzz_weight"] else [])]


def _inside(of: Parameter, value: Any) -> Any:
    if of.is_colour:
        return tuple(min(max(float(channel), of.low), of.high) for channel in value)
    return min(max(float(value), of.low), of.high)

"""Layers of OpenPBR in the words of MaterialX and of glTF's extensions.

MaterialX's `open_pbr_surface` has them all. glTF has a coat without a colour, sheen in place of fuzz, a film, a colour
of highlights and an anisotropy whose strength s gives αx = α + (1 − α) s², αy = α: at the mean roughness that is what
OpenPBR has, elsewhere nearly. What has no place is named.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from engine.brdf.models.microfacet import MetallicRoughness
from engine.brdf.models.openpbr import OpenPbr, base_width, two_widths
from engine.core.params import parameters
from engine.exchange.readers.layers import make_fuzz

#: Parameters of the model that maps hold, or that are no input of the surface.
_OF_MAPS = ("base_color", "base_metalness", "specular_roughness", "specular_ior", "rotation_deg")

#: Colours that count as white.
WHITE = 1.0 - 1e-3

#: What maps may have over their base.
Layers = OpenPbr | MetallicRoughness


def openpbr_inputs(layers: Layers, omitted: tuple[str, ...] = _OF_MAPS) -> Iterator[tuple[str, str, str]]:
    """Name, type and value of the inputs of `open_pbr_surface` that are not at their default.

    A clear coat of glTF is the nearest coat of OpenPBR, and sheen fuzz.
    """
    if isinstance(layers, MetallicRoughness):
        of_coat: dict[str, Any] = {"coat_weight": layers.coat_weight, "coat_roughness": layers.coat_roughness}
        if layers.coat_weight:
            of_coat |= {"coat_ior": 1.5, "coat_darkening": 0.0}
        layers = OpenPbr(**of_coat, **make_fuzz(layers.sheen_color, layers.sheen_roughness))
    for each in parameters(layers):
        value = getattr(layers, each.name)
        usual = 0.0 if each.name.endswith("anisotropy") else each.default
        if each.name in omitted or value == usual:
            continue
        if each.is_colour:
            yield each.name, "color3", ", ".join(f"{channel:.6g}" for channel in value)
        else:
            yield each.name, "float", f"{value:.6g}"


def gltf_values(layers: Layers, roughness: float) -> dict[str, Any]:
    """Values of glTF's layers by the names that `engine.exchange.readers.layers.gltf_layers` reads, without zeros."""
    found: dict[str, Any] = {}
    if layers.coat_weight:
        found |= {"clearcoat": layers.coat_weight, "clearcoat_roughness": layers.coat_roughness}
    if isinstance(layers, MetallicRoughness):
        if any(layers.sheen_color):
            found |= {"sheen_color": layers.sheen_color, "sheen_roughness": layers.sheen_roughness}
        return found
    if layers.fuzz_weight:
        found["sheen_color"] = tuple(layers.fuzz_weight * channel for channel in layers.fuzz_color)
        found["sheen_roughness"] = layers.fuzz_roughness
    if layers.thin_film_weight:
        found |= {"iridescence": layers.thin_film_weight, "iridescence_ior": layers.thin_film_ior}
        found["iridescence_thickness"] = 1e3 * layers.thin_film_thickness
    if min(layers.specular_color) < WHITE:
        found["specular_color"] = layers.specular_color
    anisotropy, _, rotation_deg = layers.anisotropies
    if anisotropy:
        along, across = two_widths(base_width(roughness, layers), anisotropy)
        found["anisotropy_strength"] = math.sqrt(max(float(along - across) / max(1.0 - float(across), 1e-9), 0.0))
        found["anisotropy_rotation"] = math.radians(rotation_deg)
    return found


def gltf_roughness_factor(layers: Layers | None, roughness: float) -> float:
    """The factor on the roughness that glTF's anisotropy wants: its α is the width across."""
    if not isinstance(layers, OpenPbr) or not layers.anisotropies[0]:
        return 1.0
    width = base_width(roughness, layers)
    return float(two_widths(width, layers.anisotropies[0])[1] / width) ** 0.5


def gltf_extensions(layers: Layers | None, roughness: float) -> dict[str, Any]:
    """`extensions` of a glTF material for layers over a base of this mean roughness."""
    if layers is None:
        return {}
    values, found = gltf_values(layers, roughness), dict[str, Any]()
    if "clearcoat" in values:
        found["KHR_materials_clearcoat"] = {
            "clearcoatFactor": values["clearcoat"],
            "clearcoatRoughnessFactor": values["clearcoat_roughness"],
        }
    if "sheen_color" in values:
        found["KHR_materials_sheen"] = {
            "sheenColorFactor": list(values["sheen_color"]),
            "sheenRoughnessFactor": values["sheen_roughness"],
        }
    if "iridescence" in values:
        thickness = values["iridescence_thickness"]
        found["KHR_materials_iridescence"] = {
            "iridescenceFactor": values["iridescence"],
            "iridescenceIor": values["iridescence_ior"],
            "iridescenceThicknessMinimum": thickness,
            "iridescenceThicknessMaximum": thickness,
        }
    if "anisotropy_strength" in values:
        found["KHR_materials_anisotropy"] = {
            "anisotropyStrength": values["anisotropy_strength"],
            "anisotropyRotation": values["anisotropy_rotation"],
        }
    if "specular_color" in values:
        found["KHR_materials_specular"] = {"specularColorFactor": list(values["specular_color"])}
    return found


def name_layers(layers: Layers | None) -> list[str]:
    """Return words for the layers that are seen."""
    if layers is None:
        return []
    if isinstance(layers, MetallicRoughness):
        own = {"clear coat": layers.coat_weight > 0.0, "sheen": any(layers.sheen_color)}
        return [words for words, is_seen in own.items() if is_seen]
    said = {
        "clear coat": layers.coat_weight > 0.0,
        "fuzz": layers.fuzz_weight > 0.0,
        "thin film": layers.thin_film_weight > 0.0,
        "anisotropy": any(layers.anisotropies[:2]),
        "colour of highlights": min(layers.specular_color) < WHITE,
        "diffuse roughness": layers.base_diffuse_roughness > 0.0,
    }
    return [words for words, is_seen in said.items() if is_seen]


def openpbr_warnings(layers: Layers | None) -> tuple[str, ...]:
    """Sentences on clear coat and sheen of glTF, which OpenPBR shows otherwise; none where there are none."""
    if not isinstance(layers, MetallicRoughness):
        return ()
    coat = "the clear coat of glTF is written as OpenPBR's coat, which is another lobe"
    sheen = "the sheen of glTF is written as OpenPBR's fuzz, which is another lobe"
    return (*((coat,) if layers.coat_weight else ()), *((sheen,) if any(layers.sheen_color) else ()))


def gltf_warnings(layers: Layers | None) -> tuple[str, ...]:
    """Sentences on what glTF's extensions have no place for, or show otherwise."""
    if not isinstance(layers, OpenPbr):
        return ()
    said = []
    if layers.fuzz_weight:
        said.append("fuzz is written as sheen, which is another lobe")
    if layers.coat_weight and (min(layers.coat_color) < WHITE or abs(layers.coat_ior - 1.5) > 1e-3):
        said.append("the coat has no colour here, and the index 1.5")
    if layers.coat_weight:
        said.append("the coat is written as a clear coat, which is another lobe")
    if layers.base_diffuse_roughness or layers.base_weight < WHITE or layers.specular_weight < WHITE:
        said.append("diffuse roughness and weights of the base are not written")
    return tuple(said)


def none_warnings(layers: Layers | None) -> tuple[str, ...]:
    """A sentence on layers that a target has no place for; none where there are none."""
    seen = name_layers(layers)
    return (f"layers are not written: {', '.join(seen)}",) if seen else ()

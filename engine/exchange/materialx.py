"""MaterialX 1.39: one document with the material as an OpenPBR surface and as a glTF PBR surface, textures beside it.

Both read the same nodes: base colour as `srgb_texture`, or where colours are kept beyond Rec.709 as OpenEXR in
`acescg`, the one space of the standard that holds those of Rec.2020; roughness, metallic and normals as raw data.
OpenPBR's diffuse lobe at roughness 0 is Lambert's, and its dielectric of `specular_ior` reflects f0 at normal incidence
by Fresnel's equations where glTF takes Schlick's, so that the two differ at grazing angles. The document is written as
text: it is some fifty lines, and the library of MaterialX, some 35 MB, would be needed for nothing else.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from xml.sax.saxutils import quoteattr

import numpy as np

import engine
from engine.core.colour import ACESCG, LUMINANCE
from engine.core.steps import Step, Steps
from engine.exchange.coding import encode_base_colour, encode_large
from engine.exchange.layers import gltf_values, gltf_warnings, openpbr_inputs, openpbr_warnings
from engine.exchange.subject import Contents, Files, Settings, Subject
from engine.exchange.textures import common_warnings, ior_of, mean_f0_warnings, pack
from engine.storage.atomic import Pieces
from engine.surface.pbr_maps import PbrMaps

#: Node name, type, source, and the colour space of its file.
_MAPS = (
    ("base_color", "color3", "base_colour", "srgb_texture"),
    ("roughness", "float", "roughness", ""),
    ("metallic", "float", "metallic", ""),
    ("normal_texture", "vector3", "normal", ""),
    ("occlusion", "float", "occlusion", ""),
)


def contents(subject: Subject, settings: Settings, loss: str) -> Steps[Contents]:
    """`NAME.mtlx` and the folder `textures`."""
    left_out = {"occlusion": subject.maps.occlusion is None, "normal": not subject.has_normals}
    known = [entry for entry in _MAPS if not left_out.get(entry[2])]
    yield Step(0.0, "writing the document")
    if subject.maps.wide is not None:
        known = [(*entry[:3], "acescg" if entry[2] == "base_colour" else entry[3]) for entry in known]
    files = {
        _file(subject, node, space): partial(texture_file, subject, source, space, loss)
        for node, _, source, space in known
    }
    warnings = (*common_warnings(subject, ("occlusion",), holds_wide=True), *mean_f0_warnings(subject, "the document"))
    if subject.maps.occlusion is not None:
        warnings = (*warnings, "the OpenPBR surface has no ambient occlusion; the glTF PBR surface has it")
    nodes = [(node, kind, space) for node, kind, _, space in known]
    warnings = (*warnings, *(f"the glTF PBR surface: {words}" for words in gltf_warnings(subject.maps.layers)))
    warnings = (*warnings, *(f"the OpenPBR surface: {words}" for words in openpbr_warnings(subject.maps.layers)))
    if subject.maps.openpbr is not None and subject.maps.openpbr.anisotropies[2]:
        warnings = (*warnings, "the OpenPBR surface: the rotation of the anisotropy is not written")
    made = f"Made by Lightarc {engine.__version__}. {loss}"
    hexagonal = settings.tiling_mode == "hex"
    if hexagonal:
        text = "hexagonal cells of MaterialX are blended by brightness, not by their histogram as Lightarc draws them"
        warnings = (*warnings, text)
    stated = "".join(f" {name}={quoteattr(text)}" for name, text in settings.credits.entries.items())
    lines = _document(subject, nodes, ior_of(subject.mean_f0), f"doc={quoteattr(made)}{stated}", hexagonal)
    document = {f"{subject.name}.mtlx": "\n".join([*lines, ""]).encode()}
    return Contents(Files({**document, **files}), 8.0, warnings)


def texture_file(subject: Subject, source: str, space: str, loss: str) -> bytes | Pieces:
    """A map of the subject as a PNG of 8 bits, in ACEScg as OpenEXR."""
    if space == "acescg":
        return encode_base_colour(subject.maps, ACESCG, loss)
    return encode_large(pack(subject, (source,), "png8"), loss)


def _file(subject: Subject, node: str, space: str) -> str:
    return f"textures/{subject.name}_{node.removesuffix('_texture')}.{'exr' if space == 'acescg' else 'png'}"


def _document(
    subject: Subject, maps: list[tuple[str, str, str]], ior: float, about: str, hexagonal: bool
) -> Iterator[str]:
    """Lines of the document, with attributes `about` it."""
    yield '<?xml version="1.0"?>'
    yield f'<materialx version="1.39" colorspace="lin_rec709" {about}>'
    yield '  <nodegraph name="maps">'
    for node, kind, space in maps:
        coding = f' colorspace="{space}"' if space else ""
        file = f'      <input name="file" type="filename" value="{_file(subject, node, space)}"{coding} />'
        yield from _write_hexagons(node, kind, space, file) if hexagonal else _write_grid(node, kind, file)
    names = [node.removesuffix("_texture") for node, _, _ in maps]
    kinds = {"base_color": "color3", "normal": "vector3"}
    for node in names:
        yield f'    <output name="{node}_out" type="{kinds.get(node, "float")}" nodename="{node}" />'
    yield "  </nodegraph>"
    open_pbr = {"base_color": "base_color", "metallic": "base_metalness", "roughness": "specular_roughness"}
    if "normal" in names:
        open_pbr["normal"] = "geometry_normal"
    surfaces = [
        _surface(subject, "open_pbr_surface", open_pbr, "specular_ior", ior),
        _surface(subject, "gltf_pbr", {node: node for node in names}, "ior", ior),
    ]
    # the first is what the layers are of, which readers take
    for lines in surfaces if subject.maps.of_gltf is None else reversed(surfaces):
        yield from lines
    yield "</materialx>"


def _write_grid(node: str, kind: str, file: str) -> Iterator[str]:
    """The nodes of a map that repeats in a grid; `file` is their input of that name."""
    yield from (f'    <tiledimage name="{node}" type="{kind}">', file, "    </tiledimage>")
    if node == "normal_texture":
        yield '    <normalmap name="normal" type="vector3">'
        yield '      <input name="in" type="vector3" nodename="normal_texture" />'
        yield "    </normalmap>"


def _write_hexagons(node: str, kind: str, space: str, file: str) -> Iterator[str]:
    """The nodes of a map in hexagonal cells (MaterialX 1.39), which are shifted as Lightarc shifts them, and neither
    turned nor scaled."""
    still = [f'      <input name="{name}" type="float" value="0" />' for name in ("rotation", "scale")]
    if node == "normal_texture":
        yield from ('    <hextilednormalmap name="normal" type="vector3">', file, *still, "    </hextilednormalmap>")
        return
    # brightness is weighed in the space in which the values arrive
    weights = luma_weights(space)
    named = node if kind == "color3" else f"{node}_texture"
    yield from (f'    <hextiledimage name="{named}" type="color3">', file, *still)
    yield f'      <input name="lumacoeffs" type="color3" value="{weights}" />'
    yield "    </hextiledimage>"
    if kind != "color3":
        yield f'    <extract name="{node}" type="float">'
        yield f'      <input name="in" type="color3" nodename="{named}" />'
        yield '      <input name="index" type="integer" value="0" />'
        yield "    </extract>"


def luma_weights(space: str) -> str:
    """Shares of red, green and blue in the brightness of linear Rec.709, and of the channels of data."""
    shares = tuple(map(float, LUMINANCE)) if space else (1.0 / 3.0,) * 3
    return ", ".join(f"{share:.6f}" for share in shares)


def _layer_inputs(maps: PbrMaps, node: str) -> Iterator[tuple[str, str, str]]:
    """Inputs of a surface for the layers of the maps."""
    if maps.layers is None:
        return
    if node == "open_pbr_surface":
        yield from openpbr_inputs(maps.layers)
        return
    for name, value in gltf_values(maps.layers, float(maps.roughness.mean(dtype=np.float64))).items():
        is_colour = isinstance(value, tuple)
        text = ", ".join(f"{channel:.6g}" for channel in value) if is_colour else f"{value:.6g}"
        yield name, "color3" if is_colour else "float", text


def _surface(subject: Subject, node: str, inputs: dict[str, str], ior_name: str, ior: float) -> Iterator[str]:
    """A surface of the node definition `node`, whose inputs are named by outputs of the graph, and its material."""
    kinds = {"base_color": "color3", "normal": "vector3"}
    yield f'  <{node} name="{node}_shader" type="surfaceshader">'
    for output, name in inputs.items():
        kind = kinds.get(output, "float")
        yield f'    <input name="{name}" type="{kind}" nodegraph="maps" output="{output}_out" />'
    yield f'    <input name="{ior_name}" type="float" value="{ior:.6g}" />'
    for name, kind, value in _layer_inputs(subject.maps, node):
        yield f'    <input name="{name}" type="{kind}" value="{value}" />'
    yield f"  </{node}>"
    yield f'  <surfacematerial name="{subject.name}_{node}" type="material">'
    yield f'    <input name="surfaceshader" type="surfaceshader" nodename="{node}_shader" />'
    yield "  </surfacematerial>"

"""USD: a ball with the material as one `.usdz`, for viewers, Quick Look and pipelines.

The material is a UsdPreviewSurface. A layer beside the package, `NAME_materialx.usda`, adds the same maps as nodes of
MaterialX (`outputs:mtlx:surface`, an OpenPBR surface) for renderers that know them: within the package, the validators
of a USD without MaterialX would refuse nodes that are not in its registry. The package is a layer of text and a zip of
stored members that begin at multiples of 64 bytes, as the specification of usdz wants; both are short, so the library
of USD, some 100 MB, is a witness in the tests and not needed here. Compression of PNG bounds the time.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

import engine
from engine.core.directions import normalize
from engine.core.steps import Step, Steps
from engine.exchange.coding import encode
from engine.exchange.gltf import REPEATS, ball_radius_m
from engine.exchange.layers import Layers, name_layers, openpbr_inputs, openpbr_warnings
from engine.exchange.subject import Contents, Settings, Subject
from engine.exchange.textures import common_warnings, ior_of, mean_f0_warnings, pack
from engine.geometry.shapes import shape
from engine.scene.credits import Credits

#: Multiple of bytes at which members of a usdz begin.
ALIGNMENT = 64

#: Map, its file, the type of its value, the output of a texture that it takes, and its colour space.
_MAPS = (
    ("base_colour", "baseColor", "color3f", "rgb", "sRGB"),
    ("roughness", "roughness", "float", "r", "raw"),
    ("metallic", "metallic", "float", "r", "raw"),
    ("normal", "normal", "normal3f", "rgb", "raw"),
    ("occlusion", "occlusion", "float", "r", "raw"),
)

#: Inputs of the OpenPBR surface, and the MaterialX type of each map.
_OPEN_PBR = {
    "baseColor": ("base_color", "color3"),
    "roughness": ("specular_roughness", "float"),
    "metallic": ("base_metalness", "float"),
    "normal": ("geometry_normal", "vector3"),
}
_MATERIALX_VALUES = {"color3": "color3f", "float": "float", "vector3": "float3"}


def contents(subject: Subject, settings: Settings, loss: str) -> Steps[Contents]:
    """`NAME.usdz`."""
    left_out = {"occlusion": subject.maps.occlusion is None, "normal": not subject.has_normals}
    known = [entry for entry in _MAPS if not left_out.get(entry[0])]
    images: dict[str, bytes] = {}
    for number, (source, file, *_) in enumerate(known):
        yield Step(number / len(known), f"writing {file}")
        images[f"textures/{file}.png"] = encode(pack(subject, (source,), "png8"), loss)
    mean = subject.mean_f0
    warnings = (*common_warnings(subject, ("occlusion",)), *mean_f0_warnings(subject, "the layer"))
    others = [words for words in name_layers(subject.maps.layers) if words != "clear coat"]
    if others:
        warnings = (*warnings, f"UsdPreviewSurface has no {', '.join(others)}; the layer of MaterialX has")
    warnings = (*warnings, *(f"the layer of MaterialX: {words}" for words in openpbr_warnings(subject.maps.layers)))
    yield Step(0.9, "writing the preview sphere")
    maps, stated = [entry[1:] for entry in known], [*_credit_lines(settings.credits)]
    layer = "\n".join([*_layer(subject, maps, ior_of(mean), loss, settings.width_mm, stated), ""])
    over = "\n".join([*_materialx_layer(subject, [entry[1] for entry in known], ior_of(mean), stated), ""])
    files = {
        f"{subject.name}.usdz": usdz({f"{subject.name}.usda": layer.encode(), **images}),
        f"{subject.name}_materialx.usda": over.encode(),
    }
    return Contents(files, 8.0, warnings)


def usdz(members: Mapping[str, bytes]) -> bytes:
    """A zip of stored members, the first of which is the layer, each at a multiple of 64 bytes."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as packed_file:
        for name, content in members.items():
            entry = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
            header_bytes = 30 + len(name.encode()) + 4  # an extra field begins with its kind and length
            entry.extra = b"\x86\x19" + _padding(file.tell() + header_bytes)
            packed_file.writestr(entry, content)
    return file.getvalue()


def _padding(start: int) -> bytes:
    """Length and zeros of the extra field after which a multiple of 64 bytes follows `start`."""
    count = -start % ALIGNMENT
    return count.to_bytes(2, "little") + bytes(count)


def _layer(
    subject: Subject,
    maps: list[tuple[str, str, str, str]],
    ior: float,
    loss: str,
    width_mm: float | None,
    stated: list[str],
) -> Iterator[str]:
    root = subject.name.replace("-", "_")
    yield from (
        *(
            "#usda 1.0",
            "(",
            f'    defaultPrim = "{root}"',
            f"    doc = {_quote(f'Made by Lightarc {engine.__version__}. {loss}')}",
        ),
        *(*stated, "    metersPerUnit = 1", '    upAxis = "Y"', ")", ""),
        *(f'def Xform "{root}" (', '    kind = "component"', ")", "{"),
    )
    if width_mm is not None:  # the sample has its true size on the ball
        radius = f"{ball_radius_m(width_mm, REPEATS):.6g}"
        yield f"    float3 xformOp:scale = ({radius}, {radius}, {radius})"
        yield '    uniform token[] xformOpOrder = ["xformOp:scale"]'
    yield from _sphere(root)
    shown = subject.material.name or subject.name
    yield from ("", '    def Material "material" (', f"        displayName = {_quote(shown)}", "    )", "    {")
    material = f"/{root}/material"
    yield f"        token outputs:surface.connect = <{material}/preview.outputs:surface>"
    yield from _preview(material, maps, ior, subject.maps.layers)
    yield from ("    }", "}")


def _sphere(root: str) -> Iterator[str]:
    mesh = shape("sphere")
    low, high = mesh.positions.min(axis=0), mesh.positions.max(axis=0)
    yield from ('    def Mesh "ball" (', '        prepend apiSchemas = ["MaterialBindingAPI"]', "    )", "    {")
    yield f"        float3[] extent = [{_vector(low)}, {_vector(high)}]"
    yield f"        int[] faceVertexCounts = [{', '.join(['3'] * len(mesh.faces))}]"
    yield f"        int[] faceVertexIndices = [{', '.join(map(str, mesh.faces.ravel().tolist()))}]"
    yield f"        rel material:binding = </{root}/material>"
    yield f"        normal3f[] normals = [{_vectors(normalize(mesh.normals))}] ("
    yield from ('            interpolation = "vertex"', "        )")
    yield f"        point3f[] points = [{_vectors(mesh.positions)}]"
    yield f"        texCoord2f[] primvars:st = [{_vectors(mesh.uv * REPEATS)}] ("
    yield from ('            interpolation = "vertex"', "        )")
    yield from ('        uniform token subdivisionScheme = "none"', "    }")


def _preview(material: str, maps: list[tuple[str, str, str, str]], ior: float, layers: Layers | None) -> Iterator[str]:
    """UsdPreviewSurface with a texture for each map; normals are taken back from [0, 1] by scale and bias."""
    inputs = {"baseColor": "diffuseColor"}
    lines = ['uniform token info:id = "UsdPreviewSurface"']
    for name, kind, output, _ in maps:
        lines.append(f"{kind} inputs:{inputs.get(name, name)}.connect = <{material}/{name}.outputs:{output}>")
    if layers is not None and layers.coat_weight:
        lines.append(f"float inputs:clearcoat = {layers.coat_weight:.6g}")
        lines.append(f"float inputs:clearcoatRoughness = {layers.coat_roughness:.6g}")
    lines += [f"float inputs:ior = {ior:.6g}", "int inputs:useSpecularWorkflow = 0", "token outputs:surface"]
    yield from _shader("preview", lines)
    reader = (
        'uniform token info:id = "UsdPrimvarReader_float2"',
        'string inputs:varname = "st"',
        "float2 outputs:result",
    )
    yield from _shader("st", reader)
    for name, _, output, space in maps:
        lines = [
            'uniform token info:id = "UsdUVTexture"',
            f"asset inputs:file = @textures/{name}.png@",
            f'token inputs:sourceColorSpace = "{space}"',
            f"float2 inputs:st.connect = <{material}/st.outputs:result>",
            'token inputs:wrapS = "repeat"',
            'token inputs:wrapT = "repeat"',
            f"{'float3' if output == 'rgb' else 'float'} outputs:{output}",
        ]
        if name == "normal":
            lines += ["float4 inputs:scale = (2, 2, 2, 1)", "float4 inputs:bias = (-1, -1, -1, 0)"]
        yield from _shader(name, lines)


def _credit_lines(credits: Credits) -> Iterator[str]:
    """Title, author, licence and source as data of the layer."""
    if credits:
        yield "    customLayerData = {"
        yield from (f"        string {name} = {_quote(text)}" for name, text in credits.entries.items())
        yield "    }"


def _materialx_layer(subject: Subject, maps: list[str], ior: float, stated: list[str]) -> Iterator[str]:
    """Opinions over the package: an OpenPBR surface of MaterialX, with an image for each of its inputs."""
    root = subject.name.replace("-", "_")
    material, package = f"/{root}/material", f"{subject.name}.usdz"
    # metadata of a layer does not come through those below it
    yield from ("#usda 1.0", "(", *stated, f'    defaultPrim = "{root}"', "    metersPerUnit = 1", '    upAxis = "Y"')
    yield from ("    subLayers = [", f"        @./{package}@", "    ]")
    yield from (")", "", f'over "{root}"', "{", '    over "material"', "    {")
    yield f"        token outputs:mtlx:surface.connect = <{material}/open_pbr.outputs:out>"
    lines = ['uniform token info:id = "ND_open_pbr_surface_surfaceshader"']
    for name in filter(_OPEN_PBR.__contains__, maps):
        target, kind = _OPEN_PBR[name]
        node = "mtlx_normal" if name == "normal" else f"mtlx_{name}_image"
        lines.append(f"{_MATERIALX_VALUES[kind]} inputs:{target}.connect = <{material}/{node}.outputs:out>")
    if subject.maps.layers is not None:
        for name, kind, value in openpbr_inputs(subject.maps.layers):
            lines.append(f"{_MATERIALX_VALUES[kind]} inputs:{name} = {f'({value})' if kind == 'color3' else value}")
    yield from _shader("open_pbr", [*lines, f"float inputs:specular_ior = {ior:.6g}", "token outputs:out"])
    for name in filter(_OPEN_PBR.__contains__, maps):
        kind = _OPEN_PBR[name][1]
        space = ' (colorSpace = "srgb_texture")' if name == "baseColor" else ""
        lines = [
            f'uniform token info:id = "ND_image_{kind}"',
            f"asset inputs:file = @./{package}[textures/{name}.png]@{space}",
            f"{_MATERIALX_VALUES[kind]} outputs:out",
        ]
        yield from _shader(f"mtlx_{name}_image", lines)
    lines = [
        'uniform token info:id = "ND_normalmap_float"',
        f"float3 inputs:in.connect = <{material}/mtlx_normal_image.outputs:out>",
        "float3 outputs:out",
    ]
    if "normal" in maps:
        yield from _shader("mtlx_normal", lines)
    yield from ("    }", "}")


def _shader(name: str, lines: list[str] | tuple[str, ...]) -> Iterator[str]:
    yield from ("", f'        def Shader "{name}"', "        {")
    yield from (f"            {line}" for line in lines)
    yield "        }"


def _quote(text: str) -> str:
    """A string of USD."""
    escaped = text.replace("\\", r"\\").replace('"', r"\"").replace("\n", r"\n")
    return f'"{escaped}"'


def _vector(values: NDArray[np.floating]) -> str:
    return f"({', '.join(f'{value:.6g}' for value in values.tolist())})"


def _vectors(values: NDArray[np.floating]) -> str:
    return ", ".join(_vector(row) for row in values)

"""glTF 2.0 binary: a ball with the material, its maps within, to look at and to take the material from.

Base colour, normals and the packed occlusion, roughness and metallic are PNG of 8 bits. Where f0 is not 0.04,
KHR_materials_ior states the largest, and where it varies KHR_materials_specular the share of it in a colour texture,
which leaves the reflectance at grazing angles at 1. Tangents are those of the texture coordinates, normalised against
the normals; nothing is compressed but images. Texture coordinates have v down. Compression of PNG bounds the time.
"""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

import engine
from engine.core.colour import srgb_encode
from engine.core.directions import normalize
from engine.core.steps import Step, Steps
from engine.exchange.coding import encode
from engine.exchange.layers import Layers, gltf_extensions, gltf_roughness_factor, gltf_values, gltf_warnings
from engine.exchange.readers.layers import gltf_layers
from engine.exchange.subject import Contents, Settings, Subject
from engine.exchange.textures import common_warnings, ior_of, pack
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import shape
from engine.scene.credits import Credits
from engine.surface.pbr_maps import DIELECTRIC_F0, PbrMaps

#: Repeats of the material over one unit of the ball's texture coordinates, two of which go round it.
REPEATS = 2.0

#: Kinds of numbers and targets, by OpenGL's codes.
_FLOAT, _UNSIGNED_INT, _VERTICES, _INDICES = 5126, 5125, 34962, 34963
_LINEAR, _LINEAR_MIPMAP_LINEAR, _REPEAT = 9729, 9987, 10497

_SHARED = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 1}}}


def contents(subject: Subject, settings: Settings, loss: str) -> Steps[Contents]:
    """`NAME.glb`."""
    yield Step(0.0, "writing images")
    orm = pack(subject, ("occlusion", "roughness", "metallic"), "png8")
    images = {
        "baseColor": encode(pack(subject, ("base_colour",), "png8"), loss),
        "occlusionRoughnessMetallic": encode(orm, loss),
    }
    material: dict[str, Any] = {
        "name": subject.material.name or subject.name,
        **_SHARED,
        "extras": {"lightarc_loss": loss},
    }
    if subject.maps.occlusion is not None:
        material["occlusionTexture"] = {"index": 1}
    if subject.has_normals:
        material["normalTexture"] = {"index": len(images)}
        images["normal"] = encode(pack(subject, ("normal",), "png8"), loss)
    mean = float(subject.maps.roughness.mean(dtype=np.float64))
    extensions = gltf_extensions(subject.maps.layers, mean)
    for name, entries in _extensions(subject, images).items():
        extensions[name] = {**extensions.get(name, {}), **entries}
    if extensions:
        material["extensions"] = extensions
    factor = gltf_roughness_factor(subject.maps.layers, mean)
    if factor != 1.0:
        material["pbrMetallicRoughness"] = {**_SHARED["pbrMetallicRoughness"], "roughnessFactor": factor}
    yield Step(0.7, "writing the preview sphere")
    file = glb(shape("sphere"), material, images, REPEATS, loss, settings.width_mm, settings.credits)
    warnings = (*common_warnings(subject, ("occlusion",)), *gltf_warnings(subject.maps.layers))
    return Contents({f"{subject.name}.glb": file}, 9.0, warnings)


def read_back(maps: PbrMaps) -> Layers | None:
    """The layers of the maps as readers of glTF get them back, at the mean roughness."""
    if maps.layers is None:
        return None
    mean = float(maps.roughness.mean(dtype=np.float64))
    given = gltf_values(maps.layers, mean)
    return gltf_layers(given, mean * gltf_roughness_factor(maps.layers, mean))[0]


def _extensions(subject: Subject, images: dict[str, bytes]) -> dict[str, Any]:
    """Extensions for an f0 other than that of every importer; an image is added where it varies."""
    f0 = subject.maps.f0
    largest = float(f0.max())
    if np.allclose(f0, DIELECTRIC_F0, atol=1e-3):
        return {}
    extensions: dict[str, Any] = {"KHR_materials_ior": {"ior": ior_of(largest)}}
    if largest > 0.0 and not np.allclose(f0, largest, atol=1e-3):
        share = np.repeat(srgb_encode(f0 / largest)[..., None], 3, axis=2)
        extensions["KHR_materials_specular"] = {"specularColorTexture": {"index": len(images)}}
        images["specularColor"] = encode(np.rint(255.0 * share).astype(np.uint8))
    return extensions


def glb(
    mesh: Mesh,
    material: dict[str, Any],
    images: dict[str, bytes],
    repeats: float,
    loss: str,
    width_mm: float | None = None,
    credits: Credits | None = None,
) -> bytes:
    """The file: a header, a chunk of JSON and one of bytes, both a multiple of four bytes long.

    `width_mm` is that of the sample, which then has its true size on the ball: glTF counts in metres. `credits` are the
    copyright of the asset.
    """
    node: dict[str, Any] = {"mesh": 0, "name": "preview"}
    if width_mm is not None:
        node["scale"] = [ball_radius_m(width_mm, repeats)] * 3
        material = {**material, "extras": {**material.get("extras", {}), "lightarc_width_mm": width_mm}}
    attributes = {
        "POSITION": mesh.positions.astype(np.float32),
        "NORMAL": normalize(mesh.normals).astype(np.float32),
        "TANGENT": _tangents(mesh),
        "TEXCOORD_0": (mesh.uv * (1.0, -1.0) * repeats).astype(np.float32),
    }
    views: list[dict[str, Any]] = []
    accessors: list[dict[str, Any]] = []
    body = b""
    for values in (*attributes.values(), mesh.faces.ravel().astype(np.uint32)):
        is_index = values.ndim == 1
        content = np.ascontiguousarray(values).tobytes()
        views.append(
            {
                "buffer": 0,
                "byteOffset": len(body),
                "byteLength": len(content),
                "target": _INDICES if is_index else _VERTICES,
            }
        )
        accessors.append(_accessor(values, len(views) - 1))
        body += _pad(content, b"\0")
    accessors[0] |= {
        "min": attributes["POSITION"].min(axis=0).tolist(),
        "max": attributes["POSITION"].max(axis=0).tolist(),
    }
    for content in images.values():
        views.append({"buffer": 0, "byteOffset": len(body), "byteLength": len(content)})
        body += _pad(content, b"\0")
    first = len(views) - len(images)
    document: dict[str, Any] = {
        "asset": {
            "version": "2.0",
            "generator": f"Lightarc {engine.__version__}",
            **({"copyright": credits.line} if credits else {}),
            "extras": {**(credits.entries if credits else {}), "lightarc_loss": loss},
        },
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [node],
        "meshes": [
            {
                "primitives": [
                    {
                        "attributes": {name: index for index, name in enumerate(attributes)},
                        "indices": len(attributes),
                        "material": 0,
                    }
                ]
            }
        ],
        "materials": [material],
        "samplers": [
            {"magFilter": _LINEAR, "minFilter": _LINEAR_MIPMAP_LINEAR, "wrapS": _REPEAT, "wrapT": _REPEAT},
        ],
        "textures": [{"sampler": 0, "source": index} for index in range(len(images))],
        "images": [
            {"name": name, "mimeType": "image/png", "bufferView": first + index} for index, name in enumerate(images)
        ],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(body)}],
    }
    if "extensions" in material:
        document["extensionsUsed"] = sorted(material["extensions"])
    text = _pad(json.dumps(document, ensure_ascii=False, allow_nan=False).encode(), b" ")
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(body), b"BIN\0") + body
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def ball_radius_m(width_mm: float, repeats: float) -> float:
    """The radius in metres of a ball on which a sample of this width has its true size along the equator, round which
    two units of texture coordinates go."""
    return 2.0 * repeats * width_mm / 1000.0 / (2.0 * np.pi)


def _accessor(values: NDArray[Any], view: int) -> dict[str, Any]:
    kind = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}[1 if values.ndim == 1 else values.shape[1]]
    number = _UNSIGNED_INT if values.ndim == 1 else _FLOAT
    return {"bufferView": view, "componentType": number, "count": len(values), "type": kind}


def _tangents(mesh: Mesh) -> NDArray[np.float32]:
    """(V, 4): unit tangents along +u, across the normals, and 1, for texture coordinates that are not mirrored."""
    normal = normalize(mesh.normals).astype(np.float64)
    tangent = mesh.tangents - normal * np.sum(mesh.tangents * normal, axis=1, keepdims=True)
    unit = normalize(tangent, (1.0, 0.0, 0.0))
    return np.column_stack([unit, np.ones(len(unit))]).astype(np.float32)


def _pad(content: bytes, filler: bytes) -> bytes:
    return content + filler * (-len(content) % 4)

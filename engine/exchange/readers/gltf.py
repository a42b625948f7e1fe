"""The material of a glTF 2.0 file, `.glb` or `.gltf`: `pbrMetallicRoughness`, normals, occlusion, and an f0.

Base colour is sRGB-coded, roughness is green and metallic blue of one texture, occlusion red (glTF 2.0, Sec. 3.9); y of
normals is up. KHR_materials_ior gives f0 = ((ior − 1) / (ior + 1))², KHR_materials_specular a share of it. Of several
materials the first with a texture is taken. What is not drawn is named. Images may lie within the file, beside it or
below its folder. All this runs in the decoder process (`engine.exchange.readers.documents_child`).
"""

from __future__ import annotations

import base64
import binascii
import struct
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from engine.brdf.brdf import brdf_to_text
from engine.core.errors import InputError
from engine.exchange.readers.layers import gltf_values, has_layers, layers_of
from engine.exchange.readers.textures import Channel, Described, Image, Input
from engine.images.decode import TransferChoice
from engine.storage.text import read_json
from engine.storage.untrusted import AGAIN, FILE_LIMIT_BYTES

#: Most bytes of the text of a file.
JSON_LIMIT_BYTES = 64 << 20

#: Extensions that change what is seen and are not drawn here.
_PASSED_OVER = {
    "KHR_materials_pbrSpecularGlossiness": "specular-glossiness",
}


#: Factors of the extensions that are layers, by the name that `gltf_values` has for them, with their defaults.
_LAYERS: dict[str, dict[str, tuple[str, tuple[float, ...]]]] = {
    "KHR_materials_clearcoat": {
        "clearcoatFactor": ("clearcoat", (0.0,)),
        "clearcoatRoughnessFactor": ("clearcoat_roughness", (0.0,)),
    },
    "KHR_materials_sheen": {
        "sheenColorFactor": ("sheen_color", (0.0, 0.0, 0.0)),
        "sheenRoughnessFactor": ("sheen_roughness", (0.0,)),
    },
    "KHR_materials_iridescence": {
        "iridescenceFactor": ("iridescence", (0.0,)),
        "iridescenceIor": ("iridescence_ior", (1.3,)),
        "iridescenceThicknessMaximum": ("iridescence_thickness", (400.0,)),
    },
    "KHR_materials_anisotropy": {
        "anisotropyStrength": ("anisotropy_strength", (0.0,)),
        "anisotropyRotation": ("anisotropy_rotation", (0.0,)),
    },
    "KHR_materials_specular": {"specularColorFactor": ("specular_color", (1.0, 1.0, 1.0))},
}


def has_textures(content: bytes, path: Path) -> bool:
    """True if the content of a file states a material with a texture; InputError where it is not glTF."""
    tree, _ = _open(content, path)
    return any(_is_textured(each) for each in _list(tree, "materials"))


def gltf_of(content: bytes, path: Path) -> Described:
    """The material of a file's content, as it names other files; InputError where it has none."""
    tree, body = _open(content, path)
    materials = [each for each in _list(tree, "materials") if isinstance(each, dict)]
    if not materials:
        raise InputError(path, "has no material", "Export it with its materials")
    material = next((each for each in materials if _is_textured(each)), materials[0])
    name = str(material.get("name") or path.stem)[:60]
    notes = [f"of {len(materials)} materials, {name!r} is taken"] if len(materials) > 1 else []
    return _Reader(path, tree, body, notes).describe(material, name)


class _Reader:
    """The textures of one file."""

    def __init__(self, path: Path, tree: dict[str, Any], body: bytes, notes: list[str]) -> None:
        self.path, self.tree, self.body, self.notes = path, tree, body, notes

    def describe(self, material: dict[str, Any], name: str) -> Described:
        pbr = _dict(material, "pbrMetallicRoughness")
        base = self._numbers(pbr, "baseColorFactor", (1.0, 1.0, 1.0, 1.0))[:3]
        packed = pbr.get("metallicRoughnessTexture")
        roughness, metallic = (self._numbers(pbr, key, (1.0,)) for key in ("roughnessFactor", "metallicFactor"))
        normal = _dict(material, "normalTexture")
        occlusion = material.get("occlusionTexture")
        self._say_what_is_passed_over(material)
        extensions = _dict(material, "extensions")
        f0 = self._f0(extensions)
        passing = self._numbers(_dict(extensions, "KHR_materials_transmission"), "transmissionFactor", (0.0,))[0]
        if passing > 0.0:
            self.notes.append("light that goes through the surface is lost")
            base = tuple(channel * max(1.0 - passing, 0.0) for channel in base)
        mean = roughness[0] * (0.5 if packed is not None else 1.0)
        layers, widened = self._layers(extensions, mean)
        return Described(
            name,
            base_colour=Input(base, self._image(pbr.get("baseColorTexture"), "auto")),
            roughness=Input((roughness[0] * widened,), self._image(packed, "linear", 1)),
            metallic=Input(metallic, self._image(packed, "linear", 2)),
            f0=f0,
            normal=Input(image=self._image(normal, "linear")) if normal else None,
            occlusion=Input(image=self._image(occlusion, "linear", 0)) if occlusion else None,
            normal_scale=self._numbers(normal, "scale", (1.0,))[0],
            upwards="opengl",
            notes=tuple(self.notes),
            layers=layers,
        )

    def _layers(self, extensions: dict[str, Any], roughness: float) -> tuple[str, float]:
        """The text of the layers over the base, '' for none, and the factor of their anisotropy on the roughness."""
        given: dict[str, Any] = {}
        for extension, entries in _LAYERS.items():
            owner = _dict(extensions, extension)
            for key, (name, usual) in entries.items():
                found = self._numbers(owner, key, usual)
                given[name] = found if len(usual) == 3 else found[0]
            textures = [key for key in owner if key.endswith("Texture") and key != "specularColorTexture"]
            if textures:
                self.notes.append(f"{' and '.join(textures)} is passed over")
        colour = given.pop("specular_color")
        if _is_coloured(colour) and "specularColorTexture" not in _dict(extensions, "KHR_materials_specular"):
            given["specular_color"] = colour  # otherwise it is in f0
        values, widened, notes = gltf_values(given, roughness)
        if not has_layers(values):
            return "", 1.0
        self.notes += notes
        return brdf_to_text(layers_of(values)), widened

    def _f0(self, extensions: dict[str, Any]) -> Input:
        ior = self._numbers(_dict(extensions, "KHR_materials_ior"), "ior", (1.5,))[0]
        specular = _dict(extensions, "KHR_materials_specular")
        strength = self._numbers(specular, "specularFactor", (1.0,))[0]
        colour = self._numbers(specular, "specularColorFactor", (1.0, 1.0, 1.0))
        f0 = ((ior - 1.0) / (ior + 1.0)) ** 2 if ior > 0.0 else 1.0
        coloured = _is_coloured(colour)
        if coloured and "specularColorTexture" in specular:
            self.notes.append("highlights of dielectrics have a colour, which is taken as grey")
        elif coloured:
            return Input((f0 * strength,))  # the colour is that of the layers
        factor = f0 * strength * (0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2])
        return Input((factor,), self._image(specular.get("specularColorTexture"), "auto"))

    def _say_what_is_passed_over(self, material: dict[str, Any]) -> None:
        extensions = _dict(material, "extensions")
        passed = [words for key, words in _PASSED_OVER.items() if key in extensions]
        if any(self._numbers(material, "emissiveFactor", (0.0, 0.0, 0.0))):
            passed.append("emission")
        if material.get("alphaMode", "OPAQUE") != "OPAQUE":
            passed.append("opacity")
        if passed:
            self.notes.append(f"{' and '.join(passed)} is not drawn")

    def _image(self, given: object, transfer: TransferChoice, channel: Channel = None) -> Image | None:
        """The image of a reference to a texture, None without one."""
        if not isinstance(given, dict):
            return None
        if "KHR_texture_transform" in _dict(given, "extensions"):
            self.notes.append("a texture is turned or scaled against the others, which is passed over")
        texture = self._entry("textures", given.get("index"))
        image = self._entry("images", texture.get("source"))
        name = str(image.get("name") or f"image {texture.get('source')}")[:60]
        if "bufferView" in image:
            return self._view(image["bufferView"], Image(self.path, name, transfer, channel))
        uri = image.get("uri")
        if not isinstance(uri, str):
            raise InputError(self.path, "has an image without content", AGAIN)
        if uri.startswith("data:"):
            return Image(self.path, name, transfer, channel, self._data(uri))
        return Image(Path(unquote(uri)), uri[:60], transfer, channel)

    def _entry(self, kind: str, index: object) -> dict[str, Any]:
        entries = _list(self.tree, kind)
        if not (isinstance(index, int) and not isinstance(index, bool) and 0 <= index < len(entries)):
            raise InputError(self.path, f"names one of its {kind} that it does not have", AGAIN)
        entry = entries[index]
        if not isinstance(entry, dict):
            raise InputError(self.path, f"has an entry of {kind} that is none", AGAIN)
        return entry

    def _view(self, index: object, image: Image) -> Image:
        """The image with the bytes of a view, or with their place in the file that they lie in."""
        view = self._entry("bufferViews", index)
        buffer = self._entry("buffers", view.get("buffer"))
        uri = str(buffer["uri"]) if "uri" in buffer else ""
        content = self._data(uri) if uri.startswith("data:") else self.body
        start, length = view.get("byteOffset", 0), view.get("byteLength")
        limit = FILE_LIMIT_BYTES if uri and not uri.startswith("data:") else len(content)
        if not (isinstance(start, int) and isinstance(length, int) and 0 <= start <= start + length <= limit):
            raise InputError(self.path, "names bytes of an image that it does not have", AGAIN)
        if uri and not uri.startswith("data:"):
            return replace(image, path=Path(unquote(uri)), part=(start, length))
        return replace(image, content=content[start : start + length])

    def _data(self, uri: str) -> bytes:
        try:
            return base64.b64decode(uri.partition(",")[2], validate=True)
        except (binascii.Error, ValueError):
            raise InputError(self.path, "has an image within its text that is damaged", AGAIN) from None

    def _numbers(self, owner: dict[str, Any], key: str, usual: tuple[float, ...]) -> tuple[float, ...]:
        value = owner.get(key)
        given = usual if value is None else tuple(value) if isinstance(value, list) else (value,)
        is_number = all(isinstance(each, int | float) and not isinstance(each, bool) for each in given)
        if not is_number or len(given) != len(usual) or not all(abs(each) <= 1e6 for each in given):
            raise InputError(self.path, f"has an impossible {key}", AGAIN)
        return tuple(float(each) for each in given)


def _open(content: bytes, path: Path) -> tuple[dict[str, Any], bytes]:
    """The JSON of a file and its chunk of bytes."""
    if not content.startswith(b"glTF"):
        tree, body = read_json(content, path, "the text", AGAIN), b""
    else:
        if len(content) < 20:
            raise InputError(path, "is an incomplete .glb", AGAIN)
        version, length = struct.unpack_from("<II", content, 4)
        text_bytes, kind = struct.unpack_from("<I4s", content, 12)
        if version != 2 or length > len(content) or kind != b"JSON" or 20 + text_bytes > min(length, JSON_LIMIT_BYTES):
            raise InputError(path, "is an incomplete .glb, or of another version", AGAIN)
        tree = read_json(content[20 : 20 + text_bytes], path, "its first chunk", AGAIN)
        body = _bytes_chunk(content, 20 + text_bytes)
    if not isinstance(tree, dict):
        raise InputError(path, "is not glTF", AGAIN)
    return tree, body


def _bytes_chunk(content: bytes, start: int) -> bytes:
    if start + 8 > len(content):
        return b""
    count, kind = struct.unpack_from("<I4s", content, start)
    return content[start + 8 : start + 8 + count] if kind == b"BIN\0" else b""


def _is_coloured(colour: Sequence[float]) -> bool:
    return max(colour) - min(colour) > 1e-3


def _is_textured(material: object) -> bool:
    if not isinstance(material, dict):
        return False
    pbr = _dict(material, "pbrMetallicRoughness")
    return any(key in pbr for key in ("baseColorTexture", "metallicRoughnessTexture")) or "normalTexture" in material


def _dict(owner: dict[str, Any], key: str) -> dict[str, Any]:
    value = owner.get(key)
    return value if isinstance(value, dict) else {}


def _list(owner: dict[str, Any], key: str) -> list[Any]:
    value = owner.get(key)
    return value if isinstance(value, list) else []

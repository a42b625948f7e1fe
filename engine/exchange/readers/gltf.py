"""The material of a glTF 2.0 file, `.glb` or `.gltf`: `pbrMetallicRoughness`, normals, occlusion, and an f0.

Base colour is sRGB-coded, roughness is green and metallic blue of one texture, occlusion red (glTF 2.0, Sec. 3.9); y of
normals is up. KHR_materials_ior gives f0 = ((ior − 1) / (ior + 1))², KHR_materials_specular a share of it. Materials
are read one at a time, by their names (`engine.geometry.gltf.material_names`). Specular-glossiness becomes metal and
roughness, and a material without light a diffuse one of its colour. What is not drawn is named, every property that is
not read among it, and a file that requires an extension that is not known is refused. Images may lie within the file,
beside it or below its folder. All this runs in the decoder process (`engine.exchange.readers.documents_child`).
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
from engine.exchange.readers.layers import gltf_layers
from engine.exchange.readers.textures import Channel, Described, Image, Input
from engine.geometry.gltf import NO_MATERIAL, TexturePlace, has_materials, material_names, texture_places
from engine.images.decode import TransferChoice
from engine.scene.credits import Credits, clean, credits_of
from engine.storage.text import read_json
from engine.storage.untrusted import AGAIN, FILE_LIMIT_BYTES

#: Most bytes of the text of a file.
JSON_LIMIT_BYTES = 64 << 20

#: Extensions that a file may require: those of materials that are read or named, and those of models.
_KNOWN = frozenset(
    {
        *("KHR_materials_anisotropy", "KHR_materials_clearcoat", "KHR_materials_dispersion"),
        *("KHR_materials_emissive_strength", "KHR_materials_ior", "KHR_materials_iridescence"),
        *("KHR_materials_pbrSpecularGlossiness", "KHR_materials_sheen", "KHR_materials_specular"),
        *("KHR_materials_transmission", "KHR_materials_unlit", "KHR_materials_variants", "KHR_materials_volume"),
        *("KHR_texture_basisu", "KHR_texture_transform", "EXT_texture_webp", "KHR_lights_punctual", "KHR_xmp_json_ld"),
        *("KHR_mesh_quantization", "KHR_draco_mesh_compression", "EXT_meshopt_compression", "EXT_mesh_gpu_instancing"),
    }
)

#: Properties that are read or named elsewhere, of what holds them.
_READ = {
    "material": (
        *("name", "pbrMetallicRoughness", "normalTexture", "occlusionTexture", "emissiveFactor", "emissiveTexture"),
        *("alphaMode", "alphaCutoff", "doubleSided"),
    ),
    "pbrMetallicRoughness": (
        *("baseColorFactor", "baseColorTexture", "metallicFactor", "roughnessFactor", "metallicRoughnessTexture"),
    ),
    "texture": ("index", "texCoord", "scale", "strength"),
    "KHR_materials_pbrSpecularGlossiness": (
        *("diffuseFactor", "diffuseTexture", "specularFactor", "glossinessFactor", "specularGlossinessTexture"),
    ),
    "KHR_materials_ior": ("ior",),
    "KHR_materials_specular": ("specularFactor", "specularTexture", "specularColorFactor", "specularColorTexture"),
    "KHR_materials_transmission": ("transmissionFactor", "transmissionTexture"),
    "KHR_materials_unlit": (),
    # what these say belongs to light that goes through, or is given off, which is named
    "KHR_materials_volume": ("thicknessFactor", "thicknessTexture", "attenuationDistance", "attenuationColor"),
    "KHR_materials_dispersion": ("dispersion",),
    "KHR_materials_emissive_strength": ("emissiveStrength",),
}

#: Formats of images that another extension brings, and what to ask of the program that writes it.
_IMAGES = {"KHR_texture_basisu": "KTX2", "EXT_texture_webp": "WebP"}


#: Textures of layers that count with their mean: the weight of a clear coat, in red, its roughness, in green, the
#: colour of sheen, and its roughness, in alpha.
_MEAN_TEXTURES = ("clearcoatTexture", "clearcoatRoughnessTexture", "sheenColorTexture", "sheenRoughnessTexture")

#: Factors of the extensions that are layers, by the name that `gltf_layers` has for them, with their defaults.
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


def parts_of(content: bytes, path: Path) -> list[str]:
    """Names of the materials that primitives have, in the order of the file; none where they have neither a material
    nor colours of vertices."""
    tree, _ = _open(content, path)
    if not has_materials(tree):
        return []
    names = material_names(tree)
    used = {each.get("material") for mesh in _list(tree, "meshes") for each in mesh["primitives"]}
    return [*(name for at, name in enumerate(names) if at in used), *([NO_MATERIAL] if None in used else [])]


def gltf_of(content: bytes, path: Path, name: str = "") -> Described:
    """A material of a file's content, as it names other files; InputError where it has none.

    That of this `name`, or else of those that the model has the first with a texture, which a sentence says.
    """
    tree, body = _open(content, path)
    named = dict(zip(material_names(tree), _list(tree, "materials"), strict=True))
    named = {key: each for key, each in named.items() if isinstance(each, dict)}
    parts = parts_of(content, path)
    if NO_MATERIAL in parts:
        named[NO_MATERIAL] = {}
    if not named:
        raise InputError(path, "has no material", "Export it with its materials")
    if name and name not in named:
        known = ", ".join(repr(each) for each in list(named)[:5])
        raise InputError(path, f"has no material {name!r}", f"Choose one of {known}")
    candidates = [*parts, *(each for each in named if each not in parts)]
    taken = name or next((each for each in candidates if _is_textured(named[each])), candidates[0])
    material = named[taken]
    elsewhere = []
    if len(named) > 1 and not name:
        elsewhere.append(f"of {len(named)} materials, {taken!r} is taken; {path.name}#NAME chooses another one")
    if _has_vertex_colours(tree, None if taken == NO_MATERIAL else list(material_names(tree)).index(taken)):
        elsewhere.append("colours of vertices are passed over on other models")
    title = taken if taken in (material.get("name"), NO_MATERIAL) or len(named) > 1 else path.stem
    described = _Reader(path, tree, body, []).describe(material, title[:60])
    asset = _dict(tree, "asset")
    stated = credits_of(_dict(asset, "extras")) or Credits(copyright=clean(asset.get("copyright")))
    return replace(described, credits=stated, elsewhere=(*elsewhere, *described.elsewhere))


class _Reader:
    """The textures of one file."""

    def __init__(self, path: Path, tree: dict[str, Any], body: bytes, notes: list[str]) -> None:
        self.path, self.tree, self.body, self.notes = path, tree, body, notes

    def describe(self, material: dict[str, Any], name: str) -> Described:
        """The material, with what of its texture coordinates is not that of its own model alone."""
        places = texture_places(material)
        if len(places) > 1:
            self.notes.append(
                "textures have texture coordinates of their own (texCoord or a transform), of which those "
                "of the first are taken for all"
            )
        described = self._describe(material, name)
        if any(place != TexturePlace() for place in places):
            said = "the texture coordinates that its textures ask for are those of its own model alone"
            return replace(described, elsewhere=(said,))
        return described

    def _describe(self, material: dict[str, Any], name: str) -> Described:
        pbr = _dict(material, "pbrMetallicRoughness")
        base = self._numbers(pbr, "baseColorFactor", (1.0, 1.0, 1.0, 1.0))[:3]
        packed = pbr.get("metallicRoughnessTexture")
        roughness, metallic = (self._numbers(pbr, key, (1.0,)) for key in ("roughnessFactor", "metallicFactor"))
        normal = _dict(material, "normalTexture")
        occlusion = material.get("occlusionTexture")
        self._say_what_is_passed_over(material)
        extensions = _dict(material, "extensions")
        if "KHR_materials_pbrSpecularGlossiness" in extensions:
            return self._describe_glossiness(material, _dict(extensions, "KHR_materials_pbrSpecularGlossiness"), name)
        if "KHR_materials_unlit" in extensions:
            self.notes.append("is to be shown without light; it is drawn as a diffuse surface of its colour")
            colour = Input(base, self._image(pbr.get("baseColorTexture"), "srgb"))
            return Described(name, colour, Input((1.0,)), Input((0.0,)), Input((0.0,)), notes=tuple(self.notes))
        f0 = self._f0(extensions)
        passing = self._numbers(_dict(extensions, "KHR_materials_transmission"), "transmissionFactor", (0.0,))[0]
        if packed is None:
            passing *= 1.0 - min(max(metallic[0], 0.0), 1.0)  # metals let nothing through
        if passing > 0.0:
            self.notes.append("light that goes through the surface is lost")
            if "transmissionTexture" in _dict(extensions, "KHR_materials_transmission"):
                self.notes.append("transmissionTexture is passed over")
            base = tuple(channel * max(1.0 - passing, 0.0) for channel in base)
        mean = roughness[0] * (0.5 if packed is not None else 1.0)
        layers, widened = self._layers(extensions, mean)
        given = {**_dict(extensions, "KHR_materials_clearcoat"), **_dict(extensions, "KHR_materials_sheen")}
        weight, rough, sheen, sheen_rough = (given.get(key) if layers else None for key in _MEAN_TEXTURES)
        return Described(
            name,
            base_colour=Input(base, self._image(pbr.get("baseColorTexture"), "srgb")),
            roughness=Input((roughness[0] * widened,), self._image(packed, "linear", 1)),
            metallic=Input(metallic, self._image(packed, "linear", 2)),
            f0=f0,
            normal=Input(image=self._image(normal, "linear")) if normal else None,
            occlusion=Input(image=self._image(occlusion, "linear", 0)) if occlusion else None,
            normal_scale=self._numbers(normal, "scale", (1.0,))[0],
            upwards="opengl",
            notes=tuple(self.notes),
            layers=layers,
            coat=Input(image=self._image(weight, "linear", 0)) if weight else None,
            coat_roughness=Input(image=self._image(rough, "linear", 1)) if rough else None,
            sheen=Input(image=self._image(sheen, "auto")) if sheen else None,
            sheen_roughness=Input(image=self._image(sheen_rough, "linear", "alpha")) if sheen_rough else None,
        )

    def _describe_glossiness(self, material: dict[str, Any], owner: dict[str, Any], name: str) -> Described:
        """A diffuse colour, a colour of highlights, and 1 − roughness (KHR_materials_pbrSpecularGlossiness)."""
        packed = owner.get("specularGlossinessTexture")
        normal, occlusion = _dict(material, "normalTexture"), material.get("occlusionTexture")
        return Described(
            name,
            base_colour=Input(
                self._numbers(owner, "diffuseFactor", (1.0, 1.0, 1.0, 1.0))[:3],
                self._image(owner.get("diffuseTexture"), "srgb"),
            ),
            specular=Input(self._numbers(owner, "specularFactor", (1.0, 1.0, 1.0)), self._image(packed, "srgb")),
            glossiness=Input(self._numbers(owner, "glossinessFactor", (1.0,)), self._image(packed, "linear", "alpha")),
            normal=Input(image=self._image(normal, "linear")) if normal else None,
            occlusion=Input(image=self._image(occlusion, "linear", 0)) if occlusion else None,
            normal_scale=self._numbers(normal, "scale", (1.0,))[0],
            upwards="opengl",
            notes=tuple(self.notes),
        )

    def _layers(self, extensions: dict[str, Any], roughness: float) -> tuple[str, float]:
        """The text of the layers over the base, '' for none, and the factor of their anisotropy on the roughness."""
        given: dict[str, Any] = {}
        for extension, entries in _LAYERS.items():
            owner = _dict(extensions, extension)
            for key, (name, usual) in entries.items():
                found = self._numbers(owner, key, usual)
                given[name] = found if len(usual) == 3 else found[0]
            drawn = ("specularColorTexture", *_MEAN_TEXTURES)
            textures = [key for key in owner if key.endswith("Texture") and key not in drawn]
            if textures:
                self.notes.append(f"{' and '.join(textures)} is passed over")
        colour = given.pop("specular_color")
        if _is_coloured(colour) and "specularColorTexture" not in _dict(extensions, "KHR_materials_specular"):
            given["specular_color"] = colour  # otherwise it is in f0
        layers, widened, notes = gltf_layers(given, roughness)
        self.notes += notes
        return "" if layers is None else brdf_to_text(layers), widened

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
        return Input((factor,), self._image(specular.get("specularColorTexture"), "srgb"))

    def _say_what_is_passed_over(self, material: dict[str, Any]) -> None:
        extensions = _dict(material, "extensions")
        passed = self._list_unread(material, "material")
        for key, owner in extensions.items():
            read = _READ.get(key)
            if read is None and key not in _LAYERS:
                passed.append(key[:60])
            elif isinstance(owner, dict):
                passed += self._list_unread(owner, key)
        strength = self._numbers(_dict(material, "occlusionTexture"), "strength", (1.0,))[0]
        if strength != 1.0:
            self.notes.append(f"the strength {strength:g} of the occlusion is passed over")
        if any(self._numbers(material, "emissiveFactor", (0.0, 0.0, 0.0))):
            passed.append("emission")
        if material.get("alphaMode", "OPAQUE") != "OPAQUE":
            passed.append("opacity")
        if passed:
            self.notes.append(f"{' and '.join(passed)} is not drawn")

    def _list_unread(self, owner: dict[str, Any], kind: str) -> list[str]:
        """Properties of an object that are neither read nor named otherwise."""
        textures = [key for key in owner if kind in _LAYERS and key.endswith("Texture")]  # named with the layers
        known = {*_READ.get(kind, ()), *_LAYERS.get(kind, ()), *textures, "extensions", "extras"}
        found = [f"{key[:40]} of {kind}" for key in owner if key not in known]
        for key, value in owner.items():
            if kind == "material" and key == "pbrMetallicRoughness" and isinstance(value, dict):
                found += self._list_unread(value, key)
            elif key.endswith("Texture") and isinstance(value, dict):
                found += self._list_unread(value, "texture")
        return found

    def _image(self, given: object, transfer: TransferChoice, channel: Channel = None) -> Image | None:
        """The image of a reference to a texture, None without one.

        What a PNG or JPEG says of its colours is ignored, as glTF 2.0 asks (section 3.8.3).
        """
        if not isinstance(given, dict):
            return None
        texture = self._entry("textures", given.get("index"))
        for extension, format_name in _IMAGES.items():
            if extension in _dict(texture, "extensions") and "source" not in texture:
                raise InputError(
                    self.path, f"has {format_name} images, which are not read", "Export it with PNG or JPEG"
                )
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
    required = [str(each)[:60] for each in _list(tree, "extensionsRequired") if each not in _KNOWN]
    if required:
        raise InputError(path, f"requires the extension {required[0]}, which is not known", "Export it without that")
    return tree, body


def _bytes_chunk(content: bytes, start: int) -> bytes:
    if start + 8 > len(content):
        return b""
    count, kind = struct.unpack_from("<I4s", content, start)
    return content[start + 8 : start + 8 + count] if kind == b"BIN\0" else b""


def _has_vertex_colours(tree: dict[str, Any], material: int | None) -> bool:
    """True if a part of a model that has the material has colours of vertices as well."""
    parts = [each for mesh in _list(tree, "meshes") if isinstance(mesh, dict) for each in _list(mesh, "primitives")]
    mine = [each for each in parts if isinstance(each, dict) and each.get("material") == material]
    return any("COLOR_0" in _dict(each, "attributes") for each in mine)


def _is_coloured(colour: Sequence[float]) -> bool:
    return max(colour) - min(colour) > 1e-3


def _is_textured(material: object) -> bool:
    if not isinstance(material, dict):
        return False
    pbr = {
        **_dict(material, "pbrMetallicRoughness"),
        **_dict(_dict(material, "extensions"), "KHR_materials_pbrSpecularGlossiness"),
    }
    if "diffuseTexture" in pbr or "specularGlossinessTexture" in pbr:
        return True
    return any(key in pbr for key in ("baseColorTexture", "metallicRoughnessTexture")) or "normalTexture" in material


def _dict(owner: dict[str, Any], key: str) -> dict[str, Any]:
    value = owner.get(key)
    return value if isinstance(value, dict) else {}


def _list(owner: dict[str, Any], key: str) -> list[Any]:
    value = owner.get(key)
    return value if isinstance(value, list) else []

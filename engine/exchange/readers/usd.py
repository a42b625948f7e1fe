"""The materials of a USD file: UsdPreviewSurface and surfaces of MaterialX with their networks.

A network becomes elements of a MaterialX document, which `engine.exchange.readers.materialx` reads: a shader is an
element of its node, with what its inputs state or lead to through all graphs. A surface of MaterialX
(`outputs:mtlx:surface`) is taken before a UsdPreviewSurface. Of a UsdUVTexture scale and bias are a factor, an
inversion, or those of a map of normals, by which y points up or down. Images may lie within the package, beside the
file or below its folder. All this runs in the decoder process (`engine.geometry.usd`), which sees copies of the layers.
"""

from __future__ import annotations

import os
import zipfile
from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement

from pxr import Ar, Sdf, UsdShade

from engine.core.errors import InputError
from engine.exchange.readers.documents_child import describe_to_send
from engine.exchange.readers.materialx import AUTO, NODES, SURFACES, describe_surface
from engine.exchange.readers.textures import Described, Input, Upwards
from engine.geometry.gltf import NO_MATERIAL
from engine.geometry.usd_stage import (
    FIRST,
    Coordinates,
    list_coordinates,
    list_materials,
    list_missing,
    list_used,
    name_materials,
    open_stage,
    place_of,
    refuse_damaged,
    value_of,
)
from engine.scene.credits import Credits, credits_of
from engine.storage.untrusted import AGAIN

#: Types of MaterialX by those of USD.
_TYPES = {
    **dict.fromkeys(("color3f", "color3d", "color3h"), "color3"),
    **dict.fromkeys(("color4f", "color4d", "color4h"), "color4"),
    **dict.fromkeys(("float3", "vector3f", "normal3f", "point3f", "double3"), "vector3"),
    **dict.fromkeys(("float2", "texCoord2f", "double2"), "vector2"),
    **dict.fromkeys(("float", "double", "half"), "float"),
    **dict.fromkeys(("token", "string"), "string"),
    **{"float4": "vector4", "int": "integer", "bool": "boolean", "asset": "filename"},
}

#: Most shaders of a material.
_MAX_SHADERS = 2000

#: Ways in which textures repeat that are those of our own, or say nothing.
_REPEATS = ("repeat", "useMetadata", "periodic")

_USUAL = Coordinates()

#: The material of faces that none is bound to.
_WHITE = Described(NO_MATERIAL, Input((1.0, 1.0, 1.0)))


def decode_materials(_content: Any, name: str, copies: str, file: str) -> dict[str, Any]:
    """The decoder: `materials` as `engine.exchange.readers.documents_child` sends them, and `parts`, the names of those
    that faces have, or layers that are `missing`."""
    with refuse_damaged(name, copies):
        return _decode_materials(name, copies, file)


def _decode_materials(name: str, copies: str, file: str) -> dict[str, Any]:
    if missing := list_missing(copies, file, name):
        return {"missing": missing}
    stage = open_stage(copies, file, name)
    names = name_materials(stage, name)
    described = [
        _Network(material, names[key], copies, Path(name)).describe()
        for key, material in list_materials(stage, name).items()
    ]
    parts = list_used(stage, name, names)
    if NO_MATERIAL in parts:
        described.append(_WHITE)
    credits = _read_credits(stage.GetRootLayer().customLayerData)
    described = [replace(each, credits=credits) for each in described]
    members: dict[str, dict[str, tuple[int, int]]] = {}
    return {"materials": [describe_to_send(_find_members(each, copies, members)) for each in described], "parts": parts}


def _read_credits(data: Mapping[str, Any]) -> Credits:
    """Title, author, licence, copyright and source as a layer states them, as our own exports do."""
    return credits_of({"licence": data.get("license"), **data})


class _Network:
    """The shaders of a material as elements of a MaterialX document."""

    def __init__(self, material: Any, label: str, folder: str, path: Path) -> None:
        self.material, self.label, self.folder, self.path = material, label, folder, path
        self.root = Element("materialx")
        self.elements: dict[str, Element] = {}
        self.notes: list[str] = []
        self.upwards: Upwards = "opengl"

    def describe(self) -> Described:
        """The material; white where its surface is not read, which is said."""
        surfaces = [self.material.ComputeSurfaceSource(context)[0] for context in ("mtlx", "")]
        surface = next((each for each in surfaces if each and _tag(each) in SURFACES), None)
        if surface is None:
            known = ", ".join(str(each.GetIdAttr().Get())[:40] for each in surfaces[:1] if each) or "none"
            note = f"the surface of {self.label!r} is not read ({known}), and drawn white"
            return replace(_WHITE, name=self.label, notes=(note,))
        element = self._add(surface)
        places = list_coordinates(self.material)
        if len(places) > 1:
            self.notes.append("textures have texture coordinates of their own, of which those of the first are taken")
        described = describe_surface(element, self.root, self.path)
        moved = any((each.primvar, each.matrix) != (_USUAL.primvar, _USUAL.matrix) for each in places)
        elsewhere = ("the texture coordinates that its textures ask for are those of its own model alone",)
        return replace(
            described,
            name=self.label,
            upwards=self.upwards,
            notes=(*described.notes, *dict.fromkeys(self.notes)),
            elsewhere=elsewhere if moved else (),
        )

    def _add(self, first: Any) -> Element:
        """The element of a shader, with those of all that it reads."""
        waiting = [first]
        while waiting:
            shader = waiting.pop()
            key = str(shader.GetPath())
            if key in self.elements:
                continue
            if len(self.elements) >= _MAX_SHADERS:
                raise InputError(self.path, f"has a material of more than {_MAX_SHADERS} shaders", AGAIN)
            tag = _tag(shader)
            element = self.elements[key] = SubElement(self.root, tag, name=key)
            outputs = shader.GetOutputs()
            kind = _TYPES.get(str(outputs[0].GetTypeName()), "") if outputs else ""
            element.set("type", "color3" if tag == "UsdUVTexture" else kind)
            if tag == "constant" and str(shader.GetIdAttr().Get()).startswith("UsdPrimvarReader"):
                SubElement(element, "input", name="value", type="color3", value="1, 1, 1")
                continue
            for given in shader.GetInputs():
                source = self._input(element, given)
                waiting += [] if source is None else [source]
            if tag == "UsdUVTexture":
                self._say_wrapping(shader)
        return self.elements[str(first.GetPath())]

    def _input(self, owner: Element, given: Any) -> Any:
        """Add an input to an element; the shader that it reads, None for a value."""
        attributes = given.GetValueProducingAttributes()
        if not attributes:
            return None
        attribute = attributes[0]
        name, kind = given.GetBaseName(), _TYPES.get(str(given.GetTypeName()), "")
        element = SubElement(owner, "input", name=name, type=kind)
        if UsdShade.Utils.GetType(attribute.GetName()) == UsdShade.AttributeType.Output:
            shader = UsdShade.Shader(attribute.GetPrim())
            output = UsdShade.Utils.GetBaseNameAndType(attribute.GetName())[0]
            element.set("nodename", str(shader.GetPath()))
            element.set("output", output)
            if _tag(shader) == "UsdUVTexture":
                self._scale(element, shader, output)
            return shader
        value = attribute.Get(FIRST)
        text = self._file(attribute, value) if isinstance(value, Sdf.AssetPath) else _text(value)
        if text is None:
            owner.remove(element)
            return None
        element.set("value", text)
        space = str(attribute.GetColorSpace()) if attribute.HasColorSpace() else ""
        if owner.tag == "UsdUVTexture" and name == "file":
            stated = str(value_of(UsdShade.Shader(given.GetPrim()), "sourceColorSpace") or AUTO)
            space = {"sRGB": "srgb_texture", "raw": "raw"}.get(stated, space or AUTO)
        if space:
            element.set("colorspace", space)
        return None

    def _scale(self, given: Element, texture: Any, output: str) -> None:
        """Put scale and bias of a texture between it and the input that reads it."""
        scale, bias = (_four_of(value_of(texture, name), usual) for name, usual in (("scale", 1.0), ("bias", 0.0)))
        if "ormal" in given.get("name", "") or given.get("type") == "vector3":
            if scale[1] < 0.0 < scale[0]:
                self.upwards = "directx"
            return
        at = {"r": [0], "g": [1], "b": [2], "a": [3]}.get(output, [0, 1, 2])
        factor, shift = [scale[each] for each in at], [bias[each] for each in at]
        if all(each == 1.0 for each in factor) and not any(shift):
            return
        if all(each == -1.0 for each in factor) and all(each == 1.0 for each in shift):
            kind, more = "invert", {}
            inside = "in"
        elif not any(shift):
            kind, more = "multiply", {"name": "in2", "value": ", ".join(map(repr, factor))}
            inside = "in1"
        else:
            self.notes.append(f"scale and bias of the texture of {given.get('name')} are passed over")
            return
        between = SubElement(self.root, kind, name=f"{given.get('name')} of {len(self.root)}")
        SubElement(between, "input", name=inside, nodename=given.get("nodename", ""), output=output)
        if more:
            SubElement(between, "input", more)
        given.set("nodename", between.get("name", ""))
        given.attrib.pop("output")

    def _say_wrapping(self, texture: Any) -> None:
        ways = {str(value_of(texture, name) or "useMetadata") for name in ("wrapS", "wrapT")}
        if others := sorted(ways.difference(_REPEATS)):
            self.notes.append(f"textures repeat, where {' and '.join(others)} is stated")

    def _file(self, attribute: Any, value: Any) -> str | None:
        """The name of a file from the folder of the copies, `PACKAGE[MEMBER]` for one in a package."""
        if not value.path:
            return None
        if value.path.startswith("/") or "://" in value.path:
            return str(value.path)
        layer = attribute.GetPropertyStack(FIRST)[0].layer
        place = place_of(layer, value.path)
        if not Ar.IsPackageRelativePath(place):
            return Path(os.path.relpath(place, self.folder)).as_posix()
        package, inner = Ar.SplitPackageRelativePathOuter(place)
        return str(Ar.JoinPackageRelativePath(Path(os.path.relpath(package, self.folder)).as_posix(), inner))


def _tag(shader: Any) -> str:
    """The node of a shader as MaterialX calls it."""
    stated = str(shader.GetIdAttr().Get() or "")
    if stated.startswith("UsdPrimvarReader_float3"):
        return "constant"
    if not stated.startswith("ND_"):
        return stated if _is_word(stated) else "unknown"
    rest = stated.removeprefix("ND_")
    known = [each for each in NODES if rest == each or rest.startswith(f"{each}_")]
    return max(known, key=len) if known else rest if _is_word(rest) else "unknown"


def _is_word(text: str) -> bool:
    return text.isascii() and text.isidentifier()


def _four_of(value: Any, usual: float) -> list[float]:
    """Four numbers; the `usual` one for each where a value is none or of another type."""
    try:
        found = [float(each) for each in value]
    except (TypeError, ValueError):
        found = []
    return found if len(found) == 4 else [usual] * 4


def _text(value: Any) -> str | None:
    """A value as MaterialX writes it; None for none."""
    if value is None:
        return None
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str | int | float):
        return str(value)
    try:
        return ", ".join(repr(float(each)) for each in value)
    except TypeError:
        return None


def _find_members(described: Described, folder: str, members: dict[str, dict[str, tuple[int, int]]]) -> Described:
    """The material with the places of its images within the files of packages."""
    changed: dict[str, Any] = {}
    for each in fields(described):
        given = getattr(described, each.name)
        if isinstance(given, Input) and given.image and Ar.IsPackageRelativePath(str(given.image.path)):
            package, inner = Ar.SplitPackageRelativePathOuter(str(given.image.path))
            if package not in members:
                members[package] = _list_members(Path(folder, package))
            if inner not in members[package]:
                raise InputError(package, f"has no image {inner[:60]!r}", AGAIN)
            image = replace(given.image, path=Path(package), name=inner, part=members[package][inner])
            changed[each.name] = replace(given, image=image)
    return replace(described, **changed)


def _list_members(package: Path) -> dict[str, tuple[int, int]]:
    """The first byte and the length of each stored member of a package."""
    found = {}
    try:
        with zipfile.ZipFile(package) as archive, package.open("rb") as file:
            for entry in archive.infolist():
                file.seek(entry.header_offset)
                header = file.read(30)
                if entry.compress_type == zipfile.ZIP_STORED and len(header) == 30:
                    start = entry.header_offset + 30 + int.from_bytes(header[26:28], "little")
                    found[entry.filename] = start + int.from_bytes(header[28:30], "little"), entry.file_size
    except (zipfile.BadZipFile, NotImplementedError, OSError, ValueError):
        raise InputError(package, "is a damaged package", AGAIN) from None
    return found

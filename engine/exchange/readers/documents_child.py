"""MaterialX and glTF documents, and libraries of OBJ materials, read in a decoder process (`engine.storage.untrusted`).

The decoder gets the content of a document alone, and answers what the document says, with the images that lie within
it. What it calls files is looked for here, in the folder of the document and below, and decoded later as any image.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from engine.core.errors import InputError
from engine.exchange.readers.gltf import JSON_LIMIT_BYTES, gltf_of, parts_of
from engine.exchange.readers.materialx import materialx_of
from engine.exchange.readers.mtl import has_colours_of_obj, mtl_of, scan_obj
from engine.exchange.readers.textures import Described, Image, Input
from engine.geometry.gltf import NO_MATERIAL
from engine.geometry.ply import HEADER_BYTES, has_colours
from engine.geometry.usd import ask_usd, is_usd
from engine.scene.credits import credits_of
from engine.storage.beside import file_beside, tiles_beside
from engine.storage.untrusted import FILE_LIMIT_BYTES, decode_in_child, open_checked, read_head

Kind = Literal["materialx", "gltf", "mtl", "usd"]

_TEXT_LIMIT_BYTES = 4 << 20

#: An element that includes another document, and the most of them.
_INCLUDE, _MAX_INCLUDED = re.compile(rb'<xi:include[^<>]{1,200}?href="([^"<>]{1,300}+)"'), 32

_REMEDIES = {
    "materialx": "Copy the textures next to the document, or name their folder with --search",
    "mtl": "Copy the textures next to it, or name their folder with --search",
    "gltf": "Export it as .glb, or name the folder of its images with --search",
    "usd": "Copy the textures next to it, name their folder with --search, or export it as .usdz",
}

#: The decoder of USD.
_USD = "engine.exchange.readers.usd:decode_materials"

#: The decoder processes that serve documents: that of the images, which is there next, and that of the model.
_IMAGES, _MODEL = "engine.images.decode", "engine.geometry.mesh"


def describe_document(path: Path, kind: Kind, material: str = "", search: Path | None = None) -> Described:
    """The material of a document, of a glTF file the one of that name; InputError where it has none, is damaged, or
    names a file that is not there.

    Its images lie beside it, or in the folder `search`.
    """
    decoder = "engine.exchange.readers.documents_child:decode_document"
    more: dict[str, Any] = {"material": material} if material else {}
    if kind == "materialx" and (included := _list_included(path, search)):
        more["beside"] = included
    reply = decode_in_child(decoder, path, limit_bytes=_limit_bytes(path, kind), process=_IMAGES, kind=kind, **more)
    return _build(path, kind, reply, search)


def _build(path: Path, kind: Kind, sent: dict[str, Any], search: Path | None) -> Described:
    """The material that a decoder described (`describe_to_send`), with its files looked up."""
    values: dict[str, Any] = {
        each.name: _input(path, kind, value, sent, search) if each.name in sent["inputs"] else value
        for each in fields(Described)
        if (value := sent["described"].get(each.name)) is not None
    }
    credits = credits_of(values["credits"])
    sentences = {each: tuple(values[each]) for each in ("notes", "elsewhere")}
    return Described(**{**values, **sentences, "credits": credits})


def describe_usd(path: Path, names: Sequence[str], search: Path | None = None) -> list[Described]:
    """The materials of a USD file by their `names`, '' for the one that stands for all: of those that the model has
    the first with an image; InputError for names that it has not."""
    reply = ask_usd(_USD, path, search)
    sent = {str(each["described"]["name"]): each for each in reply["materials"]}
    if not sent:
        raise InputError(path, "has no material", "Export it with its materials")
    order = [*reply["parts"], *(each for each in sent if each not in reply["parts"])]
    taken = next((each for each in order if any(_has_image(sent[each], key) for key in sent[each]["inputs"])), order[0])
    if unknown := [each for each in names if each and each not in sent]:
        known = ", ".join(repr(each) for each in order[:5])
        raise InputError(path, f"has no material {unknown[0]!r}", f"Choose one of {known}")
    found = [_build(path, "usd", sent[each or taken], search) for each in names]
    words = f"of {len(sent)} materials, {taken!r} is taken; {path.name}#NAME chooses another one"
    return [
        replace(each, elsewhere=(words, *each.elsewhere)) if not name and len(sent) > 1 else each
        for name, each in zip(names, found, strict=True)
    ]


def _has_image(sent: dict[str, Any], key: str) -> bool:
    return sent["described"][key]["image"] is not None


def _list_included(path: Path, search: Path | None) -> dict[str, Path]:
    """The documents that one includes, by the names that it gives them."""
    named = _INCLUDE.findall(read_head(path, _TEXT_LIMIT_BYTES)[0])[:_MAX_INCLUDED]
    texts = [name.decode("utf-8", "replace") for name in named]
    return {name: file_beside(path, name, _REMEDIES["materialx"], search) for name in texts}


def list_parts(path: Path) -> list[str]:
    """Names of the materials that the model of a file has on its parts; none for what cannot be read."""
    try:
        if is_usd(path):
            return [str(name) for name in ask_usd(_USD, path)["parts"]]
        return [str(name) for name in _scan(path)["parts"]]
    except InputError:
        return []


def list_libraries(path: Path) -> list[str]:
    """The libraries of materials that an OBJ file names."""
    return [str(name) for name in _scan(path)["libraries"]]


def library_beside(path: Path, named: str, search: Path | None = None) -> Path:
    """The library that an OBJ file calls `named`, beside it or in `search`; InputError where it is not there."""
    remedy = "Copy that as well, or name its folder with --search"
    return file_beside(path, named.replace("\\", "/"), remedy, search)


def _scan(path: Path) -> dict[str, Any]:
    decoder = "engine.exchange.readers.documents_child:decode_parts"
    limit_bytes = FILE_LIMIT_BYTES if path.suffix.lower() in (".obj", ".ply") else _limit_bytes(path, "gltf")
    return decode_in_child(decoder, path, limit_bytes=limit_bytes, process=_MODEL)


def is_obj(path: Path) -> bool:
    """True for an OBJ file, by its ending: it has no mark."""
    return path.suffix.lower() == ".obj"


def describe_coloured(path: Path) -> Described:
    """The white material of a model that states colours of vertices and no material."""
    said = ("colours of vertices are passed over on other models",)
    return Described(path.stem[:60], Input((1.0, 1.0, 1.0)), elsewhere=said)


def decode_parts(content: bytes, name: str) -> dict[str, list[str]]:
    """The decoder: `parts`, names of the materials of a model, and `libraries`, the files with those of an OBJ."""
    if is_obj(Path(name)):
        libraries, parts = scan_obj(content)
        parts = parts or ([NO_MATERIAL] if has_colours_of_obj(content) else [])
        return {"parts": parts, "libraries": libraries}
    if content.startswith(b"ply"):
        return {"parts": [NO_MATERIAL] if has_colours(content[:HEADER_BYTES]) else [], "libraries": []}
    return {"parts": parts_of(content, Path(name)), "libraries": []}


def decode_document(
    content: bytes, name: str, kind: Kind, material: str = "", beside: Mapping[str, bytes] = MappingProxyType({})
) -> dict[str, Any]:
    """The decoder: `described`, the fields of a `Described` by name; `inputs`, those that are an `Input`; and images.

    Each of these names the array with its content, or the file that it is, or lies in at `part`. `beside` are documents
    that a MaterialX document includes.
    """
    path = Path(name)
    if kind == "materialx":
        described = materialx_of(content, path, beside)
    else:
        described = (gltf_of if kind == "gltf" else mtl_of)(content, path, material)
    return describe_to_send(described)


def describe_to_send(described: Described) -> dict[str, Any]:
    """A material as JSON values and arrays, as `decode_document` returns it."""
    values = {each.name: getattr(described, each.name) for each in fields(Described)}
    inputs = [each for each, value in values.items() if isinstance(value, Input)]
    images = {each: values[each].image.content for each in inputs if values[each].image is not None}
    arrays = {f"image {each}": np.frombuffer(held, np.uint8) for each, held in images.items() if held is not None}
    for each in inputs:
        one = values[each]
        image = None if one.image is None else _describe(one.image)
        values[each] = {"factor": one.factor, "inverted": one.inverted, "image": image, "name": each}
    return {"described": {**values, "credits": described.credits.entries}, "inputs": inputs, **arrays}


def _describe(image: Image) -> dict[str, Any]:
    file = None if image.content is not None else str(image.path)
    return {
        "file": file,
        "part": image.part,
        "name": image.name,
        "transfer": image.transfer,
        "channel": image.channel,
        "space": image.space,
    }


def _input(path: Path, kind: Kind, said: dict[str, Any], reply: dict[str, Any], search: Path | None) -> Input:
    factor, inverted, image = tuple(map(float, said["factor"])), bool(said["inverted"]), said["image"]
    if image is None:
        return Input(factor, None, inverted)
    place, content, tiles = path, None, dict[int, Path]()
    if image["file"] is None:
        content = reply[f"image {said['name']}"].tobytes()
    elif tiles := tiles_beside(path, image["file"], _REMEDIES[kind], search):
        place = Path(image["file"])
    else:
        place = file_beside(path, image["file"], _REMEDIES[kind], search)
        content = None if image["part"] is None else _part(path, place, *image["part"])
    name, transfer, channel = image["name"], image["transfer"], image["channel"]
    place, space = place if content is None else path, str(image["space"])
    found = Image(place, name, transfer, channel, content, space=space, tiles=tuple(tiles.items()))
    return Input(factor, found, inverted)


def _part(path: Path, place: Path, start: int, length: int) -> bytes:
    """Bytes of a file beside the document."""
    with open_checked(place, FILE_LIMIT_BYTES) as (file, size_bytes):
        if start + length > size_bytes:
            raise InputError(path, "names bytes of an image that it does not have", "Export it as .glb")
        file.seek(start)
        return file.read(length)


def _limit_bytes(path: Path, kind: Kind) -> int:
    if kind != "gltf":
        return _TEXT_LIMIT_BYTES
    return FILE_LIMIT_BYTES if read_head(path, 4)[0] == b"glTF" else JSON_LIMIT_BYTES

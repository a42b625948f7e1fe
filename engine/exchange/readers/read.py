"""A material from whatever holds one: a bundle, PBR textures in a folder or a zip, a MaterialX document, a glTF file.

The content says which it is: a folder with a manifest and a zip with one are bundles, a zip of images that are named
for maps holds textures, as a folder of them does; a text that begins as XML is MaterialX, and glTF has its mark or is
JSON. A folder without textures that holds one such document stands for it. What is none of these is read as a bundle,
whose reader says what is wrong with it.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from engine.bundle.bundle import open_bundle
from engine.core.errors import InputError
from engine.core.steps import Steps, drain
from engine.exchange.readers.archive import holds_zipped_textures, read_zip
from engine.exchange.readers.documents_child import describe_document
from engine.exchange.readers.folder import describe_folder, describe_textures, document_in, holds_textures
from engine.exchange.readers.textures import Described, maps_of
from engine.scene.material import Material, material_of_maps
from engine.storage.untrusted import read_head

#: Bytes in which a file says what it is.
_HEAD_BYTES = 4096


def holds_pbr_maps(path: str | os.PathLike[str]) -> bool:
    """True if `path` is textures in a folder or a zip, a MaterialX document, a glTF file, or a folder of one of these.

    No image is decoded.
    """
    place = Path(path)
    try:
        if place.is_dir():
            is_bundle = (place / "manifest.json").is_file()
            return not is_bundle and (holds_textures(place) or document_in(place) is not None)
        return place.is_file() and (_kind(place) != "" or holds_zipped_textures(place))
    except (OSError, ValueError, InputError):
        return False


def open_material(path: str | os.PathLike[str]) -> Material:
    """The material at `path`; InputError where there is none, with what would be right."""
    return drain(read_material(path))


def read_material(path: str | os.PathLike[str]) -> Steps[Material]:
    """As `open_material`, in steps: decoding large textures takes seconds."""
    if not holds_pbr_maps(path):
        _refuse_usd(Path(path))
        return open_bundle(path)
    place = Path(path)
    if place.is_file() and not _kind(place):
        return (yield from read_zip(place))
    return (yield from _read(describe(place)))


def _refuse_usd(path: Path) -> None:
    """InputError for a layer of USD, by its first bytes."""
    if path.is_file() and read_head(path, 8)[0].startswith((b"#usda", b"PXR-USDC")):
        raise InputError(path, "is a layer of USD, which is not read", "Export its material as .mtlx, .glb or .usdz")


def read_textures(files: Sequence[Path]) -> Steps[Material]:
    """The material of textures without their folder (`engine.exchange.readers.folder.are_textures`)."""
    return (yield from _read(describe_textures(files)))


def _read(described: Described) -> Steps[Material]:
    maps, health = yield from maps_of(described)
    return replace(material_of_maps(maps, described.name, health), credits=described.credits)


def describe(path: Path) -> Described:
    """The maps of a folder, a MaterialX document or a glTF file, as its reader describes them."""
    if path.is_dir():
        document = None if holds_textures(path) else document_in(path)
        if document is None:
            return describe_folder(path)
        path = document
    return describe_document(path, "materialx" if _kind(path) == "materialx" else "gltf")


def _kind(path: Path) -> str:
    """'materialx', 'gltf', or '' for neither."""
    head, _ = read_head(path, _HEAD_BYTES)
    text = head.removeprefix(b"\xef\xbb\xbf").lstrip()
    if head.startswith(b"glTF"):
        return "gltf"
    if text.startswith(b"<") and (b"<materialx" in text or path.suffix.lower() == ".mtlx"):
        return "materialx"
    is_json = text.startswith(b"{") and (path.suffix.lower() == ".gltf" or b'"asset"' in text)
    return "gltf" if is_json else ""

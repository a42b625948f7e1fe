"""A material from whatever holds one: a bundle, a folder of PBR textures, a MaterialX document or a glTF file.

The content says which it is: a folder with a manifest and a zip are bundles, a text that begins as XML is MaterialX,
and glTF has its mark or is JSON. What is none of these is read as a bundle, whose reader says what is wrong with it.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from engine.bundle.bundle import open_bundle
from engine.core.errors import InputError
from engine.core.steps import Steps, drain
from engine.exchange.readers.folder import describe_folder, describe_textures, holds_textures
from engine.exchange.readers.gltf import describe_gltf
from engine.exchange.readers.materialx import describe_materialx
from engine.exchange.readers.textures import Described, maps_of
from engine.scene.material import Material, material_of_maps
from engine.storage.untrusted import read_head

#: Bytes in which a file says what it is.
_HEAD_BYTES = 4096


def holds_pbr_maps(path: str | os.PathLike[str]) -> bool:
    """True if `path` is a folder of textures, a MaterialX document or a glTF file; no picture is decoded."""
    place = Path(path)
    try:
        if place.is_dir():
            return not (place / "manifest.json").is_file() and holds_textures(place)
        return place.is_file() and _kind(place) != ""
    except (OSError, ValueError, InputError):
        return False


def open_material(path: str | os.PathLike[str]) -> Material:
    """The material at `path`; InputError where there is none, with what would be right."""
    return drain(read_material(path))


def read_material(path: str | os.PathLike[str]) -> Steps[Material]:
    """As `open_material`, in steps: decoding large textures takes seconds."""
    if not holds_pbr_maps(path):
        return open_bundle(path)
    return (yield from _read(describe(Path(path))))


def read_textures(files: Sequence[Path]) -> Steps[Material]:
    """The material of textures without their folder (`engine.exchange.readers.folder.are_textures`)."""
    return (yield from _read(describe_textures(files)))


def _read(described: Described) -> Steps[Material]:
    maps, health = yield from maps_of(described)
    return material_of_maps(maps, described.name, health)


def describe(path: Path) -> Described:
    """The maps of a folder, a MaterialX document or a glTF file, as its reader describes them."""
    if path.is_dir():
        return describe_folder(path)
    return describe_materialx(path) if _kind(path) == "materialx" else describe_gltf(path)


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

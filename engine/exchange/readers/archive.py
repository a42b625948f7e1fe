"""PBR textures in a zip, as libraries of materials send them, and in a USD package, which is one.

Textures are known by their names as in a folder (`engine.exchange.readers.folder`), in whatever folder of the zip they
lie. Documents beside them (MaterialX, glTF, USD) are not read, because the files that they name are not unpacked to
their places; that is said. The textures are unpacked into a folder that lasts until they are decoded.
"""

from __future__ import annotations

import dataclasses
import tempfile
from collections.abc import Sequence
from pathlib import Path, PurePosixPath

from engine.core.errors import InputError
from engine.core.steps import Steps
from engine.exchange.readers.folder import RECORD, describe_unpacked, is_material, kind_of, say_unnamed
from engine.exchange.readers.textures import Described, maps_of
from engine.scene.material import Material, material_of_maps
from engine.storage.readers import suffixes
from engine.storage.unpack import unpack, zip_names
from engine.storage.untrusted import read_head

#: The decoder process that reads the archive: that of the images in it.
_PROCESS = "engine.images.decode"

#: Endings of documents that describe a material.
DOCUMENTS = (".mtlx", ".gltf", ".glb", ".usd", ".usda", ".usdc")

#: Beginning of the files that macOS packs beside others, which hold no image.
SHADOW = "._"


def holds_zipped_textures(path: Path) -> bool:
    """True for a zip with textures of a material; InputError where it is damaged. Nothing is unpacked."""
    if path.suffix.lower() == ".lightarc" or not read_head(path, 2)[0].startswith(b"PK"):
        return False
    names = zip_names(path, _PROCESS)
    return "manifest.json" not in names and is_material([Path(name) for name in _textures(names)])


def read_zip(path: Path) -> Steps[Material]:
    """The material of a zip; InputError where it is damaged, or holds several."""
    names = zip_names(path, _PROCESS)
    noted = [*_notes(names), *say_unnamed(_list_unnamed(names))]
    with tempfile.TemporaryDirectory(prefix="lightarc-textures-", ignore_cleanup_errors=True) as folder:
        yield from unpack(path, Path(folder), _choose_files, _PROCESS)
        described: Described = describe_unpacked(path, Path(folder))
        try:
            maps, health = yield from maps_of(dataclasses.replace(described, notes=(*described.notes, *noted)))
        except InputError as error:
            raise InputError(path / Path(error.path).name, error.problem, error.remedy) from None
    return material_of_maps(maps, described.name, health)


def _textures(names: Sequence[str]) -> list[str]:
    """Names of images that are named for a map, without the shadows that macOS packs beside files."""
    paths = [PurePosixPath(name) for name in names]
    return [
        str(path)
        for path in paths
        if path.suffix.lower() in suffixes("image") and kind_of(path.name)[0] and not path.name.startswith(SHADOW)
    ]


def _choose_files(names: Sequence[str]) -> list[str]:
    """The textures, and the record of the export that wrote them."""
    return [*_textures(names), *[name for name in names if PurePosixPath(name).name == RECORD]]


def _list_unnamed(names: Sequence[str]) -> list[str]:
    """Names of images that are named for no map."""
    paths = [PurePosixPath(name) for name in names]
    images = [each for each in paths if each.suffix.lower() in suffixes("image") and not each.name.startswith(SHADOW)]
    return [each.name for each in images if not kind_of(each.name)[0]]


def _notes(names: Sequence[str]) -> list[str]:
    """A sentence on the documents of an archive; none where there are only textures."""
    documents = [PurePosixPath(name).name for name in names if name.lower().endswith(DOCUMENTS)]
    if not documents:
        return []
    return [f"{documents[0]} in the archive is not read: its textures are taken by their names; unpack it to read it"]

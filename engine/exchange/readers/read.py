"""A material from whatever holds one: a bundle, PBR textures, a MaterialX document, a glTF file, an RTI file.

The content says which it is: a folder with a manifest and a zip with one are bundles, a zip of images that are named
for maps holds textures, as a folder of them does; a text that begins as XML is MaterialX, and glTF has its mark or is
JSON. Files of reflectance transformation imaging begin as PTM and HSH do, or count their planes (`info.json`). A folder
without textures that holds one such document stands for it. What is none of these is read as a bundle, whose reader
says what is wrong with it. `FILE#NAME` is the material of that name in a glTF file.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path

from engine.bundle.bundle import open_bundle
from engine.core.errors import InputError
from engine.core.health import Finding, Verdict
from engine.core.steps import Steps, drain, part
from engine.exchange.readers.archive import holds_zipped_textures, read_zip
from engine.exchange.readers.documents_child import Kind, describe_document, list_parts
from engine.exchange.readers.folder import describe_folder, describe_textures, document_in, holds_textures
from engine.exchange.readers.rti import form_of, read_rti
from engine.exchange.readers.textures import MAX_SIDE, Described, Input, maps_of
from engine.scene.material import Material, material_of_maps
from engine.storage.untrusted import read_head

#: Bytes in which a file says what it is.
_HEAD_BYTES = 4096


def holds_material(path: str | os.PathLike[str]) -> bool:
    """True if `path` is a material of another program.

    These are textures in a folder or a zip, a MaterialX document, a glTF file, a folder of one of these, and files of
    reflectance transformation imaging.

    No image is decoded.
    """
    place = split_name(path)[0]
    try:
        if place.is_dir():
            is_bundle = (place / "manifest.json").is_file()
            return not is_bundle and (holds_textures(place) or document_in(place) is not None or bool(form_of(place)))
        return place.is_file() and (_kind(place) != "" or bool(form_of(place)) or holds_zipped_textures(place))
    except (OSError, ValueError, InputError):
        return False


def open_material(path: str | os.PathLike[str], *, parts: bool = False) -> Material:
    """The material at `path`, with those of the `parts` of its model where these are wanted; InputError where there is
    none, with what would be right."""
    return drain(read_material(path, parts=parts))


def read_material(path: str | os.PathLike[str], *, parts: bool = False) -> Steps[Material]:
    """As `open_material`, in steps: decoding large textures takes seconds."""
    if not holds_material(path):
        _refuse_others(Path(path))
        return open_bundle(path)
    place, name = split_name(path)
    if (form := form_of(place)) is not None:
        return (yield from read_rti(place, form))
    if place.is_file() and not _kind(place):
        return (yield from read_zip(place))
    of_model = list_parts(place) if parts and not name and place.is_file() and _kind(place) == "gltf" else []
    if not of_model:
        described = describe(place, name)
        return (yield from _read(replace(described, notes=(*described.notes, *described.elsewhere))))
    return (yield from _read_parts(place, of_model))


def split_name(path: str | os.PathLike[str]) -> tuple[Path, str]:
    """The file of a material, and the name of the one that is meant where it holds several ('' for none)."""
    text = os.fspath(path)
    if "#" not in text or os.path.lexists(text):
        return Path(path), ""
    file, _, name = text.rpartition("#")
    return Path(file), name


def _read_parts(path: Path, names: Sequence[str]) -> Steps[Material]:
    """The material of a glTF file that stands for all, with those of all parts of the model.

    Together they have at most as many texels as one of the largest size.
    """
    main = describe(path)
    described = [describe(path, name) for name in names]
    textured = sum(_images(each) > 0 for each in described)
    most = int(MAX_SIDE / max(1, textured) ** 0.5)
    found = []
    for number, (name, each) in enumerate(zip(names, described, strict=True)):
        material = yield from part(_read(each, most), number / len(names), (number + 1) / len(names))
        found.append(replace(material, name=name))
    first = next((each for each in found if each.name == main.name), found[0])
    findings = tuple(Finding(Verdict.WARNING, text) for text in main.elsewhere)
    health = replace(first.health, findings=(*first.health.findings, *findings))
    return replace(first, name=main.name, health=health, parts=tuple(found))


def _images(described: Described) -> int:
    values = [getattr(described, each.name) for each in fields(described)]
    return sum(isinstance(each, Input) and each.image is not None for each in values)


def _refuse_others(path: Path) -> None:
    """InputError for a layer of USD, by its first bytes, and for what is named for RTI and is not."""
    if path.is_file() and read_head(path, 8)[0].startswith((b"#usda", b"PXR-USDC")):
        raise InputError(path, "is a layer of USD, which is not read", "Export its material as .mtlx, .glb or .usdz")
    if path.is_file() and path.suffix.lower() in (".ptm", ".rti"):
        raise InputError(path, "is not a PTM or HSH file", "Give a file that begins with PTM_1.2 or #HSH1.2")


def read_textures(files: Sequence[Path]) -> Steps[Material]:
    """The material of textures without their folder (`engine.exchange.readers.folder.are_textures`)."""
    return (yield from _read(describe_textures(files)))


def _read(described: Described, most: int = MAX_SIDE) -> Steps[Material]:
    maps, health = yield from maps_of(described, most)
    return replace(material_of_maps(maps, described.name, health), credits=described.credits)


def describe(path: Path, name: str = "") -> Described:
    """The maps of a folder, a MaterialX document or a glTF file, as its reader describes them.

    Of a glTF file the material of this `name`.
    """
    if path.is_dir():
        document = None if holds_textures(path) else document_in(path)
        if document is None:
            return describe_folder(path)
        path = document
    kind: Kind = "materialx" if _kind(path) == "materialx" else "gltf"
    if name and kind != "gltf":
        raise InputError(path, "is no glTF file, of which #NAME chooses a material", f"Leave out #{name}")
    return describe_document(path, kind, name)


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

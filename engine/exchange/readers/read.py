"""A material from whatever holds one: a bundle, PBR textures, a MaterialX document, a model with its own, an RTI file.

The content says which it is: a folder with a manifest and a zip with one are bundles, a zip of images that are named
for maps holds textures, as a folder of them does; a text that begins as XML is MaterialX, and glTF has its mark or is
JSON. Files of reflectance transformation imaging begin as PTM and HSH do, or count their planes (`info.json`). A folder
without textures that holds one such document stands for it. What is none of these is read as a bundle, whose reader
says what is wrong with it. `FILE#NAME` is the material of that name in a glTF, OBJ or USD file or a library (.mtl).
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path

from engine.brdf.readers.read import refuse_others
from engine.bundle.bundle import open_bundle
from engine.core.errors import InputError
from engine.core.health import Finding, Verdict
from engine.core.steps import Steps, drain, part
from engine.exchange.readers.archive import holds_zipped_textures, read_zip
from engine.exchange.readers.documents_child import (
    Kind,
    describe_coloured,
    describe_document,
    describe_usd,
    is_obj,
    library_beside,
    list_libraries,
    list_parts,
)
from engine.exchange.readers.folder import (
    describe_folder,
    describe_textures,
    document_in,
    holds_textures,
    textures_in,
)
from engine.exchange.readers.rti import form_of, read_rti
from engine.exchange.readers.textures import MAX_SIDE, Described, Input, maps_of
from engine.geometry.gltf import NO_MATERIAL
from engine.geometry.ply import has_colours
from engine.geometry.usd import is_usd
from engine.scene.material import Material, material_of_maps
from engine.storage.untrusted import read_head

#: Endings of textures in the formats of graphics devices, and what to do with them.
_PACKED, _UNPACKED = (".ktx2", ".ktx", ".dds"), "Convert it to PNG, with ktx extract for one"

#: Bytes in which a file says what it is.
_HEAD_BYTES = 4096


def holds_material(path: str | os.PathLike[str]) -> bool:
    """True if `path` is a material of another program.

    These are textures in a folder or a zip, a MaterialX document, a glTF, OBJ or USD file, a library of OBJ materials,
    a folder of one of these, and files of reflectance transformation imaging.

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


def open_material(
    path: str | os.PathLike[str], *, parts: bool = False, search: str | os.PathLike[str] | None = None
) -> Material:
    """The material at `path`, with those of the `parts` of its model where these are wanted; InputError where there is
    none, with what would be right.

    `search` is a folder in which a document or a model may name files too.
    """
    return drain(read_material(path, parts=parts, search=search))


def read_material(
    path: str | os.PathLike[str], *, parts: bool = False, search: str | os.PathLike[str] | None = None
) -> Steps[Material]:
    """As `open_material`, in steps: decoding large textures takes seconds."""
    if not holds_material(path):
        refuse_by_name(Path(path))
        return open_bundle(path)
    place, name = split_name(path)
    within = None if search is None else Path(search)
    if (form := form_of(place)) is not None:
        return (yield from read_rti(place, form))
    if place.is_file() and not _kind(place):
        return (yield from read_zip(place))
    is_model = place.is_file() and _kind(place) in ("gltf", "obj", "ply", "usd")
    of_model = list_parts(place) if parts and not name and is_model else []
    if not of_model:
        described = describe(place, name, within)
        return (yield from _read(replace(described, notes=(*described.notes, *described.elsewhere))))
    return (yield from _read_parts(place, of_model, within))


def split_name(path: str | os.PathLike[str]) -> tuple[Path, str]:
    """The file of a material, and the name of the one that is meant where it holds several ('' for none)."""
    text = os.fspath(path)
    if "#" not in text or os.path.lexists(text):
        return Path(path), ""
    file, _, name = text.rpartition("#")
    return Path(file), name


def find_doubt_of_parts(path: Path, search: str | os.PathLike[str] | None = None) -> str | None:
    """None where a model brings materials of its parts; a sentence where it does not though it names some; otherwise
    an empty text. Libraries of an OBJ file may lie in the folder `search` too."""
    if not list_parts(path):
        return ""
    if not is_obj(path):
        return None
    libraries = list_libraries(path)
    try:
        for named in libraries:
            library_beside(path, named, None if search is None else Path(search))
    except InputError as error:
        return f"is drawn without its materials: it {error.problem}"
    return None if libraries or list_parts(path) == [NO_MATERIAL] else ""


def _read_parts(path: Path, names: Sequence[str], search: Path | None) -> Steps[Material]:
    """The material of a model that stands for all, with those of all its parts.

    Together they have at most as many texels as one of the largest size.
    """
    names = list(dict.fromkeys([*names, *([NO_MATERIAL] if is_obj(path) else [])]))
    if is_usd(path):
        main, *described = describe_usd(path, ["", *names], search)
    else:
        main = describe(path, search=search)
        described = [describe(path, name, search) for name in names]
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


def refuse_by_name(path: Path) -> None:
    """InputError for what is named for RTI and is not, packed textures, and measurements of another kind.

    A folder is refused that holds such textures, or images that are named for maps and make no material.
    """
    if path.is_dir():
        packed = sorted(each.name for each in path.iterdir() if each.suffix.lower() in _PACKED)
        if packed:
            raise InputError(path, f"holds textures that are not read ({packed[0][:40]!r})", _UNPACKED)
        if (path / "stack.json").is_file():
            raise InputError(path, "is a stack, and no material", "Make one of it with lightarc shade")
        named = textures_in(path)
        if named and not (path / "manifest.json").is_file():
            text = " and ".join(kind.replace("_", " ") for kind in list(named)[:4])
            problem = f"holds no textures of a material: by their names these are {text} alone"
            raise InputError(
                path, problem, "Put a base colour and another map there, as rock_color.png, rock_normal.png"
            )
    if path.is_file():
        head = read_head(path, _HEAD_BYTES)[0]
        refuse_others(path, head)
        if path.suffix.lower() in _PACKED and head.startswith((b"\xabKTX ", b"DDS ")):
            raise InputError(path, f"is a texture that is not read ({path.suffix[1:].upper()})", _UNPACKED)
    if path.is_file() and path.suffix.lower() in (".ptm", ".rti"):
        raise InputError(path, "is not a PTM or HSH file", "Give a file that begins with PTM_1.2 or #HSH1.2")


def read_textures(files: Sequence[Path]) -> Steps[Material]:
    """The material of textures without their folder (`engine.exchange.readers.folder.are_textures`)."""
    return (yield from _read(describe_textures(files)))


def _read(described: Described, most: int = MAX_SIDE) -> Steps[Material]:
    maps, health = yield from maps_of(described, most)
    return replace(material_of_maps(maps, described.name, health), credits=described.credits)


def describe(path: Path, name: str = "", search: Path | None = None) -> Described:
    """The maps of a folder, a MaterialX document or a glTF file, as its reader describes them.

    Of a glTF file the material of this `name`; a document may name files in the folder `search` too.
    """
    if path.is_dir():
        document = None if holds_textures(path) else document_in(path)
        if document is None:
            return describe_folder(path)
        path = document
    found = _kind(path)
    if found == "obj":
        return _describe_obj(path, name, search)
    if found == "ply":
        return describe_coloured(path)
    if found == "usd":
        return describe_usd(path, [name], search)[0]
    kind: Kind = "materialx" if found == "materialx" else "mtl" if found == "mtl" else "gltf"
    if name and kind == "materialx":
        raise InputError(path, "is no glTF file, of which #NAME chooses a material", f"Leave out #{name}")
    return describe_document(path, kind, name, search)


def _describe_obj(path: Path, name: str, search: Path | None) -> Described:
    """The material of this name in the libraries of an OBJ file, or the first with a map."""
    libraries = [library_beside(path, named, search) for named in list_libraries(path)]
    if not libraries and list_parts(path) == [NO_MATERIAL]:
        return describe_coloured(path)
    if not libraries:
        raise InputError(path, "names no library of materials (mtllib)", "Export it with its materials")
    if not name:
        described = [_describe_obj(path, each, search) for each in list_parts(path) or [NO_MATERIAL]]
        taken = next((each for each in described if _images(each)), described[0])
        if len(described) == 1:
            return taken
        words = f"of {len(described)} materials, {taken.name!r} is taken; {path.name}#NAME chooses another one"
        return replace(taken, elsewhere=(words,))
    for library in libraries:
        try:
            return describe_document(library, "mtl", name, search)
        except InputError as error:
            if not error.problem.startswith("has no material"):
                raise
    if name not in list_parts(path):
        raise InputError(path, f"has no material {name!r}", f"Choose one of {', '.join(list_parts(path)[:5])}")
    white = describe_document(libraries[0], "mtl", NO_MATERIAL)
    return replace(white, name=name, notes=("is in no library of the model, and drawn white",))


def _kind(path: Path) -> str:
    """'materialx', 'gltf', 'obj', 'mtl', 'ply' (with colours), 'usd', or '' for none of these."""
    if is_usd(path):
        return "usd"
    if path.suffix.lower() in (".obj", ".mtl"):
        return path.suffix.lower()[1:]
    head, _ = read_head(path, _HEAD_BYTES)
    if head.startswith(b"ply"):
        return "ply" if has_colours(head) else ""
    text = head.removeprefix(b"\xef\xbb\xbf").lstrip()
    if head.startswith(b"glTF"):
        return "gltf"
    if text.startswith(b"<") and (b"<materialx" in text or path.suffix.lower() == ".mtlx"):
        return "materialx"
    is_json = text.startswith(b"{") and (path.suffix.lower() == ".gltf" or b'"asset"' in text)
    return "gltf" if is_json else ""

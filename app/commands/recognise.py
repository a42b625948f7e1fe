"""What files and folders hold: by content, and by the ending of a name only where the content does not decide.

Files of any kinds may come together. `recognise` sorts them into groups, each of which opens in its own place, and
gives a reason for every file that does not open.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal
from urllib.parse import quote

from engine.capture.lights.sources import belongs, find
from engine.capture.photograph.kinds import photograph_suffixes
from engine.core.errors import InputError
from engine.geometry.usd import is_usd
from engine.storage.readers import find_reader, readers, suffixes
from engine.storage.unpack import is_archive, zip_names

Kind = Literal["photographs", "stack", "bundle", "material", "mesh", "environment", "brdf", "factors"]

#: Kinds that fill the one place of a project for a capture or a material.
CONTENT: tuple[Kind, ...] = ("bundle", "material", "stack", "photographs")

#: Names of the kinds of which a project holds one.
SINGLE = {"mesh": "model", "environment": "environment", **dict.fromkeys(CONTENT, "capture or material")}

#: Order in which groups open: the workspace of the last one comes to the front.
ORDER: tuple[Kind, ...] = ("brdf", "factors", "environment", "mesh", *CONTENT)

#: The beginning of camera files that no other image begins with.
_RAW_START = b"FUJIFILM"

#: Documents that name other files, and bytes of one that are searched for names.
_DOCUMENT_SUFFIXES, _MAX_DOCUMENT_BYTES = (".gltf", ".mtlx", ".obj", ".mtl"), 1 << 24

#: Files of a folder that are looked at where it holds no capture.
_MAX_FILES = 200

#: Number of images twice as wide as high that are a capture where their lights are stated.
_MIN_CAPTURE = 3

_RADIANCE_SIZE = re.compile(rb"\n\n[+-]([XY]) (\d{1,9}) [+-][XY] (\d{1,9})\n")
_EXR_WINDOW = b"dataWindow\0box2i\0"


@dataclass(frozen=True)
class Recognised:
    """A group of files that open together: its kind and its paths."""

    kind: Kind
    paths: tuple[Path, ...]


@dataclass(frozen=True)
class Opening:
    """Files that were given together: the `groups` in the order in which they open, and an error for each that does
    not open."""

    groups: tuple[Recognised, ...]
    excluded: tuple[InputError, ...] = ()


def recognise(paths: Sequence[Path]) -> Opening:
    """Sort `paths` into groups by what they hold.

    Loose images are photographs of one capture, or a material where each is named for a map of it. HDR and EXR images
    twice as wide as high are environments, and so is one that comes without others of its kind; three and more of one
    size whose lights are stated are photographs. A file that a document among `paths` names, as a glTF file its
    textures, opens with the document. A project holds one model, one environment, and one capture or material: of
    several the first opens.
    """
    found, excluded, given = dict[Path, Kind](), list[InputError](), list[Path]()
    for path in paths:
        given += [each for each in _inside(path) if each not in given]
    belonging = _belonging(given)
    for path in given:
        if path in belonging:
            continue
        try:
            kind = _kind(path)
        except InputError as error:
            excluded.append(error)
            continue
        if kind is None:
            excluded.append(_unknown(path))
        else:
            found[path] = kind
    beside = [Path(each.path) for each in excluded if belongs(Path(each.path)) and Path(each.path).is_file()]
    groups = _group(found, beside)
    if any(group.kind == "photographs" for group in groups):
        excluded = [each for each in excluded if Path(each.path) not in beside]
    opened, names = list[Recognised](), dict[str, str]()
    for group in groups:
        what = SINGLE.get(group.kind, "")
        if what and what in names:
            remedy = f"A project holds one {what}, here {names[what]}. Open this one alone to replace it"
            excluded += [InputError(path, f"is a second {what}", remedy) for path in group.paths]
            continue
        names[what] = group.paths[0].name
        opened.append(group)
    return Opening(tuple(sorted(opened, key=lambda group: ORDER.index(group.kind))), tuple(excluded))


def _group(found: dict[Path, Kind], beside: Sequence[Path]) -> list[Recognised]:
    """Groups in the order of their first file; photographs come with the files `beside` that describe them."""
    given = [path for path, kind in found.items() if kind == "photographs"]
    loose = [path for path in given if path.is_file() and not is_archive(path)]
    panoramas = [] if _are_textures(loose) else _environments(given, loose, beside)
    left = [path for path in loose if path not in panoramas]
    textures = left if _are_textures(left) else []
    groups: dict[object, list[Path]] = {}
    kinds: dict[object, Kind] = {}
    for path, kind in found.items():
        kind = "environment" if path in panoramas else "material" if path in textures else kind
        is_joint = kind in ("photographs", "brdf") or path in textures
        key: object = kind if is_joint else path
        kinds[key] = kind
        groups.setdefault(key, []).append(path)
    if "photographs" in groups:
        groups["photographs"] += beside
    return [Recognised(kinds[key], tuple(members)) for key, members in groups.items()]


def _are_textures(files: Sequence[Path]) -> bool:
    from engine.exchange.readers.folder import are_textures  # loads the readers of textures

    return len(files) > 1 and are_textures(files)


def _environments(given: Sequence[Path], loose: Sequence[Path], beside: Sequence[Path]) -> list[Path]:
    """The environments among `loose` images, which are those among all photographs `given` that are files."""
    images = [path for path in loose if _is_hdr(path)]
    if len(images) == 1:
        return images
    sizes = {path: _size_of(path) for path in images}
    wide = [path for path, (width, height) in sizes.items() if width == 2 * height > 0]
    is_capture = len(wide) == len(given) >= _MIN_CAPTURE and len(set(sizes.values())) == 1
    return [] if is_capture and _state_lights([*loose, *beside]) else wide


def _state_lights(files: Sequence[Path]) -> bool:
    """True if names or files beside photographs state the directions of their lights."""
    try:
        return find(files).angle_source != "assumed"
    except InputError:
        return False


def _size_of(path: Path) -> tuple[int, int]:
    """Width and height of an HDR or EXR image, as the start of its file says; (0, 0) where it does not."""
    start = _start(path)
    if start.startswith(b"#?"):
        found = _RADIANCE_SIZE.search(start)
        if found is None:
            return 0, 0
        first, second = int(found[2]), int(found[3])
        return (second, first) if found[1] == b"Y" else (first, second)
    at = start.find(_EXR_WINDOW)
    corners = start[at + len(_EXR_WINDOW) + 4 : at + len(_EXR_WINDOW) + 20]
    if at < 0 or len(corners) < 16:
        return 0, 0
    left, top, right, bottom = (int.from_bytes(corners[i : i + 4], "little", signed=True) for i in range(0, 16, 4))
    return right - left + 1, bottom - top + 1


def _unknown(path: Path) -> InputError:
    if not path.exists():
        return InputError(path, "does not exist", "Check the path, or whether its drive is connected")
    if path.is_file():
        from engine.exchange.readers.read import refuse_by_name  # loads readers of materials

        try:
            refuse_by_name(path)
        except InputError as error:
            return error
    if belongs(path):
        return InputError(path, "is not a photograph that Lightarc reads", "Open it together with the photographs")
    return InputError(
        path,
        "is not a kind of file that Lightarc opens",
        "Open photographs (a folder or an archive), a model (OBJ, PLY, STL, glTF, USD), an environment (HDR, EXR), a "
        "measured BRDF (MERL, RGL, …), a folder of factors, a .lightarc bundle, PBR textures, a MaterialX document, "
        "or RTI files (PTM, HSH)",
    )


def _inside(path: Path) -> list[Path]:
    """The files that a folder without a capture stands for; otherwise `path` itself."""
    document = _document(path)
    if document is not None:
        return [document]
    if not path.is_dir() or _kind_of_folder(path) != "photographs":
        return [path]
    try:
        entries = sorted(path.iterdir())
    except OSError:
        return [path]
    images = [entry for entry in entries if entry.suffix.lower() in photograph_suffixes()]
    if len(images) > 1 or len(entries) > _MAX_FILES or any(entry.is_dir() or is_archive(entry) for entry in entries):
        return [path]
    files = []
    for entry in entries:
        try:
            kind = _kind(entry)
        except InputError:
            continue
        if kind is not None and (kind != "photographs" or _is_hdr(entry)):
            files.append(entry)
    return files or [path]


def _belonging(paths: Sequence[Path]) -> set[Path]:
    """The files among `paths` that a document among them names: textures, buffers and libraries of materials."""
    documents = [path for path in paths if path.suffix.lower() in _DOCUMENT_SUFFIXES and path.is_file()]
    named = set[Path]()
    for document in documents:
        with document.open("rb") as file:
            content = file.read(_MAX_DOCUMENT_BYTES)
        others = (path for path in paths if path not in (document, *named) and path.parent == document.parent)
        named.update(path for path in others if _names(content, path))
    return named


def _names(content: bytes, path: Path) -> bool:
    return any(name.encode("utf-8", "surrogateescape") in content for name in (path.name, _quote(path.name)))


def _quote(name: str) -> str:
    return quote(name.encode("utf-8", "surrogateescape"))


def _kind(path: Path) -> Kind | None:
    if path.is_dir():
        return _kind_of_folder(path)
    if not path.is_file():
        return None
    start = _start(path)
    if start.startswith(b"PK"):
        return _kind_of_zip(path)
    if is_archive(path):
        return "photographs"
    if start.startswith((_RAW_START, *_signatures("image"))):
        return "brdf" if _is_hdr(path) and _is_brdf(path, start) else "photographs"
    if path.suffix.lower() == ".mtlx" or b"<materialx" in start[:4096]:
        return "material"
    if start.startswith(_signatures("mesh")) or path.suffix.lower() in suffixes("mesh"):
        return "mesh"
    if _is_rti(path):
        return "material"
    # a file with an ending of BRDFs alone is opened, so that its reader reports the error in it
    if any(path.suffix.lower() in each.suffixes for each in readers("brdf")) or _is_brdf(path, start):
        return "brdf"
    return "photographs" if path.suffix.lower() in photograph_suffixes() else None


def _is_hdr(path: Path) -> bool:
    begins = tuple(begin for each in readers("image") if each.of_radiance for begin in each.signatures)
    return path.is_file() and _start(path).startswith(begins)


def _is_brdf(path: Path, start: bytes) -> bool:
    return find_reader("brdf", start, path.stat().st_size, path.name) is not None


def _is_rti(path: Path) -> bool:
    if path.suffix.lower() in (".ptm", ".rti"):  # of which the reader says what is wrong with it
        return True
    if not path.is_dir() and path.name.lower() != "info.json":
        return False
    from engine.exchange.readers.rti import form_of  # loads readers of images

    return form_of(path) is not None


def _signatures(kind: Literal["image", "mesh"]) -> tuple[bytes, ...]:
    return tuple(begin for each in readers(kind) for begin in each.signatures)


def _start(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            return file.read(1 << 16)  # as many as `brdf_file` looks at
    except OSError as error:
        raise InputError(path, f"cannot be read ({error.strerror})", "Check the permissions of the file") from None


def _kind_of_zip(path: Path) -> Kind:
    if path.suffix.lower() == ".lightarc" or "manifest.json" in zip_names(path, "engine.capture.photograph.decode"):
        return "bundle"
    from engine.exchange.readers.archive import holds_zipped_textures  # loads the readers of textures

    if is_usd(path):
        return "mesh"
    if holds_zipped_textures(path):
        return "material"
    if path.suffix.lower() == ".usdz":
        remedy = "Install the extra usd (pip install 'lightarc[usd]'), or drop a glTF file"
        raise InputError(path, "is a USD package whose textures are not named for what they hold", remedy)
    return "photographs"


def _document(path: Path) -> Path | None:
    """The document that a folder without textures stands for; None for other folders and for files."""
    if not path.is_dir() or any((path / name).exists() for name in ("stack.json", "factors.json", "manifest.json")):
        return None
    from engine.exchange.readers.folder import document_in, holds_textures  # loads the readers of textures

    return None if holds_textures(path) else document_in(path)


def _kind_of_folder(path: Path) -> Kind:
    if (path / "stack.json").is_file():
        return "stack"
    if (path / "factors.json").is_file():
        return "factors"
    if (path / "manifest.json").is_file():
        return "bundle"
    from engine.exchange.readers.folder import holds_textures  # loads the readers of textures

    return "material" if holds_textures(path) or _is_rti(path) else "photographs"

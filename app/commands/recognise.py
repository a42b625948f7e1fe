"""The kind of a dropped file: by content, and by the ending of its name only where the content does not decide."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from engine.capture.photograph.kinds import PHOTOGRAPH_SUFFIXES
from engine.core.errors import InputError
from engine.geometry.mesh import SUFFIXES as MESH_SUFFIXES
from engine.storage.unpack import is_archive, zip_names

Kind = Literal["photographs", "stack", "bundle", "material", "mesh", "environment", "brdf", "factors"]

_PICTURE_STARTS = (
    b"\xff\xd8\xff",
    b"\x89PNG",
    b"II*\0",
    b"MM\0*",
    b"II+\0",
    b"MM\0+",
    b"\x76\x2f\x31\x01",
    b"#?RADIANCE",
    b"#?RGBE",
    b"FUJIFILM",
)
_HDR_STARTS = (b"\x76\x2f\x31\x01", b"#?RADIANCE", b"#?RGBE")
#: Endings of measured BRDFs alone: such a file is opened, so that its reader reports the error in it.
_BRDF_SUFFIXES = (".binary", ".bsdf", ".brdf", ".astm", ".alta")

_MESH_STARTS = (b"ply", b"glTF", b"solid", b"OFF")


@dataclass(frozen=True)
class Recognised:
    """One thing to open: its kind and the paths that belong to it."""

    kind: Kind
    paths: tuple[Path, ...]


def recognise(paths: Sequence[Path], *, lighting: bool = False) -> Recognised:
    """The kind of `paths`. Several files together are photographs, or a material where each is named for a map of it;
    InputError where nothing fits.

    One HDR or EXR picture is an environment where somebody is `lighting` a model; elsewhere it is refused in words,
    because one picture is no capture either.
    """
    if not paths:
        raise InputError("(nothing)", "no file was dropped", "Drop files or a folder from this computer")
    paths = [_document(path) or path for path in paths]
    kinds = {path: _kind(path) for path in paths}
    for kind in ("bundle", "material", "stack", "mesh", "factors"):
        chosen = tuple(path for path, found in kinds.items() if found == kind)
        if chosen:
            return Recognised(kind, chosen[:1])
    measured = tuple(path for path, found in kinds.items() if found == "brdf")
    if measured:
        return Recognised("brdf", measured)
    if len(paths) == 1 and kinds[paths[0]] == "photographs" and _is_hdr(paths[0]):
        if lighting:
            return Recognised("environment", tuple(paths))
        remedy = "Drop it on the View workspace to light the model with it, or drop all photographs of a capture"
        raise InputError(paths[0], "is a single picture of high dynamic range", remedy)
    if any(found == "photographs" for found in kinds.values()):
        from engine.exchange.readers.folder import are_textures  # loads the readers of textures

        if len(paths) > 1 and are_textures(paths):
            return Recognised("material", tuple(paths))
        return Recognised("photographs", tuple(paths))
    raise InputError(
        paths[0],
        "is nothing that Lightarc can open",
        "Drop a folder or an archive of photographs, a mesh (OBJ, PLY, STL, glTF), measured BRDFs "
        "(MERL, RGL, …), a folder of factors, a .lightarc bundle, PBR textures in a folder or a zip, or a MaterialX "
        "document",
    )


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
    if start.startswith(_PICTURE_STARTS):
        return "brdf" if _is_hdr(path) and _is_brdf(path, start) else "photographs"
    if path.suffix.lower() == ".mtlx" or b"<materialx" in start[:4096]:
        return "material"
    if start.startswith(_MESH_STARTS) or path.suffix.lower() in MESH_SUFFIXES:
        return "mesh"
    if path.suffix.lower() in _BRDF_SUFFIXES or _is_brdf(path, start):
        return "brdf"
    return "photographs" if path.suffix.lower() in PHOTOGRAPH_SUFFIXES else None


def _is_hdr(path: Path) -> bool:
    return path.is_file() and _start(path).startswith(_HDR_STARTS)


def _is_brdf(path: Path, start: bytes) -> bool:
    from engine.brdf.readers.read import FORMATS  # loads every reader, which the window does without until then

    size_bytes = path.stat().st_size
    return any(known.looks_like(start, size_bytes, path.name) for known in FORMATS)


def _start(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            return file.read(1 << 16)  # as many as `brdf_file` looks at
    except OSError as error:
        raise InputError(path, f"cannot be read ({error.strerror})", "Check the permissions of the file") from None


def _kind_of_zip(path: Path) -> Kind:
    if path.suffix.lower() == ".lightarc" or "manifest.json" in zip_names(path):
        return "bundle"
    from engine.exchange.readers.archive import holds_zipped_textures  # loads the readers of textures

    if holds_zipped_textures(path):
        return "material"
    if path.suffix.lower() == ".usdz":
        remedy = "Drop a folder of its textures, a MaterialX document or a glTF file"
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

    return "material" if holds_textures(path) else "photographs"

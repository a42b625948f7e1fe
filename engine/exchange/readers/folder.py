"""PBR textures in a folder or by themselves, which are known by the names of the files.

The names end in a word for the map, as Blender, Unreal, Unity, Godot, Substance, Poly Haven, ambientCG and this program
write it: `rock_base_color`, `T_Rock_BC`, `Bricks076_1K-JPG_NormalGL`, `brick_wall_diff_2k`, `wood_arm_4k`. Resolutions
and formats behind the word count for nothing. `lightarc normals` writes a `surface.json` beside its maps, and `lightarc
export` an `export.json` above them, which says where y of its normals points. Images that are named for no map are
named.

A packed texture holds a map in each channel: ORM and ARM occlusion, roughness, metallic; Unity's mask map metallic,
occlusion, and smoothness in alpha. Unity's `MetallicSmoothness` is alike.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from engine.core.errors import InputError
from engine.exchange.readers.textures import Described, Image, Input, Upwards
from engine.storage.readers import suffixes
from engine.storage.text import read_json
from engine.storage.untrusted import AGAIN, read_bytes
from engine.surface.pbr_maps import DIELECTRIC_F0

#: Most files of a folder that are looked at.
MAX_FILES = 2000

#: Letters that textures give to the name of their material.
LONGEST_NAME = 60

#: Reflectance of a dielectric that the specular level 1 stands for, in Blender, Unreal and Substance.
FULL_SPECULAR = 0.08

#: Words for maps, in lower case and without separators.
WORDS: dict[str, tuple[str, ...]] = {
    "base_colour": (
        *("basecolor", "basecolour", "basemap", "albedo", "albedotransparency", "diffuse", "diff", "color", "colour"),
        *("col", "bc", "alb", "d"),
    ),
    "normal": (
        *("normal", "normals", "norm", "nrm", "nor", "normalmap", "n", "normalgl", "norgl", "normalopengl"),
        *("normalogl", "normaldx", "nordx", "normaldirectx", "normald3d"),
    ),
    "roughness": ("roughness", "rough", "rgh", "r"),
    "smoothness": ("smoothness", "glossiness", "gloss"),
    "metallic": ("metallic", "metalness", "metal", "mtl", "m"),
    "height": ("height", "heightmap", "displacement", "disp", "bump", "h"),
    "occlusion": ("ambientocclusion", "occlusion", "ao", "occ", "mixedao"),
    "specular": ("specular", "specularlevel", "spec", "s"),
    "orm": ("orm", "arm", "occlusionroughnessmetallic", "aoroughmetal", "aorm"),
    "rma": ("rma", "roughmetalao"),
    "metallic_roughness": ("metallicroughness",),
    "mask": ("maskmap", "mask"),
    "metallic_smoothness": ("metallicsmoothness", "metallicgloss"),
}
_KINDS = {word: kind for kind, words in WORDS.items() for word in words}
_DIRECTX = ("normaldx", "nordx", "normaldirectx", "normald3d")
_OPENGL = ("normalgl", "norgl", "normalopengl", "normalogl")

#: Channels of packed textures by map; a smoothness is inverted.
_PACKED: dict[str, dict[str, int]] = {
    "orm": {"occlusion": 0, "roughness": 1, "metallic": 2},
    "rma": {"roughness": 0, "metallic": 1, "occlusion": 2},
    "metallic_roughness": {"roughness": 1, "metallic": 2},
    "mask": {"metallic": 0, "occlusion": 1},
    "metallic_smoothness": {"metallic": 0},
}

_NOTHING = re.compile(
    r"^(\d{1,9}k?|\d{1,9}x\d{1,9}|jpe?g|png|exr|tiff?|tga|hdr|\d\d?bit|linear|srgb|raw|float|half|lod\d|u\dv\d)$"
)
_PIECES = re.compile(r"[A-Z]{1,99}(?![a-z])|[A-Z]?[a-z]{1,99}|\d{1,99}[kK]?")
#: A number of a UDIM tile behind a separator, at the end of a name.
_TILE = re.compile(r"[^A-Za-z0-9](1[0-9]{3})$")

#: Record of an export, and its most bytes.
RECORD, _RECORD_BYTES = "export.json", 1 << 20

_REMEDY = "Put the textures of one material into a folder, named like rock_base_color.png and rock_normal.png"


def kind_of(name: str) -> tuple[str, str]:
    """The map that a file is named for, and the word that says so; ('', '') for none.

    >>> kind_of("Bricks076_1K-JPG_NormalGL.jpg")
    ('normal', 'normalgl')
    """
    stem = Path(name).stem
    for pieces in (_words(stem), _pieces(stem)):
        for count in (3, 2, 1):
            word = "".join(pieces[-count:])
            is_one = count == 1 or all(len(piece) > 1 for piece in pieces[-count:])  # `felt_n_orm` is no `norm`
            if len(pieces) >= count and is_one and word in _KINDS and (len(word) > 1 or len(pieces) > 1):
                return _KINDS[word], word
    return "", ""


def _words(stem: str) -> list[str]:
    """The parts of a name between separators, in lower case, without those that say nothing of the map."""
    return _telling([part.lower() for part in re.split(r"[^A-Za-z0-9]{1,99}", stem) if part])


def _pieces(stem: str) -> list[str]:
    """The same, also parted where capitals begin: `RockBaseColor` is rock, base, color."""
    return _telling([piece.lower() for piece in _PIECES.findall(stem)])


def _telling(parts: list[str]) -> list[str]:
    while parts and _NOTHING.match(parts[-1]):
        parts = parts[:-1]
    return [part for at, part in enumerate(parts) if at == 0 or not _NOTHING.match(part)]


def textures_in(folder: Path) -> dict[str, list[Path]]:
    """The images of a folder by the map that they are named for, in order of their names; empty where it is none."""
    try:
        files = sorted(each for each in folder.iterdir() if each.suffix.lower() in suffixes("image"))[:MAX_FILES]
    except OSError:
        return {}
    return by_map(files)


def by_map(files: Sequence[Path]) -> dict[str, list[Path]]:
    """Files by the map that they are named for, without those that are named for none."""
    found: dict[str, list[Path]] = {}
    for file in files:
        kind, _ = kind_of(file.name)
        if kind:
            found.setdefault(kind, []).append(file)
    return found


def holds_textures(folder: Path) -> bool:
    """True for a folder with a base colour and at least one other map, not by single letters alone.

    Nothing is decoded.
    """
    return _are_of_a_material(textures_in(folder))


def is_material(files: Sequence[Path]) -> bool:
    """True where images, of which some may be named for no map, hold what `holds_textures` asks of a folder."""
    return _are_of_a_material(by_map(files[:MAX_FILES]))


def are_textures(files: Sequence[Path]) -> bool:
    """True for images that are each named for a map, and are together what `holds_textures` asks of a folder."""
    return all(each.suffix.lower() in suffixes("image") and kind_of(each.name)[0] for each in files) and is_material(
        files
    )


def _are_of_a_material(found: dict[str, list[Path]]) -> bool:
    words = {kind_of(path.name)[1] for paths in found.values() for path in paths}
    return "base_colour" in found and len(found) > 1 and any(len(word) > 1 for word in words)


def describe_folder(folder: Path) -> Described:
    """The material in a folder of textures; InputError where it holds none, or several."""
    own = (folder / "surface.json").is_file()
    return _describe(folder, folder.absolute().name or "material", textures_in(folder), own, list_unnamed(folder))


def describe_unpacked(archive: Path, folder: Path) -> Described:
    """The material of an archive whose textures are in `folder`; errors as above, of the archive."""
    return _describe(archive, archive.stem or "material", textures_in(folder), False)


def list_unnamed(folder: Path) -> list[str]:
    """Names of the images of a folder that are named for no map."""
    files = sorted(each for each in folder.iterdir() if each.suffix.lower() in suffixes("image"))[:MAX_FILES]
    return [each.name for each in files if not kind_of(each.name)[0]]


def document_in(folder: Path) -> Path | None:
    """The one MaterialX document of a folder, or its one glTF file where no images lie beside it; else None."""
    try:
        files = sorted(folder.iterdir())[:MAX_FILES]
    except OSError:
        return None
    has_images = any(each.suffix.lower() in suffixes("image") for each in files)
    for endings in ((".mtlx",), () if has_images else (".gltf", ".glb")):
        found = [each for each in files if each.suffix.lower() in endings and each.is_file()]
        if len(found) == 1:
            return found[0]
    return None


def describe_textures(files: Sequence[Path]) -> Described:
    """The material of textures without their folder, named by what their names begin with; errors as above."""
    first, last = min(each.stem for each in files), max(each.stem for each in files)
    alike = next((at for at, pair in enumerate(zip(first, last, strict=False)) if pair[0] != pair[1]), len(first))
    name = first[: min(alike, LONGEST_NAME)].rstrip("_-. ")
    return _describe(files[0].parent, name or "material", by_map(sorted(files)), False)


def _describe(
    folder: Path, title: str, found: dict[str, list[Path]], own: bool, unnamed: Sequence[str] = ()
) -> Described:
    """`own` says that this program wrote the maps, and so how it writes specular and normals."""
    if "base_colour" not in found:
        raise InputError(folder, "holds no base colour among its images", _REMEDY)
    notes = list(say_unnamed(unnamed))
    files = {kind: _one(folder, kind, paths, notes) for kind, paths in found.items()}
    inputs: dict[str, Input] = {"base_colour": Input(image=Image(files["base_colour"], _describe_files(files), "auto"))}
    for kind, channels in _PACKED.items():
        if kind not in files:
            continue
        for name, channel in channels.items():
            packed = Image(files[kind], files[kind].name, channel=(0, 1, 2)[channel])
            inputs.setdefault(name, Input(image=packed))
        if kind in ("mask", "metallic_smoothness") and files[kind].suffix.lower() in (".png", ".exr"):
            smoothness = Image(files[kind], files[kind].name, channel="alpha")
            inputs.setdefault("roughness", Input(image=smoothness, inverted=True))
    for name in ("roughness", "metallic", "occlusion", "height"):
        if name in files:
            inputs[name] = Input(image=Image(files[name], files[name].name, channel=0))
    if "smoothness" in files and "roughness" not in files:
        image = Image(files["smoothness"], files["smoothness"].name, channel=0)
        inputs["roughness"] = Input(image=image, inverted=True)
    if "specular" in files:
        specular = Image(files["specular"], files["specular"].name, "linear")
        inputs["f0"] = Input((1.0,) if own else (FULL_SPECULAR,), specular)
    if "normal" in files:
        inputs["normal"] = Input(image=Image(files["normal"], files["normal"].name))
    absent = {"roughness": "0.5", "metallic": "0", "f0": f"{DIELECTRIC_F0:g}", "normal": "flat"}
    left = [f"{name} {value}" for name, value in absent.items() if name not in inputs and name != "f0"]
    if left:
        notes.append(f"no texture says these, which are taken as {', '.join(left)}")
    return Described(title, **inputs, upwards=_upwards(files, own), notes=tuple(notes))  # type: ignore[arg-type]


def say_unnamed(names: Sequence[str]) -> tuple[str, ...]:
    """A sentence on images that are named for no map; none where there are none."""
    more = f" and {len(names) - 3} more" if len(names) > 3 else ""
    return (f"{', '.join(names[:3])}{more}: named for no map that is drawn, and passed over",) if names else ()


def _describe_files(files: dict[str, Path]) -> str:
    return files["base_colour"].name


def _upwards(files: dict[str, Path], own: bool) -> Upwards:
    """The direction of y that names state: of the file itself, or of a program that has only one."""
    if "normal" not in files:
        return ""
    word = kind_of(files["normal"].name)[1]
    if word in _DIRECTX:
        return "directx"
    if own or word in _OPENGL:
        return "opengl"
    if recorded := _read_record(files["normal"]):
        return recorded
    # Epic's prefix and suffixes: Unreal reads normals with y down alone
    is_unreal = files["normal"].name.startswith("T_") and word == "n" and kind_of(files["base_colour"].name)[1] == "bc"
    return "directx" if is_unreal else ""


def _read_record(normal: Path) -> Upwards:
    """The direction of y that the record of an export of this program states for a file; '' without one."""
    for folder in (normal.parent, normal.parent.parent):
        try:
            content = read_bytes(folder / RECORD, _RECORD_BYTES)
            record = read_json(content, folder / RECORD, "the record", AGAIN)
        except InputError:
            continue
        targets = record.get("targets") if isinstance(record, dict) else None
        for target in targets if isinstance(targets, list) else []:
            names = target.get("files") if isinstance(target, dict) else None
            if isinstance(names, list) and any(str(name).endswith(normal.name) for name in names):
                return {"directx": "directx", "opengl": "opengl"}.get(str(target.get("normal")), "")  # type: ignore[return-value]
    return ""


def _one(folder: Path, kind: str, paths: Sequence[Path], notes: list[str]) -> Path:
    """The file of a map: of normals the one with y up, of copies in several formats the most exact one."""
    if kind == "normal":
        upward = [path for path in paths if kind_of(path.name)[1] in _OPENGL]
        plain = [path for path in paths if kind_of(path.name)[1] not in _DIRECTX]
        paths = upward or plain or paths
    stems = {path.stem for path in paths}
    tiles = {_TILE.sub("", stem) for stem in stems}
    if len(stems) > 1 and len(tiles) == 1 and all(_TILE.search(stem) for stem in stems):
        tiled = f"{paths[0].name} and {len(stems) - 1} more"
        problem = f"holds a set of UDIM tiles ({tiled}), of which one is read at a time"
        raise InputError(folder, problem, "Put the textures of one tile into a folder of its own")
    if len(stems) > 1:
        names = ", ".join(path.name for path in paths[:3])
        raise InputError(folder, f"holds several images for {kind.replace('_', ' ')} ({names})", _REMEDY)
    return min(paths, key=lambda path: suffixes("image").index(path.suffix.lower()))

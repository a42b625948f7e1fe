"""Materials of OBJ models: libraries (.mtl) of Wavefront, with the keys for PBR that programs add.

Kd and map_Kd are the base colour, Pr and Pm roughness and metallic with their maps, norm a map of normals. Without Pr
the highlight of Phong's exponent Ns becomes GGX's of alpha = √(2 / (Ns + 2)), which falls off alike about its middle.
Ks of 0.5 stands for the f0 of 0.04 that dielectrics have, as programs write it, and illum 0 and 1 for no highlight.
Relief (map_Bump) is that of normals where its file is named for them, else it is not drawn. Every key that is not drawn
is named. All this runs in the decoder process (`engine.exchange.readers.documents_child`).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path

from engine.core.errors import InputError
from engine.exchange.readers.textures import Channel, Described, Image, Input
from engine.geometry.gltf import NO_MATERIAL
from engine.images.decode import TransferChoice
from engine.storage.text import utf8

#: Options of maps, and how many words follow each at most; those of the last three are numbers.
_OPTIONS = {
    **dict.fromkeys(("-blendu", "-blendv", "-cc", "-clamp", "-imfchan", "-bm", "-boost", "-texres", "-type"), 1),
    "-mm": 2,
    **dict.fromkeys(("-o", "-s", "-t"), 3),
}

#: Keys that are read, and those that say nothing about a surface.
_READ = {"newmtl", "kd", "ks", "ns", "illum", "map_kd", "pr", "pm", "map_pr", "map_pm", "norm", "map_bump", "bump"}
_SILENT = {"ka", "map_ka", "sharpness", "ni"}

#: Words for keys that are not drawn, in lower case, and the value at which there is nothing of them.
_NOT_DRAWN = {
    "ke": ("emission", 0.0),
    "d": ("opacity", 1.0),
    "tr": ("opacity", 0.0),
    "pc": ("a clear coat", 0.0),
    "pcr": ("a clear coat", None),
    "ps": ("sheen", 0.0),
    "aniso": ("anisotropy", 0.0),
    "anisor": ("anisotropy", 0.0),
    "tf": ("a filter of transmitted light", 1.0),
    "map_ke": ("emission", None),
    "map_d": ("opacity", None),
}

_NORMALS = re.compile(r"norm|nrm|_n\.", re.IGNORECASE)
_NAMED = re.compile(rb"^[ \t]{0,40}+(usemtl|mtllib)[ \t]{1,40}+([^\r\n]{0,1000}+)", re.MULTILINE)
_COLOURED = re.compile(rb"^[ \t]{0,40}+v(?:[ \t]{1,40}+[-+.eE\d]{1,40}+){6,7}[ \t\r]{0,40}+$", re.MULTILINE)

Material = dict[str, str]


def scan_obj(content: bytes) -> tuple[list[str], list[str]]:
    """The libraries that an OBJ file names, and its materials in the order in which faces use them."""
    found: dict[bytes, list[str]] = {b"mtllib": [], b"usemtl": []}
    for key, said in _NAMED.findall(content):
        name = said.decode("utf-8", "replace").strip()
        if name and name not in found[key]:
            found[key].append(name)
    return found[b"mtllib"], found[b"usemtl"]


def has_colours_of_obj(content: bytes) -> bool:
    """True if a vertex of an OBJ file has six or seven numbers."""
    return _COLOURED.search(content) is not None


def names_of(content: bytes) -> list[str]:
    """Names of the materials of a library."""
    return list(_materials(content))


def mtl_of(content: bytes, path: Path, name: str = "") -> Described:
    """The material of this `name` in a library, or its first with a map; InputError where there is none.

    That without a name (`NO_MATERIAL`) is white.
    """
    materials = {**_materials(content), NO_MATERIAL: {}}
    if len(materials) == 1 and not name:
        raise InputError(path, "has no material", "Export the model with its materials")
    if name and name not in materials:
        known = ", ".join(repr(each) for each in list(materials)[:-1][:5])
        raise InputError(path, f"has no material {name!r}", f"Choose one of {known}")
    taken = name or next((each for each, said in materials.items() if "map_kd" in said), next(iter(materials)))
    described = _describe(path, materials[taken], taken)
    if len(materials) > 2 and not name:
        words = f"of {len(materials) - 1} materials, {taken!r} is taken; {path.name}#NAME chooses another one"
        return Described(**{**vars(described), "elsewhere": (words,)})
    return described


def _materials(content: bytes) -> dict[str, Material]:
    """For each material what its keys, in lower case, say."""
    found: dict[str, Material] = {}
    current: Material = {}
    for line in utf8(content).decode("utf-8", "replace").splitlines():
        key, _, said = line.partition("#")[0].strip().partition(" ")
        if key.lower() == "newmtl" and said.strip():
            current = found.setdefault(said.strip(), {})
        elif key:
            current[key.lower()] = said.strip()
    return found


def _describe(path: Path, said: Mapping[str, str], name: str) -> Described:
    notes: list[str] = []

    def numbers(key: str, usual: tuple[float, ...]) -> tuple[float, ...]:
        words = said.get(key, "").split()
        try:
            given = tuple(float(word) for word in words[: len(usual)])
        except ValueError:
            raise InputError(path, f"has an impossible {key} ({said[key][:40]!r})", "Export it again") from None
        if len(given) == 1 < len(usual):
            given *= len(usual)
        return given if len(given) == len(usual) and all(abs(each) <= 1e6 for each in given) else usual

    def image(key: str, transfer: TransferChoice, channel: Channel = None) -> Image | None:
        if key not in said:
            return None
        words, passed = said[key].split(), list[str]()
        while words and words[0] in _OPTIONS:
            option, count = words.pop(0), 0
            while words and count < _OPTIONS[option] and (count == 0 or _is_number(words[0])):
                words.pop(0)
                count += 1
            passed += [option] if option != "-bm" else []
        if passed:
            notes.append(f"{' and '.join(passed)} of {key} is passed over")
        named = " ".join(words).replace("\\", "/")
        return Image(Path(named), named[:60], transfer, channel) if named else None

    base = numbers("kd", (1.0 if "map_kd" in said else 0.8,) * 3)
    if "map_kd" in said and not any(base):  # programs write so that take the image alone
        base = (1.0,) * 3
        notes.append("Kd is 0 and is taken as 1 under map_Kd")
    exponent = max(numbers("ns", (0.0,))[0], 0.0)
    has_highlight = numbers("illum", (2.0,))[0] >= 2.0
    strength = sum(numbers("ks", (0.5,) * 3)) / 3.0 if has_highlight else 0.0
    relief = next((key for key in ("norm", "map_bump", "bump") if key in said), None)
    normal = image(relief, "linear") if relief is not None else None
    if relief is not None and relief != "norm" and normal is not None and not _NORMALS.search(normal.name):
        notes.append(f"the relief of {relief} is not drawn")
        normal = None
    notes += _list_passed(said, numbers)
    return Described(
        name[:60],
        base_colour=Input(base, image("map_kd", "auto")),
        roughness=Input(
            (1.0,) if "map_pr" in said else numbers("pr", ((2.0 / (exponent + 2.0)) ** 0.25,)),
            image("map_pr", "linear", 0),
        ),
        metallic=Input((1.0,) if "map_pm" in said else numbers("pm", (0.0,)), image("map_pm", "linear", 0)),
        f0=Input((min(max(0.08 * strength, 0.0), 1.0),)),
        normal=None if normal is None else Input(image=normal),
        upwards="opengl",
        notes=tuple(notes),
    )


def _list_passed(said: Mapping[str, str], numbers: Callable[[str, tuple[float, ...]], tuple[float, ...]]) -> list[str]:
    """Sentences about what is not drawn."""
    words = []
    for key in said:
        if key in _NOT_DRAWN:
            word, none = _NOT_DRAWN[key]
            if none is None or any(each != none for each in numbers(key, (none,))):
                words.append(word)
        elif key not in _READ | _SILENT:
            words.append(key[:40])
    return [f"{' and '.join(dict.fromkeys(words))} is not drawn"] if words else []


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True

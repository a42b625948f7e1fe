"""Values of the document as text and numbers: frozen dataclasses, tuples, mappings, paths and arrays as JSON.

Arrays are named by the hash of their bytes and kept by whoever stores the text. A dataclass that is compared by
identity is a value of its own, named by the hash of its text, so that what two states of the document share is stored
once and is one object again. Only the classes that `app.project.declared` knows are read, by their constructors: a file
can name no others.
"""

from __future__ import annotations

import dataclasses
import hashlib
import io
import json
import math
import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path, PurePath
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from app.project.declared import can_be_opened, class_named, is_known, problem_of
from engine.capture.stack import ImageStack
from engine.core.errors import InputError
from engine.core.health import Verdict

if TYPE_CHECKING:
    from mmap import mmap

#: Their arrays take long or can be made again from what the document names, and lie beside the file.
DERIVED = (
    "DirectionalMap",
    "EnvironmentMap",
    "ImageStack",
    "KeptTiles",
    "Mesh",
    "PbrMaps",
    "PowerLawMap",
    "ShadingMap",
)

#: Deepest nesting of a value that is read, and most values within one, each counted as often as it is named.
MAX_DEPTH, MAX_NODES = 60, 2_000_000

#: What making a value of damaged text raises; `UsageError` is a ValueError.
DAMAGE = (ValueError, KeyError, TypeError, AttributeError, IndexError, ArithmeticError, RecursionError)

#: Longest header of an array that is read, in bytes.
MAX_HEADER = 1 << 16

#: Axes of an array, at most.
MAX_AXES = 8

Array = NDArray[Any]


class Absent(Exception):
    """An array or a folder that a value needs is not there any more; the message says which kind of thing it was."""


@dataclasses.dataclass(frozen=True)
class Keeper:
    """Storage for the parts of a value.

    Attributes
    ----------
    text : keeps the text of a value of its own; gives its name.
    array : keeps an array, in the file or, where `derived`, beside it; gives its name.
    folder : place of the stacks; paths below it are kept relative to it.
    own : another folder, whose content is kept as if it lay there.
    file : what is kept of a file in place of its path.
    """

    text: Callable[[str], str]
    array: Callable[[Array, bool], str]
    folder: Path
    own: Path | None = None
    file: Callable[[Path], Any] | None = None


@dataclasses.dataclass
class Work:
    """Nodes of a value that were read so far, and the deepest of them."""

    nodes: int = 0
    deepest: int = 0


@dataclasses.dataclass(frozen=True)
class Finder:
    """The other direction: `text` and `array` give what was kept under a name, or raise Absent.

    `places` are paths by which the file knows what a user has found elsewhere since; `made` are the values that were
    read, by name, and `gone` the parts of materials whose data are not there. `work` bounds what one value may hold,
    and `sizes` are nodes and height of each value in `made`: what names others twice at each level is small on disk
    and has no end in memory. A `thorough` finder also searches large arrays for numbers that are not finite.
    """

    text: Callable[[str], str]
    array: Callable[[str], Array]
    folder: Path
    places: Mapping[str, Path] = dataclasses.field(default_factory=dict)
    made: dict[str, Any] = dataclasses.field(default_factory=dict)
    gone: set[str] = dataclasses.field(default_factory=set)
    work: Work = dataclasses.field(default_factory=Work)
    sizes: dict[str, tuple[int, int]] = dataclasses.field(default_factory=dict)
    thorough: bool = False


def is_name(text: object) -> bool:
    """True for what `name_of` gives."""
    return isinstance(text, str) and len(text) == 40 and not text.strip("0123456789abcdef")


def parse(text: str) -> Any:
    """The JSON value of a text; ValueError or RecursionError where it is none, or holds more than `MAX_NODES`."""
    if text.count(",") + text.count("[") + text.count("{") > MAX_NODES:
        raise ValueError("a value holds too many others")
    return json.loads(text, parse_constant=_refuse, parse_float=_finite)


def _refuse(constant: str) -> float:
    raise ValueError(f"{constant} is not a number")


def _finite(digits: str) -> float:
    number = float(digits)
    if not math.isfinite(number):
        raise ValueError(f"{digits:.40} is too large")
    return number


def name_of(*parts: bytes | memoryview) -> str:
    """The hash that names a content: BLAKE2b, 160 bits, as 40 hexadecimal digits."""
    digest = hashlib.blake2b(digest_size=20)
    for part in parts:
        digest.update(part)
    return digest.hexdigest()


def array_parts(array: Array) -> tuple[bytes, memoryview]:
    """Header and numbers of an array as an .npy file, the numbers not copied; ValueError for arrays of objects."""
    if array.dtype.hasobject:
        raise ValueError("an array of objects is not a value of the document")
    whole = np.ascontiguousarray(array).reshape(array.shape)
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, np.lib.format.header_data_from_array_1_0(whole))
    return header.getvalue(), whole.reshape(-1).view(np.uint8).data


#: Names under which fields are stored where their classes call them otherwise: what is stored keeps its names.
STORED = {"Setting": {"parameters": "knobs"}, "Colours": {"image": "picture"}}

#: The header of an .npy file of version 1.0 as `array_parts` writes it, by numpy's own function.
_HEADER = re.compile(
    rb"\{'descr': '([<>|=][biuf][1248])', 'fortran_order': False, "
    rb"'shape': \(((?:[0-9]{1,12}+, ){0,64}+[0-9]{0,12}+,?+)\), \} {0,999}+\n"
)


def header_of(beginning: bytes | memoryview) -> tuple[tuple[int, ...], np.dtype[Any], int]:
    """Shape, kind of numbers and place of the first number of an .npy file that begins so.

    ValueError for another version, for numbers in another order, and for what holds no numbers. numpy's own reader
    evaluates the header as an expression of Python, and raises whatever its parser raises.
    """
    start = bytes(beginning[:10])
    if len(start) < 10 or not start.startswith(b"\x93NUMPY\x01\x00"):
        raise ValueError("no array, or one of another version")
    end = 10 + int.from_bytes(start[8:], "little")
    found = _HEADER.fullmatch(bytes(beginning[10:end]))
    if found is None:
        raise ValueError("an array of other things than numbers, or in another order")
    shape = tuple(int(length) for length in found[2].replace(b",", b" ").split())
    return shape, np.dtype(found[1].decode()), end


def array_from(content: bytes | memoryview | mmap) -> Array:
    """The read-only array of an .npy file, which shares the memory of `content`.

    ValueError where it is none, or of objects.
    """
    memory = memoryview(content)
    shape, dtype, start = header_of(memory[:MAX_HEADER])
    numbers = memory[start:]
    if len(numbers) != math.prod(shape) * dtype.itemsize or len(shape) > MAX_AXES:
        raise ValueError("an array of another size")
    array: Array = np.ndarray(shape, dtype, numbers) if len(numbers) else np.empty(shape, dtype)
    array.flags.writeable = False
    return array


def encode(value: object, keeper: Keeper, derived: bool = False) -> Any:
    """`value` as what JSON can say; TypeError for what is not a value of the document."""
    if value is None or isinstance(value, bool | str):
        return value
    if isinstance(value, Verdict):
        return {"verdict": int(value)}
    if isinstance(value, int | np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else {"float": str(float(value))}
    if isinstance(value, PurePath):
        return keeper.file(Path(value)) if keeper.file else encode_path(_inside_of(keeper, Path(value)), keeper.folder)
    if isinstance(value, np.ndarray):
        return {"array": keeper.array(value, derived)}
    if isinstance(value, ImageStack) and value.folder is not None:
        return {"stack": encode_path(_inside_of(keeper, value.folder), keeper.folder)["path"]}
    if isinstance(value, Mapping):
        return {"map": [[encode(part, keeper, derived) for part in item] for item in value.items()]}
    if isinstance(value, frozenset):
        return {"set": sorted((encode(part, keeper, derived) for part in value), key=json.dumps)}
    if isinstance(value, list):
        return [encode(part, keeper, derived) for part in value]
    if isinstance(value, tuple) and not hasattr(value, "_fields"):
        return {"tuple": [encode(part, keeper, derived) for part in value]}
    return _encode_object(value, keeper, derived)


def _inside_of(keeper: Keeper, path: Path) -> Path:
    return keeper.folder / path.relative_to(keeper.own) if keeper.own and path.is_relative_to(keeper.own) else path


def _encode_object(value: object, keeper: Keeper, derived: bool) -> Any:
    kind = type(value)
    name = kind.__name__
    if not is_known(kind):
        raise TypeError(f"{kind.__module__}.{name} is not a value of the document")
    derived = derived or name in DERIVED
    kept = [part for part in _parts(kind) if (name, part) != ("Unpacked", "folder")]  # a handle, not a value
    stored = STORED.get(name, {})
    parts = {stored.get(part, part): encode(getattr(value, part), keeper, derived) for part in kept}
    said = {"is": name, "of": parts}
    if dataclasses.is_dataclass(kind) and kind.__eq__ is object.__eq__:
        return {"value": keeper.text(json.dumps(said, sort_keys=True, allow_nan=False))}
    return said


def decode(said: object, finder: Finder, depth: int = 0) -> Any:
    """The value that `said` describes.

    Raises Absent where a part is gone, and one of `DAMAGE` where this is not a value of the document.
    """
    finder.work.nodes += 1
    if depth > MAX_DEPTH or finder.work.nodes > MAX_NODES:
        raise ValueError("values are nested too deeply" if depth > MAX_DEPTH else "a value holds too many others")
    finder.work.deepest = max(finder.work.deepest, depth)
    if said is None or isinstance(said, bool | str | int | float):
        return said
    if isinstance(said, list):
        return [decode(part, finder, depth + 1) for part in said]
    if not isinstance(said, dict) or not said:
        raise ValueError(f"no value: {said!r:.60}")
    kind, content = max(said.items())  # of a path with a second key, "path"; of an object, "of"
    if kind == "of":
        return _decode_object(said, finder, depth)
    if kind == "value":
        return _decode_own(str(content), finder, depth)
    if kind == "array":
        return finder.array(str(content))
    if kind == "path":
        return find_path(said, finder.folder, finder.places)
    if kind == "stack":
        return _open_stack(_inside(str(content), finder.folder), finder)
    if kind == "verdict":
        return Verdict(content)
    if kind == "float":
        return _infinite(content)
    if not isinstance(content, list):
        raise ValueError(f"no value: {said!r:.60}")
    parts = [decode(part, finder, depth + 1) for part in content]
    if kind == "tuple":
        return tuple(parts)
    if kind == "set":
        return frozenset(parts)
    if kind == "map":
        return dict(parts)
    raise ValueError(f"no value: {said!r:.60}")


def _infinite(text: object) -> float:
    if text not in ("nan", "inf", "-inf"):
        raise ValueError(f"no number: {text!r:.60}")
    return float(text)


def _decode_own(name: str, finder: Finder, depth: int) -> Any:
    """An object that is compared by identity: the same one wherever it is named."""
    work = finder.work
    if name in finder.sizes:
        nodes, height = finder.sizes[name]
        work.nodes, work.deepest = work.nodes + nodes, max(work.deepest, depth + height)
        if work.nodes > MAX_NODES or work.deepest > MAX_DEPTH:
            raise ValueError("a value holds too many others, or is nested too deeply")
        return finder.made[name]
    nodes, deepest = work.nodes, work.deepest
    work.deepest = depth
    made = decode(parse(finder.text(name)), finder, depth + 1)
    if not dataclasses.is_dataclass(made) or type(made).__eq__ is not object.__eq__:
        raise ValueError("a value of its own that is not an object")
    finder.made[name], finder.sizes[name] = made, (work.nodes - nodes, work.deepest - depth)
    work.deepest = max(work.deepest, deepest)
    return made


def _decode_object(said: Mapping[str, Any], finder: Finder, depth: int) -> Any:
    name, parts = said["is"], said["of"]
    if not isinstance(name, str) or not isinstance(parts, dict):
        raise ValueError(f"no class of the document: {name!r:.60}")
    try:
        kind = class_named(name)
    except KeyError:
        raise ValueError(f"no class of the document: {name!r:.60}") from None
    if name == "Sources" and "archive" in (parts.get("unpacked") or ()):  # schema 1 kept no more than its name
        parts = {**parts, "unpacked": None}
    fields = {stored: field for field, stored in STORED.get(name, {}).items()}
    known = {field: each for part, each in parts.items() if (field := fields.get(part, part)) in _parts(kind)}
    if name == "Material":  # a material whose maps are gone is built again
        values = {part: _or_none(part, each, finder, depth) for part, each in known.items()}
    else:
        values = {part: decode(each, finder, depth + 1) for part, each in known.items()}
    problem = problem_of(kind, values, thorough=finder.thorough)
    if problem:
        raise ValueError(problem)
    return kind(**values)


def _or_none(part: str, said: object, finder: Finder, depth: int) -> Any:
    try:
        return decode(said, finder, depth + 1)
    except Absent:
        finder.gone.add(part)
        return None


def _open_stack(folder: Path, finder: Finder) -> ImageStack:
    from app.project.pixels import open_kept

    key = f"stack {folder}"
    if key not in finder.made:
        try:
            finder.made[key] = open_kept(folder)
        except InputError as error:
            raise Absent("stack of photographs") from error
    return cast(ImageStack, finder.made[key])


def _parts(kind: type) -> tuple[str, ...]:
    """Names of what the constructor of a class takes."""
    if hasattr(kind, "_fields"):
        return tuple(kind._fields)
    return tuple(part.name for part in dataclasses.fields(kind) if part.init)


def in_full(path: Path) -> Path:
    """A path from the root, without the steps back in it: the same file has the same path, however it was typed."""
    return Path(os.path.normpath(path.absolute()))


def encode_path(path: Path, folder: Path) -> dict[str, str]:
    """A path below the folder of the data relative to it; any other in full, and as seen from the project's folder."""
    path = in_full(path)
    if path.is_relative_to(folder):
        return {"path": path.relative_to(folder).as_posix()}
    try:
        return {"path": str(path), "near": Path(os.path.relpath(path, folder.parent)).as_posix()}
    except ValueError:  # another drive
        return {"path": str(path)}


def find_path(said: Mapping[str, Any], folder: Path, places: Mapping[str, Path] = MappingProxyType({})) -> Path:
    """The path that is there: where a user found it again (`places`), as seen from the project now, or in full.

    ValueError where it is not a path.
    """
    full, *near = paths_of(said, folder)
    candidates = (places.get(str(said["path"])), *near, full)
    return next((each for each in candidates if each is not None and is_there(each)), full)


def is_there(path: Path) -> bool:
    """True for a file or folder that a project names and that can be looked at.

    A path on another computer (`\\\\server\\share`) counts as gone unless the user works there: looking for it would
    give the user's name and password hash to whoever made the project.
    """
    if os.name == "nt" and path.drive.startswith("\\\\") and path.drive != Path.cwd().drive:
        return False
    return os.path.exists(path)  # noqa: PTH110 - Path.exists raises where a folder on the way may not be entered


def is_file(path: Path) -> bool:
    """True for a file that a project names and that can be looked at."""
    return is_there(path) and os.path.isfile(path)  # noqa: PTH113 - as above


def paths_of(said: Mapping[str, Any], folder: Path) -> list[Path]:
    """The path in full, and where it differs, as seen from where the project lies now; ValueError where it is none."""
    if not isinstance(said["path"], str) or not isinstance(said.get("near", ""), str):
        raise ValueError("no path")
    near = [Path(os.path.normpath(folder.parent / said["near"]))] if "near" in said else []
    paths = [_inside(said["path"], folder), *near]
    if not all(map(can_be_opened, paths)):
        raise ValueError("no path that can be opened")
    return paths


def _inside(text: str, folder: Path) -> Path:
    if not Path(text).is_absolute() and ".." in Path(text).parts:
        raise ValueError(f"a path that leaves its folder: {text!r:.60}")
    return folder / text
